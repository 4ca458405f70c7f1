"""The page on batches: its code runs, and prints what it says."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

PAGE = Path(__file__).parents[4] / "docs" / "batches.md"
BLOCK = re.compile(r"```python\n(.*?)```(?:\n\n```text\n(.*?)```)?", re.DOTALL)
COST = re.compile(r"about \S+ s of one processor \(\S+ s a lane\)")  # differs from run to run


def test_the_page_runs(capsys: pytest.CaptureFixture[str]) -> None:
    space: dict = {}
    blocks = BLOCK.findall(PAGE.read_text(encoding="utf-8"))
    assert len(blocks) >= 6
    for code, expected in blocks:
        exec(compile(code, PAGE.name, "exec"), space)
        printed, promised = (COST.sub("", text).split() for text in (capsys.readouterr().out, expected))
        assert printed == promised, code
