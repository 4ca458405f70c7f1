"""Arrange a canonical polynomial as a textbook prints it: a small tree of sums and products.

Terms are grouped by accelerations, then by products of speeds; the remaining terms come last. Each
group's coefficient takes its shortest form (`angle_sums`), common factors are taken out, and groups
with the same factor of parameters are joined:

    (M + m)*x'' + m*a*(theta''*cos(theta) - theta'^2*sin(theta)) + k*x

A `Sum` is a list of `Term`; a term has a rational coefficient and factors ``(node, exponent)``.
A node is a generator (its index), a sine or cosine of a sum of angles
(``("sin", ((index, multiple), ...))``), a named lump (str), or a `Sum`.

The file is longer than others: the rules of arrangement work on one tree and call each other.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction
from functools import partial
from math import gcd, inf
from typing import Any

from ...scalar.algebra import Scalar
from ...scalar.polynomial import Polynomial, Ring
from .angle_sums import shortest
from .terms import (
    ONE,
    Key,
    Part,
    Sum,
    Term,
    common_divisor,
    common_part,
    content_of,
    fold,
    made_positive,
    negative,
    without,
)

MOVING = {"reaction": 0, "acceleration": 1, "speed": 2}
FIXED = ("parameter", "constant", "load")


LONGEST = 10_000
"""Number of terms beyond which an element is not brought over a common denominator: nobody reads it."""
PRINTED = 4
"""Visits of a term until it is printed, for the budget: some 80 μs."""
LONG = 8
"""Number of terms beyond which the argument of a root or of an inverse gets a name, if names are used."""


@dataclass
class Lumps:
    """Names for the distinct coefficients of parameters; one table for many equations.

    Attributes
    ----------
    table : dict
        Name -> element of the ring, in the order of first use.
    ring : Ring, optional
        The ring of these elements; by default that of the first printer that uses them.
    """

    prefix: str = "c"
    ring: Ring | None = None
    table: dict[str, Polynomial] = field(default_factory=dict)
    _names: dict[Any, str] = field(default_factory=dict)

    def name(self, value: Polynomial) -> str:
        """Return the name of a coefficient, also of one in a ring made for a single fraction."""
        ring = self.ring or value.ring
        key = value if value.ring is ring else ring.coerce(ring.from_sympy(value.to_sympy()))
        if key not in self._names:
            taken = {str(g.atom) for g in ring.generators if g.atom is not None}
            n = len(self.table) + 1
            while f"{self.prefix}{n}" in taken:
                self.prefix += "_"
            self._names[key] = f"{self.prefix}{n}"
            self.table[self._names[key]] = key
        return self._names[key]

    def of_argument(self, g: Any) -> str | None:
        """Return the name of the argument of a root or an inverse, such as a spring's length squared, if it is long."""
        (x, *_) = g.arguments
        if g.kind not in ("sqrt", "inverse") or len(x) <= LONG:
            return None
        return self.name(x)


def arrange(x: Scalar, ring: Ring, lumps: Lumps | None = None, long: Lumps | None = None) -> Sum:
    """Return the tree to print for an element or a number; ``long`` names long arguments of roots."""
    if type(x) is not Polynomial:
        return Sum([Term(x, [])] if x != 0 else [])
    return Arrangement(ring, lumps, long).entry(x)


def over_sums(x: Scalar, ring: Ring, most: float = inf) -> tuple[Scalar, list[tuple[Any, int]]] | None:
    """Return an element over its common denominator, and the inverses of sums in that with their powers.

    None if a product on the way could have more than ``most`` terms.
    """
    below: list[tuple[Any, int]] = []
    while type(x) is Polynomial:
        inverses = [g for g in ring.used(x) if g.kind == "inverse" and len(g.arguments[0]) > 1]
        if not inverses:
            break
        g = inverses[-1]
        n = max(e for m, _ in x.terms() for i, e in m if i == g.index)
        if len(x) * len(g.arguments[0]) ** n > most:
            return None
        x = x * g.arguments[0] ** n
        below.append((g, n))
    return x, below


