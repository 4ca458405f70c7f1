"""The equations of a phase for the modes of a run, in compiled code, and what is open and returns at once."""

from __future__ import annotations

from ...native.instructions import Reals, compiled, lesser, run_by
from ..cones.contacts import Contacts
from ..cones.newton import factor
from ..ode.states import to_unit
from ..phase import laws
from ..phase.contact_outputs import evaluated
from ..phase.mode_conditions import conditions_of, elsewhere, set_modes
from ..phase.phase_record import PhaseData
from .event_run import BESIDE, EventRun
from .impulse_system import add_row, impelled_by, products
from .limits import LOW, SMALL, SUMMED
from .moment import add_response, copy, largest, look, response, row_of, slip_speed
from .problem import apart, couple, name_island


@compiled
def set_up(it: EventRun, contacts: Contacts) -> None:
    """Write the equations of the modes: independent conditions, endings, and how the modes are shown."""
    phase, size = PhaseData(it.phase), 1.0 + largest(it.y, it.n_q)
    find_dead(it, contacts)
    find_active(it, contacts)
    set_modes(phase, it.mode, it.dead, it.active, it.actives)
    for r in range(it.rows):
        phase.force[r] = 0.0
    for k in range(it.contacts):
        mode = it.mode[k]
        phase.band[k] = band_of(it, k, size)
        for j in range(2):
            phase.direction[k, j] = it.way[k, j]
        # beside a dead centre a slip begins whose rate is still zero
        along = mode == laws.SLIDE_ON or mode == laws.SLIDE_BACK
        if mode == laws.LIMIT or (along and it.dead[k] != 0 and it.holding != BESIDE):
            mode = laws.STICK
        elif mode == laws.SMOOTH:
            mode = laws.SLIDE
        it.shown[k] = mode


@compiled
def band_of(it: EventRun, k: int, size: float) -> float:
    """Return the gap at which a contact closes: 0, or the present gap if that is negative by round-off.

    ``size`` is 1 m or the greatest coordinate.

    An open gap that leaves zero changes sign by its round-off, before it is open. The flight is one so low that
    bounces are summed there (`bounces`), and does not notice that it lands lower by it. A contact that is deep and not
    closed is behind its sides, and closes at 0 once it has come around them.
    """
    gap, v = it.gap[k], it.rate[it.first[k]]
    low = LOW * size
    if gap < -it.near and (it.compliant[k] != 0 or it.closed[k] == 0):
        return 0.0
    if it.compliant[k] != 0:
        return lesser(gap, 0.0)
    leaves = (
        it.mode[k] == laws.OPEN and gap <= low and v >= -it.still and v * it.flight[k] <= 2.0 * SUMMED * size
    )
    return lesser(gap, 0.0) - low if leaves else lesser(gap, 0.0)


@compiled
def listed(it: EventRun) -> int:
    """List the conditions of closed contacts; return their number."""
    count = 0
    for k in range(it.contacts):
        count = add_conditions(it, count, k)
    return count


@compiled
def listed_in(it: EventRun, island: int) -> int:
    """List the conditions of closed contacts of an island; return their number."""
    count = 0
    for k in range(it.contacts):
        if it.island[k] == island:
            count = add_conditions(it, count, k)
    return count


@compiled
def add_conditions(it: EventRun, count: int, k: int) -> int:
    """Append the conditions of a contact to the list; return the number of its rows."""
    for j in range(conditions_of(it.tangents[k], it.mode[k], it.held[k])):
        count = add_row(it, count, it.first[k] + j + it.held[k], 0.0)
    return count


@compiled
def find_islands(it: EventRun) -> None:
    """Find the islands of closed contacts and of those that touch, their conditions, and the numbers of these."""
    apart(it)
    count = 0
    for k in range(it.contacts):
        if it.mode[k] != laws.OPEN or abs(it.gap[k]) <= it.near:
            couple(it, k)
    for k in range(it.contacts):
        name_island(it, k)
        own = conditions_of(it.tangents[k], it.mode[k], it.held[k])
        it.holds[it.island[k]] += own
        it.condition[k], count = count, count + own


@compiled
def find_active(it: EventRun, contacts: Contacts) -> None:
    """Find independent conditions of closed contacts, island by island (`find_islands`)."""
    it.actives = it.spare_count = 0
    for b in range(it.blocks):
        if it.holds[b] > 0:
            count = listed_in(it, b)
            find_independent(it, contacts, count)
            for a in range(count):
                k = it.owner[it.list[a]]
                if contacts.order[a] != 0 and it.actives < it.n:
                    it.active[it.actives] = it.condition[k] + it.list[a] - it.first[k] - it.held[k]
                    it.actives += 1
                else:
                    it.spare_count += 1


