"""Quantities of contacts as outputs and in events: what is refused, in the user's names, and the approach."""

import numpy as np
import pytest

import freebody as fb


def machine():
    s = fb.System("ball")
    s.gravity = (0, 0, -9.81)
    body = s.body("ball", fb.box(1, (0.1, 0.1, 0.1)))
    s.free("f", s.ground, body)
    s.contact("floor", body.sphere(0.05), s.ground.plane(normal="z"), friction=0.3)
    s.contacts("pile", [body.box((0.1, 0.1, 0.1)), s.ground.plane(at=(0, 0, -1), normal="z")], friction=0.3)
    return s


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("floor.mode", "Expected a number in event 'e', got the mode of contact 'floor'"),
        ("floor.force - 1", "Unknown quantity 'force' of contact 'floor' in event 'e'; .*normal"),
        ("floor.slip", "is a vector in space: name 'floor.slip.1'"),
        ("floor.slip.3", "Expected a component from 1 to 2 in event 'e', got 'floor.slip.3'"),
        ("floor.gap.1", "Expected 'floor.gap' without a component in event 'e', got 'floor.gap.1'"),
        ("floor.gap - u9", "In event 'e': Expected a known name, got 'u9'"),
        ("flor.gap", "Unknown contact 'flor'"),
        (
            "floor .gap - 0.1",
            "Expected names without blanks in event 'e', got 'floor .gap'. Write 'floor.gap'",
        ),
        ("floor.gap.x", "Expected a component by its number in event 'e', such as '.1', got 'floor.gap.x'"),
        (
            "f.force.x - 1",
            "for event 'e', got 'f.force.x', which is an output of the motion. Write it in these",
        ),
        ("pin.force - 1", "for event 'e', got 'pin.force', which is no name of this machine"),
        (
            "pile[ball,ground].gap",
            r"Expected the normal force of 'pile\[ball,ground\]' in event 'e', got 'gap': solids touch at several",
        ),
    ],
)
def test_what_no_event_watches(text, said):
    with pytest.raises(fb.errors.FreebodyError, match=said) as found:
        fb.simulate(machine(), 1, initial={"f_z": 0.2}, events=[fb.event(text, name="e")])
    assert "contact_1" not in str(found.value)


@pytest.mark.parametrize("when", ["floor.gap - 0.01", fb.event("floor.normal")])
def test_blows_are_not_called_by_them(when):
    kick = fb.blow(when, at="ball", impulse=(0, 0, 1), name="kick")
    with pytest.raises(
        fb.errors.SimulationError, match="for blow 'kick', got 'floor.*a quantity of a contact. End"
    ):
        fb.simulate(machine(), 1, initial={"f_z": 0.2}, impulses=[kick])


def test_blows_are_not_called_by_outputs():
    kick = fb.blow("f.force.x", at="ball", impulse=(0, 0, 1), name="kick")
    with pytest.raises(
        fb.errors.SimulationError, match="speeds and the time for blow 'kick', got 'f.force.x'"
    ):
        fb.simulate(machine(), 1, initial={"f_z": 0.2}, impulses=[kick])


def test_the_approach_is_an_output():
    """It is g t as the ball falls, 0 while it lies; its greatest value is that of the impact."""
    motion = fb.simulate(machine(), 0.3, initial={"f_z": 0.2})
    height = float(motion.contacts["floor"].gap[0])
    falls = motion.t < np.sqrt(2 * height / 9.81)
    assert motion["floor.approach"][falls] == pytest.approx(9.81 * motion.t[falls], abs=1e-9)
    lies = motion.contacts["floor"].mode != "open"
    assert lies.any() and not motion["floor.approach"][lies].any()
    batch = fb.simulate(machine(), 0.3, initial={"f_z": [0.2, 0.3]}, outputs="max(floor.approach)")
    assert batch["max(floor.approach)"][0] == pytest.approx(np.sqrt(2 * 9.81 * height), rel=1e-8)
    assert motion.data["floor.approach"].attrs["units"] == "m/s"
    steps = fb.simulate(machine(), 0.3, initial={"f_z": 0.2}, method="timestepping", step=1e-3)
    assert steps["floor.approach"].max() == pytest.approx(np.sqrt(2 * 9.81 * height), abs=0.02)
    assert steps["floor.approach"][-1] == 0


