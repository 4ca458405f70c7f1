"""Display of canonical polynomials: the exact text of textbook equations."""

from __future__ import annotations

import time
from fractions import Fraction

import pytest
import sympy as sp

from freebody.scalar.algebra import add, apply, apply_transpose, cross, dot, scale
from freebody.scalar.polynomial import Ring
from freebody.symbolic.printing.display import (
    Lumps,
    displayed,
    equation_latex,
    equation_text,
    latex,
    text,
)

t = sp.Symbol("t")
M, m, a, k, g, F, L, R = sp.symbols("M m a k g F L R", real=True)
m1, m2, L1, L2 = sp.symbols("m1 m2 L1 L2", real=True)
x, theta, psi, phi, th1, th2 = (sp.Function(n)(t) for n in ("x", "theta", "psi", "phi", "theta1", "theta2"))


def ring_of(parameters, coordinates):
    """A ring whose atoms are declared in this order."""
    ring = Ring()
    for p in parameters:
        ring.generator(p, "parameter")
    for kind, n in (("coordinate", 0), ("speed", 1), ("acceleration", 2)):
        for q in coordinates:
            ring.generator(sp.Derivative(q, (t, n)) if n else q, kind)
    return ring


def lagrange(ring, T, V, coordinates):
    """d/dt ∂T/∂q' - ∂T/∂q + ∂V/∂q, by SymPy, as canonical elements."""
    return [ring.from_sympy(sp.diff(sp.diff(T, q.diff(t)), t) - sp.diff(T - V, q)) for q in coordinates]


def planar_chain(lengths, masses, angles):
    """Kinetic and potential energy of slender bars hung from each other, at absolute angles."""
    T = V = 0
    px = py = sp.Integer(0)
    for length, mass, angle in zip(lengths, masses, angles, strict=True):
        cx, cy = px + length / 2 * sp.sin(angle), py - length / 2 * sp.cos(angle)
        T += mass * (sp.diff(cx, t) ** 2 + sp.diff(cy, t) ** 2) / 2
        T += mass * length**2 / 12 * sp.diff(angle, t) ** 2 / 2
        V += mass * g * cy
        px, py = px + length * sp.sin(angle), py - length * sp.cos(angle)
    return T, V


# ------------------------------------------------------------------------------ textbook systems
def test_example_6_5():
    ring = ring_of([M, m, a, k, g, F], [x, theta])
    v = sp.Matrix([x + a * sp.sin(theta), -a * sp.cos(theta)]).diff(t)
    T = M * x.diff(t) ** 2 / 2 + m * v.dot(v) / 2 + m * (2 * a) ** 2 / 12 * theta.diff(t) ** 2 / 2
    V = k * x**2 / 2 - m * g * a * sp.cos(theta)
    one, two = lagrange(ring, T, V, [x, theta])
    assert text(one, ring) == "(M + m)*x'' + m*a*(theta''*cos(theta) - theta'^2*sin(theta)) + k*x"
    assert text(two, ring) == "m*a*x''*cos(theta) + 4*m*a^2*theta''/3 + m*a*g*sin(theta)"
    assert equation_text(one, ring.generator(F), ring).endswith("+ k*x = F")
    assert latex(one, ring) == (
        r"\left(M + m\right) \ddot{x} + m a \left(\ddot{\theta} \cos\theta"
        r" - \dot{\theta}^{2} \sin\theta\right) + k x"
    )
    assert equation_latex(
        two, 2 * ring.generator(a) * ring.generator(F) * ring.cos(ring.generator(theta)), ring
    ) == (
        r"m a \ddot{x} \cos\theta + \frac{4}{3} m a^{2} \ddot{\theta} + m a g \sin\theta = 2 a F \cos\theta"
    )


def test_double_pendulum_in_absolute_angles():
    ring = ring_of([m1, m2, L1, L2, g], [th1, th2])
    T, V = planar_chain([L1, L2], [m1, m2], [th1, th2])
    one, two = lagrange(ring, T, V, [th1, th2])
    assert text(one, ring) == (
        "(m1/3 + m2)*L1^2*theta1'' + m2*L1*L2*(theta2''*cos(theta1 - theta2)"
        " + theta2'^2*sin(theta1 - theta2))/2 + (m1/2 + m2)*L1*g*sin(theta1)"
    )
    assert text(two, ring) == (
        "m2*L1*L2*(theta1''*cos(theta1 - theta2) - theta1'^2*sin(theta1 - theta2))/2"
        " + m2*L2^2*theta2''/3 + m2*L2*g*sin(theta2)/2"
    )


