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
import os
import re
from functools import cache
from pathlib import Path

from ..version import IMPORTED

PACKAGE = Path(__file__).parents[1]

_IMPORT = re.compile(rb"from (\.+)([\w.]*) import (\([^)]*\)|[^\n]*)")
_ITEM = re.compile(r"(\w+)(?: as \w+)?")
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
        if name not in texts:
            texts[name], imported = _read(name, package)
            waiting += imported
    return texts


@cache
def _read(name: str, package: Path) -> tuple[bytes, set[str]]:
    """Source text of a module, and the modules that it imports."""
    is_room = name in _contents(package)[0]
    file = (
        Path(package, *name.split("."), "__init__.py")
        if is_room
        else Path(package, *name.split(".")).with_suffix(".py")
    )
    try:
        _stamps[file] = file.stat().st_mtime_ns  # before it is read
        text = file.read_bytes()
    except OSError:  # an installation without source: its code cannot be told from another's
        _stamps[file], text = -1, b""
    return text, _imported(text, name if is_room else name.rpartition(".")[0], package)


@cache
def _contents(package: Path) -> tuple[set[str], set[str]]:
    """Rooms of a package, and its modules and rooms, by name: a question to the disk for each import takes longer."""
    rooms, modules = set(), set()
    for folder, within, files in os.walk(package):
        within[:] = [name for name in within if name != "__pycache__"]
        room = folder[len(str(package)) + 1 :].replace(os.sep, ".")
        rooms.add(room)
        modules |= {f"{room}.{name[:-3]}".lstrip(".") for name in files if name.endswith(".py")}
    return rooms, modules | rooms


def _imported(text: bytes, room: str, package: Path) -> set[str]:
    """Modules of the package that a text in a room imports.

    A room counts as a module if a name is imported from its ``__init__``. The root ``__init__``, which all share, does
    not count.
    """
    result = set()
    rooms, modules = _contents(package)
    for dots, name, items in _IMPORT.findall(text):
        base = room.split(".")[: room.count(".") + 2 - len(dots)]
        place = ".".join(part for part in (*base, name.decode()) if part)
        if place not in rooms:
            result.add(place)
            continue
        for item in _ITEM.findall(_COMMENT.sub(b"", items).decode()):
            module = f"{place}.{item}".lstrip(".")
            result.add(module if module in modules else place)
    return result - {""}


def changed() -> bool:
    """Return whether a source has changed since this process started, which may run an older text, or is missing."""
    try:
        return any(
            time > IMPORTED or file.stat().st_mtime_ns != time for file, time in _stamps.copy().items()
        )
    except OSError:
        return True
