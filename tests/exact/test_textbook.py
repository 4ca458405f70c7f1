"""The equations of textbook systems, term by term, with SymPy as an independent referee.

Each system is derived a second time here, by Lagrange's equations from the positions of the mass centres and the
angular velocities written down by hand: no line of the derivation passes through freebody.
"""

from __future__ import annotations

import pytest
import sympy
from sympy import Derivative, Rational, cos, sin

import freebody as fb
from freebody.describe.description import parameters_of


def lagrange(T, V, coordinates, forces=None):
    """d/dt dT/dq' - dT/dq + dV/dq - Q for every coordinate."""
    t = sympy.Symbol("t")
    rows = []
    for i, q in enumerate(coordinates):
        v = q.diff(t)
        momentum = T.diff(v)
        row = momentum.diff(t) - T.diff(q) + V.diff(q)
        rows.append(row - (forces[i] if forces else 0))
    return rows


def same(a, b):
    """Whether a difference is zero: sines of sums expanded and squares of sines replaced, by SymPy alone."""
    difference = sympy.expand(sympy.expand_trig(sympy.expand(a - b)))
    sines = sorted(difference.atoms(sin), key=str)
    for s in sines:
        S, C = sympy.Dummy(), sympy.Dummy()
        poly = sympy.Poly(difference.subs({s: S, cos(s.args[0]): C}), S)
        reduced = sympy.rem(poly, sympy.Poly(S**2 + C**2 - 1, S))
        difference = sympy.expand(reduced.as_expr().subs({S: s, C: cos(s.args[0])}))
    return difference == 0


def terms(expression):
    """The set of terms of an expanded sum: two forms are the same only if these are."""
    return set(sympy.Add.make_args(sympy.expand(expression)))


# --- Section 6.9: the gyroscope ---------------------------------------------------------------------


@pytest.fixture(scope="module")
def gyroscope():
    """Disk of mass m and radius R at L from the pivot; psi about Z, theta about the nodal axis, phi the spin."""
    s = fb.System("gyroscope")
    m, R, L, g = s.parameters(m=1.2, R=0.06, L=0.1, g=9.81)
    s.gravity = (0, 0, -g)
    rotor = s.body("rotor", fb.disk(m, R))
    s.gimbal("pivot", s.ground, rotor, to=(0, 0, -L), axis="ZXZ", coordinate="psi theta phi")
    return s, fb.equations(s)


def gyroscope_by_hand(s, m, R, L, g):
    psi, theta, phi = (sympy.Function(name)(s.t) for name in ("psi", "theta", "phi"))
    v = {q: q.diff(s.t) for q in (psi, theta, phi)}
    centre = sympy.Matrix([L * sin(theta) * sin(psi), -L * sin(theta) * cos(psi), L * cos(theta)])
    velocity = centre.diff(s.t)
    # components along the nodal axis, across it, and along the symmetry axis
    w = (v[theta], v[psi] * sin(theta), v[phi] + v[psi] * cos(theta))
    A, C = m * R**2 / 4, m * R**2 / 2
    T = m * velocity.dot(velocity) / 2 + (A * (w[0] ** 2 + w[1] ** 2) + C * w[2] ** 2) / 2
    return T, m * g * centre[2], (psi, theta, phi)


def test_gyroscope_is_lagranges(gyroscope):
    s, eq = gyroscope
    T, V, q = gyroscope_by_hand(s, *(p.symbol for p in parameters_of(s)))
    assert eq.coordinates == q
    for row, motion in zip(lagrange(T, V, q), eq.motion, strict=True):
        assert same(motion.lhs - motion.rhs, row)
    assert same(eq.energy.kinetic, T)
    assert same(eq.energy.potential, V)


