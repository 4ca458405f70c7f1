"""The loop from event to event, in compiled code. It returns to Python for what it cannot decide, and goes on there.

arrive     impacts; bounces too low to follow end; gaps and speeds are corrected
decide     modes, from the contact problem of the accelerations
set up     equations of the modes; the first moment of a slip in space
follow     steps of the integrator up to the next event
halt       the last moment of a slip in space
"""

from __future__ import annotations

import math

from ...native.instructions import compiled, lesser, run_by
from ..cones.contacts import Contacts
from ..kernels.switching import IS_STUCK, OTHER_SIDES, same
from ..ode.layout import COLLAPSED, FINISHED, RUNNING, STIFF, TERMINAL, UNDEFINED
from ..ode.run import Run
from ..phase import laws
from ..phase.phase_record import PhaseData
from . import event_run
from .decision import decide
from .event_run import EventRun
from .impacts.borne_loads import keep_loads
from .impacts.bounces import end_rest, limited, unseen
from .impacts.impacts import collide
from .impacts.rests import end_slow_slips, take_approach, take_away
from .jumps import (
    arrived,
    judge_sides,
    jumped,
    leave_idle,
    settle_sides,
    stick,
    take_crossing,
)
from .log import log_modes, log_phase, log_state, room_for_event
from .moment import approaches, choose, choose_all, copy, copy_wholes, find_closed, joined, look
from .phase_end import clear_reasons, creeps, depth, is_slow, parted, reasons
from .rings import follow_load, stand
from .setting import find_flights, lift, project, set_bands, set_up, shortest_flight
from .shares import forces_decide, forces_decided
from .slips.slip_ends import fading, halt, resolve_slips, turn_back
from .slips.slip_starts import begin_slip, shortest_turn, turned_over
from .slips.straight_steps import UPSET
from .speeds.held_phases import end_of_phase, keep_start, pass_dead_centre
from .speeds.open_cones import hold, rest_given_up, watch_cones
from .speeds.speeds import decided_by_speeds
from .ties import begin_to_leave


@compiled
def go_on(it: EventRun, run: Run, contacts: Contacts) -> int:
    """Go on with the run; return how it ended (`End`), or why Python is asked."""
    code = RUNNING
    resolve_slips(it, run)
    while code == RUNNING:
        code = pass_stage(it, run, contacts)
    return code


@compiled
def pass_stage(it: EventRun, run: Run, contacts: Contacts) -> int:
    """Pass one stage; return RUNNING, how the run ended, or why Python is asked."""
    code = RUNNING
    if it.stage != event_run.FOLLOW:
        code = ready(it, contacts)
        if code != RUNNING:
            return code
    if it.stage == event_run.ARRIVE:
        code = arrive(it)
    elif it.stage == event_run.COLLIDE:
        code = collision(it, contacts)
    elif it.stage == event_run.CORRECT:
        correct(it, contacts)
    elif it.stage == event_run.DECIDE:
        code = decision(it, contacts)
    elif it.stage == event_run.SET_UP:
        code = setting(it, contacts)
    elif it.stage == event_run.LAUNCH:
        code = launch(it, run, contacts)
    elif it.stage == event_run.FOLLOW:
        code = follow(it, run, contacts)
    else:
        code = stop_slips(it, run, contacts)
    return code


@compiled
def ready(it: EventRun, contacts: Contacts) -> int:
    """Return RUNNING if there is room for a stage at an event, with the contacts looked at, or why Python is asked."""
    if it.budget <= 0 or it.stop != 0:
        return event_run.PAUSE
    it.budget -= 1
    if room_for_event(it) == 0:
        return event_run.LONGER
    if it.stale != 0:
        look(it)
        it.stale = 0
    if 2 * it.needed + 3 > contacts.most and contacts.most < it.rows:
        return event_run.GROW
    return RUNNING


