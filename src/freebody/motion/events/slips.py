"""Slip in space at speed zero, where it has no direction, in compiled code: its first and last moments, as straight
steps, of 1 µs at most, with the accelerations at the start. They end where a contact closes.

    u(s) = u + s a,    q(s) = q + s B(q) (u + s a/2)
"""

from __future__ import annotations

from ...native.instructions import compiled, greater, lesser, root
from ..cones.block_rows import dot
from ..cones.contacts import Contacts
from ..ode.layout import FINISHED
from ..ode.run import Run
from ..phase import laws
from ..phase.contact_outputs import evaluated
from ..phase.mode_conditions import elsewhere
from ..phase.phase_record import PhaseData
from . import event_run
from .event_run import EventRun
from .impulse_system import add_row, impelled, move_speeds
from .log import log_phase, log_state
from .moment import approaches, copy, is_smooth, largest, look, response, row_of, slip_speed
from .setting import begins_slip, leaves_rest, project, set_up

DEAD = 1e-16
"""Part of the motion by a normal force, as a square, below which that by friction is none: at a dead centre it is zero.

An event is located to about 1e-11 of a turn.
"""
HALVINGS = 32
"""Number of halvings of a step in search of the moment at which a contact closes: 1 µs to the round-off of 1 s."""
UPSET = -2
"""Answer that a straight step would turn other slips."""
FADES, ALIKE = 100.0, 10.0
"""Multiple of the speed at which slips end up to which others end together; the part by which they must have slowed."""


@compiled
def pull(it: EventRun) -> float:
    """Return the least tangential acceleration of slips that begin at rest; -1 if none begins."""
    result = -1.0
    for k in range(it.contacts):
        if begins_slip(it, k) != 0:
            size = slip_acceleration(it, k)
            result = size if result < 0.0 else lesser(result, size)
    return result


@compiled
def slip_acceleration(it: EventRun, k: int) -> float:
    """Return the tangential acceleration of a contact under the forces of the decision."""
    square = 0.0
    for i in range(it.n):
        it.v[i] = 0.0
        for r in range(it.rows):
            it.v[i] += it.force[r] * it.X[r * it.n + i]
    for j in range(it.tangents[k]):
        r = it.first[k] + 1 + j
        a = it.c[r] + dot(row_of(it, it.W, r), it.v, it.n)
        square += a * a
    return root(square)


@compiled
def scale_of(it: EventRun) -> float:
    """Return the greatest acceleration of a contact that touches, without contact forces.

    That of the lowest point of a disk that lies flat, which is no contact, has no limit.
    """
    result = 0.0
    for k in range(it.contacts):
        if it.mode[k] != laws.OPEN:
            result = greater(result, largest(it.c[it.first[k] :], 1 + it.tangents[k]))
    return result


# -- straight steps --------------------------------------------------------------------------------------


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
    for k in range(it.contacts):
        was_open = it.mode[k] == laws.OPEN and it.held[k] == 0 and it.apart[k] >= -it.near
        deep = it.gap[k] < -band and it.reach[k] >= -it.near
        if was_open and deep and elsewhere(it.side, it.mode, it.contacts, k) == 0:
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


# -- the first moment ------------------------------------------------------------------------------------


@compiled
def nudged(it: EventRun, contacts: Contacts, alone: int) -> int:
    """Find impulses that give slips which begin the speed `NUDGE`; return 0 if other contacts prevent it, else 1.

    ``alone`` is the contact to which they give it while other slips that begin are free, or -1 for all.
    """
    count = 0
    for k in range(it.contacts):
        if it.mode[k] != laws.OPEN:
            begins = leaves_rest(it, k)
            goes = begins != 0 and (alone < 0 or alone == k)
            if it.held[k] == 0:
                count = add_row(it, count, it.first[k], 0.0)
            if it.mode[k] == laws.STICK or it.mode[k] == laws.LIMIT or goes:
                for j in range(it.tangents[k]):
                    goal = event_run.NUDGE * it.way[k, j] if goes else 0.0
                    count = add_row(it, count, it.first[k] + 1 + j, goal)
    return 1 if impelled(it, contacts, count) <= 1e-3 * event_run.NUDGE else 0


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