@compiled
def find_independent(it: EventRun, contacts: Contacts, count: int) -> int:
    """Set ``order`` to 1 for independent rows of the list, by Cholesky pivots of A, the largest first.

    With small pivots the round-off of what follows would pass for independence. Return the number of these rows.
    """
    for a in range(count):
        for b in range(count):
            contacts.A[a * count + b] = response(it, it.list[a], it.list[b])
    return factor(contacts.A, count, contacts.factors, laws.DEPENDENT, contacts.left, contacts.order)


@compiled
def has_spare(it: EventRun, contacts: Contacts) -> int:
    """Return 1 if conditions of the chosen contacts depend on others of these, else 0."""
    count = 0
    for i in range(it.count):
        count = add_conditions(it, count, it.chosen[i])
    return 1 if find_independent(it, contacts, count) < count else 0


@compiled
def find_dead(it: EventRun, contacts: Contacts) -> None:
    """Find the contacts that the others hold in place: open contacts at zero gap, or slip at zero slip velocity.

    Their rows and accelerations depend on those of the others, so the functions that end their modes stay at zero. A
    row that depends at one moment only, since the body turns, has an acceleration of its own by that.
    """
    find_islands(it)
    found, phase = 0, PhaseData(it.phase)
    for k in range(it.contacts):
        mode, it.dead[k] = it.mode[k], 0
        if mode == laws.OPEN:  # a corner beside its side, or a side beside its corner, does not touch
            touches = abs(it.gap[k]) <= it.near and elsewhere(phase, it.mode, k) == 0
            it.dead[k] = 1 if touches and it.held[k] == 0 else 0
        elif mode == laws.SLIDE_ON or mode == laws.SLIDE_BACK:
            it.dead[k] = 1 if abs(it.rate[it.first[k] + 1]) <= it.still else 0
        found += it.dead[k]
    if found == 0:
        return
    most, last, count, kept = largest(it.c, it.rows), -1, 0, 0
    for k in range(it.contacts):
        if it.dead[k] != 0:
            r = it.first[k] if it.mode[k] == laws.OPEN else it.first[k] + 1
            if it.island[k] != last:
                last = it.island[k]
                count = listed_in(it, last) if it.holds[last] > 0 else 0
                kept = products(it, contacts, 0, count)
            if count == 0 or is_combined(it, contacts, r, count, kept) == 0 or parts(it, r, count, most) != 0:
                it.dead[k] = 0


@compiled
def depends(it: EventRun, contacts: Contacts, r: int, count: int) -> int:
    """Return 1 if a row depends on the rows of the list, else 0."""
    return is_combined(it, contacts, r, count, products(it, contacts, 0, count))


@compiled
def is_combined(it: EventRun, contacts: Contacts, r: int, count: int, kept: int) -> int:
    """Return 1 if a row depends on the rows of the list, whose `products` are known, else 0."""
    rest, size, v = 0.0, 0.0, it.v
    for a in range(count):
        it.goal[a] = response(it, it.list[a], r)
    impelled_by(it, contacts, 0, count, kept)
    copy(row_of(it, it.X, r), v, it.n)
    for i in range(it.n):
        size += v[i] * v[i]
    for a in range(count):
        add_response(it, -it.x[a], it.list[a], v)
    for i in range(it.n):
        rest += v[i] * v[i]
    return 1 if rest <= SMALL * SMALL * size else 0


@compiled
def parts(it: EventRun, r: int, count: int, most: float) -> int:
    """Return 1 if a row that depends on those of the list accelerates where they do not, else 0.

    With W_r = Σ x W_a, all forces and loads cancel in c_r - Σ x c_a. The rest follows from the speeds; ``most`` is the
    greatest acceleration of a row.
    """
    a = it.c[r]
    for i in range(count):
        a -= it.x[i] * it.c[it.list[i]]
    return 1 if abs(a) > SMALL * most else 0


@compiled
def project(it: EventRun) -> None:
    """Move the state onto the conditions of the phase."""
    if PhaseData(it.phase).active == 0:
        return
    for _ in range(3):
        it.projection(it.t, it.y, it.phase, it.step)
        for i in range(it.n_q + it.n):
            it.y[i] = it.step[i]
        normalise(it)