def test_gyroscope_in_its_textbook_form(gyroscope):
    """Term by term; phi itself stands nowhere, since the rotor is axisymmetric."""
    s, eq = gyroscope
    m, R, L, g = (p.symbol for p in parameters_of(s))
    psi, theta, phi = eq.coordinates
    (dpsi, dtheta, dphi), t = (q.diff(s.t) for q in eq.coordinates), s.t
    I_xi, I_zeta = m * (R**2 / 4 + L**2), m * R**2 / 2
    expected = (
        (I_xi * sin(theta) ** 2 + I_zeta * cos(theta) ** 2) * Derivative(psi, (t, 2))
        + I_zeta * cos(theta) * Derivative(phi, (t, 2))
        + 2 * (I_xi - I_zeta) * sin(theta) * cos(theta) * dpsi * dtheta
        - I_zeta * sin(theta) * dtheta * dphi,
        I_xi * Derivative(theta, (t, 2))
        - (I_xi - I_zeta) * sin(theta) * cos(theta) * dpsi**2
        + I_zeta * sin(theta) * dpsi * dphi
        - m * g * L * sin(theta),
        I_zeta
        * (Derivative(phi, (t, 2)) + cos(theta) * Derivative(psi, (t, 2)) - sin(theta) * dtheta * dpsi),
    )
    for row, motion in zip(expected, eq.motion, strict=True):
        assert motion.rhs == 0
        assert terms(motion.lhs) == terms(row)
    everything = [x for motion in eq.motion for x in motion.args] + [eq.energy.kinetic, *eq.mass_matrix]
    assert not any(x.has(sin(phi), cos(phi), sin(psi), cos(psi)) for x in everything)


def test_gyroscope_reaction_carries_the_rotor(gyroscope):
    """Force m (a_C - g) at the pivot, no moment; the momentum about Z and along the axis."""
    s, eq = gyroscope
    m, R, L, g = (p.symbol for p in parameters_of(s))
    _, _, (psi, theta, phi) = gyroscope_by_hand(s, m, R, L, g)
    centre = sympy.Matrix([L * sin(theta) * sin(psi), -L * sin(theta) * cos(psi), L * cos(theta)])
    force = m * (centre.diff(s.t, 2) + sympy.Matrix([0, 0, g]))
    reaction = eq.reactions["pivot"]
    assert all(same(a, b) for a, b in zip(reaction.force, force, strict=True))
    assert reaction.moment == sympy.zeros(3, 1)
    assert (reaction.on, reaction.frame) == ("rotor", "ground")
    I_xi, I_zeta = m * (R**2 / 4 + L**2), m * R**2 / 2
    spin = phi.diff(s.t) + psi.diff(s.t) * cos(theta)
    H_Z = I_xi * psi.diff(s.t) * sin(theta) ** 2 + I_zeta * spin * cos(theta)
    assert same(eq.momentum.angular()[2], H_Z)


# --- Problem 6.15: two links, absolute angles -------------------------------------------------------


@pytest.fixture(scope="module")
def double_pendulum():
    s = fb.System("double pendulum")
    m1, m2, l1, l2, g = s.parameters(m1=1, m2=2, l1=1, l2=0.7, g=9.81)
    q1, q2 = s.coordinates("theta1 theta2")
    s.gravity = (0, -g, 0)
    upper = s.body("upper", fb.slender_bar(m1, l1, axis="y"))
    lower = s.body("lower", fb.slender_bar(m2, l2, axis="y"))
    s.hinge("top", s.ground, upper, to=(0, l1 / 2, 0), coordinate=q1)
    s.hinge("middle", upper, lower, at=(0, -l1 / 2, 0), to=(0, l2 / 2, 0), coordinate=q2 - q1)
    return s, fb.equations(s)


def test_double_pendulum_is_lagranges(double_pendulum):
    s, eq = double_pendulum
    m1, m2, l1, l2, g = (p.symbol for p in parameters_of(s))
    q1, q2 = (sympy.Function(f"theta{i}")(s.t) for i in (1, 2))
    c1 = sympy.Matrix([l1 * sin(q1), -l1 * cos(q1)]) / 2
    c2 = 2 * c1 + sympy.Matrix([l2 * sin(q2), -l2 * cos(q2)]) / 2
    v1, v2 = c1.diff(s.t), c2.diff(s.t)
    T = m1 * v1.dot(v1) / 2 + m2 * v2.dot(v2) / 2
    T += m1 * l1**2 / 12 * q1.diff(s.t) ** 2 / 2 + m2 * l2**2 / 12 * q2.diff(s.t) ** 2 / 2
    V = m1 * g * c1[1] + m2 * g * c2[1]
    for row, motion in zip(lagrange(T, V, (q1, q2)), eq.motion, strict=True):
        assert same(motion.lhs - motion.rhs, row)
    assert same(eq.energy.kinetic, T)
    assert same(eq.energy.potential, V)


