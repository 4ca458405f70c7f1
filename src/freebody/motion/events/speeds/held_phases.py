"""Phases that are held up to a time: rests by open forces, and the passage of a dead centre, in compiled code."""

from __future__ import annotations

from ....native.instructions import compiled, greater, lesser
from ...cones.contacts import Contacts
from ...phase import laws
from .. import event_run, limits
from ..decision import decide
from ..event_run import EventRun
from ..jumps import forget_signs
from ..moment import choose_all, copy, copy_wholes, largest, look, slip_speed

NEAR = 1e-6
"""Greatest distance of contacts that have parted, relative to 1 m or the greatest coordinate, at a place beside a dead
centre: rows there differ from those at it by its root."""


@compiled
def hold_longer(it: EventRun) -> None:
    """Hold the modes of a rest by open forces for four times as long as before, up to `HELD`."""
    it.hold = lesser(4.0 * it.hold, limits.HELD)
    it.until, it.holding, it.stage = it.t + it.hold, event_run.AT_REST, event_run.SET_UP


@compiled
def keep_start(it: EventRun) -> None:
    """Keep state and log at the start of a phase that is held."""
    copy(it.y, it.held_state, it.n_y)
    it.held_from, it.held_work, it.held_phases = it.t, it.impulses, it.phases
    it.held_marks, it.held_numbers, it.held_rows = it.marked, it.numbered, it.logged


@compiled
def go_back(it: EventRun) -> None:
    """Go back to the start of the last phase."""
    copy(it.held_state, it.y, it.n_y)
    it.t, it.impulses, it.phases = it.held_from, it.held_work, it.held_phases
    it.marked, it.numbered, it.logged = it.held_marks, it.held_numbers, it.held_rows
    forget_signs(it)
    look(it)


@compiled
def hold_shorter(it: EventRun, part: float) -> None:
    """Go back to the start of a phase that was held too long, and hold it for a part of that time."""
    go_back(it)
    it.hold = greater(it.hold / part, limits.LONGEST)
    it.until, it.holding, it.leapt = it.t + it.hold, event_run.AT_REST, it.t
    it.stage = event_run.LAUNCH


@compiled
def pass_dead_centre(it: EventRun, contacts: Contacts) -> int:
    """Begin a phase anew that closed contacts have left (`parted`), with the modes of a place beside its start.

    Forces near a dead centre grow beyond all limits, and modes at it are the limit of those beside it. These are found
    where conditions have parted a little, at the speeds of the start, and hold to there. Return 0, or why there are
    none.
    """
    it.hold = it.t - it.held_from
    if distance_parted(it) > NEAR * (1.0 + largest(it.y, it.n_q)):
        hold_shorter(it, 2.0)
        return 0 if it.hold > limits.LONGEST else event_run.PARTED
    copy_wholes(it.mode, it.before, it.contacts)
    copy(it.held_state[it.n_q :], it.y[it.n_q :], it.n)
    look(it)
    for k in range(it.contacts):
        it.closed[k] = 1 if it.before[k] != laws.OPEN else 0
    choose_all(it)
    why, changed = decide(it, contacts), 0
    go_back(it)
    for k in range(it.contacts):
        changed += 1 if it.mode[k] != it.before[k] else 0
    it.until, it.holding, it.stage = it.t + it.hold, event_run.BESIDE, event_run.SET_UP
    if why == 0 and changed == 0:
        return event_run.PARTED
    return why


@compiled
def distance_parted(it: EventRun) -> float:
    """Return the largest distance by which a closed contact has left its conditions in the last phase."""
    result, time = 0.0, it.t - it.held_from
    for k in range(it.contacts):
        if it.mode[k] != laws.OPEN and it.held[k] == 0 and it.presser[k] < 0:
            result = greater(result, abs(it.gap[k]))
        if it.mode[k] == laws.STICK:
            result = greater(result, time * slip_speed(it, k))
    return result


@compiled
def end_of_phase(it: EventRun) -> float:
    """Return the time at which a phase ends if no event ends it."""
    return lesser(it.until, it.target) if it.resting != 0 or it.holding != 0 else it.target
