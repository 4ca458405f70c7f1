"""Mass matrix by composite rigid bodies.

    I^c_i = I_i + Σ I^c_child,        M_jk = S_jᵀ X* (I^c_k S_k)   for k outward of j.

Source: Featherstone, Rigid Body Dynamics Algorithms (2008), §6.2.
"""

from __future__ import annotations

from ..model.model import GROUND, Model
from ..scalar.algebra import Scalar
from ..space.spatial import Inertia, force_to_parent, inertia_sum, inertia_to_parent, momentum_of, power
from .kinematics import motions
from .state import State


def mass_matrix(model: Model, state: State) -> tuple[tuple[Scalar, ...], ...]:
    """Return the symmetric matrix M of the kinetic energy ½ uᵀ M u (plus terms of driven joints). Shape (n_u, n_u)."""
    M: list[list[Scalar]] = [[0] * model.n_u for _ in range(model.n_u)]
    composite = _composite_inertias(model, state)
    moves = [motions(model, state, i) for i in range(len(model.links))]
    for i in range(len(model.links)):
        for place, (j, weight, S) in enumerate(moves[i]):
            F = momentum_of(composite[i], S)
            for earlier, (k, weight_k, S_k) in enumerate(moves[i][: place + 1]):
                _put(M, j, k, weight * weight_k * power(S_k, F), same=earlier == place)
            inner = i
            while model.links[inner].parent != GROUND:
                R, p, _ = state.joint(inner)
                F = force_to_parent(R, p, F)
                inner = model.links[inner].parent
                for k, weight_k, S_k in moves[inner]:
                    _put(M, j, k, weight * weight_k * power(S_k, F), same=False)
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
        for j, weight, S in link_moves:
            F = momentum_of(composite[i], S)
            same = [(weight_k, S_k) for k, weight_k, S_k in link_moves if k == j]
            diagonal[j] = diagonal[j] + sum((weight * b * power(S_k, F) for b, S_k in same), 0)
            inner = i
            while model.links[inner].parent >= first[j]:
                R, p, _ = state.joint(inner)
                F = force_to_parent(R, p, F)
                inner = model.links[inner].parent
                for k, weight_k, S_k in moves[inner]:
                    if k == j:
                        diagonal[j] = diagonal[j] + 2 * (weight * weight_k * power(S_k, F))
    return diagonal


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
