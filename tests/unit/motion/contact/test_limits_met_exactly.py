"""Loads that are just at the limit of friction: one decision, stick at equality."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

import freebody as fb


def pulled(factor, mu=0.2, given=False):
    """A disk pulled at its centre: it rolls up to F = 3 μ m g."""
    s = fb.System("pulled disk")
    m, R, k, g = s.parameters(m=10, R=0.3, mu=mu, g=9.81)
    s.gravity = (0, -g, 0)
    disk = s.body("disk", fb.disk(m, R))
    s.planar("plane", s.ground, disk, coordinate="x y phi")
    s.force("F", disk.origin, (factor * 3 * mu * 10 * 9.81 if given else factor * 3 * k * m * g, 0, 0))
    s.contact("floor", disk.circle(R), s.ground.plane(normal="y", at=(0, -R, 0)), friction=k)
    return s


def incline(beta, mu):
    """A point mass on an inclined plane."""
    s = fb.System("incline")
    m, k, b, g = s.parameters(m=2, mu=mu, beta=beta, g=9.81)
    s.gravity = (0, -g, 0)
    mass = s.body("block", fb.disk(m, 0.1))
    s.planar("plane", s.ground, mass, coordinate="x y phi")
    s.constrain("phi")
    s.contact("foot", mass.origin, s.ground.plane(normal=("-sin(beta)", "cos(beta)", 0)), friction=k)
    return s


@pytest.mark.parametrize("given", [False, True])
@pytest.mark.parametrize("mu", [0.1, 0.2, 0.3, 0.7])
def test_a_disk_pulled_just_at_the_limit_rolls(mu, given):
    motion = fb.simulate(pulled(1, mu, given), 2.0)
    assert not motion.events
    assert np.abs(motion["x"] + 0.3 * motion["phi"]).max() < 1e-9
    assert motion["x"][-1] == pytest.approx(0.5 * 2 * mu * 9.81 * 4)  # a = 2 F/(3 m)


@pytest.mark.parametrize("factor", [1 + 1e-9, 1.5])
def test_a_disk_pulled_beyond_it_slips(factor):
    motion = fb.simulate(pulled(factor), 2.0)
    assert motion["x"][-1] + 0.3 * motion["phi"][-1] > 1e-9


@pytest.mark.parametrize("beta", [0.1, 0.3, 0.7, 1.2])
def test_a_block_on_an_incline_of_its_friction_stays(beta):
    motion = fb.simulate(incline(beta, float(np.tan(beta))), 1.0)
    assert not motion.events
    assert abs(motion["x"][-1]) < 1e-12


def planar(shape):
    s = fb.System("body")
    body = s.body("body", shape)
    s.planar("plane", s.ground, body, coordinate="x y phi")
    return s, body


def just_rolling(mu, m, g):
    """A disk pulled at F = 3 μ m g."""
    s, disk = planar(fb.disk(m, 0.3))
    s.gravity = (0, -g, 0)
    s.contact("floor", disk.circle(0.3), s.ground.plane(), friction=mu)
    s.force("F", disk.origin, (Fraction(3) * Fraction(str(mu)) * Fraction(str(m)) * Fraction(str(g)), 0, 0))
    return s, {"y": 0.3}


def just_held(mu, m, g):
    """A block on two corners, on an incline with tan α = μ."""
    s, block = planar(fb.box(m, (0.4, 0.1, 0.1)))
    s.parameters(alpha=float(np.arctan(mu)))
    s.gravity = (f"{g}*sin(alpha)", f"-{g}*cos(alpha)", 0)
    s.contact("floor", block.corners(size=(0.4, 0.1)), s.ground.plane(), friction=mu)
    return s, {"y": 0.05}


def just_leaning(mu, m, g):
    """A ladder at a smooth wall, with tan θ = 1/(2 μ)."""
    angle = float(np.arctan(1 / (2 * mu)))
    s, ladder = planar(fb.slender_bar(m, 2, axis="x"))
    s.gravity = (0, -g, 0)
    s.contact("floor", ladder.point(1, 0, 0), s.ground.plane(), friction=mu)
    s.contact("wall", ladder.point(-1, 0, 0), s.ground.plane(normal="x"))
    return s, {"phi": -angle, "x": float(np.cos(angle)), "y": float(np.sin(angle))}


def just_standing(mu, m, g, part=1):
    """A box pushed at its top by the force that tips it: no normal force is left at one corner."""
    s, box = planar(fb.box(m, (0.2, 0.5, 0.1)))
    s.gravity = (0, -g, 0)
    s.contact("floor", box.corners(size=(0.2, 0.5)), s.ground.plane(), friction=mu)
    s.force("F", box.point(0, 0.25, 0), (part * Fraction(str(m)) * Fraction(str(g)) / 5, 0, 0))
    return s, {"y": 0.25}


def just_light(mu, m, g):
    """A box lifted by its weight: no normal force at all."""
    s, box = planar(fb.box(m, (0.2, 0.5, 0.1)))
    s.gravity = (0, -g, 0)
    s.contact("floor", box.corners(size=(0.2, 0.5)), s.ground.plane(), friction=mu)
    s.force("F", box.origin, (0, Fraction(str(m)) * Fraction(str(g)), 0))
    return s, {"y": 0.25}


@pytest.mark.parametrize(("mu", "m", "g"), [(0.2, 1, 9.81), (0.7, 0.013, 1.62), (1.3, 3e5, 3.7)])
@pytest.mark.parametrize("made", [just_rolling, just_held, just_leaning, just_standing, just_light])
def test_round_off_decides_nothing_at_a_limit(made, mu, m, g):
    s, start = made(mu, m, g)
    motion = fb.simulate(s, 1.0, initial=start)
    assert motion.status == "finished"
    changes = len(motion.modes) - len({one.contact for one in motion.modes})
    assert changes <= (
        made is just_standing
    )  # a corner that weighs nothing may count as touching at first or later
    if made is not just_rolling:
        for name, value in start.items():
            assert np.abs(motion[name] - value).max() < 1e-9


def test_beyond_the_limit_the_box_tips():
    s, start = just_standing(0.5, 2, 9.81, part=Fraction(1001, 1000))
    assert fb.simulate(s, 1.0, initial=start)["phi"][-1] < -1e-3


@pytest.mark.parametrize("made", [just_held, just_standing, just_light])
def test_a_huge_friction_is_no_bare_error(made):
    s, start = made(1e10, 1, 9.81)
    assert fb.simulate(s, 1.0, initial=start).status == "finished"
