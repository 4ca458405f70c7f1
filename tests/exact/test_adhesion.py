"""Contacts that adhere: closed forms of lift-off, friction of the pull, impacts, files and refusals."""

import numpy as np
import pytest
import sympy
from click.testing import CliRunner

import freebody as fb
from freebody.cli import command as program
from freebody.errors import FormatError, ModelError, SimulationError
from freebody.exact import dome_exit

G, M, A = 9.81, 2.0, 50.0
STEPS = {"method": "timestepping", "step": 1e-3}


def under_ceiling(load="0", **laws):
    """A block under a ceiling."""
    s = fb.System("block")
    s.parameters(A=A)
    s.gravity = (0, -G, 0)
    body = s.body("block", fb.particle(M))
    s.chain("plane", s.ground, body, [fb.Slider("x", "x"), fb.Slider("y", "y")])
    s.force("F", body.origin, (0, load, 0))
    s.contact("ceiling", body.origin, s.ground.plane(normal="-y"), adhesion="A", **laws)
    return s


def modes(motion):
    return [change.mode for change in motion.modes]


@pytest.mark.parametrize("route", [{"tolerance": 1e-11}, STEPS])
def test_a_pulled_block_leaves_the_ceiling_as_N_falls_to_minus_A(route):
    motion = fb.simulate(under_ceiling("-20*t", friction=0.3), 2, **route)
    leaves = (A - M * G) / 20
    assert modes(motion) == ["stick", "open"]
    assert motion.modes[1].start == pytest.approx(leaves, abs=1e-3 if route is STEPS else 1e-9)
    one, before = motion.contacts["ceiling"], motion.t < leaves - 2e-3
    at = motion.t[before] - (5e-4 if route is STEPS else 0)  # means over steps
    np.testing.assert_allclose(one.normal[before][1:], -(M * G + 20 * at)[1:], atol=1e-9)
    np.testing.assert_allclose(one.margin[before][1:], 0.3 * (A - M * G - 20 * at)[1:], atol=1e-9)
    assert np.abs(motion.energy.residual).max() < (1e-6 if route is STEPS else 1e-11)
    fall = lambda t: -(G * t**2 / 2 + 20 * (t**3 / 6 + leaves * t**2 / 2) / M)  # noqa: E731
    assert motion["y"][-1] == pytest.approx(fall(2 - leaves), rel=5e-3 if route is STEPS else 1e-8)


@pytest.mark.parametrize("route", [{"tolerance": 1e-11}, STEPS])
def test_a_bead_that_adheres_leaves_a_dome_later(route):
    s = fb.System("bead")
    s.gravity = (0, -G, 0)
    bead = s.body("bead", fb.particle(1))
    s.chain("plane", s.ground, bead, [fb.Slider("x", "x"), fb.Slider("y", "y")])
    s.contact("dome", bead.origin, s.ground.circle(1), adhesion=3)
    motion = fb.simulate(s, 1.4, initial={"y": 1, "x'": 0.1}, **route)
    assert len(motion.modes) == 2
    at = motion.modes[1].start
    assert motion.at(at)["y"] == pytest.approx(
        dome_exit(0.1, 1, 3, 1, G), abs=2e-3 if route is STEPS else 1e-8
    )
    assert np.abs(motion.contacts["dome"].gap[motion.t < at]).max() < 1e-9
    assert motion.contacts["dome"].normal[motion.t < at].min() == pytest.approx(-3, abs=0.15)


@pytest.mark.parametrize("route", [{"tolerance": 1e-11}, STEPS])
def test_friction_acts_by_the_pull(route):
    motion = fb.simulate(under_ceiling(friction=0.3), 1, initial={"x'": 3.0}, **route)
    assert modes(motion) == ["slip+", "stick"] or modes(motion) == ["slip-", "stick"]
    stops = 3 / (0.3 * (A - M * G) / M)
    assert motion.modes[1].start == pytest.approx(stops, abs=1e-3 if route is STEPS else 1e-9)
    assert motion.contacts["ceiling"].normal[-1] == pytest.approx(-M * G, rel=1e-12)


