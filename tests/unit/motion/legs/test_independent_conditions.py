"""Conditions that take over from others on the way."""

import math

import numpy as np
import pytest

import freebody as fb
from freebody.dynamics.conditions.constraints import residuals
from freebody.dynamics.state import float_state
from freebody.errors import SimulationError
from freebody.motion.kernels.kernels import kernels_of

ALPHA, BETA = 0.6, 1.1
STARTS = (0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2)


def bennett(scale=1.0):
    """Bennett's linkage: bars a and b, a sin β = b sin α; five conditions close it, of which two are independent."""
    s = fb.System("bennett")
    s.gravity = (0, 0, -9.81)
    a = scale
    b = a * math.sin(BETA) / math.sin(ALPHA)

    def twisted(angle):
        c, x = math.cos(angle), math.sin(angle)
        return ((1, 0, 0), (0, c, -x), (0, x, c))

    first, middle, last = (
        s.body(name, fb.slender_bar(1, L, axis="x")) for name, L in (("p", a), ("q", b), ("r", a))
    )
    s.hinge("A", s.ground, first, to=(-a / 2, 0, 0), coordinate="f")
    s.hinge(
        "B", first, middle, at=(a / 2, 0, 0), to=(-b / 2, 0, 0), parent_axes=twisted(ALPHA), coordinate="g"
    )
    s.hinge("C", middle, last, at=(b / 2, 0, 0), to=(-a / 2, 0, 0), parent_axes=twisted(BETA), coordinate="h")
    s.hinge(
        "D", s.ground, last, at=(-b, 0, 0), to=(a / 2, 0, 0), parent_axes=twisted(-BETA), child_axes=twisted(ALPHA)
    )  # fmt: skip
    return s


def turning(s, start=0.5, until=6, speed=1, **options):
    return fb.simulate(
        s, until, initial={"f": start, "f'": speed}, near={"g": 2, "h": 2}, **{"tolerance": 1e-10, **options}
    )


@pytest.fixture(scope="module")
def linkage():
    return bennett()


def gaps(s, motion):
    model = kernels_of(s).model
    n = model.n_q
    return max(
        abs(x)
        for y in motion.states
        for x in residuals(model, float_state(model, y[:n].tolist(), y[n : 2 * n].tolist(), 0, motion.values))
    )


@pytest.mark.parametrize("method", ["dop853", "gauss", "radau", "taylor"])
@pytest.mark.parametrize("start", STARTS)
def test_a_linkage_goes_on_where_others_take_over(linkage, method, start):
    motion = turning(linkage, start, method=method, samples=200)
    assert motion.status == "finished"
    assert gaps(linkage, motion) < 1e-8  # LOOSE times the tolerance
    assert motion.energy.relative_residual < 1e-8


def test_bennetts_relation_holds(linkage):
    """tan(θ1/2) tan(θ2/2) = sin((β + α)/2) / sin((β - α)/2), θ2 = π - g as g is counted here."""
    motion = turning(linkage, samples=300)
    f, g = motion["f"] / 2, (math.pi - motion["g"]) / 2
    ratio = math.sin((BETA + ALPHA) / 2) / math.sin((BETA - ALPHA) / 2)
    missed = np.sin(f) * np.cos(g) - ratio * np.cos(f) * np.sin(g)
    assert np.abs(missed).max() < 1e-8


def test_it_agrees_with_a_run_begun_again_by_hand(linkage):
    whole = turning(linkage, until=4)
    first = turning(linkage, until=0.95)
    rest = fb.simulate(linkage, 4, start=0.95, initial=first.at(0.95), project=True, tolerance=1e-10)
    for name in whole.names:
        assert rest.at(4)[name] == pytest.approx(whole.at(4)[name], abs=1e-8)


def test_what_took_over_is_told(linkage):
    motion = turning(linkage, until=1.8, events=["f"])
    told = [str(event) for event in motion.events]
    assert told[0].endswith("s: D_z holds the machine in place of D_x")
    assert any("f: falls through zero" in text for text in told)
    assert len(motion.path.crossings) == 1
    change = motion.happenings[0]
    assert change.name == "D_z"
    assert all(abs(change.after[name] - x) < 1e-8 for name, x in change.state.items())


def test_forces_are_those_of_the_conditions_that_hold(linkage):
    motion = turning(linkage, until=1.8)
    (first, *_) = motion.happenings
    before, after = motion.t < first.time, motion.t > first.time
    carried = motion.multipliers
    assert np.all(carried["D_z"][before] == 0) and np.all(carried["D_x"][after] == 0)
    assert np.all(carried["D_x"][before] != 0)
    # the bar "p" obeys Newton's law on either side: m a = weight + A - B
    t, h = motion.t, 1e-4
    for moment in (first.time - 0.02, first.time + 0.02, 1.5):
        k = int(np.argmin(np.abs(t - moment)))
        where = motion.at([t[k] - h, t[k], t[k] + h])
        x = np.array([[math.cos(f) / 2, math.sin(f) / 2, 0] for f in where["f"]])
        a = (x[0] - 2 * x[1] + x[2]) / h**2
        force = motion.reactions["A"].force[k] - motion.reactions["B"].force[k] + [0, 0, -9.81]
        assert force == pytest.approx(a, abs=1e-4 * np.abs(motion.reactions["A"].force[k]).max())


