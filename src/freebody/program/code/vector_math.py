"""exp, log, tan, atan, atan2, asin, acos and pow for one number or one in each lane.

No branch depends on a value, so that all lanes do the same.
There are two exceptions, which are computed lane by lane. pow uses the C library for a base that is not positive and
finite and for results next to overflow. tan uses sine and cosine beyond
:data:`freebody.program.code.sincos.LIMIT`.

    exp     x = n ln 2 + r,         2^n (1 + r + r² E(r)),                                  |r| ≤ ½ ln 2
    log     x = 2^k (1 + f),        k ln 2 + f - (f²/2 - s (f²/2 + s² L(s²))),              s = f / (2 + f)
    atan2   z = min/max or (min - max)/(min + max),     j π/4 ± (z + z³ A(z²)),             |z| ≤ tan π/8
    asin    x + x³ S(x²) for |x| ≤ ½, else π/2 - 2 asin √((1 - |x|)/2) with the square root's own error put back
    tan     sine / cosine of the argument less n π/2, each as the sum of two doubles
    pow     exp(y log x), log x in two doubles (relative error below 2^-63)

The polynomials interpolate at Chebyshev points. All errors are below two units in the last place (measured in
tests/unit/program/code/test_vector_math.py). Without a fused multiply-add the C library's functions are used instead.

Sources: W. J. Cody and W. Waite, Software Manual for the Elementary Functions (1980); Muller et al., Handbook of
Floating-Point Arithmetic (2018), ch. 4 (double-double arithmetic), ch. 10.
"""

from __future__ import annotations

import math
from functools import cache

from ...native.functions import each, rare
from ...native.instructions import (
    Real,
    Truth,
    bits,
    compiled,
    fma,
    inlined,
    library,
    polynomial,
    room,
    root,
    shifted,
    where,
    with_bits,
)
from ...native.translation import parts
from .sincos import LIMIT, reduced, sincos, sine_and_cosine

_hex = float.fromhex
_LN2_HI, _LN2_LO = _hex("0x1.62e42fefa3800p-1"), _hex("0x1.ef35793c76730p-45")  # k _LN2_HI is exact
_PIO4, _PIO4_REST = _hex("0x1.921fb54442d18p-1"), _hex("0x1.1a62633145c07p-55")
_THIRD_REST = _hex("0x1.5555555555555p-56")
_LOG2_E = _hex("0x1.71547652b82fep+0")
_ROUND, _BITS_OF_ROUND = _hex("0x1.8p52"), 0x4338 << 48
_BITS_OF_ROOT_HALF = 0x3FE6A09E667F3BCD  # subtracting it leaves k in the exponent
_TAN_PI_8 = math.sqrt(2) - 1
_INFINITE, _NONE = math.inf, math.nan
_EXP = polynomial((
    0.5, 0.1666666666666667, 0.04166666666666667, 0.008333333333325985, 0.0013888888888883642,
    0.00019841269875342141, 2.4801587325920163e-05, 2.7557254740405416e-06, 2.7557273171941026e-07,
    2.5105490906986696e-08, 2.091488256348507e-09,
))  # fmt: skip
_LOG = polynomial((
    0.6666666666666666, 0.4000000000000088, 0.28571428570801954, 0.22222222392089008, 0.18181795600060793,
    0.15386241881938595, 0.13268714792348096, 0.1308723619665962,
))  # fmt: skip
_LOG_5 = polynomial((
    0.20000000000000012, 0.14285714285669163, 0.11111111135592656, 0.09090904117001572, 0.07692787891410022,
    0.06642962328621099, 0.0645701135847418,
))  # fmt: skip
_ATAN = polynomial((
    -0.3333333333333333, 0.19999999999999993, -0.14285714285711498, 0.11111111110752325, -0.09090909066866446,
    0.07692306730961795, -0.06666641908302051, 0.05881923626133301, -0.052580257920073425, 0.04719294405473837,
    -0.04104029750501821, 0.030626287828475894, -0.013908703447288225,
))  # fmt: skip
_ASIN = polynomial((
    0.16666666666666666, 0.07500000000000118, 0.044642857142551895, 0.03038194447553234, 0.02237215744350722,
    0.017352816540325496, 0.01396378001220357, 0.011566459612121669, 0.009621842970100282, 0.009319560794767446,
    0.0030448799094556773, 0.019554513336123378, -0.01924167174674304, 0.02961201126495512,
))  # fmt: skip
_pow_of_library = library("pow", 2)


# -- pairs: the sum of two numbers, the second far below the first -----------------------------------------------


@inlined
def two_sum(a: Real, b: Real) -> tuple[Real, Real]:
    """a + b for |a| ≥ |b|, with its rounding error (Dekker)."""
    s = a + b
    return s, b - (s - a)


