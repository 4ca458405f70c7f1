"""Exact derivation of the equations of a model, on canonical polynomials.

    M(q) u' + h(q, u, t) = Q + Gᵀ λ,        G u' + γ = 0

Every quantity is formed when it is first asked for, and kept. :class:`freebody.symbolic.equations.Equations` adds the
products that users ask for.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import sympy

from ...dynamics.conditions.constraint_forces import wrenches
from ...dynamics.conditions.constraints import rows
from ...dynamics.conditions.linearized import Linearized, linearized
from ...dynamics.kinematics import Posture, accelerations, link_postures, poses, turning, velocities
from ...dynamics.loads.actions import accelerating
from ...dynamics.loads.loading import loading
from ...dynamics.newton_euler import inverse_dynamics
from ...scalar.algebra import Scalar, Vector, add, apply
from ..recursive import Recursive
from .canonical_model import CanonicalModel
from .energy import Energy
from .momentum import MomentumOf
from .questions import named


class Derivation(CanonicalModel):
    """Canonical polynomials of one model's equations, and their SymPy forms."""

    # -- equations of motion ----------------------------------------------------------------------

    @cached_property
    def _left_loads(self) -> set[str]:
        """Names of the loads on the left side: springs, dampers, and those with added mass."""
        asking = accelerating(self.model)
        return {
            name
            for name, load in self.model.loads.items()
            if load.look.role in ("spring", "damper") or name in asking
        }

    @cached_property
    def recursive(self) -> Recursive:
        """The equations of motion in named quantities."""
        return Recursive(self.model)

    @cached_property
    @named("the equations of motion")
    def canonical_left(self) -> tuple[Scalar, ...]:
        """M u' + h as canonical polynomials, by one pass of Newton-Euler with u' as symbols."""
        return inverse_dynamics(
            self.model,
            self.state,
            self.udot,
            loading(self.model, self.state, self._left_loads, udot=self.udot),
        )

    @cached_property
    @named("the mass matrix")
    def canonical_mass_matrix(self) -> tuple[tuple[Scalar, ...], ...]:
        """M as canonical polynomials: equal entries are identical, zero is recognised.

        The entries are read from the left sides, which are linear in u'. That takes half the work of composite bodies
        on polynomials.
        """
        atoms = [speed.acceleration for speed in self.model.speeds]
        return tuple(
            tuple(self.ring.derivative(left, atom) for atom in atoms) for left in self.canonical_left
        )

    @cached_property
    @named("the velocity terms")
    def canonical_bias(self) -> tuple[Scalar, ...]:
        """h as canonical polynomials: velocity terms, weight, springs and dampers; no applied loads."""
        result = []
        for left, row in zip(self.canonical_left, self.canonical_mass_matrix, strict=True):
            for entry, acceleration in zip(row, self.udot, strict=True):
                left = left - entry * acceleration
            result.append(left)
        return tuple(result)

    @cached_property
    @named("the equations of motion")
    def canonical_applied(self) -> tuple[Scalar, ...]:
        """Q as canonical polynomials: generalized forces of the applied forces, couples and motors."""
        if len(self._left_loads) == len(self.model.loads):
            return (0,) * self.model.n_u
        with_all_loads = inverse_dynamics(self.model, self.state, self.udot)
        return tuple(left - total for left, total in zip(self.canonical_left, with_all_loads, strict=True))

    @cached_property
    @named("the equations of motion")
    def balances(self) -> tuple[tuple[Scalar, Scalar], ...]:
        """(M u' + h, Q + Gᵀ λ) of every degree of freedom, canonical."""
        right = list(self.canonical_applied)
        for row, multiplier in zip(self.conditions.acting, self.canonical_multipliers, strict=True):
            right = [Q + entry * multiplier for Q, entry in zip(right, row, strict=True)]
        return tuple(zip(self.canonical_left, right, strict=True))

    # -- constraints ------------------------------------------------------------------------------

    @cached_property
    def conditions(self) -> Linearized:
        """The constraints, canonical: residuals, rates, the matrix G of the speeds, and γ; a row each."""
        return linearized(self.model, self.state)

    @property
    def _residuals(self) -> list[Scalar]:
        """Residuals of the constraints that do not hold identically, and the equations of roots that have symbols."""
        residuals = self.conditions.residual  # first: it makes the roots
        roots = [g.root.residual for g in self.ring.generators if g.root is not None]
        return [x for x in [*residuals, *roots] if x != 0]

    @cached_property
    def constraint_wrenches(self) -> list[Any]:
        """(point, force, moment) on bodies per unit multiplier, canonical, for each scalar condition."""
        return wrenches(self.model, self.state)

    @cached_property
    def condition_names(self) -> tuple[str, ...]:
        """Names of the scalar conditions; their multipliers have the same names."""
        return tuple(row.name for row in rows(self.model))

    @cached_property
    def multipliers(self) -> tuple[Any, ...]:
        """Symbols of the constraint forces: ``C_x`` of a joint C that closes a loop, else the constraint's name."""
        return tuple(sympy.Symbol(name, real=True) for name in self.condition_names)

    @cached_property
    def canonical_multipliers(self) -> tuple[Scalar, ...]:
        """Multipliers λ as elements of the ring: force and moment components of the joints that close loops."""
        return tuple(self.ring.generator(symbol, "reaction") for symbol in self.multipliers)

    # -- kinematics -------------------------------------------------------------------------------

    @cached_property
    @named("the positions")
    def postures(self) -> dict[str, Posture]:
        """Pose of every body, canonical."""
        return poses(self.model, self.state)

    @cached_property
    def joint_points(self) -> dict[str, Vector]:
        """Position in the ground of every joint's point, about which its reaction is given, canonical."""
        links = link_postures(self.model, self.state)
        return {name: links[joint.links[-1]].position for name, joint in self.model.joints.items()}

    def center_acceleration(self, body: str) -> Vector:
        """Acceleration of a body's mass centre, in ground axes, canonical [m/s²]."""
        place = self.model.bodies[body]
        w, _ = velocities(self.model, self.state)[place.link]
        alpha, a = self.accelerations[place.link]
        p = self.state.vector(tuple(x + y for x, y in zip(place.origin, place.center, strict=True)))
        a_C = add(a, apply(turning(w, alpha), p))
        return apply(link_postures(self.model, self.state)[place.link].rotation, a_C)

    @cached_property
    @named("the accelerations")
    def accelerations(self) -> list[Any]:
        """(angular acceleration, acceleration of the origin) of every link in its own axes, canonical."""
        return accelerations(self.model, self.state, self.udot)

    # -- energy and momentum ----------------------------------------------------------------------

    @cached_property
    def energy(self) -> Energy:
        """``.kinetic`` and ``.potential`` energy."""
        return Energy(self)

    @cached_property
    def momentum(self) -> MomentumOf:
        """``.linear`` momentum and ``.angular(about)`` momentum of all bodies, in ground axes."""
        return MomentumOf(self)
