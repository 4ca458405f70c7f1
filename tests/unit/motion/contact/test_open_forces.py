"""Contact forces that a motion leaves open."""

import numpy as np

import freebody as fb


def test_friction_that_a_rail_takes_is_open_and_the_normal_force_is_not():
    """A particle on a vertical rail lands on a rough floor: friction along the floor moves nothing, N = m g."""
    s = fb.System("particle on a rail")
    s.gravity = (0, -9.81, 0)
    ball = s.body("ball", fb.particle(2))
    s.slider("rail", s.ground, ball, axis="y", coordinate="y")
    s.contact("floor", ball.origin, s.ground.plane(normal="y"), friction=0.5)
    motion = fb.simulate(s, 1, initial={"y": 0.2}, times=[0.5, 1])
    floor = motion.contacts["floor"]
    assert list(floor.mode) == ["stick", "stick"]
    assert np.allclose(floor.normal, 2 * 9.81, rtol=1e-12) and np.isnan(floor.tangential).all()
