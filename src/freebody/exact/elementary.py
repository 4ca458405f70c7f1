"""Elementary functions of numbers, of arrays, and of SymPy expressions.

A closed form written with them is at once a number and a formula, so that it can be compared with an answer in symbols
as well as with a simulation.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np


def symbolic(*x: Any) -> bool:
    """Whether one of the arguments is a SymPy expression."""
    return any(hasattr(value, "free_symbols") for value in x)


def _function(name: str) -> Callable[..., Any]:
    written = {"arctan2": "atan2", "arccos": "acos", "arcsin": "asin", "arctan": "atan"}.get(name, name)
    of_numbers = getattr(np, name)

    def function(*x: Any) -> Any:
        if symbolic(*x):
            import sympy

            return getattr(sympy, written)(*x)
        return of_numbers(*x)

    function.__name__ = name
    return function


sin, cos, tan = _function("sin"), _function("cos"), _function("tan")
arcsin, arccos, arctan, arctan2 = (_function(name) for name in ("arcsin", "arccos", "arctan", "arctan2"))
sqrt, log = _function("sqrt"), _function("log")
