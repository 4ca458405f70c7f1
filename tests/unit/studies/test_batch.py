"""Many runs at once: every lane is the run that it would be alone."""

from __future__ import annotations

import math
import os
import signal
import subprocess
import sys
from concurrent.futures import Executor, Future

import numpy as np
import pytest

import freebody as fb
from batch_machines import CLOSED, cart, four_bar
from freebody.errors import MassError, ModelError, SimulationError
from freebody.motion.batch import kernels
from freebody.motion.lanes import loops as over_lanes
from freebody.program.large import tree_loop
from freebody.testing import random_system


def pendulum() -> fb.System:
    s = fb.System("pendulum")
    m, L, g, c = s.parameters(m=1.0, L=2.0, g=9.81, c=0.0)
    s.gravity = (0, -g, 0)
    bar = s.body("bar", fb.slender_bar(m, L, axis="y"))
    pin = s.hinge("pin", s.ground, bar, to=(0, L / 2, 0), axis="z", coordinate="theta")
    s.damper("c", pin, damping=c)
    return s


def free_body() -> fb.System:
    s = fb.System("stone")
    m = s.parameters(m=2.0)
    s.gravity = (0, 0, -9.81)
    s.free("turn", s.ground, s.body("stone", fb.box(m, (0.1, 0.2, 0.4))))
    return s


THETA = np.array([0.1, 1.0, 2.0, 3.0, -0.5])


@pytest.mark.parametrize("method", ["auto", "dop853", "dop54", "gauss", "radau"])
@pytest.mark.usefixtures("stages")
def test_each_lane_is_the_run_alone_to_the_last_bit(method: str) -> None:
    s = pendulum()
    # alone "auto" takes the series of a small machine at 1e-7
    options = dict(method=method, tolerance=1e-6, events=["theta'"], times=[0.3, 0.0, 2.0, 1.7, 0.3])
    lengths, damping = np.linspace(1, 3, 5), np.linspace(0, 0.5, 5)
    data = fb.simulate(
        s,
        2,
        initial={"theta": THETA, "theta'": "c"},
        values={"L": lengths, "c": damping},
        threads=2,
        **options,
    )
    assert data.sizes == {"lane": 5, "time": 5, "event": 1}
    for k in range(5):
        values = {"L": lengths[k], "c": damping[k]}
        alone = fb.simulate(s, 2, initial={"theta": THETA[k], "theta'": damping[k]}, values=values, **options)
        assert np.array_equal(data["theta"][k], alone["theta"])
        assert np.array_equal(data["theta'"][k], alone["theta'"])
        assert int(data.steps[k]) == alone.steps
        times = [event.time for event in alone.events]
        assert int(data.event_count[k, 0]) == len(times)
        if times:
            assert (data.event_time[k, 0], data.event_last[k, 0]) == (times[0], times[-1])
    assert set(data.status.values) == {"finished"}
    assert np.array_equal(data.L, lengths) and np.array_equal(data.theta_start, THETA)


def test_quaternions_and_constraints_are_as_alone() -> None:
    s = free_body()
    turns = [fb.Rotation.axis_angle((1, 0, 0), a) for a in (0.1, 0.7)]
    rates = np.array([1.0, 2.0])
    options = {"samples": 3, "method": "dop853"}
    data = fb.simulate(s, 1, initial={"turn": turns, "turn_wx": rates, "turn_wy": 3}, **options)
    by_array = fb.simulate(
        s, 1, initial={"turn": np.array([r.as_quaternion() for r in turns]), "turn_wx": rates, "turn_wy": 3}, **options
    )  # fmt: skip
    for k in range(2):
        alone = fb.simulate(s, 1, initial={"turn": turns[k], "turn_wx": rates[k], "turn_wy": 3}, **options)
        for name in alone.names:
            assert np.array_equal(data[name][k], alone[name]), name
            assert np.array_equal(by_array[name][k], alone[name]), name
    s = four_bar()
    speeds = np.array([1.0, 4.0])
    data = fb.simulate(s, 1, initial={"q1": 1.0, "q1'": speeds}, near=CLOSED, **options)
    for k in range(2):
        alone = fb.simulate(s, 1, initial={"q1": 1.0, "q1'": speeds[k]}, near=CLOSED, **options)
        for name in alone.names:
            assert np.array_equal(data[name][k], alone[name]), name


