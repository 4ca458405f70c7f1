"""What closes within the microsecond of a straight step at the start of a slip."""

import numpy as np
import pytest

import freebody as fb
from contact_machines import G, landing, puck_and_ball


def test_a_ball_lands_while_a_slip_begins():
    """The pull k t exceeds μ_s m g; 0.2 µs later the ball lands, before the slip has 4e-8 m/s."""
    static, friction, k = 0.11, 0.1, 10.0
    begins = static * G / k
    s, start = puck_and_ball(friction, begins + 2e-7, pull=k, static_friction=static)
    until = begins + 0.05
    motion = fb.simulate(s, until, initial=start)
    assert landing(motion) == pytest.approx(begins + 2e-7, abs=1e-12)
    assert motion.contacts["bounce"].gap.min() > -1e-12
    # v = (k/2)(t² - t0²) - μ g (t - t0)
    speed = k / 2 * (until**2 - begins**2) - friction * G * (until - begins)
    assert float(motion["p_vx"][-1]) == pytest.approx(speed, abs=1e-9)
    assert np.abs(motion.energy.residual).max() < 1e-12
