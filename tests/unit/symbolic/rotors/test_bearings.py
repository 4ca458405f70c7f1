"""Bearing reactions of rotors: against a machine with two real bearings, and by formula; what is refused."""

from __future__ import annotations

import numpy as np
import pytest
import sympy

import freebody as fb
from freebody.describe.description import names_of
from freebody.errors import ModelError
from freebody.testing import random_inertia

A, B = 0.7, -0.4  # places of the bearings along the shaft
TOLERANCE = 1e-11
MOTION = 1000 * TOLERANCE


def rotor(seed):
    """A rotor of any mass distribution."""
    rng = np.random.default_rng(seed)
    inertia = random_inertia(rng)
    return fb.MassProperties(float(rng.uniform(1, 5)), rng.uniform(-0.2, 0.2, 3).tolist(), inertia)


def on_hinge(properties):
    s = fb.System("rotor")
    s.gravity = (0.3, -9.81, 1.2)
    body = s.body("rotor", properties)
    s.hinge("axle", s.ground, body, axis="z", coordinate="theta")
    s.torque("motor", s.joints["axle"], "2 - t")
    return s


@pytest.mark.parametrize("seed", range(3))
def test_two_real_bearings(seed):
    """Bearing A is a gimbal, B keeps the shaft in line: two conditions, whose moments are those of its force.

    The condition is a couple, R_B at B and -R_B at A: the gimbal carries what is left, and R_B besides.
    """
    properties = rotor(seed)
    start = {"theta": 0.4, "theta'": 20.0}
    hinged = on_hinge(properties)
    motion = fb.simulate(hinged, 0.5, initial=start, tolerance=TOLERANCE, samples=11)
    felt = fb.bearing_reactions(hinged, "axle", at={"A": A, "B": B}).along(motion)

    s = fb.System("two bearings")
    s.gravity = hinged.gravity
    body = s.body("rotor", properties)
    s.gimbal("A", s.ground, body, at=(0, 0, A), to=(0, 0, A), axis="XYZ", coordinate="alpha beta theta")
    s.constrain(s.expression("alpha"), name="M_x")
    s.constrain(s.expression("beta"), name="M_y")
    s.generalized_force("theta", "2 - t")
    free = fb.simulate(s, 0.5, initial=start, tolerance=TOLERANCE, samples=11)
    np.testing.assert_allclose(motion["theta"], free["theta"], rtol=MOTION, atol=MOTION)
    # (B - A) Z x R_B = (M_x, M_y, 0)
    R_B = np.stack([free.multipliers["M_y"], -free.multipliers["M_x"]], axis=-1) / (B - A)
    size = np.abs(felt["B"]).max()
    np.testing.assert_allclose(felt["B"][:, :2], R_B, rtol=0, atol=MOTION * size)
    R_A = free.reactions["A"].force[:, :2] - R_B
    np.testing.assert_allclose(felt["A"][:, :2], R_A, rtol=0, atol=MOTION * size)
    np.testing.assert_allclose(felt["A"][:, 2], 0, atol=MOTION * size)


def unbalanced():
    s = fb.System("unbalanced")
    m, R, L, e, z, beta, g = s.parameters(m=2, R=0.1, L=0.4, e=0.001, z=0.05, beta=0.1, g=9.81)
    s.gravity = (0, -g, 0)
    disk = fb.disk(m, R).rotated(fb.Rotation.axis_angle("x", -beta)).moved((e, 0, z))
    s.hinge("axle", s.ground, s.body("disk", disk), axis="z", coordinate="theta")
    return s


def test_reactions_in_symbols_and_along_a_motion():
    s = unbalanced()
    found = fb.bearing_reactions(s, s.joints["axle"], at={"A": "L/2", "B": "-L/2"})
    assert found.names == ("A", "B") and found.axial == 0 and found.torque == 0
    start = {"theta": 0.3, "theta'": 7.0}
    motion = fb.simulate(s, 0.2, initial=start, tolerance=TOLERANCE)
    atoms = names_of(s).atoms
    acceleration = fb.equations(s).speeds[0].diff()
    here = {acceleration: fb.equations(s).solve("theta''")["theta''"]}
    here = {acceleration: here[acceleration]}
    state = {atoms["theta'"]: float(motion["theta'"][-1]), atoms["theta"]: float(motion["theta"][-1])}
    values = {atoms[name]: value for name, value in motion.values.items()}
    turn = np.array([[np.cos(x), -np.sin(x)] for x in motion["theta"][-1:]])
    for name, forces in found.along(motion).items():
        closed = found.ground[name].xreplace(here).xreplace(state).xreplace(values)
        np.testing.assert_allclose(np.array(closed, dtype=float)[:, 0], forces[-1], rtol=MOTION, atol=MOTION)
        rotating = found.rotating[name].xreplace(here).xreplace(state).xreplace(values)
        x = turn @ np.array(rotating[:2], dtype=float)
        np.testing.assert_allclose(x, forces[-1, 0], rtol=MOTION, atol=MOTION)


