"""The base class of the printers of text, LaTeX, MathML and SymPy, which walks the tree of `arrange`.

A printer defines how a number, a power, a product, a fraction, a sum and a function look. The base class walks the tree
and caches printed factors.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

from ...scalar.algebra import Scalar
from ...scalar.half_angles import half_angles
from ...scalar.polynomial import Ring
from .arrange import LONG, Lumps, arrange
from .terms import Applied, Sum, Term, without_minus


class Printer(ABC):
    """Printer of elements of one ring in one kind of output."""

    bars = True  # fractions are drawn with a bar
    ordered = True  # sums keep the order of their terms

    def __init__(self, ring: Ring, lumps: Lumps | None = None, long: Lumps | None = None):
        self.ring = ring
        self.lumps = lumps
        self.long = long
        for names in (lumps, long):
            if names is not None and names.ring is None:
                names.ring = ring
        self.memo: dict[Any, Any] = {}

    def show(self, x: Scalar) -> Any:
        """Return an element or a number; with sines in a denominator, in the form common to all equal elements."""
        form = half_angles(x)
        if form is None or self.long is not None and form.longest > LONG:
            return self.whole(arrange(x, self.ring, self.lumps, self.long))
        printer = type(self)(form.ring, self.lumps, self.long)
        return printer.whole(arrange(form.whole, form.ring, self.lumps, self.long))

    def whole(self, s: Sum) -> Any:
        """Return a sum that is a side of an equation or an answer."""
        return self.sum(without_minus(s) if self.ordered else s)

    def sum(self, s: Sum) -> Any:
        """Return the terms of a sum, joined."""
        if not s.terms:
            return self.number(0)
        if len(s.terms) == 1:
            term = s.terms[0]
            if term.coefficient == 1 and len(term.factors) == 1:
                node, e = term.factors[0]
                if e == 1 and isinstance(node, Sum):
                    return self.sum(node)
        return self.added([(t.coefficient < 0, self.term(t)) for t in s.terms])

    def term(self, t: Term) -> Any:
        """Return a term without its sign."""
        c = abs(t.coefficient)
        p, q = c.numerator, c.denominator
        over, under = [], []
        for node, e in self._with_tangents(t.factors):
            if e > 0 and isinstance(node, int) and self.ring.generators[node].kind == "inverse":
                under.append((self._below(self.ring.generators[node]), e))
            elif e > 0 or self._is_exponential(node):
                over.append((node, e))
            else:
                under.append((node, -e))
        if self.bars and under:
            return self.product(p, self._factors(over, p == 1), q, self._factors(under, q == 1))
        return self.product(p, self._factors(over, False), q, self._factors(under, False))

    def _below(self, g: Any) -> Any:
        """Return the argument of an inverse: a name or a sum."""
        return self.long and self.long.of_argument(g) or arrange(g.arguments[0], self.ring)

    def _factors(self, factors: list[tuple[Any, int]], alone: bool) -> list[Any]:
        if alone and len(factors) == 1 and factors[0][1] == 1 and isinstance(factors[0][0], Sum):
            return [self.sum(factors[0][0])]  # above or below a bar a sum needs no bracket
        return [self.factor(node, e) for node, e in factors]

    def _with_tangents(self, factors: list[tuple[Any, int]]) -> list[tuple[Any, int]]:
        """Return the factors with tan(x) in place of sin(x)/cos(x)."""
        generators = self.ring.generators
        powers = {i: e for i, e in factors if isinstance(i, int) and e < 0 and generators[i].kind == "cos"}
        if not powers:
            return factors
        result = []
        used = set()
        for i, e in factors:
            if isinstance(i, int) and generators[i].kind == "sin" and powers.get(generators[i].partner) == -e:
                result.append((("tan", ((generators[i].partner, 1),)), e))
                used.add(generators[i].partner)
            else:
                result.append((i, e))
        return [(i, e) for i, e in result if not (isinstance(i, int) and i in used)]

    def _is_exponential(self, node: Any) -> bool:
        return isinstance(node, int) and self.ring.generators[node].name == "exp"

    def factor(self, node: Any, e: int) -> Any:
        """Return a node to a positive power."""
        if isinstance(node, Sum):
            return self.power(self.bracketed(self.sum(node)), e)
        if isinstance(node, Applied):
            arguments = [self.sum(argument) for argument in node.arguments]
            if node.function == "sqrt":
                return self.power(self.root(arguments[0]), e)
            return self.function(node.function, arguments, e)
        key = (node, e)
        if key not in self.memo:
            self.memo[key] = self._factor(node, e)
        return self.memo[key]

    def _factor(self, node: Any, e: int) -> Any:
        if isinstance(node, str):
            return self.power(self.name(node), e)
        if isinstance(node, tuple):
            function, angles = node
            total: Any = 0
            for index, n in angles:
                total = self.ring.generators[index].arguments[0] * n + total
            return self.function(function, [self.argument(total)], e)
        g = self.ring.generators[node]
        if g.kind == "inverse":  # only inside arguments of functions
            return self.product(1, [], 1, self._factors([(self._below(g), e)], self.bars))
        if g.name == "exp":
            return self.function("exp", [self.argument(g.arguments[0] * e)], 1)
        if g.kind == "sqrt":
            name = self.long and self.long.of_argument(g)
            return self.power(self.root(self.name(name) if name else self.argument(g.arguments[0])), e)
        if g.arguments:
            return self.function(g.name or g.kind, [self.argument(a) for a in g.arguments], e)
        return self.generator(g.atom, e)

    def argument(self, x: Scalar) -> Any:
        """Return an argument of a function, without lumps."""
        return self.sum(arrange(x, self.ring))

    def generator(self, atom: Any, e: int) -> Any:
        """Return a symbol, or a function of time with its derivatives, to a power."""
        name, dots = name_of(atom)
        return self.power(self.name(name, dots), e)

    def numbered(self, n: int, factors: list[Any]) -> list[Any]:
        """Return factors with a whole number in front, unless it is 1 and there are factors."""
        return [self.number(n), *factors] if n != 1 or not factors else factors

    @abstractmethod
    def number(self, n: int) -> Any:
        """A whole number."""

    @abstractmethod
    def name(self, name: str, dots: int = 0) -> Any:
        """A name, differentiated ``dots`` times."""

    @abstractmethod
    def power(self, base: Any, e: int) -> Any:
        """A printed factor to a positive whole power."""

    @abstractmethod
    def bracketed(self, s: Any) -> Any:
        """A sum as a factor."""

    @abstractmethod
    def product(self, p: int, over: list[Any], q: int, under: list[Any]) -> Any:
        """p · over / (q · under), of printed factors."""

    @abstractmethod
    def added(self, terms: list[tuple[bool, Any]]) -> Any:
        """(is negative, printed term) joined by their signs."""

    @abstractmethod
    def function(self, name: str, arguments: list[Any], e: int) -> Any:
        """A function to a positive whole power."""

    @abstractmethod
    def root(self, argument: Any) -> Any:
        """A square root."""


def signed_sum(terms: list[tuple[bool, str]]) -> str:
    """Return (is negative, printed term) joined by " + " and " - "."""
    text = "".join((" - " if negative else " + ") + term for negative, term in terms)
    return "-" + text[3:] if terms[0][0] else text[3:]


def name_of(atom: Any) -> tuple[str, int]:
    """Return the name of a SymPy atom and its number of differentiations."""
    if atom.is_Derivative:
        return atom.expr.func.__name__, sum(n for _, n in atom.variable_count)
    if atom.is_Function:
        return atom.func.__name__, 0
    return str(atom), 0
