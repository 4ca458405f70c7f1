"""Stages of a phase, in compiled code: its start, its steps, and the last moments of slips in space."""

from __future__ import annotations

import math

from ....native.instructions import compiled, greater, lesser, run_by
from ...cones.contacts import Contacts
from ...kernels.switching import IS_STUCK, OTHER_SIDES, same
from ...ode.layout import COLLAPSED, FINISHED, NOT_FINITE, RUNNING, STIFF, TERMINAL, UNDEFINED
from ...ode.run import Run
from ...phase import laws
from ...phase.phase_record import PhaseData
from .. import event_run, limits
from ..decision import decide
from ..event_run import EventRun
from ..impacts.borne_loads import keep_loads
from ..impacts.bounces import end_rest
from ..jumps import arrived, judge_sides, jumped, leave_idle, stick, take_crossing
from ..log import log_phase, log_state, room_for_event
from ..moment import choose_all, copy, copy_wholes, joined, largest, look
from ..rings import lands
from ..setting import find_flights, lift, project, set_bands, set_up, shortest_flight
from ..shares import forces_decided
from ..slips.slip_ends import fading, halt, turn_back
from ..slips.slip_starts import shortest_turn
from ..slips.straight_steps import UPSET
from ..speeds.held_phases import end_of_phase, keep_start, pass_dead_centre
from ..speeds.open_cones import has_open_forces
from ..speeds.speeds import decided_by_speeds
from .phase_end import clear_reasons, creeps, depth, is_slow, parted, reasons

CORRECTED = 1e-6
"""Change of the speeds as a phase begins, relative to the greatest, above which it is an impact: the lowest point of a
disk that is flat to 1e-11 m is another one after a correction of its place."""


@compiled
def speeds_moved(it: EventRun) -> float:
    """Return the greatest change of the speeds since they were kept, relative to 1 or the greatest speed."""
    change = 0.0
    for i in range(it.n_q, it.n_q + it.n):
        change = greater(change, abs(it.y[i] - it.kept[i]))
    return change / (1.0 + largest(it.y[it.n_q :], it.n))


@compiled
def launch(it: EventRun, run: Run, contacts: Contacts) -> int:
    """Put the state onto the conditions and begin the steps, or go back to the event; return why Python is asked."""
    copy(it.y, it.kept, it.n_y)
    project(it)
    look(it)
    if it.resting == 0 and it.corrected_at != it.t and speeds_moved(it) > CORRECTED:
        copy(it.kept[it.n_q :], it.y[it.n_q :], it.n)
        look(it)
        it.corrected_at, it.stage = it.t, event_run.CORRECT
        return RUNNING
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
    if it.logged + limits.PIECE + 4 > it.path_room or room_for_event(it) == 0:
        return event_run.LONGER
    # whole pieces, whatever is left of the budget, which the clock decides: implicit steps end at the end of one
    run.room = limits.PIECE if it.steps_left > limits.PIECE else it.steps_left
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
        if crept > limits.STALL:
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
        elif it.resting == 0 and lands(it, contacts) != 0:
            it.until, status, it.holding = it.t, FINISHED, event_run.BESIDE
    if status == NOT_FINITE and other_forces(it) != 0:
        it.until, status, it.holding = it.t, FINISHED, event_run.AT_REST
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


@compiled
def other_forces(it: EventRun) -> int:
    """Return 1 if a phase whose rates end has moved on by open forces: others may do so, as in a step of the speeds.

    Where forces follow from the motion their end is that of the motion, and so is a jam, in which they grow.
    """
    moved = it.t > it.times[it.first_row] and it.t - it.leapt > 2.0 * it.leap
    if not moved or it.resting != 0 or has_open_forces(it) == 0:
        return 0
    it.forces(it.times[it.first_row], it.states[it.first_row * it.n_y :], it.phase, it.speeds)
    early = largest(it.speeds, it.rows)
    it.forces(it.t, it.y, it.phase, it.speeds)
    return 1 if largest(it.speeds, it.rows) <= limits.GROWN * early else 0


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
                choose_all(it)
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
    if not sticks and it.halting != 0:
        begin_steps(it, run, end_of_phase(it))
    return RUNNING
