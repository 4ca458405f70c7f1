"""A live motion with contacts in compiled code: the loop from event to event, with frames of each phase.

`events.event_loop` passes one stage after another. After each piece of a phase its frames are computed, since the
equations of a phase are data that the next phase overwrites. If there are too many frames, every second one is left
out, except at the ends of phases, and later pieces have half as many.
"""

from __future__ import annotations

from ...native.instructions import address_of, compiled, whole
from ..cones.contacts import Contacts
from ..events import event_run, limits
from ..events.event_loop import pass_stage
from ..events.event_run import EventRun
from ..events.jumps import forget_signs, take_sides
from ..events.moment import copy, look
from ..events.slips.slip_ends import resolve_slips
from ..kernels.hoisted import Hoisted
from ..kernels.renewal import renew
from ..kernels.sided_run import SidedRun
from ..kernels.switching import reset
from ..ode import dop853
from ..ode.layout import RUNNING
from .memory import DEEP, TOO_MANY_PHASES, Live

sample = dop853.FUNCTIONS["sample"]

FRAMES_OF_STEP, FEWEST = 4, 200
"""Frames of a step, and of a whole motion at equal distances of time, which are added."""


@compiled
def run_from_event_to_event(live: Live) -> int:
    """Run, and compute the frames; return how it ended: `End`, a reason of `event_run`, or one of `memory`."""
    it, contacts = EventRun(live.touching.run), Contacts(live.touching.problem)
    begin(live, it)
    resolve_slips(it, live.run)
    code = RUNNING
    for k in range(it.contacts):
        if it.gap[k] < -it.near and it.reach[k] >= 0.0:
            live.blame, code = k, DEEP
    fresh = 0
    while code == RUNNING:
        follows, before = it.stage == event_run.FOLLOW, it.marked
        if it.laws > 0 and follows:
            copy(SidedRun(it.sided).sides, live.touching.sides, it.laws)
        code = pass_stage(it, live.run, contacts)
        if follows and code != event_run.LONGER:
            if show(live, it, fresh) == 0:
                code = TOO_MANY_PHASES
            fresh = 0
        elif it.stage == event_run.FOLLOW:
            fresh = 1
        if code == event_run.LONGER and before > 0:
            note_events(live, it)
            forget(it)
            code = RUNNING
    note_events(live, it)
    live.reached = it.t
    if code != DEEP:
        live.blame = it.blame
    return code


@compiled
def forget(it: EventRun) -> None:
    """Empty the log, but keep the first row of a phase that goes on."""
    it.marked = it.numbered = 0
    if it.stage != event_run.FOLLOW:
        it.logged = it.first_row = 0
    elif it.logged > it.first_row + 1:
        it.logged = it.first_row + 1


@compiled
def begin(live: Live, it: EventRun) -> None:
    """Set the run to its start."""
    hold, run = live.touching, live.run
    copy(hold.fresh if hold.kept != 0 else hold.run, hold.run if hold.kept != 0 else hold.fresh, hold.n_fresh)
    hold.kept = 1
    aim(live, it)
    if it.laws > 0:
        reset(SidedRun(it.sided), live.start, live.until)
    take_sides(it)
    hold.fades = 0
    it.t, it.target = live.start, live.until
    copy(run.initial, it.y, it.n_y)
    it.steps_left, it.budget = live.most_steps, limits.NO_PAUSE
    forget_signs(it)
    look(it)


@compiled
def aim(live: Live, it: EventRun) -> None:
    """Let the constants of the kernels follow the parameters where the functions of phases read them.

    Points of disks that lie flat are where they are at first.
    """
    hoisted, hold = Hoisted(it.hoisted), live.touching
    for i in range(it.rings):
        hoisted.parameters[it.ring_at[i]], hoisted.parameters[it.ring_at[i] + 1] = 1.0, 0.0
    k = hoisted.programs
    for i in range(hold.n_of_phase):
        hoisted.prologues[k], hoisted.places[k] = live.prologue, address_of(hold.phase[hold.of_phase[i] :])
        k += 1
    for i in range(hold.n_of_looking):
        hoisted.prologues[k] = live.prologue
        hoisted.places[k] = address_of(hold.looking[hold.of_looking[i] :])
        k += 1
    hoisted.programs = k