def test_double_pendulum_in_its_textbook_form(double_pendulum):
    """Differences of the absolute angles stand as theta1 - theta2."""
    s, eq = double_pendulum
    m1, m2, l1, l2, g = (p.symbol for p in parameters_of(s))
    q1, q2 = eq.coordinates
    d1, d2, a1, a2 = q1.diff(s.t), q2.diff(s.t), q1.diff(s.t, 2), q2.diff(s.t, 2)
    between = q1 - q2
    expected = (
        (m1 / 3 + m2) * l1**2 * a1
        + m2 * l1 * l2 / 2 * (a2 * cos(between) + d2**2 * sin(between))
        + (m1 / 2 + m2) * g * l1 * sin(q1),
        m2 * l2**2 / 3 * a2
        + m2 * l1 * l2 / 2 * (a1 * cos(between) - d1**2 * sin(between))
        + m2 * g * l2 / 2 * sin(q2),
    )
    for row, motion in zip(expected, eq.motion, strict=True):
        assert motion.rhs == 0
        assert terms(motion.lhs) == terms(row)
    assert eq.mass_matrix == sympy.ImmutableMatrix(
        [
            [l1**2 * (m1 / 3 + m2), l1 * l2 * m2 * cos(between) / 2],
            [l1 * l2 * m2 * cos(between) / 2, l2**2 * m2 / 3],
        ]
    )


def test_double_pendulum_hinges_carry_forces_only(double_pendulum):
    s, eq = double_pendulum
    m1, m2, l1, l2, g = (p.symbol for p in parameters_of(s))
    q1, q2 = eq.coordinates
    c1 = sympy.Matrix([l1 * sin(q1), -l1 * cos(q1)]) / 2
    c2 = 2 * c1 + sympy.Matrix([l2 * sin(q2), -l2 * cos(q2)]) / 2
    middle = m2 * (c2.diff(s.t, 2) + sympy.Matrix([0, g]))
    top = middle + m1 * (c1.diff(s.t, 2) + sympy.Matrix([0, g]))
    for name, force in (("middle", middle), ("top", top)):
        reaction = eq.reactions[name]
        assert same(reaction.components[f"{name}_x"], force[0])
        assert same(reaction.components[f"{name}_y"], force[1])
        assert reaction.force[2] == 0
        assert reaction.moment == sympy.zeros(3, 1)


# --- Example 6.5: mass on a spring with a hinged bar ------------------------------------------------


@pytest.fixture(scope="module")
def cart_and_bar():
    s = fb.System("cart_and_bar")
    M, m, a, k, g, F = s.parameters(M=2.0, m=1.0, a=0.5, k=50.0, g=9.81, F=3.0)
    s.gravity = (0, -g, 0)
    cart = s.body("cart", fb.particle(M))
    bar = s.body("bar", fb.slender_bar(m, 2 * a, axis="y"))
    guide = s.slider("guide", s.ground, cart, axis="x", coordinate="x")
    s.hinge("pin", cart, bar, to=(0, a, 0), axis="z", coordinate="theta")
    s.spring("k", guide, stiffness=k)
    s.force("F", bar.point(0, -a, 0), (F, 0, 0))
    return s, fb.equations(s)


def test_example_6_5_is_lagranges(cart_and_bar):
    s, eq = cart_and_bar
    M, m, a, k, g, F = (p.symbol for p in parameters_of(s))
    x, theta = (sympy.Function(name)(s.t) for name in ("x", "theta"))
    centre = sympy.Matrix([x + a * sin(theta), -a * cos(theta)])
    end = sympy.Matrix([x + 2 * a * sin(theta), -2 * a * cos(theta)])
    v = centre.diff(s.t)
    T = M * x.diff(s.t) ** 2 / 2 + m * v.dot(v) / 2 + m * (2 * a) ** 2 / 12 * theta.diff(s.t) ** 2 / 2
    V = k * x**2 / 2 + m * g * centre[1]
    forces = [F * end[0].diff(q) for q in (x, theta)]
    for row, motion in zip(lagrange(T, V, (x, theta), forces), eq.motion, strict=True):
        assert same(motion.lhs - motion.rhs, row)
    assert same(eq.energy.kinetic, T)
    assert same(eq.energy.potential, V)


