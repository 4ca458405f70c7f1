"""Gear wheels of a drawing: teeth and pitch circles where their place is known.

In the plane wheels and racks have the outline of their teeth. In space the lines of the teeth are drawn on the pitch
surfaces: point of a tooth at the distance s along the line on which the surfaces touch, turned about the axis by
s tan β / r with its helix angle β at the pitch radius r.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...describe.constraints.constraint import Gear
from ...describe.contacts.backlash import Backlash
from ...describe.contacts.mesh import Mesh
from ..paper import symbols
from ..paper.palette import GREY, INK
from ..paper.sheet import Circle, Line, Style
from .machine_drawing import MachineDrawing
from .shapes import Primitive, numbers

Array = NDArray[np.float64]

ROUND = ("disk", "cylinder", "ring")
"""Kinds of solids whose outline a wheel's teeth replace."""

TOOTH = 12.0
"""Length of a pitch on paper, about [pt]."""

THREAD = Style(INK, 0.6)
PITCH_LINE = Style(GREY, 0.8, (8.0, 2.0, 1.5, 2.0))


@dataclass
class Wheel:
    """One side of a mesh in numbers: a wheel, or a rack with the radius infinity, in ground axes [m]."""

    body: str
    axis: Array  # of a rack, the direction in which it slides
    center: Array
    pitch_point: Array
    tooth: Array  # unit vector along the tooth in the pitch plane
    outward: Array  # unit vector from the teeth to those of the partner
    radius: float

    @property
    def rack(self) -> bool:
        """True if it slides."""
        return math.isinf(self.radius)


def meshes(m: MachineDrawing) -> Iterator[tuple[str, list[Wheel]]]:
    """Yield the name and both sides of every mesh whose pitch point is known."""
    played = {contact.owner: contact.law for contact in m.model.contacts if isinstance(contact.law, Backlash)}
    geared = {name: x for name, x in m.model.constraints.items() if isinstance(x, Gear)}
    every: dict[str, Gear | Backlash] = {**geared, **played}
    for name, gear in every.items():
        if isinstance(gear.mesh, Mesh):
            yield name, _sides(m, gear, gear.mesh)


def _sides(m: MachineDrawing, gear: Gear | Backlash, mesh: Mesh) -> list[Wheel]:
    R, _ = m.now.posture(mesh.carrier.name)
    point = m.now.point(mesh.point)
    tangent, apart = (R @ numbers(m.now.state, v) for v in (mesh.tangent, mesh.apart))
    away = apart / np.linalg.norm(apart)
    tooth = np.cross(away, tangent)
    tooth /= np.linalg.norm(tooth)
    result = []
    for joint, body, sign in ((gear.first, mesh.first, -1.0), (gear.second, mesh.second, 1.0)):
        i = m.model.joints[joint.name].links[0]
        n = m.axis_in_space(m.model.links[i], i)
        at = m.now.place(joint.parent.name, joint.at)
        slides = not joint.primitives[0].turns
        center = at + float((point - at) @ n) * n
        radius = math.inf if slides else float(np.linalg.norm(point - center))
        result.append(Wheel(body.name, n, center, point, tooth, sign * away, radius))
    return result


def solids_with_teeth(m: MachineDrawing) -> list[Primitive]:
    """Return the round solids of a plane drawing that are drawn with teeth instead of their outline."""
    if not m.view.planar:
        return []
    return [piece for _, pair in meshes(m) for wheel in pair if (piece := _solid(m, wheel)) is not None]


def _solid(m: MachineDrawing, wheel: Wheel) -> Primitive | None:
    if wheel.rack or wheel.body == "ground":
        return None
    pieces = [piece for piece in m.pieces[wheel.body][::-1] if piece.kind in ROUND]
    return next((piece for piece in pieces if "radius" in piece.dimensions), None)


def gears(m: MachineDrawing) -> None:
    """Draw the teeth of gears, with their pitch circles and lines; rings of inner meshes before what turns in them."""
    draw = _in_plane if m.view.planar else _in_space
    for name, pair in sorted(meshes(m), key=lambda item: -max(_radii(item[1]))):
        draw(m, name, pair)


def _radii(pair: list[Wheel]) -> list[float]:
    return [wheel.radius for wheel in pair if not wheel.rack]


def _pitch(m: MachineDrawing, pair: list[Wheel], least: int) -> float:
    """Return the length of a pitch that divides the circle of the smallest wheel [m]."""
    around = 2 * math.pi * min(_radii(pair))
    return around / max(least, round(around * m.scale / TOOTH))


