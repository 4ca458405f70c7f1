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
    """An exact number, a double or an mpmath number (all its digits) as a whole number of 2^-BITS."""
    if isinstance(value, mpmath.mpf):
        value = Fraction(*mpmath.libmp.to_rational(value._mpf_))
    value = Fraction(value)
    return (value.numerator << BITS) // value.denominator


def solve(equations, start, times):
    """States at ``times`` (rising) of y_i' = sum of c y_a y_b, equations[i] = [(c, a, b), ...]; mpmath
    numbers.

    A step is summed from 40 Taylor coefficients, found from the products of the lower ones, and is as long as
    the last two of them allow.
    """
    equations = [[(fixed(c), min(a, b), max(a, b)) for c, a, b in terms] for terms in equations]
    pairs = sorted({(a, b) for terms in equations for _, a, b in terms})
    state, t, out = [fixed(value) for value in start], 0, []
    for goal in map(fixed, times):
        while t < goal:
            series = [[value] for value in state]
            for n in range(ORDER):
                product = {
                    (a, b): sum(map(int.__mul__, series[a], series[b][::-1])) >> BITS for a, b in pairs
                }
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
    """Terms of q' = q w / 2 (body components) or w q / 2 (inertial ones); rate["w"][k] = [(c, place), ...]."""
    first = rate["q"]
    q = [first, first + 1, first + 2, first + 3]
    # rows of w_1, w_2, w_3 acting on (q0, q1, q2, q3) from the right; from the left the cross product changes
    # its sign
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


def torque_free(moments, w0, times):
    """Angular velocity (body axes) and quaternion of a torque-free body: Euler's equations and q' = q w / 2."""
    I1, I2, I3 = (Fraction(float(value)) for value in moments)
    euler = [[((I2 - I3) / I1, 1, 2)], [((I3 - I1) / I2, 0, 2)], [((I1 - I2) / I3, 0, 1)]]
    euler += quaternion_rates({"q": 3, "w": [[(Fraction(1), k)] for k in range(3)]})
    return solve(euler, [*(float(value) for value in w0), 1, 0, 0, 0], times)


def top(I_xi, I_zeta, mgL, theta0, spin, theta_rate0=0.0, psi_rate0=0.0, *, times):
    """H, axis e and quaternion of a top in inertial axes, z upward, psi = phi = 0 at first.

    H' = -m g L e x z,  e' = H x e / I_xi,  q' = w q / 2 with w = H / I_xi + Omega (1 - I_zeta / I_xi) e: no
    angle, no pole.
    """
    given = (I_xi, I_zeta, mgL, theta0, spin, theta_rate0, psi_rate0)
    with mpmath.workprec(BITS + 30):
        A, C, W, theta, Omega, theta_rate, psi_rate = (mpmath.mpf(float(value)) for value in given)
        s, c = mpmath.sin(theta), mpmath.cos(theta)
        e = [mpmath.mpf(0), -s, c]
        # w = theta' x + psi' z + (Omega - psi' c) e
        w = [theta_rate, (Omega - psi_rate * c) * e[1], psi_rate + (Omega - psi_rate * c) * c]
        H = [A * w[k] + (C - A) * Omega * e[k] for k in range(3)]
        start = [*H, *e, mpmath.cos(theta / 2), mpmath.sin(theta / 2), mpmath.mpf(0), mpmath.mpf(0), 1]
    A, C, W, Omega = (Fraction(float(value)) for value in (I_xi, I_zeta, mgL, spin))
    rates = [[(-W, 4, 10)], [(W, 3, 10)], []]  # -W (e_y, -e_x, 0); place 10 holds the number 1
    rates += [
        [(1 / A, (k + 1) % 3, 3 + (k + 2) % 3), (-1 / A, (k + 2) % 3, 3 + (k + 1) % 3)] for k in range(3)
    ]
    rates += quaternion_rates(
        {"q": 6, "w": [[(1 / A, k), (Omega * (1 - C / A), 3 + k)] for k in range(3)]}, body=False
    )
    rates.append([])
    return [state[:10] for state in solve(rates, start, times)]


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
