"""An integrator that shares nothing with the closed forms: Taylor series in integers, thirty digits and more."""

from __future__ import annotations

from fractions import Fraction

import mpmath
import pytest

BITS = 150
ONE = 1 << BITS
TOLERANCE = 1 << (BITS - 112)  # 2e-34 per step
ORDER = 40


def fixed(value):
    """An exact number, a double or an mpmath number as a whole number of 2^-BITS."""
    if isinstance(value, mpmath.mpf):
        return int(mpmath.floor(mpmath.ldexp(value, BITS) + mpmath.mpf("0.5")))
    value = Fraction(value)
    return (value.numerator << BITS) // value.denominator


def solve(equations, start, times):
    """States at ``times`` (rising) of y_i' = sum of c y_a y_b, equations[i] = [(c, a, b), ...]; mpmath numbers.

    A step is summed from 40 Taylor coefficients, found from the products of the lower ones, and is as long as the last
    two of them allow.
    """
    equations = [[(fixed(c), min(a, b), max(a, b)) for c, a, b in terms] for terms in equations]
    pairs = sorted({(a, b) for terms in equations for _, a, b in terms})
    state, t, out = [fixed(value) for value in start], 0, []
    for goal in map(fixed, times):
        while t < goal:
            series = [[value] for value in state]
            for n in range(ORDER):
                product = {(a, b): sum(map(int.__mul__, series[a], series[b][::-1])) >> BITS for a, b in pairs}
                for coefficients, terms in zip(series, equations, strict=True):
                    total = sum(c * product[a, b] for c, a, b in terms) >> BITS
                    coefficients.append(total // (n + 1))
            last = max(1, *(max(abs(c[-1]), int(abs(c[-2]))) for c in series))
            step = min(goal - t, fixed((TOLERANCE / last) ** (1 / ORDER)))
            for i, coefficients in enumerate(series):
                total = 0
                for c in reversed(coefficients):
                    total = (total * step >> BITS) + c
                state[i] = total
            t += step
        out.append([mpmath.mpf(value) / ONE for value in state])
    return out


def quaternion_rates(rate, body=True):
    """Terms of q' = q w / 2 (body components) or w q / 2 (inertial ones); ``rate[k]`` = [(c, index), ...] is w_k, q last."""
    first = rate["q"]
    q = [first, first + 1, first + 2, first + 3]
    # rows of w_1, w_2, w_3 acting on (q0, q1, q2, q3) from the right; from the left the cross product changes its sign
    sign = 1 if body else -1
    table = [
        [(-1, 1, 0), (-1, 2, 1), (-1, 3, 2)],
        [(1, 0, 0), (sign, 2, 2), (-sign, 3, 1)],
        [(1, 0, 1), (sign, 3, 0), (-sign, 1, 2)],
        [(1, 0, 2), (sign, 1, 1), (-sign, 2, 0)],
    ]
    return [
        [(Fraction(s) * c / 2, q[j], index) for s, j, k in row for c, index in rate["w"][k]] for row in table
    ]


class Taylor:
    solve = staticmethod(solve)
    quaternion_rates = staticmethod(quaternion_rates)


@pytest.fixture(scope="session")
def taylor():
    return Taylor