def test_an_unknown_contact_of_an_event():
    with pytest.raises(
        fb.errors.SimulationError,
        match=r"Unknown contact 'nosuch' in event 'nosuch.normal - 5'; known names: floor",
    ):
        fb.simulate(machine(), 0.1, initial={"f_z": 0.2}, events=[fb.event("nosuch.normal - 5")])


def test_pages_refuse_them(tmp_path):
    s = fb.System("ball")
    body = s.body("ball", fb.particle(1))
    s.slider("rail", s.ground, body, axis="y", coordinate="y")
    s.contact("floor", body.origin, s.ground.plane())
    motion = fb.simulate(s, 0.1, initial={"y": 1}, events=["floor.gap - 1"])
    with pytest.raises(
        fb.errors.SimulationError,
        match="the time, which a page watches, got 'floor.gap - 1', a quantity of a contact.*out, or live=True.",
    ):
        fb.report(s, motion, tmp_path / "page.html", live=True)


def test_an_expression_without_a_value_at_the_start_is_refused():
    with pytest.raises(
        fb.errors.SimulationError, match="expected a number for event 'e' at t = 0 s.*force or slip"
    ):
        fb.simulate(machine(), 1, initial={"f_z": 0.2}, events=[fb.event("1/floor.normal", name="e")])


@pytest.mark.parametrize("how", [{}, {"method": "timestepping", "step": 1e-3}])
def test_the_approach_is_the_rate_of_the_distance(how):
    """Beyond the ends of a side it is that of the corner, for a point there is none; of pairs in a family, too."""
    s = fb.System("past a ledge")
    ball = s.body("ball", fb.sphere(1, 0.1))
    s.planar("p", s.ground, ball, coordinate="x y turn")
    side = s.ground.segment((-1, 0, 0), (0, 0, 0), normal="y")
    s.contact("round", ball.sphere(0.1), side)
    s.contact("point", ball.origin, side)
    s.contact("road", ball.sphere(0.05), s.ground.heightline("0*x + 0.1*x", between=(-1, 0)))
    motion = fb.simulate(s, 0.6, initial={"x": -0.5, "y": 0.4, "x'": 1.5, "y'": -0.4, "turn'": 3}, **how)
    assert {one.mode for one in motion.modes} <= {"open"}
    t, x = motion.t, motion["x"]
    for name in ("round", "point", "road"):
        gap, approach = motion.contacts[name].gap, motion.contacts[name].approach
        known = np.isfinite(gap)
        assert (known == np.isfinite(approach)).all() and known.all() == (name != "point")
        if name == "point":
            assert (known == (x <= 0)).all()
        rate = np.gradient(gap[known], t[known])
        assert np.median(np.abs(rate + approach[known])) < 1e-4


def test_the_approach_of_pairs():
    """In patches by events, and in a family in time steps."""
    s = fb.System("boxes")
    s.gravity = (0, 0, -9.81)
    body = s.body("ball", fb.box(1, (0.1, 0.1, 0.1)))
    s.free("f", s.ground, body)
    shapes = [body.box((0.1, 0.1, 0.1)), s.ground.box((1, 1, 0.1), at=(0, 0, -0.1))]
    s.contacts("pile", shapes, friction=0.3)
    for how, near in (({}, 1e-9), ({"method": "timestepping", "step": 1e-3}, 1e-2)):
        motion = fb.simulate(s, 0.05, initial={"f_z": 0.3, "f_vz": -0.5}, **how)
        expected = 0.5 + 9.81 * motion.t
        assert motion["pile[ball,ground].approach"] == pytest.approx(expected, abs=near)


def test_the_gap_of_a_small_box_over_a_large_one():
    """The faces that face each other separate them equally; no corner of the large one lies over the small one."""
    s = fb.System("boxes")
    body = s.body("ball", fb.box(1, (0.1, 0.1, 0.1)))
    s.free("f", s.ground, body)
    small, large = body.box((0.1, 0.1, 0.1)), s.ground.box((1, 1, 0.1))
    s.contacts("first", [small, large])
    s.contacts("second", [large, small])
    for x in (0, 0.013, 0.44):
        motion = fb.simulate(s, 0.001, initial={"f_x": x, "f_z": 0.3})
        for name in ("first[ball,ground]", "second[ground,ball]"):
            assert motion[f"{name}.gap"][0] == pytest.approx(0.2, abs=1e-12)
