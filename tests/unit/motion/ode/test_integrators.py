"""Every method: its order, its events, its states between steps, and what it refuses."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import freebody as fb
from batch_machines import rail
from freebody.errors import SimulationError
from freebody.model import assemble
from freebody.motion.ending import End
from freebody.motion.kernels import method_kernels
from freebody.motion.kernels.kernels import kernels_of
from freebody.motion.kernels.methods import methods
from freebody.motion.ode import dop54, integration
from freebody.motion.ode.dense_output import observe
from freebody.motion.ode.gauss import integrals, tables
from freebody.motion.ode.layout import EXPLICIT, SINGLE_STEPS
from freebody.motion.ode.layout import ORDERS as LISTED
from freebody.motion.ode.loops import place
from freebody.motion.ode.tableau import OWN
from freebody.native.loop import module_named
from freebody.scalar.derivative import jacobian
from freebody.scalar.trace import Tape
from freebody.testing import random_system

OURS = [method for method in LISTED if method not in OWN]  # another test may have brought methods of its own
CONTROLLED = (*(method for method in EXPLICIT if method in OURS), "radau", "gauss", "taylor")
ALL = (*CONTROLLED, "structure")
EPS = np.finfo(float).eps


def steps(method, length=0.02):
    """Arguments of a run by a method: a step for the one that asks for it."""
    return {"method": method, "step": length if method == "structure" else None}


# --- machines ----------------------------------------------------------------------------------------


def pendulum(damping=0):
    s = fb.System("pendulum")
    s.gravity = (0, -9.81, 0)
    bob = s.body("bob", fb.slender_bar(1, 2, axis="y"))
    pin = s.hinge("pin", s.ground, bob, to=(0, 1, 0), axis="z", coordinate="theta")
    if damping:
        s.damper("c", pin, damping=damping)
    return s


def heavy_top(joint="gimbal"):
    s = fb.System("heavy top")
    s.gravity = (0, 0, -9.81)
    top = s.body("top", fb.cylinder(1, 0.1, 0.3, axis="z"))
    if joint == "gimbal":
        s.gimbal("o", s.ground, top, to=(0, 0, -0.3), axis="ZXZ", coordinate="psi theta phi")
    else:
        s.ball("o", s.ground, top, to=(0, 0, -0.3))
    return s


def tumbling_body():
    s = fb.System("tumbling body")
    box = s.body("box", fb.box(2, (0.3, 0.2, 0.1)))
    s.free("f", s.ground, box)
    return s


def four_bar():
    s = fb.System("four-bar")
    s.gravity = (0, -9.81, 0)
    crank, rod, rocker = (
        s.body(n, fb.slender_bar(1, x)) for n, x in (("crank", 1), ("rod", 2), ("rocker", 2))
    )
    s.hinge("A", s.ground, crank, to=(-0.5, 0, 0), coordinate="a")
    s.hinge("B", crank, rod, at=(0.5, 0, 0), to=(-1, 0, 0), coordinate="b")
    s.hinge("D", s.ground, rocker, at=(2, 0, 0), to=(-1, 0, 0), coordinate="d")
    s.hinge("C", rocker, rod, at=(1, 0, 0), to=(1, 0, 0))
    return s


def stiff_cart():
    """A pendulum on a cart that a stiff spring and a strong damper hold: rates of about 1, 10 and 40 000 per second."""
    s = fb.System("stiff cart")
    s.gravity = (0, -9.81, 0)
    cart, bob = s.body("cart", fb.particle(2)), s.body("bob", fb.particle(1))
    guide = s.slider("guide", s.ground, cart, axis="x", coordinate="x")
    s.hinge("pin", cart, bob, to=(0, 1, 0), axis="z", coordinate="theta")
    s.spring("k", guide, stiffness=1e6)
    s.damper("c", guide, damping=1e5)
    return s


MACHINES = {
    "heavy top": (heavy_top, {"initial": {"theta": 0.5, "phi'": 20.0, "psi'": 0.3}}, 0.4),
    "ball": (
        lambda: heavy_top("ball"),
        {"initial": {"o": (math.cos(0.25), math.sin(0.25), 0, 0), "o_wz": 20.0, "o_wx": 0.3}},
        0.4,
    ),
    "tumbling": (tumbling_body, {"initial": {"f_wx": 0.1, "f_wy": 5.0, "f_wz": 0.2, "f_vx": 1.0}}, 1.0),
    "four-bar": (four_bar, {"initial": {"a": 0.3, "a'": 3.0}, "near": {"b": 0.4, "d": 0.9}}, 0.8),
}


@pytest.mark.parametrize("method", ["dop54", "dop853", "gauss"])
def test_stages_are_at_their_times(method):
    """One step integrates a force t³ exactly, and another moment of any stage does not."""
    s = fb.System("pushed mass")
    mass = s.body("mass", fb.particle(1))
    s.slider("guide", s.ground, mass, axis="x", coordinate="x")
    s.force("push", mass.origin, ("20*t^3", 0, 0))
    motion = fb.simulate(s, 1, method=method, step=1.0)
    assert motion.steps == 1
    assert motion["x'"][-1] == pytest.approx(5, abs=1e-13)


# --- order -------------------------------------------------------------------------------------------

STEPS = {5: (20, 40, 80), 8: (6, 12, 24)}
ORDERS = {
    **{method: (order, STEPS[order]) for method, order in EXPLICIT.items() if method in OURS},
    "radau": (5, (20, 40, 80)),
    "structure": (6, (24, 48, 96)),
}


@pytest.mark.parametrize("name", OURS)
def test_a_method_is_a_value_of_its_file_with_the_order_of_the_list(name):
    method = module_named(place(name)).METHOD
    assert (method.name, method.order) == (name, LISTED[name])
    assert name in methods() or name in SINGLE_STEPS
    assert method.single_step == (name in SINGLE_STEPS)


@pytest.mark.parametrize("method", ["dop54", "dop853", "tsit5"])
def test_every_explicit_method_passes_the_battery(method):
    fb.testing.check_method(method)


def test_a_method_by_its_coefficients_is_the_same_method():
    """The tableau of Dormand and Prince, compiled from data: the steps and states of dop54."""
    E = np.append(dop54.B, 0) - dop54.E
    fb.RungeKutta("dormand", order=5, stages=dop54.A[1:], weights=dop54.B, embedded=E)
    s, start, until = heavy_top(), *MACHINES["heavy top"][1:]
    own, given = (fb.simulate(s, until, method=m, tolerance=1e-7, **start) for m in ("dormand", "dop54"))
    assert own.steps == given.steps
    assert own.states == pytest.approx(given.states, abs=1e-13)


def test_wrong_methods_are_caught():
    """Coefficients that satisfy all order conditions, with an error that is too small, and a wrong order by force."""
    careless = fb.RungeKutta(
        "careless", order=2, stages=[[1]], weights=[1 / 2, 1 / 2], embedded=[1 / 2 + 1e-9, 1 / 2 - 1e-9]
    )
    with pytest.raises(
        AssertionError, match="careless: expected an error of at most .* for the tolerance 0.0001, got"
    ):
        fb.testing.check_method(careless)
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(LISTED, "careless", 3)
        with pytest.raises(
            AssertionError, match="careless: expected errors that fall with the power 3 of the step"
        ):
            fb.testing.check_method(careless)


@pytest.fixture(scope="module", params=list(MACHINES))
def machine(request):
    """A machine, its start, the length of its run, and its end by order 16 with the finest steps."""
    make, start, until = MACHINES[request.param]
    s = make()
    end = fb.simulate(s, until, method="gauss", tolerance=1e-15, samples=2, **start).path.states[-1]
    return s, start, until, end


def errors(machine, method, numbers):
    """Greatest error of the end of runs in so many equal steps."""
    s, start, until, end = machine
    found = []
    for n in numbers:
        # the tolerance bounds the iterations only
        run = fb.simulate(s, until, method=method, step=until / n, tolerance=1e-14, samples=2, **start)
        assert run.steps == n
        found.append(np.abs(run.path.states[-1] - end).max())
    return found


@pytest.mark.parametrize("method", ORDERS)
def test_order(machine, method):
    """Quaternions that are normalised and states that are projected keep it, too."""
    closed = bool(kernels_of(machine[0]).model.constraints)
    if method == "structure" and closed:
        pytest.skip("it refuses machines with constraints")
    order, numbers = ORDERS[method]
    if closed:  # at coarser steps, the leading term of an error passes through zero
        numbers = tuple((4 if method in EXPLICIT and order == 5 else 2) * n for n in numbers)
    found = np.array(errors(machine, method, numbers))
    assert found[-1] > 30 * EPS  # else round-off is measured
    slope = np.log2(found[-2] / found[-1])
    assert slope > order - 0.35
    if not closed:  # there the leading term of the error happens to be small
        assert slope < order + 0.35


@pytest.mark.parametrize("name", ["pendulum", "ball", "four-bar"])
def test_order_of_gauss_is_sixteen(name):
    """The step may be little more than halved between the longest that converges and round-off."""
    make, start, until = MACHINES.get(name, (pendulum, {"initial": {"theta": 2.0}}, 8))
    s = make()
    until *= 8 if name == "four-bar" else 1
    end = fb.simulate(s, until, method="gauss", tolerance=1e-15, samples=2, **start).path.states[-1]
    numbers = {"pendulum": (14, 16, 20, 24, 28), "ball": (4, 5, 6), "four-bar": (60, 80, 100, 120, 140)}[name]
    found = errors((s, start, until, end), "gauss", numbers)
    assert found[-1] > 10 * EPS
    assert np.polyfit(np.log(numbers), np.log(found), 1)[0] == pytest.approx(-16, abs=2)


def test_gauss_tables():
    for s in (1, 3, 8):
        made = tables(s)
        x = np.linspace(-1, 1, 5)
        assert integrals(x, s)[:, 0] == pytest.approx((x + 1) / 2)
        assert integrals(np.array([1.0]), s)[0, 1:] == pytest.approx(np.zeros(s - 1), abs=EPS)
        # collocation: A integrates powers up to c^(s - 1) exactly, b = T[0] up to c^(2s - 1)
        c = made["C"]
        for k in range(s):
            assert made["A"] @ c**k == pytest.approx(c ** (k + 1) / (k + 1), abs=8 * EPS)
        for k in range(2 * s):
            assert made["T"][0] @ c**k == pytest.approx(1 / (k + 1), abs=8 * EPS)


# --- step control ------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", CONTROLLED)
def test_the_error_follows_the_tolerance(method):
    s, start, until = heavy_top(), *MACHINES["heavy top"][1:]
    end = fb.simulate(s, until, method="gauss", tolerance=1e-15, samples=2, **start).path.states[-1]
    for tolerance in (1e-4, 1e-7, 1e-10):
        run = fb.simulate(s, until, method=method, tolerance=tolerance, **start)
        # coordinates reach 8, speeds 20; errors of some ten steps add up
        assert np.abs(run.path.states[-1] - end).max() < 1000 * tolerance
        assert run.energy.relative_residual < 100 * tolerance


def test_gauss_reaches_round_off():
    """A run of 200 revolutions: the energy stays to a few units in the last place."""
    s, start, _ = heavy_top("ball"), *MACHINES["ball"][1:]
    run = fb.simulate(s, 60, method="gauss", tolerance=1e-14, **start)
    assert run.energy.relative_residual < 30 * EPS


@pytest.mark.parametrize("method", ALL)
def test_quaternions_are_unit(method):
    s, start, _ = tumbling_body(), *MACHINES["tumbling"][1:]
    run = fb.simulate(s, 20, tolerance=1e-8, **steps(method), **start)
    for states in (run.path.states, run.states):
        assert np.abs(np.linalg.norm(states[:, 3:7], axis=1) - 1).max() < 4 * EPS


@pytest.mark.parametrize("method", CONTROLLED)
def test_constraints_are_met_to_round_off(method):
    make, start, _ = MACHINES["four-bar"]
    run = fb.simulate(make(), 3, method=method, tolerance=1e-6, **start)
    a, b, d = run["a"], run["b"], run["d"]
    tip = np.cos(a) + 2 * np.cos(a + b) - 2 * np.cos(d) - 2, np.sin(a) + 2 * np.sin(a + b) - 2 * np.sin(d)
    assert np.abs(tip).max() < 50 * EPS
    assert run.energy.relative_residual < 1e-4


@pytest.mark.parametrize("method", CONTROLLED)
def test_the_work_of_a_damper_closes_the_ledger(method):
    run = fb.simulate(pendulum(damping=0.5), 5, initial={"theta": 1.0}, method=method, tolerance=1e-9)
    assert run.energy.work[-1] < -1
    assert run.energy.relative_residual < 1e-6


# --- events, output, interruption --------------------------------------------------------------------


@pytest.mark.parametrize("method", ALL)
def test_events_and_states_between_steps(method):
    """Of a pendulum, against order 16: turning points, and states anywhere."""
    arguments = {"initial": {"theta": 2.0}, "events": ["theta'", "theta"], "tolerance": 1e-10}
    best = fb.simulate(pendulum(), 10, method="gauss", **arguments)
    run = fb.simulate(pendulum(), 10, **steps(method), **arguments)
    assert [event.name for event in run.events] == [event.name for event in best.events]
    assert len(run.events) >= 8
    assert [e.time for e in run.events] == pytest.approx([e.time for e in best.events], abs=1e-7)
    t = np.linspace(0, 10, 57)
    assert run.at(t)["theta"] == pytest.approx(best.at(t)["theta"], abs=1e-7)
    # at an event the state is that of a run that ends there
    event = run.events[3]
    assert run.at(event.time)["theta'"] == pytest.approx(event.state["theta'"], abs=1e-9)
    dense = run.path.sample(t, dense=True)[:, 0]
    # coarser by design: they only bracket events
    assert dense == pytest.approx(best.at(t)["theta"], abs=1e-3)


@pytest.mark.parametrize("method", ALL)
def test_a_terminal_event_stops_the_run(method):
    run = fb.simulate(
        pendulum(), 10, initial={"theta": 1.0}, events=[fb.event("theta", terminal=True)], **steps(method)
    )
    assert run.status == "terminal event"
    assert run.path.states[-1][0] == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("method", ALL)
def test_backwards_returns_to_the_start(method):
    there = fb.simulate(pendulum(), 3, initial={"theta": 1.0}, tolerance=1e-9, **steps(method))
    end = dict(zip(there.names, there.path.states[-1], strict=False))
    back = fb.simulate(pendulum(), 0, start=3, initial=end, tolerance=1e-9, **steps(method))
    assert back.path.states[-1] == pytest.approx([1.0, 0.0], abs=1e-6)


@pytest.mark.parametrize("method", ALL)
def test_interrupted(method):
    def stop(part):
        raise KeyboardInterrupt

    run = fb.simulate(pendulum(), 1e5, initial={"theta": 1.0}, progress=stop, **steps(method))
    assert run.interrupted
    assert 0 < run.path.end < 1e5
    assert np.isfinite(run.states).all()


@pytest.mark.parametrize("method", ["dop853", "tsit5", "radau"])
def test_states_whose_squares_vanish_are_no_failure(method):
    """An error of 1e-163 has the square 0, and 0/0 was no number."""
    s = fb.System("spring")
    s.spring(
        "k", s.slider("rail", s.ground, s.body("mass", fb.particle(1)), axis="x", coordinate="x"), stiffness=1
    )
    motion = fb.simulate(s, 1, initial={"x": 1e-163}, method=method)
    assert motion["x"][-1] == pytest.approx(1e-163 * np.cos(1), rel=0.5, abs=0)


@pytest.mark.parametrize("method", CONTROLLED)
def test_a_rate_that_is_no_number_is_reported(method):
    s = fb.System("block")
    block = s.body("block", fb.particle(1))
    s.slider("guide", s.ground, block, axis="x", coordinate="x")
    s.force("pull", block, ("sqrt(1 - x)", 0, 0))
    with pytest.raises(SimulationError, match="is not a finite number|the step collapsed"):
        fb.simulate(s, 100, initial={"x'": 3.0}, **steps(method))


@pytest.mark.parametrize("method", CONTROLLED)
def test_too_many_steps(method):
    with pytest.raises(SimulationError, match="max_steps = 5 steps reached only"):
        fb.simulate(pendulum(), 100, initial={"theta": 1.0}, method=method, max_steps=5)


def test_long_steps_of_a_chain_can_be_divided():
    """Between steps there is no step before to predict the stages: they are led up to from shorter steps."""
    s = fb.System("chain")
    s.gravity = (0, -9.81, 0)
    last = s.ground
    for i in range(20):
        bar = s.body(f"bar{i}", fb.slender_bar(1, 1, axis="y"))
        s.hinge(f"pin{i}", last, bar, at=(0, -0.5 * (i > 0), 0), to=(0, 0.5, 0), axis="z", coordinate=f"q{i}")
        last = bar
    run = fb.simulate(s, 2, initial={"q0": 0.5}, method="gauss")
    assert run.steps < 40
    assert np.isfinite(run.states).all()
    assert run.energy.relative_residual < 1e-13


def test_a_state_that_can_not_be_computed_is_refused():
    """Of steps longer than any iteration from scratch could make."""
    run = fb.simulate(pendulum(), 10, initial={"theta": 2.0}, method="gauss")
    stretched = replace(run.path, lengths=run.path.lengths * 1e3, times=run.path.times * 1e3)
    with pytest.raises(
        fb.FreebodyError, match="The iteration of method 'gauss' does not converge for a step that ends at"
    ):
        stretched.sample(np.linspace(*stretched.times[[0, -1]], 50))


# --- radau -------------------------------------------------------------------------------------------


def test_radau_takes_long_steps_where_explicit_methods_can_not():
    arguments = {"initial": {"theta": 1.0}, "tolerance": 1e-7}
    implicit = fb.simulate(stiff_cart(), 10, method="radau", **arguments)
    explicit = fb.simulate(stiff_cart(), 10, method="dop853", **arguments)
    assert implicit.steps < 500
    assert explicit.steps > 50_000
    assert explicit.path.stiff > 10_000
    # x' is 1e-5 and less: what the stability limit leaves of it is noise of the size of the tolerance
    assert implicit.path.states[-1][:4] == pytest.approx(explicit.path.states[-1][:4], abs=1e-6)
    assert implicit.energy.relative_residual < 1e-5


def test_auto_turns_to_radau_and_only_where_it_pays():
    stiff = fb.simulate(stiff_cart(), 10, initial={"theta": 1.0})
    assert stiff.path.method == "radau"
    assert stiff.path.end == 10
    # so short a run is done before it would pay
    for tolerance, method in ((1e-6, "dop853"), (1e-9, "taylor")):
        start = {"initial": {"theta": 1.0}, "tolerance": tolerance}
        assert fb.simulate(stiff_cart(), 0.1, **start).path.method == method
        for damping in (0, 1, 100):
            assert fb.simulate(pendulum(damping), 10, **start).path.method == method


def test_auto_does_not_take_a_vibration_for_stiffness():
    """At so coarse a tolerance stability limits the steps, too; radau would stop the pendulum in a few hundred."""
    run = fb.simulate(pendulum(), 2e4, initial={"theta": 2.0}, tolerance=0.1, samples=2)
    assert run.path.method == "dop853"
    assert run.path.stiff == 0


def test_auto_takes_the_series_of_a_small_machine_from_1e_7_on():
    start = {"initial": {"theta": 1.0}}
    coarse, fine, finest = (
        fb.simulate(pendulum(), 1, tolerance=tolerance, **start) for tolerance in (2e-7, 1e-7, 2e-15)
    )
    assert [run.path.method for run in (coarse, fine, finest)] == ["dop853", "taylor", "taylor"]
    assert fine.path.states[-1] == pytest.approx(finest.path.states[-1], abs=1e-6)
    assert fb.simulate(random_system(5, 4, ("hinge",)), 0.01, tolerance=1e-10).path.method == "dop853"
    s = fb.System("friction that bends")
    block = s.body("block", fb.particle(1))
    s.slider("guide", s.ground, block, axis="x", coordinate="x")
    s.force("friction", block, ("-abs(x)*x'", 0, 0))
    assert fb.simulate(s, 1, initial={"x": 1.0}, tolerance=1e-10).path.method == "taylor"
    s.force("drag", block, ("-abs(x')*x'", 0, 0))
    assert fb.simulate(s, 1, initial={"x": 1.0}, tolerance=1e-10).path.method == "taylor"
    s.force("another", block, ("-sqrt(x'**2)*x'", 0, 0))
    assert fb.simulate(s, 1, initial={"x": 1.0}, tolerance=1e-10).path.method == "dop853"


@pytest.mark.parametrize("tolerance", [1e-5, 1e-10, 1e-14])
def test_a_series_stops_before_a_bend(tolerance):
    """A spring that pushes its end back and forth through the other one: ½ v² + ½ k (|x| - r)² is kept, and the times
    between two passes are equal."""
    start = {"x": 1.0, "x'": 4.0}
    motion = fb.simulate(rail(), 3, initial=start, tolerance=tolerance, method="taylor", events=["x"])
    assert motion.path.rejected > 0
    assert motion.energy.relative_residual < 1e3 * tolerance
    passes = np.diff([event.time for event in motion.events])
    assert len(passes) > 4 and np.ptp(passes) < 1e4 * tolerance
    end = {name: float(motion.at(3)[name]) for name in motion.names}
    back = fb.simulate(rail(), -3, initial=end, tolerance=tolerance, method="taylor").at(-3)
    assert [back["x"], back["x'"]] == pytest.approx([1.0, 4.0], abs=1e5 * tolerance)


def test_auto_sees_a_spring_whose_ends_pass_through_each_other():
    for tolerance in (1e-7, 1e-10):
        motion = fb.simulate(rail(), 3, initial={"x": 1.0}, tolerance=tolerance)
        assert motion.path.method == "dop853"
        assert motion["x"].min() < 0
        assert motion.energy.relative_residual < 1e3 * tolerance


def test_few_steps_are_rejected_where_each_is_shorter_than_the_last_by_the_same_part():
    """A comet that falls towards the sun: the error of a step is that of its length beside the distance."""
    s, e = fb.System("comet"), 0.99
    comet = s.body("comet", fb.particle(1))
    s.planar("plane", s.ground, comet, coordinate=["x", "y", "turn"])
    s.gravitation("sun", comet, parameter=1.0)
    start = {"x": 1 + e, "y'": ((1 - e) / (1 + e)) ** 0.5}
    for tolerance in (1e-6, 1e-9):
        path = fb.simulate(s, 20, initial=start, tolerance=tolerance, method="dop853").path
        assert path.rejected < 0.1 * path.steps


def gyrocompass():
    """A rotor at 24 000 rpm in a ring that is free about the vertical, on the Earth: the ring swings in seconds."""
    s = fb.System("gyrocompass")
    stand, ring = s.body("stand", fb.particle(0)), s.body("ring", fb.particle(1))
    rotor = s.body("rotor", fb.disk(2, 0.05, axis="x"))
    s.hinge("earth", s.ground, stand, axis="z", coordinate="7.292e-5*t")
    s.hinge("vertical", stand, ring, axis=(0.6, 0, 0.8), coordinate="theta")
    s.hinge("axle", ring, rotor, axis="x", coordinate="phi")
    return s


def test_auto_goes_on_without_the_series_where_a_fast_rotor_shortens_its_steps():
    start = {"theta": 0.3, "phi'": 2500.0}
    series, explicit, auto = (
        fb.simulate(gyrocompass(), 60, initial=start, method=method)
        for method in ("taylor", "dop853", "auto")
    )
    assert series.steps > 20 * explicit.steps and series.steps > 1024
    assert auto.path.method == "dop853"
    assert np.array_equal(auto.path.states, explicit.path.states)
    brief = fb.simulate(
        gyrocompass(), 5, initial=start
    )  # less than the piece after which the two are compared
    assert brief.path.method == "taylor" and brief.steps < 1024


def test_auto_keeps_to_the_series_in_a_longer_run():
    start = {"theta": 1.0, "phi'": 100.0}
    motion = fb.simulate(heavy_top(), 60, initial=start)
    assert motion.path.method == "taylor" and motion.steps > 1024
    again = fb.simulate(heavy_top(), 60, initial=start, method="taylor")
    assert np.array_equal(motion.path.states, again.path.states)


def test_an_interruption_while_two_methods_are_compared(monkeypatch):
    path = integration.Integration.path

    def interrupted(how, *arguments):
        found = path(how, *arguments)
        return replace(found, status=End.INTERRUPTED) if how.method == "dop853" else found

    monkeypatch.setattr(integration.Integration, "path", interrupted)
    motion = fb.simulate(heavy_top(), 60, initial={"theta": 1.0, "phi'": 100.0})
    assert motion.interrupted
    assert (motion.path.method, motion.steps) == ("taylor", 1024)


def test_auto_leaves_stiff_machines_to_radau_at_fine_tolerances_too():
    assert fb.simulate(stiff_cart(), 10, initial={"theta": 1.0}, tolerance=1e-10).path.method == "radau"


def test_auto_below_1e_14_is_gauss_where_no_short_series_is():
    assert fb.simulate(random_system(5, 4, ("hinge",)), 0.01, tolerance=2e-15).path.method == "gauss"


def test_explicit_method_that_runs_out_of_steps_names_the_cure():
    with pytest.raises(SimulationError, match='The machine is stiff: method="radau" takes long steps'):
        fb.simulate(stiff_cart(), 10, initial={"theta": 1.0}, method="dop853", max_steps=5000)


@pytest.mark.parametrize("make", [lambda: heavy_top("ball"), four_bar, stiff_cart])
def test_tangent_is_the_derivative_of_the_rates(make):
    """f(y + hv) - f(y - hv) over 2h, extrapolated, for a random direction."""
    kernels = kernels_of(make())
    if kernels.model.constraints:
        kernels = kernels.holding(tuple(range(2)))
    program, given = method_kernels.tangent(kernels), kernels.motion()
    parameters = kernels.parameters(kernels.model.values(None))
    rng = np.random.default_rng(4)
    n = kernels.size
    y, v = rng.uniform(0.2, 0.9, n), rng.uniform(-1, 1, n)

    def rates(y):
        return given.compiled["rates"](
            0.3, y[: kernels.model.n_q + kernels.model.n_u], given.constants(parameters)
        )

    def difference(h):
        return (rates(y + h * v) - rates(y - h * v)) / (2 * h)

    exact = program.compiled["tangent"](0.3, np.concatenate([y, v]), program.constants(parameters))
    approximate = (4 * difference(5e-4) - difference(1e-3)) / 3
    scale = 1 + np.abs(exact).max()
    assert exact / scale == pytest.approx(approximate / scale, abs=1e-9)


# --- structure ---------------------------------------------------------------------------------------


def test_the_energy_of_a_chaotic_motion_walks_less_than_any_power_of_the_step():
    """Tenths of 10⁵ steps of a double pendulum: what their medians wander, and that they are alike at 5 ms."""
    s = fb.System("double pendulum")
    s.gravity = (0, -9.81, 0)
    one, two = (s.body(name, fb.slender_bar(1, 1, axis="y")) for name in ("one", "two"))
    s.hinge("A", s.ground, one, to=(0, 0.5, 0), coordinate="p")
    s.hinge("B", one, two, at=(0, -0.5, 0), to=(0, 0.5, 0), coordinate="q")
    walk = {}
    for step in (0.014, 0.007, 0.005):
        motion = fb.simulate(s, 1e5 * step, initial={"p": 2.5, "q": 1.0}, method="structure", step=step)
        program, path = motion.kernels.motion(), motion.path
        energy = observe(program.address("energy"), 2, path.times, path.states, path.rates.constants)
        error = (energy.sum(axis=1) - energy[0].sum()) / energy[:, 0].max()
        tenths = np.array_split(error, 10)
        walk[step] = np.ptp([np.median(tenth) for tenth in tenths])
    assert walk[0.007] < walk[0.014] / 2**9  # its order is 6
    assert walk[0.005] < 1e-10
    greatest = [np.abs(tenth).max() for tenth in tenths]
    assert max(greatest) < 3 * min(greatest) < 1e-7  # each comes from a few of its fastest moments


@pytest.mark.parametrize(("name", "step"), [("heavy top", 0.01), ("ball", 0.01), ("tumbling", 0.02)])
def test_energy_stays(name, step):
    """20 000 steps: the second half of the run strays no further than the first."""
    make, start, _ = MACHINES[name]
    n = 20_000
    run = fb.simulate(make(), n * step, method="structure", step=step, samples=2001, **start)
    residual = run.energy.residual / np.abs(run.energy.total).max()
    first, second = np.abs(residual[:1000]).max(), np.abs(residual[1000:]).max()
    assert first < 1e-4
    assert second < 1.1 * first + 50 * EPS
    trend = np.polyfit(run.t, residual, 1)[0] * run.t[-1]
    assert abs(trend) < 0.05 * first + 50 * EPS


@pytest.mark.slow
def test_energy_stays_over_a_million_steps():
    make, start, _ = MACHINES["ball"]
    run = fb.simulate(make(), 1e4, method="structure", step=0.01, samples=4001, **start)
    assert run.steps == 10**6
    residual = run.energy.residual / np.abs(run.energy.total).max()
    tenths = np.abs(residual[1:]).reshape(10, 400).max(axis=1)
    assert tenths.max() < 1e-8
    assert tenths.max() < 1.2 * tenths.min()


def test_momentum_is_kept_to_round_off():
    """Quadratic invariants: angular momentum of a free body, and that of a top about the vertical."""
    s, start, _ = tumbling_body(), *MACHINES["tumbling"][1:]
    run = fb.simulate(s, 100, method="structure", step=0.05, **start)
    inertia = np.array([2 / 12 * (0.2**2 + 0.1**2), 2 / 12 * (0.3**2 + 0.1**2), 2 / 12 * (0.3**2 + 0.2**2)])
    H = np.einsum("nij,nj->ni", run.poses["box"].rotation, inertia * run.states[:, 7:10])
    # round-off of each of 2000 steps, in any direction
    assert np.abs(H - H[0]).max() / np.abs(H[0]).max() < 2000 * EPS
    ball, start, _ = heavy_top("ball"), *MACHINES["ball"][1:]
    top = fb.simulate(ball, 20, method="structure", step=0.01, **start)
    m, r, h = 1, 0.1, 0.3
    across, along = m * (3 * r**2 + h**2) / 12 + m * 0.3**2, m * r**2 / 2
    H = np.einsum(
        "nj,nj->n", top.poses["top"].rotation[:, 2, :], np.array([across, across, along]) * top.states[:, 4:7]
    )
    assert np.abs(H - H[0]).max() / np.abs(H[0]) < 2000 * EPS


@pytest.mark.parametrize("name", ["heavy top", "ball", "tumbling"])
def test_hamilton_agrees_with_the_equations_of_motion(name):
    """u computed from (q, P) along Hamilton's equations has the rate that Newton and Euler give."""
    kernels = kernels_of(MACHINES[name][0]())
    model = kernels.model
    parameters = kernels.parameters(model.values(None))
    program, given = method_kernels.hamilton(kernels), kernels.motion()
    c, d = program.constants(parameters), given.constants(parameters)
    rng = np.random.default_rng(8)
    y = rng.uniform(0.3, 0.9, model.n_q + model.n_u)
    for i in model.quaternions:
        y[i : i + 4] /= np.linalg.norm(y[i : i + 4])
    P = program.compiled["momenta"](0.0, np.concatenate([y, np.zeros(model.n_q - model.n_u)]), c)
    z = np.concatenate([y[: model.n_q], P])
    assert program.compiled["speeds"](0.0, z, c) == pytest.approx(y[model.n_q :], abs=1e-13)
    rate = program.compiled["hamilton"](0.0, z, c)
    expected = given.compiled["rates"](0.0, y, d)
    assert rate[: model.n_q] == pytest.approx(expected[: model.n_q], abs=1e-13)

    def speeds(h):
        return program.compiled["speeds"](0.0, z + h * rate, c)

    h = 1e-3
    difference = (8 * (speeds(h) - speeds(-h)) - (speeds(2 * h) - speeds(-2 * h))) / (12 * h)
    assert difference == pytest.approx(expected[model.n_q :], abs=1e-7 * (1 + np.abs(expected).max()))


