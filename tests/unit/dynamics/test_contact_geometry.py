"""The normal force of a compliant contact at a state."""

import pytest

import freebody as fb
from freebody.dynamics.contact_geometry import normal_force, touch_of_shapes, velocity_over
from freebody.dynamics.state import float_state
from freebody.model import assemble


def test_the_force_is_that_of_depth_and_rate_and_none_above():
    s = fb.System("ball")
    ball = s.body("ball", fb.sphere(1, 0.5))
    s.planar("air", s.ground, ball, coordinate="x y turn")
    s.contact("floor", ball.sphere(0.5), s.ground.plane(), normal="100*depth*(1 + 2*rate)")
    model = assemble(s)
    (contact,) = model.contacts
    deep = float_state(model, [0.0, 0.4, 0.0], [1.0, -0.25, 3.0], 0.0, {})
    assert touch_of_shapes(model, deep, contact).gap == pytest.approx(-0.1)
    assert velocity_over(model, deep, contact)[:2] == pytest.approx((2.5, -0.25))
    assert normal_force(model, deep, contact) == pytest.approx(100 * 0.1 * 1.5)
    above = float_state(model, [0.0, 0.6, 0.0], [1.0, -0.25, 3.0], 0.0, {})
    assert normal_force(model, above, contact) == 0
    assert normal_force(model, above, contact, touching=True) == pytest.approx(-100 * 0.1 * 1.5)
