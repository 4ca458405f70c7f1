"""Singular positions of a linkage, in which its conditions are dependent, passed along the branch of the motion.

Bars of a parallelogram come into line: from there it could go on as a parallelogram, or crossed. The motion goes on
along its branch, which is smooth, but the equations fail: at the distance s from the singular position
(`constrained.independence`) round-off ε of the state makes errors of ε/s³ in the accelerations, and step-size control
makes ever shorter steps. A run that meets s = 0 therefore goes back to where s became small, and one step (`crossing`)
leads across: it starts as long before the meeting as it ends after it. Steps of several lengths are tried, until one
agrees with a longer one. If a linkage only comes near such a position, it does not meet s = 0, or its steps do not
agree: the run goes on by ordinary steps.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from ...native import loop
from ..ending import End
from ..kernels.kernels import Kernels
from ..ode.crossing import ROUNDED
from ..ode.dense_output import Array, Path, Rates, Sampler, cut, observe, projected
from ..ode.integration import FINEST_OF_SUMS, Halt
from ..start.loop_closure import Entries, names_of_dependent
from ..trajectory.event import Happening
from ..trajectory.phases import Phases, segments_of

LIMIT = 0.2
"""Value of s below which a singular position is sought."""
SHARES = (1.0, 0.7, 0.5, 0.35, 0.25, 0.18)
"""Parts of the time from there to the meeting, for which steps across are tried, the longest first."""
CLOSE = 0.3  # part of the limit: a run that comes closer without turning away is on its way to s = 0
MET = 5e-3  # part of the limit: a smaller s counts as 0, since the time of the meeting is not exact
SAMPLES = 32  # times along a step at which s is evaluated
VERTICES = 3  # parabolas through s² that find its least value
NARROWER = 16  # part to which each narrows the interval around it
AGREED = 1e3
"""Greatest difference of the coordinates of two steps, in units of the tolerance; but at least ROUNDED."""
CLOSED = 1e-11
"""Greatest residual of a condition along a step, if the tolerance is smaller: some ten thousand units in the last
place, since the stages divide by s."""
FINER = 0.1
"""Part of the tolerance that ordinary steps keep in a run that meets such positions. Near them a state that is off the
conditions by e is moved by e/s, and a linkage that turns over separates from its neighbours (docs/integrators.md). A
step across costs more than a hundred ordinary steps."""
COMPARED = 12  # times at which two steps are compared
LONGEST = 10_000  # steps near a position, after which it is forgotten
SHOWN = 3  # names of conditions in a sentence

LONG = "gauss"
"""Method with steps so long that they may lead over a position and show nothing of it at their ends."""
INSIDE = np.arange(1, 16)[:, None] / 16
"""Parts of such a step at which s is computed."""
SHORTER = 0.25
"""Part of a step that led over a position, which later steps do not exceed."""

Leg = Callable[..., Any]
"""(kernels, rates, state, start, end, halt) and, for a step across, its method and True if events are watched; the
path, or `Phases` where laws switch. A step across is one path."""


def closeness(kernels: Kernels, rates: Rates, times: Array, states: Array) -> Array:
    """Return s at states."""
    squares = observe(kernels.motion().address("hold"), 1, times, states, rates.constants)[:, 0]
    return np.sqrt(np.maximum(squares, 0))


def meeting(kernels: Kernels, rates: Rates) -> Halt:
    """Return a function that stops a run in the steps in which it meets a singular position."""
    return lambda times, states: (0, End.RELEASED, 0) if meets(kernels, rates, times, states, "") else None


def meets(kernels: Kernels, rates: Rates, times: Array, states: Array, method: str) -> bool:
    """Return True if the steps of a run have met a singular position, or were about to."""
    room = np.empty(1)
    if method == LONG and leaps(kernels, rates, times, states) is not None:
        return True
    approached = _approached().code(
        kernels.motion().address("hold"), times.size, loop.address(times), loop.address(states), states.shape[1],
        rates.constants_at, loop.address(room), LIMIT,
    )  # fmt: skip
    if not approached:
        return False
    return ahead(kernels, rates, times, states, closeness(kernels, rates, times, states), None) is not None


@cache
def _approached() -> loop.Function:
    return loop.code("motion.ode.crossing", "approached")


@dataclass(frozen=True, eq=False)
class Ahead:
    """A singular position ahead of a run.

    ``start``     time of the last state before s is small
    ``before``    time at which s becomes small
    ``meeting``   time of s = 0
    """

    start: float
    before: float
    meeting: float


def ahead(
    kernels: Kernels, rates: Rates, times: Array, states: Array, s: Array, behind: float | None
) -> Ahead | None:
    """Return the first singular position met in these steps, or just after them, but beyond the time ``behind``; ``s``
    holds its values at the states.
    """
    sense = 1.0 if times[-1] >= times[0] else -1.0
    near = s < LIMIT
    entered = near[1:] & ~near[:-1]
    if len(s) > 2:
        # a step may lead from one side to the other: s falls towards 0 before it, and has risen after it
        ends = s[1:-1] + (s[1:-1] - s[:-2]) * np.diff(times)[1:] / np.diff(times)[:-1]
        entered[1:] |= ~near[1:-1] & ~near[2:] & (ends < LIMIT)
    if behind is not None:
        entered &= sense * (times[:-1] - behind) >= 0
    for k in np.flatnonzero(entered):
        rising = np.flatnonzero(np.diff(s[k:]) >= 0)
        i = int(k + rising[0]) if len(rising) else len(s) - 1
        if i == len(s) - 1 and s[i] > CLOSE * LIMIT:
            return None  # more steps are needed to tell
        before = k + int(np.flatnonzero(s[k:i] >= 2 * s[i])[-1]) if s[k] >= 2 * s[i] else k
        pairs = [pair for pair in ((before, i), (i, i + 1)) if pair[0] < pair[1] < len(s)]
        meetings = [_least(kernels, rates, times[[*j]], states[[*j]], s[[*j]]) for j in pairs]
        met = [meeting for meeting in meetings if meeting is not None]
        if met:
            moments, _, distances = _between(
                kernels, rates, times[k : k + 2], states[k : k + 2], np.linspace(0, 1, SAMPLES)
            )
            inside = np.flatnonzero(distances < LIMIT)
            before = moments[max(int(inside[0]) - 1, 0)] if inside.size else moments[-1]
            # the first; if both are the same position, the one that is nearer to s = 0
            first = sense * min(sense * moment for moment, _ in met)
            same = [meeting for meeting in met if abs(meeting[0] - first) <= SHORTER * abs(first - times[k])]
            return Ahead(float(times[k]), float(before), min(same, key=lambda meeting: meeting[1])[0])
    return None


def leaps(kernels: Kernels, rates: Rates, times: Array, states: Array) -> int | None:
    """Return the first step with s below half the limit in it, and above the limit at its ends: along the cubic through
    the coordinates at both ends with their rates.
    """
    if len(times) < 2:
        return None
    n_q, h = kernels.model.n_q, np.diff(times)[:, None]
    speeds = rates.along(times, states)[:, :n_q]
    inside = np.repeat(states[:-1], len(INSIDE), axis=0)
    q0, d, v0, v1 = (
        x[:, None, :]
        for x in (states[:-1, :n_q], np.diff(states[:, :n_q], axis=0), h * speeds[:-1], h * speeds[1:])
    )
    q = q0 + INSIDE * (v0 + INSIDE * ((3 * d - 2 * v0 - v1) + INSIDE * (v0 + v1 - 2 * d)))
    inside[:, :n_q] = q.reshape(-1, n_q)
    moments = (times[:-1, None] + h * INSIDE[:, 0]).ravel()
    least = closeness(kernels, rates, moments, inside).reshape(len(h), -1).min(axis=1)
    s = closeness(kernels, rates, times, states)
    over = np.flatnonzero((least < LIMIT / 2) & (np.minimum(s[:-1], s[1:]) > LIMIT))
    return int(over[0]) if len(over) else None


def _between(
    kernels: Kernels, rates: Rates, times: Array, states: Array, z: Array
) -> tuple[Array, Array, Array]:
    """Return the times at the parts z of a step, the states then, and s: along the cubic through the coordinates at
    both ends with their rates, and beyond it.
    """
    n_q, h = kernels.model.n_q, float(times[1] - times[0])
    speeds = h * rates.along(times, states)[:, :n_q]
    (q0, q1), (v0, v1) = states[:, :n_q], speeds
    z = z[:, None]
    d, between = q1 - q0, np.repeat(states[:1], len(z), axis=0)
    between[:, :n_q] = q0 + z * (v0 + z * ((3 * d - 2 * v0 - v1) + z * (v0 + v1 - 2 * d)))
    moments = times[0] + h * z[:, 0]
    return moments, between, closeness(kernels, rates, moments, between)


def _least(
    kernels: Kernels, rates: Rates, times: Array, states: Array, s: Array
) -> tuple[float, float] | None:
    """Return the time of s = 0 in a step or soon after, and the computed s then; None if s does not vanish."""
    last = 1.0 if s[1] >= s[0] else 1 + min(2.5 * s[1] / (s[0] - s[1]), 4.0)
    moments, _, distances = _between(kernels, rates, times, states, np.linspace(0, last, SAMPLES))
    for _ in range(VERTICES):
        if not np.isfinite(distances).all():
            return None
        inner = (_around_least(moments, distances) - times[0]) / (times[1] - times[0])
        moments, distances = _with(moments, distances, *_between(kernels, rates, times, states, inner)[::2])
    k = int(np.argmin(distances))
    return (float(moments[k]), float(distances[k])) if distances[k] < MET * LIMIT else None


def _around_least(z: Array, s: Array) -> Array:
    """Return three places around the least of s: at a simple zero of s, s² is smooth, and has a parabola's vertex."""
    i = min(max(int(np.argmin(s)), 1), len(z) - 2)
    a, b, c = z[i - 1 : i + 2]
    left, right = (s[i - 1] ** 2 - s[i] ** 2) * (c - b), (s[i + 1] ** 2 - s[i] ** 2) * (b - a)
    turned = left + right
    vertex = b + (left * (c - b) - right * (b - a)) / (2 * turned) if turned * (c - a) > 0 else b
    width = (c - a) / (2 * NARROWER)
    return np.clip(vertex + width * np.array([-1, 0, 1]), min(a, c), max(a, c))


