"""The motion of a machine whose contacts are in given modes, in compiled code: modes are data.

Closed contacts are conditions beside those of the machine itself, all with rows G, and forces λ along rows K:

    M u' = f + Kᵀ λ,   G u' = -γ      =>      (G M⁻¹ Kᵀ) λ = -γ - G M⁻¹ f

    stick     rows of N, T             K = G
    slip      row of N                 K = W_N - μ d W_T,   d the direction of slip;  μ = 0: K = G
    rolls     row of N, those of T     K = W_N - δ d W_M    of the normal, beside its friction

Only independent conditions (active ones) are imposed. The forces of the others are those of contacts of equal
compliance, in the range of the rows. With S = G M⁻¹ Kᵀ and Q = G M⁻¹ Gᵀ over active and all conditions,

    slip      λ = Qᵀ ν,   S Qᵀ ν = r           no slip    λ = W Qᵀ ν,   Q W Qᵀ ν = r,   r = -γ - G M⁻¹ f

where W = 1 gives the normal forces, and then W = N of the same contact for friction, and the mean of all N for the
others: Σ N²/mean(N) + Σ |T|²/N is least, in which friction is shared in proportion to N. All W are forces, so that the
units do not matter where normals are not parallel. Where a contact pulls, W = 1 remains.

All is in `PhaseData`. A new set of modes is other integers there for the same code.

With M = L D Lᵀ, every row stands as D^-½ L⁻¹ Gᵀ, so that G M⁻¹ Kᵀ are products of rows.
"""

from __future__ import annotations

import math

from ...native.functions import components
from ...native.instructions import Integers, Reals, Row, compiled, greater, inlined, lesser, root
from ..cones.block_rows import dot
from . import laws
from .contact_outputs import (
    adhesion_of,
    biases_of,
    force_of,
    forwarded,
    friction,
    given_force_of,
    inner,
    moved,
    rates_of,
    row_added,
    row_taken,
    row_taken_in,
    static_friction_of,
)
from .phase_record import PhaseData

NAN = float("nan")
PULL = 1e-9
"""Part of the greatest normal force up to which one below zero is round-off."""


@inlined
def positive(mu: float) -> float:
    """Return a coefficient of friction; NAN if a law of friction gives a negative one."""
    return mu if mu >= 0.0 else NAN


@compiled
def set_share(phase: PhaseData, k: int, slip: int) -> None:
    """Set the friction of a slip along each tangent, per unit of normal force: -μ d_j, at rest -μ_s d_j."""
    share, mu = phase.share[k], positive(friction(phase, k))
    if slip == laws.ALONG:
        v = rates_of(phase, k)
        speed = root(v[1] * v[1] + v[2] * v[2])
        part = -mu / speed
        share[0], share[1] = part * v[1], part * v[2]
    elif slip == laws.FIXED:
        for j in range(2):
            share[j] = -static_friction_of(phase, k) * phase.direction[k, j]
    else:
        share[0] = -mu if slip == laws.PLUS else mu


# --- conditions ----------------------------------------------------------------------------------


@inlined
def force_row(phase: PhaseData, i: int) -> Reals:
    """Return the row of K of a condition."""
    return phase.G[phase.force_row[i]]


@compiled
def rows_made(phase: PhaseData) -> None:
    """Set the rows of G of all conditions."""
    for i in range(phase.conditions):
        k, G = phase.source[i], phase.G[i]
        if k < 0:
            own = phase.own_G[-1 - k]
            for p in range(phase.n):
                G[p] = own[p]
        else:
            row_taken_in(phase, phase.first[k] + phase.row_of[i], G, phase.low[i], phase.high[i])
            forwarded(phase, G, phase.low[i], phase.high[i])


@compiled
def loads_made(phase: PhaseData) -> None:
    """Set the rows of K where they differ from those of G: what friction adds is summed before it is forwarded."""
    for i in range(phase.own, phase.conditions):
        if phase.force_row[i] != i:
            k, G, K = phase.source[i], phase.G[i], force_row(phase, i)
            for p in range(phase.low[i], phase.high[i]):
                K[p] = 0.0
            if phase.slip[i] != laws.NO_SLIP:
                add_friction(phase, K, k, phase.slip[i])
            r = k + 1
            while r < phase.contacts and phase.presser[r] == k:
                if phase.pushed[r] != laws.NO_SLIP:
                    add_friction(phase, K, r, phase.pushed[r])
                r += 1
            forwarded(phase, K, phase.low[i], phase.high[i])
            for p in range(phase.low[i], phase.high[i]):
                K[p] += G[p]


@compiled
def add_friction(phase: PhaseData, K: Reals, k: int, slip: int) -> None:
    """Add the friction of a slip, or the moments that resist rolling or spinning, per unit of normal force to K."""
    set_share(phase, k, slip)
    for j in range(phase.tangents[k]):
        row_added(phase, phase.first[k] + 1 + j, phase.share[k, j], K)


