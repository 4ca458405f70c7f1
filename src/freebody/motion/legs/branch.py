"""Positions of a linkage in which its conditions depend on each other, passed with the branch kept.

Bars of a parallelogram come into line: from there it could go on as a parallelogram, or crossed. The motion goes on
along its branch, which is smooth; what fails there are the equations: with the distance s from that position
(`dynamics.constrained.hold`) round-off ε of the state becomes accelerations that are wrong by ε/s³, and a step that is
controlled closes in on it. So a run that meets s = 0 is taken back to where s became small, and one step (`crossing`)
goes from as long before the meeting to as long after it. Steps of several lengths are tried: one is taken that agrees
with a longer one. A linkage that only comes near such a position meets nothing, or its steps do not agree: it goes on
by ordinary steps.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from ...dynamics.state import float_state
from ...native import loop
from ..kernels.kernels import Kernels
from ..ode.crossing import ROUNDED
from ..ode.dense_output import FINISHED, RELEASED, Array, Path, Rates, cut, observe, projected
from ..ode.integration import Halt
from ..start.loop_closure import nearly_dependent
from ..trajectory.phases import Happening

LIMIT = 0.2
"""s from which a position is looked for."""
SHARES = (1.0, 0.7, 0.5, 0.35, 0.25, 0.18)
"""Of the time from there to the meeting, at which steps across are tried, the longest first."""
CLOSE = 0.3  # of the limit: a run that came so close without turning away is on its way to s = 0
MET = 5e-3  # of the limit: below it s is 0 but for what is not known of the meeting
SEEN = 128  # places at which the motion is looked at
AGREED = 1e3
"""Units of the tolerance by which the coordinates of two steps may differ at worst; or ROUNDED, which no tolerance
makes smaller."""
CLOSED = 1e-11
"""What a condition may be missed by along a step, where the tolerance is less: some ten thousand units in the last
place, which the stages divide by s."""
SAMPLED = 12  # places at which two steps are compared
LONGEST = 10_000  # steps beside a position, from which on it is forgotten
SHOWN = 3  # names of conditions in a sentence

Leg = Callable[..., Path]
"""(kernels, rates, state, from, to, halt) and, for a step across, its method and whether events are watched."""


def closeness(kernels: Kernels, rates: Rates, times: Array, states: Array) -> Array:
    """s at states."""
    squares = observe(kernels.motion().address("hold"), 1, times, states, rates.constants)[:, 0]
    return np.sqrt(np.maximum(squares, 0))


def meets(kernels: Kernels, rates: Rates, path: Path) -> bool:
    """Whether a run has met such a position, or was about to."""
    times, states, room = path.times, path.states, np.empty(1)
    found = _approached().code(
        kernels.motion().address("hold"), times.size, loop.address(times), loop.address(states), states.shape[1],
        rates.told[-1], loop.address(room), LIMIT,
    )  # fmt: skip
    if not found:
        return False
    return (
        ahead(kernels, rates, times, states, closeness(kernels, rates, times, states), path.start) is not None
    )


@cache
def _approached() -> loop.Function:
    return loop.code("motion.ode.crossing", "approached")


@dataclass(frozen=True, eq=False)
class Ahead:
    """What a run comes to: the time of its last state before s is small, that at which it becomes small, and that of
    s = 0."""

    start: float
    before: float
    meeting: float


def ahead(
    kernels: Kernels, rates: Rates, times: Array, states: Array, s: Array, behind: float
) -> Ahead | None:
    """The first such position that is met in these steps, or just after them, and not before a time;
    ``s`` at the states."""
    near = s < LIMIT
    entered = near[1:] & ~near[:-1]
    if (
        len(s) > 2
    ):  # a step may go from one side to the other: s falls towards 0 before it, and has risen behind
        ends = s[1:-1] + (s[1:-1] - s[:-2]) * np.diff(times)[1:] / np.diff(times)[:-1]
        entered[1:] |= ~near[1:-1] & ~near[2:] & (ends < LIMIT)
    for k in np.flatnonzero(entered & (times[:-1] >= behind)):
        rising = np.flatnonzero(np.diff(s[k:]) >= 0)
        i = int(k + rising[0]) if len(rising) else len(s) - 1
        if i == len(s) - 1 and s[i] > CLOSE * LIMIT:
            return None  # more steps will tell
        before = k + int(np.flatnonzero(s[k:i] >= 2 * s[i])[-1]) if s[k] >= 2 * s[i] else k
        pairs = [pair for pair in ((before, i), (i, i + 1)) if pair[0] < pair[1] < len(s)]
        meetings = [_least(kernels, rates, times[[*j]], states[[*j]], s[[*j]]) for j in pairs]
        met = [found for found in meetings if found is not None]
        if met:
            moments, there, seen = _between(kernels, rates, times[k : k + 2], states[k : k + 2], 0.0, 1.0)
            before = (
                moments[max(int(np.argmax(seen < LIMIT)) - 1, 0)] if (seen < LIMIT).any() else moments[-1]
            )
            return Ahead(float(times[k]), float(before), min(met, key=lambda one: one[1])[0])
    return None


def _between(
    kernels: Kernels, rates: Rates, times: Array, states: Array, first: float, last: float
) -> tuple[Array, Array, Array]:
    """Moments from the part ``first`` of a step to ``last``, states and s there: along the cubic through the
    coordinates at both ends, and their rates, and beyond it."""
    n_q, h = kernels.model.n_q, float(times[1] - times[0])
    speeds = h * observe(rates.address, rates.size, times, states, rates.constants)[:, :n_q]
    (q0, q1), (v0, v1) = states[:, :n_q], speeds
    z = np.linspace(first, last, SEEN)[:, None]
    d, there = q1 - q0, np.repeat(states[:1], SEEN, axis=0)
    there[:, :n_q] = q0 + z * (v0 + z * ((3 * d - 2 * v0 - v1) + z * (v0 + v1 - 2 * d)))
    moments = times[0] + h * z[:, 0]
    return moments, there, closeness(kernels, rates, moments, there)


def _least(
    kernels: Kernels, rates: Rates, times: Array, states: Array, s: Array
) -> tuple[float, float] | None:
    """When s = 0 in a step or soon after, and what s is there as far as is known; None if it is not."""
    first, last = 0.0, 1.0 if s[1] >= s[0] else 1 + min(2.5 * s[1] / (s[0] - s[1]), 4.0)
    for _ in range(3):
        moments, _, seen = _between(kernels, rates, times, states, first, last)
        if not np.isfinite(seen).all():
            return None
        k = int(np.argmin(seen))
        width = (last - first) / (SEEN - 1)
        first, last = first + width * max(k - 1, 0), first + width * min(k + 1, SEEN - 1)
    return (float(moments[k]), float(seen[k])) if seen[k] < MET * LIMIT else None


class Crossing:
    """Of one run: where it is taken back to, and how it goes on.

    ``finest``   the tolerance
    ``ahead``    what the run has come to, once it was halted for it
    """

    def __init__(self, finest: float) -> None:
        self.finest, self.most = finest, max(AGREED * finest, ROUNDED)
        self.ahead: Ahead | None = None
        self.behind = -np.inf
        self.tail: tuple[Array, Array] | None = None

    def halt(self, kernels: Kernels, rates: Rates) -> Halt | None:
        """What stops a run that has met such a position, or is about to."""
        if not kernels.active:
            return None
        self.ahead = self.tail = None

        def met(times: Array, states: Array) -> tuple[int, str, int] | None:
            if times[-1] < times[0]:  # backwards: the parts of such a run are not put together
                return None
            begin = times[0]
            if self.tail is not None:
                times, states = (
                    np.concatenate([a, b[1:]]) for a, b in zip(self.tail, (times, states), strict=True)
                )
            s = closeness(kernels, rates, times, states)
            self.ahead = ahead(kernels, rates, times, states, s, self.behind)
            if self.ahead is not None:
                return int(np.searchsorted(times[times >= begin], self.ahead.start)), RELEASED, 0
            # of a position that is not passed yet, what goes before it is looked at again with what follows
            outside = np.flatnonzero(s >= LIMIT)
            last = int(outside[-1]) if len(outside) and len(s) - outside[-1] < LONGEST else len(s) - 1
            self.tail = times[last:].copy(), states[last:].copy()
            return None

        return met

    def across(
        self, leg: Leg, kernels: Kernels, parameters: Array, rates: Rates, before: Path, until: float
    ) -> tuple[list[Path], list[Happening]]:
        """Paths that take the place of one, up to behind the position, and what is told of it. If no step across is
        found, the path up to where s became small; the run goes on from there by ordinary steps."""
        found, self.ahead = self.ahead, None
        assert found is not None
        self.behind = found.meeting
        kept = cut(before, int(np.searchsorted(before.times, found.start)), RELEASED)
        start, y = kept.end, kept.states[-1]
        if until <= found.meeting:
            return [kept], []
        meeting, near = found.meeting, found.before
        best: tuple[float, Path | None, Path] | None = None
        last: Path | None = None
        for share in SHARES:
            begin = max(start, meeting - share * (meeting - near))
            lead = leg(kernels, rates, y, start, begin, None) if begin > start else None
            if lead is not None and lead.status != FINISHED:
                break
            there, end = y if lead is None else lead.states[-1], meeting + (meeting - begin)
            step = leg(kernels, rates, there, begin, end, None, "crossing", False)
            if step.steps != 1 or not self._held(kernels, parameters, step):
                continue
            seen = _met(kernels, rates, step)
            if seen is None:
                break
            apart = np.inf if last is None else _difference(last, step, kernels.model.n_q)
            if best is None or apart < best[0]:
                best = apart, lead, step
            if apart <= self.finest:
                break
            last, meeting = step, seen
        if best is None or not best[0] <= self.most:
            return [kept], []
        _, lead, step = best
        end = step.end
        step = leg(kernels, rates, step.states[0], step.start, end, None, "crossing")
        if step.status == FINISHED:
            step.states[-1] = projected(rates, step.end, step.states[-1])
        if step.end >= until:
            step = _until(step, until)
        self.behind = step.end
        parts = [one for one in (kept, lead, step) if one is not None and one.steps]
        return parts, [_told(kernels, parameters, step, meeting)] if step.end >= meeting else []

    def _held(self, kernels: Kernels, parameters: Array, step: Path) -> bool:
        """Whether the conditions hold along a step."""
        times = np.linspace(step.start, step.end, SAMPLED)
        states = step.sample(times)
        program, m = kernels.closing(), len(kernels.on_speeds)
        n_q, n_u = kernels.model.n_q, kernels.model.n_u
        moved = np.ascontiguousarray(states[:, : n_q + n_u])
        constants = program.constants(parameters)
        seen = observe(program.address("conditions"), m + m * n_u, times, moved, constants)[:, :m]
        scale = 1 + np.abs(moved[:, :n_q]).max(axis=1, keepdims=True)
        return bool((np.abs(seen) <= max(CLOSED, self.finest) * scale).all())


def _difference(one: Path, other: Path, n_q: int) -> float:
    """Of two steps across, the greatest difference of a coordinate at times of both, relative to 1 + |value|."""
    times = np.linspace(max(one.start, other.start), min(one.end, other.end), SAMPLED)
    a, b = one.sample(times)[:, :n_q], other.sample(times)[:, :n_q]
    return float((np.abs(a - b) / (1 + np.abs(b))).max(initial=0.0))


def _until(step: Path, until: float) -> Path:
    """A step of which the rest is not asked for."""
    times = np.array([step.start, until])
    states = np.stack([step.states[0], step.sample([until])[0]])
    crossings = tuple(one for one in step.crossings if one.time <= until)
    return replace(step, times=times, states=states, crossings=crossings, status=FINISHED)


def _met(kernels: Kernels, rates: Rates, step: Path) -> float | None:
    """When s = 0 along a step; None if it is not: each of three looks is closer, and s falls with the distance."""
    first, last, most = step.start, step.end, np.inf
    for _ in range(3):
        times = np.linspace(first, last, SEEN)
        s = closeness(kernels, rates, times, step.sample(times))
        k = int(np.argmin(s))
        most = min(most, max(s[0], s[-1])) * 4 / SEEN
        if not 0 < k < SEEN - 1 or s[k] > max(most, MET * MET):
            return None
        first, last = float(times[k - 1]), float(times[k + 1])
    return float(times[k])


def _told(kernels: Kernels, parameters: Array, step: Path, meeting: float) -> Happening:
    """What is said of it: the conditions that lose their hold there."""
    model = kernels.model
    values = {one.name: x for one, x in zip(model.parameters, parameters.tolist(), strict=True)}
    y = step.sample([meeting])[0]
    q, u = y[: model.n_q].tolist(), y[model.n_q : model.n_q + model.n_u].tolist()
    names = nearly_dependent(model, float_state(model, q, u, meeting, values), kernels.active, LIMIT)
    shown = [*map(repr, names[:SHOWN]), *([f"{len(names) - SHOWN} others"] if len(names) > SHOWN else [])]
    state = dict(zip(kernels.names, y.tolist(), strict=False))
    text = (
        f"{' and '.join(shown)} lose{'s its' if len(names) == 1 else ' their'} hold, as where bars come into line: the "
        "machine could go on in more ways than one, and keeps to its branch"
    )
    return Happening(meeting, names[0], 0, state, text, state)
