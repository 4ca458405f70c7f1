"""Parts of a machine in model files, read and written by their fields: loads, joints, contacts.

Each field is a key, read and written by the sort that its annotation names.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import MISSING, fields
from typing import Any

from ...describe.frame import Point, own_body
from ...describe.loads.law import RATE, STRETCH, Law
from ...describe.part import Part, add, sort_of
from ...describe.system import System
from ...errors import FormatError, nearest
from ..text import expression_text
from .table import Table
from .value_texts import ValueTexts, quoted

# --- read --------------------------------------------------------------------------------------


def added(
    system: System, name: str, kind: type[Part], table: Table, given: Mapping[str, Any] | None = None
) -> Any:
    """Add a part of a kind to the system, with the data of a table and what is ``given`` beside it, and return it."""
    data: dict[str, Any] = dict(given or {})
    for field in fields(kind):
        word = kind.words.get(field.name, field.name)
        wanted = field.init and field.name not in ("name", *data)
        if wanted and (table.has(word) or field.default is MISSING):
            data[field.name] = READERS.get(sort_of(field), _unreadable)(table, word)
    table.done()
    return table.guard(lambda: add(system, name, kind(**data)))


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


READERS: dict[str, Callable[[Table, str], Any]] = {
    "Point": own_place,
    "Body": lambda table, key: table.text(key),
    "Joint": own_joint,
    "Coordinate": lambda table, key: table.text(key),
    "Expression": lambda table, key: table.expression(key),
    "Constant": lambda table, key: table.expression(key),
    "FrictionLaw": lambda table, key: table.law(key),
    "Vector": lambda table, key: table.vector(key),
    "Axes": lambda table, key: table.matrix(key),
    "int": lambda table, key: table.whole(key, 0),
    "bool": lambda table, key: table.flag(key),
    "str": lambda table, key: table.text(key),
    "Law": lambda table, key: table.raw(key),
}


# --- write -------------------------------------------------------------------------------------


def part_keys(writer: ValueTexts, part: Part, key: str = "kind") -> dict[str, str]:
    """Return the keys of a part of a machine; ``key`` names its kind.

    Raises
    ------
    FormatError
        A kind without a name in files, or with data that a file cannot hold.
    """
    kind = type(part).__name__
    if not part.kind:
        raise FormatError(
            f"A model file cannot hold {part.title}: its kind has no name in files. Give it one, "
            f"class {kind}({part.base}, kind='{kind.lower()}')."
        )
    keys = {key: quoted(part.kind)}
    for field in fields(part):
        value = getattr(part, field.name)
        if (
            not field.init
            or field.name == "name"
            or (field.default is not MISSING and value == field.default)
        ):
            continue
        if sort_of(field) not in WRITERS:
            raise FormatError(
                f"A model file cannot hold {part.title}: its '{field.name}' is {field.type}. Use points, bodies, "
                f"joints, expressions or texts, or keep the description in Python."
            )
        text = WRITERS[sort_of(field)](writer, value)
        if text is not None:
            keys[part.words.get(field.name, field.name)] = text
    return keys


WRITERS: dict[str, Callable[[Any, Any], str | None]] = {
    "Point": lambda writer, point: writer.point(point),
    "Body": lambda writer, body: quoted(body.name),
    "Joint": lambda writer, joint: quoted(joint.name),
    "Coordinate": lambda writer, value: writer.value(value),
    "Expression": lambda writer, value: writer.value(value),
    "Constant": lambda writer, value: writer.value(value),
    "FrictionLaw": lambda writer, value: writer.law(value),
    "Vector": lambda writer, value: writer.row(value),
    "Axes": lambda writer, value: writer.matrix(value),
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