def test_any_speed():
    """``under`` puts a given motion into the reactions: theta, theta' and theta'' at once."""
    s = unbalanced()
    found = fb.bearing_reactions(s, "axle", at={"A": "L/2", "B": "-L/2"})
    x = found.under("3*t^2")["A"]
    t, m, e, L, z, R, beta = (s.expression(n) for n in ("t", "m", "e", "L", "z", "R", "beta"))
    theta = 3 * t**2
    expected = -m * e * (sympy.Rational(1, 2) + z / L) * (36 * t**2 * sympy.cos(theta) + 6 * sympy.sin(theta))
    tilt = m * R**2 * sympy.sin(beta) * sympy.cos(beta) / (4 * L)
    expected += tilt * (6 * sympy.cos(theta) - 36 * t**2 * sympy.sin(theta))
    ring = fb.equations(s).ring
    assert ring.from_sympy(x[0] - expected) == 0
    y = found.under("3*t^2")["A"][1]
    turned = found.under("3*t^2", rotating=True)["A"]
    back = turned[0] * sympy.cos(theta) - turned[1] * sympy.sin(theta)
    assert ring.from_sympy(back - expected) == 0
    assert ring.from_sympy(turned[0] * sympy.sin(theta) + turned[1] * sympy.cos(theta) - y) == 0


@pytest.mark.parametrize("axis", [(1, 2, 2), (1, 1, 0)])
def test_an_oblique_shaft(axis):
    """The sum of the forces and their moment about the hinge are the reaction of the hinge, across the shaft."""
    s = fb.System("oblique")
    s.gravity = (1, -9, 2)
    s.hinge("axle", s.ground, s.body("rotor", rotor(5)), axis=axis, coordinate="theta")
    motion = fb.simulate(s, 0.3, initial={"theta'": 9.0}, samples=4)
    found = fb.bearing_reactions(s, "axle", at={"A": A, "B": B})
    felt, hinge = found.along(motion), motion.reactions["axle"]
    n = np.array(axis) / np.linalg.norm(axis)
    across = np.eye(3) - np.outer(n, n)
    np.testing.assert_allclose(felt["A"] + felt["B"], hinge.force @ across, atol=1e-9)
    moment = np.cross(n, A * felt["A"] + B * felt["B"])
    np.testing.assert_allclose(moment, hinge.moment @ across, atol=1e-9)


def test_a_driven_shaft():
    """Its angle is given: reactions are functions of time, and the torque is one of them."""
    s = fb.System("driven")
    m, e, g, omega = s.parameters(m=2, e=0.1, g=9.81, omega=3)
    s.gravity = (0, -g, 0)
    s.hinge("axle", s.ground, s.body("bob", fb.particle(m).moved((e, 0, 0))), coordinate=omega * s.t)
    found = fb.bearing_reactions(s, "axle", at={"A": 1, "B": -1})
    assert found.torque == m * g * e * sympy.cos(omega * s.t)
    with pytest.raises(
        ModelError, match="Expected the angle of 'axle' to be a coordinate of its own, got .*: its motion"
    ):
        found.under("t")


def test_a_driven_shaft_is_simulated_and_saved(tmp_path):
    """Nothing is integrated; reactions and the file are there all the same."""
    s = fb.System("driven")
    s.gravity = (0, -9.81, 0)
    s.hinge("axle", s.ground, s.body("bob", fb.particle(2).moved((0.1, 0, 0))), coordinate=3 * s.t)
    motion = fb.simulate(s, 1.0, samples=5)
    np.testing.assert_allclose(
        motion.reactions["axle"].moment[:, 2], 2 * 9.81 * 0.1 * np.cos(3 * motion.t), rtol=1e-12
    )
    felt = fb.bearing_reactions(s, "axle", at={"A": 1, "B": -1}).along(motion)
    np.testing.assert_allclose(felt["A"], felt["B"], rtol=1e-12)
    motion.save(tmp_path / "driven.nc")
    assert fb.Trajectory.load(tmp_path / "driven.nc")["time"].size == 5


def test_display():
    found = fb.bearing_reactions(unbalanced(), "axle", at={"left": "L/2", "right": "-L/2"})
    assert found.text().startswith(
        "Forces of the bearings on the shaft of 'disk': left_x in ground axes, left_x' in its own"
    )
    assert "right_y' = " in repr(found) and "left_z" not in repr(found).split("\n", 1)[1]
    assert found.latex().startswith("\\begin{aligned}") and "<use" in found.html()
    assert found._repr_latex_().startswith("$")


REFUSALS = {
    "unknown joint": (("axel", {"A": 1, "B": 0}), "Unknown joint 'axel'; did you mean 'axle'"),
    "one bearing": (
        ("axle", {"A": 1}),
        "Expected two bearings along the shaft, got 1: A. More than two are statically",
    ),
    "three": (("axle", {"A": 1, "B": 0, "C": -1}), "Expected two bearings along the shaft, got 3: A, B, C"),
    "one place": (
        ("axle", {"A": 1, "B": 1}),
        "Expected two bearings at different places, got 'A' and 'B' at one",
    ),
    "no names": (
        ("axle", (1, -1)),
        "Expected the bearings by name with their distances along the shaft from joint 'axle'",
    ),
    "unknown name": (("axle", {"A": "L2", "B": 0}), "In the bearings: Expected a known name, got 'L2'"),
}


@pytest.mark.parametrize("case", REFUSALS)
def test_refusals(case):
    (joint, at), message = REFUSALS[case]
    with pytest.raises(ModelError, match=message):
        fb.bearing_reactions(unbalanced(), joint, at=at)


def test_only_hinges_are_shafts():
    s = fb.System("ball")
    s.ball("socket", s.ground, s.body("b", fb.sphere(1, 1)))
    with pytest.raises(
        ModelError,
        match="Expected a hinge, which two bearings of a shaft form together, got the ball 'socket'",
    ):
        fb.bearing_reactions(s, "socket", at={"A": 1, "B": -1})
