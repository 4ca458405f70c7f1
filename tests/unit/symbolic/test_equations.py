"""The symbolic products: what they are, that they agree, and that nothing is computed before it is asked for."""

from __future__ import annotations

import pytest
import sympy

import freebody as fb
from freebody.describe.description import parameters_of
from freebody.gallery import entries
from freebody.testing import random_chain


@pytest.fixture
def oscillator():
    """Mass on a spring and a damper, pushed by a force, with a motor on the rail."""
    s = fb.System("oscillator")
    m, k, c, F, P = s.parameters("m k c F P")
    block = s.body("block", fb.particle(m))
    rail = s.slider("rail", s.ground, block, coordinate="x")
    s.spring("k", rail, stiffness=k)
    s.damper("c", rail, damping=c)
    s.force("F", block, (F, 0, 0))
    s.force("P", rail, P)
    return s, fb.equations(s)


def test_springs_and_dampers_left_applied_loads_right(oscillator):
    s, eq = oscillator
    m, k, c, F, P = (p.symbol for p in parameters_of(s))
    (x,) = eq.coordinates
    (motion,) = eq.motion
    assert motion.lhs == m * x.diff(s.t, 2) + c * x.diff(s.t) + k * x
    assert motion.rhs == F + P
    assert eq.bias == sympy.ImmutableMatrix([c * x.diff(s.t) + k * x - F - P])
    assert eq.mass_matrix == sympy.ImmutableMatrix([[m]])
    assert eq.speeds == (x.diff(s.t),)
    assert eq.text() == "m*x'' + c*x' + k*x = F + P"
    assert "c" in repr(eq) and repr(eq).startswith("Equations of motion of 'oscillator'\n")


def test_latex_aligns_at_the_equal_sign(oscillator):
    _, eq = oscillator
    latex = eq.latex()
    assert latex.startswith("\\begin{aligned}\n") and latex.endswith("\n\\end{aligned}")
    assert latex.count(" &= ") == 1
    assert "\\ddot{x}" in latex and "\\dot{x}" in latex
    assert eq._repr_latex_() == f"$\\displaystyle {latex}$"
    assert "<use" in eq.html()


def test_motion_is_mass_matrix_and_bias():
    eq = fb.equations(random_chain(1, 3))
    udot = sympy.Matrix([speed.acceleration for speed in eq.model.speeds])
    for i, (motion, row) in enumerate(zip(eq.motion, eq.mass_matrix * udot + eq.bias, strict=True)):
        difference = eq.ring.from_sympy(motion.lhs - motion.rhs - row)
        assert difference == 0, i


def test_kinetic_energy_has_the_mass_matrix_as_its_second_derivative():
    eq = fb.equations(random_chain(2, 3))
    T = eq.energy.canonical_kinetic
    for i, a in enumerate(eq.model.speeds):
        for j, b in enumerate(eq.model.speeds):
            second = eq.ring.derivative(eq.ring.derivative(T, a.symbol), b.symbol)
            assert second == eq.canonical_mass_matrix[i][j]


def test_canonical_equations_are_lagranges():
    """d/dt ∂T/∂u - ∂T/∂q + ∂V/∂q = 0 with the ring's own derivatives, identically."""
    eq = fb.equations(random_chain(3, 3))
    ring, T, V = eq.ring, eq.energy.canonical_kinetic, eq.energy.canonical_potential
    rates = {
        q.symbol: ring.generator(u.symbol) for q, u in zip(eq.model.coordinates, eq.model.speeds, strict=True)
    }
    rates |= {u.symbol: ring.generator(u.acceleration) for u in eq.model.speeds}
    for q, u, (left, right) in zip(eq.model.coordinates, eq.model.speeds, eq.balances, strict=True):
        momentum = ring.derivative(T, u.symbol)
        row = (
            ring.total_derivative(momentum, rates)
            - ring.derivative(T, q.symbol)
            + ring.derivative(V, q.symbol)
        )
        assert row - left + right == 0


