"""The kernels of a phase at a state: rates, forces, and what decides events, in compiled code.

Each has the signature of a kernel, f(t, y, c, out); y = (q, u, work, heat of friction), and c is `PhaseData`.
"""

from __future__ import annotations

from ...native.instructions import EPS, Reals, Truth, compiled, greater, inlined, lesser, root
from . import laws
from .bearings import solve
from .conditions import NAN, independent
from .contact_outputs import (
    adhesion_of,
    biases_of,
    closed_touched,
    extended,
    force_of,
    forwarded,
    gaps_found,
    given_force_of,
    moved_in,
    open_touched,
    places_of,
    product,
    rates_of,
    row_along,
    row_taken_in,
    static_friction_of,
)
from .phase_record import PhaseData

INFINITE = float("inf")
ROOT, PART = EPS**0.5, 1e-3
"""Change of a component for a derivative, relative to 1 or its size, and relative to the slowest slip in space."""


@compiled
def heat_of_friction(phase: PhaseData) -> float:
    """Return the heat of friction per second, -T·v of all contacts that slip."""
    heat = 0.0
    if phase.slipping != 0:
        for i in range(phase.conditions):
            if phase.slip[i] != laws.NO_SLIP:
                k = phase.source[i]
                F, v = force_of(phase, k), rates_of(phase, k)
                for j in range(phase.tangents[k]):
                    heat -= F[1 + j] * v[1 + j]
    if phase.held_count > 0:
        for i in range(phase.closed_count):
            k = phase.closed[i]
            if phase.pushed[k] != laws.NO_SLIP:
                F, v = force_of(phase, k), rates_of(phase, k)
                for j in range(phase.tangents[k]):
                    heat -= F[1 + j] * v[1 + j]
    return heat


@compiled
def power_of_compliant(phase: PhaseData) -> float:
    """Return the power of the normal forces of compliant contacts, N g'."""
    power = 0.0
    for i in range(phase.closed_count):
        k = phase.closed[i]
        if phase.compliant[k] != 0:
            power += force_of(phase, k)[0] * rates_of(phase, k)[0]
    return power


@compiled
def rates(t: float, y: Reals, c: Reals, out: Reals) -> None:
    """Set ``out`` to q', u', the power of all that does work, and the heat of friction per second."""
    phase = PhaseData(c)
    good = solve(t, y, phase)
    n_q, n = phase.n_q, phase.n
    for i in range(n_q):
        out[i] = phase.q_dot[i]
    for i in range(n):
        out[n_q + i] = phase.udot[i] if good != 0 else NAN
    power, heat = phase.load[0], heat_of_friction(phase)
    if phase.compliant_count > 0:
        power += power_of_compliant(phase)
    if phase.driven != 0:
        extended(y, phase)
        phase.power(t, phase.state, phase.power_c, out[n_q + n :])
        power += out[n_q + n]
    out[n_q + n] = power - heat
    out[n_q + n + 1] = heat
    phase.solved, phase.solved_t = good, t
    for i in range(n_q + n):
        phase.solved_y[i] = y[i]


@compiled
def tangent(t: float, y: Reals, c: Reals, out: Reals) -> None:
    """Set ``out`` to the derivative of the rates along one component of the state; y is the state, then a unit vector.

    The components of a state are asked for in their order, since the first computes the rates at the state. The
    derivative is a difference over a small part of the slowest slip in space, whose direction turns fastest. An
    implicit method only iterates with it, so that its error is none of the motion's.
    """
    phase = PhaseData(c)
    moved, k = phase.n_q + phase.n, 0
    size, base, state = moved + 2, phase.base, phase.beside
    while y[size + k] == 0.0:
        k += 1
    if k == 0:
        rates(t, y, c, base)
        phase.slowest = slowest_slip(phase)
    if k >= moved:  # nothing depends on work and heat
        for i in range(size):
            out[i] = 0.0
        return
    for i in range(size):
        state[i] = y[i]
    state[k] += lesser(PART * phase.slowest, ROOT * greater(1.0, abs(y[k])))
    change = state[k] - y[k]
    rates(t, state, c, out)
    for i in range(size):
        out[i] = (out[i] - base[i]) / change


