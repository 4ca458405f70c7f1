"""The field of NumPy arrays: an algorithm runs once for many states, entry by entry."""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np

from .algebra import FUNCTIONS, Field, Scalar

_NAMES = {
    "asin": "arcsin", "acos": "arccos", "atan": "arctan", "atan2": "arctan2", "pow": "power",
    "min": "minimum", "max": "maximum",
}  # fmt: skip


class Column(np.ndarray):
    """An array that treats a Fraction as a number; NumPy alone would make an array of Python objects."""

    __slots__ = ()


def _plain(name: str) -> Callable[[Any, Any], Any]:
    of_array = getattr(np.ndarray, name)

    def operation(self: Any, other: Any) -> Any:
        return of_array(self, float(other) if type(other) is Fraction else other)

    return operation


for _name in ("add", "radd", "sub", "rsub", "mul", "rmul", "truediv", "rtruediv"):
    setattr(Column, f"__{_name}__", _plain(f"__{_name}__"))


def column(values: Any) -> Scalar:
    """The values as a scalar of the field :data:`arrays`."""
    return np.asarray(values, dtype=float).view(Column)


def function_of_arrays(name: str) -> Callable[..., Any]:
    """NumPy's function for a name in :data:`FUNCTIONS`."""
    function: Callable[..., Any] = getattr(np, _NAMES.get(name, name))
    return function


class Arrays(Field):
    """The field of arrays of one shape; plain numbers are constants."""

    _functions = {name: function_of_arrays(name) for name in FUNCTIONS}

    def constant(self, value: int | Fraction | float | str) -> float:
        """The number as a float, the same for every entry."""
        if isinstance(value, str):
            return {"pi": math.pi, "E": math.e}[value]
        return float(value)

    def apply(self, function: str, *arguments: Scalar) -> Scalar:
        """``function`` entry by entry; the exact 0 where sin, tan or sqrt of the int 0 is asked for."""
        if function in ("sin", "tan", "sqrt") and type(arguments[0]) is int and arguments[0] == 0:
            return 0
        numbers = [float(x) if isinstance(x, int | Fraction) else x for x in arguments]
        return self._functions[function](*numbers)


arrays = Arrays()
