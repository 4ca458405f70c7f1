"""freebody.exact: bodies and tops that turn, against ODEs written here and integrated to 20 digits."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from numpy.testing import assert_allclose

from freebody import exact
from freebody.errors import ModelError

ALGEBRA = 64 * np.finfo(float).eps
TOP = {"I_xi": 0.01308, "I_zeta": 0.00216, "mgL": 1.2 * 9.81 * 0.1}


def solution(rates, start, times):
    """States at ``times`` of y' = rates(y), by mpmath's Taylor method at 20 digits."""
    with mpmath.workdps(20):
        solve = mpmath.odefun(lambda t, y: rates(y), 0, [mpmath.mpf(value) for value in start])
        return np.array([[float(value) for value in solve(mpmath.mpf(t))] for t in times])


def euler_rates(moments):
    """Euler's equations of a torque-free body with R_NB (rows) carried along: R' = R [w]."""
    I1, I2, I3 = (mpmath.mpf(value) for value in moments)

    def rates(y):
        w1, w2, w3 = y[:3]
        out = [(I2 - I3) / I1 * w2 * w3, (I3 - I1) / I2 * w3 * w1, (I1 - I2) / I3 * w1 * w2]
        for row in range(3):
            a, b, c = y[3 + 3 * row : 6 + 3 * row]
            out += [b * w3 - c * w2, c * w1 - a * w3, a * w2 - b * w1]
        return out

    return rates


IDENTITY = [1, 0, 0, 0, 1, 0, 0, 0, 1]


@pytest.mark.parametrize(
    "I1, I3, w1, w3", [(1.0, 1.8, 0.5, 6.0), (1.8, 0.4, 0.5, 6.0), (1.0, 1.5, 0.7, -2.0)]
)
def test_symmetric_body_turns_as_its_equations_say(I1, I3, w1, w3):
    times = [0.3, 1.0, 2.0]
    motion = exact.torque_free_symmetric(I1, I3, w1, w3, times)
    expected = solution(euler_rates((I1, I1, I3)), [w1, 0, w3, *IDENTITY], times)
    assert_allclose(motion.omega, expected[:, :3], rtol=0, atol=ALGEBRA * 6)
    assert_allclose(motion.attitude.reshape(3, 9), expected[:, 3:], rtol=0, atol=ALGEBRA)


def test_symmetric_body_keeps_its_momentum_and_its_cones():
    times = np.linspace(0, 5, 11)
    I1, I3 = 1.0, 1.8
    motion = exact.torque_free_symmetric(I1, I3, 0.5, 6.0, times)
    momentum = np.einsum("tij,tj->ti", motion.attitude, motion.omega * [I1, I1, I3])
    assert_allclose(momentum, np.tile(motion.momentum, (11, 1)), atol=ALGEBRA * 11)
    axis = motion.attitude[..., 2]
    direction = motion.momentum / np.linalg.norm(motion.momentum)
    assert_allclose(axis @ direction, np.cos(motion.alpha), atol=ALGEBRA)
    # (6.80): tan(alpha) = I_1 / I_3 tan(beta)
    assert_allclose(np.tan(motion.alpha), I1 / I3 * np.tan(motion.beta), rtol=ALGEBRA)
    # the body cone rolls on the space cone without slip: equal arcs per second
    body_arc = abs(motion.rate) * np.sin(motion.body_cone)
    assert_allclose(motion.precession_rate * np.sin(motion.space_cone), body_arc, rtol=ALGEBRA)


def test_symmetric_body_wobble_of_the_earth():
    # section 6.8, case (c): (I_3 - I_1) / I_1 = 0.0033, one turn a day: about 303 days
    motion = exact.torque_free_symmetric(1.0, 1.0033, 1e-6, 2 * np.pi)
    assert_allclose(2 * np.pi / motion.rate, 1 / 0.0033, rtol=1e-12)


def test_symmetric_body_without_angular_velocity_rests():
    motion = exact.torque_free_symmetric(1.0, 2.0, 0.0, 0.0, 3.0)
    assert_allclose(motion.attitude, np.eye(3))
    assert motion.precession_rate == 0


@pytest.mark.parametrize(
    "order, w0",
    [
        ((0, 1, 2), (0.4, -1.5, 1.2)),
        ((1, 0, 2), (1.3, 0.6, -0.2)),
        ((2, 1, 0), (-0.3, 2.0, 0.1)),
        ((1, 2, 0), (0.2, -0.3, -1.4)),
        ((0, 2, 1), (0.4, 1.5, -1.2)),
        ((2, 0, 1), (-1.3, 0.6, 0.2)),
    ],
)
def test_asymmetric_body_in_every_order_of_axes(order, w0):
    moments = np.array([1.0, 1.7, 2.4])[list(order)]
    times = [0.5, 1.7, 4.0]
    rates = euler_rates(moments)
    expected = solution(lambda y: rates([*y, *[0] * 9])[:3], w0, times)
    assert_allclose(exact.torque_free(moments, w0, times), expected, rtol=0, atol=1e-13)
    assert_allclose(exact.torque_free(moments, w0, 0.0), w0, rtol=0, atol=1e-14)


def test_asymmetric_body_flips_and_keeps_energy_and_momentum():
    moments, w0 = np.array([1.0, 2.0, 3.0]), np.array([0.01, 3.0, 0.02])
    omega = exact.torque_free(moments, w0, np.linspace(0, 60, 2001))
    assert omega[:, 1].min() < -2.99  # rotation about the middle axis turns over
    assert_allclose(omega**2 @ moments, w0**2 @ moments, rtol=1e-12)
    assert_allclose(omega**2 @ moments**2, w0**2 @ moments**2, rtol=1e-12)


def test_asymmetric_body_with_equal_moments_is_the_symmetric_one():
    t = np.linspace(0, 3, 7)
    for I1, I3 in ((1.0, 1.8), (1.8, 0.4)):
        expected = exact.torque_free_symmetric(I1, I3, 0.5, 6.0, t).omega
        assert_allclose(exact.torque_free((I1, I1, I3), (0.5, 0, 6.0), t), expected, atol=1e-13)
        rolled = exact.torque_free((I3, I1, I1), (6.0, 0.5, 0), t)
        assert_allclose(rolled, np.roll(expected, 1, axis=-1), atol=1e-13)
    assert_allclose(exact.torque_free((2, 2, 2), (1, 2, 3), 5.0), (1, 2, 3))


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_rotation_about_a_principal_axis_is_steady(axis):
    w0 = np.zeros(3)
    w0[axis] = -1.5
    assert_allclose(exact.torque_free((1, 2, 3), w0, [0.0, 4.0]), [w0, w0], atol=1e-15)


def test_impossible_moments_are_refused():
    with pytest.raises(ModelError, match=r"three positive principal moments of inertia, got \(1, 0, 2\)"):
        exact.torque_free((1, 0, 2), (1, 1, 1), 0.0)
    with pytest.raises(ModelError, match="three positive principal moments"):
        exact.torque_free_symmetric(-1, 2, 1, 1)


# -- gyroscope -----------------------------------------------------------------------------------


def top_rates(I_xi, I_zeta, mgL, spin):
    """The top by Lagrange's equations in psi, theta, phi: not the form in exact/."""
    A, C, W, spin = (mpmath.mpf(value) for value in (I_xi, I_zeta, mgL, spin))

    def rates(y):
        theta, theta_rate, psi, psi_rate, phi = y
        s, c = mpmath.sin(theta), mpmath.cos(theta)
        phi_rate = spin - psi_rate * c
        theta_acc = (A * psi_rate**2 * s * c - C * (phi_rate + psi_rate * c) * psi_rate * s + W * s) / A
        # d/dt (A psi' s² + C spin c) = 0
        psi_acc = (C * spin * s * theta_rate - 2 * A * psi_rate * s * c * theta_rate) / (A * s**2)
        return [theta_rate, theta_acc, psi_rate, psi_acc, phi_rate]

    return rates


