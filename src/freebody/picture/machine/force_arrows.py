"""Arrows of a free-body diagram, before they have a place: each a magnitude times a direction at a point.

They are read off the actions of :meth:`Equations.free_body`, whatever exerts them, so that a diagram holds what the
equations hold. A vector F is written as

    F = c v,   c the greatest common divisor of its components,   F = (c |v|) · v/|v|

which finds the tension of a spring, the value of an inclined force and the unknown of a reaction, and else falls apart
into components along the axes.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...describe.constraints.constraint import Rolling
from ...dynamics.constraints import _arm, radial_names, rows
from ...dynamics.kinematics import rotation
from ...model.contact import Touching
from ...scalar.algebra import ZERO, Vector, add, apply_transpose, cross, dot, floats, subtract
from ...scalar.element import Polynomial, element
from ...scalar.expression import evaluate
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
"""Width [pt] up to which an expression stands at its arrow; a longer one is named there and written below."""

MOST_TERMS = 300
"""Terms that an exact vector or place may have, to be carried along by the drawing."""


@dataclass(frozen=True, eq=False)
class Mark:
    """One arrow.

    Attributes
    ----------
    name : str
        Of the action in the equations.
    kind : str
        As of :class:`Action`, or "kinetic".
    couple : bool
    owner : str
        The joint or constraint of a reaction.
    magnitude : canonical expression
        Of the arrow as it is drawn; its sense is ``direction``.
    direction : array (3,)
        Unit vector in ground axes.
    point : array (3,)
        Where it acts, in ground axes [m].
    symbol : str
        The magnitude as text of the equations' names.
    label : str
        What stands at the arrow.
    law : str
        An equation for the label, where the expression is too long for it.
    exact : tuple of str
        Components of the vector in the axes of ``frame``, as text of the equations' names; empty if that is very long.
    at : tuple of str
        Components of the point, likewise.
    value : float or None
        Of the magnitude, where the machine moves.
    where, where_tex : str
        A condition that the drawn configuration meets and on which the magnitude stands, such as "x > 0"; and as LaTeX.
    """

    name: str
    kind: str
    couple: bool
    owner: str
    magnitude: Any
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
    """Makes the arrows of the bodies of one model in one configuration."""

    def __init__(self, equations: Equations, now: Configuration, planar: bool) -> None:
        self.e = equations
        self.now = now
        found = plane_of(equations) if planar else ""
        self.plane: Plane | None = found if isinstance(found, Plane) else None
        self.owners: dict[str, str] = {}
        self._numbers: dict[Any, float] = dict(now.lookup)
        self._texts: dict[Any, str] = {}
        for joint in equations.model.joints:
            for c in unknowns(equations.model, equations.state, joint):
                self.owners[c.name] = joint
                if now.moving:
                    force, moment = now.transmitted[joint]
                    along, of = (c.force, force) if c.force != ZERO else (c.moment, moment)
                    direction = [self.number(x) for x in along]
                    self._numbers[c.symbol] = float(np.dot(direction, [float(x) for x in of]))
        for row in rows(equations.model):
            self.owners[row.name] = row.owner
        self.owners |= {name: gear for gear, name in radial_names(equations.model).items()}
        self.frictions: set[str] = set()
        for one in equations.model.constraints.values():
            if isinstance(one, Touching):
                names = {*one.contact.tangent_names, one.contact.normal_name.replace("N", "T", 1)}
                self.frictions |= names
                self.owners.update(dict.fromkeys(names, one.contact.name))

    def text(self, x: Any) -> str:
        """An expression as text, printed once."""
        if x not in self._texts:
            self._texts[x] = text(x, self.e.ring)
        return self._texts[x]

    # -- numbers ------------------------------------------------------------------------------------

    def number(self, x: Any) -> float:
        """The value of a canonical expression in this configuration."""
        if not isinstance(x, Polynomial):
            return float(x)
        return float(evaluate(self.e.sympy(x), self._numbers, floats))

    def vector(self, v: Vector) -> Array:
        """The value of three canonical expressions."""
        return np.array([self.number(x) for x in v])

    # -- arrows -------------------------------------------------------------------------------------

    def of(self, body: FreeBody) -> list[Mark]:
        """The external forces and couples of a free body, and its reactions."""
        result: list[Mark] = []
        zero = set(self.plane.zero) if self.plane else set()
        for action in body.actions:
            if action.name in zero:
                continue
            action = self._at_contact(action)
            found: list[Mark] = []
            if action.force != ZERO:
                found += self._resolved(action.name, action.kind, False, action.force, action.at, body)
            if action.moment != ZERO:
                found += self._resolved(action.name, action.kind, True, action.moment, action.at, body)
            rubs = action.kind == "friction" or action.name in self.frictions
            result += [replace(mark, by=action.by, kind="friction" if rubs else mark.kind) for mark in found]
        return result

    def kinetic(self, body: FreeBody) -> list[Mark]:
        """m a_C at the mass centre and dH_C/dt (I_C α in a plane), in the axes in which they are shortest."""
        e = self.e
        frames = [body] if body.frame != "ground" else [e.free_body(body.body)]
        frames.append(e.free_body(body.body, frame=body.body))
        best = min(frames, key=lambda one: self._length(one.mass_acceleration))
        turn = min(frames, key=lambda one: self._length(one.momentum_rate))
        result = []
        for k in range(3):
            result += self._component(best, k, best.mass_acceleration[k], False)
        for k in range(3):
            result += self._component(turn, k, turn.momentum_rate[k], True)
        return result

    def _length(self, v: Vector) -> int:
        return sum(len(x) if isinstance(x, Polynomial) else int(x != 0) for x in v)

    def _component(self, body: FreeBody, k: int, x: Any, couple: bool) -> list[Mark]:
        if isinstance(x, int) and x == 0:
            return []
        R = body._axes
        axis: Vector = tuple(R[i][k] for i in range(3))
        letter = "xyz"[k] if body.frame == "ground" else "123"[k]
        if couple:
            inner = r"I_{C} \alpha" if self.plane else rf"\dot{{H}}_{{C{letter}}}"
        else:
            mass = latex(self.e.state(self.e.model.bodies[body.body].mass), self.e.ring)
            inner = rf"{mass} a_{{C{letter}}}"
        name = f"{'dH' if couple else 'ma'}_C{letter}"
        vector: Vector = tuple(x if i == k else 0 for i in range(3))  # type: ignore[assignment]
        mark = self._mark(name, "kinetic", couple, x, self.vector(axis), vector, body._centre, inner)
        return [replace(mark, frame=body.frame)]

    def _at_contact(self, action: Action) -> Action:
        """The force of a wheel's contact where it acts, instead of at the centre with its moment."""
        owner = self.e.model.constraints.get(self.owners.get(action.name, ""))
        if not isinstance(owner, Rolling):
            return action
        arm = _arm(self.e.model, self.e.state, owner)
        left = subtract(action.moment, cross(arm, action.force))
        return replace(action, at=add(action.at, arm), moment=left)

    def _resolved(
        self, name: str, kind: str, couple: bool, v: Vector, at: Vector, body: FreeBody
    ) -> list[Mark]:
        """One arrow where the vector has a magnitude that can be written, else its components."""
        live = [k for k in range(3) if not (isinstance(v[k], int) and v[k] == 0)]
        if len(live) == 1:
            return [self._mark(name, kind, couple, v[live[0]], np.eye(3)[live[0]], v, at)]
        R = rotation(self.e.model, self.e.state, self.e.model.bodies[body.body].link)
        turned = apply_transpose(R, v)
        own = [k for k in range(3) if not (isinstance(turned[k], int) and turned[k] == 0)]
        if len(own) == 1:
            axis = self.vector(tuple(R[i][own[0]] for i in range(3)))
            return [self._mark(name, kind, couple, turned[own[0]], axis, v, at)]
        common = self._common(v)
        if common is not None:
            c, u = common
            square = dot(u, u)
            length = self.e.state.field.sqrt(square)
            magnitude = c * length
            direction = self.vector(u)
            norm = float(np.linalg.norm(direction))
            if norm > 1e-12 and (
                not isinstance(square, Polynomial) or self._width(magnitude) <= 2.2 * WIDEST
            ):
                return [self._mark(name, kind, couple, magnitude, direction / norm, v, at)]
        result = []
        for k in live:
            part: Vector = tuple(v[k] if i == k else 0 for i in range(3))  # type: ignore[assignment]
            inner = latex_name(f"{name}_{'M' if couple else ''}{'xyz'[k]}")
            result.append(self._mark(name, kind, couple, v[k], np.eye(3)[k], part, at, inner))
        return result

    def _common(self, v: Vector) -> tuple[Any, Vector] | None:
        """(c, u) with v = c u, c the greatest common divisor of the components."""
        ring = self.e.ring
        parts = [ring.coerce(x) for x in v if not (isinstance(x, int) and x == 0)]
        nums = [ring.promoted(x.num) for x in parts]
        found = nums[0]
        for num in nums[1:]:
            found = found.gcd(num)
        c = element(ring, found, 1, parts[0].mask)
        quotients = iter(
            element(ring, num // found, x.den, x.mask) for num, x in zip(nums, parts, strict=True)
        )
        u: Vector = tuple(0 if isinstance(x, int) and x == 0 else next(quotients) for x in v)  # type: ignore
        return c, u

    def _width(self, x: Any) -> float:
        return size_of(f"${latex(x, self.e.ring)}$", 11)[0]

    def _mark(
        self,
        name: str,
        kind: str,
        couple: bool,
        magnitude: Any,
        direction: Array,
        v: Vector,
        at: Vector,
        short: str | None = None,
    ) -> Mark:
        ring = self.e.ring
        magnitude, direction, where, where_tex = self._settled(magnitude, direction)
        label, law = latex(magnitude, ring), ""
        if self._wide(label):
            # named where it stands, written below: the name belongs to the positive sense
            if short is None and label.startswith("-"):
                magnitude, direction = -magnitude, -direction
            label = self._name(name) if short is None else short
            law = f"{label} = {latex(magnitude, ring)}"
        elif label.startswith("-"):
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
            self.text(magnitude),
            label,
            law,
            self._written(v),
            self._written(at),
            value,
            where,
            where_tex,
        )

    def _name(self, name: str) -> str:
        """An action's name; of a spring k of stiffness k that of its force."""
        return rf"F_{{{latex_name(name)}}}" if name in self.e.model.names.kinds else latex_name(name)

    def _written(self, v: Vector) -> tuple[str, ...]:
        """Components as text; none where they are too long to be carried along."""
        parts = [x for x in v if isinstance(x, Polynomial)]
        inner = [
            a for x in parts for g in self.e.ring.used(x) for a in g.arguments if isinstance(a, Polynomial)
        ]
        if sum(map(len, parts)) > MOST_TERMS or any(len(a) > MOST_TERMS // 10 for a in inner):
            return ()
        return tuple(map(self.text, v))

    def _settled(self, magnitude: Any, direction: Array) -> tuple[Any, Array, str, str]:
        """Without factors a/|a| and without |a|: the configuration shows the sign of a."""
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
            if isinstance(other, Polynomial) and any(h.kind == "inverse" for h in ring.used(other)):
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
            total: Any = 0
            for monomial, c in ring.terms(ring.promoted(magnitude.num)):
                term: Any = c
                for index, n in monomial:
                    term = term * (sign * a if index == g.index else ring.variable(index)) ** n
                total = total + term
            total = total / magnitude.den
            magnitude = total
            sense = ">" if sign > 0 else "<"
            where[f"{text(a, ring)} {sense} 0"] = f"{latex(a, ring)} {sense} 0"
        return magnitude, direction, ", ".join(where), ", ".join(where.values())

    def _wide(self, label: str) -> bool:
        if len(label) > 140:
            return True
        return size_of(f"${label}$", 11)[0] > WIDEST
