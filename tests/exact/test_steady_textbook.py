"""Steady motions against the textbook and against `freebody.exact`."""

from __future__ import annotations

import numpy as np
import pytest
import sympy
from sympy import acos, cos, sin, sqrt

import freebody as fb
from freebody.describe.description import names_of
from freebody.exact.gyroscope import (
    gyroscope_moments,
    least_spin,
    precession_response,
    sleeping_spin,
    steady_precession,
)
from freebody.gallery.textbook.examples.sec_6_9_gyroscope import build as gyroscope

EPS = np.finfo(float).eps
SPIN = {"Omega_zeta": "phi' + psi'*cos(theta)"}


def heavy_top():
    """Gyroscope with its moments of inertia about the pivot as parameters: the I_xi, I_zeta of the chapter."""
    s = fb.System("top")
    m, L, g, A, C = s.parameters(m=1, L=0.1, g=9.81, I_xi=0.02, I_zeta=0.004)
    s.parameters(Omega_zeta=300)
    s.gravity = (0, 0, -g)
    s.assume(m > 0), s.assume(L > 0), s.assume(g > 0), s.assume(A > 0), s.assume(C > 0)
    own = A - m * L**2
    rotor = s.body("rotor", fb.MassProperties(m, (0, 0, 0), ((own, 0, 0), (0, own, 0), (0, 0, C))))
    s.gimbal("pivot", s.ground, rotor, to=(0, 0, -L), axis="ZXZ", coordinate="psi theta phi")
    return s


@pytest.fixture(scope="module")
def top():
    s = heavy_top()
    return s, fb.steady_motions(s, terms=SPIN)


def symbols(s):
    atoms = names_of(s).atoms
    return [atoms[k] for k in ("m", "L", "g", "I_xi", "I_zeta", "Omega_zeta", "theta", "psi'")]


def test_condition_of_steady_precession(top) -> None:
    """(6.98): I_xi cos(theta) psi'² - I_zeta Omega psi' + m g L = 0, once sin(theta) = 0 is split off.

    The print has the second term divided by I_xi cos(theta) and the third likewise: the same equation.
    """
    s, found = top
    m, L, g, A, C, Omega, theta, w = symbols(s)
    ((condition, upright),) = found.branches
    assert sympy.expand(condition - (A * cos(theta) * w**2 - C * Omega * w + m * g * L)) == 0
    assert upright == sin(theta)


def test_fast_and_slow_precession(top) -> None:
    """(6.99), (6.100), (6.102)."""
    s, found = top
    m, L, g, A, C, Omega, theta, w = symbols(s)
    c = cos(theta)
    root = sqrt(C**2 * Omega**2 - 4 * m * g * L * A * c)
    assert sympy.simplify(found["fast"].solution["psi'"] - (C * Omega + root) / (2 * A * c)) == 0
    assert sympy.simplify(found["slow"].solution["psi'"] - (C * Omega - root) / (2 * A * c)) == 0
    for one in (found["fast"], found["slow"]):
        (exists,) = one.existence
        assert sympy.expand(exists.lhs - (C**2 * Omega**2 - 4 * m * g * L * A * c)) == 0 and exists.rhs == 0
        assert one.assuming == (Omega > 0,)
    assert sympy.simplify(found["fast"].limits["psi'"] - C * Omega / (A * c)) == 0
    assert sympy.simplify(found["slow"].limits["psi'"] - m * g * L / (C * Omega)) == 0


def test_sleeping_top(top) -> None:
    """Upright, and hanging: by the amended potential, whose limit is taken where Euler's angles are singular."""
    s, found = top
    m, L, g, A, C, Omega, theta, w = symbols(s)
    upright = next(one for one in found if one.solution == {"theta": 0})
    hanging = next(one for one in found if one.solution == {"theta": sympy.pi})
    assert upright.singular and upright.stable_if is None
    ratio = upright.stable_by_energy_if.lhs / (C**2 * Omega**2 - 4 * m * g * L * A)
    assert sympy.simplify(ratio) == 1
    assert hanging.stable_by_energy_if is sympy.true


def test_sleeping_top_by_eigenvalues() -> None:
    """The same condition from the characteristic polynomial, in angles that are not singular upright."""
    s = gyroscope("XYZ", "alpha beta phi")
    upright = next(one for one in fb.steady_motions(s) if list(one.solution.values()) == [0, 0])
    values = {s.expression(k): v for k, v in {"m": 1.2, "R": 0.06, "L": 0.1, "g": 9.81}.items()}
    spin = sleeping_spin(*gyroscope_moments(1.2, 0.06, 0.1), 1.2 * 9.81 * 0.1)
    phi = s.expression("phi'")
    for factor, stable in ((1 - 1e-9, False), (1 + 1e-9, True)):
        conditions = [one.xreplace({**values, phi: spin * factor}) for one in upright.stable_if]
        assert all(bool(one) for one in conditions) is stable


