"""Elements that resist rolling and spinning: their names, units, and rates."""

import numpy as np

import freebody as fb
from freebody.dynamics.conditions.contact import contact_rows
from freebody.dynamics.state import float_state
from freebody.model import assemble


def coin(**laws):
    """A ball between a plane and another contact whose name is that of an element."""
    s = fb.System("ball")
    ball = s.body("ball", fb.sphere(1, 0.1))
    s.free("f", s.ground, ball)
    s.contact("floor", ball.sphere(0.1), s.ground.plane(normal="z"), friction=0.5, **laws)
    s.contact("floor_rolling", ball.origin, s.ground.plane(at=(0, 0, -1), normal="z"))
    return assemble(s)


def test_elements_follow_their_contact_and_keep_names_apart():
    names = [contact.name for contact in coin(rolling=0.01, spinning=0.02).contacts]
    assert names == ["floor", "floor_rolling_", "floor_spinning", "floor_rolling"]
    assert [contact.name for contact in coin().contacts] == ["floor", "floor_rolling"]
    _, rolling, spinning, _ = coin(rolling=0.01, spinning=0.02).contacts
    assert rolling.tangent_names == ("M1_floor", "M2_floor") and spinning.tangent_names == ("M3_floor",)
    assert rolling.presser == spinning.presser == "floor" and rolling.held
    assert rolling.units["tangential"] == "N m" and rolling.units["slip"] == "rad/s"


def test_rates_are_the_angular_velocity_along_tangents_and_normal():
    model = coin(rolling=0.01, spinning=0.02)
    w = [0.3, -0.7, 1.1]
    state = float_state(model, [0, 0, 0.1, 1, 0, 0, 0], [*w, 0.2, 0.1, 0.0], 0.0, {})
    rows = contact_rows(model, state)
    rate = np.array(rows.rate[:8], dtype=float)  # N, T1, T2; N, M1, M2; N, M3
    first, second = model.contacts[0].surface.first, model.contacts[0].surface.second
    along = [float(sum(a * b for a, b in zip(e, w, strict=True))) for e in (first, second)]
    np.testing.assert_allclose(rate[4:6], along, atol=1e-15)
    assert rate[3] == rate[6] == 0 and rate[7] == 1.1
