"""Forces of contacts of equal compliance."""

import numpy as np
import pytest

import freebody as fb
from contact_machines import G, block_on_feet
from freebody.motion.kernels.kernels import kernels_of
from freebody.motion.ode.dense_output import observe
from freebody.motion.phase.scene import scene_of


def forces(s, modes, y):
    """Contact forces of a machine in modes."""
    kernels = kernels_of(s)
    scene = scene_of(kernels)
    p = kernels.parameters(kernels.values(None))
    program = scene.phase(modes, scene.at(0.0, y, scene.constants(p))).contact()
    return observe(program.address("force"), scene.rows, np.zeros(1), y[None], program.constants(p))[0]


def test_feet_share_friction_in_proportion_to_their_normal_forces():
    """The mass centre stands twice as near to the right foot, which bears twice as much."""
    left, T_left, right, T_right = forces(
        block_on_feet(load=3.0, right=0.25), ("stick", "stick"), np.zeros(8)
    )
    assert (left, right) == pytest.approx((2 * G / 3, 4 * G / 3), rel=1e-12)
    assert (T_left, T_right) == pytest.approx((-1.0, -2.0), rel=1e-12)


def test_friction_of_feet_where_one_would_pull_is_that_of_equal_weights():
    """The mass centre is beyond the right foot: what pulls is no weight, and each has half of the friction."""
    left, T_left, right, T_right = forces(
        block_on_feet(load=3.0, right=-0.1), ("stick", "stick"), np.zeros(8)
    )
    assert left < 0 < right and left + right == pytest.approx(2 * G, rel=1e-12)
    assert (T_left, T_right) == pytest.approx((-1.5, -1.5), rel=1e-12)


@pytest.mark.parametrize("angle", [1e-3, 3e-8])
def test_forces_of_an_arch_beside_feet_that_share_theirs(angle):
    """Two bars, almost in line, between a pin and the floor: N = m g, T = -m g cot(angle)/2, to round-off."""
    s = block_on_feet(load=3.0)
    left, right = s.body("bar1", fb.slender_bar(1, 1)), s.body("bar2", fb.slender_bar(1, 1))
    s.hinge("pin", s.ground, left, at=(2, 0, 0), to=(-0.5, 0, 0), coordinate="p")
    s.hinge("knee", left, right, at=(0.5, 0, 0), to=(-0.5, 0, 0), coordinate="q")
    s.contact("foot", right.point(0.5, 0, 0), s.ground.plane(normal="y"), friction=1e8)
    y = np.array([0, 0, 0, angle, -2 * angle, 0, 0, 0, 0, 0, 0, 0])
    foot = forces(s, ("stick", "stick", "stick"), y)[4:]
    assert foot == pytest.approx((G, -G / 2 / np.tan(angle)), rel=1e-12)
