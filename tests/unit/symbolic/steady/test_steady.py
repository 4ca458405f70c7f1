"""Steady motions: conditions, branches, numbers, continuation, stability, and what cannot be done."""

from __future__ import annotations

import math
import re
from fractions import Fraction
from types import SimpleNamespace

import numpy as np
import pytest
import sympy

import freebody as fb
from freebody.gallery.textbook.examples.ex_6_5_cart_and_bar import build as cart_and_bar
from freebody.gallery.textbook.examples.sec_6_9_gyroscope import build as gyroscope
from freebody.gallery.textbook.problems.prob_6_15_double_pendulum import build as double_pendulum
from freebody.scalar.polynomial import Ring
from freebody.scalar.series import SeriesField
from freebody.scalar.substitute import Substitution, arrays
from freebody.symbolic.steady.problem import Problem
from freebody.symbolic.steady.solve import roots_of
from freebody.symbolic.steady.stability import hurwitz

EPS = np.finfo(float).eps
SPIN = {"Omega_zeta": "phi' + psi'*cos(theta)"}


def pendulum(damping=0):
    s = fb.System("pendulum")
    m, L, g = s.parameters(m=1, L=2, g=9.81)
    s.parameters(c=damping)
    s.assume(g > 0), s.assume(L > 0)
    s.gravity = (0, -g, 0)
    pin = s.hinge("pin", s.ground, s.body("bob", fb.particle(m)), to=(0, L, 0), coordinate="theta")
    if damping:
        s.damper("d", pin, damping="c")
    return s


def point(load=None, gravity=0):
    s = fb.System("point")
    s.parameters(m=1, g=9.81, F=3)
    body = s.body("b", fb.particle("m"))
    s.slider("j", s.ground, body, axis="z", coordinate="z")
    s.gravity = (0, 0, gravity)
    if load:
        s.generalized_force("z", load)
    return s


# -- closed forms ---------------------------------------------------------------------------------


def test_equilibria_of_a_pendulum() -> None:
    found = fb.steady_motions(pendulum())
    assert found.text() == "0 = sin(theta)\ntheta = 0\ntheta = pi"
    assert found.rates == () and found.unknowns == ("theta",)
    hanging, standing = found
    assert hanging.stable_if == () and standing.stable_if == (sympy.false,)
    assert hanging.stable_by_energy_if is sympy.true and standing.stable_by_energy_if is sympy.false
    s = sympy.Symbol("s")
    m, L, g = sympy.symbols("m L g", real=True)
    assert sympy.expand(hanging.characteristic - (m * L**2 * s**2 + m * g * L)) == 0


def test_damping_decides() -> None:
    found = fb.steady_motions(pendulum(damping=0.3), values={})
    hanging, standing = found.states
    assert hanging.stability.verdict == "asymptotically stable" and standing.stability.verdict == "unstable"
    # m L² s² + c s + m g L
    np.testing.assert_allclose(
        np.sort_complex(hanging.stability.eigenvalues),
        np.sort_complex(np.roots([4, 0.3, 2 * 9.81])),
        rtol=16 * EPS,
    )
    assert found[0].stable_if == (sympy.Gt(sympy.Symbol("c", real=True), 0),)


def test_all_equilibria_of_a_double_pendulum() -> None:
    found = fb.steady_motions(double_pendulum(), values={})
    assert [tuple(one.solution.values()) for one in found] == [
        (0, 0), (0, sympy.pi), (sympy.pi, 0), (sympy.pi, sympy.pi)
    ]  # fmt: skip
    assert [one.stability.verdict for one in found.states] == ["stable", "unstable", "unstable", "unstable"]
    assert [one.stability.energy for one in found.states] == ["stable", "unstable", "unstable", "undecided"]


def test_balance_of_sine_and_cosine() -> None:
    found = fb.steady_motions(cart_and_bar())
    F, k, m, g = sympy.symbols("F k m g", real=True)
    assert found[0].solution == {"x": F / k, "theta": sympy.atan(2 * F / (m * g))}
    assert sympy.expand(found[1].solution["theta"] - found[0].solution["theta"]) == sympy.pi


