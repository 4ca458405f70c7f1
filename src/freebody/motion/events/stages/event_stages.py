"""Stages at an event, in compiled code: arrive, collide, correct, decide, set up."""

from __future__ import annotations

from ....native.instructions import compiled, lesser
from ...cones.contacts import Contacts
from ...ode.layout import FINISHED, RUNNING
from ...phase import laws
from ...phase.phase_record import PhaseData
from .. import event_run, limits
from ..decision import decide
from ..event_run import EventRun
from ..impacts.bounces import limited, unseen
from ..impacts.impacts import collide
from ..impacts.rests import end_slow_slips, take_approach, take_away
from ..jumps import settle_sides
from ..log import log_modes, log_phase, log_state
from ..moment import approaches, choose_all, copy_wholes, find_closed, joined, look
from ..rings import follow_load, stand
from ..setting import find_flights, lift, set_up, shortest_flight
from ..shares import forces_decide, leave_pulling
from ..slips.slip_starts import begin_slip, turned_over
from ..slips.straight_steps import UPSET
from ..speeds.held_phases import end_of_phase
from ..speeds.open_cones import hold, rest_given_up, watch_cones
from ..speeds.speeds import decided_by_speeds
from ..ties import begin_to_leave
from .phase_end import clear_reasons


@compiled
def arrive(it: EventRun) -> int:
    """Count the events of this moment. Steps are explicit again."""
    if it.implicit != 0:
        return event_run.OTHER_METHOD
    it.creeping, PhaseData(it.phase).stopped = 0, it.slowest
    it.crowd = it.crowd + 1 if it.t - it.last <= limits.CROWD else 0
    it.last = it.t
    for k in range(it.contacts):
        it.left[k] = it.parted[k] = 0
    find_closed(it)
    it.stage, it.resting, it.holding = event_run.COLLIDE, 0, 0
    return event_run.TOO_MANY if it.crowd > limits.ENDLESS or it.phases > it.most_phases else RUNNING


@compiled
def collision(it: EventRun, contacts: Contacts) -> int:
    """Let approaching contacts collide."""
    status = collide(it, contacts)
    if status != 0:
        return status
    it.stage = event_run.CORRECT
    # slips begin and stop in turn: one of two events that follow each other has one
    crowded = it.crowd % limits.CROWDED >= limits.CROWDED - 2
    if (
        it.hit == 0
        and (crowded or it.checking != 0)
        and decided_by_speeds(it, contacts, it.target - it.t) != 0
    ):
        return RUNNING
    it.checking = 0
    if it.crowd == limits.ENDLESS // 4 or it.crowd == limits.ENDLESS // 2:
        end_slow_slips(it, contacts)
    return event_run.OPEN_IMPULSES if it.hit != 0 and it.refuse != 0 and it.open != 0 else RUNNING


@compiled
def correct(it: EventRun, contacts: Contacts) -> None:
    """Correct gaps and speeds, unless a correction closes further contacts."""
    if it.resting == 0:
        lift(it, contacts)
    if joined(it) != 0:
        if it.resting != 0:
            it.bounces = 0
            clear_reasons(it, event_run.NO_REASON)
        it.stage = event_run.ARRIVE
    else:
        take_approach(it, contacts)
        it.stage = event_run.DECIDE


@compiled
def decision(it: EventRun, contacts: Contacts) -> int:
    """Find the modes, again where contacts at rest at the end of their side begin to leave it."""
    if it.rings > 0 and it.hit == 0:
        follow_load(it)
    settle_sides(it)
    if it.stale != 0:
        look(it)
        it.stale = 0
    choose_all(it)
    it.stage = event_run.SET_UP
    why = decide(it, contacts)
    if why == 0 and it.rings > 0:
        why = stand(it, contacts)
    if why != 0:
        return why
    if begin_to_leave(it) != 0:  # from now on the corner touches
        it.stage, it.stale = event_run.DECIDE, 1
    return RUNNING


