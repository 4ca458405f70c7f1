"""Runs with contacts and their pauses."""

import numpy as np
import pytest

import freebody as fb
from freebody.motion.contact import run
from space_machines import machine


@pytest.mark.parametrize("seed", [10, pytest.param(175, marks=pytest.mark.slow)])
def test_pauses_do_not_change_a_bit(seed, monkeypatch):
    """Feet that creep: steps are implicit now and then, and slips end at other speeds."""
    m, paths = machine("quadruped", seed), []
    for few in (0, 1 << 60):
        monkeypatch.setattr(run, "FEW", few)
        motion = fb.simulate(m.system, m.until, initial=m.start)
        paths.append([segment.path for segment in motion.path.segments])
    for one, other in zip(*paths, strict=True):
        assert np.array_equal(one.times, other.times)
        assert np.array_equal(one.states, other.states)
