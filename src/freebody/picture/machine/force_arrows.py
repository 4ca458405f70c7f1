"""Arrows of a free-body diagram before they have a place: each is a magnitude times a direction at a point.

They are read off the actions of :meth:`Equations.free_body`, whatever exerts them, so that a diagram contains what the
equations contain. A vector F is written as

    F = c v,   c the greatest common divisor of its components,   F = (c |v|) · v/|v|

which gives the tension of a spring, the value of an inclined force and the unknown of a reaction. A vector without
such a magnitude is split into components along the axes.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...describe.constraints.constraint import Rolling
from ...dynamics.conditions.constraints import lowest_arm, radial_names, rows
from ...dynamics.kinematics import rotation
from ...errors import TooManyTermsError
from ...model.contact_modes import Touching
from ...scalar.algebra import (
    ZERO,
    Matrix,
    Scalar,
    Vector,
    add,
    apply_transpose,
    cross,
    dot,
    floats,
    scale,
    subtract,
)
from ...scalar.element import Polynomial, element
from ...scalar.expression import evaluate
from ...scalar.substitute import Substitution
from ...symbolic.equations import Equations
from ...symbolic.free_body.action import Action
from ...symbolic.free_body.free_body import FreeBody
from ...symbolic.free_body.planar import Plane, plane_of
from ...symbolic.free_body.reaction import unknowns
from ...symbolic.printing.display import latex, text
from ...symbolic.printing.latex import latex_name
from ..paper.labels import size_of
from .configuration import Configuration

Array = NDArray[np.float64]

WIDEST = 92.0
"""Width [pt] up to which an expression is written at its arrow; a longer one is named there and written below."""

MOST_TERMS = 300
"""Most terms of an exact vector or point that the drawing carries as text; longer ones are named and not written."""

OMITTED = r"\dots"
"""The right side of the law of a name whose expression is that long."""


@dataclass(frozen=True, eq=False)
class Mark:
    """One arrow.

    Attributes
    ----------
    name : str
        Name of the action in the equations.
    kind : str
        Kind of :class:`Action`, or "kinetic".
    couple : bool
        True for a couple, False for a force.
    owner : str
        Joint or constraint of a reaction; empty for other arrows.
    magnitude : canonical expression
        Magnitude of the arrow in the sense of ``direction``.
    direction : array (3,)
        Unit vector in ground axes.
    point : array (3,)
        Point at which it acts, in ground axes [m].
    symbol : str
        The magnitude as text, in the names of the equations.
    label : str
        LaTeX of the label at the arrow.
    law : str
        Equation for the label, if the magnitude is too long to be the label.
    exact : tuple of str
        Components of the vector in the axes of ``frame``, as text in the names of the equations; empty if very long.
    at : tuple of str
        Components of the point, likewise.
    value : float or None
        Value of the magnitude at a time of a motion [N] or [N m].
    where, where_tex : str
        Condition under which the magnitude holds and which the drawn configuration meets, such as "x > 0"; and as
        LaTeX.
    frame : str
        "ground", or the body whose axes ``exact`` and ``at`` refer to.
    by : str
        Body that exerts the action.
    """

    name: str
    kind: str
    couple: bool
    owner: str
    magnitude: Scalar
    direction: Array
    point: Array
    symbol: str
    label: str
    law: str
    exact: tuple[str, ...]
    at: tuple[str, ...]
    value: float | None = None
    where: str = ""
    where_tex: str = ""
    frame: str = "ground"
    by: str = ""


class Marks:
    """Makes the arrows of the bodies of one model in one configuration, with or without the reactions of joints."""

    def __init__(
        self, equations: Equations, now: Configuration, planar: bool, *, reactions: bool = True
    ) -> None:
        self.e = equations
        self.now = now
        plane = plane_of(equations) if planar else ""
        self.plane: Plane | None = plane if isinstance(plane, Plane) else None
        self.owners: dict[str, str] = {}
        self._numbers: dict[Any, float] = dict(now.lookup)
        self._texts: dict[Any, str] = {}
        for joint in equations.model.joints if reactions else ():
            for c in unknowns(equations.model, equations.state, joint):
                self.owners[c.name] = joint
                if now.moving:
                    force, moment = now.transmitted[joint]
                    along, vector = (c.force, force) if c.force != ZERO else (c.moment, moment)
                    direction = [self.number(x) for x in along]
                    self._numbers[c.symbol] = float(np.dot(direction, [float(x) for x in vector]))
        for row in rows(equations.model):
            self.owners[row.name] = row.owner
        self.owners |= {name: gear for gear, name in radial_names(equations.model).items()}
        self.frictions: set[str] = set()
        for touching in equations.model.constraints.values():
            if isinstance(touching, Touching):
                contact = touching.contact
                names = {*contact.tangent_names, contact.normal_name.replace("N", "T", 1)}
                self.frictions |= names
                self.owners.update(dict.fromkeys(names, contact.name))

    def text(self, x: Scalar) -> str:
        """Text of an expression for readers by machine, in canonical form; it is printed once and kept."""
        if x not in self._texts:
            self._texts[x] = text(x, self.e.ring, closed=False)
        return self._texts[x]

    # -- numbers ------------------------------------------------------------------------------------

    def number(self, x: Scalar) -> float:
        """Value of a canonical expression in this configuration; 0 where it has none, as the slip of a tyre at rest."""
        if not isinstance(x, Polynomial):
            return float(x)
        try:
            return float(evaluate(self.e.sympy(x), self._known, floats))
        except ZeroDivisionError:
            return 0.0

    def _known(self, atom: Any) -> float:
        """Value of a symbol; that of a root is found when it is first asked for."""
        g = self.e.ring.find(atom)
        if atom not in self._numbers and g is not None:
            self._numbers[atom] = Substitution(self.e.ring, floats, self._numbers).generator(g.index)
        return self._numbers[atom]

    def vector(self, v: Vector) -> Array:
        """Values of three canonical expressions."""
        return np.array([self.number(x) for x in v])

    # -- arrows -------------------------------------------------------------------------------------

    def of(self, body: FreeBody) -> list[Mark]:
        """Arrows of the external forces and couples of a free body, and of its reactions."""
        result: list[Mark] = []
        zero = set(self.plane.zero) if self.plane else set()
        for action in body.actions:
            if action.name in zero:
                continue
            action = self._at_contact(action)
            marks: list[Mark] = []
            if action.force != ZERO:
                marks += self.resolved(action.name, action.kind, False, action.force, action.at, body)
            if action.moment != ZERO:
                marks += self.resolved(action.name, action.kind, True, action.moment, action.at, body)
            kind = "friction" if action.name in self.frictions else action.kind
            result += [replace(mark, by=action.by, kind=kind) for mark in marks]
        return result

    def kinetic(self, body: FreeBody) -> list[Mark]:
        """Arrows of m a_C at the mass centre and of dH_C/dt (I_C α in a plane), in the axes that make them shortest."""
        e = self.e
        frames = [body] if body.frame != "ground" else [e.free_body(body.body)]
        frames.append(e.free_body(body.body, frame=body.body))
        linear = min(frames, key=lambda body: self._length(body.mass_acceleration))
        angular = min(frames, key=lambda body: self._length(body.momentum_rate))
        result = []
        guide = self._guide_axes(body.body)
        if guide is not None and linear.frame == "ground":
            along = apply_transpose(guide[0], linear.mass_acceleration)
            if self._length(along) < self._length(linear.mass_acceleration):
                return [
                    *(mark for k in range(3) for mark in self._component(linear, k, along[k], False, guide)),
                    *(
                        mark
                        for k in range(3)
                        for mark in self._component(angular, k, angular.momentum_rate[k], True)
                    ),
                ]
        for k in range(3):
            result += self._component(linear, k, linear.mass_acceleration[k], False)
        for k in range(3):
            result += self._component(angular, k, angular.momentum_rate[k], True)
        return result

    def _guide_axes(self, body: str) -> tuple[Matrix, str] | None:
        """Axes along which the joint of a body to the ground displaces it, and their letters; None if it has none."""
        joint = next((joint for joint in self.e.model.joints.values() if joint.child == body), None)
        if joint is None or joint.parent != "ground" or not (joint.pair.planar or joint.pair.prismatic):
            return None
        return self.e.state.matrix(self.e.model.links[joint.links[0]].rotation), "tnb"

    def _length(self, v: Vector) -> int:
        """Number of terms of three canonical expressions."""
        return sum(len(x) if isinstance(x, Polynomial) else int(x != 0) for x in v)

    def _component(
        self, body: FreeBody, k: int, x: Scalar, couple: bool, guide: tuple[Matrix, str] | None = None
    ) -> list[Mark]:
        if x == 0:
            return []
        R, letters = (body._axes, "xyz" if body.frame == "ground" else "123") if guide is None else guide
        axis: Vector = tuple(R[i][k] for i in range(3))
        letter = letters[k]
        if couple:
            inner = r"I_{C} \alpha" if self.plane else rf"\dot{{H}}_{{C{letter}}}"
        else:
            mass = latex(self.e.state(self.e.model.bodies[body.body].mass), self.e.ring)
            inner = rf"{mass} a_{{C{letter}}}"
        name = f"{'dH' if couple else 'ma'}_C{letter}"
        vector: Vector = tuple(x if i == k else 0 for i in range(3))  # type: ignore[assignment]
        if guide is not None:  # written in ground axes
            vector = scale(x, axis)
        mark = self._mark(name, "kinetic", couple, x, self.vector(axis), vector, body._centre, inner)
        return [replace(mark, frame=body.frame)]

    def _at_contact(self, action: Action) -> Action:
        """The action with the force of a rolling contact at the contact, instead of at the centre with its moment."""
        owner = self.e.model.constraints.get(self.owners.get(action.name, ""))
        if not isinstance(owner, Rolling):
            return action
        arm = lowest_arm(self.e.model, self.e.state, owner)
        moment = subtract(action.moment, cross(arm, action.force))
        return replace(action, at=add(action.at, arm), moment=moment)

    def resolved(
        self, name: str, kind: str, couple: bool, v: Vector, at: Vector, body: FreeBody
    ) -> list[Mark]:
        """Arrow of a vector whose magnitude can be written; arrows of its components otherwise."""
        in_ground = [k for k in range(3) if v[k] != 0]
        if len(in_ground) == 1:
            return [self._mark(name, kind, couple, v[in_ground[0]], np.eye(3)[in_ground[0]], v, at)]
        if sum(len(x) for x in v if isinstance(x, Polynomial)) > MOST_TERMS:
            return self._by_components(name, kind, couple, v, at)
        R = rotation(self.e.model, self.e.state, self.e.model.bodies[body.body].link)
        turned = apply_transpose(R, v)
        in_body = [k for k in range(3) if turned[k] != 0]
        if len(in_body) == 1:
            axis = self.vector(tuple(R[i][in_body[0]] for i in range(3)))
            return [self._mark(name, kind, couple, turned[in_body[0]], axis, v, at)]
        c, u = self._common(v)
        try:
            square = dot(u, u)
        except TooManyTermsError:  # no label has that many terms
            return self._by_components(name, kind, couple, v, at)
        magnitude = c * self.e.state.field.sqrt(square)
        direction = self.vector(u)
        norm = float(np.linalg.norm(direction))
        short = not isinstance(square, Polynomial) or self._width(magnitude) <= 2.2 * WIDEST
        if norm > 1e-12 and short:
            return [self._mark(name, kind, couple, magnitude, direction / norm, v, at)]
        return self._by_components(name, kind, couple, v, at)

    def _by_components(self, name: str, kind: str, couple: bool, v: Vector, at: Vector) -> list[Mark]:
        """Arrows of the components of a vector in ground axes."""
        result = []
        for k in range(3):
            if v[k] != 0:
                part: Vector = tuple(v[k] if i == k else 0 for i in range(3))  # type: ignore[assignment]
                inner = latex_name(f"{name}_{'M' if couple else ''}{'xyz'[k]}")
                result.append(self._mark(name, kind, couple, v[k], np.eye(3)[k], part, at, inner))
        return result

    def _common(self, v: Vector) -> tuple[Scalar, Vector]:
        """(c, u) with v = c u, c the greatest common divisor of the components."""
        ring = self.e.ring
        parts = [ring.coerce(x) for x in v if x != 0]
        nums = [ring.promoted(x.num) for x in parts]
        divisor = nums[0]
        for num in nums[1:]:
            divisor = divisor.gcd(num)
        c = element(ring, divisor, 1, parts[0].mask)
        quotients = iter(
            element(ring, num // divisor, x.den, x.mask) for num, x in zip(nums, parts, strict=True)
        )
        u: Vector = tuple(0 if x == 0 else next(quotients) for x in v)  # type: ignore
        return c, u

    def _width(self, x: Scalar) -> float:
        """Width of an expression on paper [pt]."""
        return size_of(f"${latex(x, self.e.ring)}$", 11)[0]

    def _opposed(self, magnitude: Scalar, label: str) -> bool:
        """Return whether an arrow is drawn the other way, so that action and reaction have one label.

        A label begins with a minus sign, or a difference is printed as such both ways: then the leading term decides.
        """
        if label.startswith("-") or not isinstance(magnitude, Polynomial):
            return label.startswith("-")
        leading = magnitude.num.leading_coefficient()
        return leading < 0 and not latex(-magnitude, self.e.ring).startswith("-")

    def _mark(
        self,
        name: str,
        kind: str,
        couple: bool,
        magnitude: Scalar,
        direction: Array,
        v: Vector,
        at: Vector,
        short: str | None = None,
    ) -> Mark:
        """Arrow of the vector v = magnitude * direction at a point; ``short`` labels it if the magnitude is long."""
        ring = self.e.ring
        long = isinstance(magnitude, Polynomial) and len(magnitude) > MOST_TERMS
        where = where_tex = law = ""
        if not long:
            magnitude, direction, where, where_tex = self._settled(magnitude, direction)
        label = (self._name(name) if short is None else short) if long else latex(magnitude, ring)
        if long:
            law = f"{label} = {OMITTED}"
        elif self._wide(label):
            # the label is a name for the magnitude; a name from the equations belongs to the positive sense
            if short is None and self._opposed(magnitude, label):
                magnitude, direction = -magnitude, -direction
            label = self._name(name) if short is None else short
            law = f"{label} = {latex(magnitude, ring)}"
        elif label.startswith("-") if kind == "kinetic" else self._opposed(magnitude, label):
            magnitude, direction = -magnitude, -direction
            label = latex(magnitude, ring)
        value = None
        if self.now.moving:
            value = self.number(magnitude)
            if value < 0:
                magnitude, direction, value = -magnitude, -direction, -value
                label = f"-{label}" if law else latex(magnitude, ring)
        return Mark(
            name,
            kind,
            couple,
            self.owners.get(name, ""),
            magnitude,
            direction,
            self.vector(at),
            OMITTED if long else self.text(magnitude),
            label,
            law,
            self._written(v),
            self._written(at),
            value,
            where,
            where_tex,
        )

    def _name(self, name: str) -> str:
        """LaTeX name of an action; F_k for a spring k whose name is also that of a symbol."""
        return rf"F_{{{latex_name(name)}}}" if name in self.e.model.names.kinds else latex_name(name)

    def _written(self, v: Vector) -> tuple[str, ...]:
        """Components as text; empty if they are too long for the drawing to carry."""
        parts = [x for x in v if isinstance(x, Polynomial)]
        inner = [
            a for x in parts for g in self.e.ring.used(x) for a in g.arguments if isinstance(a, Polynomial)
        ]
        if sum(map(len, parts)) > MOST_TERMS or any(len(a) > MOST_TERMS // 10 for a in inner):
            return ()
        return tuple(map(self.text, v))

    def _settled(self, magnitude: Scalar, direction: Array) -> tuple[Scalar, Array, str, str]:
        """Magnitude and direction without |a| and a/|a|, and the condition on a: the configuration gives its sign."""
        ring = self.e.ring
        where: dict[str, str] = {}
        if not isinstance(magnitude, Polynomial):
            return magnitude, direction, "", ""
        for g in ring.used(magnitude):
            size = g.arguments[0] if g.kind == "inverse" else None
            inner = ring.used(size) if isinstance(size, Polynomial) else []
            if len(inner) != 1 or inner[0].name != "abs" or not isinstance(magnitude, Polynomial):
                continue
            a = inner[0].arguments[0]
            other = magnitude * size / a
            if self._inverses(other) - self._inverses(magnitude):  # a is no factor of the magnitude
                continue
            sign = 1 if self.number(a) > 0 else -1
            magnitude, direction = other, sign * direction
            sense = ">" if sign > 0 else "<"
            where[f"{text(a, ring)} {sense} 0"] = f"{latex(a, ring)} {sense} 0"
        for g in ring.used(magnitude) if isinstance(magnitude, Polynomial) else []:
            if g.name != "abs" or not isinstance(magnitude, Polynomial):
                continue
            a = g.arguments[0]
            sign = 1 if self.number(a) > 0 else -1
            total: Scalar = 0
            for monomial, c in ring.terms(ring.promoted(magnitude.num)):
                term: Scalar = c
                for index, n in monomial:
                    term = term * (sign * a if index == g.index else ring.variable(index)) ** n
                total = total + term
            magnitude = total / magnitude.den
            sense = ">" if sign > 0 else "<"
            where[f"{text(a, ring)} {sense} 0"] = f"{latex(a, ring)} {sense} 0"
        return magnitude, direction, ", ".join(where), ", ".join(where.values())

    def _inverses(self, x: Scalar) -> set[int]:
        """Numbers of the generators that stand for 1/a in an expression."""
        used = self.e.ring.used(x) if isinstance(x, Polynomial) else []
        return {g.index for g in used if g.kind == "inverse"}

    def _wide(self, label: str) -> bool:
        """True if a label is too wide to be written at its arrow."""
        return len(label) > 140 or size_of(f"${label}$", 11)[0] > WIDEST
