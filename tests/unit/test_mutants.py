"""The sample of faults: what is changed, that a test notices, and that what no test notices is told."""

from __future__ import annotations

import ast
import importlib.util
from pathlib import Path

import pytest

PROJECT = {
    "pyproject.toml": '[tool.pytest.ini_options]\npythonpath = ["src"]\n',
    "src/freebody/__init__.py": "",
    "src/freebody/area.py": "def area(a, b):\n    return a * b\n\n\ndef idle(x):\n    return x + 0 if x else 0\n",
    "tests/test_area.py": "from freebody.area import area\n\n\ndef test_area():\n    assert area(2, 3) == 6\n",
}


@pytest.fixture
def tool():
    spec = importlib.util.spec_from_file_location("mutants", Path(__file__).parents[1] / "mutants.py")
    import sys

    module = importlib.util.module_from_spec(spec)
    sys.modules["mutants"] = module
    spec.loader.exec_module(module)
    yield module
    del sys.modules["mutants"]


def test_each_mutant_changes_one_expression(tool):
    text = (
        "def f(a: int = 1, é='ü') -> int:\n"
        "    if a < 2 and not é:\n"
        "        raise ValueError(f'{a + 1} is 3')\n"
        "    return -a ** 2 if a else 'x' + 'y'\n"
    )
    found = {(m.before, m.after) for m in tool.mutants("f.py", text)}
    assert {("1", "(2)"), ("a < 2", "(a <= 2)"), ("not é", "(é)"), ("-a ** 2", "(a ** 2)")} <= found
    assert ("a < 2 and not é", "(a < 2 or not é)") in found
    assert not {"(a - 1)", "('x' - 'y')", "(4)"} & {after for _, after in found}  # neither messages nor texts
    for mutant in tool.mutants("f.py", text):
        changed = mutant.written(text)
        assert ast.dump(ast.parse(changed)) != ast.dump(ast.parse(text))
        assert len(changed) - len(text) == len(mutant.after) - len(mutant.before)


def test_a_sample_is_that_of_its_seed(tool, monkeypatch):
    monkeypatch.setattr(tool, "SOURCE", tool.SOURCE / "space")
    first, again, other = tool.sample(5, 1), tool.sample(5, 1), tool.sample(5, 2)
    assert first == again != other and len(first) == 5
    assert all((tool.ROOT / mutant.file).is_file() for mutant in first)


@pytest.mark.slow
def test_a_fault_that_a_test_notices_is_killed_and_one_that_none_notices_survives(
    tool, tmp_path, monkeypatch, capsys
):
    for name, text in PROJECT.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, "utf-8")
    monkeypatch.setattr(tool, "ROOT", tmp_path)
    results = tmp_path / "results.jsonl"
    survivors = tool.main(["--sample", "100", "--results", str(results)])
    told = capsys.readouterr().out
    assert survivors == told.count("SURVIVES") > 0
    assert "killed    src/freebody/area.py:2  'a * b' -> '(a / b)'" in told
    assert "SURVIVES  src/freebody/area.py:6  'x + 0' -> '(x - 0)'" in told
    before = results.read_text("utf-8")
    assert tool.main(["--sample", "100", "--results", str(results)]) == survivors
    assert results.read_text("utf-8") == before
