"""Bodies that no one can make, whose motion is determined all the same."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from freebody.errors import ModelError

UNIT = ((1, 0, 0), (0, 1, 0), (0, 0, 1))


def test_a_flywheel_whose_mass_is_counted_elsewhere():
    """A couple N between a bar and the wheel on it: (m L²/3) a'' = -N, I (a'' + b'') = N."""
    s = fb.System("flywheel")
    m, L, I, N = s.parameters(m=3.0, L=2.0, I=0.5, N=2.0)  # noqa: E741
    bar = s.body("bar", fb.slender_bar(m, L, axis="x"))
    wheel = s.body("wheel", fb.MassProperties(0, (0, 0, 0), ((I, 0, 0), (0, I, 0), (0, 0, I))))
    s.hinge("pin", s.ground, bar, to=(-L / 2, 0, 0), coordinate="a")
    s.hinge("axle", bar, wheel, at=(L / 2, 0, 0), coordinate="b")
    s.generalized_force("b", N)
    motion = fb.simulate(s, 1)
    a, b = -2.0 / 4.0, 2.0 / 0.5 + 2.0 / 4.0
    assert motion["a"][-1] == pytest.approx(a / 2, rel=1e-9) and motion["b"][-1] == pytest.approx(
        b / 2, rel=1e-9
    )


def test_inertia_without_mass_does_not_depend_on_the_point():
    wheel = fb.MassProperties(0, (0, 0, 0), UNIT)
    assert wheel.about((1, 2, 3)) == UNIT
    both = wheel + fb.particle(2)
    assert both.mass == 2 and both.inertia == UNIT
    with pytest.raises(fb.FreebodyError, match="Expected moments of inertia that are not negative"):
        fb.MassProperties(0, (0, 0, 0), ((1, 0, 0), (0, 1, 0), (0, 0, -1)))


def rolling(mass):
    """A cart on a slider with a roller, whose turn follows the cart's way."""
    s = fb.System("cart")
    m, R, N = s.parameters(m=2.0, R=0.1, N=0.3)
    cart = s.body("cart", fb.particle(m))
    s.slider("guide", s.ground, cart, axis="x", coordinate="x")
    roller = s.body("roller", mass)
    s.hinge("axle", cart, roller, coordinate="-x/R")
    s.torque("motor", roller, (0, 0, -N))
    return s


def test_a_massless_roller_that_follows_passes_its_load_on():
    """Virtual power: N x'/R = F x'."""
    s = rolling(fb.particle(0))
    assert fb.equations(s).text() == "m*x'' = N/R"
    assert fb.simulate(s, 1)["x"][-1] == pytest.approx(0.3 / 0.1 / 2.0 / 2, rel=1e-9)
    light = rolling(fb.MassProperties(1e-12, (0, 0, 0), tuple(tuple(1e-14 * x for x in row) for row in UNIT)))
    assert fb.simulate(s, 1)["x"][-1] == pytest.approx(fb.simulate(light, 1)["x"][-1], rel=1e-9)


def test_a_massless_tip_that_follows_in_part_only_is_refused():
    s = rolling(fb.particle(0))
    free = s.coordinates("z")
    tip = s.body("tip", fb.particle(0))
    s.slider("tip_guide", s.bodies["cart"], tip, axis="y", coordinate=free + s.expression("x"))
    with pytest.raises(
        ModelError, match="Body 'tip' is a moving tip without mass.*let it follow bodies with mass"
    ):
        fb.simulate(s, 1)


@pytest.mark.parametrize("joint", ["planar", "free"])
def test_a_particle_that_a_joint_may_turn_keeps_its_turn(joint):
    s = fb.System("particle")
    m, g = s.parameters(m=2.0, g=9.81)
    s.gravity = (0, -g, 0)
    body = s.body("body", fb.particle(m))
    getattr(s, joint)("j", s.ground, body)
    s.force("push", body.point(0, 0, 0), (3 * m, 0, 0))
    spin = "j_turn'" if joint == "planar" else "j_wz"
    motion = fb.simulate(s, 1, initial={spin: 2.0}, tolerance=1e-11)
    assert motion["j_x"][-1] == pytest.approx(1.5, abs=1e-9)
    assert motion["j_y"][-1] == pytest.approx(-9.81 / 2, abs=1e-9)
    assert np.abs(motion[spin] - 2.0).max() == 0
    assert motion.energy.relative_residual < 1e-9
    lanes = fb.simulate(s, 1, initial={spin: [0.0, 2.0]}, outputs=["j_x"], samples=2)
    assert lanes["j_x"].values[:, -1] == pytest.approx([1.5, 1.5], abs=1e-7)


def test_a_torque_on_a_particle_is_refused():
    s = fb.System("particle")
    body = s.body("body", fb.particle(2))
    s.planar("j", s.ground, body)
    s.torque("spin", body, (0, 0, 1))
    with pytest.raises(ModelError, match="Joint 'j' has a motion that meets no inertia"):
        fb.simulate(s, 1)


def test_a_particle_that_only_turns_is_refused():
    s = fb.System("particle")
    s.hinge("j", s.ground, s.body("body", fb.particle(2)))
    with pytest.raises(ModelError, match="Joint 'j' has a motion that meets no inertia"):
        fb.simulate(s, 1)
