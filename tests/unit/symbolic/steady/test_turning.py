"""Steady motions of machines with ball and free joints: relative equilibria, against closed forms and motions."""

from __future__ import annotations

import math

import numpy as np
import pytest
import sympy

import freebody as fb
from freebody.errors import ModelError
from freebody.gallery.beyond.rolling_disk import build as rolling_disk


def body(A=1, B=2, C=2.5, kind="ball"):
    s = fb.System("body")
    s.parameters(A=A, B=B, C=C)
    b = s.body("b", fb.MassProperties(1, (0, 0, 0), (("A", 0, 0), (0, "B", 0), (0, 0, "C"))))
    getattr(s, kind)("p", s.ground, b)
    return s


def top():
    s = fb.System("top")
    m, g, L, A, J = s.parameters(m=1, g=9.81, L=0.5, A=0.2, J=0.05)
    for x in (m, g, L, A, J):
        s.assume(x > 0)
    s.gravity = (0, 0, -g)
    b = s.body("b", fb.MassProperties(m, (0, 0, L), ((A, 0, 0), (0, A, 0), (0, 0, J))))
    s.ball("p", s.ground, b)
    return s


def pendulum(spring=False):
    """A sphere on a rod that hangs by a ball joint, from the ground or from a block on a vertical spring."""
    s = fb.System("pendulum")
    m, g, L = s.parameters(m=1, g=9.81, L=0.5)
    s.gravity = (0, 0, -g)
    bob = s.body("bob", fb.sphere(m, "1/10"))
    base = s.ground
    if spring:
        base = s.body("block", fb.particle(2))
        guide = s.slider("guide", s.ground, base, axis="z", coordinate="z")
        s.spring("k", guide, stiffness=400)
    s.ball("p", base, bob, to=(0, 0, L))
    return s


def nutation(s, state, joint="p", until=2.0):
    """Least and greatest angle of the joint's axis from the vertical along the motion that begins so."""
    found = fb.simulate(s, until, initial=state, tolerance=1e-12)
    e1, e2 = (found[f"{joint}_e{k}"] for k in (1, 2))
    cosine = 1 - 2 * (e1**2 + e2**2)
    return cosine.min(), cosine.max()


# -- closed forms ---------------------------------------------------------------------------------


def test_top_on_a_ball_joint():
    """(A + m l² - J) ψ'² cos θ - J ψ' φ' + m g l = 0: (6.98) in the spin φ' about the axis."""
    found = fb.steady_motions(top())
    assert found.unknowns == ("p_psi'", "p_phi'", "p_theta")
    assert found.text().splitlines()[0] == (
        "0 = (m*L^2 + A - J)*p_psi'^2*cos(p_theta) - J*p_psi'*p_phi' + m*g*L or sin(p_theta)"
    )
    (spin,) = (one for one in fb.steady_motions(top(), solve_for="p_phi'") if "p_phi'" in one.solution)
    names = {str(x): x for x in sympy.preorder_traversal(spin.solution["p_phi'"]) if x.is_Symbol}
    t = names["t"]
    psi, theta = sympy.Function("p_psi")(t).diff(t), sympy.Function("p_theta")(t)
    A, J, m, g, L = (names[x] for x in "AJmgL")
    expected = ((A + m * L**2 - J) * psi**2 * sympy.cos(theta) + m * g * L) / (J * psi)
    assert sympy.simplify(spin.solution["p_phi'"] - expected) == 0
    assert fb.steady_motions(top())[0].name == "fast"


def test_top_keeps_its_lean():
    s = top()
    fast, slow = sorted(
        fb.steady_motions(s, values={"p_theta": 0.5, "p_phi'": 80.0}).states,
        key=lambda one: -abs(one.values["p_psi'"]),
    )
    assert fast.name == "fast" and slow.name == "slow"
    for one in (fast, slow):
        assert one.stability.spectral == "stable"
        low, high = nutation(s, one.state)
        assert high - low < 1e-9 and low == pytest.approx(math.cos(0.5), abs=1e-9)


