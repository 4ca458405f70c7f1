"""The start of a constrained motion, in compiled code: coordinates by Gauss-Newton steps, then speeds.

    φ(q) = 0        q ← q + q'(q, δ),    G δ = -φ with |δ| least, no |δ_i| above 1
    ψ = G u + g     u ← u + δ,           G δ = -ψ with δᵀ M δ least

If the conditions on coordinates contradict each other, δ is a least-squares solution. G is factorized by
`sparse_rows`, whose cost follows the width of the machine's loops, and δ of the speeds comes from a kernel
(`constrained.least_speed_change`) for the conditions that are independent in the speeds that may change.
"""

from __future__ import annotations

import math

from ...native.instructions import (
    Integers,
    Reals,
    call,
    compiled,
    greater,
    integers_at,
    reals_at,
    root,
    shifted,
)
from ..ode.layout import (
    BY_CONDITION,
    CONDITIONS,
    COORDINATES,
    CROWDED,
    DEPENDENT,
    FACTORS,
    FACTORS_REAL,
    FAR,
    HEAVY,
    INTEGERS_AT,
    LEAST,
    LIGHT,
    MET,
    MISSED,
    MOMENT,
    MOTION,
    MOVED,
    N_CONDITIONS,
    N_COORDINATES,
    N_ENTRIES,
    N_QUATERNIONS,
    N_SPEEDS,
    NOWHERE,
    NUMBERS_AT,
    OF_PARAMETERS,
    PATTERN,
    POOR,
    ROOM_AT,
    SIZE,
    SMALL,
    STATUS,
    STEPS,
    TORN,
    WORST,
)
from .sparse_rows import PART, POOR_PART, chosen_at, factorize, shortest

CORRECTIONS = 3
"""Greatest number of corrections of the speeds: one is exact unless conditions are nearly dependent."""
CLOSELY = 1e-14
"""Residual of the speeds, relative to their scale, that is round-off."""


@compiled
def finite(values: Reals, G: Reals, a: Integers) -> int:
    """Return 1 if the residuals of conditions on coordinates, and their derivatives along free motions, are
    finite.
    """
    m = a[N_CONDITIONS]
    on_speeds = shifted(integers_at(a[INTEGERS_AT]), BY_CONDITION)
    immobile = shifted(on_speeds, 2 * m)
    start = integers_at(a[PATTERN])
    columns = shifted(start, m + 1)
    result = 1
    for i in range(m):
        if on_speeds[i] == 0:
            if not math.isfinite(values[i]):
                result = 0
            for k in range(start[i], start[i + 1]):
                if immobile[columns[k]] == 0 and not math.isfinite(G[k]):
                    result = 0
    return result


@compiled
def unit_quaternions(y: Reals, quaternions: Integers, nq: int) -> None:
    """Divide each quaternion by its length."""
    for k in range(nq):
        i = quaternions[k]
        length = root(y[i] * y[i] + y[i + 1] * y[i + 1] + y[i + 2] * y[i + 2] + y[i + 3] * y[i + 3])
        for j in range(4):
            y[i + j] /= length


@compiled
def greatest_residual(phi: Reals, on_speeds: Integers, m: int) -> float:
    """Return the greatest residual of the conditions on coordinates."""
    size = 0.0
    for i in range(m):
        if on_speeds[i] == 0:
            size = greater(size, abs(phi[i]))
    return size


@compiled
def positions(a: Integers) -> int:
    """Replace the coordinates by coordinates that satisfy the conditions on coordinates; the speeds become 0.

    Return MET, NOWHERE, FAR or CROWDED.
    """
    n_q, n, m = a[N_COORDINATES], a[N_SPEEDS], a[N_CONDITIONS]
    integers, numbers = integers_at(a[INTEGERS_AT]), reals_at(a[NUMBERS_AT])
    c, f, r = reals_at(a[OF_PARAMETERS]), integers_at(a[FACTORS]), reals_at(a[FACTORS_REAL])
    on_speeds = shifted(integers, BY_CONDITION)
    immobile = shifted(on_speeds, 2 * m)
    taking_part = shifted(immobile, 2 * n + a[N_QUATERNIONS])
    mobile = shifted(taking_part, m)
    t, y, room = numbers[MOMENT], shifted(numbers, COORDINATES), reals_at(a[ROOM_AT])
    phi = room
    G = shifted(phi, m)
    x = shifted(G, a[N_ENTRIES])
    unit = shifted(x, n)
    rates = shifted(unit, n)
    for i in range(m):
        taking_part[i] = 1 - on_speeds[i]
    for j in range(n):
        mobile[j], unit[j] = 1 - immobile[j], 1.0
    r[POOR_PART], r[PART] = numbers[DEPENDENT], numbers[DEPENDENT]
    best, stalled = math.inf, 0
    for _ in range(integers[STEPS]):
        for j in range(n):
            y[n_q + j] = 0.0
        call(a[CONDITIONS], t, y, 0, c, phi, 0)
        if finite(phi, G, a) == 0:
            return NOWHERE
        size = greatest_residual(phi, on_speeds, m)
        stalled = stalled + 1 if size >= best else 0
        best = size if size < best else best
        if size == 0.0 or (stalled >= 2 and size < numbers[SMALL]):
            return MET
        if factorize(G, integers_at(a[PATTERN]), taking_part, mobile, unit, f, r) != 0:
            return CROWDED
        for i in range(m):
            phi[i] = -phi[i]
        if shortest(phi, x, unit, f, r) != 0:
            return CROWDED
        length = 1.0
        for j in range(n):
            length = greater(length, abs(x[j]))
        for j in range(n):
            y[n_q + j] = x[j] / length
        call(a[MOVED], t, y, 0, c, rates, 0)
        for i in range(n_q):
            y[i] += rates[i]
        unit_quaternions(y, shifted(immobile, 2 * n), a[N_QUATERNIONS])
    for j in range(n):
        y[n_q + j] = 0.0
    call(a[CONDITIONS], t, y, 0, c, phi, 0)
    return MET if greatest_residual(phi, on_speeds, m) < numbers[SMALL] else FAR


