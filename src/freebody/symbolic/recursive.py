"""Equations of motion in recursive form, with names for the quantities of each body.

Outward from the ground, in the order of the links,

    φ_k = φ_{k-1} + θ_k,    a_k = a_{k-1} + α_{k-1} × r + ω_{k-1} × (ω_{k-1} × r),

inward from the tips, the force and the moment that the joint of body k transmits to it,

    f_k = m a_C + Σ f_{k+1} - loads,    n_k = dH/dt + Σ (n_{k+1} + r × f_{k+1}) - loads,

and for every coordinate the projection of these on its motion. The algorithm is the same as for the other equations
(`dynamics.newton_euler`), but each component of more than one term gets a name. So every line is short, and the number
of lines is proportional to the number of bodies. If all axes on the path from the ground are parallel, components are
along fixed axes and angles are measured from the ground; for other bodies, components are along their own axes.

Source: Luh, Walker and Paul, On-line computational scheme for mechanical manipulators (1980); as there, gravity is an
acceleration of the ground.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import sympy

from ..dynamics.conditions.constrained import constrained_loading
from ..dynamics.conditions.constraints import residuals, rows
from ..dynamics.kinematics import Posture, accelerations, velocities
from ..dynamics.loads.loading import Loading, loading
from ..dynamics.newton_euler import inverse_dynamics
from ..dynamics.state import State, polynomial_state
from ..model.model import GROUND, Model
from ..scalar.algebra import (
    IDENTITY,
    Matrix,
    Scalar,
    Vector,
    add,
    apply,
    apply_transpose,
    congruence,
    multiply,
    negate,
)
from ..scalar.polynomial import Polynomial, Ring
from ..space.spatial import Inertia, Spatial
from ..space.turn import matrix_about
from .printing.printer import Printer

FACTORS = 3
"""Most factors of a term that gets no name."""

FEW = 6
"""Most bodies that are listed by name."""

POSITIONS, MOTION, FORCES = range(3)
"""Parts of the definitions, in the order in which they are printed."""


@dataclass(frozen=True)
class Definition:
    """A named quantity: its symbol, its value as a canonical polynomial, and its part of the definitions.

    A rate of an angle is defined by the angle, whose generator is ``angle``.
    """

    symbol: Any
    value: Scalar
    part: int
    angle: int | None = None


@dataclass(frozen=True)
class Turn:
    """Rotation of a link by ``angle`` about a fixed ``axis``: R = R(axis, angle) ``rest``."""

    axis: Vector | None
    angle: Scalar
    rate: Scalar
    second: Scalar
    rest: Matrix


class Names:
    """The named quantities of one machine, in the order of their definition."""

    def __init__(self, model: Model, ring: Ring) -> None:
        self.ring = ring
        self.definitions: dict[int, Definition] = {}
        self._symbols: dict[Scalar, Scalar] = {}
        self._time = model.names.atoms["t"]
        self._reserved = {*model.names.kinds, *model.loads, *(row.name for row in rows(model))}

    def fresh(self, name: str) -> str:
        """Return a name that the model does not have, and reserve it."""
        while name in self._reserved:
            name += "_"
        self._reserved.add(name)
        return name

    def named(self, name: str, value: Scalar, kind: str, part: int) -> Scalar:
        """Return ``value`` itself if it is short, else a symbol for it; equal and opposite values share a symbol."""
        if type(value) is not Polynomial or (len(value) == 1 and value.num.total_degree() <= FACTORS):
            return value
        for signed, sign in ((value, 1), (-value, -1)):
            if signed in self._symbols:
                return sign * self._symbols[signed]
        symbol = sympy.Symbol(self.fresh(name), real=True)
        return self._add(symbol, value, kind, part)

    def _add(self, symbol: Any, value: Scalar, kind: str, part: int, angle: int | None = None) -> Scalar:
        x = self.ring.generator(symbol, kind)
        (g,) = self.ring.used(x)
        self.definitions[g.index] = Definition(symbol, value, part, angle)
        self._symbols[value] = x
        return x

    def vector(self, name: str, v: Vector, kind: str, part: int) -> Vector:
        """Return a vector with symbols for its long components."""
        x, y, z = (self.named(f"{name}_{c}", a, kind, part) for c, a in zip("xyz", v, strict=True))
        return (x, y, z)

    def angle(self, name: str, value: Scalar, rates: Sequence[Scalar]) -> tuple[Scalar, Scalar, Scalar]:
        """Return an angle and its two rates, or symbols for them: a name, and the name with primes."""
        if type(value) is not Polynomial or (len(value) == 1 and value.num.total_degree() == 1):
            return value, *rates
        phi = sympy.Function(self.fresh(name), real=True)(self._time)
        whole = self._add(phi, value, "coordinate", POSITIONS)
        (g,) = self.ring.used(whole)
        first, second = (
            self._add(symbol, x, kind, POSITIONS, g.index) if type(x) is Polynomial else x
            for symbol, x, kind in zip(
                (phi.diff(), phi.diff().diff()), rates, ("speed", "acceleration"), strict=True
            )
        )
        return whole, first, second

    def used_by(self, elements: Sequence[Scalar]) -> list[Definition]:
        """Return the definitions that elements need, in order."""
        needed: set[int] = set()
        pending = list(elements)
        while pending:
            x = pending.pop()
            for g in self.ring.of_mask(self.ring.depends(x)):
                if g.index in self.definitions and g.index not in needed:
                    needed.add(g.index)
                    definition = self.definitions[g.index]
                    pending.append(definition.value)
                    if definition.angle is not None:
                        pending.append(self.ring.variable(definition.angle))
        return [d for i, d in self.definitions.items() if i in needed]


class _Placed(State):
    """State in the axes of the links, with names for the lines of action and forces of springs and dampers."""

    def __init__(self, base: State, names: Names) -> None:
        super().__init__(base.model, base.field, base.t, base.q, base.u, base.values)
        self._names = names

    def intermediate(self, what: str, of: Any, value: Any) -> Any:
        if what == "line":
            return self._names.vector(f"d_{of}", value, "coordinate", POSITIONS)
        return self._names.vector(f"F_{of}", value, "reaction", FORCES) if what == "pull" else value


class _Working(State):
    """State in working axes: fixed axes if all axes on the path from the ground are parallel, else the link's own axes.

    The algorithms use the axes in which the joints, inertias and subspaces are given.
    """

    def __init__(self, base: State, names: Names, udot: Sequence[Scalar]) -> None:
        super().__init__(base.model, base.field, base.t, base.q, base.u, base.values)
        self._base = base
        self._names = names
        self._udot = udot
        self._turns: list[Turn | None] = []
        for i in range(len(self.model.links)):
            self._turns.append(self._turn(i))

    def label(self, i: int) -> str:
        """Name of the joint of a link, with a number for links inside the joint."""
        joint = self.model.joints[self.model.links[i].joint]
        return (
            self.model.links[i].joint
            if joint.links[-1] == i
            else f"{self.model.links[i].joint}_{joint.links.index(i) + 1}"
        )

    def _turn(self, i: int) -> Turn | None:
        link = self.model.links[i]
        parent = Turn(None, 0, 0, 0, IDENTITY) if link.parent == GROUND else self._turns[link.parent]
        if parent is None or link.own:
            return None
        rest = multiply(parent.rest, self.matrix(link.rotation))
        if not (link.turns_only or link.advances):
            return Turn(parent.axis, parent.angle, parent.rate, parent.second, rest)
        n = apply(rest, self.vector(link.axis))
        y, rate, second = self(link.displacement), self.rate(link), self.second_rate(link, self._udot)
        axis = n if parent.axis is None else parent.axis
        if axis == negate(n):
            y, rate, second = -y, -rate, -second
        elif axis != n:
            return None
        name = f"phi_{link.body}" if link.body else f"phi_{self.label(i)}"
        rates = (parent.rate + rate, parent.second + second)
        return Turn(axis, *self._names.angle(name, parent.angle + y, rates), rest)

    def axes(self, i: int) -> Matrix:
        """Return the rotation from a link's axes to its working axes."""
        if i == GROUND:
            return IDENTITY
        turn = self._turns[i]
        if turn is None:
            return IDENTITY
        if turn.axis is None:
            return turn.rest
        if ("axes", i) not in self.cache:
            self.cache["axes", i] = multiply(matrix_about(turn.axis, turn.angle, self.field), turn.rest)
        return self.cache["axes", i]

    def fixed(self, i: int) -> bool:
        """Return True if the working axes of a link are fixed."""
        return i == GROUND or self._turns[i] is not None

    def joint(self, i: int) -> tuple[Matrix, Vector, Spatial]:
        if i not in self._joints:
            parent = self.model.links[i].parent
            R, p, (w, v) = self._base.joint(i)
            R_P, R_i = self.axes(parent), self.axes(i)
            if self.fixed(i):
                R = IDENTITY
            elif self.fixed(parent):
                R = multiply(R_P, R)
            turn = self._turns[i]
            if (
                turn is not None
                and turn.axis is not None
                and (self.model.links[i].turns_only or self.model.links[i].advances)
            ):
                before = self._turns[parent] if parent != GROUND else None
                w = tuple((turn.rate - (before.rate if before else 0)) * n for n in turn.axis)
            else:
                w = apply(R_i, w)
            self._joints[i] = (R, apply(R_P, p), (w, apply(R_i, v)))
        return self._joints[i]

    def inertia(self, i: int) -> Inertia:
        if i not in self._inertias:
            m, h, J = self._base.inertia(i)
            R = self.axes(i)
            self._inertias[i] = (m, apply(R, h), J if R == IDENTITY else congruence(R, J))
        return self._inertias[i]

    def spin(self, i: int) -> tuple[Vector, Vector] | None:
        spin = self._base.spin(i)
        if spin is None:
            return None
        return apply(self.axes(self.model.links[i].parent), spin[0]), apply(self.axes(i), spin[1])

    def subspace(self, i: int) -> Spatial:
        n, s = self._base.subspace(i)
        return apply(self.axes(i), n), apply(self.axes(i), s)

    def intermediate(self, what: str, of: Any, value: Any) -> Any:
        turn, label = self._turns[of], self.label(of)
        names = self._names
        if what == "force":
            n, f = value
            f = names.vector(label, f, "reaction", FORCES)
            x, y, z = (
                names.named(f"{label}_M{c}", a, "reaction", FORCES) for c, a in zip("xyz", n, strict=True)
            )
            return (x, y, z), f
        turning, moving = value
        kind = "speed" if what == "velocity" else "acceleration"
        if turn is not None:
            along = turn.rate if what == "velocity" else turn.second
            turning = (0, 0, 0) if turn.axis is None else tuple(along * n for n in turn.axis)
        else:
            body = self.model.links[of].body or label
            letter = "omega" if kind == "speed" else "alpha"
            turning = names.vector(f"{letter}_{body}", turning, kind, MOTION)
        return turning, names.vector(f"{'v' if kind == 'speed' else 'a'}_{label}", moving, kind, MOTION)


