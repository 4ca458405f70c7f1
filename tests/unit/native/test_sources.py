"""The source of what emits machine code is in the key of that code on disk."""

from __future__ import annotations

import ast
import os
import shutil
import subprocess
import sys
import time
from functools import cache as cached
from pathlib import Path

import pytest

from freebody.motion.ode.layout import ORDERS
from freebody.motion.ode.loops import place
from freebody.native import cache, sources
from freebody.program.kernels import compile_tape
from freebody.scalar.trace import Tape

LOOP = "native.loop"
WRITERS = [
    ("program.kernels",),
    *((place(method), LOOP) for method in ORDERS),
    *((place(method), "motion.lanes.lanes", LOOP) for method in ORDERS),
    ("motion.moreau.moreau", LOOP),
    ("motion.start.gauss_newton", LOOP),
]
"""What writes a kernel, and what writes each loop."""


@pytest.fixture(scope="module")
def package(tmp_path_factory):
    """A copy of freebody's source that may be changed."""
    copy = tmp_path_factory.mktemp("source") / "freebody"
    shutil.copytree(sources.PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__", "gallery"))
    return copy


def forget():
    """Read the sources anew when they are asked for next."""
    for function in (sources._identity, sources._read, sources._contents):
        function.cache_clear()


def module_file(name, package=sources.PACKAGE):
    folder = package.joinpath(*name.split("."))
    return folder / "__init__.py" if folder.is_dir() else folder.with_suffix(".py")


def imported(name):
    """Modules of the package that a module imports, by Python's own reading of it, and those that they import."""
    found, waiting = set(), [name]
    while waiting:
        name = waiting.pop()
        if name not in found:
            found.add(name)
            waiting += named_in(name)
    return found


@cached
def named_in(name):
    """Modules of the package that the text of a module imports."""
    file, result = module_file(name), []
    room = ["freebody", *name.split(".")]
    room = room if file.name == "__init__.py" else room[:-1]
    for node in ast.walk(ast.parse(file.read_bytes())):
        if isinstance(node, ast.Import):
            assert not any(one.name.startswith("freebody") for one in node.names), name
        if not isinstance(node, ast.ImportFrom):
            continue
        if not node.level:
            assert not node.module.startswith("freebody"), name
            continue
        base = [*room[: len(room) + 1 - node.level], *(node.module or "").split(".")]
        base = [part for part in base if part][1:]
        for one in node.names:
            whole = ".".join([*base, one.name])
            result.append(whole if module_file(whole).is_file() else ".".join(base))
    return [one for one in result if one]


@pytest.mark.parametrize("writers", WRITERS, ids=" ".join)
def test_every_module_that_has_a_say_is_in_the_key(writers):
    """A module that is not hashed is a stale number one day: what is hashed is what Python would import."""
    assert set(sources.closure(writers)) == set().union(*map(imported, writers))


@pytest.mark.parametrize("writers", [WRITERS[0], WRITERS[1], WRITERS[-1]], ids=" ".join)
def test_key_changes_with_each_source(package, writers):
    """Mutate each module that emits, one after the other; and one that does not."""

    def identity():
        forget()
        return sources.identity(*writers, package=package)

    first = identity()
    assert first == sources.identity(*writers)
    for name in sources.closure(writers):
        file = module_file(name, package)
        text = file.read_bytes()
        file.write_bytes(text + b"# changed\n")
        assert identity() != first, name
        file.write_bytes(text)
    assert identity() == first
    other = package / "symbolic" / "printing" / "latex.py"
    other.write_bytes(other.read_bytes() + b"# changed\n")
    assert identity() == first
    sources._stamps.clear()


PROGRAM = """
from freebody.program.kernels import compile_tape
from freebody.scalar.trace import Tape
tape = Tape(); x, p = tape.input("x"), tape.input("p")
kernels = compile_tape(tape, {"f": [x + p]}, None, [x], [p])
print(kernels["f"](0.0, [2.0], kernels.constants([3.0]))[0], kernels.from_disk)
"""


def test_wrong_emitter_leaves_nothing_behind(package, tmp_path):
    """2 + 3 by an emitter that multiplies, and by the repaired one, with one cache."""

    def run():
        environment = {**os.environ, "PYTHONPATH": str(package.parent), "FREEBODY_CACHE": str(tmp_path)}
        # Python tells byte code from another's by length and second: both texts may have the same of both
        environment |= {"PYTHONDONTWRITEBYTECODE": "1", "PYTHONPYCACHEPREFIX": str(tmp_path / "none")}
        return subprocess.run(
            [sys.executable, "-c", PROGRAM],
            env=environment,
            capture_output=True,
            text=True,
            timeout=120,
            check=True,
        ).stdout.split()

    file = package / "program" / "code" / "emit.py"
    text = file.read_text(encoding="utf-8")
    assert run() == ["5.0", "False"]
    file.write_text(text.replace('f"fadd {FLAGS}"', 'f"fmul {FLAGS}"'), encoding="utf-8")
    assert run() == ["6.0", "False"]
    file.write_text(text, encoding="utf-8")
    assert run() == ["5.0", "True"]  # of the text it had before


def build():
    tape = Tape()
    x = tape.input("x")
    return compile_tape(tape, {"f": [x + 1]}, None, [x], [])


def test_process_older_than_its_sources_keeps_nothing(tmp_path, monkeypatch):
    """What it has in memory need not be what lies on the disk."""
    monkeypatch.setenv("FREEBODY_CACHE", str(tmp_path))
    build()
    assert build().from_disk
    assert not sources.changed()
    with monkeypatch.context() as patch:
        patch.setattr(sources, "IMPORTED", 0)
        assert sources.changed()
        assert not build().from_disk
    edited = tmp_path / "module.py"
    edited.write_text("")
    os.utime(edited, (1, 1))
    monkeypatch.setitem(sources._stamps, edited, edited.stat().st_mtime_ns)
    assert build().from_disk
    edited.write_text("changed")
    assert not build().from_disk
    assert not cache.store("key", {}, b"")
    edited.unlink()
    assert not build().from_disk


def test_installation_without_source_keeps_nothing(tmp_path, monkeypatch):
    """In an archive, or compiled: programs run, and nothing is taken for another's."""
    monkeypatch.setenv("FREEBODY_CACHE", str(tmp_path))
    monkeypatch.setattr(sources, "_stamps", {})
    monkeypatch.setattr(sources, "PACKAGE", tmp_path / "archive.zip" / "freebody")
    for _ in range(2):
        kernels = build()
        assert not kernels.from_disk
        assert kernels["f"](0.0, [2.0], [])[0] == 3


def test_hashing_waits_for_the_first_kernel_and_takes_little():
    done = subprocess.run(
        [sys.executable, "-c", "import sys, freebody, freebody.studies.simulate\n"
         "from freebody.native import sources\nprint(len(sources._stamps))"],
        env={**os.environ, "PYTHONPATH": str(Path(sources.PACKAGE).parent)},
        capture_output=True, text=True, timeout=120, check=True,
    )  # fmt: skip
    assert done.stdout.split() == ["0"]
    times = []
    for _ in range(5):
        forget()
        begin = time.process_time()
        sources.identity(*WRITERS[0])
        times.append(time.process_time() - begin)
    assert min(times) < 0.02  # 1.5 ms
