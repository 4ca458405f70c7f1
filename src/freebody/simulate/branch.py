"""Positions of a linkage in which its conditions depend on each other, passed with the branch kept.

Bars of a parallelogram come into line: from there it could go on as a parallelogram, or crossed. The motion goes on
along its branch, which is smooth; what fails there are the equations: with the distance s from that position
(`dynamics.constrained.hold`) round-off of the state becomes accelerations that are wrong by ε/s³. So a run halts where s
falls below the distance at which that is a tenth of the tolerance, the moment s = 0 is foreseen on the motion so
far, and one step (`crossing`) goes from as long before it to as long after it. It is taken if its error is within
the tolerance, and the conditions hold along it. A linkage that only comes near such a position does not pass that test,
and goes on by ordinary steps.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..dynamics.state import float_state
from . import loop
from .closing import nearly_dependent
from .crossing import MOVED, ONTO, OWN, PLACES, RATES, ROOM, SIZE, TURNING
from .kernels import Kernels
from .path import FINISHED, TERMINAL, UNDEFINED, Array, Path, Rates, observe, projected
from .phases import Happening

LIMIT = 0.1
"""s from which a run looks ahead."""
SHARES = (1.0, 0.7, 0.5, 0.35)  # of that distance, at which steps across are tried
MET = 1e-2  # of the distance: below it the position itself is met, not passed by
SHOWN = 3  # names of conditions in a sentence
SEEN = 256  # places at which the motion ahead is looked at
MISSED = 1e3  # units of the tolerance by which a condition may be missed along a step
_PASSED = (FINISHED, TERMINAL, UNDEFINED)
SOURCES = ("crossing.py", "machine.py", "translation.py", "rows.py", "layout.py")


def along_branch(rates: Rates) -> Rates:
    """f(P(y)) of the rates f and their projection P (`crossing`)."""
    n = rates.size
    room = np.zeros(2 * n + 8)
    function = loop.code("crossing", "along_branch", SOURCES)
    constants = np.zeros(OWN + rates.constants.size)
    constants[RATES], constants[ONTO], constants[SIZE] = rates.address, rates.projection, n
    constants[MOVED], constants[TURNING] = rates.projected, len(rates.quaternions)
    constants[PLACES], constants[ROOM] = loop.address(rates.corrections), loop.address(room)
    constants[OWN:] = rates.constants
    address = ctypes.cast(function.code, ctypes.c_void_p).value
    assert address is not None
    return replace(
        rates, address=address, constants=constants, keep=(rates, room, function), projection=0, projected=0
    )


def closeness(kernels: Kernels, rates: Rates, times: Array, states: Array) -> Array:
    """s at states."""
    squares = observe(kernels.motion().address("hold"), 1, times, states, rates.constants)[:, 0]
    return np.sqrt(np.maximum(squares, 0))


@dataclass(frozen=True, eq=False)
class Ahead:
    """What a run comes to: the time of its last state before s is small, the next one's, that of s = 0, and that at which
    s is LIMIT before."""

    start: float
    after: float
    meeting: float
    before: float


def ahead(kernels: Kernels, rates: Rates, times: Array, states: Array, behind: float = -np.inf) -> tuple[int, Ahead] | None:
    """The first such position that a run meets after a time, and the number of the last state before it is near."""
    s = closeness(kernels, rates, times, states)
    near = s < LIMIT
    for k in np.flatnonzero(near[1:] & ~near[:-1] & (times[:-1] >= behind)):
        pair = slice(k, k + 2)
        found = _foreseen(kernels, rates, times[pair], states[pair], s[pair])
        if found is not None:
            return int(k), Ahead(float(times[k]), float(times[k + 1]), *found)
    return None


def _foreseen(kernels: Kernels, rates: Rates, times: Array, states: Array, s: Array) -> tuple[float, float] | None:
    """When s = 0 is met in or after a step, and when it is LIMIT before; None if it is not met.

    The coordinates are followed along the cubic through both states and their rates, and beyond it.
    """
    n_q, h = kernels.model.n_q, float(times[1] - times[0])
    speeds = observe(rates.address, rates.size, times, states, rates.constants)[:, :n_q]
    q0, q1, v0, v1 = states[0, :n_q], states[1, :n_q], h * speeds[0], h * speeds[1]
    if not np.isfinite(speeds).all():
        return None
    first, last, before, k = 0.0, 1 + 2.5 * s[1] / (s[0] - s[1]), 0.0, 0
    for turn in range(3):
        x = np.linspace(first, last, SEEN)
        z, d, there = x[:, None], q1 - q0, np.repeat(states[:1], SEEN, axis=0)
        there[:, :n_q] = q0 + z * (v0 + z * ((3 * d - 2 * v0 - v1) + z * (v0 + v1 - 2 * d)))
        seen = closeness(kernels, rates, times[0] + h * x, there)
        k = int(np.argmin(seen))
        if turn == 0:
            far = np.flatnonzero(seen[:k] >= LIMIT)
            before = float(x[far[-1]]) if len(far) else 0.0
        if k in (0, SEEN - 1) or not np.isfinite(seen).all():
            return None
        first, last = float(x[k - 1]), float(x[k + 1])
    if not seen[k] < MET * LIMIT:
        return None
    return float(times[0]) + h * float(x[k]), float(times[0]) + h * before


class Crossing:
    """Of one run: where it halts, and how it goes on."""

    def __init__(self, finest: float) -> None:
        self.finest = finest
        self.ahead: Ahead | None = None
        self.behind = -np.inf

    def begin(self, start: float, until: float) -> None:
        self.ahead, self.behind = None, -np.inf if until > start else np.inf

    def halt(self, kernels: Kernels, rates: Rates) -> Callable[[Array, Array], int | None] | None:
        """Of times and states: the last before such a position is near."""
        if not kernels.active or self.behind == np.inf:
            return None

        def last(times: Array, states: Array) -> int | None:
            found = ahead(kernels, rates, times, states, self.behind)
            self.ahead = None if found is None else found[1]
            return None if found is None else found[0]

        return last

    def across(
        self, leg: Callable[..., Path], kernels: Kernels, parameters: Array, rates: Rates, y: Array, start: float,
        until: float,
    ) -> tuple[list[Path], list[Happening]]:  # fmt: skip
        """Paths up to behind the position, and what is told of it; none if the run has to go on by ordinary steps."""
        assert self.ahead is not None
        meeting, before = self.ahead.meeting, self.ahead.before
        self.ahead, self.behind = None, max(self.ahead.after, meeting + (meeting - before))
        if until <= meeting:
            return [], []
        for share in SHARES:
            begin = max(start, meeting - share * (meeting - before))
            first = leg(kernels, rates, y, start, begin, None) if begin > start else None
            if first is not None and first.status != FINISHED:
                return [], []
            there = y if first is None else first.states[-1]
            step = leg(kernels, rates, there, begin, meeting + (meeting - begin), None, "crossing")
            if step.steps == 1 and step.status in _PASSED and self._held(kernels, parameters, rates, step):
                if step.end >= until:
                    step = _until(step, until)
                self.behind = step.end
                paths = [step] if first is None else [first, step]
                return paths, [] if step.end < meeting else [_told(kernels, parameters, step, meeting)]
        return [], []

    def _held(self, kernels: Kernels, parameters: Array, rates: Rates, step: Path) -> bool:
        """Whether the conditions hold along a step; its end is moved onto them."""
        times = np.linspace(step.start, step.end, 12)
        states = step.sample(times)
        program, m = kernels.closing(), len(kernels.on_speeds)
        n_q, n_u = kernels.model.n_q, kernels.model.n_u
        seen = observe(
            program.address("conditions"), m + m * n_u, times, np.ascontiguousarray(states[:, : n_q + n_u]),
            program.constants(parameters),
        )[:, :m]
        scale = 1 + np.abs(states[:, :n_q]).max(axis=1, keepdims=True)
        if not (np.abs(seen) <= MISSED * self.finest * scale).all():
            return False
        if step.status == FINISHED:
            step.states[-1] = projected(rates, step.end, step.states[-1])
        return True


def _until(step: Path, until: float) -> Path:
    """A step of which the rest is not asked for."""
    times = np.array([step.start, until])
    states = np.stack([step.states[0], step.sample([until])[0]])
    crossings = tuple(one for one in step.crossings if one.time <= until)
    return replace(step, times=times, states=states, crossings=crossings, status=FINISHED)


def _told(kernels: Kernels, parameters: Array, step: Path, meeting: float) -> Happening:
    """What is said of it: the conditions that lose their hold there."""
    model = kernels.model
    values = {one.name: x for one, x in zip(model.parameters, parameters.tolist(), strict=True)}
    y = step.sample([meeting])[0]
    q, u = y[: model.n_q].tolist(), y[model.n_q : model.n_q + model.n_u].tolist()
    names = nearly_dependent(model, float_state(model, q, u, meeting, values), kernels.active)
    shown = [*map(repr, names[:SHOWN]), *([f"{len(names) - SHOWN} others"] if len(names) > SHOWN else [])]
    state = dict(zip(kernels.names, y.tolist(), strict=False))
    text = f"the bars come into line: {' and '.join(shown) or 'the conditions'} could let go of the branch, and it is kept"
    return Happening(meeting, names[0] if names else "", 0, state, text, state)
