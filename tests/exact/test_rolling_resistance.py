"""Resistance to rolling and spinning: closed forms of balls that come to rest, exact stick, files and refusals."""

import numpy as np
import pytest
from click.testing import CliRunner

import freebody as fb
from freebody.cli import command as program
from freebody.dynamics.motion import motion as accelerations
from freebody.dynamics.state import float_state
from freebody.errors import FormatError, ModelError, SimulationError
from freebody.exact import rolling_ball, spinning_ball
from freebody.motion.contact.starting_modes import starting_modes

G, R, DELTA, NU, H = 9.81, 0.1, 0.01, 0.005, 1e-2


def ball(space=True, slope=0.0, **laws):
    """A homogeneous ball of 1 kg on a rough floor."""
    s = fb.System("ball")
    s.parameters(delta=DELTA, nu=NU)
    body, level, weight = s.body("ball", fb.sphere(1, R)), G * np.sin(slope), -G * np.cos(slope)
    if space:
        s.gravity = (level, 0, weight)
        s.free("f", s.ground, body)
    else:
        s.gravity = (level, weight, 0)
        s.planar("f", s.ground, body, coordinate="x y turn")
    floor = s.ground.plane(normal="z" if space else "y")
    s.contact("floor", body.sphere(R), floor, friction=0.5, **laws)
    return s


def stepped(s, end, initial, **options):
    return fb.simulate(s, end, initial=initial, method="timestepping", step=H, **options)


def modes(motion, contact):
    return [(change.mode, change.start) for change in motion.modes.of(contact)]


def test_a_ball_rolls_to_rest():
    motion = stepped(ball(False, rolling="delta"), 2, {"y": R, "x'": 1, "turn'": -1 / R})
    exact = rolling_ball(1, R, DELTA, G)
    assert [mode for mode, _ in modes(motion, "floor")] == ["stick"]
    (slip, _), (stick, stops) = modes(motion, "floor_rolling")
    assert (slip, stick) == ("slip-", "stick")
    assert stops == pytest.approx(exact.time, abs=H)
    assert motion["x"][-1] == pytest.approx(1 / (2 * exact.deceleration), rel=H**2)
    one = motion.contacts["floor_rolling"]
    assert one.tangential[5] == pytest.approx(DELTA * G, rel=1e-12)  # against the turn to the right
    assert one.normal[5] == pytest.approx(G, rel=1e-12)
    assert one.margin[[5, -1]] == pytest.approx([0, DELTA * G], abs=1e-12)
    assert np.abs(motion["x'"][motion.t > stops + H]).max() < 1e-15
    assert abs(motion.energy.residual[-1]) < 1e-13


def test_a_ball_rolls_to_rest_in_any_direction():
    motion = stepped(
        ball(rolling="delta", spinning="nu"), 2, {"f_z": R, "f_vx": 0.6, "f_vy": 0.8, "f_wx": -8, "f_wy": 6}
    )
    exact = rolling_ball(1, R, DELTA, G)
    (slip, _), (stick, stops) = modes(motion, "floor_rolling")
    assert (slip, stick) == ("slip", "stick")
    assert stops == pytest.approx(exact.time, abs=H)
    way = [0.6 / (2 * exact.deceleration), 0.8 / (2 * exact.deceleration)]
    np.testing.assert_allclose([motion["f_x"][-1], motion["f_y"][-1]], way, rtol=(10 * H) ** 2)
    one = motion.contacts["floor_rolling"]
    np.testing.assert_allclose(
        np.linalg.norm(one.tangential[:50], axis=1), DELTA * one.normal[:50], rtol=1e-9
    )
    assert [mode for mode, _ in modes(motion, "floor_spinning")] == ["stick"]


def test_a_spinning_ball_stops():
    motion = stepped(ball(rolling="delta", spinning="nu"), 1, {"f_z": R, "f_wz": 10})
    exact = spinning_ball(10, R, NU, G)
    (slip, _), (stick, stops) = modes(motion, "floor_spinning")
    assert (slip, stick) == ("slip+", "stick")
    assert stops == pytest.approx(exact.time, abs=H)
    at = int(np.searchsorted(motion.t, 0.5))
    assert motion["f_wz"][at] == pytest.approx(10 - exact.deceleration * motion.t[at], rel=1e-12)
    assert motion.contacts["floor_spinning"].tangential[at] == pytest.approx(-NU * G, rel=1e-12)


