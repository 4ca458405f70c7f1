"""Motion with contacts, from event to event.

    between events   the usual loop integrates the compiled equations of one set of modes (open, stick, slip)
    events           a gap closes, N falls to zero, |T| reaches μ_s N, the slip stops, a contact leaves its surface
    at an event      impulses if contacts approach (`impacts`), then modes from the contact problem of the
                     accelerations (`complementarity` for few contacts, `cone_problem` for many and for indeterminate
                     forces); if a law holds with equality, derivatives along each candidate decide

Bounces too low to follow are summed (`bounces`). Slip in space begins and ends with a straight step (`leaps`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...errors import SimulationError
from ..ending import End
from ..ode.dense_output import Array, Path, Rates, projected
from ..ode.integration import Integration
from ..phase.places import STOPPED
from ..phase.scene import Ending, Modes, Phase, Snapshot
from ..trajectory.phases import Phases, Segment
from .bounces import lifted, limit
from .bounces import settled as taken_away
from .complementarity import OPEN, SMALL
from .leaps import LONGEST, fading, halt, held, onset
from .modes import modes_at
from .state import CROWD, ENDLESS, LOW, PHASES, ContactRun

SLOW = 10 * STOPPED
"""Slip speed in space below which a body comes to rest at all its contacts at once, where events crowd [m/s]."""
LOOKS = 32
"""Steps at which indeterminate forces are checked: the first ones of a phase, and as many spread along it."""


@dataclass(frozen=True)
class Change:
    """Mode of a contact from ``start`` to ``end`` [s], and the reason why it began."""

    contact: str
    mode: str
    start: float
    end: float
    why: str

    def __str__(self) -> str:
        return f"{self.contact}: {shown(self.mode)} from {self.start:.6g} to {self.end:.6g} s ({self.why})"


def shown(mode: str) -> str:
    """Return the printed form of a mode."""
    return {"slip+": "slip +", "slip-": "slip -"}.get(mode, mode)


def check_apart(work: ContactRun, y: Array, seen: Snapshot) -> None:
    """Raise if bodies are inside each other in the initial state."""
    deepest = min(range(len(work.names)), key=lambda k: seen.gap[k] if seen.reach[k] >= 0 else math.inf)
    if seen.gap[deepest] < -work.near(y) and seen.reach[deepest] >= 0:
        raise SimulationError(
            f"The initial state of '{work.model.name}' has contact '{work.names[deepest]}' {-seen.gap[deepest]:.6g} m "
            f"deep. Begin with every gap at zero or above."
        )


def run(
    work: ContactRun, state: Array, begin: float, end: float, between: Callable[[float], None] | None
) -> Phases:
    """Return the path from ``state`` (q, u) at ``begin`` to ``end``; ``work`` records happenings and mode changes."""
    n = work.n + work.n_u
    y = np.concatenate([state[:n], [0.0, 0.0]])
    t = begin
    work.rates = None
    current: Modes = ("",) * len(work.names)
    past = current
    reasons: dict[int, str] = {}
    status, crowded, last = End.RUNNING, 0, -math.inf
    seen = work.look(t, y)
    check_apart(work, y, seen)
    while True:
        if status:
            if status != End.FINISHED or not work.blows_due(t):
                break
            y, status = work.struck(t, y), End.RUNNING
            reasons = dict.fromkeys(range(len(work.names)), "a blow")
        target = work.target(end)
        work.left.clear()
        crowded = crowded + 1 if t - last <= CROWD else 0
        last = t
        _check_endless(work, t, crowded, current)
        seen = work.look(t, y)
        y, hit = work.collide(t, y, seen)
        if crowded in (ENDLESS // 4, ENDLESS // 2):
            y = _slowed(work, t, _quieted(work, t, y))
        settled = limit(work, t, y) if hit else None
        if settled is not None:
            settled = (_quieted(work, t, settled[0]), *settled[1:])
            t, y, current, past, reasons, status = _rest(work, t, y, settled, current, past, target, between)
            continue
        y = lifted(work, t, y)
        if work.joined(t, y):
            continue
        y = _still(work, t, y)
        modes, one, seen = modes_at(work, t, y, current)
        modes = held(work, t, y, modes, one, seen)
        phase, rates, watch, endings = work.setup(modes, y, seen)
        low = LOW * (1 + work.size(y))
        flights = _flights(work, t, y, modes, phase)
        unseen = frozenset(k for k, (v, a) in flights.items() if v * v / (2 * a) < low)
        if unseen:  # a flight lower than the round-off of its gap is no flight
            y = taken_away(work, t, y, seen, unseen)
            work.bounces.clear()
            continue
        for i in np.flatnonzero(phase.loose):
            work.indeterminate.setdefault(work.scene.names[i], t)
        shown_now = phase.shown
        _note_modes(work, t, y, past, shown_now, reasons, hit, _decided(work, phase, modes, seen, y))
        current, past = modes, shown_now
        if t >= target:
            status = _ended(work, phase, rates, t, y)
            continue
        returns = (v / a for v, a in flights.values())  # a straight step beyond them would lose their impacts
        before = y
        t, y = onset(work, t, y, modes, one, seen, target, min(LONGEST, *returns, LONGEST))
        if t >= target:
            status = End.FINISHED
            continue
        if y is not before:
            phase, rates, watch, endings = work.setup(modes, y, seen)
        y = lifted(work, t, projected(rates, t, y))
        if work.joined(t, y):
            continue
        t, after = fading(work, phase, rates, t, y, modes)
        if after is not y:
            y = after
            continue
        t, y, reasons, status = _phase(work, phase, rates, watch, endings, t, y, target, modes, between)
    for change in work.changes:
        change[3] = t if change[3] is None else change[3]
    return Phases(tuple(work.segments), status)


def _ended(work: ContactRun, phase: Phase, rates: Rates, t: float, y: Array) -> End:
    """Record a phase without length, the last one, and return the status."""
    tail = Path(rates, np.array([t]), np.empty(0), y[None], (), End.FINISHED, 0, 0, 0)
    work.segments.append(Segment(tail, phase, work.impulses, phase.shown, phase.loose))
    return End.FINISHED


def _check_endless(work: ContactRun, t: float, crowded: int, current: Modes) -> None:
    """Raise if too many modes changed at one moment, or in the run."""
    if crowded > ENDLESS or len(work.segments) > PHASES:
        states = ", ".join(f"{a}: {b}" for a, b in zip(work.names, current, strict=True))
        raise SimulationError(
            f"Contacts of '{work.model.name}' change their modes again and again at t = {t:.9g} s ({states}), "
            f"{len(work.segments)} phases so far. Impacts that end in a finite time only together (restitution of "
            f"several contacts at once; a coin that comes to lie flat on its two edges) do this: "
            f"method='timestepping' with step= goes through them."
        )


def _decided(work: ContactRun, phase: Phase, modes: Modes, seen: Snapshot, y: Array) -> bool:
    """Return True if the shares of indeterminate forces decide the motion with these modes."""
    if not work.shared or not phase.spare:
        return False
    contacts = [work.touching(seen, k, work.still(y)) for k, mode in enumerate(modes) if mode != OPEN]
    closed = [k for k, mode in enumerate(modes) if mode != OPEN]
    return work.spread(modes, seen, y) > 10 * work.alike(contacts, seen, closed, y)


def _check_shared(work: ContactRun, phase: Phase, path: Path, modes: Modes) -> None:
    """Raise if the friction of indeterminate forces would decide the motion, unless ``work.shared`` permits it."""
    if work.shared or not phase.spare:
        return
    count = len(path.times)
    for i in np.unique([*range(min(count, LOOKS)), *np.linspace(0, count - 1, LOOKS).astype(int)]):
        t, y = float(path.times[i]), path.states[i]
        seen = work.look(t, y)
        closed = [k for k, mode in enumerate(modes) if mode != OPEN]
        alike = 10 * work.alike([work.touching(seen, k, work.still(y)) for k in closed], seen, closed, y)
        if work.spread(modes, seen, y) > alike:
            names = ", ".join(f"'{work.names[k]}'" for k in closed)
            raise SimulationError(
                f"The normal forces of contacts {names} at t = {t:.9g} s are statically indeterminate, and with "
                "different friction, or a turn as they slide, each distribution moves the machine differently. Give "
                "them equal friction, or fewer contacts, or take indeterminate='compliance'."
            )


def _phase(
    work: ContactRun, phase: Phase, rates: Rates, watch: Any, endings: Sequence[Ending], t: float, y: Array,
    end: float, modes: Modes, between: Any,
) -> tuple[float, Array, dict[int, str], End]:  # fmt: skip
    """Integrate one phase to its end. Return time, state, reasons by contact, and the status if the run ends."""
    # half of the shortest flight: a longer step could jump over the return of a contact
    first_step = min((v / a for v, a in _flights(work, t, y, modes, phase).values()), default=None)
    if watch is not None:
        phase.closing_at(watch.keep, watch.constants, work.look(t, y).gap)
    way = Integration(
        rates, work.relative, watch, first_step=first_step, max_steps=work.steps_left, **work.options
    )
    path = way.path(y, t, end, work.absolute, between)
    work.steps_left = None if work.steps_left is None else work.steps_left - path.steps
    _check_depth(work, path, modes)
    _check_shared(work, phase, path, modes)
    asked = len(work.specs)
    mine = [c for c in path.crossings if c.number >= asked]
    shown_ = tuple(c for c in path.crossings if c.number < work.asked)
    work.segments.append(
        Segment(replace(path, crossings=shown_), phase, work.impulses, phase.shown, phase.loose)
    )
    if path.status == End.FINISHED:
        return path.end, path.states[-1], {}, End.FINISHED
    if path.status != End.TERMINAL:
        return path.end, path.states[-1], {}, path.status
    t_new, y_new = path.end, path.states[-1].copy()
    if any(
        c.time == path.end and c.number < work.asked and work.specs[c.number].terminal for c in path.crossings
    ):
        return t_new, y_new, {}, End.TERMINAL
    reasons: dict[int, str] = {}
    for c in path.crossings:
        if work.asked <= c.number < asked and c.time == path.end:
            y_new = work.struck_by(c.number - work.asked, t_new, y_new)
            reasons = dict.fromkeys(range(len(work.names)), "a blow")
    stopped = []
    # at the end of a side N may reach 0 too: the reason is the end
    for c in sorted(mine, key=lambda c: endings[c.number - asked].law != "normal"):
        ending = endings[c.number - asked]
        reasons[ending.contact] = why = _why(work, phase, ending, t_new, y_new)
        if ending.law in (
            "reach",
            "side",
        ):  # the corner takes over from its side, or the side from the corner
            here = (ending.contact, ending.place)
            reasons.update((j, why) for j, sides in work.scene.ends.items() if here in sides)
        if ending.law == "slip" and work.scene.tangents[ending.contact] == 2:
            stopped.append(ending.contact)
    for k in stopped:
        t_new, y_new = halt(work, phase, rates, k, t_new, y_new, modes)
    return t_new, y_new, reasons, End.RUNNING


def _quieted(work: ContactRun, t: float, y: Array) -> Array:
    """Return the state with all contacts at rest that bounce no higher than 1e-12 m.

    Used when bounces end, or when events crowd at one moment.
    """
    seen = work.look(t, y)
    low = 1e-12 * (1 + work.size(y))
    quiet = frozenset(
        k
        for k in work.closed(t, seen, y)
        for v, a in ((seen.rate[work.scene.first[k]], -seen.c[work.scene.first[k]]),)
        if a > 0 and abs(v) > work.still(y) and v * v / (2 * a) < low
    )
    if not quiet:
        return y
    y = taken_away(work, t, y, seen, quiet)
    names = ", ".join(work.names[k] for k in sorted(quiet))
    work.tell(t, "rest", y, y, f"{names}: bounces lower than {low:.0e} m end here")
    work.bounces.clear()
    return y


def _still(work: ContactRun, t: float, y: Array) -> Array:
    """Return the state without the approach that corrections left to contacts that have collided at this moment."""
    if not work.approaching(t, y):
        return y
    seen, still, first = work.look(t, y), work.still(y), work.scene.first
    return taken_away(
        work, t, y, seen, frozenset(k for k in work.closed(t, seen, y) if seen.rate[first[k]] < -still)
    )


def _slowed(work: ContactRun, t: float, y: Array) -> Array:
    """Return the state without slips in space slower than :data:`SLOW`, where events crowd at one moment.

    A body that turns about one of its contacts as it stops has no direction of slip there, and a straight step that
    begins one outlasts the slip at the others. The impulses move the masses least: the energy falls.
    """
    seen, scene = work.look(t, y), work.scene
    closed = [k for k in work.closed(t, seen, y) if abs(seen.rate[scene.first[k]]) <= work.still(y)]
    speeds = {k: work.speed(seen, k) for k in closed}
    slow = [k for k in closed if scene.tangents[k] == 2 and not work.smooth(seen, k) and speeds[k] <= SLOW]
    if not any(speeds[k] > work.still(y) for k in slow):
        return y
    rows = [scene.first[k] for k in closed] + [scene.first[k] + j for k in slow for j in (1, 2)]
    impulses = np.zeros(scene.rows)
    impulses[rows] = np.linalg.lstsq(seen.between(rows), -seen.rate[rows], rcond=SMALL)[0]
    after = y.copy()
    after[work.n : work.n + work.n_u] += impulses @ seen.responses
    work.impulses += work.gained(t, y, seen, impulses)
    names = ", ".join(work.names[k] for k in slow)
    work.tell(t, "rest", y, after, f"{names}: slips slower than {SLOW:.0e} m/s end here together")
    return after


def _rest(
    work: ContactRun, t: float, y: Array, settled: Any, current: Modes, past: Modes, end: float, between: Any
) -> tuple[float, Array, Modes, Modes, dict[int, str], End]:
    """Replace the remaining time of bounces that are too low to follow by motion in contact."""
    y, left, contacts = settled
    if work.joined(t, y):
        work.bounces.clear()
        return t, y, current, past, {}, End.RUNNING
    y = _still(work, t, y)
    modes, one, seen = modes_at(work, t, y, current)
    modes = held(work, t, y, modes, one, seen)
    until = min(t + left, end)
    names = ", ".join(work.names[k] for k in sorted(contacts))
    phase, rates, watch, endings = work.setup(modes, y, seen)
    _note_modes(
        work, t, y, past, phase.shown, dict.fromkeys(contacts, "bounces below what numbers resolve"), True
    )
    work.bounces.clear()
    t, y = onset(work, t, y, modes, one, seen, until)
    phase, rates, watch, endings = work.setup(modes, y, seen)
    y = lifted(work, t, projected(rates, t, y))
    reasons: dict[int, str] = {}
    if until > t:
        t, y, reasons, stop = _phase(work, phase, rates, watch, endings, t, y, until, modes, between)
        if stop and (stop != End.FINISHED or t >= end):
            return t, y, modes, phase.shown, {}, stop
    if not reasons:  # else another event came before the end of the bounces
        work.tell(t, "rest", y, y, f"{names}: the bounces end here, the limit of their geometric series")
        reasons = dict.fromkeys(contacts, "end of the bounces, the limit of a geometric series")
    return t, y, modes, phase.shown, reasons, End.RUNNING


def _why(work: ContactRun, phase: Phase, ending: Ending, t: float, y: Array) -> str:
    if ending.law == "gap":
        return "the gap closed"
    if ending.law == "normal":
        return "N reached 0"
    if ending.law == "reach":
        return "the end of the side"
    if ending.law == "side":
        return "the foot came onto the side"
    if ending.law == "slip":
        return "the slip stopped"
    force = work.along(phase, "force", t, y)
    at, n = work.scene.first[ending.contact], work.scene.tangents[ending.contact]
    return f"|T| reached {float(np.linalg.norm(force[at + 1 : at + 1 + n])):.6g} N"


def _note_modes(
    work: ContactRun,
    t: float,
    y: Array,
    before: Modes,
    after: Modes,
    reasons: Mapping[int, str],
    hit: bool,
    compliance: bool = False,
) -> None:
    for k, name in enumerate(work.names):
        if before[k] == after[k]:
            continue
        first = before[k] == ""
        why = reasons.get(k) or (
            "the start" if first else "an impact" if hit else "a change at another contact"
        )
        if compliance and after[k] != OPEN:
            why += "; equal compliance shares the forces"
        for change in work.changes:
            if change[0] == name and change[3] is None:
                change[3] = t
        work.changes.append([name, after[k], t, None, why])
        if not first:
            work.tell(t, name, y, y, f"contact {name}: {shown(before[k])} → {shown(after[k])}, {why}")


def _flights(
    work: ContactRun, t: float, y: Array, modes: Modes, phase: Phase
) -> dict[int, tuple[float, float]]:
    """(speed, deceleration) of open contacts that leave a surface and return to it at once in this phase."""
    seen = work.look(t, y)
    near, still = work.near(y), work.still(y)
    leaving = [
        k
        for k, mode in enumerate(modes)
        if mode == OPEN and abs(seen.gap[k]) <= near and seen.rate[work.scene.first[k]] > still
    ]
    if not leaving:
        return {}
    a = work.along(phase, "acceleration", t, y)
    return {
        k: (float(seen.rate[work.scene.first[k]]), -float(a[work.scene.first[k]]))
        for k in leaving
        if a[work.scene.first[k]] < 0
    }


def _check_depth(work: ContactRun, path: Path, modes: Modes) -> None:
    """Raise if a closing or a reversal of slip was passed over: a contact ends the phase deep or slipping back."""
    y = path.states[-1]
    if not np.isfinite(y).all():
        return
    seen, h = work.look(path.end, y), float(np.diff(path.times).max(initial=0))
    slow, near = 1e3 * work.still(y), work.near(y)
    for k, mode in enumerate(modes):
        v = float(seen.rate[work.scene.first[k] + 1]) if mode in ("slip+", "slip-") else 0.0
        if (v < -slow and mode == "slip+") or (v > slow and mode == "slip-"):
            raise SimulationError(
                f"Contact '{work.names[k]}' of '{work.model.name}' changed its sense of slip between {path.start:.9g} "
                f"and {path.end:.9g} s within one step of {h:.3g} s, and was passed over. Give a max_step shorter than "
                f"that, or take method='timestepping' with step=."
            )
    for k in np.flatnonzero((seen.gap < -near) & (seen.reach > 0)).tolist():
        if modes[k] == OPEN and path.start < path.end:
            before = work.look(path.start, path.states[0])
            behind = before.gap[k] < -near and math.isfinite(before.reach[k])  # came around its end
            deeper = seen.gap[k] < min(before.gap[k], 0.0) - near
            if before.reach[k] > 0 and deeper and not behind:
                raise SimulationError(
                    f"Contact '{work.names[k]}' of '{work.model.name}' closed between {path.start:.6g} and "
                    f"{path.end:.6g} s within one step of {h:.3g} s, and was passed over: it is {-seen.gap[k]:.3g} m "
                    f"deep. Give a max_step shorter than that contact lasts, or take method='timestepping' with step=."
                )
