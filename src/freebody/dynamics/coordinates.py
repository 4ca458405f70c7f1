"""Relation between the displacements of the joints and the coordinates.

Displacements are expressions of coordinates and time, so that with J = ∂y/∂q

    y'' = J u' + γ,        Q = Jᵀ τ.

If each displacement determines one more coordinate (absolute angles of a chain, for instance), both are
solved by substitution along ``model.order``; J is never inverted.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ..model.model import Model
from ..scalar.algebra import Scalar, divide
from ..space.spatial import Spatial
from .joints.freedom import free_displacements
from .state import State


def accelerations_of_coordinates(
    model: Model, state: State, second_rates: Mapping[int, Scalar], joint_rates: Mapping[int, Scalar]
) -> tuple[Scalar, ...]:
    """Return u' from y'' of the 1-dof links and, by speed, from u' of ball and free joints (``joint_rates``)."""
    assert model.order is not None
    udot: list[Scalar] = [0] * model.n_u
    for j, value in joint_rates.items():
        udot[j] = value
    for i, j in model.order:
        link = model.links[i]
        rest = second_rates[i] - state(link.bias)
        pivot: Scalar = 1
        for k, partial in link.partials:
            if k == j:
                pivot = partial
            else:
                rest = rest - state(partial) * udot[k]
        udot[j] = rest if pivot == 1 else divide(rest, pivot)
    return tuple(udot)


def forces_on_displacements(model: Model, state: State, forces: Mapping[int, Scalar]) -> dict[int, Scalar]:
    """Return τ with Jᵀ τ = Q: forces conjugate to the displacements from forces conjugate to the speeds."""
    assert model.order is not None
    links_with = _links_with(model)
    tau: dict[int, Scalar] = {}
    for i, j in reversed(model.order):
        rest = forces.get(j, 0)
        pivot: Scalar = 1
        for k, partial in links_with[j]:
            if k == i:
                pivot = partial
            else:
                rest = rest - state(partial) * tau[k]
        tau[i] = rest if pivot == 1 else divide(rest, pivot)
    return tau


def _links_with(model: Model) -> dict[int, list[tuple[int, Any]]]:
    """Return, for each coordinate, the links whose displacements depend on it, with ∂y/∂q."""
    result: dict[int, list[tuple[int, Any]]] = {}
    for i, link in enumerate(model.links):
        for j, partial in link.partials:
            result.setdefault(j, []).append((i, partial))
    return result


def forces_on_free_displacements(model: Model, state: State, speed: int, force: Scalar) -> dict[int, Scalar]:
    """Return τ along the displacements that can change alone, equivalent to a ``force`` conjugate to one speed.

    Forces on displacements that share coordinates are not included: they are part of their joints' reactions.
    """
    links_with = _links_with(model)
    tau: dict[int, Scalar] = {}
    for i, j in free_displacements(model):
        rest = force if j == speed else 0
        for k, partial in links_with[j]:
            if k != i:
                rest = rest - state(partial) * tau.get(k, 0)
        pivot = dict(links_with[j])[i]
        tau[i] = rest if pivot == 1 else divide(rest, state(pivot))
    return tau


def forces_on_coordinates(model: Model, state: State, tau: Sequence[Scalar]) -> list[Scalar]:
    """Return Jᵀ τ: forces conjugate to the speeds from forces along the displacements (one entry per link)."""
    total: list[Scalar] = [0] * model.n_u
    for i, link in enumerate(model.links):
        for j, partial in link.partials:
            total[j] = total[j] + state(partial) * tau[i]
    return total


def forces_on_speeds(
    model: Model, state: State, tau: Sequence[Scalar], wrenches: Sequence[Spatial]
) -> list[Scalar]:
    """Return the forces conjugate to all speeds: Jᵀ τ, and the wrenches on the links of ball and free joints."""
    total = forces_on_coordinates(model, state, tau)
    for i, link in enumerate(model.links):
        if link.u >= 0:
            n, f = wrenches[i]
            for k in range(3):
                total[link.u + k] = n[k]
                if link.flies:
                    total[link.u + 3 + k] = f[k]
    return total
