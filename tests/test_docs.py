"""The README and what it promises."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest

import freebody as fb

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def test_the_example_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (code,) = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    assert len([line for line in code.splitlines() if line.strip()]) <= 12
    monkeypatch.chdir(tmp_path)
    exec(compile(code, "README.md", "exec"), {})
    printed = capsys.readouterr().out
    assert "theta" in printed
    assert (tmp_path / "pendulum.nc").stat().st_size > 1000


def test_the_two_commands() -> None:
    run, tests = re.findall(r"```sh\n(.*?)\n```", README, re.DOTALL)
    assert run.startswith(
        "python3.11 -m venv .venv && .venv/bin/pip install . && .venv/bin/freebody run gyroscope"
    )
    assert tests == "python3.11 -m venv .venv && .venv/bin/pip install '.[test]' && .venv/bin/pytest"
    ci = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    assert "pip\" install --quiet '.[test]'" in ci
    assert re.search(r'^step "\$bin/pytest"', ci, re.MULTILINE)


@pytest.mark.parametrize(
    "page",
    [
        "README.md",
        "CONTRIBUTING.md",
        "docs/conventions.md",
        "docs/decisions.md",
        "docs/model-files.md",
        "docs/analysis.md",
        "docs/constraints.md",
        "docs/integrators.md",
        "docs/contact.md",
        "docs/plots.md",
        "docs/report.md",
        "docs/contact-simulation.md",
    ],
)
def test_links_lead_somewhere(page: str) -> None:
    text = (ROOT / page).read_text(encoding="utf-8")
    for target in re.findall(r"\]\(([^)#]+)\)", text):
        if not target.startswith("http"):
            assert ((ROOT / page).parent / target).exists(), f"{page} links to {target}"


def test_the_analysis_page_prints_what_it_says(capsys: pytest.CaptureFixture[str]) -> None:
    """Every block runs, in order, and prints the block of text below it."""
    page = (ROOT / "docs" / "analysis.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```\n(?:\n```text\n(.*?)```\n)?", page, re.DOTALL)
    assert len(blocks) == page.count("```python") and page.count("```") == 2 * (
        page.count("```python") + page.count("```text")
    )
    names: dict[str, object] = {}
    for code, printed in blocks:
        exec(compile(code, "docs/analysis.md", "exec"), names)
        assert capsys.readouterr().out == printed, code


@pytest.mark.parametrize("page", ["plots.md", "report.md"])
def test_the_blocks_of_a_page_run(page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every block of code runs, in order."""
    text = (ROOT / "docs" / page).read_text(encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    blocks = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    assert blocks
    for code in blocks:
        exec(compile(code, page, "exec"), names)


def test_constraints_page(capsys: pytest.CaptureFixture[str]) -> None:
    """Every block that begins with an import runs, and prints the block of text below it."""
    page = (ROOT / "docs" / "constraints.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(import .*?)```\n\n```text\n(.*?)```\n", page, re.DOTALL)
    assert len(blocks) == page.count("```python\nimport") == page.count("```text") > 0
    for code, printed in blocks:
        exec(compile(code, "docs/constraints.md", "exec"), {})
        assert capsys.readouterr().out == printed, code


def test_one_version() -> None:
    with (ROOT / "pyproject.toml").open("rb") as stream:
        assert tomllib.load(stream)["project"]["version"] == fb.__version__
