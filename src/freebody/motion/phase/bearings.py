"""The forces of closed contacts together with the loads of joints that bound their friction, in compiled code.

The friction of a slip is -μ P d, with P = r (|F_a| + |F_b|) of the reactions, which this friction changes:

    P = r (|F_a(P)| + |F_b(P)|)

The forces are affine in P. Each pass solves for the motion at P and takes P from its reactions. Where the right side
changes by less than P does, there is one solution, and the passes lead to it from P = 0 by Banach's theorem; where they
do not come to it, the joint jams under its own friction (Painlevé).
"""

from __future__ import annotations

from ...native.instructions import EPS, Reals, compiled, greater, root
from .closed_contacts import NAN, balance
from .contact_outputs import closed_touched, evaluated, extended, force_of
from .phase_record import PhaseData
from .slopes_record import PhaseSlopes

PASSES = 2000
"""Passes after which loads are not found: those that shrink by less than a fiftieth each."""
SAME, NEARLY = 4.0 * EPS, 1e-9
"""Changes of a load, relative to the greatest, that are round-off: at once, and if they do not shrink any more."""


@compiled
def solve(t: float, y: Reals, phase: PhaseData) -> int:
    """Set accelerations, contact forces and multipliers; return 0 if they are not found, else 1.

    A condition may have lost its independence, or a joint may jam.
    """
    evaluated(t, y, phase)
    closed_touched(t, y, phase)
    if phase.loaded_count == 0:
        return balance(phase)
    for i in range(phase.n):
        phase.unloaded[i] = phase.free[i]
    for j in range(phase.loaded_count):
        phase.pressure[phase.loaded[j]] = 0.0
    extended(y, phase)
    last = 1.0
    for _ in range(PASSES):
        for i in range(phase.n):
            phase.free[i] = phase.unloaded[i]
        if balance(phase) == 0:
            return 0
        change = bear(t, phase)
        if change <= SAME or NEARLY >= change >= last:
            return 1
        last = change
    for j in range(phase.loaded_count):  # it grows by its own friction
        force_of(phase, phase.loaded[j])[0] = NAN
    return 0


@compiled
def solve_once(t: float, y: Reals, phase: PhaseData) -> None:
    """Do what :func:`solve` does, unless the rates at this very state have been asked for last.

    The end of a step is such a state. The parameters may change after this look at it.
    """
    known = phase.solved != 0 and t == phase.solved_t
    for i in range(phase.n_q + phase.n):
        known = known and y[i] == phase.solved_y[i]
    if not known:
        solve(t, y, phase)
    phase.solved = 0


@compiled
def load_of(bearing: Reals, j: int) -> float:
    """Return r (|F_a| + |F_b|) of a joint."""
    F = bearing[7 * j :]
    return F[0] * (
        root(F[1] * F[1] + F[2] * F[2] + F[3] * F[3]) + root(F[4] * F[4] + F[5] * F[5] + F[6] * F[6])
    )


@compiled
def bear(t: float, phase: PhaseData) -> float:
    """Set the loads to those of the present forces; return their greatest change, relative to the greatest load."""
    change, most = 0.0, 0.0
    phase.bearings(t, phase.state, phase.bearings_c, phase.bearing)
    for j in range(phase.loaded_count):
        k, load = phase.loaded[j], load_of(phase.bearing, j)
        change, most = greater(change, abs(load - phase.pressure[k])), greater(most, load)
        phase.pressure[k] = load
        force_of(phase, k)[0] = load
    return change / most if most > 0.0 else 0.0


@compiled
def loads_along(t: float, it: PhaseSlopes, phase: PhaseData, out: Reals) -> None:
    """Set ``out`` to the derivatives of the loads of joints by the present ones of accelerations and forces."""
    at, first, size = it.n_q + it.n, it.n + it.rows, it.n + it.rows + it.all_own
    acting, direction = it.borne[at:], it.borne[at + size :]
    for i in range(at):
        it.borne[i] = it.given[i]
    for i in range(at + 1 + it.symbols):  # τ and dp follow s
        direction[i] = it.s[i]
    for i in range(it.n):
        acting[i], it.ways[i] = phase.udot[i], it.udot[i]
    for i in range(it.rows):
        acting[it.n + i], it.ways[it.n + i] = phase.force[i], it.force[i]
    for i in range(it.all_own):
        acting[first + i], it.ways[first + i] = phase.multiplier[i], it.multiplier[i]
    it.bearings(t, it.borne, it.bearings_c, it.bearing)
    for j in range(phase.loaded_count):
        F, dF, load = it.bearing[14 * j :], it.bearing[14 * j + 7 :], 0.0
        for place in range(2):
            square, along = 0.0, 0.0
            for i in range(1 + 3 * place, 4 + 3 * place):
                square += F[i] * F[i]
                along += F[i] * dF[i]
            if square > 0.0:
                load += dF[0] * root(square) + F[0] * along / root(square)
        out[j] = load