@inlined
def two_product(a: Real, b: Real) -> tuple[Real, Real]:
    """a b with its rounding error."""
    p = a * b
    return p, fma(a, b, -p)


@inlined
def product(a: Real, a_rest: Real, b: Real, b_rest: Real) -> tuple[Real, Real]:
    """Product of two pairs."""
    h, low = two_product(a, b)
    low = fma(a, b_rest, low)
    low = fma(a_rest, b, low)
    h, low = two_sum(h, low)
    return h, low


# -- exp, log ----------------------------------------------------------------------------------------------------


@inlined
def in_octaves(x: Real) -> tuple[Real, Real, Real]:
    """(n in its low bits, high, low) with x = n ln 2 + high + low. Beyond ±800, exp overflows or vanishes anyway."""
    x = where(x > 800.0, 800.0, x)
    x = where(x < -800.0, -800.0, x)
    near = fma(x, _LOG2_E, _ROUND)
    n = near - _ROUND
    return near, fma(-n, _LN2_HI, x), -n * _LN2_LO  # high is exact


@inlined
def raised(near: Real, high: Real, low: Real) -> Real:
    """2^n exp(high + low)."""
    r = high + low
    error = (high - r) + low  # of r: |high| ≥ |low| or high = 0
    z = r * r
    value = 1.0 + (r + fma(z, _EXP(r, z), error))
    # 2^n in two factors, since n may leave the range of exponents
    n = bits(near) - _BITS_OF_ROUND
    half = n >> 1
    value = value * with_bits((half + 1023) << 52)
    return value * with_bits(((n - half) + 1023) << 52)


@compiled
def exp(x: Real) -> Real:
    """Exponential function."""
    near, high, low = in_octaves(x)
    return raised(near, high, low)


@inlined
def split(x: Real) -> tuple[Real, Real]:
    """(k, m) with x = m 2^k and m in [√½, √2), for finite x > 0."""
    tiny = x < 2.0**-1000
    word = bits(where(tiny, x * 2.0**54, x))
    k = (word - _BITS_OF_ROOT_HALF) >> 52
    return where(tiny, k - 54.0, k), with_bits(word - (k << 52))


@compiled
def log(x: Real) -> Real:
    """Natural logarithm."""
    k, m = split(x)
    f = m - 1.0
    s = f / (2.0 + f)
    z = s * s
    L = z * _LOG(z, z * z)
    half = 0.5 * f * f
    inner = fma(s, half + L, k * _LN2_LO)
    value = fma(k, _LN2_HI, f - (half - inner))
    value = where(x == 0.0, -_INFINITE, value)
    value = where(x < 0.0, _NONE, value)
    return where(x < _INFINITE, value, x)  # infinity and nan stay


# -- inverse functions of angles ---------------------------------------------------------------------------------


@inlined
def angle(y: Real, x: Real) -> Real:
    """Angle of the point (x, y)."""
    ay, ax = abs(y), abs(x)
    steep = ay > ax
    small, large = where(steep, ax, ay), where(steep, ay, ax)
    # infinity over infinity counts as 1, 0 over 0 as 0, and their sum must not overflow
    infinite = large == _INFINITE
    small = where(infinite, where(small == _INFINITE, 1.0, 0.0), small)
    large = where(infinite, 1.0, large)
    large = where(large == 0.0, 1.0, large)
    scale = where(large > 2.0**1000, 2.0**-10, 1.0)
    small, large = small * scale, large * scale
    wide = small > large * _TAN_PI_8
    t = where(wide, small - large, small) / where(wide, small + large, large)
    z = t * t
    more = t * z * _ATAN(z, z * z)  # atan t = t + more
    # j π/4 + sign (t + more): first about the diagonal, then about the axes
    j, sign = where(wide, 1.0, 0.0), where(steep, -1.0, 1.0)
    j = where(steep, 2.0 - j, j)
    behind = bits(x) < 0
    j, sign = where(behind, 4.0 - j, j), where(behind, -sign, sign)
    base = j * _PIO4
    error = fma(j, _PIO4_REST, fma(j, _PIO4, -base))
    # base is 0 or above |t|; the rounding error of base ± t goes to the small terms
    total, lost = two_sum(base, sign * t)
    value = total + (fma(sign, more, error) + lost)
    value = math.copysign(where(j == 0.0, t + more, value), y)
    return where((x != x) | (y != y), _NONE, value)


@compiled
def atan2(y: Real, x: Real) -> Real:
    """Angle of the point (x, y)."""
    return angle(y, x)


@compiled
def atan(x: Real) -> Real:
    """Inverse of the tangent."""
    return angle(x, 1.0)


