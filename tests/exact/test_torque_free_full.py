"""exact.torque_free in full: angular velocity, attitude and curves against integer Taylor series of 33 digits."""

from __future__ import annotations

import json
from pathlib import Path

import mpmath
import numpy as np
import pytest
from numpy.testing import assert_allclose

from freebody import exact
from freebody.errors import ModelError

EPS = np.finfo(float).eps
#: What the closed form is off its reference, measured 2.3e-15 at most; a few roundings of sums of a few terms.
ATTITUDE = 32 * EPS
HUNDRED = json.loads((Path(__file__).parent / "hundred_periods.json").read_text(encoding="utf-8"))
BODIES = [case for case in HUNDRED if case["body"] == "torque_free"]
SEPARATRIX = (1.0, 2.0, 2.25), (0.75, 0.3, 1.0)  # I_3 (I_3 - I_2) w_3² = I_1 (I_2 - I_1) w_1² exactly


def turn(axis, angle):
    """Rotation matrix about a coordinate axis."""
    c, s = np.cos(angle), np.sin(angle)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    R = np.eye(3)
    R[i, i], R[i, j], R[j, i], R[j, j] = c, -s, s, c
    return R


def compare(taylor, moments, w0, times):
    """Largest errors of angular velocity and quaternion (sign included: it is continuous in t)."""
    motion = exact.torque_free(moments, w0)
    expected = np.array([[float(v) for v in state] for state in taylor.torque_free(moments, w0, list(times))])
    assert_allclose(
        motion.angular_velocity(times), expected[:, :3], rtol=0, atol=ATTITUDE * max(map(abs, w0))
    )
    assert_allclose(motion.quaternion(times), expected[:, 3:], rtol=0, atol=ATTITUDE)
    return motion


def test_the_reference_agrees_with_mpmath(taylor):
    moments, w0, times = (1.0, 1.7, 2.4), (0.4, -1.5, 1.2), [0.5, 2.0]
    found = np.array(taylor.torque_free(moments, w0, times))
    with mpmath.workdps(30):
        I1, I2, I3 = map(mpmath.mpf, moments)

        def rates(t, y):
            w1, w2, w3, q0, q1, q2, q3 = y
            return [
                (I2 - I3) / I1 * w2 * w3,
                (I3 - I1) / I2 * w3 * w1,
                (I1 - I2) / I3 * w1 * w2,
                (-q1 * w1 - q2 * w2 - q3 * w3) / 2,
                (q0 * w1 + q2 * w3 - q3 * w2) / 2,
                (q0 * w2 + q3 * w1 - q1 * w3) / 2,
                (q0 * w3 + q1 * w2 - q2 * w1) / 2,
            ]

        solve = mpmath.odefun(rates, 0, [mpmath.mpf(v) for v in w0] + [1, 0, 0, 0])
        expected = np.array([solve(t) for t in times])
        assert max(abs(found - expected).ravel()) < 1e-15  # the reference is returned in doubles


@pytest.mark.parametrize("order", [(0, 1, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0), (0, 2, 1), (1, 0, 2)])
@pytest.mark.parametrize(
    "w0", [(0.4, -1.5, 1.2), (-1.3, 0.6, 0.2)]
)  # about the greatest, about the least moment
def test_a_period_in_every_order_of_axes(taylor, order, w0):
    moments, w0 = (tuple(np.array(values)[list(order)]) for values in ((1.0, 1.7, 2.4), w0))
    period = exact.torque_free(moments, w0).period
    motion = compare(taylor, moments, w0, period * np.array([0.13, 0.3, 0.61, 1.0]))
    assert motion.kind == "triaxial"
    assert_allclose(motion.angular_velocity(period), w0, rtol=0, atol=ATTITUDE)


@pytest.mark.parametrize("deviation", [1e-6, -1e-6, 1e-9, -1e-9, 1e-12, -1e-15])
def test_a_period_near_the_separatrix(taylor, deviation):
    moments, (w1, w2, w3) = SEPARATRIX
    w0 = (w1 * (1 + deviation), w2, w3)
    period = exact.torque_free(moments, w0).period
    motion = compare(taylor, moments, w0, period * np.array([0.02, 0.11, 0.24, 0.26, 0.49, 0.53, 0.77, 0.96]))
    # to first order 1 - k² = (I_3 - I_1) (H² - 2 T I_2) / ((I_3 - I_2) (H² - 2 T I_1)), cyclic when w circles axis 1
    assert_allclose(motion.complementary, 1.88 * abs(deviation), rtol=0.2)
    assert motion.kind == "triaxial"