def test_extremes_are_those_of_the_motion_and_not_of_the_output_times() -> None:
    """The pendulum let go at rest returns to where it began; its greatest speed follows from the energy."""
    s = pendulum()
    asked = ["max(theta)", "min(theta)", "max(theta')", "final(theta)", "range(theta)", "initial(theta)"]
    data = fb.simulate(s, 9.7, initial={"theta": THETA[:3]}, tolerance=1e-11, outputs=asked)
    assert "time" not in data.dims
    fastest = np.sqrt(3 * 9.81 / 2 * (1 - np.cos(THETA[:3])))  # (m L²/6) θ'² = m g (L/2) (1 - cos θ)
    assert np.allclose(data["max(theta)"], THETA[:3], rtol=0, atol=1e-8)
    assert np.allclose(data["min(theta)"], -THETA[:3], rtol=0, atol=1e-8)
    assert np.allclose(data["max(theta')"], fastest, rtol=1e-8, atol=0)
    assert np.allclose(data["range(theta)"], 2 * THETA[:3], rtol=0, atol=1e-8)
    assert np.array_equal(data["initial(theta)"], THETA[:3])
    alone = fb.simulate(s, 9.7, initial={"theta": THETA[1]}, tolerance=1e-11, times=[9.7])
    assert abs(float(data["final(theta)"][1]) - alone["theta"][0]) < 1e-8


def test_outputs_are_expressions_and_energies() -> None:
    s = pendulum()
    data = fb.simulate(
        s, 2, initial={"theta": 1.0}, values={"c": [0.0, 0.3], "m": [1.0, 2.0]}, samples=3, method="dop853",
        outputs={"height": "-L/2*cos(theta)", "energy": "energy", "work": "work", "deepest": "min(-L/2*cos(theta))"},
    )  # fmt: skip
    alone = fb.simulate(s, 2, initial={"theta": 1.0}, values={"c": 0.3, "m": 2}, samples=3, method="dop853")
    assert np.allclose(data["height"][1], -np.cos(alone["theta"]), rtol=0, atol=1e-15)
    assert np.allclose(data["energy"][1], alone.energy.total, rtol=0, atol=1e-14)
    assert np.array_equal(data["work"][1], alone["work"])
    assert float(data["deepest"][0]) == pytest.approx(-1, abs=1e-12)
    drift = data["energy"] - data["energy"][:, :1] - data["work"]
    assert float(abs(drift).max()) < 1e-7


def test_a_terminal_event_ends_a_lane_and_leaves_nan_behind() -> None:
    s = pendulum()
    stop = fb.event("theta", name="bottom", terminal=True)
    data = fb.simulate(s, 3, initial={"theta": [0.2, 0.0], "theta'": [0.0, 7.0]}, events=[stop], samples=31)
    assert list(data.status.values) == ["terminal event", "finished"]
    quarter = float(data.event_time[0, 0])
    w = math.sqrt(1.5 * 9.81 / 2)
    period = (
        2 * math.pi / w * (1 + 0.2**2 / 16 + 11 * 0.2**4 / 3072)
    )  # of amplitude 0.2; the next term is 4e-8
    assert quarter == float(data.end[0]) == pytest.approx(period / 4, rel=1e-7)
    known = np.isfinite(data["theta"][0])
    assert np.array_equal(known, data.time <= quarter)


