"""Gear trains against Newton's equations of each wheel, written by hand.

Shigley & Mischke, Mechanical Engineering Design (1989), equations (13-32) to (13-43): with the tangential force W_t,

    helical    W_r = W_t tan φ_n / cos ψ,    W_a = W_t tan ψ
    bevel      W_r = W_t tan φ cos γ,        W_a = W_t tan φ sin γ
    worm       W_t = W cos φ_n sin λ,        W_r = W sin φ_n,        W_a = W cos φ_n cos λ
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import freebody as fb

EXACT = 1e-12
PRESSURE = math.pi / 9
M1, M2, R1, R2, TORQUE = 1.5, 4.0, 0.1, 0.25, 7.0
J1, J2 = M1 * R1**2 / 2, M2 * R2**2 / 2


def tangential(ratio: float) -> float:
    """F_t on both wheels: J₁ a₁ = T - F_t R₁, J₂ a₂ = F_t R₁ |a₁/a₂|."""
    return TORQUE / R1 / (1 + J1 * ratio**2 / J2)


def machine(at, axes, ratio, **angles):
    """Two wheels on the ground, driven by a torque on the first."""
    s = fb.System("gears")
    one, two = s.body("one", fb.disk(M1, R1, axis=axes[0])), s.body("two", fb.disk(M2, R2, axis=axes[1]))
    first = s.hinge("first", s.ground, one, at=at[0], axis=axes[0], coordinate="p")
    second = s.hinge("second", s.ground, two, at=at[1], axis=axes[1], coordinate="q")
    s.gear(first, second, ratio, name="mesh", **angles)
    s.torque("motor", first, TORQUE)
    return s


def check(s, force, arms, ratio):
    """The bearing of each wheel holds the force of the teeth, and the moment about its centre but for the axle's."""
    motion = fb.simulate(s, 0.1, samples=2, tolerance=1e-12)
    for name, axis, arm, sign, J in zip(
        ("first", "second"), s.joints.values(), arms, (1, -1), (J1, J2), strict=True
    ):
        n = np.array([float(x) for x in axis.primitives[0].axis])
        push = sign * np.array(force)
        found = motion.reactions[name]
        turning = np.cross(arm, push)
        assert found.force[0] == pytest.approx(-push, rel=EXACT, abs=EXACT * np.abs(push).max())
        moment = -(turning - (turning @ n) * n)
        assert found.moment[0] == pytest.approx(moment, rel=EXACT, abs=EXACT * np.abs(turning).max())
        speed = {"first": "p'", "second": "q'"}[name]
        drive = TORQUE if name == "first" else 0
        assert J * motion[speed][-1] / 0.1 == pytest.approx(turning @ n + drive, rel=1e-10)
    assert motion["p'"][-1] == pytest.approx(ratio * motion["q'"][-1], rel=EXACT)


@pytest.mark.parametrize("psi", [0.3, -0.4])
def test_helical_wheels(psi):
    """The driver turns about +z: its teeth are pushed down (-y); a right-handed one is pushed along +z."""
    ratio = -R2 / R1
    s = machine([(0, 0, 0), (R1 + R2, 0, 0)], "zz", ratio, helix_angle=psi)
    F = tangential(ratio)
    force = (-F * math.tan(PRESSURE) / math.cos(psi), -F, F * math.tan(psi))
    check(s, force, [(R1, 0, 0), (-R2, 0, 0)], ratio)


def test_bevel_wheels():
    """Axes x and y that meet in the origin; the pinion turns about +x, so its teeth, at +y, are pushed along -z."""
    ratio = -R2 / R1
    s = machine([(R2, 0, 0), (0, R1, 0)], "xy", ratio, pressure_angle=PRESSURE)
    F = tangential(ratio)
    gamma = math.atan2(R1, R2)
    force = (F * math.tan(PRESSURE) * math.sin(gamma), -F * math.tan(PRESSURE) * math.cos(gamma), -F)
    check(s, force, [(0, R1, 0), (R2, 0, 0)], ratio)


@pytest.mark.parametrize("psi", [0.5, -0.5])
def test_spiral_bevel_wheels(psi):
    """Shigley (13-40): the force along the cone is F_t tan ψ, that square to it F_t tan φ_n / cos ψ."""
    ratio = -R2 / R1
    s = machine([(R2, 0, 0), (0, R1, 0)], "xy", ratio, pressure_angle=PRESSURE, helix_angle=psi)
    F = tangential(ratio)
    gamma = math.atan2(R1, R2)
    along, square = F * math.tan(psi), F * math.tan(PRESSURE) / math.cos(psi)
    # a right-handed driver that turns about the axis which leads away from the apex is pushed away from it
    force = (
        square * math.sin(gamma) + along * math.cos(gamma), -square * math.cos(gamma) + along * math.sin(gamma), -F
    )  # fmt: skip
    check(s, force, [(0, R1, 0), (R2, 0, 0)], ratio)


