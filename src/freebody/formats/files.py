"""Atomic replacement of files: a reader sees the old file or the new file, never a part."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ..errors import FormatError


@contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield a temporary path beside ``path``, which is renamed to it if the block ends without an error.

    The temporary name keeps the suffix, by which writers of pictures choose their format.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     target = Path(folder, "note.txt")
    ...     with replacing(target) as new:
    ...         _ = new.write_text("done")
    ...     target.read_text()
    'done'
    """
    target = Path(path)
    if not target.parent.is_dir():
        raise FormatError(
            f"Expected an existing folder for '{target}', got '{target.parent}'. Make it first."
        )
    if target.is_dir():
        raise FormatError(f"Expected the name of a file, got the folder '{target}'.")
    try:
        handle, name = tempfile.mkstemp(dir=target.parent, prefix=f".{target.stem}-", suffix=target.suffix)
    except OSError as error:
        raise FormatError(f"Cannot write '{target}': {error.strerror}. Choose another folder.") from None
    os.close(handle)
    new = Path(name)
    try:
        yield new
        # mkstemp makes files that only their owner can read; the result gets the usual permissions
        mask = os.umask(0)
        os.umask(mask)
        new.chmod(0o666 & ~mask)
        new.replace(target)
    finally:
        new.unlink(missing_ok=True)
