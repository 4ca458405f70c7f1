"""Rotors whose angle stands in no equation: the same accelerations as without the shortcut."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from freebody.dynamics.rotors import is_symmetric


def machine(rotor, load=None):
    """A rotor in two gimbals, off the pivot."""
    s = fb.System("gimbals")
    s.gravity = (0.3, -0.2, -9.81)
    outer = s.body("outer", fb.MassProperties(0.5, (0.1, 0, 0), ((2e-3, 0, 0), (0, 3e-3, 0), (0, 0, 4e-3))))
    body = s.body("rotor", rotor)
    s.universal("stand", s.ground, outer, axis=("z", "x"), coordinate="a b")
    spin = s.hinge("spin", outer, body, at=(0, 0.05, 0.2), axis="z", coordinate="c")
    s.damper("drag", spin, damping=0.1)
    if load == "force":
        s.force("push", body.point(0, 0.1, 0.05), (1, 2, 3), frame=body)
    if load == "torque":
        s.torque("twist", body, (1, 2, 3))
    return s


SYMMETRIC = fb.cylinder(2, 0.1, 0.3, axis="z")
OTHERS = {
    "flattened": fb.MassProperties(2, (0, 0, 0), ((0.02, 0, 0), (0, 0.03, 0), (0, 0, 0.04))),
    "off its hinge": fb.MassProperties(2, (0.01, 0, 0), ((0.02, 0, 0), (0, 0.02, 0), (0, 0, 0.03))),
    "skew": fb.MassProperties(2, (0, 0, 0), ((0.02, 0, 1e-3), (0, 0.02, 0), (1e-3, 0, 0.03))),
}


@pytest.mark.parametrize("load", [None, "force", "torque"])
@pytest.mark.parametrize("rotor", [SYMMETRIC, *OTHERS.values()], ids=["symmetric", *OTHERS])
def test_accelerations_are_those_of_the_mass_matrix(rotor, load):
    program = fb.compile(machine(rotor, load))
    random = np.random.default_rng(5)
    for _ in range(5):
        q, u = random.uniform(-1.2, 1.2, 3), random.uniform(-5, 5, 3)
        expected = np.linalg.solve(program.mass_matrix(q), -program.bias(q, u))
        np.testing.assert_allclose(program.forward_dynamics(q, u), expected, rtol=1e-11, atol=1e-10)


def test_only_symmetric_masses_are_taken():
    assert is_symmetric(fb.assemble(machine(SYMMETRIC)).links[-1])
    for rotor in OTHERS.values():
        assert not is_symmetric(fb.assemble(machine(rotor)).links[-1])


def test_the_angle_costs_no_sine():
    with_angle = fb.compile(machine(OTHERS["flattened"])).describe("forward_dynamics")
    without = fb.compile(machine(SYMMETRIC)).describe("forward_dynamics")
    assert "3 sincos" in with_angle and "2 sincos" in without