@inlined
def gamma_of(phase: PhaseData, i: int) -> float:
    """Return γ of a condition."""
    k = phase.source[i]
    return phase.gamma[-1 - k] if k < 0 else biases_of(phase, k)[phase.row_of[i]]


@inlined
def joint(phase: PhaseData, i: int, j: int, K: Row) -> float:
    """Return G of a condition times a row of another one, over the places that both have."""
    low = phase.low[i] if phase.low[i] > phase.low[j] else phase.low[j]
    high = phase.high[i] if phase.high[i] < phase.high[j] else phase.high[j]
    return between(phase.G[i], K, low, high, phase.n)


@inlined
def between(a: Row, b: Row, low: int, high: int, n: int) -> float:
    """Return a · b from ``low`` up to ``high``."""
    result = 0.0
    if high - low == n:
        result = inner(a, b, n)
    elif high > low:
        result = dot(a[low:], b[low:], high - low)
    return result


@inlined
def add_in(phase: PhaseData, i: int, x: float, K: Row) -> None:
    """Add x times a row of a condition to the step."""
    w, low, high = phase.step, phase.low[i], phase.high[i]
    if high - low == phase.n:
        for p in components(phase.n):
            w[p] += x * K[p]
    else:
        for p in range(low, high):
            w[p] += x * K[p]


# --- forces --------------------------------------------------------------------------------------


@compiled
def shared(phase: PhaseData) -> int:
    """Set λ of all conditions to forces of equal compliance with ``right``; return 0 if they do not exist, else 1."""
    S, Q = phase.S, phase.Q
    for j in range(phase.conditions):
        phase.weight[j], first = 1.0, phase.active_at[phase.island[j]]
        for a in range(phase.active_at[phase.island[j] + 1] - first):
            i = phase.independent[first + a]
            Q[j, a] = joint(phase, i, j, phase.G[j])
            S[j, a] = Q[j, a]
            if phase.force_row[j] != j:
                S[j, a] = joint(phase, i, j, force_row(phase, j))
    if weighted(phase) == 0:
        return 0
    if phase.slipping == 0:
        again = 0
        for s in range(phase.islands):
            if pulls(phase, s) == 0:
                weigh(phase, s)
                again = 1
        if again != 0:
            weighted(phase)  # contacts without load have no friction to share: the first shares remain
    return 1


@compiled
def weigh(phase: PhaseData, island: int) -> None:
    """Set W of an island to the first shares of its normal forces."""
    mean = mean_normal(phase, island, phase.lam, 1.0)
    for m in range(phase.member_at[island], phase.member_at[island + 1]):
        j = phase.members[m]
        k = phase.source[j]
        if phase.normal_of[j] >= 0:
            phase.weight[j] = phase.lam[phase.normal_of[j]]
        elif k >= 0 and phase.held[k] != 0:
            phase.weight[j] = force_of(phase, k)[0]
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
def independent(phase: PhaseData, chosen: Integers, size: int, sliding: int) -> int:
    """Set λ of the ``chosen`` conditions for ``right``, of the others 0; return 0 if they are not independent, else 1.

    They stand island by island. If ``sliding`` is 0, K = G.
    """
    if size < phase.conditions:
        for i in range(phase.conditions):
            phase.lam[i] = 0.0
    first, good = 0, 1
    while first < size and good != 0:
        count = 1
        while first + count < size and phase.island[chosen[first + count]] == phase.island[chosen[first]]:
            count += 1
        good = solved_in(phase, chosen[first:], count, sliding)
        first += count
    return good


@compiled
def solved_in(phase: PhaseData, chosen: Integers, size: int, sliding: int) -> int:
    """Set λ of conditions of one island as `independent` does."""
    lam, square, nu = phase.lam, phase.square, phase.nu
    for a in range(size):
        if sliding != 0:
            for b in range(size):
                square[a, b] = joint(phase, chosen[a], chosen[b], force_row(phase, chosen[b]))
        else:
            for b in range(a + 1):
                square[a, b] = joint(phase, chosen[a], chosen[b], phase.G[chosen[b]])
                square[b, a] = square[a, b]
        square[a, size] = phase.right[chosen[a]]
    if eliminated(phase, size) == 0:
        return 0
    for a in range(size):
        lam[chosen[a]] = nu[a]
    return 1


