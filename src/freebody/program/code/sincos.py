"""Sine and cosine together, for one number or one in each lane.

    n = round(2 x / π),   r = x - n π/2,   (sin x, cos x) = ± (sin r, cos r) or ± (cos r, sin r)

The reduction is exact enough for a result within one unit in the last place at every |x| below :data:`LIMIT`, also
next to multiples of π/2: with π/2 = P1 + P2 + P3,

- n P1 is subtracted with one fused multiply-add, whose result is exact by cancellation;
- P2 has 33 bits and n fewer than 20, so n P2 is exact and so is the rounding error of its subtraction;
- P3 and that error form a correction y, which enters as sin(r + y) ≈ sin r + y cos r.

Larger arguments, infinities and NaN are reduced one lane at a time, on a branch marked unlikely, with the digits of 2/π
that they need (Payne and Hanek). For |x| = M 2^E, M is multiplied by 192 bits of 2/π that begin at the weight 2^(1-E).
The product modulo 4 has 126 bits after the point, and no double comes nearer to a multiple of π/2 than 2^-62. The C
library is no substitute: next to zeros of huge arguments, glibc 2.36 errs by thousands of units in the last place.

The polynomials are minimax in relative error on [-π/4, π/4] (3e-18 and 5e-20), found with Remez's algorithm.

Sources: W. J. Cody and W. Waite, Software Manual for the Elementary Functions (1980), ch. 8; Muller et al.,
Handbook of Floating-Point Arithmetic (2018), §10.2 (also on the reduction of huge arguments).
"""

from __future__ import annotations

from functools import cache

import numpy as np

from ...native.functions import each, rare
from ...native.instructions import (
    Real,
    Reals,
    Row,
    Whole,
    bits,
    compiled,
    fma,
    high,
    inlined,
    joined,
    lanes,
    leading_zeros,
    library,
    numbers,
    polynomial,
    shifted,
    unsigned,
    where,
    with_bits,
)
from ...native.translation import parts

LIMIT = 5e5
"""Largest argument of the short reduction: 2 x / π must stay below 2^19."""

_hex = float.fromhex
_P1, _P2, _P3 = _hex("0x1.921fb54442d18p0"), _hex("0x1.1a62633100000p-54"), _hex("0x1.1701b839a2520p-88")
_TWO_OVER_PI = _hex("0x1.45f306dc9c883p-1")
_PI_LOW = _hex("0x1.1a62633145c07p-54")  # π/2 - P1
_WORDS = (
    0, 0xA2F9836E4E441529, 0xFC2757D1F534DDC0, 0xDB6295993C439041, 0xFE5163ABDEBBC561, 0xB7246E3A424DD2E0,
    0x06492EEA09D1921C, 0xFE1DEB1CB129A73E, 0xE88235F52EBB4484, 0xE99C7026B45F7E41, 0x3991D639835339F4,
    0x9C845F8BBDF9283B, 0x1FF897FFDE05980F, 0xEF2F118B5A0A6D1F, 0x6D367ECF27CB09B7, 0x4F463F669E5FEA2D,
    0x7527BAC7EBE5F17B, 0x3D0739F78A5292EA, 0x6BFB5FB11F8D5D08, 0x56033046FC7B6BAB, 0xF0CFBC209AF4361D,
)  # fmt: skip
_DIGITS = np.array(_WORDS, dtype=np.uint64).view(np.int64)
"""2/π in words of 64 bits after the point, behind a word of zeros: the first bit is read at the place E + 62."""
_SIGN = -(1 << 63)
_ROUND = _hex("0x1.8p52")  # adding it leaves the nearest integer in the low bits
_SIN = polynomial((
    -0.16666666666666632, 0.008333333333322413, -0.00019841269829807805,
    2.755731369191626e-06, -2.505075811491489e-08, 1.589679563029853e-10,
))  # fmt: skip
_COS = polynomial((
    0.0416666666666666, -0.0013888888888874125, 2.4801587289482188e-05,
    -2.7557314352334094e-07, 2.0875723273401634e-09, -1.1359647811748212e-11,
))  # fmt: skip
sin, cos = library("sin"), library("cos")


@compiled
def sincos(x: Real, sine: Row, cosine: Row) -> None:
    """Sine and cosine; a lane beside a large argument keeps the bits that it has alone."""
    n, r, y = reduced(x)
    finish(n, r, y, sine, cosine)
    small = abs(x) <= LIMIT
    if rare(not all(small)):
        for lane in each(not small):
            huge(x[lane], shifted(numbers(sine), lane), shifted(numbers(cosine), lane))


