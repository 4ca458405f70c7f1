"""The README and the pages: what they promise is run, and the whole is built."""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from importlib.util import find_spec
from pathlib import Path
from types import SimpleNamespace

import pytest

import freebody as fb
from freebody.cli import main

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
PAGES = sorted(
    path.relative_to(ROOT).as_posix()
    for path in (ROOT / "docs").rglob("*.md")
    if not {"systems", "reference", "_build"} & set(path.relative_to(ROOT / "docs").parts)
)
"""What is written by hand; the rest is made by the build."""

TUTORIAL = [page for page in PAGES if page.startswith("docs/tutorial/")]


def blocks(page: str, kind: str = "python") -> list[str]:
    return re.findall(rf"```{kind}\n(.*?)```", (ROOT / page).read_text(encoding="utf-8"), re.DOTALL)


def run(page: str, names: dict[str, object]) -> None:
    """Run every block of a page, in order."""
    found = blocks(page)
    assert found
    for code in found:
        exec(compile(code, page, "exec"), names)


def arrows(svg: str) -> list[str]:
    """Names of the forces in a drawing."""
    return re.findall(r'data-name="([^"]*)"', svg)


def test_the_readme_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The first block is a model of eight lines that prints what its comment says."""
    first, _ = blocks("README.md")
    assert len([line for line in first.splitlines() if line.strip()]) == 8
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    run("README.md", names)
    printed = capsys.readouterr().out
    assert printed == re.findall(r"print\(.*?\)\)?  # (.*)", first)[0].strip() + "\n"
    made = {path.name for path in tmp_path.iterdir()}
    assert made == {"bar.svg", "pendulum.html", "live.html", "pendulum.nc", "generated"}
    assert (tmp_path / "pendulum.nc").stat().st_size > 1000
    shown = (ROOT / "docs" / "pendulum_bar.svg").read_text(encoding="utf-8")
    assert arrows((tmp_path / "bar.svg").read_text(encoding="utf-8")) == arrows(shown) != []


def test_the_comments_of_the_readme(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A comment that says a result says the right one."""
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    first, second = blocks("README.md")
    exec(first, names)
    exec("eq = fb.equations(s)", names)
    said = {}
    for line in second.splitlines():
        code, mark, comment = line.partition("  # ")
        if mark and not line.startswith(("motion", "fb.report", "program")):
            said[code] = (comment, str(eval(code, names)) if "=" not in code.split("(")[0] else "")
    shown = [(comment, result) for comment, result in said.values() if comment[:1] in "[2" or ": " in comment]
    assert len(shown) == 3
    for comment, result in shown:
        result = result.splitlines()[0].replace("pin_y = ", "")
        assert comment.split(": ")[-1] == result