def test_sine_cosine_and_a_constant() -> None:
    """A bar turned by a couple under its weight and a side load: a sin + b cos + d = 0, both roots."""
    s = fb.System("loaded")
    a, b, d = s.parameters(a=3, b=4, d=2)
    s.hinge("pin", s.ground, s.body("bar", fb.slender_bar(1, 1)), coordinate="theta")
    s.generalized_force("theta", "a*sin(theta) + b*cos(theta) + d")
    found = fb.steady_motions(s)
    (exists,) = found[0].existence
    assert found[1].existence == (exists,) and sympy.expand(exists.lhs - (a**2 + b**2 - d**2)) == 0
    values = {a: 3, b: 4, d: 2}
    closed = sorted(float(one.solution["theta"].xreplace(values)) for one in found)
    for x in closed:
        assert 3 * np.sin(x) + 4 * np.cos(x) + 2 == pytest.approx(0, abs=16 * EPS)
    assert [one.values["theta"] for one in found.at({})] == pytest.approx(closed, rel=16 * EPS)
    assert found.at({"d": 6}) == ()


def test_quartic_in_squares() -> None:
    found = fb.steady_motions(point("F*(z^4 - 5*z^2 + 4)"))
    z = [float(one.solution["z"].subs("F", 3)) for one in found]
    assert sorted(z) == pytest.approx([-2, -1, 1, 2], rel=8 * EPS)


def test_roots_without_a_closed_form() -> None:
    s = point("F*(z^5 - z - 1)")
    found = fb.steady_motions(s)
    assert len(found) == 1 and len(found[0].left) == 1 and "where" in found.text()
    (one,) = found.at({})
    assert one.values["z"] == pytest.approx(1.1673039782614187, rel=4 * EPS)
    assert one.residual < 8 * EPS and one.error < 8 * EPS
    with pytest.raises(
        fb.errors.ModelError,
        match=r"No closed form for z; unsolved: F\*\(z\^5 - z - 1\) = 0|unsolved: .* = 0",
    ):
        fb.steady_motions(s, solve_for="z")


def test_roots_of_other_functions() -> None:
    states = fb.steady_motions(point("F*(exp(z) - 2 - z)")).at({})
    assert [round(one.values["z"], 6) for one in states] == [-1.841406, 1.146193]


def test_coupled_unknowns_in_numbers() -> None:
    s = fb.System("two")
    s.parameters(k=1)
    a, b = s.body("a", fb.particle(1)), s.body("b", fb.particle(1))
    s.slider("ja", s.ground, a, axis="x", coordinate="x")
    s.slider("jb", s.ground, b, axis="y", coordinate="y")
    s.generalized_force("x", "k*(x^2 + y^2 - 5)")
    s.generalized_force("y", "k*(x*y - 2)")
    states = fb.steady_motions(s).at({})
    found = sorted((round(one.values["x"], 9), round(one.values["y"], 9)) for one in states)
    assert found == [(-2, -1), (-1, -2), (1, 2), (2, 1)]


def test_symmetry_of_absolute_azimuths() -> None:
    """Nothing depends on a turn of both azimuths together: one rate, found without being told."""
    s = fb.System("double")
    m, L, g = s.parameters(m=1, L=1, g=9.81)
    s.gravity = (0, 0, -g)
    p1, t1, p2, t2 = s.coordinates("p1 t1 p2 t2")
    a, b, w = s.body("a", fb.particle(m)), s.body("b", fb.particle(m)), s.body("w", fb.particle(0))
    s.universal("j1", s.ground, a, to=(0, 0, L), axis=("z", "x"), coordinate=[p1, t1])
    s.hinge("level", a, w, axis="x", coordinate=-t1)
    s.universal("j2", w, b, to=(0, 0, L), axis=("z", "x"), coordinate=[p2 - p1, t2])
    found = fb.steady_motions(s)
    assert found.rates == ("p1'",)
    e = fb.equations(s)
    assert Problem(e).families == [{0: 1, 2: 1}]
    states = [one for one in found.at({"p1'": 6.0}) if one.stability.spectral != "singular"]
    for one in states:
        t1_, t2_ = one.values["t1"], one.values["t2"]
        side = 1 if abs(one.values["p2"]) < 1 else -1
        # forces on both, and on the lower bob alone, along and across their arms
        assert 36 * (np.sin(t1_) * side + np.sin(t2_)) * np.cos(t2_) == pytest.approx(
            9.81 * np.sin(t2_), abs=1e-12
        )
        assert one.state["p2'"] == one.state["p1'"] == 6.0
    assert len([one for one in states if one.stability.verdict == "stable"]) == 8