def _with(z: Array, s: Array, more: Array, values: Array) -> tuple[Array, Array]:
    """Return places and values of s with more of them, in order."""
    places, first = np.unique(np.concatenate([z, more]), return_index=True)
    return places, np.concatenate([s, values])[first]


class Crossing:
    """Steps of one run across singular positions.

    ``finest``   the tolerance
    ``finer``    part of the tolerance that ordinary steps keep: 1 until a position is met
    ``long``     True if steps may lead over a position, and ``longest`` what they do not exceed
    ``ahead``    the position for which the run was halted
    ``behind``   time of the last position that was passed; None before the first
    ``tail``     times and states that are evaluated again together with the steps that follow
    """

    def __init__(self, finest: float, method: str) -> None:
        self.long, self.longest = method == LONG, np.inf
        self.finest, self.most, self.finer = finest, max(AGREED * finest, ROUNDED), 1.0
        self.ahead: Ahead | None = None
        self.behind: float | None = None
        self.tail: tuple[Array, Array] | None = None

    def refine(self) -> None:
        """Let ordinary steps keep a part of the tolerance, but none that needs another method."""
        self.finer = max(FINER, min(1.0, FINEST_OF_SUMS / self.finest))

    def halt(self, kernels: Kernels, rates: Rates) -> Halt | None:
        """Return a function that stops a run that has met a singular position, or is about to."""
        if not kernels.active:
            return None
        self.ahead = self.tail = None

        def met(times: Array, states: Array) -> tuple[int, End, int] | None:
            begin, sense = times[0], 1.0 if times[-1] >= times[0] else -1.0
            if self.tail is not None:
                times, states = (
                    np.concatenate([a, b[1:]]) for a, b in zip(self.tail, (times, states), strict=True)
                )
            s = closeness(kernels, rates, times, states)
            self.ahead = ahead(kernels, rates, times, states, s, self.behind)
            over = leaps(kernels, rates, times, states) if self.long else None
            if over is not None and (self.ahead is None or sense * (times[over] - self.ahead.start) <= 0):
                self.longest, self.ahead = SHORTER * abs(times[over + 1] - times[over]), None
                first = int(np.searchsorted(sense * times, sense * begin))
                return max(over - first, 0), End.RELEASED, 0
            if self.ahead is not None:
                here = sense * times[sense * (times - begin) >= 0]
                return int(np.searchsorted(here, sense * self.ahead.start)), End.RELEASED, 0
            # if a position is not passed yet, the steps before it are evaluated again with the steps that follow
            outside = np.flatnonzero(s >= LIMIT)
            # and with the step before them, which shows how s changes
            last = int(outside[-1]) if len(outside) and len(s) - outside[-1] < LONGEST else len(s) - 1
            last = max(last - 1, 0)
            self.tail = times[last:].copy(), states[last:].copy()
            return None

        return met

    def across(
        self, leg: Leg, kernels: Kernels, parameters: Array, rates: Rates, before: Path, until: float, watched: bool
    ) -> tuple[list[Path], list[Happening]]:  # fmt: skip
        """Return the paths that replace ``before`` and lead across the position, and the event.

        With ``watched`` events are looked for. If no step across is found, return the path up to where s became small;
        the run goes on from there by ordinary steps.
        """
        position, self.ahead = self.ahead, None
        assert position is not None
        self.refine()
        self.behind = position.meeting
        sense = 1.0 if until >= before.start else -1.0
        steps = int(np.searchsorted(sense * before.times, sense * position.start))
        approach = cut(before, steps, End.RELEASED)
        start, y = approach.end, approach.states[-1]
        if sense * (until - position.meeting) <= 0:
            return [approach], []
        meeting, near = position.meeting, position.before
        best: tuple[float, Path | Phases | None, Sampler] | None = None
        last: Sampler | None = None
        for share in SHARES:
            begin = sense * max(sense * start, sense * (meeting - share * (meeting - near)))
            lead = leg(kernels, rates, y, start, begin, None) if begin != start else None
            if lead is not None and lead.status != End.FINISHED:
                break
            state, end = y if lead is None else lead.states[-1], meeting + (meeting - begin)
            step = leg(kernels, rates, state, begin, end, None, "crossing", False)
            if step.steps != 1:
                continue
            sampler = Sampler(step)
            if not self._closed(kernels, parameters, sampler):
                continue
            met = _met(kernels, rates, sampler)
            if met is None:
                break
            difference = np.inf if last is None else _difference(last, sampler, kernels.model.n_q)
            if best is None or difference < best[0]:
                best = difference, lead, sampler
            if difference <= self.finest:
                break
            last, meeting = sampler, met
        if best is None or not best[0] <= self.most:
            return [approach], []
        _, lead, sampler = best
        step = sampler.path
        state = sampler([meeting])[0]
        if watched:
            step = leg(kernels, rates, step.states[0], step.start, step.end, None, "crossing")
        step = replace(step, step=None)
        if step.status == End.FINISHED:
            step.states[-1] = projected(rates, step.end, step.states[-1])
        if sense * (step.end - until) >= 0:
            step = _until(step, until)
        self.behind = step.end
        leading = [] if lead is None else [segment.path for segment in segments_of(lead, kernels)]
        parts = [path for path in (approach, *leading, step) if path.steps]
        passes = sense * (step.end - meeting) >= 0
        return parts, [_event(kernels, parameters, state, meeting)] if passes else []

    def _closed(self, kernels: Kernels, parameters: Array, sampler: Sampler) -> bool:
        """Return True if the conditions hold along a step."""
        step = sampler.path
        times = np.linspace(step.start, step.end, COMPARED)
        n_q, n_u = kernels.model.n_q, kernels.model.n_u
        program, states = kernels.closing(), sampler(times)[:, : n_q + n_u]
        constants = program.constants(parameters)
        residuals = program.observed("conditions", times, states, constants)[:, : len(kernels.on_speeds)]
        scale = 1 + np.abs(states[:, :n_q]).max(axis=1, keepdims=True)
        return bool((np.abs(residuals) <= max(CLOSED, self.finest) * scale).all())