def test_the_commands_of_the_readme(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (listed,) = [block for block in blocks("README.md", "sh") if block.startswith("freebody")]
    monkeypatch.chdir(tmp_path)
    for line in listed.splitlines():
        program, *arguments = shlex.split(line, comments=True)
        assert program == "freebody"
        with pytest.raises(SystemExit) as end:
            main(arguments)
        assert end.value.code == 0, line
    assert {path.name for path in tmp_path.iterdir()} == {
        "gyroscope.html",
        "four_bar.svg",
        "radii.zarr",
        "radii.png",
    }


def test_the_two_commands() -> None:
    run, tests, *_ = (block.strip() for block in blocks("README.md", "sh"))
    assert run.startswith(
        "python3.11 -m venv .venv && .venv/bin/pip install . && .venv/bin/freebody run gyroscope"
    )
    options = "-n auto --dist loadfile"
    assert (
        tests == f"python3.11 -m venv .venv && .venv/bin/pip install '.[test]' && .venv/bin/pytest {options}"
    )
    ci = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    assert "pip\" install --quiet '.[test]'" in ci
    assert f'\nstep "$bin/pytest" {options} ' in ci


@pytest.mark.parametrize("page", ["README.md", "CONTRIBUTING.md", *PAGES])
def test_links_lead_somewhere(page: str) -> None:
    """Pages that the build makes are for its own warnings to watch."""
    text = (ROOT / page).read_text(encoding="utf-8")
    for target in re.findall(r"\]\(([^)#]+)\)", text):
        if not target.startswith(("http", "systems/", "reference/")):
            assert ((ROOT / page).parent / target).exists(), f"{page} links to {target}"


@pytest.mark.parametrize("page", ["docs/analysis.md", "docs/how-do-i.md", "docs/loads.md", *TUTORIAL])
def test_a_page_prints_what_it_says(
    page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Every block runs, in order, and prints the block of text below it; pictures show what stands in the page."""
    text = (ROOT / page).read_text(encoding="utf-8")
    pairs = re.findall(r"```python\n(.*?)```\n(?:\n```text\n(.*?)```\n)?", text, re.DOTALL)
    kinds = sum(text.count(f"```{kind}\n") for kind in ("python", "text", "sh"))
    assert len(pairs) == text.count("```python") and text.count("```") == 2 * kinds
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    for code, printed in pairs:
        exec(compile(code, page, "exec"), names)
        assert capsys.readouterr().out == printed, code
    for target in re.findall(r"!\[[^\]]*\]\(([^)]+)\)", text):
        made = tmp_path / Path(target).name
        assert made.exists(), f"no block makes {target}"
        if made.suffix == ".svg":
            kept = (ROOT / page).parent / target
            assert arrows(made.read_text(encoding="utf-8")) == arrows(kept.read_text(encoding="utf-8"))


def test_the_calls_of_the_index_by_task_exist() -> None:
    """Every call in the tables of the page is there, under the names that its blocks give."""
    from freebody.program.program import Program
    from freebody.symbolic.equations import Equations

    text = (ROOT / "docs" / "how-do-i.md").read_text(encoding="utf-8")
    homes = {
        "fb": fb, "s": fb.System, "eq": Equations, "motion": fb.Trajectory, "program": Program, "plot": fb.plot,
    }  # fmt: skip
    calls = re.findall(r"`(?:fb\.)?(fb|s|eq|motion|program|plot)\.(\w+)`", text)
    assert len(calls) > 60
    for home, name in calls:
        assert hasattr(homes[home], name), f"{home}.{name}"


@pytest.mark.parametrize("page", ["docs/plots.md", "docs/report.md"])
def test_the_blocks_of_a_page_run(page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    run(page, {})


@pytest.mark.skipif(
    not all(map(find_spec, ("sphinx", "myst_parser", "furo"))), reason="needs the extra 'docs'"
)
@pytest.mark.parametrize("systems", ["ex-6-2", pytest.param("", marks=pytest.mark.slow)])
def test_the_documentation_is_built(systems: str, tmp_path: Path) -> None:
    """Without a warning and without a network, each system and each public name with its page.

    The pages of ``systems``, or all, hold what running them gives.
    """
    from freebody.gallery import entries

    made = shutil.ignore_patterns("systems", "reference", "_build", "__pycache__")
    shutil.copytree(ROOT / "docs", tmp_path / "docs", ignore=made)
    shutil.copy(ROOT / "CHANGELOG.md", tmp_path)
    paths = os.pathsep.join([str(ROOT / "src"), os.environ.get("PYTHONPATH", "")])
    proxy = dict.fromkeys(("http_proxy", "https_proxy", "HTTP_PROXY", "HTTPS_PROXY"), "http://127.0.0.1:9")
    build = subprocess.run(
        [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-D", f"systems_run={systems}", "docs", "site"],
        cwd=tmp_path, env={**os.environ, **proxy, "PYTHONPATH": paths}, capture_output=True, text=True,
    )  # fmt: skip
    assert build.returncode == 0, build.stderr
    site = tmp_path / "site"
    reference = "".join(path.read_text(encoding="utf-8") for path in (site / "reference").glob("*.html"))
    for name in fb.__all__:
        value = getattr(fb, name)
        if callable(value) and value.__module__.startswith("freebody"):  # others are names for annotations
            assert f'id="freebody.{name}"' in reference, name
    for name in entries():
        page = (site / "systems" / f"{name}.html").read_text(encoding="utf-8")
        is_run = name in systems.split(",") or not systems
        for heading in ("The machine", "Answers", "Motion", "The model") if is_run else ("The model",):
            assert f"<h2>{heading}<" in page, f"{name}: {heading}"
        assert not is_run or ("<use" in page and page.count("<img") >= 2), name
        assert f"def {entries()[name].build.__name__}(" in re.sub("<[^>]*>", "", page), name
    index = (site / "searchindex.js").read_text(encoding="utf-8")
    assert "freebody.linearize" in index or '"linearize"' in index
    rooms = "|".join(
        path.name
        for path in (ROOT / "src" / "freebody").iterdir()
        if (path / "__init__.py").exists() and path.name not in fb.__all__  # fb.exact is public
    )
    named = set(re.findall(rf"freebody\.(?:{rooms})\.[\w.]+", index))
    assert not named, "the search speaks of files"
    for path in site.rglob("*.html"):
        fetched = re.findall(
            r'(?:src|href)="(?:https?:)?//([^"/]+)[^"]*"[^>]*(?:>|rel="stylesheet")', _without_links(path)
        )
        assert not fetched, f"{path.name} asks {fetched} for something"


def _without_links(path: Path) -> str:
    """A page without the links that a reader may follow."""
    return re.sub(r"<a\b[^>]*>", "", path.read_text(encoding="utf-8"))


def test_the_home_page_shows_what_it_prints(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    run("docs/index.md", {})
    assert capsys.readouterr().out == blocks("docs/index.md", "text")[0]
    shown = (ROOT / "docs" / "pendulum_bar.svg").read_text(encoding="utf-8")
    assert arrows((tmp_path / "bar.svg").read_text(encoding="utf-8")) == arrows(shown) != []


def test_constraints_page(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Every block that begins with an import runs, and prints the block of text below it."""
    monkeypatch.chdir(tmp_path)
    page = (ROOT / "docs" / "constraints.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(import .*?)```\n\n```text\n(.*?)```\n", page, re.DOTALL)
    assert len(blocks) == page.count("```python\nimport") == page.count("```text") > 0
    for code, printed in blocks:
        exec(compile(code, "docs/constraints.md", "exec"), {})
        assert capsys.readouterr().out == printed, code


def test_the_code_of_a_page_stands_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """What a page shows as the model is all that is needed to build it."""
    from freebody.gallery import entries

    monkeypatch.syspath_prepend(str(ROOT / "docs" / "_ext"))
    from gallery_pages import code_of

    for i, (name, entry) in enumerate(entries().items()):
        code = code_of(entry.build)
        assert len(code.splitlines()) <= 25 and max(map(len, code.splitlines())) <= 110, name
        if i % 3:
            continue
        names: dict[str, object] = {}
        exec(compile(code, name, "exec"), names)
        made, meant = names[entry.build.__name__](), entry.build()
        assert fb.assemble(made).coordinate_names == fb.assemble(meant).coordinate_names
        assert (list(made.bodies), list(made.loads)) == (list(meant.bodies), list(meant.loads))


def test_a_page_of_no_system_is_not_made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(ROOT / "docs" / "_ext"))
    from gallery_pages import write_pages

    app = SimpleNamespace(srcdir=tmp_path, config=SimpleNamespace(systems_run="sec-6-9,sec-6-99"))
    with pytest.raises(ValueError, match=r"Expected systems of the gallery in 'systems_run', got sec-6-99\."):
        write_pages(app)


def test_the_makers_of_pages(monkeypatch: pytest.MonkeyPatch) -> None:
    """Their examples run."""
    import doctest

    monkeypatch.syspath_prepend(str(ROOT / "docs" / "_ext"))
    import bibliography_page
    import generated

    for module in (generated, bibliography_page):
        failed, tried = doctest.testmod(module)
        assert tried > 0 and failed == 0


def test_one_version() -> None:
    with (ROOT / "pyproject.toml").open("rb") as stream:
        settings = tomllib.load(stream)
    assert settings["project"]["dynamic"] == ["version"]
    file = (ROOT / settings["tool"]["hatch"]["version"]["path"]).read_text(encoding="utf-8")
    assert f'VERSION = "{fb.__version__}"' in file
