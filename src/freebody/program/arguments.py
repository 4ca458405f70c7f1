"""Arguments of a program's functions, checked against the model: one state or a batch."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy
from numpy.typing import ArrayLike, NDArray

from ..errors import ModelError, nearest
from ..model import Model
from ..model.values import check_assumption

Array = NDArray[np.float64]
FORCES = ("tau", "torque", "torques", "force", "effort")
"""Names of generalized forces that are none of a program's arguments."""
NUMBERS = frozenset((float, int, np.float64))
"""Types of a parameter's value that need no reading: they are numbers already."""


CALLS = {"forced_dynamics": "forward_dynamics", "reactions_at": "reactions"}
"""Methods of products that have another name."""


def call_of(key: Any, arguments: Mapping[str, Any]) -> str:
    """Return a sentence with the arguments of the call that evaluates a product, or no text for one without a name."""
    if not isinstance(key, str) or not key.isidentifier() or "_by_" in key:
        return ""
    names = [*(name for name in arguments if name != "forces"), "t"]
    options = ", forces=" if key in ("forward_dynamics", "forced_dynamics") else ""
    return f" The call is {CALLS.get(key, key)}({', '.join(names)}{options}), with parameters by name."


def checked(
    model: Model,
    arguments: Mapping[str, ArrayLike],
    t: ArrayLike,
    parameters: Mapping[str, Any],
    key: Any = None,
) -> tuple[dict[str, Array], Array, int | None]:
    """Return arrays, time and the number of states; None for one state without a leading axis.

    ``key`` is the product for which they are.
    """
    sizes = {"q": model.n_q, "u": model.n_u, "udot": model.n_u, "forces": model.n_u}
    call = call_of(key, arguments)
    arrays = {name: _numbers(model, value, name, call) for name, value in arguments.items()}
    time = array(t, "t", call)
    count: int | None = None
    source = ""

    def leading(n: int, argument: str) -> None:
        nonlocal count, source
        if count is not None and count != n:
            raise ModelError(f"Expected {argument} for {count} states as in {source}, got {n}.{call}")
        count, source = n, argument

    for name, x in arrays.items():
        if x.ndim not in (1, 2) or x.shape[-1] != sizes[name]:
            names = model.coordinate_names if name == "q" else model.speed_names
            raise ModelError(
                f"Expected {name} of shape ({sizes[name]},) or (N, {sizes[name]}), one number for each of "
                f"{', '.join(names) or 'no coordinates'}; got shape {x.shape}.{call}"
            )
        if x.ndim == 2:
            leading(len(x), name)
    if time.ndim > 1:
        raise ModelError(f"Expected t to be a number or of shape (N,), got shape {time.shape}.{call}")
    if time.ndim == 1:
        leading(len(time), "t")
    for name, value in parameters.items():
        if isinstance(value, np.ndarray):
            leading(len(value), f"parameter '{name}'")
    return arrays, time, count


def parameters_by_name(
    model: Model, values: Mapping[Any, Any] | None, named: Mapping[str, Any]
) -> dict[str, Any]:
    """Return the parameters of a call by name; arrays are for a batch."""
    if values is None and not named:
        return {}
    if not isinstance(values, Mapping | None):
        raise ModelError(f"Expected values of parameters by name, such as {{'m': 2}}, got {values!r}.")
    defaults = model.defaults
    result: dict[str, Any] = {}
    for key, value in (*(values or {}).items(), *named.items()):
        name = key if isinstance(key, str) else model.parameter_names.get(key, key)
        if name not in defaults:
            known = nearest(str(key), defaults) if defaults else f"'{model.name}' has none."
            cure = " Generalized forces of forward_dynamics are forces=." if str(key) in FORCES else ""
            raise ModelError(f"Unknown parameter '{key}'; {known}{cure}")
        if name in result:
            raise ModelError(f"Parameter '{name}' is given twice. Leave one out.")
        if isinstance(value, list | tuple) or isinstance(value, np.ndarray) and value.ndim > 0:
            value = array(value, f"parameter '{name}'")
            if value.ndim != 1:
                raise ModelError(
                    f"Expected parameter '{name}' to be a number or of shape (N,), got shape {value.shape}."
                )
        result[name] = value
    return result


@dataclass(frozen=True)
class Assumption:
    """An expression of parameters that the user assumed positive, and its value as a function of these parameters."""

    expression: sympy.Expr
    names: tuple[str, ...]
    value: Callable[..., Any]

    def values(self, columns: Mapping[str, Array], numbers: Mapping[str, float]) -> Any:
        """Value of the expression; an array if one of its parameters is a column of a batch."""
        return self.value(
            *[columns[name] if name in columns else np.float64(numbers[name]) for name in self.names]
        )

    def holds(self, columns: Mapping[str, Array], numbers: Mapping[str, float]) -> bool:
        """Return whether no value contradicts the assumption."""
        value = self.values(columns, numbers)
        return not (value <= 0).any() if isinstance(value, np.ndarray) else bool(value > 0)


