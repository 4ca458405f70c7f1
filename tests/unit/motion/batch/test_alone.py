"""Lanes that are runs alone: contacts, blows, controllers, other methods. Each is the single run, to the last bit."""

from __future__ import annotations

import math
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from importlib import import_module
from multiprocessing import get_context

import numpy as np
import pytest

import freebody as fb
from freebody.errors import SimulationError


def pulled_disk() -> fb.System:
    s = fb.System("pulled disk")
    m, R, mu, F, g = s.parameters(m=10.0, R=0.3, mu=0.2, F=30.0, g=9.81)
    s.gravity = (0, -g, 0)
    disk = s.body("disk", fb.disk(m, R))
    s.planar("plane", s.ground, disk, at=(0, R, 0), coordinate="x y phi")
    s.contact("floor", disk.circle(R), s.ground.plane(), friction=mu)
    s.force("pull", disk.origin, (F, 0, 0))
    return s


def ball() -> fb.System:
    s = fb.System("ball")
    e, g = s.parameters(e=0.8, g=9.81)
    s.gravity = (0, -g, 0)
    one = s.body("ball", fb.disk(1, 0.1))
    s.planar("plane", s.ground, one, coordinate="x y turn")
    s.contact("floor", one.circle(0.1), s.ground.plane(normal="y"), friction=0, restitution=e)
    return s


def same(data, lane: int, alone, names) -> None:
    """All of a lane's outputs are those of the run alone, bit for bit."""
    for name in names:
        assert np.array_equal(data[name][lane], alone[name]), (lane, name)
    assert int(data.steps[lane]) == alone.steps
    assert str(data.status[lane].item()) == alone.status
    assert float(data.end[lane]) == alone.path.end


def test_disks_that_roll_or_slip_are_as_alone() -> None:
    s = pulled_disk()
    forces, friction = np.array([30.0, 250.0, 58.8, 60.0]), np.array([0.2, 0.2, 0.2, 0.1])
    speeds = np.array([0.0, 0.0, 3.0, -1.0])
    times = [0.5, 0.0, 1.0, 0.7]
    data = fb.simulate(
        s, 1, initial={"x'": speeds}, values={"F": forces, "mu": friction}, times=times, events=["x - 0.5"],
        outputs=["x", "phi'", "floor.gap", "floor.normal", "floor.tangential", "floor.slip", "floor.margin",
                 "floor.mode", "energy", "work", "work_rate", "x*phi", "modes"],
    )  # fmt: skip
    for k in range(4):
        alone = fb.simulate(
            s, 1, initial={"x'": speeds[k]}, values={"F": forces[k], "mu": friction[k]}, times=times, events=["x - 0.5"]
        )  # fmt: skip
        same(data, k, alone, ["x", "phi'", "work", "x*phi"])
        floor = alone.contacts["floor"]
        for what in ("gap", "normal", "tangential", "slip", "margin", "mode"):
            mine, its = data[f"floor.{what}"][k].values, getattr(floor, what)
            assert np.array_equal(mine, its, equal_nan=what == "margin"), what
        assert np.array_equal(data["energy"][k], alone.energy.total)
        assert fb.timeline(data["modes"][k]) == alone.modes
        asked = [e.time for e in alone.events if e.name == "x - 0.5"]
        assert int(data.event_count[k, 0]) == len(asked)
        assert not asked or float(data.event_time[k, 0]) == asked[0]
        # the pull at the centre and what the friction takes: P = F x' + T v_slip
        power = forces[k] * alone["x'"] + floor.tangential * floor.slip
        assert np.allclose(data["work_rate"][k], power, rtol=1e-12, atol=1e-9)
    assert data["floor.mode"].dims == ("lane", "time") and data.reason.values.tolist() == [""] * 4
    assert data["floor.normal"].attrs["units"] == "N"


def test_bounces_and_their_limit_are_as_alone() -> None:
    """The heights of fall, restitutions and the sum of the bounces: sqrt(2 h/g) (1 + e)/(1 - e)."""
    s = ball()
    heights, e = np.array([0.5, 1.0, 2.0]), np.array([0.5, 0.8, 0.0])
    data = fb.simulate(
        s, 6, initial={"y": 0.1 + heights}, values={"e": e}, samples=7,
        outputs=["y", "y'", "modes", "max(y')", "min(y)"],
    )  # fmt: skip
    for k in range(3):
        alone = fb.simulate(s, 6, initial={"y": 0.1 + heights[k]}, values={"e": e[k]}, samples=7)
        same(data, k, alone, ["y", "y'"])
        rest = fb.timeline(data["modes"][k])[-1]
        fall = math.sqrt(2 * heights[k] / 9.81)
        assert fb.timeline(data["modes"][k]) == alone.modes and rest.mode == "slip"
        # rest begins where the bounces are lower than 1e-9 m, a geometric series before they end
        end = fall * (1 + e[k]) / (1 - e[k])
        left = 2 * math.sqrt(2 * 1e-9 * (1 + 0.1 + heights[k]) / 9.81) / (1 - e[k])
        assert end - left <= rest.start <= end * (1 + 1e-12)
        # the greatest speed upwards is just after the first bounce, between no two output times
        assert float(data["max(y')"][k]) == pytest.approx(e[k] * 9.81 * fall, rel=1e-9, abs=1e-12)
        assert float(data["min(y)"][k]) == pytest.approx(0.1, abs=1e-9)


