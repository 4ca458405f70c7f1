"""Derivatives of extremes, ends and times of events, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from freebody.errors import SimulationError

M, D, INERTIA, G = 2.0, 0.3, 0.5, 9.81


def pendulum() -> fb.System:
    s = fb.System("pendulum")
    m, d, inertia = s.parameters(m=M, d=D, I=INERTIA)
    s.gravity = (0, -G, 0)
    bar = s.body("bar", fb.MassProperties(m, (0, -d, 0), ((1, 0, 0), (0, 1, 0), (0, 0, inertia))))
    s.hinge("pin", s.ground, bar, axis="z", coordinate="theta")
    return s


def throw() -> fb.System:
    s = fb.System("throw")
    g, T = s.parameters(g=G, T=1.0)
    s.gravity = (0, -g, 0)
    s.slider("rail", s.ground, s.body("stone", fb.particle(1)), axis="y", coordinate="y")
    return s


HIT = fb.event("y", name="hit", direction=-1, terminal=True)


def test_extremes_of_a_pendulum_by_energy() -> None:
    """w² = 2 m g d (1 - cos θ₀)/J at the lowest point; errors of 1e-11 a step, some hundred steps."""
    s, start = pendulum(), 1.0
    motion = fb.simulate(s, 10, initial={"theta": start}, sensitivities=["I", "theta"], tolerance=1e-11)
    J, torque = INERTIA + M * D**2, M * G * D
    w = np.sqrt(2 * torque / J * (1 - np.cos(start)))
    slopes = motion.sensitivity
    assert slopes["max(theta')", "I"] == pytest.approx(-w / (2 * J), abs=1e-9)
    assert slopes["max(theta')", "theta"] == pytest.approx(torque / J * np.sin(start) / w, abs=1e-9)
    assert slopes["min(theta')", "I"] == pytest.approx(w / (2 * J), abs=1e-9)
    assert slopes["range(theta)", "theta"] == pytest.approx(2, abs=1e-9)
    assert slopes["max(kinetic_energy)", "theta"] == pytest.approx(torque * np.sin(start), abs=1e-9)
    assert slopes["final(theta)", "I"] == slopes["theta", "I"][-1]
    assert slopes["initial(theta)", "theta"] == 1


def test_landing_of_a_stone() -> None:
    """t = 2 v/g, at the speed -v; the top at v²/(2 g)."""
    v = 3.0
    motion = fb.simulate(
        throw(), 9, initial={"y'": v}, events=[HIT], sensitivities=["y'", "g"], tolerance=1e-12
    )
    slopes = motion.sensitivity
    assert slopes.times("hit", "y'") == pytest.approx([2 / G], abs=1e-10)
    assert slopes.times(HIT).shape == (1, 2)
    assert slopes.times("hit", "g") == pytest.approx([-2 * v / G**2], abs=1e-10)
    assert slopes.of("max(y)") == pytest.approx([v / G, -(v**2) / (2 * G**2)], abs=1e-10)
    # at the end: the time of the end moves
    assert slopes.of("final(y')") == pytest.approx([-1, 0], abs=1e-10)
    assert slopes.of("min(y')") == pytest.approx([-1, 0], abs=1e-10)
    assert slopes.of("final(y)") == pytest.approx([0, 0], abs=1e-10)
    with pytest.raises(SimulationError, match="Unknown event 'hits' in .*times; did you mean 'hit'"):
        slopes.times("hits")


def test_times_that_depend_on_parameters() -> None:
    """From T to 2 T: y = v (t - T) - g (t - T)²/2."""
    v = 3.0
    motion = fb.simulate(
        throw(), "2*T", start="T", initial={"y'": v}, sensitivities=["T"], tolerance=1e-12, times=[1.5]
    )
    assert motion.sensitivity["y", "T"] == pytest.approx([-v + G / 2], abs=1e-10)
    assert motion.sensitivity["final(y)", "T"] == pytest.approx(v - G, abs=1e-10)
    assert motion.sensitivity["initial(y)", "T"] == pytest.approx(0, abs=1e-10)


def test_a_bend_moves_along_both_branches() -> None:
    """The least |y - 1/4| is 0 for all speeds, and the greatest of min(y, 1 - y) is 1/2."""
    motion = fb.simulate(throw(), 0.4, initial={"y'": 6.0}, sensitivities=["y'"], tolerance=1e-12)
    assert motion.sensitivity["min(abs(y - 1/4))", "y'"] == pytest.approx(0, abs=1e-8)
    assert motion.sensitivity["max(min(y, 1 - y))", "y'"] == pytest.approx(0, abs=1e-8)


def test_equal_extremes_with_different_derivatives_have_none() -> None:
    """(y - 1/2)² is 1/4 at y = 0, where the stone is fixed, and at y = 1, where it is not."""
    v = np.sqrt(2 * G)
    motion = fb.simulate(throw(), v / G, initial={"y'": v}, sensitivities=["y'"])
    with pytest.raises(
        SimulationError, match="Expected one derivative of 'max.*' by 'y'', but the run reaches 0.25"
    ):
        motion.sensitivity["max((y - 1/2)^2)", "y'"]
    rest = fb.simulate(pendulum(), 5, sensitivities=["theta"])
    with pytest.raises(SimulationError, match="Expected one derivative of 'max.theta.'"):
        rest.sensitivity["max(theta)", "theta"]


def test_an_event_that_touches_zero_has_no_derivative() -> None:
    graze = fb.event("y - 9/(2*g) + 1e-9", name="top")
    motion = fb.simulate(throw(), 0.5, initial={"y'": 3.0}, events=[graze], sensitivities=["g"])
    assert motion.events
    with pytest.raises(SimulationError, match="it only touches zero"):
        motion.sensitivity.times(motion.events[0].name)
    jump = fb.simulate(throw(), 0.5, initial={"y'": 3.0}, events=["sign(y')"], sensitivities=["g"])
    with pytest.raises(SimulationError, match="it jumps from one sign|it only touches zero"):
        jump.sensitivity.times("sign(y')")


def test_backwards() -> None:
    motion = fb.simulate(throw(), -1, initial={"y'": -3.0}, sensitivities=["y'"], tolerance=1e-12)
    assert motion.sensitivity["max(y)", "y'"] == pytest.approx(-3.0 / G, abs=1e-10)


def test_a_file_keeps_the_shift_of_the_end(tmp_path) -> None:
    motion = fb.simulate(throw(), "2*T", initial={"y'": 3.0}, sensitivities=["T"])
    motion.save(tmp_path / "y.nc")
    again = fb.Trajectory.load(tmp_path / "y.nc")
    assert again.sensitivity["final(y)", "T"] == motion.sensitivity["final(y)", "T"] != 0
