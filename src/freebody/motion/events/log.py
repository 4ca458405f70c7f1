"""The log of a run from event to event, in compiled code: entries of integers and of real numbers.

marks      kind, number of its marks, number of its numbers, then what `contact.history` reads
numbers    of the entries, one after another
"""

from __future__ import annotations

from ...native.instructions import Integers, Reals, compiled, inlined
from ..kernels.hoisted import Hoisted
from ..kernels.switching import sign_of
from ..phase.laws import LIMIT, STICK
from ..phase.phase_record import PhaseData
from . import event_run
from .event_run import EventRun
from .moment import copy


@compiled
def room_for_event(it: EventRun) -> int:
    """Return 1 if the log has room for what one stage of the loop may add, else 0."""
    marks = 4 * (16 + 4 * it.contacts + it.rows + it.laws) + 8 * it.crossed
    numbers = 4 * (16 + 4 * it.n_y + 4 * it.contacts + 4 * it.rows + 2 * it.rings) + (it.n_y + 1) * it.crossed
    fits = it.marked + marks <= it.marks_room and it.numbered + numbers <= it.numbers_room
    return 1 if fits and it.logged + 4 <= it.path_room else 0


@compiled
def begin(it: EventRun, kind: int) -> int:
    """Begin an entry; return its place."""
    at = it.marked
    it.marks[at], it.marks[at + 1], it.marks[at + 2] = kind, 3, it.numbered
    it.marked += 3
    return at


@compiled
def mark(it: EventRun, number: int) -> None:
    """Append an integer."""
    it.marks[it.marked] = number
    it.marked += 1


@compiled
def note(it: EventRun, number: float) -> None:
    """Append a real number."""
    it.numbers[it.numbered] = number
    it.numbered += 1


@compiled
def note_all(it: EventRun, x: Reals, n: int) -> None:
    """Append n real numbers."""
    copy(x, it.numbers[it.numbered :], n)
    it.numbered += n


@compiled
def end(it: EventRun, at: int) -> None:
    """End an entry: write the number of its marks."""
    it.marks[at + 1] = it.marked - at


@compiled
def log_state(it: EventRun, t: float, y: Reals, length: float) -> None:
    """Append a row of the path: time, state, and length of the step that begins there."""
    it.times[it.logged], it.lengths[it.logged] = t, length
    copy(y, it.states[it.logged * it.n_y :], it.n_y)
    it.logged += 1


@compiled
def log_phase(it: EventRun, status: int, rejected: int, evaluated: int, stiff: int, kind: int) -> None:
    """Log a phase whose rows of the path begin at ``first_row``: how it ended, of which ``kind`` its steps are (`STEPS`
    and its kin), its modes, the sides of laws that switch, and its conditions.
    """
    at, phase = begin(it, event_run.PHASE), PhaseData(it.phase)
    mark(it, it.first_row)
    mark(it, it.logged - it.first_row)
    mark(it, status)
    mark(it, rejected)
    mark(it, evaluated)
    mark(it, stiff)
    mark(it, it.blame)
    mark(it, kind)
    mark(it, it.spare_count)
    note(it, it.impulses)
    for k in range(it.contacts):
        mark(it, it.mode[k])
        if it.mode[k] == LIMIT:
            note(it, it.way[k, 0])
            note(it, it.way[k, 1])
    for k in range(it.contacts):
        mark(it, it.shown[k] + event_run.DEAD * it.dead[k])
    for k in range(it.laws):
        mark(it, sign_of(phase.sides[k]))
    for i in range(it.actives):
        mark(it, it.active[i])
    for i in range(it.rings):
        note_all(it, Hoisted(it.hoisted).parameters[it.ring_at[i] :], 2)
    end(it, at)
    it.phases += 1


@compiled
def find_phases(it: EventRun, places: Integers) -> int:
    """Set ``places`` to the places of the entries of phases; return their number."""
    at, count = 0, 0
    while at < it.marked:
        if it.marks[at] == event_run.PHASE:
            places[count] = at
            count += 1
        at += it.marks[at + 1]
    return count


@compiled
def log_crossing(it: EventRun, t: float, number: int, sign: int, y: Reals) -> None:
    """Log an event of the user, before the phase in which it happens."""
    at = begin(it, event_run.CROSSING)
    mark(it, number)
    mark(it, sign)
    note(it, t)
    note_all(it, y, it.n_y)
    end(it, at)


@inlined
def noted_mode(it: EventRun, k: int) -> int:
    """Return the shown mode of a contact; `HELD_OPEN` is added if only the next step of the speeds asks for its end."""
    unwatched = it.holding == event_run.AT_REST and it.mode[k] == STICK
    return it.shown[k] + event_run.HELD_OPEN if unwatched else it.shown[k]


@compiled
def log_modes(it: EventRun, hit: int, shares: int) -> None:
    """Log a change of the modes that are shown, with the reasons; the new modes become the past ones.

    ``shares`` is 1 if the shares of indeterminate forces decide the motion.
    """
    changed = 0
    for k in range(it.contacts):
        changed += 1 if it.past[k] != noted_mode(it, k) else 0
    if changed == 0:
        return
    at = begin(it, event_run.NOTE)
    mark(it, hit)
    mark(it, shares)
    note(it, it.t)
    note_all(it, it.y, it.n_y)
    for k in range(it.contacts):
        if it.mode[k] == LIMIT:
            note(it, it.way[k, 0])
            note(it, it.way[k, 1])
        mark(it, it.mode[k])
    for k in range(it.contacts):
        now = noted_mode(it, k)
        if it.past[k] != now:
            mark(it, k)
            mark(it, it.past[k])
            mark(it, now)
            mark(it, it.reason[k])
            note(it, it.measure[k] if it.reason[k] == event_run.CONE_REACHED else 0.0)
        it.past[k] = now
    end(it, at)