def test_nothing_is_derived_or_compiled_for_another_lane(monkeypatch: pytest.MonkeyPatch) -> None:
    s = pulled_disk()
    options = {"outputs": ["x", "floor.normal", "max(x')"], "samples": 3, "events": ["x - 1"]}
    fb.simulate(s, 1, values={"F": [30.0, 250.0]}, **options)
    made: list[str] = []
    for name in ("compile_tape", "assemble", "traced_state"):
        kernels = import_module("freebody.motion.kernels.kernels")
        monkeypatch.setattr(kernels, name, lambda *a, _name=name, **k: made.append(_name))
    fb.simulate(s, 1, values={"F": np.linspace(20, 260, 9), "mu": 0.25, "m": 11.0}, **options)
    assert made == []


def pendulum(motor: bool = True) -> fb.System:
    s = fb.System("pendulum")
    m, L, g, tau = s.parameters(m=1.0, L=0.5, g=9.81, tau=0.0)
    s.gravity = (0, -g, 0)
    bob = s.body("bob", fb.particle(m))
    pin = s.hinge("pin", s.ground, bob, to=(0, L, 0), axis="z", coordinate="theta")
    if motor:
        s.torque("motor", pin, tau)
    return s


THETA = np.array([0.3, -1.0, 2.0])


@pytest.mark.parametrize(
    "options",
    [
        {"method": "structure", "step": 0.01},
        {"method": "structure", "step": 0.01, "until": -1},
        {"impulses": True},
    ],
)
def test_other_methods_and_blows_are_as_alone_in_any_number_of_threads(options: dict) -> None:
    s, options = pendulum(motor=False), {"until": 1, **options}
    if "impulses" in options:
        bob = s.bodies["bob"]
        options["impulses"] = [
            fb.blow(0.25, at=bob, impulse=(0.3, 0, 0)),
            fb.blow(fb.event("theta", direction=1), at=bob, impulse=(0.01, 0, 0)),
        ]
    until = options.pop("until")
    one, two = (
        fb.simulate(s, until, initial={"theta": THETA}, samples=5, threads=n, outputs=["theta", "work", "max(theta)"],
                    **options)
        for n in (1, 2)
    )  # fmt: skip
    assert one.identical(two)
    for k in range(3):
        alone = fb.simulate(s, until, initial={"theta": THETA[k]}, samples=5, **options)
        same(one, k, alone, ["theta", "work"])
        assert float(one["max(theta)"][k]) >= alone["theta"].max()


def test_controllers_are_asked_once_per_sample_and_lane() -> None:
    s = pendulum()
    calls: list[float] = []

    class Memory:
        def __init__(self) -> None:
            self.before = 0.0

        def reset(self) -> None:
            self.before = 0.0

        def __call__(self, t: float, x) -> float:
            calls.append(t)
            rate, self.before = x["theta"] - self.before, x["theta"]
            return -8 * x["theta"] - rate

    s.controller(Memory(), 0.1, "tau")
    data = fb.simulate(s, 0.95, initial={"theta": THETA}, samples=4, outputs=["theta", "tau"])
    assert len(calls) == 3 * 10 and calls[:10] == pytest.approx(np.arange(10) / 10)
    for k in range(3):
        alone = fb.simulate(s, 0.95, initial={"theta": THETA[k]}, samples=4)
        same(data, k, alone, ["theta", "tau"])


def test_extremes_of_runs_alone_are_those_of_the_compiled_lanes() -> None:
    """The same pendulum by a method with a loop over lanes and by one without; both located to the run's accuracy."""
    s = pendulum()
    asked = [
        "max(theta)",
        "min(theta)",
        "range(theta')",
        "max(cos(3*theta) + theta')",
        "initial(theta)",
        "final(theta)",
    ]
    lanes = fb.simulate(s, 5, initial={"theta": THETA}, outputs=asked, tolerance=1e-12)
    alone = fb.simulate(
        s, 5, initial={"theta": THETA}, outputs=asked, tolerance=1e-12,
        impulses=[fb.blow(5, at=s.bodies["bob"], impulse=(0, 0, 0))],
    )  # fmt: skip
    for name in asked:
        assert np.allclose(alone[name], lanes[name], rtol=0, atol=1e-9), name
    assert np.allclose(alone["max(theta)"], abs(THETA), rtol=0, atol=1e-10)


