"""Elementary functions of numbers, of arrays, and of SymPy expressions.

A closed form written with them gives numbers or formulas, so that it can be compared with a simulation and with a
symbolic result.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np


def symbolic(*x: Any) -> bool:
    """True if one of the arguments is a SymPy expression."""
    return any(hasattr(value, "free_symbols") for value in x)


def _function(name: str) -> Callable[..., Any]:
    """NumPy's function of this name, or SymPy's for symbolic arguments."""
    sympy_name = {"arctan2": "atan2", "arccos": "acos", "arcsin": "asin", "arctan": "atan"}.get(name, name)
    numeric = getattr(np, name)

    def function(*x: Any) -> Any:
        if symbolic(*x):
            import sympy

            return getattr(sympy, sympy_name)(*x)
        return numeric(*x)

    function.__name__ = name
    return function


sin, cos, tan = _function("sin"), _function("cos"), _function("tan")
arcsin, arccos, arctan, arctan2 = (_function(name) for name in ("arcsin", "arccos", "arctan", "arctan2"))
sqrt, log, exp = _function("sqrt"), _function("log"), _function("exp")
cosh, tanh = _function("cosh"), _function("tanh")
