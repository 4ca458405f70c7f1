"""freebody.exact: planar machines, against Lagrange's equations of their points, formed by SymPy."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
import sympy
from numpy.testing import assert_allclose

from freebody import exact
from freebody.errors import ModelError

RANDOM = np.random.default_rng(0)
t, s = sympy.symbols("t s")


def lagrange(kinetic, potential, coordinates, loads):
    """Accelerations as functions of (q, q'), from d/dt dL/dq' - dL/dq = Q."""
    q = [sympy.Function(f"q{i}")(t) for i in range(coordinates)]
    L = kinetic(q) - potential(q)
    Q = loads(q)
    rows = [
        sympy.diff(sympy.diff(L, qi.diff(t)), t) - sympy.diff(L, qi) - Qi for qi, Qi in zip(q, Q, strict=True)
    ]
    acc = sympy.symbols(f"a0:{coordinates}")
    rows = [row.subs({qi.diff(t, 2): ai for qi, ai in zip(q, acc, strict=True)}) for row in rows]
    plain = sympy.symbols(f"x0:{coordinates} v0:{coordinates}")
    names = {qi.diff(t): v for qi, v in zip(q, plain[coordinates:], strict=True)}
    rows = [row.subs(names).subs(dict(zip(q, plain, strict=False))) for row in rows]
    matrix, right = sympy.linear_eq_to_matrix(rows, acc)
    matrix, right = sympy.lambdify([plain], matrix, "numpy"), sympy.lambdify([plain], right, "numpy")
    return lambda state: np.linalg.solve(matrix(state), right(state))[:, 0]


def bar_energy(m, length, start, direction):
    """Kinetic energy of a uniform bar, by integration over its points ``start + s length direction``."""
    point = [p + s * length * d for p, d in zip(start, direction, strict=True)]
    return sympy.integrate(sum(sympy.diff(p, t) ** 2 for p in point) * m / 2, (s, 0, 1))


def test_cart_and_bar_accelerations():
    M, m, a, k, F, g = (sympy.Rational(v) for v in ("2", "1", "1/2", "50", "3", "9.81"))
    solve = lagrange(
        lambda q: (
            M * q[0].diff(t) ** 2 / 2 + bar_energy(m, 2 * a, (q[0], 0), (sympy.sin(q[1]), -sympy.cos(q[1])))
        ),
        lambda q: k * q[0] ** 2 / 2 - m * g * a * sympy.cos(q[1]) - F * (q[0] + 2 * a * sympy.sin(q[1])),
        2,
        lambda q: (0, 0),
    )
    for state in RANDOM.uniform(-2, 2, (5, 4)):
        motion = exact.cart_and_bar(*state)
        assert_allclose((motion.x_acceleration, motion.theta_acceleration), solve(state), rtol=1e-12)


def test_cart_and_bar_forces_balance_every_body():
    M, m, a, k, F, g = 2.0, 1.0, 0.5, 50.0, 3.0, 9.81
    x, theta, v, w = RANDOM.uniform(-2, 2, (4, 6))
    motion = exact.cart_and_bar(x, theta, v, w)
    hx, hy = motion.hinge.T  # on the particle
    assert_allclose(-k * x + hx, M * motion.x_acceleration, rtol=1e-12)
    assert_allclose(motion.ground + hy - M * g, 0, atol=1e-12)
    # moment about the bar's centre of -hinge at the top and F at the bottom, (e) of the example
    moment = a * np.cos(theta) * (F + hx) + a * np.sin(theta) * hy
    assert_allclose(moment, m * a**2 / 3 * motion.theta_acceleration, rtol=1e-11, atol=1e-12)
    # power of F is the rate of the energy: d/dt by the chain rule, central difference of the flow
    step = 1e-6

    def energy(sign):
        h = sign * step
        return exact.cart_and_bar(
            x + h * v, theta + h * w, v + h * motion.x_acceleration, w + h * motion.theta_acceleration
        ).energy

    power = F * (v + 2 * a * np.cos(theta) * w)
    assert_allclose((energy(1) - energy(-1)) / (2 * step), power, rtol=1e-6, atol=1e-6)


def test_double_pendulum_accelerations_and_energy():
    m1, m2, L1, L2, g = (sympy.Rational(v) for v in ("2", "1", "4/5", "3/5", "9.81"))

    def kinetic(q):
        d1, d2 = ((sympy.sin(angle), -sympy.cos(angle)) for angle in q)
        return bar_energy(m1, L1, (0, 0), d1) + bar_energy(m2, L2, (L1 * d1[0], L1 * d1[1]), d2)

    def potential(q):
        return -m1 * g * L1 / 2 * sympy.cos(q[0]) - m2 * g * (L1 * sympy.cos(q[0]) + L2 / 2 * sympy.cos(q[1]))

    solve = lagrange(kinetic, potential, 2, lambda q: (0, 0))
    for state in RANDOM.uniform(-2, 2, (5, 4)):
        assert_allclose(exact.double_pendulum(*state).accelerations, solve(state), rtol=1e-12)


def test_double_pendulum_forces():
    m1, m2, L1, L2, g = 2.0, 1.0, 0.8, 0.6, 9.81
    state = RANDOM.uniform(-2, 2, (4, 6))
    motion = exact.double_pendulum(*state)
    (th1, th2, _, _), (a1, a2) = state, motion.accelerations.T
    # moment balances about each centre: both pin forces act there
    lever1, lever2 = (
        L1 / 2 * np.array([np.sin(th1), -np.cos(th1)]),
        L2 / 2 * np.array([np.sin(th2), -np.cos(th2)]),
    )

    def cross(r, f):
        return r[0] * f[1] - r[1] * f[0]

    joint, support = motion.joint.T, motion.support.T
    assert_allclose(cross(-lever2, joint), m2 * L2**2 / 12 * a2, rtol=1e-10, atol=1e-12)
    assert_allclose(
        cross(-lever1, support) + cross(lever1, -joint), m1 * L1**2 / 12 * a1, rtol=1e-10, atol=1e-12
    )
    rest = exact.double_pendulum(0.0, 0.0, 0.0, 0.0)
    assert_allclose(rest.support, (0, (m1 + m2) * g), rtol=1e-14, atol=1e-14)
    assert_allclose(rest.joint, (0, m2 * g), rtol=1e-14, atol=1e-14)


@pytest.mark.slow
def test_double_pendulum_keeps_its_energy_in_a_20_digit_motion():
    with mpmath.workdps(20):
        # the start of Problem 6.15, from Hamilton's equations
        A, B, D = mpmath.mpf("1.0666666666666666666666667"), mpmath.mpf("0.24"), mpmath.mpf("0.12")
        k1, k2 = (
            mpmath.mpf("2") * mpmath.mpf("9.81") * mpmath.mpf("0.8"),
            mpmath.mpf("0.3") * mpmath.mpf("9.81"),
        )

        def rates(_, y):
            th1, th2, p1, p2 = y
            c, sn = mpmath.cos(th1 - th2), mpmath.sin(th1 - th2)
            det = A * D - (B * c) ** 2
            w1, w2 = (D * p1 - B * c * p2) / det, (A * p2 - B * c * p1) / det
            return [w1, w2, -B * sn * w1 * w2 - k1 * mpmath.sin(th1), B * sn * w1 * w2 - k2 * mpmath.sin(th2)]

        y = mpmath.odefun(rates, 0, [mpmath.mpf("0.5"), mpmath.mpf(1), mpmath.mpf(0), mpmath.mpf(0)])(
            mpmath.mpf(1)
        )
        c = mpmath.cos(y[0] - y[1])
        det = A * D - (B * c) ** 2
        state = [
            float(v) for v in (y[0], y[1], (D * y[2] - B * c * y[3]) / det, (A * y[3] - B * c * y[2]) / det)
        ]
    start = exact.double_pendulum(0.5, 1.0, 0.0, 0.0).energy
    assert_allclose(exact.double_pendulum(*state).energy, start, rtol=1e-13)


def test_double_pendulum_frequencies_are_those_of_the_linear_equations():
    low, high = exact.double_pendulum_frequencies()
    size = 1e-5  # the Jacobian of the accelerations, by central differences
    forth, back = (exact.double_pendulum(*(step * np.eye(2)), 0, 0).accelerations for step in (size, -size))
    jacobian = (forth - back).T / (2 * size)
    assert_allclose(np.sort(np.sqrt(-np.linalg.eigvals(jacobian))), (low, high), rtol=1e-8)


def test_hinged_bar_from_the_pendulum_it_is():
    m, L, g = 3.0, 1.5, 9.81
    bar = exact.hinged_bar(m, L)
    inertia = sum(m / 1000 * (((i + 0.5) / 1000 - 1 / 3) * L) ** 2 for i in range(1000))  # midpoint rule
    assert_allclose(bar.alpha, m * g * L / 6 / inertia, rtol=1e-5)
    assert_allclose(bar.omega_vertical, np.sqrt(2 * m * g * L / 6 / inertia), rtol=1e-5)
    assert_allclose(bar.energy_vertical, m * g * L / 6, rtol=1e-15)
    assert_allclose(bar.reaction_start, m * (g - bar.alpha * L / 6), rtol=1e-15)
    assert_allclose(bar.reaction_vertical, m * (g + bar.omega_vertical**2 * L / 6), rtol=1e-15)


@pytest.mark.parametrize("amplitude", [1e-3, 0.5, 2.0, 3.1])
def test_pendulum(amplitude):
    rate, times = 1.3, [0.4, 1.9, 3.0]
    with mpmath.workdps(20):
        w2 = mpmath.mpf(rate) ** 2
        solve = mpmath.odefun(
            lambda _, y: [y[1], -w2 * mpmath.sin(y[0])], 0, [mpmath.mpf(amplitude), mpmath.mpf(0)]
        )
        expected = np.array([[float(v) for v in solve(time)] for time in times])
        k = mpmath.sin(mpmath.mpf(amplitude) / 2)
        period = float(4 * mpmath.ellipk(k**2) / mpmath.mpf(rate))
    theta, theta_rate = exact.pendulum(amplitude, rate, times)
    assert_allclose(theta, expected[:, 0], rtol=0, atol=2e-13 * amplitude)
    assert_allclose(theta_rate, expected[:, 1], rtol=0, atol=2e-13 * amplitude)
    assert_allclose(exact.pendulum_period(amplitude, rate), period, rtol=1e-14)
    assert_allclose(exact.pendulum(amplitude, rate, period)[0], amplitude, rtol=1e-12)


def test_pendulum_refusals_and_limits():
    assert_allclose(exact.pendulum_period(0.0, 2.0), np.pi, rtol=1e-15)
    with pytest.raises(ModelError, match="amplitude from 0 to pi, pi excluded, got 3.5 rad"):
        exact.pendulum_period(3.5, 1.0)
    with pytest.raises(ModelError, match="amplitude between -pi and pi"):
        exact.pendulum(-3.2, 1.0, 0.0)