class NamedMotion:
    """Motion of a model in named quantities."""

    def __init__(self, model: Model) -> None:
        self.model = model
        self.ring = Ring(capacity=64 + len(model.parameters) + 6 * model.n_q + 24 * len(model.links))
        self.ring.budget.subject = f"the recursive equations of '{model.name}'"
        self.ring.budget.cure = "Ask for numbers: fb.simulate, fb.compile, fb.linearize with values=."
        self.names = Names(model, self.ring)
        base = _Placed(polynomial_state(model, self.ring), self.names)
        self.udot = tuple(self.ring.generator(speed.acceleration, "acceleration") for speed in model.speeds)
        self._base = base
        self.working = _Working(base, self.names, self.udot)

    def place(self) -> State:
        """Form the postures and velocities of the links, with names, and return the state that holds them."""
        model, base, working, names = self.model, self._base, self.working, self.names
        postures: list[Posture] = []
        for i, link in enumerate(model.links):
            label = working.label(i)
            R, p, _ = base.joint(i)
            at = Posture(IDENTITY, (0, 0, 0)) if link.parent == GROUND else postures[link.parent]
            if working.fixed(i):
                turned = working.axes(i)
            else:
                rows_ = multiply(at.rotation, R)
                turned = tuple(  # type: ignore[assignment]
                    names.vector(f"R_{label}_{c}", row, "coordinate", POSITIONS)
                    for c, row in zip("xyz", rows_, strict=True)
                )
            place = add(at.position, apply(at.rotation, p))
            postures.append(Posture(turned, names.vector(f"r_{label}", place, "coordinate", POSITIONS)))
        base.cache["postures"] = postures
        link_velocities = []
        for i, (w, v) in enumerate(velocities(model, working)):
            R = working.axes(i)
            link_velocities.append((apply_transpose(R, w), apply_transpose(R, v)))
        base.cache["velocities"] = link_velocities
        return base

    def accelerations(self) -> list[Spatial]:
        """Return the accelerations of the links in their own axes, with names for those in working axes."""
        result = []
        for i, (alpha, a) in enumerate(accelerations(self.model, self.working, self.udot)):
            R = self.working.axes(i)
            result.append((apply_transpose(R, alpha), apply_transpose(R, a)))
        return result

    def meanings(self, definitions: Sequence[Definition], less: str = "") -> list[tuple[str, list[Any]]]:
        """Return (heading, [(symbol, value), ...]) of definitions; accelerations are ``less`` something."""
        in_own_axes = [
            link.body for i, link in enumerate(self.model.links) if link.body and not self.working.fixed(i)
        ]
        axes = "along ground axes"
        if in_own_axes:
            names = _listed(in_own_axes)
            if len(in_own_axes) < len(self.model.bodies):
                axes = f"along ground axes, those of {names} along their own axes"
            else:
                axes = f"along the own axes of {names}"
        headings = {
            POSITIONS: "Angles and positions, outward from the ground; an angle's rates are its derivatives:",
            MOTION: f"Motion at the joints, outward; accelerations{less}; components {axes}:",
            FORCES: "Forces and moments that the joints pass on, springs and motors along them included, inward:",
        }
        result = []
        for part, heading in headings.items():
            lines = [(d.symbol, d.value) for d in definitions if d.part == part and d.angle is None]
            if lines:
                result.append((heading, lines))
        return result

    def written(
        self, kind: type[Printer], sign: str, formulas: Sequence[tuple[str, list[Any]]]
    ) -> Iterator[tuple[str, list[str]]]:
        """Yield (heading, lines) of formulas as written by one kind of printer."""
        printer = kind(self.ring)
        for heading, pairs in formulas:
            lines = []
            for left, right in pairs:
                name = printer.generator(left, 1) if isinstance(left, sympy.Basic) else printer.show(left)
                lines.append(f"{name}{sign}{printer.show(right)}")
            yield heading, lines


