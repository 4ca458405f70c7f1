"""Gears in mesh: the point where the teeth of two geared bodies touch, and the directions of the forces there.

Seen from the body that carries both, the first wheel turns about its axis n through O₁, the second about m through O₂,
with ω₁ = i ω₂. O₁ and O₂ are the centres of the pitch circles, which touch at the pitch point P. The *pitch plane* is
square to both radii there. In it lie the teeth, at the helix angle β to the axis of the first wheel, and across them
the teeth transmit the force on the first body f = F_t (t - tan β n), t = n × r₁/|r₁|. With d = O₂ - O₁, c = n·m:

    wheels    P = O₁ + k/(k - i) d,   k = c - tan β d·(n × m)/|d|        parallel (m = ± n) or crossed axes
    cones     P = A + κ (i n - m),    κ = n·(O₁ - A)/(i - c)             axes that meet in A
    rack      P = O + r e × n                                            a rack that slides along e with v = r ω

The first follows from one velocity of both bodies across the teeth; along the teeth of crossed axes they slide. Cones
roll on each other along the line A P, and a tooth of the helix angle β is inclined to it. The multiplier is the moment
(of a rack, the force) on the first joint; f does its work. The force that presses the teeth apart is square to the
pitch plane and does no work. With the pressure angle α across the teeth it is |f| tan α on either flank.

Sources: Shigley & Mischke, Mechanical Engineering Design (1989), §13-12 to 13-17; Litvin & Fuentes, Gear Geometry and
Applied Theory (2004), chapter 3.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import sympy

from ...scalar.algebra import Expression, Vector, add, apply, cross, dot, scale, subtract
from ...scalar.expression import exact
from ..frame import Frame, Point
from ..joints.joint import Joint


@dataclass(frozen=True)
class Mesh:
    """Point and directions of the force of a gear, in the axes of the body that carries both bodies.

    Attributes
    ----------
    first, second : Frame
    point : Point
        The pitch point, on the carrier.
    tangent : Vector
        Force on the first body per unit multiplier, across the teeth.
    apart : Vector
        Direction, of any length, of the force on the first body that presses the teeth apart.
    teeth : Vector or None
        Direction, of any length, in which the teeth slide along each other, if they do.
    positive : tuple
        Expressions of parameters that must be positive for a pitch point to exist.
    """

    first: Frame
    second: Frame
    point: Point
    tangent: Vector
    apart: Vector
    teeth: Vector | None = None
    positive: tuple[Any, ...] = ()

    @property
    def carrier(self) -> Frame:
        """The body that carries both bodies."""
        return self.point.body


@dataclass(frozen=True)
class _Side:
    """A joint of a gear, seen from the carrier: its motion per unit displacement of the other body."""

    body: Frame
    slides: bool
    axis: Vector
    point: Vector


def mesh_of(first: Joint, second: Joint, ratio: Expression, helix_angle: Expression = 0) -> Mesh | str:
    """Return the mesh of two joints, or the reason why only the ratio is known."""
    for joint in (first, second):
        if joint.primitives[0].turns and joint.primitives[0].slides:
            return f"'{joint.name}' is a screw"
    shared = [body for body in (first.parent, first.child) if body in (second.parent, second.child)]
    if not shared:
        return f"'{first.name}' and '{second.name}' join no common body"
    one, two = (_side(joint, shared[0] is joint.child) for joint in (first, second))
    if one.slides and two.slides:
        return f"'{first.name}' and '{second.name}' are sliders"
    make = _rack if one.slides or two.slides else _wheels
    geometry = make(one, two, sympy.sympify(ratio), sympy.tan(sympy.sympify(helix_angle)))
    if isinstance(geometry, str):
        return geometry
    point, tangent, apart = (_tidy(v) for v in geometry[:3])
    teeth = None if geometry[3] is None else _tidy(geometry[3])
    positive = tuple(x for x in map(sympy.sympify, geometry[4:]) if x.free_symbols)
    return Mesh(one.body, two.body, Point(shared[0], point), tangent, apart, teeth, positive)


def _wheels(first: _Side, second: _Side, i: Any, slope: Any) -> tuple[Any, ...] | str:
    """Point, tangent, direction apart, sliding and positive expressions of two wheels, or the reason for none."""
    n, d = first.axis, subtract(second.point, first.point)
    across = cross(n, second.axis)
    crossed = not all(_zero(x) for x in across)
    if crossed and _zero(dot(d, across)):
        return _cones(first, second, i, slope)
    if crossed and not all(_zero(x) for x in cross(d, across)):
        return "the points of its joints are not on the common perpendicular of its crossed axes"
    if not crossed and not _zero(dot(n, d)):
        return "the points of its joints are not in one plane across the axes"
    if all(_zero(x) for x in d):
        return "its wheels have one axis"
    square = dot(d, d)
    distance = sympy.sqrt(square)
    k = dot(n, second.axis) - (slope * dot(d, across) / distance if crossed else 0)
    if _zero(k):
        return "the axes of its wheels cross at right angles, and the teeth have no helix_angle"
    if _zero(k - i):
        return "its wheels turn alike, and so have no pitch point"
    point = add(first.point, scale(k / (k - i), d))
    t = cross(n, d)
    f = t if slope == 0 else subtract(t, scale(slope * distance, n))
    teeth = add(scale(distance, n), scale(slope, t)) if crossed else None
    return point, scale((k - i) / (k * square), f), scale(k * i, d), teeth, (k - i) ** 2, k**2, square


def _cones(first: _Side, second: _Side, i: Any, slope: Any) -> tuple[Any, ...] | str:
    """Return the same of bevel wheels, whose axes meet."""
    n, m, d = first.axis, second.axis, subtract(second.point, first.point)
    across, c = cross(n, m), dot(n, m)
    square = sympy.sympify(dot(across, across))
    # O₁ = A + h n, O₂ = A + g m
    h, g = -dot(cross(d, m), across) / square, -dot(cross(d, n), across) / square
    if _zero(h) and _zero(g) or not _zero(h * (i * c - 1) - g * (i - c)):
        return (
            "its axes meet, but the points of its joints are not the centres of two pitch circles of this ratio "
            "that touch"
        )
    crown = _zero(i - c)
    if crown and slope != 0:
        return "its first wheel is a crown wheel, whose teeth have no hand; name the other joint first"
    kappa = g / (i * c - 1) if crown else h / (i - c)
    line = subtract(scale(kappa * i, n), scale(kappa, m))  # from A to P
    radius = subtract(line, scale(h, n))
    v = cross(n, radius)
    r = dot(radius, radius)
    f = scale(1 / r, v)
    if slope != 0:
        hand = h / sympy.sqrt(h**2)
        f = subtract(f, scale(slope * hand / sympy.sqrt(r * dot(line, line)), line))
    # the first is pressed to its axis, or as the ring of an inner mesh from it: r₂/|r₂|² - r₁/|r₁|², |r₂| = |i r₁|
    apart = subtract(scale(h * i**2, n), scale(g, m))
    apart = subtract(apart, scale(dot(apart, line) / dot(line, line), line))
    point = add(subtract(first.point, scale(h, n)), line)
    return point, f, apart, None, r


def _rack(first: _Side, second: _Side, ratio: Any, slope: Any) -> tuple[Any, ...] | str:
    """Return the same of a wheel and a rack."""
    wheel, rack = (second, first) if first.slides else (first, second)
    n, e = wheel.axis, rack.axis
    if not _zero(dot(n, e)):
        return "its rack does not slide across the axis of its wheel"
    if not _zero(dot(n, subtract(rack.point, wheel.point))):
        return "the points of its joints are not in one plane across the axis"
    r = ratio if first.slides else 1 / ratio
    arm = scale(r, cross(e, n))
    f = e if slope == 0 else subtract(e, scale(slope * r / sympy.sqrt(r**2), n))
    if first.slides:
        return add(wheel.point, arm), f, arm, None
    return add(wheel.point, arm), scale(1 / r, f), scale(-1, arm), None


def _side(joint: Joint, inside: bool) -> _Side:
    """The other body of a joint, seen from the carrier; from the child (``inside``) the parent moves backwards."""
    primitive = joint.primitives[0]
    slides, body = not primitive.turns, joint.parent if inside else joint.child
    axes, place, sign = (joint.child_axes, joint.to, -1) if inside else (joint.parent_axes, joint.at, 1)
    if primitive.at is not None:
        place = add(place, apply(axes, primitive.at))
    return _Side(body, slides, scale(sign, apply(axes, primitive.axis)), place)


def _zero(x: Any) -> bool:
    return bool(sympy.simplify(x) == 0)


def _tidy(v: Vector) -> Vector:
    x, y, z = (exact(sympy.cancel(sympy.sympify(c))) for c in v)
    return (x, y, z)
