"""Looks of bodies in model files: the keys ``shape`` and ``color`` of a body, read and written.

color = "#0072B2"
shape = { solid = "box", sizes = [0.4, 0.2, 0.2], at = [0, 0.1, 0] }

A shape of several parts is a list of such tables; parts with ``hole = true`` are cut out. First ``axes`` (a rotation
matrix whose columns are the part's axes) turns a part, then ``at`` displaces it. ``shape = "nothing"``: the body is
not drawn. The key ``scenery`` of the file is such a shape fixed in the ground.
"""

from __future__ import annotations

import inspect
import json
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from ...describe.axes import UNIT
from ...describe.looks import NOTHING
from ...errors import FreebodyError, nearest
from ...scalar.algebra import IDENTITY, ZERO, apply
from ...space import solids
from ...space.mass import MassProperties
from ...space.shape import Shape
from .table import Table
from .value_texts import ValueTexts


def read_looks(
    table: Table, kinds: tuple[str, ...], arguments: Callable[..., Any]
) -> tuple[Shape | None, str | None]:
    """Return the shape and the colour of a body, None for those that the file does not name."""
    color = table.text("color") if table.has("color") else None
    if not table.has("shape"):
        return None, color
    if table.raw("shape") == NOTHING:
        return Shape(NOTHING), color
    return read_shape(table, "shape", kinds, arguments), color


def read_shape(table: Table, key: str, kinds: tuple[str, ...], arguments: Callable[..., Any]) -> Shape:
    """Return the shape that a key describes: one part, or a list of parts."""
    value = table.raw(key)
    tables = value if isinstance(value, list) else [value]
    if not tables or not all(isinstance(data, dict) for data in tables):
        table.fail(
            'Expected a shape such as { solid = "box", sizes = [0.4, 0.2, 0.2] }, or a list of these, '
            f"got {value!r}.",
            key,
        )
    parts = [_part(table, key, data, kinds, arguments) for data in tables]
    if len(parts) == 1 and not parts[0].hole:
        return parts[0]
    return Shape("compound", parts=tuple(parts))


def _part(table: Table, key: str, data: Any, kinds: tuple[str, ...], arguments: Callable[..., Any]) -> Shape:
    """Return one part of a shape."""
    part = Table(table.document, (*table.path, key), data, table.system)
    if part.has("mass"):
        part.fail("Expected no mass in a shape, which is only drawn; the mass belongs to the body.", "mass")
    kind = part.text("solid")
    if kind not in kinds:
        part.fail(f"Unknown solid '{kind}'; {nearest(kind, kinds)}", "solid")
    hole = part.has("hole") and part.flag("hole")
    part.data = {**part.data, "mass": 1}
    make = getattr(solids, kind)
    dimensions = dict(arguments(part, make))
    axes = part.matrix("axes") if part.has("axes") else IDENTITY
    at = part.vector("at", (0, 0, 0))
    part.done()
    solid: MassProperties = part.guard(lambda: make(**dimensions))
    assert solid.shape is not None
    return replace(solid.shape.rotated(axes).moved(at), hole=hole)


def looks_keys(
    writer: ValueTexts, shape: Shape | None, kinds: tuple[str, ...], solid: bool
) -> dict[str, str]:
    """Return the keys ``shape`` and ``color``; without a shape if the body's keys name its ``solid``.

    Meshes and solids of revolution have no keys either: such a body is then drawn by its joints and inertia.
    """
    if shape is None:
        return {}
    keys = {}
    text = json.dumps(NOTHING) if shape.kind == NOTHING else shape_text(writer, shape, kinds)
    if not solid and text is not None:
        keys["shape"] = text
    if shape.color:
        keys["color"] = json.dumps(shape.color)
    return keys


def shape_text(writer: ValueTexts, shape: Shape, kinds: tuple[str, ...]) -> str | None:
    """Return a shape as a table or a list of tables; None if a part has no keys."""
    leaves = shape.parts if shape.kind == "compound" else (shape,)
    texts = [_part_text(writer, part, kinds) for part in leaves]
    tables = [text for text in texts if text is not None]
    if not leaves or len(tables) != len(texts):
        return None
    return tables[0] if len(tables) == 1 else f"[{', '.join(tables)}]"


def dimensions(shape: Shape, make: Callable[..., Any]) -> dict[str, Any]:
    """Return the arguments, without the mass, with which a function makes a solid of this shape."""
    axis: Any = next((name for name, unit in UNIT.items() if tuple(shape.axis) == unit), tuple(shape.axis))
    sizes = tuple(value for _, value in shape.dimensions)
    arguments = {**dict(shape.dimensions), "axis": axis, "normal": axis, "sizes": sizes, "semiaxes": sizes}
    parameters = inspect.signature(make).parameters
    return {key: value for key, value in arguments.items() if key in parameters}


def _part_text(writer: ValueTexts, shape: Shape, kinds: tuple[str, ...]) -> str | None:
    """Return one part as an inline table, or None if no solid gives exactly this part."""
    if shape.kind not in kinds:
        return None
    make = getattr(solids, shape.kind)
    arguments = dimensions(shape, make)
    try:
        base = make(m=1, **arguments).shape.rotated(shape.axes)
    except (FreebodyError, TypeError):
        return None
    turned = apply(shape.axes, make(m=1, **arguments).shape.center)
    at: Any = tuple(a - b for a, b in zip(shape.center, turned, strict=True))
    if base.moved(at) != replace(shape, hole=False, color=""):
        return None
    keys = {"solid": json.dumps(shape.kind)}
    for name, value in arguments.items():
        keys[name] = writer.argument(value)
    if shape.axes != IDENTITY:
        keys["axes"] = writer.matrix(shape.axes)
    if at != ZERO:
        keys["at"] = writer.row(at)
    if shape.hole:
        keys["hole"] = "true"
    return "{ " + ", ".join(f"{key} = {value}" for key, value in keys.items()) + " }"