@inlined
def arc(x: Real) -> tuple[Truth, Real, Real]:
    """(|x| ≤ ½, s, p), where s is |x| or √((1 - |x|)/2) and s + p is asin s."""
    size = abs(x)
    inside = size <= 0.5
    t = (1.0 - size) * 0.5
    side = root(t)
    error = where(side == 0.0, 0.0, fma(-side, side, t) / (side + side))
    z = where(inside, size * size, t)
    s = where(inside, size, side)
    p = s * z * _ASIN(z, z * z)
    return inside, s, where(inside, p, p + error)


@compiled
def asin(x: Real) -> Real:
    """Inverse of the sine."""
    inside, s, p = arc(x)
    high, lost = two_sum(2.0 * _PIO4, -2.0 * s)
    low = fma(-2.0, p, 2.0 * _PIO4_REST + lost)
    return math.copysign(where(inside, s + p, high + low), x)


@compiled
def acos(x: Real) -> Real:
    """Inverse of the cosine."""
    inside, s, p = arc(x)
    negative = x < 0.0
    high, lost = two_sum(2.0 * _PIO4, -math.copysign(s, x))
    middle = high + ((2.0 * _PIO4_REST - where(negative, -p, p)) + lost)
    right = 2.0 * (s + p)
    high, lost = two_sum(4.0 * _PIO4, -2.0 * s)
    far = high + fma(-2.0, p, 4.0 * _PIO4_REST + lost)
    return where(inside, middle, where(negative, far, right))


# -- pow, tan ----------------------------------------------------------------------------------------------------


@compiled
def pow(x: Real, y: Real) -> Real:
    """x to the power y."""
    k, m = split(x)
    # log m = 2 s (1 + s² (⅓ + s² Q)) in two numbers,  s = f / (2 + f)
    f, under = m - 1.0, 1.0 + m
    under_rest = m - (under - 1.0)
    s = f / under
    s_rest = fma(-s, under_rest, fma(-s, under, f)) / under
    z, z_rest = product(s, s_rest, s, s_rest)
    third, third_rest = two_sum(1.0 / 3.0, z * _LOG_5(z, z * z))
    series, series_rest = product(z, z_rest, third, third_rest + _THIRD_REST)
    series, series_rest = product(series, series_rest, s, s_rest)
    h, low = two_sum(s, series)
    h, low = 2.0 * h, 2.0 * ((low + series_rest) + s_rest)
    # + k ln 2
    H, lost = two_sum(k * _LN2_HI, h)  # the product is exact, and 0 or above h
    H, lost = where(k == 0.0, h, H), where(k == 0.0, 0.0, lost)
    L, L_rest = two_sum(H, fma(k, _LN2_LO, lost) + low)
    P, rest = two_product(y, L)
    near, high, low = in_octaves(P)
    result = raised(near, high, low + fma(y, L_rest, rest))
    plain = (abs(P) < 700.0) & (x > 0.0) & (x < _INFINITE) & (abs(y) > 2.0**-500)
    if rare(not all(plain)):
        for lane in each(not plain):
            result[lane] = _pow_of_library(x[lane], y[lane])
    return result


@compiled
def tan(x: Real) -> Real:
    """Tangent."""
    n, r, y = reduced(x)
    s, s_rest, c, c_rest = sine_and_cosine(r, y)
    s, s_rest = two_sum(s, s_rest)
    c, c_rest = two_sum(c, c_rest)
    odd = (n & 1) != 0
    over, over_rest = where(odd, -c, s), where(odd, -c_rest, s_rest)
    under, under_rest = where(odd, s, c), where(odd, s_rest, c_rest)
    q = over / under
    remainder = fma(-q, under, over) + fma(-q, under_rest, over_rest)
    result = q + remainder / under
    small = abs(x) <= LIMIT
    if rare(not all(small)):
        for lane in each(not small):
            result[lane] = huge_tan(x[lane])
    return result


@compiled
def huge_tan(x: float) -> float:
    """Tangent of a number beyond `sincos.LIMIT`: three roundings, two of them below one unit."""
    memory = room(2)
    sincos(x, memory, shifted(memory, 1))
    return memory[0] / memory[1]


FUNCTIONS = {
    "exp": exp, "log": log, "tan": tan, "atan": atan, "atan2": atan2, "asin": asin, "acos": acos, "pow": pow,
}  # fmt: skip


def name(function: str, lanes: int) -> str:
    """IR name of a function for this number of lanes."""
    return f"@{function}.lanes.{lanes}"


@cache
def texts(function: str, lanes: int) -> dict[str, str]:
    """IR of ``T function(T x)`` or ``T function(T x, T y)``, and of what it needs."""
    return parts({name(function, lanes)[1:]: FUNCTIONS[function]}, lanes)
