"""Object code on disk, shared by all processes of a user.

Each program has one file, named by the hash of everything that shapes it. A file is written under a temporary name and
renamed, so that a reader sees all of it or nothing.

The content of a file is executed, so nobody else may have written it. The folder and the file must belong to this user
and be closed to writing by others (`ownership`). The file begins with a hash of its name and content, keyed with a
secret that lies beside it and that only this user can read. A file that is damaged, or belongs to another program,
counts as absent.

A folder that cannot be used causes one warning, and programs are then compiled each time. A process older than the
source text that it compiles with does not use the cache either, without a warning. The oldest files are removed when
the folder grows beyond :data:`LIMIT`.
"""

from __future__ import annotations

import contextlib
import hmac
import json
import os
import sys
import tempfile
import threading
import time
import warnings
from pathlib import Path
from typing import Any

from . import ownership, sources

LIMIT = 256 * 2**20
"""Largest size of the folder in bytes."""

_SECRET, _LENGTH = "secret", 32
_DAY = 86400.0
_STORING = threading.Lock()
_warned: set[Path | None] = set()
"""Folders about which a warning was issued."""


def folder() -> Path | None:
    """Return the folder of compiled programs: ``FREEBODY_CACHE``, else the user's cache folder.

    ``FREEBODY_CACHE=off`` turns the cache off.
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
        _warn_once(None, "this user has no home folder.")
        return None
    return base / "freebody" / "kernels"


def load(key: str) -> tuple[dict[str, Any], bytes] | None:
    """Return header and object code stored under the key; None if absent, damaged, not ours or of another key."""
    place = _usable()
    if place is None:
        return None
    path = place / f"{key}.o"
    try:
        if not place.exists():
            return None
        ownership.check_folder(place)
        content = ownership.read(path)
        secret = None if content is None else _secret(place)
    except (OSError, ownership.Untrusted) as error:
        _warn_once(place, error)
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
            os.utime(path)  # mark as recently used: such files are removed last
    end = start + int.from_bytes(content[_LENGTH:start], "little")
    return json.loads(content[start:end]), content[end:]


def store(key: str, header: dict[str, Any], code: bytes) -> bool:
    """Store the object code and return whether that was possible."""
    place = _usable()
    if place is None:
        return False
    text = json.dumps(header).encode()
    payload = b"".join((len(text).to_bytes(4, "little"), text, code))
    try:
        with _STORING:  # two threads would make two secrets
            ownership.make_folder(place)
            secret = _secret(place)
            if secret is None:  # if two processes make one at once, the later one stays
                _put(place, _SECRET, os.urandom(_LENGTH))
                secret = _secret(place) or b""
            _put(place, f"{key}.o", _signature(secret, key, payload) + payload)
            trim(place)
    except (OSError, ownership.Untrusted) as error:
        _warn_once(place, error)
        return False
    return True


def _usable() -> Path | None:
    """Return the folder, or None if this process must not use it."""
    return None if sources.changed() else folder()


def _secret(place: Path) -> bytes | None:
    """Return the secret that signs the files of a folder; None if there is none."""
    secret = ownership.read(place / _SECRET, secret=True)
    return secret if secret is not None and len(secret) == _LENGTH else None


def _signature(secret: bytes, key: str, payload: bytes | memoryview) -> bytes:
    digest = hmac.new(secret, key.encode() + b"\n", "sha256")
    digest.update(payload)
    return digest.digest()


def _put(place: Path, name: str, content: bytes) -> None:
    """Write a file that only this user can read, completely or not at all."""
    handle, temporary = tempfile.mkstemp(prefix="new-", suffix=".tmp", dir=place)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content)
        os.replace(temporary, place / name)
    except OSError:
        with contextlib.suppress(OSError):
            os.unlink(temporary)
        raise


def _warn_once(place: Path | None, reason: object) -> None:
    """Warn about a folder, once in a process."""
    if place in _warned:
        return
    _warned.add(place)
    if isinstance(reason, OSError):
        reason = f"'{reason.filename or place}' cannot be used: {reason.strerror or reason}."
    warnings.warn(
        f"Expected a folder of your own for compiled programs, but {reason} Nothing of it is used: programs are "
        "compiled anew, which takes seconds. Set FREEBODY_CACHE to a folder that only you can write, or to off.",
        RuntimeWarning,
        stacklevel=2,
    )


def trim(place: Path, limit: int | None = None) -> None:
    """If the folder exceeds the limit, remove its oldest files until three quarters of the limit are left."""
    limit = LIMIT if limit is None else limit
    files: list[tuple[float, int, str]] = []
    now = time.time()
    with os.scandir(place) as entries:
        for entry in entries:
            with contextlib.suppress(OSError):
                status = entry.stat(follow_symlinks=False)
                if entry.name.endswith(".o"):
                    files.append((status.st_mtime, status.st_size, entry.path))
                elif entry.name.endswith(".tmp") and now - status.st_mtime > _DAY:
                    os.unlink(entry.path)  # left behind by a process that was stopped
    total = sum(size for _, size, _ in files)
    if total <= limit:
        return
    for _, size, path in sorted(files):
        with contextlib.suppress(OSError):
            os.unlink(path)
        total -= size
        if total <= limit * 3 // 4:
            break
