"""Forces of contacts of equal compliance, whose conditions depend on each other (`closed_contacts`), compiled."""

from __future__ import annotations

from ...native.functions import components
from ...native.instructions import Reals, compiled, greater, lesser
from .conditions import eliminated, force_row, joint
from .contact_outputs import force_of, inner, static_friction_of
from .phase_record import PhaseData

PULL = 1e-9
"""Part of the greatest normal force up to which one below zero is round-off."""


@compiled
def shared(phase: PhaseData) -> int:
    """Set λ of all conditions to forces of equal compliance with ``right``; return 0 if they do not exist, else 1."""
    S, Q = phase.S, phase.Q
    for j in range(phase.conditions):
        phase.weight[j], first = unit(phase, j), phase.active_at[phase.island[j]]
        for a in range(phase.active_at[phase.island[j] + 1] - first):
            i = phase.independent[first + a]
            Q[j, a] = joint(phase, i, j, phase.G[j])
            S[j, a] = Q[j, a]
            if phase.force_row[j] != j:
                S[j, a] = joint(phase, i, j, force_row(phase, j))
    if weighted(phase) == 0:
        return 0
    for s in range(phase.islands):
        shares = is_independent(phase, s) == 0 and phase.slips_in[s] == 0 and pulls(phase, s) == 0
        phase.weighed[s] = 1 if shares else 0
        if phase.weighed[s] != 0:
            weigh(phase, s)
            weighted_in(phase, s)  # contacts without load have no friction to share: the first shares remain
    return 1


@compiled
def unit(phase: PhaseData, j: int) -> float:
    """Return W of a condition per force: 1, and δ² of a moment M that resists rolling or spinning, as the force M/δ."""
    k = phase.source[j]
    if k < 0 or phase.presser[k] < 0:
        return 1.0
    return static_friction_of(phase, k) ** 2


@compiled
def weigh(phase: PhaseData, island: int) -> None:
    """Set W of an island to the first shares of its normal forces."""
    mean = mean_normal(phase, island, phase.lam, 1.0)
    for m in range(phase.member_at[island], phase.member_at[island + 1]):
        j = phase.members[m]
        k = phase.source[j]
        if phase.normal_of[j] >= 0:
            phase.weight[j] = unit(phase, j) * phase.lam[phase.normal_of[j]]
        elif k >= 0 and phase.held[k] != 0:
            phase.weight[j] = unit(phase, j) * force_of(phase, k)[0]
        else:
            phase.weight[j] = mean


@compiled
def pulls(phase: PhaseData, island: int) -> int:
    """Return 1 if the normal force of a contact of an island pulls, so that it is no weight, else 0."""
    least, most = 0.0, 0.0
    for m in range(phase.member_at[island], phase.member_at[island + 1]):
        i = phase.members[m]
        if phase.source[i] >= 0 and phase.row_of[i] == 0:
            least, most = lesser(least, phase.lam[i]), greater(most, abs(phase.lam[i]))
    return 1 if least < -PULL * most else 0


@compiled
def mean_normal(phase: PhaseData, island: int, forces: Reals, none: float) -> float:
    """Return the mean of the ``forces`` on normals of contacts of an island, or ``none`` if there are none."""
    total, count = 0.0, 0
    for m in range(phase.member_at[island], phase.member_at[island + 1]):
        i = phase.members[m]
        if phase.source[i] >= 0 and phase.row_of[i] == 0:
            total += forces[i]
            count += 1
    return total / count if count > 0 else none


@compiled
def weighted(phase: PhaseData) -> int:
    """Set λ to W Qᵀ ν with S W Qᵀ ν = r and W = ``weight``, island by island.

    Return 0 if S W Qᵀ of one is singular, whose λ stay, else 1.
    """
    good = 1
    for s in range(phase.islands):
        if weighted_in(phase, s) == 0:
            good = 0
    return good