def test_equilibrium_under_constraints() -> None:
    s = fb.System("rod")
    m, L, g = s.parameters(m=1, L=2, g=9.81)
    s.gravity = (0, -g, 0)
    s.assume(g > 0), s.assume(L > 0)
    s.planar("p", s.ground, s.body("b", fb.disk(m, 1)), coordinate="x y f")
    s.constrain("x**2 + y**2 - L**2", name="rod")
    low, high = sorted(fb.steady_motions(s).at({}), key=lambda one: one.values["y"])
    assert low.values == pytest.approx({"rod": -9.81 / 4, "x": 0, "y": -2}, abs=16 * EPS)
    # a pendulum: s² = -g/L, and two zeros of the free turning
    frequency = np.abs(low.stability.eigenvalues.imag).max()
    assert frequency == pytest.approx(np.sqrt(9.81 / 2), rel=1e-9)
    assert low.stability.spectral == "stable" and high.stability.spectral == "unstable"


# -- numbers --------------------------------------------------------------------------------------


def test_state_in_numbers() -> None:
    (slow, fast) = fb.steady_motions(gyroscope(), terms=SPIN, values={"theta": 1.0}).states
    assert (slow.name, fast.name) == ("slow", "fast")
    assert set(slow.state) == {"psi", "theta", "phi", "psi'", "theta'", "phi'"}
    assert slow.state["phi'"] == pytest.approx(300 - slow.values["psi'"] * np.cos(1.0), rel=4 * EPS)
    assert repr(slow).startswith(
        "slow: theta = 1, Omega_zeta = 300, psi' = 1.8541609; stable (spectral: stable"
    )
    assert slow.residual < 16 * EPS


def test_values_of_rates_that_are_open() -> None:
    s = gyroscope("XYZ", "alpha beta phi")
    found = fb.steady_motions(s)
    assert found[0].free == ("phi'",)
    states = [
        one for one in found.at({"phi'": 300}) if abs(one.values["alpha"]) + abs(one.values["beta"]) == 0
    ]
    assert [one.stability.verdict for one in states] == ["stable"]
    states = [
        one for one in found.at({"phi'": 30}) if abs(one.values["alpha"]) + abs(one.values["beta"]) == 0
    ]
    assert [one.stability.verdict for one in states] == ["unstable"]


def test_stability_where_angles_are_singular() -> None:
    """The sleeping top in Euler angles: no eigenvalues there, but the amended potential has a limit."""
    found = fb.steady_motions(gyroscope(), terms=SPIN)
    for spin, verdict in ((300, "stable"), (30, "unstable")):
        upright = next(one for one in found.at({"psi'": 0, "Omega_zeta": spin}) if one.values["theta"] == 0)
        assert upright.stability.spectral == "singular" and upright.stability.verdict == verdict


# -- continuation ---------------------------------------------------------------------------------


def test_fold_of_a_branch() -> None:
    """z² = p: the branch turns back at p = 0."""
    s = fb.System("fold")
    s.parameters(p=1)
    s.slider("j", s.ground, s.body("b", fb.particle(1)), axis="z", coordinate="z")
    s.generalized_force("z", "p - z^2")
    (branch,) = fb.steady_motions(s).continuation("p", (-1, 4))
    assert [one.kind for one in branch.special] == ["fold"]
    assert branch.folds[0].parameter == pytest.approx(0, abs=1e-9)
    assert branch.folds[0].values["z"] == pytest.approx(0, abs=1e-6)
    np.testing.assert_allclose(branch.values["z"] ** 2, branch.parameters, atol=1e-9)
    assert sorted(branch.values["z"][[0, -1]]) == pytest.approx([-2, 2], rel=1e-9)
    assert set(branch.stable) == {"stable", "unstable"} or set(branch.stable) == {
        "stable",
        "unstable",
        "undecided",
    }


def test_continuation_of_a_rate() -> None:
    found = fb.steady_motions(gyroscope(), terms=SPIN)
    branches = found.continuation("Omega_zeta", (50, 600), values={"theta": 1.0})
    (branch,) = branches
    (fold,) = branch.folds
    from freebody.exact.gyroscope import gyroscope_moments, least_spin

    assert fold.parameter == pytest.approx(
        least_spin(*gyroscope_moments(1.2, 0.06, 0.1), 1.2 * 9.81 * 0.1, 1.0), rel=1e-9
    )
    assert branch.parameter == "Omega_zeta" and set(branch.values) == {"psi'"}


