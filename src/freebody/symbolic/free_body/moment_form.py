"""Moment equations about any point, by the acceleration of that point.

About a point A of the body, with ρ from A to the mass centre C,

    Σ M_A = ρ × m a_A + I_A α + ω × I_A ω                  (planar:  M_A = ρ × m a_A + I_A α)

and about any other moving point A, to which the body moves with ρ' = v_C - v_A and ρ'' = a_C - a_A,

    Σ M_A = ρ × m a_A + I_C α + ω × I_C ω + ρ × m ρ''.

Each time it is proven canonically that the right side equals dH_C/dt + ρ × m a_C.

Source: chapter 6, eqs (6.19), (6.25), (6.28).
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import sympy

from ...describe.body import Body
from ...describe.frame import Point
from ...dynamics.kinematics import accelerations, point_acceleration, point_position, velocities
from ...errors import ModelError, nearest
from ...scalar.algebra import (
    ZERO,
    Matrix,
    Scalar,
    Vector,
    add,
    add_matrices,
    apply,
    cross,
    dot,
    outer,
    scale,
    subtract,
    subtract_matrices,
)
from ..derivation.bodies import NamedBody, PointOf, own_body
from ..printing.display import latex, text
from ..printing.show import aligned
from ..printing.typeset import Typeset
from .balance import BodyBalance, body_balance, total_of
from .planar import plane_in
from .reaction import LETTERS


class MomentForm(Typeset):
    """Moment equations of a free body about a point, term by term. Made by :meth:`FreeBody.moment_form`.

    Attributes
    ----------
    body, about, frame : str
        The body, the point, the axes of the components.
    of_body : bool
        True if the point is fixed in the body.
    """

    def __init__(self, body: BodyBalance, about: Any) -> None:
        self._free = body
        self._e = body._e
        self.body = body.body
        self.frame = body.frame
        self.of_body, position, acceleration, arm = self._point(about)
        self.about = f"joint '{about}'" if isinstance(about, str) else str(about)
        e, model, state = self._e, self._e.model, self._e.state
        place = body._place
        w, _ = velocities(model, state)[place.link]
        wdot, _ = accelerations(model, state, e.udot)[place.link]
        mass = state(place.mass)
        rho = subtract(body._centre, position)
        inertia = state.matrix(place.inertia)
        if self.of_body:
            inertia = add_matrices(inertia, _parallel(mass, arm))
        name = "I_A" if self.of_body else "I_C"
        terms = {
            "rho x m a_A": cross(rho, scale(mass, acceleration)),
            f"{name} alpha": apply(body._R, apply(inertia, wdot)),
            f"omega x {name} omega": apply(body._R, cross(w, apply(inertia, w))),
        }
        if body.spin_rate != ZERO:
            terms["rate of the rotors' spin"] = apply(body._R, body.spin_rate)
        if not self.of_body:
            relative = subtract(e.center_acceleration(self.body), acceleration)
            terms["rho x m rho''"] = cross(rho, scale(mass, relative))
        self.canonical_terms: dict[str, Vector] = {name: body._in_axes(v) for name, v in terms.items()}
        self._position = position

    def _point(self, about: Any) -> tuple[bool, Vector, Vector, Vector]:
        """Return (fixed in the body, position, acceleration, ρ in body axes) of A."""
        e, free = self._e, self._free
        model, state = e.model, e.state
        if isinstance(about, str):
            about = _joint_point(free, about)
        if isinstance(about, Body):
            about = about.origin
        if not isinstance(about, Point | PointOf):
            raise ModelError(
                f"Expected a point, such as bar.point(0, 1, 0), or the name of a joint to take moments about, "
                f"got {about!r}."
            )
        if isinstance(about, Point):
            own_body(model, about.body, "a point to take moments about")
        fixed = not about.body.is_ground and about.body.name == free.body
        arm = ZERO
        if fixed:
            arm = state.vector([c - x for c, x in zip(free._place.center, about.components, strict=True)])
        return (
            fixed,
            point_position(model, state, about),
            point_acceleration(model, state, about, e.udot),
            arm,
        )

    @cached_property
    def moments(self) -> Vector:
        """Σ M_A of all forces and couples in the axes of the components, canonical."""
        return self._free._moments_about(self._position)

    @cached_property
    def balances(self) -> tuple[tuple[Scalar, Scalar], ...]:
        """(Σ M_A, sum of the terms), canonical, three of them."""
        return tuple(zip(self.moments, total_of(self.canonical_terms.values()), strict=True))

    @cached_property
    def proven(self) -> bool:
        """True if the terms add up to dH_C/dt + ρ × m a_C: their difference is canonically zero."""
        about_c = body_balance(self._e, self.body)
        e = self._e
        rho = subtract(self._free._centre, self._position)
        ma = scale(e.state(self._free._place.mass), e.center_acceleration(self.body))
        rate = self._free._in_axes(add(about_c.momentum_rate, cross(rho, ma)))
        return all(total == expected for (_, total), expected in zip(self.balances, rate, strict=True))

    @property
    def terms(self) -> dict[str, Any]:
        """The terms on the right as SymPy columns, by name [N m]."""
        return {name: self._e.column(v) for name, v in self.canonical_terms.items()}

    @property
    def equations(self) -> tuple[Any, ...]:
        """Σ M_A = sum of the terms, three SymPy ``Eq``."""
        show = self._e.displayed
        return tuple(sympy.Eq(show(a), show(b), evaluate=False) for a, b in self.balances)

    def _rows(self) -> list[int]:
        """Printed components: along the normal of a planar model, else all that are not 0 = 0."""
        plane = plane_in(self._free)
        if not isinstance(plane, str):
            return [plane[1]]
        return [k for k in range(3) if self.balances[k] != (0, 0)]

    def text(self) -> str:
        """The general form, and each component term by term, as plain text."""
        ring = self._e.ring
        names = " + ".join(self.canonical_terms)
        lines = [
            f"Moments on '{self.body}' about A = {self.about}, components in {self.frame} axes",
            f"  M_A = {names}",
        ]
        for k in self._rows():
            parts = [text(v[k], ring) for v in self.canonical_terms.values() if v[k] != 0]
            right = " + ".join(f"({part})" for part in parts) or "0"
            lines.append(f"  moment {LETTERS[k]}:  {text(self.moments[k], ring, closed=False)} = {right}")
        return "\n".join(lines)

    def latex(self) -> str:
        """The general form and the components as a LaTeX ``aligned`` block."""
        ring = self._e.ring
        inertia = "I_A" if self.of_body else "I_C"
        general = (
            r"\mathbf{M}_A &= \boldsymbol{\rho} \times m \mathbf{a}_A + "
            + inertia
            + r" \boldsymbol{\alpha} + "
            r"\boldsymbol{\omega} \times " + inertia + r" \boldsymbol{\omega}"
        )
        if not self.of_body:
            general += r" + \boldsymbol{\rho} \times m \ddot{\boldsymbol{\rho}}"
        rows = [general]
        for k in self._rows():
            parts = [latex(v[k], ring) for v in self.canonical_terms.values() if v[k] != 0]
            right = " + ".join(rf"\left({part}\right)" for part in parts) or "0"
            rows.append(f"{latex(self.moments[k], ring, closed=False)} &= {right}")
        return aligned(rows)

    def __repr__(self) -> str:
        return self.text()


def _joint_point(free: BodyBalance, name: str) -> PointOf:
    """Point of a joint on its parent if that is the free body, else on its child."""
    model = free._e.model
    if name not in model.joints:
        raise ModelError(f"Unknown joint '{name}' to take moments about; {nearest(name, model.joints)}")
    joint = model.joints[name]
    if joint.parent == free.body:
        return PointOf(NamedBody(joint.parent, joint.parent == "ground"), joint.at)
    return PointOf(NamedBody(joint.child), joint.to)


def _parallel(mass: Scalar, arm: Vector) -> Matrix:
    """m (ρ·ρ 1 - ρ ρᵀ), the term of the parallel axis theorem."""
    d = dot(arm, arm)
    spread: Matrix = ((d, 0, 0), (0, d, 0), (0, 0, d))
    a, b, c = subtract_matrices(spread, outer(arm, arm))
    return (scale(mass, a), scale(mass, b), scale(mass, c))
