"""Teeth with backlash: impacts, efficiency in both senses, and gears that lock themselves, against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest

import freebody as fb
from freebody.describe.contacts.backlash import Backlash
from freebody.errors import ModelError

R1, R2, M1, M2 = 0.1, 0.25, 1.5, 4.0
J1, J2 = M1 * R1**2 / 2, M2 * R2**2 / 2
RATIO = -R2 / R1
PLAY = 0.02


def pair(**losses):
    s = fb.System("pair")
    one, two = s.body("one", fb.disk(M1, R1)), s.body("two", fb.disk(M2, R2))
    first = s.hinge("first", s.ground, one, coordinate="p")
    second = s.hinge("second", s.ground, two, at=(R1 + R2, 0, 0), coordinate="q")
    s.gear(first, second, RATIO, name="mesh", backlash=PLAY, **losses)
    return s, first, second


def worm(mu, lead, backlash=1e-3):
    s = fb.System("worm")
    screw, wheel = s.body("screw", fb.disk(M1, R1, axis="x")), s.body("wheel", fb.disk(M2, R2, axis="y"))
    first = s.hinge("first", s.ground, screw, at=(0, 0, R1 + R2), axis="x", coordinate="p")
    second = s.hinge("second", s.ground, wheel, axis="y", coordinate="q")
    ratio = -R2 / (R1 * math.tan(lead))
    s.gear(first, second, ratio, name="mesh", helix_angle=math.pi / 2 - lead, backlash=backlash, friction=mu)
    return s, first, second, ratio


def closed(s, side, **speeds):
    """Motion from one flank, the first joint shifted by half of the backlash."""
    return fb.simulate(s, 0.1, initial={"p": side * float(s.contacts["mesh"].backlash) / 2, "q": 0, **speeds})


def test_the_gap_is_crossed_freely_and_the_impact_keeps_what_it_must():
    """b/2 = T t²/(2 J₁); Newton's restitution; p J₁ and q J₂ change by the moments of one impulse."""
    s, first, _ = pair(restitution=0.4)
    s.torque("T", first, 0.3)
    motion = fb.simulate(s, 0.2, tolerance=1e-12)
    event = motion.events[0]
    t = math.sqrt(PLAY * J1 / 0.3)
    assert event.time == pytest.approx(t, rel=1e-11) and "mesh_back" in str(event)
    before = 0.3 / J1 * t
    impulse = 1.4 * before / (1 / J1 + RATIO**2 / J2)
    state = motion.at(t * (1 + 1e-13))
    assert state["p'"] == pytest.approx(before - impulse / J1, rel=1e-9)
    assert state["q'"] == pytest.approx(impulse * RATIO / J2, rel=1e-9)
    assert abs(motion.energy.residual).max() < 1e-12


@pytest.mark.parametrize("eta", [1, 0.9, 0.6])
@pytest.mark.parametrize("sense", [1, -1])
def test_efficiency_of_both_senses_of_the_power(eta, sense):
    """η with the first wheel as driver, 2 - 1/η with the second."""
    s, first, second = pair(efficiency=eta)
    s.torque("T", first, sense * 5)
    driving = closed(s, sense, **{"p'": sense, "q'": sense / RATIO})
    # J₁ a = T - λ, J₂ a/i² = η λ
    a = 5 / (J1 + J2 / RATIO**2 / eta)
    assert driving["p'"][-1] == pytest.approx(sense * (1 + 0.1 * a), rel=1e-9)
    push = J2 * a / RATIO**2 / eta
    assert driving.energy.friction[-1] == pytest.approx(-(1 - eta) * push * (0.1 + a * 0.1**2 / 2), abs=1e-9)
    s, first, second = pair(efficiency=eta)
    s.torque("T", second, sense * 5 / RATIO)
    driven = closed(s, -sense, **{"p'": sense, "q'": sense / RATIO})
    back = 2 - 1 / eta
    # J₁ a = η' λ, J₂ a/i² = T/|i| - λ
    a = 5 / RATIO**2 / (J1 / back + J2 / RATIO**2)
    assert driven["p'"][-1] == pytest.approx(sense * (1 + 0.1 * a), rel=1e-9)


@pytest.mark.parametrize(("eta", "locked"), [(0.5 - 1e-6, True), (0.5 + 1e-6, False)])
def test_a_gear_below_one_half_locks_itself(eta, locked):
    s, _, second = pair(efficiency=eta)
    s.torque("T", second, 5)
    motion = closed(s, 1)
    assert (abs(motion["q"][-1]) < 1e-15) == locked
    assert motion.modes[-1].mode == ("stick" if locked else "slip-")


