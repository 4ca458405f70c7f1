"""Parameters and initial values of the lanes of a batch: numbers, arrays and expressions become one row per lane."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy
from numpy.typing import NDArray

from ...describe.names import finite
from ...errors import ExpressionError, SimulationError
from ...model import Model
from ...model.model import unit_of
from ...scalar.arrays import arrays, column
from ...scalar.expression import evaluate
from ...scalar.units import quantity
from ...space.feasibility import TOLERANCE
from ...space.rotation import Rotation
from ..kernels.kernels import Kernels
from ..start.initial import named_state, quaternions_by_joint, refuse_unit, several
from ..start.loop_closure import closed_start
from .kernels import state_of

Array = NDArray[np.float64]

_CHUNK = 1 << 14
"""Number of lanes that are checked at a time: their numbers stay in the cache of a processor."""
_CLEAR = 1e-9
"""Share of the greatest number, among the lanes, below which a negative one may be due to round-off."""


@dataclass(frozen=True, eq=False)
class Lanes:
    """Parameters and initial values of all lanes.

    ``count``     number of lanes
    ``columns``   value of every parameter: a number, or an array of length ``count``
    ``initial``   initial values by name: numbers, texts, expressions, or arrays of length ``count``
    ``varied``    names of the parameters, and names of the initial values, that differ between lanes
    """

    model: Model
    count: int
    columns: Mapping[str, Any]
    initial: Mapping[str, Any]
    varied: tuple[tuple[str, ...], tuple[str, ...]]

    def values_of(self, lane: int) -> dict[str, float]:
        """Return the parameters of one lane by name."""
        return {name: float(x[lane]) if np.ndim(x) else float(x) for name, x in self.columns.items()}

    def given_to(self, lane: int) -> dict[str, float]:
        """Return the parameters of one lane by name, as a user would give them: without those that a motion writes."""
        return self.model.given(self.values_of(lane))

    def initial_of(self, lane: int) -> dict[str, Any]:
        """Return the initial values of one lane by name."""
        values = {name: x[lane] if name in self.varied[1] else x for name, x in self.initial.items()}
        return {name: float(x) if isinstance(x, np.floating) else x for name, x in values.items()}

    def part(self, lanes: NDArray[np.int64]) -> tuple[dict[str, Any], dict[str, Any]]:
        """Return values and initial values of some lanes, as a user would give them."""
        columns = {name: x[lanes] if np.ndim(x) else float(x) for name, x in self.columns.items()}
        start = {
            name: ([x[k] for k in lanes] if isinstance(x, list) else x[lanes])
            if name in self.varied[1]
            else x
            for name, x in self.initial.items()
        }
        return self.model.given(columns), start

    def first(self, count: int) -> Lanes:
        """Return the first lanes."""
        if self.count <= count:
            return self
        columns = {name: x[:count] if np.ndim(x) else x for name, x in self.columns.items()}
        initial = {name: x[:count] if name in self.varied[1] else x for name, x in self.initial.items()}
        return Lanes(self.model, count, columns, initial, self.varied)

    @property
    def extremes(self) -> tuple[int, ...]:
        """A few lanes that show whether a value depends on the lane."""
        n = self.count
        return tuple(dict.fromkeys((0, n // 3, n // 2, n - 1))) if self.varied[0] else (0,)

    def parameters(self, lanes: NDArray[np.int64]) -> Array:
        """Return rows of parameters, in the order of the model."""
        result = np.empty((len(lanes), max(1, len(self.model.parameters))))
        for j, parameter in enumerate(self.model.parameters):
            x = self.columns[parameter.name]
            result[:, j] = x[lanes] if np.ndim(x) else x
        return np.ascontiguousarray(result[:, : len(self.model.parameters)])

    def suspects(self) -> list[int]:
        """Return the lanes whose values seem impossible; those that are the same in all lanes are left out."""
        return np.flatnonzero(self.impossible()[0]).tolist() if self.varied[0] else []

    def impossible(self, constants: bool = False) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Return the lanes whose values seem impossible, and those in which they are so beyond round-off.

        Where only the first holds, `check_bodies` and `check_assumptions` decide. What is the same in all lanes is left
        out, since any lane tells it, unless ``constants`` is True.
        """
        varied = {p.symbol for p in self.model.parameters if p.name in self.varied[0]}

        def varies(*expressions: Any) -> bool:
            return constants or any(varied & getattr(x, "free_symbols", set()) for x in expressions)

        signs = [(x, True) for x in self.model.assumed if varies(x)]
        inertias = []
        for place in self.model.bodies.values():
            if place.properties is not None:
                signs += [(x, False) for x in (place.mass, *place.properties.positive) if varies(x)]
                if varies(*(x for row in place.inertia for x in row)):
                    inertias.append(place.inertia)
        bad, clear = np.zeros(self.count, dtype=bool), np.zeros(self.count, dtype=bool)
        for low in range(0, self.count, _CHUNK) if signs or inertias else ():
            rows = slice(low, low + _CHUNK)
            columns = {name: column(x[rows] if np.ndim(x) else x) for name, x in self.columns.items()}
            with np.errstate(all="ignore"):
                state = state_of(self.model, arrays, columns)
                for inertia in inertias:
                    finite, excess = _excess(state.matrix(inertia))
                    # half and twice the round-off that `space.feasibility` allows
                    bad[rows] |= ~finite | (excess > TOLERANCE / 2)
                    clear[rows] |= finite & (excess > 2 * TOLERANCE)
                for expression, strictly in signs:
                    x = np.asarray(state(expression), dtype=float)
                    bad[rows] |= ~(x > 0) if strictly else ~(x >= 0)
                    clear[rows] |= x < -_CLEAR * np.max(np.abs(x), initial=0.0, where=np.isfinite(x))
        return bad, clear

    def states(
        self, near: Mapping[Any, Any], begin: float, project: bool, kernels: Kernels,
        active: tuple[int, ...] | None = None,
    ) -> tuple[Array, dict[int, str], tuple[int, ...], tuple[int, ...]]:  # fmt: skip
        """Return the initial states of the lanes.

        They are (q, u), shape (count, n) or (1, n); the reasons of lanes without an initial state; the independent
        conditions, ``active`` or else those of the first lane; and the lanes in which other conditions are independent.
        """
        if self.model.constraints:
            return self._closed(near, begin, project, kernels, active)
        y, _ = named_state(self.model, self.values_of(0), self.initial_of(0))
        if not self.varied[0] and not self.varied[1]:
            return y[None], {}, (), ()
        names = self.model.state_names
        quaternions = quaternions_by_joint(self.model)
        result = np.tile(y, (self.count, 1))
        named: set[int] = set()
        for name, value in self.initial.items():
            if name in quaternions:
                if name in self.varied[1]:
                    start = quaternions[name]
                    rows = [x.as_quaternion() if isinstance(x, Rotation) else x for x in value]
                    result[:, start : start + 4] = np.asarray(rows, dtype=float)
            else:
                i = names.index(name)
                result[:, i] = self._column(value, name)
                named.add(i)
        for start in self.model.quaternions:
            four = result[:, start : start + 4]
            length = np.linalg.norm(four, axis=1, keepdims=True)
            if (length == 0).any():
                raise SimulationError(
                    f"Expected quaternions ({', '.join(names[start : start + 4])}) of length 1, got all zeros in lane "
                    f"{int(np.flatnonzero(length == 0)[0])}."
                )
            if named & set(range(start, start + 4)) or self.varied[1]:
                four /= length
        return result, {}, (), ()

    def _column(self, value: Any, name: str) -> Any:
        """Return an initial value in all lanes."""
        if name in self.varied[1]:
            return np.asarray(value, dtype=float)
        expression = self.model.names.expression(value, f"the initial value of '{name}'")
        if not isinstance(expression, sympy.Basic):
            return float(expression)
        lookup = {p.symbol: column(self.columns[p.name]) for p in self.model.parameters}
        with np.errstate(all="ignore"):
            result = np.asarray(evaluate(expression, lookup, arrays), dtype=float)
        result = np.broadcast_to(result, (self.count,))
        if not np.isfinite(result).all():
            lane = int(np.flatnonzero(~np.isfinite(result))[0])
            raise SimulationError(
                f"Expected finite numbers for the initial value of '{name}', but '{value}' has no value in lane {lane}."
            )
        return result

    def _closed(
        self,
        near: Mapping[Any, Any],
        begin: float,
        project: bool,
        kernels: Kernels,
        active: tuple[int, ...] | None,
    ) -> tuple[Array, dict[int, str], tuple[int, ...], tuple[int, ...]]:
        """Return :meth:`states` of a machine with constraints, solved for in each lane."""
        same = not self.varied[0] and not self.varied[1]
        rows: dict[int, Any] = {}
        no_start: dict[int, str] = {}
        apart: list[int] = []
        for lane in range(1 if same else self.count):
            try:
                y, independent = closed_start(
                    kernels, self.values_of(lane), self.initial_of(lane), near, begin, project
                )
            except SimulationError as error:
                if same:
                    raise
                no_start[lane] = str(error)
                continue
            active = independent if active is None else active
            if independent != active:
                apart.append(lane)
            rows[lane] = y
        if active is None:
            raise SimulationError(f"No lane has a start. Lane 0: {no_start[0]}")
        if same:
            return rows[0][None], {}, active, tuple(apart)
        result = np.full((self.count, self.model.n_q + self.model.n_u), np.nan)
        for lane, y in rows.items():
            result[lane] = y
        return result, no_start, active, tuple(apart)


