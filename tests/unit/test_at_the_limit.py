"""Loads that are just at the limit of friction: one decision, stick at equality."""

from __future__ import annotations

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
