"""Every keyword of `simulate` is heeded in each kind of run, or refused by its name."""

import concurrent.futures

import numpy as np
import pytest

import freebody as fb
from freebody.errors import SimulationError

G = 9.81
STEPPED = {"method": "timestepping", "step": 0.01}


@pytest.fixture(scope="module")
def disk():
    s = fb.System("disk")
    s.parameters(m=1)
    s.gravity = (0, -G, 0)
    body = s.body("disk", fb.disk("m", 0.1))
    s.planar("rail", s.ground, body, coordinate="x y turn")
    s.contact("floor", body.circle(0.1), s.ground.plane(normal="y"), friction=0.3)
    return s


@pytest.fixture(scope="module")
def table():
    """Four legs that turn as they slide: friction depends on how they share the weight."""
    s = fb.System("table")
    s.gravity = (0, 0, -G)
    top = s.body("top", fb.box(10, (1, 0.8, 0.1)))
    s.free("f", s.ground, top)
    legs = top.corners((-0.5, -0.4, -0.4), (0.5, -0.4, -0.4), (0.5, 0.4, -0.4), (-0.5, 0.4, -0.4))
    s.contact("leg", legs, s.ground.plane(normal="z"), friction=0.3)
    return s


@pytest.mark.parametrize("many", [{}, {"outputs": "a"}, {"sensitivities": ["m"]}])
@pytest.mark.parametrize(
    ("given", "text"),
    [
        ({"near": {"a": 1}}, "Expected a machine with constraints for near=, but 'pendulum' has none"),
        ({"project": True}, "Expected a machine with constraints for project=, but 'pendulum' has none"),
        ({"impacts": "sequential"}, "Expected a machine with contacts for impacts=, but 'pendulum' has none"),
        (
            {"indeterminate": "refuse"},
            "Expected a machine with contacts for indeterminate=, but 'pendulum' has",
        ),
        ({"max_steps": 0.5}, "Expected a number of steps of at least 1, got max_steps=0.5"),
        ({"max_step": -1}, "Expected a longest step greater than 0 s, got max_step=-1"),
        ({"samples": 1.5}, "Expected a number of samples of at least 2, got 1.5"),
    ],
)
def test_of_a_machine_without_constraints_and_contacts(pendulum, many, given, text):
    with pytest.raises(SimulationError, match=text):
        fb.simulate(pendulum, 0.1, **given, **many)


@pytest.mark.parametrize("many", [{}, {"outputs": "y"}])
@pytest.mark.parametrize(
    ("given", "text"),
    [
        ({"tolerance": 1e-6}, 'Expected no tolerance= for method="timestepping", got 1e-06: all its steps have'),
        ({"max_step": 0.1}, 'Expected no max_step= for method="timestepping", got 0.1'),
        ({"impacts": "sequential"}, "Expected no impacts= for .*, got 'sequential': it solves all contacts of a step"),
        ({"indeterminate": "refuse"}, "Expected no indeterminate= for .*, got 'refuse': it solves all contacts"),
    ],
)  # fmt: skip
def test_of_time_stepping(disk, many, given, text):
    with pytest.raises(SimulationError, match=text):
        fb.simulate(disk, 0.1, initial={"y": 0.1}, **STEPPED, **given, **many)


def test_of_one_motion_and_of_a_batch(pendulum):
    with pytest.raises(SimulationError, match="Expected several motions for threads=, got one of 'pendulum'"):
        fb.simulate(pendulum, 0.1, threads=2)
    with (
        concurrent.futures.ThreadPoolExecutor(1) as pool,
        pytest.raises(SimulationError, match="Expected threads= or executor=, got both"),
    ):
        fb.simulate(pendulum, 0.1, values={"m": [1, 2]}, threads=2, executor=pool)


def test_shared_contact_forces_of_a_batch_are_those_of_a_run_alone(table):
    start = {"f_z": 0.4, "f_vx": 1.0, "f_wz": 1.0}
    many = {**start, "f_wz": [1.0, 0.0]}
    refused = fb.simulate(table, 0.05, initial=many, samples=2, indeterminate="refuse")
    assert list(refused.status) == ["no start", "finished"]
    assert "take indeterminate='compliance'" in refused.reason.values[0]
    alone = fb.simulate(table, 0.05, initial=start, samples=2, indeterminate="compliance")
    data = fb.simulate(table, 0.05, initial=many, samples=2, indeterminate="compliance")
    assert list(data.status) == ["finished", "finished"]
    assert np.array_equal(data["f_wz"][0], alone["f_wz"])
    swept = fb.sweep(
        table, {"f_wz": [1.0]}, 0.05, initial={"f_z": 0.4, "f_vx": 1.0}, samples=2, indeterminate="compliance"
    )
    assert np.array_equal(swept["f_wz"][0], alone["f_wz"])
    with pytest.raises(
        SimulationError, match="No lane has a start.*indeterminate='compliance' .*or 'refuse'.*'most'"
    ):
        fb.simulate(table, 0.05, initial=many, indeterminate="most")


def test_a_store_of_other_shared_forces_is_not_gone_on_with(table, tmp_path):
    run = {"initial": {"f_z": [0.4, 0.5]}, "samples": 2, "store": tmp_path / "lanes.nc"}
    fb.simulate(table, 0.01, **run)
    with pytest.raises(SimulationError, match="to hold results of the same runs"):
        fb.simulate(table, 0.01, indeterminate="refuse", **run)


def test_steps_are_counted_over_a_whole_run(pendulum):
    """Blows, signals and controllers divide it into legs."""
    bar = pendulum.bodies["bar"]
    kicks = [fb.blow(t / 10, at=bar, moment=(0, 0, 0.01)) for t in range(1, 10)]
    assert fb.simulate(pendulum, 1, initial={"a": 1}, impulses=kicks).steps > 6
    with pytest.raises(SimulationError, match="max_steps = 6 steps reached only t = 0"):
        fb.simulate(pendulum, 1, initial={"a": 1}, impulses=kicks, max_steps=6)


def test_steps_of_all_phases_of_contacts_count(disk):
    hop = {"y": 0.3, "x'": 1, "turn'": -5}
    steps = fb.simulate(disk, 2, initial=hop).steps  # of the fall, of the slip and of the roll
    with pytest.raises(SimulationError, match=f"max_steps = {steps - 1} steps reached only t = "):
        fb.simulate(disk, 2, initial=hop, max_steps=steps - 1)