@compiled
def sincos_of_library(x: Real, sine: Row, cosine: Row) -> None:
    """Sine and cosine of the C library, for processors without a fused multiply-add."""
    for lane in range(lanes(x)):
        numbers(sine)[lane] = sin(x[lane])
        numbers(cosine)[lane] = cos(x[lane])


@inlined
def reduced(x: Real) -> tuple[Whole, Real, Real]:
    """(n in its low bits, r, y) with x = n π/2 + r + y, for |x| up to `LIMIT`."""
    near = fma(x, _TWO_OVER_PI, _ROUND)
    n = near - _ROUND
    r0 = fma(-n, _P1, x)
    p = n * _P2
    r = r0 - p
    return bits(near), r, fma(-n, _P3, (r0 - r) - p)


@inlined
def sine_and_cosine(r: Real, y: Real) -> tuple[Real, Real, Real, Real]:
    """Sine and cosine of r + y, each as a large and a small term.

    sin(r + y) = r + (r³ S + y (1 - z/2)),  cos(r + y) = W + (((1 - W) - z/2) + (z² C - r y)),  z = r², W = 1 - z/2
    """
    z = r * r
    zz = z * z
    h = z * 0.5
    W = 1.0 - h
    sine = fma(r * z, _SIN(z, zz), y * W)
    rest = fma(-r, y, (1.0 - W) - h)
    return r, sine, W, fma(zz, _COS(z, zz), rest)


@inlined
def finish(n: Whole, r: Real, y: Real, sine: Row, cosine: Row) -> None:
    """Store sine and cosine of n π/2 + r + y: swapped when n is odd, with signs from its second bit."""
    s, s_small, c, c_small = sine_and_cosine(r, y)
    s, c = s + s_small, c + c_small
    odd = (n & 1) != 0
    sine[0] = with_bits(bits(where(odd, c, s)) ^ ((n & 2) << 62))
    cosine[0] = with_bits(bits(where(odd, s, c)) ^ ((n + 1 & 2) << 62))


@compiled
def huge(x: float, sine: Reals, cosine: Reals) -> None:
    """Sine and cosine of a number beyond `LIMIT`, infinity or nan, with the digits of 2/π that it needs."""
    word = bits(abs(x))
    M = word & (1 << 52) - 1 | 1 << 52
    place = (word >> 52) + 62 - 1075
    first, shift = place >> 6, place & 63
    # M times three words of 2/π: the last 128 bits of the 192 behind the point of the product modulo 4
    w0 = joined(_DIGITS[first], _DIGITS[first + 1], shift)
    w1 = joined(_DIGITS[first + 1], _DIGITS[first + 2], shift)
    w2 = joined(_DIGITS[first + 2], _DIGITS[first + 3], shift)
    below, carried = M * w1, high(M, w2)
    lower = below + carried
    carry = 1 if lower ^ _SIGN < carried ^ _SIGN else 0  # as natural numbers
    upper = M * w0 + high(M, w1) + carry
    # the nearest quarter, and the remainder H 2^-126
    quarter = upper + (1 << 61) >> 62 & 3
    left = upper - (quarter << 62)
    negative = left < 0
    if negative:
        left = -left - (0 if lower == 0 else 1)
        lower = -lower
    # |H| as the sum of two doubles
    zeros = 0
    if left == 0:
        left, lower, zeros = lower, 0, 64
    more = leading_zeros(left)
    top, bottom, zeros = joined(left, lower, more), lower << more, zeros + more
    d0 = unsigned(top & -2048)
    d1 = fma(unsigned(bottom), 2.0**-64, unsigned(top & 2047))
    scale = with_bits(1023 - 62 - zeros << 52)
    scale = -scale if negative != (bits(x) < 0) else scale
    u0, u1 = d0 * scale, d1 * scale
    # times π/2
    h = u0 * _P1
    small = fma(u0, _PI_LOW, fma(u1, _P1, fma(u0, _P1, -h)))
    r = h + small
    y = (h - r) + small
    r += x - x  # nan for infinities and nan
    finish(-quarter if bits(x) < 0 else quarter, r, y, sine, cosine)


def name(lanes: int) -> str:
    """IR name of the function for this number of lanes."""
    return f"@sincos.{lanes}"


@cache
def texts(lanes: int, fused: bool) -> dict[str, str]:
    """IR of ``void sincos(x, ptr s, ptr c)`` for ``double`` (1 lane) or ``<lanes x double>``, and of what it needs.

    Without fused multiply-add (``fused=False``) the whole function is the C library's.
    """
    return parts({name(lanes)[1:]: sincos if fused else sincos_of_library}, lanes)