@compiled
def judge_speeds(a: Integers, psi: Reals, G: Reals) -> None:
    """Put the largest residual of the speeds, its condition and its scale in place."""
    n, m = a[N_SPEEDS], a[N_CONDITIONS]
    integers, numbers = integers_at(a[INTEGERS_AT]), reals_at(a[NUMBERS_AT])
    u = shifted(numbers, COORDINATES + a[N_COORDINATES])
    largest, fastest, worst = 0.0, 0.0, 0
    for j in range(n):
        fastest = greater(fastest, abs(u[j]))
    for k in range(a[N_ENTRIES]):
        largest = greater(largest, abs(G[k]))
    for i in range(m):
        if abs(psi[i]) > abs(psi[worst]):
            worst = i
    integers[WORST] = worst
    numbers[MISSED], numbers[SIZE] = 0.0, 1.0 + largest * fastest
    if m > 0:
        numbers[MISSED] = psi[worst]


@compiled
def speeds(a: Integers, psi: Reals, G: Reals) -> int:
    """Replace the speeds by speeds that satisfy all conditions. The fixed speeds do not change.

    The selection of `least_speed_change` stands after the state. Return MET or TORN.
    """
    n_q, n, m = a[N_COORDINATES], a[N_SPEEDS], a[N_CONDITIONS]
    numbers = reals_at(a[NUMBERS_AT])
    y = shifted(numbers, COORDINATES)
    change = shifted(G, a[N_ENTRIES])
    active = shifted(y, n_q + 2 * n)
    start = integers_at(a[PATTERN])
    columns = shifted(start, m + 1)
    count = 0.0
    for i in range(m):
        count += active[i]
    last, k = math.inf, 0
    judge_speeds(a, psi, G)
    while (
        count > 0.0 and k < CORRECTIONS and (k == 0 or CLOSELY < abs(numbers[MISSED]) / numbers[SIZE] < last)
    ):
        last = math.inf if k == 0 else abs(numbers[MISSED]) / numbers[SIZE]
        call(a[LEAST], numbers[MOMENT], y, 0, reals_at(a[OF_PARAMETERS]), change, 0)
        for j in range(n):
            y[n_q + j] += change[j]
        for i in range(m):
            for e in range(start[i], start[i + 1]):
                psi[i] += G[e] * change[columns[e]]
        judge_speeds(a, psi, G)
        k += 1
    return TORN if abs(numbers[MISSED]) > numbers[DEPENDENT] * numbers[SIZE] else MET


@compiled
def close(a: Integers) -> None:
    """Move coordinates and speeds onto the constraints, and find which conditions are independent there.

    ``a`` holds the addresses of four kernels of (q, u, selection), which give (φ, G), (ψ, G, diagonal of M, pivots of
    M), q' and δ; numbers of things; and the addresses of the integers and numbers that are passed in and returned, of
    the pattern of G, of memory and of the constants of the kernels (`layout`).
    """
    n_q, n, m = a[N_COORDINATES], a[N_SPEEDS], a[N_CONDITIONS]
    integers, numbers = integers_at(a[INTEGERS_AT]), reals_at(a[NUMBERS_AT])
    f, r = integers_at(a[FACTORS]), reals_at(a[FACTORS_REAL])
    chosen = shifted(integers, BY_CONDITION + m)
    fixed = shifted(chosen, m + n)
    taking_part = shifted(fixed, n + a[N_QUATERNIONS])
    free = shifted(taking_part, m)
    state, psi = shifted(numbers, COORDINATES), reals_at(a[ROOM_AT])
    before = shifted(psi, m + a[N_ENTRIES] + 3 * n + n_q)
    for j in range(n):
        before[j] = state[n_q + j]
    integers[STATUS] = positions(a)
    for j in range(n):
        state[n_q + j] = before[j]
    if integers[STATUS] != MET:
        return
    call(a[MOTION], numbers[MOMENT], state, 0, reals_at(a[OF_PARAMETERS]), psi, 0)
    G = shifted(psi, m)
    masses = shifted(G, a[N_ENTRIES])
    pivots, some_fixed = shifted(masses, n), 0
    integers[HEAVY] = 1
    for j in range(n):
        if not pivots[j] > numbers[LIGHT] * masses[j]:
            integers[HEAVY] = 0
        masses[j] = 1.0 / root(masses[j])
        free[j] = 1
        some_fixed += fixed[j]
    for i in range(m):
        taking_part[i] = 1
    r[POOR_PART], r[PART] = numbers[POOR], numbers[DEPENDENT]
    if factorize(G, integers_at(a[PATTERN]), taking_part, free, masses, f, r) != 0:
        integers[STATUS] = CROWDED
        return
    independent = chosen_at(f)
    for i in range(m):
        chosen[i] = independent[i]
    if some_fixed > 0:
        for j in range(n):
            free[j] = 1 - fixed[j]
        if factorize(G, integers_at(a[PATTERN]), taking_part, free, masses, f, r) != 0:
            integers[STATUS] = CROWDED
            return
    selection = shifted(state, n_q + n)
    for j in range(n):
        selection[j] = 1.0 * free[j]
    for i in range(m):
        selection[n + i] = 1.0 * independent[i]
    integers[STATUS] = speeds(a, psi, G)