def test_example_6_5_in_its_textbook_form(cart_and_bar):
    s, eq = cart_and_bar
    M, m, a, k, g, F = (p.symbol for p in parameters_of(s))
    x, theta = eq.coordinates
    ddx, ddtheta, dtheta = x.diff(s.t, 2), theta.diff(s.t, 2), theta.diff(s.t)
    expected = (
        ((M + m) * ddx + m * a * (ddtheta * cos(theta) - dtheta**2 * sin(theta)) + k * x, F),
        (
            Rational(4, 3) * m * a**2 * ddtheta + m * a * ddx * cos(theta) + m * g * a * sin(theta),
            2 * a * F * cos(theta),
        ),
    )
    for (left, right), motion in zip(expected, eq.motion, strict=True):
        assert terms(motion.lhs) == terms(left)
        assert terms(motion.rhs) == terms(right)
    assert eq.text().splitlines() == [
        "(M + m)*x'' + m*a*(theta''*cos(theta) - theta'^2*sin(theta)) + k*x = F",
        "m*a*x''*cos(theta) + 4*m*a^2*theta''/3 + m*a*g*sin(theta) = 2*a*F*cos(theta)",
    ]


def test_example_6_5_hinge_and_ground_forces(cart_and_bar):
    """Hand formulas: on the bar m a_C - F - m g; the ground carries the weights and the bar's vertical inertia."""
    s, eq = cart_and_bar
    M, m, a, k, g, F = (p.symbol for p in parameters_of(s))
    x, theta = eq.coordinates
    ddx, ddtheta, dtheta = x.diff(s.t, 2), theta.diff(s.t, 2), theta.diff(s.t)
    lift = m * a * (ddtheta * sin(theta) + dtheta**2 * cos(theta))
    pin = eq.reactions["pin"].components
    assert same(pin["pin_x"], m * ddx + m * a * (ddtheta * cos(theta) - dtheta**2 * sin(theta)) - F)
    assert same(pin["pin_y"], m * g + lift)
    guide = eq.reactions["guide"].components
    assert same(guide["guide_y"], (M + m) * g + lift)
    assert [name for name, value in guide.items() if value != 0] == ["guide_y"]
    assert [name for name, value in pin.items() if value != 0] == ["pin_x", "pin_y"]


def test_example_6_5_free_body_of_the_bar(cart_and_bar):
    s, eq = cart_and_bar
    M, m, a, k, g, F = (p.symbol for p in parameters_of(s))
    x, theta = eq.coordinates
    ddx, ddtheta, dtheta = x.diff(s.t, 2), theta.diff(s.t, 2), theta.diff(s.t)
    body = eq.free_body("bar")
    assert [action.name for action in body.actions] == [
        "weight", "F", "pin_x", "pin_y", "pin_z", "pin_Mx", "pin_My",
    ]  # fmt: skip
    assert list(body.forces) == ["weight", "F", "pin_x", "pin_y", "pin_z"]
    assert [str(u) for u in body.unknowns] == ["pin_x", "pin_y", "pin_z", "pin_Mx", "pin_My"]
    pin_x, pin_y, pin_z, pin_Mx, pin_My = body.unknowns
    along, up = ddtheta * cos(theta) - dtheta**2 * sin(theta), ddtheta * sin(theta) + dtheta**2 * cos(theta)
    expected = [
        (F + pin_x, m * (ddx + a * along)),
        (pin_y - m * g, m * a * up),
        (pin_z, 0),
        (pin_Mx + a * pin_z * cos(theta), 0),
        (pin_My + a * pin_z * sin(theta), 0),
        (F * a * cos(theta) - a * pin_x * cos(theta) - a * pin_y * sin(theta), m * a**2 / 3 * ddtheta),
    ]
    assert len(body.equations) == 6
    for (left, right), equation in zip(expected, body.equations, strict=True):
        assert terms(equation.lhs) == terms(left)
        assert terms(equation.rhs) == terms(right)
    assert body.forces["weight"] == sympy.ImmutableMatrix([0, -m * g, 0])
    cart = eq.free_body("cart")
    assert [action.name for action in cart.actions][:3] == ["weight", "k", "guide_y"]
    assert cart.forces["k"] == sympy.ImmutableMatrix([-k * x, 0, 0])
    assert cart.forces["pin_x"] == sympy.ImmutableMatrix([-pin_x, 0, 0])


