"""exact.top: angles, rates and attitude against integer Taylor series of 33 digits in other variables."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from freebody import exact
from freebody.errors import ModelError

EPS = np.finfo(float).eps
HUNDRED = json.loads((Path(__file__).parent / "hundred_periods.json").read_text(encoding="utf-8"))
TOPS = [case for case in HUNDRED if case["body"] == "top"]
TOP = (0.01308, 0.00216, 1.1772)  # I_xi, I_zeta, m g L of the gyroscope of section 6.9
SLEEP = float(exact.sleeping_spin(*TOP))
STEADY = float(exact.steady_precession(*TOP, theta=1.0, spin=300.0)[1])
#: Measured: 3e-15 at most, but 1.1e-14 after 100 periods of 7 s at 250 rad/s.
ANGLE = 64 * EPS


def compare(taylor, arguments, fractions, span=None):
    """Axis, attitude (sign of the quaternion included), angles and rates at fractions of the period."""
    motion = exact.top(*arguments)
    times = (span or motion.period) * np.array(fractions)
    state = np.array(taylor.top(*arguments, times=list(times)), dtype=float)
    check(motion, arguments, times, state)
    return motion


def check(motion, arguments, times, state):
    I_xi, I_zeta, mgL, _, spin, *_ = arguments
    H, axis, q = state[:, :3], state[:, 3:6], state[:, 6:10]
    # the phase of a whirling axis is as uncertain as its total angle in doubles
    psi = motion.psi(times)
    turned = EPS * (1 + abs(psi)).max()
    assert_allclose(motion.axis(times), axis, rtol=0, atol=ANGLE + turned)
    # so is the attitude, by the angle turned in one period
    whirl = EPS * np.nan_to_num(abs(motion.psi_advance) + abs(motion.phi_advance))
    assert_allclose(motion.quaternion(times), q, rtol=0, atol=ANGLE + whirl)
    assert_allclose(abs(np.sin(motion.theta(times))), np.hypot(*axis.T[:2]), rtol=64 * EPS, atol=8 * EPS)
    # theta' sin(theta) = -e_z', psi' sin²(theta) = (H_z - I_zeta Omega e_z) / I_xi, with e' = H x e / I_xi
    theta_rate, psi_rate, phi_rate = motion.theta_rate(times), motion.psi_rate(times), motion.phi_rate(times)
    scale = np.linalg.norm(H, axis=1).max() / I_xi + abs(spin)
    falls = -(H[:, 0] * axis[:, 1] - H[:, 1] * axis[:, 0]) / I_xi
    assert_allclose(theta_rate * np.sin(motion.theta(times)), falls, rtol=0, atol=ANGLE * scale)
    sine2 = np.sin(motion.theta(times)) ** 2
    vertical = (H[:, 2] - I_zeta * spin * axis[:, 2]) / I_xi
    assert_allclose(psi_rate * sine2, vertical, rtol=0, atol=ANGLE * scale)
    assert_allclose(
        phi_rate + psi_rate * np.cos(motion.theta(times)),
        spin,
        rtol=0,
        atol=ANGLE * (abs(spin) + abs(psi_rate).max()),
    )
    # half of psi + phi is the angle of (q0, q3): the single angles, where the Euler angles are no angles near a pole
    where = abs(np.sin(motion.theta(times))) > 1e-3
    total = motion.phi(times)[where] + psi[where]
    size = np.hypot(q[where, 0], q[where, 3])
    much = EPS * (1 + abs(psi) + abs(motion.phi(times))).max()
    assert_allclose(
        size * np.cos(total / 2) * np.sign(np.cos(motion.theta(times)[where] / 2)),
        q[where, 0],
        atol=ANGLE + much,
    )


PATHS = {
    "cusp": (*TOP, 1.0, 200.0),
    "cusp, spin backwards": (*TOP, 1.0, -200.0),
    "loop": (*TOP, 1.0, 200.0, 0.5, -2.0),
    "wave": (*TOP, 1.0, 200.0, 0.3, 2.0),
    "wave below the pivot": (*TOP, 2.5, -20.0, 0.3, 2.0),
    "loop near the vertical": (*TOP, 1e-3, 100.0, 5.0, 3.0),
    "loop, 1e-9 from the vertical": (*TOP, 1e-9, 100.0, 5.0),
    "through the vertical": (*TOP, 0.0, 100.0, 5.0),
    "through the vertical backwards": (*TOP, 0.0, -30.0, -5.0),
    "wave of a spherical pendulum": (*TOP, 1.5, 0.0, 0.3, 2.0),
    "wave of an almost plane pendulum": (*TOP, 1.5, 0.0, 0.3, 1e-9),
    "plane swing": (*TOP, 1.5, 0.0, 0.3),
    "plane swing upwards": (*TOP, 1.5, 0.0, -0.3),
    "plane rotation": (*TOP, 1.5, 0.0, 20.0),
    "plane rotation upwards": (*TOP, 1.5, 0.0, -20.0),
    "plane rotation from the top": (*TOP, 0.0, 0.0, -0.5),
    "loop of a fast top": (*TOP, 1.0, 2e4, 0.3, 2.0),
    "steady": (*TOP, 1.0, 300.0, 0.0, STEADY),
    "steady at the bottom": (*TOP, np.pi, 100.0),
    "loop through the bottom": (*TOP, np.pi, 100.0, 1.0),
    "wave of a rod": (0.01, 0.0, 1.0, 2.0, 5.0, 1.0, 2.0),
    "wave of a flat body": (0.01, 0.02, 1.0, 0.3, 5.0, 1.0, 20.0),
}


@pytest.mark.parametrize("name", PATHS)
def test_a_period_of_every_path(taylor, name):
    motion = compare(taylor, PATHS[name], [0.07, 0.31, 0.5, 0.69, 0.93, 1.0, 1.3])
    assert name.startswith(motion.path)


@pytest.mark.parametrize(
    "arguments, path, complementary",
    [
        ((*TOP, 1e-6, 0.9 * SLEEP), "cusp", 7e-12),
        ((*TOP, 1e-9, 0.5 * SLEEP, 1e-9, 3.0), "wave", 3.4e-19),
        ((*TOP, 1e-6, 0.0, 0.0, 1e-6), "wave", 2.5e-13),
        ((*TOP, 1e-8, 0.0), "plane swing", 2.5e-17),
        ((*TOP, 0.0, 0.0, 1e-8), "plane rotation", 2.8e-19),
        ((*TOP, 1e-6, 1.1 * SLEEP), "cusp", 1.0),
    ],
)
def test_a_period_near_the_sleeping_top(taylor, arguments, path, complementary):
    motion = compare(taylor, arguments, [0.03, 0.2, 0.45, 0.5, 0.55, 0.8, 0.99])
    assert motion.path == path
    assert_allclose(motion.complementary, complementary, rtol=0.05)


@pytest.mark.parametrize("case", TOPS, ids=[case["name"] for case in TOPS])
def test_a_hundred_periods(case):
    motion = exact.top(*case["arguments"])
    assert max(case["times"]) > 99.9 * motion.period
    check(motion, case["arguments"], np.array(case["times"]), np.array(case["states"]))


@pytest.mark.slow
@pytest.mark.parametrize("case", TOPS, ids=[case["name"] for case in TOPS])
def test_the_stored_hundred_periods_are_those_of_the_taylor_series(taylor, case):
    found = np.array(taylor.top(*case["arguments"], times=case["times"]), dtype=float)
    assert_allclose(found, case["states"], rtol=0, atol=EPS)


def test_the_reference_agrees_with_the_thirty_digits_of_the_benchmarks(taylor):
    # benchmarks/references.json was integrated in other variables by other code
    motion = json.loads((Path(__file__).parents[2] / "benchmarks" / "references.json").read_text())[
        "heavy_top"
    ]
    p = {name: float(value) for name, value in motion["parameters"].items()}
    I_xi, I_zeta = exact.gyroscope_moments(p["m"], p["R"], p["L"])
    theta0 = np.arccos(p["cos_theta0"])
    found = exact.top(I_xi, I_zeta, p["m"] * p["g"] * p["L"], theta0, p["spin"])
    times = np.array(motion["times"], dtype=float)
    q, expected = found.quaternion(times), np.array(motion["quaternions"], dtype=float)
    q *= np.sign((q * expected).sum(axis=1))[:, None]
    assert_allclose(q, expected, rtol=0, atol=2e-12)  # theta0 and the moments are rounded here


# -- limits and classes ----------------------------------------------------------------------------


@pytest.mark.parametrize(
    "name", ["cusp", "loop", "wave", "wave below the pivot", "wave of a spherical pendulum"]
)
def test_limits_and_advances(name):
    arguments = PATHS[name]
    motion = exact.top(*arguments)
    t = np.linspace(0, 2 * motion.period, 4001)
    theta = motion.theta(t)
    assert_allclose([theta.min(), theta.max()], [motion.theta_min, motion.theta_max], rtol=0, atol=1e-5)
    assert theta.min() >= motion.theta_min - ANGLE and theta.max() <= motion.theta_max + ANGLE
    # roots of f(u) = (1 - u²) (alpha - beta u) - (b - a u)²
    I_xi, I_zeta, mgL, theta0, spin, theta_rate, psi_rate = (*arguments, 0.0, 0.0)[:7]
    u, a, beta = np.cos(theta0), I_zeta * spin / I_xi, 2 * mgL / I_xi
    b = psi_rate * np.sin(theta0) ** 2 + a * u
    alpha = theta_rate**2 + psi_rate**2 * np.sin(theta0) ** 2 + beta * u
    cubic = [beta, -(alpha + a * a), 2 * a * b - beta, alpha - b * b]
    assert_allclose(motion.roots, np.sort(np.roots(cubic).real), rtol=1e-7)
    assert_allclose(np.cos([motion.theta_max, motion.theta_min]), motion.roots[:2], rtol=1e-14)
    later = t + 3 * motion.period
    assert_allclose(motion.psi(later) - motion.psi(t), 3 * motion.psi_advance, rtol=0, atol=1e-12)
    assert_allclose(motion.phi(later) - motion.phi(t), 3 * motion.phi_advance, rtol=0, atol=1e-11)
    assert_allclose(motion.precession_rate, motion.psi_advance / motion.period)


@pytest.mark.parametrize(
    "psi_rate, path", [(-2.0, "loop"), (-1e-3, "loop"), (0.0, "cusp"), (1e-3, "wave"), (2.0, "wave")]
)
def test_class_is_told_by_the_precession_at_the_upper_limit(psi_rate, path):
    # section 6.12: let go with a precession against, without, and with the sense of the slow one
    motion = exact.top(*TOP, 1.0, 200.0, psi_rate0=psi_rate)
    assert motion.path == path
    rates = motion.psi_rate(np.linspace(0, motion.period, 1001))
    assert (rates.min() < -1e-12) == (path == "loop")
    assert_allclose(motion.psi_rate(0.0), psi_rate, rtol=0, atol=1e-13)


@pytest.mark.parametrize("fast", [False, True])
def test_steady_precession(fast):
    rate = exact.steady_precession(*TOP, theta=1.0, spin=300.0)[0 if fast else 1]
    motion = exact.top(*TOP, 1.0, 300.0, psi_rate0=rate)
    t = np.linspace(0, 10, 50)
    assert motion.path == "steady"
    assert_allclose(motion.theta(t), 1.0, rtol=0, atol=1e-13)
    assert_allclose(motion.psi(t), rate * t, rtol=1e-12)
    assert_allclose(motion.precession_rate, rate, rtol=1e-12)
    # its period is that of the small nutation about it
    slow = exact.precession_response(*TOP, theta0=1.0, spin=300.0, w_xi=0.0, w_eta=0.0, t=0.0)
    if not fast:
        assert_allclose(motion.period, 2 * np.pi / slow.frequency, rtol=1e-9)


def test_let_go_from_rest_as_the_older_formula_has_it():
    t = np.linspace(0, 1, 9)
    old = exact.top_from_rest(*TOP, theta0=1.0, spin=250.0, t=t)
    new = exact.top(*TOP, 1.0, 250.0)
    for name in ("theta", "psi", "phi", "theta_rate", "psi_rate", "phi_rate"):
        assert_allclose(getattr(new, name)(t), getattr(old, name), rtol=0, atol=1e-11)
    assert_allclose([new.theta_max, new.period], [old.theta_max, old.period], rtol=1e-13)


def test_the_plane_pendulum_swings_through_the_bottom_and_over_the_top():
    I_xi, _, mgL = TOP
    rate, t = np.sqrt(mgL / I_xi), np.linspace(0, 3, 31)
    swing = exact.top(*TOP, 0.9, 0.0)
    angle, angle_rate = exact.pendulum(np.pi - 0.9, rate, t)  # from the downward vertical
    assert_allclose(np.pi - swing.theta(t), angle, rtol=0, atol=1e-12)
    assert_allclose(-swing.theta_rate(t), angle_rate, rtol=0, atol=1e-11)
    assert_allclose(2 * swing.period, exact.pendulum_period(np.pi - 0.9, rate), rtol=1e-13)
    over = exact.top(*TOP, 0.9, 0.0, theta_rate0=-20.0)
    theta = over.theta(t)
    assert (np.diff(theta) < 0).all() and theta[-1] < -6 * np.pi  # theta goes on over the top
    assert_allclose(over.theta(t + over.period), theta - 2 * np.pi, rtol=0, atol=1e-12)
    energy = I_xi * over.theta_rate(t) ** 2 / 2 + mgL * np.cos(theta)
    assert_allclose(energy, I_xi * 200 + mgL * np.cos(0.9), rtol=1e-13)
    for path in (swing, over):
        assert_allclose(path.psi(t), 0)
        assert_allclose(path.phi(t), 0)


# -- upright ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("spin", [1.1 * SLEEP, 0.9 * SLEEP, 0.0])
def test_sleeping(spin):
    motion = exact.top(*TOP, 0.0, spin)
    t = np.array([0.0, 0.3, 50.0])
    assert motion.path == "sleeping" and motion.period == np.inf
    assert_allclose(motion.theta(t), 0)
    assert_allclose(motion.theta_rate(t), 0)
    assert_allclose(motion.psi(t) + motion.phi(t), spin * t, rtol=1e-14)
    assert_allclose(motion.psi_rate(t) + motion.phi_rate(t), spin, rtol=1e-14)
    assert_allclose(motion.quaternion(t)[:, 0], np.cos(spin * t / 2), rtol=0, atol=1e-11)
    # the roots tell whether it is stable: u_3 beyond the double root 1, or u_1 below it
    assert (motion.roots[2] > 1) == (spin > SLEEP) and 1.0 in motion.roots


@pytest.mark.parametrize("spin", [0.0, 30.0, -0.5 * SLEEP, 0.99 * SLEEP])
def test_asymptotic(taylor, spin):
    motion = exact.asymptotic_top(*TOP, spin)
    assert motion.path == "asymptotic" and motion.period == np.inf and motion.complementary == 0
    I_xi, I_zeta, mgL = TOP
    assert_allclose(np.cos(motion.theta_max), (I_zeta * spin) ** 2 / (2 * mgL * I_xi) - 1, rtol=1e-13)
    t = np.array([-3.0, -0.4, 0.0, 0.1, 0.3, 0.8])
    u, sine = np.cos(motion.theta(t)), np.sin(motion.theta(t))
    # energy and vertical momentum are those of the upright top
    energy = I_xi * (motion.theta_rate(t) ** 2 + (motion.psi_rate(t) * sine) ** 2) / 2 + mgL * u
    assert_allclose(energy, mgL, rtol=1e-13)
    assert_allclose(
        I_xi * motion.psi_rate(t) * sine**2 + I_zeta * spin * u, I_zeta * spin, rtol=1e-12, atol=1e-15
    )
    assert_allclose(np.sin(motion.theta([-60.0, 60.0])), 0, atol=1e-6)
    # from its lowest point, rounded to doubles, the same motion for as long as rounding is not yet magnified
    start = (*TOP, motion.theta(0.0), spin, motion.theta_rate(0.0), motion.psi_rate(0.0))
    times = [0.1, 0.2, 0.3]
    state = np.array(taylor.top(*start, times=times), dtype=float)
    assert_allclose(motion.axis(times), state[:, 3:6], rtol=0, atol=1e-13)
    assert_allclose(motion.quaternion(times), state[:, 6:10], rtol=0, atol=1e-12)


def test_the_period_near_the_sleeping_top_grows_as_a_logarithm():
    periods = [exact.top(*TOP, theta0, 0.5 * SLEEP).period for theta0 in (1e-5, 1e-7, 1e-9, 1e-11)]
    steps = np.diff(periods)
    assert_allclose(steps, steps[0], rtol=1e-6)
    # each factor 100 in theta_0 takes 2 ln(100) / growth rate; the rate is that of the upright top, sqrt(beta/2 - a²/4)
    I_xi, I_zeta, mgL = TOP
    growth = np.sqrt(mgL / I_xi - (I_zeta * 0.5 * SLEEP / I_xi) ** 2 / 4)
    assert_allclose(steps[0], 2 * np.log(100) / growth, rtol=1e-6)


def test_a_top_without_much_weight_is_a_torque_free_body():
    I_xi, I_zeta, _ = TOP
    top = exact.top(I_xi, I_zeta, 1e-13, 1.0, 40.0, 0.5, 2.0)
    # components of the angular velocity in the body at psi = phi = 0: (theta', psi' sin(theta), Omega)
    start = np.array([[1, 0, 0], [0, np.cos(1.0), -np.sin(1.0)], [0, np.sin(1.0), np.cos(1.0)]])
    free = exact.torque_free((I_xi, I_xi, I_zeta), (0.5, 2 * np.sin(1.0), 40.0), attitude=start)
    t = np.linspace(0, 2, 7)
    assert_allclose(top.attitude(t), free.attitude(t), rtol=0, atol=1e-8)
    assert_allclose(top.period, 2 * np.pi / free.cones.precession_rate, rtol=1e-8)


def test_angles_at_the_start_and_shapes():
    motion = exact.top(*TOP, 1.0, 200.0, psi0=0.7, phi0=-2.0)
    assert_allclose([motion.theta(0.0), motion.psi(0.0), motion.phi(0.0)], [1.0, 0.7, -2.0], rtol=1e-14)
    for shape in ((), (3,), (2, 3)):
        t = np.full(shape, 0.1)
        for name in ("theta", "psi", "phi", "theta_rate", "psi_rate", "phi_rate"):
            assert np.shape(getattr(motion, name)(t)) == shape
        assert motion.attitude(t).shape == (*shape, 3, 3)
        assert motion.axis(t).shape == (*shape, 3)
    assert_allclose(motion.attitude(0.3)[:, 2], motion.axis(0.3), rtol=0, atol=ANGLE)
    turned = exact.top(*TOP, 1.0, 200.0)
    assert_allclose(motion.theta(0.3), turned.theta(0.3))
    assert_allclose(motion.psi(0.3) - turned.psi(0.3), 0.7, rtol=1e-14)


def test_refusals():
    with pytest.raises(
        ModelError,
        match=r"positive moment mgL .* got 0 N m.* exact.torque_free\(\(I_xi, I_xi, I_zeta\), w0\)",
    ):
        exact.top(0.01, 0.02, 0.0, 1.0, 10.0)
    with pytest.raises(ModelError, match="between 0 and pi, got -0.1 rad.* add pi to psi0 and to phi0"):
        exact.top(*TOP, -0.1, 10.0)
    with pytest.raises(ModelError, match="between 0 and pi, got 30 rad.* numpy.radians"):
        exact.top(*TOP, 30.0, 10.0)
    with pytest.raises(ModelError, match="positive transverse .* I_xi = -0.01"):
        exact.top(-0.01, 0.02, 1.0, 1.0, 10.0)
    with pytest.raises(ModelError, match="finite number for spin, got nan"):
        exact.top(*TOP, 1.0, np.nan)
    with pytest.raises(ModelError, match=r"from 114.\d+ rad/s upwards the top sleeps. Spin slower"):
        exact.asymptotic_top(*TOP, 2 * SLEEP)


def test_the_cures_of_the_refusals_are_right(taylor):
    # theta0 = -0.4: the same attitude and motion with theta0 = 0.4
    motion = exact.top(*TOP, 0.4, 50.0, -0.3, 1.0, psi0=np.pi, phi0=np.pi)
    c, s = np.cos(-0.4), np.sin(-0.4)
    assert_allclose(motion.attitude(0.0), [[1, 0, 0], [0, c, -s], [0, s, c]], rtol=0, atol=1e-15)
    # the mass centre on the other side: the opposite axis, which leans pi - theta0 with theta_rate0 and spin reversed
    I_xi, I_zeta, mgL = TOP
    times = np.array([0.2, 0.5])
    below = np.array(taylor.top(I_xi, I_zeta, -mgL, 0.9, 50.0, -0.3, 1.0, times=list(times)), dtype=float)
    motion = exact.top(*TOP, np.pi - 0.9, -50.0, 0.3, 1.0, psi0=np.pi)
    assert_allclose(motion.axis(times), -below[:, 3:6], rtol=0, atol=1e-14)