@pytest.mark.parametrize("spin", [0.999, 1.001])
def test_sleeping_top(spin):
    """Stable for (J ω)² > 4 (A + m l²) m g l."""
    critical = math.sqrt(4 * (0.2 + 0.25) * 9.81 * 0.5) / 0.05
    (upright, *_) = fb.steady_motions(top(), values={"p_psi'": 0, "p_phi'": spin * critical}).states
    assert upright.values["p_theta"] == 0
    assert upright.stability.spectral == ("stable" if spin > 1 else "unstable")


def test_pendulum_on_a_ball_joint():
    """Without spin the whole of ω is along the vertical: (m l² + A - J) ψ'² cos θ = m g l, with A = J of a sphere."""
    states = fb.steady_motions(pendulum(), values={"p_psi'": 6, "p_phi'": 0}).states
    angles = [one.values["p_theta"] for one in states]
    # φ' = 0: ω = ψ' about the vertical; the sphere's own inertia is the same about all axes
    assert angles == pytest.approx([0, math.acos(9.81 / (0.5 * 36)), math.pi], rel=1e-14)
    assert [one.stability.spectral for one in states][1:] == ["stable", "unstable"]
    low, high = nutation(pendulum(), states[1].state)
    assert high - low < 1e-9


def test_pendulum_on_a_spring():
    """A ball joint on a body that only slides: the spring carries (m + M) g, whatever the cone."""
    s = pendulum(spring=True)
    states = fb.steady_motions(s, values={"p_psi'": 6, "p_phi'": 0}).states
    cone = next(one for one in states if 0 < one.values["p_theta"] < 3)
    assert cone.values["z"] == pytest.approx(-3 * 9.81 / 400, rel=1e-13)
    found = fb.simulate(s, 1, initial=cone.state, tolerance=1e-12)
    assert np.ptp(found["z"]) < 1e-10


# -- torque-free bodies ---------------------------------------------------------------------------


def test_turning_about_principal_axes():
    """Three axes; that of middle inertia is unstable, with growth w sqrt((B - A)(C - B)/(A C))."""
    s = body()
    states = fb.steady_motions(s, values={"p_psi'": 1.5}).states
    assert len(states) == 3
    for one in states:
        w = np.array([one.state[f"p_w{c}"] for c in "xyz"])
        k = int(np.abs(w).argmax())
        assert np.abs(w[k]) == pytest.approx(1.5) and np.abs(np.delete(w, k)).max() < 1e-14
        assert one.stability.spectral == ("unstable" if k == 1 else "stable")
        if k == 1:
            growth = 1.5 * math.sqrt((2 - 1) * (2.5 - 2) / (1 * 2.5))
            assert one.stability.eigenvalues.real.max() == pytest.approx(growth, rel=1e-12)
    assert fb.steady_motions(s).rates == ("p_psi'",)


def test_regular_precession():
    """A free body of revolution: φ' = (A - C) ψ' cos θ / C, at every θ; its centre moves along the axis as it likes."""
    s = fb.System("spinner")
    A, C = s.parameters(A=1, C=2)
    b = s.body("b", fb.MassProperties(3, (0, 0, 0), ((A, 0, 0), (0, A, 0), (0, 0, C))))
    s.free("p", s.ground, b)
    found = fb.steady_motions(s)
    assert found.rates == ("p_psi'", "p_phi'", "p_z'")
    (one,) = fb.steady_motions(s, values={"p_psi'": 1.0, "p_theta": 0.4, "p_z'": 0.25}).states
    assert one.values["p_phi'"] == pytest.approx((1 - 2) / 2 * math.cos(0.4), rel=1e-13)
    low, high = nutation(s, one.state)
    assert high - low < 1e-9 and low == pytest.approx(math.cos(0.4), abs=1e-9)
    moved = fb.simulate(s, 1, initial=one.state)
    assert moved["p_z"][-1] == pytest.approx(0.25, rel=1e-9)


