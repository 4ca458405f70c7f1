"""How bodies are drawn, in model files: the keys ``shape`` and ``color`` of a body, read and written.

color = "#0072B2"
shape = { solid = "box", sizes = [0.4, 0.2, 0.2], at = [0, 0.1, 0] }

A shape of several parts is a list of such tables, in which ``hole = true`` is cut out. ``at`` displaces a part, and
``axes`` (a rotation matrix, columns are the part's axes) turns it before.
"""

from __future__ import annotations

import inspect
import json
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from ...errors import FreebodyError, nearest
from ...scalar.algebra import IDENTITY, ZERO, apply
from ...space import solids
from ...space.mass import MassProperties
from ...space.shape import Shape
from .table import Table

if TYPE_CHECKING:
    from .write import Writer

_UNITS = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}


def read_looks(
    table: Table, kinds: tuple[str, ...], arguments: Callable[..., Any]
) -> tuple[Shape | None, str | None]:
    """The shape and the colour of a body, None where the file names none."""
    color = table.text("color") if table.has("color") else None
    if not table.has("shape"):
        return None, color
    given = table.raw("shape")
    listed = given if isinstance(given, list) else [given]
    if not listed or not all(isinstance(one, dict) for one in listed):
        table.fail(
            'Expected a shape such as { solid = "box", sizes = [0.4, 0.2, 0.2] }, or a list of these, '
            f"got {given!r}.",
            "shape",
        )
    parts = [_part(table, one, kinds, arguments) for one in listed]
    if len(parts) == 1 and not parts[0].hole:
        return parts[0], color
    return Shape("compound", parts=tuple(parts)), color


def _part(table: Table, data: Any, kinds: tuple[str, ...], arguments: Callable[..., Any]) -> Shape:
    part = Table(table.document, (*table.path, "shape"), data, table.system)
    if part.has("mass"):
        part.fail("Expected no mass in a shape, which is only drawn; the mass stands in the body.", "mass")
    kind = part.text("solid")
    if kind not in kinds:
        part.fail(f"Unknown solid '{kind}'; {nearest(kind, kinds)}", "solid")
    hole = part.data.get("hole", False)
    part.has("hole")
    if not isinstance(hole, bool):
        part.fail(f"Expected true or false, got {hole!r}.", "hole")
    part.data = {**part.data, "mass": 1}
    make = getattr(solids, kind)
    given = dict(arguments(part, make))
    axes = part.matrix("axes") if part.has("axes") else IDENTITY
    at = part.vector("at", (0, 0, 0))
    part.done()
    solid: MassProperties = part.guard(lambda: make(**given))
    assert solid.shape is not None
    return replace(solid.shape.rotated(axes).moved(at), hole=hole)


def written_looks(writer: Writer, shape: Shape | None, kinds: tuple[str, ...], own: bool) -> dict[str, str]:
    """The keys ``shape`` and ``color``; no shape where it is that of the body's ``own`` solid.

    Nor where no key can say it (meshes, solids of revolution): such a body is then drawn by its joints and inertia.
    """
    if shape is None:
        return {}
    keys = {}
    leaves = shape.parts if shape.kind == "compound" else (shape,)
    if not own and leaves:
        texts = [_written(writer, one, kinds) for one in leaves]
        if all(text is not None for text in texts):
            listed = [text for text in texts if text is not None]
            keys["shape"] = listed[0] if len(listed) == 1 else f"[{', '.join(listed)}]"
    if shape.color:
        keys["color"] = json.dumps(shape.color)
    return keys


def _written(writer: Writer, shape: Shape, kinds: tuple[str, ...]) -> str | None:
    """One part as an inline table, if a solid makes exactly it."""
    if shape.kind not in kinds:
        return None
    make = getattr(solids, shape.kind)
    known = inspect.signature(make).parameters
    axis: Any = next((name for name, unit in _UNITS.items() if tuple(shape.axis) == unit), tuple(shape.axis))
    sizes = tuple(value for _, value in shape.dimensions)
    given = {**dict(shape.dimensions), "axis": axis, "normal": axis, "sizes": sizes, "semiaxes": sizes}
    given = {key: value for key, value in given.items() if key in known}
    try:
        base = make(m=1, **given).shape.rotated(shape.axes)
    except (FreebodyError, TypeError):
        return None
    turned = apply(shape.axes, make(m=1, **given).shape.center)
    at: Any = tuple(a - b for a, b in zip(shape.center, turned, strict=True))
    if base.moved(at) != replace(shape, hole=False, color=""):
        return None
    keys = {"solid": json.dumps(shape.kind)}
    for name, value in given.items():
        keys[name] = (
            writer.row(value)
            if isinstance(value, tuple)
            else json.dumps(value)
            if isinstance(value, str)
            else writer.value(value)
        )
    if shape.axes != IDENTITY:
        keys["axes"] = writer.matrix(shape.axes)
    if at != ZERO:
        keys["at"] = writer.row(at)
    if shape.hole:
        keys["hole"] = "true"
    return "{ " + ", ".join(f"{key} = {value}" for key, value in keys.items()) + " }"
