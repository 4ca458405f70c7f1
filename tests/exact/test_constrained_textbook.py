"""Constrained machines of the textbooks against their closed forms.

Sources: chapter 6, (6.54); Routh, Advanced Rigid Dynamics (1905), §244 (rolling hoop and disk); Neimark & Fufaev,
Dynamics of Nonholonomic Systems (1972), chapter III (Chaplygin's sleigh); Synge & Griffith, Mechanics (1959), (ladder).
"""

from __future__ import annotations

import math

import numpy as np
import pytest
import sympy

import freebody as fb

MOTION = 1e-8


def test_disk_on_an_incline_in_symbols():
    """(6.54): 3/2 m x'' = m g sin β, with the reactions N = m g cos β and T = -m g sin β / 3."""
    s = fb.System("incline")
    m, R, g, beta = s.parameters(m=1, R=1, g=9.81, beta=0.3)
    s.gravity = (g * sympy.sin(beta), -g * sympy.cos(beta), 0)
    disk = s.body("disk", fb.disk(m, R))
    s.planar("plane", s.ground, disk, coordinate="x y f")
    s.constrain("y - R", name="N")
    s.constrain_speed("x' + R*f'", name="T")
    e = fb.equations(s)
    x2, y2, f2 = (speed.acceleration for speed in e.model.speeds)
    (equation,) = e.eliminated(["x"])
    # -R a common factor: the determinant of the dependent block
    rest = sympy.expand(equation.lhs.xreplace({f2: -x2 / R, y2: 0}) / R)
    expected = sympy.Rational(3, 2) * m * x2 - m * g * sympy.sin(beta)
    assert sympy.simplify(rest / expected) in (1, -1)
    solved = sympy.solve(
        [*e.motion, *(c.lhs.diff(s.t) for c in e.constraints[1:]), y2],
        [x2, y2, f2, *e.multipliers],
        dict=True,
    )[0]
    N, T = e.multipliers
    assert sympy.simplify(solved[x2] - 2 * g * sympy.sin(beta) / 3) == 0
    assert sympy.simplify(solved[N] - m * g * sympy.cos(beta)) == 0
    assert sympy.simplify(solved[T] + m * g * sympy.sin(beta) / 3) == 0


def test_atwood_s_machine_in_symbols():
    s = fb.System("atwood")
    M, m, g, L = s.parameters(M=2, m=1, g=9.81, L=3)
    s.gravity = (0, -g, 0)
    a, b = s.body("a", fb.particle(M)), s.body("b", fb.particle(m))
    s.slider("left", s.ground, a, axis="-y", coordinate="p")
    s.slider("right", s.ground, b, at=(1, 0, 0), axis="-y", coordinate="q")
    s.assume(s.expression("p") > 0, s.expression("q") > 0)
    s.rope([a.origin, s.ground.origin, s.ground.point(1, 0, 0), b.origin], L, name="S")
    e = fb.equations(s)
    p2, q2 = (speed.acceleration for speed in e.model.speeds)
    (equation,) = e.eliminated(["p"])
    found = sympy.solve(equation.lhs.xreplace({q2: -p2}), p2)
    assert [sympy.simplify(x - g * (M - m) / (M + m)) for x in found] == [0]
    tension = sympy.solve(e.motion[0].xreplace({p2: found[0]}), e.multipliers[0])
    assert [sympy.simplify(x - 2 * M * m * g / (M + m)) for x in tension] == [0]


def test_ladder_against_a_smooth_wall():
    """θ'² = 3 g/L (sin θ0 - sin θ); wall 3/4 m g cos θ (3 sin θ - 2 sin θ0), zero at sin θ = 2/3 sin θ0."""
    m, L, g, start = 2.0, 3.0, 9.81, 1.2
    s = fb.System("ladder")
    s.gravity = (0, -g, 0)
    bar = s.body("bar", fb.slender_bar(m, L))
    s.planar("plane", s.ground, bar, coordinate="x y f")
    s.constrain(f"y = {L / 2}*sin(f)", name="floor")
    s.constrain(f"x = {L / 2}*cos(f)", name="wall")
    found = fb.simulate(
        s, 1.5, initial={"f": start}, near={"x": 1, "y": 1}, tolerance=1e-12, events=["sin(f) - 0.2"]
    )
    sine, cosine = np.sin(found["f"]), np.cos(found["f"])
    assert found["f'"] ** 2 == pytest.approx(3 * g / L * (math.sin(start) - sine), abs=MOTION)
    wall = 0.75 * m * g * cosine * (3 * sine - 2 * math.sin(start))
    floor = m * g + m * L / 2 * (-1.5 * g / L * cosine**2 - 3 * g / L * sine * (math.sin(start) - sine))
    assert found.multipliers["wall"] == pytest.approx(wall, abs=10 * MOTION)
    assert found.multipliers["floor"] == pytest.approx(floor, abs=10 * MOTION)
    assert found.energy.relative_residual < 1e-11


