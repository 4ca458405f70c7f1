"""The text of every message of a simulation."""

from __future__ import annotations

import math

import numpy as np
import pytest

import freebody as fb
from freebody.errors import ExpressionError, ModelError, SimulationError


@pytest.fixture(scope="module")
def pendulum(bar):
    return bar


@pytest.fixture(scope="module")
def swing(pendulum):
    return fb.simulate(pendulum, 1, initial={"theta": 1})


def flying():
    s = fb.System("flying")
    s.free("air", s.ground, s.body("ball", fb.sphere(1, 1)))
    return s


def block(force, **parameters):
    s = fb.System("block")
    s.parameters(**(parameters or {"m": 1.0}))
    body = s.body("block", fb.particle(1))
    s.slider("guide", s.ground, body, axis="x", coordinate="x")
    s.force("F", body.origin, (force, 0, 0))
    return s


def refused(match, *arguments, kind=SimulationError, **options):
    with pytest.raises(kind, match=match):
        fb.simulate(*arguments, **options)


# --- what is asked ---------------------------------------------------------------------------------


def test_not_a_system():
    refused(
        r"Expected a System or a Model to simulate, got 'pendulum'.*fb\.System",
        "pendulum",
        1,
        kind=ModelError,
    )


def test_unknown_name_in_initial(pendulum):
    refused(r"Unknown name 'thetta' in initial; did you mean 'theta'\?", pendulum, 1, initial={"thetta": 1})
    refused(r"Unknown name 'phi\(t\)' in initial; known names: theta, theta'\.", pendulum, 1,
            initial={fb.System().coordinates("phi"): 1})  # fmt: skip


def test_speed_without_a_prime(pendulum):
    refused(r"Unknown name 'theta_dot' in initial.*A speed is written with a prime: \"theta'\"", pendulum, 1,
            initial={"theta_dot": 1})  # fmt: skip


def test_initial_is_no_mapping(pendulum):
    refused(
        r"Expected initial values by name, such as \{'theta': 0\.1\}, got \[1\]", pendulum, 1, initial=[1]
    )


def test_initial_value_given_twice(pendulum):
    theta = pendulum.expression("theta")
    refused(r"The initial value of 'theta' is given twice, as 'theta' and as 'theta\(t\)'\. Leave one out", pendulum,
            1, initial={"theta": 1, theta: 2})  # fmt: skip


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_initial_value_is_not_finite(pendulum, value):
    refused(
        r"initial value of 'theta'.*finite number",
        pendulum,
        1,
        initial={"theta": value},
        kind=ExpressionError,
    )


def test_initial_value_of_unknown_names(pendulum):
    refused(r"In the initial value of 'theta': Expected a known name, got 'LL'", pendulum, 1,
            initial={"theta": "LL/2"}, kind=ExpressionError)  # fmt: skip


def test_initial_value_that_moves(pendulum):
    refused(r"Expected a number or an expression of parameters for the initial value of 'theta', but .* depends on t",
            pendulum, 1, initial={"theta": pendulum.t})  # fmt: skip


def test_initial_value_without_value(pendulum):
    refused(r"Expected a number for the initial value of 'theta', but 'sqrt\(-L\)' has no value", pendulum, 1,
            initial={"theta": "sqrt(-L)"})  # fmt: skip


def test_quaternion_of_length_zero():
    refused(r"Expected a quaternion \(air_e0, air_e1, air_e2, air_e3\) of length 1, got all zeros", flying(), 1,
            initial={"air": (0, 0, 0, 0)})  # fmt: skip


def test_quaternion_of_three_numbers():
    refused(r"Expected a quaternion \(w, x, y, z\) or a Rotation for joint 'air' in initial, got \(1, 2, 3\).*euler",
            flying(), 1, initial={"air": (1, 2, 3)})  # fmt: skip


def test_unknown_parameter(pendulum):
    refused(r"Unknown parameter 'l'; did you mean|known names", pendulum, 1, values={"l": 1}, kind=ModelError)


def test_parameter_without_value():
    s = fb.System("open")
    m = s.parameters("m")
    s.slider("guide", s.ground, s.body("block", fb.particle(m)), axis="x", coordinate="x")
    refused(r"No value for parameter m\. Give a default.*values=\{'m': \.\.\.\}", s, 1, kind=ModelError)


def test_end_of_unknown_names(pendulum):
    refused(r"In until: Expected a known name, got 'T'", pendulum, "T", kind=ExpressionError)