def test_example_6_5_about_the_pin_and_in_the_axes_of_the_bar(cart_and_bar):
    """About the pin the unknown forces leave the moment equation; turning the axes changes no content."""
    s, eq = cart_and_bar
    M, m, a, k, g, F = (p.symbol for p in parameters_of(s))
    bar = s.bodies["bar"]
    x, theta = eq.coordinates
    ddx, ddtheta = x.diff(s.t, 2), theta.diff(s.t, 2)
    about_pin = eq.free_body("bar", about=bar.point(0, a, 0))
    moment = about_pin.equations[5]
    assert terms(moment.lhs) == terms(2 * a * F * cos(theta) - m * g * a * sin(theta))
    assert terms(moment.rhs) == terms(4 * m * a**2 / 3 * ddtheta + m * a * ddx * cos(theta))
    here, turned = eq.free_body("bar"), eq.free_body("bar", frame=bar)
    R = sympy.Matrix([[cos(theta), -sin(theta), 0], [sin(theta), cos(theta), 0], [0, 0, 1]])
    for part in (slice(0, 3), slice(3, 6)):
        for side in ("lhs", "rhs"):
            ground, body = (
                sympy.Matrix([getattr(e, side) for e in x.equations[part]]) for x in (here, turned)
            )
            assert all(same(p, q) for p, q in zip(ground, R * body, strict=True))
    shifted = eq.free_body("bar", about=s.ground.point(1, 2, 0))
    # M_P = M_C + r_PC x F on both sides
    r = sympy.Matrix([x + a * sin(theta) - 1, -a * cos(theta) - 2, 0])
    for side in ("lhs", "rhs"):
        force, moment = (sympy.Matrix([getattr(e, side) for e in here.equations[i : i + 3]]) for i in (0, 3))
        other = sympy.Matrix([getattr(e, side) for e in shifted.equations[3:]])
        assert all(same(p, q) for p, q in zip(other, moment + r.cross(force), strict=True))


# --- Example 6.2: bar hinged at its third point -----------------------------------------------------


@pytest.fixture(scope="module")
def hinged_bar():
    """theta from the horizontal, counter-clockwise; the mass centre at L/6 to the right of the hinge."""
    s = fb.System("hinged bar")
    m, L, g = s.parameters(m=3.0, L=1.5, g=9.81)
    s.gravity = (0, -g, 0)
    bar = s.body("bar", fb.slender_bar(m, L, axis="x"))
    s.hinge("pin", s.ground, bar, to=(-L / 6, 0, 0), axis="z", coordinate="theta")
    return s, fb.equations(s)


def test_example_6_2_motion_and_reaction(hinged_bar):
    s, eq = hinged_bar
    m, L, g = (p.symbol for p in parameters_of(s))
    (theta,) = eq.coordinates
    dtheta, ddtheta = theta.diff(s.t), theta.diff(s.t, 2)
    I_0 = m * L**2 / 12 + m * (L / 6) ** 2
    (motion,) = eq.motion
    assert terms(motion.lhs - motion.rhs) == terms(I_0 * ddtheta + m * g * L / 6 * cos(theta))
    pin = eq.reactions["pin"].components
    assert same(pin["pin_x"], -m * L / 6 * (ddtheta * sin(theta) + dtheta**2 * cos(theta)))
    assert same(pin["pin_y"], m * g + m * L / 6 * (ddtheta * cos(theta) - dtheta**2 * sin(theta)))
    # just after release from the horizontal: alpha = -3 g / (2 L), R = 3 m g / 4
    put = [(ddtheta, -3 * g / (2 * L)), (dtheta, 0), (theta, 0)]
    assert sympy.simplify((motion.lhs - motion.rhs).subs(put)) == 0
    assert sympy.simplify(pin["pin_y"].subs(put)) == 3 * m * g / 4
    # vertical: omega² = 3 g / L by energy, R = m g (1 + 1/2)
    T, V = eq.energy.kinetic, eq.energy.potential
    start, end = [(dtheta, 0), (theta, 0)], [(dtheta, sympy.sqrt(3 * g / L)), (theta, -sympy.pi / 2)]
    assert sympy.simplify((T + V).subs(start) - (T + V).subs(end)) == 0
    low = [(ddtheta, 0), *end]
    assert sympy.simplify((motion.lhs - motion.rhs).subs(low)) == 0
    assert sympy.simplify(pin["pin_y"].subs(low)) == 3 * m * g / 2
    assert sympy.simplify(T.subs(end)) == m * g * L / 6


# --- the referee catches a wrong sign ---------------------------------------------------------------


def test_the_referee_is_not_blind(cart_and_bar):
    _, eq = cart_and_bar
    (first, _) = eq.motion
    wrong = first.lhs - first.rhs + 2 * sympy.Symbol("F", real=True)
    assert not same(wrong, first.lhs - first.rhs)
    theta = eq.coordinates[1]
    assert same(sin(theta) ** 2, 1 - cos(theta) ** 2)
    assert not same(sin(theta) ** 2, 1 + cos(theta) ** 2)
