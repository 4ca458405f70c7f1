"""Taylor series in time: steps as long as the series allows.

    y(t + τ) = Σ_k y_k τᵏ,    k = 0 ... p

A kernel of the model (`compile.jet`) fills the coefficients at the start of a step. The last six give the length h of
it: the last two terms are within the tolerance a + r |y|, and those before them within as much as leaves the last two
there if each is smaller than the one before by r^(1/p), which is h over the radius of convergence:

    |y_p| h^p <= a + r |y|,    |y_m| h^m <= (a + r |y|) r^((m + 1)/p - 1)    for m = p - 5 ... p - 1

Six, since terms of a symmetric series vanish: every other one of an even series, three of four where a pendulum is let
go with its rod horizontal, and five of six are the most that elliptic functions leave out. No step is rejected, and a
state inside a step, of an event or for output, is the polynomial itself. What y_0 + h (y_1 + ...) loses to rounding is
kept and added to the next sum, so that the round-off of many steps does not add up.

A decay e^(λt) that is over does not end the step before h |λ| is at the bound of the region of stability, where its
terms grow back to the tolerance. That is seen by y_p ≈ λ y_(p-1) / p.

Source: A. Jorba, M. Zou, A software package for the numerical integration of ODEs by means of high-order Taylor methods
(2005), sections 3.1 and 3.2.
"""

from __future__ import annotations

import math

from . import stepping
from .layout import BLAME, CONSTANTS, EVALUATED, KERNELS, ORDERS, POINT, RAW, ROWS, STATE
from .machine import Integers, Reals, bits, call, compiled, greater, horner, shifted, whole, with_bits

P = ORDERS["taylor"]
# After KERNELS stands the address of the kernel. Rows of the method: what the sum lost before this step, in it, and
# in it while parts of it are tried; then the length of the step; then the coefficients.
LOST, LOSES, HELD, LENGTH, SERIES = ROWS, ROWS + 1, ROWS + 2, ROWS + 3, ROWS + 4
TERMS = 6
"""Terms of the series that the length of a step is taken from."""
TINY = 1e-300
"""A part of the tolerance that counts as nothing."""
BOUND = 6.0
"""h |λ| from which a decay is suspected to limit the step: somewhat less than 7.33, where |Σ_k (-x)^k / k!|, k <= P,
is 1."""


@compiled
def expand(t: float, work: Reals, w: int, c: Reals, quaternions: Integers, nq: int) -> None:
    """The coefficients of the solution through STATE."""
    place = quaternions[nq + CONSTANTS]
    call(quaternions[nq + KERNELS], t, work, STATE * w, shifted(c, place), work, SERIES * w)


@compiled
def logarithm2(x: float) -> float:
    """log₂ x of a normal number x > 0, within 0.01: its exponent, and a parabola of what is left, 1 <= m < 2."""
    exponent = (bits(x) >> 52) - 1023
    m = with_bits(bits(x) - (exponent << 52))
    return exponent + ((2.0 - m / 3.0) * m - 5.0 / 3.0)


@compiled
def power2(x: float) -> float:
    """2ˣ for |x| < 1000, within 0.2 %."""
    exponent = whole(x + 1023.0)
    r = x - (exponent - 1023)
    return with_bits(exponent << 52) * (1.0 + r * (2.0 + r) / 3.0)


@compiled
def prepare(
    rates: int, t: float, work: Reals, w: int, n: int, c: Reals, quaternions: Integers, nq: int, integers: Integers
) -> None:  # fmt: skip
    """The series of the first step."""
    for i in range(w):
        work[LOST * w + i] = 0.0
    expand(t, work, w, c, quaternions, nq)


