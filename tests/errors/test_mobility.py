"""A motion that meets no inertia is refused by name."""

import pytest

import freebody as fb
from freebody.dynamics.mobility import check_mobility, massless_motion
from freebody.dynamics.state import float_state
from freebody.errors import ModelError


def test_particle_that_spins_about_itself_is_refused():
    s = fb.System("spin")
    bead = s.body("bead", fb.particle(2))
    s.hinge("axle", s.ground, bead, coordinate="theta")
    with pytest.raises(ModelError, match="singular: changing 'theta'' moves no mass.*Give a body"):
        check_mobility(fb.assemble(s))


def test_two_coordinates_that_do_the_same_are_named_together():
    s = fb.System("twice")
    a, b = s.coordinates("a b")
    block = s.body("block", fb.box(1, (1, 1, 1)))
    s.slider("rail", s.ground, block, coordinate=a + b)
    with pytest.raises(ModelError, match="'a'', 'b''"):
        check_mobility(fb.assemble(s))


def test_gimbal_lock_is_a_matter_of_the_state():
    s = fb.System("top")
    rotor = s.body("rotor", fb.disk(1, 1))
    s.gimbal("pivot", s.ground, rotor, to=(0, 0, -1), axis="ZXZ", coordinate="psi theta phi")
    model = fb.assemble(s)
    check_mobility(model)
    assert massless_motion(model, float_state(model, [0.3, 0, 0.4])) == ("psi'", "phi'")
    assert massless_motion(model, float_state(model, [0.3, 1, 0.4])) == ()
