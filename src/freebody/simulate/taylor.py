"""Taylor series in time, computed by heyoka: steps that another program has made, for the loop to go along.

    y(t + τ) = Σ_k y_k τᵏ,    τ from 0 to h

heyoka (`series`) makes the steps and leaves a table of their times, lengths and coefficients, some thousand steps at a
time. The loop walks along it: events, states between steps and the rest are as with any method, and a state between two
steps is the polynomial itself, by Horner's rule.
"""

from __future__ import annotations

import math

from . import stepping
from .layout import BLAME, KERNELS, POINT, RAW, ROWS
from .machine import Integers, Reals, compiled, reals_at, whole
from .stepping import nothing_to_keep

# Places after KERNELS: address of the table, its number of steps, and numbers per component.
TABLE, STEPS, TERMS = 0, 1, 2
# Of the rows of the method the first holds the number of the step and the number of terms, the others the polynomials.


@compiled
def prepare(
    rates: int, t: float, work: Reals, w: int, n: int, c: Reals, quaternions: Integers, nq: int, integers: Integers
) -> None:  # fmt: skip
    """The step of the table that begins nearest to ``t``."""
    table, count = reals_at(quaternions[nq + KERNELS + TABLE]), quaternions[nq + KERNELS + STEPS]
    width = 2 + n * quaternions[nq + KERNELS + TERMS]
    direction = 1.0 if table[1] >= 0.0 else -1.0
    low, high = 0, count
    while high - low > 1:
        middle = (low + high) // 2
        if (table[middle * width] - t) * direction <= 0.0:
            low = middle
        else:
            high = middle
    if low + 1 < count and abs(table[(low + 1) * width] - t) < abs(table[low * width] - t):
        low += 1
    work[ROWS * w] = low


@compiled
def given(work: Reals, w: int, n: int, quaternions: Integers, nq: int) -> float:
    """Length of the step that comes next."""
    table = reals_at(quaternions[nq + KERNELS + TABLE])
    width = 2 + n * quaternions[nq + KERNELS + TERMS]
    return table[whole(work[ROWS * w]) * width + 1]


@compiled
def horner(work: Reals, w: int, n: int, table: Reals, place: int, terms: int, x: float, row: int) -> None:
    """Row ``row``: the polynomials at the time ``x`` after the start of the step."""
    for i in range(n):
        at = place + 2 + i * terms
        value = table[at + terms - 1]
        for k in range(terms - 2, -1, -1):
            value = value * x + table[at + k]
        work[row * w + i] = value


@compiled
def attempt(
    rates: int, t: float, h: float, work: Reals, w: int, n: int, c: Reals, quaternions: Integers, nq: int,
    relative: Reals, absolute: Reals, integers: Integers,
) -> int:  # fmt: skip
    """The state at the time ``h`` of the step."""
    table, terms = reals_at(quaternions[nq + KERNELS + TABLE]), quaternions[nq + KERNELS + TERMS]
    horner(work, w, n, table, whole(work[ROWS * w]) * (2 + n * terms), terms, h, RAW)
    return 0


@compiled
def judge(
    n: int, work: Reals, w: int, h: float, relative: Reals, absolute: Reals, integers: Integers
) -> float:
    """0, nan if the state is not finite: heyoka has chosen the step."""
    for i in range(n):
        if not math.isfinite(work[RAW * w + i]):
            integers[BLAME] = i
            return math.nan
    return 0.0


@compiled
def densify(
    rates: int, t: float, h: float, work: Reals, w: int, n: int, c: Reals, quaternions: Integers, nq: int
) -> None:
    """The polynomials of the step, over their whole length, to the method's rows."""
    table, terms = reals_at(quaternions[nq + KERNELS + TABLE]), quaternions[nq + KERNELS + TERMS]
    place = whole(work[ROWS * w]) * (2 + n * terms)
    work[ROWS * w + 1] = terms
    for k in range(terms):
        for i in range(w):
            work[(ROWS + 1 + k) * w + i] = 0.0
    power = 1.0
    for k in range(terms):
        for i in range(n):
            work[(ROWS + 1 + k) * w + i] = table[place + 2 + i * terms + k] * power
        power *= h


@compiled
def interpolate(x: float, work: Reals, w: int) -> None:
    """Row POINT: the polynomial at the part ``x`` (0 to 1) of the step."""
    terms = whole(work[ROWS * w + 1])
    for i in range(w):
        value = work[(ROWS + terms) * w + i]
        for k in range(terms - 2, -1, -1):
            value = value * x + work[(ROWS + 1 + k) * w + i]
        work[POINT * w + i] = value


@compiled
def accept(work: Reals, w: int, n: int) -> None:
    """On to the next step of the table."""
    work[ROWS * w] += 1.0


FUNCTIONS = stepping.functions(
    {
        "GIVEN": 1,
        "prepare": prepare,
        "given": given,
        "horner": horner,
        "attempt": attempt,
        "judge": judge,
        "densify": densify,
        "interpolate": interpolate,
        "hold": nothing_to_keep,
        "accept": accept,
    }
)