def test_double_pendulum_in_relative_angles():
    ring = ring_of([m1, m2, L1, L2, g], [th1, th2])
    T, V = planar_chain([L1, L2], [m1, m2], [th1, th1 + th2])
    one, two = lagrange(ring, T, V, [th1, th2])
    assert text(one, ring) == (
        "((m1/3 + m2)*L1^2 + m2*L2^2/3 + m2*L1*L2*cos(theta2))*theta1''"
        " + m2*L2*(L2/3 + L1*cos(theta2)/2)*theta2''"
        " - m2*L1*L2*sin(theta2)*(theta1'*theta2' + theta2'^2/2)"
        " + (m1/2 + m2)*L1*g*sin(theta1) + m2*L2*g*sin(theta1 + theta2)/2"
    )
    assert text(two, ring) == (
        "m2*L2*(L2/3 + L1*cos(theta2)/2)*theta1'' + m2*L2^2*theta2''/3"
        " + m2*L1*L2*theta1'^2*sin(theta2)/2 + m2*L2*g*sin(theta1 + theta2)/2"
    )


def gyroscope(ring, transverse, axial):
    spin = phi.diff(t) + psi.diff(t) * sp.cos(theta)
    T = transverse * (theta.diff(t) ** 2 + psi.diff(t) ** 2 * sp.sin(theta) ** 2) / 2 + axial * spin**2 / 2
    return lagrange(ring, T, m * g * L * sp.cos(theta), [psi, theta, phi])


def test_gyroscope():
    I, J = sp.symbols("I_xi I_zeta", real=True)  # noqa: E741
    ring = ring_of([I, J, m, g, L], [psi, theta, phi])
    equations = [text(e, ring) for e in gyroscope(ring, I, J)]
    assert equations == [
        "(I_xi*sin(theta)^2 + I_zeta*cos(theta)^2)*psi''"
        " + I_zeta*(phi''*cos(theta) - theta'*phi'*sin(theta))"
        " + 2*(I_xi - I_zeta)*psi'*theta'*sin(theta)*cos(theta)",
        "I_xi*theta'' - (I_xi - I_zeta)*psi'^2*sin(theta)*cos(theta)"
        " + I_zeta*psi'*phi'*sin(theta) - m*g*L*sin(theta)",
        "I_zeta*(psi''*cos(theta) + phi'' - psi'*theta'*sin(theta))",
    ]


def test_gyroscope_of_a_disk():
    ring = ring_of([m, R, L, g], [psi, theta, phi])
    equations = gyroscope(ring, m * R**2 / 4 + m * L**2, m * R**2 / 2)
    assert text(equations[0], ring) == (
        "m*((R^2/4 + L^2)*sin(theta)^2 + R^2*cos(theta)^2/2)*psi''"
        " + m*R^2*(phi''*cos(theta) - theta'*phi'*sin(theta))/2"
        " - m*(R^2/2 - 2*L^2)*psi'*theta'*sin(theta)*cos(theta)"
    )
    assert latex(equations[2], ring) == (
        r"\frac{1}{2} m R^{2} \left(\ddot{\psi} \cos\theta + \ddot{\phi}"
        r" - \dot{\psi} \dot{\theta} \sin\theta\right)"
    )


