"""The projection of a state onto the conditions of a phase, in compiled code."""

from __future__ import annotations

from ...native.instructions import Reals, compiled
from .closed_contacts import NAN, independent, rows_made
from .contact_outputs import closed_touched, evaluated, moved, rates_of
from .phase_record import PhaseData


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
    n, w = phase.n, phase.step
    rows_made(phase)
    for i in range(phase.conditions):
        phase.right[i] = -residual_of(phase, i, speeds)
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
