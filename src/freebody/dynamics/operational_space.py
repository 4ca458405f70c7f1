"""Operational space: inertia and bias that a machine shows at a point of a body.

With the velocities x' = J u of the point (angular, linear, or some of these components), M u' + h = Jᵀ F and the
constraints G u' + γ = 0 give

    Λ x'' + μ = F,        Λ⁻¹ = J P Jᵀ,        P = M⁻¹ - M⁻¹ Gᵀ (G M⁻¹ Gᵀ)⁻¹ G M⁻¹,        μ = -Λ x''|_(F = 0)

Source: O. Khatib, A unified approach for motion and force control of robot manipulators (1987).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..errors import ModelError
from ..model.model import Model
from ..scalar.algebra import Scalar, apply
from .composite import mass_matrix
from .conditions.linearized import linearized
from .kinematics import accelerations, jacobian, place_of, point_acceleration, rotation
from .linear import Factorization, products
from .motion import motion
from .state import State

COMPONENTS = ("wx", "wy", "wz", "vx", "vy", "vz")
"""Components of the velocities: of the body's angular velocity and of the point's velocity, in ground axes."""


def operational_inertia(
    model: Model,
    state: State,
    point: Any,
    components: Sequence[int] = range(6),
    active: Sequence[int] | None = None,
) -> tuple[tuple[Scalar, ...], ...]:
    """Return Λ for some components at a point; ``active`` are the independent conditions of a constrained model."""
    J = jacobian(model, state, point)
    M = Factorization(mass_matrix(model, state))
    # J M⁻¹ Gᵀ = (L⁻¹ Jᵀ)ᵀ D⁻¹ (L⁻¹ Gᵀ)
    rows = [M.forward(J[k]) for k in components]
    mobility = products([M.divided(row) for row in rows], rows)
    if model.constraints:
        conditions = linearized(model, state)
        if not conditions.symmetric:
            raise ModelError(
                f"Expected contacts that do not slide with friction for the operational space of '{model.name}': their "
                "forces do not follow from a mass matrix. Ask in another mode of the contacts."
            )
        independent = range(len(conditions.bias)) if active is None else active
        G = [M.forward(conditions.matrix[i]) for i in independent]
        weighed = [M.divided(row) for row in G]
        S, across = Factorization(products(weighed, G)), products(rows, weighed)
        held = products(across, [S.solve(row) for row in across])
        mobility = [[a - b for a, b in zip(x, y, strict=True)] for x, y in zip(mobility, held, strict=True)]
    count = range(len(rows))
    solved = Factorization(mobility)
    columns = [solved.solve([int(i == k) for i in count]) for k in count]
    return tuple(tuple(columns[k][i] for k in count) for i in count)


def operational_bias(
    model: Model,
    state: State,
    point: Any,
    components: Sequence[int] = range(6),
    active: Sequence[int] | None = None,
) -> tuple[Scalar, ...]:
    """Return μ: minus the force Λ x'' of the motion without a force at the point."""
    udot = motion(model, state, active).udot
    link, _ = place_of(model, point.body)
    alpha = apply(rotation(model, state, link), accelerations(model, state, udot)[link][0])
    free = (*alpha, *point_acceleration(model, state, point, udot))
    inertia = operational_inertia(model, state, point, components, active)
    return tuple(-sum((a * free[k] for a, k in zip(row, components, strict=True)), 0) for row in inertia)