def test_impacts_are_those_without_adhesion():
    start = {"y": -0.1, "y'": 3.0}
    bounces = fb.simulate(under_ceiling(restitution=0.5), 0.1, initial=start)
    assert bounces["y"][-1] == pytest.approx(
        fb.simulate(under_ceiling(restitution=0.5), 0.1, initial=start, values={"A": 0})["y"][-1], abs=1e-12
    )
    sticks = fb.simulate(under_ceiling(), 0.1, initial=start)
    assert modes(sticks) == ["open", "slip"]
    falls = fb.simulate(under_ceiling(), 0.1, initial=start, values={"A": 10})
    assert modes(falls) == ["open", "open"] or modes(falls)[-1] == "open"


def test_a_bar_is_peeled_off_one_end_after_the_other():
    """Pulled at an end, N_B = -(m g + F)... : the end opens as N falls to -A, then the bar swings from the other."""
    s = fb.System("bar")
    s.gravity = (0, -G, 0)
    bar = s.body("bar", fb.slender_bar(1, 1, axis="x"))
    s.planar("plane", s.ground, bar, coordinate="x y turn")
    s.force("F", bar.point(0.5, 0, 0), (0, "-5*t", 0))
    ends = bar.corners((-0.5, 0, 0), (0.5, 0, 0))
    s.contact("ceiling", ends, s.ground.plane(normal="-y"), friction=0.5, adhesion=10)
    motion = fb.simulate(s, 1.1, tolerance=1e-10)
    opens = {change.contact: change.start for change in motion.modes if change.mode == "open"}
    assert opens["ceiling_2"] == pytest.approx((10 - G / 2) / 5, abs=1e-9)
    assert "ceiling_1" not in opens or opens["ceiling_1"] > opens["ceiling_2"]
    # about the end that holds: J a = -(m g/2 + F), and N follows from m a/2
    k = int(np.searchsorted(motion.t, opens["ceiling_2"])) + 1
    F = 5 * motion.t[k]
    turn = 3 * (G / 2 + F)
    assert motion.contacts["ceiling_1"].normal[k] == pytest.approx(-(G + F - turn / 2), abs=0.2)
    assert np.abs(motion.energy.residual).max() < 1e-9


def test_equations_have_the_friction_of_the_pull():
    e = fb.equations(under_ceiling(friction=0.3), modes={"ceiling": "slip+"})
    assert str(e.solve(["x''"])) == "x'' = 3*(50*A - 981)/1000"
    T, N = (e.reactions["ceiling"].components[f"{letter}_ceiling"] for letter in "TN")
    assert sympy.expand(T + sympy.Rational(3, 10) * (N + sympy.Symbol("A", real=True))) == 0
    assert e.free_body("block").text().count("T_ceiling ") == 1
    assert abs(e.reactions["ceiling"].force[0]) == abs(T)


def test_files_check_and_report_keep_it(tmp_path):
    s = under_ceiling(friction=0.3)
    fb.write(s, tmp_path / "block.toml")
    assert fb.read(tmp_path / "block.toml").contacts["ceiling"].adhesion == s.contacts["ceiling"].adhesion
    said = CliRunner().invoke(program, ["check", str(tmp_path / "block.toml")], catch_exceptions=False).output
    assert "adhesion A" in said
    fb.report(s, fb.simulate(s, 0.1), tmp_path / "block.html")
    assert "adhesion 50 N" in (tmp_path / "block.html").read_text(encoding="utf-8")
    with pytest.raises(FormatError, match="its adhesion; leave out adhesion="):
        fb.write(s, tmp_path / "block.xml")


def test_what_cannot_adhere_is_refused():
    with pytest.raises(ModelError) as caught:
        under_ceiling(normal="1e4*depth")
    assert str(caught.value) == (
        "Contact 'ceiling' has a normal force and an adhesion, which rigid contacts have. A compliant one only "
        "presses: leave adhesion= or normal= out."
    )
    s = fb.System("block")
    body = s.body("block", fb.particle(1))
    with pytest.raises(ModelError, match="Expected an adhesion of 0 N or more for contact 'wall', got -1."):
        s.contact("wall", body.origin, s.ground.plane(), adhesion=-1)
    with pytest.raises(
        SimulationError, match="Expected an adhesion of contact 'ceiling' of at least 0 N, got -2."
    ):
        fb.simulate(under_ceiling(), 0.1, values={"A": -2})