@pytest.mark.parametrize("ahead", [0.3, 1.0])
def test_chaplygin_s_sleigh(ahead):
    """Mass centre ahead of the edge: v = V tanh κt, f' = W sech κt, κ = m a V/(I + m a²), W² = m V²/(I + m a²)."""
    m, inertia, V = 2.0, 0.7, 3.0
    k = m * ahead * V / (inertia + m * ahead**2)
    W = V * math.sqrt(m / (inertia + m * ahead**2))
    s = fb.System("sleigh")
    sleigh = s.body("sleigh", fb.MassProperties(m, (ahead, 0, 0), ((1, 0, 0), (0, 1, 0), (0, 0, inertia))))
    s.planar("ice", s.ground, sleigh, coordinate="x y f")
    s.constrain_speed("x'*sin(f) - y'*cos(f)", name="edge")
    begin = -2.0
    found = fb.simulate(
        s, 2, start=begin, tolerance=1e-12,
        initial={"x'": V * math.tanh(k * begin), "f'": W / math.cosh(k * begin)},
    )  # fmt: skip
    v = found["x'*cos(f) + y'*sin(f)"]
    assert v == pytest.approx(V * np.tanh(k * found.t), abs=MOTION)
    assert found["f'"] == pytest.approx(W / np.cosh(k * found.t), abs=MOTION)
    # it turns round, whatever its start: the edge ends up behind
    turned = 2 * W / k * (np.arctan(np.exp(k * found.t)) - math.atan(math.exp(k * begin)))
    assert found["f"] == pytest.approx(turned, abs=MOTION)
    assert found.energy.relative_residual < 1e-11


@pytest.mark.parametrize(
    ("body", "k"), [(fb.disk(1, 0.5), 1 / 2), (fb.ring(1, 0.5), 1)], ids=["disk", "hoop"]
)
def test_a_rolling_wheel_is_stable_above_its_critical_spin(body, k):
    """Straight rolling of a wheel in a light fork: axial inertia C, transverse inertia of both A, mass m.

    Lean θ and turn ψ, spin ω:  (A + m R²) θ'' + (C + m R²) ω ψ' - m g R θ = 0,  A ψ' = C ω θ  (the vertical through the
    contact has no arm), so that  (A + m R²) θ'' = (m g R - C (C + m R²) ω²/A) θ.  Without fork: ω² > g/(3R) for a disk
    and g/(4R) for a hoop.
    """
    m, R, g, fork = 1, 0.5, 9.81, 0.01
    C, A = k * m * R**2, k * m * R**2 / 2 + fork
    critical = math.sqrt(m * g * R * A / (C * (C + m * R**2)))
    s = fb.System("wheel")
    s.gravity = (0, 0, g)
    wheel = s.body("wheel", body)
    # all mass is the wheel's but for a grain, whose weight is below what is asked for
    frame = s.body("fork", fb.MassProperties(1e-12, (0, 0, 0), ((fork, 0, 0), (0, fork, 0), (0, 0, fork))))
    s.free("air", s.ground, frame, to=(0, 0, R))  # speeds are those of the contact point below
    s.hinge(
        "axle",
        frame,
        wheel,
        axis="y",
        coordinate="spin",
        child_axes=fb.Rotation.euler("XYZ", math.pi / 2, 0, 0),
    )
    s.rolling("contact", wheel, radius=R, axis="z", normal="-z")
    model = fb.assemble(s)
    for factor in (0.8, 0.95, 1.05, 1.5):
        w = factor * critical
        linear = fb.linearize(model, about={"air_vx": w * R, "spin'": -w}, values={})
        rate = (m * g * R - C * (C + m * R**2) * w**2 / A) / (A + m * R**2)
        found = linear.eigenvalues()
        expected = math.sqrt(abs(rate)) * (1j if factor > 1 else 1)
        for root in (expected, -expected):
            assert np.abs(found - root).min() < 1e-7 * abs(root)
        # the others are zero: place, heading and spin are free
        assert (found.real.max() < 1e-3) == (factor > 1)
