"""Taylor series in time: steps as long as the series allows.

    y(t + τ) = Σ_k y_k τᵏ,    k = 0 ... p

A kernel of the model (`jet`) fills the coefficients at the start of a step. The last six give the length h of the step.
The last two terms must be within the tolerance a + r |y|. The terms before them are bounded so that the last two are
within the tolerance if each term is smaller than the one before by r^(1/p), which is h over the radius of convergence:

    |y_p| h^p <= a + r |y|,    |y_m| h^m <= (a + r |y|) r^((m + 1)/p - 1)    for m = p - 5 ... p - 1

Six terms, because terms of a symmetric series vanish: every other term of an even series, three of four if a pendulum
is released with its rod horizontal, and at most five of six for elliptic functions. A state inside a step, of an event
or for output, is the polynomial itself. The rounding error of y_0 + h (y_1 + ...) is kept and added to the next sum, so
that the round-off of many steps does not accumulate.

A decay e^(λt) that is over does not end the step before h |λ| reaches the bound of the region of stability, where its
terms grow back to the tolerance. It is recognised by y_p ≈ λ y_(p-1) / p, and by y_p ≈ λ^(p-m) m!/p! y_m, m = p/4. The
terms near a pole at the distance R fall alike at the end, but from the first on: at tolerance r, h/R is r^(1/p), and so
(p!/m!)^(1/(p-m)) h/R, which corresponds to h |λ|, is 3.6 at 1e-7 and less at finer tolerances.

Where a function may bend, as √(x²) = |x| does, the series continues as if it did not. So for machines with roots,
powers or arcs the rates halfway and at the end are compared with the derivative of the series, and a step with too
large a difference is shortened. No other step is rejected. At a distance d from a bend the terms grow as d^-k. If they
allow no step that the time resolves, the step is a straight line, as long as the comparison allows:
h |y_1| <= 100 (a + r |y|).

Source: A. Jorba, M. Zou, A software package for the numerical integration of ODEs by means of high-order Taylor methods
(2005), sections 3.1 and 3.2.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from ...native.instructions import (
    EPS,
    Integers,
    Reals,
    call,
    compiled,
    greater,
    root,
    shifted,
    whole,
    with_bits,
)
from ...native.row_arithmetic import Eight, copied, rowwise
from . import step_control
from .layout import BLAME, CONSTANTS, EVALUATED, KERNELS, ORDERS, POINT, RAW, ROWS, STATE

P = ORDERS["taylor"]
# The address of the kernel follows at KERNELS. Rows of the method: the rounding error of the sum before this step, in
# it, and in the saved step; then the length of the step; r and log₂ r^(1/p); then the coefficients.
LOST, LOSES, HELD, LENGTH, RATE, SERIES = ROWS, ROWS + 1, ROWS + 2, ROWS + 3, ROWS + 4, ROWS + 5
BENDS = 1
"""Index after the kernel: 1 if a function in the rates may bend, which the series does not show."""
SLOPES = 12
"""Row of the rates at the end of a step, if they may bend."""
TERMS = 6
"""Number of terms of the series that determine the length of a step."""
BEND, ROUNDED = 100.0, 1e-14
"""Admissible error of the derivative of a good series, as a multiple of the tolerance and as a fraction of the change
in a step. The error is p + 1 times the first omitted term."""
BOUND = 6.0
"""h |λ| from which a decay is suspected to limit the step: a little less than 7.33, where |Σ_k (-x)^k / k!|, k <= P, is
1."""

EARLY = P // 4
"""m of a decay."""
GROWN = math.factorial(P) / math.factorial(EARLY) / BOUND ** (P - EARLY) / P
"""|y_m| over h^(p-m) |p y_p| for a decay with h |λ| = BOUND."""


@compiled
def expand(t: float, work: Reals, w: int, c: Reals, quaternions: Integers, nq: int) -> None:
    """Compute the coefficients of the solution through STATE."""
    place = quaternions[nq + CONSTANTS]
    call(quaternions[nq + KERNELS], t, work, STATE * w, shifted(c, place), work, SERIES * w)


@compiled
def power2(x: float) -> float:
    """Return 2ˣ for |x| < 1000, within 0.2 %."""
    exponent = whole(x + 1023.0)
    r = x - (exponent - 1023)
    return with_bits(exponent << 52) * (1.0 + r * (2.0 + r) / 3.0)


@compiled
def prepare(
    rates: int, t: float, work: Reals, w: int, n: int, c: Reals, quaternions: Integers, nq: int, integers: Integers
) -> None:  # fmt: skip
    """Compute the series of the first step."""
    for i in range(w):
        work[LOST * w + i] = 0.0
    work[RATE * w] = 0.0
    expand(t, work, w, c, quaternions, nq)


def in_pairs(numbers: list[Any], of: Callable[[Any, Any], Any]) -> Any:
    """Reduce numbers by ``of``, two at a time, so that few operations wait for each other."""
    while len(numbers) > 1:
        pairs = [of(a, b) for a, b in zip(numbers[::2], numbers[1::2], strict=False)]
        numbers = [*pairs, *numbers[len(numbers) - len(numbers) % 2 :]]
    return numbers[0]


@compiled
def blamed(work: Reals, w: int, n: int) -> int:
    """Return the first component that is not finite: in the lowest order of the series, since others follow from it, in
    the rates at the end of a step, or in the state there.
    """
    for j in range(1, P + 1):
        for i in range(n):
            if not math.isfinite(work[(SERIES + j) * w + i]):
                return i
    for i in range(n):
        if not math.isfinite(work[SLOPES * w + i]):
            return i
    for i in range(n):
        if not math.isfinite(work[RAW * w + i]):
            return i
    return 0


@rowwise
def slowest(row: Any, relative: Any, absolute: Any, rate: Any) -> Any:
    """Return the largest log₂ (1 / h) over the lengths h that the terms allow; nan if a term is not finite."""
    scale = 1.0 / (absolute + relative * abs(row[STATE]))
    sizes = [abs(row[SERIES + P - j]) * scale for j in range(TERMS)]
    allowed = [(size.logarithm2() + max(0, j - 1) * rate) * (1.0 / (P - j)) for j, size in enumerate(sizes)]
    return in_pairs(allowed, Eight.greater) + in_pairs(sizes, Eight.__add__) * 0.0


@rowwise
def fastest(row: Any, relative: Any, absolute: Any) -> Any:
    """Return the largest rate in units of the tolerance."""
    return abs(row[SERIES + 1]) / (absolute + relative * abs(row[STATE]))


@rowwise
def straighten(row: Any) -> None:
    """Replace the series by that of a straight line."""
    for k in range(2, P + 1):
        row[SERIES + k] = row[STATE] * 0.0


def polynomial(terms: list[Any], x: Any) -> Any:
    """Return Σ_k x^k terms[k], computed in four parts, since each addition waits for the one before."""
    double = x * x
    fourth = double * double
    parts = []
    for k in range(4):
        *rest, part = terms[k::4]
        for term in reversed(rest):
            part = part.times_plus(fourth, term)
        parts.append(part)
    low, high = (parts[k + 1].times_plus(x, parts[k]) for k in (0, 2))
    return high.times_plus(double, low)


def sum_of_series(row: Any, h: Any) -> Any:
    """Set row RAW to the sum of the series, STATE + (h (y_1 + ...) + LOST), and row LOSES to its rounding error.

    Return 0, or nan if a sum is not finite.
    """
    start = row[STATE]
    change = h * polynomial([row[SERIES + k] for k in range(1, P + 1)], h) + row[LOST]
    end = start + change
    part = end - start
    row[LOSES] = (start - (end - part)) + (change - part)
    row[RAW] = end
    return end * 0.0


@rowwise
def summed(row: Any, h: Any) -> None:
    """Set row POINT: the series at the time h."""
    row[POINT] = polynomial([row[SERIES + k] for k in range(P + 1)], h)


def distance(row: Any, h: Any, relative: Any, absolute: Any) -> Any:
    """Return the difference of the derivative of the series at the end of the step from the rates there, row SLOPES.

    It is multiplied by the step, and in units of the admissible error from the last terms and round-off.
    """
    slope = polynomial([row[SERIES + k] * float(k) for k in range(1, P + 1)], h)
    allowed = BEND * (absolute + relative * abs(row[RAW])) + ROUNDED * abs(h * row[SLOPES])
    return abs(h * (row[SLOPES] - slope)) / allowed


added, missed = rowwise(sum_of_series), rowwise(distance)


@rowwise
def beyond(row: Any, h: Any) -> Any:
    """Return a positive number if the term P y_P h is more than BOUND times the one before it."""
    above, below = h * (P * 1.0) * row[SERIES + P], BOUND * row[SERIES + P - 1]
    return above * above - below * below


@compiled
def predicted_length(
    t: float, work: Reals, w: int, n: int, c: Reals, quaternions: Integers, nq: int, relative: Reals, absolute: Reals,
    integers: Integers,
) -> float:  # fmt: skip
    """Return the length of the next step: very large for a polynomial, nan if the coefficients are not finite."""
    expand(t, work, w, c, quaternions, nq)
    integers[EVALUATED] += 1
    coarsest = 1e-16
    for i in range(n):
        coarsest = greater(coarsest, relative[i])
    if work[RATE * w] != coarsest:  # at the start, and when a long run tightens it
        work[RATE * w] = coarsest
        work[RATE * w + 1] = math.log2(coarsest) / P
    logarithm = slowest(work, w, n, relative, absolute, work[RATE * w + 1])
    size = power2(-logarithm) if math.isfinite(logarithm) else math.nan
    if quaternions[nq + KERNELS + BENDS] != 0 and not size > 8.0 * EPS * abs(t):
        greatest_rate = fastest(work, w, n, relative, absolute)
        if 0.0 < greatest_rate < math.inf:
            straighten(work, w, n)
            return BEND / greatest_rate
    if size != size:
        integers[BLAME] = blamed(work, w, n)
    return size


@compiled
def attempt(
    rates: int, t: float, h: float, work: Reals, w: int, n: int, c: Reals, quaternions: Integers, nq: int,
    relative: Reals, absolute: Reals, integers: Integers,
) -> int:  # fmt: skip
    """Compute the state at the time ``h`` of the step."""
    work[LENGTH * w + 1] = added(work, w, n, h)
    if quaternions[nq + KERNELS + BENDS] != 0:
        half = 0.5 * h
        summed(work, w, w, half)
        call(rates, t + half, work, POINT * w, c, work, SLOPES * w)
        work[LENGTH * w + 1] += missed(work, w, n, half, relative, absolute)
        call(rates, t + h, work, RAW * w, c, work, SLOPES * w)
        work[LENGTH * w + 1] += missed(work, w, n, h, relative, absolute)
    return 0


@compiled
def judge(
    n: int, work: Reals, w: int, h: float, relative: Reals, absolute: Reals, integers: Integers
) -> float:
    """Return 0, or the error of a step that continued past a bend; nan if the state is not finite."""
    error = work[LENGTH * w + 1]
    if not math.isfinite(error):
        integers[BLAME] = blamed(work, w, n)
    return error


@compiled
def densify(
    rates: int, t: float, h: float, work: Reals, w: int, n: int, c: Reals, quaternions: Integers, nq: int
) -> None:
    """Store the length of the step for `interpolate`: the series is the dense output."""
    work[LENGTH * w] = h


@compiled
def interpolate(x: float, work: Reals, w: int) -> None:
    """Set row POINT: the polynomial at the fraction ``x`` (0 to 1) of the step."""
    summed(work, w, w, x * work[LENGTH * w])


@compiled
def hold(work: Reals, w: int, n: int) -> None:
    """Save the rounding error of the sum while parts of the step are tried."""
    copied(work, w, LOSES, HELD)


@compiled
def accept(work: Reals, w: int, n: int) -> None:
    """Pass the rounding error of this sum to the next."""
    copied(work, w, HELD, LOST)


@compiled
def limited_by_stability(work: Reals, w: int, n: int, h: float) -> int:
    """Return 1 if the step is as long as the region of stability allows, with λ of a decay."""
    if not beyond(work, w, n, h) > 0.0:  # no component does, so their sums do not either
        return 0
    above, below, across, early = 0.0, 0.0, 0.0, 0.0
    for i in range(n):
        a, b = P * work[(SERIES + P) * w + i], work[(SERIES + P - 1) * w + i]
        early += work[(SERIES + EARLY) * w + i] * work[(SERIES + EARLY) * w + i]
        above += a * a
        below += b * b
        across += a * b
    decays = h * across < 0.0 and 4.0 * across * across > above * below
    if not decays or not (h * h * above > BOUND * BOUND * below and below > 0.0):
        return 0
    return 1 if root(early) <= GROWN * abs(h) ** (P - EARLY) * root(above) else 0


FUNCTIONS = step_control.Functions(
    {
        "PREDICTED": 1,
        "prepare": prepare,
        "predicted_length": predicted_length,
        "attempt": attempt,
        "judge": judge,
        "densify": densify,
        "interpolate": interpolate,
        "hold": hold,
        "accept": accept,
        "limited_by_stability": limited_by_stability,
    }
)
