"""simulate and Trajectory on small machines with known motions."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
import sympy
import xarray

import freebody as fb
from freebody.describe.description import parameters_of
from freebody.errors import SimulationError
from freebody.motion.kernels.kernels import kernels_of
from freebody.motion.trajectory.event import Event, EventSpec
from freebody.motion.trajectory.quantities import quaternions
from freebody.motion.trajectory.trajectory import Trajectory


def oscillator(damping=0):
    """A block of 2 kg on a spring of 8 N/m: 2 rad/s."""
    s = fb.System("oscillator")
    m, k = s.parameters(m=2.0, k=8.0)
    block = s.body("block", fb.particle(m))
    guide = s.slider("guide", s.ground, block, axis="x", coordinate="x")
    s.spring("k", guide, stiffness=k)
    if damping:
        s.damper("c", guide, damping=damping)
    return s


def pendulum():
    s = fb.System("pendulum")
    m, L, g = s.parameters(m=1.0, L=2.0, g=9.81)
    s.gravity = (0, -g, 0)
    bar = s.body("bar", fb.slender_bar(m, L, axis="y"))
    s.hinge("pin", s.ground, bar, to=(0, L / 2, 0), axis="z", coordinate="theta")
    s.describe("theta", unit="rad", about="angle from the vertical")
    return s


def flying_body():
    s = fb.System("flying box")
    box = s.body("box", fb.box(1.0, (0.3, 0.2, 0.1)))
    s.gravity = (0, 0, -9.81)
    s.free("air", s.ground, box)
    return s


@pytest.fixture(scope="module")
def motion():
    return fb.simulate(oscillator(), 10, initial={"x": 0.5}, tolerance=1e-11)


@pytest.fixture(scope="module")
def swing():
    events = [fb.event("theta'", "turn"), fb.event("theta", "down", direction=-1)]
    return fb.simulate(pendulum(), 10, initial={"theta": "60deg"}, tolerance=1e-10, events=events)


# --- the motion ------------------------------------------------------------------------------------


def test_oscillator_follows_the_cosine(motion):
    # 1e-11 (1 + |value|) per step, added
    bound = 2e-11 * motion.steps
    assert motion["x"] == pytest.approx(0.5 * np.cos(2 * motion.t), abs=bound)
    assert motion["x'"] == pytest.approx(-np.sin(2 * motion.t), abs=2 * bound)


def test_output_times_are_a_regular_grid_with_both_ends(motion):
    assert len(motion) == len(motion.t) >= 200
    assert (motion.t[0], motion.t[-1]) == (0.0, 10.0)
    assert np.ptp(np.diff(motion.t)) < 1e-14 * 10


def test_samples_and_times():
    s = oscillator()
    assert fb.simulate(s, 2, initial={"x": 1}, samples=5).t.tolist() == [0, 0.5, 1, 1.5, 2]
    times = [0.3, 1.7, 0.1]
    motion = fb.simulate(s, 2, initial={"x": 1}, times=times)
    assert motion.t.tolist() == times
    assert motion["x"] == pytest.approx(np.cos(2 * np.array(times)), abs=1e-8)


def test_backward_run_returns():
    s = oscillator(damping=0.3)
    there = fb.simulate(s, 3, initial={"x": 1, "x'": -0.2}, tolerance=1e-12)
    end = there.at(3)
    back = fb.simulate(s, 0, start=3, initial=dict(end), tolerance=1e-12)
    assert back.at(0)["x"] == pytest.approx(1, abs=1e-10)
    assert back.at(0)["x'"] == pytest.approx(-0.2, abs=1e-10)
    assert back.t[0] == 3.0
    assert back.t[-1] == 0.0


def test_start_time_matters_for_loads_of_time():
    s = fb.System("pushed")
    block = s.body("block", fb.particle(1))
    s.slider("guide", s.ground, block, axis="x", coordinate="x")
    s.force("F", block.origin, (s.t, 0, 0))
    motion = fb.simulate(s, 5, start=2, tolerance=1e-12)
    # x'' = t from t = 2 at rest
    assert motion["x"] == pytest.approx(motion.t**3 / 6 - 2 * motion.t + 8 / 3, abs=1e-10)


def test_values_replace_defaults():
    s = oscillator()
    m = parameters_of(s)[0].symbol
    by_name = fb.simulate(s, 1, initial={"x": 1}, values={"k": 32.0}, tolerance=1e-12)
    by_symbol = fb.simulate(s, 1, initial={"x": 1}, values={m: Fraction(1, 2)}, tolerance=1e-12)
    assert by_name["x"] == pytest.approx(np.cos(4 * by_name.t), abs=1e-10)
    assert by_symbol["x"] == pytest.approx(np.cos(4 * by_symbol.t), abs=1e-10)
    assert by_name.values == {"m": 2.0, "k": 32.0}


@pytest.mark.parametrize(
    "value",
    [math.pi / 3, "60deg", "pi/3", "L*pi/6", sympy.pi / 3, sympy.Symbol("L", real=True) * sympy.pi / 6],
)
def test_initial_values_in_every_form(value):
    assert fb.simulate(pendulum(), 0.1, initial={"theta": value}).at(0)["theta"] == math.pi / 3


def test_initial_values_by_atom():
    s = pendulum()
    theta = s.expression("theta")
    motion = fb.simulate(s, 0.1, initial={theta: 0.25, theta.diff(s.t): -1})
    assert dict(motion.at(0)) == {"theta": 0.25, "theta'": -1.0}


def test_end_may_be_an_expression_of_parameters():
    s = pendulum()
    assert fb.simulate(s, "2*pi*sqrt(L/g)").t[-1] == pytest.approx(
        2 * math.pi * math.sqrt(2 / 9.81), rel=1e-15
    )


def test_a_model_can_be_simulated_like_its_system():
    s = oscillator()
    a = fb.simulate(s, 1, initial={"x": 1})
    b = fb.simulate(fb.assemble(s), 1, initial={"x": 1})
    assert (a["x"] == b["x"]).all()


def test_a_system_that_has_changed_is_assembled_again():
    s = oscillator()
    assert kernels_of(s) is kernels_of(s)
    before = kernels_of(s)
    s.force("push", s.bodies["block"].origin, (8, 0, 0))
    assert kernels_of(s) is not before
    motion = fb.simulate(s, 1, tolerance=1e-12)
    assert motion["x"] == pytest.approx(1 - np.cos(2 * motion.t), abs=1e-10)
    s.gravity = (4, 0, 0)
    again = fb.simulate(s, 1, tolerance=1e-12)
    assert again["x"] == pytest.approx(2 * (1 - np.cos(2 * motion.t)), abs=1e-10)


def test_tolerance_by_name():
    given = {"initial": {"x": 1}, "method": "dop853"}
    loose = fb.simulate(oscillator(), 5, tolerance={"x": 1e-4, "x'": 1e-4}, **given)
    tight = fb.simulate(oscillator(), 5, tolerance={"x": 1e-4, "x'": 1e-12}, **given)
    assert tight.steps > 2 * loose.steps


def test_tighter_tolerance_gives_smaller_error():
    errors = []
    for tolerance in (1e-5, 1e-8, 1e-11):
        motion = fb.simulate(oscillator(), 10, initial={"x": 1}, tolerance=tolerance)
        errors.append(abs(motion["x"] - np.cos(2 * motion.t)).max())
    assert errors[0] > 30 * errors[1] > 900 * errors[2]


def test_max_step_is_kept():
    motion = fb.simulate(oscillator(), 1, initial={"x": 1}, max_step=0.01)
    assert motion.steps >= 99


# --- ball and free joints --------------------------------------------------------------------------


def test_free_flight():
    turned = fb.Rotation.euler("ZXZ", 0.3, 0.4, 0.5)
    s = flying_body()
    initial = {"air": turned, "air_z": 2, "air_vx": 1, "air_wz": 3, "air_wx": 0.1}
    motion = fb.simulate(s, 2, initial=initial, tolerance=1e-11)
    first = motion.poses["box"].rotation[0]
    assert first == pytest.approx(np.array(turned.matrix, dtype=float), abs=1e-15)
    velocity = first @ [1, 0, 0]
    fall = np.outer(motion.t, velocity) + [0, 0, 2] - np.outer(motion.t**2, [0, 0, 9.81 / 2])
    assert motion.poses["box"].position == pytest.approx(fall, abs=1e-9)
    four = np.stack([motion[f"air_e{i}"] for i in range(4)], axis=1)
    assert np.linalg.norm(four, axis=1) == pytest.approx(1, abs=1e-15)
    assert motion.poses["box"].quaternion == pytest.approx(four * np.sign(four[0, 0]), abs=1e-14)


def test_quaternions_are_normalised_and_default_to_the_identity():
    s = flying_body()
    assert fb.simulate(s, 0.1).at(0).q.tolist() == [0, 0, 0, 1, 0, 0, 0]
    given = fb.simulate(s, 0.1, initial={"air": (0, 0, 2, 0)})
    assert given.at(0).q.tolist() == [0, 0, 0, 0, 0, 1, 0]
    single = fb.simulate(s, 0.1, initial={"air_e1": 5})
    assert single.at(0).q.tolist() == [0, 0, 0, 0, 1, 0, 0]


def test_quaternions_of_matrices_do_not_jump():
    angles = np.linspace(0, 6 * math.pi, 200)
    axis = np.array([0.6, 0, 0.8])
    K = np.array([[0, -0.8, 0], [0.8, 0, -0.6], [0, 0.6, 0]])
    R = np.array([np.eye(3) + math.sin(a) * K + (1 - math.cos(a)) * K @ K for a in angles])
    expected = np.concatenate([np.cos(angles / 2)[:, None], np.sin(angles / 2)[:, None] * axis], axis=1)
    assert quaternions(R) == pytest.approx(expected, abs=4e-16 * 8)


# --- trajectory ------------------------------------------------------------------------------------


def test_any_expression_can_be_asked_for(swing):
    s = pendulum()
    m, L, g = (p.symbol for p in parameters_of(s))
    theta = s.expression("theta")
    speed = 2 * swing["theta'"]
    assert swing["L*theta'"] == pytest.approx(speed, rel=1e-15)
    assert swing[L * theta.diff(s.t)] == pytest.approx(speed, rel=1e-15)
    assert swing["-m*g*L/2*cos(theta)"] == pytest.approx(swing.energy.potential, rel=1e-14)
    assert swing["t"] is swing.t
    assert swing["kinetic_energy"] is swing.energy.kinetic


def test_at_gives_one_time_or_many(swing):
    one = swing.at(3.21)
    many = swing.at([[1, 2], [3, 3.21]])
    assert many["theta"].shape == (2, 2)
    assert many["theta"][1, 1] == one["theta"]
    assert isinstance(one["theta'"], float)
    assert one.q.tolist() == [one["theta"]]
    assert one.u.tolist() == [one["theta'"]]
    assert repr(one).startswith("<State at t = 3.21 s: theta = ")
    assert repr(swing.at([1, 2])) == "<States at 2 times of theta, theta'>"


def test_energy_ledger_of_a_conservative_machine(swing):
    assert swing.energy.relative_residual < 1e-9
    assert (swing.energy.work == 0).all()
    assert swing.energy.total == pytest.approx(swing.energy.total[0], rel=1e-9)
    assert not swing.kernels.works


def test_energy_ledger_of_a_damped_machine():
    motion = fb.simulate(oscillator(damping=0.7), 10, initial={"x": 1}, tolerance=1e-10)
    assert motion.kernels.works
    assert motion.energy.relative_residual < 1e-9
    assert motion.energy.work[-1] == pytest.approx(motion.energy.total[-1] - 4.0, abs=1e-8)
    assert (np.diff(motion.energy.work) <= 1e-12).all()
    assert "work" not in motion.names
    assert motion.at(1).q.shape == motion.at(1).u.shape == (1,)


def test_energy_of_output_times_that_leave_out_the_start():
    motion = fb.simulate(oscillator(damping=0.7), 10, initial={"x": 1}, tolerance=1e-10, times=[4, 5])
    assert abs(motion.energy.residual).max() < 4e-9
    assert motion.energy.work[0] < -1


def test_work_of_a_force_of_time():
    s = fb.System("pushed")
    block = s.body("block", fb.particle(1))
    s.slider("guide", s.ground, block, axis="x", coordinate="x")
    s.force("F", block.origin, (6 * s.t, 0, 0))
    motion = fb.simulate(s, 2, tolerance=1e-11)
    # v = 3 t², W = T = 9 t⁴/2
    assert motion.energy.work == pytest.approx(4.5 * motion.t**4, abs=1e-9)


def test_reactions_of_a_pendulum(swing):
    theta, rate = swing["theta"], swing["theta'"]
    reaction = swing.reactions["pin"]
    # slender bar, m = 1, L = 2, C at 1 m: theta'' = -3 g sin(theta) / (2 L)
    acceleration = -1.5 * 9.81 / 2 * np.sin(theta)
    x = acceleration * np.cos(theta) - rate**2 * np.sin(theta)
    y = acceleration * np.sin(theta) + rate**2 * np.cos(theta) + 9.81
    assert reaction.force == pytest.approx(np.stack([x, y, 0 * x], axis=1), abs=1e-12)
    assert abs(reaction.moment).max() < 1e-12
    assert (reaction.on, reaction.frame) == ("bar", "ground")
    assert reaction.about == "the point of joint 'pin' on 'bar'"


def test_poses_of_a_pendulum(swing):
    pose = swing.poses["bar"]
    theta = swing["theta"]
    assert pose.position == pytest.approx(
        np.stack([np.sin(theta), -np.cos(theta), 0 * theta], axis=1), abs=1e-15
    )
    half = np.stack([np.cos(theta / 2), 0 * theta, 0 * theta, np.sin(theta / 2)], axis=1)
    assert pose.quaternion == pytest.approx(half, abs=1e-15)


def test_repr(swing):
    assert repr(swing) == "Trajectory of 'pendulum': t = 0 to 10 s, 1 coordinate, 13 events, finished"


def test_plot_writes_a_picture(swing, tmp_path):
    panels = swing.plot(["theta", "L*theta'"], path=tmp_path / "swing.png")
    assert [axis.get_ylabel() for axis in panels] == [r"$\theta$ [rad]", "L*theta'"]
    assert (tmp_path / "swing.png").read_bytes()[:4] == b"\x89PNG"
    assert swing.plot().get_ylabel() == r"$\theta$ [rad]"
    assert swing.plot("theta'").get_ylabel() == r"$\dot{\theta}$ [rad/s]"


# --- dataset ---------------------------------------------------------------------------------------


def test_dataset_has_everything_with_units(swing):
    data = swing.data
    assert isinstance(data, xarray.Dataset)
    n = len(swing)
    assert dict(data.sizes) == {"time": n, "axis": 3, "component": 4, "event": len(swing.events)}
    expected = {
        "theta": ("rad", ("time",)),
        "theta'": ("rad/s", ("time",)),
        "kinetic_energy": ("J", ("time",)),
        "potential_energy": ("J", ("time",)),
        "work": ("J", ("time",)),
        "energy_residual": ("J", ("time",)),
        "bar.position": ("m", ("time", "axis")),
        "bar.quaternion": ("1", ("time", "component")),
        "pin.force": ("N", ("time", "axis")),
        "pin.moment": ("N m", ("time", "axis")),
        "event_time": ("s", ("event",)),
    }
    for name, (unit, dims) in expected.items():
        assert data[name].attrs["units"] == unit
        assert data[name].dims == dims
        assert data[name].attrs["long_name"]
    assert set(data.data_vars) == {*expected, "event_name", "event_direction"}
    assert data["theta"].attrs["long_name"] == "angle from the vertical"
    assert (data["pin.force"].values == swing.reactions["pin"].force).all()
    assert data["event_name"].values.tolist() == [event.name for event in swing.events]


def test_units_of_free_joints_and_sliders():
    assert fb.simulate(oscillator(), 0.1).data["x'"].attrs["units"] == "m/s"
    data = fb.simulate(flying_body(), 0.1).data
    units = {name: data[f"air_{name}"].attrs["units"] for name in ("x", "e0", "wx", "vx")}
    assert units == {"x": "m", "e0": "1", "wx": "rad/s", "vx": "m/s"}


def test_save_and_load(swing, tmp_path):
    path = tmp_path / "swing.nc"
    swing.save(path)
    xarray.testing.assert_identical(Trajectory.load(path).data, swing.data)
    swing.save(str(path))  # over the first
    assert [file.name for file in tmp_path.iterdir()] == ["swing.nc"]


def test_nothing_is_left_of_a_failed_save(swing, tmp_path, monkeypatch):
    target = tmp_path / "swing.nc"
    target.write_text("kept")

    def fail(self, path, **options):
        path.write_text("half")
        raise OSError("disk full")

    monkeypatch.setattr(xarray.Dataset, "to_netcdf", fail)
    with pytest.raises(SimulationError, match=f"Cannot write '{target}': disk full") as error:
        swing.save(target)
    assert type(error.value.__cause__) is OSError
    assert [(file.name, file.read_text()) for file in tmp_path.iterdir()] == [("swing.nc", "kept")]


# --- events ----------------------------------------------------------------------------------------


def test_events_of_a_pendulum(swing):
    assert [event.name for event in swing.events][:4] == ["turn", "down", "turn", "turn"]
    assert swing.events[0].time == 0.0  # it begins at a turning point
    for event in swing.events:
        assert abs(event.state["theta'" if event.name == "turn" else "theta"]) < 1e-13
        assert dict(swing.at(event.time)) == pytest.approx(dict(event.state), abs=1e-12)
    assert isinstance(swing.events[1], Event)
    assert {event.direction for event in swing.events if event.name == "down"} == {-1}


def test_terminal_event_stops_the_run():
    stop = fb.event("theta", "bottom", terminal=True)
    motion = fb.simulate(pendulum(), 10, initial={"theta": 1}, events=[stop])
    assert motion.t[-1] == motion.events[-1].time < 1
    assert abs(motion["theta"][-1]) < 1e-15
    assert motion.status == "terminal event"
    assert repr(motion).endswith("1 event, stopped by 'bottom'")
    kept = fb.simulate(pendulum(), 10, initial={"theta": 1}, events=[stop], times=[0.1, 0.2, 9])
    assert kept.t.tolist() == [0.1, 0.2]


def test_events_of_expressions_with_time_and_parameters():
    s = pendulum()
    L = parameters_of(s)[1].symbol
    theta = s.expression("theta")
    motion = fb.simulate(s, 3, initial={"theta": 1}, events=["t - L/4", L * theta - 1])
    assert motion.events[0].time == pytest.approx(1.0, abs=1e-14) or motion.events[1].time == 0.5
    assert {event.name for event in motion.events} == {"t - L/4", "L*theta(t) - 1"}
    clock = [event.time for event in motion.events if event.name == "t - L/4"]
    assert clock == pytest.approx([0.5], rel=1e-12)


def test_a_single_event_needs_no_list():
    assert len(fb.simulate(pendulum(), 1, initial={"theta": 1}, events="theta").events) == 1
    assert fb.event("x") == EventSpec("x", "x")


# --- interruption and progress ---------------------------------------------------------------------


def test_interrupted_run_returns_what_was_computed():
    parts = []

    def progress(part):
        parts.append(part)
        if len(parts) == 2:
            raise KeyboardInterrupt

    motion = fb.simulate(oscillator(), 1e7, initial={"x": 1}, progress=progress)
    assert motion.interrupted
    assert 0 < motion.t[-1] < 1e7
    assert parts == sorted(parts)
    assert repr(motion).endswith("interrupted")
    t = motion.t[-1] / 2
    assert motion.at(t)["x"] == pytest.approx(math.cos(2 * t), abs=2e-9 * motion.steps)


def test_progress_bar_appears_after_a_second(monkeypatch, capsys):
    from freebody.motion.trajectory import progress as module

    monkeypatch.setattr(module, "_PATIENCE", 0.0)
    fb.simulate(oscillator(), 2e4, initial={"x": 1}, progress=True)
    assert "simulating" in capsys.readouterr().err
    monkeypatch.setattr(module, "_PATIENCE", 1e9)
    fb.simulate(oscillator(), 2e4, initial={"x": 1}, progress=True)
    fb.simulate(oscillator(), 2e4, initial={"x": 1})
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("method", ["dop853", "dop54", "radau", "gauss", "taylor"])
def test_the_dataset_names_the_method_that_ran(method: str) -> None:
    motion = fb.simulate(pendulum(), 0.2, initial={"theta": 1.0}, method=method)
    assert motion.data.attrs["method"] == motion.path.method == method
