"""Runs of machines whose laws switch, in legs between the switches, in which the laws keep their sides (`sides`).

At e = 0 a law takes the side s that e enters. With ė(s) the rate of e on either side,

    s ė(s) < 0 and -s ė(-s) < 0        both sides lead back to e = 0

there no motion leaves e = 0: it would stay, under a force between those of both sides that the law does not state, and
the run ends. So it does where switches follow one another ever faster, as after bounces that lose speed. A law that
only bends where e is zero, as |e| does, is left as it is while e is round-off, such as a velocity out of a plane.

Source: A. F. Filippov, Differential Equations with Discontinuous Righthand Sides (1988), section 4.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from threading import get_ident
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..ending import End
from ..ode.dense_output import Array, Crossing, Path, Rates, Watch, cut, observe
from ..ode.integration import Halt, first_halt
from ..ode.layout import SINGLE_STEPS
from .kernels import Kernels
from .methods import Way
from .sides import Sides, sides_of

IN_A_ROW = 64
"""Number of switches in a row that are looked at together."""
MOST = 1_000_000
"""Number of legs after which a run ends: each keeps some thousand bytes."""
SAME = 1e-12
"""Difference of the times of two events, relative to 1 s or the time, that counts as none (`event_search`)."""
QUICK = 1e-9
"""Part of a run within which so many switches show that they come ever faster."""


class SidedWay:
    """The method and options of runs from several initial states, of a machine with laws that switch.

    The arguments are those of `Way`; the programs with their sides are in the place of the rates.
    """

    def __init__(
        self, kernels: Kernels, sides: Sides, parameters: Array, method: str, relative: Array,
        *, watch: Watch | None = None, max_steps: int | None = None, first_step: float | None = None, **options: Any,
    ) -> None:  # fmt: skip
        self.kernels, self.sides, self.parameters, self.method = kernels, sides, parameters, method
        self.relative, self.watch, self.options = relative, watch, options
        self.most_steps, self.first_step = max_steps, first_step
        self.ways: dict[tuple[Any, ...], Way] = {}
        self.events = 0 if watch is None else len(watch.directions)

    def leg(self, method: str, sides: Array, free: frozenset[int], idle: frozenset[int]) -> Way:
        """Return the way of a leg with these sides; that of an idle law does not count."""
        now = sides.copy()
        now[[*idle]] = 1.0
        key = get_ident(), method, now.tobytes(), free, idle  # a run tells its way the steps that are left
        if key not in self.ways:
            programs, count = self.sides.kernels(free), len(now)
            constants = np.concatenate([self.parameters, now])
            watch = self.watch
            if method not in SINGLE_STEPS:
                watch = programs.watched(
                    watch, constants, count, [k not in free and k not in idle for k in range(count)]
                )
            way = Way(
                programs, constants, method, programs.rates(constants), self.relative, watch=watch, **self.options
            )  # fmt: skip
            operations = None if watch is None else watch.keep.compiled["values"].operations
            way.jumping = operations is None or "sign" in operations
            self.ways[key] = way
        return self.ways[key]

    def paths(
        self, state: Sequence[float] | Array, start: float, until: float, absolute: ArrayLike,
        between: Callable[[float], None] | None = None, halt: Halt | None = None,
    ) -> list[Path]:  # fmt: skip
        """Return the paths of all legs of a run (`Way.path`); the last one tells how the run ended."""
        run = _Run(self, np.array(state, dtype=float), start, until)
        try:
            while run.goes_on:
                run.leg(absolute, between, halt)
        except KeyboardInterrupt:  # between two legs
            if not run.paths:
                raise
            run.paths[-1].status = End.INTERRUPTED
        for path in run.paths:
            path.crossings = tuple(x for x in path.crossings if x.number < self.events and self.asked(x))
        return run.paths

    def asked(self, crossing: Crossing) -> bool:
        """Return True if the direction of an event is one that is asked for."""
        return self.watch is not None and self.watch.directions[crossing.number] in (0, crossing.sign)


def way_of(
    kernels: Kernels, parameters: Array, method: str, rates: Rates, relative: Array, **options: Any
) -> Way | SidedWay:
    """Return the way of runs of a machine, by legs where its laws switch."""
    sides = None if method == "structure" else sides_of(kernels)  # its steps are equal and end nowhere else
    if sides is None:
        return Way(kernels, parameters, method, rates, relative, **options)
    return SidedWay(kernels, sides, parameters, method, relative, **options)


class _Run:
    """The legs of one run.

    ``sides``    side of each law; 0 of a law whose e is zero
    ``idle``     laws on which the rates do not depend with the sides of the others; they are not looked at
    ``rests``    laws whose e stays zero
    ``free``     laws that bend while e is round-off, with the time until which they are left as they are
    ``last``     the last switches: law, steps of the leg before, its end, and the change of e in it
    ``signs``    the sign of the last crossing of each event; 0 before the first
    """

    def __init__(self, way: SidedWay, y: Array, start: float, until: float) -> None:
        self.way, self.y, self.t, self.start, self.until = way, y, start, start, until
        self.sense = 1.0 if until >= start else -1.0
        self.laws = way.sides.laws
        self.paths: list[Path] = []
        self.goes_on = True
        self.method, self.first_step, self.left = way.method, way.first_step, way.most_steps
        self.rests: set[int] = set()
        self.free: dict[int, float] = {}
        self.spans: dict[int, float] = {}
        self.last: deque[tuple[int, int, float, float]] = deque(maxlen=IN_A_ROW)
        self.stuck = self.awake = -1
        self.waking_side = 0.0
        self.sides = way.sides.start(start, y, way.parameters)
        self.idle: set[int] = set()
        self.signs = [0] * way.events
        for law in np.flatnonzero(self.sides == 0):
            self.start_from_zero(int(law))

    def at(self, sides: Array) -> Array:
        """Return e, ė and ë of each law at the present state with these sides."""
        return self.way.sides.at(self.t, self.y, self.way.parameters, sides)

    def leading(self, law: int, side: float) -> float:
        """Return the rate at which e leaves zero on a side; that of its lowest derivative that is not zero."""
        sides = self.sides.copy()
        sides[law] = side
        _, rate, change = self.at(sides)[law]
        out = float(self.sense * rate if self.laws[law].order == 1 or rate != 0 else change)
        return side * out if side else out

    def start_from_zero(self, law: int) -> None:
        """Give a law whose e is zero the side on which e leaves zero; it rests if it stays there."""
        out = self.leading(law, 0.0)
        if out == 0:
            self.rests.add(law)
        else:
            self.take(law, math.copysign(1.0, out), 0.0)

    def take(self, law: int, side: float, e: float) -> None:
        """Give a law the side that e enters, or the other if e turns back; it is stuck if both lead back."""
        self.sides[law] = side
        self.rests.discard(law)
        if (self.laws[law].order == 1 or e * side <= 0) and self.leading(law, side) < 0:
            if self.leading(law, -side) >= 0:
                self.sides[law] = -side
            elif self.laws[law].jumps:
                self.stuck = law

    def settle(self) -> None:
        """Find the laws that are idle, after those that were have taken the sides that they have by now."""
        idle = sorted(self.idle)
        for _ in idle:
            side = np.sign(self.at(self.sides)[idle, 0])
            changed = (side != 0) & (side != self.sides[idle])
            if not changed.any():
                break
            self.sides[idle] = np.where(changed, side, self.sides[idle])
        counting = self.way.sides.counting(self.sides)
        woken = self.idle & counting
        self.idle = {k for k in range(len(self.laws)) if k not in counting} - {*self.free} - self.rests
        for law in sorted(woken):
            if self.at(self.sides)[law, 0] == 0:
                self.start_from_zero(law)

    def leg(self, absolute: ArrayLike, between: Any, halt: Halt | None) -> None:
        """Append the next leg, and switch where it ends."""
        self.settle()
        way = self.way.leg(
            self.method, self.sides, frozenset((*self.free, *self.rests)), frozenset(self.idle)
        )
        way.options |= {"max_steps": self.left, "first_step": self.first_step}
        way.first.max_steps, way.first.first_step = self.left, self.first_step
        until, self.awake = self.until, -1
        for bound in self.free.values():
            until = self.sense * min(self.sense * until, self.sense * bound)
        if self.stuck >= 0:
            until = self.t
        path = way.path(self.y, self.t, until, absolute, between, first_halt(self.waking(), halt))
        if self.awake >= 0:
            path = cut(path, path.steps - 1, End.RUNNING)
        passed, row = self.passed(path)
        if passed >= 0:
            path = cut(path, row, End.RUNNING)
        if self.way.events and way.jumping:
            path.crossings = self.alternating((*path.crossings, *self.jumps(way, path)))
        duration = abs(path.end - self.t)
        self.t, self.y = path.end, path.states[-1].copy()
        if self.left is not None:
            self.left -= path.steps
        if path.method == "radau":
            self.method = "radau"
        if path.steps:
            self.first_step = float(np.abs(path.lengths).max())
        if passed >= 0 and self.stuck < 0:
            side = -self.sides[passed]
            self.last.append((passed, path.steps, self.t, 0.0))
            self.take(passed, side, side)
            self.look_back()
        elif self.stuck < 0:
            self.goes_on = self.switches(path, duration)
        if self.stuck >= 0:
            path.status, path.blame, self.goes_on = End.STUCK, self.stuck, False
        if path.steps or not self.goes_on:
            self.paths.append(path)
        if self.goes_on and len(self.paths) >= MOST:
            path.status, self.goes_on = End.TOO_MANY_STEPS, False

    def switches(self, path: Path, duration: float) -> bool:
        """Switch where a leg ended; return True if the run goes on."""
        if self.awake >= 0:
            self.take(self.awake, self.waking_side, 0.0)
            return True
        if path.status == End.FINISHED and path.end != self.until:
            self.bind(path.end)
            return True
        if path.status != End.TERMINAL:
            return False
        watch = self.way.watch
        if watch is not None and any(
            watch.terminal[x.number] and self.way.asked(x) and x.time != path.start
            for x in path.crossings
            if x.number < self.way.events
        ):
            return False
        if path.end == self.until:
            path.status = End.FINISHED
            return False
        now = self.at(self.sides)
        for law, side in self.events(path).items():
            if side != self.sides[law]:
                self.last.append((law, path.steps, self.t, abs(now[law, 1]) * duration))
                self.take(law, side, float(now[law, 0]))
        self.look_back()
        return True

    def events(self, path: Path) -> dict[int, float]:
        """Return the laws whose e passes zero in a leg, with the sides that they enter."""
        count = self.way.events
        found = {x.number - count: float(x.sign) for x in path.crossings if x.number >= count}
        return {law: side for law, side in found.items() if not self.unseen(law)}

    def unseen(self, law: int) -> bool:
        """Return True for a law whose switches do not end a leg."""
        return law in self.free or law in self.rests or law in self.idle

    def jumps(self, way: Way, path: Path) -> list[Crossing]:
        """Return the events that a leg has passed and not logged: those that jump where a law switches."""
        watch, count = way.options["watch"], self.way.events
        if watch is None or path.steps == 0:
            return []
        ends, states = path.times[[0, -1]], path.states[[0, -1]]
        before, after = np.sign(
            observe(watch.address, len(watch.directions), ends, states, watch.constants)[:, :count]
        )
        for x in path.crossings:
            if x.number < count:
                before[x.number] = 0.0 if abs(x.time - path.end) <= SAME * max(1.0, abs(path.end)) else x.sign
        return [
            Crossing(path.end, int(k), int(after[k]), path.states[-1].copy())
            for k in np.flatnonzero(before * after < 0)
        ]

    def alternating(self, crossings: Iterable[Crossing]) -> tuple[Crossing, ...]:
        """Return crossings without those that the leg before has logged: an event rises and falls in turn."""
        kept = []
        for x in crossings:
            if x.number >= self.way.events or x.sign != self.signs[x.number]:
                kept.append(x)
            if x.number < self.way.events:
                self.signs[x.number] = x.sign
        return tuple(kept)

    def passed(self, path: Path) -> tuple[int, int]:
        """Return a law whose e has passed zero unseen, between two moments that a time does not tell apart, and the
        number of the step in which it has; -1 if there is none.
        """
        if self.awake >= 0 or path.steps == 0 or self.stuck >= 0 or path.method in SINGLE_STEPS:
            return -1, 0
        events = list(self.events(path))
        if path.steps == 1 and len(events) == len(self.laws) - len(self.idle):
            return -1, 0
        e = self.way.sides.along(path.times, path.states, self.way.parameters, self.sides)[1:, :, 0]
        wrong = e * self.sides < 0
        wrong[:, [k for k in range(len(self.laws)) if self.unseen(k)]] = False
        wrong[-1, events] = False
        rows, laws = np.nonzero(wrong)
        return (int(laws[0]), int(rows[0])) if rows.size else (-1, 0)

    def look_back(self) -> None:
        """End the run where switches come ever faster; free laws that bend where their e is round-off."""
        if len(self.last) < IN_A_ROW or self.stuck >= 0:
            return
        faster = abs(self.t - self.last[0][2]) <= QUICK * abs(self.until - self.start)
        if not faster and self.laws[self.last[-1][0]].jumps:
            return
        jumping = next((law for law, *_ in self.last if self.laws[law].jumps), -1)
        if faster and jumping >= 0:
            self.stuck = jumping
            return
        if not faster and (
            jumping >= 0
            or any(steps > 2 or change > self.round_off(law) for law, steps, _, change in self.last)
        ):
            return
        laws = {law for law, *_ in self.last}
        for law in laws:
            self.spans[law] = max(2 * self.spans.get(law, 0.0), IN_A_ROW * (self.first_step or 0.0))
            self.free[law] = self.t + self.sense * self.spans[law]
        self.last.clear()

    def round_off(self, law: int) -> float:
        """Return the change of e that the tolerances of the state allow."""
        y, total = self.y, 0.0
        e = self.at(self.sides)[law, 0]
        for i, part in enumerate(np.broadcast_to(self.way.relative, y.shape)):
            self.y = y.copy()
            self.y[i] += part * (1 + abs(y[i]))
            total += abs(float(self.at(self.sides)[law, 0] - e))
        self.y = y
        return total

    def bind(self, t: float) -> None:
        """Give laws that have been free until a time their sides."""
        for law in [law for law, bound in self.free.items() if self.sense * (bound - t) <= 0]:
            del self.free[law]
            self.sides[law] = np.sign(self.at(self.sides)[law, 0])
            if self.sides[law] == 0:
                self.start_from_zero(law)

    def waking(self) -> Halt | None:
        """Return a function that stops a leg at the first state at which the e of a law at rest is not zero."""
        if not self.rests:
            return None
        laws, sides, parameters = sorted(self.rests), self.sides.copy(), self.way.parameters

        def first(times: Array, states: Array) -> tuple[int, End, int] | None:
            values = self.way.sides.along(times, states, parameters, sides)[:, laws, 0]
            rows, found = np.nonzero(values)
            if not rows.size or rows[0] == 0:
                return None
            self.awake, self.waking_side = laws[found[0]], float(np.sign(values[rows[0], found[0]]))
            return int(rows[0]), End.RELEASED, 0

        return first
