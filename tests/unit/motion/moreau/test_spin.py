"""The turning of free bodies in the equations of a step: its inverse, and motions that it leaves as they are."""

import numpy as np
import pytest

import freebody as fb
from freebody.native import loop


def closed(c):
    """Return c (1 - c_ω)⁻¹ as the compiled code has it, and whether it has one."""
    C = np.ascontiguousarray(c)
    return loop.code("motion.moreau.spin", "closed")(C.reshape(-1)), C


def test_the_answer_with_the_turning_is_the_inverse():
    c = np.random.default_rng(1).normal(size=(6, 3)) / 10
    found, C = closed(c.copy())
    assert found == 1
    assert np.abs(C @ (np.eye(3) - c[:3]) - c).max() < 1e-15


def test_a_step_that_turns_too_far_has_none():
    assert closed(np.vstack([np.eye(3), np.zeros((3, 3))]))[0] == 0


@pytest.mark.parametrize("friction", [0.3, 0.0])
def test_a_box_that_spins_and_slides_keeps_its_balance(friction):
    s = fb.System("box")
    s.gravity = (0, 0, -9.81)
    body = s.body("box", fb.box(2, (0.2, 0.1, 0.05)))
    s.free("free", s.ground, body)
    s.contacts("all", [s.ground.plane(normal="z"), body.box((0.2, 0.1, 0.05))], friction=friction)
    start = {"free_z": 0.3, "free_wx": 9.0, "free_wy": -7.0, "free_wz": 11.0, "free_vx": 1.0}
    motion = fb.simulate(s, 0.4, initial=start, method="timestepping", step=1e-3)
    assert motion.residual <= 1e-12
    model, y = motion.kernels.model, motion.path.states
    names = list(model.coordinate_names) + list(model.speed_names)
    w = y[:, [names.index(f"free_w{c}") for c in "xyz"]]
    J = np.array([0.1**2 + 0.05**2, 0.2**2 + 0.05**2, 0.2**2 + 0.1**2]) * 2 / 12
    flies = motion.path.times < 0.15
    energy = (J * w**2).sum(axis=1)[flies]
    assert np.abs(energy - energy[0]).max() < 1e-13 * energy[0]  # the midpoint rule keeps it to round-off
