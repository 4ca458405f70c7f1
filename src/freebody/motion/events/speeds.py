"""A short step of the speeds alone, in compiled code: which contacts stick and where the others slip to, at once.

    u⁺ = u + h M⁻¹ f + M⁻¹ Wᵀ Λ,    0 <= Λ_N  ⟂  v_N⁺ >= 0,    -Λ_T in μ Λ_N Sgn(v_T⁺)

M, f and W are those of the position halfway, so that a contact that stays closed as it turns does no work by N.
Where several contacts come to rest and begin to slip within less than a microsecond, the directions of slip follow each
other faster than events tell, and no nudge along directions of the accelerations is possible. This problem decides for
all of them, and always has a solution. It is of first order in h where slips begin and end.

Source: J. J. Moreau, Unilateral contact and dry friction in finite freedom dynamics (1988).
"""

from __future__ import annotations

import math

from ...native.instructions import Truth, compiled, greater, inlined, lesser, run_by
from ..cones.contacts import ACCEPTED, Contacts
from ..phase import laws
from ..phase.contact_outputs import evaluated, extended, force_of
from ..phase.phase_record import PhaseData
from . import event_run
from .decision import decide
from .event_run import EventRun
from .impulse_system import add_row, impelled, move_speeds
from .jumps import forget_signs
from .moment import (
    approaches,
    choose_all,
    copy,
    copy_wholes,
    is_smooth,
    largest,
    look,
    presses,
    pull,
    size_of,
    slip_speed,
)
from .problem import gather
from .setting import depends, displace, leaves_rest, listed, normalise, set_up
from .shares import find_shared, has_forces, leave_pulling
from .slips import closes, log_leap, loses_places, nudged, scale_of, slip_acceleration

NEAR = 1e-6
"""Greatest distance of contacts that have parted, relative to 1 m or the greatest coordinate, at a place beside a dead
centre: rows there differ from those at it by its root."""

UNCHANGED = 1e-12
"""Relative difference of all that a step of the speeds is computed from, below which its result is the same."""
CREPT = 10.0
"""Part of the speed of a slip that creeps at which it ends."""


@compiled
def step_of_speeds(it: EventRun, contacts: Contacts, length: float) -> int:
    """Pass a step of this length; return 1 if the state has changed, or 0.

    It is 0 if nothing touches, if an impact comes first, if a drive acts in a closed loop, if there is no solution, or
    if a contact would close, also one at a place of a patch that has no features yet, or a compliant one that presses
    would not any more. Its force is that of the depth halfway; joints bear the load of the last decision.
    """
    n_q, n, begun, machine = it.n_q, it.n, it.t, PhaseData(it.looking)
    if approaches(it) != 0 or (machine.own > 0 and (machine.driven != 0 or it.moving != 0)):
        return 0
    choose_all(it)
    if it.count == 0:
        return 0
    copy(it.y, it.start, it.n_y)
    copy(it.gap, it.apart, it.contacts)
    copy(it.rate, it.speeds, it.rows)
    look_halfway(it, length)
    gather(it, contacts, 1, length)
    for i in range(it.count):
        k, at = it.chosen[i], contacts.at[i]
        for j in range(it.compliant[k], 1 + it.tangents[k]):  # the normal of a compliant one is no unknown
            contacts.given[at + j] += length * it.c[it.first[k] + j]
    run_by(it.finding, contacts)
    if not contacts.residual <= ACCEPTED:
        look(it)
        return 0
    it.worst = greater(it.worst, contacts.residual)
    for i in range(n):
        change = length * it.free[i]
        for a in range(contacts.rows):
            change += contacts.forces[a] * it.X[it.list[a] * n + i]
        it.step[i] = change
        it.trial[n_q + i] += change / 2.0
    it.t = begun + length / 2.0
    evaluated(it.t, it.trial, machine)
    work = length * machine.load[0]
    if machine.driven != 0:
        work += driven_work(it, contacts, length)
    for i in range(n_q):
        it.y[i] += length * machine.q_dot[i]
    for i in range(n):
        it.y[n_q + i] += it.step[i]
    normalise(it)
    it.t = begun + length
    look(it)
    if closes(it, it.near) != 0 or loses_places(it) != 0 or presses_anew(it) != 0:
        it.t = begun
        copy(it.start, it.y, it.n_y)
        look(it)
        return 0
    heat = 0.0
    for i in range(it.count):
        k, at = it.chosen[i], contacts.at[i]
        for j in range(1 + it.tangents[k]):
            r = it.first[k] + j
            done = contacts.forces[at + j] * (it.speeds[r] + it.rate[r]) / 2.0
            if j < it.compliant[k]:
                work += done
            else:
                heat -= done
    it.y[n_q + n] += work - heat
    it.y[n_q + n + 1] += heat
    keep_closed(it, contacts)
    log_leap(it, begun, length)
    return 1


