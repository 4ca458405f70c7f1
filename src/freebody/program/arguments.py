"""What the functions of a program are given: checked against the model, one state or a batch."""

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
NUMBERS = frozenset((float, int, np.float64))
"""Types of a parameter's value that is a number and nothing to be read."""


def checked(
    model: Model, given: Mapping[str, ArrayLike], t: ArrayLike, parameters: Mapping[str, Any]
) -> tuple[dict[str, Array], Array, int | None]:
    """The arrays, the time, and the number of states; None for one state without a leading axis."""
    sizes = {"q": model.n_q, "u": model.n_u, "udot": model.n_u, "forces": model.n_u}
    arrays = {name: array(value, name) for name, value in given.items()}
    time = array(t, "t")
    count: int | None = None
    source = ""

    def leading(n: int, what: str) -> None:
        nonlocal count, source
        if count is not None and count != n:
            raise ModelError(f"Expected {what} for {count} states as in {source}, got {n}.")
        count, source = n, what

    for name, x in arrays.items():
        if x.ndim not in (1, 2) or x.shape[-1] != sizes[name]:
            names = model.coordinate_names if name == "q" else model.speed_names
            raise ModelError(
                f"Expected {name} of shape ({sizes[name]},) or (N, {sizes[name]}), one number for each of "
                f"{', '.join(names) or 'no coordinates'}; got shape {x.shape}."
            )
        if x.ndim == 2:
            leading(len(x), name)
    if time.ndim > 1:
        raise ModelError(f"Expected t to be a number or of shape (N,), got shape {time.shape}.")
    if time.ndim == 1:
        leading(len(time), "t")
    for name, value in parameters.items():
        if isinstance(value, np.ndarray):
            leading(len(value), f"parameter '{name}'")
    return arrays, time, count


def parameters_given(
    model: Model, values: Mapping[Any, Any] | None, named: Mapping[str, Any]
) -> dict[str, Any]:
    """Parameters by name; arrays are for a batch."""
    if values is None and not named:
        return {}
    if not isinstance(values, Mapping | None):
        raise ModelError(f"Expected values of parameters by name, such as {{'m': 2}}, got {values!r}.")
    known = model.defaults
    result: dict[str, Any] = {}
    for key, value in (*(values or {}).items(), *named.items()):
        name = key if isinstance(key, str) else model.parameter_names.get(key, key)
        if name not in known:
            raise ModelError(f"Unknown parameter '{key}'; {nearest(str(key), known)}")
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
    """An expression of parameters that was assumed positive, and its value at numbers or arrays of their names."""

    expression: Any
    names: tuple[str, ...]
    value: Callable[..., Any]


def assumptions(model: Model) -> tuple[Assumption, ...]:
    """What was assumed of the parameters; of positive multiples of one expression it stands for all."""
    bases = dict.fromkeys(
        e.as_coeff_Mul()[1] if e.as_coeff_Mul()[0].is_positive else e for e in model.assumed if e.free_symbols
    )
    result = []
    for base in bases:
        symbols = sorted(base.free_symbols, key=str)
        made = (lambda x: x) if base.is_Symbol else sympy.lambdify(symbols, base, "numpy")
        result.append(Assumption(base, tuple(symbol.name for symbol in symbols), made))
    return tuple(result)


def check_parameters(
    model: Model, given: Sequence[Assumption], columns: Mapping[str, Array], numbers: Mapping[str, float]
) -> None:
    """Refuse values, or values of a batch, that contradict what was assumed of them.

    In a batch NaN is an answer like others.

    Raises
    ------
    ModelError
        What is not positive, with the values in it and the first state.
    """
    with np.errstate(all="ignore"):
        wrong = [one for one in given if not _holds(one, columns, numbers)]
    for one in wrong:
        varied = [name for name in one.names if name in columns]
        k = 0
        if varied:
            with np.errstate(all="ignore"):
                k = int(np.argmax(_value(one, columns, numbers) <= 0))
        row = {**numbers, **{name: float(columns[name][k]) for name in varied}}
        check_assumption(model, one.expression, row, f"State {k}: " if varied else "")


def _holds(one: Assumption, columns: Mapping[str, Array], numbers: Mapping[str, float]) -> bool:
    value = _value(one, columns, numbers)
    return not (value <= 0).any() if isinstance(value, np.ndarray) else bool(value > 0)


def _value(one: Assumption, columns: Mapping[str, Array], numbers: Mapping[str, float]) -> Any:
    return one.value(*[columns[name] if name in columns else np.float64(numbers[name]) for name in one.names])


def signals_at(model: Model, t: ArrayLike) -> dict[str, Any]:
    """The constants that signals have at a time, or at the times of a batch."""
    result: dict[str, Any] = {}
    for placed in model.signals:
        result.update(placed.settings(float(array(t, "t"))) if np.ndim(t) == 0 else placed.columns(t))
    return result


def place_of(model: Model, point: Any) -> Any:
    """A point of a body of the model; a body, or its name, stands for its origin."""
    if isinstance(point, str):
        if point not in model.bodies:
            raise ModelError(f"Unknown body '{point}'; {nearest(point, model.bodies)}")
        return _Origin(_Named(point))
    place = getattr(point, "origin", point)
    body = getattr(place, "body", None)
    if body is None or not (body.is_ground or body.name in model.bodies):
        raise ModelError(
            f"Expected a point of a body, a body or its name, got {point!r}. "
            f"Bodies of '{model.name}': {', '.join(model.bodies)}."
        )
    return place


def is_plain(x: Any, shape: tuple[int, ...]) -> bool:
    """Whether x is a contiguous array of doubles of this shape."""
    return type(x) is np.ndarray and x.shape == shape and x.dtype == np.float64 and x.flags.c_contiguous


def array(value: ArrayLike, name: str) -> Array:
    """Doubles of any shape."""
    try:
        given = np.asarray(value)
        kind = given.dtype.kind
        # numpy would read None as nan, text as a number, and cut off what is imaginary
        if kind == "c" or (kind not in "biuf" and any(x is None or isinstance(x, str) for x in given.flat)):
            raise TypeError
        return given.astype(float, copy=False)
    except (TypeError, ValueError):
        raise ModelError(f"Expected real numbers for {name}, got {value!r}.") from None


@dataclass(frozen=True)
class _Named:
    """A body known by its name only."""

    name: str
    is_ground: bool = False


@dataclass(frozen=True)
class _Origin:
    """The origin of a body known by its name only."""

    body: _Named
    components: tuple[int, int, int] = (0, 0, 0)