@pytest.mark.parametrize(
    "w0", [(1e-9, 2.0, 1e-9), (1e-9, 2.0, -1.4e-9), (-1e-6, -2.0, 3e-7), (0.0, 2.0, 1e-8)]
)
def test_a_body_that_turns_over(taylor, w0):
    moments = (1.0, 2.0, 3.0)
    period = exact.torque_free(moments, w0).period
    motion = compare(taylor, moments, w0, period * np.array([0.1, 0.23, 0.27, 0.5, 0.76]))
    assert motion.angular_velocity(np.linspace(0, period, 201))[:, 1].min() < -1.999999


@pytest.mark.parametrize("sign1, sign2, sign3", [(1, 1, 1), (-1, 1, 1), (1, -1, 1), (-1, -1, -1)])
def test_on_the_separatrix(taylor, sign1, sign2, sign3):
    moments, w0 = SEPARATRIX
    w0 = (sign1 * w0[0], sign2 * w0[1], sign3 * w0[2])
    motion = compare(taylor, moments, w0, np.linspace(0.5, 20, 8))
    assert motion.kind == "separatrix" and motion.period == np.inf and motion.complementary == 0
    # towards the middle axis, one way in the past and the other in the future, at |w| = H / I_2
    ends = motion.angular_velocity([-1e4, 1e4])
    H = np.linalg.norm(motion.momentum)
    assert_allclose(abs(ends), [[0, H / 2, 0]] * 2, rtol=0, atol=ATTITUDE)
    assert_allclose(ends[0], -ends[1], rtol=0, atol=ATTITUDE)
    # the herpolhode winds into the foot of H
    assert_allclose(motion.herpolhode(1e4), motion.momentum / 2, rtol=0, atol=ATTITUDE)
    curve = motion.polhode(5)
    assert_allclose(abs(curve[[0, -1]]), [[0, H / 2, 0]] * 2, rtol=0, atol=ATTITUDE)


@pytest.mark.parametrize("case", BODIES, ids=[case["name"] for case in BODIES])
def test_a_hundred_periods(case):
    motion = exact.torque_free(case["moments"], case["w0"])
    states = np.array(case["states"])
    assert max(case["times"]) > 99.9 * motion.period
    assert_allclose(motion.angular_velocity(case["times"]), states[:, :3], rtol=0, atol=ATTITUDE)
    assert_allclose(motion.quaternion(case["times"]), states[:, 3:], rtol=0, atol=ATTITUDE)


@pytest.mark.slow
@pytest.mark.parametrize("case", BODIES, ids=[case["name"] for case in BODIES])
def test_the_stored_hundred_periods_are_those_of_the_taylor_series(taylor, case):
    found = np.array(taylor.torque_free(case["moments"], case["w0"], case["times"]), dtype=float)
    assert_allclose(found, case["states"], rtol=0, atol=EPS)


def test_a_million_periods_are_not_worse_than_one():
    moments, w0 = (1.0, 1.7, 2.4), (0.4, -1.5, 1.2)
    motion = exact.torque_free(moments, w0)
    t = 1e6 * motion.period  # rounded: off by less than an ulp of t, 1e-9 s
    assert_allclose(motion.angular_velocity(t), w0, rtol=0, atol=np.spacing(t) * 4)
    H = motion.herpolhode(t) @ motion.momentum
    assert_allclose(H, 2 * motion.energy, rtol=ATTITUDE)


# -- bodies with two equal moments -----------------------------------------------------------------


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("I_t, I_s", [(1.0, 1.8), (1.8, 0.4)])
def test_symmetric_bodies_about_any_axis(taylor, axis, I_t, I_s):
    moments = np.roll((I_t, I_t, I_s), axis + 1)
    w0 = np.roll((0.5, -0.3, 6.0), axis + 1)
    motion = compare(taylor, moments, w0, np.array([0.3, 1.0, 7.0]))
    cones = motion.cones
    assert motion.kind == "symmetric" and cones.axis == axis
    assert_allclose(cones.rate, (I_s - I_t) / I_t * 6.0, rtol=EPS * 4)
    assert_allclose(motion.period, 2 * np.pi / abs(cones.rate), rtol=EPS * 4)
    assert_allclose(np.tan(cones.alpha), I_t / I_s * np.tan(cones.beta), rtol=EPS * 8)
    assert_allclose(
        np.cos(cones.alpha), motion.moments[axis] * 6 / np.linalg.norm(motion.momentum), rtol=EPS * 8
    )
    # rolling: equal arcs on both cones
    arcs = cones.precession_rate * np.sin(cones.space_cone), abs(cones.rate) * np.sin(cones.body_cone)
    assert_allclose(*arcs, rtol=EPS * 16)
    assert_allclose(motion.precession_per_period, cones.precession_rate * motion.period, rtol=EPS * 8)


