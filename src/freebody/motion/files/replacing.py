"""Files of results: what is written takes its place when it is whole, and what can not be written is told in full.

A write that fails leaves HDF5 in a state in which it damages the file that it closes, or ends the process. Room on the
disk is therefore taken first, by the system's own calls, and HDF5 only fills it.
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
    """Name of a new file, ``.NAME.PID.new``, that takes the place of ``path`` at the end of the block.

    A block that fails leaves the old file as it was. New files that killed processes have left are removed.

    Parameters
    ----------
    path : Path
    size : int
        Bytes that are to be written, at most.
    """
    _clear(path)
    new = path.with_name(f".{path.name}.{os.getpid()}.new")
    try:
        with told(path, size):
            with new.open("wb") as file:
                _take_room(file, size)
            yield new
            os.replace(new, path)
    finally:
        with suppress(OSError):
            new.unlink(missing_ok=True)


@contextmanager
def told(path: Path, size: int = 0, more: str = "") -> Iterator[None]:
    """Errors of the block as one error about the user's path, with the cause and the cure.

    Raises
    ------
    SimulationError
        A full disk, a folder or file that may not be written, a file in use; ``error.__cause__`` is the system's own.
    """
    try:
        yield
    except FreebodyError:
        raise
    except (OSError, RuntimeError) as error:  # HDF5 closes with the latter what it could not write
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
        raise SimulationError(f"Can not write '{path}': {text}. {more}{cure}") from error


def reserve(path: Path, size: int) -> None:
    """Take room on the disk behind the end of a file, which HDF5 then writes to or gives back.

    Raises
    ------
    OSError
        There is no room, and the file is as it was; or another process writes to it.
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
    """Keep others from a file until it is closed.

    Raises
    ------
    BlockingIOError
        One of them has it.
    """
    if _locked(file.fileno()):
        raise BlockingIOError(errno.EAGAIN, os.strerror(errno.EAGAIN))


def _take_room(file: BinaryIO, size: int) -> None:
    """Make a file longer by so many bytes, for which there is then room."""
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
    """Number and text of the system's error behind one, or behind those that it was raised in the course of."""
    one: BaseException | None = error
    while one is not None:
        number = getattr(one, "errno", None)
        within = re.search(r"errno = (\d+)", str(one))
        number = int(within[1]) if number is None and within else number
        if number:
            return number, os.strerror(number)
        one = one.__cause__ or one.__context__
    return None, str(error).rstrip(".")


def _clear(path: Path) -> None:
    """Remove the new files of processes that are no more."""
    pattern = re.compile(re.escape(f".{path.name}.") + r"(\d{1,9})\.new")
    with suppress(OSError):
        for one in os.listdir(path.parent):
            found = pattern.fullmatch(one)
            if found and not _lives(int(found[1])) and not _written(path.parent / one):
                (path.parent / one).unlink(missing_ok=True)


def _lives(process: int) -> bool:
    """Whether there is such a process on this computer."""
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
    """Whether a process of another computer, or container, may be writing a file, or it is none."""
    try:
        file = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_NOFOLLOW)
    except OSError:
        return True
    try:
        return not stat.S_ISREG(os.fstat(file).st_mode) or _locked(file)
    finally:
        os.close(file)


def _locked(file: int) -> bool:
    """Whether another holds the lock that HDF5 puts on what it reads or writes."""
    if os.name != "posix":
        return False
    import fcntl

    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        return error.errno in _IN_USE
    return False