def test_equal_systems_have_the_same_text():
    """Whatever the order of the factors in the user's expressions."""

    def text(stiffness, center):
        s = fb.System("one")
        s.parameters("a b m")
        bar = s.body("bar", fb.particle(s.expression("m")).moved((s.expression(center), 0, 0)))
        pin = s.hinge("pin", s.ground, bar, coordinate="theta")
        s.spring("k", pin, stiffness=stiffness)
        return fb.equations(s).text()

    assert text("(a + b)**2", "a - b") == text("b*(2*a + b) + a*a", "(a*a - b*b)/(b + a)")


def test_the_spin_angle_of_an_axisymmetric_body_cancels():
    s = fb.System("top")
    m, R, h = s.parameters("m R h")
    s.gravity = (0, 0, "-9.81")
    rotor = s.body("rotor", fb.cylinder(m, R, h))
    s.gimbal("pivot", s.ground, rotor, to=(0, 0, -h), axis="ZXZ", coordinate="psi theta phi")
    eq = fb.equations(s)
    assert not any(name in eq.text() for name in ("(phi)", "(psi)"))


def test_a_ball_joint_gives_eulers_equations():
    s = fb.System("body")
    A, B, C = s.parameters("A B C")
    body = s.body("body", fb.MassProperties(1, (0, 0, 0), ((A, 0, 0), (0, B, 0), (0, 0, C))))
    s.ball("j", s.ground, body)
    eq = fb.equations(s)
    x, y, z = eq.speeds
    rows = [
        A * x.diff(s.t) + (C - B) * y * z,
        B * y.diff(s.t) + (A - C) * z * x,
        C * z.diff(s.t) + (B - A) * x * y,
    ]
    for motion, row in zip(eq.motion, rows, strict=True):
        assert sympy.expand(motion.lhs - motion.rhs - row) == 0
    assert eq.text().splitlines()[0] == "A*j_wx' - (B - C)*j_wy*j_wz = 0"


def test_a_free_sphere():
    s = fb.System("throw")
    m, R, g = s.parameters("m R g")
    s.gravity = (0, 0, -g)
    s.free("air", s.ground, s.body("ball", fb.sphere(m, R)))
    eq = fb.equations(s)
    J = sympy.Rational(2, 5) * m * R**2
    assert eq.mass_matrix == sympy.ImmutableMatrix(sympy.diag(J, J, J, m, m, m))
    assert len(eq.free_body("ball").unknowns) == 0
    assert eq.energy.potential == m * g * sympy.Function("air_z")(s.t)


def test_energy_is_conserved_without_loads():
    """dE/dt = Σ u (M u' + h) identically, and no more."""
    eq = fb.equations(random_chain(4, 3))
    ring = eq.ring
    rates = {
        q.symbol: ring.generator(u.symbol) for q, u in zip(eq.model.coordinates, eq.model.speeds, strict=True)
    }
    rates |= {u.symbol: ring.generator(u.acceleration) for u in eq.model.speeds}
    rate = ring.total_derivative(eq.energy.canonical_kinetic + eq.energy.canonical_potential, rates)
    for u, (left, right) in zip(eq.state.u, eq.balances, strict=True):
        rate = rate - u * (left - right)
    assert rate == 0


def test_momentum_about_points(oscillator):
    s = fb.System("pendulum")
    m, L = s.parameters("m L")
    bob = s.body("bob", fb.particle(m))
    s.hinge("pin", s.ground, bob, at=(1, 0, 0), to=(0, L, 0), coordinate="theta")
    eq = fb.equations(s)
    (theta,) = eq.coordinates
    v = theta.diff(s.t)
    assert eq.momentum.linear == sympy.ImmutableMatrix(
        [m * L * v * sympy.cos(theta), m * L * v * sympy.sin(theta), 0]
    )
    assert eq.momentum.angular((1, 0, 0))[2] == m * L**2 * v
    assert eq.momentum.angular(s.ground.point(1, 0, 0)) == eq.momentum.angular(("1", 0, 0))
    assert eq.momentum.angular(bob) == sympy.zeros(3, 1) == eq.momentum.angular(bob.center)
    about_origin = eq.momentum.angular()[2]
    assert sympy.expand(about_origin - m * L**2 * v - m * L * v * sympy.sin(theta)) == 0