def test_moments_of_the_gyroscope():
    I_xi, I_zeta = exact.gyroscope_moments(1.2, 0.06, 0.1)
    assert_allclose((I_xi, I_zeta), (1.2 * 0.0036 / 4 + 0.012, 1.2 * 0.0036 / 2), rtol=ALGEBRA)


@pytest.mark.parametrize(
    "theta0, spin, times",
    [
        (np.pi / 3, 300.0, (0.05, 0.4)),
        (np.pi / 3, 40.0, (0.1, 0.3)),
        (2.0, -120.0, (0.2, 0.5)),
        (0.4, 5.0, (0.2, 0.3)),
    ],
)
def test_top_let_go_from_rest(taylor, theta0, spin, times):
    motion = exact.top_from_rest(**TOP, theta0=theta0, spin=spin, t=times)
    I_xi, I_zeta, mgL = TOP.values()
    state = np.array(taylor.top(I_xi, I_zeta, mgL, theta0, spin, times=times), dtype=float)
    (H_x, H_y, H_z), (e_x, e_y, e_z), (q0, _, _, q3) = state[:, :3].T, state[:, 3:6].T, state[:, 6:].T
    sine = np.hypot(e_x, e_y)
    # e = (sin(psi) sin(theta), -cos(psi) sin(theta), cos(theta)), e' = H x e / I_xi
    assert_allclose(motion.theta, np.arctan2(sine, e_z), rtol=0, atol=1e-13)
    assert_allclose(motion.theta_rate, (H_y * e_x - H_x * e_y) / (I_xi * sine), rtol=0, atol=1e-11)
    assert_allclose(np.exp(1j * motion.psi), (-e_y + 1j * e_x) / sine, rtol=0, atol=1e-12)
    psi_rate = (H_z - I_zeta * spin * e_z) / (I_xi * sine**2)
    assert_allclose(motion.psi_rate, psi_rate, rtol=0, atol=1e-11)
    half = (q0 + 1j * q3) / np.hypot(q0, q3)  # (psi + phi) / 2 is its angle
    assert_allclose(np.exp(1j * (motion.psi + motion.phi)), half**2, rtol=0, atol=1e-11)
    assert_allclose(motion.phi_rate, spin - motion.psi_rate * np.cos(motion.theta), rtol=0, atol=1e-12)