def test_a_terminal_event_is_not_counted_where_the_run_begins() -> None:
    """A stone thrown up from the ground y = 0 is back after 2 v/g; by the compiled lanes, and run by run."""
    s = fb.System("stone")
    g = s.parameters(g=9.81)
    s.gravity = (0, -g, 0)
    stone = s.body("stone", fb.particle(1))
    s.slider("rail", s.ground, stone, axis="y", coordinate="y")
    speeds = np.array([3.0, 5.0])
    landing = fb.event("y", name="landing", terminal=True)
    events = [landing, fb.event("y", name="level")]
    nothing = fb.blow(100, at=stone, impulse=(0, 0, 0))
    for more in ({}, {"impulses": [nothing]}):
        data = fb.simulate(s, 100, initial={"y'": speeds}, events=events, outputs=["final(y)"], **more)
        assert set(data.status.values) == {"terminal event"}
        assert np.allclose(data["event_time"][:, 0], 2 * speeds / 9.81, rtol=1e-12)
        assert np.array_equal(data["event_time"][:, 0], data["end"])
        assert data["event_count"].values.tolist() == [[1, 2], [1, 2]]  # others count as in a run alone
        assert np.array_equal(data["event_time"][:, 1], [0, 0])
    grid = fb.sweep(s, {"y'": speeds, "g": [9.81, 1.62]}, 100, events=[landing], outputs="max(y)")
    assert np.allclose(grid["event_time"][..., 0], 2 * speeds[:, None] / grid.g.values, rtol=1e-12)
    alone = fb.simulate(s, 100, initial={"y'": 3.0}, events=[landing])
    assert [one.time for one in alone.events] == [0.0, alone.path.end]


def test_a_lane_that_fails_is_reported_and_the_others_go_on() -> None:
    s = fb.System("repelled")
    s.parameters(a=1.0)
    s.slider("rail", s.ground, s.body("bead", fb.particle(1)), axis="x", coordinate="x")
    s.generalized_force("x", "a*sqrt(x)")
    data = fb.simulate(s, 2, initial={"x": [1.0, 1.0, 0.5], "x'": [0.0, -3.0, 0.0]}, samples=5)
    assert list(data.status.values) == ["finished", "not finite", "finished"]
    assert str(data.blame.values[1]) in ("x'", "x", "work") and data.blame.values[0] == ""
    assert 0 < float(data.end[1]) < 2
    assert np.isfinite(data["x"][0]).all() and np.isnan(data["x"][1]).any()
    few = fb.simulate(s, 2, initial={"x": [1.0, 2.0]}, max_steps=2, samples=2)
    assert set(few.status.values) == {"too many steps"}


@pytest.mark.usefixtures("stages")
def test_a_stiff_lane_is_run_by_radau() -> None:
    s = cart()
    stiffness, damping = np.array([1.0, 1e6]), np.array([1.0, 1e5])
    data = fb.simulate(
        s, 10, initial={"x": 1.0}, values={"k": stiffness, "c": damping}, tolerance=1e-6, samples=3
    )
    assert set(data.status.values) == {"finished"} and int(data.steps[1]) < 1000
    for lane in range(2):
        alone = fb.simulate(
            s,
            10,
            initial={"x": 1.0},
            values={"k": stiffness[lane], "c": damping[lane]},
            tolerance=1e-6,
            samples=3,
        )
        assert np.array_equal(data["x"][lane], alone["x"])


def test_results_do_not_depend_on_threads_and_backward_runs_work() -> None:
    s = pendulum()
    many = np.linspace(-3, 3, 97)
    one, two = (fb.simulate(s, -2, initial={"theta": many}, samples=5, threads=n) for n in (1, 2))
    assert one.equals(two)
    assert list(one.time.values) == [0, -0.5, -1, -1.5, -2]
    forward = fb.simulate(s, 2, initial={"theta": many}, samples=5)
    assert np.allclose(forward["theta"], one["theta"], atol=1e-7)  # from rest: even in time


