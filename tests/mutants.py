"""A sample of small faults put into the source, one at a time, and those that no test notices.

    python -m tests.mutants --sample 40 --seed 1

Each mutant changes one operation of `src/freebody`: a sign, an operator, a comparison, a number, a branch. The nearest
tests run first: the twin of the changed module and the tests whose text names it, then the tests of its room, then all
of them. The first that fails kills the mutant, and so does a run beyond the limit of time. What survives is printed,
for a reader to judge: some change no result. Mutants that were judged before are read from the file of results, so that
an interrupted run goes on. A survivor takes as long as the whole suite, which has to pass without a fault first;
``--stages 2`` leaves the whole suite out.
"""

from __future__ import annotations

import argparse
import ast
import json
import os
import random
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from time import perf_counter

from tests import twins

ROOT = Path(__file__).resolve().parent.parent
SOURCE = Path("src/freebody")
LEFT_OUT = ("errors.py",)
"""Texts of messages have tests of their own."""
COPIED = (
    ".ci",
    "src",
    "tests",
    "docs",
    "benchmarks",
    "pyproject.toml",
    "README.md",
    "CHANGELOG.md",
    "CONTRIBUTING.md",
    "LICENSE",
)
OPERATORS = {ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.Pow: ast.Mult}
COMPARISONS = {
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In,
}  # fmt: skip


@dataclass(frozen=True)
class Mutant:
    """One changed expression: its file, its place in the text, and what stands there before and after."""

    file: str
    line: int
    start: int
    end: int
    before: str
    after: str

    def written(self, text: str) -> str:
        """The text of the file with the fault in it."""
        return text[: self.start] + self.after + text[self.end :]


def mutants(file: str, text: str) -> Iterator[Mutant]:
    """All mutants of a source file."""
    starts = [0]
    for line in text.encode().splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    raw = text.encode()

    def place(line: int, column: int) -> int:
        return len(raw[: starts[line - 1] + column].decode())

    for node in _judged(ast.parse(text)):
        for changed in _changes(node):
            start = place(node.lineno, node.col_offset)
            end = place(node.end_lineno, node.end_col_offset)
            after = f"({ast.unparse(changed)})"
            yield Mutant(file, node.lineno, start, end, text[start:end], after)


def _judged(tree: ast.AST) -> Iterator[ast.AST]:
    """Nodes outside messages, annotations and what is for type checking only."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.Raise | ast.JoinedStr | ast.Import | ast.ImportFrom):
            continue
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            continue
        if isinstance(node, ast.FunctionDef):
            parts: list[ast.AST] = [*node.body, *node.args.defaults]
        elif isinstance(node, ast.AnnAssign):
            parts = [node.value] if node.value else []
        else:
            yield node
            yield from _judged(node)
            continue
        for part in parts:
            yield part
            yield from _judged(part)


def _changes(node: ast.AST) -> Iterator[ast.AST]:
    if isinstance(node, ast.BinOp) and type(node.op) in OPERATORS and not _is_text(node):
        yield ast.BinOp(node.left, OPERATORS[type(node.op)](), node.right)
    elif isinstance(node, ast.Compare) and len(node.ops) == 1:
        yield ast.Compare(node.left, [COMPARISONS[type(node.ops[0])]()], node.comparators)
    elif isinstance(node, ast.BoolOp):
        yield ast.BoolOp(ast.Or() if isinstance(node.op, ast.And) else ast.And(), node.values)
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub | ast.Not):
        yield node.operand
    elif isinstance(node, ast.Constant) and type(node.value) in (int, float):
        yield ast.Constant(node.value + 1)
    elif isinstance(node, ast.IfExp):
        yield ast.IfExp(node.test, node.orelse, node.body)


def _is_text(node: ast.BinOp) -> bool:
    return any(isinstance(x, ast.JoinedStr) or isinstance(x, ast.Constant) and isinstance(x.value, str)
               for x in (node.left, node.right))  # fmt: skip


@cache
def every_mutant(root: Path) -> list[Mutant]:
    """Mutants of the whole source."""
    found: list[Mutant] = []
    for path in sorted((root / SOURCE).rglob("*.py")):
        if path.name not in LEFT_OUT:
            found += mutants(path.relative_to(root).as_posix(), path.read_text("utf-8"))
    return found


def sample(count: int, seed: int) -> list[Mutant]:
    """Mutants of the whole source, drawn so that the same seed gives the same ones."""
    every = every_mutant(ROOT)
    return random.Random(seed).sample(every, min(count, len(every)))


def judged(mutant: Mutant | None, limit: float, stages: int = 3) -> tuple[bool, str]:
    """Whether a test notices the fault, and which, or why; None is no fault at all."""
    with tempfile.TemporaryDirectory() as folder:
        for name in COPIED:
            if (ROOT / name).is_dir():
                shutil.copytree(
                    ROOT / name, Path(folder, name), ignore=shutil.ignore_patterns("__pycache__", "_build")
                )
            elif (ROOT / name).exists():
                shutil.copy2(ROOT / name, Path(folder, name))
        if mutant is None:
            return _run(folder, [], limit)
        path = Path(folder, mutant.file)
        path.write_text(mutant.written(path.read_text("utf-8")), "utf-8")
        for chosen in ([*tests_of(mutant.file), mutant.file], tests_of_room(mutant.file), [])[:stages]:
            killed, why = _run(folder, chosen, limit)
            if killed:
                return True, why
    return False, "all tests pass" if stages > 2 else "the tests of its room pass"


def tests_of(file: str) -> list[str]:
    """Files of tests nearest to a module: its twin, and those whose text or name names it."""
    source = Path(file).relative_to(SOURCE)
    dotted = file.removeprefix("src/").removesuffix(".py").replace("/", ".")
    near = {twins.twin(source.as_posix()), twins.UNIT / twins.table().get(source.as_posix(), "-")}
    return [
        path.relative_to(ROOT).as_posix()
        for path in sorted((ROOT / "tests").rglob("test_*.py"))
        if path in near or source.stem in path.stem or dotted in path.read_text("utf-8")
    ]


def tests_of_room(file: str) -> list[str]:
    """Folders and files of tests that bear the name of the module's room."""
    room = Path(file).relative_to(SOURCE).parts[0]
    near = [
        *(ROOT / "tests").glob(room),
        *(ROOT / "tests").glob(f"*/{room}"),
        *(ROOT / "tests").glob(f"test_{room}.py"),
    ]
    return [path.relative_to(ROOT).as_posix() for path in sorted(near)]