@pytest.mark.parametrize(
    ("parameter", "span", "message"),
    [
        ("Omga", (1, 2), "Unknown parameter 'Omga' to continue along"),
        ("p", 3, "Expected a range of two numbers to continue over, such as"),
        ("p", (2, 2), "Expected a range of two different finite numbers"),
        ("p", (-2, -1), "No steady motion at either end of the range of p from -2 to -1"),
    ],
)
def test_continuation_refuses(parameter, span, message) -> None:
    s = fb.System("fold")
    s.parameters(p=1)
    s.slider("j", s.ground, s.body("b", fb.particle(1)), axis="z", coordinate="z")
    s.generalized_force("z", "p - z^2")
    with pytest.raises(fb.errors.ModelError, match=message):
        fb.steady_motions(s).continuation(parameter, span)


# -- errors ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: point(gravity="-g"), "'point' has no steady motion: it would need g = 0. Change the loads"),
        (lambda: point("3"), "'point' has no steady motion: it would need 3 = 0"),
        (lambda: point("F*sin(t)"), "has no steady motion: the equation of z' depends on the time"),
        (lambda: point("-F*exp(z)"), "'point' has no steady motion|No steady"),
    ],
    ids=["falling", "pushed", "shaken", "never"],
)
def test_no_steady_motion(build, message) -> None:
    with pytest.raises(fb.errors.ModelError, match=message):
        fb.steady_motions(build())


def along(law: str) -> fb.System:
    """A particle on a line under a force by its coordinate z."""
    s = fb.System("along")
    s.slider("j", s.ground, s.body("b", fb.particle(1)), axis="z", coordinate="z")
    s.generalized_force("z", law)
    return s


def test_a_root_at_which_gravitation_has_no_value_is_none() -> None:
    s = fb.System("attracted")
    b = s.body("b", fb.particle(1))
    s.slider("j", s.ground, b, axis="z", coordinate="z")
    s.gravitation("pull", b, parameter=2)
    message = "'attracted' has no steady motion: it would need 2*z = 0, and there the loads or conditions have no value"
    with pytest.raises(fb.errors.ModelError, match=re.escape(message)):
        fb.steady_motions(s)


@pytest.mark.parametrize(
    ("law", "forms", "roots"),
    [
        ("z*(z - 2)/abs(z)", ["z = 2"], [2]),  # -+2 beside zero, no value there
        ("abs(z)/z - z", ["any z  where abs(z) - z^2 = 0"], [-1, 1]),
        ("z^2/z - z^3", ["z = 0", "z = 1", "z = -1"], [-1, 0, 1]),  # the quotient is z, also at zero
        ("-abs(z)", ["z = 0"], [0]),  # a value without a slope
        ("-tanh(z)", ["z = 0"], [0]),
        ("z*sqrt(z) - z*abs(z)", ["z = 0", "any z  where abs(z) - sqrt(z) = 0"], [0, 1]),
    ],
)
def test_roots_are_where_the_law_has_a_value(law, forms, roots) -> None:
    motions = fb.steady_motions(along(law))
    assert motions.text().splitlines()[1:] == forms
    assert [state.values["z"] for state in motions.states] == pytest.approx(roots, rel=1e-15)


def test_a_law_without_a_slope_leaves_stability_undecided() -> None:
    (state,) = fb.steady_motions(along("-abs(z)")).states
    assert (state.stability.spectral, state.stability.energy) == ("undecided", "undecided")


def test_unknown_names() -> None:
    with pytest.raises(
        fb.errors.ModelError,
        match="'thta' is no unknown of the steady motions of 'gyroscope'; did you mean 'theta'",
    ):
        fb.steady_motions(gyroscope(), solve_for="thta")
    with pytest.raises(
        fb.errors.ModelError, match="Expected the term 'W' to hold a rate of this steady motion"
    ):
        fb.steady_motions(gyroscope(), terms={"W": "psi'*cos(theta)"})
    found = fb.steady_motions(pendulum())
    with pytest.raises(fb.errors.ModelError, match="'theta'' is no unknown of these steady motions"):
        found.at({"theta'": 1})
    with pytest.raises(fb.errors.ModelError, match="Unknown steady motion 'fast'"):
        found["fast"]