def test_the_same_cones_and_attitude_as_the_formulas_of_the_chapter():
    t = np.linspace(0, 5, 7)
    chapter = exact.torque_free_symmetric(1.0, 1.8, 0.5, 6.0, t)
    motion = exact.torque_free((1.0, 1.0, 1.8), (0.5, 0.0, 6.0))
    assert_allclose(motion.attitude(t), chapter.attitude, rtol=0, atol=ATTITUDE)
    assert_allclose(motion.angular_velocity(t), chapter.omega, rtol=0, atol=8 * ATTITUDE)
    for name in ("rate", "alpha", "beta", "body_cone", "space_cone", "precession_rate"):
        assert_allclose(getattr(motion.cones, name), getattr(chapter, name), rtol=8 * EPS)


@pytest.mark.parametrize("excess", [1e-3, 1e-9, 1e-15])
def test_almost_equal_moments_are_no_special_case(taylor, excess):
    compare(taylor, (1.0, 1.0 + excess, 2.0), (1e-5, 1.0, 0.1), [3.0, 40.0])
    compare(taylor, (1.0, 2.0, 2.0 + excess), (0.7, 1.0, 0.1), [3.0, 40.0])


@pytest.mark.parametrize(
    "moments, w0",
    [((1, 2, 3), (0, -1.5, 0)), ((2, 2, 2), (1, 2, 3)), ((1, 1, 2), (3, 4, 0)), ((1, 2, 3), (0, 0, 0))],
)
def test_steady_rotations(moments, w0):
    motion = exact.torque_free(moments, w0)
    assert motion.kind == "steady" and np.isnan(motion.period)
    size, t = np.linalg.norm(w0), np.array([0.0, 0.7, 100.0])
    q = motion.quaternion(t)
    assert_allclose(q[:, 0], np.cos(size * t / 2), rtol=0, atol=ATTITUDE)
    assert_allclose(
        q[:, 1:], np.outer(np.sin(size * t / 2), np.array(w0) / (size or 1)), rtol=0, atol=ATTITUDE
    )
    assert_allclose(motion.herpolhode(t), np.tile(w0, (3, 1)), rtol=0, atol=4 * ATTITUDE)
    assert_allclose(motion.polhode(3), np.tile(w0, (3, 1)))
    assert_allclose(motion.herpolhode_radii, 0, atol=ATTITUDE)


# -- curves and forms ------------------------------------------------------------------------------


@pytest.mark.parametrize("w0", [(0.4, -1.5, 1.2), (-1.3, 0.6, 0.2), (1e-9, 2.0, 1e-9)])
def test_polhode_and_herpolhode(w0):
    moments, w0 = np.array([1.0, 1.7, 2.4]), np.array(w0)
    motion = exact.torque_free(moments, w0)
    curve = motion.polhode(50)
    assert curve.shape == (50, 3)
    assert_allclose(curve[0], curve[-1], rtol=0, atol=ATTITUDE)
    # on both ellipsoids
    assert_allclose(curve**2 @ moments, w0**2 @ moments, rtol=ATTITUDE)
    assert_allclose(curve**2 @ moments**2, w0**2 @ moments**2, rtol=ATTITUDE)
    # Poinsot: in the invariable plane, between two circles, which it touches
    H = motion.momentum / np.linalg.norm(motion.momentum)
    t = np.linspace(0, motion.period, 401)
    points = motion.herpolhode(t)
    assert_allclose(points @ H, motion.plane_distance, rtol=ATTITUDE)
    radius = np.linalg.norm(points - np.outer(points @ H, H), axis=1)
    low, high = motion.herpolhode_radii
    assert radius.min() >= low - ATTITUDE and radius.max() <= high + ATTITUDE
    assert_allclose(radius.max(), high, rtol=1e-2)  # 401 samples
    # after a period the herpolhode has turned by precession_per_period about H
    first, last = points[0] - H * (points[0] @ H), points[-1] - H * (points[-1] @ H)
    angle = np.arctan2(np.cross(first, last) @ H, first @ last)
    # the radius is small near the middle axis, and so the angle is known less well
    assert_allclose(
        np.exp(1j * angle), np.exp(1j * motion.precession_per_period), rtol=0, atol=ATTITUDE / radius[0]
    )


