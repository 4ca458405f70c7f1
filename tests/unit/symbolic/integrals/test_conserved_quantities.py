"""Conserved quantities and Routh's reduction: found, proven, and removed by what breaks them."""

from __future__ import annotations

import time

import numpy as np
import pytest
import sympy

import freebody as fb
from freebody.gallery.beyond.tumbling_body import build as tumbling_body
from freebody.gallery.textbook.examples.sec_6_8_torque_free import build as torque_free
from freebody.gallery.textbook.examples.sec_6_9_gyroscope import build as gyroscope
from freebody.gallery.textbook.problems.prob_6_15_double_pendulum import build as double_pendulum
from freebody.symbolic.derivation.along_motion import rate_of


def free_body(moments=("A", "B", "C"), gravity=False):
    s = fb.System("free")
    s.parameters(m=2, A=1, B=2, C=2.5, g=9.81)
    A, B, C = (s.expression(x) for x in moments)
    body = s.body("body", fb.MassProperties(s.expression("m"), (0, 0, 0), ((A, 0, 0), (0, B, 0), (0, 0, C))))
    s.free("j", s.ground, body)
    if gravity:
        s.gravity = (0, 0, "-g")
    return s


def carts(wall=False, damper=False, force=False):
    s = fb.System("carts")
    s.parameters(m=1, M=2, k=30, c=1, F=4)
    a, b = s.body("a", fb.particle("m")), s.body("b", fb.particle("M"))
    first = s.slider("first", s.ground, a, axis="x", coordinate="x")
    s.slider("second", s.ground, b, axis="x", coordinate="y")
    s.spring("k", a.origin, b.origin, stiffness="k", rest=1)
    if wall:
        s.spring("wall", first, stiffness="k")
    if damper:
        s.damper("d", a.origin, b.origin, damping="c")
    if force:
        s.force("F", b.origin, ("F", 0, 0))
    return s


def names(s):
    return fb.equations(s).integrals.names


AXES = "XYZ"
LINEAR = tuple(f"linear momentum along {k}" for k in AXES)
ORIGIN = tuple(f"angular momentum along {k} about the ground's origin" for k in AXES)
CENTRE = tuple(f"angular momentum along {k} about the mass centre" for k in AXES)


@pytest.mark.parametrize(
    ("build", "expected"),
    [
        (gyroscope, ("energy", "momentum of psi", "momentum of phi")),
        (double_pendulum, ("energy",)),
        (torque_free, ("energy", *ORIGIN, "angular momentum along z of body")),
        (tumbling_body, ("energy", *LINEAR, *ORIGIN, *CENTRE)),
        (free_body, ("energy", *LINEAR, *ORIGIN, *CENTRE)),
        (
            lambda: free_body("AAC", gravity=True),
            ("energy", *LINEAR[:2], ORIGIN[2], *CENTRE, "angular momentum along z of body"),
        ),
        (carts, ("energy", LINEAR[0])),
        (lambda: carts(wall=True), ("energy",)),
        (lambda: carts(damper=True), (LINEAR[0],)),
        (lambda: carts(force=True), ("energy",)),
    ],
    ids=[
        "gyroscope", "double pendulum", "torque-free", "tumbling", "free body", "heavy free body", "carts",
        "spring to the wall", "damper between", "constant force",
    ],
)  # fmt: skip
def test_found(build, expected) -> None:
    assert names(build()) == expected


@pytest.mark.parametrize("build", [gyroscope, double_pendulum, free_body, torque_free, carts])
def test_every_proof_holds_when_formed_anew(build) -> None:
    found = fb.equations(build()).integrals
    assert len(found) > 0
    for one in found:
        assert one.remainder() == 0


def test_proof_as_sympy_sees_it() -> None:
    """dI/dt less multipliers times the printed equations of motion, simplified by SymPy: zero."""
    s = gyroscope()
    e = fb.equations(s)
    for one in e.integrals:
        rest = one.expression.diff(s.t)
        for name, equation in zip(e.model.speed_names, e.motion, strict=True):
            rest -= one.proof.multipliers.get(name, 0) * (equation.lhs - equation.rhs)
        assert sympy.simplify(rest.doit()) == 0
    assert e.integrals["energy"].proof.multipliers == dict(zip(e.model.speed_names, e.speeds, strict=True))