def test_a_store_goes_on_where_it_was_left(tmp_path, monkeypatch) -> None:
    from freebody.motion.batch.lane_loop import LaneLoop

    s, many = pendulum(), np.linspace(0.1, 3, 150)
    options = dict(
        initial={"theta": many},
        outputs=["theta", "max(theta)"],
        times=[1.0, 2.0],
        events=["theta"],
        threads=1,
    )
    whole = fb.simulate(s, 2, **options)
    path = tmp_path / "x.nc"
    calls = {"n": 0}

    def stop(part: float) -> None:
        calls["n"] += 1
        if calls["n"] == 2:
            raise KeyboardInterrupt

    first = fb.simulate(s, 2, store=path, progress=stop, **options)
    done = (first.status != "waiting").values
    assert 0 < done.sum() < 150 and "interrupted" in first.attrs
    first.close()
    run: list[int] = []
    chunk = LaneLoop.chunk
    monkeypatch.setattr(LaneLoop, "chunk", lambda self, lanes, m: (run.extend(lanes), chunk(self, lanes, m)))
    second = fb.simulate(s, 2, store=path, **options)
    assert sorted(run) == list(np.flatnonzero(~done))
    for name in ("theta", "max(theta)", "event_time", "event_count", "status", "end", "steps"):
        assert np.array_equal(second[name].values, whole[name].values, equal_nan=name == "event_time"), name
    second.close()
    with pytest.raises(SimulationError, match="hold results of the same runs, .* Choose another path"):
        fb.simulate(s, 2, store=path, **{**options, "times": [1.0, 1.5]})
    path.write_text("nothing")
    with pytest.raises(SimulationError, match="cannot be read"):
        fb.simulate(s, 2, store=path, **options)
    with pytest.raises(SimulationError, match="there is no folder"):
        fb.simulate(s, 2, store=tmp_path / "no" / "x.nc", **options)


