"""Runs of machines whose laws switch, in legs between the switches, in which the laws keep their sides (`sides`).

The compiled loop switches (`sided_loop`). Its legs become paths of their own here, each with the constants of its
sides.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...native.loop import Function, made, sibling
from ..ending import End
from ..ode import loops
from ..ode.dense_output import Array, Path, Rates, Watch
from ..ode.integration import Halt, Integration
from ..ode.layout import SINGLE_STEPS
from ..ode.memory import equip, make_log, make_rows, memory
from ..ode.memory import watch as watch_by
from ..ode.run import Run
from .contact_quantities import laws_watched, watched_program
from .hoisted import Hoisted
from .kernels import Kernels
from .methods import Way, made_by
from .sided_run import SidedLoop
from .sides import Sides, sides_of

PIECE = 256
"""Greatest number of steps of a leg between two looks at them."""
SPARE = 8
"""Number of memories of finished runs that a machine keeps: one for each thread that asks for the same functions."""


def way_of(
    kernels: Kernels, parameters: Array, method: str, rates: Rates, relative: Array, **options: Any
) -> Way:
    """Return the way of runs of a machine, by legs where its laws switch."""
    alone = method in SINGLE_STEPS  # these end where their steps do, and nowhere else
    sides = None if alone else sides_of(kernels)
    if sides is None:
        return Way(kernels, parameters, method, rates, relative, **options)
    return SidedWay(sides, parameters, method, relative, **options)


class SidedWay(Way):
    """The method and options of runs from several initial states, of a machine with laws that switch.

    The arguments are those of `Way`; the programs with their sides are in the place of the rates.
    """

    def __init__(
        self, sides: Sides, parameters: Array, method: str, relative: Array, **options: Any
    ) -> None:  # fmt: skip
        self.sides, self.own, programs = sides, parameters, sides.kernels
        with_sides = np.concatenate([parameters, np.zeros(len(sides.laws))])
        super().__init__(programs, with_sides, method, programs.rates(with_sides), relative, **options)

    def by(self, method: str, may_change: bool | None = None) -> Integration:
        """Return the integration by a method, whose steps are those of legs."""
        result = super().by(method, may_change)
        result.drive = self
        return result

    def _compared(
        self, state: Any, start: float, absolute: ArrayLike, between: Callable[[float], None] | None
    ) -> Callable[[float], None] | None:
        """Return ``between`` as it is: no other method is compared, which would not switch."""
        return between

    def begin(self, common: Integration, record: Run, start: float, until: float) -> Steps:
        """Return the steps of a run whose numbers are in a record."""
        watch = common.watch
        shape = common.method, () if watch is None else (watch.functions, watch.directions, watch.terminal)
        try:
            steps = self.sides.spare[shape].pop()
        except (KeyError, IndexError):  # none, or another thread took it
            steps = Steps(self, common, shape)
        steps.begin(self.own, common, record, start, until)
        return steps

    def paths(
        self, state: Sequence[float] | Array, start: float, until: float, absolute: ArrayLike,
        between: Callable[[float], None] | None = None, halt: Halt | None = None,
    ) -> list[Path]:  # fmt: skip
        """Return the paths of all legs of a run (`Way.path`); the last one tells how the run ended."""
        return self.split(self.path(state, start, until, absolute, between, halt))

    def split(self, path: Path) -> list[Path]:
        """Return the legs of a path, each with the rates of its sides."""
        legs = [leg for leg in path.legs if leg[0] < path.steps or leg[0] == 0]
        if not legs:  # it did not begin
            return [path]
        sense = 1.0 if path.end >= path.start else -1.0
        crossings, paths, done = list(path.crossings), list[Path](), 0
        numbers = np.empty((len(legs), len(self.parameters)))
        numbers[:, : len(self.own)] = self.own
        for k, (first, sides) in enumerate(legs):
            last = legs[k + 1][0] if k + 1 < len(legs) else path.steps
            end, begun, numbers[k, len(self.own) :] = path.times[last], done, sides
            if last == path.steps:
                done = len(crossings)
            while done < len(crossings) and sense * (crossings[done].time - end) <= 0:
                done += 1
            leg = object.__new__(Path)
            leg.__dict__.update(
                path.__dict__, _recipe=(made_by, self.kernels, numbers[k], path.method),
                times=path.times[first : last + 1], lengths=path.lengths[first:last],
                states=path.states[first : last + 1], crossings=tuple(crossings[begun:done]),
            )  # fmt: skip
            del leg.__dict__["rates"]
            del leg.__dict__["legs"]
            if last < path.steps:
                leg.status, leg.blame, leg.rejected, leg.evaluations, leg.stiff = End.RUNNING, 0, 0, 0, 0
            paths.append(leg)
        return paths


class Steps:
    """The steps of one run: a function that computes its next piece, with memory of its own.

    ``legs``    row of the first state, and the sides, of each leg so far
    """

    def __init__(self, way: SidedWay, common: Integration, shape: Any) -> None:
        self.shape, sides, rates, watch = shape, way.sides, common.rates, common.watch
        self.spare = sides.spare
        n, laws, m = rates.size, len(sides.laws), 0 if watch is None else len(watch.directions)
        watched = Watch(0, (), ()) if watch is None else watch
        self.rates = replace(rates, constants=rates.constants.copy())
        inner, own = memory(common.method, n, m + laws)
        equip(inner, own, self.rates)
        values = watched_program(way.kernels, watched.functions)
        constants = values.constants(way.parameters)
        self.hoisted = Hoisted.made(numbers=len(way.parameters), most_programs=4)
        self.laws = sides.run(n, self.hoisted)
        way.kernels.motion().follow(self.hoisted, self.rates.constants)
        if rates.method_kernels:
            rates.keep[1].follow(self.hoisted, self.rates.constants[rates.method_constants :])
        values.follow(self.hoisted, constants)
        loop = self.loop = SidedLoop.made(events=m, watched=m + laws, n=n, piece_room=PIECE)
        loop.values, loop.values_c = values.address("values"), constants
        loop.law_of[:] = laws_watched(way.kernels, watched.functions)
        loop.directions[:], loop.final[:] = watched.directions, watched.terminal
        loop.piece = loops.functions(common.method).functions["piece"].address
        loop.inner, loop.sided = inner.memory, self.laws.memory
        address = code("watched").address
        watch_by(inner.search, address, loop.memory, watched.directions, watched.terminal, laws)
        make_rows(inner, PIECE)
        make_log(inner.search, PIECE, n)
        self.inner, self.room = inner, 0
        self.pieces = code("pieces")

    def begin(
        self, parameters: Array, common: Integration, record: Run, start: float, until: float
    ) -> None:  # fmt: skip
        """Begin another run."""
        self.hoisted.parameters[: len(parameters)] = parameters
        self.laws.relative[:] = common.relative
        code("reset")(self.laws, start, until)
        self.record, self.taken, self.legs = record, 0, list[tuple[int, Array]]()
        self.loop.run, self.loop.ends, self.loop.step = record.memory, 0, common.step or 0.0

    def __call__(self, where: int) -> int:
        """Compute the next piece of the run."""
        loop, rows = self.loop, self.record.room + 2
        if rows > self.room:
            self.room = rows
            loop.leg_rows, loop.leg_sides = np.zeros(rows, dtype=np.int64), np.zeros((rows, self.laws.laws))
        status: int = self.pieces(loop)
        for k in range(loop.legs):
            self.legs.append((self.taken + int(loop.leg_rows[k]), loop.leg_sides[k].copy()))
        self.taken += self.record.accepted
        return status

    def give_back(self) -> None:
        """Offer this memory to the next run with the same functions."""
        if self.shape not in self.spare and len(self.spare) >= SPARE:
            self.spare.clear()
        of_shape = self.spare.setdefault(self.shape, [])
        if len(of_shape) < SPARE:
            of_shape.append(self)


_MODULES = tuple(sibling(__name__, name) for name in ("sided_loop", "switching"))


def code(name: str) -> Function:
    """Return a compiled function of `sided_loop`."""

    def functions() -> dict[str, Any]:
        from . import sided_loop, switching

        return vars(switching) | vars(sided_loop)

    return made(_MODULES[0], _MODULES, ("pieces", "watched", "reset"), functions, passes="few").functions[
        name
    ]