# ------------------------------------------------------------------------------ single features
SHOWN = [
    (M * m / (M + m) * x.diff(t, 2) + k * x / M, "M*m*x''/(M + m) + k*x/M"),
    ((F - k * x) / (m1 + m2 * sp.sin(theta) ** 2), "(F - k*x)/(m1 + m2*sin(theta)^2)"),
    (-k / (2 * m) * x, "-k*x/(2*m)"),
    (m * sp.sin(theta / 2) ** 2, "m*sin(theta/2)^2"),
    (m * (sp.sin(3 * theta) + sp.cos(2 * theta)), "m*(cos(2*theta) + sin(3*theta))"),
    (m * sp.cos(theta) ** 2, "m*cos(theta)^2"),
    (m * sp.sin(theta) ** 2, "m*sin(theta)^2"),
    (m * sp.sin(theta) * sp.cos(theta), "m*sin(theta)*cos(theta)"),
    (sp.sin(g * t + L) * F, "F*sin(L + g*t)"),
    (F * sp.tan(theta), "F*tan(theta)"),
    (sp.exp(-k * t), "exp(-k*t)"),
    (sp.sqrt(m**2 + k**2) * x, "sqrt(m^2 + k^2)*x"),
    (k * sp.Abs(x) * x, "k*x*abs(x)"),
    (k * x ** sp.Rational(1, 3), "k*x^(1/3)"),
    (sp.atan2(x, L), "atan2(x, L)"),
    (-m * g + F, "F - m*g"),
    (sp.Rational(3, 2) * sp.pi * L, "3*pi*L/2"),
    (sp.sin(sp.pi / 3) * L, "sqrt(3)*L/2"),
    (m * x.diff(t, 2) - m * x * theta.diff(t) ** 2, "m*(x'' - x*theta'^2)"),
    (k * (1 + L) * x, "k*(L + 1)*x"),
    (-(m * g - k) * x, "(k - m*g)*x"),
    (F - (m * g - k) * x, "F - (m*g - k)*x"),
]  # fmt: skip


@pytest.mark.parametrize("expr, shown", SHOWN, ids=[s for _, s in SHOWN])
def test_text(expr, shown):
    ring = ring_of([M, m, k, g, F, L, m1, m2], [x, theta])
    assert text(ring.from_sympy(expr), ring) == shown


BARS = [  # forms of one fraction, and what is printed for each
    ([1 / (1 + sp.cos(theta)), (1 - sp.cos(theta)) / sp.sin(theta) ** 2], "1/(1 + cos(theta))"),
    ([sp.cos(theta) / (1 + sp.sin(theta)), (1 - sp.sin(theta)) / sp.cos(theta)], "cos(theta)/(1 + sin(theta))"),
    (
        [sp.sin(theta) / (1 + sp.cos(theta)), sp.tan(theta / 2), (1 - sp.cos(theta)) / sp.sin(theta)],
        "sin(theta)/(1 + cos(theta))",
    ),
    ([1 / (1 + sp.cosh(x)), (sp.cosh(x) - 1) / sp.sinh(x) ** 2], "1/(1 + cosh(x))"),
    ([sp.sinh(x) / (1 + sp.cosh(x)), sp.tanh(x / 2)], "sinh(x)/(1 + cosh(x))"),
    (
        [1 / (m * sp.sin(theta) + k * sp.cos(theta)), (m * sp.sin(theta) - k * sp.cos(theta))
         / (m**2 * sp.sin(theta) ** 2 - k**2 * sp.cos(theta) ** 2)],
        "1/(m*sin(theta) + k*cos(theta))",
    ),
    (
        [sp.sqrt(k) * g / (m * sp.sin(theta) ** 2), 2 * sp.sqrt(k) * g / (m - m * sp.cos(2 * theta))],
        "g*sqrt(k)/(m*sin(theta)^2)",
    ),
]  # fmt: skip


@pytest.mark.parametrize("forms, shown", BARS, ids=[s for _, s in BARS])
def test_equal_fractions_are_printed_alike(forms, shown):
    together = ring_of([M, m, k, g, F, L, m1, m2], [x, theta])
    for form in forms:
        ring = ring_of([M, m, k, g, F, L, m1, m2], [x, theta])
        assert text(ring.from_sympy(form), ring) == shown
        assert text(together.from_sympy(form), together) == shown


def test_names_of_coefficients_are_shared_by_fractions_and_other_equations():
    ring, lumps = ring_of([M, m, k, g, F, L, m1, m2], [x, theta]), Lumps()
    whole = text(ring.from_sympy((M + m) * x), ring, lumps)
    fraction = text(ring.from_sympy((M + m) / (1 + sp.cos(theta)) + (k + g) * sp.tan(theta / 2)), ring, lumps)
    assert (whole, fraction) == ("c1*x", "(c1 + c2*sin(theta))/(1 + cos(theta))")
    assert {name: text(x, ring) for name, x in lumps.table.items()} == {"c1": "M + m", "c2": "k + g"}


@pytest.mark.parametrize("expr", [e for e, _ in SHOWN], ids=[s for _, s in SHOWN])
def test_grouped_expression_is_the_same_element(expr):
    ring = ring_of([M, m, k, g, F, L, m1, m2], [x, theta])
    element = ring.from_sympy(expr)
    assert ring.from_sympy(displayed(element, ring)) == element


