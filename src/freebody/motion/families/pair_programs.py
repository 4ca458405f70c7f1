"""The contact of two shapes as one program over two poses and the numbers of the shapes.

    (R_A, p_A, R_B, p_B, numbers of A, numbers of B)  ->  g, n, P, Q, t1, t2, reaches

A is the feature, B the surface, as in :mod:`freebody.dynamics.contact`, whose formulas these are. There is one program
for each two kinds of shapes, whatever the machine. Where neither shape gives tangents, `narrow_phase` adds them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import sympy

from ...describe.contact_shapes import Ball, Circle, Cylinder, Ellipsoid, Plane, Segment
from ...describe.frame import Point
from ...describe.system import System
from ...dynamics.contact import touch
from ...dynamics.kinematics import Posture
from ...dynamics.state import State
from ...model import Model, assemble
from ...model.contact import Contact
from ...program.kernels import KernelSet, compile_tape
from ...scalar.algebra import IDENTITY, ZERO, Vector
from ...scalar.trace import Tape
from ...space.mass import MassProperties
from .family_record import TOUCH

VECTORS = {
    "point": ("components",), "end": ("components",), "sphere": ("at",), "ellipsoid": ("at", "half_axes"),
    "circle": ("at", "axis"), "cylinder": ("at", "axis"), "plane": ("at", "normal", "first", "second"),
    "segment": ("start", "along", "normal", "end"),
}  # fmt: skip
"""Fields of three components of each kind. They stand in this order before the number in `NUMBERS`."""
NUMBERS = {"sphere": "radius", "circle": "radius", "cylinder": "radius", "segment": "length"}
CLASSES: dict[str, Any] = {
    "point": Point, "end": Point, "sphere": Ball, "ellipsoid": Ellipsoid, "circle": Circle, "cylinder": Cylinder,
    "plane": Plane, "segment": Segment,
}  # fmt: skip
OUTSIDE = {"bowl": "sphere", "ring": "circle", "pipe": "cylinder"}
"""Kinds of which these are the inside."""
FIXED = ("at", "components", "start", "end")
"""Fields that are places: from the origin of the body, in the description."""


@dataclass(frozen=True)
class PairProgram:
    """A compiled program; ``reaches`` and ``defined`` (whether it gives tangents) describe its outputs."""

    compiled: KernelSet
    reaches: int
    defined: bool

    @property
    def address(self) -> int:
        """Address of its code."""
        return int(self.compiled["touch"].address)


def numbers_of(shape: Any, kind: str, origin: Vector) -> list[Any]:
    """Return the expressions of a shape's numbers, places from the origin of the link."""
    kind = OUTSIDE.get(kind, kind)
    result: list[Any] = []
    for name in VECTORS[kind]:
        shift = origin if name in FIXED else ZERO
        result += [a + b for a, b in zip(getattr(shape, name), shift, strict=True)]
    return [*result, getattr(shape, NUMBERS[kind])] if kind in NUMBERS else result


@lru_cache(maxsize=128)
def pair_program(first: str, second: str, planar: Vector | None) -> PairProgram:
    """Return the program of two kinds of members."""
    model, tape = _two_bodies(), Tape()
    poses, inputs = [], []
    for letter in "AB":
        x = [tape.input(f"{letter}{k}") for k in range(12)]
        poses.append(Posture((tuple(x[0:3]), tuple(x[3:6]), tuple(x[6:9])), tuple(x[9:12])))  # type: ignore[arg-type]
        inputs += x
    values: dict[Any, Any] = {}
    shapes = [
        _shape(kind, body, values, tape)
        for kind, body in zip((first, second), model.described[0].bodies.values(), strict=True)
    ]
    state = State(model, tape, tape.input("t"), model.rest[: model.n_q], [0] * model.n_u, values)
    state.cache["postures"] = poses
    feature, surface = shapes
    contact = Contact(
        "pair",
        "pair",
        feature,
        surface,
        0,
        0,
        0,
        "newton",
        planar,
        IDENTITY[2],
        "N",
        ("T",) if planar else ("T1", "T2"),
    )
    it = touch(model, state, contact)
    walls = {"plane", "circle", "cylinder", "ring", "pipe"}
    defined = planar is not None or not walls.isdisjoint((first, second))
    tangents = [*it.tangents, ZERO][:2] if defined else [ZERO, ZERO]
    outputs = [it.gap, *it.normal, *it.on_feature, *it.on_surface, *tangents[0], *tangents[1], *it.reach]
    assert len(outputs) <= TOUCH
    compiled = compile_tape(tape, {"touch": outputs}, state.t, [*inputs, *values.values()], [])
    return PairProgram(compiled, len(it.reach), defined)


def _shape(kind: str, body: Any, values: dict[Any, Any], tape: Tape) -> Any:
    """Return a shape of a kind whose numbers are inputs of the tape; ``values`` receives these."""
    outside = OUTSIDE.get(kind, kind)

    def number(name: str) -> Any:
        symbol = sympy.Symbol(f"{body.name}_{name}")
        values[symbol] = tape.input(str(symbol))
        return symbol

    fields: dict[str, Any] = {
        name: tuple(number(f"{name}{k}") for k in range(3)) for name in VECTORS[outside]
    }
    if outside in NUMBERS:
        fields[NUMBERS[outside]] = number(NUMBERS[outside])
    if kind in OUTSIDE:
        fields["inside"] = True
    return CLASSES[outside](body, **fields)


@lru_cache(maxsize=1)
def _two_bodies() -> Model:
    """Return a machine of two free bodies, whose shapes the programs are about."""
    s = System("two bodies")
    for name in "AB":
        body = s.body(name, MassProperties(1, ZERO, IDENTITY))
        s.free(f"free{name}", s.ground, body)
    return assemble(s)


def chosen(first: str, second: str) -> tuple[str, str, bool]:
    """Return two kinds as feature and surface, and whether they are exchanged: a hollow is the surface."""
    turned = first in OUTSIDE
    return (second, first, True) if turned else (first, second, False)
