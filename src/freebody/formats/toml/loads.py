"""Loads in model files, read and written: a table for each load, whose keys are the data of its kind.

[springs.k]
joint = "guide"
stiffness = "k"

Kinds that users add stand in one section, by the name of the kind, which a package may make known by an entry point
``freebody.kinds``:

[loads.air]
kind = "gust"
point = "ball"
factor = 0.1
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ...describe.loads.load import KINDS, Load
from ...describe.system import System
from ..own_kinds import named_kind
from .parts import added, own_joint, part_keys
from .table import Table
from .value_texts import ValueTexts

# --- read --------------------------------------------------------------------------------------


def load_calls(system: System, root: Table) -> list[Callable[[], None]]:
    """Return one call for each load, which adds it to the system, in the order of the file."""
    sections = dict.fromkeys(section for kind in KINDS.values() for section in kind.sections)
    readers: dict[str, Callable[[System, str, Table], Any]] = dict.fromkeys((*sections, "loads"), _load)
    readers["torsion_springs"] = _torsion_spring
    calls = []
    for section, read in readers.items():
        for name, table in root.tables(section):
            line = root.document.line(table.path)

            def action(read: Any = read, name: str = name, table: Table = table) -> None:
                read(system, name, table)

            calls.append((line, action))
    return [action for _, action in sorted(calls, key=lambda pair: pair[0])]


def _load(system: System, name: str, table: Table) -> None:
    """Add a load of the kind that its section, and the key ``kind`` or ``joint`` in it, name."""
    section = table.path[0]
    kind = _named_kind(table) if section == "loads" else _kind_in(section, table.has("joint"))
    load = added(system, name, kind, table)
    if load.section != section:
        table.fail(f"Expected {load.title} in [{load.section}.{name}], got it in [{section}.{name}].")


def _named_kind(table: Table) -> type[Load]:
    kind: type[Load] = named_kind(
        table, "kind", KINDS, Load, "kind of load", lambda kind: kind.sections == ("loads",)
    )
    return kind


def _kind_in(section: str, on_joint: bool) -> type[Load]:
    """Return the kind of load in a section: on a joint, or not."""
    kinds = [kind for kind in KINDS.values() if section in kind.sections]
    return next((k for k in kinds if ("joint" in k.__dataclass_fields__) == on_joint), kinds[0])


def _torsion_spring(system: System, name: str, table: Table) -> None:
    joint, stiffness = own_joint(table), table.expression("stiffness")
    rest = table.expression("rest", 0)
    index = table.whole("coordinate", 0) if table.has("coordinate") else None
    table.done()
    table.guard(lambda: system.torsion_spring(name, joint, stiffness=stiffness, rest=rest, coordinate=index))


# --- write -------------------------------------------------------------------------------------


def load_keys(writer: ValueTexts, load: Load) -> tuple[str, dict[str, str]]:
    """Return the section and the keys of a load."""
    keys = part_keys(writer, load)
    if load.section != "loads":
        del keys["kind"]
    return load.section, keys
