"""The source text of what writes machine code, as a part of that code's key on disk.

Between what is compiled (a trace, whose content is in the key; or a loop, which is source itself) and LLVM stand the
module that writes LLVM's text and the modules that it imports, directly or not. Nothing else has a say in the code,
and each of them may: so their texts are hashed, all of them, and found anew in each process by following the import
statements. A list kept by hand would be wrong one day; the rooms as a whole would make every kernel anew for a
sentence in a docstring. What describes a machine and what states its dynamics is not followed: it speaks through the
trace alone.

Statements are read, not executed, and those within functions count. Only names that are made at run time escape; who
imports so names the modules to `identity`.
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
"""Of each file read: when it was changed last [ns]."""


def identity(*modules: str, package: Path | None = None) -> str:
    """Hash of modules, such as ``"program.kernels"``, and of all of the package that they import.

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
    """Source text of modules and of all that they import, by name."""
    found: dict[str, bytes] = {}
    waiting = list(modules)
    while waiting:
        name = waiting.pop()
        folder = package.joinpath(*name.split("."))
        if name in found:
            continue
        whole = folder.is_dir()
        file = folder / "__init__.py" if whole else folder.with_suffix(".py")
        try:
            _stamps[file] = file.stat().st_mtime_ns  # before it is read
            text = file.read_bytes()
        except OSError:  # an installation without source: nothing tells its code from another's
            _stamps[file], text = -1, b""
        found[name] = text
        waiting += _imported(text, name if whole else name.rpartition(".")[0], package)
    return found


def _imported(text: bytes, room: str, package: Path) -> set[str]:
    """Modules of the package that a text imports, which stands in a room.

    A room itself is one of them if a name is taken from its ``__init__``; the package's own, which all share, is not.
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
            own = (place / item).is_dir() or (place / f"{item}.py").is_file()
            result.add(".".join([*parts, item] if own else parts))
    return result - {""}


def changed() -> bool:
    """Whether a source is younger than this process, in which an older text of it may be at work; or is not there."""
    try:
        return any(time > IMPORTED or file.stat().st_mtime_ns != time for file, time in _stamps.items())
    except OSError:
        return True