@pytest.mark.parametrize("theta", [0.3, 1.0, 2.0])
@pytest.mark.parametrize("spin", [300.0, 550.0])
def test_numbers_against_exact(theta: float, spin: float) -> None:
    s = gyroscope()
    m, R, L, g = 1.2, 0.06, 0.1, 9.81
    A, C = gyroscope_moments(m, R, L)
    states = fb.steady_motions(s, terms=SPIN, values={"theta": theta, "Omega_zeta": spin}).states
    by_name = {one.name: one for one in states}
    fast, slow = steady_precession(A, C, m * g * L, theta, spin)
    # the slow root loses digits in the coefficients' sum; 16 roundings
    assert by_name["fast"].values["psi'"] == pytest.approx(fast, rel=64 * EPS)
    assert by_name["slow"].values["psi'"] == pytest.approx(slow, rel=64 * EPS)
    for name, one in by_name.items():
        assert one.stability.spectral == "stable" and one.stability.verdict == "stable"
        response = precession_response(A, C, m * g * L, theta, spin, fast=name == "fast")
        assert np.abs(one.stability.eigenvalues.imag).max() == pytest.approx(response.frequency, rel=1e-9)


def test_no_precession_below_the_least_spin() -> None:
    s = gyroscope()
    A, C = gyroscope_moments(1.2, 0.06, 0.1)
    least = least_spin(A, C, 1.2 * 9.81 * 0.1, 1.0)
    found = fb.steady_motions(s, terms=SPIN)
    assert len(found.at({"theta": 1.0, "Omega_zeta": least * (1 - 1e-9)})) == 0
    assert len(found.at({"theta": 1.0, "Omega_zeta": least * (1 + 1e-9)})) == 2


def test_steady_state_stays_steady() -> None:
    s = gyroscope()
    (one,) = (x for x in fb.steady_motions(s, terms=SPIN, values={"theta": 1.0}).states if x.name == "slow")
    trajectory = fb.simulate(s, until=0.5, initial=one.state, tolerance=1e-11)
    assert np.ptp(np.asarray(trajectory["theta"])) < 1e-9
    assert np.asarray(trajectory["psi"])[-1] == pytest.approx(0.5 * one.values["psi'"], rel=1e-8)


def test_regular_precession_without_torque() -> None:
    """psi' = I_zeta Omega / (I_xi cos(theta)): fast precession of a body that nothing turns; stable."""
    s = fb.System("torque-free")
    A, C = s.parameters(A=1, C=2)
    s.assume(A > 0), s.assume(C > 0)
    body = s.body("body", fb.MassProperties(1, (0, 0, 0), ((A, 0, 0), (0, A, 0), (0, 0, C))))
    s.gimbal("j", s.ground, body, axis="ZXZ", coordinate="psi theta phi")
    found = fb.steady_motions(s, terms={"Omega": "phi' + psi'*cos(theta)"})
    theta, Omega = s.expression("theta"), sympy.Symbol("Omega", real=True)
    turning = next(one for one in found if one.solution.get("psi'", 0) != 0)
    assert sympy.simplify(turning.solution["psi'"] - C * Omega / (A * cos(theta))) == 0
    assert turning.existence == () and turning.stable_if == ()
    assert turning.stable_by_energy_if is sympy.true
    # nutation at the rate of the angular momentum over A, seen from the nodal frame
    c = sympy.Poly(turning.characteristic, sympy.Symbol("s"))
    frequency = sympy.sqrt(c.coeff_monomial(1) / c.coeff_monomial(sympy.Symbol("s") ** 2))
    assert sympy.simplify(frequency**2 - (C * Omega / (A * cos(theta))) ** 2) == 0


def test_conical_pendulum() -> None:
    s = fb.System("conical pendulum")
    m, L, g = s.parameters(m=1, L=0.5, g=9.81)
    s.assume(L > 0), s.assume(g > 0)
    s.gravity = (0, 0, -g)
    bob = s.body("bob", fb.particle(m))
    s.universal("arm", s.ground, bob, to=(0, 0, L), axis=("z", "x"), coordinate="psi theta")
    theta, w = s.expression("theta"), s.expression("psi'")
    cone = fb.steady_motions(s, solve_for="theta")[0]
    assert cone.solution == {"theta": acos(g / (L * w**2))}
    assert cone.existence == (sympy.Ge(L * w**2 - g, 0),)
    rates = fb.steady_motions(s)
    assert sympy.simplify(rates[0].solution["psi'"] ** 2 - g / (L * cos(theta))) == 0
    # Landau and Lifshitz, Mechanics, §14: small oscillations at w² (1 + 3 cos²)
    c = sympy.Poly(rates[0].characteristic, sympy.Symbol("s"))
    square = c.coeff_monomial(1) / c.coeff_monomial(sympy.Symbol("s") ** 2)
    assert sympy.simplify(square - g / (L * cos(theta)) * (1 + 3 * cos(theta) ** 2)) == 0