@pytest.mark.parametrize("method", ["dop853", "taylor", "radau"])
def test_a_store_compiles_nothing_more(tmp_path, monkeypatch, method: str) -> None:
    """Neither what it is marked with nor its last block, of three lanes, asks for a program of its own."""
    made = []
    compiled = kernels.compile_tape
    monkeypatch.setattr(
        kernels, "compile_tape", lambda *given: (made.append(given[1].keys()), compiled(*given))[1]
    )
    loops = []
    loop = over_lanes.function
    monkeypatch.setattr(over_lanes, "function", lambda *name: (loops.append(name), loop(*name))[1])
    options = {"initial": {"theta": np.linspace(0.1, 3, 67)}, "outputs": ["theta"], "times": [0.5]}
    kept = fb.simulate(pendulum(), 0.5, store=tmp_path / "x.nc", method=method, **options)
    assert len(made) == 1 and len(set(loops)) == 1 and len(loops) > 1
    whole = fb.simulate(pendulum(), 0.5, method=method, **options)
    assert np.array_equal(kept["theta"], whole["theta"])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"initial": {"theta": [1, 2]}, "values": {"m": [1, 2, 3]}}, "got 3 values of 'm' and 2 initial values"),
        ({"initial": {"theta": [[1, 2]]}}, r"\(lanes,\) for the initial values of 'theta', got shape \(1, 2\).*sweep"),
        ({"initial": {"theta": [1, float("nan")]}}, "finite numbers for the initial values of 'theta', .* in lane 1"),
        ({"initial": {"theta": []}}, "at least one lane, got no initial values of 'theta'. Give one for each lane"),
        ({"values": {"c": [1, float("inf")]}}, r"got inf in lane 1\. Leave that lane out, of every array"),
        ({"initial": {"theta": [1, [2, 3]]}}, r"got \[1, \[2, 3\]\]\. Give one number for each lane"),
        ({"initial": {"theta": {1, 2}}, "outputs": ["theta"]}, r"an array .* got \{1, 2\}\. Write list"),
        ({"initial": {"theta": (x for x in (1, 2))}, "outputs": ["theta"]}, "a list or an array .* Write list"),
        ({"initial": {"theta": ["m/10", 1]}}, r"'m/10' in lane 0\. An expression .* initial=\{'theta': 'm/10'\}"),
        ({"initial": {"theta": ["20 deg", 1]}}, r"without a unit for the initial values of 'theta', .* Write pi/9"),
        ({"initial": {"theta": [1, 2]}, "executor": Executor}, "an executor with submit.*, got <class"),
        ({"initial": {"thet": [1, 2]}}, "Unknown name 'thet' in initial; did you mean 'theta'"),
        ({"initial": {"theta": [1, 2]}, "outputs": ["thet"]}, "Expected a coordinate, .* 'thet'"),
        ({"initial": {"theta": [1, 2]}, "outputs": []}, "at least one output"),
        ({"initial": {"theta": [1, 2]}, "outputs": ["theta", "theta"]}, "'theta' is asked for twice"),
        ({"initial": {"theta": [1, "x"]}}, "Expected an array of numbers for the initial values of 'theta'"),
        ({"initial": {"theta": [1, 2]}, "method": "structure"}, "the length of a step for method=\"structure\""),
        ({"initial": {"theta": [1, 2]}, "threads": 0}, "at least 1, got 0"),
        ({"initial": {"theta": [1, 2]}, "samples": 1}, "at least 2, got 1"),
        ({"initial": {"theta": [1, 2]}, "impulses": ["x"]}, "in impulses, got 'x'"),
        ({"initial": {"theta": "log(m - 1)"}, "values": {"m": [2.0, 1.0]}}, "has no value in lane 1"),
        ({"until": "m", "values": {"m": [2.0, 1.0]}}, "until to be the same for all lanes, but 'm' depends"),
        ({"until": [1, 2], "values": {"m": [2.0, 1.0]}}, "one number for until"),
        ({"initial": {"theta": [1, 2]}, "times": [99]}, "Expected output times from 0 to 2 s, got 99"),
    ],
)  # fmt: skip
def test_refusals(options: dict, message: str) -> None:
    options = {"until": 2, **options}
    with pytest.raises(SimulationError, match=message):
        fb.simulate(pendulum(), options.pop("until"), **options)


def test_quaternions_of_lanes_that_are_none() -> None:
    for value, message in (
        (np.ones((2, 3)), r"shape \(lanes, 4\) .* got shape \(2, 3\)\. Give four components of a quaternion"),
        ([fb.Rotation.axis_angle((1, 0, 0), 1), 3], "got .*Rotation.* or a list of Rotations only"),
    ):
        with pytest.raises(SimulationError, match=message):
            fb.simulate(free_body(), 1, initial={"turn": value})


def test_lanes_from_what_holds_numbers() -> None:
    """Arrays of other libraries, ranges and texts with units, as parameters read them."""
    pandas, xarray = pytest.importorskip("pandas"), pytest.importorskip("xarray")
    given = {"samples": 2}
    meant = fb.simulate(pendulum(), 0.2, initial={"theta": [1.0, 2.0]}, values={"L": [0.25, 2.0]}, **given)
    for start in (
        pandas.Series([1.0, 2.0], index=[5, 6]), xarray.DataArray([1, 2], dims="k"), range(1, 3), ["1", "4/2"],
    ):  # fmt: skip
        said = fb.simulate(pendulum(), 0.2, initial={"theta": start}, values={"L": ["25 cm", 2]}, **given)
        assert said.equals(meant)


def test_a_place_to_close_near_is_the_same_for_all_lanes() -> None:
    with pytest.raises(
        SimulationError, match=r"one number for 'q2' in near=, .* got \[-0.7, -0.8\].* into initial="
    ):
        fb.simulate(four_bar(), 1, initial={"q1": [1, 1.1]}, near={"q2": [-0.7, -0.8], "q3": 1.2})