def test_a_driven_machine_has_no_equation_of_motion_but_a_torque():
    s = fb.System("shaft")
    m, R, omega = s.parameters("m R omega")
    disk = s.body("disk", fb.disk(m, R))
    s.hinge("shaft", s.ground, disk, coordinate=omega * s.t**2 / 2)
    eq = fb.equations(s)
    assert (eq.motion, eq.text()) == ((), "")
    assert eq.reactions["shaft"].components["shaft_Mz"] == m * R**2 * omega / 2
    assert eq.energy.kinetic == m * R**2 * omega**2 * s.t**2 / 4


def test_nothing_is_computed_before_it_is_asked_for():
    eq = fb.equations(random_chain(5, 4))
    assert not {"canonical_left", "balances", "motion", "mass_matrix", "canonical_reactions"} & set(vars(eq))
    eq.text()
    assert "balances" in vars(eq) and "motion" not in vars(eq)
    assert eq.balances is eq.balances


def test_a_model_serves_as_well_as_a_system(oscillator):
    s, eq = oscillator
    assert fb.equations(fb.assemble(s)).text() == eq.text()


def test_functions_that_users_write_stand_in_the_equations():
    s = fb.System("drag")
    m, c = s.parameters("m c")
    block = s.body("block", fb.particle(m))
    s.slider("rail", s.ground, block, coordinate="x")
    s.force("drag", block, ("-c*x'*abs(x')", 0, 0))
    eq = fb.equations(s)
    v = eq.speeds[0]
    assert sympy.expand(eq.motion[0].rhs + c * v * sympy.Abs(v)) == 0
    assert eq.text() == "m*x'' = -c*x'*abs(x')"


def test_the_length_of_a_spring_in_space_is_printed_once() -> None:
    """A spring at a body on a ball joint: its squared length stands in every moment, under a root and under a bar."""
    s = fb.System("body on a spring")
    m, k, length = s.parameters(m=2, k=100, length=0.5)
    body = s.body("body", fb.box(m, (1, 2, 3)))
    s.ball("pivot", s.ground, body, to=(0, 0, 1), coordinate="b")
    s.spring("spring", s.ground.point(3, 2, 1), body.point(1, 2, -1), stiffness=k, rest=length)
    e = fb.equations(s)
    shown = e.text()
    assert len(shown) < 5000 and "sqrt(P1)" in shown and "/P1" in shown
    *_, where, last = shown.splitlines()
    assert where == "where" and last.startswith("  P1 = ")
    square = sympy.sympify(last.split(" = ")[1].replace("^", "**"))
    names = sympy.symbols("b_e0 b_e1 b_e2 b_e3")
    # the end is at (1, 2, -2) of the pivot, and at (-1, -2, -2) after half a turn about z
    for attitude, expected in (((1, 0, 0, 0), 4 + 0 + 9), ((0, 0, 0, 1), 16 + 16 + 9)):
        assert square.subs(dict(zip(names, attitude, strict=True))) == expected
    assert r"P_{1} &= " in e.latex() and e.html().count("data-tex") == 4


@pytest.mark.parametrize("name", ["ex-6-5", "prob-6-15", "sec-6-9", "four-bar"])
def test_solved_equations_have_the_accelerations_on_the_left(name: str) -> None:
    """They satisfy the equations of motion and the conditions exactly; every kind of print shows the solution."""
    e = fb.equations(entries()[name].build())
    names = [f"{speed.name}'" for speed in e.model.speeds]
    solution = e.solve(names)
    assert [line.split(" = ")[0] for line in e.text(solved=True).splitlines()] == names
    assert e.latex(solved=True) == solution.latex() and e.html(solved=True) == solution.html()
    accelerations = {speed.acceleration: solution[f"{speed.name}'"] for speed in e.model.speeds}
    if e.model.constraints:
        rates = sympy.Matrix(list(accelerations.values()))
        residuals = list(e.constraint_matrix * rates + e.constraint_bias)
    else:
        residuals = [(equation.lhs - equation.rhs).xreplace(accelerations) for equation in e.motion]
    assert residuals and all(e.ring.from_sympy(x) == 0 for x in residuals)
