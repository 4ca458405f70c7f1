"""Why a phase ends, in compiled code: an ending of a mode, a contact that was passed over, steps that do not move on.

Friction of a slow slip in space is stiff. The direction of a slip of the speed v follows the load at the rate
λ = μ N / (m v). From rest, where μ_s N is reached, v grows from zero with the square of time, and explicit steps,
h < 6/λ, are thousands. Implicit ones grow with v.
"""

from __future__ import annotations

import math

from ....native.instructions import compiled, lesser, root
from ...ode.layout import RUNNING, TERMINAL
from ...ode.run import Newton, Run
from ...phase import laws
from ...phase.phase_record import PhaseData
from .. import event_run, limits
from ..event_run import EventRun
from ..jumps import switch_laws
from ..moment import copy, largest, look, slip_speed

TURNS = 8
"""Number of turns of the power method: the fastest rate of stiff friction is far above the next."""
STABLE = 12.0
"""h λ up to which explicit steps cost less: those of `dop853` are stable up to 6, and take half the evaluations."""


@compiled
def is_slow(run: Run) -> int:
    """Return 1 if the present implicit steps are short enough for an explicit method, else 0.

    λ is the greatest eigenvalue of the derivative of the rates, by the power method.
    """
    own, n, x, y = Newton(run.own), run.n, run.argument, run.error3
    for i in range(n):
        x[i] = 1.0
    fastest = 0.0
    for _ in range(TURNS):
        size = largest(x, n)
        if not size > 0.0:
            return 1
        for i in range(n):
            y[i] = 0.0
        for k in range(n):
            for i in range(n):
                y[i] += own.J[k, i] * x[k] / size
        fastest = largest(y, n)
        for i in range(n):
            x[i] = y[i]
    return 1 if abs(run.h) * fastest < STABLE else 0


@compiled
def creeps(it: EventRun, steps: int) -> int:
    """Return the number of steps in which the run has hardly moved on, 0 if it is small."""
    it.crept += steps
    if not it.t - it.crept_from <= limits.STALL_TIME:
        it.crept, it.crept_from = 0, it.t
    return it.crept if it.crept > limits.CREEPS else 0


@compiled
def depth(it: EventRun, status: int) -> int:
    """Return a code if a closing or a reversal of slip was passed over: a contact is deep or slips back; else 0.

    So is an event whose state is not finite, between states that are.
    """
    for i in range(it.n_y):
        if not math.isfinite(it.y[i]):
            return event_run.NO_STATE if status == TERMINAL else 0
    look(it)
    near, slow, first = it.near, 1e3 * it.still, it.first_row
    for k in range(it.contacts):
        v = it.rate[it.first[k] + 1] if it.mode[k] == laws.SLIDE_ON or it.mode[k] == laws.SLIDE_BACK else 0.0
        if (v < -slow and it.mode[k] == laws.SLIDE_ON) or (v > slow and it.mode[k] == laws.SLIDE_BACK):
            it.blame = k
            return event_run.TURNED
    for k in range(it.contacts):
        alone = it.presser[k] < 0 and it.mode[k] == laws.OPEN
        if it.gap[k] < -near and it.reach[k] > 0.0 and alone and it.times[first] < it.t:
            t, gap, pressing = it.t, it.gap[k], it.given[k]
            copy(it.y, it.kept, it.n_y)
            it.t = it.times[first]
            copy(it.states[first * it.n_y :], it.y, it.n_y)
            look(it)
            behind = it.gap[k] < -near and math.isfinite(it.reach[k])  # came around its end
            deeper = gap < lesser(it.gap[k], 0.0) - near and (it.compliant[k] == 0 or pressing > 0.0)
            wrong = it.reach[k] > 0.0 and deeper and not behind
            it.t = t
            copy(it.kept, it.y, it.n_y)
            look(it)
            if wrong:
                it.blame = k
                return event_run.PASSED_OVER
    return 0