def test_top_let_go_from_rest_keeps_its_integrals_over_many_nutations():
    I_xi, I_zeta, mgL = TOP.values()
    t = np.linspace(0, 40, 4001)
    motion = exact.top_from_rest(**TOP, theta0=1.0, spin=250.0, t=t)
    u = np.cos(motion.theta)
    energy = I_xi * (motion.theta_rate**2 + (motion.psi_rate * np.sin(motion.theta)) ** 2) / 2 + mgL * u
    assert_allclose(energy, mgL * np.cos(1.0), rtol=1e-11)
    about_vertical = I_xi * motion.psi_rate * np.sin(motion.theta) ** 2 + I_zeta * 250.0 * u
    assert_allclose(about_vertical, I_zeta * 250.0 * np.cos(1.0), rtol=1e-12)
    assert motion.theta.max() <= motion.theta_max + 1e-12
    assert_allclose(motion.theta.max(), motion.theta_max, atol=1e-4)
    # psi is continuous and is the integral of its rate (trapezoid, step 0.01)
    assert_allclose(motion.psi[-1], np.trapezoid(motion.psi_rate, t), rtol=3e-5)
    later = exact.top_from_rest(**TOP, theta0=1.0, spin=250.0, t=3 * motion.period)
    assert_allclose(later.theta, 1.0, atol=1e-12)
    assert_allclose(
        later.psi, 3 * exact.top_from_rest(**TOP, theta0=1.0, spin=250.0, t=motion.period).psi, rtol=1e-10
    )


def test_top_without_spin_is_a_pendulum():
    I_xi, _, mgL = TOP.values()
    rate, t = np.sqrt(mgL / I_xi), np.linspace(0, 2, 9)
    motion = exact.top_from_rest(**TOP, theta0=2.2, spin=0.0, t=t)
    swing, swing_rate = exact.pendulum(np.pi - 2.2, rate, t)
    assert_allclose(np.pi - motion.theta, abs(swing), atol=1e-12)
    assert_allclose(abs(motion.theta_rate), abs(swing_rate), atol=1e-11)
    assert_allclose(motion.period, exact.pendulum_period(np.pi - 2.2, rate) / 2, rtol=1e-13)
    assert_allclose(motion.theta_max, np.pi)