@compiled
def break_off(it: EventRun, status: int) -> None:
    """Log the phase that is interrupted, or an empty one."""
    if it.stage != event_run.FOLLOW:
        it.first_row = it.logged
    log_state(it, it.t, it.y, 0.0)
    log_phase(it, status, 0, 0, 0, event_run.STEPS)


# -- at an event -----------------------------------------------------------------------------------------


@compiled
def arrive(it: EventRun) -> int:
    """Count the events of this moment. Steps are explicit again."""
    if it.implicit != 0:
        return event_run.OTHER_METHOD
    it.creeping, PhaseData(it.phase).stopped = 0, it.slowest
    it.crowd = it.crowd + 1 if it.t - it.last <= event_run.CROWD else 0
    it.last = it.t
    for k in range(it.contacts):
        it.left[k] = it.parted[k] = 0
    find_closed(it)
    it.stage, it.resting, it.holding = event_run.COLLIDE, 0, 0
    return event_run.TOO_MANY if it.crowd > event_run.ENDLESS or it.phases > it.most_phases else RUNNING


@compiled
def collision(it: EventRun, contacts: Contacts) -> int:
    """Let approaching contacts collide."""
    status = collide(it, contacts)
    if status != 0:
        return status
    it.stage = event_run.CORRECT
    # slips begin and stop in turn: one of two events that follow each other has one
    crowded = it.crowd % event_run.CROWDED >= event_run.CROWDED - 2
    if (
        it.hit == 0
        and (crowded or it.checking != 0)
        and decided_by_speeds(it, contacts, it.target - it.t) != 0
    ):
        return RUNNING
    it.checking = 0
    if it.crowd == event_run.ENDLESS // 4 or it.crowd == event_run.ENDLESS // 2:
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
        set_up(it, contacts)
    decides = 1 if it.choice != 0 or (it.spare_count > 0 and forces_decide(it, contacts) != 0) else 0
    if decides != 0 and it.refuse != 0:
        return event_run.OPEN_FORCES
    longest, end = event_run.LONGEST, it.target
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
    return RUNNING


@compiled
def stage_after_slip(it: EventRun) -> int:
    """Return the stage after the first moment of a slip: what struck in it comes first."""
    if it.resting == 0 and approaches(it) != 0:
        return event_run.ARRIVE
    return event_run.DECIDE if turned_over(it) != 0 else it.stage


# -- a phase ---------------------------------------------------------------------------------------------


@compiled
def launch(it: EventRun, run: Run, contacts: Contacts) -> int:
    """Put the state onto the conditions and begin the steps, or go back to the event; return why Python is asked."""
    project(it)
    look(it)
    lift(it, contacts)
    end = end_of_phase(it)
    if it.resting == 0:
        if joined(it) != 0:
            it.stage = event_run.ARRIVE
            return RUNNING
        turn_back(it, contacts)
        k = fading(it, 1)
        if k >= 0:
            it.stopping[k], it.stage, it.halting = 1, event_run.HALT, 1
            return RUNNING
    elif not end > it.t:
        end_rest(it)
        return RUNNING
    if it.laws > 0 and it.resting == 0:
        why = judge_sides(it)
        if why == OTHER_SIDES:
            it.stage = event_run.DECIDE
            return RUNNING
        if why == IS_STUCK:
            return stick(it)
    if it.followed > 0:
        it.watched(it.t, it.y, it.phase, it.watch)
        if it.watch[it.followed - 1] < 0.0:  # a tie of features: the correction has decided it
            it.stage = event_run.ARRIVE
            return event_run.OTHER_PLACES
    set_bands(it)
    if jumped(it, run) != 0:
        it.first_row = it.logged
        log_state(it, it.t, it.y, 0.0)
        log_phase(it, TERMINAL, 0, 0, 0, event_run.STEPS)
        return TERMINAL
    if it.holding != 0 or it.spare_count > 0:
        keep_start(it)
    # no accelerations agree with the loads of joints; a step of the speeds has those of before
    undefined = it.loads > 0 and it.resting == 0 and is_defined(it) == 0
    if undefined and decided_by_speeds(it, contacts, end - it.t) != 0:
        return RUNNING
    if it.creeping != 0 and it.implicit == 0:
        it.pace = shortest_turn(it)
        return event_run.OTHER_METHOD
    begin_steps(it, run, end)
    return RUNNING