def _excess(inertia: Any) -> tuple[Any, Any]:
    """Return whether the entries of inertia matrices are finite, and by how much these cannot be.

    Moments that are negative or break the triangle inequality count, in units of the greatest entry. The moments about
    the axes of the matrix must obey both as the principal ones do.

    Parameters
    ----------
    inertia : 3 rows of 3 numbers or arrays of one length
    """
    entries = [np.asarray(x, dtype=float) for row in inertia for x in row]
    scale = np.abs(entries[0])
    for x in entries[1:]:
        if x.ndim or x:
            scale = np.maximum(scale, np.abs(x))
    finite = np.isfinite(scale)
    result = _excess_of_moments(*entries[::4])
    if any(x.ndim or x for i, x in enumerate(entries) if i % 4):
        matrices = np.stack(np.broadcast_arrays(*entries), axis=-1)
        matrices = np.where(np.asarray(finite)[..., None], matrices, 0.0).reshape(-1, 3, 3)
        moments = np.asarray(np.linalg.eigvalsh(matrices), dtype=np.float64)
        result = np.maximum(result, _excess_of_moments(*moments.T))
    return finite, np.where(finite & (scale > 0), result / scale, 0.0)


def _excess_of_moments(a: Any, b: Any, c: Any) -> Any:
    """Return the greatest of -a and a - b - c, over all orders of three moments of inertia."""
    least, greatest = np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)
    return np.maximum(-least, 2 * greatest - (a + b + c))


