"""Files of results: a new file replaces the old one when it is whole, and errors name the cause and the cure.

A write that fails leaves HDF5 in a state in which it damages the file that it closes, or ends the process. Room on the
disk is therefore reserved first, by calls of the system, and HDF5 only fills it.
"""

from __future__ import annotations

import errno
import os
import re
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from ...errors import FreebodyError, SimulationError

_FULL = (errno.ENOSPC, errno.EDQUOT)
_FORBIDDEN = (errno.EACCES, errno.EPERM, errno.EROFS)
_IN_USE = (errno.EAGAIN, errno.EWOULDBLOCK, errno.EBUSY, errno.ETXTBSY)


@contextmanager
def replacing(path: Path, size: int) -> Iterator[Path]:
    """Context with the path of a new file, ``.NAME.PID.new``, which replaces ``path`` at the end of the block.

    A block that fails leaves the old file as it was. New files left by killed processes are removed.

    Parameters
    ----------
    path : Path
    size : int
        Greatest number of bytes that are written.
    """
    _clear(path)
    new = path.with_name(f".{path.name}.{os.getpid()}.new")
    try:
        with explained(path, size):
            with new.open("wb") as file:
                _take_room(file, size)
            yield new
            os.replace(new, path)
    finally:
        with suppress(OSError):
            new.unlink(missing_ok=True)


@contextmanager
def explained(path: Path, size: int = 0, more: str = "") -> Iterator[None]:
    """Context that turns errors of the block into one error about the user's path, with the cause and the cure.

    Raises
    ------
    SimulationError
        A full disk, a folder or file that may not be written, a file in use; ``error.__cause__`` is the error of the
        system.
    """
    try:
        yield
    except FreebodyError:
        raise
    except (
        OSError,
        RuntimeError,
    ) as error:  # HDF5 raises the latter on closing a file that it could not write
        number, text = _cause(error)
        if number in _FULL:
            room = f"{size / 1e6:.3g} MB" if size else "some room"
            cure = f"Free {room}, or choose a path on another disk."
        elif number == errno.EFBIG:
            cure = f"Choose a disk that takes files of {size / 1e6:.3g} MB, or ask for less."
        elif number in _FORBIDDEN:
            cure = "Choose a path at which you may write, or change the rights there."
        elif number in _IN_USE or "already open" in text:
            cure = "Close the dataset that was read from it, or wait for the process that writes to it."
        else:
            cure = "Choose another path."
        raise SimulationError(f"Cannot write '{path}': {text}. {more}{cure}") from error


def reserve(path: Path, size: int) -> None:
    """Reserve room on the disk behind the end of a file, which HDF5 then fills or frees.

    Raises
    ------
    OSError
        There is no room, and the file is as it was; or another process writes to the file.
    """
    if not size:
        return
    with path.open("r+b") as file:
        lock(file)
        before = file.seek(0, os.SEEK_END)
        try:
            _take_room(file, size)
        except OSError:
            os.ftruncate(file.fileno(), before)
            raise


def lock(file: BinaryIO) -> None:
    """Lock a file for this process until it is closed.

    Raises
    ------
    BlockingIOError
        Another process has locked it.
    """
    if _locked(file.fileno()):
        raise BlockingIOError(errno.EAGAIN, os.strerror(errno.EAGAIN))


def _take_room(file: BinaryIO, size: int) -> None:
    """Extend a file by ``size`` bytes on the disk."""
    if hasattr(os, "posix_fallocate"):
        try:
            os.posix_fallocate(file.fileno(), file.tell(), size)
            return
        except OSError as error:
            if error.errno not in (errno.EOPNOTSUPP, errno.EINVAL, errno.ENOSYS):
                raise
    while size > 0:
        size -= file.write(bytes(min(size, 1 << 20)))
    file.flush()
    os.fsync(file.fileno())


def _cause(error: BaseException) -> tuple[int | None, str]:
    """Return number and text of the system's error that is the cause, or the context, of an error."""
    cause: BaseException | None = error
    while cause is not None:
        number = getattr(cause, "errno", None)
        match = re.search(r"errno = (\d+)", str(cause))
        number = int(match[1]) if number is None and match else number
        if number:
            return number, os.strerror(number)
        cause = cause.__cause__ or cause.__context__
    return None, str(error).rstrip(".")


def _clear(path: Path) -> None:
    """Remove new files of processes that have ended."""
    pattern = re.compile(re.escape(f".{path.name}.") + r"(\d{1,9})\.new")
    with suppress(OSError):
        for name in os.listdir(path.parent):
            match = pattern.fullmatch(name)
            if match and not _lives(int(match[1])) and not _written(path.parent / name):
                (path.parent / name).unlink(missing_ok=True)


def _lives(process: int) -> bool:
    """Return True if there is such a process on this computer."""
    if os.name != "posix" or process == os.getpid():
        return True
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:
        pass
    return True


def _written(path: Path) -> bool:
    """Return True if a process of another computer or container may be writing a file, or the path is no file."""
    try:
        file = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_NOFOLLOW)
    except OSError:
        return True
    try:
        return not stat.S_ISREG(os.fstat(file).st_mode) or _locked(file)
    finally:
        os.close(file)


def _locked(file: int) -> bool:
    """Return True if another process holds the lock that HDF5 puts on files it reads or writes."""
    if os.name != "posix":
        return False
    import fcntl

    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        return error.errno in _IN_USE
    return False
