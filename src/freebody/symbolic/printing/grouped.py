"""SymPy expressions, grouped as the text is printed."""

from __future__ import annotations

from typing import Any

import sympy

from ...scalar.to_sympy import atom_of
from .printer import Printer


class Grouped(Printer):
    """Printer of SymPy expressions that keep their brackets; SymPy would multiply numbers into sums."""

    ordered = False

    def number(self, n: int) -> Any:
        """A whole number."""
        return sympy.Integer(n)

    def name(self, name: str, dots: int = 0) -> Any:
        """A name, differentiated ``dots`` times."""
        return sympy.Symbol(name)

    def generator(self, atom: Any, e: int) -> Any:
        """A SymPy atom to a power."""
        return self.power(atom, e)

    def power(self, base: Any, e: int) -> Any:
        """A factor to a positive whole power."""
        return base if e == 1 else sympy.Pow(base, e)

    def bracketed(self, s: Any) -> Any:
        """A sum as a factor."""
        return s

    def product(self, p: int, over: list[Any], q: int, under: list[Any]) -> Any:
        """p · over / (q · under)."""
        factors = over + [sympy.Pow(f, -1) for f in under]
        number = sympy.Rational(p, q)
        if len(factors) == 1 and factors[0].is_Add and number != 1:
            return sympy.Mul(number, factors[0], evaluate=False)
        return sympy.Mul(number, *factors)

    def added(self, terms: list[tuple[bool, Any]]) -> Any:
        """Terms joined by their signs."""
        return sympy.Add(*(_negative(t) if negative else t for negative, t in terms))

    def function(self, name: str, arguments: list[Any], e: int) -> Any:
        """A function to a positive whole power."""
        if name == "pow":
            return self.power(sympy.Pow(*arguments), e)
        special = {"abs": sympy.Abs, "min": sympy.Min, "max": sympy.Max}
        return self.power((special.get(name) or getattr(sympy, name))(*arguments), e)

    def root(self, argument: Any) -> Any:
        """A square root."""
        return sympy.sqrt(argument)

    def _factor(self, node: Any, e: int) -> Any:
        if isinstance(node, int) and e > 0:
            return self.power(atom_of(self.ring, self.ring.generators[node]), e)
        return super()._factor(node, e)


def _negative(term: Any) -> Any:
    if term.is_Add:
        return sympy.Mul(-1, term, evaluate=False)
    if term.is_Mul and len(term.args) == 2 and term.args[0].is_Number and term.args[1].is_Add:
        return sympy.Mul(-term.args[0], term.args[1], evaluate=False)
    return -term
