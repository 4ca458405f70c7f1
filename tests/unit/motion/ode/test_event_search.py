"""Zeros of event functions: told from poles and from functions without a value, and found however many there are."""

import math

import numpy as np
import pytest

import freebody as fb
from freebody.errors import SimulationError

METHODS = (
    "dop853",
    "gauss",
    "taylor",
    # one loop for all, but compiled for each
    *(pytest.param(method, marks=pytest.mark.slow) for method in ("dop54", "radau", "structure")),
)


def oscillator():
    """A block of 2 kg on a spring of 8 N/m: x = cos 2t from rest at 1."""
    s = fb.System("oscillator")
    block = s.body("block", fb.particle(2))
    guide = s.slider("guide", s.ground, block, axis="x", coordinate="x")
    s.spring("spring", guide, stiffness=8)
    return s


def motion(events, until=3, x=1, method="dop853", **options):
    if method == "structure":
        options["step"] = 0.05
    return fb.simulate(oscillator(), until, initial={"x": x}, events=events, method=method, **options)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    "expression", ["1/x", "1/x^3", "1/(x + 1000 - 1000)", "1/(t - 1/2)", "exp(1/x) - 1", "x^2/x^3"]
)
def test_a_pole_is_not_a_zero(method, expression):
    assert motion([expression], method=method).events == []


@pytest.mark.parametrize("method", METHODS)
def test_zeros_beside_poles_are_found(method):
    # tan 3x: zeros at x = 0, poles at x = ±π/6; x/(t - 1) passes its pole at 1 s, once at the end of a step
    found = motion(["tan(3*x)", "x/(t - 1)"], method=method).events
    quarters = [math.pi / 4, 3 * math.pi / 4]
    for name in ("tan(3*x)", "x/(t - 1)"):
        times = [event.time for event in found if event.name == name]
        assert times == pytest.approx(quarters, abs=1e-6)


@pytest.mark.parametrize(
    "expression", ["sign(x)", "sign(x)*(2 - abs(x))", "atan(1e30*x)", "x^3", "x + 1e6 - 1e6"]
)
def test_jumps_and_flat_zeros_are_zeros(expression):
    found = motion([expression]).events
    assert [event.time for event in found] == pytest.approx([math.pi / 4, 3 * math.pi / 4], abs=1e-4)


def test_a_function_of_large_numbers_keeps_its_zeros():
    """Near 1e9 a step of the time is coarse, and neighbouring values are alike."""
    s = oscillator()
    found = fb.simulate(s, 1e9 + 3, start=1e9, initial={"x": 1}, events=["t - 1e9 - 1", "x", "1/x"]).events
    assert [event.name for event in found] == ["x", "t - 1e9 - 1", "x"]


def test_backwards():
    found = fb.simulate(oscillator(), -3, initial={"x": 1}, events=["1/x", "x"]).events
    assert [event.name for event in found] == ["x", "x"]


def test_an_event_without_a_value_at_the_start_is_refused():
    text = (
        r"expected a number for event 'log' at t = 0 s, where it begins, got nan for log\(-x\(t\)\)"
        r".*watch what passes"
    )
    with pytest.raises(SimulationError, match=text):
        motion([fb.event("log(-x)", name="log")])
    with pytest.raises(
        SimulationError, match=r"event '1/x' at t = 0 s, where it begins, got inf for 1/x\(t\)"
    ):
        motion(["1/x"], x=0)


@pytest.mark.parametrize("method", METHODS)
def test_an_event_that_loses_its_value_stops_the_run(method):
    """√(x - 1/2) ends where cos 2t = 1/2, at t = π/6; what happens before is kept."""
    with pytest.raises(
        SimulationError, match=r"event 'root' has no value just after t = 0\.523598"
    ) as caught:
        motion([fb.event("sqrt(x - 1/2)", name="root"), "x - 3/4", "x"], method=method, tolerance=1e-10)
    stopped = caught.value.trajectory
    assert stopped.status == "event undefined"
    assert stopped.path.end == pytest.approx(math.pi / 6, abs=1e-6)
    assert stopped.events[0].name == "x - 3/4"  # √(x - 1/2) may, or may not, come out 0 where it ends
    assert "x" not in [event.name for event in stopped.events]
    assert stopped.at(0.5)["x"] == pytest.approx(math.cos(1), abs=1e-7)


