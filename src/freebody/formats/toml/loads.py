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
from dataclasses import MISSING, fields
from typing import Any

from ...describe.frame import Point, own_body
from ...describe.loads.law import RATE, STRETCH, Law
from ...describe.loads.load import KINDS, Load, Part, add, sort_of
from ...describe.system import System
from ...errors import FormatError, nearest
from ..own_kinds import named_kind
from ..text import expression_text
from .table import Table
from .value_texts import ValueTexts, quoted

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


def added(system: System, name: str, kind: type[Part], table: Table) -> Any:
    """Add a part of a kind to the system, with the data of a table, and return it."""
    data: dict[str, Any] = {}
    for field in fields(kind):
        word = kind.words.get(field.name, field.name)
        if field.name != "name" and (table.has(word) or field.default is MISSING):
            data[field.name] = _READERS.get(sort_of(field), _unreadable)(table, word)
    table.done()
    return table.guard(lambda: add(system, name, kind(**data)))


def _named_kind(table: Table) -> type[Load]:
    kind: type[Load] = named_kind(
        table, "kind", KINDS, Load, "load", lambda kind: kind.sections == ("loads",)
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


def own_joint(table: Table, key: str = "joint") -> Any:
    """Return the joint that a key names."""
    name = table.text(key)
    joints = table.system.joints
    if name not in joints:
        table.fail(f"Unknown joint '{name}'; {nearest(name, joints)}", key)
    return joints[name]


def own_place(table: Table, key: str) -> Point:
    """Return the point ``{ body = "bar", point = [0, "a", 0] }``, or the origin of a body given by name."""
    return place(table, table.raw(key), key)


def place(table: Table, value: Any, key: str) -> Point:
    """Return the point that a value of a key describes."""
    if isinstance(value, str):
        return table.guard(lambda: own_body(table.system, value, f"'{key}'").origin, key)
    if not isinstance(value, dict):
        table.fail(
            f'Expected a point {{ body = "NAME", point = [x, y, z] }} or a body\'s name, got {value!r}.', key
        )
    below = Table(table.document, (*table.path, key), value, table.system)
    body = below.guard(lambda: own_body(below.system, below.text("body"), f"'{key}'"), "body")
    components = below.vector("point", (0, 0, 0))
    below.done()
    return below.guard(lambda: body.point(*components), "point")


def _unreadable(table: Table, key: str) -> Any:
    table.fail("Expected data that a file can hold: points, bodies, joints, expressions, texts.", key)


_READERS: dict[str, Callable[[Table, str], Any]] = {
    "Point": own_place,
    "Body": lambda table, key: table.text(key),
    "Joint": own_joint,
    "Coordinate": lambda table, key: table.text(key),
    "Expression": lambda table, key: table.expression(key),
    "Constant": lambda table, key: table.expression(key),
    "Vector": lambda table, key: table.vector(key),
    "int": lambda table, key: table.whole(key, 0),
    "bool": lambda table, key: table.flag(key),
    "str": lambda table, key: table.text(key),
    "Law": lambda table, key: table.raw(key),
}


# --- write -------------------------------------------------------------------------------------


def load_keys(writer: ValueTexts, load: Load) -> tuple[str, dict[str, str]]:
    """Return the section and the keys of a load."""
    keys = part_keys(writer, load, "fb.Load")
    if load.section != "loads":
        del keys["kind"]
    return load.section, keys


def part_keys(writer: ValueTexts, load: Part, base: str) -> dict[str, str]:
    """Return the keys of a part of a machine, whose kind is a subclass of ``base``.

    Raises
    ------
    FormatError
        A kind without a name in files, or with data that a file cannot hold.
    """
    kind = type(load).__name__
    if not load.kind:
        raise FormatError(
            f"A model file cannot hold {load.title}: its kind has no name in files. Give it one, "
            f"class {kind}({base}, kind='{kind.lower()}')."
        )
    keys = {"kind": quoted(load.kind)}
    for field in fields(load):
        value = getattr(load, field.name)
        if field.name == "name" or (field.default is not MISSING and value == field.default):
            continue
        if sort_of(field) not in _WRITERS:
            raise FormatError(
                f"A model file cannot hold {load.title}: its '{field.name}' is {field.type}. Use points, bodies, "
                f"joints, expressions or texts, or keep the description in Python."
            )
        keys[load.words.get(field.name, field.name)] = _WRITERS[sort_of(field)](writer, value)
    return keys


_WRITERS: dict[str, Callable[[ValueTexts, Any], str]] = {
    "Point": lambda writer, point: writer.point(point),
    "Body": lambda writer, body: quoted(body.name),
    "Joint": lambda writer, joint: quoted(joint.name),
    "Coordinate": lambda writer, value: writer.value(value),
    "Expression": lambda writer, value: writer.value(value),
    "Constant": lambda writer, value: writer.value(value),
    "Vector": lambda writer, value: writer.row(value),
    "int": lambda writer, value: str(value),
    "bool": lambda writer, value: str(value).lower(),
    "str": lambda writer, value: quoted(value),
    "Law": lambda writer, value: _law(writer, value),
}


def _law(writer: ValueTexts, law: Law) -> str:
    """Return the text of an expression of stretch and rate, or the pairs of a table."""
    if law.table:
        return writer.matrix(law.table)
    return quoted(expression_text(law.expression, {**writer.texts, STRETCH: "stretch", RATE: "rate"}))
