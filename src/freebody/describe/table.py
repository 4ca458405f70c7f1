"""Tables of a description that count their changes: results derived from them hold while the count is the same."""

from __future__ import annotations

from typing import Any


class Changes:
    """Number of changes of a description."""

    def __init__(self) -> None:
        self.count = 0


class Table(dict[Any, Any]):
    """A dictionary that counts its changes among those of a description."""

    changes = Changes()  # used while a copy is filled, before it has its own

    def __init__(self, changes: Changes) -> None:
        super().__init__()
        self.changes = changes


def _counting(name: str) -> Any:
    method = getattr(dict, name)

    def changed(self: Table, *arguments: Any, **named: Any) -> Any:
        self.changes.count += 1
        return method(self, *arguments, **named)

    return changed


for _name in ("__setitem__", "__delitem__", "__ior__", "clear", "pop", "popitem", "setdefault", "update"):
    setattr(Table, _name, _counting(_name))
