"""Belts: Newton's equations of each pulley by hand, energy, free bodies on a moving carrier, files, refusals."""

# ruff: noqa: E501 (tables: one case, one line)

from __future__ import annotations

import numpy as np
import pytest
import sympy

import freebody as fb
from freebody.errors import ModelError
from page_data import scene_of

from ....laws.test_laws_free_bodies import check, on_a_motion

EPS = np.finfo(float).eps
EXACT = 2**12 * EPS
R1, R2, K, T0, D = 0.1, 0.3, 2000.0, 100.0, 0.8


def pulleys(run="open", second="z", **given):
    s = fb.System("belt")
    small, large = s.body("small", fb.disk(1, R1)), s.body("large", fb.disk(9, R2))
    one = s.hinge("one", s.ground, small, coordinate="p")
    two = s.hinge("two", s.ground, large, at=(D, 0, 0), axis=second, coordinate="q")
    radii = given.pop("radii", (R1, R2))
    options = {"stiffness": K, "tension": T0, "run": run} | given
    s.belt("belt", (one, radii[0]), (two, radii[1]), **options)
    return s


@pytest.mark.parametrize("run", ["open", "crossed"])
@pytest.mark.parametrize("second", ["z", "-z"])
def test_each_pulley_by_hand(run, second):
    """I y'' = r (T_2 - T_1) and its like; the bearings hold both tensions, at the angle of the spans."""
    program = fb.compile(pulleys(run, second, damping=3))
    p, q, rates = 0.02, 0.013, (0.4, -0.3)
    sense, turned = (1 if run == "open" else -1), (1 if second == "z" else -1)
    x = R1 * p - sense * turned * R2 * q
    rate = R1 * rates[0] - sense * turned * R2 * rates[1]
    T1, T2 = T0 + K * x + 3 * rate, T0 - K * x - 3 * rate
    expected = [R1 * (T2 - T1) / (R1**2 / 2), turned * sense * R2 * (T1 - T2) / (9 * R2**2 / 2)]
    np.testing.assert_allclose(program.forward_dynamics([p, q], rates), expected, rtol=1e-12)
    sine = (R1 - sense * R2) / D
    pull = np.array([(T1 + T2) * np.sqrt(1 - sine**2), (T2 - T1) * sine, 0])
    found = program.reactions([p, q], rates)
    np.testing.assert_allclose(found["one"].force, -pull, rtol=0, atol=1e-12 * T0)
    np.testing.assert_allclose(found["two"].force, pull, rtol=0, atol=1e-12 * T0)


def test_a_slack_span_pulls_nothing():
    program = fb.compile(pulleys())
    force = program.reactions([1.0, 0.0], [0, 0])["one"].force
    T1 = T0 + K * R1
    sine = (R1 - R2) / D
    np.testing.assert_allclose(force, [-T1 * np.sqrt(1 - sine**2), T1 * sine, 0], rtol=0, atol=1e-12 * T1)


def test_energy_of_a_belt_with_spans_that_go_slack():
    motion = fb.simulate(pulleys(tension=2), until=0.5, initial={"p'": 40.0}, tolerance=1e-11)
    assert motion.events
    assert np.abs(motion["energy_residual"]).max() < 1e-6


def carried(run):
    """Pulleys on an arm that turns and slides, with mass centres off their axes."""
    s = fb.System("belt on an arm")
    s.gravity = (0, -9, 1)
    arm, one, two = (
        s.body("arm", fb.box(2, (1, 2, 3))),
        s.body("one", fb.box(1, (1, 2, 1))),
        s.body("two", fb.disk(3, 1)),
    )
    s.hinge("base", s.ground, arm, to=(1, 0, 0), coordinate="a")
    first = s.hinge("first", arm, one, to=(0, 1, 0), coordinate="p")
    second = s.hinge("second", arm, two, at=(0, 5, 0), coordinate="q")
    s.belt("belt", (first, 1), (second, 1), stiffness=2, tension=500, run=run)
    return s


@pytest.mark.parametrize("run", ["open", "crossed"])
def test_six_equations_of_every_body(run):
    eq, values, condition = on_a_motion(carried(run), 4)
    check(eq, values, EXACT * condition)
    assert {"belt_1", "belt_2"} & {a.name for a in eq.free_body("one").actions} or "belt" in str(
        eq.free_body("one")
    )


def test_round_trip(tmp_path):
    s = pulleys("crossed", damping=2)
    fb.write(s, tmp_path / "belt.toml")
    again = fb.read(tmp_path / "belt.toml")
    assert again.loads["belt"].run == "crossed"
    q = [0.1, 0.2]
    np.testing.assert_array_equal(
        fb.compile(again).forward_dynamics(q, q), fb.compile(s).forward_dynamics(q, q)
    )