def test_grouped_expression_keeps_its_brackets():
    ring = ring_of([M, m, a, k], [x, theta])
    element = ring.from_sympy((M + m) * x.diff(t, 2) / 2 + m * a * sp.sin(theta) + m * x)
    assert displayed(element, ring) == (M + m) * x.diff(t, 2) / 2 + a * m * sp.sin(theta) + m * x


def test_plain_numbers():
    ring = Ring()
    assert text(0, ring) == "0" and latex(0, ring) == "0"
    assert text(Fraction(-3, 2), ring) == "-3/2"
    assert latex(Fraction(-3, 2), ring) == r"-\frac{3}{2}"
    assert equation_text(0, 1, ring) == "0 = 1"
    assert displayed(Fraction(1, 2), ring) == sp.Rational(1, 2)
    assert text(ring.constant(0), ring) == "0"


def test_reactions_come_first():
    ring = Ring()
    N = ring.generator(sp.Symbol("pin_y"), "reaction")
    ring.generator(m, "parameter")
    weight = ring.from_sympy(m * g)
    assert text(N - weight, ring) == "pin_y - m*g"


def test_order_is_that_of_declaration_not_of_first_use():
    ring = Ring()
    ring.from_sympy(g + L + m)  # seen in an expression before it is declared
    for p in (m, L, g):
        ring.generator(p, "parameter")
    assert text(ring.from_sympy(g * L * m), ring) == "m*L*g"


def test_equal_elements_have_one_text():
    ring = ring_of([m, M], [th1, th2])
    u = ring.from_sympy(m * sp.cos(th1 - th2))
    v = ring.from_sympy(m * (sp.cos(th1) * sp.cos(th2) + sp.sin(th1) * sp.sin(th2)))
    assert text(u, ring) == text(v, ring) == "m*cos(theta1 - theta2)"


def test_crossed_axes_stay_sines_and_cosines():
    ring = ring_of([m, L], [th1, th2])
    assert text(ring.from_sympy(m * L * sp.sin(th1) * sp.cos(th2)), ring) == "m*L*sin(theta1)*cos(theta2)"


def test_only_parallel_angles_are_added():
    ring = ring_of([m, M], [th1, th2, psi])
    expr = m * sp.sin(psi) ** 2 * sp.cos(th1 + th2) + M * sp.sin(psi) * sp.sin(th1 + th2)
    shown = text(ring.from_sympy(expr), ring)
    assert shown == "(M*sin(theta1 + theta2) + m*cos(theta1 + theta2)*sin(psi))*sin(psi)"


# ------------------------------------------------------------------------------ names, LaTeX
def test_latex_of_names():
    ring = Ring()
    names = ["theta_1", "theta1", "I_xx", "mass", "Omega_zeta", "k", "pin_x", "a_b_c"]
    shown = [latex(ring.generator(sp.Symbol(n)), ring) for n in names]
    assert shown == [
        r"\theta_{1}", r"\theta_{1}", "I_{xx}", r"\mathrm{mass}", r"\Omega_{\zeta}", "k",
        r"\mathrm{pin}_{x}", "a_{b, c}",
    ]  # fmt: skip
    jx = sp.Function("j_wx")(t)
    assert latex(ring.generator(jx.diff(t)), ring) == r"\dot{\omega}_{x, j}"


def test_latex_of_functions():
    ring = ring_of([M, m, k, L], [x, theta])
    shown = {
        sp.sin(theta) ** 2: r"\sin^{2}\theta",
        sp.sin(2 * theta) * m
        + sp.cos(3 * theta) * m: r"m \left(\sin\left(2 \theta\right) + \cos\left(3 \theta\right)\right)",
        sp.atan2(x, L): r"\operatorname{atan2}\left(x, L\right)",
        sp.exp(-k * t): "e^{-k t}",
        sp.sqrt(M**2 + m**2): r"\sqrt{M^{2} + m^{2}}",
        sp.Abs(x): r"\left|x\right|",
        k * x / (M + m): r"\frac{k x}{M + m}",
        sp.asin(x): r"\arcsin\left(x\right)",
    }
    for expr, expected in shown.items():
        assert latex(ring.from_sympy(expr), ring) == expected


