"""Rows of the conditions of contacts in given modes."""

import numpy as np
import pytest

from contact_machines import tumbling_box
from freebody.motion.kernels.kernels import kernels_of
from freebody.motion.ode.dense_output import observe
from freebody.motion.phase.phase import at_limit
from freebody.motion.phase.scene import scene_of


def test_the_limit_of_friction_is_a_force_of_fixed_direction():
    s = tumbling_box()
    kernels = kernels_of(s)
    scene = scene_of(kernels)
    p = kernels.parameters(kernels.values(None))
    y = np.zeros(17)
    y[2:4] = 0.1, 1.0
    seen = scene.at(0.0, y, scene.constants(p))
    phase = scene.phase((at_limit((0.6, 0.8)), "open", "open", "open", "open"), seen)
    program = phase.contact()
    N, first, second = observe(
        program.address("force"), scene.rows, np.zeros(1), y[None], program.constants(p)
    )[0, :3]
    assert N > 0
    assert (first, second) == pytest.approx((-0.3 * N, -0.4 * N))