@compiled
def is_defined(it: EventRun) -> int:
    """Return 1 if the rates at the start of a phase are finite, else 0."""
    it.rates(it.t, it.y, it.phase, it.step)
    for i in range(it.n_y):
        if not math.isfinite(it.step[i]):
            return 0
    return 1


@compiled
def begin_steps(it: EventRun, run: Run, end: float) -> None:
    """Begin the steps of a phase."""
    phase = PhaseData(it.phase)
    set_bands(it)
    for i in range(phase.endings):  # two that fly may meet and be apart again between two points of a step
        k = it.ending[i]
        flies = phase.law[i] == laws.GAP and it.mode[k] == laws.OPEN and it.dead[k] == 0
        run.search.unjudged[it.events + i] = 0 if flies else 1
    leave_idle(it, run)
    find_flights(it)
    # half of the shortest flight: a longer step could jump over the return of a contact
    run.t, run.h, run.old_error, run.until, run.start = it.t, shortest_flight(it), 0.0, end, it.t
    turns = shortest_turn(it) if it.implicit == 0 else 0.0
    # in a longer step than this turn the rates at its start are unlike all others, and its error passes unseen
    if turns > 0.0:
        run.h = lesser(run.h, turns) if run.h > 0.0 else turns
    if it.implicit != 0:  # a long first step has other solutions: it turns slips of 1e-8 m/s anywhere
        run.h = lesser(run.h, it.pace) if run.h > 0.0 else it.pace
    run.longest = it.longest
    run.accepted = run.rejected = run.evaluated = run.events = run.blame = run.after_rejection = 0
    run.taken = run.suspect = run.calm = run.stiffness = run.sampled = 0
    copy(it.y, run.initial, it.n_y)
    it.first_row, it.stage = it.logged, event_run.FOLLOW


@compiled
def follow(it: EventRun, run: Run, contacts: Contacts) -> int:
    """Take the steps of a phase, up to its end or to the next pause."""
    if it.budget <= 0 or it.stop != 0:
        return event_run.PAUSE
    if it.logged + event_run.PIECE + 4 > it.path_room or room_for_event(it) == 0:
        return event_run.LONGER
    piece = event_run.PIECE if it.budget > event_run.PIECE else it.budget
    run.room = piece if it.steps_left > piece else it.steps_left
    status = run_by(it.piece, run)
    n, n_y, search = run.accepted, it.n_y, run.search
    for i in range(n):
        log_state(it, run.times[i], run.times[2 * n + 1 + i * n_y :], run.times[n + 1 + i])
    for e in range(run.events):
        number, way = search.log_numbers[e], search.log_signs[e]
        # the search may find a jump on both sides of a switch
        if number < it.asked and not (
            it.ways[number] == way and same(search.log_times[e], it.crossed_at[number])
        ):
            take_crossing(it, search.log_times[e], number, way, search.log_states[e])
            it.signs[number] = way
    it.steps_left -= n
    it.budget -= n
    it.t = run.times[n]
    copy(run.times[2 * n + 1 + n * n_y :], it.y, n_y)
    if status == RUNNING and it.implicit != 0 and it.creeping == 0 and is_slow(run) != 0:
        status = STIFF
    if status == RUNNING:
        crept = creeps(it, n)
        if crept != 0:
            look(it)
            if fading(it, 0) >= 0:
                it.crept = 0
                return end_phase(it, run, contacts, COLLAPSED)
        if crept > event_run.STALL:
            return event_run.STALLED
        if it.steps_left > 0:
            return RUNNING
        status = event_run.TOO_MANY_STEPS
    it.blame = run.blame
    return end_phase(it, run, contacts, status)