@compiled
def keep_closed(it: EventRun, contacts: Contacts) -> None:
    """Close contacts that press in a step, and stop those that rest: its rows are those halfway, at other speeds.

    What they miss is of second order in its length, but where friction wedges bodies, it would open a contact for the
    10 ns that 1 kN needs to close it by another impact.
    """
    for turn in range(2):  # positions, then speeds
        count = 0
        for i in range(it.count):
            k = it.chosen[i]
            if it.held[k] == 0 and it.presser[k] < 0 and presses_in_step(it, contacts, i) != 0:
                goal = it.gap[k] if turn == 0 else it.rate[it.first[k]]
                count = add_row(it, count, it.first[k], -goal)
        impelled(it, contacts, count)
        if turn == 0:
            displace(it, it.x, count)
        else:
            move_speeds(it)
            look(it)


@compiled
def presses_in_step(it: EventRun, contacts: Contacts, i: int) -> int:
    """Return 1 if a contact of the list presses in the step that has been passed, or its normal force is given."""
    if it.held[it.chosen[i]] != 0:
        return 1
    p = contacts.presser[i] if contacts.presser[i] >= 0 else i
    least = event_run.SMALL * largest(contacts.forces, contacts.rows)
    return 1 if contacts.forces[contacts.at[p]] > least else 0


@compiled
def rests_in_step(it: EventRun, contacts: Contacts, i: int) -> int:
    """Return 1 if a contact of the list is at rest in the step that has been passed, else 0."""
    n, none = it.tangents[it.chosen[i]], ACCEPTED * largest(contacts.given, contacts.rows)
    stays = size_of(contacts.after[contacts.at[i] + 1 :], n) <= none
    return 1 if n > 0 and contacts.static[i] > 0.0 and stays else 0


@compiled
def presses_anew(it: EventRun) -> int:
    """Return 1 if a compliant contact presses that is not chosen, or does not that is, else 0."""
    for k in range(it.contacts):
        if it.compliant[k] != 0:
            pressed = 0
            for i in range(it.count):
                pressed = 1 if it.chosen[i] == k else pressed
            if presses(it, k) != pressed:
                return 1
    return 0


@compiled
def look_halfway(it: EventRun, length: float) -> None:
    """Look at the contacts in the position after half of a step, ``trial``, with the speeds that they have now."""
    machine, state = PhaseData(it.looking), it.trial
    evaluated(it.t, it.y, machine)
    copy(it.y, state, it.n_y)
    for i in range(it.n_q):
        state[i] += length * machine.q_dot[i] / 2.0
    it.looked(it.t + length / 2.0, state, it.looking, it.seen)
    copy(it.speeds, it.rate, it.rows)
    for k in range(it.contacts):
        if it.loaded[k] != 0:
            it.given[k] = it.load[k]
        if it.adhering[k] != 0:
            it.adhering[k] = 0
            pull(it, k, 1)


