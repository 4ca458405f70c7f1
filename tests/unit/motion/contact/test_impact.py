"""Impacts as the log of a run holds them, against the laws of momentum, of the rebound and of friction."""

import numpy as np
import pytest

import freebody as fb
from freebody.dynamics import mass_matrix
from freebody.dynamics.conditions.contact import contact_rows
from freebody.dynamics.state import state_at
from freebody.motion.contact.impact import impact_of
from freebody.motion.events import event_run


@pytest.mark.parametrize("e", [0.0, 0.6])
def test_impulses_of_the_log_change_the_momentum(e):
    s = fb.System("ball")
    s.gravity = (0, 0, -9.81)
    ball = s.body("ball", fb.sphere(2, 0.1))
    s.free("f", s.ground, ball)
    s.contact("floor", ball.sphere(0.1), s.ground.plane(normal="z"), friction=0.3, restitution=e)
    motion = fb.simulate(s, 0.4, initial={"f_z": 0.5, "f_vx": 0.4, "f_wy": 300})
    history, model = motion.course.history, motion.kernels.model
    hits = [impact_of(history.work, entry) for entry in history.entries(event_run.IMPACT)]
    first, n, m = hits[0], model.n_q, model.n_q + model.n_u
    assert list(first.chosen) == [0] and first.part == 1 and not first.open
    assert first.speeds[0] == pytest.approx(-np.sqrt(2 * 9.81 * 0.4), rel=1e-9)
    assert first.speeds_after[0] == pytest.approx(-e * first.speeds[0], rel=1e-12, abs=1e-12)
    state = state_at(model, first.before, first.t, motion.values)
    M, W = (np.array(x, dtype=float) for x in (mass_matrix(model, state), contact_rows(model, state).matrix))
    np.testing.assert_allclose(M @ (first.after - first.before)[n:m], first.impulses @ W, atol=1e-11)
    assert np.hypot(*first.impulses[1:]) == pytest.approx(0.3 * first.impulses[0], rel=1e-9)  # it slips
    assert (first.taken, first.compressed, first.origin) == (False, None, None)
