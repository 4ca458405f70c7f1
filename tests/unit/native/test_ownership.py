"""Machine code that others could have written is not run."""

from __future__ import annotations

import errno
import hmac
import os
import pathlib
import sys
import time
import warnings

import pytest

from freebody.native import cache, ownership
from freebody.program.kernels import compile_tape
from freebody.scalar.trace import Tape

pytestmark = pytest.mark.skipif(not hasattr(os, "geteuid"), reason="users and modes of POSIX")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A cache with one kernel, which nobody was warned about."""
    monkeypatch.setenv("FREEBODY_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(cache, "_told", set())
    build()
    assert build().from_disk
    return tmp_path / "cache" / "kernels"


def build(factor=3):
    tape = Tape()
    x = tape.input("x")
    return compile_tape(tape, {"f": [x * factor]}, None, [x], [])


def check_refused(why):
    """Compiled anew, with one warning in all, and right."""
    with pytest.warns(RuntimeWarning, match=rf"folder of your own .* but .*{why}.*FREEBODY_CACHE") as told:
        kernels = build()
    assert len(told) == 1
    assert not kernels.from_disk
    assert kernels["f"](0.0, [2.0], [])[0] == 6
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        build(4)


@pytest.mark.parametrize("mode", [0o777, 0o770, 0o1777, 0o702])
def test_folder_that_others_may_write(folder, mode):
    folder.chmod(mode)
    check_refused("'.*kernels' can be written by others.*chmod go-w")
    assert not build().from_disk
    folder.chmod(0o755)
    assert build().from_disk


def test_folder_above_that_others_may_write(folder):
    folder.parent.chmod(0o777)
    check_refused("cache' can be written by others")


def test_folder_above_that_keeps_what_is_ones_own(folder):
    """As /tmp: all may write, but nobody may rename what is another's."""
    folder.parent.chmod(0o1777)
    assert build().from_disk


def test_new_folder_is_not_made_where_others_may_write(folder, tmp_path, monkeypatch):
    (tmp_path / "open").mkdir()
    (tmp_path / "open").chmod(0o777)
    monkeypatch.setenv("FREEBODY_CACHE", str(tmp_path / "open" / "cache"))
    check_refused("open' can be written by others")
    assert not list((tmp_path / "open").iterdir())


def test_folders_made_are_closed_whatever_the_mask(tmp_path, monkeypatch):
    monkeypatch.setenv("FREEBODY_CACHE", str(tmp_path / "a" / "b"))
    before = os.umask(0)
    try:
        build()
    finally:
        os.umask(before)
    assert build().from_disk
    for path in (tmp_path / "a", tmp_path / "a" / "b", tmp_path / "a" / "b" / "kernels"):
        assert path.stat().st_mode & 0o777 == 0o700
    assert {path.stat().st_mode & 0o777 for path in (tmp_path / "a" / "b" / "kernels").iterdir()} == {0o600}


def test_folder_of_another(folder, monkeypatch):
    """Made beforehand by another user; or by root, before the user was changed; or on a share that maps users."""
    stranger = os.geteuid() + 1
    monkeypatch.setattr(os, "geteuid", lambda: stranger)
    check_refused(f"kernels' belongs to another user .uid {stranger - 1}.")


def test_link_to_a_folder_of_ones_own(folder, tmp_path, monkeypatch):
    (tmp_path / "link").symlink_to(folder.parent)
    monkeypatch.setenv("FREEBODY_CACHE", str(tmp_path / "link"))
    assert build().from_disk


def the_file(folder):
    (path,) = folder.glob("*.o")
    return path


def test_file_that_others_may_write(folder):
    path = the_file(folder)
    path.chmod(0o666)
    check_refused(r"\.o' can be written by others")
    assert build().from_disk  # it was replaced
    assert path.stat().st_mode & 0o777 == 0o600


def link(path):
    path.symlink_to(path.with_suffix(".moved"))


@pytest.mark.parametrize(
    ("put", "why"),
    [
        (os.mkfifo, "is no file"),
        (link, "is a link or a device"),
        (lambda path: path.symlink_to("/dev/zero"), "is a link or a device"),
        (lambda path: path.mkdir(), "is no file"),
        pytest.param(
            lambda path: os.mknod(path, 0o020600, os.makedev(1, 5)),
            "is no file",
            marks=pytest.mark.skipif(
                not hasattr(os, "geteuid") or os.geteuid() != 0, reason="only root makes devices"
            ),
        ),
    ],
)
@pytest.mark.parametrize("name", ["code", "secret"])
def test_what_is_no_file_is_neither_waited_for_nor_run(folder, put, why, name):
    path = the_file(folder) if name == "code" else folder / "secret"
    path.rename(path.with_suffix(".moved"))
    try:
        put(path)
    except PermissionError:
        pytest.skip("no devices here")
    begin = time.monotonic()
    check_refused(f"{path.name}' {why}")
    assert time.monotonic() - begin < 10


def test_code_that_is_not_signed_with_the_secret_is_not_run(folder):
    """A planted file with everything right but what only the user knows."""
    path = the_file(folder)
    good = path.read_bytes()
    payload = good[32:]
    for secret in (b"", bytes(32), b"x" * 32):
        planted = hmac.new(secret, path.stem.encode() + b"\n" + payload, "sha256").digest() + payload
        path.write_bytes(planted)
        again = build()
        assert not again.from_disk
        assert again["f"](0.0, [2.0], [])[0] == 6
    path.write_bytes(good)
    assert build().from_disk


@pytest.mark.parametrize("damage", [lambda path: path.unlink(), lambda path: path.write_bytes(b"short")])
def test_lost_secret_is_made_anew(folder, damage):
    damage(folder / "secret")
    assert not build().from_disk
    assert build().from_disk
    assert (folder / "secret").stat().st_mode & 0o777 == 0o600


def test_secret_that_others_may_read(folder):
    (folder / "secret").chmod(0o644)
    check_refused("secret' can be read by others")


def test_user_without_a_home(folder, monkeypatch):
    """A container with a number for a user."""
    monkeypatch.delenv("FREEBODY_CACHE")
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setattr(sys, "platform", "linux")

    def no_home():
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.setattr(pathlib.Path, "home", no_home)
    check_refused("this user has no home folder")


def test_home_that_can_not_be_written(folder, tmp_path, monkeypatch):
    def refuse(path, *_, **__):
        raise OSError(errno.EROFS, os.strerror(errno.EROFS), str(path))

    monkeypatch.setenv("FREEBODY_CACHE", str(tmp_path / "other"))
    monkeypatch.setattr(pathlib.Path, "mkdir", refuse)
    check_refused("other' can not be used: Read-only file system")


def test_file_that_can_not_be_opened(folder, monkeypatch):
    def refuse(path, *_, **__):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(path))

    monkeypatch.setattr(ownership.os, "open", refuse)
    monkeypatch.setattr(ownership, "make_folder", lambda where: None)
    check_refused("can not be used: Permission denied")
