"""Resistance to rolling and spinning: closed forms of balls that come to rest, exact stick, files and refusals."""

import numpy as np
import pytest
from click.testing import CliRunner

import freebody as fb
from freebody.cli import command as program
from freebody.errors import FormatError, ModelError, SimulationError
from freebody.exact import rolling_ball, spinning_ball
from freebody.motion.live.export import check_machine

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
    with pytest.raises(ModelError) as caught:
        fb.equations(s, modes={"floor": "stick", "floor_rolling": "slip+"})
    assert str(caught.value) == (
        "Expected 'stick' or 'open' for 'floor_rolling', got a slip: its moment is a multiple of the normal force of "
        "'floor', which equations in modes do not have. Motions do, by method='timestepping'."
    )


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


def test_other_routes_refuse_it():
    s = ball(False, rolling="delta")
    with pytest.raises(SimulationError) as caught:
        fb.simulate(s, 1, initial={"y": R})
    assert str(caught.value) == (
        "Contact 'floor' resists rolling, which motions from event to event do not have. Take method='timestepping' "
        "with step=, which does it exactly in every step, or leave rolling= out."
    )
    with pytest.raises(SimulationError, match="contact 'floor', which resists rolling or spinning"):
        motion = stepped(s, 0.1, {"y": R})
        check_machine(motion.kernels)
    with pytest.raises(ModelError) as caught:
        fb.equations(ball(False, spinning="nu"), modes={})
    assert str(caught.value) == (
        "Contact 'floor' resists spinning about its normal, but the machine moves in a plane and does not spin so. "
        "Leave spinning= out."
    )
    with pytest.raises(ModelError, match="Expected rolling= of 0 m or more for contact 'floor', got -1."):
        ball(rolling=-1)
