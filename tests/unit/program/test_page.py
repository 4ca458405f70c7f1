"""The page on compiled dynamics: its blocks run and print what it says."""

from __future__ import annotations

import re
from pathlib import Path

PAGE = Path(__file__).parents[3] / "docs" / "compiled.md"


def test_the_page(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"```(python|text)\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    space: dict[str, object] = {}
    printed = []
    for kind, text in blocks:
        if kind == "python":
            exec(compile(text, "compiled.md", "exec"), space)
            printed.append(capsys.readouterr().out)
        else:
            assert printed[-1] == text
    assert len(printed) >= 5