def test_a_wrong_multiplier_proves_nothing() -> None:
    from freebody.symbolic.integrals.conserved_quantities import remainder

    e = fb.equations(gyroscope())
    energy = e.integrals["energy"]
    assert remainder(e, energy.canonical, (1, 0, 0), ()) != 0
    assert rate_of(e, energy.canonical) != 0  # it is constant along motions only


def test_values_along_a_motion() -> None:
    s = gyroscope()
    e = fb.equations(s)
    trajectory = fb.simulate(s, until=0.2, initial={"theta": 1.0, "phi'": 300}, tolerance=1e-12)
    columns = {
        name: np.asarray(trajectory[name]) for name in (*e.model.coordinate_names, *e.model.speed_names)
    }
    for one in e.integrals:
        along = one.value(columns)
        # tolerance of the simulation times the spread of the terms
        assert np.ptp(along) <= 1e-9 * max(1, np.abs(along).max())
    assert np.ptp(columns["theta"]) > 1e-3


@pytest.mark.parametrize("build", [gyroscope, double_pendulum, free_body, torque_free])
def test_rates_by_the_recursive_dynamics(build) -> None:
    """dI/dt with u' from the articulated-body algorithm on floats, at a random state: zero to round-off."""
    from freebody.dynamics.articulated import forward_dynamics
    from freebody.dynamics.state import float_state
    from freebody.scalar.substitute import Substitution, arrays
    from freebody.testing import random_state

    e = fb.equations(build())
    q, u = random_state(e.model, 3)
    state = float_state(e.model, q, u)
    atoms = {c.symbol: x for c, x in zip(e.model.coordinates, state.q, strict=True)}
    atoms |= {u.symbol: x for u, x in zip(e.model.speeds, state.u, strict=True)}
    atoms |= {
        u.acceleration: x for u, x in zip(e.model.speeds, forward_dynamics(e.model, state), strict=True)
    }
    atoms |= dict(state.values)
    at = Substitution(e.ring, arrays, atoms)
    for one in e.integrals:
        size = sum(abs(float(at(e.ring.derivative(one.canonical, a))) * x) for a, x in atoms.items())
        assert abs(float(at(rate_of(e, one.canonical)))) <= 256 * np.finfo(float).eps * (1 + size)


def test_value_of_one_state() -> None:
    energy = fb.equations(gyroscope()).integrals["energy"]
    m, L, g = 1.2, 0.1, 9.81
    assert energy.value() == pytest.approx(m * g * L, rel=1e-15)
    assert energy.value({"theta": np.pi / 2}, m=3) == pytest.approx(0, abs=1e-15)
    with pytest.raises(fb.errors.ModelError, match=r"Unknown name 'thetta'; did you mean 'theta'\?"):
        energy.value(thetta=1)


def test_jacobi_integral_of_a_driven_system() -> None:
    s = fb.System("hoop")
    m, R, g, Omega = s.parameters(m=1, R=1, g=9.81, Omega=3)
    s.gravity = (0, 0, -g)
    hoop, bead = s.body("hoop", fb.particle(m)), s.body("bead", fb.particle(m))
    s.hinge("axle", s.ground, hoop, axis="z", coordinate=Omega * s.t)
    s.hinge("wire", hoop, bead, to=(0, 0, R), axis="x", coordinate="theta")
    (h,) = fb.equations(s).integrals
    assert h.name == "Jacobi's integral"
    theta = s.expression("theta")
    expected = m * R**2 * theta.diff(s.t) ** 2 / 2 - m * R**2 * Omega**2 * sympy.sin(theta) ** 2 / 2
    assert sympy.simplify(h.expression - expected + m * g * R * sympy.cos(theta)) == 0


def test_what_changes_with_time_keeps_nothing() -> None:
    s = carts(wall=True)
    s.generalized_force("y", "F*sin(t)")
    found = fb.equations(s).integrals
    assert len(found) == 0
    assert found.text() == "No conserved quantities."
    with pytest.raises(
        fb.errors.ModelError, match="No conserved quantity of this system is known, so there is no 'energy'"
    ):
        found["energy"]


def test_constant_forces_have_a_potential() -> None:
    s = carts(force=True)
    energy = fb.equations(s).integrals["energy"]
    F, y = s.expression("F"), s.expression("y")
    assert sympy.diff(energy.expression, F) == -y