@pytest.mark.parametrize("hand", [1, -1])
def test_worm_and_wheel(hand):
    """A worm about x above its wheel about y: W_t of the worm is W_a of the wheel, and the reverse.

    The lead angle λ follows from the ratio: tan λ = R₂/(i R₁). A right-handed worm that turns about +x is a screw: it
    pushes the wheel's teeth along -x and is pushed along +x.
    """
    starts, teeth = 2, 30
    ratio = -hand * teeth / starts
    lam = math.atan(R2 * starts / (R1 * teeth))
    s = machine(
        [(0, 0, R1 + R2), (0, 0, 0)], "xy", ratio, pressure_angle=PRESSURE, helix_angle=hand * (math.pi / 2 - lam)
    )  # fmt: skip
    F = tangential(ratio)  # around the worm
    W = F / (math.cos(PRESSURE) * math.sin(lam))
    # the worm's lowest point moves along +y, so its teeth are pushed along -y
    force = (hand * W * math.cos(PRESSURE) * math.cos(lam), -F, W * math.sin(PRESSURE))
    check(s, force, [(0, 0, -R1), (0, 0, R2)], ratio)


def test_a_planetary_set_with_a_turning_ring():
    """Sun, planet, ring and arm: eight equations by hand, with the planet's centre on its circle."""
    rs, rp, masses = 0.1, 0.04, {"arm": 2.0, "sun": 1.0, "planet": 0.6, "ring": 3.0}
    rr, d = rs + 2 * rp, rs + rp
    s = fb.System("planetary")
    arm = s.body("arm", fb.disk(masses["arm"], 0.1))
    sun, planet = s.body("sun", fb.disk(masses["sun"], rs)), s.body("planet", fb.disk(masses["planet"], rp))
    ring = s.body("ring", fb.ring(masses["ring"], rr))
    s.hinge("axle", s.ground, arm, coordinate="a")
    joints = {
        name: s.hinge(name, arm, body, at=(x, 0, 0), coordinate=name[0])
        for name, body, x in (("sun_on_arm", sun, 0), ("planet_on_arm", planet, d), ("ring_on_arm", ring, 0))
    }
    s.gear(joints["sun_on_arm"], joints["planet_on_arm"], -rp / rs, name="inner")
    s.gear(joints["ring_on_arm"], joints["planet_on_arm"], rp / rr, name="outer")
    s.torque("drive", sun, (0, 0, 5))
    s.torque("brake", ring, (0, 0, -2))
    J = {
        "arm": 2.0 * 0.1**2 / 2, "sun": 1.0 * rs**2 / 2, "planet": 0.6 * rp**2 / 2, "ring": 3.0 * rr**2
    }  # fmt: skip
    # unknowns: angular accelerations of arm, sun, planet, ring; teeth S on the sun and R on the ring (along y at the
    # planet); pin Y on the planet
    A = np.zeros((7, 7))
    b = np.zeros(7)
    A[0, [0, 6]] = J["arm"], d
    A[1, [1, 4]] = J["sun"], -rs
    A[2, [2, 4, 5]] = J["planet"], -rp, rp
    A[3, [3, 5]] = J["ring"], -rr
    b[1], b[3] = 5, -2
    A[4, [0, 4, 5, 6]] = masses["planet"] * d, 1, 1, -1
    A[5, [0, 1, 2]] = d, -rs, -rp  # one velocity at the sun's pitch point: rs ω_s = d ω_a - rp ω_p
    A[6, [0, 2, 3]] = d, rp, -rr
    arm_, sun_, planet_, ring_, S, R, Y = np.linalg.solve(A, b)
    motion = fb.simulate(s, 1e-3, samples=2, tolerance=1e-12)
    found = motion.reactions["planet_on_arm"].force[0]
    # both teeth press the planet, inwards and outwards
    press = math.tan(PRESSURE) * (abs(R) - abs(S))
    assert found == pytest.approx([press, Y, 0], rel=EXACT, abs=EXACT * abs(Y))
    assert motion.reactions["sun_on_arm"].force[0][1] == pytest.approx(-S, rel=EXACT)
    assert motion.reactions["ring_on_arm"].force[0][1] == pytest.approx(-R, rel=EXACT)
    rates = fb.compile(s, at=[0, 0, 0, 0]).forward_dynamics([0, 0, 0, 0], [0, 0, 0, 0])
    assert rates == pytest.approx([arm_, sun_ - arm_, planet_ - arm_, ring_ - arm_], rel=EXACT)