@compiled
def settle(it: EventRun, contacts: Contacts) -> int:
    """End bounces that are too low to follow, or to tell from round-off; return 1 if there are any, else 0.

    The contacts of a series stay closed for the time that it takes.
    """
    find_flights(it)
    if it.resting != 0:
        return 0
    if limited(it) != 0:
        copy_wholes(it.taking, it.resters, it.contacts)
        it.resting, it.until, it.stage = 1, it.t + it.rest_left, event_run.CORRECT
    elif unseen(it) > 0:
        it.bounces, it.stage = 0, event_run.ARRIVE
    else:
        return 0
    take_away(it, contacts)
    return 1


@compiled
def setting(it: EventRun, contacts: Contacts) -> int:
    """Write the equations of the modes, log their changes, and pass the first moment of a slip in space."""
    set_up(it, contacts)
    if settle(it, contacts) != 0 or rest_given_up(it) != 0:
        return RUNNING
    if it.holding == 0 and it.creeping == 0 and hold(it, contacts) != 0:
        if it.refuse != 0:
            return event_run.UNDECIDED
        # friction of a fixed direction would move the body, where open forces hold it
        if it.resting == 0 and decided_by_speeds(it, contacts, it.target - it.t) != 0:
            return RUNNING
        stick_in_series(it, contacts)
    decides = 1 if it.choice != 0 or (it.spare_count > 0 and forces_decide(it, contacts) != 0) else 0
    if decides != 0 and it.refuse != 0:
        return event_run.OPEN_FORCES
    longest, end = limits.LONGEST, it.target
    if it.holding == event_run.AT_REST:
        watch_cones(it, contacts)
    if it.resting != 0:
        end = end_of_phase(it)
        clear_reasons(it, event_run.NO_REASON)
        for k in range(it.contacts):
            if it.resters[k] != 0:
                it.reason[k] = event_run.BOUNCES_BELOW
        log_modes(it, 1, decides)
    else:
        log_modes(it, it.hit, decides)
        if it.t >= it.target:
            it.first_row = it.logged
            log_state(it, it.t, it.y, 0.0)
            log_phase(it, FINISHED, 0, 0, 0, event_run.STEPS)
            return FINISHED
        flight = shortest_flight(it)  # a straight step beyond it would lose its impact
        longest = lesser(longest, flight) if flight > 0.0 else longest
    it.stage = event_run.LAUNCH
    changed = begin_slip(it, contacts, end, longest, 1)
    if changed < 0 and it.resting == 0 and decided_by_speeds(it, contacts, end - it.t) != 0:
        return RUNNING
    if changed == UPSET:
        changed = begin_slip(it, contacts, end, longest, 0)
    if changed > 0:
        if it.resting == 0 and it.t >= it.target:
            return FINISHED
        it.stage = stage_after_slip(it)
        set_up(it, contacts)
        share_again(it, contacts, decides)
    return RUNNING


@compiled
def stick_in_series(it: EventRun, contacts: Contacts) -> None:
    """Let what is at its limit stick while bounces end, which no step of the speeds follows, if open forces hold it.

    Friction of a fixed direction leaves a contact free across it, which the others hold only along it.
    """
    copy_wholes(it.mode, it.before, it.contacts)
    for k in range(it.contacts):
        if it.resting != 0 and it.mode[k] == laws.LIMIT:
            it.mode[k] = laws.STICK
    set_up(it, contacts)
    if it.spare_count == 0 or forces_decide(it, contacts) != 0:
        copy_wholes(it.before, it.mode, it.contacts)
        set_up(it, contacts)


@compiled
def share_again(it: EventRun, contacts: Contacts, decides: int) -> None:
    """Open the contacts whose shares of open forces pull, now that slips have directions."""
    if it.stage == event_run.LAUNCH and it.spare_count > 0:
        choose_all(it)
        leave_pulling(it, contacts)
        log_modes(it, 1 if it.resting != 0 else it.hit, decides)


@compiled
def stage_after_slip(it: EventRun) -> int:
    """Return the stage after the first moment of a slip: what struck in it comes first."""
    if it.resting == 0 and approaches(it) != 0:
        return event_run.ARRIVE
    return event_run.DECIDE if turned_over(it) != 0 else it.stage