@pytest.mark.parametrize("tolerance", [0, -1e-9, 1, math.nan, 1e-16, "fine", True])
def test_tolerance(pendulum, tolerance):
    refused(r"Expected a tolerance between 1e-15 and 1, got .*1e-9 suits", pendulum, 1, tolerance=tolerance)


def test_tolerance_of_an_unknown_name(pendulum):
    refused(
        r"Unknown name 'thet' in tolerance; did you mean 'theta'\?", pendulum, 1, tolerance={"thet": 1e-9}
    )


def test_unknown_method(pendulum):
    refused(r"Unknown method 'dop85'; did you mean 'dop853'\?", pendulum, 1, method="dop85")


def test_times_and_samples(pendulum):
    refused(r"Expected times= or samples=, got both", pendulum, 1, times=[0, 1], samples=2)


def test_times_outside(pendulum):
    refused(r"Expected output times from 0 to 1 s, got 1\.5\. Leave it out, or simulate further", pendulum, 1,
            times=[0, 1.5])  # fmt: skip
    refused(r"Expected output times from 0 to 1 s, got nan", pendulum, 1, times=[math.nan])
    refused(r"Expected a list of output times, got an array of shape \(0,\)", pendulum, 1, times=[])


@pytest.mark.parametrize("samples", [1, 0, 2.5, True])
def test_samples(pendulum, samples):
    refused(r"Expected a number of samples of at least 2, got", pendulum, 1, samples=samples)


def test_max_step(pendulum):
    refused(r"Expected a longest step greater than 0 s, got max_step=0", pendulum, 1, max_step=0)


# --- events ----------------------------------------------------------------------------------------


def test_event_of_a_python_function(pendulum):
    def hits(t, y):
        return y[0]

    refused(r"Expected an expression for an event, got the Python function 'hits'\. No Python runs inside a step.*"
            r'fb\.event\("theta - pi/2"\)', pendulum, 1, events=[hits])  # fmt: skip


def test_event_of_unknown_names(pendulum):
    refused(
        r"In event 'phi': Expected a known name, got 'phi'", pendulum, 1, events=["phi"], kind=ExpressionError
    )


def test_event_that_never_changes(pendulum):
    refused(r"Expected an expression that changes for event 'size', but 'L - 1' depends on no coordinate", pendulum, 1,
            events=[fb.event("L - 1", "size")])  # fmt: skip


def test_direction_of_an_event():
    with pytest.raises(SimulationError, match=r"Expected direction -1 .* for event 'hit', got 'up'"):
        fb.event("theta", "hit", direction="up")


# --- what is asked of a trajectory -----------------------------------------------------------------


def test_unknown_name_in_a_trajectory(swing):
    with pytest.raises(
        SimulationError, match=r"Expected a coordinate, a speed .* 'thetta'; did you mean 'theta'\?"
    ):
        swing["thetta"]
    with pytest.raises(SimulationError, match=r"Unknown name 'thetta'; did you mean 'theta'\?"):
        swing.at(0.5)["thetta"]


def test_what_only_other_motions_have(swing):
    """A motion without contacts has none; what only time steps or derivatives give says how to ask for it."""
    assert len(swing.contacts) == len(swing.modes) == len(swing.happenings) == 0
    with pytest.raises(
        SimulationError, match=r"for trajectory.sensitivity, got one without. .*sensitivities=\["
    ):
        _ = swing.sensitivity
    for name in ("step", "depth", "sweeps"):
        with pytest.raises(SimulationError, match=f'method="timestepping" for trajectory.{name}, got one by'):
            getattr(swing, name)
    with pytest.raises(
        SimulationError, match="a machine with contacts for plot_margin, but 'pendulum' has none"
    ):
        swing.plot_margin()


def test_unknown_joint(swing):
    with pytest.raises(SimulationError, match=r"Unknown joint 'pinn'; did you mean 'pin'\?"):
        swing.reactions["pinn"]


def test_unknown_body(swing):
    with pytest.raises(SimulationError, match=r"Unknown body 'bat'; did you mean 'bar'\?"):
        swing.poses["bat"]


def test_time_outside_the_run(swing):
    with pytest.raises(
        SimulationError, match=r"Expected times within the run, 0 to 1; got 2\.0\. Ask .*simulate further"
    ):
        swing.at(2)


