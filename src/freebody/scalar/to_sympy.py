"""Canonical polynomials as SymPy expressions, built in SymPy's own argument order.

SymPy sorts the arguments of every sum and product by pairwise comparison, which takes most of the
time for a large sum. Here the distinct factors are sorted once, terms are ordered by the ranks of
their factors, and the nodes are made from arguments that are already in SymPy's order.
"""

from __future__ import annotations

from functools import cmp_to_key
from typing import Any

import sympy
from sympy.core.basic import Basic

from .element import Polynomial

_FUNCTIONS = {
    "asin": sympy.asin, "acos": sympy.acos, "atan": sympy.atan, "atan2": sympy.atan2, "exp": sympy.exp,
    "log": sympy.log, "abs": sympy.Abs, "sign": sympy.sign, "min": sympy.Min, "max": sympy.Max,
    "pow": sympy.Pow, "sin": sympy.sin, "cos": sympy.cos, "sinh": sympy.sinh, "cosh": sympy.cosh,
    "sqrt": sympy.sqrt,
}  # fmt: skip
_sort_key = cmp_to_key(Basic.compare)
_PRODUCT = sympy.Symbol("a") * sympy.Symbol("b")  # represents the class of products in comparisons


def atom_of(ring: Any, g: Any) -> Any:
    """The SymPy expression of a generator."""
    if g.atom is None:
        arguments = [expression_of(ring, a) for a in g.arguments]
        if g.kind == "inverse":
            g.atom = sympy.Pow(arguments[0], -1)
        else:
            g.atom = _FUNCTIONS[g.name or g.kind](*arguments)
    return g.atom


def number_of(value: Any, den: int = 1) -> Any:
    """An int or Fraction over ``den`` as a SymPy number."""
    return sympy.Rational(value.numerator, value.denominator * den)


def expression_of(ring: Any, x: Any) -> Any:
    """An element as an expanded SymPy expression; see `Ring.to_sympy`."""
    if type(x) is not Polynomial:
        return number_of(x)
    terms = ring.terms(x.num)
    factors: dict[tuple[int, int], Any] = {}
    plain = True
    for monomial, _ in terms:
        for f in monomial:
            if f not in factors:
                atom = atom_of(ring, ring.generators[f[0]])
                factors[f] = atom if f[1] == 1 else sympy.Pow(atom, f[1])
                base = atom.base if atom.is_Pow else atom
                # SymPy joins numbers, roots and powers of one base: these are left to its own product
                plain = (
                    plain
                    and (base.is_Symbol or base.is_Function or base.is_Derivative)
                    and atom.func is not sympy.exp
                )
                plain = plain and not (factors[f].is_Add or factors[f].is_Mul)
    if not plain:
        return sympy.Add(
            *(sympy.Mul(number_of(c, x.den), *(factors[f] for f in monomial)) for monomial, c in terms)
        )
    numbers = {c: number_of(c, x.den) for _, c in terms}
    order = sorted(set(factors.values()) | set(numbers.values()), key=_sort_key)
    rank = {e: i for i, e in enumerate(order)}
    factor_rank = {f: rank[e] for f, e in factors.items()}
    of_class = {type(e): e for e in order} | {sympy.Mul: _PRODUCT}
    class_rank = {type(e): i for i, e in enumerate(sorted(of_class.values(), key=_sort_key))}
    mul = class_rank[sympy.Mul]
    unit = sympy.S.One
    rows = []
    constant = None
    for monomial, c in terms:
        number = numbers[c]
        if not monomial:
            constant = number
            continue
        ranked = sorted([(factor_rank[f], factors[f]) for f in monomial], key=_first)
        if number is not unit:
            key = (mul, len(ranked) + 1, (rank[number], *(r for r, _ in ranked)))
            rows.append((key, sympy.Mul._from_args((number, *(e for _, e in ranked)))))
        elif len(ranked) == 1:
            e = ranked[0][1]
            rows.append(((class_rank[type(e)], 0, (ranked[0][0],)), e))
        else:
            key = (mul, len(ranked), tuple(r for r, _ in ranked))
            rows.append((key, sympy.Mul._from_args(tuple(e for _, e in ranked))))
    rows.sort(key=_first)
    arguments = [e for _, e in rows]
    if constant is not None:
        arguments.insert(0, constant)
    return sympy.Add._from_args(tuple(arguments))


def _first(row: Any) -> Any:
    return row[0]