@compiled
def driven_work(it: EventRun, contacts: Contacts, length: float) -> float:
    """Return the work of drives in a step, by its mean accelerations and contact forces, in its middle."""
    machine = PhaseData(it.looking)
    extended(it.trial, machine)
    for i in range(it.n):
        machine.udot[i] = it.step[i] / length
    for r in range(it.rows):
        machine.force[r] = 0.0
    for a in range(contacts.rows):
        machine.force[it.list[a]] = contacts.forces[a] / length
    for k in range(it.contacts):
        if it.adhering[k] != 0:
            machine.force[it.first[k]] -= it.adhesion[k]
    machine.power(it.t, machine.state, machine.power_c, it.x)
    return length * it.x[0]


@compiled
def decided_by_speeds(it: EventRun, contacts: Contacts, longest: float) -> int:
    """Pass a step of the speeds where slips begin and end faster than events tell; return 1 if it did, else 0.

    Steps that follow each other grow to twice their length, up to `LONGEST`. If contacts are at rest after it by forces
    that are open, a phase with their modes follows, to its end at the next such step.
    """
    checked = it.checking
    it.checking = 0
    again = it.leap > 0.0 and it.t - it.leapt <= 2.0 * it.leap
    length = lesser(2.0 * it.leap, event_run.LONGEST) if again else event_run.SHORTEST
    if checked != 0 and is_unchanged(it, length) != 0:
        hold_longer(it)
        return 1
    if length > longest or step_of_speeds(it, contacts, length) == 0:
        it.rested[0] = math.nan
        return 0
    it.leap, it.leapt, it.stage, it.hit = length, it.t, event_run.ARRIVE, 0
    if hold_at_rest(it, contacts) != 0:
        it.hold = it.hold if checked != 0 else event_run.LONGEST / 4.0
        hold_longer(it)
    elif checked != 0 and it.hold > event_run.LONGEST:
        hold_shorter(it, 8.0)  # contacts had begun to slip before its end
        return 1
    elif length == event_run.LONGEST and creep(it, contacts) != 0:
        it.stage = event_run.SET_UP
    for k in range(it.contacts):
        if it.reason[k] == event_run.CONE_REACHED:
            it.reason[k] = event_run.NO_REASON
    return 1


@compiled
def hold_longer(it: EventRun) -> None:
    """Hold the modes of a rest by open forces for four times as long as before, up to `HELD`."""
    it.hold = lesser(4.0 * it.hold, event_run.HELD)
    it.until, it.holding, it.stage = it.t + it.hold, event_run.AT_REST, event_run.SET_UP


@compiled
def is_unchanged(it: EventRun, length: float) -> int:
    """Return 1 if a step of the speeds is that of the last check, which found a rest, else 0."""
    copy(it.rate, it.speeds, it.rows)
    look_halfway(it, length)
    same = 1
    for i in range(it.seen_size):
        # gaps and reaches may be infinite
        if it.seen[i] != it.rested[i] and not abs(it.seen[i] - it.rested[i]) <= UNCHANGED * (
            1.0 + abs(it.seen[i])
        ):
            same = 0
    copy(it.seen, it.rested, it.seen_size)
    look(it)
    return same


@compiled
def hold_at_rest(it: EventRun, contacts: Contacts) -> int:
    """Set the modes of the step that has been passed if no contact slips slowly after it; return 1, or 0."""
    copy_wholes(it.mode, it.before, it.contacts)
    if are_at_rest(it, contacts) != 0:
        leave_pulling(it, contacts)
        if beyond_cones(it, -event_run.SMALL, 0) != 0:
            stay_at_limits(it, contacts)
        return 1
    copy_wholes(it.before, it.mode, it.contacts)  # a phase that was held too long is passed again with them
    it.rested[0] = math.nan
    return 0