@pytest.mark.parametrize(("part", "locked"), [(1 + 1e-6, True), (1 - 1e-6, False)])
def test_a_worm_locks_itself_from_the_cone_of_friction_on(part, locked):
    lead = 0.2
    s, _, second, _ = worm(part * math.cos(math.pi / 9) * math.tan(lead), lead)
    s.torque("T", second, 5)
    motion = closed(s, 1)
    assert (abs(motion["q"][-1]) < 1e-15) == locked


@pytest.mark.parametrize("mu", [0, 0.05, 0.2])
def test_efficiency_of_a_worm(mu):
    """Shigley & Mischke (13-46): e = (cos φ_n - f tan λ)/(cos φ_n + f cot λ)."""
    lead, phi = 0.25, math.pi / 9
    s, first, _, ratio = worm(mu, lead)
    s.torque("T", first, 3)
    motion = closed(s, 1, **{"p'": 1, "q'": 1 / ratio})
    e = (math.cos(phi) - mu * math.tan(lead)) / (math.cos(phi) + mu / math.tan(lead))
    a = 3 / (J1 + J2 / ratio**2 / e)
    assert motion["p'"][-1] == pytest.approx(1 + 0.1 * a, rel=1e-9)
    # the separating force of the normal force N alone, upwards on the worm
    N = J2 * a / abs(ratio) / R2 / (math.cos(phi) * math.cos(lead) - mu * math.sin(lead))
    assert motion.reactions["first"].force[-1][2] == pytest.approx(-N * math.sin(phi), rel=1e-9)


@pytest.mark.parametrize("data", [{"side": 1}, {"side": -1, "friction": 0.2}])
def test_battery_of_contacts(data):
    fb.testing.check_contact(Backlash, ratio=-2, backlash=0.1, pressure_angle=0.35, **data)


def test_a_gear_of_which_only_the_ratio_is_known_may_have_backlash():
    s = fb.System("coaxial")
    one, two = s.body("one", fb.disk(M1, R1)), s.body("two", fb.disk(M2, R2))
    first, second = (s.hinge(n, s.ground, b, coordinate=n[0]) for n, b in (("p1", one), ("q1", two)))
    s.gear(first, second, 3, name="mesh", backlash=PLAY)
    s.torque("T", first, 2)
    motion = fb.simulate(s, 0.3, initial={"p": PLAY / 2, "q": 0})
    assert motion["q'"][-1] == pytest.approx(0.3 * 2 * 3 / (9 * J1 + J2), rel=1e-9)


def test_it_is_the_same_after_a_file(tmp_path):
    s, first, _ = pair(efficiency=0.9, restitution=0.2)
    s.torque("T", first, "2*cos(9*t)")
    fb.write(s, tmp_path / "pair.toml")
    a, b = (fb.simulate(x, 0.4) for x in (s, fb.read(tmp_path / "pair.toml")))
    assert np.array_equal(a["p"], b["p"]) and len(a.events) == len(b.events) > 2


REFUSED = {
    "Expected a backlash greater than 0 for gear 'mesh', got -1": {"backlash": -1},
    "Expected an efficiency above 0 and up to 1 for gear 'mesh', got 1.2": {"efficiency": 1.2},
    "Expected efficiency= for gear 'mesh', whose teeth do not slide at the pitch point, got friction=": {"friction": 1},
    "Gear 'mesh' has an efficiency but no backlash": {"efficiency": 0.9, "backlash": None},
    "Gear 'mesh' has friction but no backlash": {"friction": 0.9, "backlash": None},
    "Gear 'mesh' has a restitution but no backlash": {"restitution": 0.9, "backlash": None},
}  # fmt: skip


@pytest.mark.parametrize("words", REFUSED)
def test_refusals(words):
    s = fb.System("pair")
    one, two = s.body("one", fb.disk(M1, R1)), s.body("two", fb.disk(M2, R2))
    first = s.hinge("first", s.ground, one, coordinate="p")
    second = s.hinge("second", s.ground, two, at=(R1 + R2, 0, 0), coordinate="q")
    with pytest.raises(ModelError, match=words):
        s.gear(first, second, RATIO, name="mesh", **{"backlash": PLAY, **REFUSED[words]})


def test_crossed_teeth_have_friction_and_no_efficiency():
    s = fb.System("worm")
    screw, wheel = s.body("screw", fb.disk(M1, R1, axis="x")), s.body("wheel", fb.disk(M2, R2, axis="y"))
    first = s.hinge("first", s.ground, screw, at=(0, 0, R1 + R2), axis="x", coordinate="p")
    second = s.hinge("second", s.ground, wheel, axis="y", coordinate="q")
    with pytest.raises(
        ModelError, match="Expected friction= for gear 'mesh', whose teeth slide along each other"
    ):
        s.gear(first, second, -20, name="mesh", helix_angle=1.4, backlash=0.01, efficiency=0.8)