def test_internal_motors_keep_the_momenta() -> None:
    s = fb.System("two links in space")
    a, b = s.body("a", fb.slender_bar(1, 1, axis="x")), s.body("b", fb.slender_bar(1, 1, axis="x"))
    s.planar("float", s.ground, a, coordinate="x y p")
    joint = s.hinge("joint", a, b, at=("1/2", 0, 0), to=("-1/2", 0, 0), coordinate="q")
    s.torque("motor", joint, "sin(3*t)")
    assert names(s) == ("momentum of x", "momentum of y", ORIGIN[2], CENTRE[2])


def test_momentum_through_particles() -> None:
    """A universal joint does not let a rigid body turn about the vertical, but a particle at its end does."""
    s = fb.System("spherical pendulum")
    m, L, g = s.parameters(m=1, L=1, g=9.81)
    s.gravity = (0, 0, -g)
    bob = s.body("bob", fb.particle(m))
    s.universal("arm", s.ground, bob, to=(0, 0, L), coordinate="alpha beta")
    e = fb.equations(s)
    assert e.integrals.names == ("energy", ORIGIN[2])
    assert e.integrals[1].remainder() == 0


def test_constraints_and_rolling_keep_the_energy() -> None:
    s = fb.System("rod")
    m, L, g = s.parameters(m=1, L=2, g=9.81)
    s.gravity = (0, -g, 0)
    body = s.body("b", fb.disk(m, 1))
    s.planar("p", s.ground, body, coordinate="x y f")
    s.constrain("x**2 + y**2 - L**2", name="rod")
    found = fb.equations(s).integrals
    assert found.names == ("energy", "momentum of f")
    assert list(found["energy"].proof.constraints) == ["rod"]
    assert all(one.remainder() == 0 for one in found)

    s = fb.System("rolling")
    m, R = s.parameters(m=1, R=0.5)
    wheel = s.body("wheel", fb.disk(m, R))
    s.planar("p", s.ground, wheel, coordinate="x y f")
    s.constrain_speed("x' + R*f'", name="rolling")
    found = fb.equations(s).integrals
    assert "energy" in found.names and "momentum of x" not in found.names
    assert "momentum of y" in found.names


def test_floating_four_bar_keeps_momentum() -> None:
    s = fb.System("floating loop")
    bars = [s.body(f"b{k}", fb.slender_bar(1, 1, axis="x")) for k in range(3)]
    s.planar("float", s.ground, bars[0], coordinate="x y p")
    s.hinge("j1", bars[0], bars[1], at=("1/2", 0, 0), to=("-1/2", 0, 0), coordinate="q1")
    s.hinge("j2", bars[1], bars[2], at=("1/2", 0, 0), to=("-1/2", 0, 0), coordinate="q2")
    s.constrain("q1 + q2 - 1", name="tie")
    found = fb.equations(s).integrals
    assert found.names == ("energy", "momentum of x", "momentum of y", ORIGIN[2], CENTRE[2])


def test_names_and_text() -> None:
    s = fb.System("pendulum")
    m, L, g = s.parameters(m=1, L=1, g=9.81)
    s.gravity = (0, -g, 0)
    bob = s.body("bob", fb.particle(m))
    s.hinge("pin", s.ground, bob, to=(0, L, 0), coordinate="theta")
    found = fb.equations(s).integrals
    assert found.text() == "energy: m*L^2*theta'^2/2 - m*L*g*cos(theta) = const"
    assert found[0].latex().endswith(r"= \text{const}")
    assert r"\begin{aligned}" in found.latex() and found._repr_latex_().startswith("$")
    assert found[0]._repr_latex_().startswith("$\\displaystyle")
    assert str(found[0].proof) == "d(energy)/dt = theta'*(equation of theta')"
    with pytest.raises(
        fb.errors.ModelError, match=r"Unknown conserved quantity 'enregy'; did you mean 'energy'\?"
    ):
        found["enregy"]


def test_one_quantity_of_two_names() -> None:
    e = fb.equations(gyroscope())
    one = e.integrals["momentum of psi"]
    assert one.also == (ORIGIN[2],)
    assert e.integrals[ORIGIN[2]] is one


@pytest.mark.parametrize("build", [gyroscope, double_pendulum, free_body])
def test_quick(build) -> None:
    assert fb.equations(build()).integrals  # imports and caches of SymPy
    e = fb.equations(build())
    start = time.perf_counter()
    assert len(e.integrals) > 0
    assert time.perf_counter() - start < 0.5


# -- Routh ----------------------------------------------------------------------------------------


