"""Friction with two coefficients: what is no ellipse is refused."""

import pytest

import freebody as fb
from freebody.errors import ModelError, SimulationError


def block(friction=("mu_1", "mu_2"), along="x", **laws):
    """A particle over a floor."""
    s = fb.System("block")
    s.parameters(mu_1=0.2, mu_2=0.4)
    body = s.body("block", fb.particle(2))
    s.chain("move", s.ground, body, [fb.Slider(axis, axis) for axis in "xyz"])
    s.contact("floor", body.origin, s.ground.plane(normal="z"), friction=friction, along=along, **laws)
    return s


REFUSED = {
    "no direction": (
        dict(along=None),
        "Expected along= for contact 'floor', whose friction has two coefficients: the direction of the first, in axes "
        "of the surface's body, such as along='x'.",
    ),
    "the normal": (
        dict(along="z"),
        "The direction of friction of contact 'floor', along='z', is the normal of its plane. Give a direction along "
        "the surface.",
    ),
    "one coefficient": (
        dict(friction=0.3),
        "Contact 'floor' has a direction, along='x', and one coefficient of friction, which needs none. Give "
        "friction=(mu1, mu2), or leave along= out.",
    ),
    "three": (
        dict(friction=(0.1, 0.2, 0.3)),
        "Expected two coefficients of friction for contact 'floor', along its direction and across it, got (0.1, 0.2, "
        "0.3).",
    ),
    "zero": (
        dict(friction=(0.1, 0)),
        "Expected two coefficients of friction above 0 for contact 'floor', got 0. Without friction in one direction, "
        "take a small part of the other coefficient.",
    ),
    "another shape": (
        dict(static_friction=(0.4, 0.4)),
        "Expected static_friction of contact 'floor' in the ratio of friction, mu_1 to mu_2, got 2/5 to 2/5: the "
        "ellipses of both have one shape. Multiply both of friction by one factor.",
    ),
    "static below": (
        dict(static_friction=(0.1, 0.2), friction=(0.2, 0.4)),
        "The static friction of contact 'floor' is 0.1, below its kinetic friction 0.2. Static friction is at least as "
        "large as kinetic friction: exchange them.",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_no_ellipse_is_refused(name):
    laws, text = REFUSED[name]
    with pytest.raises(ModelError) as caught:
        block(**laws)
    assert str(caught.value) == text


def test_a_plane_machine_and_bad_values_are_refused():
    s = fb.System("block")
    body = s.body("block", fb.particle(1))
    s.chain("plane", s.ground, body, [fb.Slider("x", "x"), fb.Slider("y", "y")])
    s.contact("floor", body.origin, s.ground.plane(), friction=(0.1, 0.2), along="x")
    with pytest.raises(ModelError) as caught:
        fb.equations(s)
    assert str(caught.value) == (
        "Contact 'floor' has two coefficients of friction, but the machine moves in a plane, in which the contact "
        "slips along one line. Give the one coefficient of that line."
    )
    with pytest.raises(SimulationError) as caught:
        fb.simulate(block(), 0.1, values={"mu_2": -1})
    assert str(caught.value) == (
        "Expected two coefficients of friction above 0 of contact 'floor', got 0.2 and -1."
    )
