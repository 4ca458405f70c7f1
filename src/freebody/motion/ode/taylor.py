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

from ...native.functions import components, each, unrolled
from ...native.instructions import (
    EPS,
    Real,
    Truth,
    bits,
    compiled,
    greater,
    inlined,
    lanes,
    larger,
    lesser,
    maximum,
    muladd,
    root,
    where,
    with_bits,
)  # fmt: skip
from .layout import ORDERS
from .method import Method
from .run import OneRun, Run, Series
from .states import not_finite
from .step_control import Functions

P = ORDERS["taylor"]
TERMS = 6
"""Number of terms of the series that determine the length of a step."""
BEND, ROUNDED = 100.0, 1e-14
"""Admissible error of the derivative of a good series, as a multiple of the tolerance and as a fraction of the change
in a step. The error is p + 1 times the first omitted term."""
BOUND = 6.0
"""h |λ| from which a decay is suspected to limit the step: a little less than 7.33, where |Σ_k (-x)^k / k!|, k <= P, is
1."""

TO_INTEGER = 2.0**52
"""A number that leaves no bits for fractions of a smaller one that is added: the integer is in its lowest bits."""
EARLY = P // 4
"""m of a decay."""
GROWN = math.factorial(P) / math.factorial(EARLY) / BOUND ** (P - EARLY) / P
"""|y_m| over h^(p-m) |p y_p| for a decay with h |λ| = BOUND."""


@compiled
def expand(run: Run, own: Series) -> None:
    """Compute the coefficients of the solution through y."""
    own.coefficients(run.t, run.y, own.c, own.terms[0])


@inlined
def power2(x: Real) -> Real:
    """Return 2ˣ for |x| < 1000, within 0.2 %."""
    biased = x + 1023.0
    nearest = (biased + TO_INTEGER) - TO_INTEGER
    exponent = where(nearest > biased, nearest - 1.0, nearest)
    r = x - (exponent - 1023.0)
    return with_bits(bits(exponent + TO_INTEGER) << 52) * (1.0 + r * (2.0 + r) * (1.0 / 3.0))


@inlined
def logarithm2(x: Real) -> Real:
    """Return log₂ x of x >= 0, or up to 0.087 more: the exponent, and the mantissa 1 + f as if log₂ (1 + f) were f.

    A step is then at most 0.6 % shorter. It is -1023 of 0, and a number of infinity and nan.
    """
    return bits(x) * 2.0**-52 - (1023.0 - 0.0861)


@compiled
def prepare(run: Run, fresh: Truth) -> None:
    """Clear the rounding errors of the sums, and compute the series of the first step of one run.

    Lanes begin at any time: their series are computed together, by `length`.
    """
    own = Series(run.own)
    own.lost[:] = where(fresh, 0.0, own.lost)
    if lanes(run.t) == 1:
        expand(run, own)


@compiled
def blamed(run: Run, own: Series, lane: int) -> int:
    """Return the first component of a lane that is not finite: in the lowest order of the series, since others follow
    from it, in the rates at the end of a step, or in the state there.
    """
    for j in range(1, P + 1):
        i = not_finite(own.terms[j], run.n, lane)
        if i >= 0:
            return i
    i = not_finite(run.k[12], run.n, lane)
    if i < 0:
        i = not_finite(run.y_new, run.n, lane)
    return i if i >= 0 else 0


@inlined
def inverse_length(run: Run, own: Series) -> Real:
    """Return the largest log₂ (1 / h) over the lengths h that the last terms allow; nan if a term is not finite."""
    for i in components(run.n):
        run.point[i] = 1.0 / (run.absolute[i] + run.relative[i] * abs(run.y[i]))
    logarithm: Real = -math.inf
    overall: Real = 0.0
    for m in unrolled(P, P - TERMS, -1):
        largest: Real = 0.0
        for i in components(run.n):
            largest = larger(largest, abs(own.terms[m, i]) * run.point[i])
        stricter = (P - lesser(m + 1, P)) * own.logarithm
        logarithm = greater(logarithm, (logarithm2(largest) + stricter) * (1.0 / m))
        overall = larger(overall, largest)
    return logarithm + 0.0 * overall


@compiled
def straight(run: Run, own: Series, bent: Truth) -> Real:
    """Replace the series by that of a straight line where ``bent``; return the greatest rate |y_1| / (a + r |y|)."""
    rate: Real = 0.0
    for i in components(run.n):
        rate = maximum(rate, abs(own.terms[1, i]) / (run.absolute[i] + run.relative[i] * abs(run.y[i])))
    for k in unrolled(2, P + 1):
        own.terms[k][:] = where(bent and 0.0 < rate < math.inf, 0.0, own.terms[k])
    return rate


