"""Compliant normal forces: closed forms of impacts, rolling on a soft floor, friction that sticks, files, refusals."""

import math

import numpy as np
import pytest
from click.testing import CliRunner

import freebody as fb
from freebody.cli import command as program
from freebody.errors import FormatError, ModelError, SimulationError
from freebody.exact import damped_impact, elastic_impact, hunt_crossley_restitution

G, R, M = 9.81, 0.02, 0.1


def falling(law, **laws):
    """A particle over a floor, without gravity."""
    s = fb.System("ball")
    s.parameters(k=1e4, c=20.0)
    ball = s.body("ball", fb.particle(1))
    s.slider("guide", s.ground, ball, axis="y", coordinate="y")
    s.contact("floor", ball.origin, s.ground.plane(), normal=law, **laws)
    return s


def sphere(space=False, law="k*depth**1.5"):
    """A sphere over a floor with friction."""
    s = fb.System("ball")
    s.parameters("g", k=1e6, mu=0.3)
    ball = s.body("ball", fb.sphere(M, R))
    up = "z" if space else "y"
    s.gravity = (0, 0, "-g") if space else (0, "-g", 0)
    if space:
        s.free("air", s.ground, ball)
    else:
        s.planar("air", s.ground, ball, coordinate="x y turn")
    s.contact("floor", ball.sphere(R), s.ground.plane(normal=up), friction="mu", normal=law)
    return s


def changes(motion):
    return [(change.mode, change.start) for change in motion.modes]


IMPACTS = {
    "Hertz": ("1e6*depth**1.5", elastic_impact(1, 1e6, 1.0)),
    "a linear spring": ("k*depth", elastic_impact(1, 1e4, 1.0, n=1)),
    "a spring and a damper": ("k*depth + c*rate", damped_impact(1, 1e4, 20.0, 1.0)),
}


@pytest.mark.parametrize("name", IMPACTS)
def test_impacts_last_and_rebound_as_their_closed_forms(name):
    law, exact = IMPACTS[name]
    motion = fb.simulate(falling(law), 0.1, initial={"y": 0.01, "y'": -1}, tolerance=1e-12, samples=20001)
    _, (mode, start), (_, end) = changes(motion)
    assert mode == "slip"
    assert end - start == pytest.approx(float(exact.duration), rel=1e-9)
    assert motion["y'"][-1] == pytest.approx(float(exact.restitution), rel=1e-9)
    assert -motion.contacts["floor"].gap.min() == pytest.approx(float(exact.depth), rel=1e-6)
    assert np.abs(motion.energy.residual).max() < 1e-12
    assert motion.contacts["floor"].normal.min() >= 0


def test_a_law_of_two_stiffnesses_switches_where_its_depth_does():
    """k up to the depth a, then k + K: two quarters of ω = √k, and between them an arc of Ω = √(k + K)."""
    k, K, a = 1e4, 4e4, 1e-3
    s = falling("k*depth + 4*k*max(depth - 1/1000, 0)")
    motion = fb.simulate(s, 0.1, initial={"y": 0.05, "y'": -1.0}, tolerance=1e-10)
    first = math.asin(a * math.sqrt(k)) / math.sqrt(k)
    v, W = math.cos(first * math.sqrt(k)), math.sqrt(k + K)
    arc = 2 * math.atan2(v / W, a - K * a / (k + K)) / W
    assert motion["y"][-1] == pytest.approx(0.05 - 2 * first - arc, abs=1e-12)
    assert motion["y'"][-1] == pytest.approx(1, abs=1e-12)


def test_hunt_and_crossleys_restitution_depends_on_c_and_v_only():
    motion = fb.simulate(
        falling("k*depth**1.5*(1 + c*rate)"),
        0.4,
        initial={"y": 0.01, "y'": -1},
        values={"c": 0.4},
        tolerance=1e-12,
    )
    assert motion["y'"][-1] == pytest.approx(float(hunt_crossley_restitution(0.4, 1.0)), rel=1e-9)


def test_a_sphere_on_a_soft_floor_slips_then_rolls():
    depth = (M * G / 1e6) ** (2 / 3)
    motion = fb.simulate(sphere(), 0.2, initial={"y": R - depth, "x'": 1}, values={"g": G}, tolerance=1e-11)
    (first, _), (second, stop) = changes(motion)
    assert (first, second) == ("slip+", "stick")
    assert stop == pytest.approx(2 / (7 * 0.3 * G), rel=1e-9)
    assert motion["x'"][-1] == pytest.approx(5 / 7, rel=1e-12)
    assert motion.contacts["floor"].slip[-1] == pytest.approx(0, abs=1e-14)


