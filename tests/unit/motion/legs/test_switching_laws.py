"""Laws that switch on a speed: where a motion would stick on one it stops, and nowhere else."""

import math
import re

import numpy as np
import pytest

import freebody as fb
from freebody.errors import SimulationError


def block(law, **parameters):
    s = fb.System("block")
    s.parameters(m=1.0, c=2.0, k=9.0, g=9.81, **parameters)
    body = s.body("block", fb.particle("m"))
    s.slider("guide", s.ground, body, axis="x", coordinate="x")
    s.force("law", body, (law, 0, 0))
    return s


def stopped(s, until=5, **options):
    with pytest.raises(SimulationError) as caught:
        fb.simulate(s, until, **options)
    return str(caught.value), caught.value.trajectory


@pytest.mark.parametrize("method", ["auto", "dop853", "dop54", "radau"])
def test_a_slide_sticks_where_its_speed_is_zero(method):
    """v₀ - c t = 0 at t = v₀ / c, under a load that is less than c."""
    text, motion = stopped(block("-c*sign(x')"), initial={"x'": 3}, method=method)
    assert motion.status == "stuck on a switching law"
    assert motion.path.end == pytest.approx(1.5, abs=1e-6)
    assert motion["x"][-1] == pytest.approx(9 / 4, abs=1e-6)
    assert (
        re.search(r"it sticks at t = 1\.(5|49999)", text)
        and "a law with sign(x') drives it back from either side" in text
    )
    assert "s.contact(..., friction=mu)" in text and "tanh((x')/width)" in text
    assert motion.path.steps < 1000


def test_steps_of_one_length_stick_too():
    text, motion = stopped(block("-c*sign(x')"), initial={"x'": 3}, method="dop853", step=0.01)
    assert "it sticks at t = 1." in text
    assert motion.path.end == pytest.approx(1.5, abs=0.02)


def test_a_start_at_rest_sticks_under_a_load_that_is_less():
    text, motion = stopped(block("c/2 - c*sign(x')"))
    assert motion.path.end == 0 and "it sticks at t = 0 s" in text


def test_a_rest_that_the_law_allows_is_one():
    """No load, no speed: sign(0) = 0 keeps the block where it is."""
    motion = fb.simulate(block("-c*sign(x')"), 5)
    assert motion.status == "finished" and not motion["x"].any()


def test_a_load_that_is_greater_moves_it():
    motion = fb.simulate(block("3*c/2 - c*sign(x')"), 2)
    assert motion["x"][-1] == pytest.approx(2.0, rel=1e-8)  # (3/2 - 1) c t² / 2


def test_a_vibration_that_turns_above_the_friction_is_not_stopped():
    """Forced at resonance: at every turning point the spring pulls by more than the friction holds."""
    s = block("-k*x - c*sign(x')/4 + 4*sin(3*t)")
    motion = fb.simulate(s, 20, initial={"x": 1}, events=["x'"], tolerance=1e-6)
    assert motion.status == "finished" and len(motion.events) > 15
    assert np.abs(9 * motion["x"][motion.t > 10]).max() > 2


def test_friction_brings_a_vibration_to_rest_after_half_turns():
    """Each half turn takes 2 F / k from the amplitude: 1 - 2 n F/k, until k x is less than F."""
    s = block("-k*x - 2*c*sign(x')/5")  # F / k = 4/45
    text, motion = stopped(s, 20, initial={"x": 1})
    assert motion.path.end == pytest.approx(6 * math.pi / 3, abs=1e-4)
    assert motion["x"][-1] == pytest.approx(1 - 12 * 4 / 45, abs=1e-5)


def test_a_place_that_switches_holds_nothing():
    """The side of a place, sign(x), has no speed to drive back: a block goes to and fro over it."""
    motion = fb.simulate(block("-c*sign(x)"), 8, initial={"x": 1.0}, tolerance=1e-7)
    assert motion.status == "finished"
    assert motion.energy.residual == pytest.approx(0, abs=1e-4) or np.abs(motion["x"]).max() < 1.001


def test_lanes_stick_as_runs_alone_do():
    s = block("-c*sign(x')")
    data = fb.simulate(s, 2, initial={"x'": np.linspace(1, 5, 9)}, outputs=["x"], samples=3)
    sticks = np.linspace(1, 5, 9) < 4
    assert (data.status.values == np.where(sticks, "stuck on a switching law", "finished")).all()
    assert data.end.values[sticks] == pytest.approx(np.linspace(1, 5, 9)[sticks] / 2, abs=1e-6)


def test_a_run_has_bounds_without_being_told(monkeypatch):
    from freebody.motion.start import arguments

    monkeypatch.setattr(arguments, "MOST_STEPS", 300)
    text, motion = stopped(block("-k*x"), 1e9, initial={"x": 1}, method="dop853")
    assert "max_steps = 300 steps reached only t = " in text and motion.path.steps == 300
    assert "The fastest motion there is a vibration at 3 1/s, mostly of 'x''." in text
    lanes = fb.simulate(block("-k*x"), 1e9, initial={"x": [1, 2]}, samples=2, method="dop853")
    assert set(lanes.status.values) == {"too many steps"} and set(lanes.steps.values) == {300}


def test_what_makes_a_run_slow_is_named():
    text, motion = stopped(block("-1e7*x'"), 1e3, initial={"x'": 1}, method="dop853", max_steps=2000)
    assert "The fastest motion there is a decay at 1e+07 1/s, mostly of 'x''." in text
    assert 'method="radau" takes long steps' in text


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"method": "gauss", "step": 1e-3}, "at most 10000000 steps, got step = 0.001 s, which makes 1e+12"),
        ({"max_step": 1e-3}, "got max_step = 0.001 s, which makes 1e+12. Take a longer max_step="),
        ({"max_step": 1e-3, "initial": {"x": [1, 2]}}, "got max_step = 0.001 s, which makes 1e+12"),
    ],
)  # fmt: skip
def test_steps_that_are_known_to_be_too_many_are_refused_before(options, text):
    with pytest.raises(SimulationError) as caught:
        fb.simulate(block("-k*x"), 1e9, **options)
    assert text in str(caught.value)


def test_samples_of_a_controller_that_are_too_many_are_refused_before():
    s = block("F", F=0.0)
    s.controller(lambda t, state: 0.0, period=1e-9, inputs=["F"])
    with pytest.raises(
        SimulationError, match=r"got a period of 1e-09 s of controller .*, which makes 1e\+10"
    ):
        fb.simulate(s, 10)


def test_steps_of_contacts_that_are_too_many_are_refused_before():
    s = fb.System("ball")
    s.gravity = (0, 0, -9.81)
    ball = s.body("ball", fb.sphere(1, 0.1))
    s.free("free", s.ground, ball)
    s.contact("floor", ball.point(0, 0, 0), s.ground.plane(normal="z"))
    with pytest.raises(SimulationError, match=r"got step = 1e-09 s, which makes 1e\+10"):
        fb.simulate(s, 10, method="timestepping", step=1e-9)
    with pytest.raises(
        SimulationError, match="at most 9 steps, got step = 0.1 s, which makes 10. Take a longer step="
    ):
        fb.simulate(s, 1, method="timestepping", step=0.1, max_steps=9)


def test_memory_bounds_steps_that_are_asked_for():
    from freebody.motion.start.arguments import MOST_STEPS, largest_memory, most_steps

    assert most_steps(None, 5) == MOST_STEPS
    assert most_steps(None, 1000) == min(2**31, largest_memory() / 4) // 16000
    assert most_steps(7, 5) == 7
    assert most_steps(10**30, 5) <= max(largest_memory(), 2.0**62) / 80