def test_replaced_follows_every_operation():
    tape = Tape()
    x, y = tape.input("x"), tape.input("y")
    made = [x * y - x / y, -tape.sin(x) + tape.apply("atan2", x, y), tape.sqrt(x) + 2, 3]
    found = method_kernels.replaced(tape, made, {y: x + 1})
    values = {"x": 0.7, "y": 1.7}
    assert tape.evaluate(found, values) == pytest.approx(tape.evaluate(made, values), abs=4 * EPS)
    assert jacobian(tape, found, [y]) == [[0]] * 4


# --- taylor ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", MACHINES)
def test_taylor_agrees_with_gauss(name):
    make, start, until = MACHINES[name]
    s = make()
    gauss = fb.simulate(s, until, method="gauss", tolerance=1e-15, **start)
    for tolerance in (1e-15, 1e-16):
        series = fb.simulate(s, until, method="taylor", tolerance=tolerance, **start)
        assert series.path.method == "taylor"
        assert series.states == pytest.approx(gauss.at(series.t)._y, abs=1e-12, rel=1e-12)
        assert series.energy.relative_residual < 100 * EPS


def test_order_of_taylor_is_sixteen():
    """Also where quaternions are normalised after each step."""
    make, start, until = MACHINES["ball"]
    s = make()
    end = fb.simulate(s, until, method="gauss", tolerance=1e-15, **start).path.states[-1]
    numbers = (5, 6, 7, 8, 10, 12)
    found = errors((s, start, until, end), "taylor", numbers)
    assert found[-1] > 10 * EPS
    assert np.polyfit(np.log(numbers), np.log(found), 1)[0] == pytest.approx(-16, abs=1)


