"""Kinds that users add to model files, by their names or in packages by an entry point ``freebody.kinds``."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from ..errors import nearest


def named_kind(
    table: Any, key: str, known: Mapping[str, Any], base: type, noun: str, allowed: Any = bool
) -> Any:
    """Return the kind that a key of a table names, among the known ones or from a package.

    Parameters
    ----------
    known : mapping of str to class
        It grows by what a package brings.
    base : class
        What the kinds are subclasses of.
    noun : str
        What messages call them: "kind of load", "type of joint".
    allowed : callable
        Whether a kind may stand here.

    Raises
    ------
    FormatError
        An unknown name, or a package whose kind cannot be used.
    """
    name = table.text(key)
    if name not in known:
        for entry in entry_points(group="freebody.kinds", name=name):
            _import(table, key, entry, base, noun)
    if name not in known or not allowed(known[name]):
        names = [
            *(other for other, kind in known.items() if allowed(kind)),
            *entry_points(group="freebody.kinds").names,
        ]
        table.fail(
            f"Unknown {noun} '{name}'; {nearest(name, names)} Import the module that defines it, as "
            f"class Own(fb.{base.__name__}, kind='{name}'), before the file is read.",
            key,
        )
    return known[name]


def _import(table: Any, key: str, entry: EntryPoint, base: type, noun: str) -> None:
    """Import the class that a package names for a kind."""
    package = "a package" if entry.dist is None else f"the package '{entry.dist.name}'"
    try:
        found = entry.load()
    except Exception as error:
        table.fail(
            f"The {noun} '{entry.name}' is that of {package}, whose {entry.value} cannot be imported: "
            f"{type(error).__name__}: {error}. Repair or remove the package.",
            key,
        )
    if not (isinstance(found, type) and issubclass(found, base) and getattr(found, "kind", "") == entry.name):
        table.fail(
            f"The {noun} '{entry.name}' is that of {package}, but its {entry.value} is not a class "
            f"(fb.{base.__name__}, kind='{entry.name}').",
            key,
        )
