"""A motion that meets no inertia is refused by name."""

import pytest

import freebody as fb
from freebody.dynamics.conditions.mobility import massless_motion
from freebody.dynamics.state import float_state
from freebody.errors import MassError, ModelError, SimulationError


def test_particle_that_spins_about_itself_is_refused():
    s = fb.System("spin")
    bead = s.body("bead", fb.particle(2))
    s.hinge("axle", s.ground, bead, coordinate="theta")
    model = fb.assemble(s)
    assert massless_motion(model, float_state(model, [0.7])) == ("theta'",)


def test_two_coordinates_that_do_the_same_are_named_together():
    s = fb.System("twice")
    a, b = s.coordinates("a b")
    block = s.body("block", fb.box(1, (1, 1, 1)))
    s.slider("rail", s.ground, block, coordinate=a + b)
    model = fb.assemble(s)
    assert massless_motion(model, float_state(model, [0.3, 0.4])) == ("a'", "b'")
    with pytest.raises(
        ModelError, match="singular in every configuration: a', b' do not move.*Leave out a coordinate"
    ):
        fb.simulate(s, 1)


def test_gimbal_lock_is_a_matter_of_the_state():
    s = fb.System("top")
    rotor = s.body("rotor", fb.disk(1, 1))
    s.gimbal("pivot", s.ground, rotor, to=(0, 0, -1), axis="ZXZ", coordinate="psi theta phi")
    model = fb.assemble(s)
    assert massless_motion(model, float_state(model, [0.3, 0, 0.4])) == ("psi'", "phi'")
    assert massless_motion(model, float_state(model, [0.3, 1, 0.4])) == ()


def test_gimbal_lock_is_named_when_a_motion_starts_in_it():
    s = fb.System("top")
    rotor = s.body("rotor", fb.disk(1, 1))
    s.gimbal("pivot", s.ground, rotor, to=(0, 0, -1), axis="ZXZ", coordinate="psi theta phi")
    with pytest.raises(
        SimulationError, match='singular at t = 0 s.*"psi\'" and "phi\'" together move no mass.*ball'
    ):
        fb.simulate(s, 1)


def test_motion_without_inertia_is_named_before_anything_is_compiled():
    s = fb.System("spin")
    bead = s.body("bead", fb.particle(2))
    s.hinge("axle", s.ground, bead, coordinate="theta")
    with pytest.raises(
        ModelError,
        match="Joint 'axle' has a motion that meets no inertia.*Give the bodies that it carries mass",
    ):
        fb.simulate(s, 1)


def test_impossible_body_by_values_is_refused():
    s = fb.System("ball")
    m = s.parameters(m=1.0)
    s.free("air", s.ground, s.body("ball", fb.sphere(m, 1)))
    with pytest.raises(MassError, match="Body 'ball'.*-2"):
        fb.simulate(s, 1, values={"m": -2})


def test_a_head_without_moments_of_inertia_is_named_where_the_steps_crawl():
    """A point mass in the plane of the axes of two hinges: their inertia is round-off, and a damper makes it stiff."""
    s = fb.System("head")
    s.gravity = (0, -9.81, 0)
    neck, head = (
        s.body(name, fb.MassProperties(m, place, ((I, 0, 0), (0, I, 0), (0, 0, I))))
        for name, m, place, I in (("neck", 1e-12, (0, 0, 0), 1e-20), ("head", 1, (0.1, 0, 0.2), 1e-18))  # noqa: E741
    )
    for name, parent, child, axis in (("roll", s.ground, neck, "x"), ("yaw", neck, head, "z")):
        s.damper(f"{name}_oil", s.hinge(name, parent, child, axis=axis), damping=0.1)
    with pytest.raises(
        SimulationError,
        match='singular at t = .*"roll\'" and "yaw\'" together move no mass.*without moments of inertia',
    ):
        fb.simulate(s, 1)