class Recursive(NamedMotion):
    """Equations of motion of a model in named quantities."""

    def __init__(self, model: Model) -> None:
        super().__init__(model)
        if model.loads or model.constraints:
            self.place()
        self.balances = inverse_dynamics(model, self.working, self.udot, self._loads())
        self.residuals = [x for x in residuals(model, self._base) if x != 0] if model.constraints else []

    def _loads(self) -> Loading:
        """The loads and the forces of constraints, in working axes."""
        model, base, working = self.model, self._base, self.working
        if model.constraints:
            multipliers = [
                self.ring.generator(sympy.Symbol(row.name, real=True), "reaction") for row in rows(model)
            ]
            loads = constrained_loading(model, base, multipliers, self.udot)
        else:
            loads = loading(model, base, udot=self.udot)
        turned = {
            i: (apply(working.axes(i), n), apply(working.axes(i), f)) for i, (n, f) in loads.wrenches.items()
        }
        return Loading(turned, loads.along, loads.generalized)

    @property
    def normal(self) -> int | None:
        """Index of the ground axis that alone is an axis of rotation and along which no body moves; else None."""
        working, still = self.working, [True, True, True]
        turns = [True, True, True]
        for i, (w, v) in enumerate(velocities(self.model, working)):
            if not working.fixed(i):
                return None
            for k in range(3):
                still[k] = still[k] and v[k] == 0
                turns[k] = turns[k] and all(w[j] == 0 for j in range(3) if j != k)
        return next((k for k in (2, 1, 0) if still[k] and turns[k]), None)

    @cached_property
    def definitions(self) -> list[Definition]:
        """The named quantities that the equations need, in order."""
        return self.names.used_by([*self.balances, *self.residuals])

    @cached_property
    def formulas(self) -> list[tuple[str, list[tuple[Any, Any]]]]:
        """(heading, [(left, right), ...]) of the definitions in the order of their use, then of the equations."""
        equations = [(x, 0) for x in (*self.balances, *self.residuals)]
        return [
            *self.meanings(self.definitions, " less that of gravity"),
            ("Equations of motion:", equations),
        ]


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names) if len(names) <= FEW else f"{', '.join(names[: FEW - 1])}, ..., {names[-1]}"
