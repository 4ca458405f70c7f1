"""Sine and cosine together, as LLVM IR, for one double or a vector of doubles.

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

from ...native.ir_text import literal
from .vector_writer import VectorWriter

LIMIT = 5e5
"""Largest argument of the short reduction: 2 x / π must stay below 2^19."""

_hex = float.fromhex
_P1, _P2, _P3 = _hex("0x1.921fb54442d18p0"), _hex("0x1.1a62633100000p-54"), _hex("0x1.1701b839a2520p-88")
_TWO_OVER_PI = _hex("0x1.45f306dc9c883p-1")
_PI_LOW = _hex("0x1.1a62633145c07p-54")  # π/2 - P1
_DIGITS = (
    0xA2F9836E4E441529, 0xFC2757D1F534DDC0, 0xDB6295993C439041, 0xFE5163ABDEBBC561, 0xB7246E3A424DD2E0,
    0x06492EEA09D1921C, 0xFE1DEB1CB129A73E, 0xE88235F52EBB4484, 0xE99C7026B45F7E41, 0x3991D639835339F4,
    0x9C845F8BBDF9283B, 0x1FF897FFDE05980F, 0xEF2F118B5A0A6D1F, 0x6D367ECF27CB09B7, 0x4F463F669E5FEA2D,
    0x7527BAC7EBE5F17B, 0x3D0739F78A5292EA, 0x6BFB5FB11F8D5D08, 0x56033046FC7B6BAB, 0xF0CFBC209AF4361D,
)  # fmt: skip
"""2/π in words of 64 bits after the point."""
_ROUND = _hex("0x1.8p52")  # adding it leaves the nearest integer in the low bits
_SIN = (
    -0.16666666666666632, 0.008333333333322413, -0.00019841269829807805,
    2.755731369191626e-06, -2.505075811491489e-08, 1.589679563029853e-10,
)  # fmt: skip
_COS = (
    0.0416666666666666, -0.0013888888888874125, 2.4801587289482188e-05,
    -2.7557314352334094e-07, 2.0875723273401634e-09, -1.1359647811748212e-11,
)  # fmt: skip


def name(lanes: int) -> str:
    """IR name of the function for this number of lanes."""
    return f"@sincos.{lanes}"


def definition(lanes: int, fused: bool) -> str:
    """IR of ``void sincos(x, ptr s, ptr c)`` for ``double`` (1 lane) or ``<lanes x double>``.

    Without fused multiply-add (``fused=False``) the whole function is the C library's.
    """
    w = VectorWriter(lanes)
    head = (
        f"define internal void {name(lanes)}({w.T} %x, ptr noalias %s, ptr noalias %c) nounwind noinline {{\n"
    )
    if not fused:
        return head + _library(lanes, w.T) + "}\n"
    size = w.size("%x")
    large = w.compare("ugt", size, w.number(LIMIT))
    if lanes == 1:
        w.lines += [f"  br i1 {large}, label %huge, label %reduce, !prof !0", *_huge(size), "reduce:"]
    bits, r, y = _reduced(w, "%x")
    if lanes == 1:
        w.lines += ["  br label %both", "both:"]
        r, y = (
            w.emit(f"phi double [{near}, %reduce], [%huge.{x}, %huge]") for near, x in ((r, "r"), (y, "y"))
        )
        bits = w.emit(f"phi i64 [{bits}, %reduce], [%huge.bits, %huge]")
    (sine, cosine) = (w.add(*parts) for parts in _sine_and_cosine(w, r, y))
    # the quadrant: swap when n is odd, signs from its second bit
    swap = w.emit(f"icmp ne {w.J} {w.whole('and', bits, w.integer(1))}, {w.integer(0)}")
    following = w.whole("add", bits, w.integer(1))
    for target, quadrant, odd, even in (("s", bits, cosine, sine), ("c", following, sine, cosine)):
        value = w.bits(w.choose(swap, odd, even))
        sign = w.whole("shl", w.whole("and", quadrant, w.integer(2)), w.integer(62))
        w.lines.append(f"  store {w.T} {w.double(w.whole('xor', value, sign))}, ptr %{target}, align 8")
    if lanes == 1:
        return "\n".join([_table(), head + "entry:", *w.lines, "  ret void"]) + "\n}\n"
    mask = w.emit(f"bitcast {w.B} {large} to i{lanes}")
    some = w.emit(f"icmp ne i{lanes} {mask}, 0")
    w.lines += [f"  br i1 {some}, label %alone, label %done, !prof !0", "alone:"]
    for i in range(lanes):  # the lanes beside a large one keep the bits that they have alone
        is_large = w.emit(f"extractelement {w.B} {large}, i32 {i}")
        w.lines += [f"  br i1 {is_large}, label %call{i}, label %next{i}", f"call{i}:"]
        x = w.emit(f"extractelement {w.T} %x, i32 {i}")
        s, c = (w.emit(f"getelementptr double, ptr %{target}, i64 {i}") for target in "sc")
        w.lines.append(f"  call void {name(1)}(double {x}, ptr {s}, ptr {c})")
        w.lines += [f"  br label %next{i}", f"next{i}:"]
    return "\n".join([head + "entry:", *w.lines, "  br label %done", "done:", "  ret void"]) + "\n}\n"


def reduced(w: VectorWriter, x: str) -> tuple[str, tuple[str, str], tuple[str, str]]:
    """(n in its low bits, sin r, cos r) with x = n π/2 + r, for |x| below :data:`LIMIT`.

    Sine and cosine are sums of two doubles.
    """
    bits, r, y = _reduced(w, x)
    sine, cosine = (w.two_sum(*parts) for parts in _sine_and_cosine(w, r, y))
    return bits, sine, cosine


def _reduced(w: VectorWriter, x: str) -> tuple[str, str, str]:
    """(n in its low bits, r, y) with x = n π/2 + r + y."""
    shifted = w.fma(x, w.number(_TWO_OVER_PI), w.number(_ROUND))
    n = w.sub(shifted, w.number(_ROUND))
    m = w.neg(n)
    r0 = w.fma(m, w.number(_P1), x)
    p = w.mul(n, w.number(_P2))
    r = w.sub(r0, p)
    y = w.fma(m, w.number(_P3), w.sub(w.sub(r0, r), p))
    return w.bits(shifted), r, y


def _sine_and_cosine(w: VectorWriter, r: str, y: str) -> tuple[tuple[str, str], tuple[str, str]]:
    """Sine and cosine of r + y, each as a large and a small term."""
    z = w.mul(r, r)
    zz = w.mul(z, z)
    # sin(r + y) = r + (r³ S + y (1 - z/2)),  cos(r + y) = W + (((1 - W) - z/2) + (z² C - r y)),  W = 1 - z/2
    h = w.mul(z, w.number(0.5))
    W = w.sub(w.number(1.0), h)
    sine = w.fma(w.mul(r, z), w.polynomial(_SIN, z, zz), w.mul(y, W))
    rest = w.fma(w.neg(r), y, w.sub(w.sub(w.number(1.0), W), h))
    cosine = w.fma(zz, w.polynomial(_COS, z, zz), rest)
    return (r, sine), (W, cosine)


def _table() -> str:
    """Table of the digits, after a word of zeros: E + 62 is the place of the first bit that is read."""
    words = ", ".join(f"i64 {word}" for word in (0, *_DIGITS))
    return f"@two.over.pi = private constant [{1 + len(_DIGITS)} x i64] [{words}]"


def _huge(size: str) -> list[str]:
    """Block that reduces a huge %x, whose |x| is ``size``, to %huge.r, %huge.y and the quadrant in %huge.bits."""
    lines = ["huge:"]

    def emit(target: str, operation: str) -> None:
        lines.append(f"  %{target} = {operation}")

    def fma(target: str, a: str, b: str, c: str) -> None:
        emit(target, f"call double @llvm.fma.f64(double {a}, double {b}, double {c})")

    emit("word", f"bitcast double {size} to i64")
    emit("exponent", "lshr i64 %word, 52")
    emit("fraction", f"and i64 %word, {(1 << 52) - 1}")
    emit("M", f"or i64 %fraction, {1 << 52}")
    emit("MM", "zext i64 %M to i128")
    emit("place", f"add i64 %exponent, {62 - 1075}")
    emit("first", "lshr i64 %place, 6")
    emit("shift", "and i64 %place, 63")
    for j in range(4):
        emit(f"k{j}", f"add i64 %first, {j}")
        emit(f"at{j}", f"getelementptr i64, ptr @two.over.pi, i64 %k{j}")
        emit(f"digits{j}", f"load i64, ptr %at{j}, align 8")
    for j in range(3):
        emit(f"W{j}", f"call i64 @llvm.fshl.i64(i64 %digits{j}, i64 %digits{j + 1}, i64 %shift)")
    for j in (1, 2):
        emit(f"W{j}w", f"zext i64 %W{j} to i128")
        emit(f"P{j}", f"mul i128 %MM, %W{j}w")
    emit("carry2", "lshr i128 %P2, 64")
    emit("P1c", "add i128 %P1, %carry2")
    emit("carry1", "lshr i128 %P1c, 64")
    emit("carried", "trunc i128 %carry1 to i64")
    emit("P0", "mul i64 %M, %W0")
    emit("upper", "add i64 %P0, %carried")
    # the nearest quarter, and the remainder H 2^-126
    emit("half", f"add i64 %upper, {1 << 61}")
    emit("quarter", "lshr i64 %half, 62")
    emit("whole", "shl i64 %quarter, 62")
    emit("left", "sub i64 %upper, %whole")
    emit("leftw", "zext i64 %left to i128")
    emit("leftu", "shl i128 %leftw, 64")
    emit("lower", f"and i128 %P1c, {(1 << 64) - 1}")
    emit("H", "or i128 %leftu, %lower")
    emit("below", "icmp slt i64 %left, 0")
    emit("minus.H", "sub i128 0, %H")
    emit("A", "select i1 %below, i128 %minus.H, i128 %H")
    # |H| as the sum of two doubles
    emit("zeros", "call i128 @llvm.ctlz.i128(i128 %A, i1 false)")
    emit("B", "shl i128 %A, %zeros")
    emit("Bu", "lshr i128 %B, 64")
    emit("top", "trunc i128 %Bu to i64")
    emit("bottom", "trunc i128 %B to i64")
    emit("topu", "and i64 %top, -2048")
    emit("topl", "and i64 %top, 2047")
    for target, source in (("d0", "topu"), ("dl", "topl"), ("db", "bottom")):
        emit(target, f"uitofp i64 %{source} to double")
    fma("d1", "%db", literal(2.0**-64), "%dl")
    emit("zeros64", "trunc i128 %zeros to i64")
    emit("power", f"sub i64 {1023 - 62}, %zeros64")
    emit("powerb", "shl i64 %power, 52")
    emit("scale", "bitcast i64 %powerb to double")
    emit("bits.x", "bitcast double %x to i64")
    emit("negative", "icmp slt i64 %bits.x, 0")
    emit("turned", "xor i1 %below, %negative")
    emit("minus.scale", "fneg double %scale")
    emit("scaled", "select i1 %turned, double %minus.scale, double %scale")
    emit("u0", "fmul double %d0, %scaled")
    emit("u1", "fmul double %d1, %scaled")
    # times π/2
    emit("h0", f"fmul double %u0, {literal(_P1)}")
    emit("minus.h0", "fneg double %h0")
    fma("h1", "%u0", literal(_P1), "%minus.h0")
    fma("h2", "%u1", literal(_P1), "%h1")
    fma("h3", "%u0", literal(_PI_LOW), "%h2")
    emit("h4", "fadd double %h0, %h3")
    emit("h5", "fsub double %h0, %h4")
    emit("huge.y", "fadd double %h5, %h3")
    emit("none", "fsub double %x, %x")  # NaN for infinities and NaN
    emit("huge.r", "fadd double %h4, %none")
    emit("minus.quarter", "sub i64 0, %quarter")
    emit("huge.bits", "select i1 %negative, i64 %minus.quarter, i64 %quarter")
    return [*lines, "  br label %both"]


def _library(lanes: int, T: str) -> str:
    """IR of the calls of the C library for each lane."""
    lines = []
    for i in range(lanes):
        x = "%x"
        if lanes > 1:
            x = f"%x{i}"
            lines.append(f"  {x} = extractelement {T} %x, i32 {i}")
        for function, target in (("sin", "s"), ("cos", "c")):
            lines.append(f"  %l{target}{i} = call double @{function}(double {x})")
            lines.append(f"  %a{target}{i} = getelementptr double, ptr %{target}, i64 {i}")
            lines.append(f"  store double %l{target}{i}, ptr %a{target}{i}, align 8")
    lines.append("  ret void")
    return "\n".join(lines) + "\n"


def declarations(lanes: int) -> list[str]:
    """Declarations of the functions that the definition calls."""
    T, suffix = ("double", "f64") if lanes == 1 else (f"<{lanes} x double>", f"v{lanes}f64")
    return [
        "declare double @sin(double)",
        "declare double @cos(double)",
        "declare i64 @llvm.fshl.i64(i64, i64, i64)",
        "declare i128 @llvm.ctlz.i128(i128, i1)",
        f"declare {T} @llvm.fma.{suffix}({T}, {T}, {T})",
        f"declare {T} @llvm.fabs.{suffix}({T})",
    ]
