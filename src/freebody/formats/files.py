"""Files are replaced whole: a reader sees the old one or the new one, never half of one."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ..errors import FormatError


@contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[Path]:
    """A temporary path beside ``path``, renamed to it when the block ends without an error.

    The temporary name keeps the suffix, since writers of pictures choose their format by it.

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
        raise FormatError(f"Can not write '{target}': {error.strerror}. Choose another folder.") from None
    os.close(handle)
    new = Path(name)
    try:
        yield new
        # mkstemp makes files that only their owner reads; a result is an ordinary file
        mask = os.umask(0)
        os.umask(mask)
        new.chmod(0o666 & ~mask)
        new.replace(target)
    finally:
        new.unlink(missing_ok=True)
