"""exp, log, tan, atan, atan2, asin, acos and pow as LLVM IR, for one double or a vector of doubles.

No branch depends on a value, so that all lanes do the same and a lane of eight gives the same bits as a single one.
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
from collections.abc import Sequence

from .sincos import LIMIT, reduced
from .sincos import name as sincos
from .vector_writer import VectorWriter

FUNCTIONS = frozenset({"exp", "log", "tan", "atan", "atan2", "asin", "acos", "pow"})

_hex = float.fromhex
_LN2_HI, _LN2_LO = _hex("0x1.62e42fefa3800p-1"), _hex("0x1.ef35793c76730p-45")  # k _LN2_HI is exact
_LN2, _LN2_REST = _hex("0x1.62e42fefa39efp-1"), _hex("0x1.abc9e3b39803fp-56")
_PIO4, _PIO4_REST = _hex("0x1.921fb54442d18p-1"), _hex("0x1.1a62633145c07p-55")
_THIRD_REST = _hex("0x1.5555555555555p-56")
_LOG2_E = _hex("0x1.71547652b82fep+0")
_ROUND = _hex("0x1.8p52")
_TAN_PI_8 = math.sqrt(2) - 1
_EXP = (
    0.5, 0.1666666666666667, 0.04166666666666667, 0.008333333333325985, 0.0013888888888883642,
    0.00019841269875342141, 2.4801587325920163e-05, 2.7557254740405416e-06, 2.7557273171941026e-07,
    2.5105490906986696e-08, 2.091488256348507e-09,
)  # fmt: skip
_LOG = (
    0.6666666666666666, 0.4000000000000088, 0.28571428570801954, 0.22222222392089008, 0.18181795600060793,
    0.15386241881938595, 0.13268714792348096, 0.1308723619665962,
)  # fmt: skip
_LOG_5 = (
    0.20000000000000012, 0.14285714285669163, 0.11111111135592656, 0.09090904117001572, 0.07692787891410022,
    0.06642962328621099, 0.0645701135847418,
)  # fmt: skip
_ATAN = (
    -0.3333333333333333, 0.19999999999999993, -0.14285714285711498, 0.11111111110752325, -0.09090909066866446,
    0.07692306730961795, -0.06666641908302051, 0.05881923626133301, -0.052580257920073425, 0.04719294405473837,
    -0.04104029750501821, 0.030626287828475894, -0.013908703447288225,
)  # fmt: skip
_ASIN = (
    0.16666666666666666, 0.07500000000000118, 0.044642857142551895, 0.03038194447553234, 0.02237215744350722,
    0.017352816540325496, 0.01396378001220357, 0.011566459612121669, 0.009621842970100282, 0.009319560794767446,
    0.0030448799094556773, 0.019554513336123378, -0.01924167174674304, 0.02961201126495512,
)  # fmt: skip


def name(function: str, lanes: int) -> str:
    """IR name of a function for this number of lanes."""
    return f"@{function}.lanes.{lanes}"


def definition(function: str, lanes: int) -> str:
    """IR of ``T function(T x)`` or ``T function(T x, T y)``."""
    w = VectorWriter(lanes)
    two = function in ("atan2", "pow")
    arguments = f"{w.T} %x, {w.T} %y" if two else f"{w.T} %x"
    result = {
        "exp": lambda: _exp(w, "%x", None),
        "log": lambda: _log(w, "%x"),
        "tan": lambda: _tan(w, "%x"),
        "atan": lambda: _atan2(w, "%x", w.number(1.0)),
        "atan2": lambda: _atan2(w, "%x", "%y"),
        "asin": lambda: _asin(w, "%x"),
        "acos": lambda: _acos(w, "%x"),
        "pow": lambda: _pow(w, "%x", "%y"),
    }[function]()
    head = f"define internal {w.T} {name(function, lanes)}({arguments}) nounwind noinline {{"
    return "\n".join([head, "entry:", *w.lines, f"  ret {w.T} {result}", "}", ""])


def declarations(function: str, lanes: int) -> list[str]:
    """Declarations of the functions that the definition calls."""
    T, suffix = ("double", "f64") if lanes == 1 else (f"<{lanes} x double>", f"v{lanes}f64")
    result = [
        f"declare {T} @llvm.fma.{suffix}({T}, {T}, {T})",
        f"declare {T} @llvm.fabs.{suffix}({T})",
        f"declare {T} @llvm.sqrt.{suffix}({T})",
        f"declare {T} @llvm.copysign.{suffix}({T}, {T})",
    ]
    return [*result, "declare double @pow(double, double)"] if function == "pow" else result


def _exp(w: VectorWriter, x: str, rest: str | None) -> str:
    """exp(x + rest) for a rest far below x. Beyond ±800 the result overflows or vanishes anyway."""
    for how, limit in (("ogt", 800.0), ("olt", -800.0)):
        x = w.choose(w.compare(how, x, w.number(limit)), w.number(limit), x)
    shifted = w.fma(x, w.number(_LOG2_E), w.number(_ROUND))
    n = w.sub(shifted, w.number(_ROUND))
    m = w.neg(n)
    high = w.fma(m, w.number(_LN2_HI), x)  # exact
    low = w.mul(m, w.number(_LN2_LO))
    if rest is not None:
        low = w.add(low, rest)
    r = w.add(high, low)
    error = w.add(w.sub(high, r), low)  # of r: |high| ≥ |low| or high = 0
    z = w.mul(r, r)
    E = w.polynomial(_EXP, r, z)
    tail = w.fma(z, E, error)
    value = w.add(w.number(1.0), w.add(r, tail))
    # 2^n in two factors, since n may leave the range of exponents
    integer = w.whole("sub", w.bits(shifted), w.bits(w.number(_ROUND)))
    half = w.whole("ashr", integer, w.integer(1))
    for part in (half, w.whole("sub", integer, half)):
        biased = w.whole("add", part, w.integer(1023))
        value = w.mul(value, w.double(w.whole("shl", biased, w.integer(52))))
    return value


def _split(w: VectorWriter, x: str) -> tuple[str, str]:
    """(k, m) with x = m 2^k and m in [√½, √2), for finite x > 0."""
    tiny = w.compare("olt", x, w.number(2.0**-1000))
    x = w.choose(tiny, w.mul(x, w.number(2.0**54)), x)
    bits = w.bits(x)
    # √½ has the bits 0x3FE6A09E...: subtracting them leaves k in the exponent
    shifted = w.whole("sub", bits, w.integer(0x3FE6A09E667F3BCD))
    k = w.whole("ashr", shifted, w.integer(52))
    m = w.double(w.whole("sub", bits, w.whole("shl", k, w.integer(52))))
    count = w.emit(f"sitofp {w.J} {k} to {w.T}")
    return w.choose(tiny, w.sub(count, w.number(54.0)), count), m


def _log(w: VectorWriter, x: str) -> str:
    k, m = _split(w, x)
    f = w.sub(m, w.number(1.0))
    s = w.div(f, w.add(w.number(2.0), f))
    z = w.mul(s, s)
    L = w.mul(z, w.polynomial(_LOG, z, w.mul(z, z)))
    half = w.mul(w.mul(w.number(0.5), f), f)
    inner = w.fma(s, w.add(half, L), w.mul(k, w.number(_LN2_LO)))
    value = w.fma(k, w.number(_LN2_HI), w.sub(f, w.sub(half, inner)))
    value = w.choose(w.compare("oeq", x, w.number(0.0)), w.number(-math.inf), value)
    value = w.choose(w.compare("olt", x, w.number(0.0)), w.number(math.nan), value)
    # infinity and NaN stay
    return w.choose(w.compare("ult", x, w.number(math.inf)), w.choose(w.compare("uno", x, x), x, value), x)


def _atan2(w: VectorWriter, y: str, x: str) -> str:
    ay, ax = w.size(y), w.size(x)
    steep = w.compare("ogt", ay, ax)
    small, large = w.choose(steep, ax, ay), w.choose(steep, ay, ax)
    # infinity over infinity counts as 1, 0 over 0 as 0, and their sum must not overflow
    infinite = w.compare("oeq", large, w.number(math.inf))
    both = w.choose(w.compare("oeq", small, w.number(math.inf)), w.number(1.0), w.number(0.0))
    small, large = w.choose(infinite, both, small), w.choose(infinite, w.number(1.0), large)
    large = w.choose(w.compare("oeq", large, w.number(0.0)), w.number(1.0), large)
    scale = w.choose(w.compare("ogt", large, w.number(2.0**1000)), w.number(2.0**-10), w.number(1.0))
    small, large = w.mul(small, scale), w.mul(large, scale)
    wide = w.compare("ogt", small, w.mul(large, w.number(_TAN_PI_8)))
    over = w.choose(wide, w.sub(small, large), small)
    under = w.choose(wide, w.add(small, large), large)
    t = w.div(over, under)
    z = w.mul(t, t)
    A = w.polynomial(_ATAN, z, w.mul(z, z))
    angle = w.mul(w.mul(t, z), A)  # atan t = t + angle
    # j π/4 + sign (t + angle): first about the diagonal, then about the axes
    j = w.choose(wide, w.number(1.0), w.number(0.0))
    sign = w.number(1.0)
    j, sign = w.choose(steep, w.sub(w.number(2.0), j), j), w.choose(steep, w.number(-1.0), sign)
    negative = w.emit(f"icmp slt {w.J} {w.bits(x)}, {w.integer(0)}")
    j, sign = w.choose(negative, w.sub(w.number(4.0), j), j), w.choose(negative, w.neg(sign), sign)
    base = w.mul(j, w.number(_PIO4))
    error = w.fma(j, w.number(_PIO4), w.neg(base))
    error = w.fma(j, w.number(_PIO4_REST), error)
    # base is 0 or above |t|; the rounding error of base ± t goes to the small terms
    total, lost = w.two_sum(base, w.mul(sign, t))
    value = w.add(total, w.add(w.fma(sign, angle, error), lost))
    value = w.choose(w.compare("oeq", j, w.number(0.0)), w.add(t, angle), value)
    value = w.signed(value, y)
    return w.choose(w.compare("uno", x, y), w.number(math.nan), value)


def _arc(w: VectorWriter, x: str) -> tuple[str, str, str, str]:
    """(|x| ≤ ½, s, p, |x|), where s is |x| or √((1 - |x|)/2) and s + p is asin s."""
    size = w.size(x)
    inside = w.compare("ole", size, w.number(0.5))
    t = w.mul(w.sub(w.number(1.0), size), w.number(0.5))
    root = w.sqrt(t)
    error = w.div(w.fma(w.neg(root), root, t), w.add(root, root))
    error = w.choose(w.compare("oeq", root, w.number(0.0)), w.number(0.0), error)
    z = w.choose(inside, w.mul(size, size), t)
    s = w.choose(inside, size, root)
    S = w.polynomial(_ASIN, z, w.mul(z, z))
    p = w.mul(w.mul(s, z), S)
    return inside, s, w.choose(inside, p, w.add(p, error)), size


def _asin(w: VectorWriter, x: str) -> str:
    inside, s, p, _ = _arc(w, x)
    double = w.mul(w.number(-2.0), s)
    high, lost = w.two_sum(w.number(2 * _PIO4), double)
    low = w.fma(w.number(-2.0), p, w.add(w.number(2 * _PIO4_REST), lost))
    value = w.choose(inside, w.add(s, p), w.add(high, low))
    return w.signed(value, x)


def _acos(w: VectorWriter, x: str) -> str:
    inside, s, p, _ = _arc(w, x)
    negative = w.compare("olt", x, w.number(0.0))
    s_x, p_x = w.signed(s, x), w.choose(negative, w.neg(p), p)
    high, lost = w.two_sum(w.number(2 * _PIO4), w.neg(s_x))
    middle = w.add(high, w.add(w.sub(w.number(2 * _PIO4_REST), p_x), lost))
    right = w.mul(w.number(2.0), w.add(s, p))
    high, lost = w.two_sum(w.number(4 * _PIO4), w.mul(w.number(-2.0), s))
    far = w.add(high, w.fma(w.number(-2.0), p, w.add(w.number(4 * _PIO4_REST), lost)))
    return w.choose(inside, middle, w.choose(negative, far, right))


def _pow(w: VectorWriter, x: str, y: str) -> str:
    k, m = _split(w, x)
    # log m = 2 s (1 + s² (⅓ + s² Q)) in two doubles,  s = f / (2 + f)
    f = w.sub(m, w.number(1.0))
    under = w.add(w.number(1.0), m)
    under_error = w.sub(m, w.sub(under, w.number(1.0)))
    s = w.div(f, under)
    remainder = w.fma(w.neg(s), under_error, w.fma(w.neg(s), under, f))
    S = (s, w.div(remainder, under))
    z = w.product(S, S)
    Q = w.polynomial(_LOG_5, z[0], w.mul(z[0], z[0]))
    third = w.two_sum(w.number(1 / 3), w.mul(z[0], Q))
    third = (third[0], w.add(third[1], w.number(_THIRD_REST)))
    series = w.product(w.product(z, third), S)
    h, low = w.two_sum(S[0], series[0])
    low = w.add(w.add(low, series[1]), S[1])
    h, low = w.mul(w.number(2.0), h), w.mul(w.number(2.0), low)
    # + k ln 2
    base = w.mul(k, w.number(_LN2_HI))  # exact, and 0 or above h
    H, lost = w.two_sum(base, h)
    zero = w.compare("oeq", k, w.number(0.0))
    H, lost = w.choose(zero, h, H), w.choose(zero, w.number(0.0), lost)
    low = w.add(w.fma(k, w.number(_LN2_LO), lost), low)
    L = w.two_sum(H, low)
    P, rest = w.two_product(y, L[0])
    rest = w.fma(y, L[1], rest)
    fast = _exp(w, P, rest)
    plain = w.compare("olt", w.size(P), w.number(700.0))
    for good in (w.compare("ogt", x, w.number(0.0)), w.compare("olt", x, w.number(math.inf))):
        plain = w.emit(f"and {w.B} {plain}, {good}")
    good = w.compare("ogt", w.size(y), w.number(2.0**-500))
    plain = w.emit(f"and {w.B} {plain}, {good}")
    return _unless(w, plain, fast, "pow", (x, y))


def _tan(w: VectorWriter, x: str) -> str:
    inside = w.compare("ole", w.size(x), w.number(LIMIT))
    bits, sine, cosine = reduced(w, x)
    odd = w.emit(f"icmp ne {w.J} {w.whole('and', bits, w.integer(1))}, {w.integer(0)}")
    over = [w.choose(odd, w.neg(c), s) for s, c in zip(sine, cosine, strict=True)]
    under = [w.choose(odd, s, c) for s, c in zip(sine, cosine, strict=True)]
    q = w.div(over[0], under[0])
    remainder = w.fma(w.neg(q), under[0], over[0])
    remainder = w.add(remainder, w.fma(w.neg(q), under[1], over[1]))
    return _unless(w, inside, w.add(q, w.div(remainder, under[0])), "tan.huge", (x,))


HUGE_TAN = f"""define internal double @tan.huge(double %x) nounwind noinline {{
  %s = alloca double, align 8
  %c = alloca double, align 8
  call void {sincos(1)}(double %x, ptr %s, ptr %c)
  %sine = load double, ptr %s, align 8
  %cosine = load double, ptr %c, align 8
  %tan = fdiv double %sine, %cosine
  ret double %tan
}}
"""
"""Tangent of an argument beyond `sincos.LIMIT`: three roundings, two of them below one unit."""


def _unless(w: VectorWriter, plain: str, fast: str, function: str, arguments: Sequence[str]) -> str:
    """``fast`` in the lanes where ``plain`` holds; another function, usually the C library's, in the others."""
    if w.lanes == 1:
        every = plain
    else:
        mask = w.emit(f"bitcast {w.B} {plain} to i{w.lanes}")
        every = w.emit(f"icmp eq i{w.lanes} {mask}, -1")
    w.lines += [f"  br i1 {every}, label %done, label %library", "library:"]
    if w.lanes == 1:
        slow = w.emit(f"call double @{function}({', '.join(f'double {a}' for a in arguments)})")
    else:
        slow = "poison"
        for i in range(w.lanes):
            scalars = [w.emit(f"extractelement {w.T} {a}, i32 {i}") for a in arguments]
            value = w.emit(f"call double @{function}({', '.join(f'double {a}' for a in scalars)})")
            slow = w.emit(f"insertelement {w.T} {slow}, double {value}, i32 {i}")
    mixed = w.choose(plain, fast, slow)
    w.lines += ["  br label %done", "done:"]
    return w.emit(f"phi {w.T} [{fast}, %entry], [{mixed}, %library]")
