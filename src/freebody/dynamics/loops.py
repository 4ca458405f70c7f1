"""Deep trees with loops: M u - Gᵀ λ = f and G u = g by one recursion over the links, at a cost linear in their number.

By Gauss's principle u makes ½ uᵀ M u - fᵀ u - λᵀ (G u - g) stationary. The contribution of the links beyond a joint is
a function of the acceleration a of the link that carries them and of the multipliers of the loops still open there,

    ½ aᵀ I a + aᵀ (p + P λ) - ½ λᵀ Λ λ - λᵀ r.

From the tips inward each joint is eliminated as in the articulated-body algorithm, and each λ at the link that carries
its loop, after all joints of the loop. The divisor is then G M⁻¹ Gᵀ of the joints beyond that link, which is positive
if the conditions are independent.

Source: Featherstone, Rigid Body Dynamics Algorithms (2008), §7.2 for the joints.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..model.model import GROUND, Model
from ..scalar.algebra import Scalar, divide
from ..space.spatial import (
    ZERO6,
    Spatial,
    blocks,
    blocks_less_outer,
    blocks_sum,
    blocks_times,
    blocks_to_parent,
    force_to_parent,
    motion_to_child,
    plus,
    power,
    times,
)
from .articulated import free_motions
from .linear import entries
from .state import State


def own_speeds(model: Model) -> list[list[int]] | None:
    """Return the speeds of each link's own motions if each is the rate of one motion; None for other models."""
    result: list[list[int]] = []
    for link in model.links:
        if not link.one_dof:
            count = 0 if link.u < 0 else {"ball": 3, "free": 6}[link.kind]
            result.append([link.u + k for k in range(count)])
        elif link.driven:
            result.append([])
        elif len(link.partials) == 1 and link.partials[0][1] == 1:
            result.append([link.partials[0][0]])
        else:
            return None
    speeds = [j for link_speeds in result for j in link_speeds]
    return result if len(speeds) == len(set(speeds)) else None


def carriers(model: Model, speeds: Sequence[Sequence[int]], G: Sequence[Sequence[Any]]) -> list[int]:
    """Return, for each row of G, the outermost link that carries all its motions."""
    moved = {j: i for i, link_speeds in enumerate(speeds) for j in link_speeds}
    result = []
    for row in G:
        meet: int | None = None
        for j, _ in entries(row):
            i = model.links[moved[j]].parent
            if meet is None:
                meet = i
            while meet != i:  # parents come before their children
                meet, i = min(meet, i), max(meet, i)
                i = model.links[i].parent
        result.append(GROUND if meet is None else meet)
    return result


def loop_motion(
    model: Model, state: State, speeds: Sequence[Sequence[int]], f: Sequence[Scalar],
    G: Sequence[Sequence[Scalar]], g: Sequence[Scalar],
) -> tuple[list[Scalar], list[Scalar]]:  # fmt: skip
    """Return u and λ; the rows of G must be independent."""
    count = len(model.links)
    loops_of: dict[int, list[int]] = {}
    for c, i in enumerate(carriers(model, speeds, G)):
        loops_of.setdefault(i, []).append(c)
    I = [blocks(state.inertia(i)) for i in range(count)]  # noqa: E741 - inertia
    p: list[Spatial] = [ZERO6] * count
    P: list[dict[int, Spatial]] = [{} for _ in range(count)]
    L: list[dict[int, Any]] = [{} for _ in G]  # Λ, both triangles
    r: list[Any] = [-x for x in g]
    columns: dict[int, dict[int, Any]] = {}
    for c, row in enumerate(G):
        for j, x in entries(row):
            columns.setdefault(j, {})[c] = x

    def eliminate(c: int) -> tuple[int, Any, dict[int, Any], Any]:
        """Eliminate λ_c = (P_cᵀ a - Σ Λ_ck λ_k - r_c) / Λ_cc from Λ and r; return its terms."""
        w = divide(1, L[c].pop(c))
        coupled = L[c]
        for k, x in coupled.items():
            del L[k][c]
            r[k] = r[k] - x * (r[c] * w)
            for m, y in coupled.items():
                if m <= k:
                    L[k][m] = L[m][k] = L[k].get(m, 0) - x * y * w
        return c, w, coupled, r[c]

    joint_terms: list[list[Any]] = [[] for _ in range(count)]
    loop_terms: list[list[Any]] = [[] for _ in range(count)]
    for i in range(count - 1, -1, -1):
        link = model.links[i]
        for c in loops_of.get(i, ()):
            c, w, coupled, rest = eliminate(c)
            force = P[i].pop(c, ZERO6)
            weighed = times(w, force)
            I[i] = blocks_less_outer(I[i], force, times(-1, weighed))
            p[i] = plus(p[i], times(-rest, weighed))
            for k, x in coupled.items():
                P[i][k] = plus(P[i].get(k, ZERO6), times(-x, weighed))
            loop_terms[i].append((c, w, coupled, rest, force))
        motions = free_motions(link, state.subspace(i) if link.one_dof and not link.driven else None)
        for S, j in zip(motions, speeds[i], strict=True):
            U = blocks_times(I[i], S)
            w = divide(1, power(S, U))
            m = f[j] - power(S, p[i])
            column = columns.get(j, {})
            mu = {c: column.get(c, 0) - power(S, P[i].get(c, ZERO6)) for c in {**P[i], **column}}
            joint_terms[i].append((S, j, U, w, m, mu))
            I[i] = blocks_less_outer(I[i], U, times(w, U))
            p[i] = plus(p[i], times(m * w, U))
            for c, x in mu.items():
                P[i][c] = plus(P[i].get(c, ZERO6), times(x * w, U))
                r[c] = r[c] + x * w * m
                for k, y in mu.items():
                    if k <= c:
                        L[c][k] = L[k][c] = L[c].get(k, 0) + x * y * w
        if link.parent != GROUND:
            R, d, _ = state.joint(i)
            I[link.parent] = blocks_sum(I[link.parent], blocks_to_parent(R, d, I[i]))
            p[link.parent] = plus(p[link.parent], force_to_parent(R, d, p[i]))
            above = P[link.parent]
            for c, x in P[i].items():
                above[c] = plus(above.get(c, ZERO6), force_to_parent(R, d, x))

    u: list[Any] = [0] * model.n_u
    lam: list[Any] = [0] * len(G)

    def substitute(c: int, w: Any, coupled: dict[int, Any], rest: Any, along: Any) -> None:
        for k, x in coupled.items():
            along = along - x * lam[k]
        lam[c] = (along - rest) * w

    for c, w, coupled, rest in reversed([eliminate(c) for c in loops_of.get(GROUND, ())]):
        substitute(c, w, coupled, rest, 0)
    A: list[Spatial] = []
    for i, link in enumerate(model.links):
        R, d, _ = state.joint(i)
        a = ZERO6 if link.parent == GROUND else motion_to_child(R, d, A[link.parent])
        for S, j, U, w, m, mu in reversed(joint_terms[i]):
            for c, x in mu.items():
                m = m + x * lam[c]
            u[j] = (m - power(a, U)) * w
            a = plus(a, times(u[j], S))
        for c, w, coupled, rest, force in reversed(loop_terms[i]):
            substitute(c, w, coupled, rest, power(a, force))
        A.append(a)
    return u, lam
