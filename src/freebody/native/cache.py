"""Object code on disk, shared by all processes of a user.

One file per program, named by the hash of everything that shapes it. A file is written aside and renamed, so that a
reader sees all of it or nothing. What lies in it is run, so it must be ours: the folder and the file are this user's
and nobody else may write to them (`ownership`), and the file begins with a hash of its name and its content that is
made with a secret, which lies beside it and only this user can read. A file that is damaged, or of another program,
counts as absent. A folder that can not be used is told once: programs are then compiled each time. So they are,
without a word, in a process that is older than the source of what it compiles with. The oldest files go when the
folder grows beyond :data:`LIMIT`.
"""

from __future__ import annotations

import contextlib
import hmac
import json
import os
import sys
import tempfile
import time
import warnings
from pathlib import Path
from typing import Any

from . import ownership, sources

LIMIT = 256 * 2**20
"""Bytes the folder may hold."""

_SECRET, _LENGTH = "secret", 32
_DAY = 86400.0
_told: set[Path | None] = set()
"""Folders that there was a warning about."""


def folder() -> Path | None:
    """Where compiled programs are kept: ``FREEBODY_CACHE``, else the user's cache folder.

    ``FREEBODY_CACHE=off`` keeps nothing.
    """
    chosen = os.environ.get("FREEBODY_CACHE")
    if chosen is not None:
        return None if chosen in ("", "off") else Path(chosen) / "kernels"
    try:
        if sys.platform == "win32":
            base = Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local")
        elif sys.platform == "darwin":
            base = Path.home() / "Library" / "Caches"
        else:
            base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    except RuntimeError:
        _tell_once(None, "this user has no home folder.")
        return None
    return base / "freebody" / "kernels"


def load(key: str) -> tuple[dict[str, Any], bytes] | None:
    """Header and object code stored under the key; None when absent, damaged, not ours or of another key."""
    where = _usable()
    if where is None:
        return None
    path = where / f"{key}.o"
    try:
        if not where.exists():
            return None
        ownership.check_folder(where)
        content = ownership.read(path)
        secret = None if content is None else _secret(where)
    except (OSError, ownership.Untrusted) as error:
        _tell_once(where, error)
        return None
    if content is None or secret is None:
        return None
    start = _LENGTH + 4
    if not hmac.compare_digest(_signature(secret, key, memoryview(content)[_LENGTH:]), content[:_LENGTH]):
        with contextlib.suppress(OSError):
            path.unlink()
        return None
    with contextlib.suppress(OSError):
        if time.time() - path.stat().st_mtime > _DAY:
            os.utime(path)  # recently used: removed last
    end = start + int.from_bytes(content[_LENGTH:start], "little")
    return json.loads(content[start:end]), content[end:]


def store(key: str, header: dict[str, Any], code: bytes) -> bool:
    """Keep the object code; whether that was possible."""
    where = _usable()
    if where is None:
        return False
    text = json.dumps(header).encode()
    payload = b"".join((len(text).to_bytes(4, "little"), text, code))
    try:
        ownership.make_folder(where)
        secret = _secret(where)
        if secret is None:  # of two processes that make one, the second's stays
            _put(where, _SECRET, os.urandom(_LENGTH))
            secret = _secret(where) or b""
        _put(where, f"{key}.o", _signature(secret, key, payload) + payload)
        trim(where)
    except (OSError, ownership.Untrusted) as error:
        _tell_once(where, error)
        return False
    return True


def _usable() -> Path | None:
    """The folder, unless this process must not use it."""
    return None if sources.changed() else folder()


def _secret(where: Path) -> bytes | None:
    """What the files of a folder are signed with; None if there is none."""
    secret = ownership.read(where / _SECRET, secret=True)
    return secret if secret is not None and len(secret) == _LENGTH else None


def _signature(secret: bytes, key: str, payload: bytes | memoryview) -> bytes:
    digest = hmac.new(secret, key.encode() + b"\n", "sha256")
    digest.update(payload)
    return digest.digest()


def _put(where: Path, name: str, content: bytes) -> None:
    """Write a file that only this user can read, whole or not at all."""
    handle, temporary = tempfile.mkstemp(prefix="new-", suffix=".tmp", dir=where)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content)
        os.replace(temporary, where / name)
    except OSError:
        with contextlib.suppress(OSError):
            os.unlink(temporary)
        raise


def _tell_once(where: Path | None, why: object) -> None:
    """Warn about a folder, once in a process."""
    if where in _told:
        return
    _told.add(where)
    if isinstance(why, OSError):
        why = f"'{why.filename or where}' can not be used: {why.strerror or why}."
    warnings.warn(
        f"Expected a folder of your own for compiled programs, but {why} Nothing of it is used: programs are compiled "
        "anew, which takes seconds. Set FREEBODY_CACHE to a folder that only you can write, or to off.",
        RuntimeWarning,
        stacklevel=2,
    )


def trim(where: Path, limit: int | None = None) -> None:
    """Remove the oldest files until the rest holds three quarters of the limit, if it held more than the limit."""
    limit = LIMIT if limit is None else limit
    files: list[tuple[float, int, str]] = []
    now = time.time()
    with os.scandir(where) as entries:
        for entry in entries:
            with contextlib.suppress(OSError):
                status = entry.stat(follow_symlinks=False)
                if entry.name.endswith(".o"):
                    files.append((status.st_mtime, status.st_size, entry.path))
                elif entry.name.endswith(".tmp") and now - status.st_mtime > _DAY:
                    os.unlink(entry.path)  # left by a process that was stopped
    total = sum(size for _, size, _ in files)
    if total <= limit:
        return
    for _, size, path in sorted(files):
        with contextlib.suppress(OSError):
            os.unlink(path)
        total -= size
        if total <= limit * 3 // 4:
            break