def test_a_belt_is_drawn():
    assert 'data-load="belt"' in fb.draw(pulleys()).svg


CASES = [
    ({"run": "twisted"}, "Expected run='open' or run='crossed' of belt 'belt', got 'twisted'."),
    ({"radii": (0.5, 0.4)}, "The pulleys of belt 'belt' overlap: the distance of their axes is 4/5. Move them apart."),
    ({"second": "x"}, "Belt 'belt' runs in one plane, so the axes of 'one' and 'two' must be parallel, and their points in one plane across them. Move at= of one of them."),
]  # fmt: skip


@pytest.mark.parametrize(("given", "words"), CASES, ids=range(len(CASES)))
def test_refusals(given, words):
    with pytest.raises(ModelError) as error:
        fb.assemble(pulleys(**given if given.get("radii") != (0.5, 0.4) else {"run": "crossed", **given}))
    assert words in str(error.value)


@pytest.mark.parametrize("stiffness", [None, float("inf"), sympy.oo])
def test_a_rigid_belt_is_refused_with_the_cure(stiffness):
    s = pulleys()
    with pytest.raises(ModelError) as error:
        s.belt("rigid", (s.joints["one"], R1), (s.joints["two"], R2), stiffness=stiffness)
    for words in (
        "stiffness of each span of belt 'rigid'",
        "does not determine its two tensions",
        "s.constrain",
    ):
        assert words in str(error.value)
    with pytest.raises(ModelError, match=r"Expected a stiffness greater than 0 N/m of belt 'rigid', got 0"):
        s.belt("rigid", (s.joints["one"], R1), (s.joints["two"], R2), stiffness=0)


def test_pulleys_on_other_joints_or_other_bodies():
    s = pulleys()
    rail = s.slider("rail", s.ground, s.body("cart", fb.particle(1)))
    on_cart = s.hinge("on", s.bodies["cart"], s.body("wheel", fb.disk(1, 1)))
    for joint, words in (
        (rail, "Belt 'b' runs around pulleys on hinges, but 'rail' is a slider. Put the pulley on a hinge."),
        (on_cart, "Belt 'b' runs around two pulleys whose hinges stand in one body; 'one' stands in 'ground' and 'on' in 'cart'. Join them so."),
    ):  # fmt: skip
        with pytest.raises(ModelError) as error:
            s.belt("b", (s.joints["one"], 1), (joint, 1), stiffness=1)
        assert words in str(error.value)
    with pytest.raises(
        ModelError, match=r"Expected a pulley of belt 'b' as \(hinge, radius\), got hinge 'one'"
    ):
        s.belt("b", s.joints["one"], (rail, 1), stiffness=1)


@pytest.mark.parametrize(("run", "sense"), [("open", 1), ("crossed", -1)])
def test_it_is_drawn_along_the_tangents(run, sense):
    """Every point of the line is on a rim, and each span is at right angles to the radii at its ends."""
    s = pulleys(run)
    line = np.array([[float(x) for x in point.components] for point in s.loads["belt"].strand])[:, :2]
    assert line[0] == pytest.approx(line[-1], abs=1e-15)
    centres, radii = np.array([[0, 0], [D, 0]]), np.array([R1, R2])
    on = np.abs(np.linalg.norm(line[:, None] - centres, axis=2) - radii) < 1e-15
    assert on.any(axis=1).all()
    spans = [(a, b) for a, b in zip(line, line[1:], strict=False) if np.linalg.norm(b - a) > D / 2]
    assert len(spans) == 2
    for a, b in spans:
        assert np.linalg.norm(b - a) == pytest.approx(np.sqrt(D**2 - (R1 - sense * R2) ** 2), rel=1e-14)
    assert 'class="belt"' in fb.draw(s).svg
    page = fb.simulate(s, 0.01).animate().html
    assert "belt" in {line["name"] for line in scene_of(page)["lines"]}


def test_the_search_for_short_labels_is_bounded():
    """Roots in arguments of roots: the arguments of functions share the budget of the formula."""
    s = fb.System("symbolic pulleys")
    r, R, k = s.parameters(r=0.1, R=0.3, k=2000.0)
    one = s.hinge("one", s.ground, s.body("small", fb.disk(1, r)), coordinate="p")
    two = s.hinge("two", s.ground, s.body("large", fb.disk(9, R)), at=(1, 0, 0), coordinate="q")
    s.belt("belt", (one, r), (two, R), stiffness=k, tension=100)
    assert 'class="belt"' in fb.draw(s).svg
