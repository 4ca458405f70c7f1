"""Gears in mesh: the point where two geared bodies touch, and the directions of the forces there.

Seen from the body C that carries both bodies, a wheel turns about its axis n with the angular velocity ω, and a rack
slides along e. Both bodies have the same velocity at the pitch point P. Let d be the vector from the axis of the first
wheel to the axis of the second. With ω₁ = i ω₂ for two wheels, and v = κ ω for a wheel and a rack,

    P = O₁ + d / (1 - i),        P = O + κ e × n.

P is between the axes of wheels that turn against each other (i < 0), and outside for i > 0. A force f on the first body
at P, and -f on the second, does the work of the condition: f = λ (1 - i) n × d / d². The force that presses the teeth
apart is along the centre line and does no work. With the pressure angle α it is |f| tan α on either flank.

Source: Shigley & Mischke, Mechanical Engineering Design (1989), §13-3 and 13-12.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import sympy

from ..describe.constraints.constraint import Gear
from ..scalar.algebra import Expression, Vector, add, apply, cross, dot, scale, subtract
from ..scalar.expression import exact
from .parts import JointPlace, Link


@dataclass(frozen=True)
class Mesh:
    """Point and directions of the force of a gear, in the axes of the link that carries both bodies.

    Attributes
    ----------
    carrier : int
    first, second : Body
    point : Vector
        The pitch point from the origin of the carrier [m].
    tangent : Vector
        Force on the first body per unit multiplier.
    apart : Vector
        Direction, of any length, of the force on the first body that presses the teeth apart.
    positive : tuple
        Expressions of parameters that must be positive for a pitch point to exist.
    """

    carrier: int
    first: Any
    second: Any
    point: Vector
    tangent: Vector
    apart: Vector
    positive: tuple[Any, ...] = ()


@dataclass(frozen=True)
class _Side:
    """A joint of a gear, seen from the carrier: its motion per unit displacement of the other body."""

    body: Any
    slides: bool
    axis: Vector
    point: Vector


def mesh_of(joints: Mapping[str, JointPlace], tree: Sequence[Link], gear: Gear) -> Mesh | str:
    """Return the mesh of a gear, or the reason why only its ratio is known."""
    numbers = [joints[joint.name].links[0] for joint in (gear.first, gear.second)]
    links = [tree[i] for i in numbers]
    for joint, link in zip((gear.first, gear.second), links, strict=True):
        if link.advances:
            return f"'{joint.name}' is a screw"
    shared = [c for c in (links[0].parent, numbers[0]) if c in (links[1].parent, numbers[1])]
    if not shared:
        return f"'{gear.first.name}' and '{gear.second.name}' join no common body"
    first, second = (
        _side(joint, link, shared[0] == i)
        for joint, link, i in zip((gear.first, gear.second), links, numbers, strict=True)
    )
    if first.slides and second.slides:
        return f"'{gear.first.name}' and '{gear.second.name}' are sliders"
    ratio = sympy.sympify(gear.ratio)
    with_rack = first.slides or second.slides
    geometry = _rack(first, second, ratio) if with_rack else _wheels(first, second, ratio)
    if isinstance(geometry, str):
        return geometry
    point, tangent, apart = (_tidy(v) for v in geometry[:3])
    positive = tuple(x for x in map(sympy.sympify, geometry[3:]) if x.free_symbols)
    return Mesh(shared[0], first.body, second.body, point, tangent, apart, positive)


def _wheels(first: _Side, second: _Side, ratio: Expression) -> tuple[Any, ...] | str:
    """Point, tangent, direction apart and positive expressions of two wheels, or the reason why there are none."""
    n = first.axis
    if not all(_zero(c) for c in cross(n, second.axis)):
        return "the axes of its wheels are not parallel"
    d = subtract(second.point, first.point)
    if not _zero(dot(n, d)):
        return "the points of its joints are not in one plane across the axes"
    if all(_zero(c) for c in d):
        return "its wheels have one axis"
    i = ratio * dot(n, second.axis)
    if _zero(1 - i):
        return "its wheels turn alike, and so have no pitch point"
    square = dot(d, d)
    point = add(first.point, scale(1 / (1 - i), d))
    return point, scale((1 - i) / square, cross(n, d)), scale(i, d), (1 - i) ** 2, square


def _rack(first: _Side, second: _Side, ratio: Expression) -> tuple[Any, ...] | str:
    """Point, tangent and direction apart of a wheel and a rack, or the reason why there are none."""
    wheel, rack = (second, first) if first.slides else (first, second)
    n, e = wheel.axis, rack.axis
    if not _zero(dot(n, e)):
        return "its rack does not slide across the axis of its wheel"
    if not _zero(dot(n, subtract(rack.point, wheel.point))):
        return "the points of its joints are not in one plane across the axis"
    travel = ratio if first.slides else 1 / ratio
    arm = scale(travel, cross(e, n))
    if first.slides:
        return add(wheel.point, arm), e, arm
    return add(wheel.point, arm), scale(1 / travel, e), scale(-1, arm)


def _side(joint: Any, link: Link, inside: bool) -> _Side:
    """The other body of a joint, seen from the carrier; from the child (``inside``) the parent moves backwards."""
    if inside:
        return _Side(joint.parent, link.slides_only, scale(-1, link.axis), (0, 0, 0))
    return _Side(joint.child, link.slides_only, apply(link.rotation, link.axis), link.position)


def _zero(x: Any) -> bool:
    return bool(sympy.simplify(x) == 0)


def _tidy(v: Vector) -> Vector:
    x, y, z = (exact(sympy.cancel(sympy.sympify(c))) for c in v)
    return (x, y, z)
