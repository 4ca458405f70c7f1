"""The contact of two shapes as one program over two poses and the numbers of the shapes.

    (R_A, p_A, R_B, p_B, numbers of A, numbers of B)  ->  g, n, P, Q, t1, t2, reaches

A is the feature, B the surface, as in :mod:`freebody.dynamics.conditions.contact`, whose formulas these are. There is
one program for each two kinds of shapes, whatever the machine. Where neither shape gives tangents, `narrow_phase` adds
them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import sympy

from ...describe.shapes.shape import ContactShape, numbers
from ...describe.system import System
from ...dynamics.conditions.contact import touch
from ...dynamics.kinematics import Posture
from ...dynamics.state import State
from ...model import Model, assemble
from ...model.contact import Contact
from ...program.kernel import KernelSet
from ...program.kernels import compile_tape
from ...scalar.algebra import IDENTITY, ZERO, Vector
from ...scalar.trace import Tape
from ...space.mass import MassProperties
from .family_record import TOUCH

Kind = tuple[type[ContactShape], bool]
"""Class of a shape, and whether it is touched from inside."""


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


def numbers_of(shape: ContactShape, origin: Vector) -> list[Any]:
    """Return the expressions of a shape's numbers, places from the origin of the link."""
    result: list[Any] = []
    for name, count in numbers(type(shape)).items():
        value = getattr(shape, name)
        shift = origin if name in shape.places else ZERO
        result += [a + b for a, b in zip(value, shift, strict=True)] if count > 1 else [value]
    return result


def pair_program(first: ContactShape, second: ContactShape, planar: Vector | None) -> PairProgram:
    """Return the program of two members: that of their kinds."""
    return _program((type(first), first.inside), (type(second), second.inside), planar)


@lru_cache(maxsize=128)
def _program(first: Kind, second: Kind, planar: Vector | None) -> PairProgram:
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
    defined = planar is not None or max(feature.precedence, surface.precedence) > 0
    tangents = [*it.tangents, ZERO][:2] if defined else [ZERO, ZERO]
    outputs = [it.gap, *it.normal, *it.on_feature, *it.on_surface, *tangents[0], *tangents[1], *it.reach]
    assert len(outputs) <= TOUCH
    compiled = compile_tape(tape, {"touch": outputs}, state.t, [*inputs, *values.values()], [])
    return PairProgram(compiled, len(it.reach), defined)


def _shape(kind: Kind, body: Any, values: dict[Any, Any], tape: Tape) -> ContactShape:
    """Return a shape of a kind whose numbers are inputs of the tape; ``values`` receives these."""
    shape, inside = kind

    def number(name: str) -> Any:
        symbol = sympy.Symbol(f"{body.name}_{name}")
        values[symbol] = tape.input(str(symbol))
        return symbol

    fields: dict[str, Any] = {
        name: tuple(number(f"{name}{k}") for k in range(count)) if count > 1 else number(name)
        for name, count in numbers(shape).items()
    }
    return shape(body, **fields, **({"inside": True} if inside else {}))


@lru_cache(maxsize=1)
def _two_bodies() -> Model:
    """Return a machine of two free bodies, whose shapes the programs are about."""
    s = System("two bodies")
    for name in "AB":
        body = s.body(name, MassProperties(1, ZERO, IDENTITY))
        s.free(f"free{name}", s.ground, body)
    return assemble(s)