@compiled
def show(live: Live, it: EventRun, fresh: int) -> int:
    """Compute the frames and note the events of a piece of a phase, the first one if it is ``fresh``.

    Return 1; or 0 if there is no room for another phase.
    """
    run, hold = live.run, live.touching
    n = run.accepted
    live.steps += n
    live.rejected, live.evaluated = live.rejected + run.rejected, live.evaluated + run.evaluated
    run.rejected = run.evaluated = 0
    note_events(live, it)
    forget(it)
    if n == 0:
        return 1
    if fresh != 0 and new_phase(live, it) == 0:
        return 0
    first, last = run.times[0], run.times[n]
    count = frames_of_piece(live, n, last - first)
    while live.frames + count + 1 > live.most_frames and hold.fades < 60:
        thin(live)
        count = frames_of_piece(live, n, last - first)
    if live.frames + count + 1 > live.most_frames:
        return 0
    at, skipped = live.frames, 0 if fresh != 0 else 1
    for k in range(skipped, count + 1):
        live.times[at + k - skipped] = first + k / count * (last - first)
    live.frames += count + 1 - skipped
    live.times[live.frames - 1] = last
    exchange_sides(live, it)
    live.viewer.sampled = 0
    sample(live.viewer, n, live.dense, live.frames - at, live.times[at:], live.states[at])
    work = live.n_state
    for k in range(at, live.frames):
        if live.n_outputs > 0:
            hold.observing(live.times[k], live.states[k], hold.phase, live.outputs[k])
        live.states[k, work] += it.impulses
    exchange_sides(live, it)
    return 1


@compiled
def exchange_sides(live: Live, it: EventRun) -> None:
    """Exchange the sides of laws with those of the phase that is shown, after which they may have switched."""
    s, kept, changed = SidedRun(it.sided), live.touching.sides, 0
    for k in range(it.laws):
        if s.sides[k] != kept[k]:
            s.sides[k], kept[k], changed = kept[k], s.sides[k], 1
    if changed != 0:
        renew(Hoisted(it.hoisted))


@compiled
def frames_of_piece(live: Live, steps: int, length: float) -> int:
    """Return the number of frames of a piece after its first."""
    part = length / (live.until - live.start)
    count = (FRAMES_OF_STEP * steps + whole(FEWEST * part)) >> live.touching.fades
    return count if count > 1 else 1


@compiled
def new_phase(live: Live, it: EventRun) -> int:
    """Note the modes of a phase that begins; return 0 if there is no room, else 1."""
    p = live.phases
    if p == live.room_of_phases:
        return 0
    live.phase_times[p], live.phase_frames[p] = live.run.times[0], live.frames
    for k in range(it.contacts):
        live.modes[p * it.contacts + k] = it.shown[k]
    live.phases += 1
    return 1


@compiled
def note_events(live: Live, it: EventRun) -> None:
    """Note the user's events in the log, as long as there is room."""
    entry = 0
    while entry < it.marked:
        if it.marks[entry] == event_run.CROSSING and live.events < live.room_of_events:
            at, first = live.events, it.marks[entry + 2]
            live.event_times[at], live.event_numbers[at] = it.numbers[first], it.marks[entry + 3]
            live.event_signs[at] = it.marks[entry + 4]
            copy(it.numbers[first + 1 :], live.event_states[at], it.n_y)
            live.events += 1
        entry += it.marks[entry + 1]


@compiled
def thin(live: Live) -> None:
    """Leave out every second frame of each phase, but not its last."""
    live.touching.fades += 1
    n, width, kept = live.run.n, live.n_outputs, 0
    for p in range(live.phases):
        first = live.phase_frames[p]
        end = live.phase_frames[p + 1] if p + 1 < live.phases else live.frames
        live.phase_frames[p] = kept
        for k in range(first, end):
            if (k - first) % 2 == 0 or k == end - 1:
                live.times[kept] = live.times[k]
                copy(live.states[k], live.states[kept], n)
                copy(live.outputs[k], live.outputs[kept], width)
                kept += 1
    live.frames = kept
