"""Model files: read and written, one module per format."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import FormatError
from .files import replacing

if TYPE_CHECKING:
    from ..describe.system import System
    from .case import Case

MAX_SIZE = 4_000_000  # bytes

__all__ = ["read", "read_case", "replacing", "write"]


def read(path: str | os.PathLike[str]) -> System:
    """Return the system that a model file describes.

    Nothing in a file is executed, and a file opens no other file.

    Parameters
    ----------
    path : path-like
        A ``.toml`` file; the page *Model files* of the documentation gives its keys.

    Returns
    -------
    System

    Raises
    ------
    FormatError
        The message names the file, the line and the key, and says what was expected and what came.

    See Also
    --------
    write : write a system to a file
    """
    return read_case(path).system


def read_case(path: str | os.PathLike[str]) -> Case:
    """Return the system of a model file with its ``[initial]``, ``[near]`` and ``[run]``; errors as in :func:`read`."""
    from .toml.read import case_from_text

    file = _checked(path)
    if not file.is_file():
        content = "a folder" if file.is_dir() else "a special file" if file.exists() else "no file"
        raise FormatError(f"Expected a model file at '{file}', found {content}.")
    try:
        with file.open("rb") as stream:
            data = stream.read(MAX_SIZE + 1)
    except OSError as error:
        raise FormatError(f"Cannot read '{file}': {error.strerror}.") from None
    if len(data) > MAX_SIZE:
        raise FormatError(f"{file.name}: expected at most {MAX_SIZE} bytes, got more.")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        raise FormatError(
            f"{file.name}, line {line}: expected UTF-8 text, got the byte {data[error.start]:#04x}."
        ) from None
    return case_from_text(text, file.name)


def write(
    system: System,
    path: str | os.PathLike[str],
    *,
    initial: Mapping[str, Any] | None = None,
    until: Any = None,
    tolerance: float | None = None,
    near: Mapping[str, Any] | None = None,
) -> None:
    """Write a system as a model file that :func:`read` reads back as the same system.

    The file is replaced as a whole: an error leaves the old file in place.

    Parameters
    ----------
    system : System
    path : path-like
        Ends in ``.toml``; its folder must exist.
    initial : mapping of str to number or expression, optional
        Initial values by name, for the table ``[initial]``.
    until : number or expression, optional
        Length of the run [s].
    tolerance : float, optional
    near : mapping, optional
        For machines with constraints, for the table ``[near]``: an approximate closed configuration.

    Raises
    ------
    FormatError
        An expression that has no text in the file's language, or a folder that cannot be written.

    Examples
    --------
    >>> import tempfile, freebody as fb
    >>> s = fb.System("ball")
    >>> m = s.parameters(m=1.0)
    >>> ball = s.body("ball", fb.sphere(m, 0.1))
    >>> joint = s.free("air", s.ground, ball)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     fb.write(s, f"{folder}/ball.toml")
    ...     fb.read(f"{folder}/ball.toml")
    System 'ball': 1 body, 1 joint, 0 coordinates
    """
    from .toml.write import toml_text

    file = _checked(path)
    text = toml_text(system, initial=initial, until=until, tolerance=tolerance, near=near)
    with replacing(file) as new:
        new.write_text(text, encoding="utf-8", newline="\n")


def _checked(path: str | os.PathLike[str]) -> Path:
    """Return the path of a model file, or raise FormatError."""
    try:
        file = Path(path)
        valid = file.suffix.lower() == ".toml" and "\0" not in str(file)
    except TypeError:
        raise FormatError(f"Expected the path of a model file, got {path!r}.") from None
    if not valid:
        raise FormatError(
            f"Expected a file that ends in .toml, got '{file}'. Other formats are not read or written yet."
        )
    return file