def test_small_and_large_linkages_change_at_the_same_places():
    """Conditions of lengths are compared with each other, those of angles with each other: in metres or millimetres."""
    places, near = [], {"g": 2, "h": 2}
    for scale in (1.0, 1e-3):
        s = bennett(scale)
        s.gravity = (0, 0, -9.81 * scale)
        motion = fb.simulate(s, 3, initial={"f": 0.5, "f'": 1}, near=near, tolerance=1e-9)
        near = motion.at(0)
        places.append([(one.name, round(one.state["f"], 2)) for one in motion.happenings])
    assert places[0] == places[1]


def test_a_sampled_controller_and_a_blow_on_the_way():
    """Each stretch between samples, and what follows a blow, goes on with the conditions that hold by then."""
    s = bennett()
    s.parameters(tau=0.0)
    s.torque("motor", s.joints["A"], "tau")
    s.controller(lambda t, x: -0.5 * x["f'"], 0.05, "tau", name="brake")
    tip = s.bodies["p"].point(0.5, 0, 0)
    hit = fb.blow(1.4, at=tip, impulse=(0, 0.5, 0), name="hit")
    motion = turning(s, until=3, impulses=[hit], tolerance=1e-9)
    assert [one.name for one in motion.happenings][:3] == ["D_z", "hit", "D_Mx"]
    assert gaps(s, motion) < 1e-7
    assert motion.energy.relative_residual < 1e-7


def test_lanes_are_the_runs_alone(linkage):
    starts = np.array(STARTS[:4])
    data = fb.simulate(
        linkage, 3, initial={"f": starts, "f'": 1}, near={"g": 2, "h": 2}, tolerance=1e-10, times=[0, 1.5, 3],
        outputs=["f", "h", "max(f)"],
    )  # fmt: skip
    assert data.status.values.tolist() == ["finished"] * 4
    for lane, start in enumerate(starts):
        alone = turning(linkage, start, until=3, times=[0, 1.5, 3])
        assert data.f.values[lane].tolist() == alone["f"].tolist()
        assert data.h.values[lane].tolist() == alone["h"].tolist()


def test_lanes_that_begin_on_other_conditions(linkage):
    """At f = 0 the condition D_x holds nothing: that lane begins with others."""
    data = fb.simulate(
        linkage, 1, initial={"f": [0.8, 1e-6], "f'": 1}, near={"g": 2, "h": 2}, tolerance=1e-10, outputs=["f"]
    )
    assert data.status.values.tolist() == ["finished", "finished"]


def test_derivatives_do_not_follow(linkage):
    text = (
        "'D_x', active from the start, becomes dependent on other conditions there, and 'D_z' must take over"
    )
    with pytest.raises(SimulationError, match=text):
        turning(linkage, until=3, sensitivities=["f"])


def test_a_flat_parallelogram_is_passed_straight():
    """Three cranks carry one coupler; where all lie in line, a step of the run passes over and they turn on alike."""
    s = fb.System("cranks")
    s.gravity = (0, -9.81, 0)
    coupler = None
    for k in range(3):
        rod = s.body(f"rod{k}", fb.slender_bar(1, 1, axis="x"))
        s.hinge(f"A{k}", s.ground, rod, at=(2 * k, 0, 0), to=(-0.5, 0, 0), coordinate=f"f{k}")
        coupler = coupler or s.body("coupler", fb.slender_bar(1, 4, axis="x"))
        more = {"coordinate": "g"} if k == 0 else {}
        s.hinge(f"B{k}", rod, coupler, at=(0.5, 0, 0), to=(2 * k - 2, 0, 0), **more)
    near = {"g": -1, "f1": 1, "f2": 1}
    motion = fb.simulate(s, 3, initial={"f0": 1, "f0'": 8}, near=near, tolerance=1e-10)
    assert motion["f0"][-1] > 4 * math.pi  # twice around
    for name in ("f1", "f2"):
        assert motion[name] == pytest.approx(motion["f0"], abs=1e-9)
    assert motion.energy.relative_residual < 1e-8


def test_a_start_beside_a_place_where_a_condition_holds_nothing(linkage):
    """At f = 0.004 D_x is a 250th of D_z: independent, but not to be held by."""
    motion = turning(linkage, 0.004, until=1)
    assert motion.happenings[0].time == 0.0
    assert gaps(linkage, motion) < 1e-8
    assert motion.energy.relative_residual < 1e-8


def test_conditions_that_vanish_are_named_where_a_run_ends() -> None:
    """Bars in line: along them no condition holds, however their rows are scaled; beside the line all do."""
    from freebody.dynamics.state import float_state
    from freebody.motion.start.loop_closure import nearly_dependent

    s = fb.System("parallelogram")
    bars = [s.body(name, fb.slender_bar(1, 1, axis="x")) for name in "lr"]
    coupler = s.body("coupler", fb.slender_bar(1, 2, axis="x"))
    for bar, x in zip(bars, (0, 2), strict=True):
        s.hinge(f"A{bar.name}", s.ground, bar, at=(x, 0, 0), to=(-0.5, 0, 0), axis="z", coordinate=bar.name)
    s.hinge("B", bars[0], coupler, at=(0.5, 0, 0), to=(-1, 0, 0), axis="z", coordinate="c")
    s.hinge("C", coupler, bars[1], at=(1, 0, 0), to=(0.5, 0, 0), axis="z")
    model = fb.assemble(s)
    for angle, found in ((0.8, ()), (1e-8, ("C_x",))):
        state = float_state(model, [angle, angle, -angle], [0, 0, 0], 0, {})
        assert nearly_dependent(model, state, (0, 1)) == found
