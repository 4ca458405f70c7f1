"""Teeth in mesh: where two geared bodies touch, and along what they push each other.

Seen from the body C that carries both, a wheel turns about its axis n with the angular velocity ω, a rack slides along
e. The pitch point P is where both bodies have the same velocity. With d from the axis of the first wheel to that of the
second, ω₁ = i ω₂, and of a wheel and a rack v = κ ω:

    P = O₁ + d / (1 - i),        P = O + κ e × n

between the axes of wheels that turn against each other (i < 0), outside for i > 0. A force f on the first body at P,
and -f on the second, does the work of the condition: f = λ (1 - i) n × d / d². What presses the teeth apart is along
the centre line and does no work; with the pressure angle α it is |f| tan α, whichever flank bears.

Source: Shigley & Mischke, Mechanical Engineering Design (1989), §13-3 and 13-12.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import sympy

from ..describe.constraints.constraint import Gear
from ..scalar.algebra import Vector, add, apply, cross, dot, scale, subtract
from ..scalar.expression import exact

if TYPE_CHECKING:
    from .model import Link, Model


@dataclass(frozen=True)
class Mesh:
    """The place and the directions of the force of a gear, in the axes of the link that carries both bodies.

    Attributes
    ----------
    carrier : int
    first, second : Body
    point : Vector
        The pitch point, from the origin of the carrier.
    tangent : Vector
        Force on the first body per unit multiplier.
    apart : Vector
        Along the force on the first body that presses the teeth apart, of any length.
    positive : tuple
        Expressions of parameters that are positive where there is a pitch point.
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


def mesh_of(model: Model, gear: Gear) -> Mesh | str:
    """The mesh of a gear, or the reason why its ratio alone is known."""
    numbers = [model.joints[joint.name].links[0] for joint in (gear.first, gear.second)]
    links = [model.links[i] for i in numbers]
    for joint, link in zip((gear.first, gear.second), links, strict=True):
        if link.kind == "screw":
            return f"'{joint.name}' is a screw"
    shared = [c for c in (links[0].parent, numbers[0]) if c in (links[1].parent, numbers[1])]
    if not shared:
        return f"'{gear.first.name}' and '{gear.second.name}' join no common body"
    one, two = (
        _side(joint, link, shared[0] == i)
        for joint, link, i in zip((gear.first, gear.second), links, numbers, strict=True)
    )
    if one.slides and two.slides:
        return f"'{gear.first.name}' and '{gear.second.name}' are sliders"
    ratio = sympy.sympify(gear.ratio)
    found = _rack(one, two, ratio) if one.slides or two.slides else _wheels(one, two, ratio)
    if isinstance(found, str):
        return found
    point, tangent, apart = (_tidy(v) for v in found[:3])
    positive = tuple(x for x in map(sympy.sympify, found[3:]) if x.free_symbols)
    return Mesh(shared[0], one.body, two.body, point, tangent, apart, positive)


def _wheels(one: _Side, two: _Side, ratio: Any) -> tuple[Any, ...] | str:
    n = one.axis
    if not all(_zero(c) for c in cross(n, two.axis)):
        return "the axes of its wheels are not parallel"
    d = subtract(two.point, one.point)
    if not _zero(dot(n, d)):
        return "the points of its joints are not in one plane across the axes"
    if all(_zero(c) for c in d):
        return "its wheels have one axis"
    i = ratio * dot(n, two.axis)
    if _zero(1 - i):
        return "its wheels turn alike, and so have no pitch point"
    square = dot(d, d)
    point = add(one.point, scale(1 / (1 - i), d))
    return point, scale((1 - i) / square, cross(n, d)), scale(i, d), (1 - i) ** 2, square


def _rack(one: _Side, two: _Side, ratio: Any) -> tuple[Any, ...] | str:
    wheel, rack = (two, one) if one.slides else (one, two)
    n, e = wheel.axis, rack.axis
    if not _zero(dot(n, e)):
        return "its rack does not slide across the axis of its wheel"
    if not _zero(dot(n, subtract(rack.point, wheel.point))):
        return "the points of its joints are not in one plane across the axis"
    travel = ratio if one.slides else 1 / ratio
    arm = scale(travel, cross(e, n))
    if one.slides:
        return add(wheel.point, arm), e, arm
    return add(wheel.point, arm), scale(1 / travel, e), scale(-1, arm)


def _side(joint: Any, link: Link, inside: bool) -> _Side:
    """With the carrier as the parent of the joint, or as its child, which sees the other body move back."""
    if inside:
        return _Side(joint.parent, link.kind == "slider", scale(-1, link.axis), (0, 0, 0))
    return _Side(joint.child, link.kind == "slider", apply(link.rotation, link.axis), link.position)


def _zero(x: Any) -> bool:
    return bool(sympy.simplify(x) == 0)


def _tidy(v: Vector) -> Vector:
    x, y, z = (exact(sympy.cancel(sympy.sympify(c))) for c in v)
    return (x, y, z)
