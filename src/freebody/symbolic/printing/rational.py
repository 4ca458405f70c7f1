"""Rational functions of a ring's generators, and polynomials in s over them.

Partial fractions need division, and the ring of canonical polynomials would introduce a generator for each divisor.
Here sines, roots and the like are independent symbols: an identity of rational functions holds whatever relations they
have. Results are converted back to the ring, where they are canonical.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import sympy

from ...scalar.algebra import Scalar
from ...scalar.element import Polynomial
from ...scalar.polynomial import Ring
from .display import displayed

S = sympy.Symbol("s")


class Rationals:
    """The field of rational functions of the generators of a ring that occur in some elements."""

    def __init__(self, ring: Ring, elements: Iterable[Scalar]) -> None:
        self.ring = ring
        indices: set[int] = set()
        todo = [x for x in elements if type(x) is Polynomial]
        while todo:
            for g in ring.used(todo.pop()):
                if g.index in indices or g.atom is S:
                    continue
                indices.add(g.index)
                if g.kind == "inverse":
                    todo += [x for x in g.arguments if type(x) is Polynomial]
        plain = [i for i in sorted(indices) if ring.generators[i].kind != "inverse"]
        symbols = [sympy.Symbol(f"g{i}") for i in plain]
        self.domain = sympy.QQ.frac_field(*symbols) if symbols else sympy.QQ
        self._values: dict[int, Any] = {
            i: self.domain.from_sympy(x) for i, x in zip(plain, symbols, strict=True)
        }
        self._atoms = {x: ring.to_sympy(ring.variable(i)) for i, x in zip(plain, symbols, strict=True)}
        for i in sorted(indices - set(plain)):  # older generators first: the argument of an inverse is older
            self._values[i] = 1 / self(ring.generators[i].arguments[0])

    def __call__(self, x: Scalar) -> Any:
        """Return an element that does not depend on s as a rational function."""
        (value,) = self.coefficients(x) or (self.domain.zero,)
        return value

    def coefficients(self, x: Scalar) -> list[Any]:
        """Return the coefficients of an element by rising powers of s."""
        if type(x) is not Polynomial:
            return [self.domain.from_sympy(sympy.Rational(x.numerator, x.denominator))] if x != 0 else []
        by_power: dict[int, Any] = {}
        for monomial, c in self.ring.terms(x.num):
            value = self.domain.from_sympy(sympy.Rational(c, x.den))
            power = 0
            for i, e in monomial:
                if self.ring.generators[i].atom is S:
                    power = e
                else:
                    value = value * self._values[i] ** e
            by_power[power] = by_power[power] + value if power in by_power else value
        return [by_power.get(k, self.domain.zero) for k in range(max(by_power, default=-1) + 1)]

    def poly(self, x: Scalar) -> Any:
        """Return an element as a polynomial in s."""
        return self.of(self.coefficients(x))

    def of(self, coefficients: Sequence[Any]) -> Any:
        """Return the polynomial with these coefficients, by rising powers of s."""
        return sympy.Poly.from_list(list(reversed(coefficients)) or [0], S, domain=self.domain)

    def sympy(self, value: Any) -> Any:
        """Return a rational function as a SymPy expression, canonical and grouped as it is printed."""
        if isinstance(value, sympy.Basic):
            above, below = sympy.fraction(sympy.together(value))
        else:
            above, below = sympy.fraction(self.domain.to_sympy(value))
        ring = self.ring
        above, below = (ring.coerce(ring.from_sympy(x.xreplace(self._atoms))) for x in (above, below))
        return sympy.factor_terms(displayed(above, ring)) / sympy.factor_terms(displayed(below, ring))

    def listed(self, poly: Any) -> list[Any]:
        """Return the coefficients of a polynomial in s by rising powers, as SymPy expressions."""
        return [self.sympy(c) if c != 0 else sympy.Integer(0) for c in reversed(poly.rep.to_list())]
