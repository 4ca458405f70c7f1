"""Time derivatives of contact forces and accelerations along the motion with one set of modes.

    λ = B x,   S x = -c_rows,   S = A_rows B     (rows: vanishing accelerations; B contains the slip directions)
    S x' = -(A' λ + A B' x + c')_rows,   λ' = B x' + B' x,   r' = A λ' + A' λ + c'

A' λ + c' for constant λ comes from the trace and is exact. If the motion leaves forces indeterminate, then x = A_rows ν
with S A_rows ν = g. Where it does not depend on them, x = W z, z = (S W)⁺ g, as
:func:`freebody.motion.contact.complementarity.balanced` chooses them. With T = S W of constant rank,

    z' = T⁺ (g' - T' z) + (1 - T⁺ T) T'ᵀ T⁺ᵀ z

Source: G. H. Golub, V. Pereyra, The differentiation of pseudo-inverses and nonlinear least squares problems whose
variables separate (1973).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..phase.scene import Snapshot
from .complementarity import SLIP, SMALL, Array, Solution, Touching, unknowns
from .state import ContactRun


def slopes(
    work: ContactRun,
    t: float,
    y: Array,
    seen: Snapshot,
    chosen: Sequence[int],
    contacts: Sequence[Touching],
    one: Solution,
) -> tuple[Array, Array]:
    """Return r' and λ' of the chosen contacts, in the rows of their contact problem."""
    A, rows, responses, _ = work.part(seen, chosen, y)
    udot = seen.free + one.forces @ responses

    def along(forces: Array) -> Array:
        whole = np.zeros(work.scene.rows)
        whole[rows] = forces
        return work.scene.slopes(t, y, work.parameters, udot, whole)[rows]

    changed = along(one.forces)
    columns, held = unknowns(len(A), contacts, one.modes)
    if not held:
        return changed, np.zeros(len(A))
    B, turned = np.array(columns).T, np.zeros((len(columns), len(A)))  # B and B'ᵀ
    for k, contact, (mode, d) in zip(chosen, contacts, one.modes, strict=True):
        at = contact.row
        if mode == SLIP and contact.tangents == 2 and contact.sliding is not None:
            (j,) = (j for j, column in enumerate(columns) if column[at])
            a = one.rates[at + 1 : at + 3]
            turned[j, at + 1 : at + 3] = (
                -contact.friction * (a - d * (d @ a)) / np.linalg.norm(work.slip(seen, k))
            )
    x = np.linalg.lstsq(B, one.forces, rcond=None)[0]
    S = A[held] @ B
    if one.rank_lack and not np.array_equal(
        S, A[np.ix_(held, held)]
    ):  # x = A_rows ν: x' = A_rows' ν + A_rows ν'
        Q, nu = A[np.ix_(held, held)], np.zeros(len(A))
        inverse = np.linalg.pinv(S @ Q, rcond=SMALL)
        nu[held] = inverse @ (S @ x)
        first = (along(nu) - along(np.zeros(len(A))))[held]
        change = first + Q @ (inverse @ (-(changed + A @ (x @ turned))[held] - S @ first))
    elif not one.rank_lack:
        change = np.linalg.solve(S, -(changed + A @ (x @ turned))[held])
    else:
        still = along(np.zeros(len(A)))

        def shared(root: Array, growth: Array) -> tuple[Array, Array]:
            """Return x and x' for x = W z, where W is ``root`` and W' is ``growth``."""
            inverse = np.linalg.pinv(S * root, rcond=SMALL)
            z = inverse @ (S @ x)
            zeta = np.zeros(len(A))
            zeta[held] = inverse.T @ z
            goal = -(along(B @ (root * z)) + A @ ((root * z) @ turned))[held]
            back = root * (B.T @ (along(zeta) - still) + turned @ (A @ zeta)) + growth * (B.T @ (A @ zeta))
            slope = inverse @ (goal - S @ (growth * z)) + back - inverse @ (S @ (root * back))
            return root * z, growth * z + root * slope

        ones = np.ones(len(x))
        first, change = shared(ones, 0 * ones)
        weights, growth = ones.copy(), 0 * ones
        for contact in contacts:
            tangent = [j for j, row in enumerate(held) if contact.row < row <= contact.row + contact.tangents]
            if tangent:
                weights[tangent] = (B @ first)[contact.row]
                growth[tangent] = (B @ change)[contact.row]
        if (weights > 0).all():
            root = np.sqrt(weights)
            _, change = shared(root, growth / (2 * root))
    force = B @ change + x @ turned
    return changed + A @ force, force
