"""A second call is what it would be alone, whatever changed since the first ."""

import copy
import pickle

import numpy as np
import pytest
import sympy
import xarray

import freebody as fb
from freebody.describe.description import take_as_positive
from freebody.errors import FreebodyError, SimulationError
from freebody.motion.kernels.kernels import kernels_of


def oscillator():
    """m x'' = -k x - c x', of which the damper does work."""
    s = fb.System("oscillator")
    m, k, c = s.parameters(m=1.0, k=4.0, c=0.0)
    s.assume(k > 0)
    mass = s.body("mass", fb.particle(m))
    rail = s.slider("rail", s.ground, mass, axis="x", coordinate="x")
    s.spring("spring", rail, stiffness=k)
    s.damper("damper", rail, damping=c)
    return s


def spun():
    s = fb.System("spun")
    s.ball("joint", s.ground, s.body("body", fb.box(1, (0.1, 0.2, 0.3))), coordinate="turn")
    return s


USUAL = {"initial": {"x": 1.0}, "values": {"c": 0.25}, "events": ["x"]}


def same(a, b):
    return (
        all(np.array_equal(getattr(a.path, name), getattr(b.path, name)) for name in ("times", "states"))
        and [e.time for e in a.events] == [e.time for e in b.events]
        and (a.values, a.status, a.path.method) == (b.values, b.status, b.path.method)
        and np.array_equal(a.t, b.t)
    )


@pytest.fixture
def used():
    """A system that has run once."""
    s = oscillator()
    fb.simulate(s, 3, **USUAL)
    return s


@pytest.mark.parametrize(
    "until, changed",
    [
        (3, {}),
        (2.0, {}),
        ("3*m", {}),
        (3, {"initial": {"x": 0.5, "x'": 2}}),
        (3, {"initial": {"x": "1/2"}}),
        (3, {"initial": {}}),
        (3, {"initial": None}),
        (3, {"values": {"c": 0.5}}),
        (3, {"values": {"k": 9}}),
        (3, {"values": {"c": "0.25 kg/s"}}),
        (3, {"values": None}),
        (3, {"values": {}}),
        (3, {"events": ["x'"]}),
        (3, {"events": "x"}),
        (3, {"events": [fb.event("x", direction=1, terminal=True)]}),
        (3, {"events": ()}),
        (3, {"tolerance": 1e-6}),
        (3, {"tolerance": {"x": 1e-6}}),
        (3, {"method": "dop853"}),
        (3, {"method": "dop853", "step": 0.01}),
        (3, {"samples": 7}),
        (3, {"times": [0, 1, 2]}),
        (3, {"times": (0, np.array(1.0), 2)}),
        (3, {"impulses": []}),
        (sympy.Integer(2), {"start": np.float64(1)}),
        (3, {"start": 1}),
        (3, {"max_step": 0.01}),
        (3, {"max_steps": 1000}),
        (3, {"impulses": [fb.blow(1, at="mass", impulse=(1, 0, 0))]}),
        (3, {"progress": abs}),
    ],
    ids=str,
)
def test_another_call_is_as_it_would_be_alone(used, until, changed):
    arguments = USUAL | changed
    if changed.get("impulses"):
        arguments["impulses"] = [fb.blow(1, at=used.bodies["mass"].origin, impulse=(1, 0, 0))]
    again = [fb.simulate(used, until, **arguments) for _ in range(2)]
    usual = fb.simulate(used, 3, **USUAL)
    other = oscillator()
    if changed.get("impulses"):
        arguments["impulses"] = [fb.blow(1, at=other.bodies["mass"].origin, impulse=(1, 0, 0))]
    alone = fb.simulate(other, until, **arguments)
    assert all(same(one, alone) for one in again)
    assert same(usual, fb.simulate(oscillator(), 3, **USUAL))


def test_quaternions_and_rotations_of_a_second_run():
    s, speeds = spun(), {"turn_wx": 0.1, "turn_wy": 2.0}
    fb.simulate(s, 1, initial=speeds)
    for turned in ([0, 3, 0, 4], fb.Rotation.axis_angle("z", 0.5), {"turn_e0": 1, "turn_e1": 1}):
        more = turned if isinstance(turned, dict) else {"joint": turned}
        again, alone = (fb.simulate(one, 1, initial={**speeds, **more}) for one in (s, spun()))
        assert same(again, alone)
        assert np.linalg.norm(again.path.states[:, :4], axis=1) == pytest.approx(1, abs=1e-15)


def test_texts_of_a_start_are_read_as_at_first():
    s = oscillator()
    for start in (
        {"x": "1/3", "x'": "2*k"},
        {"x'": "1/3", "x": "2*k"},
        {"x": "2*k"},
        {"x": "1/4", "x'": "1/3"},
    ):
        for more in ({}, {"values": {"k": 9}}):
            alone = fb.simulate(oscillator(), 1, initial=start, **more)
            assert all(same(fb.simulate(s, 1, initial=start, **more), alone) for _ in range(3))
    with pytest.raises(FreebodyError, match="Expected a known name"):
        fb.simulate(s, 1, initial={"x": "1/4", "x'": "w"})


