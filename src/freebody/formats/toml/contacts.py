"""Contacts in model files, read and written: a table for each contact, with its two shapes, or with its kind.

[contacts.floor]
feature = { body = "disk", shape = "circle", radius = "R" }
surface = { shape = "plane", normal = "y" }
friction = "mu"

[contacts.knee]
kind = "stop"
joint = "hip"
low = 0

[families.pile]
shapes = [{ body = "a", shape = "sphere", radius = 0.1 }, { shape = "plane", normal = "y" }]
friction = "mu"
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import sympy

from ...describe.contacts.coefficients import at_rest
from ...describe.contacts.contact import ContactPair
from ...describe.contacts.family import ContactFamily
from ...describe.contacts.gap import GAPS, Gap
from ...describe.frame import own_body
from ...describe.shapes.heightline import LINE
from ...describe.shapes.shape import KINDS, ContactShape
from ...describe.system import System
from ...scalar.expression import exact
from ..own_kinds import named_kind
from ..text import expression_text
from .parts import added, part_keys
from .table import Table
from .value_texts import ValueTexts

POINT = "point"
"""Kind of a shape that does not say its kind."""

_UNITS = {
    (1, 0, 0): "x", (0, 1, 0): "y", (0, 0, 1): "z", (-1, 0, 0): "-x", (0, -1, 0): "-y", (0, 0, -1): "-z",
}  # fmt: skip


# --- read --------------------------------------------------------------------------------------


def read_contacts(system: System, root: Table) -> None:
    """Add the contacts and families of a file to the system."""
    for contact, table in root.tables("contacts"):
        read_contact(system, contact, table)
    for family, table in root.tables("families"):
        read_family(system, family, table)


def read_contact(system: System, name: str, table: Table) -> None:
    """Add one contact of a file to the system."""
    if table.has("kind"):
        added(system, name, named_kind(table, "kind", GAPS, Gap, "kind of contact"), table)
        return
    feature, surface = (
        _shape(Table(table.document, (*table.path, key), table.raw(key), table.system), key)
        for key in ("feature", "surface")
    )
    laws = _laws(table)
    table.done()
    table.guard(lambda: system.contact(name, feature, surface, **laws))


def _laws(table: Table) -> dict[str, Any]:
    """Return the laws that contacts and families have."""
    laws: dict[str, Any] = {
        key: table.expression(key)
        for key in ("restitution", "adhesion", "rolling", "spinning")
        if table.has(key)
    }
    laws |= {key: _friction(table, key) for key in ("friction", "static_friction") if table.has(key)}
    if table.has("impact"):
        laws["impact"] = table.text("impact")
    if table.has("normal"):
        laws["normal"] = table.law("normal")
    if table.has("along"):
        laws["along"] = _direction(table, "along")
    return laws


def _friction(table: Table, key: str) -> Any:
    """Return a law of friction, or two coefficients."""
    value = table.data[key]
    if not isinstance(value, list):
        return table.law(key) if key == "friction" else table.expression(key)
    return tuple(table.read(one, key) for one in value)


def _shape(place: Table, key: str = "shapes") -> Any:
    """Return the shape that a table describes."""
    body = place.guard(lambda: own_body(place.system, place.text("body", "ground"), f"'{key}'"), "body")
    kind = (
        named_kind(place, "shape", KINDS, ContactShape, "kind of shape")
        if place.has("shape")
        else KINDS[POINT]
    )
    for key in kind.required:
        place.raw(key)
    data = {key: _READERS[sort](place, key) for key, sort in kind.words.items() if place.has(key)}
    place.done()
    return place.guard(lambda: kind.made(body, **data))


def _direction(table: Table, key: str) -> Any:
    value = table.data[key]
    return value if isinstance(value, str) else table.three(value, key)


def _rows(table: Table, key: str) -> Any:
    value = table.data[key]
    if not isinstance(value, list) or not value:
        table.fail(f"Expected a list of points [[x, y, z], ...], got {value!r}.", key)
    return tuple(table.three(row, key) for row in value)


def _edges(table: Table, key: str) -> Any:
    value = table.data[key]
    if not isinstance(value, list) or len(value) not in (2, 3):
        table.fail(f"Expected two or three edges [a, b, c], got {value!r}.", key)
    return tuple(table.read(edge, key) for edge in value)


def _height(table: Table, key: str) -> Any:
    # x is the position along the line, a name of the body and not of the system
    return table.text(key)


_READERS: dict[str, Callable[[Table, str], Any]] = {
    "vector": lambda table, key: table.vector(key),
    "expression": lambda table, key: table.expression(key),
    "direction": _direction,
    "flag": Table.flag,
    "points": _rows,
    "edges": _edges,
    "text": _height,
}
"""Readers of the data of shapes, by the sorts that their ``words`` name."""


def read_family(system: System, name: str, table: Table) -> None:
    """Add one family of contacts of a file to the system."""
    shapes = [_shape(place) for place in _each(table, "shapes")]
    laws = _laws(table)
    if table.has("against"):
        laws["against"] = [_shape(place) for place in _each(table, "against")]
    if table.has("apart"):
        laws["apart"] = table.raw("apart")
    table.done()
    table.guard(lambda: system.contacts(name, shapes, **laws))


def _each(table: Table, key: str) -> list[Table]:
    """Return the tables of a list of shapes."""
    value = table.raw(key)
    if not isinstance(value, list):
        table.fail(f"Expected a list of shapes [{{ body = ..., shape = ... }}, ...], got {value!r}.", key)
    return [
        Table(table.document, (*table.path, f"{key}[{k}]"), one, table.system) for k, one in enumerate(value)
    ]


# --- write -------------------------------------------------------------------------------------


def contact_keys(writer: ValueTexts, pair: ContactPair | Gap) -> dict[str, str]:
    """Return the keys of one contact and their texts."""
    if isinstance(pair, Gap):
        return part_keys(writer, pair)
    keys = {"feature": _shape_text(writer, pair.feature), "surface": _shape_text(writer, pair.surface)}
    return keys | _law_keys(writer, pair)


def _law_keys(writer: ValueTexts, pair: ContactPair | ContactFamily) -> dict[str, str]:
    """Return the keys of the laws of a contact or a family, and their texts."""
    keys = _round(writer, pair) if pair.friction_across is None else _elliptic(writer, pair)
    keys |= _other_keys(writer, pair)
    if pair.normal_force is not None:
        keys["normal"] = writer.law(pair.normal_force)
    return keys


def _round(writer: ValueTexts, pair: ContactPair | ContactFamily) -> dict[str, str]:
    """Return the keys of friction with one coefficient, and their texts."""
    keys = {"friction": writer.law(pair.friction)} if pair.friction != 0 else {}
    if pair.static_friction != at_rest(pair.friction):
        keys["static_friction"] = writer.value(pair.static_friction)
    return keys


def _other_keys(writer: ValueTexts, pair: ContactPair | ContactFamily) -> dict[str, str]:
    """Return the keys of laws beside friction and compliance, and their texts."""
    keys = {"restitution": writer.value(pair.restitution)} if pair.restitution != 0 else {}
    if pair.impact != "newton":
        keys["impact"] = f'"{pair.impact}"'
    for key in ("adhesion", "rolling", "spinning"):
        if getattr(pair, key) != 0:
            keys[key] = writer.value(getattr(pair, key))
    return keys


def _elliptic(writer: ValueTexts, pair: ContactPair | ContactFamily) -> dict[str, str]:
    """Return the keys of friction with two coefficients, and their texts."""
    assert pair.along is not None
    keys = {
        "friction": writer.row((pair.friction, pair.friction_across)),
        "along": _direction_text(writer, pair.along),
    }
    if pair.static_friction != pair.friction:
        second = exact(sympy.sympify(pair.friction_across) * pair.static_friction / pair.friction)
        keys["static_friction"] = writer.row((pair.static_friction, second))
    return keys


def family_keys(writer: ValueTexts, family: ContactFamily) -> dict[str, str]:
    """Return the keys of one family of contacts and their texts."""
    keys = {"shapes": f"[{', '.join(_shape_text(writer, shape) for shape in family.shapes)}]"}
    if family.against:
        keys["against"] = f"[{', '.join(_shape_text(writer, shape) for shape in family.against)}]"
    keys |= _law_keys(writer, family)
    if family.apart:
        pairs = (f'["{first.name}", "{second.name}"]' for first, second in family.apart)
        keys["apart"] = f"[{', '.join(pairs)}]"
    return keys


def _shape_text(writer: ValueTexts, shape: ContactShape) -> str:
    """Return a shape as an inline table."""
    keys: dict[str, str] = {}
    if not shape.body.is_ground:
        keys["body"] = f'"{shape.body.name}"'
    if shape.kind != POINT:
        keys["shape"] = f'"{shape.kind}"'
    for word, sort in shape.words.items():
        value = shape.told(word)
        if value is not None:
            keys[word] = _WRITERS[sort](writer, value)
    return "{ " + ", ".join(f"{key} = {text}" for key, text in keys.items()) + " }"


def _direction_text(writer: ValueTexts, value: Any) -> str:
    letter = _UNITS.get(tuple(value))
    return f'"{letter}"' if letter else writer.row(value)


_WRITERS: dict[str, Callable[[ValueTexts, Any], str]] = {
    "vector": ValueTexts.row,
    "expression": ValueTexts.value,
    "direction": _direction_text,
    "flag": lambda writer, value: "true" if value else "false",
    "edges": ValueTexts.row,
    "points": lambda writer, value: f"[{', '.join(map(writer.row, value))}]",
    "text": lambda writer, value: f'"{expression_text(sympy.sympify(value), {**writer.texts, LINE: "x"})}"',
}
"""Texts of the data of shapes, by the sorts that their ``words`` name."""
