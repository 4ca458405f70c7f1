"""Chains of primitive motions: two of them that have names, and what they look like."""

from __future__ import annotations

import sympy

import freebody as fb
from freebody.describe.joints.pair import parallel_turns
from freebody.dynamics.joints.motions import dual


def test_two_hinges_of_one_body_are_a_double_pendulum_whose_first_rod_has_no_mass():
    s = fb.System("leg")
    m, a, b, g = s.parameters("m a b g")
    s.gravity = (0, -g, 0)
    foot = s.body("foot", fb.particle(m))
    s.chain("leg", s.ground, foot, [fb.Hinge("z", "p"), fb.Hinge("z", "q", at=(0, -a, 0))], to=(0, a + b, 0))
    p, q = sympy.symbols("p q")
    K = fb.equations(s)
    M = K.mass_matrix.subs({s.expression("p"): p, s.expression("q"): q})
    expected = [
        [m * (a**2 + b**2 + 2 * a * b * sympy.cos(q)), m * (b**2 + a * b * sympy.cos(q))],
        [m * (b**2 + a * b * sympy.cos(q)), m * b**2],
    ]
    assert sympy.simplify(M - sympy.Matrix(expected)) == sympy.zeros(2)


def test_turns_about_parallel_axes_are_one_turn_and_a_slide():
    motions = [
        fb.Hinge((0, 0, 1)),
        fb.Slider((1, 0, 0)),
        fb.Hinge((0, 0, -1)),
        fb.Hinge((1, 0, 0)),
        fb.Hinge((0, 0, 1)),
    ]
    assert parallel_turns(motions) == ((0, 1), (1, 1), (0, -1), (3, 1), (4, 1))


def test_dual_vectors():
    vectors = [(1, 2, 2), (0, 3, 4), (2, 0, 1)]
    for count in (1, 2, 3):
        pairs = dual([tuple(map(sympy.Integer, v)) for v in vectors[:count]])
        for i, a in enumerate(vectors[:count]):
            for j, b in enumerate(pairs):
                assert sum(x * y for x, y in zip(a, b, strict=True)) == (i == j)


def test_a_chain_is_drawn_and_tabulated():
    s = fb.System("leg")
    foot = s.body("foot", fb.slender_bar(1, 1, axis="y"))
    joint = s.chain("leg", s.ground, foot, [fb.Hinge("x", "roll"), fb.Hinge("y", at=(0, 0, 2))], to=(0, 1, 0))
    assert str(joint) == "chain 'leg' (ground -> foot)"
    assert [str(p.coordinate) for p in joint.primitives] == ["roll(t)", "leg_2(t)"]
    assert "foot" in fb.draw(s).svg