@pytest.mark.parametrize("part", [0.99, 1.01])
def test_a_ball_rests_on_a_slope_below_delta_over_R(part):
    """About the contact m g sin β R <= δ m g cos β."""
    slope = np.arctan(part * DELTA / R)
    motion = stepped(ball(False, slope, rolling="delta"), 0.5, {"y": R})
    rests = part < 1
    assert [mode for mode, _ in modes(motion, "floor_rolling")] == ["stick" if rests else "slip-"]
    a = 5 / 7 * (G * np.sin(slope) - DELTA / R * G * np.cos(slope))
    assert motion["x'"][-1] == pytest.approx(0 if rests else a * 0.5, rel=1e-9, abs=1e-13)
    assert motion.contacts["floor"].tangential[-1] == pytest.approx(
        -G * np.sin(slope) + (0 if rests else a), rel=1e-9
    )


def test_resistance_on_a_soft_floor_has_its_normal_force():
    s = ball(False, rolling="delta", normal="1e4*depth + 100*rate")
    motion = stepped(s, 0.5, {"y": R - G / 1e4, "x'": 1, "turn'": -1 / R})
    assert motion["x'"][-1] == pytest.approx(1 - 0.5 * rolling_ball(1, R, DELTA, G).deceleration, rel=1e-3)


def test_what_resists_is_open_in_the_air():
    motion = stepped(ball(False, rolling="delta"), 0.1, {"y": 2 * R, "turn'": -1})
    assert modes(motion, "floor_rolling") == [("open", 0.0)]
    assert motion["turn'"][-1] == -1


def test_equations_have_stick_and_free_rolling():
    s = ball(False, rolling="delta")
    stuck = fb.equations(s, modes={"floor": "stick", "floor_rolling": "stick"})
    assert "M_floor" in stuck.free_body("ball").text()
    assert len(stuck.constraints) == 3


def test_equations_of_a_slip_have_the_normal_force_as_a_number():
    s = ball(False, rolling="delta")
    slowed = fb.equations(s, modes={"floor": "stick", "floor_rolling": "slip-"})
    assert "M_floor  couple delta*N_floor_rolling" in slowed.free_body("ball").text()
    answer = str(slowed.solve("x''", where={"N_floor_rolling": "N_floor"}))
    assert answer == "x'' = -981*delta/14"  # 5 g δ/(7 R)
    assert pytest.approx(rolling_ball(1, R, DELTA, G).deceleration, rel=1e-14) == 981 * DELTA / 14


SOFT = pytest.param({"normal": "1e4*depth + 100*rate"}, marks=pytest.mark.slow)


@pytest.mark.parametrize("soft", [{}, SOFT, {"adhesion": 2}], ids=str)
def test_equations_of_a_slip_are_those_of_the_motion(soft):
    s = ball(rolling="delta", spinning="nu", **soft)
    start = {
        "f_z": R - ("normal" in soft) * G / 1e4,
        "f_vx": 1,
        "f_vy": 0.2,
        "f_wy": 10,
        "f_wx": -2,
        "f_wz": 3,
    }
    motion = fb.simulate(s, 0.02, initial=start)
    assert (modes(motion, "floor_rolling")[0][0], modes(motion, "floor_spinning")[0][0]) == ("slip", "slip+")
    drawn = fb.free_body_diagram(s, "ball", trajectory=motion, at=0.01)
    assert "floor rolling: slip" in drawn.svg
    e = fb.equations(s, modes={x.contact: x.mode for x in motion.modes})
    now, values = motion.at(0.01), dict(motion.values)
    if "normal" not in soft:
        kinds = "rolling", "spinning"
        values |= {f"N_floor_{kind}": float(motion[f"floor_{kind}.normal"][200]) for kind in kinds}
    state = float_state(e.model, now.q.tolist(), now.u.tolist(), 0.01, values)
    there = [motion[f"{name}'"][200] for name in e.model.speed_names]
    assert accelerations(e.model, state).udot == pytest.approx(there, rel=1e-12)


def test_files_check_and_report_keep_it(tmp_path):
    s = ball(rolling="delta", spinning="nu")
    fb.write(s, tmp_path / "ball.toml")
    again = fb.read(tmp_path / "ball.toml").contacts["floor"]
    assert (again.rolling, again.spinning) == (s.contacts["floor"].rolling, s.contacts["floor"].spinning)
    said = CliRunner().invoke(program, ["check", str(tmp_path / "ball.toml")], catch_exceptions=False).output
    assert "rolling delta" in said.replace("\n", " ")
    fb.report(s, stepped(s, 0.1, {"f_z": R, "f_vx": 1, "f_wy": 10}), tmp_path / "ball.html")
    assert "floor_rolling" in (tmp_path / "ball.html").read_text(encoding="utf-8")
    with pytest.raises(FormatError, match="its resistance to rolling; leave out rolling="):
        fb.write(s, tmp_path / "ball.xml")