def _in_plane(m: MachineDrawing, name: str, pair: list[Wheel]) -> None:
    pitch = _pitch(m, pair, 8)
    inner = (
        all(not wheel.rack for wheel in pair)
        and float((pair[0].center - pair[0].pitch_point) @ (pair[1].center - pair[1].pitch_point)) > 0
    )
    largest = max(wheel.radius for wheel in pair)
    for k, wheel in sorted(enumerate(pair), key=lambda item: -item[1].radius if inner else 0):
        point, center = m.page(wheel.pitch_point), m.page(wheel.center)
        if wheel.rack:
            along = m.view(wheel.axis)
            out = m.view(wheel.outward)
            length = 1.6 * m.scale * min(_radii(pair))
            items = symbols.rack(point, along / np.linalg.norm(along), out, m.scale * pitch, length, bool(k))
        else:
            radius = m.scale * wheel.radius
            across = point - center
            count = max(8, round(2 * math.pi * wheel.radius / pitch))
            phase = math.atan2(across[1], across[0]) + (math.pi / count if k else 0.0)
            ring = inner and wheel.radius == largest
            solid = _solid(m, wheel)
            fill = "none" if ring or solid is None else m.fill(wheel.body)
            items = symbols.teeth(center, radius, count, phase, fill)
            if ring:
                items.append(Circle(center, radius + 9.0, Style(INK, 1.0)))
        m.add(items, class_="gear", data_constraint=name)


def _in_space(m: MachineDrawing, name: str, pair: list[Wheel]) -> None:
    """Draw the pitch circles, and those parts of the lines of the teeth that face the reader."""
    pitch = _pitch(m, pair, 12)
    width = min(_radii(pair)) / 2
    for wheel in pair:
        items: list[Any] = []
        if wheel.rack:
            if float(wheel.outward @ m.view.toward) > 0:
                half = width * wheel.tooth / 2
                teeth = [wheel.pitch_point + t * pitch * wheel.axis for t in range(-4, 5)]
                items = [Line(np.array([m.page(x - half), m.page(x + half)]), THREAD) for x in teeth]
        else:
            items = list(_lines(m, wheel, pitch, width))
            circle = [_turned(wheel, 2 * math.pi * j / 60, wheel.pitch_point) for j in range(61)]
            items.append(Line(np.array([m.page(x) for x in circle]), PITCH_LINE))
        m.add(items, class_="gear", data_constraint=name)


def _lines(m: MachineDrawing, wheel: Wheel, pitch: float, width: float) -> Iterator[Any]:
    """Yield the lines of the teeth of a wheel in space, as far as they face the reader."""
    arm = wheel.pitch_point - wheel.center
    around = np.cross(wheel.axis, arm) / wheel.radius
    line = np.cross(wheel.outward, around)
    cosine = float(wheel.tooth @ line)
    if cosine < 0:
        line, cosine = -line, -cosine
    slope = float(wheel.tooth @ around) / cosine
    count = max(1, round(2 * math.pi * wheel.radius * cosine / pitch))
    # without a length of its own, a worm is about as long as it is thick
    length = width if abs(slope) < 1 else 2.4 * wheel.radius
    ends = _ends(m, wheel, line) or (-length / 2, length / 2)
    if abs(float(wheel.outward @ wheel.axis)) > 1e-9:  # a bevel wheel: from its pitch circle towards the apex
        ends = (0.0, -math.copysign(length, float(line @ arm)))
    steps = np.linspace(*ends, 3 + int(abs(slope) * abs(ends[1] - ends[0]) / wheel.radius * 8))
    for j in range(count):
        run: list[Array] = []
        for s in steps:
            angle = 2 * math.pi * j / count + slope * s / wheel.radius
            out = _turned(wheel, angle, wheel.center + wheel.outward) - wheel.center
            if float(out @ m.view.toward) > 0:
                run.append(m.page(_turned(wheel, angle, wheel.pitch_point + s * line)))
                continue
            if len(run) > 1:
                yield Line(np.array(run), THREAD)
            run = []
        if len(run) > 1:
            yield Line(np.array(run), THREAD)


def _ends(m: MachineDrawing, wheel: Wheel, line: Array) -> tuple[float, float] | None:
    """Return where the cylinder that bears the teeth ends, along ``line`` from the pitch point; None without one."""
    R, origin = m.now.posture(wheel.body)
    for piece in m.pieces.get(wheel.body, ()):
        size = piece.dimensions
        if piece.kind == "cylinder" and math.isclose(size["radius"], wheel.radius):
            middle = float((origin + R @ piece.center - wheel.pitch_point) @ line)
            return middle - size["length"] / 2, middle + size["length"] / 2
    return None


def _turned(wheel: Wheel, angle: float, point: Array) -> Array:
    """Return a point turned about the axis of a wheel."""
    r = point - wheel.center
    n = wheel.axis
    along = float(r @ n) * n
    return wheel.center + along + math.cos(angle) * (r - along) + math.sin(angle) * np.cross(n, r)