@compiled
def parted(it: EventRun) -> int:
    """Return 1 if a closed contact has left its conditions, which followed from the others as the phase began; else 0.

    At a dead centre rows depend on each other at one position only. At rest there, no acceleration shows it (`parts`):
    the gap of such a contact changes with the fourth power of time.
    """
    if it.spare_count == 0:
        return 0
    slow = 1e3 * it.still
    for k in range(it.contacts):
        if it.mode[k] != laws.OPEN:
            rigid = it.held[k] == 0 and it.presser[k] < 0
            if (rigid and abs(it.gap[k]) > it.near) or (
                it.mode[k] == laws.STICK and slip_speed(it, k) > slow
            ):
                it.blame = k
                return 1
    return 0


@compiled
def reasons(it: EventRun, run: Run) -> int:
    """Note why the modes end; return TERMINAL if the user's event ends the run, STRUCK for a blow, else RUNNING.

    OTHER_PLACES, if a contact closes beside patches: a corner that passes the side of a face has no gap there, and no
    place. Only the state of the event shows that, to a part of the integrator's accuracy.
    """
    search, called, closes, phase = run.search, 0, 0, PhaseData(it.phase)
    for e in range(run.events):
        number = search.log_numbers[e]
        if number < it.events and search.log_times[e] == it.t:
            if number < it.asked and it.final[number] != 0:
                return TERMINAL
            if number >= it.asked and not it.first_law <= number < it.first_law + it.laws:
                called = 1
    if called != 0:
        clear_reasons(it, event_run.BLOW)
    for turn in range(2):  # at the end of a side N may reach 0 too: the reason is the end
        for e in range(run.events):
            i = search.log_numbers[e] - it.events
            if i >= 0:
                law = phase.law[i]
                if (turn == 0) == (law == laws.NORMAL):
                    set_reason(it, i, law)
                if law == laws.GAP and it.followed > 0:
                    closes = 1
    if it.laws > 0 and switch_laws(it, run) != 0:
        for k in range(it.contacts):
            if it.reason[k] == event_run.NO_REASON:
                it.reason[k] = event_run.SWITCHED
    it.stage, it.halting = event_run.HALT, 0
    if called != 0:
        return event_run.STRUCK
    return event_run.OTHER_PLACES if closes != 0 else RUNNING


@compiled
def set_reason(it: EventRun, i: int, law: int) -> None:
    """Note why the mode of the contact of an ending ends."""
    k, why = it.ending[i], event_run.SLIP_STOPPED
    if law == laws.GAP or law == laws.PRESS:
        why = event_run.GAP_CLOSED
    elif law == laws.NORMAL or law == laws.RELEASE:
        why = event_run.NORMAL_ZERO
    elif law == laws.REACH:
        why = event_run.END_OF_SIDE
    elif law == laws.SIDE:
        why = event_run.ONTO_SIDE
    elif law == laws.LINE_CONE or law == laws.CONE or law == laws.YIELD:
        # N of a compliant contact falls to zero at its surface, and with it the limit of friction
        surfaced = it.compliant[k] != 0 and it.gap[k] >= -it.near
        why = event_run.NORMAL_ZERO if surfaced else event_run.CONE_REACHED
        it.forces(it.t, it.y, it.phase, it.speeds)
        square = 0.0
        for j in range(it.tangents[k]):
            square += it.speeds[it.first[k] + 1 + j] * it.speeds[it.first[k] + 1 + j]
        it.measure[k] = root(square)
    it.reason[k] = why
    # the corner takes over from its side, or the side from the corner
    if law == laws.REACH or law == laws.SIDE:
        for j in range(it.contacts):
            if it.side[j] == k and it.end_of[j] == it.place[i]:
                it.reason[j] = why
    # a slip along a line stops at a time that is known to its round-off, in which a great force turns it back
    if law == laws.STOP or (law == laws.LINE_STOP and abs(it.rate[it.first[k] + 1]) > it.still):
        it.stopping[k] = 1


@compiled
def clear_reasons(it: EventRun, reason: int) -> None:
    """Give every contact the same reason."""
    for k in range(it.contacts):
        it.reason[k] = reason
