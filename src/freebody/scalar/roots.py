"""Square roots and absolute values of canonical polynomials, by irreducible factors, and tests for their sign."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from flint import fmpz

from ..errors import ExpressionError
from .element import Polynomial, element


def is_positive(ring: Any, num: Any) -> bool:
    """True if an fmpz_mpoly is known or assumed to be nowhere negative."""
    if ring.positive and element(ring, num // int(num.content()), 1, ring.support(num)) in ring.positive:
        return True
    return all(
        c > 0 and all(e % 2 == 0 or _positive(ring, ring.generators[i]) for i, e in monomial)
        for monomial, c in ring.terms(num)
    )


def with_sines(ring: Any, factors: Sequence[tuple[Any, Any]]) -> tuple[int, list[tuple[Any, int]]]:
    """Sign and factors of a denominator with (c - 1)(c + 1) replaced by -s², so that 1/sin² keeps its name."""
    result = [(p, int(n)) for p, n in factors]
    sign = 1
    for p, n in list(result):
        if len(p) != 2 or p.total_degree() != 1:
            continue
        g = ring.generators[ring.exponents(p.monomial(0))[0][0]]
        if g.kind != "cos":
            continue
        c = ring.promoted(ring.variable(g.index).num)
        if p == c - 1 and (c + 1, n) in result:
            result.remove((p, n))
            result.remove((c + 1, n))
            result.append((ring.variable(g.partner).num, 2 * n))
            sign *= (-1) ** n
    return sign, result


def _positive(ring: Any, g: Any) -> bool:
    if g.kind == "inverse":
        return is_positive(ring, g.arguments[0].num)
    return g.positive


def divide(ring: Any, a: Any, b: Any) -> Any:
    """a / b of elements or numbers."""
    return ring.quotient(ring.coerce(a), ring.coerce(b))


def monomial_of(ring: Any, monomial: Sequence[tuple[int, int]]) -> Any:
    """The element for a monomial ((generator, exponent), ...)."""
    result: Any = ring.one
    for i, e in monomial:
        result = result * ring.variable(i) ** e
    return result


def square_root(ring: Any, x: Polynomial) -> Any:
    """√x with squares extracted: √(12 m²) = 2√3 m for a positive m, 2√3 |m| otherwise."""
    if not x:
        return 0
    outside: Any = 1
    x, divisor = _cleared(ring, x, even=True)  # √(N/d²ⁿ) = √N/|d|ⁿ
    # √(N/D) = √(N D)/D
    outside = Fraction(1, x.den)
    constant, factors = ring.factored(x.num * x.den)
    constant = int(constant)
    radicand: Any = 1 if constant > 0 else -1
    for p, n in factors:
        n = int(n)
        positive = is_positive(ring, p)
        if not positive and is_positive(ring, -p):
            p, positive = -p, True
            radicand = radicand * (-1) ** n
        f = element(ring, p, 1, ring.support(p))
        if n >= 2:
            outside = outside * (f if positive or (n // 2) % 2 == 0 else absolute(ring, f)) ** (n // 2)
        if n % 2:
            if positive:
                outside = outside * _root_generator(ring, f)
            else:
                radicand = radicand * f
    for prime, n in fmpz(abs(constant)).factor():
        outside = outside * int(prime) ** (int(n) // 2)
        if int(n) % 2:
            outside = outside * _root_generator(ring, ring.constant(int(prime)))
    if type(radicand) is Polynomial:
        outside = outside * _root_generator(ring, radicand)
    elif radicand < 0:
        raise ExpressionError(f"Expected a radicand that can be positive, got sqrt({x}).")
    for d, n in divisor:
        outside = divide(ring, outside, (d if is_positive(ring, d.num) else absolute(ring, d)) ** n)
    return outside


def _root_generator(ring: Any, radicand: Polynomial) -> Polynomial:
    key = ("sqrt", radicand)
    g = ring.find(key)
    if g is None:
        g = ring.new("sqrt", key, arguments=(radicand,), positive=True)
        r = ring.variable(g.index)
        ring.relations.add_square(1 << g.index, r.num * r.num - ring.promoted(radicand.num))
    return ring.variable(g.index)


def _cleared(ring: Any, x: Polynomial, even: bool) -> tuple[Polynomial, list[tuple[Polynomial, int]]]:
    """x times powers of the reciprocals of its inverse generators, and these powers (halved if even)."""
    divisor: list[tuple[Polynomial, int]] = []
    for _ in range(len(ring.generators)):
        inverses = [g for g in ring.used(x) if g.kind == "inverse"]
        if not inverses:
            break
        i = inverses[-1].index
        n = int(x.num.degrees()[-1 - i])
        n = (n + 1) // 2 if even else n
        d = inverses[-1].arguments[0]
        divisor.append((d, n))
        x = ring.coerce(x * d ** (2 * n if even else n))
    return x, divisor


def absolute(ring: Any, x: Polynomial) -> Any:
    """|x| as a product over the irreducible factors of x."""
    if x.is_number:
        return abs(x.number())
    x, divisor = _cleared(ring, x, even=False)
    constant, factors = ring.factored(x.num) if not x.is_number else (x.number(), [])
    result: Any = abs(Fraction(int(constant), x.den)) if factors else abs(x.number())
    for p, n in factors:
        f = element(ring, p, 1, ring.support(p))
        n = int(n)
        if n % 2 == 0 or is_positive(ring, p):
            result = result * f**n
            continue
        if is_positive(ring, -p):
            result = result * (-f) ** n
            continue
        result = result * f ** (n - 1) * _absolute_generator(ring, f)
    for d, n in divisor:
        result = divide(ring, result, absolute(ring, d) ** n)
    return result.numerator if isinstance(result, Fraction) and result.denominator == 1 else result


def _absolute_generator(ring: Any, f: Polynomial) -> Polynomial:
    if f.num.leading_coefficient() < 0:
        f = -f
    key = ("abs", f)
    g = ring.find(key)
    if g is None:
        square = ring.coerce(f * f)
        g = ring.new("function", key, name="abs", arguments=(f,), positive=True)
        r = ring.variable(g.index)
        if square.den == 1:  # |f|² = f²
            ring.relations.add_square(1 << g.index, r.num * r.num - ring.promoted(square.num))
    return ring.variable(g.index)
