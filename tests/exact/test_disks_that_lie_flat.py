"""Disks and cylinders that lie flat on a plane, by events: what they carry, how they fall and come to rest."""

import math

import numpy as np
import pytest

import freebody as fb

G, R, H = 9.81, 0.012, 0.002


@pytest.fixture(scope="module")
def coin():
    """A coin of two circles."""
    s = fb.System("coin")
    s.gravity = (0, 0, -G)
    mu, e = s.parameters(mu=0.4, e=0.4)
    disk = s.body("disk", fb.cylinder(0.005, R, H))
    s.free("f", s.ground, disk)
    for name, z in (("tail", -H / 2), ("head", H / 2)):
        edge = disk.circle(R, at=(0, 0, z))
        s.contact(name, edge, s.ground.plane(normal="z"), friction=mu, restitution=e)
    return s


def tilted(angle, azimuth=0.3, lift=0.0):
    """A coin that stands on its lower edge, tilted about a horizontal line."""
    half = math.sin(angle / 2)
    return {
        "f_z": R * math.sin(angle) + H / 2 * math.cos(angle) + lift, "f_e0": math.cos(angle / 2),
        "f_e1": half * math.cos(azimuth), "f_e2": half * math.sin(azimuth),
    }  # fmt: skip


@pytest.mark.parametrize("e", [0, 0.4])
def test_a_coin_that_falls_flat_comes_to_rest(coin, e):
    """The fall turns m g (z - h/2) into ½ (m/4 R² + m h²/12 + m h²/4 + m R²) w² if the edge does not slip."""
    a = 0.3
    motion = fb.simulate(coin, 0.2, initial=tilted(a), values={"mu": 5, "e": e})
    fall = tilted(a)["f_z"] - H / 2
    w = math.sqrt(2 * G * fall / (R**2 / 4 + H**2 / 12 + H**2 / 4 + R**2))
    flat = next(one.time for one in motion.happenings if "impact" in str(one))
    before = motion.at(flat - 1e-9)
    assert np.hypot(*before.u[:2]) == pytest.approx(w, rel=1e-6)
    assert np.abs(motion.at(0.2).u).max() < 1e-20
    assert motion["f_z"][-1] == pytest.approx(H / 2, abs=1e-12)
    assert [motion.contacts[f"tail_{k}"].mode[-1] for k in range(1, 5)] == ["stick"] * 4
    assert sum(motion.contacts[f"tail_{k}"].least[-1, 0] for k in range(1, 5)) == pytest.approx(0.005 * G)
    assert abs(motion.contacts["tail"].gap[-1]) < 1e-20 and motion.contacts["tail"].gap.min() > -1e-10
    assert motion.energy.relative_residual < 1e-8
    assert np.diff(motion.energy.total).max() < 1e-11


def test_friction_stops_the_spin_of_a_flat_coin(coin):
    """I w' = -μ m g R with I = m R²/2, however the points share the weight."""
    w, mu = 30.0, 0.4
    stops = R * w / (2 * mu * G)
    motion = fb.simulate(coin, 2 * stops, initial={"f_z": H / 2, "f_wz": w})
    assert motion["f_wz"] == pytest.approx(np.maximum(w - 2 * mu * G / R * motion.t, 0), abs=1e-7)
    assert motion.energy.relative_residual < 1e-9


@pytest.mark.parametrize("share", [0.99, 1.01])
def test_a_cylinder_tips_where_the_moment_is_more_than_its_weight_times_the_radius(share):
    s = fb.System("can")
    s.gravity = (0, 0, -G)
    can = s.body("can", fb.cylinder(1, 0.1, 0.3))
    s.free("f", s.ground, can)
    s.contact("rim", can.circle(0.1, at=(0, 0, -0.15)), s.ground.plane(normal="z"), friction=2)
    s.force("push", can.origin, (share * G * 0.1 / 0.15, 0, 0))
    motion = fb.simulate(s, 0.2, initial={"f_z": 0.15})
    tilt = 2 * np.hypot(motion["f_e1"][-1], motion["f_e2"][-1])
    assert tilt == pytest.approx(0, abs=1e-12) if share < 1 else tilt > 1e-4
    assert motion.energy.relative_residual < 1e-9


def test_a_coin_with_resistance_rolls_wobbles_and_rests():
    """It lies flat at a finite time, before which its lowest point turns without bound (Euler's disk)."""
    s = fb.System("coin")
    s.gravity = (0, 0, -G)
    disk = s.body("disk", fb.cylinder(0.005, R, H))
    s.free("f", s.ground, disk)
    laws = {"friction": 0.3, "rolling": 2e-4, "spinning": 1e-4}
    s.contact("tail", disk.circle(R, at=(0, 0, -H / 2)), s.ground.plane(normal="z"), **laws)
    motion = fb.simulate(s, 1, initial={**tilted(0.1), "f_wy": 2.0})
    assert np.abs(motion.at(1).u).max() < 1e-20
    assert motion["f_z"][-1] == pytest.approx(H / 2, abs=1e-12)
    assert motion.energy.relative_residual < 1e-8