def test_in_space_a_sphere_that_falls_bounces_as_in_its_plane():
    start = {"y": 0.021, "y'": -1, "x'": 0.5}
    plane = fb.simulate(sphere(), 0.01, initial=start, values={"g": 0}, tolerance=1e-11)
    start = {"air_z": 0.021, "air_vz": -1, "air_vx": 0.3, "air_vy": 0.4}
    space = fb.simulate(sphere(space=True), 0.01, initial=start, values={"g": 0}, tolerance=1e-11)
    np.testing.assert_allclose(space["air_z"], plane["y"], rtol=1e-9)
    np.testing.assert_allclose(0.8 * space["air_x"], 0.6 * space["air_y"], atol=1e-14)
    np.testing.assert_allclose(space["air_x"] / 0.6, plane["x"], rtol=1e-7, atol=1e-12)
    assert np.abs(space.energy.residual).max() < 1e-12


def test_on_a_slope_a_block_sticks_below_the_angle_of_friction():
    s = fb.System("block")
    s.parameters("a", mu=0.5)
    s.gravity = ("9.81*sin(a)", "-9.81*cos(a)", 0)
    block = s.body("block", fb.particle(1))
    s.chain("plane", s.ground, block, [fb.Slider("x", "x"), fb.Slider("y", "y")])
    s.contact("floor", block.origin, s.ground.plane(), friction="mu", normal="1e5*depth + 100*rate")
    for a, sticks in ((0.4, True), (0.5, False)):
        sunk = -G * math.cos(a) / 1e5
        motion = fb.simulate(s, 0.5, initial={"y": sunk}, values={"a": a}, tolerance=1e-10)
        assert [change.mode for change in motion.modes] == (["stick"] if sticks else ["slip+"])
        travel = 0 if sticks else G * (math.sin(a) - 0.5 * math.cos(a)) * 0.5**2 / 2
        assert motion["x"][-1] == pytest.approx(travel, abs=1e-12)


def test_equations_in_a_mode_have_the_law_as_a_load():
    s = falling("k*depth + c*rate")
    e = fb.equations(s, modes={"floor": "slip"})
    assert e.text() == "y'' + c*y' + k*y = 0"
    assert [action.name for action in e.free_body("ball").actions if action.load] == ["N_floor"]
    frequency = fb.linearize(e, about={"y": 0}, values={"c": 0}).natural_frequencies()
    assert [float(x) for x in frequency] == pytest.approx([100.0])
    stick = fb.equations(sphere(), modes={"floor": "stick"})
    assert "m*x''" not in stick.text() and "x' + turn'/50 = 0" in stick.text()


def test_the_ledger_and_the_friction_of_a_state_agree_with_the_equations_of_its_mode():
    motion = fb.simulate(
        sphere(), 0.01, initial={"y": 0.021, "y'": -1, "x'": 2}, values={"g": G}, tolerance=1e-11
    )
    one, k = motion.contacts["floor"], 60
    assert one.mode[k] == "slip+"
    np.testing.assert_allclose(one.normal[k], 1e6 * (-one.gap[k]) ** 1.5, rtol=1e-12)
    np.testing.assert_allclose(one.tangential[k], -0.3 * one.normal[k], rtol=1e-12)
    np.testing.assert_allclose(motion["x''"][k], one.tangential[k] / M, rtol=1e-12)
    np.testing.assert_allclose(motion["y''"][k], one.normal[k] / M - G, rtol=1e-12)


def test_time_steps_converge_to_the_motion_by_events():
    start = {"y": 0.021, "y'": -1, "x'": 0.2}
    event = fb.simulate(sphere(), 0.01, initial=start, values={"g": G}, tolerance=1e-11)
    errors = []
    for h in (5e-5, 2.5e-5):
        steps = fb.simulate(
            sphere(), 0.01, initial=start, values={"g": G}, method="timestepping", step=h, samples=201
        )
        errors.append(abs(steps["y'"][-1] - event["y'"][-1]))
        assert np.abs(steps.energy.residual).max() < 1e-14
    assert errors[1] < errors[0] < 1e-4
    assert [change.mode for change in steps.modes] == ["open", "slip+", "stick", "open"]


def test_the_ledger_counts_the_work_of_a_moving_floor():
    s = fb.System("shaken")
    s.gravity = (0, -G, 0)
    plate, block = s.body("plate", fb.particle(1)), s.body("block", fb.particle(1))
    s.slider("drive", s.ground, plate, axis="y", coordinate="0.01*sin(20*t)")
    s.chain("plane", s.ground, block, [fb.Slider("x", "x"), fb.Slider("y", "y")])
    s.contact("floor", block.origin, plate.plane(), friction=0.3, normal="1e4*depth + 10*rate")
    start = {"y": 0.02, "x'": 0.5}
    motion = fb.simulate(s, 0.3, initial=start, tolerance=1e-11)
    assert np.abs(motion.energy.residual).max() < 1e-11
    left = []
    for h in (1e-3, 5e-4):
        steps = fb.simulate(s, 0.3, initial=start, method="timestepping", step=h, samples=301)
        left.append(np.abs(steps.energy.residual).max())
    assert left[1] < left[0] / 3 < 1e-5
    assert steps["y"][-1] == pytest.approx(motion["y"][-1], abs=1e-3)


