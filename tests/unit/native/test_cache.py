"""Object code on disk."""

from __future__ import annotations

import os
import subprocess
import sys
import time
import warnings

import numpy as np
import pytest

from freebody.native import cache
from freebody.program.kernels import compile_tape
from freebody.scalar.trace import Tape


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("FREEBODY_CACHE", str(tmp_path))
    return tmp_path / "kernels"


def build(factor=3, batch=()):
    tape = Tape()
    x, p = tape.input("x"), tape.input("p")
    return compile_tape(tape, {"f": [tape.sin(x) * p * factor + 1]}, None, [x], [p], batch=batch)


def value(kernels):
    return kernels["f"](0.0, [0.4], kernels.constants([2.0]))[0]


def test_second_time_from_disk(folder):
    first, second = build(), build()
    assert not first.from_disk
    assert second.from_disk
    assert value(first) == value(second) == pytest.approx(6 * np.sin(0.4) + 1)
    assert first.operations == second.operations
    assert sorted(path.suffix for path in folder.iterdir()) == ["", ".o"]  # the secret, and the code


def test_another_program_is_another_file(folder):
    build(3)
    assert not build(4).from_disk
    assert not build(3, batch=["f"]).from_disk
    assert build(3, batch=["f"]).from_disk
    assert len(list(folder.glob("*.o"))) == 3


@pytest.mark.parametrize(
    "damage", [lambda b: b[:-5], lambda b: b"", lambda b: b[:60] + b"\0" + b[61:], lambda b: b"x" + b]
)
def test_damaged_file_is_compiled_again(folder, damage):
    build()
    (path,) = folder.glob("*.o")
    path.write_bytes(damage(path.read_bytes()))
    again = build()
    assert not again.from_disk
    assert value(again) == pytest.approx(6 * np.sin(0.4) + 1)
    assert build().from_disk


def test_folder_that_can_not_be_written(tmp_path, monkeypatch):
    obstacle = tmp_path / "file"
    obstacle.write_text("no folder")
    monkeypatch.setenv("FREEBODY_CACHE", str(obstacle))
    with pytest.warns(
        RuntimeWarning,
        match=r"folder of your own .* but '.*file' is no folder.*Set FREEBODY_CACHE to a folder",
    ):
        assert not build().from_disk
    with warnings.catch_warnings():  # once is enough
        warnings.simplefilter("error")
        assert not build().from_disk
    assert obstacle.read_text() == "no folder"


def test_use_keeps_a_file_from_being_the_oldest(folder, monkeypatch):
    build()
    (path,) = folder.glob("*.o")
    long_ago = time.time() - 1e6
    os.utime(path, (long_ago, long_ago))

    def refuse(*_):
        raise PermissionError

    with monkeypatch.context() as patch:
        patch.setattr(os, "utime", refuse)
        assert build().from_disk  # a folder that can be read only is read
    assert path.stat().st_mtime == pytest.approx(long_ago)
    assert build().from_disk
    assert path.stat().st_mtime > long_ago + 1e5


def test_off(monkeypatch):
    monkeypatch.setenv("FREEBODY_CACHE", "off")
    assert cache.folder() is None
    assert cache.load("x") is None
    assert not cache.store("x", {}, b"")


def test_default_folder_is_the_users(monkeypatch, tmp_path):
    monkeypatch.delenv("FREEBODY_CACHE")
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert cache.folder() == tmp_path / "freebody" / "kernels"


@pytest.fixture(autouse=True)
def _environment(monkeypatch):
    monkeypatch.setenv("FREEBODY_CACHE", "off")


def test_oldest_files_go_first(folder):
    folder.mkdir(mode=0o700)
    now = time.time()
    for k in range(10):
        path = folder / f"{k}.o"
        path.write_bytes(bytes(100))
        os.utime(path, (now - 1000 + k, now - 1000 + k))
    stale, fresh = folder / "new-a.tmp", folder / "new-b.tmp"
    for path in (stale, fresh):
        path.write_bytes(b"")
    os.utime(stale, (now - 1e6, now - 1e6))
    cache.trim(folder, limit=1000)
    assert len(list(folder.glob("*.o"))) == 10
    assert not stale.exists()
    assert fresh.exists()
    cache.trim(folder, limit=999)
    assert sorted(path.stem for path in folder.glob("*.o")) == ["3", "4", "5", "6", "7", "8", "9"]


def test_header_and_code_round_trip(folder):
    assert cache.store("key", {"a": [1, 2]}, b"\0code\xff")
    assert cache.load("key") == ({"a": [1, 2]}, b"\0code\xff")
    assert cache.load("other") is None


def test_code_of_another_program_is_not_run(folder):
    """Files that are signed rightly: under another name, for another processor, with other code inside."""
    build(3)
    (three,) = folder.glob("*.o")
    build(4)
    (four,) = set(folder.glob("*.o")) - {three}
    good, other = three.read_bytes(), four.read_bytes()
    three.write_bytes(other)
    again = build(3)
    assert not again.from_disk
    assert value(again) == pytest.approx(6 * np.sin(0.4) + 1)
    three.write_bytes(good)
    header, code = cache.load(three.stem)
    for wrong in (
        ({**header, "target": "another processor"}, code),
        (header, cache.load(four.stem)[1]),
        ({}, b""),
    ):
        assert cache.store(three.stem, *wrong)
        again = build(3)
        assert not again.from_disk
        assert value(again) == pytest.approx(6 * np.sin(0.4) + 1)
    assert build(3).from_disk


def test_what_was_compiled_is_described(folder):
    first, second = build(), build()
    assert first.size == second.size > 500
    assert first.seconds == second.seconds > 0


def test_many_processes_at_once(folder):
    """Each finds or compiles the same program; none sees half a file."""
    program = (
        "from freebody.program.kernels import compile_tape\n"
        "from freebody.scalar.trace import Tape\n"
        "for k in range(12):\n"
        "    tape = Tape(); x = tape.input('x'); p = tape.input('p')\n"
        "    K = compile_tape(tape, {'f': [tape.sin(x) * p + k]}, None, [x], [p])\n"
        "    print(repr(float(K['f'](0.0, [0.4], K.constants([2.0]))[0])))\n"
    )
    source = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(cache.__file__))))
    environment = {**os.environ, "PYTHONPATH": source}
    running = [
        subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, env=environment, text=True)
        for _ in range(3)
    ]
    results = {process.communicate(timeout=120)[0] for process in running}
    assert all(process.returncode == 0 for process in running)
    assert len(results) == 1
    assert len(results.pop().split()) == 12
    assert len(list(folder.glob("*.o"))) == 12
