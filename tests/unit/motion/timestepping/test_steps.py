"""States between the ends of steps, and what is asked outside the run."""

import math

import numpy as np
import pytest

import freebody as fb


def test_states_between_steps_are_linear_with_unit_quaternions():
    s = fb.System("die")
    die = s.body("die", fb.box(1, (0.1, 0.1, 0.1)))
    s.free("f", s.ground, die)
    s.contact("floor", die.box((0.1, 0.1, 0.1)), s.ground.plane(normal="z"))
    start = {"f_z": 1, "f_wx": 3, "f_vx": 2}
    path = fb.simulate(s, 0.3, initial=start, method="timestepping", step=0.1).path
    half = path.sample([0.05, 0.25])
    quaternion = slice(*(path.rates.quaternions[0] + k for k in (0, 4)))
    np.testing.assert_allclose(np.linalg.norm(half[:, quaternion], axis=1), 1, rtol=1e-15)
    for y, before, after in zip(half, path.states[[0, 2]], path.states[[1, 3]], strict=True):
        mean = (before + after) / 2
        mean[quaternion] /= math.hypot(*mean[quaternion])
        np.testing.assert_allclose(y, mean, rtol=0, atol=1e-15)
    np.testing.assert_array_equal(path.sample(path.times), path.states)
    with pytest.raises(ValueError, match=r"Expected times within the run, 0 to 0\.3; got 0\.31"):
        path.sample([0.1, 0.31])