@compiled
def begin_slip(it: EventRun, contacts: Contacts, end: float, longest: float, whole: int) -> int:
    """Pass the first moment of a slip in space that begins at rest; return 1 if the state has changed, else 0.

    This moment is a straight step of at most ``longest`` that gives the slip a direction. It ends before where a
    contact closes. Return -1 if the others prevent the slip in the direction of its acceleration, and `UPSET` if other
    slow slips would turn within the step, and ``whole`` is not 0.
    """
    least = pull(it)
    if least < 0.0:
        return 0
    n_q, n = it.n_q, it.n
    if least <= event_run.SMALL * scale_of(it) or least * longest < 4.0 * laws.STOPPED:
        if nudged(it, contacts, -1) == 0:
            return -1
        work = it.impulses
        move_speeds(it)
        it.impulses = work
        look(it)
        return 1
    length = lesser(greater(4.0 * laws.STOPPED / least, 1e-9), end - it.t)
    if whole != 0:
        slip_acceleration(it, 0)  # sets the change by the forces
        for r in range(it.rows):
            it.speeds[r] = it.c[r] + dot(row_of(it, it.W, r), it.v, n)
        if upset(it, -1, length) != 0:
            return UPSET
    copy(it.y, it.start, it.n_y)
    for i in range(n):
        it.step[n_q + i] = it.free[i]
        for r in range(it.rows):
            it.step[n_q + i] += it.force[r] * it.X[r * n + i]
    begun = it.t
    length = go_straight(it, length)
    if approaches(it) == 0:  # else the impact comes first
        set_up(it, contacts)
        project(it)
    it.rates(it.t, it.y, it.phase, it.step)
    for i in range(it.n_q + it.n, it.n_y):  # work and heat, of loads and of contacts that slip already
        it.y[i] += length * it.step[i]
    look(it)
    log_leap(it, begun, length)
    return 1


@compiled
def shortest_turn(it: EventRun) -> float:
    """Return the shortest time in which friction turns a slip in space that has just begun, v/a, or 0 without one."""
    result, a = 0.0, scale_of(it)
    for k in range(it.contacts):
        v, slides = slip_speed(it, k), it.mode[k] == laws.SLIDE and it.tangents[k] == 2
        if slides and it.still < v <= event_run.SLOW and a > 0.0 and not is_smooth(it, k):
            result = lesser(result, v / a) if result > 0.0 else v / a
    return result


# -- the last moment -------------------------------------------------------------------------------------


@compiled
def resolve_slips(it: EventRun, run: Run) -> None:
    """Set the speed at which slips in space end: what the tolerances of the speeds resolve."""
    most = 0.0
    for i in range(it.n_q, it.n_q + it.n):
        most = greater(most, run.absolute[i])
    it.slowest = greater(laws.STOPPED, laws.RESOLVED * most)
    if it.creeping == 0:
        PhaseData(it.phase).stopped = it.slowest


@compiled
def fading(it: EventRun, slows: int) -> int:
    """Return a contact with friction that slips in space so slowly that the slip soon has no direction, or -1.

    With ``slows`` 1 it is one that slows further: its speed does not pass the end of slips, and its direction turns at
    rates of 1/speed.
    """
    known = 0
    for k in range(it.contacts):
        rough = it.mode[k] == laws.SLIDE and it.tangents[k] == 2 and not is_smooth(it, k)
        if not rough or slip_speed(it, k) > PhaseData(it.phase).stopped:
            continue
        if slows == 0:
            return k
        if slip_speed(it, k) > it.still:
            if known == 0:
                it.accelerations(it.t, it.y, it.phase, it.speeds)
                known = 1
            r = it.first[k] + 1
            if dot(it.rate[r:], it.speeds[r:], 2) < 0.0:
                return k
    return -1


@compiled
def stop(it: EventRun, contacts: Contacts, keep: int) -> int:
    """Cancel the slip of the contacts ``stopped``; those that stick, and are closed, stay so. Return 1, or 0 if not all
    of them can.

    With ``keep`` 1 the work is not counted.

    Slips along tangents at a dead centre go on: what stops them there would stop all that moves.
    """
    count = 0
    for k in range(it.contacts):
        if it.mode[k] != laws.OPEN and it.held[k] == 0:
            count = add_row(it, count, it.first[k], -it.rate[it.first[k]])
        if it.stopped[k] != 0 or it.mode[k] == laws.STICK:
            for j in range(1, 1 + it.tangents[k]):
                if is_dead_centre(it, k, it.first[k] + j) == 0:
                    count = add_row(it, count, it.first[k] + j, -it.rate[it.first[k] + j])
    missed, work = impelled(it, contacts, count), it.impulses
    move_speeds(it)
    if keep != 0:
        it.impulses, it.rest_left = work, it.impulses - work
    look(it)
    return 1 if missed <= it.still else 0