# ------------------------------------------------------------------------------ lumped parameters
def test_lumped_parameters():
    ring = ring_of([m1, m2, L1, L2, g], [th1, th2])
    T, V = planar_chain([L1, L2], [m1, m2], [th1, th2])
    one, two = lagrange(ring, T, V, [th1, th2])
    shown, table = text(one, ring, lump=True)
    assert shown == (
        "c1*theta1''/3 + m2*L1*L2*(theta2''*cos(theta1 - theta2) + theta2'^2*sin(theta1 - theta2))/2"
        " + c2*sin(theta1)/2"
    )
    assert table == {"c1": "(m1 + 3*m2)*L1^2", "c2": "(m1 + 2*m2)*L1*g"}
    lumps = Lumps()
    again = [equation_text(e, 0, ring, lump=lumps) for e in (one, one)]
    assert again[0] == again[1] == shown + " = 0"
    assert lumps.table["c1"] == ring.from_sympy((m1 + 3 * m2) * L1**2)
    assert latex(one, ring, lump=True)[1]["c1"] == r"\left(m_{1} + 3 m_{2}\right) L_{1}^{2}"


def test_lumps_avoid_names_in_use():
    c1 = sp.Symbol("c1")
    ring = ring_of([c1, m1, m2], [x])
    shown, table = text(ring.from_sympy((m1 + m2) * x.diff(t, 2) + c1 * x), ring, lump=True)
    (name,) = table
    assert name != "c1" and shown == f"{name}*x'' + c1*x"


# ------------------------------------------------------------------------------ size
def spatial_chain(n):
    """Inverse dynamics of n bars hinged about x, z, x, ... by Newton-Euler on canonical elements."""
    ring = Ring(capacity=96)
    ms, Ls, qs = ([sp.Symbol(f"{c}{i + 1}", real=True) for i in range(n)] for c in "mLq")
    weight = ring.generator(g, "parameter")
    ms = [ring.generator(s, "parameter") for s in ms]
    Ls = [ring.generator(s, "parameter") for s in Ls]
    fs = [sp.Function(str(s))(t) for s in qs]
    q = [ring.generator(f, "coordinate") for f in fs]
    u = [ring.generator(sp.Derivative(f, t), "speed") for f in fs]
    udot = [ring.generator(sp.Derivative(f, (t, 2)), "acceleration") for f in fs]
    w = wd = (0, 0, 0)
    acceleration = (0, weight, 0)
    links = []
    for i in range(n):
        c, s = ring.cos(q[i]), ring.sin(q[i])
        about_x = i % 2 == 0
        turn = ((1, 0, 0), (0, c, -s), (0, s, c)) if about_x else ((c, -s, 0), (s, c, 0), (0, 0, 1))
        axis = (1, 0, 0) if about_x else (0, 0, 1)
        w, wd, acceleration = (apply_transpose(turn, v) for v in (w, wd, acceleration))
        rate = scale(u[i], axis)
        wd = add(add(wd, scale(udot[i], axis)), cross(w, rate))
        w = add(w, rate)
        center, tip = (0, -Ls[i] / 2, 0), (0, -Ls[i], 0)
        at = [add(acceleration, add(cross(wd, p), cross(w, cross(w, p)))) for p in (center, tip)]
        inertia = ms[i] * Ls[i] * Ls[i] / 12
        moment = add((inertia * wd[0], 0, inertia * wd[2]), cross(w, (inertia * w[0], 0, inertia * w[2])))
        links.append((turn, axis, center, tip, scale(ms[i], at[0]), moment))
        acceleration = at[1]
    force = moment = (0, 0, 0)
    result = []
    outer = None
    for turn, axis, center, tip, own_force, own_moment in reversed(links):
        if outer is not None:
            force, moment = apply(outer, force), apply(outer, moment)
            moment = add(moment, cross(tip, force))
        force = add(force, own_force)
        moment = add(moment, add(own_moment, cross(center, own_force)))
        result.append(dot(axis, moment))
        outer = turn
    return ring, result[::-1]


def test_spatial_chain_prints_fast_and_right():
    ring, equations = spatial_chain(3)
    for e in equations:
        assert ring.from_sympy(displayed(e, ring)) == e
    ring, equations = spatial_chain(6)
    started = time.process_time()
    shown = [latex(e, ring) for e in equations]
    # of the processor: 0.5 s where it is idle
    assert time.process_time() - started < 3
    assert sum(map(len, shown)) > 100_000 and all(s.count("\\left") == s.count("\\right") for s in shown)