def lanes_of(model: Model, values: Mapping[Any, Any], initial: Mapping[Any, Any]) -> Lanes:
    """Return the lanes that arrays among values and initial values ask for, all of one length.

    Raises
    ------
    SimulationError
        Arrays of different lengths or of more axes, and numbers that are not finite, by name and lane.
    """
    for what, argument in (("values", values), ("initial", initial)):
        if not isinstance(argument, Mapping):
            raise SimulationError(f"Expected {what}= by name, such as {{'theta': 0.1}}, got {argument!r}.")
    symbols = {parameter.symbol: parameter.name for parameter in model.parameters}
    quaternions = quaternions_by_joint(model)
    lengths: dict[str, int] = {}
    given_values: dict[str, Any] = {}
    given_initial: dict[str, Any] = {}
    for key, value in values.items():
        name = key if isinstance(key, str) else symbols.get(key, str(key))
        given_values[name] = _array(model, value, name, False, lengths, f"values of '{name}'")
    for key, value in initial.items():
        name = model.names.text_of(key)
        given_initial[name] = _array(
            model, value, name, name in quaternions, lengths, f"initial values of '{name}'"
        )
    count = max(lengths.values(), default=1)
    if count == 0:
        raise SimulationError(
            f"Expected at least one lane, got no {next(iter(lengths))}. Give one for each lane."
        )
    others = {what: n for what, n in lengths.items() if n not in (1, count)}
    if others:
        largest = next(what for what, n in lengths.items() if n == count)
        (what, n), *_ = others.items()
        raise SimulationError(
            f"Expected arrays of one length, got {count} {largest} and {n} {what}. Entry k of every array belongs to "
            "lane k; for all combinations use fb.sweep."
        )
    model.refuse_written(given_values)
    numbers = model.values({k: v[0] if isinstance(v, np.ndarray) else v for k, v in given_values.items()})
    columns: dict[str, Any] = dict(numbers)
    varied: tuple[list[str], list[str]] = ([], [])
    for name, value in given_values.items():
        if isinstance(value, np.ndarray):
            columns[name] = np.broadcast_to(value, (count,))
            varied[0].append(name)
    start: dict[str, Any] = {}
    for name, value in given_initial.items():
        many = (isinstance(value, np.ndarray) and value.ndim > int(name in quaternions)) or (
            name in quaternions and isinstance(value, list) and bool(value) and isinstance(value[0], Rotation)
        )
        start[name] = value
        if many:
            start[name] = list(value) * count if isinstance(value, list) and len(value) == 1 else value
            if isinstance(value, np.ndarray):
                start[name] = np.broadcast_to(value, (count, *value.shape[1:]))
            varied[1].append(name)
    return Lanes(model, count, columns, start, (tuple(varied[0]), tuple(varied[1])))


