"""What a trajectory gives by name: accelerations, and single numbers of the whole run."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from freebody.errors import ExpressionError, ModelError, SimulationError


def pendulum():
    s = fb.System("pendulum")
    m, L, g = s.parameters(m=1.0, L=2.0, g=9.81)
    s.gravity = (0, -g, 0)
    bar = s.body("bar", fb.slender_bar(m, L, axis="y"))
    s.hinge("pin", s.ground, bar, to=(0, L / 2, 0), coordinate="theta")
    return s


def test_accelerations_by_name():
    motion = fb.simulate(pendulum(), 2, initial={"theta": 1})
    expected = -3 * 9.81 / 4 * np.sin(motion["theta"])
    assert motion["theta''"] == pytest.approx(expected, abs=1e-13)


def test_accelerations_in_the_modes_of_contacts():
    """A ball that falls, strikes without rebound and lies: -g, then zero."""
    s = fb.System("ball")
    (g,) = (s.parameters(g=9.81),)
    s.gravity = (0, -g, 0)
    ball = s.body("ball", fb.particle(1))
    s.slider("guide", s.ground, ball, axis="y", coordinate="y")
    s.contact("floor", ball.point(0, 0, 0), s.ground.plane(normal="y"), friction=0)
    motion = fb.simulate(s, 1, initial={"y": 1})
    landed = motion.t > (2 / 9.81) ** 0.5
    assert motion["y''"] == pytest.approx(np.where(landed, 0.0, -9.81), abs=1e-12)
    stepped = fb.simulate(s, 1, initial={"y": 1}, method="timestepping", step=1e-2)
    with pytest.raises(SimulationError, match="so it has no accelerations"):
        stepped["y''"]


def test_rates_that_are_not_are_refused_with_those_that_are():
    motion = fb.simulate(pendulum(), 1, initial={"theta": 1})
    for name in ("theta'''", "2*theta''"):
        with pytest.raises(SimulationError, match="'theta' has \"theta'\" here"):
            motion[name]


def test_the_greatest_of_a_run_is_that_of_an_output():
    s = pendulum()
    motion = fb.simulate(s, 2, initial={"theta": 1})
    for how in ("max", "min", "range", "initial", "final"):
        name = f"{how}(theta')"
        batch = fb.simulate(s, 2, initial={"theta": [1]}, outputs=[name], samples=3)
        assert isinstance(motion[name], float)
        assert motion[name] == pytest.approx(float(batch[name][0]), abs=1e-8)
    speed = (3 * 9.81 / 2 * (1 - np.cos(1))) ** 0.5  # of energy
    assert motion["max(theta')"] == pytest.approx(speed, abs=1e-8)
    assert motion["max(theta')"] > motion["theta'"].max()


def test_one_argument_of_max_has_no_other_meaning():
    s = pendulum()
    with pytest.raises(
        ExpressionError, match="Expected 2 to 32 arguments of max, got 1. The greatest or smallest of"
    ):
        fb.simulate(s, 1, events=["max(theta)"])
    motion = fb.simulate(s, 2, initial={"theta": 1}, sensitivities=["L"])
    assert isinstance(motion.sensitivity["max(theta')", "L"], float)
    assert (motion["max(theta, 1/2)"] == np.maximum(motion["theta"], 0.5)).all()


def test_times_of_a_signal_are_numbers():
    signal = fb.signal([0, 1], [1, 2])
    for nonsense in ("x", [10**400], {}):
        with pytest.raises(ModelError, match="Expected a time, or times"):
            signal(nonsense)
    with pytest.raises(ModelError, match="Expected numbers for the times of signal"):
        fb.signal([10**400, 1], [1, 2])