def test_a_lane_that_fails_says_why_and_the_others_go_on() -> None:
    """Bar on a rough floor that begins below it, or well above: no start, and a motion."""
    s = ball()
    data = fb.simulate(s, 0.3, initial={"y": [0.5, 0.05, 1.0]}, samples=3)
    assert data.status.values.tolist() == ["finished", "no start", "finished"]
    assert "has contact 'floor' 0.05 m deep" in data.reason.values[1] and data.reason.values[0] == ""
    assert np.isnan(data["y"][1]).all() and np.isfinite(data["y"][[0, 2]]).all()
    assert fb.timeline(data["modes"][1]) == [] and len(fb.timeline(data["modes"][2])) == 1
    few = fb.simulate(s, 2, initial={"y": [0.5, 1.0]}, samples=3, max_steps=1)
    assert set(few.status.values) == {"too many steps"} and "max_steps = " in few.reason.values[0]


def test_a_motion_that_the_laws_of_contact_end_keeps_what_it_had() -> None:
    """Painlevé: a rod that slides into the paradox is refused there, with the motion up to it."""
    s = fb.System("rod")
    mu, g = s.parameters(mu=0.5, g=9.81)
    s.gravity = (0, -g, 0)
    rod = s.body("rod", fb.slender_bar(1, 2, axis="x"))
    s.planar("plane", s.ground, rod, coordinate="x y turn")
    s.contact("tip", rod.point((-1, 0, 0)), s.ground.plane(), friction=mu)
    s.torque("press", rod, (0, 0, "30*t"))
    turn = 0.8
    start = {"turn": turn, "x": math.cos(turn), "y": math.sin(turn), "x'": -3.0}
    rough = [0.1, 2.0]
    data = fb.simulate(
        s, 0.4, initial=start, values={"mu": rough}, samples=9, outputs=["x", "tip.normal", "modes"]
    )
    ended = []
    for k, mu_k in enumerate(rough):
        try:
            alone = fb.simulate(s, 0.4, initial=start, values={"mu": mu_k}, samples=9)
        except SimulationError as error:
            alone, why = getattr(error, "trajectory", None), str(error)
            assert data.reason.values[k] == why
            ended.append("no start" if alone is None else "refused")
        else:
            ended.append(alone.status)
        assert data.status.values[k] == ended[-1]
        if alone is not None:
            assert float(data.end[k]) == alone.path.end
    assert ended[0] == "finished" and ended[1] in ("no start", "refused")


def test_a_store_goes_on_and_loses_nothing(tmp_path) -> None:
    s, path = ball(), tmp_path / "x.nc"
    heights = np.linspace(0.2, 2, 9)
    options = {
        "initial": {"y": 0.1 + heights}, "samples": 4, "outputs": ["y", "floor.mode", "modes", "final(floor.mode)"]
    }  # fmt: skip
    whole = fb.simulate(s, 1, **options)
    calls = {"n": 0}

    def stop(part: float) -> None:
        calls["n"] += 1
        if calls["n"] == 3:
            raise KeyboardInterrupt

    first = fb.simulate(s, 1, store=path, progress=stop, **options)
    done = (first.status != "waiting").values
    assert 0 < done.sum() < 9 and "interrupted" in first.attrs
    assert np.array_equal(first["y"].values[done], whole["y"].values[done])
    first.close()
    second = fb.simulate(s, 1, store=path, **options)
    for name in whole.data_vars:
        assert second[name].dtype == whole[name].dtype, name
        assert np.array_equal(second[name].values, whole[name].values), name
    second.close()
    for other in ({"impacts": "sequential"}, {"initial": {"y": 0.2 + heights}}):
        with pytest.raises(SimulationError, match="hold results of the same runs"):
            fb.simulate(s, 1, store=path, **{**options, **other})


def test_an_interrupted_batch_in_memory_keeps_the_lanes_that_are_done() -> None:
    calls = {"n": 0}

    def stop(part: float) -> None:
        calls["n"] += 1
        if calls["n"] == 2:
            raise KeyboardInterrupt

    data = fb.simulate(ball(), 1, initial={"y": np.linspace(0.2, 2, 40)}, samples=4, progress=stop)
    waiting = (data.status == "waiting").values
    assert 0 < waiting.sum() < 40 and np.isnan(data["y"].values[waiting]).all()
    assert np.isfinite(data["y"].values[~waiting]).all()