@compiled
def slowest_slip(phase: PhaseData) -> float:
    """Return the least speed of a slip in space, or infinity if there is none."""
    least = INFINITE
    for i in range(phase.conditions):
        if phase.slip[i] == laws.ALONG:
            v = rates_of(phase, phase.source[i])
            least = lesser(least, root(v[1] * v[1] + v[2] * v[2]))
    for k in range(phase.contacts if phase.held_count > 0 else 0):
        if phase.pushed[k] == laws.ALONG:
            v = rates_of(phase, k)
            least = lesser(least, root(v[1] * v[1] + v[2] * v[2]))
    return least


@compiled
def derived(t: float, y: Reals, c: Reals, out: Reals) -> None:
    """Call a kernel of the state, accelerations, contact forces and multipliers."""
    phase = PhaseData(c)
    solve(t, y, phase)
    extended(y, phase)
    phase.derived(t, phase.state, phase.derived_c, out)


@compiled
def multipliers(t: float, y: Reals, c: Reals, out: Reals) -> None:
    """Set ``out`` to the multipliers of all conditions of the machine itself."""
    phase = PhaseData(c)
    solve(t, y, phase)
    for i in range(phase.all_own):
        out[i] = phase.multiplier[i]


@compiled
def force(t: float, y: Reals, c: Reals, out: Reals) -> None:
    """Set ``out`` to the forces of all contacts."""
    phase = PhaseData(c)
    solve(t, y, phase)
    for r in range(phase.rows):
        out[r] = phase.force[r]


@compiled
def acceleration(t: float, y: Reals, c: Reals, out: Reals) -> None:
    """Set ``out`` to the derivatives of the rates of all contacts."""
    phase = PhaseData(c)
    solve(t, y, phase)
    open_touched(t, y, phase)
    for k in range(phase.contacts):
        b = biases_of(phase, k)
        for j in range(1 + phase.tangents[k]):
            r = phase.first[k] + j
            out[r] = row_along(phase, r, phase.udot) + b[j]


@compiled
def gap(t: float, y: Reals, c: Reals, out: Reals) -> None:
    """Set ``out`` to the gaps of all contacts."""
    phase = PhaseData(c)
    gaps_found(t, y, phase)
    for k in range(phase.contacts):
        out[k] = phase.gaps[phase.gap_at[k]]


@compiled
def reach(t: float, y: Reals, c: Reals, out: Reals) -> None:
    """Set ``out`` to the least reach of all contacts: negative beyond the ends of a side, infinite without ends."""
    phase = PhaseData(c)
    gaps_found(t, y, phase)
    for k in range(phase.contacts):
        out[k] = INFINITE
        for j in range(phase.reaches[k]):
            out[k] = lesser(out[k], phase.gaps[phase.gap_at[k] + 1 + j])


@compiled
def static_friction(t: float, y: Reals, c: Reals, out: Reals) -> None:
    """Set ``out`` to the coefficients of static friction of all contacts."""
    phase = PhaseData(c)
    closed_touched(t, y, phase)
    open_touched(t, y, phase)
    for k in range(phase.contacts):
        out[k] = static_friction_of(phase, k)


@compiled
def rate(t: float, y: Reals, c: Reals, out: Reals) -> None:
    """Set ``out`` to the rates of all contacts."""
    phase = PhaseData(c)
    closed_touched(t, y, phase)
    open_touched(t, y, phase)
    for k in range(phase.contacts):
        v = rates_of(phase, k)
        for j in range(1 + phase.tangents[k]):
            out[phase.first[k] + j] = v[j]


# --- all contacts at one moment ------------------------------------------------------------------


