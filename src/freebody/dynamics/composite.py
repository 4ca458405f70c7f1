"""Mass matrix by composite rigid bodies.

    I^c_i = I_i + Σ I^c_child,        M_jk = S_jᵀ X* (I^c_k S_k)   for k outward of j.

Armature adds to M_jj, and the spin of rotors in the parent of link k to I^c_k S_k at the parent. What loads set in
motion adds to all of M (:mod:`freebody.dynamics.loads.added_mass`).

Source: Featherstone, Rigid Body Dynamics Algorithms (2008), §6.2.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..model.model import GROUND, Model
from ..scalar.algebra import Scalar, add
from ..space.spatial import (
    Inertia,
    Spatial,
    force_to_parent,
    inertia_sum,
    inertia_to_parent,
    momentum_of,
    power,
)
from .kinematics import motions
from .loads.added_mass import added_mass
from .state import State


def mass_matrix(model: Model, state: State) -> tuple[tuple[Scalar, ...], ...]:
    """Return the symmetric matrix M of the kinetic energy ½ uᵀ M u (plus terms of driven joints). Shape (n_u, n_u)."""
    M: list[list[Scalar]] = [[0] * model.n_u for _ in range(model.n_u)]
    composite = _composite_inertias(model, state)
    moves = [motions(model, state, i) for i in range(len(model.links))]
    for i in range(len(model.links)):
        for place, (j, weight, S) in enumerate(moves[i]):
            F = momentum_of(composite[i], S)
            own = _own_inertias(model, state, i, moves[i])
            for earlier, (k, weight_k, S_k) in enumerate(moves[i][: place + 1]):
                inertia = power(S_k, F) + own.get((earlier, place), 0)
                _put(M, j, k, weight * weight_k * inertia, same=earlier == place)
            inner = i
            while model.links[inner].parent != GROUND:
                F = _inward(state, inner, F, with_spin=inner == i)
                inner = model.links[inner].parent
                for k, weight_k, S_k in moves[inner]:
                    _put(M, j, k, weight * weight_k * power(S_k, F), same=False)
    if (added := added_mass(model, state)) is not None:
        M = [[a + b for a, b in zip(row, more, strict=True)] for row, more in zip(M, added, strict=True)]
    return tuple(map(tuple, M))


def mass_diagonal(model: Model, state: State) -> list[Scalar]:
    """Return the diagonal of M: twice the kinetic energy of each speed alone at unit value. Shape (n_u,).

    Inward of the first link that a speed moves, no term of it is left, so that the work is linear in the links.
    """
    diagonal: list[Scalar] = [0] * model.n_u
    composite = _composite_inertias(model, state)
    moves = [motions(model, state, i) for i in range(len(model.links))]
    first: dict[int, int] = {}  # innermost link that a speed moves; parents come before their children
    for i, link_moves in enumerate(moves):
        for j, _, _ in link_moves:
            first.setdefault(j, i)
    for i, link_moves in enumerate(moves):
        for place, (j, weight, S) in enumerate(link_moves):
            F = momentum_of(composite[i], S)
            own = _own_inertias(model, state, i, link_moves)
            for other, (k, weight_k, S_k) in enumerate(link_moves):
                if k == j:
                    inertia = power(S_k, F) + own.get((other, place), 0)
                    diagonal[j] = diagonal[j] + weight * weight_k * inertia
            inner = i
            while model.links[inner].parent >= first[j]:
                F = _inward(state, inner, F, with_spin=inner == i)
                inner = model.links[inner].parent
                for k, weight_k, S_k in moves[inner]:
                    if k == j:
                        diagonal[j] = diagonal[j] + 2 * (weight * weight_k * power(S_k, F))
    if (added := added_mass(model, state)) is not None:
        diagonal = [a + row[j] for j, (a, row) in enumerate(zip(diagonal, added, strict=True))]
    return diagonal


def _own_inertias(model: Model, state: State, i: int, moves: Sequence[Any]) -> dict[tuple[int, int], Scalar]:
    """Return the armature that two motions of a link, by their places, move together."""
    armature = state.armature(i)
    if not armature:
        return {}
    if model.links[i].one_dof:  # all its motions are along one displacement
        return {(j, k): armature[0] for j in range(len(moves)) for k in range(len(moves))}
    return {(k, k): x for k, x in enumerate(armature)}


def _inward(state: State, i: int, F: Spatial, *, with_spin: bool) -> Spatial:
    """Return the momentum of link ``i`` at its parent, with that of the parent's rotors that the link turns."""
    R, p, _ = state.joint(i)
    F = force_to_parent(R, p, F)
    spin = state.spin(i) if with_spin else None
    return F if spin is None else (add(F[0], spin[0]), F[1])


def _composite_inertias(model: Model, state: State) -> list[Inertia]:
    """Return the inertia of each link with all links outward of it, in the axes of the link."""
    composite = [state.inertia(i) for i in range(len(model.links))]
    for i in range(len(model.links) - 1, -1, -1):
        parent = model.links[i].parent
        if parent != GROUND:
            R, p, _ = state.joint(i)
            composite[parent] = inertia_sum(composite[parent], inertia_to_parent(R, p, composite[i]))
    return composite


def _put(M: list[list[Scalar]], j: int, k: int, entry: Scalar, same: bool) -> None:
    """Add an entry and its mirror image; the entry of a motion with itself has none."""
    M[j][k] = M[j][k] + entry
    if not same:
        M[k][j] = M[k][j] + entry