def bead(driven: bool):
    s = fb.System("bead on a hoop")
    m, R, g, Omega = s.parameters(m=1, R=1, g=9.81, Omega=3)
    s.assume(g > 0), s.assume(R > 0)
    s.gravity = (0, 0, -g)
    hoop, ball = s.body("hoop", fb.ring(3 * m, R, axis="x")), s.body("bead", fb.particle(m))
    s.hinge("axle", s.ground, hoop, axis="z", coordinate=Omega * s.t if driven else "psi")
    s.hinge("wire", hoop, ball, to=(0, 0, R), axis="x", coordinate="theta")
    return s


def test_bead_on_a_driven_hoop() -> None:
    """Below Omega² = g/R the bead stays at the bottom, above it at cos(theta) = g/(R Omega²)."""
    s = bead(driven=True)
    R, g, Omega = (s.expression(k) for k in ("R", "g", "Omega"))
    found = fb.steady_motions(s)
    aside = found[0]
    assert aside.solution == {"theta": acos(g / (R * Omega**2))}
    assert aside.existence == (sympy.Ge(Omega**2 * R - g, 0),)
    assert aside.stable_if == (sympy.Gt(Omega**2 * R - g, 0),)
    bottom, above = found["theta = 0"], found["theta = pi"]
    assert bottom.stable_if == (sympy.Gt(g - Omega**2 * R, 0),) and above.stable_if == (sympy.false,)
    assert bottom.stable_by_energy_if == sympy.Gt(g - Omega**2 * R, 0)
    assert [one.stability.verdict for one in found.at({"Omega": 3})] == ["stable", "unstable"]
    assert [round(one.values["theta"], 3) for one in found.at({"Omega": 5})] == [-1.168, 0, 1.168, 3.142]


def test_bifurcation_of_the_bead() -> None:
    branches = fb.steady_motions(bead(driven=True)).continuation("Omega", (1, 6))
    critical = np.sqrt(9.81)
    bottom, top, aside = branches
    assert np.abs(bottom.values["theta"]).max() == 0 and np.ptp(top.values["theta"]) == 0
    assert bottom.folds == () and top.special == ()
    # the branches cross: the test function vanishes linearly on the bottom branch, on a parabola aside
    assert [one.parameter for one in bottom.bifurcations] == [pytest.approx(critical, rel=1e-10)]
    assert [one.parameter for one in aside.bifurcations] == [pytest.approx(critical, rel=1e-8)]
    assert bottom.stable[0] == "stable" and bottom.stable[-1] == "unstable"
    inside = slice(1, -1)
    np.testing.assert_allclose(
        np.cos(aside.values["theta"][inside]), 9.81 / aside.parameters[inside] ** 2, rtol=1e-9
    )
    assert repr(bottom) == "Branch over Omega from 1 to 6, 52 points, bifurcation at 3.13209"


def test_bead_on_a_free_hoop() -> None:
    s = bead(driven=False)
    R, g, w = (s.expression(k) for k in ("R", "g", "psi'"))
    found = fb.steady_motions(s, solve_for="theta")
    assert found[0].solution == {"theta": acos(g / (R * w**2))}
    assert [one.stability.verdict for one in found.at({"psi'": 5})] == [
        "stable",
        "unstable",
        "stable",
        "unstable",
    ]


def test_watt_governor() -> None:
    """cos(theta) = (m + M) g / (m L Omega²), with the sleeve of mass M lifted by both pairs of arms."""
    s = fb.System("governor")
    m, M, L, g, Omega = s.parameters(m=1, M=2, L=1, g=9.81, Omega=8)
    s.assume(L > 0), s.assume(g > 0)
    s.gravity = (0, 0, -g)
    theta = s.coordinates("theta")
    shaft = s.body("shaft", fb.particle(1))
    s.hinge("axle", s.ground, shaft, axis="z", coordinate=Omega * s.t)
    for k, sign in enumerate((1, -1)):
        ball = s.body(f"ball{k}", fb.particle(m))
        s.hinge(f"arm{k}", shaft, ball, to=(0, 0, L), axis="x", coordinate=sign * theta)
    s.slider("collar", shaft, s.body("sleeve", fb.particle(M)), axis="z", coordinate=-2 * L * cos(theta))
    found = fb.steady_motions(s)
    assert sympy.simplify(cos(found[0].solution["theta"]) - (m + M) * g / (m * L * Omega**2)) == 0
    (exists,) = found[0].existence
    assert sympy.expand(exists.lhs - (m * L * Omega**2 - (m + M) * g)) == 0
    assert found.at({})[-2].values["theta"] == pytest.approx(np.arccos(3 * 9.81 / 64), rel=8 * EPS)


