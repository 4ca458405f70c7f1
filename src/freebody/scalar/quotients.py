"""Division of canonical polynomials.

Common factors cancel first, so that (m² - M²)/(m + M) is m - M. Each remaining irreducible factor p of the
divisor becomes an inverse generator, with the relation p·p⁻¹ = 1.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from flint.utils.flint_exceptions import DomainError

from ..errors import DivisorError, ExpressionError
from .element import Polynomial, element
from .roots import is_positive, with_sines


def quotient(ring: Any, a: Any, b: Any) -> Any:
    """a / b of two elements of a ring; see `Ring.quotient`."""
    result = _quotient(ring, a, b)
    return result.numerator if isinstance(result, Fraction) and result.denominator == 1 else result


def _quotient(ring: Any, a: Any, b: Any) -> Any:
    if not b:
        raise DivisorError(f"Expected a divisor that is not zero in ({a}) / 0.")
    if b.num.is_constant():
        return a * (1 / Fraction(b.number()))
    if not a:
        return 0
    a, b = _without_inverses(ring, a, b)
    if not isinstance(b, Polynomial):
        return a * (1 / Fraction(b))
    a = ring.coerce(a)
    an, bn = ring.promoted(a.num), ring.promoted(b.num)
    content = int(bn.content())
    if bn.leading_coefficient() < 0:
        content = -content
    bn = bn // content
    factor = Fraction(b.den, content * a.den)
    whole = _exact(an, bn)
    if whole is not None:
        mask = ring.support(whole)
        whole, scale, mask = ring.relations.normal_form(whole, mask, mask)
        return element(ring, whole, scale, mask) * factor
    common = ring.common(an, bn)
    if not common.is_constant():
        an, bn = an // common, bn // common
    mask = ring.support(an)
    an, scale, mask = ring.relations.normal_form(an, mask, mask)
    return element(ring, an, scale, mask) * factor * _inverse(ring, bn)


def _exact(a: Any, b: Any) -> Any:
    """a / b, or None if b does not divide a. The remainder is not computed: it could be longer than both."""
    try:
        return a / b
    except DomainError:
        return None


def _without_inverses(ring: Any, a: Any, b: Any) -> tuple[Any, Any]:
    """Numerator and denominator, both times the reciprocals of the inverse generators of b."""
    for _ in range(len(ring.generators)):
        if type(b) is not Polynomial:
            break
        inverses = [g for g in ring.used(b) if g.kind == "inverse"]
        if not inverses:
            break
        p = inverses[-1].arguments[0]
        a, b = a * p, b * p
    return a, b


def _inverse(ring: Any, num: Any) -> Any:
    """1 / num as a product of inverse generators of its irreducible factors."""
    constant, factors = ring.factored(num)
    sign, factors = with_sines(ring, factors)
    result: Any = Fraction(sign, int(constant))
    for p, n in factors:
        if len(p) == 1:  # a generator
            g = ring.generators[ring.exponents(p.monomial(0))[0][0]]
            square = ring.relations.square.get(1 << g.index)
            if g.kind == "sqrt" and square is not None:  # 1/√P = √P / P
                x = ring.variable(g.index)
                result = result * quotient(ring, x, ring.coerce(x * x)) ** n
                continue
            if g.kind == "inverse":
                result = result * g.arguments[0] ** n
                continue
        result = result * inverse_of(ring, p) ** n
    return result


def inverse_of(ring: Any, p: Any) -> Any:
    """The inverse generator of an irreducible, primitive fmpz_mpoly."""
    if p.leading_coefficient() < 0:
        return -inverse_of(ring, -p)
    x = element(ring, p, 1, ring.support(p))
    key = ("inverse", x)
    g = ring.find(key)
    if g is None:
        g = ring.new("inverse", key, arguments=(x,), positive=is_positive(ring, p))
        i = ring.variable(g.index)
        relation = i.num * ring.promoted(p) - 1
        try:
            ring.relations.add_general([relation], 1 << g.index)
        except ZeroDivisionError:
            raise ExpressionError(f"Expected a divisor that has an inverse, got {x}.") from None
    return ring.reduced(ring.variable(g.index))