@pytest.mark.parametrize("name", ["top", "tumbling"])
def test_taylor_against_thirty_digits(name):
    """Attitudes at ten times. The coarser error grows with the step to the power 16; the finest is round-off of a
    spin of 1000 rad, or what a turn-over every 8 s amplifies of it."""
    case = pytest.importorskip("benchmarks.precision", reason="benchmarks are not in the package").CASES[
        name
    ]()
    error = {}
    for tolerance in (1e-8, 1e-11, 1e-15):
        run = fb.simulate(case.system, case.end, initial=case.initial, method="taylor", tolerance=tolerance)
        error[tolerance] = case.error(run.path.sample(case.times).T)
    assert error[1e-8] < 1e-5
    assert error[1e-11] < 3e-3 * error[1e-8]
    assert error[1e-15] < 2e-11


def test_taylor_follows_parameters_and_time():
    s = fb.System("forced")
    k, f = s.parameters(k=4.0, f=1.0)
    block = s.body("block", fb.particle(1))
    guide = s.slider("guide", s.ground, block, axis="x", coordinate="x")
    s.spring("k", guide, stiffness=k)
    s.force("push", block, ("f*exp(-t)*sin(3*t)", 0, 0))
    for values in ({}, {"k": 9.0, "f": -2.0}):
        runs = [
            fb.simulate(s, 5, start=1, values=values, initial={"x": 1.0}, method=m, tolerance=1e-14)
            for m in ("taylor", "gauss")
        ]
        assert runs[0]["x"] == pytest.approx(runs[1]["x"], abs=1e-13)
        assert runs[0].energy.relative_residual < 1e-13


