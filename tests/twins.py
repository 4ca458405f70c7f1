"""Which unit tests run each file of the source, measured.

A file ``motion/ode/dop853.py`` has a twin if there is ``tests/unit/motion/ode/test_dop853.py``. A file without a
twin is run by other tests: ``tests/unit/covers.toml`` names, for each, the test file that runs most of its lines.
``python -m tests.twins`` measures anew and writes it (half an hour; needs ``coverage`` and ``pytest-cov``). Compiled
code runs unseen: a file that no test is seen to run keeps the test file that it has in the table.
"""

from __future__ import annotations

import ast
import os
import subprocess
import sys
import tomllib
from collections import defaultdict
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SOURCE, UNIT = ROOT / "src" / "freebody", ROOT / "tests" / "unit"
TABLE = UNIT / "covers.toml"
ELSEWHERE = ("gallery", "chapter", "exact", "formats")
"""Rooms with tests of their own: tests/test_gallery.py, tests/test_chapter.py, tests/exact, tests/formats."""


def sources() -> list[str]:
    """Files of the source that need a twin, such as ``"motion/ode/dop853.py"``."""
    paths = (path.relative_to(SOURCE) for path in sorted(SOURCE.rglob("*.py")))
    return [
        p.as_posix()
        for p in paths
        if len(p.parts) > 1 and p.name != "__init__.py" and p.parts[0] not in ELSEWHERE
    ]


def twin(source: str) -> Path:
    """The unit test file that mirrors a file of the source."""
    path = UNIT / source
    return path.with_name(f"test_{path.name}")


def table() -> dict[str, str]:
    """File without a twin -> test file that runs it, under ``tests/unit``."""
    with TABLE.open("rb") as stream:
        return tomllib.load(stream)["run_by"]


def write(run_by: dict[str, str]) -> None:
    rows = "\n".join(f'"{source}" = "{test}"' for source, test in sorted(run_by.items()))
    TABLE.write_text(f"# written by python -m tests.twins\n[run_by]\n{rows}\n", encoding="utf-8")


def bodies(path: Path) -> set[int]:
    """Lines inside functions: an import runs the others."""
    lines: set[int] = set()
    for node in ast.walk(ast.parse(path.read_bytes())):
        if isinstance(node, ast.FunctionDef):
            lines |= set(range(node.body[0].lineno, (node.end_lineno or node.lineno) + 1))
    return lines


def measured(data: str) -> dict[str, dict[str, int]]:
    """Lines of each file of the source that each test file runs, from a file of ``coverage``."""
    from coverage import CoverageData

    found = CoverageData(data)
    found.read()
    result: dict[str, dict[str, int]] = {}
    for file in found.measured_files():
        inside = bodies(Path(file))
        counts: dict[str, int] = defaultdict(int)
        for line, contexts in found.contexts_by_lineno(file).items():
            if line in inside:
                for test in {context.split("::")[0] for context in contexts if "::" in context}:
                    counts[test] += 1
        result[Path(file).relative_to(SOURCE).as_posix()] = dict(counts)
    return result


def chosen(source: str, counts: dict[str, int]) -> str | None:
    """The test file that runs most lines; one in the folder that mirrors the source if it runs half as many."""
    if not counts:
        return None
    folder = f"tests/unit/{Path(source).parent.as_posix()}/"
    best = max(counts, key=lambda test: counts[test] * (2 if test.startswith(folder) else 1))
    return best.removeprefix("tests/unit/")


def main() -> None:
    """Run the unit tests under ``coverage`` and write the table."""
    data = str(ROOT / ".coverage.twins")
    options = ["--cov=src/freebody", "--cov-context=test", "--cov-report=", "-q", "tests/unit"]
    subprocess.run(
        [sys.executable, "-m", "pytest", *options],
        cwd=ROOT,
        env={**os.environ, "COVERAGE_FILE": data},
        check=True,
    )
    old, counts = table(), measured(data)
    os.remove(data)
    without = [source for source in sources() if not twin(source).is_file()]
    new = {source: chosen(source, counts.get(source, {})) or old.get(source) for source in without}
    write({source: test for source, test in new.items() if test})


if __name__ == "__main__":
    main()
