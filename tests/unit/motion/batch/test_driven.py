"""Signals in the compiled lanes: every lane is the driven run alone, to the last bit."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from batch_machines import CLOSED, cart, four_bar
from freebody.errors import SimulationError

WIND = fb.signal([0, 0.4, 0.5, 0.9, 1.3, 3], [0, 3, -1, 2, 2, 0], name="wind")


def pendulum(signal=WIND) -> fb.System:
    s = fb.System("pendulum in the wind")
    m, L, g, c = s.parameters(m=1.0, L=0.5, g=9.81, c=0.1)
    s.gravity = (0, -g, 0)
    bob = s.body("bob", fb.particle(m))
    pin = s.hinge("pin", s.ground, bob, to=(0, L, 0), axis="z", coordinate="theta")
    s.damper("c", pin, damping=c)
    s.force("push", bob, (signal, 0, 0))
    return s


def check(s: fb.System, until: float, initial: dict, values: dict, count: int, **options) -> None:
    names = ["theta", "theta'", "work", "energy"]
    data = fb.simulate(s, until, initial=initial, values=values, outputs=names, **options)
    for k in range(count):
        alone = fb.simulate(
            s,
            until,
            initial={name: x[k] for name, x in initial.items()},
            values={name: x[k] for name, x in values.items()},
            **options,
        )
        assert str(data.status.values[k]) == alone.status
        known = np.isfinite(data["theta"].values[k])
        for name in names[:3]:
            assert np.array_equal(data[name].values[k, known], alone[name]), (k, name)
        assert np.allclose(data["energy"].values[k, known], alone.energy.total, rtol=1e-15, atol=0)
        assert int(data.steps[k]) == alone.steps and float(data.end[k]) == alone.path.end
        for e, name in enumerate(data.event.values if "event" in data.dims else ()):
            found = [one.time for one in alone.events if one.name == name]
            assert int(data.event_count[k, e]) == len(found), (k, name)
            if found:
                assert (data.event_time[k, e], data.event_last[k, e]) == (found[0], found[-1])


TIMES = [2.0, 0.0, 0.3, 0.5, 0.9, 0.45, 0.4, 1.9]  # on and between break points, not in order


@pytest.mark.parametrize("method", ["auto", "dop54", "gauss", "radau"])
def test_each_driven_lane_is_the_run_alone(method: str, loops: list[bool]) -> None:
    """Events at zeros of the motion, and of an expression of the signal that bends at its break points."""
    k = np.arange(5)
    check(
        pendulum(), 2, {"theta": -1 + 0.4 * k}, {"L": 0.4 + 0.1 * k, "c": 0.1 * k}, 5, method=method, tolerance=1e-8,
        times=TIMES, events=["theta", fb.event("wind*cos(theta) - 1", name="gust")],
    )  # fmt: skip
    assert loops == [False]


@pytest.mark.parametrize("kind", ["previous", "linear", "cubic"])
def test_eight_driven_lanes_at_once_are_runs_alone(kind: str, loops: list[bool]) -> None:
    k = np.arange(13)
    wind = fb.signal(WIND.times, [0, 3, -1, 2, 2, 0], kind, name="wind")
    check(
        pendulum(wind), 2, {"theta": -1 + 0.2 * k, "theta'": 0.3 * k}, {"c": 0.02 * k}, 13, times=TIMES, tolerance=1e-10
    )  # fmt: skip
    assert loops == [True]


def test_steps_of_one_length_and_greatest_steps(loops: list[bool]) -> None:
    k = np.arange(3)
    start = {"theta": 0.3 * k}
    check(pendulum(), 2, start, {}, 3, times=TIMES, method="dop54", step=0.03)
    check(pendulum(), 2, start, {}, 3, times=TIMES, max_step=0.05)
    check(pendulum(), 2, {"theta": 0.3 * np.arange(9)}, {}, 9, times=TIMES, max_step=0.05)
    assert loops == [False, False, True]


@pytest.mark.parametrize("lanes", [3, 9])
def test_steps_are_counted_over_all_legs(lanes: int, loops: list[bool]) -> None:
    """A run alone stops after as many steps, where it was; also where they end with a leg."""
    s, theta = pendulum(), np.linspace(0.3, 1, lanes)
    whole = fb.simulate(s, 2, initial={"theta": theta}, samples=2)
    first_leg = fb.simulate(s, 0.4, initial={"theta": theta}, samples=2)
    for most in (int(whole.steps.min()) - 2, int(first_leg.steps[0])):
        data = fb.simulate(s, 2, initial={"theta": theta}, samples=2, max_steps=most)
        assert set(data.status.values) == {"too many steps"} and set(data.steps.values) == {most}
        for k in range(lanes):
            with pytest.raises(SimulationError, match=f"max_steps = {most} steps reached only") as caught:
                fb.simulate(s, 2, initial={"theta": theta[k]}, samples=2, max_steps=most)
            assert float(data.end[k]) == caught.value.trajectory.path.end
    assert loops == [lanes == 9] * 4


def test_a_signal_that_jumps_across_an_event_function(loops: list[bool]) -> None:
    """A held signal jumps through the event's level at a break point: an event, and the end if it is terminal."""
    gusts = fb.signal([0, 0.5, 1.0], [0, 2, -1], "previous", name="wind")
    k = np.arange(4)
    for terminal in (False, True):
        check(
            pendulum(gusts), 2, {"theta": 0.2 * k}, {}, 4, times=TIMES,
            events=[fb.event("wind - 1", name="up", direction=1), fb.event("wind - 1", name="down", direction=-1,
                                                                           terminal=terminal)],
        )  # fmt: skip
    data = fb.simulate(
        pendulum(gusts), 2, initial={"theta": 0.2 * k}, outputs=["max(wind)", "min(wind)", "max(wind*t)"]
    )
    # just before 1 s the held value is 2; the greatest product is the limit there, that of the break point itself is -1
    assert set(data["max(wind)"].values) == {2.0} and set(data["min(wind)"].values) == {-1.0}
    assert np.allclose(data["max(wind*t)"], 2.0, rtol=1e-12)
    assert loops == [False, False, False]