def test_no_component_is_blamed_for_too_many_steps() -> None:
    data = fb.simulate(pendulum(), 10, initial={"theta": [1, 2]}, max_steps=3)
    assert set(data.status.values) == {"too many steps"} and set(data.blame.values) == {""}


def test_impossible_parameters_name_the_lane() -> None:
    with pytest.raises(MassError, match="Lane 2: Body 'bar'"):
        fb.simulate(pendulum(), 1, values={"m": [1.0, 2.0, -1.0]})
    with pytest.raises(ModelError, match="Unknown parameter 'M'"):
        fb.simulate(pendulum(), 1, values={"M": [1.0, 2.0]})


@pytest.mark.parametrize("threads", [1, 2])
def test_a_signal_from_the_keyboard_leaves_the_lanes_that_are_done(tmp_path, threads: int) -> None:
    """SIGINT after some lanes: they are in the file and in the result, and the same call goes on with the others."""
    s, many = pendulum(), np.linspace(0.1, 3, 300)
    options = {"initial": {"theta": many}, "outputs": ["theta"], "times": [1.0, 2.0], "threads": threads}
    whole = fb.simulate(s, 2, **options)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)

    def press(part: float) -> None:
        if part > 0.05:
            os.kill(os.getpid(), signal.SIGINT)

    try:
        in_memory = fb.simulate(s, 2, progress=press, **options)
        kept = fb.simulate(s, 2, progress=press, store=tmp_path / "x.nc", **options)
    finally:
        signal.signal(signal.SIGINT, before)
    for part in (in_memory, kept):
        done = (part.status == "finished").values
        assert (
            0 < done.sum() < 300
            and part.attrs["interrupted"] == f"{300 - done.sum()} of 300 lanes were not run"
        )
        assert set(part.status.values[~done]) == {"waiting"} and np.isnan(part["theta"].values[~done]).all()
        assert np.array_equal(part["theta"].values[done], whole["theta"].values[done])
    kept.close()
    again = fb.simulate(s, 2, store=tmp_path / "x.nc", **options)
    assert np.array_equal(again["theta"].values, whole["theta"].values)


def test_blocks_of_an_executor_that_are_done_before_their_turn_are_kept() -> None:
    class Eager(Executor):
        """Runs all blocks at once but the second, at which the keyboard interrupts."""

        submitted = 0

        def submit(self, function, /, *arguments, **options):
            task: Future = Future()
            self.submitted += 1
            if self.submitted == 2:
                task.set_exception(KeyboardInterrupt())
            else:
                task.set_result(function(*arguments, **options))
            return task

    data = fb.simulate(pendulum(), 1, initial={"theta": [0.1, 0.2, 0.3, 0.4]}, samples=2, executor=Eager())
    assert data.status.values.tolist() == ["finished", "waiting", "finished", "finished"]


def test_a_program_ends_whose_pool_loses_a_process_at_ctrl_c() -> None:
    """The keyboard interrupts all processes of a terminal; of a pool one may die and another live."""
    program = """
import os, signal
from concurrent.futures import ProcessPoolExecutor
import freebody as fb
from freebody.gallery.beyond.bouncing_ball import build

pool = ProcessPoolExecutor(2)

def press(part):
    os.kill(next(iter(pool._processes)), signal.SIGKILL)
    raise KeyboardInterrupt

start, heights = {"y": "h"}, [1.0 + k / 100 for k in range(20)]
data = fb.simulate(build(), 1, initial=start, values={"h": heights}, samples=2, executor=pool, progress=press)
print((data.status == "waiting").sum().item())
"""
    found = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=600)
    assert 0 < int(found.stdout) < 20 and "InvalidStateError" not in found.stderr, found.stderr


def test_more_samples_than_the_memory_holds_are_refused_at_once() -> None:
    for initial in ({"theta": 1.0}, {"theta": [1.0, 2.0]}):
        with pytest.raises(
            SimulationError, match=r"fit into memory, got samples=10000000000000, which take .* GiB"
        ):
            fb.simulate(pendulum(), 1, initial=initial, samples=10**13)