def numbers_in(model: Model, values: Any, name: str, what: str) -> Any:
    """Return several values of a parameter, or of an initial value, with numbers in place of texts."""
    if not isinstance(values, list | tuple | np.ndarray):
        return values
    if isinstance(values, np.ndarray) and values.dtype.kind in "biuf":
        return values
    if not any(issubclass(kind, str) for kind in set(map(type, values))):
        return values
    numbers = []
    unit = unit_of(model, name) if name in model.defaults else ""
    for lane, x in enumerate(values):
        if isinstance(x, str):
            try:
                if name in model.defaults:
                    numbers.append(finite(quantity(x, unit, f"parameter '{name}'"), what))
                    continue
                expression = model.names.expression(x, what)
            except ExpressionError as error:
                if name not in model.defaults:
                    refuse_unit(x, f"the {what}")
                raise SimulationError(
                    f"Expected an array of numbers for the {what}, got {values!r}. {error}"
                ) from None
            if getattr(expression, "free_symbols", None):
                raise SimulationError(
                    f"Expected numbers for the {what}, got '{x}' in lane {lane}. An expression of parameters stands "
                    f"for all lanes: initial={{'{name}': '{x}'}}."
                )
            x = float(expression)
        numbers.append(x)
    return numbers


def _array(model: Model, value: Any, name: str, quaternion: bool, lengths: dict[str, int], what: str) -> Any:
    """Return a value as an array with an axis of lanes, if it has one; else the value."""
    if quaternion and isinstance(value, list) and value and all(isinstance(x, Rotation) for x in value):
        lengths[what] = len(value)
        return value
    if isinstance(value, set | frozenset | Iterator):
        raise SimulationError(f"Expected a list or an array for the {what}, got {value!r}. Write list(...).")
    entries = several(value)
    if entries is None:
        return float(value) if isinstance(value, np.ndarray) else value
    try:
        if np.iscomplexobj(entries):
            raise TypeError
        array = np.array(entries if quaternion else numbers_in(model, entries, name, what), dtype=float)
    except (TypeError, ValueError):
        cure = "Give one number for each lane."
        if quaternion:
            cure = "Give four components of a quaternion for each lane, or a list of Rotations only."
        raise SimulationError(f"Expected an array of numbers for the {what}, got {value!r}. {cure}") from None
    if quaternion and array.shape == (4,):
        return value
    if array.ndim != 1 + quaternion or (quaternion and array.shape[1] != 4):
        shape, cure = "(lanes,)", "For a grid of several parameters use fb.sweep."
        if quaternion:
            shape, cure = "(lanes, 4)", "Give four components of a quaternion for each lane, or Rotations."
        raise SimulationError(
            f"Expected an array of shape {shape} for the {what}, got shape {array.shape}. {cure}"
        )
    if not np.isfinite(array).all():
        lane = int(np.flatnonzero(~np.isfinite(array.reshape(len(array), -1)).all(axis=1))[0])
        raise SimulationError(
            f"Expected finite numbers for the {what}, got {array[lane]} in lane {lane}. Leave that lane out, of every "
            "array."
        )
    lengths[what] = len(array)
    return array