def test_a_crank_that_a_signal_turns_and_free_bodies_with_quaternions() -> None:
    """Prescribed turns with constraints of their own, and quaternions normalised at every break point."""
    s = fb.System("stone in the wind")
    m = s.parameters(m=2.0)
    stone = s.body("stone", fb.box(m, (0.1, 0.2, 0.4)))
    s.free("turn", s.ground, stone)
    s.torque("twist", stone, (WIND, 0.1, 0))
    rates = np.linspace(0.5, 4, 9)
    start = {"turn": fb.Rotation.axis_angle((1, 0, 0), 0.4), "turn_wy": 3.0}
    data = fb.simulate(s, 2, initial={**start, "turn_wx": rates}, samples=4)
    few = fb.simulate(s, 2, initial={**start, "turn_wx": rates[:3]}, samples=4, events=["turn_wx"])
    for k in range(9):
        alone = fb.simulate(s, 2, initial={**start, "turn_wx": rates[k]}, samples=4)
        for name in alone.names:
            assert np.array_equal(data[name][k], alone[name]), (k, name)
            assert k > 2 or np.array_equal(few[name][k], alone[name]), (k, name)
    s = four_bar()
    s.torque("motor", s.joints["A"], WIND)
    data = fb.simulate(s, 1, initial={"q1": 1.0, "q1'": [1.0, 4.0]}, near=CLOSED, samples=4)
    for k, speed in enumerate((1.0, 4.0)):
        alone = fb.simulate(s, 1, initial={"q1": 1.0, "q1'": speed}, near=CLOSED, samples=4)
        for name in alone.names:
            assert np.array_equal(data[name][k], alone[name]), name


def test_a_stiff_leg_changes_the_method_there_as_alone() -> None:
    s = cart()
    s.generalized_force("x", fb.signal([0.0, 0.5, 20.0], [0.0, 1.0, 0.0], name="push"))
    stiffness, damping = np.array([1.0, 1e6]), np.array([1.0, 1e5])
    options = {"tolerance": 1e-7, "samples": 3}
    data = fb.simulate(s, 10, initial={"x": 1.0}, values={"k": stiffness, "c": damping}, **options)
    assert set(data.status.values) == {"finished"} and int(data.steps[1]) < 5000  # not 80,000
    for lane in range(2):
        alone = fb.simulate(
            s, 10, initial={"x": 1.0}, values={"k": stiffness[lane], "c": damping[lane]}, **options
        )
        assert np.array_equal(data["x"][lane], alone["x"]) and int(data.steps[lane]) == alone.steps


def test_refusals() -> None:
    s, start = pendulum(), {"theta": [0.1, 0.2]}
    with pytest.raises(SimulationError, match="signals and controllers have no way back"):
        fb.simulate(s, -1, initial=start)
    with pytest.raises(
        SimulationError, match="'wind' is given from 0 to 3 s, but its value is needed at t = 4 s"
    ):
        fb.simulate(s, 4, initial=start)
    other = fb.signal([0, 5], [0, 1], name="other")
    with pytest.raises(SimulationError, match="Signal 'other' occurs in no load"):
        fb.simulate(s, 1, initial=start, outputs=[other * 2])