def test_taylor_refuses_what_has_no_series():
    s = fb.System("dry friction")
    block = s.body("block", fb.particle(1))
    s.slider("guide", s.ground, block, axis="x", coordinate="x")
    s.parameters(k=1.0)
    s.force("friction", block, ("-k*x*abs(x')", 0, 0))
    refused(
        "Expected rates with a Taylor series.* but of 'dry friction' 'abs' has no Taylor series where it bends. "
        'Use method="dop853" or "gauss"', s, 1, method="taylor", initial={"x": 1.0}, sensitivities=["k"],
    )  # fmt: skip


def test_taylor_locates_events_and_goes_on():
    """Of the polynomial itself; a run that starts again where one stopped ends where one in one piece does."""
    s, start = pendulum(), {"theta": 1.0}
    zero = fb.event("theta", terminal=True)
    run = fb.simulate(s, 1e9, initial=start, events=zero, method="taylor", tolerance=1e-13)
    other = fb.simulate(s, 1e9, initial=start, events=zero, method="gauss", tolerance=1e-14)
    assert run.status == "terminal event"
    assert run.path.end == pytest.approx(other.path.end, abs=1e-12)
    assert abs(run.path.states[-1][0]) < 1e-14
    y = run.path.states[-1]
    rest = fb.simulate(
        s, 5, start=run.path.end, initial={"theta": y[0], "theta'": y[1]}, method="taylor", tolerance=1e-14
    )
    whole = fb.simulate(s, 5, initial=start, method="taylor", tolerance=1e-14)
    assert rest.path.states[-1] == pytest.approx(whole.path.states[-1], abs=1e-11)