@compiled
def weighted_in(phase: PhaseData, island: int) -> int:
    """Set λ of an island as `weighted` does."""
    if is_independent(phase, island) != 0:
        return unshared(phase, island)
    square, given, nu, lam, weight, S, Q = (
        phase.square, phase.given_square, phase.nu, phase.lam, phase.weight, phase.S, phase.Q,
    )  # fmt: skip
    first, begin, end = phase.active_at[island], phase.member_at[island], phase.member_at[island + 1]
    active = phase.active_at[island + 1] - first
    for a in range(active):
        row = given[a]
        for b in components(active):
            row[b] = 0.0
    for m in range(begin, end):
        j = phase.members[m]
        of_j = Q[j]
        for a in range(active):
            x, row = S[j, a] * weight[j], given[a]
            for b in components(active):
                row[b] += x * of_j[b]
    # S W Qᵀ has the condition of S squared: what is left of r is solved for once more
    for refined in range(2):
        for a in range(active):
            left, row, copy = phase.right[phase.independent[first + a]], given[a], square[a]
            if refined != 0:
                for m in range(begin, end):
                    left -= S[phase.members[m], a] * lam[phase.members[m]]
            for b in components(active):
                copy[b] = row[b]
            copy[active] = left
        if eliminated(phase, active) == 0:
            return 0
        for m in range(begin, end):
            j = phase.members[m]
            before = lam[j] if refined != 0 else 0.0
            lam[j] = before + weight[j] * inner(nu, Q[j], active)
    return 1


@compiled
def is_independent(phase: PhaseData, island: int) -> int:
    """Return 1 if the conditions of an island are independent, so that none of its forces is shared, else 0."""
    count = phase.member_at[island + 1] - phase.member_at[island]
    return 1 if count == phase.active_at[island + 1] - phase.active_at[island] else 0


@compiled
def unshared(phase: PhaseData, island: int) -> int:
    """Set λ of an island of independent conditions to the solution of S λ = r; return 0 if S is singular, else 1.

    S W Qᵀ has the condition of S squared: beside a dead centre its forces are noise long before those of S are.
    """
    first, begin, S, square = phase.active_at[island], phase.member_at[island], phase.S, phase.square
    active = phase.active_at[island + 1] - first
    for a in range(active):
        for b in range(active):
            square[a, b] = S[phase.members[begin + b], a]
        square[a, active] = phase.right[phase.independent[first + a]]
    if eliminated(phase, active) == 0:
        return 0
    for b in range(active):
        phase.lam[phase.members[begin + b]] = phase.nu[b]
    return 1


@compiled
def product_of_shares(phase: PhaseData, a: int, forces: Reals) -> float:
    """Return S of an independent condition times forces of all conditions."""
    s, total = phase.island[phase.independent[a]], 0.0
    for m in range(phase.member_at[s], phase.member_at[s + 1]):
        i = phase.members[m]
        total += phase.S[i, a - phase.active_at[s]] * forces[i]
    return total


@compiled
def first_shares(phase: PhaseData, forces: Reals, weights: Reals, firsts: Reals) -> int:
    """Set ``firsts`` to the forces that W = `unit` shares, of the λ ``forces`` of a phase, and ``weights`` to its W.

    Leave W = `unit`. Return 0 if a contact without load has none, else 1.
    """
    good = 1
    for i in range(phase.conditions):
        weights[i] = phase.weight[i]
        if not phase.weight[i] > 0.0:
            good = 0
        phase.weight[i] = unit(phase, i)
    for a in range(phase.active):
        phase.right[phase.independent[a]] = product_of_shares(phase, a, forces)
    weighted(phase)
    for i in range(phase.conditions):
        firsts[i] = phase.lam[i]
    return good


@compiled
def set_weights(phase: PhaseData, weights: Reals) -> None:
    """Set W."""
    for i in range(phase.conditions):
        phase.weight[i] = weights[i]
