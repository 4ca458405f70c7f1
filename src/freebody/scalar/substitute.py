"""Canonical polynomials at other scalars: numbers, arrays, series, or other polynomials in place of the atoms."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import Any

from .algebra import Field, Floats, divide
from .polynomial import Polynomial, Ring


class Substitution:
    """Maps elements of one ring into a field, atom by atom.

    What derived generators (sines, inverses, roots, functions) become follows from their arguments, each once.

    Parameters
    ----------
    ring : Ring
    field : Field
        Where the results live; the ring itself for a substitution of polynomials.
    values : mapping
        SymPy atom -> scalar of the field. In the ring itself, atoms without one stay as they are.
    generators : mapping, optional
        Index of a generator -> scalar, where a derived generator is given directly: cos(theta) = 1/2.

    Examples
    --------
    >>> import sympy
    >>> ring = Ring()
    >>> q, m = sympy.Function("q")(sympy.Symbol("t")), sympy.Symbol("m")
    >>> x = ring.from_sympy(m * sympy.sin(q) + m)
    >>> Substitution(ring, ring, {q: 0})(x)
    m
    """

    def __init__(
        self,
        ring: Ring,
        field: Field,
        values: Mapping[Any, Any],
        generators: Mapping[int, Any] | None = None,
    ) -> None:
        self.ring = ring
        self.field = field
        self.values = values
        self._made: dict[int, Any] = dict(generators or {})
        self._inexact = isinstance(field, Arrays | Floats)

    def __call__(self, x: Any) -> Any:
        """The value of an element, or of a number."""
        if type(x) is not Polynomial:
            return float(x) if self._inexact else x
        total: Any = 0
        for monomial, c in x.terms():
            term: Any = float(Fraction(c, x.den)) if self._inexact else c
            for index, e in monomial:
                term = self._power(index, e) * term
            total = total + term
        return total if x.den == 1 or self._inexact else divide(total, x.den)

    def _power(self, index: int, e: int) -> Any:
        base = self.generator(index)
        return base if e == 1 else base**e

    def generator(self, index: int) -> Any:
        """The value of a generator."""
        if index not in self._made:
            self._made[index] = self._make(index)
        return self._made[index]

    def _make(self, index: int) -> Any:
        g = self.ring.generators[index]
        if not g.arguments:
            if g.atom in self.values:
                return self.values[g.atom]
            if g.kind == "constant":
                return self.field.constant(str(g.atom))
            if self.field is self.ring:
                return self.ring.variable(index)
            raise KeyError(g.atom)
        if self.field is self.ring and not self._touches(g):
            return self.ring.variable(index)
        arguments = [self(argument) for argument in g.arguments]
        if g.kind == "inverse":
            return 1 / arguments[0] if self._inexact else divide(1, arguments[0])
        return self.field.apply(g.name or g.kind, *arguments)

    def _touches(self, g: Any) -> bool:
        """Whether anything that is replaced occurs in a derived generator."""
        if any(one.atom in self.values for one in self.ring.of_mask(g.depends)):
            return True
        return any(
            i in self._made or self._touches(self.ring.generators[i])
            for argument in g.arguments
            for i in (one.index for one in self.ring.used(argument))
            if self.ring.generators[i].arguments
        )


class Arrays(Field):
    """The field of NumPy arrays: one evaluation at many points."""

    def constant(self, value: Any) -> Any:
        import math

        return {"pi": math.pi, "E": math.e}[value] if isinstance(value, str) else value

    def apply(self, function: str, *arguments: Any) -> Any:
        import numpy as np

        names: dict[str, Callable[..., Any]] = {
            "asin": np.arcsin, "acos": np.arccos, "atan": np.arctan, "atan2": np.arctan2, "abs": np.abs,
            "pow": lambda x, y: np.asarray(x, dtype=float) ** y, "min": np.minimum, "max": np.maximum,
        }  # fmt: skip
        return (names.get(function) or getattr(np, function))(
            *(np.asarray(a, dtype=float) for a in arguments)
        )


arrays = Arrays()
