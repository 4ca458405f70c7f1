"""Sine and cosine together, as LLVM IR, for one double or a vector of doubles.

    n = round(2 x / π),   r = x - n π/2,   (sin x, cos x) = ± (sin r, cos r) or ± (cos r, sin r)

The reduction is exact enough for a result within one unit in the last place at every |x| below :data:`LIMIT`, also
next to multiples of π/2: with π/2 = P1 + P2 + P3,

- n P1 is subtracted with one fused multiply-add, whose result is exact by cancellation;
- P2 has 33 bits and n fewer than 20, so n P2 is exact and so is the rounding error of its subtraction;
- P3 and that error form a correction y, which enters as sin(r + y) ≈ sin r + y cos r.

Larger arguments, infinities and NaN go through the C library, one lane at a time, on a branch marked unlikely; the
lanes beside them do not.
The polynomials are minimax in relative error on [-π/4, π/4] (3e-18 and 5e-20), found with Remez's algorithm.

Sources: W. J. Cody and W. Waite, Software Manual for the Elementary Functions (1980), ch. 8; Muller et al.,
Handbook of Floating-Point Arithmetic (2018), §10.2.
"""

from __future__ import annotations

from typing import Any

from .text import literal, splat

LIMIT = 5e5
"""Arguments beyond this are left to the C library: 2 x / π must stay below 2^19."""

_hex = float.fromhex
_P1, _P2, _P3 = _hex("0x1.921fb54442d18p0"), _hex("0x1.1a62633100000p-54"), _hex("0x1.1701b839a2520p-88")
_TWO_OVER_PI = _hex("0x1.45f306dc9c883p-1")
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
    """The IR name of the function of this many lanes."""
    return f"@sincos.{lanes}"


def definition(lanes: int, fused: bool) -> str:
    """IR of ``void sincos(x, ptr s, ptr c)`` for ``double`` (1 lane) or ``<lanes x double>``.

    Without fused multiply-add (``fused=False``) the whole function is the C library's.
    """
    T = "double" if lanes == 1 else f"<{lanes} x double>"
    head = (
        f"define internal void {name(lanes)}({T} %x, ptr noalias %s, ptr noalias %c) nounwind noinline {{\n"
    )
    if not fused:
        return head + _library(lanes, T) + "}\n"
    J = "i64" if lanes == 1 else f"<{lanes} x i64>"
    B = "i1" if lanes == 1 else f"<{lanes} x i1>"
    suffix = "f64" if lanes == 1 else f"v{lanes}f64"
    lines = [head + "entry:"]

    def emit(target: str, operation: str) -> str:
        lines.append(f"  %{target} = {operation}")
        return f"%{target}"

    def k(value: float) -> str:
        return splat(literal(value), lanes)

    def fma(target: str, a: str, b: str, c: str) -> str:
        return emit(target, f"call {T} @llvm.fma.{suffix}({T} {a}, {T} {b}, {T} {c})")

    def integer(value: int) -> str:
        return splat(str(value), lanes, "i64")

    def horner(target: str, coefficients: tuple[float, ...]) -> str:
        """Σ coefficients z^i in two interleaved chains (Estrin's first step): shorter to wait for."""
        even, odd = coefficients[0::2], coefficients[1::2]
        sums = []
        for label, part in (("e", even), ("o", odd)):
            value = k(part[-1])
            for i, c in reversed(list(enumerate(part[:-1]))):
                value = fma(f"{target}{label}{i}", value, "%zz", k(c))
            sums.append(value)
        return fma(target, sums[1], "%z", sums[0])

    emit("size", f"call {T} @llvm.fabs.{suffix}({T} %x)")
    emit("large", f"fcmp ugt {T} %size, {k(LIMIT)}")
    if lanes == 1:
        lines += ["  br i1 %large, label %library, label %reduce, !prof !0", "reduce:"]
    fma("shifted", "%x", k(_TWO_OVER_PI), k(_ROUND))
    emit("n", f"fsub {T} %shifted, {k(_ROUND)}")
    emit("m", f"fneg {T} %n")
    fma("r0", "%m", k(_P1), "%x")
    emit("p", f"fmul {T} %n, {k(_P2)}")
    emit("r", f"fsub {T} %r0, %p")
    emit("d", f"fsub {T} %r0, %r")
    emit("e", f"fsub {T} %d, %p")
    fma("y", "%m", k(_P3), "%e")
    emit("z", f"fmul {T} %r, %r")
    emit("zz", f"fmul {T} %z, %z")
    # sin(r + y) = r + (r³ (S1 + z S) + y (1 - z/2))
    emit("h", f"fmul {T} %z, {k(0.5)}")
    emit("w", f"fsub {T} {k(1.0)}, %h")
    emit("rz", f"fmul {T} %r, %z")
    horner("S", _SIN)
    emit("yw", f"fmul {T} %y, %w")
    fma("sr", "%rz", "%S", "%yw")
    emit("sin", f"fadd {T} %r, %sr")
    # cos(r + y) = w + (((1 - w) - z/2) + (z² C - r y)),  w = 1 - z/2
    horner("C", _COS)
    emit("v", f"fsub {T} {k(1.0)}, %w")
    emit("vh", f"fsub {T} %v, %h")
    emit("minus_r", f"fneg {T} %r")
    fma("ry", "%minus_r", "%y", "%vh")
    fma("cr", "%zz", "%C", "%ry")
    emit("cos", f"fadd {T} %w, %cr")
    # the quadrant: swap when n is odd, signs from its second bit
    emit("bits", f"bitcast {T} %shifted to {J}")
    emit("low", f"and {J} %bits, {integer(1)}")
    emit("swap", f"icmp ne {J} %low, {integer(0)}")
    emit("next", f"add {J} %bits, {integer(1)}")
    for target, source, first, second in (("s", "bits", "cos", "sin"), ("c", "next", "sin", "cos")):
        emit(f"{target}0", f"select {B} %swap, {T} %{first}, {T} %{second}")
        emit(f"{target}1", f"bitcast {T} %{target}0 to {J}")
        emit(f"{target}2", f"and {J} %{source}, {integer(2)}")
        emit(f"{target}3", f"shl {J} %{target}2, {integer(62)}")
        emit(f"{target}4", f"xor {J} %{target}1, %{target}3")
        emit(f"{target}5", f"bitcast {J} %{target}4 to {T}")
        lines.append(f"  store {T} %{target}5, ptr %{target}, align 8")
    if lanes == 1:
        lines += ["  ret void", "library:"]
        return "\n".join(lines) + "\n" + _library(lanes, T) + "}\n"
    emit("mask", f"bitcast {B} %large to i{lanes}")
    emit("any", f"icmp ne i{lanes} %mask, 0")
    lines.append("  br i1 %any, label %library, label %done, !prof !0")
    lines.append("library:")
    for i in range(lanes):  # the lanes beside a large one keep what they have alone
        emit(f"l{i}", f"extractelement {B} %large, i32 {i}")
        lines += [
            f"  br i1 %l{i}, label %call{i}, label %next{i}",
            f"call{i}:",
            *_lane(i, T),
            f"  br label %next{i}",
        ]
        lines.append(f"next{i}:")
    return "\n".join([*lines, "  br label %done", "done:", "  ret void"]) + "\n}\n"