def _summands(term: Term) -> list[Term]:
    """Return the terms of a term that is only a number times a bracket; [] for other terms."""
    if len(term.factors) == 1 and term.factors[0][1] == 1 and isinstance(term.factors[0][0], Sum):
        return [Term(t.coefficient * term.coefficient, t.factors) for t in term.factors[0][0].terms]
    return []


class Arrangement:
    """The rules of arrangement for elements of one ring."""

    def __init__(self, ring: Ring, lumps: Lumps | None, long: Lumps | None = None):
        self.ring = ring
        self.lumps = lumps
        self.long = long
        self.classes: dict[int, int] = {}
        self.ranks: dict[int, Any] = {}

    def rank(self, index: int) -> Any:
        """Return the sorting key of a generator: the rank of the atoms that it depends on."""
        if index not in self.ranks:
            g = self.ring.generators[index]
            atoms = sorted(a.rank for a in self.ring.of_mask(g.depends))
            self.ranks[index] = (*atoms, index) if g.arguments else (g.rank,)
        return self.ranks[index]

    def _rank_of_factor(self, factor: tuple[int, int]) -> Any:
        return self.rank(factor[0])

    def _ordered(self, monomial: Key) -> list[tuple[Any, int]]:
        return sorted(monomial, key=self._rank_of_factor)

    def class_of(self, index: int) -> int:
        """Return 0 for moving generators (reactions, accelerations, speeds), 1 for parameters, 2 for all others."""
        if index not in self.classes:
            g = self.ring.generators[index]
            if g.kind in MOVING:
                number = 0
            elif g.kind in FIXED or g.kind in ("inverse", "sqrt") and self._fixed(g):
                number = 1
            else:
                number = 2
            self.classes[index] = number
        return self.classes[index]

    def _fixed(self, g: Any) -> bool:
        atoms = self.ring.of_mask(g.depends)
        return all(a.kind in FIXED for a in atoms) and not any(
            h.kind in ("sin", "cos") for h in self.ring.used(g.arguments[0])
        )

    def entry(self, x: Polynomial) -> Sum:
        """Return a whole element over its denominators that are not parameters."""
        self.ring.budget.scan(PRINTED * len(x))
        denominators: list[tuple[Any, int]] = []
        y: Scalar = x
        while type(y) is Polynomial:
            fractions = [
                g
                for g in self.ring.used(y)
                if g.kind == "inverse" and self.class_of(g.index) == 2 and len(g.arguments[0]) > 1
                if self.long is None or len(g.arguments[0]) <= LONG
            ]
            if not fractions:
                break
            g = fractions[-1]
            n = max(e for m, _ in y.terms() for i, e in m if i == g.index)
            if len(y) * len(g.arguments[0]) ** n > LONGEST:
                break  # the inverse stays a factor of its terms
            y = y * g.arguments[0] ** n
            denominators.append((g.arguments[0], n))
        body = self.groups(self.ring.coerce(y))
        if not denominators:
            return body
        sign = 1
        below: list[tuple[Any, int]] = []
        for d, n in denominators:
            shown = self.groups(d)
            if shown.terms[0].coefficient < 0:
                shown = negative(shown)
                sign *= (-1) ** n
            below.append((shown, -n))
        if sign < 0:
            body = negative(body)
        if len(body.terms) == 1:
            return Sum([Term(body.terms[0].coefficient, body.terms[0].factors + below)])
        return Sum([Term(1, [(body, 1), *below])])

    # ------------------------------------------------------------------ grouping
    def groups(self, x: Polynomial) -> Sum:
        """Return the terms with accelerations, then with products of speeds, then all others."""
        table: dict[Key, dict[Key, dict[Key, int]]] = {}
        class_of = self.class_of
        folded = self._folded()
        for monomial, c in x.terms():
            moving, parameters, other = [], [], []
            for f in monomial:
                k = class_of(f[0])
                if k == 2:
                    other.append(f)
                elif k == 1:
                    parameters.append(f)
                else:
                    moving.append(f)
            if folded:
                parameters = fold(parameters, folded)
                other = fold(other, folded)
            row = table.setdefault(tuple(moving), {}).setdefault(tuple(other), {})
            key = tuple(parameters)
            row[key] = row.get(key, 0) + c
        groups = []
        for moving_key in sorted(table, key=self._order_of_moving):
            coefficient, power = shortest(self.ring, table[moving_key], self.rank)
            if coefficient:
                groups.append((moving_key, self._by_parameters(coefficient, x.den * power)))
        return Sum(self._assembled(groups))

    def _folded(self) -> dict[int, int]:
        """Return {inverse of a single generator: that generator}, to print inverses as negative powers."""
        result = {}
        for g in self.ring.generators:
            if g.kind == "inverse" and len(g.arguments[0]) == 1:
                ((index, _),) = g.arguments[0].terms()[0][0]
                result[g.index] = index
        return result

    def _order_of_moving(self, key: Key) -> Any:
        if not key:
            return (9,)
        kinds = [MOVING[self.ring.generators[i].kind] for i, _ in key]
        degree = sum(e for _, e in key)
        indices = sorted(self.rank(i) for i, e in key for _ in range(e))
        return (min(kinds), -degree, indices)

    def _by_parameters(self, coefficient: Any, den: int) -> dict[Key, list[Part]]:
        """Return {primitive polynomial in parameters: [(rational, monomial of other generators), ...]}."""
        result: dict[Key, list[Part]] = {}
        for other in sorted(coefficient, key=self._order_of_other):
            parameters = coefficient[other]
            content = gcd(*parameters.values())
            items = sorted(parameters.items(), key=self._order_of_parameters)
            if items[0][1] < 0:
                content = -content
            key = tuple((m, c // content) for m, c in items)
            result.setdefault(key, []).append((Fraction(content, den), other))
        return result

    def _order_of_other(self, key: Key) -> Any:
        """Return the sorting key of a monomial: the constant, coordinates, then sines and cosines by angle."""
        degree = 0
        order = []
        for i, e in key:
            if isinstance(i, str):
                degree += 1
                order.append((1, tuple((self.rank(j), n) for j, n in e), i != "sin"))
                continue
            g = self.ring.generators[i]
            degree += abs(e)
            if g.kind in ("sin", "cos"):
                order.append((1, ((self.rank(min(g.index, g.partner)), e),), g.kind != "sin"))
            else:
                order.append((0, ((self.rank(i), e),), False))
        return (degree, sorted(order))

    # ------------------------------------------------------------------ assembly
    def _assembled(self, groups: list[tuple[Key, dict[Key, list[Part]]]]) -> list[Term]:
        """Return the terms of a sum; groups with the same polynomial of parameters are joined."""
        joined: dict[Key, list[tuple[Key, list[Part]]]] = {}
        for moving, by_parameters in groups:
            if moving and len(by_parameters) == 1:
                ((parameters, others),) = by_parameters.items()
                if parameters != ONE:
                    joined.setdefault(parameters, []).append((moving, others))
        terms: list[Term] = []
        printed: set[Key] = set()
        for moving, by_parameters in groups:
            if not moving:
                for parameters, others in by_parameters.items():
                    terms += self._separate(parameters, others)
                continue
            if len(by_parameters) > 1:
                terms.append(self._mixed(moving, by_parameters))
                continue
            ((parameters, others),) = by_parameters.items()
            if parameters in printed:
                continue
            if len(joined.get(parameters, ())) > 1:
                printed.add(parameters)
                terms.append(self._joined(parameters, joined[parameters]))
            else:
                terms.append(self._product(parameters, moving, others))
        return terms

    def _separate(self, parameters: Key, others: list[Part]) -> list[Term]:
        """Return terms without speeds: one factored product, or several if factoring gains nothing."""
        if len(others) > 1 and parameters != ONE:
            return [self._product(parameters, (), others)]
        terms = []
        for r in others:
            term = self._product(parameters, (), [r])
            if inner := _summands(term):
                terms += sorted(inner, key=lambda t: t.coefficient < 0)  # F - m g, not -m g + F
            else:
                terms.append(term)
        return terms

    def _product(self, parameters: Key, moving: Key, others: list[Part]) -> Term:
        """Return parameters · coordinates · moving · trigonometry."""
        content, common, inner = common_part(others)
        number, factors = self._parameters(parameters, content)
        before, after = self._sides(common)
        factors += before
        if len(inner) > 1:
            body = Sum([Term(c, self._flat(other)) for c, other in inner])
            number = made_positive(body, number)
            factors.append((body, 1))
        return Term(number, factors + self._ordered(moving) + after)

    def _joined(self, parameters: Key, parts: list[tuple[Key, list[Part]]]) -> Term:
        """Return parameters · common · (moving · trigonometry + ...)."""
        flat = [entry for _, others in parts for entry in others]
        content, common, _ = common_part(flat)
        inner = []
        for moving, others in parts:
            cofactors = [(c / content, without(other, common)) for c, other in others]
            if len(cofactors) == 1:
                c, other = cofactors[0]
                before, after = self._sides(other)
                inner.append(Term(c, before + self._ordered(moving) + after))
            else:
                inner.append(self._product(ONE, moving, cofactors))
        number, factors = self._parameters(parameters, content)
        before, after = self._sides(common)
        body = Sum(inner)
        number = made_positive(body, number)
        return Term(number, factors + before + after + [(body, 1)])

    def _mixed(self, moving: Key, by_parameters: dict[Key, list[Part]]) -> Term:
        """Return common · (parameters · trigonometry + ...) · moving."""
        everything = [entry for others in by_parameters.values() for entry in others]
        _, common, _ = common_part(everything)
        shared = () if self.lumps else common_divisor([m for key in by_parameters for m, _ in key])
        inner = []
        for parameters, others in by_parameters.items():
            parameter_cofactor = tuple((without(m, shared), c) for m, c in parameters)
            cofactors = [(c, without(other, common)) for c, other in others]
            term = self._product(parameter_cofactor, (), cofactors)
            inner += _summands(term) or [term]  # only parameters: add their terms without a bracket
        number: Any = content_of([Fraction(t.coefficient) for t in inner])
        if number != 1:
            for t in inner:
                t.coefficient = t.coefficient / number
        body = Sum(inner)
        number = made_positive(body, number)
        before, after = self._sides(common)
        front = self._ordered(shared)
        return Term(number, front + before + [(body, 1)] + self._ordered(moving) + after)

    def _flat(self, other: Key) -> list[tuple[Any, int]]:
        before, after = self._sides(other)
        return before + after

    def _sides(self, other: Key) -> tuple[list[tuple[Any, int]], list[tuple[Any, int]]]:
        """Return the factors to print before accelerations and speeds (coordinates) and after them (functions)."""
        before: list[tuple[Any, int]] = []
        after: list[tuple[Any, int]] = []
        for factor in sorted(other, key=lambda f: self._order_of_other((f,))):
            i, e = factor
            if isinstance(i, str):
                after.append((factor, 1))
            elif self.ring.generators[i].kind in ("coordinate", "time", "quaternion"):
                before.append((i, e))
            else:
                after.append((i, e))
        return before, after

    # ------------------------------------------------------------------ parameters
    def _order_of_parameters(self, item: tuple[Key, int]) -> Any:
        """Return the sorting key of a monomial of parameters: oldest generators first, a plain number last."""
        monomial = self._ordered(item[0])
        ranks = [self.rank(i) for i, e in monomial for _ in range(abs(e))]
        return not monomial, ranks, [-e for _, e in monomial]

    def _parameters(self, key: Key, number: Fraction) -> tuple[Fraction | int, list[tuple[Any, int]]]:
        """Return a polynomial of parameters times a number as a number and factors."""
        fixed = self._fraction(key)
        if fixed is not None:
            return fixed.coefficient * number, fixed.factors
        if len(key) == 1:
            ((monomial, c),) = key
            return number * c, self._ordered(monomial)
        if self.lumps is not None:
            return number, [(self.lumps.name(self._element(key)), 1)]
        common = common_divisor([m for m, _ in key])
        inner = [(without(m, common), c) for m, c in key]
        if common:
            inner.sort(key=self._order_of_parameters)
        front_number = number
        if number.denominator != 1:  # (m/3 + M), not (m + 3 M)/3: fewer numbers
            spread = [Fraction(c) * number for _, c in inner]
            if sum(abs(c) != 1 for c in spread) <= 1 + sum(abs(c) != 1 for _, c in inner):
                inner = [(m, c) for (m, _), c in zip(inner, spread, strict=True)]
                front_number = Fraction(1)
        body = self._collected(inner)
        front_number = made_positive(body, front_number)
        front = self._ordered(common)
        at = self._place(front, [m for m, _ in inner])
        return front_number, front[:at] + [(body, 1)] + front[at:]

    def _place(self, factors: list[tuple[Any, int]], bracket: list[Key]) -> int:
        """Return the position of a bracket: after the factors if all are older, else before them."""
        ranks = [self.rank(i) for m in bracket for i, _ in m]
        first = all(self.rank(i) < min(ranks) for i, _ in factors) if ranks else False
        return len(factors) if first else 0

    def _collected(self, inner: list[tuple[Key, Any]]) -> Sum:
        """Return m₁ L² + m₂ L² as (m₁ + m₂) L² if this has fewer terms."""
        plain = Sum([Term(c, self._ordered(m)) for m, c in inner])
        if len(inner) < 3 or len(inner) > 200:
            return plain
        best = None
        oldest_linear = partial(min, key=lambda f: (abs(f[1]), self.rank(f[0])))
        for pick in (
            oldest_linear,
            partial(min, key=self._rank_of_factor),
            partial(max, key=self._rank_of_factor),
        ):
            rows: dict[Key, list[tuple[Key, Any]]] = {}
            for m, c in inner:
                if not m:
                    rows.setdefault((), []).append(((), c))
                    continue
                g, e = pick(m)
                cofactor = tuple(f for f in m if f[0] != g)
                rows.setdefault(cofactor, []).append((((g, e),), c))
            if best is None or len(rows) < len(best):
                best = rows
        if best is None or len(best) == len(inner):
            return plain
        terms = []
        for cofactor, summands in best.items():
            if len(summands) == 1:
                ((m, c),) = summands
                terms.append(Term(c, self._ordered(tuple(sorted(m + cofactor, reverse=True)))))
                continue
            if not cofactor:
                terms += [Term(c, self._ordered(m)) for m, c in summands]
                continue
            number = content_of([Fraction(c) for _, c in summands])
            body = Sum([Term(c / number, self._ordered(m)) for m, c in summands])
            number = made_positive(body, number)
            factors = self._ordered(cofactor)
            at = self._place(factors, [m for m, _ in summands])
            terms.append(Term(number, factors[:at] + [(body, 1)] + factors[at:]))
        return Sum(terms)

    def _element(self, key: Key) -> Polynomial:
        total: Scalar = 0
        for monomial, c in key:
            value: Scalar = c
            for i, e in monomial:
                g = self.ring.variable(i)
                value = value * (g**e if e > 0 else 1 / g**-e)
            total = value + total
        return self.ring.coerce(total)

    def _fraction(self, key: Key) -> Term | None:
        """Return M - M²/(m + M) as m M/(m + M): parameters over a common denominator; None without denominators."""
        generators = self.ring.generators
        if not any(generators[i].kind == "inverse" for m, _ in key for i, _ in m):
            return None
        cleared = over_sums(self._element(key), self.ring)
        if cleared is None:
            return None
        x, over = cleared
        below: list[tuple[Any, int]] = [(self.groups(g.arguments[0]), -n) for g, n in over]
        top = arrange(x, self.ring)
        if len(top.terms) == 1:
            return Term(top.terms[0].coefficient, top.terms[0].factors + below)
        return Term(1, [(top, 1), *below])
