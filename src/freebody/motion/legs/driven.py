"""Motion under signals and sampled controllers: constants of the machine that have other values in each interval.

    y' = f(t, y, p_k)    for t_k <= t < t_{k+1}

The times t_k are the break points of the signals and the samples of the controllers. Each interval is integrated by
itself, so that no step crosses a jump or a bend and every method keeps its order. All intervals use the same machine
code, with other constants. Controllers are called between two intervals only.

If a constant of gravity or of a spring changes at t_k, the energy jumps, and the ledger counts the jump as work:

    W_k = V(q, p_k) - V(q, p_{k-1})
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ...describe.controller import Controller
from ...dynamics.state import state_at
from ...errors import SimulationError, nearest
from ...model import Model
from ...model.symbols import symbols_of
from ...scalar.dual import value_of
from ..ending import End
from ..kernels.contact_quantities import OfContacts
from ..kernels.kernels import Kernels
from ..kernels.program import at_state
from ..ode.dense_output import Array, Crossing, Path, Rates, Watch, outputs_at
from ..start.arguments import MOST_STEPS, check_count, check_forwards
from ..start.initial import number
from ..start.signals import at_time
from ..trajectory.contact_expressions import of_contacts, refuse_outputs
from ..trajectory.phases import Phases, Segment, segments_of

_TOGETHER = 1e-12
"""Times that are closer, relative to 1 s or to their value, count as equal."""


class Reading(Mapping[str, float]):
    """Input of a controller: coordinates, speeds, parameters and sensors by name."""

    def __init__(self, values: Mapping[str, float], controller: str) -> None:
        self._values = values
        self._controller = controller

    def __getitem__(self, name: Any) -> float:
        text = name if isinstance(name, str) else str(name)
        if text not in self._values:
            raise SimulationError(
                f"Controller '{self._controller}' asks for '{text}'; {nearest(text, self._values)} Other quantities "
                "are passed to it as sensors={...}."
            )
        return self._values[text]

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def __repr__(self) -> str:
        return f"<Reading: {', '.join(f'{name} = {value:g}' for name, value in self._values.items())}>"


class Drives:
    """Constants of a machine as functions of time, from ``begin`` to ``end``.

    ``numbers``     current value of every parameter
    ``potential``   True if a constant of a potential changes
    """

    touched: Callable[[], Mapping[Any, Any]]
    """What gives the present quantities of contacts that sensors take; the run sets it."""

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
        for controller in model.controllers:
            name = controller.name
            period = number(model, numbers, controller.period, f"the period of controller '{name}'")
            if not period > 0:
                raise SimulationError(
                    f"Expected a period greater than 0 s for controller '{name}', got {period:g}."
                )
            what = f"a period of {period:g} s of controller '{name}'"
            check_count((end - begin) / period, most, what, "Sample less often")
            self.periods.append(period)
            reset = getattr(controller.function, "reset", None)
            if callable(reset):
                reset()
        self._sensors = [_sensors(kernels, controller) for controller in model.controllers]
        # (time, number of the controller or signal, number of its sample or piece) of the next change of each
        self._next: list[tuple[float, int, int]] = [(begin, i, 0) for i in range(len(self.periods))]
        for j, placed in enumerate(model.signals):
            times = placed.signal.times
            k = int(np.searchsorted(times, begin, side="right"))
            if k < len(times):
                self._next.append((float(times[k]), len(self.periods) + j, k))
        heapq.heapify(self._next)
        self.potential = self._potential()

    def _potential(self) -> bool:
        """Return True if a constant of a potential changes."""
        texts = {name for controller in self.model.controllers for name in controller.inputs}
        texts.update(symbol.name for placed in self.model.signals for symbol in placed.symbols)
        parts: list[Any] = list(self.model.gravity)
        for load in self.model.loads.values():
            if load.is_conservative:
                parts.append(load)
        return any(symbol.name in texts for symbol in symbols_of(parts))

    def until(self) -> float:
        """Return the time of the next change, or the end."""
        return min(self._next[0][0], self.end) if self._next else self.end

    def stops(self) -> list[float]:
        """Return the times of all changes between the start and the end, those that count as one once."""
        moments = [self.begin + p * np.arange(1, (self.end - self.begin) / p + 1) for p in self.periods]
        moments += [np.asarray(placed.signal.times, dtype=float) for placed in self.model.signals]
        result: list[float] = []
        last = self.begin
        for t in sorted(np.concatenate([np.empty(0), *moments]).tolist()):
            if t > self._soon(last) and self._soon(t) < self.end:
                result.append(t)
                last = t
        return result

    def change(self, t: float, y: Array) -> bool:
        """Apply the changes at t, signals before controllers; return True if there were any."""
        due = self._due(t)
        self._change(due, t, y)
        return bool(due)

    def _due(self, t: float) -> list[tuple[float, int, int]]:
        """Return the changes at t, which are the next ones no more."""
        due = []
        while self._next and self._next[0][0] <= self._soon(t):
            due.append(heapq.heappop(self._next))
        return due

    def _soon(self, t: float) -> float:
        """Return the time up to which changes count as those at t."""
        return t + _TOGETHER * max(1.0, abs(t))

    def _change(self, due: Sequence[tuple[float, int, int]], t: Any, y: Any) -> None:
        n = len(self.periods)
        for time, i, k in due:
            if i < n:
                heapq.heappush(self._next, (self.begin + (k + 1) * self.periods[i], i, k + 1))
                continue
            placed = self.model.signals[i - n]
            times = placed.signal.times
            # the end of the interval may miss the break point by round-off: take the piece that begins there
            self.numbers.update(placed.settings(time))
            if k + 1 < len(times):
                heapq.heappush(self._next, (float(times[k + 1]), i, k + 1))
        for i in sorted(i for _, i, _ in due if i < n):
            self._call_controller(i, t, y)

    def _call_controller(self, i: int, t: Any, y: Any) -> None:
        """Set the inputs of a controller to what its function returns."""
        controller = self.model.controllers[i]
        values = dict(self.numbers)
        values.update(zip(self.model.state_names, y.tolist(), strict=False))
        values.update(self._sensed(i, t, y))
        try:
            answer = controller.function(t, Reading(values, controller.name))
        except SimulationError as error:
            raise SimulationError(f"{error} (t = {t:.9g} s)") from None
        except Exception as error:
            raise self._failed(controller, t, error) from error
        for name, value in _answers(controller, answer, t, self._number):
            self.numbers[name] = value

    def _sensed(self, i: int, t: Any, y: Any) -> dict[str, Any]:
        """Return what the sensors of a controller give, by name."""
        names, program, of_contacts = self._sensors[i]
        result: dict[str, Any] = {}
        if names:
            constants = program.constants(self.kernels.parameters(self.numbers))
            result.update(zip(names, at_state(program, "values", t, y, constants).tolist(), strict=True))
        if of_contacts:
            state, numbers = state_at(self.model, y, t, self.numbers), self.touched()
            result.update({name: float(x.value(state, numbers)) for name, x in of_contacts.items()})
        return result

    @property
    def sensed(self) -> tuple[OfContacts, ...]:
        """Expressions of quantities of contacts that sensors of controllers give."""
        return tuple(x for _, _, of_contacts in self._sensors for x in of_contacts.values())

    def _failed(self, controller: Controller, t: float, error: Exception) -> SimulationError:
        """Return the error for a function that fails."""
        return SimulationError(
            f"Controller '{controller.name}' failed at t = {t:.9g} s: {type(error).__name__}: {error}"
        )

    _number: Callable[[Any], float] = float
    """Type of the numbers that controllers give."""


def _sensors(kernels: Kernels, controller: Controller) -> tuple[tuple[str, ...], Any, dict[str, OfContacts]]:
    """Return the sensors of a controller: names and program of those of the state, and those of contacts by name."""
    plain, contacts = dict[str, Any](), dict[str, OfContacts]()
    for name, x in controller.sensors:
        what = f"sensor '{name}' of controller '{controller.name}'"
        touches = of_contacts(kernels.model, x, what)
        if touches is None:
            refuse_outputs(kernels.model, x, what, "coordinates, speeds, contacts, parameters and the time")
            plain[name] = x
        else:
            contacts[name] = touches
    return tuple(plain), kernels.expressions(tuple(plain.values())) if plain else None, contacts


def intervals(
    kernels: Kernels, numbers: Mapping[str, float], begin: float, end: float
) -> tuple[Array, list[int], Array]:
    """Return the intervals from ``begin`` to ``end`` in which signals are polynomials.

    They are (start, end) of each, the indices of the coefficients among the parameters, and the coefficients, one row
    for each interval.
    """
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


def _answers(
    controller: Controller, answer: Any, t: float, read: Callable[[Any], float]
) -> Iterator[tuple[str, float]]:
    """Yield the inputs of a controller and their values from what its function returned."""
    expected = (
        f"a number for '{controller.inputs[0]}'"
        if len(controller.inputs) == 1
        else f"a mapping, or {len(controller.inputs)} numbers, for {', '.join(controller.inputs)}"
    )
    if isinstance(answer, Mapping):
        inputs = {str(key): value for key, value in answer.items()}
        for name in inputs:
            if name not in controller.inputs:
                raise SimulationError(
                    f"Controller '{controller.name}' returned a value for '{name}' at t = {t:.9g} s, which is not "
                    f"among its inputs; {nearest(name, controller.inputs)}"
                )
    elif answer is not None and np.ndim(answer) == 0 and len(controller.inputs) == 1:
        inputs = {controller.inputs[0]: answer}
    elif np.ndim(answer) == 1 and len(answer) == len(controller.inputs):
        inputs = dict(zip(controller.inputs, answer, strict=True))
    else:
        raise SimulationError(
            f"Expected {expected} from controller '{controller.name}' at t = {t:.9g} s, got {answer!r}."
        )
    for name, value in inputs.items():
        try:
            result = read(value)
        except (TypeError, ValueError):
            result = math.nan
        if not math.isfinite(value_of(result)):
            raise SimulationError(
                f"Expected a finite number for '{name}' from controller '{controller.name}' at t = {t:.9g} s, "
                f"got {value!r}."
            )
        yield name, result


_FIXED = (
    "mass", "center", "inertia", "armature", "rotor", "rotation", "position", "axis", "pitch", "displacement",
)  # fmt: skip
"""Data of a link that do not jump."""


def _check_inputs(model: Model) -> None:
    """Refuse inputs outside of loads and gravity: they would move masses by jumps."""
    names = {name: controller.name for controller in model.controllers for name in controller.inputs}
    if not names:
        return
    fixed: list[Any] = [getattr(link, name) for link in model.links for name in _FIXED]
    fixed += [(family.law, [member.shape for member in family.members]) for family in model.families]
    fixed += [model.constraints, list(model.contacts)]
    for symbol in symbols_of(fixed):
        if symbol.name in names:
            raise SimulationError(
                f"Controller '{names[symbol.name]}' sets '{symbol.name}', which occurs in a mass, a dimension, a "
                "displacement or a constraint. It jumps between samples, and the jump would need infinite forces: "
                "set a force, a torque, or the stiffness or rest of a spring."
            )


def driven_path(
    drives: Drives,
    leg: Callable[..., Path | Phases],
    rates: Rates,
    watch: Watch | None,
    state: Any,
    begin: float,
    end: float,
    work: float,
) -> Phases:
    """Return the path of a machine whose constants change during the run.

    Parameters
    ----------
    leg                  (parameters, rates, state, start, end, watch=, first_step=, method=) -> Path
    work                 work of blows until now
    """
    kernels = drives.kernels
    energy, constants_of = kernels.motion().address("energy"), rates.keep.constants
    segments: list[Segment] = []
    t, y = begin, np.array(state, dtype=float)
    parameters = kernels.parameters(drives.numbers)
    current = rates
    first_step: float | None = None
    method: str | None = None
    at_start = True
    while True:
        before = current
        try:
            changed = drives.change(t, y)
        except KeyboardInterrupt:
            return _ended(segments, current, t, y, work, parameters, End.INTERRUPTED)
        if changed or at_start:
            parameters = kernels.parameters(drives.numbers)
            current = replace(rates, constants=constants_of(parameters), recipe=(kernels.rates, parameters))
            if drives.potential and not at_start:
                work += _energy_jump(energy, t, y, before, current)
            if watch is not None:
                previous, watch = watch, replace(watch, constants=watch.keep.constants(parameters))
                if segments:
                    last = segments[-1].path
                    jumps = _event_jumps(previous, watch, t, y)
                    if jumps:
                        last = replace(last, crossings=(*last.crossings, *jumps))
                        segments[-1] = replace(segments[-1], path=last)
                        if any(watch.terminal[crossing.number] for crossing in jumps):
                            return Phases(tuple(segments), End.TERMINAL)
        at_start = False
        until = min(drives.until(), end)
        path = leg(parameters, current, y, t, until, watch=watch, first_step=first_step, method=method)
        segments += [replace(x, impulses=work, parameters=parameters) for x in segments_of(path, kernels)]
        if path.method == "radau":
            method = "radau"
        if path.steps > 1:
            first_step = float(np.max(np.abs(path.lengths)))
        elif path.steps:
            first_step = max(first_step or 0.0, abs(float(path.lengths[0])))
        y, t = path.states[-1].copy(), path.end
        if path.status != End.FINISHED or t >= end:
            return Phases(tuple(segments), path.status)


def _ended(
    segments: list[Segment], rates: Rates, t: float, y: Array, work: float, parameters: Array, status: End
) -> Phases:
    """Return the path that ends at t."""
    tail = Path(rates, np.array([t]), np.empty(0), y[None], (), status, 0, 0, 0)
    return Phases(
        (*segments, Segment(tail, segments[-1].kernels if segments else None, work, parameters=parameters)),
        status,
    )


def _energy_jump(energy: int, t: float, y: Array, before: Rates, after: Rates) -> float:
    """Return the change of the energy when constants change."""
    old, new = (outputs_at(energy, 2, t, y, rates.constants) for rates in (before, after))
    return float(np.sum(new - old))


def _event_jumps(old: Watch, new: Watch, t: float, y: Array) -> tuple[Crossing, ...]:
    """Return the crossings of event functions that jump across zero when constants change."""
    m = len(new.directions)
    assert old.constants is not None and new.constants is not None
    before = np.sign(outputs_at(old.address, m, t, y, old.constants))
    after = np.sign(outputs_at(new.address, m, t, y, new.constants))
    return tuple(
        Crossing(t, k, int(after[k]), y.copy())
        for k in range(m)
        if before[k] * after[k] < 0 and new.directions[k] in (0, int(after[k]))
    )