def test_a_terminal_event_before_the_loss_ends_the_run():
    stopped = motion(["sqrt(x - 1/2)", fb.event("x - 3/4", terminal=True)])
    assert stopped.status == "terminal event"


def test_a_gap_within_a_bracket_is_a_loss():
    # x √(x² - 1e-6)/|x|: signs on both sides, no value between
    with pytest.raises(SimulationError, match="has no value just after t = 0.7"):
        motion(["x*sqrt(x^2 - 1e-6)/abs(x)"])


def test_lanes():
    """Each lane tells for itself; what is only asked for may lack a value."""
    data = fb.simulate(
        oscillator(), 3, initial={"x": [1.0, 0.4]}, outputs=["x", "max(sqrt(x))", "max(x)"],
        events=["1/x", "x", fb.event("sqrt(x + 1/2)", name="root")],
    )  # fmt: skip
    assert data.status.values.tolist() == ["event undefined", "finished"]
    assert data.blame.values.tolist() == ["root", ""]
    assert data.end.values == pytest.approx([math.pi / 3, 3], abs=1e-6)
    assert data.event_count.values[:, :2].tolist() == [[0, 1], [0, 2]]
    assert np.isnan(data["max(sqrt(x))"].values).all()
    assert data["max(x)"].values == pytest.approx([1.0, 0.4])


def test_lanes_that_can_not_begin():
    data = fb.simulate(oscillator(), 3, initial={"x": [1.0, 0.0]}, events=["1/x"])
    assert data.status.values.tolist() == ["finished", "event undefined"]
    assert data.blame.values.tolist() == ["", "1/x"]


def test_a_blow_called_for_by_what_has_no_value():
    s = oscillator()
    hit = fb.blow("log(x)", at=s.bodies["block"].origin, impulse=(1, 0, 0), name="hit")
    with pytest.raises(SimulationError, match="event 'hit' has no value just after t = 0.8203"):
        fb.simulate(s, 3, initial={"x": 2}, impulses=[hit])


def test_events_of_time_stepping():
    s = oscillator()
    s.contact("wall", s.bodies["block"].sphere(1), s.ground.plane(normal="x", at=(-5, 0, 0)))
    options = dict(initial={"x": 1}, method="timestepping", step=0.01)
    found = fb.simulate(s, 3, events=["1/x", "x"], **options).events
    assert [event.name for event in found if event.name in ("1/x", "x")] == ["x", "x"]
    with pytest.raises(
        SimulationError, match=r"number for event 'sqrt\(x\)' at t = 0.79 s, got nan for sqrt"
    ):
        fb.simulate(s, 3, events=["sqrt(x)"], **options)


@pytest.mark.parametrize("method", ["dop853", "dop54", "radau", "gauss", "taylor"])
def test_an_event_at_the_start_has_the_state_of_the_start(method):
    s = fb.System("block")
    s.slider("guide", s.ground, s.body("block", fb.particle(1)), axis="x", coordinate="x")
    s.force("spring", s.bodies["block"], ("-4*x", 0, 0))
    first = fb.simulate(s, 1, initial={"x": 0.5}, events=["x'"], method=method).events[0]
    assert first.time == 0 and dict(first.state) == {"x": 0.5, "x'": 0.0}


# --- many zeros in one step ---------------------------------------------------------------------------


@pytest.mark.parametrize("method", METHODS)
def test_no_zero_of_a_fast_function_is_missed(method):
    """2000 cos 2t passes 636 multiples of π in each quarter of a period, in a few long steps."""
    found = motion(["sin(2000*x)"], until=math.pi / 2, method=method)
    count = math.floor(2000 / math.pi)
    assert found.steps < 60
    times = [event.time for event in found.events]
    exact = [math.acos(k * math.pi / 2000) / 2 for k in range(count, -count - 1, -1)]
    assert times == pytest.approx(exact, abs=1e-6)


@pytest.mark.parametrize("amplitude, rate", [(1e-4, 2e4), (1e-5, 3e5), (1e-3, 1e3)])
def test_no_zero_of_a_small_fast_part_is_missed(amplitude, rate):
    """Beside the zero of a slow function a small vibration has others; far from it, the vibration costs nothing."""
    found = motion([f"x - 0.5 + {amplitude}*sin({rate}*x)"], until=1).events
    x = np.linspace(0.5 - 2 * amplitude, 0.5 + 2 * amplitude, 200_001)
    g = x - 0.5 + amplitude * np.sin(rate * x)
    exact = np.arccos(x[1:][(g[1:] > 0) != (g[:-1] > 0)][::-1]) / 2
    assert [event.time for event in found] == pytest.approx(list(exact), abs=1e-7)