def test_taylor_backwards_and_in_bounded_steps():
    s, start = pendulum(), {"theta": 2.0}
    there = fb.simulate(s, 10, initial=start, method="taylor", tolerance=1e-14)
    y = there.path.states[-1]
    back = fb.simulate(
        s, 0, start=10, initial={"theta": y[0], "theta'": y[1]}, method="taylor", tolerance=1e-14
    )
    assert back.path.states[-1] == pytest.approx([2.0, 0.0], abs=1e-11)
    short = fb.simulate(s, 10, initial=start, method="taylor", tolerance=1e-14, max_step=0.05)
    assert short.steps == 200
    assert short.path.states[-1] == pytest.approx(y, abs=1e-12)
    inside = there.at(short.t)._y
    assert short.states == pytest.approx(inside, abs=1e-11)
    assert there.path.sample(short.t, dense=True) == pytest.approx(inside, abs=1e-13)


@pytest.mark.parametrize("tolerance", [1e-6, 1e-9, 1e-12])
def test_taylor_of_a_series_with_three_of_four_terms_zero(tolerance):
    """A pendulum let go with its rod horizontal: θ - π/2 has the powers 2, 6, 10, 14, its speed 1, 5, 9, 13."""
    s = fb.System("pendulum")
    s.gravity = (0, -9.81, 0)
    s.hinge("pin", s.ground, s.body("bob", fb.particle(1)), to=(0, 1, 0), axis="z", coordinate="theta")
    run = fb.simulate(s, 10, initial={"theta": "90deg"}, method="taylor", tolerance=tolerance, samples=51)
    exact, _ = fb.exact.pendulum(np.pi / 2, np.sqrt(9.81), run.t)
    assert np.abs(run["theta"] - exact).max() < 100 * tolerance


