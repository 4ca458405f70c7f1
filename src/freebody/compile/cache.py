"""Object code on disk, shared by all processes of a user.

One file per program, named by the hash of everything that shapes it. A file is written aside and renamed, so that a
reader sees all of it or nothing; it carries a checksum, so that a damaged one counts as absent, and it names in its
header the program that it was made for, so that a file of another program under its name is not run. A folder that can
not be written is told once: programs are then compiled each time. The oldest files go when the folder grows beyond
:data:`LIMIT`.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import sys
import tempfile
import time
import warnings
from functools import cache
from pathlib import Path
from typing import Any

VERSION = 15
"""Of the format and of the emitted code: raise it when either changes."""
LIMIT = 256 * 2**20
"""Bytes the folder may hold."""

_MAGIC = b"freebody"
_DAY = 86400.0


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
    except RuntimeError:  # no home
        return None
    return base / "freebody" / "kernels"


def load(key: str) -> tuple[dict[str, Any], bytes] | None:
    """Header and object code stored under the key; None when absent, damaged, unreadable or of another key."""
    where = folder()
    if where is None:
        return None
    path = where / f"{key}.o"
    try:
        content = path.read_bytes()
    except OSError:
        return None
    with contextlib.suppress(OSError):
        if time.time() - path.stat().st_mtime > _DAY:
            os.utime(path)  # recently used: removed last
    start = len(_MAGIC) + 32
    if (
        content[: len(_MAGIC)] != _MAGIC
        or hashlib.sha256(content[start:]).digest() != content[len(_MAGIC) : start]
    ):
        with contextlib.suppress(OSError):
            path.unlink()
        return None
    size = int.from_bytes(content[start : start + 4], "little")
    header, code = json.loads(content[start + 4 : start + 4 + size]), content[start + 4 + size :]
    return (header, code) if header.pop("made for", None) == [VERSION, key] else None


def store(key: str, header: dict[str, Any], code: bytes) -> bool:
    """Keep the object code; whether that was possible."""
    where = folder()
    if where is None:
        return False
    text = json.dumps({**header, "made for": [VERSION, key]}).encode()
    payload = len(text).to_bytes(4, "little") + text + code
    temporary = ""
    try:
        where.mkdir(mode=0o700, parents=True, exist_ok=True)
        handle, temporary = tempfile.mkstemp(prefix="new-", suffix=".tmp", dir=where)
        with os.fdopen(handle, "wb") as file:
            file.write(_MAGIC + hashlib.sha256(payload).digest() + payload)
        os.replace(temporary, where / f"{key}.o")
        trim(where)
    except OSError as error:
        if temporary:
            with contextlib.suppress(OSError):
                os.unlink(temporary)
        _tell_once(where, error.strerror or str(error))
        return False
    return True


@cache
def _tell_once(where: Path, why: str) -> None:
    warnings.warn(
        f"Expected a folder for compiled programs, but '{where}' can not be written: {why}. Every process compiles "
        "them anew, which takes seconds. Set FREEBODY_CACHE to a folder that can be written, or to off.",
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
                status = entry.stat()
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