@compiled
def normalise(it: EventRun) -> None:
    """Divide each quaternion of the state by its norm."""
    to_unit(it.y, it.quaternions, it.turned)


@compiled
def find_flights(it: EventRun) -> None:
    """Set ``flight``, the time to the highest point, of open contacts that leave a surface and return to it at once.

    Of others it is 0.
    """
    leaving = 0
    for k in range(it.contacts):
        leaves = it.mode[k] == laws.OPEN and abs(it.gap[k]) <= it.near and it.rate[it.first[k]] > it.still
        it.flight[k] = 1.0 if leaves else 0.0
        leaving += 1 if leaves else 0
    if leaving == 0:
        return
    it.accelerations(it.t, it.y, it.phase, it.speeds)
    for k in range(it.contacts):
        if it.flight[k] != 0.0:
            v, a = it.rate[it.first[k]], -it.speeds[it.first[k]]
            it.flight[k] = v / a if a > 0.0 else 0.0


@compiled
def shortest_flight(it: EventRun) -> float:
    """Return the shortest time to the highest point of a flight; 0 if there is none."""
    result = 0.0
    for k in range(it.contacts):
        if it.flight[k] > 0.0 and (result == 0.0 or it.flight[k] < result):
            result = it.flight[k]
    return result


@compiled
def begins_slip(it: EventRun, k: int) -> int:
    """Return 1 if a slip of a contact in space begins at rest, else 0."""
    slides = it.mode[k] == laws.SLIDE and it.tangents[k] == 2 and it.rough[k] != 0
    return 1 if slides and slip_speed(it, k) <= it.still else 0


@compiled
def leaves_rest(it: EventRun, k: int) -> int:
    """Return 1 if a slip of a contact, in space or along a line, begins at rest, else 0.

    One along a line that the others hold in place (`find_dead`) does not begin.
    """
    along = (it.mode[k] == laws.SLIDE_ON or it.mode[k] == laws.SLIDE_BACK) and it.dead[k] == 0
    return 1 if begins_slip(it, k) != 0 or (along and slip_speed(it, k) <= it.still) else 0


@compiled
def set_bands(it: EventRun) -> None:
    """Write the gaps at which contacts close."""
    phase, size = PhaseData(it.phase), 1.0 + largest(it.y, it.n_q)
    for k in range(it.contacts):
        phase.band[k] = band_of(it, k, size)


@compiled
def lift(it: EventRun, contacts: Contacts) -> None:
    """Move contacts that open from a slightly negative gap (closed within tolerance) to gap zero.

    Their return is then a zero crossing of the gap; from a negative gap it would not be. It is the least motion that
    leaves no gap of a closed contact negative, g + W dq >= 0, dq = M⁻¹ Wᵀ x, x >= 0: an impact without friction whose
    speeds are gaps. Equations for all gaps would turn bodies by the gap over the distance of two contacts.
    """
    low, below, count = LOW * (1.0 + largest(it.y, it.n_q)), 0, 0
    for k in range(it.contacts):
        if it.closed[k] != 0:
            below += 1 if it.gap[k] < -low and it.rate[it.first[k]] > it.still else 0
            count = add_row(it, count, it.first[k], it.gap[k])
    if below == 0:
        return
    contacts.contacts, contacts.rows, contacts.equalities = count, count, 0
    for a in range(count):
        contacts.at[a], contacts.tangents[a], contacts.given[a] = a, 0, it.goal[a]
        contacts.friction[a] = contacts.static[a] = contacts.least[a] = 0.0
        contacts.slides[a], contacts.held[a], contacts.presser[a] = 0, 0, -1
        for b in range(count):
            contacts.A[a * count + b] = response(it, it.list[a], it.list[b])
    run_by(it.finding, contacts)
    displace(it, contacts.forces, count)


@compiled
def displace(it: EventRun, impulses: Reals, count: int) -> None:
    """Move the coordinates by M⁻¹ Wᵀ x, with numbers x for the rows of the list."""
    n, machine, state = it.n, PhaseData(it.looking), it.trial
    copy(it.y, state, it.n_y)
    for i in range(n):
        state[it.n_q + i] = 0.0
    evaluated(it.t, state, machine)
    copy(machine.q_dot, it.step, it.n_q)
    for a in range(count):
        add_response(it, impulses[a], it.list[a], state[it.n_q :])
    evaluated(it.t, state, machine)
    for i in range(it.n_q):
        it.y[i] += machine.q_dot[i] - it.step[i]
    look(it)