def test_what_the_user_changes_in_place_is_read_again(used):
    initial, values, events = {"x": 1.0}, {"c": 0.25}, ["x"]
    tolerance, times = {"x": 1e-9}, np.array([0.0, 1.0])

    def run(s, **more):
        return fb.simulate(s, 3, initial=initial, values=values, events=events, **more)

    run(used), run(used, tolerance=tolerance, times=times)
    first = run(used)
    initial["x"], values["c"], tolerance["x"], times[1] = 2.0, 0.75, 1e-5, 2.0
    events.append("x'")
    assert same(run(used), run(oscillator()))
    assert same(
        run(used, tolerance=tolerance, times=times), run(oscillator(), tolerance=tolerance, times=times)
    )
    assert first.values["c"] == 0.25
    assert same(first, fb.simulate(oscillator(), 3, **USUAL))


def test_what_is_done_to_a_motion_does_not_reach_the_next(used):
    first = fb.simulate(used, 3, **USUAL)
    first.values["k"] = 100.0
    first.path.states[:] = 0
    assert same(fb.simulate(used, 3, **USUAL), fb.simulate(oscillator(), 3, **USUAL))


def test_a_system_that_changes_is_followed(used):
    def changed(s):
        s.gravity = (9.81, 0, 0)
        yield
        s.force("push", s.bodies["mass"], (2, 0, 0))
        yield
        s.parameters(k2=0.0)
        yield

    others = oscillator()
    for _ in zip(changed(used), changed(others), strict=True):
        assert same(fb.simulate(used, 3, **USUAL), fb.simulate(others, 3, **USUAL))
    used.assume(used.expression("c - 1") > 0)
    with pytest.raises(FreebodyError, match="c - 1 > 0"):
        fb.simulate(used, 3, **USUAL)


@pytest.mark.parametrize(
    "changed",
    [
        {"values": {"c": np.array([0.25, 0.5])}},
        {"initial": {"x": [1.0, 2.0]}},
        {"outputs": "x"},
    ],
    ids=str,
)
def test_lanes_after_a_single_run(used, changed):
    arguments = {key: value for key, value in (USUAL | changed).items() if key != "events"}
    fb.simulate(used, 3, initial={"x": 1.0}, values={"c": 0.25})
    lanes = fb.simulate(used, 3, **arguments)
    assert isinstance(lanes, xarray.Dataset) and np.isfinite(lanes["x"].values).all()
    assert lanes.identical(fb.simulate(oscillator(), 3, **arguments))


@pytest.mark.parametrize(
    "until, changed, message",
    [
        (3, {"initial": {"y": 1.0}}, "Unknown name 'y' in initial"),
        (3, {"initial": {"x": float("nan")}}, "initial value of 'x': Expected a finite number"),
        (3, {"initial": [1.0]}, "Expected initial values by name"),
        (3, {"initial": []}, "Expected initial values by name"),
        (3, {"near": ""}, "Expected near values by name"),
        (3, {"project": None}, "Expected project=True or False"),
        (3, {"initial": {"x": "w"}}, "Expected a known name, got 'w'"),
        (3, {"values": {"q": 1.0}}, "Unknown parameter 'q'"),
        (3, {"values": {"m": -1.0}}, "Expected m not to be negative"),
        (3, {"values": {"k": -4.0}}, "k > 0"),
        (3, {"values": {"c": True}}, "Expected a number or an expression, got True"),
        (3, {"values": [1.0]}, "Expected values of parameters by name"),
        (True, {}, "In until: Expected a number or an expression, got True"),
        (float("inf"), {}, "In until: Expected a finite number"),
        (3, {"tolerance": True}, "Expected a tolerance between"),
        (3, {"tolerance": 2}, "Expected a tolerance between"),
        (3, {"samples": True}, "Expected a number of samples"),
        (3, {"samples": 5, "times": [1]}, "Expected times= or samples="),
        (3, {"max_steps": 2}, "max_steps = 2 steps reached only"),
        (3, {"near": {"x": 1.0}}, "Expected a machine with constraints for near="),
        (3, {"threads": 2}, "Expected several motions for threads="),
        (3, {"progress": "yes"}, "Expected True, False, or a function"),
        (3, {"events": {"x": 0}}, "Expected a list of fb.event"),
        (3, {"method": "euler"}, "Unknown method 'euler'"),
    ],
    ids=str,
)
def test_what_is_refused_is_refused_after_a_run_too(used, until, changed, message):
    for s in (oscillator(), used, used):
        with pytest.raises(FreebodyError, match=message):
            fb.simulate(s, until, **USUAL | changed)
    assert same(fb.simulate(used, 3, **USUAL), fb.simulate(oscillator(), 3, **USUAL))