@compiled
def eliminated(phase: PhaseData, size: int) -> int:
    """Set ν to the solution of the equations ``square``, whose right sides are in their last column.

    Return 0 if they are singular, else 1. They are a few: a row is taken from all others (Gauss and Jordan), eight
    numbers at a time, so that nothing is substituted one after another.
    """
    square = phase.square
    for k in range(size):
        p = k
        for i in range(k + 1, size):
            if abs(square[i, k]) > abs(square[p, k]):
                p = i
        if square[p, k] == 0.0 or not math.isfinite(square[p, k]):
            return 0
        above, greatest = square[k], square[p]
        if p != k:
            for c in components(size + 1):
                x = above[c]
                above[c] = greatest[c]
                greatest[c] = x
        inverse = 1.0 / square[k, k]
        phase.nu[k] = inverse
        for i in range(size):
            if i != k:
                part, row = square[i, k] * inverse, square[i]
                for c in components(size + 1):
                    row[c] -= part * above[c]
    for k in range(size):
        phase.nu[k] *= square[k, size]
    return 1


@compiled
def push(phase: PhaseData, z: Reals) -> None:
    """Set the normal forces that the state gives, and the friction of those contacts that slip; add them to z.

    The pull -A of a rigid contact that adheres is added, too: λ = N + A is what its condition gives, and its cone has.
    """
    for closed in range(phase.closed_count):
        k = phase.closed[closed]
        presser = phase.presser[k]
        if presser >= 0 and phase.held[presser] == 0:
            continue  # it is found with its normal force
        if phase.held[k] != 0:
            F = force_of(phase, k)
            F[0] = given_force_of(phase, k) if presser < 0 else force_of(phase, presser)[0]
            if phase.compliant[k] != 0:
                push_along(phase, z, phase.first[k], F[0])
            if phase.pushed[k] != laws.NO_SLIP:
                set_share(phase, k, phase.pushed[k])
                for j in range(phase.tangents[k]):
                    F[1 + j] = F[0] * phase.share[k, j]
                    push_along(phase, z, phase.first[k] + 1 + j, F[1 + j])
        elif phase.adhesive_count > 0:
            push_along(phase, z, phase.first[k], -adhesion_of(phase, k))


@compiled
def push_along(phase: PhaseData, z: Reals, r: int, force: float) -> None:
    """Add a force along a row of the contacts to z."""
    spare = phase.spare
    row_taken(phase, r, spare)
    forwarded(phase, spare, 0, phase.n)
    for i in range(phase.n):
        z[i] += force * spare[i]


@compiled
def balance(phase: PhaseData) -> int:
    """Set accelerations, contact forces and multipliers; return 0 if a condition has lost its independence, else 1."""
    n, count, w, z = phase.n, phase.conditions, phase.step, phase.free
    if phase.held_count + phase.adhesive_count > 0:
        push(phase, z)
    rows_made(phase)
    if phase.slipping != 0:
        loads_made(phase)
    for p in range(n):
        w[p] = z[p]
    for i in range(count):
        phase.right[i] = -(gamma_of(phase, i) + between(phase.G[i], w, phase.low[i], phase.high[i], n))
    good = 1
    if count > phase.active:
        good = shared(phase)
    elif count > 0:
        good = independent(phase, phase.independent, count, phase.slipping)
    for i in range(count):
        x, K, k = phase.lam[i], force_row(phase, i), phase.source[i]
        add_in(phase, i, x, K)
        if k < 0:
            phase.multiplier[phase.number[-1 - k]] = x
        else:
            F = force_of(phase, k)
            F[phase.row_of[i]] = x
            if phase.row_of[i] == 0:
                rub(phase, k, phase.slip[i], x)
                F[0] = x - adhesion_of(phase, k)
                r = k + 1
                while r < phase.contacts and phase.presser[r] == k:
                    rub(phase, r, phase.pushed[r], x)
                    force_of(phase, r)[0] = x
                    r += 1
    moved(phase, w, phase.udot)
    # what sticks without load needs no friction, and has none below 0
    for closed in range(phase.closed_count):
        if static_friction_of(phase, phase.closed[closed]) < 0.0:
            phase.udot[0] = NAN
    return good


@compiled
def rub(phase: PhaseData, k: int, slip: int, normal: float) -> None:
    """Set the friction, or the moments, of a contact that slips, rolls or spins."""
    if slip != laws.NO_SLIP:
        F = force_of(phase, k)
        for j in range(phase.tangents[k]):
            F[1 + j] = normal * phase.share[k, j]


# --- shares, once more, for derivatives ----------------------------------------------------------


@compiled
def condition_force(phase: PhaseData, i: int) -> float:
    """Return λ of a condition of a phase that is solved."""
    k = phase.source[i]
    if k < 0:
        return phase.multiplier[phase.number[-1 - k]]
    return force_of(phase, k)[phase.row_of[i]] + (adhesion_of(phase, k) if phase.row_of[i] == 0 else 0.0)


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
    """Set ``firsts`` to the forces that W = 1 shares, of the λ ``forces`` of a phase, and ``weights`` to its W.

    Leave W = 1. Return 0 if a contact without load has none, else 1.
    """
    good = 1
    for i in range(phase.conditions):
        weights[i] = phase.weight[i]
        if not phase.weight[i] > 0.0:
            good = 0
        phase.weight[i] = 1.0
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
