"""Motion under signals and sampled controllers: constants of the machine that have other values in each interval.

    y' = f(t, y, p_k)    for t_k <= t < t_{k+1}

The moments t_k are the break points of the signals and the samples of the controllers. Each interval is integrated by
itself, so that no step crosses a jump or a bend and every method keeps its order; the machine code is one, and called
with other constants. Python is asked between two intervals only.

Where gravity or a spring has another constant from t_k on, the energy jumps, and the ledger counts the jump as work:

    W_k = V(q, p_k) - V(q, p_{k-1})
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import sympy

from ...describe.loads.load import JointSpring, Spring
from ...errors import ModelError, SimulationError, nearest
from ...model import Model
from ...model.symbols import symbols_of
from ..kernels.kernels import Kernels
from ..ode.dense_output import FINISHED, INTERRUPTED, Array, Crossing, Path, Rates, Watch, observe
from ..start.arguments import MOST_STEPS, check_count, check_forwards
from ..start.initial import number
from ..trajectory.event import EventSpec
from ..trajectory.phases import Phases, Segment, segments_of

_TOGETHER = 1e-12
"""Moments that are closer, relative to 1 s or to their time, are one."""


def refuse_switched(model: Model, what: str) -> None:
    """Refuse a machine with signals or controllers where constants can not change on the way."""
    if model.switched:
        names = [one.name for one in model.controllers] + [one.signal.name for one in model.signals]
        raise SimulationError(
            f"'{model.name}' has signals or controllers ({', '.join(names)}), which are not for {what}. Leave them "
            "out, or write the law as an expression of time, coordinates and speeds."
        )


def at_time(model: Model, numbers: Mapping[str, float], t: float) -> Mapping[str, float]:
    """Values of all parameters with those that signals have at a time."""
    if not model.names.signals:
        return numbers
    result = dict(numbers)
    for placed in model.signals:
        try:
            result.update(placed.settings(t))
        except ModelError as error:
            raise SimulationError(str(error)) from None
    return result


def check_signals(model: Model) -> None:
    """Signals that an event brought are part of no machine."""
    if not model.names.signals:
        return
    known = {placed.signal.name for placed in model.signals}
    for placed in model.names.signals.values():
        if placed.signal.name not in known:
            raise SimulationError(
                f"Signal '{placed.signal.name}' stands in no load and no drive of '{model.name}', only in an event or "
                "an output. Use it in the machine before it is assembled: in a load of a factor 0, if nothing else."
            )


class Reading(Mapping[str, float]):
    """What a controller is told: coordinates, speeds, parameters and sensors by name."""

    def __init__(self, values: Mapping[str, float], who: str) -> None:
        self._values = values
        self._who = who

    def __getitem__(self, name: Any) -> float:
        text = name if isinstance(name, str) else str(name)
        if text not in self._values:
            raise SimulationError(
                f"Controller '{self._who}' asks for '{text}'; {nearest(text, self._values)} Other quantities are "
                "passed to it as sensors={...}."
            )
        return self._values[text]

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def __repr__(self) -> str:
        return f"<Reading: {', '.join(f'{name} = {value:g}' for name, value in self._values.items())}>"


class Drives:
    """The constants of a machine as time goes on, from ``begin`` to ``end``."""

    def __init__(
        self, kernels: Kernels, numbers: Mapping[str, float], begin: float, end: float, most: int
    ) -> None:
        model = kernels.model
        check_forwards(begin, end, f"a run of '{model.name}'", "signals and controllers")
        self.kernels, self.model, self.begin, self.end = kernels, model, begin, end
        _check_inputs(model)
        self.numbers = dict(at_time(model, numbers, begin))
        at_time(model, {}, end)
        self.periods = []
        for one in model.controllers:
            period = number(model, numbers, one.period, f"the period of controller '{one.name}'")
            if not period > 0:
                raise SimulationError(
                    f"Expected a period greater than 0 s for controller '{one.name}', got {period:g}."
                )
            what = f"a period of {period:g} s of controller '{one.name}'"
            check_count((end - begin) / period, most, what, "Sample less often")
            self.periods.append(period)
            reset = getattr(one.function, "reset", None)
            if callable(reset):
                reset()
        self._sensors = [
            kernels.expressions(tuple(e for _, e in one.sensors)) if one.sensors else None
            for one in model.controllers
        ]
        # (moment, place in order, what, which): the next sample of each controller, the next break of each signal
        self._next: list[tuple[float, int, int]] = [(begin, i, 0) for i in range(len(self.periods))]
        for j, placed in enumerate(model.signals):
            times = placed.signal.times
            k = int(np.searchsorted(times, begin, side="right"))
            if k < len(times):
                self._next.append((float(times[k]), len(self.periods) + j, k))
        heapq.heapify(self._next)
        self.potential = self._potential()

    def _potential(self) -> bool:
        """Whether what changes stands in a potential."""
        texts = {name for one in self.model.controllers for name in one.inputs}
        texts.update(symbol.name for placed in self.model.signals for symbol in placed.symbols)
        parts: list[Any] = list(self.model.gravity)
        for load in self.model.loads.values():
            if isinstance(load, Spring | JointSpring):
                parts += [load.stiffness, load.rest]
        return any(
            symbol.name in texts
            for part in parts
            if isinstance(part, sympy.Basic)
            for symbol in part.free_symbols
        )

    def until(self) -> float:
        """The next moment of a change, or the end."""
        return min(self._next[0][0], self.end) if self._next else self.end

    def change(self, t: float, y: Array) -> bool:
        """Whatever changes at t: signals first, then controllers in order of declaration. Whether any did."""
        due = []
        while self._next and self._next[0][0] <= t + _TOGETHER * max(1.0, abs(t)):
            due.append(heapq.heappop(self._next))
        if not due:
            return False
        n = len(self.periods)
        for moment, i, k in due:
            if i < n:
                heapq.heappush(self._next, (self.begin + (k + 1) * self.periods[i], i, k + 1))
                continue
            placed = self.model.signals[i - n]
            times = placed.signal.times
            # the piece that begins at the break point itself, which the end of the interval may miss by round-off
            self.numbers.update(placed.settings(moment))
            if k + 1 < len(times):
                heapq.heappush(self._next, (float(times[k + 1]), i, k + 1))
        for i in sorted(i for _, i, _ in due if i < n):
            self._ask(i, t, y)
        return True

    def _ask(self, i: int, t: float, y: Array) -> None:
        one = self.model.controllers[i]
        told = dict(self.numbers)
        told.update(zip((*self.model.coordinate_names, *self.model.speed_names), y.tolist(), strict=False))
        program = self._sensors[i]
        if program is not None:
            constants = program.constants(self.kernels.parameters(self.numbers))
            found = observe(program.address("values"), len(one.sensors), np.array([t]), y[None], constants)[0]
            told.update(zip((name for name, _ in one.sensors), found.tolist(), strict=True))
        try:
            answer = one.function(t, Reading(told, one.name))
        except SimulationError as error:
            raise SimulationError(f"{error} (t = {t:.9g} s)") from None
        except Exception as error:
            raise SimulationError(
                f"Controller '{one.name}' failed at t = {t:.9g} s: {type(error).__name__}: {error}"
            ) from error
        for name, value in _answers(one, answer, t):
            self.numbers[name] = value


def intervals(
    kernels: Kernels, numbers: Mapping[str, float], begin: float, end: float
) -> tuple[Array, list[int], Array]:
    """Intervals from ``begin`` to ``end`` in which signals are polynomials, (start, end) of each; places of their
    coefficients among the parameters; and their values, a row for each interval."""
    model = kernels.model
    names = [symbol.name for placed in model.signals for symbol in placed.symbols]
    order = [parameter.name for parameter in model.parameters]
    places = [order.index(name) for name in names]
    if not names:
        return np.array([[begin, end]]), places, np.empty((1, 0))
    drives = Drives(kernels, numbers, begin, end, MOST_STEPS)
    spans: list[tuple[float, float]] = []
    settings: list[list[float]] = []
    t, nowhere = begin, np.empty(0)
    while not spans or t < end:
        drives.change(t, nowhere)
        until = min(drives.until(), end)
        spans.append((t, until))
        settings.append([drives.numbers[name] for name in names])
        t = until
    return np.array(spans), places, np.array(settings)


def _answers(one: Any, answer: Any, t: float) -> Iterator[tuple[str, float]]:
    """Inputs and their values from what a controller returned."""
    expected = (
        f"a number for '{one.inputs[0]}'"
        if len(one.inputs) == 1
        else f"a mapping, or {len(one.inputs)} numbers, for {', '.join(one.inputs)}"
    )
    if isinstance(answer, Mapping):
        given = {str(key): value for key, value in answer.items()}
        for name in given:
            if name not in one.inputs:
                raise SimulationError(
                    f"Controller '{one.name}' returned a value for '{name}' at t = {t:.9g} s, which is not among its "
                    f"inputs; {nearest(name, one.inputs)}"
                )
    elif answer is not None and np.ndim(answer) == 0 and len(one.inputs) == 1:
        given = {one.inputs[0]: answer}
    elif np.ndim(answer) == 1 and len(answer) == len(one.inputs):
        given = dict(zip(one.inputs, answer, strict=True))
    else:
        raise SimulationError(
            f"Expected {expected} from controller '{one.name}' at t = {t:.9g} s, got {answer!r}."
        )
    for name, value in given.items():
        try:
            result = float(value)
        except (TypeError, ValueError):
            result = math.nan
        if not math.isfinite(result):
            raise SimulationError(
                f"Expected a finite number for '{name}' from controller '{one.name}' at t = {t:.9g} s, got {value!r}."
            )
        yield name, result


def _check_inputs(model: Model) -> None:
    """Inputs may not move what has mass by jumps: they stand in loads and gravity only."""
    names = {name: one.name for one in model.controllers for name in one.inputs}
    if not names:
        return
    fixed: list[Any] = [
        (
            link.mass,
            link.center,
            link.inertia,
            link.rotation,
            link.position,
            link.axis,
            link.pitch,
            link.displacement,
        )
        for link in model.links
    ]
    fixed += [model.constraints, [pair for pair in model.contacts]]
    for symbol in symbols_of(fixed):
        if symbol.name in names:
            raise SimulationError(
                f"Controller '{names[symbol.name]}' sets '{symbol.name}', which stands in a mass, a dimension, a "
                "displacement or a constraint. It jumps between samples, and what it moved would need infinite forces: "
                "set a force, a torque, or the stiffness or rest of a spring."
            )


def driven_path(
    drives: Drives,
    leg: Callable[..., Path | Phases],
    rates: Rates,
    watch: Watch | None,
    specs: Sequence[EventSpec],
    state: Any,
    begin: float,
    end: float,
    work: float = 0.0,
) -> Phases:
    """The path of a machine whose constants change on the way.

    Parameters
    ----------
    leg                  (parameters, rates, state, from, to, watch=, first_step=, method=) -> Path
    specs                events of the user (and of blows), in the order of ``watch``
    work                 that blows have done until now
    """
    kernels = drives.kernels
    energy, constants_of = kernels.motion().address("energy"), rates.keep.constants
    segments: list[Segment] = []
    t, y = begin, np.array(state, dtype=float)
    parameters = kernels.parameters(drives.numbers)
    here = rates
    natural: float | None = None
    method: str | None = None
    fresh = True
    while True:
        before = here
        try:
            changed = drives.change(t, y)
        except KeyboardInterrupt:
            return _ended(segments, here, t, y, work, parameters, INTERRUPTED)
        if changed or fresh:
            parameters = kernels.parameters(drives.numbers)
            here = replace(rates, constants=constants_of(parameters), recipe=(kernels.rates, parameters))
            if drives.potential and not fresh:
                work += _jump(energy, t, y, before, here)
            if watch is not None:
                was, watch = watch, replace(watch, constants=watch.keep.constants(parameters))
                if segments:
                    last = segments[-1].path
                    found = _jumped(was, watch, t, y)
                    if found:
                        last = replace(last, crossings=(*last.crossings, *found))
                        segments[-1] = replace(segments[-1], path=last)
                        if any(specs[one.number].terminal for one in found):
                            return Phases(tuple(segments), "terminal event")
        fresh = False
        path = leg(
            parameters, here, y, t, min(drives.until(), end), watch=watch, first_step=natural, method=method
        )
        segments += [replace(one, impulses=work, parameters=parameters) for one in segments_of(path, kernels)]
        if path.method == "radau":
            method = "radau"
        if path.steps > 1:
            natural = float(np.max(np.abs(path.lengths)))
        elif path.steps:
            natural = max(natural or 0.0, abs(float(path.lengths[0])))
        y, t = path.states[-1].copy(), path.end
        if path.status != FINISHED or t >= end:
            return Phases(tuple(segments), path.status)


def _ended(
    segments: list[Segment], rates: Rates, t: float, y: Array, work: float, parameters: Array, status: str
) -> Phases:
    tail = Path(rates, np.array([t]), np.empty(0), y[None], (), status, 0, 0, 0)
    return Phases(
        (*segments, Segment(tail, segments[-1].kernels if segments else None, work, parameters=parameters)),
        status,
    )


def _jump(energy: int, t: float, y: Array, before: Rates, after: Rates) -> float:
    """Change of the energy where constants change."""
    moment, state = np.array([t]), y[None]
    was = observe(energy, 2, moment, state, before.constants)[0]
    return float(np.sum(observe(energy, 2, moment, state, after.constants)[0] - was))


def _jumped(was: Watch, now: Watch, t: float, y: Array) -> tuple[Crossing, ...]:
    """Event functions that jump across zero where constants change."""
    moment, state, m = np.array([t]), y[None], len(now.directions)
    assert was.constants is not None and now.constants is not None
    before = np.sign(observe(was.address, m, moment, state, was.constants)[0])
    after = np.sign(observe(now.address, m, moment, state, now.constants)[0])
    return tuple(
        Crossing(t, k, int(after[k]), y.copy())
        for k in range(m)
        if before[k] * after[k] < 0 and now.directions[k] in (0, int(after[k]))
    )