def test_what_is_assumed_after_a_first_run_counts_in_the_next() -> None:
    s = pendulum()
    fb.simulate(s, 0.1, values={"c": -1.0})
    s.assume(s.expression("c") > 0)
    with pytest.raises(ModelError, match="c"):
        fb.simulate(s, 0.1, values={"c": -1.0})


def test_results_larger_than_the_memory_are_refused_before_they_are_computed() -> None:
    with pytest.raises(SimulationError, match=r'GiB. Pass store="lanes.nc"'):
        fb.simulate(pendulum(), 1, initial={"theta": np.zeros(10**6)}, samples=10**6)


def test_lanes_of_trees_that_are_looped_over_but_not_large(loops: list[bool]) -> None:
    """Lanes of other starts go eight at a time through the loops of a run alone; of other parameters, in straight code,
    which agrees to round-off."""
    s = fb.System("chain")
    m = s.parameters(m=1.0)
    s.gravity = (0, -9.81, 0)
    last, place = s.ground, {}
    for i in range(40):
        bar = s.body(f"bar{i}", fb.slender_bar(m, 1, axis="x"))
        s.hinge(f"pin{i}", last, bar, **place, to=(-0.5, 0, 0), axis="z", coordinate=f"q{i}")
        last, place = bar, {"at": (0.5, 0, 0)}
    start = np.linspace(0.1, 0.2, 9)
    data = fb.simulate(s, 0.01, initial={"q0": start}, samples=3, outputs=["q0", "q39'"])
    alone = fb.simulate(s, 0.01, initial={"q0": start[3]}, samples=3)
    assert isinstance(alone.kernels.motion().compiled, tree_loop.LoopedSet)
    for name in ("q0", "q39'"):
        assert np.array_equal(data[name][3], alone[name])
    data = fb.simulate(
        s, 0.01, initial={"q0": 0.1}, values={"m": np.linspace(1, 2, 9)}, samples=3, outputs=["q0", "q39'"]
    )
    alone = fb.simulate(s, 0.01, initial={"q0": 0.1}, values={"m": 1.5}, samples=3)
    for name in ("q0", "q39'"):
        assert data[name][4].values == pytest.approx(alone[name], abs=1e-9)
    assert loops == [True, True]


def test_lanes_of_large_trees_are_runs_alone() -> None:
    """Both loop over the 200 bodies, so that no code of a batch grows with them."""
    s = fb.System("chain")
    s.gravity = (0, -9.81, 0)
    last, place = s.ground, {}
    for i in range(200):
        bar = s.body(f"bar{i}", fb.slender_bar(1, 1, axis="x"))
        s.hinge(f"pin{i}", last, bar, **place, to=(-0.5, 0, 0), axis="z", coordinate=f"q{i}")
        last, place = bar, {"at": (0.5, 0, 0)}
    data = fb.simulate(s, 0.01, initial={"q0": [0.1, 0.2]}, samples=3, outputs=["q0", "q199'"])
    alone = fb.simulate(s, 0.01, initial={"q0": 0.1}, samples=3)
    for name in ("q0", "q199'"):
        assert np.array_equal(data[name][0], alone[name])


