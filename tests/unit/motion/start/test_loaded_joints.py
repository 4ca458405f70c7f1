"""What motions refuse where the load of a joint bounds its friction, and what time steps do instead."""

import re

import pytest

import freebody as fb
from contact_machines import rough_pendulum

G = 9.81


def looped():
    """A rough pendulum that carries a block along a rail, with a wall for the block."""
    s = rough_pendulum(0.3, 0.02)
    block = s.body("block", fb.particle(1))
    rail = s.slider("rail", s.ground, block, at=(0, -1, 0), axis="x", coordinate="x")
    s.constrain("x - sin(theta)", name="tie")
    s.stop("wall", rail, low=0.2)
    return s


def test_impacts_in_sequence_blows_in_steps_and_families_beside_it_are_refused():
    s, start = looped(), {"theta": 0.6, "x": 0.5646424733950354}
    motion = fb.simulate(s, 1, initial=start)
    stepped = fb.simulate(s, 1, initial=start, method="timestepping", step=1e-3)
    assert motion["x"].min() > 0.2 - 1e-9 and stepped["x"].min() > 0.2 - 1e-9
    hit = "Contacts 'wall' collide one after another. The load of a joint is an impulse then"
    with pytest.raises(fb.FreebodyError, match=re.escape(hit)):
        fb.simulate(s, 1, initial=start, impacts="sequential")
    s = rough_pendulum(0.3, 0.02)
    blow = [fb.blow(0.05, at=s.bodies["bar"].origin, impulse=(1, 0, 0))]
    message = "'pendulum' has a blow, 'blow', and moves in time steps. The load of a joint is"
    with pytest.raises(fb.FreebodyError, match=re.escape(message)):
        fb.simulate(s, 1, impulses=blow, method="timestepping", step=1e-3)
    bounce = [fb.blow(0.05, at=s.bodies["bar"].origin, normal=(-1, 0, 0), restitution=0.5)]
    with pytest.raises(
        fb.FreebodyError, match="the blow has a restitution of its own, of a surface that s.contact"
    ):
        fb.simulate(s, 1, initial={"theta'": 1}, impulses=bounce)
    s = rough_pendulum(0.3, 0.02)
    ball = s.body("ball", fb.sphere(1, 0.1))
    s.free("air", s.ground, ball)
    s.contacts("pile", [ball.sphere(0.1)], against=s.ground.plane(normal="y"))
    with pytest.raises(
        fb.FreebodyError, match=re.escape("has contacts in families, 'pile', whose forces are not")
    ):
        fb.simulate(s, 1, initial={"air_y": 1}, method="timestepping", step=1e-2)
