"""Whether open forces of contacts at rest are within their cones, in compiled code."""

from __future__ import annotations

from ....native.instructions import Truth, compiled, inlined
from ...cones.contacts import Contacts
from ...phase import laws
from ...phase.contact_outputs import force_of
from ...phase.phase_record import PhaseData
from .. import event_run, limits
from ..event_run import EventRun
from ..setting import leaves_rest
from ..shares import find_shared
from ..slips.slip_starts import nudged, scale_of, slip_acceleration


@compiled
def watch_cones(it: EventRun, contacts: Contacts) -> None:
    """Watch the cones of a phase at rest by open forces if its shares are well within them.

    Else watch those of forces that are not open, and leave it to the next step of the speeds whether open ones can hold
    the contacts.
    """
    if beyond_cones(it, limits.CLOSE, 0) == 0:
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
def hold(it: EventRun, contacts: Contacts) -> int:
    """Let contacts whose slip would begin, but that the others hold at rest, be at their limits; return 1, or 0.

    Their friction stays at μ_s N, and the others share what is left: the path of equal compliance. The slip begins when
    all that can hold it have reached their limits. So it is, without such modes, where shares of contacts at rest lie
    outside their cones along a line. In space they pass the cone again and again where contacts crowd, without need.
    """
    weak, starts, held = limits.SMALL * scale_of(it), 0, 0
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
    return 1 if held != 0 or beyond_cones(it, -limits.SMALL, 1) != 0 else 0


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
    if not (rests and are_near_cones(it, -limits.SMALL, 0) != 0):
        return 0
    it.holding, it.creeping, it.stage = 0, 0, event_run.DECIDE
    PhaseData(it.phase).stopped = it.slowest
    return 1