def test_executors_give_the_same_whatever_they_are() -> None:
    """Threads of a user do not mix the contacts of lanes; processes get the machine by pickling."""
    s, heights = ball(), np.linspace(0.2, 2, 70)
    options = {"samples": 4, "outputs": ["y", "floor.mode", "modes"]}
    here = fb.simulate(s, 0.7, initial={"y": 0.1 + heights}, **options)
    with ThreadPoolExecutor(2) as pool:
        assert fb.simulate(s, 0.7, initial={"y": 0.1 + heights}, executor=pool, **options).identical(here)
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        few = fb.simulate(s, 0.7, initial={"y": 0.1 + heights[:2]}, executor=pool, **options)
    assert np.array_equal(few["y"], here["y"][:2]) and np.array_equal(few["modes"], here["modes"][:2])


def test_time_stepping_is_as_alone() -> None:
    s = pulled_disk()
    forces = np.array([30.0, 250.0])
    options = {"method": "timestepping", "step": 1e-2}
    data = fb.simulate(
        s, 1, values={"F": forces}, samples=3, threads=2,
        outputs=["x", "floor.normal", "floor.mode", "max(floor.normal)"], **options,
    )  # fmt: skip
    for k in range(2):
        alone = fb.simulate(s, 1, values={"F": forces[k]}, samples=3, **options)
        same(data, k, alone, ["x"])
        assert np.array_equal(data["floor.normal"][k], alone.contacts["floor"].normal)
        assert data["floor.mode"][k].values.tolist() == alone.contacts["floor"].mode.tolist()
    assert np.allclose(data["max(floor.normal)"], 98.1, rtol=1e-9)


def test_components_in_space_have_numbers() -> None:
    s = fb.System("puck")
    s.gravity = (0, 0, -9.81)
    puck = s.body("puck", fb.sphere(1, 0.1))
    s.free("free", s.ground, puck)
    s.contact("ice", puck.sphere(0.1), s.ground.plane(normal="z"), friction=0.1)
    data = fb.simulate(
        s, 0.1, initial={"free_z": 0.1, "free_vx": [1.0, 2.0], "free_vy": 1.0}, samples=3,
        outputs=["ice.slip", "max(ice.slip.1)", "ice.tangential.2"],
    )  # fmt: skip
    alone = fb.simulate(s, 0.1, initial={"free_z": 0.1, "free_vx": 2.0, "free_vy": 1.0}, samples=3)
    assert np.array_equal(data["ice.slip.2"][1], alone.contacts["ice"].slip[:, 1])
    assert np.array_equal(data["ice.tangential.2"][1], alone.contacts["ice"].tangential[:, 1])


@pytest.mark.parametrize(
    ("outputs", "message"),
    [
        ("roof.gap", "Unknown contact 'roof' in output 'roof.gap'; did you mean 'floor'|known names: floor"),
        ("max(floor.mode)", r"initial\(\) or final\(\) of a mode, got 'max\(floor.mode\)'"),
        ("floor.slip.2", "'floor.slip', which has no components, got the output 'floor.slip.2'"),
    ],
)
def test_refused_outputs(outputs: str, message: str) -> None:
    with pytest.raises(SimulationError, match=message):
        fb.simulate(ball(), 1, initial={"y": [1.0, 2.0]}, outputs=[outputs])


def test_refusals() -> None:
    start = {"y": [1.0, 2.0]}
    stepped = {"initial": start, "method": "timestepping", "step": 0.1}
    with pytest.raises(SimulationError, match="'work_rate' for method='timestepping'"):
        fb.simulate(ball(), 1, outputs=["work_rate"], **stepped)
    with pytest.raises(SimulationError, match="no timeline of modes.*'floor.mode'"):
        fb.simulate(ball(), 1, outputs=["modes"], **stepped)
    with pytest.raises(SimulationError, match="Unknown name 'yy' in initial"):
        fb.simulate(ball(), 1, initial={"yy": [1.0, 2.0]})
    with pytest.raises(
        SimulationError, match="No lane has a start. Lane 0: .*constant for method=.structure."
    ):
        fb.simulate(pendulum(), 1, initial={"theta": THETA}, method="structure", step=0.1)
    with pytest.raises(SimulationError, match="Unknown order of impacts 'together'"):
        fb.simulate(ball(), 1, initial=start, impacts="together")
    with pytest.raises(SimulationError, match="'pendulum' has no contacts"):
        fb.simulate(pendulum(), 1, initial={"theta": THETA}, outputs=["floor.gap"])
    with pytest.raises(SimulationError, match="Expected the modes of one lane, such as data"):
        fb.timeline(3)
