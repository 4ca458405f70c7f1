"""Hashes of the source text that shapes machine code, as a part of that code's key on disk.

The input of a compilation is a trace, whose content is in the key, or a loop, which is source text itself. Between it
and LLVM stand the module that writes LLVM's text and all modules that this one imports, directly or indirectly. These
texts, and no others, shape the code. So all of them are hashed. Each process collects them anew by following the import
statements: a list kept by hand would be wrong one day, and hashing whole rooms would recompile every kernel for a
sentence in a docstring. Modules that describe machines or state their dynamics are not followed, since they shape the
code through the trace alone.

Import statements are read, not executed, and those within functions count. Imports by names made at run time are not
seen; code with such imports passes the modules to `identity`.
"""

from __future__ import annotations

import hashlib
import re
from functools import cache
from pathlib import Path

from ..version import IMPORTED

PACKAGE = Path(__file__).parents[1]

_IMPORT = re.compile(rb"from (\.+)([\w.]*) import (\([^)]*\)|[^\n]*)")
_COMMENT = re.compile(rb"#[^\n]*")
_stamps: dict[Path, int] = {}
"""Time of the last change [ns] of each file that was read."""


def identity(*modules: str, package: Path | None = None) -> str:
    """Hash of modules, such as ``"program.kernels"``, and of all modules of the package that they import.

    ``package`` is the folder of another copy of freebody.
    """
    return _identity(modules, package or PACKAGE)


@cache
def _identity(modules: tuple[str, ...], package: Path) -> str:
    digest = hashlib.sha256()
    for name, text in sorted(closure(modules, package).items()):
        digest.update(f"{name} {len(text)}\n".encode() + text)
    return digest.hexdigest()


def closure(modules: tuple[str, ...], package: Path = PACKAGE) -> dict[str, bytes]:
    """Source texts of modules and of all modules that they import, by name."""
    texts: dict[str, bytes] = {}
    waiting = list(modules)
    while waiting:
        name = waiting.pop()
        folder = package.joinpath(*name.split("."))
        if name in texts:
            continue
        is_room = folder.is_dir()
        file = folder / "__init__.py" if is_room else folder.with_suffix(".py")
        try:
            _stamps[file] = file.stat().st_mtime_ns  # before it is read
            text = file.read_bytes()
        except OSError:  # an installation without source: its code cannot be told from another's
            _stamps[file], text = -1, b""
        texts[name] = text
        waiting += _imported(text, name if is_room else name.rpartition(".")[0], package)
    return texts


def _imported(text: bytes, room: str, package: Path) -> set[str]:
    """Modules of the package that a text in a room imports.

    A room counts as a module if a name is imported from its ``__init__``. The root ``__init__``, which all share, does
    not count.
    """
    result = set()
    for dots, name, items in _IMPORT.findall(text):
        base = room.split(".")[: room.count(".") + 2 - len(dots)]
        parts = [part for part in (*base, *name.decode().split(".")) if part]
        place = package.joinpath(*parts)
        if not place.is_dir():
            result.add(".".join(parts))
            continue
        for item in re.findall(r"(\w+)(?: as \w+)?", _COMMENT.sub(b"", items).decode()):
            is_module = (place / item).is_dir() or (place / f"{item}.py").is_file()
            result.add(".".join([*parts, item] if is_module else parts))
    return result - {""}


def changed() -> bool:
    """Return whether a source has changed since this process started, which may run an older text, or is missing."""
    try:
        return any(
            time > IMPORTED or file.stat().st_mtime_ns != time for file, time in _stamps.copy().items()
        )
    except OSError:
        return True