# -- by events -------------------------------------------------------------------------------------------


def test_a_ball_rolls_to_rest_by_events():
    motion = fb.simulate(ball(False, rolling="delta"), 2, initial={"y": R, "x'": 1, "turn'": -1 / R})
    exact = rolling_ball(1, R, DELTA, G)
    (slip, _), (stick, stops) = modes(motion, "floor_rolling")
    assert (slip, stick) == ("slip-", "stick")
    assert stops == pytest.approx(exact.time, rel=1e-13)
    assert motion["x"][-1] == pytest.approx(1 / (2 * exact.deceleration), rel=1e-13)
    one = motion.contacts["floor_rolling"]
    assert one.tangential[3] == pytest.approx(DELTA * G, rel=1e-13)
    assert one.normal[3] == pytest.approx(G, rel=1e-13)
    assert one.margin[[3, -1]] == pytest.approx([0, DELTA * G], abs=1e-12)
    assert np.abs(motion.at(2).u).max() < 1e-15
    assert motion.energy.friction[-1] == pytest.approx(-0.7, rel=1e-13)  # all of 7/10 m v²


def test_a_ball_that_slides_rolls_and_stops_by_events():
    """ω' = (μ R - δ) m g/I from rest until v - μ g t = ω R, then 5/7 g δ/R; M resists while the ball slides, too."""
    mu = 0.5
    motion = fb.simulate(ball(False, rolling="delta"), 3, initial={"y": R, "x'": 1})
    rate = 5 / 2 * G * (mu * R - DELTA) / R**2
    rolls = 1 / (mu * G + rate * R)
    speed = rate * rolls * R
    (slides, _), (sticks, begins) = modes(motion, "floor")
    assert (slides, sticks) == ("slip+", "stick") and begins == pytest.approx(rolls, rel=1e-12)
    (_, _), (_, stops) = modes(motion, "floor_rolling")
    assert stops == pytest.approx(rolls + rolling_ball(speed, R, DELTA, G).time, rel=1e-12)


def test_a_ball_rolls_to_rest_in_any_direction_by_events():
    start = {"f_z": R, "f_vx": 0.6, "f_vy": 0.8, "f_wx": -8, "f_wy": 6}
    motion = fb.simulate(ball(rolling="delta", spinning="nu"), 2, initial=start)
    exact = rolling_ball(1, R, DELTA, G)
    (_, _), (_, stops) = modes(motion, "floor_rolling")
    assert stops == pytest.approx(exact.time, abs=1e-9)
    way = [0.6 / (2 * exact.deceleration), 0.8 / (2 * exact.deceleration)]
    np.testing.assert_allclose([motion["f_x"][-1], motion["f_y"][-1]], way, rtol=1e-9)
    assert np.abs(motion.at(2).u).max() < 1e-12
    assert np.abs(motion.energy.residual).max() < 1e-9


def test_a_spinning_ball_stops_by_events():
    motion = fb.simulate(ball(rolling="delta", spinning="nu"), 1, initial={"f_z": R, "f_wz": 10})
    (slip, _), (stick, stops) = modes(motion, "floor_spinning")
    assert (slip, stick) == ("slip+", "stick")
    assert stops == pytest.approx(spinning_ball(10, R, NU, G).time, rel=1e-13)


@pytest.mark.parametrize("space", [False, True])
@pytest.mark.parametrize("part", [0.99, 1.01])
def test_a_ball_rests_on_a_slope_below_delta_over_R_by_events(part, space):
    slope, rests = np.arctan(part * DELTA / R), part < 1
    motion = fb.simulate(ball(space, slope, rolling="delta"), 0.5, initial={"f_z" if space else "y": R})
    mode = "stick" if rests else "slip" if space else "slip-"
    assert [one for one, _ in modes(motion, "floor_rolling")] == [mode]
    a = 5 / 7 * (G * np.sin(slope) - DELTA / R * G * np.cos(slope))
    moved = motion["f_x" if space else "x"][-1]
    assert moved == pytest.approx(0 if rests else a / 8, rel=1e-9, abs=1e-15)


