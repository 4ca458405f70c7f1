"""The forces of closed contacts together with the loads of joints that bound their friction, in compiled code.

The friction of a slip is -μ P d, with P = r (|F_a| + |F_b|) of the reactions, which this friction changes:

    P = r (|F_a(P)| + |F_b(P)|)

The forces are affine in P, so that the right side is convex. Newton's method from P = 0 comes to the least solution:
that which friction has as its coefficient grows from zero. Where there is none, the joint jams under its own friction
(Painlevé). Shares of open forces are no affine functions of P, and jump at zero: there each pass takes the right side.
"""

from __future__ import annotations

from ...dynamics.bearing_loads import LOADED
from ...native.instructions import EPS, Reals, compiled, greater, root
from ..cones.block_rows import root_of
from ..cones.elimination import solved
from .closed_contacts import balance
from .conditions import NAN
from .contact_outputs import closed_touched, evaluated, extended, force_of
from .equal_shares import is_independent
from .phase_record import PhaseData
from .slopes_record import PhaseSlopes

TURNS, PASSES = 50, 2000
"""Steps of Newton's method, and passes after which loads are not found: those that shrink by less than a fiftieth each.
"""
SAME, NEARLY = 4.0 * EPS, 1e-9
"""Changes of a load, relative to the greatest, that are round-off: at once, and if they do not shrink any more.

The second holds also relative to the parts of loads that cancel.
"""


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
        phase.loads[j] = 0.0
    extended(y, phase)
    if loaded(t, phase) == 0:
        return 0
    last, change = 1.0, missed(phase)
    if change > 0.0 and differ(t, phase) == 0:
        return 0
    for _ in range(PASSES):
        if change <= SAME or NEARLY >= change >= last:
            return 1
        if change >= last and is_round_off(t, phase, change) != 0:
            return 1
        last = change
        newton(phase)
        if loaded(t, phase) == 0:
            return 0
        change = missed(phase)
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
def loaded(t: float, phase: PhaseData) -> int:
    """Set the motion at ``loads``, and ``at_loads`` to its bearings; return 0 if it is not found, else 1."""
    for i in range(phase.n):
        phase.free[i] = phase.unloaded[i]
    for j in range(phase.loaded_count):
        phase.pressure[phase.loaded[j]] = phase.loads[j]
    good = balance(phase)
    phase.bearings(t, phase.state, phase.bearings_c, phase.at_loads)
    return good


@compiled
def load_of(bearing: Reals, j: int) -> float:
    """Return r (|F_a| + |F_b|) of a joint."""
    F = bearing[LOADED * j :]
    return F[0] * (
        root(F[1] * F[1] + F[2] * F[2] + F[3] * F[3]) + root(F[4] * F[4] + F[5] * F[5] + F[6] * F[6])
    )


@compiled
def missed(phase: PhaseData) -> float:
    """Note the loads of the motion; return by how much ``loads`` differ, relative to the greatest load."""
    change, most = 0.0, 0.0
    for j in range(phase.loaded_count):
        load = load_of(phase.at_loads, j)
        change, most = greater(change, abs(load - phase.loads[j])), greater(most, load)
        force_of(phase, phase.loaded[j])[0] = load
    return change / most if most > 0.0 else 0.0


@compiled
def is_round_off(t: float, phase: PhaseData, change: float) -> int:
    """Return 1 if loads that differ by this part of the greatest one are the round-off of their parts, else 0.

    Reactions that cancel, as in a joint of two bodies of which each lies on the floor, have that of their parts: what
    they are without accelerations and contact forces, and these forces.
    """
    most, part, force = 0.0, 0.0, 0.0
    for r in range(phase.rows):
        force = greater(force, abs(phase.force[r]))
    for j in range(phase.loaded_count):
        most = greater(most, load_of(phase.at_loads, j))
        part = greater(part, force * phase.at_loads[LOADED * j])
    for i in range(phase.n + phase.rows + phase.all_own):
        phase.state[phase.n_q + phase.n + i] = 0.0
    phase.bearings(t, phase.state, phase.bearings_c, phase.at_loads)
    for j in range(phase.loaded_count):
        part = greater(part, load_of(phase.at_loads, j))
    loaded(t, phase)
    missed(phase)
    return 1 if change * most <= NEARLY * part else 0


@compiled
def differ(t: float, phase: PhaseData) -> int:
    """Set ``per_load`` by the motions at each load alone, beside that without; return 0 if one is not found, else 1.

    It is zero where forces beside these joints are open.
    """
    size, count, first, is_open = 0.0, phase.loaded_count, phase.bearing, bear_shares(phase) != 0
    for i in range(LOADED * count):
        first[i] = phase.at_loads[i]
    for j in range(count):
        size = greater(size, load_of(first, j))
    for j in range(count):
        if not is_open:
            phase.loads[j] = size
            if loaded(t, phase) == 0:
                return 0
            phase.loads[j] = 0.0
        for i in range(LOADED * count):
            phase.per_load[j, i] = 0.0 if is_open else (phase.at_loads[i] - first[i]) / size
    for i in range(LOADED * count):
        phase.at_loads[i] = first[i]
    return 1


@compiled
def bear_shares(phase: PhaseData) -> int:
    """Return 1 if forces are open in an island of a joint with a load, so that it bears shares of them, else 0."""
    for j in range(2 * phase.loaded_count):
        b = phase.beside_of[2 * phase.loaded[j // 2] + j % 2]
        island = phase.number_of[root_of(phase.parent, b)]
        if island >= 0 and is_independent(phase, island) == 0:
            return 1
    return 0


@compiled
def newton(phase: PhaseData) -> None:
    """Move ``loads`` to P = r (|F_a| + |F_b|) of forces that are affine in P, and ``at_loads`` with them."""
    F, A, b, count = phase.at_loads, phase.newton, phase.newton_step, phase.loaded_count
    for _ in range(TURNS):
        for j in range(count):
            b[j] = load_of(F, j) - phase.loads[j]
            for k in range(count):
                A[j * count + k] = (1.0 if j == k else 0.0) - change_of(F, phase.per_load[k], j)
        if solved(A, count, b) == 0:
            return
        size, most = 0.0, 0.0
        for j in range(count):
            step = greater(b[j], -phase.loads[j])
            phase.loads[j] += step
            size, most = greater(size, abs(step)), greater(most, phase.loads[j])
            for i in range(LOADED * count):
                if i % LOADED != 0:  # the first of each is its lever
                    F[i] += step * phase.per_load[j, i]
        if not size > EPS * most:
            return


@compiled
def change_of(bearing: Reals, change: Reals, j: int) -> float:
    """Return the derivative of a load by that of its forces."""
    result, F, dF = 0.0, bearing[LOADED * j :], change[LOADED * j :]
    for place in range(2):
        square, along = 0.0, 0.0
        for i in range(1 + 3 * place, 4 + 3 * place):
            square += F[i] * F[i]
            along += F[i] * dF[i]
        if square > 0.0:
            result += F[0] * along / root(square)
    return result


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
        F, dF = it.bearing[2 * LOADED * j :], it.bearing[(2 * j + 1) * LOADED :]
        out[j] = change_of(F, dF, 0) + dF[0] * load_of(F, 0) / F[0]
