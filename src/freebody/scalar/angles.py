"""Sine and cosine (sinh and cosh) of canonical polynomials, by the addition theorems.

The atoms are sine and cosine of one monomial each, over a common denominator when fractions of
it occur: sin(theta/2) after sin(theta) becomes a new pair of atoms that is related to the old pair.
"""

from __future__ import annotations

from fractions import Fraction
from math import lcm
from typing import Any

import sympy

from .element import Polynomial
from .roots import divide, monomial_of, square_root

LARGEST_MULTIPLE = 24
"""sin(n x) is expanded in sin(x) and cos(x) up to this n; beyond it, it is a separate atom."""


def sine_and_cosine(ring: Any, kind: str, x: Polynomial) -> tuple[Any, Any]:
    """(sin x, cos x), or (sinh x, cosh x), by the addition theorems."""
    key = (kind, x)
    if key in ring.cache:
        return ring.cache[key]
    sign = -1 if kind == "sin" else 1
    S: Any = 0
    C: Any = 1
    ring.budget.angle_sum(len(x))
    for monomial, c in ring.terms(x.num):
        s, c = _multiple(ring, kind, monomial, Fraction(c, x.den))
        S, C = S * c + C * s, C * c + sign * (S * s)
    ring.cache[key] = S, C
    return S, C


def _multiple(ring: Any, kind: str, monomial: Any, q: Fraction) -> tuple[Any, Any]:
    """Sine and cosine of q times a monomial."""
    if q < 0:
        s, c = _multiple(ring, kind, monomial, -q)
        return -s, c
    g = ring.generators[monomial[0][0]] if len(monomial) == 1 and monomial[0][1] == 1 else None
    if kind == "sin" and g is not None and g.atom is sympy.pi:
        return _of_pi(ring, monomial, q % 2)
    if kind == "sin" and g is not None and q.denominator == 1 and q <= LARGEST_MULTIPLE:
        pair = _of_inverse_function(ring, g)
        if pair is not None:
            return _times(kind, pair, int(q))
    key, atom, n = _fraction(ring, kind, monomial, q)
    table = ring.cache.setdefault(("multiples", key), [(0, 1), atom])
    while len(table) <= n:
        table.append(_sum(kind, table[-1], atom))
    return table[n]


def _sum(kind: str, a: tuple[Any, Any], b: tuple[Any, Any]) -> tuple[Any, Any]:
    """Sine and cosine of the sum of two angles."""
    sign = -1 if kind == "sin" else 1
    return a[0] * b[1] + a[1] * b[0], a[1] * b[1] + sign * (a[0] * b[0])


def _times(kind: str, pair: tuple[Any, Any], n: int) -> tuple[Any, Any]:
    """Sine and cosine of n times an angle."""
    result: tuple[Any, Any] = (0, 1)
    for _ in range(n):
        result = _sum(kind, result, pair)
    return result


def _fraction(ring: Any, kind: str, monomial: Any, q: Fraction) -> tuple[Any, tuple[Any, Any], int]:
    """Key and atom pair of monomial/d, and n with q = n/d; d grows when a new fraction occurs."""
    chain = ring.cache.setdefault(("fractions", kind, monomial), [])
    n, d = q.numerator, q.denominator
    for level, pair in chain:
        if level % d == 0 and n * (level // d) <= LARGEST_MULTIPLE:
            return (kind, monomial, level), pair, n * (level // d)
    finest = chain[-1][0] if chain else 1
    common = lcm(finest, d) if chain else d
    if common // finest > LARGEST_MULTIPLE and chain or n * (common // d) > LARGEST_MULTIPLE:
        key = (kind, monomial, q)  # a separate atom, not related to the others
        if key not in ring.cache:
            ring.cache[key] = _atoms(ring, kind, monomial_of(ring, monomial) * q, None, 1)
        return key, ring.cache[key], 1
    pair = _atoms(
        ring,
        kind,
        monomial_of(ring, monomial) * Fraction(1, common),
        chain[-1][1] if chain else None,
        common // finest,
    )
    chain.append((common, pair))
    return (kind, monomial, common), pair, n * (common // d)


def _atoms(ring: Any, kind: str, angle: Any, coarser: tuple[Any, Any] | None, k: int) -> tuple[Any, Any]:
    """New generators for sine and cosine of ``angle``; ``coarser`` is the pair of k times the angle."""
    angle = ring.coerce(angle)
    names = ("cos", "sin") if kind == "sin" else ("sinh", "cosh")  # the second leads the relation
    first = ring.new(names[0], (names[0], angle), arguments=(angle,))
    second = ring.new(names[1], (names[1], angle), arguments=(angle,), partner=first.index)
    first.partner = second.index
    a, b = ring.variable(first.index), ring.variable(second.index)
    (cosine, sine) = (a, b) if kind == "sin" else (b, a)
    if kind == "sin":
        square = b.num * b.num + a.num * a.num - 1  # sin² + cos² = 1
    else:
        square = b.num * b.num - a.num * a.num - 1  # cosh² = 1 + sinh²
        second.positive = True
    if coarser is None:
        ring.relations.add_square(1 << second.index, square)
        return sine, cosine
    # (c + i s)^k = C + i S in the new generators, before any relation
    sign = -1 if kind == "sin" else 1
    S, C = sine.num * 0, cosine.num * 0 + 1
    for _ in range(k):
        S, C = S * cosine.num + C * sine.num, C * cosine.num + sign * (S * sine.num)
    coarse = [ring.coerce(x) for x in coarser]
    relations = [
        square,
        S * coarse[0].den - ring.promoted(coarse[0].num),
        C * coarse[1].den - ring.promoted(coarse[1].num),
    ]
    ring.relations.add_general(relations, 1 << first.index | 1 << second.index)
    return ring.reduced(sine), ring.reduced(cosine)


def _of_pi(ring: Any, monomial: Any, q: Fraction) -> tuple[Any, Any]:
    """Sine and cosine of q π, 0 <= q < 2; exact for multiples of π/12."""
    quarter, rest = divmod(q * 2, 1)
    rest = rest / 2
    pair: tuple[Any, Any]
    if rest == 0:
        pair = (0, 1)
    elif (rest * 12).denominator == 1:
        angle = sympy.pi * sympy.Rational(rest.numerator, rest.denominator)
        pair = (ring.from_sympy(sympy.sin(angle)), ring.from_sympy(sympy.cos(angle)))
    else:
        key, atom, n = _fraction(ring, "sin", monomial, rest)
        pair = _times("sin", atom, n)
    for _ in range(int(quarter)):
        pair = (pair[1], -pair[0])
    return pair


def _of_inverse_function(ring: Any, g: Any) -> tuple[Any, Any] | None:
    """Sine and cosine of a generator that is an inverse trigonometric function; None for any other."""
    if g.name == "asin":
        return g.arguments[0], square_root(ring, ring.coerce(1 - g.arguments[0] * g.arguments[0]))
    if g.name == "acos":
        return square_root(ring, ring.coerce(1 - g.arguments[0] * g.arguments[0])), g.arguments[0]
    if g.name in ("atan", "atan2"):
        y, x = g.arguments if g.name == "atan2" else (g.arguments[0], ring.one)
        r = square_root(ring, ring.coerce(x * x + y * y))
        return divide(ring, y, r), divide(ring, x, r)
    return None