@compiled
def creep(it: EventRun, contacts: Contacts) -> int:
    """Set the modes of steps that have gone on with slips in space slower than `slowest`; return 1 if there are any.

    A slip that stops takes a part of such a step. What is left moves with the machine, as feet do that cannot all stay
    in place while their legs turn: friction has the direction of a speed of 1e-9 m/s, and follows the load. The last
    step is a short one, since its mean rows leave its length times such changes in the speeds.
    """
    least = it.slowest
    for k in range(it.contacts):
        if it.closed[k] != 0 and it.tangents[k] == 2 and not is_smooth(it, k):
            v = slip_speed(it, k)
            least = lesser(least, v) if v > it.still else least
    if least == it.slowest or it.refuse != 0:
        return 0
    copy_wholes(it.mode, it.before, it.contacts)
    if step_of_speeds(it, contacts, event_run.BRIEF) == 0 or modes_of_step(it, contacts) < 0:
        copy_wholes(it.before, it.mode, it.contacts)
        return 0
    open_pulling(it, contacts)
    PhaseData(it.phase).stopped, it.creeping = least / CREPT, 1
    return 1


@compiled
def open_pulling(it: EventRun, contacts: Contacts) -> None:
    """Open the contacts that have pressed in a step, since they approached, and pull after it."""
    pulls = 1
    while pulls != 0:
        set_up(it, contacts)
        found, least = -1, -event_run.SMALL * largest(contacts.forces, contacts.rows)
        if has_forces(it, contacts) != 0:
            for i in range(contacts.contacts):
                k = it.chosen[i]
                rigid = it.held[k] == 0 and it.presser[k] < 0 and it.compliant[k] == 0
                N = it.speeds[it.first[k]] + (it.adhesion[k] if it.adhering[k] != 0 else 0.0)
                if rigid and it.mode[k] != laws.OPEN and least > N:
                    found, least = k, N
        pulls = 0
        if found >= 0:
            for k in range(it.contacts):
                if k == found or it.presser[k] == found:
                    it.mode[k], pulls = laws.OPEN, 1


@compiled
def are_at_rest(it: EventRun, contacts: Contacts) -> int:
    """Set the modes of the step that has been passed; return 1 if contacts are at rest, and none slips slowly, else 0.

    Forces beyond their cone by F give a body of mass m the speed F h/m, far below a slip, so contacts are at rest whose
    speeds in the problem are its round-off.
    """
    if it.refuse != 0 or slow_slips(it) > 0 or approaches(it) != 0:
        return 0
    return 1 if modes_of_step(it, contacts) > 0 and begin_at_limits(it, contacts) != 0 else 0


@compiled
def modes_of_step(it: EventRun, contacts: Contacts) -> int:
    """Set the modes of the step that has been passed; return 1 if contacts are at rest by forces that may be open, 0 if
    none is, and -1 if a slip begins in it.

    A slip that begins has no direction yet. A contact that rests alone in a plane has a force that events follow.
    """
    found = 0
    for k in range(it.contacts):
        it.mode[k], it.way[k, 0], it.way[k, 1] = laws.OPEN, 0.0, 0.0
    for i in range(it.count):
        k = it.chosen[i]
        p = contacts.presser[i] if contacts.presser[i] >= 0 else i
        closed = it.held[k] != 0 or it.closed[it.chosen[p]] != 0
        if closed and presses_in_step(it, contacts, i) != 0:
            n = it.tangents[k]
            rests = slip_speed(it, k) <= it.still and rests_in_step(it, contacts, i) != 0
            it.mode[k] = laws.STICK if rests else laws.SLIDE
            if it.mode[k] == laws.SLIDE and it.rough[k] != 0:
                if is_smooth(it, k):
                    it.mode[k] = laws.SMOOTH
                elif slip_speed(it, k) <= it.still:
                    return -1
                elif n == 1:
                    it.mode[k] = laws.SLIDE_BACK if it.rate[it.first[k] + 1] < 0.0 else laws.SLIDE_ON
            if rests:
                found += 1 if n == 1 and it.held[k] == 0 else 2
    return 1 if found > 1 else 0