@compiled
def given(
    t: float, work: Reals, w: int, n: int, c: Reals, quaternions: Integers, nq: int, relative: Reals, absolute: Reals,
    integers: Integers,
) -> float:  # fmt: skip
    """Length of the step that comes next, infinite for a polynomial, nan if the coefficients are not finite."""
    expand(t, work, w, c, quaternions, nq)
    integers[EVALUATED] += 1
    maxima, coarsest, total = LENGTH * w + 1, 1e-16, 0.0
    for j in range(TERMS):
        work[maxima + j] = TINY
    for i in range(n):
        scale = 1.0 / (absolute[i] + relative[i] * abs(work[STATE * w + i]))
        coarsest = greater(coarsest, relative[i])
        for j in range(TERMS):
            size = abs(work[(SERIES + P - j) * w + i]) * scale
            work[maxima + j] = greater(work[maxima + j], size)
            total += size
    if not math.isfinite(total):
        for i in range(n):
            for j in range(TERMS):
                if not math.isfinite(work[(SERIES + P - j) * w + i]):
                    integers[BLAME] = i
                    return math.nan
    slowest, some, rate = 0.0, False, logarithm2(coarsest) / P
    for j in range(TERMS):
        if work[maxima + j] > TINY:
            size = logarithm2(work[maxima + j])
            if j > 1:
                size += (j - 1) * rate
            size /= P - j
            slowest = greater(slowest, size) if some else size
            some = True
    return power2(-slowest) if some else math.inf


@compiled
def attempt(
    rates: int, t: float, h: float, work: Reals, w: int, n: int, c: Reals, quaternions: Integers, nq: int,
    relative: Reals, absolute: Reals, integers: Integers,
) -> int:  # fmt: skip
    """The state at the time ``h`` of the step."""
    horner(work, w, SERIES + 1, P - 1, h, RAW)
    for i in range(n):
        start = work[STATE * w + i]
        change = h * work[RAW * w + i] + work[LOST * w + i]
        end = start + change
        part = end - start
        work[LOSES * w + i] = (start - (end - part)) + (change - part)
        work[RAW * w + i] = end
    return 0


@compiled
def judge(
    n: int, work: Reals, w: int, h: float, relative: Reals, absolute: Reals, integers: Integers
) -> float:
    """0, nan if the state is not finite: the length of the step has been chosen before."""
    total = 0.0
    for i in range(n):
        total += abs(work[RAW * w + i])
    if not math.isfinite(total):
        for i in range(n):
            if not math.isfinite(work[RAW * w + i]):
                integers[BLAME] = i
                return math.nan
    return 0.0


@compiled
def densify(
    rates: int, t: float, h: float, work: Reals, w: int, n: int, c: Reals, quaternions: Integers, nq: int
) -> None:
    """The series is the dense output; its length is what `interpolate` needs."""
    work[LENGTH * w] = h


@compiled
def interpolate(x: float, work: Reals, w: int) -> None:
    """Row POINT: the polynomial at the part ``x`` (0 to 1) of the step."""
    horner(work, w, SERIES, P, x * work[LENGTH * w], POINT)


@compiled
def hold(work: Reals, w: int, n: int) -> None:
    """Keep what the sum lost while parts of the step are tried."""
    for i in range(n):
        work[HELD * w + i] = work[LOSES * w + i]


@compiled
def accept(work: Reals, w: int, n: int) -> None:
    """What the sum of this step lost is added to the next."""
    for i in range(n):
        work[LOST * w + i] = work[HELD * w + i]


@compiled
def limited(work: Reals, w: int, n: int, h: float) -> int:
    """Whether the step is as long as the region of stability allows, with λ of a decay."""
    above, below, across = 0.0, 0.0, 0.0
    for i in range(n):
        a, b = P * work[(SERIES + P) * w + i], work[(SERIES + P - 1) * w + i]
        above += a * a
        below += b * b
        across += a * b
    decays = h * across < 0.0 and 4.0 * across * across > above * below
    return 1 if decays and h * h * above > BOUND * BOUND * below and below > 0.0 else 0


FUNCTIONS = stepping.functions(
    {
        "GIVEN": 1,
        "prepare": prepare,
        "given": given,
        "attempt": attempt,
        "judge": judge,
        "densify": densify,
        "interpolate": interpolate,
        "hold": hold,
        "accept": accept,
        "limited": limited,
        "expand": expand,
        "logarithm2": logarithm2,
        "power2": power2,
    }
)