# -- several joints -------------------------------------------------------------------------------


def test_body_with_a_rotor():
    """A scalar coordinate beside the ball joint: a gyrostat turns about its rotor's axis at any two rates."""
    s = fb.System("gyrostat")
    core = s.body("core", fb.MassProperties(1, (0, 0, 0), ((1, 0, 0), (0, 2, 0), (0, 0, "5/2"))))
    s.ball("p", s.ground, core)
    rotor = s.body("rotor", fb.disk(1, "1/2", axis="z"))
    s.hinge("axle", core, rotor, axis="z", coordinate="r")
    found = fb.steady_motions(s)
    assert found.rates == ("p_psi'", "r'")
    states = fb.steady_motions(s, values={"p_psi'": 1.0, "r'": 20.0}).states
    upright = next(one for one in states if one.values["p_theta"] == 0)
    moved = fb.simulate(s, 1, initial=upright.state, tolerance=1e-11)
    assert np.ptp(moved["p_wz"]) < 1e-9 and np.ptp(moved["r'"]) < 1e-9


@pytest.mark.slow
def test_double_pendulum_of_ball_joints():
    s = fb.System("double")
    s.gravity = (0, 0, -10)
    a, b = s.body("a", fb.sphere(1, 0.1)), s.body("b", fb.sphere(1, 0.1))
    s.ball("p", s.ground, a, to=(0, 0, 1))
    s.ball("q", a, b, to=(0, 0, 1))
    found = fb.steady_motions(s, values={"p_psi'": 5.0, "q_phi'": 0})
    bent = [one for one in found.states if 0.1 < abs(one.values["p_theta"]) < 3]
    assert len(bent) >= 3  # both out on one side, folded, and with the first bar up
    for one in bent:
        low, high = nutation(s, one.state, until=0.2)
        assert high - low < 1e-8
    with pytest.raises(
        ModelError, match="No closed form for p_theta; unsolved: .*give values= for roots in numbers"
    ):
        fb.steady_motions(s, solve_for="p_theta")


# -- continuation -----------------------------------------------------------------------


def test_continuation_over_the_spin():
    s = top()
    found = fb.steady_motions(s, values={"p_theta": 0.5, "p_phi'": 80.0})
    branches = found.continuation("p_phi'", (60, 120))
    assert {len(branch.values["p_psi'"]) > 3 for branch in branches} == {True}


# -- refused --------------------------------------------------------------------------------------


def test_messages():
    with pytest.raises(
        ModelError, match=r"has both constraints \(contact\) and joints with unit quaternions"
    ):
        fb.steady_motions(rolling_disk())
    s = fb.System("fall")
    s.gravity = (0, 0, -9.81)
    s.free("p", s.ground, s.body("b", fb.box(1, (1, 2, 3))))
    with pytest.raises(ModelError, match="'fall' has no steady motion: it would need"):
        fb.steady_motions(s)
    s = fb.System("slanting")
    s.gravity = (0, -6, -8)
    s.ball("p", s.ground, s.body("b", fb.sphere(1, 1)), to=(0, 0, 2))
    with pytest.raises(ModelError, match="Gravity does not stand along an axis of joint 'p' of 'slanting'"):
        fb.steady_motions(s)
    with pytest.raises(
        ModelError, match=r"is given by the angles and rates of its ball and free joints \(p_psi'"
    ):
        fb.linearize(top(), fb.steady_motions(top())[0])
    with pytest.raises(ModelError, match="Expected no `terms` for 'top': .* Ask for these: psi' of the turn"):
        fb.steady_motions(top(), terms={"W": "p_wz"})
    with pytest.raises(
        ModelError, match="'p_thta' is no unknown of the steady motions of 'top'; did you mean 'p_theta'"
    ):
        fb.steady_motions(top(), solve_for="p_thta")
