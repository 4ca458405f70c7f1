"""The projection of a state, and of its derivatives, onto the conditions of a phase, in compiled code."""

from __future__ import annotations

from ...native.instructions import Reals, compiled
from .conditions import NAN, independent, rows_made
from .contact_outputs import closed_touched, direct, evaluated, moved, rates_of, touch_along
from .phase_record import PhaseData
from .slopes_record import PhaseSlopes


@compiled
def projection(t: float, y: Reals, c: Reals, out: Reals) -> None:
    """Set ``out`` to (q, u) moved onto the active conditions by one Newton step for q, then one for u.

    The state after a step is off by the local error. The error of a Newton step is the square of that, so one step
    reaches round-off.
    """
    phase = PhaseData(c)
    n_q, n, state = phase.n_q, phase.n, phase.state
    if phase.active == 0:
        for i in range(n_q + n):
            out[i] = y[i]
        return
    evaluated(t, y, phase)
    closed_touched(t, y, phase)
    corrected(phase, 0)
    for i in range(n_q):
        state[i] = out[i] = y[i]
    for i in range(n):
        state[n_q + i] = phase.udot[i]
    evaluated(t, state, phase)
    for i in range(n_q):
        state[i] = out[i] = y[i] + phase.q_dot[i]
    for i in range(n):
        state[n_q + i] = y[n_q + i]
    evaluated(t, state, phase)
    closed_touched(t, state, phase)
    corrected(phase, 1)
    for i in range(n):
        out[n_q + i] = y[n_q + i] + phase.udot[i]


@compiled
def residual_of(phase: PhaseData, i: int, speeds: int) -> float:
    """Return the residual of a condition, or its rate (``speeds`` 1)."""
    k = phase.source[i]
    if k < 0:
        return phase.rate[-1 - k] if speeds != 0 else phase.residual[-1 - k]
    return rates_of(phase, k)[phase.row_of[i]] if speeds != 0 else phase.touch[phase.touch_at[k]]


@compiled
def corrected(phase: PhaseData, speeds: int) -> None:
    """Set ``udot`` to the least step that cancels the residuals of active conditions, or their rates (``speeds`` 1)."""
    rows_made(phase)
    for i in range(phase.conditions):
        phase.right[i] = -residual_of(phase, i, speeds)
    least_step(phase, speeds)


@compiled
def least_step(phase: PhaseData, speeds: int) -> None:
    """Set ``udot`` to the least step with G udot = ``right`` of the active conditions, or of those on coordinates."""
    n, w = phase.n, phase.step
    rows, size = phase.independent, phase.active
    if speeds == 0:
        rows, size = phase.holonomic, phase.holonomics
    good = independent(phase, rows, size, 0)
    for k in range(n):
        w[k] = 0.0 if good != 0 else NAN
    for a in range(size):
        x, G = phase.lam[rows[a]], phase.G[rows[a]]
        for k in range(n):
            w[k] += x * G[k]
    moved(phase, w, phase.udot)


# -- derivatives ---------------------------------------------------------------------------------------


@compiled
def corrected_state(t: float, y: Reals, c: Reals, out: Reals) -> None:
    """Set ``out`` to (q, u) moved onto the conditions of the phase, and to derivatives that keep to these.

    Along a derivative gaps and rates of closed contacts, and conditions of the machine, have no change. What they have
    by the errors of steps would grow: that of a gap, whose second derivative is kept at zero, with the square of time.
    """
    it = PhaseSlopes(c)
    phase, n_q, n = PhaseData(it.phase), it.n_q, it.n
    size = n_q + n
    projection(t, y, it.phase, out)
    for i in range(size, size + 2 + it.unknowns * size):
        out[i] = y[i]
    if phase.active == 0:
        return
    for i in range(size):
        phase.state[i] = out[i]
    evaluated(t, phase.state, phase)
    closed_touched(t, phase.state, phase)
    rows_made(phase)
    at = size + 2
    for j in range(it.unknowns):
        for speeds in range(2):
            direct(it, out, phase.udot, out[at:])
            it.rest[0] = it.shifts[j]
            for m in range(it.symbols):
                it.rest[1 + m] = it.seeds[j, m]
            keep(t, it, phase, speeds)
            if speeds != 0:
                for i in range(n):
                    out[at + n_q + i] += phase.udot[i]
                continue
            for i in range(n_q):  # q' = S u: that of a step of the speeds is S udot
                it.s[i] = 0.0
            for i in range(n):
                it.s[n_q + i] = phase.udot[i]
            for m in range(1 + it.symbols):
                it.rest[m] = 0.0
            it.machine(t, it.given, it.machine_c, it.q_dot)
            for i in range(n_q):
                out[at + i] += it.q_dot[i]
        at += size


@compiled
def keep(t: float, it: PhaseSlopes, phase: PhaseData, speeds: int) -> None:
    """Set ``udot`` to the least step that takes from a direction the change of the conditions, or of their rates."""
    for i in range(phase.closed_count):
        touch_along(t, it, phase, phase.closed[i])
    if it.own > 0:
        if speeds != 0:
            it.speeds(t, it.given, it.machine_c, it.change)
        else:
            it.residuals(t, it.given, it.machine_c, it.change)
    for i in range(phase.conditions):
        k = phase.source[i]
        if k < 0:
            phase.right[i] = -it.change[-1 - k]
        elif speeds != 0:
            phase.right[i] = -it.touch[phase.rates_at[k] + phase.row_of[i]]
        else:
            phase.right[i] = -it.touch[phase.touch_at[k]]
    least_step(phase, speeds)
