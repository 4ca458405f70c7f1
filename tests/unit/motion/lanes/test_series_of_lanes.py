"""Lanes by Taylor series, eight at a time: the motion of a run alone, whatever the neighbours do."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import freebody as fb
from batch_machines import CLOSED, cart, four_bar, pendulum, rail
from freebody.errors import SimulationError
from freebody.model import assemble
from freebody.motion.batch.job import job_of
from freebody.motion.request import Request
from freebody.testing import random_state, random_system

EPS = np.finfo(float).eps
NAMES = ("status", "end", "steps", "blame")


def stone() -> fb.System:
    s = fb.System("stone")
    m = s.parameters(m=2.0)
    s.free("turn", s.ground, s.body("stone", fb.box(m, (0.1, 0.2, 0.4))))
    return s


TUMBLING = {"turn": fb.Rotation.axis_angle((1, 0, 0), 0.4), "turn_wy": 3.0, "turn_wz": 0.1, "turn_vx": 1.0}


@pytest.mark.parametrize("joint", ["hinge", "slider", "cylindrical", "universal", "planar", "screw"])
@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_random_machines_move_as_alone(joint: str, seed: int, loops: list[bool]) -> None:
    """Parameters, starts and constants of each lane are its own. The sums of a lane are added in another order than
    those of a run alone: at 1e-13 both are off by so much a step."""
    model = assemble(random_system(seed, 1, (joint,)))
    names = [*model.coordinate_names, *model.speed_names]
    states = np.array([np.concatenate(random_state(model, k)) for k in range(11)])
    given = {"tolerance": 1e-13, "method": "taylor", "times": [0.3, 0.1, 0.5]}
    data = fb.simulate(model, 0.5, initial=dict(zip(names, states.T, strict=True)), **given)
    assert loops == [True] and set(data.status.values) == {"finished"}
    for k, state in enumerate(states):
        alone = fb.simulate(model, 0.5, initial=dict(zip(names, state, strict=True)), **given)
        scale = 1 + np.abs(alone.states).max()
        assert abs(int(data.steps[k]) - alone.steps) <= 1
        for name in names:
            assert np.abs(data[name][k].values - alone[name]).max() < 1e-10 * scale, (k, name)


@pytest.mark.parametrize("count", [1, 3, 8, 13])
def test_a_lane_does_not_depend_on_its_neighbours(count: int, loops: list[bool]) -> None:
    """To the last bit: in any number, place and order, beside lanes that end, fail or take longer steps."""
    rng = np.random.default_rng(count)
    s = pendulum()
    s.generalized_force("theta", "sqrt(theta + 3.5)/100")
    theta, damping = np.linspace(-3, 3, 21), np.linspace(0, 0.5, 21)
    speed = np.where(np.arange(21) % 7 == 3, -30.0, 0.0)  # runs into where there is no force
    given = {"tolerance": 1e-9, "method": "taylor", "times": [0.5, 2.0, 3.9]}
    options = {
        "events": [fb.event("theta'"), fb.event("theta - 1", terminal=True)],
        "outputs": ["theta", "work"],
    }

    def run(lanes: list[int], **more: object) -> object:
        return fb.simulate(
            s, 4, initial={"theta": theta[lanes], "theta'": speed[lanes]}, values={"c": damping[lanes]}, **given,
            **options, **more,
        )  # fmt: skip

    whole = run(list(range(21)))
    assert {"finished", "not finite", "terminal event"} == set(whole.status.values)
    some = rng.permutation(21)[:count].tolist()
    for threads in (1, 2):
        part = run(some, threads=threads)
        for name in (*NAMES, "theta", "work", "event_time", "event_last", "event_count"):
            mine, other = part[name].values, whole[name].values[some]
            assert np.array_equal(mine, other, equal_nan=mine.dtype.kind == "f"), name
    assert set(loops) == {True}


@pytest.mark.parametrize("tolerance", [1e-9, 1e-11])
def test_series_stop_before_bends_in_the_lanes_that_have_one(tolerance: float, loops: list[bool]) -> None:
    """√(x²) is |x|: from x = r the block passes through the other end of its spring where ½ m v² > ½ k r², v > 3 m/s.
    ½ v² + ½ k (|x| - r)² is kept, and a lane is the run alone."""
    speeds = np.concatenate([np.linspace(0.4, 2.4, 5), np.linspace(4, 7, 7)])
    given = {"tolerance": tolerance, "method": "taylor", "samples": 5}
    data = fb.simulate(
        rail(), 3, initial={"x": 0.3, "x'": speeds}, outputs=["x", "x'", "min(x)"], events=["x"], **given
    )
    assert loops == [True] and set(data.status.values) == {"finished"}
    passes = speeds > 3
    assert ((data["min(x)"].values < 0) == passes).all() and (
        (data.event_count.values[:, 0] > 0) == passes
    ).all()
    energy = data["x'"].values ** 2 + 100 * (np.abs(data["x"].values) - 0.3) ** 2
    assert np.abs(energy / speeds[:, None] ** 2 - 1).max() < 1e3 * tolerance
    for k, speed in enumerate(speeds):
        alone = fb.simulate(rail(), 3, initial={"x": 0.3, "x'": speed}, events=["x"], **given)
        assert alone.path.method == "taylor" and (alone.path.rejected > 0) == passes[k]
        # how close to a bend the last step before it comes is a matter of round-off
        assert abs(int(data.steps[k]) - alone.steps) <= (0.3 * alone.steps if passes[k] else 0)
        for name in ("x", "x'"):
            assert data[name][k].values == pytest.approx(alone[name], abs=2e4 * tolerance)
        assert int(data.event_count[k, 0]) == len(alone.events)
    some = [11, 2, 7]
    few = fb.simulate(rail(), 3, initial={"x": 0.3, "x'": speeds[some]}, outputs=["x", "x'"], **given)
    whole = fb.simulate(rail(), 3, initial={"x": 0.3, "x'": speeds}, outputs=["x", "x'"], **given)
    for name in ("x", "x'", "steps"):
        assert np.array_equal(few[name].values, whole[name].values[some])


@pytest.mark.parametrize("tolerance", [1e-5, 1e-7, 1e-9, 1e-11, 1e-13])
def test_series_look_for_bends_halfway_and_cross_those_closer_than_time_resolves(tolerance: float) -> None:
    """Steps that end on this side of the bend and have been behind it, and bends within the last digit of the time:
    of 1000 lanes some have either. ½ v² + ½ k (|x| - r)² is kept as a run alone keeps it."""
    speeds = np.random.default_rng(0).uniform(0.2, 8, 1000)
    data = fb.simulate(
        rail(), 3, initial={"x": 1.0, "x'": speeds}, outputs=["x", "x'"], tolerance=tolerance, method="taylor",
        samples=5, progress=False,
    )  # fmt: skip
    assert set(data.status.values) == {"finished"}
    energy = data["x'"].values ** 2 + 100 * (np.abs(data["x"].values) - 0.3) ** 2
    first = speeds**2 + 100 * (1 - 0.3) ** 2
    assert np.abs(energy / first[:, None] - 1).max() < 1e3 * tolerance


def test_closed_loops_with_a_spring_across() -> None:
    """Rates of a machine whose states are projected, at the ends of steps that are not yet."""
    s, start = four_bar(), {"q1": np.linspace(0.9, 1.1, 9)}
    s.spring("across", s.ground.point(0, 2, 0), s.bodies["b"].point(0, 0, 0), stiffness=20, rest=1)
    given = {"near": CLOSED, "tolerance": 1e-11, "method": "taylor", "samples": 5}
    data = fb.simulate(s, 2, initial=start, outputs=["q1", "q3"], **given)
    assert set(data.status.values) == {"finished"}
    for k in (0, 8):
        alone = fb.simulate(s, 2, initial={"q1": start["q1"][k]}, **given)
        assert abs(int(data.steps[k]) - alone.steps) <= 1
        for name in ("q1", "q3"):
            assert data[name][k].values == pytest.approx(alone[name], abs=1e-8)


def test_the_order_is_sixteen() -> None:
    """Slope of the error over the step, quaternions being normalised after each."""
    s = fb.System("top")
    s.gravity = (0, 0, -9.81)
    top = s.body("top", fb.cylinder(1, 0.1, 0.3, axis="z"))
    s.ball("o", s.ground, top, to=(0, 0, -0.3))
    start = {"o": (math.cos(0.25), math.sin(0.25), 0, 0), "o_wz": np.linspace(12, 20, 9), "o_wx": 0.3}

    def end(**options: object) -> np.ndarray:
        data = fb.simulate(s, 0.4, initial=start, times=[0.4], outputs=["o_wx", "o_wy"], **options)
        return np.stack([data[name].values[:, -1] for name in ("o_wx", "o_wy")])

    exact = end(method="gauss", tolerance=1e-15)
    numbers = (5, 6, 7, 8, 10, 12)
    errors = [np.abs(end(method="taylor", step=0.4 / k) - exact).max() for k in numbers]
    assert errors[-1] > 10 * EPS
    assert np.polyfit(np.log(numbers), np.log(errors), 1)[0] == pytest.approx(-16, abs=1)


def test_steps_of_one_length_and_greatest_steps() -> None:
    s, theta = pendulum(), np.linspace(0.1, 2, 9)
    data = fb.simulate(s, 3, initial={"theta": theta}, method="taylor", step=0.07, samples=3)
    assert set(data.steps.values) == {43}
    alone = fb.simulate(s, 3, initial={"theta": theta[4]}, method="taylor", step=0.07, samples=3)
    assert data["theta"][4].values == pytest.approx(alone["theta"], abs=1e-13)
    data = fb.simulate(s, 3, initial={"theta": theta}, method="taylor", max_step=0.02, samples=3)
    assert set(data.steps.values) <= {150, 151}


def test_events_extremes_and_energies_are_as_alone() -> None:
    s = pendulum()
    theta, damping = np.linspace(-2.5, 2.5, 10), np.linspace(0, 0.5, 10)
    given = {"tolerance": 1e-12, "method": "taylor", "events": [fb.event("theta", direction=1), "theta' - 1"]}
    data = fb.simulate(
        s, 6, initial={"theta": theta}, values={"c": damping}, samples=7,
        outputs=["theta", "work", "energy", "work_rate", "max(theta)", "min(theta')", "final(theta)"], **given,
    )  # fmt: skip
    for k in range(10):
        alone = fb.simulate(s, 6, initial={"theta": theta[k]}, values={"c": damping[k]}, samples=7, **given)
        for e in (0, 1):
            times = [x.time for x in alone.path.crossings if x.number == e]
            assert int(data.event_count[k, e]) == len(times) > 0
            assert data.event_time[k, e] == pytest.approx(times[0], abs=1e-9)
            assert data.event_last[k, e] == pytest.approx(times[-1], abs=1e-9)
        assert data["theta"][k].values == pytest.approx(alone["theta"], abs=1e-9)
        assert data["work"][k].values == pytest.approx(alone["work"], abs=1e-9)
        assert data["energy"][k].values == pytest.approx(alone.energy.total, abs=1e-8)
        fine = fb.simulate(
            s, 6, initial={"theta": theta[k]}, values={"c": damping[k]}, samples=20001, **given
        )
        assert float(data["max(theta)"][k]) == pytest.approx(np.max(fine["theta"]), abs=1e-6)
        assert float(data["min(theta')"][k]) == pytest.approx(np.min(fine["theta'"]), abs=1e-6)
        assert float(data["final(theta)"][k]) == float(data["theta"][k, -1])


def test_terminal_events_end_each_lane_at_its_own_time() -> None:
    """θ = 0 on the polynomial itself."""
    s, theta = pendulum(), np.linspace(0.2, 2.8, 12)
    data = fb.simulate(
        s, 1e3, initial={"theta": theta}, events=fb.event("theta", terminal=True), method="taylor", tolerance=1e-13,
        times=[0.0, 0.1, 1e3], outputs=["theta", "final(theta)"],
    )  # fmt: skip
    assert set(data.status.values) == {"terminal event"}
    assert np.array_equal(data.end.values, data.event_time.values[:, 0])
    assert np.abs(data["final(theta)"].values).max() < 1e-13
    assert np.isnan(data["theta"][:, -1]).all() and np.isfinite(data["theta"][:, :2]).all()
    for k in (0, 7):
        alone = fb.simulate(
            s, 1e3, initial={"theta": theta[k]}, events=fb.event("theta", terminal=True), method="gauss",
            tolerance=1e-14,
        )  # fmt: skip
        assert float(data.end[k]) == pytest.approx(alone.path.end, abs=1e-11)


def test_free_bodies_with_quaternions_and_backwards() -> None:
    s, rates = stone(), np.linspace(0.5, 9, 11)
    for until in (3.0, -3.0):
        given = {"samples": 4, "method": "taylor", "tolerance": 1e-13}
        data = fb.simulate(s, until, initial={**TUMBLING, "turn_wx": rates}, **given)
        for k in range(11):
            alone = fb.simulate(s, until, initial={**TUMBLING, "turn_wx": rates[k]}, **given)
            for name in alone.names:
                assert data[name][k].values == pytest.approx(alone[name], abs=1e-11), (until, k, name)
        e = np.stack([data[name].values for name in alone.names[3:7]])
        assert any("e0" in name for name in alone.names[3:7])
        assert np.abs((e**2).sum(axis=0) - 1).max() < 8 * EPS


def test_closed_loops_stay_closed() -> None:
    s, start = four_bar(), {"q1": np.linspace(0.9, 1.1, 10)}
    given = {"near": CLOSED, "tolerance": 1e-12, "method": "taylor", "samples": 5}
    gaps = {"gap": "cos(q1) + 3*cos(q1 + q2) - 3 - 2*cos(q3)"}
    data = fb.simulate(s, 2, initial=start, outputs={"q1": "q1", "q3": "q3", **gaps}, **given)
    assert set(data.status.values) == {"finished"}
    assert np.abs(data["gap"].values).max() < 1e-13
    for k in (0, 9):
        alone = fb.simulate(s, 2, initial={"q1": start["q1"][k]}, **given)
        for name in ("q1", "q3"):
            assert data[name][k].values == pytest.approx(alone[name], abs=1e-9)


def test_signals_go_from_break_to_break() -> None:
    """Events where a signal jumps, settings of each leg, outputs at break points; a jump that ends the run."""
    push = fb.signal([0, 1, 2, 3], [1.0, -2.0, 0.5, 0.5], "previous", name="push")
    s = fb.System("pushed")
    k = s.parameters(k=1.0)
    block = s.body("block", fb.particle(1))
    s.spring("k", s.slider("rail", s.ground, block, axis="x", coordinate="x"), stiffness=k)
    s.force("push", block, (push, 0, 0))
    stiffness = np.linspace(0.5, 3, 9)
    for terminal in (False, True):
        jump = fb.event("push", terminal=terminal)
        given = {"times": [0.5, 1.0, 2.0, 3.0], "events": [jump], "tolerance": 1e-13, "method": "taylor"}
        data = fb.simulate(s, 3, initial={"x": 0.3}, values={"k": stiffness}, **given)
        for lane in range(9):
            alone = fb.simulate(s, 3, initial={"x": 0.3}, values={"k": stiffness[lane]}, **given)
            known = np.isfinite(data["x"][lane].values)
            assert data["x"][lane].values[known] == pytest.approx(alone["x"], abs=1e-12)
            assert int(data.event_count[lane, 0]) == len(alone.events) == (1 if terminal else 2)
            assert int(data.steps[lane]) == alone.steps and float(data.end[lane]) == alone.path.end


@pytest.mark.slow  # the loop of "radau" has to be compiled; `test_batch` has the fast one of stages
def test_what_decays_is_left_to_radau(loops: list[bool]) -> None:
    stiffness, damping = np.linspace(1, 2, 10), np.linspace(0.1, 1, 10)
    stiffness[4], damping[4] = 1e6, 1e5
    given = {"tolerance": 1e-7, "samples": 3}
    data = fb.simulate(cart(), 10, initial={"x": 1.0}, values={"k": stiffness, "c": damping}, **given)
    assert loops == [True, False] and set(data.status.values) == {"finished"}
    assert int(data.steps[4]) < 1000
    alone = fb.simulate(cart(), 10, initial={"x": 1.0}, values={"k": 1e6, "c": 1e5}, **given)
    assert alone.path.method == "radau" and np.array_equal(data["x"][4], alone["x"])
    named = fb.simulate(
        cart(),
        0.1,
        initial={"x": 1.0},
        values={"k": stiffness, "c": damping},
        method="taylor",
        max_steps=500,
        **given,
    )
    assert named.status.values[4] == "too many steps" and int(named.steps[4]) == 500


def test_long_runs_tighten_where_a_run_alone_does(monkeypatch: pytest.MonkeyPatch) -> None:
    """After its budget of steps a run with "auto" takes shorter ones."""
    from freebody.motion.batch import lane_loop
    from freebody.motion.kernels import methods

    monkeypatch.setattr(lane_loop, "BUDGET", 500)
    monkeypatch.setattr(methods, "BUDGET", 500)
    s, speeds = pendulum(), np.linspace(1.0, 1.4, 9)
    given = {"samples": 3, "tolerance": 1e-10}
    data = fb.simulate(s, 300, initial={"theta": 1.0, "theta'": speeds}, **given)
    never = fb.simulate(s, 300, initial={"theta": 1.0, "theta'": speeds}, method="taylor", **given)
    for k in (0, 8):
        alone = fb.simulate(s, 300, initial={"theta": 1.0, "theta'": speeds[k]}, **given)
        assert alone.path.method == "taylor"
        assert alone.steps > int(never.steps[k]) + 50
        assert abs(int(data.steps[k]) - alone.steps) <= 2


def test_auto_takes_series_of_small_machines_from_a_tolerance_on() -> None:
    def first(s: fb.System, tolerance: float, **options: Any) -> str:
        initial = {next(iter(assemble(s).coordinate_names)): [0.1, 0.2]}
        return job_of(Request(s, 1, **{"initial": initial, "tolerance": tolerance, **options})).first_method

    bent = cart()
    bent.generalized_force("x", "-abs(x)")
    long = random_system(3, 4, ("universal",))
    found = [first(pendulum(), x) for x in (1e-5, 1e-6, 1e-9, 1e-15)]
    assert found == ["dop853", "taylor", "taylor", "taylor"]
    assert [first(x, 1e-9) for x in (bent, long)] == ["dop853", "dop853"]
    assert first(long, 1e-15) == "gauss"
    assert first(pendulum(), 1e-9, method="radau") == "radau"


def test_what_has_no_series_is_refused() -> None:
    """Derivatives do not follow the side of a bend, as motions do: |x| of lanes that stay at x > 0 has a series."""
    s = cart()
    s.generalized_force("x", "-abs(x)")
    data = fb.simulate(s, 0.1, initial={"x": [1.0, 2.0]}, method="taylor", outputs=["x"], samples=2)
    alone = fb.simulate(s, 0.1, initial={"x": 2.0}, method="dop853", tolerance=1e-12)
    assert data["x"].values[1, -1] == pytest.approx(float(alone["x"][-1]), rel=1e-9)
    with pytest.raises(
        SimulationError,
        match="Expected rates with a Taylor series for method=\"taylor\", but of 'cart' 'abs' has no Taylor series "
        'where it bends. Use method="dop853" or "gauss".',
    ):
        fb.simulate(s, 1, initial={"x": 1.0}, sensitivities=["x"], method="taylor")


def test_no_time_and_nothing_to_move() -> None:
    s = pendulum()
    data = fb.simulate(s, 0, initial={"theta": [0.5, 1.0]}, method="taylor")
    assert data["theta"].values.ravel().tolist() == [0.5, 1.0] and set(data.steps.values) == {0}


@pytest.mark.parametrize("method", ["taylor", "dop853", "dop54", "radau"])
def test_the_rate_that_fails_is_to_blame(method: str) -> None:
    """√(1 - x) ends where x = 1, and √(1 - y) where y = 1: alone and in lanes, whichever comes first."""
    s = fb.System("two rails")
    for name in "xy":
        block = s.body(f"block_{name}", fb.particle(1))
        s.slider(f"rail_{name}", s.ground, block, axis="x", coordinate=name)
        s.generalized_force(name, f"sqrt(1 - {name})/100")
    first = np.arange(10) % 3 == 0
    speeds = {"x'": np.where(first, 3.0, 0.1), "y'": np.where(first, 0.1, 3.0)}
    data = fb.simulate(s, 2, initial=speeds, method=method, outputs=["x"])
    assert set(data.status.values) == {"not finite"}
    assert data.blame.values.tolist() == np.where(first, "x'", "y'").tolist()
    for name, start in (("x'", {"x'": 3.0, "y'": 0.1}), ("y'", {"x'": 0.1, "y'": 3.0})):
        with pytest.raises(SimulationError, match=f"the rate of '{name}' is not a finite number"):
            fb.simulate(s, 2, initial=start, method=method)
