"""Springs and dampers against the turn of ball and free joints."""

from __future__ import annotations

import numpy as np
import pytest
import sympy

import freebody as fb
from freebody.describe.loads.torsion import TorsionDamper
from freebody.dynamics.loads.actions import actions
from freebody.dynamics.state import float_state
from freebody.errors import ModelError
from freebody.space.quaternion import quaternion_from_matrix
from freebody.testing.states import random_state


def ball(**at):
    s = fb.System("neck")
    head = s.body("head", fb.MassProperties(2, (0, 0, 0), np.diag([0.3, 0.3, 0.3])))
    return s, s.ball("neck", s.ground, head, **at)


def chain(closing=False):
    """Two bodies with springs and dampers on their ball, or on the ball that closes their loop."""
    s = fb.System("two")
    s.gravity = (0, 0, -9.81)
    a, b = (s.body(x, fb.box(2, (0.1, 0.2, 0.4))) for x in "ab")
    s.universal("top", s.ground, a, to=(0, 0, 0.5))
    axes = [fb.Rotation.axis_angle((3, -1, 2), x) for x in (0.7, 1.1)]
    middle = s.ball("middle", a, b, at=(0, 0, -0.5), to=(0, 0, 0.5), parent_axes=axes[0], child_axes=axes[1])
    joint = s.ball("foot", s.ground, b, at=(0, 0.6, -0.7), to=(0, 0, -0.5)) if closing else middle
    assert joint.closes == closing
    s.torsion_spring("spring", joint, stiffness=3, rest=fb.Rotation.axis_angle((1, 1, 1), 0.4))
    return s, joint


@pytest.mark.parametrize("closing", [False, True])
def test_the_work_is_that_of_the_potential(closing):
    s, joint = chain(closing)
    start = {"middle_wx": 0.5, "middle_wz": 1} if not closing else {}
    assert fb.simulate(s, 0.5, initial=start).energy.relative_residual < 1e-9
    s.damper("damper", joint, damping=0.2)
    energy = fb.simulate(s, 0.5, initial=start).energy
    assert energy.relative_residual < 1e-9 and energy.work[-1] < 0


def test_both_bodies_feel_it_and_files_hold_it(tmp_path):
    s, _ = chain()
    s.damper("damper", s.joints["middle"], damping="1/5")
    model = fb.assemble(s)
    q, u = random_state(model, 3)
    for x in ("spring", "damper"):
        couples = actions(model, float_state(model, q, u), x)
        assert sum(np.array(one.moment, float) for one in couples) == pytest.approx(np.zeros(3), abs=1e-15)
    fb.write(s, tmp_path / "two.toml")
    other = fb.read(tmp_path / "two.toml")
    assert fb.compile(other).bias(q, u) == pytest.approx(fb.compile(s).bias(q, u), rel=1e-14)


@pytest.mark.parametrize("size", [0, 1e-9, 0.3, 2.0, 3.1415])
def test_the_moment_is_the_stiffness_times_the_rotation_vector(size):
    rest, axis = fb.Rotation.axis_angle((2, 1, 2), 0.5), np.array([1, 2, -2]) / 3
    s, neck = ball()
    s.torsion_spring("spring", neck, stiffness=5, rest=rest)
    turned = np.array(rest.matrix, float) @ np.array(fb.Rotation.axis_angle((1, 2, -2), size).matrix, float)
    moment = -fb.compile(s).bias(quaternion_from_matrix(turned), np.zeros(3))  # in the axes of the head
    # R has errors of 1e-16, of which cos(h) gets its share over itself
    assert np.linalg.norm(moment + 5 * size * axis) < 1e-14 / np.cos(size / 2)


def test_equal_moments_of_inertia_swing_along_the_rotation_vector():
    s, neck = ball()
    s.torsion_spring("spring", neck, stiffness=2.7)
    sine = np.sin(0.75)
    motion = fb.simulate(
        s, 4, initial={"neck_e0": np.cos(0.75), "neck_e1": 0.6 * sine, "neck_e3": 0.8 * sine}
    )
    angle = 1.5 * np.cos(np.sqrt(2.7 / 0.3) * motion.t)
    assert motion["neck_e1"] == pytest.approx(0.6 * np.sin(angle / 2), abs=1e-7)
    assert motion["neck_e0"] == pytest.approx(np.cos(angle / 2), abs=1e-7)


def test_formulas_and_small_motions_are_exact():
    s, neck = ball()
    k, c = s.parameters("k c")
    s.torsion_spring("spring", neck, stiffness=k)
    s.damper("damper", neck, damping=c)
    assert "acos" in fb.equations(s).text()
    linear = fb.linearize(s, about={})
    assert k * sympy.eye(3) == linear.K and c * sympy.eye(3) == linear.C


def test_a_hinge_has_no_rotation_vector():
    s = fb.System("door")
    pin = s.hinge("pin", s.ground, s.body("leaf", fb.sphere(1, 0.1)))
    with pytest.raises(
        ModelError,
        match="Torsion damper 'd' acts against the turn of a ball or free joint, but 'pin' is a hinge",
    ):
        s.add("d", TorsionDamper(pin, 1))


def test_a_ball_beside_a_hinge_has_no_rotation_vector_of_its_own():
    """The turn of the bodies is that of both; along the hinge springs and dampers act as ever."""
    s = fb.System("arm")
    motions = [fb.Hinge("z", "a"), fb.Ball(coordinate="b", at=(1, 0, 0))]
    arm = s.chain("arm", s.ground, s.body("arm", fb.sphere(1, 0.1)), motions)
    message = r"acts against the turn of a ball, but chain 'arm' turns about other axes beside it\. Put a body between"
    for refused in (
        lambda: s.damper("d", arm, damping=1),
        lambda: s.torsion_spring("k", arm, stiffness=1),
        lambda: s.stop("end", arm, high=1, coordinate=1),
        lambda: s.friction("dry", arm, torque=1, coordinate=1),
    ):
        with pytest.raises(ModelError, match=message):
            refused()
    with pytest.raises(ModelError, match="Chain 'arm' has no single displacement for"):
        s.spring("k", arm, stiffness=1, coordinate=1)
    s.damper("d", arm, damping="2", coordinate=0)
    s.torsion_spring("k", arm, stiffness=3, coordinate=0)
    linear = fb.linearize(s, about={})
    assert linear.C[0, 0] == 2 and linear.K[0, 0] == 3
    assert not any(linear.C[1:, :]) and not any(linear.K[1:, :])