def _difference(one: Sampler, other: Sampler, n_q: int) -> float:
    """Return the greatest difference of a coordinate between two steps across, relative to 1 + |value|."""
    (begin, end), (other_begin, other_end) = (sorted((x.path.start, x.path.end)) for x in (one, other))
    times = np.linspace(max(begin, other_begin), min(end, other_end), COMPARED)
    a, b = one(times)[:, :n_q], other(times)[:, :n_q]
    return float((np.abs(a - b) / (1 + np.abs(b))).max(initial=0.0))


def _until(step: Path, until: float) -> Path:
    """Return the part of a step up to a time."""
    times = np.array([step.start, until])
    states = np.stack([step.states[0], step.sample([until])[0]])
    passed = (crossing for crossing in step.crossings if (until - crossing.time) * (until - step.start) >= 0)
    return replace(step, times=times, states=states, crossings=tuple(passed), status=End.FINISHED)


def _met(kernels: Kernels, rates: Rates, sampler: Sampler) -> float | None:
    """Return the time of s = 0 along a step; None if s does not fall with the distance from it."""
    times = np.linspace(sampler.path.start, sampler.path.end, SAMPLES)
    s = closeness(kernels, rates, times, sampler(times))
    most = max(s[0], s[-1]) * 4 / SAMPLES
    for _ in range(VERTICES):
        k = int(np.argmin(s))
        if not 0 < k < len(s) - 1 or s[k] > max(most, MET * MET):
            return None
        most = min(most, s[k - 1], s[k + 1]) / 4
        inner = _around_least(times, s)
        times, s = _with(times, s, inner, closeness(kernels, rates, inner, sampler(inner)))
    k = int(np.argmin(s))
    return float(times[k]) if s[k] <= max(most, MET * MET) else None


def _event(kernels: Kernels, parameters: Array, y: Array, meeting: float) -> Happening:
    """Return the event of a singular position, which names the conditions that become dependent."""
    model, n = kernels.model, kernels.model.n_u
    program = kernels.closing()
    moved = y[None, : model.n_q + n]
    numbers = program.observed("motion", np.array([meeting]), moved, program.constants(parameters))[0]
    G = Entries(program.entries(numbers), program.rows, program.columns)
    names = names_of_dependent(model, G, numbers[-2 * n : -n], kernels.active, LIMIT)
    shown = [*map(repr, names[:SHOWN]), *([f"{len(names) - SHOWN} others"] if len(names) > SHOWN else [])]
    text = (
        f"{' and '.join(shown)} become{'s' if len(names) == 1 else ''} dependent, as where bars come into line: the "
        "machine could go on in more ways than one, and keeps to its branch"
    )
    return Happening.between(kernels.names, meeting, names[0], (y, y), text)