def test_too_few_values() -> None:
    found = fb.steady_motions(gyroscope(), terms=SPIN)
    with pytest.raises(
        fb.errors.ModelError, match=r"do not determine psi', theta. Give values of some of them"
    ):
        found.at({"Omega_zeta": 300})


def test_dependent_conditions_on_speeds() -> None:
    s = fb.System("wheel")
    s.planar("p", s.ground, s.body("w", fb.disk(1, 1)), coordinate="x y f")
    s.constrain_speed("x' + f'", name="a")
    s.constrain_speed("2*x' + 2*f'", name="b")
    with pytest.raises(fb.errors.ModelError, match="The conditions on speeds depend on each other"):
        fb.steady_motions(s)


# -- display --------------------------------------------------------------------------------------


def test_what_may_have_any_value() -> None:
    def block() -> tuple[fb.System, fb.Joint]:
        s = fb.System("block")
        return s, s.slider("guide", s.ground, s.body("b", fb.particle(1)), axis="x", coordinate="x")

    s, _ = block()
    assert fb.steady_motions(s).text() == "any x'"
    s, guide = block()
    s.friction("dry", guide, force=2)
    stuck = fb.steady_motions(fb.equations(s, modes={"dry": "stick"}))
    assert stuck.text() == "any x" and r"\text{any } x" in stuck.latex()


def test_display() -> None:
    found = fb.steady_motions(gyroscope(), terms=SPIN)
    lines = found.text().splitlines()
    assert lines[0] == "0 = (R^2 + 4*L^2)*psi'^2*cos(theta) - 2*R^2*Omega_zeta*psi' + 4*L*g or sin(theta)"
    assert lines[1].startswith("fast: psi' = (R^2*Omega_zeta + sqrt(R^4*Omega_zeta^2 - ")
    assert lines[1].endswith("if R^4*Omega_zeta^2 - 4*(R^2 + 4*L^2)*L*g*cos(theta) >= 0")
    assert lines[3] == "theta = 0, any psi', Omega_zeta  (coordinates are singular here)"
    assert repr(found).startswith("Steady motions of 'gyroscope'\n0 = ")
    latex = found.latex()
    assert r"\text{fast: }" in latex and r"\ge 0" in latex and r"\ \text{or}\ " in latex
    assert found._repr_latex_().startswith("$") and found[0]._repr_latex_().startswith("$")
    assert found[0].text() == lines[1] == repr(found[0])
    (condition,) = found.conditions
    assert isinstance(condition, sympy.Eq) and condition.rhs == 0
    numbers = fb.steady_motions(gyroscope(), terms=SPIN, values={"theta": 1.0})
    assert "slow: theta = 1" in repr(numbers)
    assert found["fast"] is found[0] and len(found) == 4


# -- substitution ---------------------------------------------------------------------------------


def test_substitution_in_other_fields() -> None:
    t = sympy.Symbol("t")
    m, q = sympy.Symbol("m", real=True), sympy.Function("q")(t)
    ring = Ring()
    x = ring.from_sympy(
        m * sympy.sin(q) ** 2 + sympy.sqrt(2) * q / (1 + m) - sympy.pi * sympy.exp(m) + sympy.Rational(1, 3)
    )
    given = {m: np.array([0.5, 2.0]), q: np.array([1.0, -0.3])}
    expected = (
        given[m] * np.sin(given[q]) ** 2
        + np.sqrt(2) * given[q] / (1 + given[m])
        - np.pi * np.exp(given[m])
        + 1 / 3
    )
    np.testing.assert_allclose(Substitution(ring, arrays, given)(x), expected, rtol=8 * EPS)
    assert Substitution(ring, ring, {q: 0})(x) == ring.from_sympy(
        -sympy.pi * sympy.exp(m) + sympy.Rational(1, 3)
    )
    field = SeriesField(ring, 1)
    along = Substitution(ring, field, {m: field.series([1]), q: field.series([0, 1])})(
        ring.from_sympy(m * sympy.sin(q))
    )
    assert along.c == (0, 1)
    with pytest.raises(KeyError):
        Substitution(ring, arrays, {m: 1.0})(x)