def test_a_run_that_fails_fails_again():
    s = fb.System("runaway")
    s.slider("rail", s.ground, s.body("mass", fb.particle(1)), axis="x", coordinate="x")
    s.generalized_force("x", "x'^2")
    for _ in range(2):
        with pytest.raises(SimulationError, match="cannot be continued") as found:
            fb.simulate(s, 2, initial={"x'": 1.0})
        assert found.value.trajectory.path.end == pytest.approx(1, abs=1e-6)
    assert fb.simulate(s, 2, initial={"x'": 0.25}).at(2)["x'"] == pytest.approx(0.5, rel=1e-7)


# --- with constraints ------------------------------------------------------------------------------


def four_bar():
    s = fb.System("four-bar")
    s.gravity = (0, -9.81, 0)
    lengths = {"crank": 1, "rod": 2, "rocker": 1.5}
    crank, rod, rocker = (s.body(name, fb.slender_bar(x, x)) for name, x in lengths.items())
    s.hinge("A", s.ground, crank, to=(-0.5, 0, 0), coordinate="a")
    s.hinge("B", crank, rod, at=(0.5, 0, 0), to=(-1, 0, 0), coordinate="b")
    s.hinge("D", s.ground, rocker, at=(2, 0, 0), to=(-0.75, 0, 0), coordinate="d")
    s.hinge("C", rocker, rod, at=(0.75, 0, 0), to=(1, 0, 0))
    return s


def test_another_start_of_a_loop_is_closed_as_it_would_be_alone():
    s, near = four_bar(), {"b": 0.4, "d": 0.9}
    for start in (
        {"initial": {"a": 0.3}, "near": near},
        {"initial": {"a": 0.9, "a'": 1.0}, "near": near},
        {"initial": {"a": "1/2"}, "near": {"b": -0.4, "d": -0.9}},
        {"initial": {"a": 0.3, "b": 0.4, "d": 0.9}, "project": True},
    ):
        again, alone = (fb.simulate(one, 0.5, **start) for one in (s, four_bar()))
        assert same(again, alone)
    for _ in range(2):
        with pytest.raises(SimulationError, match="constraint"):
            fb.simulate(s, 0.5, initial={"a": 0.3, "b": 0.4, "d": 0.9})
        with pytest.raises(SimulationError, match="Unknown name 'e' in near"):
            fb.simulate(s, 0.5, initial={"a": 0.3}, near={"e": 0.4})
    assert "lane" in fb.simulate(s, 0.5, initial={"a": [0.3, 0.5]}, near=near).dims


def test_a_loop_that_begins_with_other_conditions():
    """A parallelogram in line has one independent condition less than beside that position."""

    def parallelogram():
        s = fb.System("parallelogram")
        one, rod, two = (s.body(name, fb.slender_bar(1, 1)) for name in ("one", "rod", "two"))
        s.hinge("A", s.ground, one, to=(-0.5, 0, 0), coordinate="a")
        s.hinge("B", one, rod, at=(0.5, 0, 0), to=(-0.5, 0, 0), coordinate="b")
        s.hinge("D", s.ground, two, at=(1, 0, 0), to=(-0.5, 0, 0), coordinate="d")
        s.hinge("C", two, rod, at=(0.5, 0, 0), to=(0.5, 0, 0))
        return s

    s = parallelogram()
    beside = {"initial": {"a": 1.0, "a'": 0.5}, "near": {"b": -1.0, "d": 1.0}}
    fb.simulate(s, 0.1, **beside)
    for one in (s, parallelogram()):
        with pytest.raises(SimulationError, match="followed from the others at the start"):
            fb.simulate(one, 0.1, initial={"a": 0.0, "a'": 0.5})
    assert same(fb.simulate(s, 0.1, **beside), fb.simulate(parallelogram(), 0.1, **beside))


# --- what a description consists of ----------------------------------------------------------------


@pytest.mark.parametrize(
    "change",
    [
        lambda s: s.loads.pop("damper"),
        lambda s: s.loads.popitem(),
        lambda s: s.loads.clear(),
        lambda s: s.loads.update(damper=s.loads["spring"]),
        lambda s: s.loads.__ior__({"damper": s.loads["spring"]}),
        lambda s: s.loads.__delitem__("damper"),
        lambda s: s.loads.setdefault("third", s.loads["spring"]),
        lambda s: s.describe("x", unit="m"),
        lambda s: take_as_positive(s, s.expression("c")),
        lambda s: setattr(s, "gravity", (1, 0, 0)),
        lambda s: s.parameters(new=1.0),
        lambda s: s.body("new", fb.particle(1)),
    ],
)
def test_every_change_of_a_description_is_noticed(used, change):
    before = kernels_of(used)
    assert kernels_of(used) is before
    change(used)
    try:
        assert kernels_of(used) is not before
    except FreebodyError as error:  # a body that no joint holds
        assert "new" in str(error)


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda s: pickle.loads(pickle.dumps(s))])
def test_a_copy_of_a_system_is_followed_on_its_own(used, copied):
    other = copied(used)
    before = kernels_of(other), kernels_of(used)
    other.gravity = (1, 0, 0)
    other.loads.pop("damper")
    assert kernels_of(used) is before[1]
    assert kernels_of(other) is not before[0]
    assert list(used.loads) == ["spring", "damper"] and list(other.loads) == ["spring"]