def assumptions(model: Model) -> tuple[Assumption, ...]:
    """Assumptions about the parameters; positive multiples of one expression are listed once."""
    bases = dict.fromkeys(
        e.as_coeff_Mul()[1] if e.as_coeff_Mul()[0].is_positive else e for e in model.assumed if e.free_symbols
    )
    result = []
    for base in bases:
        symbols = sorted(base.free_symbols, key=str)
        value = (lambda x: x) if base.is_Symbol else sympy.lambdify(symbols, base, "numpy")
        result.append(Assumption(base, tuple(symbol.name for symbol in symbols), value))
    return tuple(result)


def check_parameters(
    model: Model,
    assumptions: Sequence[Assumption],
    columns: Mapping[str, Array],
    numbers: Mapping[str, float],
) -> None:
    """Refuse values, or columns of values of a batch, that contradict the assumptions.

    In a batch, NaN is accepted.

    Raises
    ------
    ModelError
        Names the expression that is not positive, its values and the first state of a batch that has them.
    """
    with np.errstate(all="ignore"):
        broken = [assumption for assumption in assumptions if not assumption.holds(columns, numbers)]
    for assumption in broken:
        varied = [name for name in assumption.names if name in columns]
        k = 0
        if varied:
            with np.errstate(all="ignore"):
                k = int(np.argmax(assumption.values(columns, numbers) <= 0))
        row = {**numbers, **{name: float(columns[name][k]) for name in varied}}
        check_assumption(model, assumption.expression, row, f"State {k}: " if varied else "")


def signals_at(model: Model, t: ArrayLike) -> dict[str, Any]:
    """Constants of the signals at a time, or at the times of a batch."""
    result: dict[str, Any] = {}
    for placed in model.signals:
        result.update(placed.settings(float(array(t, "t"))) if np.ndim(t) == 0 else placed.columns(t))
    return result


def place_of(model: Model, point: Any) -> Any:
    """Return a point of a body; a body, its name, or the name of a frame of a robot's file stands for its origin."""
    if isinstance(point, str):
        if point in model.bodies:
            return _Place(_Named(point))
        if point not in model.frames:
            kinds = "body or frame" if model.frames else "body"
            raise ModelError(f"Unknown {kinds} '{point}'; {nearest(point, [*model.bodies, *model.frames])}")
        carrier, components = model.frames[point]
        return _Place(_Named(carrier, carrier not in model.bodies), components)
    place = getattr(point, "origin", point)
    body = getattr(place, "body", None)
    if body is None or not (body.is_ground or body.name in model.bodies):
        raise ModelError(
            f"Expected a point of a body, a body or its name, got {point!r}. "
            f"Bodies of '{model.name}': {', '.join(model.bodies)}."
        )
    return place


def is_plain(x: Any, shape: tuple[int, ...]) -> bool:
    """Return whether x is a contiguous array of doubles of this shape."""
    return type(x) is np.ndarray and x.shape == shape and x.dtype == np.float64 and x.flags.c_contiguous


def of_list(x: Any) -> Any:
    """Return an array of doubles for a list of numbers within their range, and anything else as it is."""
    if type(x) is not list or not NUMBERS.issuperset(map(type, x)):
        return x
    try:
        return np.array(x, float)
    except OverflowError:
        return x  # refused by its name later


def _numbers(model: Model, value: Any, name: str, call: str) -> Array:
    """Return one of the arguments of a state as an array."""
    names = model.coordinate_names if name == "q" else model.speed_names
    order = f" They stand in the order {', '.join(names)}."
    if isinstance(value, Mapping):
        wrong = [str(key) for key in value if str(key) not in names]
        own = "coordinate_names" if name == "q" else "speed_names"
        cure = (
            f" '{wrong[0]}' is none of them; {nearest(wrong[0], names)}" if wrong
            else f" [given[name] for name in program.model.{own}] is such a list."
        )  # fmt: skip
        raise ModelError(f"Expected real numbers for {name}, got names.{order}{cure}{call}")
    return array(value, name, order + call)


def array(value: ArrayLike, name: str, cure: str = "") -> Array:
    """Return the value as an array of doubles of any shape; ``cure`` is added to an error."""
    try:
        result = np.asarray(value)
        kind = result.dtype.kind
        # NumPy would read None as nan and text as a number, and would drop imaginary parts
        if kind == "c" or (kind not in "biuf" and any(x is None or isinstance(x, str) for x in result.flat)):
            raise TypeError
        return result.astype(float, copy=False)
    except (TypeError, ValueError, OverflowError):
        raise ModelError(f"Expected real numbers for {name}, got {value!r}.{cure}") from None


@dataclass(frozen=True)
class _Named:
    """A body known by its name only."""

    name: str
    is_ground: bool = False


@dataclass(frozen=True)
class _Place:
    """A point of a body known by its name only."""

    body: _Named
    components: Any = (0, 0, 0)
