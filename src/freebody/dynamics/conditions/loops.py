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
from dataclasses import dataclass

from ...model.model import GROUND, Model
from ...scalar.algebra import ZERO, Scalar, Vector, divide
from ...space.spatial import (
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
from ..articulated import free_motions
from ..linear import Selection, entries
from ..state import State
from .dependence import path_between


def own_speeds(model: Model) -> list[list[int]] | None:
    """Return the speeds of each link's own motions if each is the rate of one motion; None for other models."""
    result: list[list[int]] = []
    for link in model.links:
        if not link.one_dof:
            count = 0 if link.u < 0 else link.n_speeds
            result.append([link.u + k for k in range(count)])
        elif link.driven:
            result.append([])
        elif len(link.partials) == 1 and link.partials[0][1] == 1:
            result.append([link.partials[0][0]])
        else:
            return None
    speeds = [j for link_speeds in result for j in link_speeds]
    return result if len(speeds) == len(set(speeds)) else None


def carriers(model: Model, speeds: Sequence[Sequence[int]], G: Sequence[Sequence[Scalar]]) -> list[int]:
    """Return, for each row of G, the outermost link that carries all its motions."""
    moved = {j: i for i, link_speeds in enumerate(speeds) for j in link_speeds}
    result = []
    for row in G:
        meet: int | None = None
        for j, _ in entries(row):
            i = model.links[moved[j]].parent
            meet = i if meet is None else path_between(model, meet, i)[1]
        result.append(GROUND if meet is None else meet)
    return result


def loop_motion(
    model: Model, state: State, speeds: Sequence[Sequence[int]], f: Sequence[Scalar],
    G: Sequence[Sequence[Scalar]], g: Sequence[Scalar], selection: Selection | None = None,
) -> tuple[list[Scalar], list[Scalar]]:  # fmt: skip
    """Return u and λ; the rows of G must be independent. With a selection, f, G and g are 0 where it is."""
    return _Recursion(model, state, speeds, f, G, g, selection).solved()


def articulated_masses(model: Model, state: State, speeds: Sequence[Sequence[int]]) -> list[Scalar]:
    """Return, for each speed, the inertia Sᵀ I S of its motion if all motions outward of it follow freely."""
    zeros = [0] * model.n_u
    recursion = _Recursion(model, state, speeds, zeros, [], [])
    recursion.solved()
    result: list[Scalar] = [0] * model.n_u
    for terms in (terms for joint in recursion.joint_terms for terms in joint):
        result[terms.speed] = terms.D
    return result


@dataclass(frozen=True)
class _JointTerms:
    """Terms of an eliminated motion S: y'' = (m + Σ μ_c λ_c - Uᵀ a) / D."""

    S: Spatial
    speed: int
    U: Spatial
    D: Scalar
    inverse: Scalar  # 1/D
    m: Scalar
    mu: dict[int, Scalar]


@dataclass(frozen=True)
class _LoopTerms:
    """Terms of an eliminated multiplier: λ_c = (P_cᵀ a - Σ Λ_ck λ_k - r_c) / Λ_cc."""

    row: int
    inverse: Scalar  # 1/Λ_cc
    coupled: dict[int, Scalar]  # Λ_ck
    r: Scalar


def _inverse(x: Scalar, taking_part: Scalar | None) -> Scalar:
    """Return 1/x, or 0 for what takes no part in a selection, where x may be 0."""
    return divide(1, x) if taking_part is None else divide(taking_part, x + (1 - taking_part))


class _Recursion:
    """The recursion over the links: eliminate motions and multipliers inward, then solve for them outward."""

    def __init__(
        self, model: Model, state: State, speeds: Sequence[Sequence[int]], f: Sequence[Scalar],
        G: Sequence[Sequence[Scalar]], g: Sequence[Scalar], selection: Selection | None = None,
    ) -> None:  # fmt: skip
        count = len(model.links)
        self.model, self.state, self.speeds, self.f, self.selection = model, state, speeds, f, selection
        self.loops_of: dict[int, list[int]] = {}
        for c, i in enumerate(carriers(model, speeds, G)):
            self.loops_of.setdefault(i, []).append(c)
        self.I = [blocks(state.inertia(i)) for i in range(count)]
        self.p: list[Spatial] = [ZERO6] * count
        self.P: list[dict[int, Spatial]] = [{} for _ in range(count)]
        self.L: list[dict[int, Scalar]] = [{} for _ in G]  # Λ, both triangles
        self.r: list[Scalar] = [-x for x in g]
        self.columns: dict[int, dict[int, Scalar]] = {}
        for c, row in enumerate(G):
            for j, x in entries(row):
                self.columns.setdefault(j, {})[c] = x
        self.joint_terms: list[list[_JointTerms]] = [[] for _ in range(count)]
        self.loop_terms: list[list[tuple[_LoopTerms, Spatial]]] = [[] for _ in range(count)]
        self.u: list[Scalar] = [0] * model.n_u
        self.lam: list[Scalar] = [0] * len(G)

    def solved(self) -> tuple[list[Scalar], list[Scalar]]:
        """Return u and λ."""
        for i in range(len(self.model.links) - 1, -1, -1):
            for c in self.loops_of.get(i, ()):
                self.eliminate_loop(i, c)
            link = self.model.links[i]
            subspace = self.state.subspace(i) if link.one_dof and not link.driven else None
            armature = self.state.armature(i) or (0,) * len(self.speeds[i])
            spin = self.state.spin(i) if link.one_dof and link.parent != GROUND else None
            for S, j, x in zip(free_motions(link, subspace), self.speeds[i], armature, strict=True):
                self.eliminate_motion(i, S, j, x, ZERO if spin is None else spin[1])
            if link.parent != GROUND:
                self.add_to_parent(i, link.parent)
        for terms in reversed([self.eliminate(c) for c in self.loops_of.get(GROUND, ())]):
            self.substitute(terms, 0)
        self.outward()
        return self.u, self.lam

    def eliminate(self, c: int) -> _LoopTerms:
        """Eliminate λ_c from Λ and r."""
        L, r = self.L, self.r
        w = _inverse(L[c].pop(c, 0), None if self.selection is None else self.selection.active[c])
        coupled = L[c]
        for k, x in coupled.items():
            del L[k][c]
            r[k] = r[k] - x * (r[c] * w)
            for m, y in coupled.items():
                if m <= k:
                    L[k][m] = L[m][k] = L[k].get(m, 0) - x * y * w
        return _LoopTerms(c, w, coupled, r[c])

    def eliminate_loop(self, i: int, c: int) -> None:
        """Eliminate λ_c at the link that carries its loop."""
        terms = self.eliminate(c)
        force = self.P[i].pop(c, ZERO6)
        weighed = times(terms.inverse, force)
        self.I[i] = blocks_less_outer(self.I[i], force, times(-1, weighed))
        self.p[i] = plus(self.p[i], times(-terms.r, weighed))
        for k, x in terms.coupled.items():
            self.P[i][k] = plus(self.P[i].get(k, ZERO6), times(-x, weighed))
        self.loop_terms[i].append((terms, force))

    def eliminate_motion(self, i: int, S: Spatial, j: int, armature: Scalar, spin: Vector) -> None:
        """Eliminate the motion S of link i, whose speed is j; ``spin`` is that of rotors in the parent."""
        P, L = self.P[i], self.L
        U = blocks_times(self.I[i], S)
        D = power(S, U) + armature
        U = plus(U, (spin, ZERO))
        w = _inverse(D, None if self.selection is None else self.selection.free[j])
        m = self.f[j] - power(S, self.p[i])
        column = self.columns.get(j, {})
        mu = {c: column.get(c, 0) - power(S, P.get(c, ZERO6)) for c in {**P, **column}}
        self.joint_terms[i].append(_JointTerms(S, j, U, D, w, m, mu))
        self.I[i] = blocks_less_outer(self.I[i], U, times(w, U))
        self.p[i] = plus(self.p[i], times(m * w, U))
        for c, x in mu.items():
            P[c] = plus(P.get(c, ZERO6), times(x * w, U))
            self.r[c] = self.r[c] + x * w * m
            for k, y in mu.items():
                if k <= c:
                    L[c][k] = L[k][c] = L[c].get(k, 0) + x * y * w

    def add_to_parent(self, i: int, parent: int) -> None:
        """Add the contribution of link i to that of its parent."""
        R, d, _ = self.state.joint(i)
        self.I[parent] = blocks_sum(self.I[parent], blocks_to_parent(R, d, self.I[i]))
        self.p[parent] = plus(self.p[parent], force_to_parent(R, d, self.p[i]))
        for c, x in self.P[i].items():
            self.P[parent][c] = plus(self.P[parent].get(c, ZERO6), force_to_parent(R, d, x))

    def substitute(self, terms: _LoopTerms, along: Scalar) -> None:
        """Solve for one multiplier; ``along`` is P_cᵀ a."""
        for k, x in terms.coupled.items():
            along = along - x * self.lam[k]
        self.lam[terms.row] = (along - terms.r) * terms.inverse

    def outward(self) -> None:
        """Solve for the speeds and the multipliers of the loops, from the ground to the tips."""
        A: list[Spatial] = []
        for i, link in enumerate(self.model.links):
            R, d, _ = self.state.joint(i)
            a = ZERO6 if link.parent == GROUND else motion_to_child(R, d, A[link.parent])
            for joint in reversed(self.joint_terms[i]):
                m = joint.m
                for c, x in joint.mu.items():
                    m = m + x * self.lam[c]
                rate = self.u[joint.speed] = (m - power(a, joint.U)) * joint.inverse
                a = plus(a, times(rate, joint.S))
            for loop, force in reversed(self.loop_terms[i]):
                self.substitute(loop, power(a, force))
            A.append(a)