def test_more_events_in_one_step_than_the_log_holds():
    """The search goes on in the same step, so that the steps are those of a run without events."""
    found, plain = motion(["sin(2e4*x)"], until=1), motion([], until=1, method="dop853")
    assert np.array_equal(found.states[-1], plain.states[-1])
    assert len(found.events) == math.floor(2e4 / math.pi) + math.floor(2e4 * -math.cos(2) / math.pi) + 1
    times = [event.time for event in found.events]
    assert times == sorted(times)


def test_lanes_find_what_a_single_run_finds():
    data = motion(["sin(2000*x)"], until=1, x=np.linspace(0.5, 1.0, 9))
    for k, x in enumerate(np.linspace(0.5, 1.0, 9)):
        single = motion(["sin(2000*x)"], until=1, x=x).events
        assert int(data.event_count[k, 0]) == len(single) > 400
        assert float(data.event_time[k, 0]) == single[0].time


@pytest.mark.parametrize("expression", ["sin(1e7*x)", "sin(1e9*t) - 0.5"])
def test_a_function_with_too_many_zeros_is_refused(expression):
    with pytest.raises(
        SimulationError, match="more zeros than can be told apart in one step.*max_step="
    ) as error:
        motion([expression])
    assert f"'{expression}'" in str(error.value)
    assert error.value.trajectory.status == "event not resolved"
    data = motion([expression], x=[1.0, 0.9])
    assert data.blame.values.tolist() == [expression] * 2
    assert data.status.values.tolist() == ["event not resolved"] * 2


@pytest.mark.parametrize("x", [-0.5, -0.2, 0.0, 0.2])
def test_a_jump_to_and_fro_before_another_event_stops_the_run(x):
    """The function jumps at x, x - 0.01 and x - 0.06, of which two points of the step show one; the run would stop at
    x - 0.005.
    """
    jumps = f"sign(x - {x})*sign(x - {x} + 0.01)*sign(x - {x} + 0.06)"
    found = motion([fb.event(jumps, terminal=True), fb.event(f"x - {x} + 0.005", terminal=True)])
    assert [event.name for event in found.events] == [jumps]
    assert float(found.t[-1]) == pytest.approx(math.acos(x) / 2, abs=1e-4)


def test_a_function_has_changed_its_sign_at_its_event():
    """The states of the run tell, not the dense output of a long step: where they differ, a run would stop again."""
    for x in np.linspace(-0.9, 0.9, 19):
        found = motion([fb.event(f"sign(x - {x})", terminal=True)], tolerance=1e-3)
        assert float(found["x"][-1]) <= x


@pytest.mark.parametrize(("tolerance", "known"), [(1e-9, True), (1e-6, False)])
def test_states_beside_each_other_take_one_shorter_step(tolerance, known):
    """Eleven stages, the rates there and theirs; at a loose tolerance each state is the end of a shorter step."""
    apart = 1e-8
    options = {"until": 1, "tolerance": tolerance}
    plain, found = motion([], **options), motion(["x", f"x - {apart}"], **options)
    assert len(found.path.crossings) == 2
    for crossing in found.path.crossings:
        assert crossing.state[0] == pytest.approx(crossing.number * apart, abs=2e-15)
        assert crossing.state == pytest.approx(found.path.sample([crossing.time])[0], abs=2e-15)
        assert crossing.state[0] == pytest.approx(math.cos(2 * crossing.time), abs=10 * tolerance)
    assert (found.path.evaluations - plain.path.evaluations <= 11 + 2) == known


def test_events_after_the_stop_are_told_by_its_state():
    """x falls through 0.001, where the run stops, and in that step through 0; one 5e-14 s later is kept."""
    stop = fb.event("x - 0.001", terminal=True)
    alone, found = motion([stop], until=1), motion([stop, "x", "x - 0.001 + 1e-13"], until=1)
    assert [event.name for event in found.events] == ["x - 0.001", "x - 0.001 + 1e-13"]
    assert found.path.evaluations == alone.path.evaluations


def test_round_off_is_no_reason_to_search_on():
    """A function that is zero but for round-off has events, but is not searched without end."""
    found = motion(["2*x'^2 + 8*x^2 - 8"], until=1)
    assert found.status == "finished" and len(found.events) < 100