@compiled
def response(phase: PhaseData, v: Reals, X: Reals, low: int, high: int) -> None:
    """Set X to M⁻¹ v with the conditions of the phase enforced; v, in the order of elimination, is overwritten.

    Both are zero, and stay so, but from ``low`` up to ``high``: all speeds if there are conditions.
    """
    n = phase.n
    forwarded(phase, v, low, high)
    for i in range(phase.conditions):
        phase.right[i] = -product(phase.G[i], v, n)
    if phase.active > 0 and independent(phase, phase.independent, phase.active, 0) != 0:
        for i in range(phase.conditions):
            G = phase.G[i]
            for p in range(n):
                v[p] += phase.lam[i] * G[p]
    moved_in(phase, v, X, low, high)


@compiled
def row_seen(phase: PhaseData, k: int, r: int, W: Reals, X: Reals) -> None:
    """Set row r of a contact, and the change of u' per unit of its force, over the blocks of speeds that it has.

    Elsewhere they are zero, and are not written.
    """
    spare, low, high = phase.spare, 0, phase.n
    if phase.conditions == 0:
        low, high = places_of(phase, phase.beside_of[2 * k], phase.beside_of[2 * k + 1])
    row_taken_in(phase, r, spare, low, high)
    for p in range(low, high):
        W[phase.order[p]] = spare[p]
    response(phase, spare, X, low, high)


@inlined
def is_nearby(phase: PhaseData, k: int, limit: float) -> Truth:
    """Return True if the rows of a contact, or of what resists its rolling, are asked for.

    Adhesion changes the accelerations of all contacts.
    """
    p = phase.presser[k] if phase.presser[k] >= 0 else k
    gap = phase.touch[phase.touch_at[p]]
    return phase.only_near == 0 or phase.held[k] != 0 or phase.adhesive_count > 0 or not gap > limit


@compiled
def looked(t: float, y: Reals, c: Reals, out: Reals) -> None:
    """Set ``out`` to what decides events: gaps, least reaches, rates, W u' + b without contact forces, u' so, W, the
    change of u' per unit of each contact force, μ, μ_s, e, μ at rest, the least rates of reaches that are zero, and the
    normal forces that the state gives, and the adhesion.

    The machine's own conditions are enforced. With ``only_near`` rows of W, and changes by forces, of contacts that are
    far keep what they were: there are as many as pairs of bodies, and decisions ask for none of them.
    """
    phase = PhaseData(c)
    n, E, m, near = phase.n, phase.contacts, phase.rows, 1.0
    gap, reach, rate = out, out[E:], out[2 * E :]
    change, free = rate[m:], rate[2 * m :]
    W, X = free[n:], free[n + m * n :]
    coefficients, away, given, adhesion = (
        X[m * n :],
        X[m * n + 4 * E :],
        X[m * n + 5 * E :],
        X[m * n + 6 * E :],
    )
    solve(t, y, phase)
    open_touched(t, y, phase)
    for i in range(n):
        free[i] = phase.udot[i]
    for i in range(phase.n_q):
        near = greater(near, 1.0 + abs(y[i]))
    reach_of_rows, near = laws.NEARBY * near, laws.CLOSED * near
    for k in range(E):
        seen, v, b = phase.touch[phase.touch_at[k] :], rates_of(phase, k), biases_of(phase, k)
        gap[k], reach[k], away[k] = seen[0], INFINITE, INFINITE
        for j in range(phase.reaches[k]):
            reach[k] = lesser(reach[k], seen[1 + j])
            if abs(seen[1 + j]) <= near:
                away[k] = lesser(away[k], phase.touch[phase.away_at[k] + j])
        given[k], adhesion[k] = given_force_of(phase, k), adhesion_of(phase, k)
        for j in range(4):
            coefficients[4 * k + j] = phase.touch[phase.laws_at[k] + j]
        nearby = is_nearby(phase, k, reach_of_rows)
        for j in range(1 + phase.tangents[k]):
            r = phase.first[k] + j
            rate[r] = v[j]
            change[r] = row_along(phase, r, free) + b[j]
            if nearby:
                row_seen(phase, k, r, W[r * n :], X[r * n :])