def test_taylor_of_a_polynomial_takes_one_step():
    """A throw: the series ends, and no step is too long."""
    s = fb.System("throw")
    s.gravity = (0, -9.81, 0)
    s.planar("p", s.ground, s.body("ball", fb.sphere(1, 0.1)))
    names = list(kernels_of(s).names)
    run = fb.simulate(s, 1e3, initial={names[0]: 0.0, names[4]: 10.0}, method="taylor")
    assert run.steps == 1
    assert run.path.states[-1][1] == pytest.approx(10.0 * 1e3 - 9.81 / 2 * 1e6, rel=4 * EPS)


def test_taylor_adds_up_long_runs():
    """10 000 steps: what sums lose is kept, so that energy stays to a few units."""
    run = fb.simulate(pendulum(), 4000, initial={"theta": 1.0}, method="taylor", tolerance=1e-15, samples=2)
    assert run.steps > 10_000
    assert run.path.times[-1] == 4000
    assert run.energy.relative_residual < 50 * EPS


def test_taylor_ends_where_there_are_no_rates():
    """x'' = -1/x³ from rest falls into x = 0 at t = 1, where the steps close in on the pole."""
    s = fb.System("pole")
    block = s.body("block", fb.particle(1))
    s.slider("guide", s.ground, block, axis="x", coordinate="x")
    s.force("pull", block, ("-1/x**3", 0, 0))
    with pytest.raises(SimulationError, match="t = 1"):
        fb.simulate(s, 2, initial={"x": 1.0}, method="taylor")


