"""Constants of an elliptic motion to a hundred digits, in decimal arithmetic.

Near a separatrix the period depends on the logarithm of a difference of almost equal numbers. The data are
exact (each double is a rational number), so the few constants of a motion are computed once from them without
any cancellation worth the name; only what depends on time is left to doubles
(:mod:`freebody.exact.elliptic`).

Sources: *NIST Handbook of Mathematical Functions* (DLMF), sections 19.8 (arithmetic-geometric mean) and 19.36
(duplication); B. C. Carlson, "Numerical computation of real or complex elliptic integrals", *Numerical
Algorithms* 10 (1995), 13-26.
"""

from __future__ import annotations

from collections.abc import Callable
from decimal import Context, Decimal, localcontext
from fractions import Fraction
from functools import cache, wraps
from typing import Any, ParamSpec, TypeVar

DIGITS = 100
_SMALL = Decimal(10) ** (4 - DIGITS)
INFINITY = Decimal("Infinity")

P = ParamSpec("P")
T = TypeVar("T")


def precise(function: Callable[P, T]) -> Callable[P, T]:
    """Decorator: decimal arithmetic inside the function is to ``DIGITS`` digits, whatever the caller's context."""

    @wraps(function)
    def wrapper(*args: P.args, **kwargs: P.kwargs) -> T:
        with localcontext(Context(prec=DIGITS)):
            return function(*args, **kwargs)

    return wrapper


@precise
def decimal(value: Fraction | float | Decimal) -> Decimal:
    """The number to ``DIGITS`` digits (a double is taken as the rational number it is)."""
    if isinstance(value, Fraction):
        return Decimal(value.numerator) / Decimal(value.denominator)
    return +Decimal(value)


@cache
@precise
def pi() -> Decimal:
    """The circle number, by the method of Gauss and Legendre (DLMF 19.8.5 with E and K of modulus 1/sqrt(2))."""
    a, g, total, weight = Decimal(1), Decimal("0.5").sqrt(), Decimal("0.25"), Decimal(1)
    while abs(a - g) > _SMALL:
        a, g, previous = (a + g) / 2, (a * g).sqrt(), a
        total -= weight * (a - previous) ** 2
        weight *= 2
    return (a + g) ** 2 / (4 * total)


@precise
def sine_cosine(angle: Any) -> tuple[Decimal, Decimal]:
    """Sine and cosine by their power series, of an angle of a few radians."""
    x = decimal(angle)
    sums, term, order = [Decimal(0), Decimal(1)], Decimal(1), 0
    while abs(term) > _SMALL * abs(x) and x:
        order += 1
        term = term * x / order if order % 2 else -term * x / order
        # the sign goes with pairs of terms: x, -x²/2, -x³/6, +x⁴/24
        sums[1 - order % 2] += term
    return sums[0], sums[1]


@precise
def complete_first(m1: Decimal) -> Decimal:
    """K of the complementary parameter m1 = 1 - k²: pi / (2 M(1, k')), infinite at m1 = 0 (DLMF 19.8.5)."""
    if m1 == 0:
        return INFINITY
    a, g = Decimal(1), m1.sqrt()
    while abs(a - g) > _SMALL * a:
        a, g = (a + g) / 2, (a * g).sqrt()
    return pi() / (2 * a)


@precise
def complete_third(m1: Decimal, nu: Decimal) -> Decimal:
    """Integral of 1 / (1 + nu sn²) over one quarter period, nu > -1, m1 > 0 (DLMF 19.8.7 with alpha² = -nu)."""
    a, g, p = Decimal(1), m1.sqrt(), (1 + nu).sqrt()
    term, total = Decimal(1), Decimal(0)
    while abs(term) > _SMALL * abs(total) or abs(a - g) > _SMALL * a:
        total += term
        term *= (p * p - a * g) / (p * p + a * g) / 2
        p = (p * p + a * g) / (2 * p)
        a, g = (a + g) / 2, (a * g).sqrt()
    return pi() / (4 * a) * (2 - nu / (1 + nu) * total)


@precise
def complete_pulse(m1: Decimal, nu: Decimal) -> Decimal:
    """Integral of cn² / (1 + nu sn²) over one quarter period, nu > 0 (to fewer digits when nu is tiny)."""
    if m1 == 0:
        raise ValueError("the quarter period is infinite")
    return ((1 + nu) * complete_third(m1, nu) - complete_first(m1)) / nu


@precise
def first(sine2: Decimal, cosine2: Decimal, delta2: Decimal) -> Decimal:
    """F(phi | m) = s R_F(c², d², 1) from the squares of s = sin(phi), c = cos(phi) and d (DLMF 19.25.5)."""
    x, y, z = cosine2, delta2, Decimal(1)
    mean = (x + y + z) / 3
    # the error of the series below is of the eighth order of the spread: sixty digits
    while max(abs(x - mean), abs(y - mean), abs(z - mean)) > mean * Decimal("1e-8"):
        r, s, t = x.sqrt(), y.sqrt(), z.sqrt()
        shift = r * s + s * t + t * r
        x, y, z = (x + shift) / 4, (y + shift) / 4, (z + shift) / 4
        mean = (x + y + z) / 3
    X, Y = 1 - x / mean, 1 - y / mean
    Z = -X - Y
    E2, E3 = X * Y - Z * Z, X * Y * Z
    # DLMF 19.36.1
    series = (
        1
        - E2 / 10
        + E3 / 14
        + E2**2 / 24
        - 3 * E2 * E3 / 44
        - 5 * E2**3 / 208
        + 3 * E3**2 / 104
        + E2**2 * E3 / 16
    )
    return sine2.sqrt() * series / mean.sqrt()


@precise
def root_between(function: Callable[[Decimal], Decimal], low: Decimal, high: Decimal) -> Decimal:
    """Where the function turns from negative at ``low`` to positive at ``high``, by bisection.

    Not Newton's method: a double root is the interesting case here.
    """
    width = high - low
    while width > _SMALL:
        middle, width = low + width / 2, width / 2
        if function(middle) <= 0:
            low = middle
    return low + width / 2
