"""Substitution into canonical polynomials: numbers, arrays, series or other polynomials in place of the atoms."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import Any

from .algebra import Field, Floats, Scalar, divide
from .arrays import Arrays
from .arrays import arrays as arrays
from .functions import UNKNOWN
from .polynomial import Polynomial, Ring


class Substitution:
    """Map from the elements of one ring into a field, given by the values of the atoms.

    The values of derived generators (sines, inverses, roots, functions) follow from their arguments and are computed
    once each.

    Parameters
    ----------
    ring : Ring
    field : Field
        Field of the results; the ring itself for a substitution of polynomials.
    values : mapping
        SymPy atom -> scalar of the field. In the ring itself, atoms without a value stay unchanged.
    generators : mapping, optional
        Index of a derived generator -> scalar, to set its value directly, such as cos(theta) = 1/2.

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
        values: Mapping[Any, Scalar],
        generators: Mapping[int, Scalar] | None = None,
    ) -> None:
        self.ring = ring
        self.field = field
        self.values = values
        self._results: dict[int, Scalar] = dict(generators or {})
        self._inexact = isinstance(field, Arrays | Floats)

    def __call__(self, x: Scalar) -> Scalar:
        """Value of an element or a number."""
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
        """Value of a generator."""
        if index not in self._results:
            self._results[index] = self._make(index)
        return self._results[index]

    def _make(self, index: int) -> Scalar:
        g = self.ring.generators[index]
        if not g.arguments:
            if g.atom in self.values:
                return self.values[g.atom]
            if g.kind == "constant":
                return self.field.constant(str(g.atom))
            if self.field is self.ring and not (g.root and self._touches(g)):
                return self.ring.variable(index)
            if g.root:
                return self._root(g)
            raise KeyError(g.atom)
        if self.field is self.ring and not self._touches(g):
            return self.ring.variable(index)
        arguments = [self(argument) for argument in g.arguments]
        if g.kind == "inverse":
            return 1 / arguments[0] if self._inexact else divide(1, arguments[0])
        return self.field.apply(g.name or g.kind, *arguments)

    def _root(self, g: Any) -> Scalar:
        """Value of the root of a function with the values of the atoms."""

        def of(x: Scalar) -> Callable[[Scalar], Scalar]:
            return lambda z: Substitution(self.ring, self.field, {**self.values, UNKNOWN: z})(x)

        root = g.root
        ends = self(root.ends[0]), self(root.ends[1])
        return self.field.root(of(root.function), of(root.slope), ends, g.atom.name, root.certain)

    def _touches(self, g: Any) -> bool:
        """True if the substitution changes a derived generator."""
        if any(atom.atom in self.values for atom in self.ring.of_mask(g.depends)):
            return True
        return any(
            inner.index in self._results or self._touches(inner)
            for argument in g.arguments
            for inner in self.ring.used(argument)
            if inner.arguments
        )