def tackle():
    s = fb.System("tackle")
    M, m, g, L = s.parameters(M=100, m=30, g=9.81, L=14)
    s.gravity = (g, 0, 0)
    block, weight = s.body("block", fb.particle(M)), s.body("weight", fb.particle(m))
    s.slider("b", s.ground, block, axis="x", coordinate="x")
    s.slider("w", s.ground, weight, at=(0, 0, 1), axis="x", coordinate="y")
    up, over = s.ground.point(0, 0, 0), s.ground.point(0, 0, 1)
    s.rope([up, block.origin, up, block.origin, up, over, weight.origin], L + 1)
    return s


def test_conditions_freed_of_a_length_have_no_roots_of_their_own():
    """A block and tackle: a balance times |y| holds at y = 0, the balance itself does not."""
    found = fb.steady_motions(tackle())
    assert found.at({}) == ()
    balanced = found.at({"m": 25})  # wherever it hangs
    assert balanced
    for state in balanced:
        assert abs(state.values["rope"]) == pytest.approx(25 * 9.81)
        assert 4 * abs(state.values["x"]) + abs(state.values["y"]) == pytest.approx(14)


def linkage(a, b, c, d):
    """Four bars without forces."""
    s = fb.System("four bars")
    A, B, C = (s.body(name, fb.slender_bar(1, x)) for name, x in zip("ABC", (a, b, c), strict=True))
    s.hinge("O", s.ground, A, to=(-a / 2, 0, 0), axis="z", coordinate="p")
    s.hinge("P", A, B, at=(a / 2, 0, 0), to=(-b / 2, 0, 0), axis="z", coordinate="q")
    s.hinge("G", s.ground, C, at=(d, 0, 0), to=(-c / 2, 0, 0), axis="z", coordinate="r")
    s.hinge("Q", B, C, at=(b / 2, 0, 0), to=(c / 2, 0, 0))
    return s


def gap(p, q, r, a, b, c, d):
    """Of the loop."""
    return [
        a * np.cos(p) + b * np.cos(p + q) - d - c * np.cos(r),
        a * np.sin(p) + b * np.sin(p + q) - c * np.sin(r),
    ]


BARS = [
    (Fraction(3, 10), Fraction(9, 10), Fraction(7, 10), 1),
    (Fraction(8, 10), Fraction(6, 10), Fraction(7, 10), 1),
]


@pytest.mark.parametrize(
    ("bars", "pieces"),
    [pytest.param(BARS[0], 2, marks=pytest.mark.slow), (BARS[1], 1)],
    ids=["Grashof", "not Grashof"],
)
def test_a_linkage_without_forces_rests_anywhere_on_its_circuits(bars, pieces) -> None:
    """Its closed positions are one circle, or two where a bar can turn all the way round (Grashof's law)."""
    found = fb.steady_motions(linkage(*bars), values={})
    assert len(found.states) == pieces
    for state in found.states:
        assert np.abs(gap(*(state.state[name] for name in "pqr"), *map(float, bars))).max() < 1e-12
        assert state.values["Q_x"] == state.values["Q_y"] == 0
        assert state.stability.family == 1 and state.stability.verdict == "neutral along the family"
        assert "one of a family of dimension 1, neutral along the family" in state.text()
        assert np.abs(state.stability.eigenvalues).max() == 0


def test_a_place_that_is_given_picks_members_of_the_family() -> None:
    """A root found by division by what a later root makes zero is no solution: it is left out, not divided by."""
    found = fb.steady_motions(linkage(*BARS[0]), values={"p": 1.0})
    assert len(found.states) == 2  # the open and the crossed one
    for state in found.states:
        assert np.abs(gap(*(state.state[name] for name in "pqr"), *map(float, BARS[0]))).max() < 1e-12
        assert max(abs(state.values["Q_x"]), abs(state.values["Q_y"])) < 1e-12
        assert state.stability.family == 1 and state.stability.verdict == "neutral along the family"


def balanced():
    """A pendulum on a force to the point above the pin that grows with the distance: V = (k h - m g) y + const."""
    s = fb.System("balanced")
    m, L, g, h, k = s.parameters(m=1, L=2, g=10, h=1, k=10)
    s.parameters(c=0)
    s.gravity = (0, -g, 0)
    bob = s.body("bob", fb.particle(m))
    s.hinge("O", s.ground, bob, to=(0, L, 0), coordinate="theta")
    s.force("f", bob.origin, ("-k*L*sin(theta)", "k*(h + L*cos(theta))", 0))
    s.generalized_force("theta", "-c*theta'")
    return s