@compiled
def length(run: Run) -> Real:
    """Return the length of the next step: very large for a polynomial, nan if the coefficients are not finite."""
    own = Series(run.own)
    expand(run, own)
    run.evaluated += 1
    coarsest: Real = 1e-16
    for i in components(run.n):
        coarsest = larger(coarsest, run.relative[i])
    if any(own.coarsest != coarsest):  # at the start, and when a long run tightens it
        own.coarsest = coarsest
        own.logarithm = math.log2(coarsest) / P
    logarithm = inverse_length(run, own)
    size = where(math.isfinite(logarithm), power2(-logarithm), math.nan)
    bent: Truth = not size > 8.0 * EPS * abs(run.t)  # a bend is closer than that
    if own.bends != 0 and any(bent):
        rate = straight(run, own, bent)
        size = where(bent and 0.0 < rate < math.inf, BEND / rate, size)
    for lane in each(size != size):
        run.blame[lane] = blamed(run, own, lane)
    return size


@compiled
def set_point(run: Run, own: Series, h: Real) -> None:
    """Set row point: the series at the time h, by Horner's rule."""
    for i in components(run.n):
        p = own.terms[P, i]
        for k in unrolled(P - 1, -1, -1):
            p = muladd(p, h, own.terms[k, i])
        run.point[i] = p


@compiled
def misfit(run: Run, own: Series, h: Real) -> Real:
    """Return the difference of the derivative of the series at the time h from the rates there, k[12].

    It is multiplied by h, and in units of the admissible error from the last terms and round-off. It is nan if a rate
    is not finite.
    """
    error: Real = 0.0
    for i in components(run.n):
        slope = P * own.terms[P, i]
        for k in unrolled(P - 1, 0, -1):
            slope = muladd(slope, h, k * own.terms[k, i])
        change = h * run.k[12, i]
        allowed = BEND * (run.absolute[i] + run.relative[i] * abs(run.y_new[i])) + ROUNDED * abs(change)
        error = maximum(error, abs(change - h * slope) / allowed)
    return error


@compiled
def attempt(run: Run, h: Real) -> int:
    """Compute the state at the time ``h`` of the step, y + (h (y_1 + ...) + lost), and the rounding error."""
    own, square = Series(run.own), h * h
    fourth = square * square
    doubt: Real = 0.0
    for i in components(run.n):
        a, b, c, d = own.terms[P, i], own.terms[P - 1, i], own.terms[P - 2, i], own.terms[P - 3, i]
        for k in unrolled(P - 4, 0, -4):  # four parts, since each addition waits for the one before
            a, b = muladd(a, fourth, own.terms[k, i]), muladd(b, fourth, own.terms[k - 1, i])
            c, d = muladd(c, fourth, own.terms[k - 2, i]), muladd(d, fourth, own.terms[k - 3, i])
        y, change = run.y[i], h * muladd(muladd(a, h, b), square, muladd(c, h, d)) + own.lost[i]
        end = y + change
        part = end - y
        own.loses[i] = (y - (end - part)) + (change - part)
        run.y_new[i] = end
        doubt += 0.0 * end
    own.error = doubt
    if own.bends != 0:
        half = 0.5 * h
        set_point(run, own, half)
        run.rates(run.t + half, run.point, run.c, run.k[12])
        own.error += misfit(run, own, half)
        run.rates(run.t + h, run.y_new, run.c, run.k[12])
        own.error += misfit(run, own, h)
    return 0


@compiled
def judge(run: Run, h: Real) -> Real:
    """Return 0, or the error of a step that continued past a bend; nan if the state is not finite."""
    own = Series(run.own)
    for lane in each(not math.isfinite(own.error)):
        run.blame[lane] = blamed(run, own, lane)
    return own.error


@compiled
def lift(run: Run, lane: int, one: OneRun) -> None:
    """Copy the series of a lane into the memory of one run."""
    own, alone = Series(run.own), Series(one.own)
    for i in range(run.n):
        for j in range(P + 1):
            alone.terms[j, i] = own.terms[j, i][lane]


@compiled
def interpolate(run: Run, x: float) -> None:
    """Set the row point: the polynomial at the fraction ``x`` (0 to 1) of the step."""
    set_point(run, Series(run.own), x * run.h)


@compiled
def accept(run: Run, good: Truth) -> None:
    """Pass the rounding error of this sum to the next."""
    own = Series(run.own)
    own.lost[:] = where(good, own.loses, own.lost)


@compiled
def limited(run: Run, h: Real) -> Truth:
    """Return whether the step is as long as the region of stability allows, with λ of a decay."""
    own = Series(run.own)
    above: Real = 0.0
    below: Real = 0.0
    for i in components(run.n):
        a, b = P * own.terms[P, i], own.terms[P - 1, i]
        above += a * a
        below += b * b
    suspect = h * h * above > BOUND * BOUND * below and below > 0.0
    if any(suspect):
        across: Real = 0.0
        early: Real = 0.0
        for i in components(run.n):
            a, b, e = P * own.terms[P, i], own.terms[P - 1, i], own.terms[EARLY, i]
            across += a * b
            early += e * e
        growth = GROWN * root(above)
        for _ in range(P - EARLY):
            growth *= abs(h)
        suspect = suspect and h * across < 0.0 and 4.0 * across * across > above * below
        suspect = suspect and root(early) <= growth
    return suspect


METHOD = Method(
    name="taylor", order=P, attempt=attempt, judge=judge, interpolate=interpolate, prepare=prepare,
    accept=accept, length=length, limited=limited, lift=lift,
)  # fmt: skip
FUNCTIONS = Functions(METHOD)