def test_lanes_are_the_runs_alone():
    starts = np.linspace(-1.0, -0.5, 3)
    lanes = fb.simulate(
        sphere(),
        0.01,
        initial={"y": 0.021, "y'": starts, "x'": 0.2},
        values={"g": G},
        outputs=["x", "turn", "max(N_floor)"],
    )
    for k, v in enumerate(starts):
        alone = fb.simulate(sphere(), 0.01, initial={"y": 0.021, "y'": float(v), "x'": 0.2}, values={"g": G})
        assert float(lanes["x"][k].values.ravel()[-1]) == pytest.approx(alone["x"][-1], rel=1e-12)


def test_files_keep_the_law(tmp_path):
    s = sphere(law="k*depth**1.5*(1 + mu*rate)")
    fb.write(s, tmp_path / "ball.toml")
    text = (tmp_path / "ball.toml").read_text()
    assert 'normal = "' in text and "rate" in text
    again = fb.read(tmp_path / "ball.toml")
    assert str(again.contacts["floor"].normal_force) == str(s.contacts["floor"].normal_force)
    shown = CliRunner().invoke(program, ["check", str(tmp_path / "ball.toml")]).output
    assert "N = " in shown and "depth" in shown
    with pytest.raises(FormatError, match="its normal force; contacts of the format have solref instead"):
        fb.write(s, tmp_path / "ball.xml", values={"g": G})


PULLING = {
    "-depth": "Expected a normal force of contact 'floor' that grows from 0 with `depth`, since it only presses, got "
    '-depth: -9.31323e-10 N at depth = 9.3e-10 m. Write a law such as "k*depth" with k > 0.',
    "c*depth*rate": "Expected a normal force of contact 'floor' that grows from 0 with `depth`, since it only presses, "
    'got c*depth*rate: 0 N at depth = 9.3e-10 m. Write a law such as "k*depth" with k > 0.',
    "k*depth - c*rate": "Expected a normal force of contact 'floor' that presses as the contact closes, at rate > 0, "
    "got -c*rate + depth*k: -1.86265e-08 N at depth = 0, rate = 9.3e-10 m/s. A damper has c > 0 in "
    '"k*depth + c*rate".',
}


@pytest.mark.parametrize("law", PULLING)
def test_a_law_that_pulls_is_refused(law):
    with pytest.raises(ModelError) as caught:
        falling(law)
    assert str(caught.value) == PULLING[law]


@pytest.mark.parametrize("route", [{}, {"method": "timestepping", "step": 1e-3}])
def test_a_law_that_pulls_with_the_values_of_a_run_is_refused(route):
    with pytest.raises(
        SimulationError, match="grows from 0 with `depth`, since it only presses, got depth\\*k: -9.3"
    ):
        fb.simulate(falling("k*depth"), 0.1, initial={"y": 0.01}, values={"k": -10}, **route)


def test_a_box_that_rocks_on_four_soft_corners_comes_to_rest_in_steps():
    """Corners at different depths slip by nanometres over each other as the box pitches: all cannot stick."""
    s = fb.System("box")
    s.gravity = (0, 0, -G)
    box = s.body("box", fb.box(1, (0.2, 0.2, 0.1)))
    s.free("f", s.ground, box)
    corners = box.corners(*((x, y, -0.05) for x in (-0.1, 0.1) for y in (-0.1, 0.1)))
    s.contact("floor", corners, s.ground.plane(normal="z"), friction=0.4, normal="1e4*depth + 20*rate")
    start = {"f_z": 0.06, "f_wx": 1.0, "f_wy": 0.3, "f_vx": 0.2}
    motion = fb.simulate(s, 0.5, initial=start, method="timestepping", step=1e-3)
    assert motion["f_z"][-1] == pytest.approx(0.05 - G / 4e4, abs=1e-5)
    assert abs(motion["f_vx"][-1]) < 1e-6


@pytest.mark.parametrize("law", ["1e4*depth + 30*rate", "1e5*depth**1.5*(1 + 0.4*rate)"])
def test_a_corner_that_slips_as_the_box_is_level_is_not_held_by_the_other(law):
    """A box that lands on two soft corners and rocks: as it passes the level, both corners move alike for a moment."""
    s = fb.System("box")
    s.gravity = (0, -G, 0)
    box = s.body("box", fb.box(1, (0.54, 0.236, 0.2)))
    s.planar("air", s.ground, box, coordinate="x y turn")
    s.contact("feet", box.corners(size=(0.54, 0.236)), s.ground.plane(), friction=0.2, normal=law)
    start = {"y": 0.119, "turn": 2e-3, "x'": -0.2, "turn'": 0.01}
    motion = fb.simulate(s, 0.3, initial=start, samples=301)
    assert (np.diff(np.sign(motion["turn"])) != 0).sum() > 2
    for contact in motion.contacts.values():
        assert np.abs(contact.slip[contact.mode == "stick"]).max(initial=0) < 1e-9
    assert motion.energy.relative_residual < 1e-8
