"""Balancing of rotors: corrections in two planes and in one, in symbols and numbers, checked by simulation."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from freebody.errors import ModelError
from freebody.testing import random_inertia

PLANES = {"left": 0.3, "right": -0.5}
BEARINGS = {"A": 0.7, "B": -0.6}


def spun(properties, corrections=()):
    """A rotor with correction masses welded to it, without weight."""
    s = fb.System("rotor")
    body = s.body("rotor", properties)
    s.hinge("axle", s.ground, body, at=(0.1, 0, 0), to=(0, 0, 0.2), axis="z", coordinate="theta")
    for i, (mass, place) in enumerate(corrections):
        lead = s.body(f"lead_{i}", fb.particle(mass))
        s.weld(f"on_{i}", body, lead, at=(place[0], place[1], place[2] + 0.2))
    return s


def rotor(seed):
    rng = np.random.default_rng(seed)
    return fb.MassProperties(
        float(rng.uniform(1, 5)), rng.uniform(-0.2, 0.2, 3).tolist(), random_inertia(rng)
    )


def largest(s):
    """Largest bearing force while the shaft turns at 50 rad/s [N]."""
    motion = fb.simulate(s, 0.3, initial={"theta'": 50.0}, tolerance=1e-10, samples=31)
    return max(
        np.abs(force).max() for force in fb.bearing_reactions(s, "axle", at=BEARINGS).along(motion).values()
    )


@pytest.mark.parametrize("seed", range(3))
def test_two_planes_remove_the_dynamic_reactions(seed):
    properties = rotor(seed)
    before = spun(properties)
    found = fb.balance(before, "axle", planes=PLANES)
    masses = found.masses(radius=0.15)
    for name, (mass, place) in masses.items():
        assert (
            mass > 0
            and np.hypot(*place[:2]) == pytest.approx(0.15)
            and place[2] == pytest.approx(PLANES[name])
        )
    after = spun(properties, masses.values())
    assert largest(after) < 1e-10 * largest(before)
    # nothing is left to correct
    left = fb.balance(after, "axle", planes=PLANES).masses(radius=0.15)
    assert max(mass for mass, _ in left.values()) < 1e-13


@pytest.mark.parametrize("seed", range(3))
def test_one_plane_leaves_a_couple(seed):
    """Static balance: the sum of the bearing forces vanishes, their couple is ω² times the product moment left."""
    properties = rotor(seed)
    found = fb.balance(spun(properties), "axle", planes={"only": 0.1})
    after = spun(properties, found.masses(radius=0.2).values())
    motion = fb.simulate(after, 0.1, initial={"theta'": 50.0}, tolerance=1e-10, samples=3)
    felt = fb.bearing_reactions(after, "axle", at=BEARINGS).along(motion)
    size = np.abs(felt["A"]).max()
    assert np.abs(felt["A"] + felt["B"]).max() < 1e-10 * size
    couple = np.linalg.norm(felt["A"], axis=1) * (BEARINGS["A"] - BEARINGS["B"])
    expected = 50.0**2 * np.linalg.norm(np.array(found.left, dtype=float))
    np.testing.assert_allclose(couple, expected, rtol=1e-9)


def test_an_oblique_shaft_in_a_rotor_of_two_bodies():
    """The shaft is no axis of the body, and a second body is welded on: both turn, and both are balanced."""

    def machine(corrections=()):
        s = fb.System("rotor")
        hub, blade = s.body("hub", rotor(7)), s.body("blade", fb.slender_bar(0.7, 0.5, axis="x"))
        s.hinge("axle", s.ground, hub, axis=(1, 2, 2), coordinate="theta")
        s.weld("root", hub, blade, at=(0.3, 0.1, 0.2), parent_axes=fb.Rotation.axis_angle((1, 1, 0), 0.6))
        for i, (mass, place) in enumerate(corrections):
            s.weld(f"on_{i}", hub, s.body(f"lead_{i}", fb.particle(mass)), at=place)
        return s

    before = machine()
    after = machine(fb.balance(before, "axle", planes=PLANES).masses(radius=0.1).values())
    assert largest(after) < 1e-10 * largest(before)


def test_in_symbols():
    """A disk off the shaft by e at z: -m e shared by the lever rule; a tilted one needs a couple."""
    s = fb.System("rotor")
    m, R, e, z, a, beta = s.parameters(m=2, R=0.1, e=0.001, z=0.05, a=0.2, beta=0.1)
    tilted = fb.disk(m, R).rotated(fb.Rotation.axis_angle("x", -beta)).moved((e, 0, z))
    s.hinge("axle", s.ground, s.body("disk", tilted), coordinate="theta")
    found = fb.balance(s, "axle", planes={"U": a, "W": -a})
    ring = fb.equations(s).ring
    I_yz = -m * R**2 / 4 * fb.exact.elementary.sin(beta) * fb.exact.elementary.cos(beta)
    expected = {
        "U": (-m * e * (a + z) / (2 * a), -I_yz / (2 * a), 0),
        "W": (-m * e * (a - z) / (2 * a), I_yz / (2 * a), 0),
    }
    for name, vector in expected.items():
        assert all(ring.from_sympy(x - y) == 0 for x, y in zip(found.corrections[name], vector, strict=True))
    S, P = found.unbalance
    assert ring.from_sympy(S[0] - m * e) == 0 and ring.from_sympy(P[1] - I_yz) == 0
    assert list(found.left) == [0, 0, 0]
    assert found.text().splitlines()[1].startswith("  U_x = ") and "<use" in found.html()
    assert "U_{x} &= " in found.latex() and found._repr_latex_().startswith("$")
    one = fb.balance(s, "axle", planes={"U": z})
    assert ring.from_sympy(one.left[0]) == 0 and ring.from_sympy(one.left[1] - I_yz) == 0


def test_a_balanced_rotor():
    s = fb.System("rotor")
    s.hinge("axle", s.ground, s.body("disk", fb.disk(1, 1)), coordinate="theta")
    found = fb.balance(s, "axle", planes=PLANES)
    assert "none: the rotor is balanced" in found.text()
    assert found.masses(0.1) == {"left": (0.0, (0.0, 0.0, 0.3)), "right": (0.0, (0.0, 0.0, -0.5))}


def test_refusals():
    s = fb.System("rotor")
    (r,) = (s.parameters(r=0.1),)
    disk = s.body("disk", fb.disk(1, 1).moved((0.1, 0, 0)))
    axle = s.hinge("axle", s.ground, disk, coordinate="theta")
    with pytest.raises(ModelError, match="Expected a positive radius of the correction masses, got -0.1 m"):
        fb.balance(s, axle, planes=PLANES).masses(-r)
    with pytest.raises(ModelError, match="Expected two correction planes along the shaft, got 3"):
        fb.balance(s, axle, planes={"a": 1, "b": 2, "c": 3})
    with pytest.raises(ModelError, match="Expected the correction planes by name with their distances"):
        fb.balance(s, axle, planes={})
    s.hinge(
        "flap",
        disk,
        s.body("blade", fb.slender_bar(1, 1, axis="x")),
        at=(0.5, 0, 0),
        axis="y",
        coordinate="b",
    )
    with pytest.raises(
        ModelError, match="Expected a rigid rotor on 'axle', but 'flap' lets a part of it move. Weld it"
    ):
        fb.balance(s, axle, planes=PLANES)