def test_a_pushed_ball_begins_to_roll_where_the_push_has_the_moment():
    """F R = δ m g about the contact, F = k t at the centre."""
    s = ball(False, rolling="delta")
    s.force("push", s.bodies["ball"].origin, (2 * s.t, 0, 0))
    motion = fb.simulate(s, 1, initial={"y": R})
    (stick, _), (slip, begins) = modes(motion, "floor_rolling")
    assert (stick, slip) == ("stick", "slip-") and begins == pytest.approx(DELTA * G / (2 * R), rel=1e-11)
    (change,) = (one for one in motion.modes.of("floor_rolling") if one.start > 0)
    assert change.why == "|M| reached 0.0981 N m"


@pytest.mark.parametrize("impacts", ["simultaneous", "sequential"])
@pytest.mark.parametrize("impact", ["newton", "poisson"])
@pytest.mark.parametrize("spin", [-20.0, -0.5])
def test_an_impact_takes_of_the_rolling_what_its_impulse_bounds(impact, impacts, spin):
    """About the contact (7/5) m R² Δω = δ Λ, Λ = (1 + e) m v, or to rest."""
    v, e = 1.0, 0.25
    s = ball(False, rolling="delta", restitution=e, impact=impact)
    start = {"y": R, "y'": -v, "x'": -spin * R, "turn'": spin}
    motion = fb.simulate(s, 0.01, initial=start, impacts=impacts)
    change = DELTA * (1 + e) * v / (7 / 5 * R**2)
    assert motion["turn'"][-1] == pytest.approx(min(spin + change, 0), rel=1e-12, abs=1e-14)
    assert motion["x'"][-1] == pytest.approx(-R * motion["turn'"][-1], rel=1e-12)
    assert motion["y'"][-1] == pytest.approx(e * v - G * 0.01, rel=1e-12)


def test_resistance_has_the_load_of_adhesion_and_of_a_soft_floor():
    rolls = {"x'": 1, "turn'": -1 / R}
    motion = fb.simulate(ball(False, rolling="delta", adhesion=2), 2, initial={"y": R, **rolls})
    assert modes(motion, "floor_rolling")[-1][1] == pytest.approx(
        rolling_ball(1, R, DELTA, G + 2).time, rel=1e-12
    )
    soft = ball(False, rolling="delta", normal="1e4*depth + 100*rate")
    motion = fb.simulate(soft, 2, initial={"y": R - G / 1e4, **rolls})
    assert modes(motion, "floor_rolling")[-1][1] == pytest.approx(rolling_ball(1, R, DELTA, G).time, rel=1e-9)


def test_lanes_are_single_motions():
    s, start = ball(rolling="delta", spinning="nu"), {"f_z": 2 * R, "f_vx": 1, "f_wx": 5, "f_wz": 7}
    deltas = [0.005, 0.02]
    many = fb.simulate(s, 1, initial=start, values={"delta": deltas}, samples=11)
    for k, delta in enumerate(deltas):
        one = fb.simulate(s, 1, initial=start, values={"delta": delta}, samples=11)
        np.testing.assert_array_equal(many["f_x"][k], one["f_x"])


def test_modes_at_the_start():
    s = ball(False, np.arctan(1.01 * DELTA / R), rolling="delta")
    assert starting_modes(s, {"y": R}) == {"floor": "stick", "floor_rolling": "slip-"}
    assert starting_modes(s, {"y": R}, values={"delta": 2 * DELTA}) == {
        "floor": "stick",
        "floor_rolling": "stick",
    }
    assert starting_modes(s, {"y": 2 * R}) == {"floor": "open", "floor_rolling": "open"}


def test_what_it_refuses():
    s = ball(False, rolling="delta")
    with pytest.raises(SimulationError) as caught:
        fb.simulate(s, 1, initial={"y": R}, values={"delta": -1})
    assert str(caught.value) == "Expected rolling= of 0 m or more for contact 'floor', got -1."
    with pytest.raises(ModelError) as caught:
        fb.equations(ball(False, spinning="nu"), modes={})
    assert str(caught.value) == (
        "Contact 'floor' resists spinning about its normal, but the machine moves in a plane and does not spin so. "
        "Leave spinning= out."
    )
    with pytest.raises(ModelError, match="Expected rolling= of 0 m or more for contact 'floor', got -1."):
        ball(rolling=-1)
