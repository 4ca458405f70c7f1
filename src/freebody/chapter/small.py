"""The small quantity of an approximation, and the order of a value in it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import sympy

DIGITS = 60
"""Digits of the numbers with which the errors of approximations are measured."""


def put(expression: Any, pairs: Sequence[tuple[Any, Any]]) -> Any:
    """Substitute pairs one after the other: accelerations before speeds before coordinates."""
    result = sympy.sympify(expression)
    for old, new in pairs:
        result = result.xreplace({old: sympy.sympify(new)})
    return result


@dataclass(frozen=True)
class Small:
    """The small quantity of an approximation, its ordinary size, and substitutions that make a value a number.

    ``pairs`` are substituted one after the other; only the small quantity remains as a symbol.
    """

    symbol: Any
    size: Any
    pairs: Sequence[tuple[Any, Any]]
    _values: dict[Any, Any] = field(default_factory=dict, repr=False, compare=False)

    def number(self, value: Any, size: Any) -> Any:
        """Return the magnitude of a value at a size of the small quantity."""
        values = self._numbers(size)
        return sympy.sqrt(sum(abs(sympy.N(x.xreplace(values), DIGITS)) ** 2 for x in components(value)))

    def _numbers(self, size: Any) -> dict[Any, Any]:
        """Return every symbol as a number: the last pair first, since the earlier ones depend on it."""
        if size not in self._values:
            values = {self.symbol: sympy.N(size, DIGITS)}
            for old, new in reversed(self.pairs):
                values[old] = sympy.N(sympy.sympify(new).xreplace(values), DIGITS)
            self._values[size] = values
        return self._values[size]

    def order(self, value: Any) -> float:
        """Return the order of a value in the small quantity: the logarithmic slope between two small sizes."""
        a, b = (self.number(value, self.size / 10**k) for k in (4, 5))
        return float(sympy.log(a / b, 10)) if a and b else float("inf")


def components(value: Any) -> tuple[Any, ...]:
    """Return the components of a vector, or a tuple of the single value."""
    return tuple(value) if isinstance(value, sympy.MatrixBase) else (sympy.sympify(value),)