def reduced(w: Any, x: str) -> tuple[str, tuple[str, str], tuple[str, str]]:
    """(n in its low bits, sin r, cos r) with x = n π/2 + r, for |x| below :data:`LIMIT`; sine and cosine as sums of two
    doubles. The writer ``w`` is that of :mod:`freebody.compile.vector_math`."""
    shifted = w.fma(x, w.number(_TWO_OVER_PI), w.number(_ROUND))
    n = w.sub(shifted, w.number(_ROUND))
    m = w.neg(n)
    r0 = w.fma(m, w.number(_P1), x)
    p = w.mul(n, w.number(_P2))
    r = w.sub(r0, p)
    y = w.fma(m, w.number(_P3), w.sub(w.sub(r0, r), p))
    z = w.mul(r, r)
    zz = w.mul(z, z)
    # sin(r + y) = r + (r³ S + y (1 - z/2)),  cos(r + y) = W + (((1 - W) - z/2) + (z² C - r y)),  W = 1 - z/2
    h = w.mul(z, w.number(0.5))
    W = w.sub(w.number(1.0), h)
    sine = w.fma(w.mul(r, z), w.polynomial(_SIN, z, zz), w.mul(y, W))
    rest = w.fma(w.neg(r), y, w.sub(w.sub(w.number(1.0), W), h))
    cosine = w.fma(zz, w.polynomial(_COS, z, zz), rest)
    return w.bits(shifted), w.two_sum(r, sine), w.two_sum(W, cosine)


def _library(lanes: int, T: str) -> str:
    """Each lane through the C library."""
    lines = [line for i in range(lanes) for line in _lane(i, T)]
    return "\n".join([*lines, "  ret void"]) + "\n"


def _lane(i: int, T: str) -> list[str]:
    """One lane through the C library."""
    lines, x = [], "%x"
    if T != "double":
        x = f"%x{i}"
        lines.append(f"  {x} = extractelement {T} %x, i32 {i}")
    for function, target in (("sin", "s"), ("cos", "c")):
        lines.append(f"  %l{target}{i} = call double @{function}(double {x})")
        lines.append(f"  %a{target}{i} = getelementptr double, ptr %{target}, i64 {i}")
        lines.append(f"  store double %l{target}{i}, ptr %a{target}{i}, align 8")
    return lines


def declarations(lanes: int) -> list[str]:
    """What the definition calls."""
    T, suffix = ("double", "f64") if lanes == 1 else (f"<{lanes} x double>", f"v{lanes}f64")
    return [
        "declare double @sin(double)",
        "declare double @cos(double)",
        f"declare {T} @llvm.fma.{suffix}({T}, {T}, {T})",
        f"declare {T} @llvm.fabs.{suffix}({T})",
    ]
