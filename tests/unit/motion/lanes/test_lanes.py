"""Eight lanes in a register: each is the run alone, to the last bit, whatever its neighbours do."""

from __future__ import annotations

import numpy as np
import pytest
import xarray

import freebody as fb
from batch_machines import CLOSED, cart, four_bar
from batch_machines import pendulum as driven
from freebody.motion.ode.layout import EXPLICIT

pytestmark = pytest.mark.usefixtures("stages")


def pendulum() -> fb.System:
    """Of a root "auto" makes no series: a run alone goes by "dop853" as lanes do."""
    return driven("m*sin(3*t)*sqrt(2 + cos(t))")


@pytest.mark.parametrize("lanes", [8, 13, 40])
def test_driven_pendulums_with_work_and_time(loops: list[bool], lanes: int) -> None:
    s = pendulum()
    theta, damping = np.linspace(-3, 3, lanes), np.linspace(0, 0.5, lanes)
    times = [0.0, 0.3, 0.31, 4.0, 2.5]
    data = fb.simulate(
        s, 4, initial={"theta": theta}, values={"c": damping}, tolerance=1e-9, times=times, max_step=0.5,
        outputs=["theta", "theta'", "work", "energy"],
    )  # fmt: skip
    assert loops == [True]
    for k in range(lanes):
        alone = fb.simulate(
            s,
            4,
            initial={"theta": theta[k]},
            values={"c": damping[k]},
            tolerance=1e-9,
            times=times,
            max_step=0.5,
        )
        for name in ("theta", "theta'", "work"):
            assert np.array_equal(data[name][k], alone[name]), (k, name)
        assert int(data.steps[k]) == alone.steps and float(data.end[k]) == 4


def test_free_bodies_with_quaternions_and_backwards(loops: list[bool]) -> None:
    s = fb.System("stone")
    m = s.parameters(m=2.0)
    s.free("turn", s.ground, s.body("stone", fb.box(m, (0.1, 0.2, 0.4))))
    rates = np.linspace(0.5, 9, 11)
    start = {"turn": fb.Rotation.axis_angle((1, 0, 0), 0.4), "turn_wy": 3.0, "turn_wz": 0.1, "turn_vx": 1.0}
    for until in (3.0, -3.0):
        options = {"samples": 4, "method": "dop853"}
        data = fb.simulate(s, until, initial={**start, "turn_wx": rates}, **options)
        for k in range(11):
            alone = fb.simulate(s, until, initial={**start, "turn_wx": rates[k]}, **options)
            for name in alone.names:
                assert np.array_equal(data[name][k], alone[name]), (until, k, name)
    assert loops == [True, True]


def test_lanes_that_fail_or_are_stiff_do_not_touch_their_neighbours(loops: list[bool]) -> None:
    s = cart()
    s.generalized_force("x", "sqrt(x + 2)")
    stiffness = np.ones(20)
    damping = np.linspace(0.1, 2, 20)
    stiffness[[3, 11]], damping[[3, 11]] = 1e6, 1e5
    x = np.linspace(0, 1, 20)
    speed = np.zeros(20)
    x[7], speed[8] = -2.5, -60.0  # no force there from the start; runs into where there is none
    data = fb.simulate(
        s, 10, initial={"x": x, "x'": speed}, values={"k": stiffness, "c": damping}, samples=5, tolerance=1e-7
    )
    assert loops == [True, False]  # the stiff ones again, by radau
    for lane in range(20):
        given = {
            "initial": {"x": x[lane], "x'": speed[lane]},
            "values": {"k": stiffness[lane], "c": damping[lane]},
        }
        if lane in (7, 8):
            assert data.status.values[lane] == "not finite"
            with pytest.raises(fb.errors.SimulationError) as caught:
                fb.simulate(s, 10, samples=5, tolerance=1e-7, **given)
            assert float(data.end[lane]) == caught.value.trajectory.path.end
            continue
        alone = fb.simulate(s, 10, samples=5, tolerance=1e-7, **given)
        assert np.array_equal(data["x"][lane], alone["x"]), lane
        assert data.status.values[lane] == "finished"
    few = fb.simulate(s, 10, initial={"x": x[:7]}, values={"k": np.linspace(1, 2, 7)}, max_steps=3, samples=2)
    more = fb.simulate(s, 10, initial={"x": x[:7].tolist() + [0, 0]}, max_steps=3, samples=2)
    assert set(few.status.values) == set(more.status.values) == {"too many steps"}
    assert set(few.steps.values) == set(more.steps.values) == {3}


def test_long_runs_tighten_where_a_run_alone_does(loops: list[bool]) -> None:
    """After its budget of 30,000 steps a run with "auto" takes shorter ones; in the register, and lane by lane."""
    s = pendulum()
    start, speeds = 1.0, np.linspace(1.0, 1.4, 8)
    given = {"values": {"m": 1.0}, "samples": 3, "tolerance": 2e-10}
    together = fb.simulate(s, 14000, initial={"theta": start, "theta'": speeds}, **given)
    by_lane = fb.simulate(s, 14000, initial={"theta": start, "theta'": speeds[:2]}, **given)
    never = fb.simulate(
        s, 14000, initial={"theta": start, "theta'": speeds[:2]}, **{**given, "method": "dop853"}
    )
    assert loops == [True, False, False]
    for k in (0, 1):
        alone = fb.simulate(s, 14000, initial={"theta": start, "theta'": speeds[k]}, **given)
        assert alone.steps > int(never.steps[k]) > 30_000  # so there was something to tighten
        for data in (together, by_lane):
            assert int(data.steps[k]) == alone.steps
            assert np.array_equal(data["theta"][k], alone["theta"])
            assert np.array_equal(data["theta'"][k], alone["theta'"])


