"""An integrator that shares nothing with the closed forms: Taylor series in integers, thirty digits and more."""

from __future__ import annotations

from fractions import Fraction
from operator import mul

import mpmath
import pytest

BITS = 150
ONE = 1 << BITS
TOLERANCE = 1 << (BITS - 112)  # 2e-34 per step
ORDER = 40


def fixed(value):
    """An exact number, a double or an mpmath number (all its digits) as a whole number of 2^-BITS."""
    if isinstance(value, mpmath.mpf):
        value = Fraction(*mpmath.libmp.to_rational(value._mpf_))
    value = Fraction(value)
    return (value.numerator << BITS) // value.denominator


def solve(equations, start, times):
    """States at ``times`` (rising) of y_i' = sum of c y_a y_b, equations[i] = [(c, a, b), ...], where y_None = 1;
    mpmath numbers.

    A step is summed from 40 Taylor coefficients, found from the products of the lower ones, and is as long as
    the last two of them allow.
    """
    equations = [[(fixed(c), (a, b)) for c, a, b in terms] for terms in equations]
    pairs = {pair for terms in equations for _, pair in terms}
    state, t, out = [fixed(value) for value in start], 0, []
    for goal in map(fixed, times):
        while t < goal:
            series = [[value] for value in state]
            for n in range(ORDER):
                product = {
                    (a, b): series[a][n]
                    if b is None
                    else sum(map(mul, series[a], reversed(series[b]))) >> BITS
                    for a, b in pairs
                }
                for coefficients, terms in zip(series, equations, strict=True):
                    total = sum(c * product[pair] for c, pair in terms) >> BITS
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


def quaternion_rates(w, q, body=True, scale=1):
    """Terms of q' = q w / 2 (body components) or w q / 2 (inertial ones), w = ``scale`` y_w; w and q are places."""
    # rows of w_1, w_2, w_3 acting on (q0, q1, q2, q3) from the right; from the left the cross product changes
    # its sign
    sign = 1 if body else -1
    table = [
        [(-1, 1, 0), (-1, 2, 1), (-1, 3, 2)],
        [(1, 0, 0), (sign, 2, 2), (-sign, 3, 1)],
        [(1, 0, 1), (sign, 3, 0), (-sign, 1, 2)],
        [(1, 0, 2), (sign, 1, 1), (-sign, 2, 0)],
    ]
    return [[(Fraction(s, 2) * scale, w[k], q[j]) for s, j, k in row] for row in table]


def torque_free(moments, w0, times):
    """Angular velocity (body axes) and quaternion of a torque-free body: Euler's equations and q' = q w / 2."""
    I1, I2, I3 = (Fraction(float(value)) for value in moments)
    euler = [[((I2 - I3) / I1, 1, 2)], [((I3 - I1) / I2, 0, 2)], [((I1 - I2) / I3, 0, 1)]]
    euler += quaternion_rates(range(3), range(3, 7))
    return solve(euler, [*(float(value) for value in w0), 1, 0, 0, 0], times)


def top(I_xi, I_zeta, mgL, theta0, spin, theta_rate0=0.0, psi_rate0=0.0, *, times):
    """H, axis e and quaternion of a top in inertial axes, z upward, psi = phi = 0 at first.

    H' = -m g L e x z,  e' = H x e / I_xi,  q' = w q / 2 with w = H / I_xi + Omega (1 - I_zeta / I_xi) e: no
    angle, no pole. The turn about e is one about a fixed axis of the body at a steady rate, so q = p s with
    p' = H p / (2 I_xi) and s = cos(rate t / 2) + k sin(rate t / 2); p turns slowly, and steps are long.
    """
    given = (I_xi, I_zeta, mgL, theta0, spin, theta_rate0, psi_rate0)
    A, C, W, _, Omega, *_ = (Fraction(float(value)) for value in given)
    rates = [[(-W, 4, None)], [(W, 3, None)], []]  # -W (e_y, -e_x, 0)
    rates += [
        [(1 / A, (k + 1) % 3, 3 + (k + 2) % 3), (-1 / A, (k + 2) % 3, 3 + (k + 1) % 3)] for k in range(3)
    ]
    rates += quaternion_rates(range(3), range(6, 10), body=False, scale=1 / A)
    with mpmath.workprec(BITS + 30):
        A, C, W, theta, Omega, theta_rate, psi_rate = (mpmath.mpf(float(value)) for value in given)
        s, c = mpmath.sin(theta), mpmath.cos(theta)
        e = [mpmath.mpf(0), -s, c]
        # w = theta' x + psi' z + (Omega - psi' c) e
        w = [theta_rate, (Omega - psi_rate * c) * e[1], psi_rate + (Omega - psi_rate * c) * c]
        H = [A * w[k] + (C - A) * Omega * e[k] for k in range(3)]
        states = solve(rates, [*H, *e, mpmath.cos(theta / 2), mpmath.sin(theta / 2), 0, 0], times)
        for state, t in zip(states, times, strict=True):
            p0, p1, p2, p3 = state[6:]
            half = (1 - C / A) * Omega * mpmath.mpf(float(t)) / 2
            s, c = mpmath.sin(half), mpmath.cos(half)
            state[6:] = [p0 * c - p3 * s, p1 * c + p2 * s, p2 * c - p1 * s, p3 * c + p0 * s]
        return states


@pytest.fixture(params=["all parameters", pytest.param("each parameter", marks=pytest.mark.slow)])
def changing(request):
    """What :func:`chapter_answers.check_numbers` changes: all parameters at once, or each in turn as well."""
    return request.param


class Taylor:
    solve = staticmethod(solve)
    torque_free = staticmethod(torque_free)
    top = staticmethod(top)


@pytest.fixture(scope="session")
def taylor():
    return Taylor
