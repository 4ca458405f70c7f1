"""Disks that lie flat, in compiled code: the four points on which they stand turn with the load.

A rigid disk on a plane is held as long as the centre of its normal forces, c = Σ N p/Σ N, lies within its edge. Four
fixed points hold it within their square only. So they turn about the axis, by an angle that is data:

- a point loses its force: a point is in the direction of c, and is the last one that presses as |c| grows to R;
- a decision lets the disk tip over a side of the square, so that accelerations of the rim, a + α cos φ + β sin φ,
  are negative somewhere: a point is where the disk stays, or where it tips about that point alone, whose acceleration
  is then the least of the rim, g(φ) = d a/dφ = 0. This angle is found by the secant between signs of g.

The plane of the disk and friction laws of points stay those of any contact.
"""

from __future__ import annotations

from ...native.instructions import compiled, root
from ..cones.contacts import Contacts
from ..kernels.hoisted import Hoisted
from ..kernels.renewal import renew
from ..phase import laws
from . import event_run, limits
from .decision import decide
from .event_run import EventRun
from .impulse_system import add_row, impelled
from .moment import acceleration_of, choose_all, look, normal_speed, set_response
from .setting import displace, normalise
from .slips.slip_starts import scale_of

POINTS = 4
HEIGHT = 2e-11
"""Height of the highest point over the lowest of a disk that begins to tip [m]: twice that of a flat one."""
ALIGNED = 1e-9
"""Sine of an angle from which points turn, and the part of the greatest acceleration of a contact that is one."""
EIGHTHS, STEPS = 8, 60
"""Number of steps of an eighth of a turn in search of a change of the sign of g, and of secants between two signs."""


@compiled
def turn(it: EventRun, i: int, cosine: float, sine: float) -> None:
    """Turn the points of an edge by an angle."""
    p, at = Hoisted(it.hoisted).parameters, it.ring_at[i]
    x, y = p[at] * cosine - p[at + 1] * sine, p[at] * sine + p[at + 1] * cosine
    set_turned(it, i, x, y)


@compiled
def set_turned(it: EventRun, i: int, x: float, y: float) -> None:
    """Set the points of an edge to the direction (x, y), and look at them."""
    hoisted, at, size = Hoisted(it.hoisted), it.ring_at[i], root(x * x + y * y)
    hoisted.parameters[at], hoisted.parameters[at + 1] = x / size, y / size
    renew(hoisted)
    look(it)
    for j in range(POINTS):
        k = it.ring_first[i] + j
        it.reason[k] = event_run.RESULTANT


@compiled
def turn_to(it: EventRun, i: int, x: float, y: float) -> int:
    """Turn the points of an edge, by at most an eighth of a turn, until one has the direction (x, y) of the first two.

    Return 1 if they have turned.
    """
    for _ in range(POINTS):
        if x < abs(y) or (x == abs(y) and y < 0.0):
            x, y = y, -x
    size = root(x * x + y * y)
    if not size > 0.0 or abs(y) <= ALIGNED * size:
        return 0
    turn(it, i, x / size, y / size)
    return 1


@compiled
def follow_load(it: EventRun) -> None:
    """Turn the points of edges of which one has lost its force in the last phase to the resultant."""
    for i in range(it.rings):
        if presses(it, i) != 0 and lies_flat(it, i) != 0:
            k = it.ring_first[i]
            it.forces(it.t, it.y, it.phase, it.speeds)
            a, b = it.speeds[it.first[k]], it.speeds[it.first[k + 1]]
            c, d = it.speeds[it.first[k + 2]], it.speeds[it.first[k + 3]]
            lost = 0
            for j in range(POINTS):
                small = it.speeds[it.first[k + j]] <= limits.SMALL * (a + b + c + d)
                lost += 1 if small and it.mode[k + j] != laws.OPEN else 0
            if lost > 0:
                turn_to(it, i, a - c, b - d)


@compiled
def presses(it: EventRun, i: int) -> int:
    """Return the number of the points of an edge that are closed in the present modes."""
    closed = 0
    for j in range(POINTS):
        closed += 1 if it.mode[it.ring_first[i] + j] != laws.OPEN else 0
    return closed


@compiled
def lies_flat(it: EventRun, i: int) -> int:
    """Return 1 if all points of an edge touch and are at rest along the normal, else 0."""
    for j in range(POINTS):
        k = it.ring_first[i] + j
        if it.closed[k] == 0 or abs(normal_speed(it, k)) > it.still:
            return 0
    return 1


@compiled
def least_of_rim(it: EventRun, i: int) -> float:
    """Return the least acceleration of the gaps of an edge."""
    k = it.ring_first[i]
    set_response(it, it.force)
    a, b = acceleration_of(it, it.first[k]), acceleration_of(it, it.first[k + 1])
    c, d = acceleration_of(it, it.first[k + 2]), acceleration_of(it, it.first[k + 3])
    return (a + b + c + d) / 4.0 - root((a - c) * (a - c) + (b - d) * (b - d)) / 2.0


@compiled
def slope(it: EventRun, i: int) -> float:
    """Return the change of the acceleration along the rim at the first point, or the sign of it if that is open."""
    k, most = it.ring_first[i], scale_of(it)
    if it.mode[k] == laws.OPEN and it.mode[k + 1] != laws.OPEN:
        return -most
    if it.mode[k] == laws.OPEN and it.mode[k + 3] != laws.OPEN:
        return most
    set_response(it, it.force)
    return (acceleration_of(it, it.first[k + 1]) - acceleration_of(it, it.first[k + 3])) / 2.0