def test_routh_of_the_gyroscope() -> None:
    s = gyroscope()
    e = fb.equations(s)
    reduced = e.routh()
    assert reduced.ignorable == ("psi", "phi") and reduced.coordinates == ("theta",)
    ring = e.ring
    theta, rate, acceleration = e.coordinates[1], e.speeds[1], e.model.speeds[1].acceleration
    # d/dt ∂R/∂θ' - ∂R/∂θ is the same canonical polynomial as E_θ with the ignorable speeds put in
    slope = ring.derivative(reduced.canonical_routhian, rate)
    lagrange = slope.total_derivative({theta: ring.generator(rate), rate: ring.generator(acceleration)})
    lagrange = lagrange - ring.derivative(reduced.canonical_routhian, theta)
    assert lagrange == reduced.canonical_equations[0]
    assert sympy.simplify(reduced.equations[0].lhs - ring.to_sympy(lagrange)) == 0
    # recovery: the momenta of the recovered speeds are the symbols
    p_psi, p_phi = reduced.momenta
    speeds = {e.speeds[0]: reduced.recovery["psi"].speed, e.speeds[2]: reduced.recovery["phi"].speed}
    for name, p in (("psi", p_psi), ("phi", p_phi)):
        assert sympy.simplify(reduced.recovery[name].momentum.xreplace(speeds) - p) == 0
    assert "psi' =" in reduced.text() and r"\begin{aligned}" in reduced.latex()
    assert repr(reduced).startswith("Routh's reduction of 'gyroscope', without psi, phi")
    assert reduced._repr_latex_().startswith("$")
    at_rest = reduced.routhian.xreplace({rate: 0})
    assert sympy.simplify(at_rest + reduced.amended_potential) == 0


def test_symbols_of_momenta_do_not_clash() -> None:
    s = carts()
    s.parameters(p_x=1)
    s = fb.System("slide")
    s.parameters(m=1, p_x=1)
    s.slider("j", s.ground, s.body("b", fb.particle("m")), axis="x", coordinate="x")
    assert [str(p) for p in fb.equations(s).routh().momenta] == ["p_x_"]


def test_nothing_to_reduce() -> None:
    with pytest.raises(fb.errors.ModelError, match="No coordinate of 'double_pendulum' is ignorable"):
        fb.equations(double_pendulum()).routh()


def test_the_momentum_of_an_ignorable_coordinate_is_kept_though_other_joints_are_driven() -> None:
    """A control moment gyro turns its platform: H_Z depends on the time, but no moment acts about Z."""
    s = fb.System("gyro on a platform")
    I_P, I_S, I_T, Omega, nu = s.parameters(I_P=12, I_S=0.06, I_T=0.035, Omega=600, nu=0.5)
    platform = s.body("platform", fb.MassProperties(1, (0, 0, 0), ((I_P, 0, 0), (0, I_P, 0), (0, 0, I_P))))
    gimbal = s.body("gimbal", fb.particle(0))
    rotor = s.body("rotor", fb.MassProperties(1, (0, 0, 0), ((I_T, 0, 0), (0, I_S, 0), (0, 0, I_T))))
    s.hinge("pivot", s.ground, platform, axis="z", coordinate="theta")
    s.hinge("gimbal", platform, gimbal, axis="x", coordinate=nu * s.t)
    s.hinge("axle", gimbal, rotor, axis="y", coordinate=Omega * s.t)
    found = fb.equations(s).integrals
    assert found.names == ("momentum of theta",)
    speed, turn = sympy.Derivative(s.expression("theta"), s.t), nu * s.t
    H = (I_P + I_S * sympy.sin(turn) ** 2 + I_T * sympy.cos(turn) ** 2) * speed + I_S * Omega * sympy.sin(
        turn
    )
    assert sympy.simplify(found[0].expression - H) == 0
    assert str(found[0].proof).endswith("(equation of theta')")


def test_a_driven_carrier_keeps_the_momentum_of_what_slides_on_it_unless_a_spring_holds_it() -> None:
    """x'' = -2 k on a cart driven by k t²: m (x' + 2 k t) is constant."""
    names = []
    for held in (False, True):
        s = fb.System("driven")
        m, k = s.parameters(m=1, k=1)
        cart, bob = s.body("cart", fb.particle(m)), s.body("bob", fb.particle(m))
        s.slider("rail", s.ground, cart, axis="x", coordinate=k * s.t**2)
        groove = s.slider("groove", cart, bob, axis="x", coordinate="x")
        if held:
            s.spring("held", groove, stiffness=k)
        names.append(fb.equations(s).integrals.names)
    assert names[0][0] == "momentum of x"
    assert not names[1]
