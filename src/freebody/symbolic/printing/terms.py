"""Terms, sums and common divisors of monomials: the arithmetic of `arrange`."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from math import gcd, lcm
from typing import Any

Key = tuple[Any, ...]
"""A monomial: ((generator, exponent), ...), newest generator first."""
Part = tuple[Fraction, Key]
"""A rational coefficient and a monomial."""


@dataclass(slots=True)
class Term:
    """coefficient · Π nodeᵉ; the coefficient is an int or a Fraction."""

    coefficient: Any
    factors: list[tuple[Any, int]]


@dataclass(slots=True)
class Sum:
    """Terms in printing order; the sign of a ``fixed`` sum is not changed, because it is known to be positive."""

    terms: list[Term]
    fixed: bool = False


@dataclass(slots=True)
class Applied:
    """A function of sums, such as the root of a product of several factors."""

    function: str
    arguments: list[Sum]


ONE: Key = (((), 1),)


def fold(factors: list[tuple[int, int]], folded: dict[int, int]) -> list[tuple[int, int]]:
    """Return factors with each inverse in ``folded`` as a negative power of its generator."""
    if not any(i in folded for i, _ in factors):
        return factors
    return sorted(((folded[i], -e) if i in folded else (i, e) for i, e in factors), reverse=True)


def negative(s: Sum) -> Sum:
    """Return -s."""
    return Sum([Term(-t.coefficient, t.factors) for t in s.terms])


def without_minus(s: Sum) -> Sum:
    """Return -(a - b) c as (b - a) c; sums of several terms as they are, so that equal brackets in them stay equal."""
    (term,) = s.terms if len(s.terms) == 1 else (None,)
    if term is None or term.coefficient > 0:
        return s
    for k, (node, e) in enumerate(term.factors):
        if isinstance(node, Sum) and not node.fixed and e % 2 and len(node.terms) == 2:
            a, b = node.terms
            if a.coefficient > 0 > b.coefficient:
                other = Sum([Term(-b.coefficient, b.factors), Term(-a.coefficient, a.factors)])
                return Sum([Term(-term.coefficient, [*term.factors[:k], (other, e), *term.factors[k + 1 :]])])
    return s


def made_positive(body: Sum, number: Any) -> Any:
    """Make the first term of a bracket positive; return the number in front with its sign."""
    if body.terms and body.terms[0].coefficient < 0:
        for t in body.terms:
            t.coefficient = -t.coefficient
        return -number
    return number


def content_of(values: list[Fraction]) -> Fraction:
    """Return the number to factor out of a bracket so that the fewest numbers are printed."""
    numerator = gcd(*(v.numerator for v in values)) or 1
    best, least = Fraction(1), sum(abs(v) != 1 for v in values)
    for content in (Fraction(numerator, lcm(*(v.denominator for v in values))), Fraction(numerator)):
        n = (content != 1) + sum(abs(v) != content for v in values)
        if n < least or n == least and best == 1:
            best, least = content, n
    return best


def common_part(entries: list[Part]) -> tuple[Fraction, Key, list[Part]]:
    """Return (rational content, common monomial, cofactors) of a list of terms."""
    if len(entries) == 1:
        return entries[0][0], entries[0][1], [(Fraction(1), ())]
    content = content_of([c for c, _ in entries])
    common = common_divisor([other for _, other in entries])
    return content, common, [(c / content, without(other, common)) for c, other in entries]


def common_divisor(monomials: list[Key]) -> Key:
    """Return the largest common divisor of monomials; negative powers have negative common powers."""
    if len(monomials) == 1:
        return monomials[0]
    common = dict(monomials[0])
    for m in monomials[1:]:
        if not common:
            break
        powers = dict(m)
        shared = {}
        for i, e in common.items():
            f = powers.get(i)
            if f is None:
                continue
            if isinstance(i, str):  # a wave: all or nothing
                if f == e:
                    shared[i] = e
            elif e > 0 and f > 0:
                shared[i] = min(e, f)
            elif e < 0 and f < 0:
                shared[i] = max(e, f)
        common = shared
    return tuple(f for f in monomials[0] if f[0] in common for f in [(f[0], common[f[0]])])


def without(monomial: Key, divisor: Key) -> Key:
    """Return a monomial divided by its divisor."""
    if not divisor:
        return monomial
    powers = dict(divisor)
    result = []
    for i, e in monomial:
        if isinstance(i, str):
            if i not in powers:
                result.append((i, e))
            continue
        power = e - powers.get(i, 0)
        if power:
            result.append((i, power))
    return tuple(result)