@compiled
def begin_at_limits(it: EventRun, contacts: Contacts) -> int:
    """Let contacts at rest slip that are at their limits by forces that are not open; return 0 if one has no direction.

    A slip that begins is too slow for a step of 0.1 µs to tell it from rest.
    """
    find_shared(it, contacts)
    for i in range(it.count):
        k, at, n = it.chosen[i], contacts.at[i], contacts.tangents[i]
        if it.mode[k] == laws.STICK and it.shared[k] == 0:
            limit = contacts.static[i] * contacts.forces[at]
            if limit > 0.0 and limit - size_of(contacts.forces[at + 1 :], n) <= ACCEPTED * limit:
                if n > 1:
                    return 0
                it.mode[k] = laws.SLIDE_BACK if contacts.forces[at + 1] > 0.0 else laws.SLIDE_ON
    return 1


@compiled
def stay_at_limits(it: EventRun, contacts: Contacts) -> None:
    """Let what is at rest at its limit in the step stay there, of contacts in space and of joints, where equal shares
    would be beyond cones.

    The others hold them; their forces decide the motion, as where a ball that is clamped spins at a third contact.
    """
    copy_wholes(it.mode, it.before, it.contacts)
    for i in range(it.count):
        k, at, n = it.chosen[i], contacts.at[i], contacts.tangents[i]
        limit = contacts.static[i] * contacts.forces[at]
        friction = size_of(contacts.forces[at + 1 :], n)
        stays = it.mode[k] == laws.STICK and (n > 1 or it.held[k] != 0)
        if stays and limit > 0.0 and limit - friction <= ACCEPTED * limit:
            for j in range(n):
                it.way[k, j] = -contacts.forces[at + 1 + j] / friction
            it.mode[k] = laws.LIMIT
            if n == 1:
                it.mode[k] = laws.SLIDE_BACK if it.way[k, 0] < 0.0 else laws.SLIDE_ON
    set_up(it, contacts)
    if beyond_cones(it, -event_run.SMALL, 0) != 0 or are_held(it, contacts) == 0:
        copy_wholes(it.before, it.mode, it.contacts)
        set_up(it, contacts)


@compiled
def are_held(it: EventRun, contacts: Contacts) -> int:
    """Return 1 if the others hold the contacts that have been put to their limits, else 0."""
    count = listed(it)
    for k in range(it.contacts):
        if it.mode[k] != it.before[k]:
            for j in range(it.tangents[k]):
                if depends(it, contacts, it.first[k] + 1 + j, count) == 0:
                    return 0
    return 1


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
    it.hold = greater(it.hold / part, event_run.LONGEST)
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
        return 0 if it.hold > event_run.LONGEST else event_run.PARTED
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


@compiled
def watch_cones(it: EventRun, contacts: Contacts) -> None:
    """Watch the cones of a phase at rest by open forces if its shares are well within them.

    Else watch those of forces that are not open, and leave it to the next step of the speeds whether open ones can hold
    the contacts.
    """
    if beyond_cones(it, event_run.CLOSE, 0) == 0:
        it.holding = 0
        return
    phase = PhaseData(it.phase)
    find_shared(it, contacts)
    for i in range(phase.endings):
        known = it.shared[it.ending[i]] == 0 and it.watch[it.events + i] > 0.0
        if is_cone(phase.law[i], 0) and not known:
            phase.law[i] = laws.NEVER


@inlined
def is_cone(law: int, alone: int) -> Truth:
    """Return True for the cone of a contact at rest; with ``alone`` 1 only for one along a line."""
    return law == laws.LINE_CONE or (law == laws.CONE and alone == 0)


