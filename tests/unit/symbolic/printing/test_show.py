"""Every result shows itself: text, LaTeX, HTML, in a notebook and at the prompt."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
import re
from collections.abc import Callable
from typing import Any
from xml.etree import ElementTree

import pytest
import sympy

import freebody as fb
from freebody.symbolic.printing.show import latex_of, text_of
from freebody.typesetting.latex import rows


def pendulum() -> fb.System:
    s = fb.System("bar_on_a_pin")
    m, L, g, F = s.parameters(m=1, L=1, g=9.81, F=0)
    s.gravity = (0, -g, 0)
    bar = s.body("bar", fb.slender_bar(m, L, axis="y"))
    s.hinge("pin", s.ground, bar, to=(0, L / 2, 0), axis="z", coordinate="theta_1")
    s.force("push", bar.origin, (F, 0, 0))
    return s


def hoop() -> fb.System:
    """A bead on a spherical pendulum whose length is called R, as the Routhian is."""
    s = fb.System("hoop")
    R, g = s.parameters(R=1, g=9.81)
    s.gravity = (0, 0, -g)
    bob = s.body("bob", fb.particle(1))
    s.universal("arm", s.ground, bob, to=(0, 0, R), axis=("z", "x"), coordinate="psi_1 theta")
    return s


def struck(**options: Any) -> Any:
    s = pendulum()
    tip = s.bodies["bar"].point(0, "-L/2", 0)
    return fb.impulse(s, at=tip, impulse=(1, 0, 0), **options)


def hanging() -> Any:
    return struck(initial={"theta_1": 0})


RESULTS: dict[str, tuple[Callable[[], Any], str, str, str]] = {
    # what makes it, and what stands in its text, its LaTeX and its label
    "equations": (lambda: fb.equations(pendulum()), "m*L^2*theta_1''/3", r"\ddot{\theta}_{1}", "θ"),
    "free body": (lambda: fb.equations(pendulum()).free_body("bar"), "pin_x", r"\mathrm{pin}_{x}", "pin"),
    "moment form": (
        lambda: fb.equations(pendulum()).free_body("bar").moment_form("pin"),
        "M_A",
        r"\mathbf{M}_A",
        "θ",
    ),
    "reaction": (lambda: fb.equations(pendulum()).reactions["pin"], "pin_x = ", r"\mathbf{F} &=", "F"),
    "energy": (lambda: fb.equations(pendulum()).energy, "T = m*L^2*theta_1'^2/6", r"T &= \frac{1}{6}", "T"),
    "integrals": (
        lambda: fb.equations(hoop()).integrals,
        "momentum of psi_1: ",
        r"\text{momentum of psi\_1:}",
        "momentum of psi_1: ",
    ),
    "integral": (
        lambda: fb.equations(hoop()).integrals[1],
        "R^2*psi_1'*sin(theta)^2 = const",
        r"\text{const}",
        "const",
    ),
    "no integrals": (
        lambda: fb.equations(driven()).integrals,
        "No conserved quantities.",
        r"\text{No conserved",
        "No conserved quantities.",
    ),
    "proof": (
        lambda: fb.equations(hoop()).integrals[0].proof,
        "d(energy)/dt = psi_1'*(equation of psi_1')",
        r"\frac{d}{dt}",
        "energy",
    ),
    "Routh": (
        lambda: fb.equations(hoop()).routh(),
        "Routhian = R^2*theta'^2/2 + ",
        r"\mathrm{Routhian} &=",
        "Routhian",
    ),
    "steady motions": (
        lambda: fb.steady_motions(hoop()),
        "0 = R*psi_1'^2*cos(theta) - g or sin(theta)",
        r"\ \text{or}\ ",
        "or",
    ),
    "steady motion": (
        lambda: fb.steady_motions(hoop())[0],
        "  if R*g*cos(theta) >= 0",
        r"\quad\text{if }",
        "≥",
    ),
    "state": (
        lambda: fb.steady_motions(pendulum(), values={}).states[0],
        "theta_1 = 0; stable",
        r"\theta_{1} = 0",
        "0",
    ),
    "linear model": (
        lambda: fb.linearize(pendulum(), inputs="F"),
        "m*L*g*theta_1/2 = L*F/2",
        r"\theta_{1}",
        "θ",
    ),
    "numbers": (lambda: fb.linearize(pendulum(), values={}), "4.905*theta_1 = 0", "4.905", "4.905"),
    "modes": (
        lambda: fb.linearize(pendulum(), inputs="F").modes(),
        "oscillation  sqrt(3*g/(2*L))",
        r"\sqrt{\frac{3 g}{2 L}}",
        "damping ratio",
    ),
    "modes in numbers": (
        lambda: fb.linearize(pendulum(), values={}).modes(),
        "3.83601",
        "3.83601",
        "3.83601",
    ),
    "characteristic": (
        lambda: fb.linearize(pendulum(), inputs="F").characteristic,
        "L^2*m*s^2/3",
        r"\frac{L^{2} m s^{2}}{3}",
        "s",
    ),
    "state space": (
        lambda: fb.linearize(pendulum(), inputs="F").state_space(),
        "inputs F",
        r"\dot{x} &= A x + B f",
        "A",
    ),
    "state space in numbers": (
        lambda: fb.linearize(pendulum(), values={}).state_space(),
        "-14.715",
        "-14.715",
        "−14.715",
    ),
    "response": (
        lambda: fb.linearize(pendulum(), inputs="F").response({"theta_1": "1/10"}),
        "theta_1(t) = cos(",
        r"\cos",
        "cos",
    ),
    "response in numbers": (
        lambda: fb.linearize(pendulum(), values={}).response({"theta_1": 2}),
        "theta_1(t) = 2*cos(3.83601*t)",
        r"2 \cos",
        "3.83601",
    ),
    "solution": (lambda: fb.equations(pendulum()).solve("pin_x"), "pin_x = ", r"\mathrm{pin}_{x} &=", "pin"),
    "solutions": (
        lambda: fb.equations(pendulum()).solve("theta_1'", {"pin_y": 0, "theta_1": 0}),
        "theta_1' = ",
        r"\sqrt",
        "θ",
    ),
    "elimination": (
        lambda: fb.equations(pendulum()).eliminate("pin"),
        "[bar: force x]",
        r"\text{bar: force x}",
        "bar: force x",
    ),
    "impulse": (
        hanging,
        "theta_1' = theta_1' + 3/(m*L)",
        r"\hat{\mathrm{pin}_{x}} &= \frac{1}{2}",
        "pin",
    ),
    "impulse in numbers": (
        lambda: struck(values={}),
        "theta_1' = 3",
        r"\text{pin: impulse }",
        "pin: impulse ",
    ),
    "stability": (
        lambda: fb.steady_motions(pendulum(), values={}).states[0].stability,
        "stable (spectral: stable; energy: stable)\neigenvalues: ",
        r"\text{eigenvalues: }",
        "eigenvalues: ",
    ),
    "mode": (
        lambda: fb.linearize(pendulum(), inputs="F").modes()[0],
        "oscillation: frequency sqrt(3*g/(2*L)), damping ratio 0; theta_1 = 1",
        r"\theta_{1} = 1",
        "θ",
    ),
    "mode in numbers": (
        lambda: fb.linearize(pendulum(), values={}).modes()[0],
        "3.83601",
        "3.83601",
        "3.83601",
    ),
    "branch": (lambda: along_the_rate()[0], "Steady motions over psi_1'", r"\dot{\psi}_{1} =", "ψ"),
    "bifurcation": (
        lambda: next(one for branch in along_the_rate() for one in branch.bifurcations),
        "bifurcation at 3.1320",
        r"\text{bifurcation at }",
        "bifurcation at ",
    ),
    "reactions": (
        lambda: fb.equations(pendulum()).reactions,
        "Reaction of 'pin' on 'bar'",
        r"\mathbf{F} &=",
        "F",
    ),
    "momentum": (
        lambda: fb.equations(pendulum()).momentum,
        "angular about the ground's origin = (0, 0, L^2*m*theta_1'/3)",
        r"\text{linear} = \begin{bmatrix}",
        "linear",
    ),
    "recovery": (
        lambda: fb.equations(hoop()).routh().recovery["psi_1"],
        "psi_1' = p_psi_1/(R^2*sin(theta)^2)",
        r"\dot{\psi}_{1} =",
        "ψ",
    ),
    "comparison": (
        lambda: fb.compare_linear(pendulum(), initial={"theta_1": 0.1}, until=1, samples=11),
        "theta_1: largest deviation 0.1",
        r"\theta_{1} \text{: largest deviation 0.1",
        "θ",
    ),
    "impulsive reaction": (
        lambda: hanging().reactions["pin"],
        "pin_x = 1/2",
        r"\hat{\mathrm{pin}_{x}}",
        "pin",
    ),
}


INTERNAL = {
    # what results are made of: canonical polynomials, tables of a printer, requests that are read
    "abbreviations.Elimination",
    "arrange.Arrangement", "arrange.Lumps", "form.ClosedForms", "letters.Letters", "operations.Length",
    "operations.Operations", "products.Bracket", "products.Product", "products.Products",
    "balance.BodyBalance", "canonical_model.CanonicalModel", "bearings.Shaft",
    "bodies.NamedBody", "bodies.PointOf",
    "characteristic.Factor", "constrained_symbols.Motion",
    "derivation.Derivation", "eliminate.Combination",
    "combinations.Columns", "random_place.NoRootError", "random_place.Place", "random_place.Placed",
    "length_bound.Lengths", "length_bound.Terms",
    "named_quantities.NamedDerivation", "recursive.Definition", "recursive.NamedMotion",
    "recursive.Names", "recursive.Recursive", "states.SteadyStates",
    "checks.Checks", "recorded_functions.Points", "recorded_functions.Recorded", "recursive.Turn",
    "forcing.Term", "action.Action", "grouped.Grouped", "latex.Latex", "lines.Name", "lines.Sign", "typeset.Typeset",
    "operating_point.OperatingPoint", "planar.Plane", "printer.Printer", "rational.Rationals", "reaction.Component",
    "reduction.Choice", "reduction.Slopes", "request.Request", "request.Unknown", "response.Start", "solution.Branch",
    "stability.Amended", "stability.Linear", "stability.ProblemStability", "stability.Spectrum", "motion.Words",
    "conditions.Conditions",
    "numeric.NumericRoot", "numeric.Underdetermined", "problem.Problem", "solve.Solution",
    "solve.Root", "turning.Turning", "turning.TurningProblem", "turning.TurningStability",
    "systems.Pivot", "systems.Row",
    "terms.Applied", "terms.Sum", "terms.Term", "text.Text", "vocabulary.Vocabulary",
}  # fmt: skip
DISPLAY = ("text", "latex", "html", "_repr_latex_", "_repr_html_")


def classes() -> dict[str, type]:
    """All classes of the symbolic side, by module and name."""
    package = importlib.import_module("freebody.symbolic")
    found = {}
    for module in [*pkgutil.walk_packages(package.__path__, "freebody.symbolic."), None]:
        name = module.name if module else "freebody.picture.plots.compare_linear"
        for key, one in vars(importlib.import_module(name)).items():
            if inspect.isclass(one) and one.__module__ == name and not key.startswith("_"):
                found[f"{name.rpartition('.')[2]}.{key}"] = one
    return found


def test_every_result_class_shows_itself() -> None:
    found = classes()
    assert set(found) >= INTERNAL
    for name in sorted(set(found) - INTERNAL):
        assert [x for x in DISPLAY if not hasattr(found[name], x)] == [], name


def along_the_rate() -> Any:
    return fb.steady_motions(hoop(), solve_for="theta", values={"psi_1'": 6}).continuation("psi_1'", (1, 6))


def driven() -> fb.System:
    s = fb.System("shaken")
    block = s.body("block", fb.particle(1))
    guide = s.slider("guide", s.ground, block, axis="x", coordinate="x")
    s.damper("damper", guide, damping=1)
    s.force("push", block.origin, ("sin(t)*x^2", 0, 0))
    return s


@pytest.fixture(scope="module", params=RESULTS)
def shown(request: pytest.FixtureRequest) -> tuple[str, Any]:
    return request.param, RESULTS[request.param][0]()


def test_text(shown: tuple[str, Any]) -> None:
    name, result = shown
    text = result.text()
    assert RESULTS[name][1] in text, text
    assert (
        "\\" not in text
        and "<" not in text
        and "Derivative" not in text
        and "(t)" not in text.replace("(t) =", "")
    )


def test_latex(shown: tuple[str, Any]) -> None:
    name, result = shown
    latex = result.latex()
    assert RESULTS[name][2] in latex, latex
    assert latex.count("{") == latex.count("}")
    assert latex.count(r"\left") == latex.count(r"\right")
    assert sorted(re.findall(r"\\begin{(\w+)}", latex)) == sorted(re.findall(r"\\end{(\w+)}", latex))
    for words in re.findall(r"\\text{((?:[^{}]|\\[{}])*)}", latex):
        assert "_" not in words.replace(r"\_", ""), latex


def test_html(shown: tuple[str, Any]) -> None:
    """Well-formed, with all glyphs that it uses; it says what it shows, and holds its LaTeX."""
    name, result = shown
    tree = ElementTree.fromstring(result.html())
    formulas = [part for part in tree.iter("span") if part.get("class") == "formula"]
    assert [part.get("data-tex") for part in formulas] == rows(result.latex())
    said = " ".join(part.get("aria-label", "") for part in formulas)
    assert RESULTS[name][3].strip() in said, said
    ids = {part.get("id") for part in tree.iter() if part.get("id")}
    assert {part.get("href", "")[1:] for part in tree.iter("use")} <= ids


def test_notebook(shown: tuple[str, Any]) -> None:
    _, result = shown
    assert result._repr_latex_() == f"$\\displaystyle {result.latex()}$"
    assert result._repr_html_() == result.html()


def test_prompt(shown: tuple[str, Any]) -> None:
    _, result = shown
    assert " object at 0x" not in repr(result) and len(repr(result)) > 3


def test_a_trajectory_has_no_one_formula() -> None:
    """Along a trajectory the linear equations are arrays: a notebook falls back on the name."""
    s = pendulum()
    linear = fb.linearize(s, fb.simulate(s, until=0.5, initial={"theta_1": 1}))
    assert linear._repr_latex_() is None and linear._repr_html_() is None
    assert re.fullmatch(r"Linear equations of 'bar_on_a_pin' along a trajectory, at \d+ times", repr(linear))


def test_a_response_without_modes_says_its_names() -> None:
    s = fb.System("puck")
    puck = s.body("puck", fb.particle(1))
    s.slider("ice", s.ground, puck, axis="x", coordinate="x")
    response = fb.linearize(s, values={}).response({"x'": 2})
    assert response.text() == "Response of x, x': call it with times"
    assert (
        response.latex() == "\\begin{aligned}\n&\\text{Response of x, x': call it with times}\n\\end{aligned}"
    )
    assert "call it with times" in response.html()
    assert response(3.0)["x"] == pytest.approx(6)


def test_damped_response_as_text() -> None:
    """x'' + 2 x' + 5 x = 0 from x = 1: e^(-t) (cos 2t + sin 2t / 2)."""
    s = fb.System("oscillator")
    block = s.body("block", fb.particle(1))
    guide = s.slider("guide", s.ground, block, axis="x", coordinate="x")
    s.spring("spring", guide, stiffness=5)
    s.damper("damper", guide, damping=2)
    text = fb.linearize(s, values={}).response({"x": 1}).text()
    t = sympy.Symbol("t")
    expected = sympy.exp(-t) * (sympy.cos(2 * t) + sympy.sin(2 * t) / 2)
    found = sympy.sympify(text.removeprefix("x(t) = "), {"t": t})
    assert sympy.simplify(sympy.nsimplify(found) - expected) == 0


def test_sympy_in_the_names_of_a_model() -> None:
    t = sympy.Symbol("t")
    theta, k = sympy.Function("theta_1")(t), sympy.Symbol("k_a", real=True)
    x = k * theta.diff(t, 2) ** 2 / 2 + sympy.sqrt(k)
    assert text_of(x) == "sqrt(k_a) + k_a*theta_1''^2/2"
    assert latex_of(x) == r"\sqrt{k_{a}} + \frac{k_{a} \ddot{\theta}_{1}^{2}}{2}"
