"""Files that nobody else can have written, checked as ssh checks its own files.

A file is trusted if it is a regular file of this user in a folder of this user, and nobody else may write to either.
The folders above may also belong to the system's administrator. They may be writable by all only if their sticky bit
protects each owner's files (/tmp). Links on the way to the folder are followed first; a link inside it is refused. On
systems without such users (Windows) folders have the protection that they inherit, and only links are refused.
"""

from __future__ import annotations

import errno
import os
import stat
from pathlib import Path

_USERS = hasattr(os, "geteuid")
_FLAGS = (
    os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
)
_OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH
_OTHERS = stat.S_IRWXG | stat.S_IRWXO


class Untrusted(Exception):
    """A file or a folder that others can write, with the cure."""

    def __init__(self, path: object, reason: str, cure: str) -> None:
        super().__init__(f"'{path}' {reason}. {cure}")


def check_folder(folder: Path, *, own: bool = True) -> None:
    """Raise an error if somebody else can put files into a folder.

    With ``own=False`` the folder may belong to the administrator; nobody else may then reach folders made in it.

    Raises
    ------
    Untrusted
    OSError
        If there is no such folder.
    """
    place = os.path.realpath(folder)
    status, shared = os.lstat(place), not own
    if not stat.S_ISDIR(status.st_mode):
        raise Untrusted(place, "is no folder", "Choose another path.")
    while _USERS:
        if status.st_uid != os.geteuid() and not (shared and status.st_uid == 0):
            cure = "Choose a folder of your own."
            raise Untrusted(place, f"belongs to another user (uid {status.st_uid})", cure)
        if status.st_mode & _OTHERS_WRITE and not (shared and status.st_mode & stat.S_ISVTX):
            raise Untrusted(place, "can be written by others", f"Close it: chmod go-w '{place}'.")
        above = os.path.dirname(place)
        if above == place:
            break
        place, status, shared = above, os.lstat(above), True


def make_folder(folder: Path) -> None:
    """Make a folder and its missing parents for this user alone, in a place where nobody else can interfere."""
    missing, place = [], folder
    while not place.exists():
        missing.append(place)
        place = place.parent
    if missing:
        check_folder(place, own=False)
    for place in reversed(missing):
        place.mkdir(mode=0o700, exist_ok=True)
    check_folder(folder)


def read(path: Path, *, secret: bool = False) -> bytes | None:
    """Return the content of a file that nobody else can have written; None if there is no such file.

    If it is ``secret``, nobody else can have read it either. A pipe or a device is refused without waiting for it.

    Raises
    ------
    Untrusted
    OSError
    """
    try:
        handle = os.open(path, _FLAGS)
    except FileNotFoundError:
        return None
    except OSError as error:
        if error.errno in (errno.ELOOP, errno.ENXIO, errno.EMLINK) or path.is_symlink():
            raise Untrusted(path, "is a link or a device", "Remove it.") from None
        raise
    try:
        status = os.fstat(handle)
        if not stat.S_ISREG(status.st_mode):
            raise Untrusted(path, "is no file", "Remove it.")
        if _USERS and status.st_uid != os.geteuid():
            raise Untrusted(path, f"belongs to another user (uid {status.st_uid})", "Remove it.")
        if _USERS and status.st_mode & (_OTHERS if secret else _OTHERS_WRITE):
            raise Untrusted(path, f"can be {'read' if secret else 'written'} by others", "Remove it.")
        with open(handle, "rb", closefd=False) as file:
            return file.read()
    finally:
        os.close(handle)
