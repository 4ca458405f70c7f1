"""The start of a constrained motion, in compiled code: coordinates by Gauss-Newton steps, then speeds.

    φ(q) = 0        q ← q + q'(q, δ),    G δ = -φ with |δ| least, no |δ_i| above 1
    ψ = G u + g     u ← u + δ,           G δ = -ψ with δᵀ M δ least

If the conditions on coordinates contradict each other, δ is a least-squares solution. G is factorized by
`sparse_rows`, whose cost follows the width of the machine's loops, and δ of the speeds comes from a kernel
(`constrained.least_speed_change`) for the conditions that are independent in the speeds that may change.
"""

from __future__ import annotations

import math

from ...native.instructions import Reals, compiled, greater, root
from .closing_record import CROWDED, FAR, MET, NOWHERE, TORN, Closing
from .sparse_rows import factorize, shortest

CORRECTIONS = 3
"""Greatest number of corrections of the speeds: one is exact unless conditions are nearly dependent."""
CLOSELY = 1e-14
"""Residual of the speeds, relative to their scale, that is round-off."""


@compiled
def finite(a: Closing) -> int:
    """Return 1 if the residuals of conditions on coordinates, and their derivatives along free motions, are finite."""
    phi, G, rows, result = a.outputs, a.outputs[a.n_conditions :], a.rows, 1
    for i in range(a.n_conditions):
        if a.on_speeds[i] == 0:
            if not math.isfinite(phi[i]):
                result = 0
            for k in range(rows.starts[i], rows.starts[i + 1]):
                if a.immobile[rows.columns[k]] == 0 and not math.isfinite(G[k]):
                    result = 0
    return result


@compiled
def unit_quaternions(a: Closing) -> None:
    """Divide each quaternion by its length."""
    y = a.state
    for k in range(a.n_quaternions):
        i = a.quaternions[k]
        length = root(y[i] * y[i] + y[i + 1] * y[i + 1] + y[i + 2] * y[i + 2] + y[i + 3] * y[i + 3])
        for j in range(4):
            y[i + j] /= length


@compiled
def residual_at_rest(a: Closing) -> float:
    """Evaluate φ and G with all speeds zero; return the greatest residual of the conditions on coordinates."""
    for j in range(a.n_speeds):
        a.state[a.n_coordinates + j] = 0.0
    a.conditions(a.t, a.state, a.c, a.outputs)
    size = 0.0
    for i in range(a.n_conditions):
        if a.on_speeds[i] == 0:
            size = greater(size, abs(a.outputs[i]))
    return size


@compiled
def positions(a: Closing) -> int:
    """Replace the coordinates by coordinates that satisfy the conditions on coordinates; the speeds become 0.

    Return MET, NOWHERE, FAR or CROWDED.
    """
    n_q, n, m, rows = a.n_coordinates, a.n_speeds, a.n_conditions, a.rows
    phi, G, x, u = a.outputs, a.outputs[m:], a.change, a.state[n_q:]
    for i in range(m):
        rows.taking_part[i] = 1 - a.on_speeds[i]
    for j in range(n):
        rows.free[j], a.unit[j] = 1 - a.immobile[j], 1.0
    rows.poor = rows.least = a.dependent
    best, stalled = math.inf, 0
    for _ in range(a.most_steps):
        size = residual_at_rest(a)
        if finite(a) == 0:
            return NOWHERE
        stalled = stalled + 1 if size >= best else 0
        best = size if size < best else best
        if size == 0.0 or (stalled >= 2 and size < a.near):
            return MET
        if factorize(G, a.unit, rows) != 0:
            return CROWDED
        for i in range(m):
            phi[i] = -phi[i]
        if shortest(phi, x, a.unit, rows) != 0:
            return CROWDED
        length = 1.0
        for j in range(n):
            length = greater(length, abs(x[j]))
        for j in range(n):
            u[j] = x[j] / length
        a.moved(a.t, a.state, a.c, a.rates)
        for i in range(n_q):
            a.state[i] += a.rates[i]
        unit_quaternions(a)
    return MET if residual_at_rest(a) < a.near else FAR


@compiled
def judge_speeds(a: Closing, psi: Reals, G: Reals) -> None:
    """Set the largest residual of the speeds, its condition and its scale."""
    u, largest, fastest, worst = a.state[a.n_coordinates :], 0.0, 0.0, 0
    for j in range(a.n_speeds):
        fastest = greater(fastest, abs(u[j]))
    for k in range(a.n_entries):
        largest = greater(largest, abs(G[k]))
    for i in range(a.n_conditions):
        if abs(psi[i]) > abs(psi[worst]):
            worst = i
    a.worst, a.missed, a.scale = worst, 0.0, 1.0 + largest * fastest
    if a.n_conditions > 0:
        a.missed = psi[worst]


@compiled
def speeds(a: Closing) -> int:
    """Replace the speeds by speeds that satisfy all conditions. The fixed speeds do not change.

    The selection of `least_speed_change` stands after the state. Return MET or TORN.
    """
    psi, G, rows, u = a.outputs, a.outputs[a.n_conditions :], a.rows, a.state[a.n_coordinates :]
    count = 0
    for i in range(a.n_conditions):
        count += rows.chosen[i]
    last, k = math.inf, 0
    judge_speeds(a, psi, G)
    while count > 0 and k < CORRECTIONS and (k == 0 or CLOSELY < abs(a.missed) / a.scale < last):
        last = math.inf if k == 0 else abs(a.missed) / a.scale
        a.least(a.t, a.state, a.c, a.change)
        for j in range(a.n_speeds):
            u[j] += a.change[j]
        for i in range(a.n_conditions):
            for e in range(rows.starts[i], rows.starts[i + 1]):
                psi[i] += G[e] * a.change[rows.columns[e]]
        judge_speeds(a, psi, G)
        k += 1
    return TORN if abs(a.missed) > a.dependent * a.scale else MET


@compiled
def close(a: Closing) -> None:
    """Move coordinates and speeds onto the constraints, and find which conditions are independent there."""
    n, m, rows, u = a.n_speeds, a.n_conditions, a.rows, a.state[a.n_coordinates :]
    for j in range(n):
        a.before[j] = u[j]
    a.status = positions(a)
    for j in range(n):
        u[j] = a.before[j]
    if a.status != MET:
        return
    a.motion(a.t, a.state, a.c, a.outputs)
    G, masses, some_fixed = a.outputs[m:], a.outputs[m + a.n_entries :], 0
    a.heavy = 1
    for j in range(n):
        if not masses[n + j] > a.light * masses[j]:  # its pivot
            a.heavy = 0
        masses[j] = 1.0 / root(masses[j])
        rows.free[j] = 1
        some_fixed += a.fixed[j]
    for i in range(m):
        rows.taking_part[i] = 1
    rows.poor, rows.least = a.poor, a.dependent
    if factorize(G, masses, rows) != 0:
        a.status = CROWDED
        return
    for i in range(m):
        a.independent[i] = rows.chosen[i]
    if some_fixed > 0:
        for j in range(n):
            rows.free[j] = 1 - a.fixed[j]
        if factorize(G, masses, rows) != 0:
            a.status = CROWDED
            return
    selection = u[n:]
    for j in range(n):
        selection[j] = 1.0 * rows.free[j]
    for i in range(m):
        selection[n + i] = 1.0 * rows.chosen[i]
    a.status = speeds(a)