def test_an_inertia_matrix_and_an_attitude_at_the_start():
    moments, w0, t = np.array([1.0, 1.7, 2.4]), np.array([0.4, -1.5, 1.2]), np.linspace(0, 9, 5)
    axes = turn(0, 0.4) @ turn(2, 1.3) @ turn(1, -0.7)
    start = turn(2, 2.0) @ turn(0, 0.5)
    plain = exact.torque_free(moments, w0)
    inertia = axes @ np.diag(moments) @ axes.T
    body = exact.torque_free((inertia + inertia.T) / 2, axes @ w0, attitude=start)
    assert_allclose(body.angular_velocity(t), plain.angular_velocity(t) @ axes.T, rtol=0, atol=1e-13)
    assert_allclose(body.attitude(t), start @ axes @ plain.attitude(t) @ axes.T, rtol=0, atol=1e-13)
    assert_allclose(body.momentum, start @ axes @ plain.momentum, rtol=1e-14)
    assert_allclose(body.herpolhode(t), plain.herpolhode(t) @ (start @ axes).T, rtol=0, atol=1e-13)
    half = np.array([np.cos(0.3), 0.0, np.sin(0.3), 0.0])
    assert_allclose(exact.torque_free(moments, w0, attitude=half).attitude(0.0), turn(1, 0.6), atol=ATTITUDE)


def test_a_symmetric_body_given_by_a_matrix_keeps_its_cones():
    axes = turn(0, 0.4) @ turn(2, 1.3) @ turn(1, -0.7)
    inertia = axes @ np.diag([1.0, 1.0, 1.8]) @ axes.T
    motion = exact.torque_free((inertia + inertia.T) / 2, axes @ [0.5, 0.0, 6.0])
    assert motion.kind == "symmetric"
    assert_allclose(abs(motion.cones.rate), 4.8, rtol=1e-14)
    assert exact.torque_free((inertia + inertia.T) / 2, axes @ [0.0, 0.0, 6.0]).kind == "steady"
    # a diagonal matrix keeps its axes
    diagonal = exact.torque_free(np.diag([3.0, 1.0, 2.0]), (1, 2, 3))
    assert_allclose(diagonal.axes, np.eye(3))


def test_shapes_follow_the_times():
    motion = exact.torque_free((1, 2, 4), (1, 2, 3))
    for shape in ((), (3,), (2, 3)):
        t = np.full(shape, 0.5)
        assert motion.angular_velocity(t).shape == (*shape, 3)
        assert motion.quaternion(t).shape == (*shape, 4)
        assert motion.attitude(t).shape == (*shape, 3, 3)
        assert motion.herpolhode(t).shape == (*shape, 3)
    assert_allclose(exact.torque_free((1, 2, 4), (1, 2, 3), 0.5), motion.angular_velocity(0.5))
    with pytest.raises(AttributeError):  # frozen
        motion.period = 1.0


def test_backwards_in_time():
    motion = exact.torque_free((1.0, 1.7, 2.4), (0.4, -1.5, 1.2))
    back = exact.torque_free((1.0, 1.7, 2.4), (-0.4, 1.5, -1.2))
    t = np.linspace(0, 20, 9)
    assert_allclose(motion.angular_velocity(-t), -back.angular_velocity(t), rtol=0, atol=ATTITUDE)
    assert_allclose(motion.attitude(-t), back.attitude(t), rtol=0, atol=ATTITUDE)


def test_refusals():
    with pytest.raises(
        ModelError, match=r"two equal principal moments .* got \(1, 2, 4\) .* polhode\(\) and herpolhode"
    ):
        exact.torque_free((1, 2, 4), (1, 2, 3)).cones  # noqa: B018
    with pytest.raises(
        ModelError, match=r"three principal moments of inertia or a 3 x 3 inertia matrix, got shape \(2,\)"
    ):
        exact.torque_free((1, 2), (1, 2, 3))
    with pytest.raises(
        ModelError, match=r"symmetric 3 x 3 inertia .* difference of 0.5 kg m² .* use \(I \+ I.T\) / 2"
    ):
        exact.torque_free([[1, 0.5, 0], [0, 2, 0], [0, 0, 2]], (1, 2, 3))
    with pytest.raises(
        ModelError, match=r"three finite components of the angular velocity w0 .* got \(1, 2\)"
    ):
        exact.torque_free((1, 2, 4), (1, 2))
    with pytest.raises(ModelError, match=r"three finite components"):
        exact.torque_free((1, 2, 4), (1, 2, np.nan))
    with pytest.raises(ModelError, match=r"rotation matrix R_NB, .* Normalize the quaternion"):
        exact.torque_free((1, 2, 4), (1, 2, 3), attitude=(1, 1, 0, 0))
    with pytest.raises(ModelError, match=r"determinant \+1"):
        exact.torque_free((1, 2, 4), (1, 2, 3), attitude=np.diag([1, 1, -1]))
    with pytest.raises(ModelError, match="at least 2 points of a polhode, got 1"):
        exact.torque_free((1, 2, 4), (1, 2, 3)).polhode(1)
    with pytest.raises(ModelError, match="three positive principal moments"):
        exact.torque_free((1, 2, -4), (1, 2, 3))
