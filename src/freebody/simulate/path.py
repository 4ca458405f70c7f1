"""The computed path of a state through time: the run of the integrator in pieces, and its dense output.

The compiled loop (`dop853`) works in pieces of about a tenth of a second. Between two pieces Python may show the
progress, notice an interruption, and lengthen the buffers; within a step there is no Python.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import dop853
from .machine import padded

Array = NDArray[np.float64]

FINISHED = "finished"
TERMINAL = "terminal event"
NOT_FINITE = "not finite"
COLLAPSED = "step collapsed"
TOO_MANY_STEPS = "too many steps"
INTERRUPTED = "interrupted"

_STATUS = {
    dop853.FINISHED: FINISHED,
    dop853.TERMINAL: TERMINAL,
    dop853.NOT_FINITE: NOT_FINITE,
    dop853.COLLAPSED: COLLAPSED,
}
_PIECE = 0.1  # seconds between two looks at the keyboard
_MEMORY = 1 << 25  # bytes of one buffer at most


@dataclass(frozen=True)
class Rates:
    """The right-hand side y' = f(t, y, c) as machine code, with the constants it is called with.

    ``address``      of ``void f(double t, const double *y, const double *c, double *out)``
    ``size``         number of components of y
    ``constants``    c
    ``quaternions``  places in y where a unit quaternion (four components) begins
    ``keep``         whatever owns the machine code
    """

    address: int
    size: int
    constants: Array
    quaternions: tuple[int, ...] = ()
    keep: Any = None


@dataclass(frozen=True)
class Watch:
    """Event functions g(t, y, c) as machine code; ``directions`` -1, 0 or +1 and ``terminal`` of each.

    ``constants`` None: those of the rates.
    """

    address: int
    directions: tuple[int, ...]
    terminal: tuple[bool, ...]
    constants: Array | None = None
    keep: Any = None


@dataclass(frozen=True)
class Crossing:
    """A located zero of event function ``number``; ``sign`` is that of the function just after it."""

    time: float
    number: int
    sign: int
    state: Array


@dataclass(frozen=True, eq=False)
class Path:
    """States of a run, one per accepted step, and the dense output between them.

    ``times`` (m + 1) and ``states`` (m + 1, n) hold the starts of the m steps and the end of the run; ``lengths`` (m)
    are the steps the integrator took (the last may reach beyond a terminal event). ``blame`` is the component that
    stopped a failed run.
    """

    rates: Rates
    times: Array
    lengths: Array
    states: Array
    crossings: tuple[Crossing, ...]
    status: str
    blame: int
    rejected: int
    evaluations: int

    @property
    def start(self) -> float:
        return float(self.times[0])

    @property
    def end(self) -> float:
        return float(self.times[-1])

    @property
    def steps(self) -> int:
        return self.lengths.size

    def sample(self, times: ArrayLike, dense: bool = False) -> Array:
        """States, shape (k, n), at ``times``, shape (k,), each between the start and the end of the run.

        They are as accurate as the steps, at the price of a step each. ``dense`` takes them from the dense
        output of order 7: less accurate, and faster where many times lie in one step.

        Raises
        ------
        ValueError           a time outside the run
        """
        wanted = np.atleast_1d(np.ascontiguousarray(times, dtype=float))
        first, last = sorted((self.start, self.end))
        outside = ~((wanted >= first) & (wanted <= last))
        if outside.any():
            raise ValueError(
                f"Expected times within the run, {first:g} to {last:g}; got {wanted[outside][0]!r}. "
                "Ask for a time inside, or simulate further."
            )
        result = np.empty((wanted.size, self.rates.size))
        width = padded(self.rates.size)
        dop853.sample(
            self.rates.address, self.rates.size, self.rates.constants, np.zeros(dop853.ROWS * width), width,
            np.array(self.rates.quaternions, dtype=np.int64), self.times, self.lengths, self.states, int(dense), wanted,
            result,
        )  # fmt: skip
        return result


def observe(address: int, outputs: int, times: Array, states: Array, constants: Array) -> Array:
    """Outputs, shape (k, outputs), of the kernel at ``address`` at each of the k times and states."""
    result = np.zeros((times.size, outputs))
    if outputs:
        flat = np.ascontiguousarray(states)
        dop853.observe(
            address, times, flat.reshape(-1), flat.shape[1], constants, result.reshape(-1), outputs
        )
    return result


@dataclass
class _Pieces:
    """What the compiled loop has filled so far."""

    times: list[Array] = field(default_factory=list)
    lengths: list[Array] = field(default_factory=list)
    states: list[Array] = field(default_factory=list)
    crossings: list[Crossing] = field(default_factory=list)
    rejected: int = 0
    evaluations: int = 0


def integrate(
    rates: Rates,
    state: ArrayLike,
    start: float,
    until: float,
    *,
    relative: ArrayLike = 1e-9,
    absolute: ArrayLike = 1e-9,
    watch: Watch | None = None,
    max_step: float = math.inf,
    first_step: float | None = None,
    max_steps: int | None = None,
    between: Callable[[float], None] | None = None,
) -> Path:
    """The path from ``state`` at ``start`` to ``until`` (earlier than ``start``: backwards in time).

    The local error of component i is kept below absolute[i] + relative[i] |y_i|.

    Parameters
    ----------
    rates                right-hand side
    state                shape (n,); its quaternions are normalised
    relative, absolute   tolerances, scalar or shape (n,)
    watch                event functions
    max_step, first_step greatest and first length of a step; the first is chosen when it is not given
    max_steps            stop after so many accepted steps
    between              called with the reached time between two pieces of the run; KeyboardInterrupt, from it or
                         from the keyboard, ends the run and keeps what was computed
    """
    n, width = rates.size, padded(rates.size)
    quaternions = np.array(rates.quaternions, dtype=np.int64)
    y, start, until = np.array(state, dtype=float), float(start), float(until)
    for i in rates.quaternions:
        y[i : i + 4] /= np.linalg.norm(y[i : i + 4])
    rtol = np.broadcast_to(np.asarray(relative, dtype=float), (n,)).copy()
    atol = np.broadcast_to(np.asarray(absolute, dtype=float), (n,)).copy()
    direction = 1.0 if until >= start else -1.0

    at = _caller(rates)
    f = at(start, y)
    pieces = _Pieces(evaluations=2)

    def path(status: str, blame: int, end: float, last: Array) -> Path:
        return Path(
            rates,
            np.concatenate([*pieces.times, [end]]),
            np.concatenate([*pieces.lengths, []]),
            np.concatenate([*pieces.states, last[None]]),
            tuple(pieces.crossings),
            status,
            blame,
            pieces.rejected,
            pieces.evaluations,
        )

    if not np.isfinite(f).all():
        return path(NOT_FINITE, int(np.flatnonzero(~np.isfinite(f))[0]), start, y)
    longest = min(max_step, abs(until - start))
    if longest == 0:
        return path(FINISHED, 0, start, y)
    if first_step is None:
        first_step = _first_step(at, start, direction, longest, y, f, atol + rtol * np.abs(y))

    work = np.zeros(dop853.ROWS * width)
    work[dop853.STATE * width :][:n] = y
    work[:n] = f
    watch = watch or Watch(0, (), ())
    m = len(watch.directions)
    directions = np.array(watch.directions, dtype=np.int64)
    terminal = np.array(watch.terminal, dtype=np.int64)
    table = np.zeros((dop853.PARTS + 3, m + 1))
    g = np.zeros(m)
    event_constants = rates.constants if watch.constants is None else watch.constants
    if m:
        table[0, :m] = observe(watch.address, m, np.array([start]), y[None], event_constants)[0]
    last_sign = np.sign(table[0, :m]).astype(np.int64)
    # in a step each function can be recorded twice between two points, and each point can be a zero
    found = np.zeros((3 * (dop853.PARTS + 2) * max(m, 1), 4))
    reals = np.zeros(dop853.REALS)
    reals[dop853.TIME] = reals[dop853.START] = start
    reals[dop853.UNTIL], reals[dop853.MAX_STEP] = until, max_step
    reals[dop853.STEP], reals[dop853.OLD_ERROR] = direction * min(first_step, longest), 1e-4
    integers = np.zeros(dop853.INTEGERS, dtype=np.int64)
    advance = dop853.advance_watching() if m else dop853.advance
    largest = max(16, _MEMORY // (8 * (n + 2)))
    room = min(256, largest)
    left = math.inf if max_steps is None else max_steps
    status = None
    try:
        while status is None:
            room = int(min(room, left))
            times, lengths, states = np.empty(room), np.empty(room), np.empty((room, n))
            arguments = (
                rates.address, n, rates.constants, work, width, quaternions, rtol, atol, reals, integers,
                times, lengths, states,
            )  # fmt: skip
            clock = perf_counter()
            if m:
                event_log, event_states = np.empty((len(found) + room, 3)), np.empty((len(found) + room, n))
                watching = (
                    watch.address, event_constants, directions, terminal, last_sign, table, g, found, event_log,
                    event_states,
                )  # fmt: skip
                code = advance(*arguments, watching)
            else:
                code = advance(*arguments, None)
            clock = perf_counter() - clock
            done, events = integers[dop853.ACCEPTED], integers[dop853.EVENTS]
            pieces.times.append(times[:done])
            pieces.lengths.append(lengths[:done])
            pieces.states.append(states[:done])
            for k in range(events):
                time, number, sign = event_log[k]
                pieces.crossings.append(Crossing(float(time), int(number), int(sign), event_states[k].copy()))
            left -= done
            if code != dop853.RUNNING:
                status = _STATUS[code]
            elif left <= 0:
                status = TOO_MANY_STEPS
            else:
                pace = max(done, 1) / max(clock, 1e-6)
                room = int(min(largest, max(16, min(4 * room, _PIECE * pace))))
                if between is not None:
                    between(float(reals[dop853.TIME]))
    except KeyboardInterrupt:
        status = INTERRUPTED
    pieces.rejected = int(integers[dop853.REJECTED])
    pieces.evaluations += int(integers[dop853.EVALUATED])
    end = work[dop853.STATE * width :][:n].copy()
    return path(status, int(integers[dop853.BLAME]), float(reals[dop853.TIME]), end)


def _caller(rates: Rates) -> Callable[[float, Array], Array]:
    def at(t: float, y: Array) -> Array:
        return observe(rates.address, rates.size, np.array([t]), y[None], rates.constants)[0]

    return at


def _first_step(
    at: Callable[[float, Array], Array],
    t: float,
    direction: float,
    longest: float,
    y: Array,
    f: Array,
    scale: Array,
) -> float:
    """A length for the first step (Hairer, Norsett, Wanner, section II.4)."""
    size, slope = float(np.max(np.abs(y) / scale)), float(np.max(np.abs(f) / scale))
    guess = min(1e-6 if size < 1e-5 or slope < 1e-5 else 0.01 * size / slope, longest)
    curve = float(np.max(np.abs(at(t + direction * guess, y + direction * guess * f) - f) / scale)) / guess
    if not math.isfinite(curve):
        return guess
    steepest = max(slope, curve)
    other = max(1e-6, guess * 1e-3) if steepest <= 1e-15 else (0.01 / steepest) ** (1 / 8)
    return min(100 * guess, other, longest)