def _run(folder: str, chosen: list[str], limit: float) -> tuple[bool, str]:
    command = [
        sys.executable, "-m", "pytest", "-x", "-q", "--no-header", "-p", "no:cacheprovider",
        *(["-n", "auto", "--dist", "loadfile"] if len(chosen) != 1 else []), *chosen,
    ]  # fmt: skip
    environment = {
        **os.environ,
        "PYTHONPATH": str(Path(folder, "src")),
        "FREEBODY_CACHE": str(Path(folder, "cache")),
    }
    process = subprocess.Popen(
        command, cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
        start_new_session=True,
    )  # fmt: skip
    try:
        told, _ = process.communicate(timeout=limit)
    except subprocess.TimeoutExpired:
        return True, f"no end within {limit:g} s"
    finally:
        if process.poll() is None:
            os.killpg(process.pid, 9)
            process.wait()
    if process.returncode in (0, 5):  # 5: there are no tests among the chosen files
        return False, "passes"
    lines = [line for line in told.splitlines() if line.startswith(("FAILED", "ERROR"))]
    return True, lines[0] if lines else f"exit {process.returncode}"


def main(arguments: list[str] | None = None) -> int:
    """Judge a sample and print the survivors; the result is their number."""
    parser = argparse.ArgumentParser(prog="python -m tests.mutants", description=str(__doc__).splitlines()[0])
    parser.add_argument("--sample", type=int, default=40, help="number of mutants")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument(
        "--stages", type=int, default=3, help="1: the nearest tests; 2: its room's too; 3: all tests"
    )
    parser.add_argument("--limit", type=float, default=1800.0, help="seconds of one run of tests")
    parser.add_argument(
        "--results", type=Path, default=Path("results/mutants.jsonl"), help="file that is gone on with"
    )
    given = parser.parse_args(arguments)
    known: dict[str, dict[str, object]] = {}
    if given.results.exists():
        for line in given.results.read_text("utf-8").splitlines():
            one = json.loads(line)
            known[json.dumps(one["mutant"])] = one
    given.results.parent.mkdir(parents=True, exist_ok=True)
    if not known and given.stages > 2:
        failed, why = judged(None, given.limit)
        if failed:
            sys.exit(f"Expected tests that pass without a fault, but: {why}. Mend that first.")
    survivors, chosen = [], sample(given.sample, given.seed)
    for i, mutant in enumerate(chosen, 1):
        key = json.dumps(asdict(mutant))
        begun = perf_counter()
        if key not in known:
            killed, why = judged(mutant, given.limit, given.stages)
            known[key] = {"mutant": asdict(mutant), "killed": killed, "why": why}
            with given.results.open("a", encoding="utf-8") as file:
                file.write(json.dumps(known[key]) + "\n")
        one = known[key]
        print(
            f"{i:3d}/{len(chosen)}  {'killed  ' if one['killed'] else 'SURVIVES'}  {mutant.file}:{mutant.line}  "
            f"{mutant.before!r} -> {mutant.after!r}  [{one['why']}, {perf_counter() - begun:.0f} s]",
            flush=True,
        )
        if not one["killed"]:
            survivors.append(mutant)
    print(f"\n{len(chosen) - len(survivors)} of {len(chosen)} killed; survivors, to be read:")
    for mutant in survivors:
        print(f"{mutant.file}:{mutant.line}\n  - {mutant.before}\n  + {mutant.after}")
    return len(survivors)


if __name__ == "__main__":
    sys.exit(min(main(), 1))
