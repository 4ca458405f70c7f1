"""Poisson's law in a step: without forces it is the impact by events."""

import numpy as np
import pytest

import freebody as fb


def rod(mu, e):
    """A rod without weight that flies to a floor, with one end or flat with both."""
    s = fb.System("rod")
    body = s.body("rod", fb.slender_bar(1.0, 1.0, axis="x"))
    s.planar("p", s.ground, body, coordinate="x y a")
    feet = body.corners((-0.5, 0, 0), (0.5, 0, 0))
    s.contact("foot", feet, s.ground.plane(normal="y"), friction=mu, restitution=e, impact="poisson")
    return s


@pytest.mark.parametrize("mu", [0.0, 0.2, 0.8])
@pytest.mark.parametrize("angle", [0.0, 0.5, -0.9])
@pytest.mark.parametrize("e", [0.0, 0.5, 1.0])
def test_an_impact_without_forces_is_that_by_events_up_to_the_turn_of_a_step(mu, angle, e):
    start = {"a": angle, "y": 0.6, "x'": 0.7, "y'": -1.0}
    end = 0.6 - 0.5 * abs(np.sin(angle)) + 0.02  # after the first impact
    exact = fb.simulate(rod(mu, e), end, initial=start)
    steps = fb.simulate(rod(mu, e), end, initial=start, method="timestepping", step=1e-3)
    assert sum("impact" in str(event) for event in exact.happenings) >= 1
    turn = 1e-3 * 0.5 * (1 + abs(exact.at(end).u[2])) ** 2  # h r ω² of the end that hits
    np.testing.assert_allclose(steps.at(end).u, exact.at(end).u, rtol=0, atol=turn)
    assert steps.residual <= 1e-12 and steps.energy.kinetic[-1] <= steps.energy.kinetic[0] * (1 + 1e-12)


def test_contacts_at_rest_in_an_impact_expand_with_the_others():
    """A ball hits a ball that leans on a wall: compression P with all at rest, then e P back at both contacts."""
    s = fb.System("cradle")
    balls = [s.body(f"b{i}", fb.sphere(m, 0.1)) for i, m in enumerate((1.0, 2.0))]
    for i, ball in enumerate(balls):
        s.slider(f"rail{i}", s.ground, ball, axis="x", coordinate=f"x{i}")
    law = {"friction": 0, "restitution": 0.5, "impact": "poisson"}
    s.contact("pair", balls[0].sphere(0.1), balls[1].sphere(0.1), **law)
    s.contact("wall", balls[1].sphere(0.1), s.ground.plane(at=(1, 0, 0), normal="-x"), **law)
    start = {"x0": 0.0, "x0'": 1.0, "x1": 0.9}
    motion = fb.simulate(s, 0.8, initial=start, method="timestepping", step=1e-3)
    np.testing.assert_allclose(motion.at(0.8).u, [-0.5, 0.0], atol=1e-12)
    np.testing.assert_allclose(fb.simulate(s, 0.8, initial=start).at(0.8).u, [-0.5, 0.0], atol=1e-12)


def test_a_ball_comes_to_rest():
    s = fb.System("ball")
    s.gravity = (0, -9.81, 0)
    ball = s.body("ball", fb.disk(1, 0.1))
    s.planar("p", s.ground, ball, coordinate="x y a")
    law = {"friction": 0.3, "restitution": 0.6, "impact": "poisson"}
    s.contact("floor", ball.circle(0.1), s.ground.plane(normal="y"), **law)
    start = {"y": 1.1, "x'": 2, "a'": 30}
    exact = fb.simulate(s, 2.5, initial=start)
    errors = [
        abs(fb.simulate(s, 2.5, initial=start, method="timestepping", step=h)["x"][-1] - exact["x"][-1])
        for h in (2e-3, 2e-4)
    ]
    assert errors[1] < 0.3 * errors[0] and errors[0] < 1e-2