@compiled
def slow_slips(it: EventRun) -> int:
    """Return the number of slips in space of closed contacts below `SLOW`."""
    found = 0
    for k in range(it.contacts):
        touches = it.closed[k] != 0 or (it.compliant[k] != 0 and presses(it, k) != 0)
        if touches and it.tangents[k] == 2 and it.still < slip_speed(it, k) <= event_run.SLOW:
            found += 1
    return found


# -- when it is asked ------------------------------------------------------------------------------------


@compiled
def hold(it: EventRun, contacts: Contacts) -> int:
    """Let contacts whose slip would begin, but that the others hold at rest, be at their limits; return 1, or 0.

    Their friction stays at μ_s N, and the others share what is left: the path of equal compliance. The slip begins when
    all that can hold it have reached their limits. So it is, without such modes, where shares of contacts at rest lie
    outside their cones along a line. In space they pass the cone again and again where contacts crowd, without need.
    """
    weak, starts, held = event_run.SMALL * scale_of(it), 0, 0
    for k in range(it.contacts):
        if leaves_rest(it, k) != 0 and slip_acceleration(it, k) <= weak:
            if nudged(it, contacts, k) == 0:
                held = hold_at_limit(it, k)
            else:
                starts += 1
    if starts > 0 and nudged(it, contacts, -1) == 0:
        for k in range(it.contacts):
            if leaves_rest(it, k) != 0 and slip_acceleration(it, k) <= weak:
                held = hold_at_limit(it, k)
    return 1 if held != 0 or beyond_cones(it, -event_run.SMALL, 1) != 0 else 0


@compiled
def hold_at_limit(it: EventRun, k: int) -> int:
    """Let a contact be at its limit, where a line alone does not give its direction; return 1."""
    if it.tangents[k] == 2:
        it.mode[k] = laws.LIMIT
    return 1


@compiled
def beyond_cones(it: EventRun, part: float, alone: int) -> int:
    """Return 1 if open forces of a contact at rest are within less than ``part`` of its cone as a phase begins, else 0.

    Where they are outside, the function that ends the rest would never fall through zero. Shares are open, and so is
    what is left by friction at the limit of a contact that others hold in place. With ``alone`` 1 only cones along a
    line are looked at.
    """
    return 1 if has_open_forces(it) != 0 and are_near_cones(it, part, alone) != 0 else 0


@compiled
def has_open_forces(it: EventRun) -> int:
    """Return 1 if the motion leaves forces open, else 0."""
    found = it.spare_count
    for k in range(it.contacts):
        found += it.dead[k] if it.mode[k] != laws.OPEN else 0
    return 1 if found > 0 else 0


@compiled
def are_near_cones(it: EventRun, part: float, alone: int) -> int:
    """Return 1 if forces of a contact at rest are within less than ``part`` of its cone as a phase begins, else 0."""
    watched, phase = 0, PhaseData(it.phase)
    for i in range(phase.endings):
        watched += 1 if is_cone(phase.law[i], alone) else 0
    if watched == 0 or it.ready == 0:
        return 0
    it.watched(it.t, it.y, it.phase, it.watch)
    for i in range(phase.endings):
        k, law = it.ending[i], phase.law[i]
        if is_cone(law, alone):
            limit = it.coefficients[4 * k + 1] * abs(force_of(phase, k)[0])
            if not it.watch[it.events + i] >= part * (limit * limit if law == laws.CONE else limit):
                return 1
    return 0


@compiled
def rest_given_up(it: EventRun) -> int:
    """Let accelerations decide where the forces of a rest after a step of the speeds are given and too great; return 1.

    Beside a dead centre forces grow beyond all limits, which such a step of 0.1 µs does not show. Else return 0.
    """
    rests = (it.holding == event_run.AT_REST or it.creeping != 0) and has_open_forces(it) == 0
    if not (rests and are_near_cones(it, -event_run.SMALL, 0) != 0):
        return 0
    it.holding, it.creeping, it.stage = 0, 0, event_run.DECIDE
    return 1