@compiled
def tips(it: EventRun, i: int) -> int:
    """Return 1 if a decision lets some of a rim that lies flat go into its plane, else 0."""
    if lies_flat(it, i) == 0:
        return 0
    return 1 if least_of_rim(it, i) < -ALIGNED * scale_of(it) else 0


@compiled
def decide_at(it: EventRun, contacts: Contacts, i: int, x: float, y: float) -> int:
    """Decide with the points of an edge in a direction; return why that fails, or 0."""
    set_turned(it, i, x, y)
    choose_all(it)
    return decide(it, contacts)


@compiled
def stand(it: EventRun, contacts: Contacts) -> int:
    """Decide again with other angles of edges that tip over a side of their points; return why that fails, or 0."""
    for i in range(it.rings):
        why, k = 0, it.ring_first[i]
        if (
            presses(it, i) == 2 and lies_flat(it, i) != 0
        ):  # it may be about to tip, without any acceleration yet
            a, b, c, d = it.first[k], it.first[k + 1], it.first[k + 2], it.first[k + 3]
            if turn_to(it, i, it.force[a] - it.force[c], it.force[b] - it.force[d]) != 0:
                choose_all(it)
                why = decide(it, contacts)
        if why == 0 and tips(it, i) != 0:
            why = find_angle(it, contacts, i)
        if why == 0 and only_bearer(it, i) >= 0 and lies_flat(it, i) != 0:
            tilt(it, contacts, i)
            choose_all(it)
            why = decide(it, contacts)
        if why != 0:
            return why
    return 0


@compiled
def only_bearer(it: EventRun, i: int) -> int:
    """Return which point of an edge alone bears force in a decision, or -1: one that only touches bears none."""
    found, total = -1, 0.0
    for j in range(POINTS):
        total += it.force[it.first[it.ring_first[i] + j]]
    for j in range(POINTS):
        if it.force[it.first[it.ring_first[i] + j]] > limits.SMALL * total:
            if found >= 0:
                return -1
            found = j
    return found


@compiled
def tilt(it: EventRun, contacts: Contacts, i: int) -> None:
    """Tilt a disk about the only point of its edge that presses, so far that it stands on its lowest point.

    From zero, the lowest point of a tilt that grows would have no direction; it is the one that presses.
    """
    first = it.ring_first[i]
    lay(it, contacts, first, only_bearer(it, i), HEIGHT)
    for j in range(POINTS):
        it.reason[first + j] = event_run.TIPS
    it.reason[it.side[first]] = event_run.TIPS


@compiled
def lay(it: EventRun, contacts: Contacts, first: int, p: int, height: float) -> None:
    """Lay a disk so that point p of its edge is in the plane, and the opposite one at a height over it."""
    count = 0
    for j in range(3):
        k = first + (p + j) % POINTS
        count = add_row(it, count, it.first[k], height * j / 2.0 - it.gap[k])
    impelled(it, contacts, count)
    displace(it, it.x, count)
    normalise(it)
    look(it)


@compiled
def lands(it: EventRun, contacts: Contacts) -> int:
    """Lay a disk flat whose edge touches and whose steps collapse as it falls flat from less than `HEIGHT`; return 1.

    Places are known to 1e-17 m, so the lowest point of such a tilt to 1e-6 of a turn only, and a fast one turns by
    radians within the 1e-12 s that are left. Return 0 if there is none.
    """
    for i in range(it.rings):
        first, low, change = it.ring_first[i], 1, 0.0
        for j in range(POINTS):
            low = low if it.gap[first + j] < HEIGHT else 0
            change += normal_speed(it, first + j)
        if it.mode[it.side[first]] != laws.OPEN and low != 0 and change < -it.still:
            lay(it, contacts, first, 0, 0.0)
            return 1
    return 0


@compiled
def find_angle(it: EventRun, contacts: Contacts, i: int) -> int:
    """Decide with the angle at which a disk stands, or tips about one point; return why that fails, or 0."""
    first, p, at = it.ring_first[i], Hoisted(it.hoisted).parameters, it.ring_at[i]
    press, best = 0, 0.0
    for j in range(POINTS):
        N = it.force[it.first[first + j]]
        if best < N:
            press, best = j, N
    x, y = p[at], p[at + 1]
    for _ in range(press):
        x, y = -y, x
    why = decide_at(it, contacts, i, x, y)
    if why != 0 or tips(it, i) == 0:
        return why
    g_low, g_high = slope(it, i), 0.0
    way = -1.0 if g_low > 0.0 else 1.0
    for _ in range(EIGHTHS):
        why = decide_at(it, contacts, i, x - way * y, y + way * x)
        if why != 0 or tips(it, i) == 0:
            return why
        g_high = slope(it, i)
        if (g_high > 0.0) != (g_low > 0.0):
            return find_between(it, contacts, i, x, y, g_low, g_high)
        x, y, g_low = p[at], p[at + 1], g_high
    return 0


@compiled
def find_between(
    it: EventRun, contacts: Contacts, i: int, x: float, y: float, g_low: float, g_high: float
) -> int:
    """Decide with the angle, within an eighth of a turn from the direction (x, y), at which g = 0, by the secant."""
    low, high = 0.0, 1.0 if g_low <= 0.0 else -1.0
    for _ in range(STEPS):
        tangent = low + g_low / (g_low - g_high) * (high - low)
        why = decide_at(it, contacts, i, x - tangent * y, y + tangent * x)
        if why != 0 or tips(it, i) == 0:
            return why
        g = slope(it, i)
        if (g > 0.0) == (g_high > 0.0):  # Illinois: the end that stays counts half
            high, g_high, g_low = tangent, g, g_low / 2.0
        else:
            low, g_low, high, g_high = high, g_high, tangent, g
    return 0
