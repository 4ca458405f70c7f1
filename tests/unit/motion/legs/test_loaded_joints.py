"""What motions refuse where the load of a joint bounds its friction, and what time steps do instead."""

import re

import pytest

import freebody as fb
from contact_machines import rough_pendulum

G = 9.81


def test_impacts_blows_and_families_beside_it_are_refused():
    s = rough_pendulum(0.3, 0.02)
    s.stop("wall", s.joints["pin"], low=0.5)
    hit = "Contacts 'wall' collide. The load of a joint is an impulse then, and so is the friction 'dry' that it bounds"
    with pytest.raises(fb.FreebodyError, match=re.escape(hit)):
        fb.simulate(s, 1, initial={"theta": 1.2})
    stepped = fb.simulate(s, 1, initial={"theta": 1.2}, method="timestepping", step=1e-3)
    assert stepped["theta"].min() > 0.5 - 1e-9
    blow = [fb.blow(0.5, at=s.bodies["bar"].origin, impulse=(1, 0, 0))]
    with pytest.raises(
        fb.FreebodyError, match=re.escape("'pendulum' has a blow, 'blow'. The load of a joint is")
    ):
        fb.simulate(rough_pendulum(0.3, 0.02), 1, impulses=blow)
    s = rough_pendulum(0.3, 0.02)
    ball = s.body("ball", fb.sphere(1, 0.1))
    s.free("air", s.ground, ball)
    s.contacts("pile", [ball.sphere(0.1)], against=s.ground.plane(normal="y"))
    with pytest.raises(
        fb.FreebodyError, match=re.escape("has contacts in families, 'pile', whose forces are not")
    ):
        fb.simulate(s, 1, initial={"air_y": 1}, method="timestepping", step=1e-2)