def test_steady_turns_of_a_rolling_disk() -> None:
    """5 psi'² sin cos + 6 psi' phi' sin + 4 (g/R) cos = 0 for a thin disk, theta from the vertical to its axis.

    D. T. Greenwood, Principles of Dynamics, 2nd ed., §8-5 (thin disk), in his angles.
    """
    s = fb.System("disk")
    m, R, g = s.parameters(m=1, R=0.5, g=9.81)
    s.assume(R > 0), s.assume(g > 0)
    s.gravity = (0, 0, -g)
    psi, theta, phi = s.coordinates("psi theta phi")
    first, second, third = (s.body(name, fb.particle(0)) for name in "abc")
    disk = s.body("disk", fb.disk(m, R))
    s.slider("sx", s.ground, first, axis="x", coordinate="x")
    s.slider("sy", first, second, axis="y", coordinate="y")
    s.slider("sz", second, third, axis="z", coordinate=R * sin(theta))
    s.gimbal("g", third, disk, axis="ZXZ", coordinate=[psi, theta, phi])
    # velocity of the lowest point, -R along the disk's line of slope: v_C + R (w_zeta i - theta' k)
    spin = phi.diff(s.t) + psi.diff(s.t) * cos(theta)
    x, y = s.expression("x'"), s.expression("y'")
    s.constrain_speed(x + R * (spin * cos(psi) - theta.diff(s.t) * sin(psi) * sin(theta)), name="roll_x")
    s.constrain_speed(y + R * (spin * sin(psi) + theta.diff(s.t) * cos(psi) * sin(theta)), name="roll_y")
    found = fb.steady_motions(s, solve_for="phi'")
    assert found.rates == ("psi'", "phi'")
    w, p = psi.diff(s.t), phi.diff(s.t)
    ((condition,),) = found.branches
    expected = R * (5 * w**2 * sin(theta) * cos(theta) + 6 * w * p * sin(theta)) + 4 * g * cos(theta)
    assert sympy.expand(condition - expected) in (0, sympy.expand(-2 * expected))
    (one,) = found.at({"theta": 1.2, "psi'": 2.0})
    # it rolls on a circle: speeds of the centre follow from the conditions
    assert one.state["x'"] == pytest.approx(-0.5 * (one.values["phi'"] + 2 * np.cos(1.2)), rel=8 * EPS)
    assert "energy" in fb.equations(s).integrals.names


def test_rolling_straight_ahead_is_stable_above_a_speed() -> None:
    """Upright thin disk: stable for phi'² > g/(3 R).

    D. T. Greenwood, Principles of Dynamics, 2nd ed., §8-5; L. A. Pars, A Treatise on Analytical Dynamics, §8.13.
    """
    s = fb.System("upright disk")
    m, R, g = s.parameters(m=1, R=0.5, g=9.81)
    s.assume(R > 0), s.assume(g > 0)
    s.gravity = (0, 0, -g)
    # lean is zero upright: heading, lean, roll about Z, X, Y of the wheel, whose axis is y
    psi, lean, phi = s.coordinates("psi lean phi")
    first, second, third = (s.body(name, fb.particle(0)) for name in "abc")
    disk = s.body("disk", fb.disk(m, R, axis="y"))
    s.slider("sx", s.ground, first, axis="x", coordinate="x")
    s.slider("sy", first, second, axis="y", coordinate="y")
    s.slider("sz", second, third, axis="z", coordinate=R * cos(lean))
    s.gimbal("g", third, disk, axis="ZXY", coordinate=[psi, lean, phi])
    spin = phi.diff(s.t) + psi.diff(s.t) * sin(lean)
    x, y = s.expression("x'"), s.expression("y'")
    # contact at -R along the wheel's upright line k: w × (-R k) = -R (spin i - lean' j), i ahead, j sideways
    ahead = (cos(psi), sin(psi))
    aside = (-sin(psi) * cos(lean), cos(psi) * cos(lean))
    s.constrain_speed(x - R * (spin * ahead[0] - lean.diff(s.t) * aside[0]), name="roll_x")
    s.constrain_speed(y - R * (spin * ahead[1] - lean.diff(s.t) * aside[1]), name="roll_y")
    found = fb.steady_motions(s)
    states = found.at({"phi'": 1.0, "psi'": 0.0})
    upright = [one for one in states if one.values["lean"] == 0]
    assert len(upright) == 1
    critical = np.sqrt(9.81 / (3 * 0.5))
    for factor, verdict in ((0.99, "unstable"), (1.01, "stable")):
        states = found.at({"phi'": critical * factor, "psi'": 0.0})
        (one,) = (x for x in states if x.values["lean"] == 0)
        assert one.stability.spectral == verdict