def both(
    s: fb.System, until: float, initial: dict, values: dict, count: int, **options: object
) -> xarray.Dataset:
    """Lanes in registers of eight; all that they leave is what they leave one after another."""

    def run(some: slice) -> xarray.Dataset:
        return fb.simulate(
            s, until, **options, **{  # type: ignore[arg-type]
                "initial": {k: v[some] if np.ndim(v) else v for k, v in initial.items()},
                "values": {k: v[some] if np.ndim(v) else v for k, v in values.items()},
            },
        )  # fmt: skip

    together = run(slice(0, count))
    for low in range(0, count, 7):
        some = slice(low, min(low + 7, count))
        for name, found in run(some).data_vars.items():
            other = together[name].values[some]
            assert np.array_equal(found.values, other, equal_nan=other.dtype.kind == "f"), (low, name)
    return together


def test_events_and_extremes(loops: list[bool]) -> None:
    """Looked for in the step of a lane that is lifted out of the register."""
    theta, damping = np.linspace(-3, 3, 17), np.linspace(0, 0.5, 17)
    for terminal in (False, True):
        data = both(
            pendulum(), 4, {"theta": theta}, {"c": damping}, 17, times=[0.0, 1.3, 4.0, 2.5],
            outputs=["theta", "work", "max(theta)", "min(theta')", "initial(theta)", "final(energy)"],
            events=[fb.event("theta", direction=1), fb.event("theta' - 1", terminal=terminal), "theta - 0.5"],
        )  # fmt: skip
        assert terminal or (data.event_count > 1).any()
        assert np.isfinite(data["max(theta)"]).all()
        assert ("terminal event" in data.status.values) == terminal
        assert loops[-4:] == [True, False, False, False]


@pytest.mark.parametrize("method", EXPLICIT)
def test_every_explicit_method(method: str, loops: list[bool]) -> None:
    """A method is written once, and is translated for one run and for eight lanes."""
    theta = np.linspace(-2, 2, 9)
    given = {"method": method, "tolerance": 1e-6, "samples": 4, "events": ["theta"]}
    data = both(pendulum(), 3, {"theta": theta}, {}, 9, **given)
    assert set(data.status.values) == {"finished"} and loops == [True, False, False]
    alone = fb.simulate(pendulum(), 3, initial={"theta": theta[4]}, **given)
    assert np.array_equal(data["theta"][4], alone["theta"]) and int(data.steps[4]) == alone.steps


def test_closed_loops(loops: list[bool]) -> None:
    """Projected onto the constraints eight at a time."""
    data = both(
        four_bar(), 2, {"q1": np.linspace(0.9, 1.1, 9)}, {}, 9, near=CLOSED, samples=4, events=["q3'"],
        outputs=["q1", "q2", "q3", "max(q3)"],
    )  # fmt: skip
    assert set(data.status.values) == {"finished"}
    assert loops == [True, False, False]


def test_steps_of_one_length(loops: list[bool]) -> None:
    both(
        pendulum(),
        3,
        {"theta": np.linspace(-1, 1, 9)},
        {},
        9,
        method="dop853",
        step=0.07,
        samples=5,
        events=["theta"],
    )
    assert loops == [True, False, False]


@pytest.mark.parametrize("method", ["dop853", "tsit5", "radau", "gauss"])
def test_outputs_in_the_middle_of_steps_of_one_length(method: str) -> None:
    """They are at the same fraction of each step, but not the same states."""
    times = np.arange(33) / 16
    given = {"method": method, "step": 1 / 8, "times": times}
    lanes = fb.simulate(pendulum(), 2, initial={"theta": np.array([1.0, 0.5])}, **given)["theta"]
    alone = fb.simulate(pendulum(), 2, initial={"theta": 1.0}, **given)["theta"]
    assert np.array_equal(lanes[0], alone) and len(set(alone.tolist())) > 30


def test_signals_that_jump(loops: list[bool]) -> None:
    """An event where a signal jumps, and the end of a run there."""
    gusts = fb.signal([0, 0.5, 1.0], [0, 2, -1], "previous", name="wind")
    s = pendulum()
    s.generalized_force("theta", gusts)
    for terminal in (False, True):
        data = both(
            s, 2, {"theta": np.linspace(-1, 1, 9)}, {}, 9, samples=5, outputs=["theta", "max(wind)"],
            events=[fb.event("wind - 1", name="up", direction=1),
                    fb.event("wind - 1", name="down", direction=-1, terminal=terminal)],
        )  # fmt: skip
        assert set(data.status.values) == {"terminal event" if terminal else "finished"}
    assert loops == 2 * [True, False, False]