@compiled
def end_phase(it: EventRun, run: Run, contacts: Contacts, status: int) -> int:
    """Log a phase, and say why it ends."""
    ends = arrived(it, run)
    log_state(it, it.t, it.y, 0.0)
    kind = event_run.IMPLICIT if it.implicit != 0 else event_run.STEPS
    if status == COLLAPSED:
        look(it)
        if fading(it, 0) >= 0:  # the rest of a series, in which contacts are closed anyway, is not waited for
            it.until, status = it.t, FINISHED
            it.holding = event_run.AT_REST if it.resting == 0 else it.holding
    log_phase(it, FINISHED if status == STIFF else status, run.rejected, run.evaluated, run.stiffness, kind)
    if status == UNDEFINED and it.blame >= it.events:
        it.blame = it.ending[it.blame - it.events]
        return event_run.NO_VALUE
    wrong = depth(it, status)
    if wrong != 0:
        return wrong
    keep_loads(it)
    if parted(it) != 0:
        why = pass_dead_centre(it, contacts)
        return why if why != 0 else RUNNING
    if status == STIFF:  # the phase goes on by the other method
        it.stage, it.pace = event_run.LAUNCH, run.h if it.implicit == 0 else 0.0
        return event_run.OTHER_METHOD
    if ends != 0:
        return TERMINAL
    clear_reasons(it, event_run.NO_REASON)
    code = status
    if status == FINISHED and it.resting != 0 and it.until < it.target:
        end_rest(it)
        code = RUNNING
    elif status == FINISHED and it.holding != 0 and it.until < it.target:
        it.checking = 1 if it.holding == event_run.AT_REST else 0
        it.stage, code = event_run.ARRIVE, RUNNING
    elif status == TERMINAL:
        code = reasons(it, run)
    if it.refuse != 0 and it.spare_count > 0 and forces_decided(it, contacts) != 0:
        return event_run.OPEN_FORCES
    return code


# -- the last moment of slips ----------------------------------------------------------------------------


@compiled
def stop_slips(it: EventRun, run: Run, contacts: Contacts) -> int:
    """Pass the ends of slips in space, then go to the event; a slip that fades before a phase may go on instead."""
    if it.stage == event_run.HALTED:
        return judge(it, run, contacts)
    for k in range(it.contacts):
        if it.stopping[k] != 0:
            it.stopping[k] = 0
            changed = halt(it, contacts, k, 1)
            if changed == UPSET:
                if decided_by_speeds(it, contacts, it.target - it.t) != 0:
                    for j in range(it.contacts):
                        it.stopping[j] = 0
                    return RUNNING
                changed = halt(it, contacts, k, 0)
            if changed < 0:
                it.begun = k
                copy_wholes(it.mode, it.before, it.contacts)
                for j in range(it.contacts):
                    it.way_before[j, 0], it.way_before[j, 1] = it.way[j, 0], it.way[j, 1]
                choose(it)
                it.stage = event_run.HALTED
                return decide(it, contacts)
            if it.halting != 0 and changed == 0:
                begin_steps(it, run, end_of_phase(it))
            return RUNNING
    it.stage = event_run.ARRIVE
    return RUNNING


@compiled
def judge(it: EventRun, run: Run, contacts: Contacts) -> int:
    """Keep the state without slip if the contact sticks in it; otherwise the slip has only just begun."""
    sticks = it.mode[it.begun] == laws.STICK
    copy_wholes(it.before, it.mode, it.contacts)
    for k in range(it.contacts):
        it.way[k, 0], it.way[k, 1] = it.way_before[k, 0], it.way_before[k, 1]
    it.stage = event_run.HALT
    if sticks:
        it.impulses += it.rest_left
    else:
        copy(it.kept, it.y, it.n_y)
        look(it)
        set_up(it, contacts)  # the decision has written the equations of its own modes
        if it.halting != 0:
            begin_steps(it, run, end_of_phase(it))
    return RUNNING