def test_fast_top_nutates_little_at_the_frequency_of_its_spin():
    I_xi, I_zeta, mgL = TOP.values()
    motion = exact.top_from_rest(**TOP, theta0=1.0, spin=1e5, t=0.0)
    assert_allclose(motion.period, 2 * np.pi * I_xi / (I_zeta * 1e5), rtol=1e-6)
    # theta_max - theta_0 = 2 I_xi m g L sin(theta_0) / (I_zeta Omega)² to first order
    assert_allclose(motion.theta_max - 1.0, 2 * I_xi * mgL * np.sin(1.0) / (I_zeta * 1e5) ** 2, rtol=1e-5)


@pytest.mark.parametrize("theta", [0.3, np.pi / 3, np.pi / 2, 2 * np.pi / 3])
@pytest.mark.parametrize("fast", [False, True])
def test_steady_precession_stays_steady(theta, fast):
    spin = 300.0
    rate = exact.steady_precession(**TOP, theta=theta, spin=spin)[0 if fast else 1]
    if np.isinf(rate) or abs(rate) > 1e6:
        assert abs(np.cos(theta)) < 1e-15  # only the fast rate of a horizontal shaft has no bound
        return
    acceleration = top_rates(*TOP.values(), spin)([mpmath.mpf(v) for v in (theta, 0, 0, rate, 0)])[1]
    assert abs(float(acceleration)) < 1e-13 * rate**2 + 1e-12


def test_steady_precession_ends_where_its_rates_meet():
    least = exact.least_spin(**TOP, theta=np.pi / 3)
    fast, slow = exact.steady_precession(**TOP, theta=np.pi / 3, spin=least * (1 + 1e-12))
    assert_allclose(fast, slow, rtol=1e-5)
    with pytest.raises(
        ModelError, match=r"No steady precession at theta = 1\.0472 rad .* at least 81\.\d+ rad/s"
    ):
        exact.steady_precession(**TOP, theta=np.pi / 3, spin=0.99 * least)
    assert exact.least_spin(**TOP, theta=2.0) == 0
    assert_allclose(exact.sleeping_spin(**TOP), exact.least_spin(**TOP, theta=0.0))


def test_sleeping_spin_is_where_the_upright_top_begins_to_leave():
    # a top let go very near the vertical stays near it above the threshold, and leaves below
    least = exact.sleeping_spin(**TOP)
    assert exact.top_from_rest(**TOP, theta0=1e-4, spin=1.1 * least).theta_max < 1e-3
    assert exact.top_from_rest(**TOP, theta0=1e-4, spin=0.9 * least).theta_max > 0.5


def test_small_oscillation_is_the_limit_of_the_motion():
    theta0, spin, times = np.pi / 3, 300.0, [0.03, 0.1]
    slow = exact.steady_precession(**TOP, theta=theta0, spin=spin)[1]
    errors = []
    for size in (1e-3, 1e-4):
        w_xi, w_eta = 0.5 * size, 0.8 * size
        linear = exact.precession_response(**TOP, theta0=theta0, spin=spin, w_xi=w_xi, w_eta=w_eta, t=times)
        start = [theta0, w_xi, 0, slow + w_eta / np.sin(theta0), 0]
        expected = solution(top_rates(*TOP.values(), spin), start, times)
        errors.append(max(abs(linear.theta - expected[:, 0]).max(), abs(linear.psi - expected[:, 2]).max()))
    assert errors[0] < 1e-6 and errors[1] < errors[0] / 50  # second order


def test_refusals_of_the_top():
    with pytest.raises(ModelError, match="theta0 between 0 and pi"):
        exact.top_from_rest(**TOP, theta0=0.0, spin=10.0)
    with pytest.raises(ModelError, match="positive moment mgL of the weight, got -1"):
        exact.top_from_rest(0.01, 0.01, -1.0, 1.0, 10.0)
