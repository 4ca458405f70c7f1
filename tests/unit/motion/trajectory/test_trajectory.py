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


def wheel():
    s = fb.System("wheel")
    s.hinge("axle", s.ground, s.body("wheel", fb.disk(1, 1)), axis="z", coordinate="theta")
    return s


def test_extremes_of_a_fast_quantity_in_one_step():
    """A wheel that turns by 3 rad: the last crest and trough are the greatest, tan 500 θ = -500 (10 + θ)."""
    s, fast = wheel(), "sin(500*theta)*(1+theta/10)"
    motion = fb.simulate(s, 1, initial={"theta'": 3})
    lanes = fb.simulate(s, 1, initial={"theta'": [3]}, outputs=[f"max({fast})", f"min({fast})"])
    assert motion.steps == 1
    for how, crest in (("max", 2 * np.pi * 238 + np.pi / 2), ("min", 2 * np.pi * 238 - np.pi / 2)):
        theta = crest / 500
        for _ in range(3):  # Newton's method for 500 (1 + θ/10) cos 500 θ + sin 500 θ / 10
            u, wide = 500 * theta, 1 + theta / 10
            theta -= (500 * wide * np.cos(u) + np.sin(u) / 10) / (
                -250000 * wide * np.sin(u) + 100 * np.cos(u)
            )
        exact = np.sin(500 * theta) * (1 + theta / 10)
        assert motion[f"{how}({fast})"] == pytest.approx(exact, rel=1e-12)
        assert lanes[f"{how}({fast})"].values == pytest.approx([exact], rel=1e-12)


def test_a_quantity_too_fast_for_its_extremes_is_refused_by_name():
    motion = fb.simulate(wheel(), 1, initial={"theta'": 3})
    with pytest.raises(
        SimulationError, match=r"'sin\(1e9\*theta\)' has more of them than 4096 parts of a step"
    ):
        motion["max(sin(1e9*theta))"]
    lanes = fb.simulate(wheel(), 1, initial={"theta'": [3]}, outputs=["max(sin(1e9*theta))"])
    assert lanes.status.values == ["event not resolved"] and lanes.blame.values == ["sin(1e9*theta)"]


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


# The bar hangs straight down with theta'^2 = 3 g (1 - cos theta_0)/L: the pin carries m g + m L theta'^2/2.
LARGEST = 9.81 * (5 - 3 * np.cos(1.0)) / 2


@pytest.mark.parametrize("method", ["dop853", "taylor", "radau", "gauss"])
def test_reactions_are_outputs_of_lanes(method):
    names = ["pin", "pin.force", "max(pin)", "min(pin.force.y)", "max(pin.moment.z)"]
    lanes = fb.simulate(pendulum(), 2, initial={"theta": [0.5, 1.0]}, outputs=names, method=method, samples=5)
    motion = fb.simulate(pendulum(), 2, initial={"theta": 1.0}, times=lanes.time.values)
    force = motion.reactions["pin"].force
    assert lanes["max(pin)"][1] == pytest.approx(LARGEST, rel=1e-8)
    assert lanes["max(pin.moment.z)"][1] == pytest.approx(0, abs=1e-12)
    assert lanes["pin"].values[1] == pytest.approx(np.linalg.norm(force, axis=1), rel=1e-7)
    for i, axis in enumerate("xyz"):
        assert lanes[f"pin.force.{axis}"].values[1] == pytest.approx(force[:, i], rel=1e-7, abs=1e-7)
    assert lanes["max(pin)"].attrs["units"] == "N" and lanes["max(pin.moment.z)"].attrs["units"] == "N m"


def test_reactions_of_a_motion_by_name():
    motion = fb.simulate(pendulum(), 2, initial={"theta": 1.0})
    reaction = motion.reactions["pin"]
    assert (motion["pin.force"] == reaction.force).all() and (
        motion["pin.moment.z"] == reaction.moment[:, 2]
    ).all()
    assert motion["pin"] == pytest.approx(np.linalg.norm(reaction.force, axis=1), rel=1e-15)
    assert motion["max(pin)"] == pytest.approx(LARGEST, rel=1e-8)


def test_reaction_of_a_joint_that_closes_a_loop_and_of_a_coordinate_with_its_name():
    from freebody.gallery.beyond.four_bar import NEAR, build

    alone = fb.simulate(build(), 0.5, near=NEAR)
    largest = fb.simulate(build(), 0.5, values={"g": [9.81, 0]}, near=NEAR, outputs="max(C)")["max(C)"].values
    assert alone["C"] == pytest.approx(np.linalg.norm(alone.reactions["C"].force, axis=1), rel=1e-15)
    assert largest[0] == pytest.approx(alone["max(C)"], rel=1e-8) and largest[0] > alone["C"].max() * (
        1 - 1e-12
    )
    assert abs(largest[1] - largest[0]) > 1
    s = fb.System("slider")
    s.slider("x", s.ground, s.body("block", fb.particle(1)), axis="x", coordinate="x")
    assert fb.simulate(s, 1, initial={"x": 2.0})["x"][0] == 2  # the coordinate


def test_derivatives_of_a_reaction():
    motion = fb.simulate(pendulum(), 2, initial={"theta": 1.0}, sensitivities=["theta"])
    step = 1e-4
    ends = [fb.simulate(pendulum(), 2, initial={"theta": 1 + h}, tolerance=1e-12) for h in (step, -step)]
    for name in ("pin", "pin.force.x"):
        difference = (ends[0][name] - ends[1][name]) / (2 * step)
        assert motion.sensitivity.of(name)[:, 0] == pytest.approx(difference, abs=1e-5)
    # d/d theta_0 of m g (5 - 3 cos theta_0)/2
    assert motion.sensitivity.of("max(pin)")[0] == pytest.approx(9.81 * 1.5 * np.sin(1.0), rel=1e-6)


def test_a_vector_has_no_greatest_value():
    with pytest.raises(SimulationError, match=r"ask for 'max\(pin.force.x\)'"):
        fb.simulate(pendulum(), 1, initial={"theta": [1.0]}, outputs=["max(pin.force)"])