def test_a_balanced_pendulum_rests_anywhere() -> None:
    found = fb.steady_motions(balanced())
    assert found.text() == "0 = sin(theta)  unless h*k - m*g = 0\ntheta = 0\ntheta = pi"
    assert r"\quad\text{unless }" in found.latex() and "unless" in found.html()
    ((condition,),) = found.excluded
    assert sympy.Symbol("h", real=True) in condition.free_symbols and isinstance(condition, sympy.Ne)
    for values in ({}, {"theta": 0.5}):
        (state,) = found.at(values)
        assert state.stability.family == 1 and state.stability.verdict == "neutral along the family"
        (damped,) = found.at({**values, "c": 1})
        assert damped.stability.family == 1 and damped.stability.spectral == "asymptotically stable"
        assert damped.stability.verdict == "neutral along the family"
        (driven,) = found.at({**values, "c": -1})
        assert driven.stability.family == 1 and driven.stability.verdict == "unstable"
    assert [state.stability.family for state in found.at({"k": 9})] == [0, 0]
    assert [state.stability.verdict for state in found.at({"k": 9})] == ["stable", "unstable"]


def test_of_a_balanced_tackle_one_member_is_given_for_each_side() -> None:
    states = fb.steady_motions(tackle()).at({"m": 25})
    assert [np.sign(state.values["rope"]) for state in states] == [-1, 1]
    assert all(state.stability.family == 1 for state in states)


def test_a_double_root_is_no_family() -> None:
    """At F = F_max = 2/3 sqrt(1/3) of V' = z³ - z + F two equilibria meet: the kernel is there, the family is not."""
    s = point("z - z^3 - F")
    found = fb.steady_motions(s, values={"F": 2 / 27**0.5, "m": 1})
    assert len(found.states) >= 2 and all(state.stability.family == 0 for state in found.states)


def test_where_a_leading_coefficient_is_zero_in_numbers_the_other_root_is_left() -> None:
    """A gyroscope whose axis is level: (A - C) cos θ psi'² - C psi' phi' + m g L = 0 has the root m g L/(C phi')."""
    s = fb.System("level")
    m, L, g = s.parameters(m=1, L=0.3, g=9.81)
    s.gravity = (0, 0, -g)
    body = s.body("top", fb.cylinder(m, 1, L).moved((0, 0, L)))
    s.gimbal("pivot", s.ground, body, coordinate="psi theta phi")
    found = fb.steady_motions(s, solve_for="psi'")
    assert [len(one.nonzero) for one in found] == [1, 1, 0, 0]
    (state,) = found.at({"theta": np.pi / 2, "phi'": 20})
    assert state.values["psi'"] == pytest.approx(2 * 0.3 * 9.81 / 20, rel=1e-12)  # C = m/2


# -- conditions of stability and roots, by their definitions --------------------------------------------


@pytest.mark.parametrize("degree", [1, 2, 3, 4])
def test_hurwitz_conditions_are_those_of_the_roots(degree):
    """All conditions are positive exactly where all roots of Σ c_k s^k are left of the imaginary axis."""
    rng = np.random.default_rng(degree)
    ring = Ring()
    symbols = sympy.symbols(f"c:{degree + 1}", real=True)
    conditions = hurwitz(SimpleNamespace(ring=ring), [ring.generator(x) for x in symbols])
    values = sympy.lambdify(symbols, [x.to_sympy() for x in conditions], "math")
    seen = set()
    for _ in range(300):
        # half of them around roots that are left of it, so that both verdicts occur at every degree
        c = (
            np.poly(rng.normal(-0.4, 0.7, degree))[::-1]
            if rng.random() < 0.5
            else rng.normal(0.3, 1, degree + 1)
        )
        at = c * rng.choice([-1, 1])
        left = bool((np.roots(c[::-1]).real < 0).all())
        assert (min(values(*at)) > 0) == left
        seen.add(left)
    assert seen == {True, False}