def test_no_folder_to_write_to(swing, tmp_path):
    with pytest.raises(
        SimulationError, match=r"Cannot write '.*nowhere/x\.nc': there is no folder '.*nowhere'"
    ):
        swing.save(tmp_path / "nowhere" / "x.nc")


def test_no_file_to_read(swing, tmp_path):
    with pytest.raises(SimulationError, match=r"There is no file '.*x\.nc' to read a trajectory from"):
        swing.load(tmp_path / "x.nc")
    (tmp_path / "x.nc").write_text("not netCDF")
    with pytest.raises(SimulationError, match=r"Expected a trajectory in netCDF format in '.*x\.nc'"):
        swing.load(tmp_path / "x.nc")


# --- motions that cannot be continued -------------------------------------------------------------


def stopped(s, until, **options):
    with pytest.raises(SimulationError) as caught:
        fb.simulate(s, until, **options)
    return str(caught.value), caught.value.trajectory


def test_a_rate_that_is_no_number_stops_with_time_coordinate_and_state():
    text, motion = stopped(block("sqrt(1 - t)"), 3)
    assert "The motion of 'block' cannot be continued: the rate of 'x'' is not a finite number" in text
    assert "just after t = 1 s" in text or "just after t = 0.99999" in text
    assert "Last good state: x = 0.4" in text
    assert "stop before with a terminal event" in text
    assert motion.status == "not finite"
    # x' = 2/3 (1 - (1 - t)^(3/2)) up to the end
    assert motion.t[-1] == pytest.approx(1, abs=1e-8)
    assert motion["x'"] == pytest.approx(2 / 3 * (1 - (1 - motion.t).clip(0) ** 1.5), abs=1e-7)
    assert np.isfinite(motion.states).all()


def test_a_start_without_rates_stops_at_once():
    text, motion = stopped(block("1/x"), 1)
    assert "the rate of 'x'' is not a finite number just after t = 0 s" in text
    assert motion.t.tolist() == [0.0]
    assert motion["x"].tolist() == [0.0]


def test_a_coordinate_without_bound_collapses_the_step():
    # x'' = 2 x³ with x(0) = x'(0) = 1 is x = 1/(1 - t)
    text, motion = stopped(block("2*x**3"), 2, initial={"x": 1, "x'": 1})
    assert "The motion of 'block' cannot be continued" in text
    assert "'x''" in text
    assert "error.trajectory" in text
    assert motion.t[-1] == pytest.approx(1, abs=1e-3)
    assert motion["x"][:100] == pytest.approx(1 / (1 - motion.t[:100]), rel=1e-6)


def test_too_many_steps():
    text, motion = stopped(block("-x"), 1000, initial={"x": 1}, max_steps=20)
    assert "max_steps = 20 steps reached only t = " in text
    assert "of 1000 s" in text
    assert "Raise max_steps, or loosen the tolerance" in text
    assert motion.steps == 20


# -- the component that is to blame -----------------------------------------------------------------


def escaping(which, force):
    """Three blocks on a track; one of them is pushed by a force that grows without bound."""
    s = fb.System("blocks")
    for name in "abc":
        s.slider(f"guide_{name}", s.ground, s.body(name, fb.particle(1)), axis="x", coordinate=name)
        s.generalized_force(name, force.replace("@", which) if name == which else f"-{name}")
    return s


@pytest.mark.parametrize("which", "abc")
@pytest.mark.parametrize("method", ["dop853", "dop54", "radau", "taylor"])
def test_the_component_that_escapes_is_named(which, method):
    start = {"a": 1, "b": -1, "c": 0.5, f"{which}'": 1}  # q' = 1/√(1 - 2t): at t = 1/2
    with pytest.raises(
        SimulationError, match=f"collapsed at t = 0.5 s: '{which}'' changes faster than any step"
    ):
        fb.simulate(escaping(which, "@'^3"), until=1, initial=start, method=method)


@pytest.mark.parametrize("which", "abc")
@pytest.mark.parametrize("method", ["dop853", "radau"])
def test_the_component_without_a_value_is_named(which, method):
    """√(1/2 - q) of a block that moves on at a speed near 1."""
    start = {name: 0.1 for name in "abc"} | {f"{which}'": 2}
    with pytest.raises(SimulationError, match=f"'{which}''"):
        fb.simulate(escaping(which, "-@'/9 - sqrt(1/2 - @)"), until=2, initial=start, method=method)