@compiled
def is_dead_centre(it: EventRun, k: int, r: int) -> int:
    """Return 1 if force along tangent r of a contact moves the machine by nothing beside its normal force, else 0.

    The slip of a crank's pin in a straight slot is zero there, whatever the speed of the crank.
    """
    p = it.presser[k] if it.presser[k] >= 0 else k
    if it.held[p] != 0:
        return 0
    normal = it.first[p]
    return 1 if response(it, r, r) <= DEAD * response(it, normal, normal) else 0


@compiled
def turn_back(it: EventRun, contacts: Contacts) -> None:
    """Take away slips along a line that are against the sense in which they begin: what an impact has left of them.

    Otherwise the function that ends the slip would begin below zero, and never fall through it.
    """
    found, noise = 0, event_run.NOISE * (1.0 + largest(it.y[it.n_q :], it.n))
    for k in range(it.contacts):
        v, it.stopped[k] = 0.0, 0
        if it.mode[k] == laws.SLIDE_ON or it.mode[k] == laws.SLIDE_BACK:
            v = it.rate[it.first[k] + 1]
            v = v if it.mode[k] == laws.SLIDE_ON else -v
        if -it.still <= v < -noise:
            it.stopped[k], found = 1, 1
    if found != 0:
        stop(it, contacts, 0)


@compiled
def turned_over(it: EventRun) -> int:
    """Return 1 if the first moment of a slip has given one along a line the other sense than its mode, else 0.

    The impulses that nudge a slip spin the body, too: a spin that was about to begin has a speed then. If a contact
    closes at its end, the impact comes first.
    """
    if approaches(it) != 0:
        return 0
    for k in range(it.contacts):
        v = it.rate[it.first[k] + 1] if it.tangents[k] == 1 else 0.0
        if (it.mode[k] == laws.SLIDE_ON and v < -it.still) or (
            it.mode[k] == laws.SLIDE_BACK and v > it.still
        ):
            return 1
    return 0


@compiled
def find_stopped(it: EventRun, k: int, length: float) -> None:
    """Let the slips of other contacts end with that of contact k, after this time; ``speeds`` are the accelerations.

    A body that turns as it stops comes to rest at all its contacts at once.
    """
    fast = FADES * PhaseData(it.phase).stopped
    for j in range(it.contacts):
        slides = it.mode[j] == laws.SLIDE and it.tangents[j] == 2 and it.rough[j] != 0
        r, speed, left = it.first[j] + 1, slip_speed(it, j), 0.0
        for i in range(it.tangents[j]):
            left += (it.rate[r + i] + length * it.speeds[r + i]) ** 2
        ends = slides and speed <= fast and root(left) <= speed / ALIKE
        it.stopped[j] = 1 if j == k or ends else 0


@compiled
def halt(it: EventRun, contacts: Contacts, k: int, whole: int) -> int:
    """Pass the end of a slip in space whose speed has fallen to that of its end, by a straight step to it.

    A slip along a line is at its end. The step ends before where a contact closes. Return 1 if the state has changed, 0
    if not, and -1 if it hardly slows: it stops if it sticks then. The state is that without slip, and ``kept`` the one
    before. Return `UPSET` if other slow slips would turn within the step, or what sticks cannot stay in place without
    the slip, and ``whole`` is not 0.
    """
    speed, r = slip_speed(it, k), it.first[k] + 1
    if not speed > 0.0:
        return 0
    for j in range(it.contacts):
        it.stopped[j] = 1 if j == k else 0
    if it.tangents[k] == 1:
        stop(it, contacts, 0)
        return 1
    it.accelerations(it.t, it.y, it.phase, it.speeds)
    slowing = -dot(it.rate[r:], it.speeds[r:], 2) / speed
    if not slowing > 0.0:  # it turns as it slows: a new slip begins, or it sticks
        stop(it, contacts, 0)
        return 1
    length = speed / slowing
    find_stopped(it, k, length)
    if length > event_run.LONGEST:
        copy(it.y, it.kept, it.n_y)
        if stop(it, contacts, 1) == 0 and whole != 0:
            copy(it.kept, it.y, it.n_y)
            look(it)
            return UPSET
        return -1
    if whole != 0 and upset(it, k, length) != 0:
        return UPSET
    copy(it.y, it.start, it.n_y)
    it.rates(it.t, it.y, it.phase, it.step)
    begun = it.t
    passed = go_straight(it, length)
    for i in range(it.n_q + it.n, it.n_y):
        it.y[i] += passed * it.step[i]
    if passed < length:  # what closes comes first
        for j in range(it.contacts):
            it.stopping[j] = 0
    else:
        stop(it, contacts, 0)  # the slip that remains after a straight step is of second order in its length
    log_leap(it, begun, passed)
    return 1
