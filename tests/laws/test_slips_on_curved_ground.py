"""Slips in space that end and begin, at coarse tolerances: times and derivatives have the accuracy of the steps."""

import math

import numpy as np
import pytest

import freebody as fb

G, SLOWEST = 9.81, 10  # a slip ends at this multiple of the tolerance of speeds


@pytest.mark.parametrize("tolerance", [1e-3, 1e-5, 1e-7])
def test_a_ball_comes_to_roll_when_its_slip_has_ended(tolerance):
    """v_slip falls by 7/2 μ g to zero; steps that cannot resolve it would turn friction to and fro, without an end."""
    mu, r, v, w = 0.3, 0.1, (1.0, 0.5), (8.0, 3.0)
    s = fb.System("ball")
    s.gravity = (0, 0, -G)
    ball = s.body("ball", fb.sphere(1, r))
    s.free("f", s.ground, ball)
    s.contact("floor", ball.sphere(r), s.ground.plane(normal="z"), friction=mu)
    start = {"f_z": r, "f_vx": v[0], "f_vy": v[1], "f_wx": w[0], "f_wy": w[1], "f_wz": 1.0}
    motion = fb.simulate(s, 1, initial=start, tolerance=tolerance)
    slowing = 7 / 2 * mu * G
    expected = math.hypot(v[0] - r * w[1], v[1] + r * w[0]) / slowing
    (rolls,) = motion.events
    assert rolls.time == pytest.approx(expected, abs=2 * SLOWEST * tolerance / slowing)
    assert motion.path.steps < 60


def bowl():
    s = fb.System("bowl")
    s.parameters(mu=0.15)
    s.gravity = (0, 0, -G)
    ball = s.body("ball", fb.sphere(1, 0.1))
    s.free("f", s.ground, ball)
    s.contact("bowl", ball.sphere(0.1), s.ground.sphere(1.0, inside=True), friction="mu")
    return s


@pytest.mark.parametrize(("angle", "speed"), [(0.5, 0.5), (0.5, 0.1), (0.9, 0.0), (1.2, 0.5)])
def test_slips_in_a_bowl_have_derivatives_at_coarse_tolerances(angle, speed):
    """A ball slips, rolls, and slips again where |T| reaches μ N on the other side."""
    start = {"f_x": 0.9 * math.sin(angle), "f_z": -0.9 * math.cos(angle), "f_vy": speed}
    runs = [
        fb.simulate(bowl(), 1.9, initial=start, tolerance=tolerance, sensitivities=["mu"], samples=9)
        for tolerance in (1e-12, 1e-8, 1e-6)
    ]
    times = [np.array([event.time for event in motion.events]) for motion in runs]
    slopes = [np.array([motion.sensitivity[x, "mu"] for x in motion.names]) for motion in runs]
    assert len(times[0])
    for motion, when, of in zip(runs[1:], times[1:], slopes[1:], strict=True):
        tolerance = float(motion.tolerances.min())
        assert len(when) == len(times[0])
        assert np.abs(when - times[0]).max() < 100 * tolerance
        assert np.abs(of - slopes[0]).max() < 1e4 * tolerance * (1 + np.abs(slopes[0]).max())