def test_large_trees_eight_at_a_time_are_runs_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Rates that loop over links in the loop over lanes: every lane is what it would be alone, to the last bit; one
    that fails tells why."""
    monkeypatch.setattr(tree_loop, "BODIES", 1)
    s = random_system(2, bodies=6, joints=("ball", "hinge", "slider"), driven=True)
    names = fb.assemble(s).speed_names
    random = np.random.default_rng(3)
    initial = {names[0]: random.normal(size=11), names[1]: random.normal(size=11)}
    options = {"samples": 4, "method": "dop853", "outputs": [names[0], f"{names[1]} + 2"]}
    data = fb.simulate(s, 0.3, initial=initial, **options)
    assert (data["status"] == "finished").all()
    for lane in range(11):
        alone = fb.simulate(
            s, 0.3, initial={name: x[lane] for name, x in initial.items()}, samples=4, method="dop853"
        )
        assert np.array_equal(data[names[0]][lane], alone[names[0]])
        assert int(data["steps"][lane]) == alone.steps
    initial[names[0]][4] = 1e200
    worse = fb.simulate(s, 0.3, initial=initial, **options)
    assert str(worse["status"][4].values) == "not finite"
    assert "cannot be continued" in str(worse["reason"][4].values)
    kept = [k for k in range(11) if k != 4]
    assert np.array_equal(worse[names[0]][kept], data[names[0]][kept])


def test_a_lane_that_contradicts_an_assumption_is_refused() -> None:
    s = fb.System("loaded")
    c, k = s.parameters(c=2.0, k=1.0)
    s.assume(c > k)
    s.slider("rail", s.ground, s.body("bead", fb.particle(1)), axis="x", coordinate="x")
    with pytest.raises(ModelError, match="Lane 2: Expected c - k > 0 in 'loaded'.*k = 3 makes it -1"):
        fb.simulate(s, 1, values={"k": [0.5, 1.0, 3.0]}, outputs=["x"])


@pytest.mark.parametrize(
    ("more", "message"),
    [
        (
            {"outputs": {"status": "theta"}},
            "another name for the output 'status', which in the results tells how lanes",
        ),
        (
            {"outputs": {"lane": "theta"}},
            "another name for the output 'lane', which in the results counts the lanes",
        ),
        (
            {"outputs": ["L"]},
            "another name for the output 'L', which in the results holds the varied parameter",
        ),
        (
            {"outputs": {"theta_start": "theta"}},
            "which in the results holds the varied start. Name it: outputs={'my_",
        ),
        (
            {"events": [fb.event("theta", name="a"), fb.event("theta'", name="a")]},
            "different names in a batch, got 'a'",
        ),
        (
            {"initial": {"theta": np.array([1j, 0])}},
            "Expected an array of numbers for the initial values of 'theta'",
        ),
        (
            {"outputs": "mean(theta)"},
            "or max(...), min(...), initial(...), final(...), range(...) of one. In output",
        ),
    ],
)
def test_names_that_the_results_can_not_hold_twice(more: dict, message: str) -> None:
    options = {"initial": {"theta": [0.1, 0.2]}, "values": {"L": [1.0, 2.0]}, **more}
    with pytest.raises(SimulationError) as caught:
        fb.simulate(pendulum(), 1, **options)
    assert message in str(caught.value)


def test_a_varied_parameter_with_the_name_of_a_result_is_refused() -> None:
    s = pendulum()
    steps = s.parameters(steps=1.0)
    s.generalized_force("theta", steps)
    with pytest.raises(SimulationError) as caught:
        fb.simulate(s, 1, values={"steps": [1.0, 2.0]})
    assert "another name for the varied parameter 'steps', which in the results tells how lanes" in str(
        caught.value
    )


@pytest.mark.parametrize("method", ["auto", "dop853", "radau"])
@pytest.mark.parametrize("which", ["a", "b", "c"])
def test_lanes_blame_what_escapes(which, method):
    """Of three blocks one is driven by the cube of its speed v, and gone at 1/(2 v²)."""
    s = fb.System("blocks")
    for name in "abc":
        s.slider(f"guide_{name}", s.ground, s.body(name, fb.particle(1)), axis="x", coordinate=name)
        s.generalized_force(name, f"{which}'^3" if name == which else f"-{name}")
    speeds = np.array([0.1, 1, 2])
    data = fb.simulate(s, 1, initial={f"{which}'": speeds}, outputs=["a"], samples=2, method=method)
    assert data.blame.values.tolist() == ["", f"{which}'", f"{which}'"]
    assert data.end.values[1:] == pytest.approx(1 / (2 * speeds[1:] ** 2), abs=1e-6)