@pytest.mark.parametrize("degree", [2, 4])
def test_conditions_of_conservative_systems_are_those_of_the_roots(degree):
    """Even powers alone: positive exactly where all squares of the roots are real and negative."""
    rng = np.random.default_rng(degree)
    ring = Ring()
    symbols = sympy.symbols(f"d:{degree // 2 + 1}", real=True)
    c = [0] * (degree + 1)
    c[::2] = [ring.generator(x) for x in symbols]
    conditions = hurwitz(SimpleNamespace(ring=ring), c)
    values = sympy.lambdify(symbols, [x.to_sympy() for x in conditions], "math")
    seen = set()
    for _ in range(300):
        d = (
            np.poly(rng.normal(-0.4, 0.7, degree // 2))[::-1]
            if rng.random() < 0.5
            else rng.normal(1, 1.5, degree // 2 + 1)
        )
        squares = np.roots(d[::-1])
        bound = bool((np.isreal(squares) & (squares.real < 0)).all())
        assert (min(values(*d)) > 0) == bound
        seen.add(bound)
    assert seen == {True, False}
    assert hurwitz(SimpleNamespace(ring=ring), [ring.one] * 6) is None  # beyond degree 4


@pytest.mark.parametrize("seed", range(4))
def test_roots_of_even_quartics(seed):
    """a w⁴ + b w² + c = 0: four roots, real exactly where what is said of their existence holds."""
    rng = np.random.default_rng(seed)
    ring = Ring()
    a, b, c, w = sympy.symbols("a b c w", real=True)
    found = roots_of(ring, ring.from_sympy(a * w**4 + b * w**2 + c), w)
    assert len(found) == 4
    roots = [
        [sympy.lambdify((a, b, c), x.to_sympy(), "math") for x in (root.value, *root.exists)]
        for root in found
    ]
    counts = set()
    for place in rng.normal(0, 1, (100, 3)):
        expected = np.roots([place[0], 0, place[1], 0, place[2]])
        real = np.sort(expected[np.abs(expected.imag) < 1e-9].real)
        reached = [value(*place) for value, *exists in roots if all(x(*place) > 0 for x in exists)]
        assert np.sort(reached) == pytest.approx(real, rel=1e-9)
        counts.add(len(real))
    assert counts == {0, 2, 4}


def test_biquadratic_steady_motion():
    """A bead on a turning arm, pulled inward by a constant force and driven outward by the wind, at rest at x = 0 where

    m b W² - k b + c W⁴ = 0: W² = (-m b + √(m² b² + 4 c k b))/(2 c).
    """
    s = fb.System("arm")
    m, k, b, c = s.parameters(m=2, k=30, b=0.5, c=0.1)
    s.assume(k > 0)
    s.assume(b > 0)
    s.assume(c > 0)
    arm, bead = s.body("arm", fb.particle(0)), s.body("bead", fb.particle(m))
    s.hinge("shaft", s.ground, arm, axis="z", coordinate="psi")
    s.slider("along", arm, bead, at=(b, 0, 0), axis="x", coordinate="x")
    s.generalized_force("x", "-k*b + c*psi'^4")
    at = {m: 2, k: 30, b: 0.5, c: 0.1, s.expression("x"): 0}
    found = [motion.solution["psi'"].subs(at) for motion in fb.steady_motions(s, solve_for="psi'")]
    assert len(found) == 4
    square = (-2 * 0.5 + math.sqrt((2 * 0.5) ** 2 + 4 * 0.1 * 30 * 0.5)) / 0.2
    rates = sorted(float(x) for x in found if x.is_real)
    assert rates == pytest.approx([-math.sqrt(square), math.sqrt(square)], rel=1e-12)


def test_a_state_in_which_a_law_has_no_value_is_no_steady_motion() -> None:
    # dry friction in a plane has no direction at rest, next to which the slopes of the equations are immense
    s = fb.System("puck")
    m, F, C = s.parameters(m=1, F=1, C=2)
    puck = s.body("puck", fb.particle(m))
    s.chain("ice", s.ground, puck, [fb.Slider("x", coordinate="x"), fb.Slider("y", coordinate="y")])
    s.generalized_force("x", "F - C*x'/sqrt(x'^2 + y'^2)")
    s.generalized_force("y", "-F/5 - C*y'/sqrt(x'^2 + y'^2)")
    motions = fb.steady_motions(fb.equations(s))
    atoms, unknowns, _ = motions._in_numbers._numbers({"m": 1, "F": 1, "C": 2})
    places = {str(atom): k for k, atom in enumerate(unknowns)}
    state = np.zeros(len(unknowns))
    state[[places["Derivative(x(t), t)"], places["Derivative(y(t), t)"]]] = 1e-20, -2e-21
    assert not motions._in_numbers._balanced(atoms, unknowns, state)
    assert motions.at({"m": 1, "F": 1, "C": 2}) == ()
