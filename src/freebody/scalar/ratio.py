"""Fractions of canonical polynomials, the scalars in which systems of linear equations are solved.

    a/b + c/d = (a d' + c b')/lcm(b, d),        a/b = 0  if and only if  a = 0

The ring has no zero divisors, so a ratio is zero if its numerator is canonically zero. FLINT's gcd cancels common
factors after every operation, which keeps the elements small. No inverse generator is made, so that divisions do not
enlarge the ring.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import gcd
from typing import Any

from ..errors import DivisorError
from .algebra import Scalar
from .element import Polynomial, element

_SHORT = (
    400  # longest ratio, in terms, whose denominator is freed of sines and roots in search of a shorter form
)


class Ratio:
    """``num / den`` of elements of one ring; ``den`` is primitive, with a positive leading coefficient.

    Equal ratios with sines and cosines may have different terms, but their difference is zero.

    Parameters
    ----------
    ring : Ring
    num, den : Polynomial, int or Fraction

    Examples
    --------
    >>> import sympy
    >>> from freebody.scalar.polynomial import Ring
    >>> ring = Ring()
    >>> m, M = (ring.generator(sympy.Symbol(name)) for name in ("m", "M"))
    >>> Ratio(ring, m, m + M) + Ratio(ring, M, m + M)
    1
    >>> Ratio(ring, m * m - M * M, 2 * m + 2 * M)
    -M/2 + m/2
    >>> Ratio(ring, m, m + M)
    (m)/(M + m)
    """

    __slots__ = ("den", "num", "ring")

    def __init__(self, ring: Any, num: Scalar, den: Scalar = 1) -> None:
        self.ring = ring
        self.num, self.den = _reduced(ring, num, den)

    def _coerced(self, other: Scalar) -> Any:
        if type(other) is Ratio:
            return other
        if isinstance(other, int | Fraction) or type(other) is Polynomial:
            return Ratio(self.ring, other)
        return NotImplemented

    def __add__(self, other: Scalar) -> Scalar:
        other = self._coerced(other)
        if other is NotImplemented:
            return other
        if self.den == other.den:
            return Ratio(self.ring, self.num + other.num, self.den)
        b, d = _without_common(self.ring, self.den, other.den)
        return Ratio(self.ring, self.num * d + other.num * b, self.den * d)

    __radd__ = __add__

    def __neg__(self) -> Ratio:
        return Ratio(self.ring, -self.num, self.den)

    def __sub__(self, other: Scalar) -> Scalar:
        other = self._coerced(other)
        return other if other is NotImplemented else self + (-other)

    def __rsub__(self, other: Scalar) -> Scalar:
        return -self + other

    def __mul__(self, other: Scalar) -> Scalar:
        other = self._coerced(other)
        if other is NotImplemented:
            return other
        return Ratio(self.ring, self.num * other.num, self.den * other.den)

    __rmul__ = __mul__

    def __truediv__(self, other: Scalar) -> Scalar:
        other = self._coerced(other)
        if other is NotImplemented:
            return other
        if other.num == 0:
            raise DivisorError(f"Expected a divisor that is not zero in ({self}) / 0.")
        return Ratio(self.ring, self.num * other.den, self.den * other.num)

    def __rtruediv__(self, other: Scalar) -> Scalar:
        return Ratio(self.ring, other) / self

    def __pow__(self, n: int) -> Scalar:
        result: Any = Ratio(self.ring, 1)
        for _ in range(abs(n)):
            result = result * self
        return result if n >= 0 else 1 / result

    def __eq__(self, other: Any) -> bool:
        other = self._coerced(other)
        return NotImplemented if other is NotImplemented else bool((self - other).num == 0)

    def __hash__(self) -> int:
        raise TypeError("A ratio has no hash: equal ones may differ in their terms.")

    def __bool__(self) -> bool:
        return bool(self.num != 0)

    def __len__(self) -> int:
        """Number of terms, 1 for a number: the cost of computing with it."""
        return _size(self.num) + _size(self.den) - 1

    @property
    def is_number(self) -> bool:
        """True if no symbol occurs."""
        return type(self.num) is not Polynomial and type(self.den) is not Polynomial

    def whole(self) -> Scalar:
        """The ratio as an element of the ring; a denominator becomes inverse generators."""
        return (
            self.num
            if self.den == 1
            else self.ring.quotient(self.ring.coerce(self.num), self.ring.coerce(self.den))
        )

    def tidy(self) -> Ratio:
        """The ratio in its shortest form: with sines cancelled, or with no roots in the denominator."""
        best = _with_sines(self)
        rational = _rationalised(best)
        return rational if len(rational) < len(best) else best

    def __repr__(self) -> str:
        return str(self.num) if self.den == 1 else f"({self.num})/({self.den})"


def _size(x: Scalar) -> int:
    return len(x) if type(x) is Polynomial else 1


def cleared(ring: Any, ratios: Sequence[Ratio]) -> list[Scalar]:
    """The ratios times the least common multiple of their denominators: elements of the ring."""
    total: Any = None  # not in normal form: the relations would hide the factors of the product
    integers = 1
    for r in ratios:
        if type(r.den) is Polynomial:
            num = ring.promoted(r.den.num)
            total = num if total is None else ring.promoted(total)
            cofactor = num // ring.common(total, num)
            ring.budget.product(total, cofactor)
            total = total * cofactor
        den = r.num.den if type(r.num) is Polynomial else Fraction(r.num).denominator
        integers = integers * den // gcd(integers, den)
    if total is None:
        return [r.num * integers for r in ratios]
    result = []
    for r in ratios:
        cofactor = total // ring.promoted(r.den.num) if type(r.den) is Polynomial else total
        x = element(ring, cofactor, 1, ring.support(cofactor))
        result.append(r.num * (ring.reduced(x) if type(x) is Polynomial else x) * integers)
    return result


def common_factor(ring: Any, elements: Sequence[Scalar]) -> Scalar:
    """Greatest common divisor of elements without inverse generators (their integer contents included)."""
    factor: Any = None
    for x in elements:
        if x == 0:
            continue
        x = ring.coerce(x)
        num = ring.promoted(x.num)
        factor = num if factor is None else ring.common(ring.promoted(factor), num)
        if factor.is_constant() and int(factor.leading_coefficient()) in (1, -1):
            return 1
    return 1 if factor is None else element(ring, factor, 1, ring.support(factor))


def divided(ring: Any, x: Scalar, divisor: Scalar) -> Scalar:
    """x / divisor for a divisor that divides the terms of x, as :func:`common_factor` does."""
    if divisor == 1 or x == 0:
        return x
    x, divisor = ring.coerce(x), ring.coerce(divisor)
    num = ring.promoted(x.num) // ring.promoted(divisor.num)
    return element(ring, num, x.den, ring.support(num)) * divisor.den


def _reduced(ring: Any, a: Scalar, b: Scalar) -> tuple[Scalar, Scalar]:
    """Numerator and denominator of a / b without common factors; the denominator is primitive or 1."""
    if a == 0:
        return 0, 1
    if b == 0:
        raise DivisorError(f"Expected a divisor that is not zero in ({a}) / 0.")
    a, b = _without_inverses(ring, a, b)
    if type(b) is not Polynomial or b.is_number:
        b = b.number() if type(b) is Polynomial else b
        return (a if b == 1 else a * (1 / Fraction(b))), 1
    if type(a) is Polynomial:
        an, bn = ring.promoted(a.num), ring.promoted(b.num)
        common = ring.common(an, bn)
        if not common.is_constant():
            an, bn = an // common, bn // common
            a = element(ring, an, a.den, ring.support(an))
            b = element(ring, bn, b.den, ring.support(bn))
            if type(b) is not Polynomial:
                return a * (1 / Fraction(b)), 1
    bn = ring.promoted(b.num)
    content = int(bn.content())
    if bn.leading_coefficient() < 0:
        content = -content
    if content != 1 or b.den != 1:
        factor = Fraction(b.den, content)
        return a * factor, element(ring, bn // content, 1, b.mask)
    return a, b


def _without_inverses(ring: Any, a: Scalar, b: Scalar) -> tuple[Scalar, Scalar]:
    """Both times the reciprocals of their inverse generators."""
    for _ in range(10 * len(ring.generators)):
        newest = -1
        for x in (a, b):
            if type(x) is Polynomial:
                newest = max([newest, *(g.index for g in ring.used(x) if g.kind == "inverse")])
        if newest < 0:
            break
        p = ring.generators[newest].arguments[0]
        a, b = a * p, b * p
    return a, b


def _without_common(ring: Any, b: Scalar, d: Scalar) -> tuple[Scalar, Scalar]:
    """b and d, both divided by their greatest common divisor."""
    if type(b) is not Polynomial or type(d) is not Polynomial:
        return b, d
    bn, dn = ring.promoted(b.num), ring.promoted(d.num)
    common = ring.common(bn, dn)
    if common.is_constant():
        return b, d
    bn, dn = bn // common, dn // common
    return element(ring, bn, 1, ring.support(bn)), element(ring, dn, 1, ring.support(dn))


def _with_sines(r: Ratio) -> Ratio:
    """The ratio with common sines cancelled, which the common divisor misses because s² is written 1 - c²."""
    ring = r.ring
    if type(r.num) is not Polynomial or type(r.den) is not Polynomial:
        return r
    for g in ring.used(r.den):
        for sine in (g.index, g.partner):
            if g.kind in ("sin", "cos") and ring.generators[sine].kind == "sin":
                top, bottom = over_sine(ring, r.num, sine), over_sine(ring, r.den, sine)
                if top is not None and bottom is not None:
                    return _with_sines(Ratio(ring, top, bottom))
    return r


def over_sine(ring: Any, x: Scalar, index: int) -> Scalar:
    """x / s for the sine s of an index, None if s does not divide x: (a + b s)/s = b + s a/(1 - c²)."""
    if type(x) is not Polynomial:
        return None
    g = ring.generators[index]
    num = ring.promoted(x.num)
    s, c = (ring.promoted(ring.variable(i).num) for i in (index, g.partner))
    b, a = divmod(num, s)
    quotient, rest = divmod(a, 1 - c * c)
    if rest:
        return None
    first = element(ring, b, x.den, ring.support(b))
    second = element(ring, quotient, x.den, ring.support(quotient))
    return first + second * ring.variable(index)


def _rationalised(r: Ratio) -> Ratio:
    """The ratio with a denominator free of sines and square roots, as long as it stays short."""
    ring = r.ring
    squares = ring.relations.squares
    for _ in range(8):
        if type(r.den) is not Polynomial:
            return r
        roots = [g for g in ring.used(r.den) if (1 << g.index) & squares]
        if not roots or len(r) > _SHORT:
            break
        place = ring.capacity - 1 - roots[-1].index
        num = ring.promoted(r.den.num)
        slope = num.derivative(place)
        # den = d0 + d1 g, times its conjugate d0 - d1 g
        d1 = element(ring, slope, 1, ring.support(slope))
        conjugate = r.den - 2 * d1 * ring.variable(roots[-1].index)
        r = Ratio(ring, r.num * conjugate, r.den * conjugate)
    return r