def test_taylor_sees_what_stability_limits():
    """On the stiff cart, whose decay of 25 ns is over at once, its steps are as long as stability allows."""
    run = fb.simulate(stiff_cart(), 10, initial={"theta": 1}, method="taylor")
    assert run.path.stiff > 0.9 * (run.steps - 10_000)
    assert fb.simulate(heavy_top(), 2, method="taylor", **MACHINES["heavy top"][1]).path.stiff == 0


# --- refusals ----------------------------------------------------------------------------------------


def refused(message, *args, **kwargs):
    with pytest.raises(SimulationError, match=message):
        fb.simulate(*args, **kwargs)


def test_refusals():
    s = pendulum()
    refused('Expected the length of a step for method="structure", got none.*step=', s, 1, method="structure")
    refused(r"Expected a length of steps greater than 0 s, got step=-1", s, 1, method="gauss", step=-1)
    refused(
        r"Expected a length of steps greater than 0 s, got step='fine'", s, 1, method="gauss", step="fine"
    )
    refused('Expected a method for steps of one length, got step=0.1 with method="auto"', s, 1, step=0.1)
    refused(
        "Expected a machine without constraints for method=\"structure\", but 'four-bar' has 'C'.*\"gauss\"",
        four_bar(), 1, method="structure", step=0.01, **MACHINES["four-bar"][1],
    )  # fmt: skip
    refused(
        "Expected a machine whose energy is constant.*'pendulum' loads without potential", pendulum(1), 1,
        method="structure", step=0.1,
    )  # fmt: skip


