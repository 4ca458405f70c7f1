"""Reaction of a joint: its unknown components, and its value as a function of the motion.

A joint transmits a wrench that does no work in the motions it allows. The components have the joint's name:
``pin_x`` is a force, ``pin_Mx`` a moment. They are along ground axes if the joint's free direction is a ground axis in
every configuration or if it has none, and else along the axes of the child body.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import sympy

from ...dynamics.joints.freedom import free_motions, joint_axes
from ...dynamics.joints.motions import couple_beside, dual, slides_and_turns
from ...dynamics.kinematics import rotation
from ...dynamics.state import State
from ...model.model import Model
from ...scalar.algebra import (
    IDENTITY,
    ZERO,
    Matrix,
    Scalar,
    Vector,
    add,
    apply,
    apply_transpose,
    cross,
    divide,
    dot,
    scale,
    transpose,
)
from ..derivation.derivation import Derivation
from ..printing.show import aligned, column_latex, text_of
from ..printing.typeset import Typeset

LETTERS = "xyz"


@dataclass(frozen=True)
class Component:
    """One unknown of a joint: its wrench on the child per unit, in ground axes, about the joint's point."""

    name: str
    symbol: sympy.Symbol
    force: Vector
    moment: Vector


@dataclass(frozen=True)
class Reaction(Typeset):
    """Force and moment of a joint on its child body.

    Attributes
    ----------
    joint : str
    force, moment : SymPy column vectors
        [N], [N m], components in the axes named by ``frame``.
    on : str
        The body they act on; the opposite acts on the parent.
    about : str
        The point that the moment is about.
    frame : str
    components : dict
        Value of each named component, such as ``pin_x``.
    notes : tuple of str
        A sentence on each part that no motion determines.
    """

    joint: str
    force: Any
    moment: Any
    on: str
    about: str
    frame: str
    components: dict[str, Any]
    notes: tuple[str, ...] = ()

    @classmethod
    def of(
        cls, e: Derivation, joint: str, wrench: tuple[Vector, Vector], on: str, about: Any,
        components: dict[str, Any], notes: Sequence[str] = (),
    ) -> Reaction:  # fmt: skip
        """Return a reaction in ground axes; ``about`` is a point of the body, by its components, or a text."""
        force, moment = map(e.column, wrench)
        point = about if isinstance(about, str) else f"point ({', '.join(map(str, about))}) of {on}"
        return cls(joint, force, moment, on, point, "ground", components, tuple(notes))

    def text(self) -> str:
        """Body, point and axes of the reaction, and its components, as plain text."""
        parts = self.components or {"force": self.force, "moment": self.moment}
        lines = [f"Reaction of '{self.joint}' on '{self.on}' about {self.about}, {self.frame} axes"]
        lines += [f"  {name} = {text_of(x)}" for name, x in parts.items()]
        return "\n".join([*lines, *(f"  {note}" for note in self.notes)])

    def latex(self) -> str:
        """Force and moment as a LaTeX ``aligned`` block."""
        named = (("F", self.force), ("M", self.moment))
        return aligned(rf"\mathbf{{{name}}} &= {column_latex(v)}" for name, v in named)

    def __repr__(self) -> str:
        return self.text()


def unknowns(model: Model, state: State, name: str) -> list[Component]:
    """Components of a joint's reaction, in a stable order: forces, then moments."""
    joint = model.joints[name]
    last = joint.links[-1]
    R = rotation(model, state, last)
    if joint.pair.anchored:
        return _of_chain(model, state, name, R)
    free = [axis for axis in joint_axes(model, state, joint) if axis.free]
    links = [model.links[i] for i in joint.links]
    slides = [axis.direction for axis in free if axis.slides_only]
    turns = [axis.direction for axis in free if not axis.slides_only]
    result: list[Component] = []
    if any(link.flies for link in links):
        return result
    for letter, along in _across(model, state, slides, R):
        result.append(_component(model, state, f"{name}_{letter}", along, ZERO))
    if not any(link.pivots for link in links) and len(turns) < 3:
        for letter, along in _across(model, state, turns, R):
            result.append(_component(model, state, f"{name}_M{letter}", ZERO, along))
    if any(link.advances for link in links) and turns:
        # the thread carries an axial force f and the moment -h f, which together do no work
        n = apply(R, turns[0])
        result = [_threaded(c, n, free[0].pitch) for c in result]
    return result


def _of_chain(model: Model, state: State, name: str, R: Matrix) -> list[Component]:
    """Components of a chain or a path: each force with the couple that takes away its power in the turns."""
    slides, turns = slides_and_turns(free_motions(model, state, model.joints[name]))
    up = dual([t.turn for t in turns])
    result = []
    for letter, along in _across(model, state, [_unit(state, v) for v in slides.values()], R):
        couple = apply(R, couple_beside(apply_transpose(R, along), turns, up))
        result.append(_component(model, state, f"{name}_{letter}", along, couple))
    for letter, along in _across(model, state, [_unit(state, t.turn) for t in turns], R):
        result.append(_component(model, state, f"{name}_M{letter}", ZERO, along))
    return result


def _threaded(component: Component, n: Vector, pitch: Scalar) -> Component:
    if component.force == ZERO:
        return component
    couple = scale(-(pitch * dot(component.force, n)), n)
    return Component(component.name, component.symbol, component.force, add(component.moment, couple))


def _component(model: Model, state: State, name: str, force: Vector, moment: Vector) -> Component:
    while name in model.names.kinds or name in model.loads:
        name += "_"
    symbol = sympy.Symbol(name, real=True)
    state.field.generator(symbol, "reaction")  # type: ignore[attr-defined]
    return Component(name, symbol, force, moment)


def _across(model: Model, state: State, free: list[Vector], R: Matrix) -> list[tuple[str, Vector]]:
    """(letter, unit vector in ground axes) of the directions at right angles to the free directions."""
    if not free:
        return list(zip(LETTERS, IDENTITY, strict=True))
    if len(free) == 1:
        for axes, frame in ((apply(R, free[0]), IDENTITY), (free[0], transpose(R))):
            k = _along(axes)
            if k is not None:
                return [(LETTERS[i], frame[i]) for i in range(3) if i != k]
        return _perpendicular(state, free[0], R)
    if len(free) == 2:
        n = cross(free[0], free[1])
        for axes, frame in ((apply(R, n), IDENTITY), (n, transpose(R))):
            k = _along(axes)
            if k is not None:
                return [(LETTERS[k], frame[k])]
        return [("n", apply(R, _unit(state, n)))]
    return []


def _along(axis: Vector) -> int | None:
    """Index of the coordinate axis that a unit vector lies along; None for an oblique one."""
    nonzero = [k for k in range(3) if axis[k] != 0]
    if len(nonzero) == 1 and (axis[nonzero[0]] == 1 or axis[nonzero[0]] == -1):
        return nonzero[0]
    return None


def _unit(state: State, v: Vector) -> Vector:
    nonzero = [k for k in range(3) if v[k] != 0]
    if len(nonzero) == 1:
        return IDENTITY[nonzero[0]]
    length = state.field.sqrt(dot(v, v))
    return scale(divide(1, length), v)


def _perpendicular(state: State, n: Vector, R: Matrix) -> list[tuple[str, Vector]]:
    """Two unit vectors at right angles to an oblique axis."""
    helper = next(e for e in IDENTITY if not all(c == 0 for c in cross(n, e)))
    first = _unit(state, cross(n, helper))
    return [("p", apply(R, first)), ("q", apply(R, cross(n, first)))]
