"""Joints by functions: beads on curves and surfaces with closed forms, a knee, and the words of refusals."""

# ruff: noqa: E501 (tables: one case, one line)

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from freebody.dynamics import float_state, forward_dynamics
from freebody.dynamics.newton_euler import reactions
from freebody.errors import ModelError

from ....laws.test_laws_free_bodies import check, on_a_motion

EPS = np.finfo(float).eps
EXACT = 2**12 * EPS


def bead(coordinate, position, **given):
    s = fb.System("bead")
    m, g = s.parameters(m=2, g=9.81)
    s.gravity = (0, -g, 0)
    body = s.body("bead", fb.particle(m))
    s.path_joint("wire", s.ground, body, coordinate=coordinate, position=position, **given)
    return s


def test_the_cycloid_is_isochronous():
    """x = a(p + sin p), y = a(1 - cos p): the arc 4 a sin(p/2) swings with the period 4 pi sqrt(a/g) from every height."""
    s = fb.System("cycloid")
    a, g = s.parameters(a=0.4, g=9.81)
    s.gravity = (0, -g, 0)
    body = s.body("bead", fb.particle(1))
    s.path_joint("wire", s.ground, body, coordinate="p", position=("a*(p + sin(p))", "a*(1 - cos(p))", 0))
    period = 4 * np.pi * np.sqrt(0.4 / 9.81)
    for start in (0.1, 1.0, 2.5):
        motion = fb.simulate(s, until=period, initial={"p": start}, tolerance=1e-12)
        assert motion["p"][-1] == pytest.approx(start, abs=1e-9)
        assert motion["p"].min() == pytest.approx(-start, abs=1e-3)  # among the samples


def test_a_bead_on_a_helix_slides_uniformly_accelerated():
    """p'' = -g c / (r² + c²), and the wire's force across it is the weight's part and the centripetal force."""
    s = fb.System("helix")
    r, c, g = s.parameters("r c g")
    s.gravity = (0, 0, -g)
    body = s.body("bead", fb.particle(1))
    s.path_joint("wire", s.ground, body, coordinate="p", position=("r*cos(p)", "r*sin(p)", "c*p"))
    eq = fb.equations(s)
    R, C, G = 0.7, 0.2, 9.81
    state = float_state(eq.model, [0.8], [1.5], values={"r": R, "c": C, "g": G})
    (udot,) = forward_dynamics(eq.model, state)
    assert float(udot) == pytest.approx(float(-G * C / (R**2 + C**2)), rel=EXACT)
    force, moment = reactions(eq.model, state, [udot])["wire"]
    tangent = np.array([-0.7 * np.sin(0.8), 0.7 * np.cos(0.8), 0.2])
    assert np.dot(np.array(force, float), tangent) == pytest.approx(0, abs=EXACT * 10)
    inward = -0.7 * 1.5**2 * np.array([np.cos(0.8), np.sin(0.8), 0])
    whole = inward + np.array([0, 0, 9.81]) + float(udot) * tangent
    np.testing.assert_allclose(np.array(force, float), whole, rtol=0, atol=EXACT * 10)
    assert not np.any(np.array(moment, float))


def knee(explicit=False):
    """A shin whose point moves on a curve as it turns, after the functions of a knee; with a foot on a hinge."""
    s = fb.System("knee")
    s.gravity = (1, -3, 2)
    shin, foot = s.body("shin", fb.box(2, (1, 3, 1))), s.body("foot", fb.box(1, (2, 1, 1)))
    if explicit:
        (q,) = [s.coordinates("q")]
        between = [s.body(f"m{k}", fb.particle(0)) for k in range(2)]
        s.slider("a", s.ground, between[0], axis="x", coordinate="q/10 - q^2/5")
        s.slider("b", between[0], between[1], axis="y", coordinate="q^3/7 - q/4")
        s.hinge("c", between[1], shin, to=(0, 1, 0), coordinate=q)
    else:
        s.path_joint(
            "knee",
            s.ground,
            shin,
            to=(0, 1, 0),
            coordinate="q",
            position=("q/10 - q^2/5", "q^3/7 - q/4", 0),
            turns=[("z", "q")],
        )
    s.hinge("ankle", shin, foot, at=(0, -1, 0), to=(1, 0, 0), axis="z", coordinate="r")
    s.generalized_force("q", "2*t - 1")
    s.generalized_force("r", 3)
    return s


