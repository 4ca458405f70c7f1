"""Laws of normal forces: their names, and what is none."""

import pytest

import freebody as fb
from freebody.describe.contacts.normal_law import DEPTH, RATE
from freebody.errors import FreebodyError, ModelError


def falling(law, **laws):
    """A particle over a floor."""
    s = fb.System("ball")
    s.parameters(k=1e4, c=20.0)
    ball = s.body("ball", fb.particle(1))
    s.slider("guide", s.ground, ball, axis="y", coordinate="y")
    s.contact("floor", ball.origin, s.ground.plane(), normal=law, **laws)
    return s


def test_a_law_knows_depth_and_rate():
    law = falling("k*depth*(1 + c*rate)").contacts["floor"].normal_force
    assert law.free_symbols >= {DEPTH, RATE}
    assert falling(DEPTH * 3).contacts["floor"].normal_force == 3 * DEPTH


REFUSED = {
    "no depth": (
        {"normal": "k"},
        "Expected a normal force of contact 'floor' that depends on `depth`, such as",
    ),
    "a load at the start": (
        {"normal": "k*depth + 3"},
        "is 0 at depth = 0 and rate = 0, got 3 N. A constant load is",
    ),
    "restitution": (
        {"normal": "k*depth", "restitution": 0.5},
        "Contact 'floor' has a normal force and a restitution.",
    ),
    "unknown name": ({"normal": "q*depth"}, "q"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_laws_that_are_none_are_refused(name):
    laws, message = REFUSED[name]
    with pytest.raises(FreebodyError) as caught:
        falling(laws.pop("normal"), **laws)
    assert message in str(caught.value)


def test_names_of_the_law_and_sides_with_ends_are_refused():
    s = fb.System("depths")
    s.parameters("depth")
    bar = s.body("bar", fb.slender_bar(1, 1))
    s.planar("air", s.ground, bar, coordinate="x y turn")
    with pytest.raises(
        ModelError, match="`depth`, the depth of the contact, but this system has a parameter 'depth'"
    ):
        s.contact("floor", bar.origin, s.ground.plane(), normal="depth")
    side = s.ground.segment((-1, 0, 0), (1, 0, 0), normal="y")
    t = fb.System("side")
    bar = t.body("bar", fb.slender_bar(1, 1))
    t.planar("air", t.ground, bar, coordinate="x y turn")
    side = t.ground.segment((-1, 0, 0), (1, 0, 0), normal="y")
    with pytest.raises(
        ModelError, match="Expected shapes without ends for contact 'floor', .* got a segment"
    ):
        t.contact("floor", bar.origin, side, normal="3*depth")
