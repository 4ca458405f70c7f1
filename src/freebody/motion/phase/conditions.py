"""Rows of the conditions of a phase (`closed_contacts`), and forces of those that are independent, compiled."""

from __future__ import annotations

import math

from ...native.functions import components
from ...native.instructions import Integers, Reals, Row, compiled, inlined, root
from ..cones.block_rows import dot
from . import laws
from .contact_outputs import (
    adhesion_of,
    biases_of,
    force_of,
    forwarded,
    friction,
    inner,
    rates_of,
    row_added,
    row_taken_in,
    static_friction_of,
)
from .phase_record import PhaseData

NAN = float("nan")


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
def condition_force(phase: PhaseData, i: int) -> float:
    """Return λ of a condition of a phase that is solved."""
    k = phase.source[i]
    if k < 0:
        return phase.multiplier[phase.number[-1 - k]]
    return force_of(phase, k)[phase.row_of[i]] + (adhesion_of(phase, k) if phase.row_of[i] == 0 else 0.0)