def test_a_knee_moves_as_its_parts_and_carries_what_they_carry():
    one, parts = fb.assemble(knee()), fb.assemble(knee(explicit=True))
    q, u = [0.7, -0.4], [1.2, 0.3]
    a, b = float_state(one, q, u, 0.3), float_state(parts, q, u, 0.3)
    udot = forward_dynamics(one, a)
    np.testing.assert_allclose(udot, forward_dynamics(parts, b), rtol=EXACT)
    np.testing.assert_allclose(fb.compile(one).forward_dynamics(q, u, 0.3), udot, rtol=EXACT)


def test_six_equations_hold_with_the_reaction_of_a_knee_and_of_a_puck_on_a_surface():
    for s, freedom in ((knee(), 1), (surface(), 2)):
        eq, values, condition = on_a_motion(s, 3)
        check(eq, values, EXACT * condition)
        name = next(iter(s.joints))
        assert len(eq.reactions[name].components) == 6 - freedom


def surface():
    s = fb.System("puck on a saddle")
    s.gravity = (0, 1, -3)
    puck = s.body("puck", fb.box(2, (1, 2, 3)))
    s.path_joint("bowl", s.ground, puck, coordinate="u v", position=("u", "v", "u^2 - v^2/3"), to=(1, 0, 2))
    return s


def test_a_program_of_a_saddle_conserves_energy():
    s = surface()
    motion = fb.simulate(s, until=1, initial={"u": 0.3, "v": 0.1}, tolerance=1e-11)
    energy = motion.energy.total
    assert np.ptp(energy) < 1e-8


CASES = [
    ({"position": (1, 2, 0)}, "The pose of path joint 'wire' does not depend on its coordinate 'wire'. Give position= or turns= with it"),
    ({"coordinate": "a b c"}, "Expected the name of a coordinate, or of two, for path joint 'wire', such as 'q', got 'a b c'."),
    ({"coordinate": "q", "position": ("q", "typo", 0)}, "typo"),
    ({"coordinate": "q", "position": ("q'", 0, 0)}, "a displacement may depend on coordinates, parameters and time, not on q'."),
    ({"coordinate": "q", "turns": ["z"]}, "Expected turns such as [('z', 'q')], axis and angle, for path joint 'wire', got ['z']."),
    ({"coordinate": "q", "turns": [((0, 0, 0), "q")]}, "The axis of turn 1 of path joint 'wire' has length zero."),
]  # fmt: skip


@pytest.mark.parametrize(("given", "words"), CASES, ids=range(len(CASES)))
def test_refusals(given, words):
    s = fb.System("bead")
    body = s.body("bead", fb.particle(1))
    with pytest.raises(fb.FreebodyError) as error:
        s.path_joint("wire", s.ground, body, **given)
    assert words in str(error.value)
    assert not s.joints
    s.path_joint("wire", s.ground, body, coordinate="q", position=("q", 0, 0))


def test_a_path_closes_no_loop_and_has_no_displacement_for_springs():
    s = bead("q", ("q", "q^2", 0))
    with pytest.raises(ModelError, match="Path joint 'wire' has no single displacement for"):
        s.spring("k", s.joints["wire"], stiffness=2)
    with pytest.raises(
        ModelError, match="Path joint 'second' closes a loop, which joints of this type cannot."
    ):
        s.path_joint("second", s.ground, s.bodies["bead"], coordinate="r", position=("r", 0, 0))