def test_a_step_too_long_to_converge_is_refused():
    refused(
        "too long for its iteration to converge. A smaller step= converges", pendulum(), 100,
        initial={"theta": 2.0}, method="structure", step=5.0,
    )  # fmt: skip


def test_every_method_is_described():
    for method in set(methods()) - set(OWN):
        assert f'"{method}"' in fb.simulate.__doc__


def test_the_page_prints_what_it_says(capsys):
    page = (Path(__file__).parents[4] / "docs" / "integrators.md").read_text(encoding="utf-8")
    ((code, printed),) = re.findall(r"```python\n(.*?)```\n\n```text\n(.*?)```\n", page, re.DOTALL)
    exec(compile(code, "docs/integrators.md", "exec"), {})
    assert capsys.readouterr().out == printed
    assert all(f'"{method}"' in page for method in set(methods()) - set(OWN))


def test_model_is_compiled_for_what_is_asked_only():
    s = pendulum()
    kernels = kernels_of(s)
    fb.simulate(s, 1, initial={"theta": 1.0})
    assert "tangent" not in kernels.programs
    assert "hamilton" not in kernels.programs
    assert assemble(s).n_q == 1


# --- long runs ---------------------------------------------------------------------------------------


def test_auto_tightens_a_long_run_and_can_be_repeated():
    """40 000 steps at ε drift by that many errors; from 30 000 on "auto" takes finer ones, always at the same place.

    The steps repeat with the swings, so that their errors add up or cancel as the start decides: several are compared.
    """
    s, drift = pendulum(), {"taylor": 0.0, "auto": 0.0}
    for start in (1.2, 1.6, 2.0):
        asked = {"initial": {"theta": start}, "tolerance": 1e-9}
        tightened = fb.simulate(s, 12_000, **asked).path.times[30_000]
        for method in drift:
            motion = fb.simulate(s, 12_000, **asked, method=method, times=[0, tightened, 12_000])
            drift[method] += abs(np.diff(motion.energy.residual)[1])
            assert motion.path.method == "taylor"
    assert motion.steps > 40_000
    assert motion.path.relative[0] < 1e-9
    assert drift["auto"] < 0.5 * drift["taylor"]
    motion = fb.simulate(s, 12_000, initial={"theta": 2}, tolerance=1e-9, samples=2)
    again = fb.simulate(s, 12_000, initial={"theta": 2}, tolerance=1e-9, samples=2)
    np.testing.assert_array_equal(again.path.times, motion.path.times)
    np.testing.assert_array_equal(again.path.states, motion.path.states)


@pytest.mark.parametrize("tolerance", [1e-7, 1e-8, 1e-10])
def test_a_pole_is_no_decay(tolerance):
    """Terms of a pendulum fall as those of a decay do where its pole in complex time is nearest: it is not stiff."""
    for theta in np.linspace(1, 2.8, 10):
        motion = fb.simulate(pendulum(), 12_000, initial={"theta": theta}, tolerance=tolerance, samples=2)
        assert motion.path.method == "taylor"


def test_auto_leaves_a_short_run_alone():
    one = fb.simulate(pendulum(), 20, initial={"theta": 2})
    two = fb.simulate(pendulum(), 20, initial={"theta": 2}, method="taylor")
    np.testing.assert_array_equal(one.path.states, two.path.states)
    assert one.path.relative[0] == 1e-9


def test_a_state_between_steps_that_passed_over_a_place_without_rates():
    s = fb.System("gap")
    body = s.body("b", fb.sphere(1, 0.1))
    s.slider("rail", s.ground, body, axis="x", coordinate="x")
    s.force("F", body.origin, ("sqrt((t - 0.45)**2 - 0.0004)", 0, 0))
    motion = fb.simulate(s, 1.0, step=1.0, method="dop853", samples=2)
    with pytest.raises(
        fb.FreebodyError,
        match="rates are not finite at t = 0.45 s, between the steps of the run at 0 and 1 s",
    ):
        motion.at(0.45)
