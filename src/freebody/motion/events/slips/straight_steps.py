"""Straight steps, of 1 µs at most, with the accelerations at the start, in compiled code.

They end where a contact closes.

    u(s) = u + s a,    q(s) = q + s B(q) (u + s a/2)
"""

from __future__ import annotations

from ....native.instructions import compiled, greater
from ...cones.block_rows import dot
from ...ode.layout import FINISHED
from ...phase import laws
from ...phase.contact_outputs import evaluated
from ...phase.mode_conditions import elsewhere
from ...phase.phase_record import PhaseData
from .. import event_run
from ..event_run import EventRun
from ..log import log_phase, log_state
from ..moment import copy, is_smooth, look, slip_speed

HALVINGS = 32
"""Number of halvings of a step in search of the moment at which a contact closes: 1 µs to the round-off of 1 s."""
UPSET = -2
"""Answer that a straight step would turn other slips."""


@compiled
def go_straight(it: EventRun, length: float) -> float:
    """Pass a straight step from ``start``, with the accelerations in ``step``, up to the first contact that closes.

    Return its length. A place of a patch of solids that comes is no contact yet, and ends it, too.
    """
    begun, low, high = it.t, 0.0, length
    copy(it.gap, it.apart, it.contacts)
    move_straight(it, begun, length)
    if closes(it, it.near) != 0 or loses_places(it) != 0:
        for _ in range(HALVINGS):
            move_straight(it, begun, (low + high) / 2.0)
            if closes(it, 0.0) != 0 or loses_places(it) != 0:
                high = (low + high) / 2.0
            else:
                low = (low + high) / 2.0
        move_straight(it, begun, high)
    return high


@compiled
def move_straight(it: EventRun, begun: float, length: float) -> None:
    """Set the state at this distance from ``start`` on a straight step, and look at the contacts."""
    n_q, n, machine = it.n_q, it.n, PhaseData(it.looking)
    copy(it.start, it.trial, it.n_y)
    for i in range(n):
        it.trial[n_q + i] += length * it.step[n_q + i] / 2.0
    evaluated(begun, it.trial, machine)
    for i in range(n_q):
        it.y[i] = it.start[i] + length * machine.q_dot[i]
    for i in range(n):
        it.y[n_q + i] = it.start[n_q + i] + length * it.step[n_q + i]
    it.t = begun + length
    look(it)


@compiled
def closes(it: EventRun, band: float) -> int:
    """Return 1 if an open contact, whose gap was ``apart``, has become deeper than ``band``, or a closed one has sunk;
    else 0.

    A wheel that falls flat touches at another point at the end of a step, and there strikes the floor.
    """
    phase = PhaseData(it.phase)
    for k in range(it.contacts):
        was_open = it.mode[k] == laws.OPEN and it.held[k] == 0 and it.apart[k] >= -it.near
        deep = it.gap[k] < -band and it.reach[k] >= -it.near
        if was_open and deep and elsewhere(phase, it.mode, k) == 0:
            return 1
        if it.mode[k] != laws.OPEN and it.held[k] == 0 and it.presser[k] < 0 and it.gap[k] < -it.near:
            return 1
    return 0


@compiled
def loses_places(it: EventRun) -> int:
    """Return 1 if a patch of solids has other features than its places, else 0."""
    if it.followed == 0:
        return 0
    it.watched(it.t, it.y, it.phase, it.watch)
    return 1 if it.watch[it.followed - 1] < 0.0 else 0


@compiled
def log_leap(it: EventRun, begun: float, length: float) -> None:
    """Log a straight step."""
    it.first_row = it.logged
    log_state(it, begun, it.start, length)
    log_state(it, it.t, it.y, 0.0)
    log_phase(it, FINISHED, 0, 0, 0, event_run.STRAIGHT)


@compiled
def upset(it: EventRun, own: int, length: float) -> int:
    """Return 1 if a slip in space of another contact than ``own`` would turn within a straight step, else 0.

    ``speeds`` are the accelerations. A slip that stops with the others keeps its direction.
    """
    for k in range(it.contacts):
        if k != own and it.mode[k] == laws.SLIDE and it.tangents[k] == 2 and not is_smooth(it, k):
            r, speed = it.first[k] + 1, slip_speed(it, k)
            along = dot(it.rate[r:], it.speeds[r:], 2)
            across = it.rate[r] * it.speeds[r + 1] - it.rate[r + 1] * it.speeds[r]
            turns = length * (abs(across) + greater(along, 0.0)) > speed * speed
            if it.still < speed and (turns or -along * length > 2.0 * speed * speed):
                return 1
    return 0
