"""Every equation of the chapter: none is left out, each verdict is derived here, and the referee is not blind."""

from __future__ import annotations

import json
import math
import re

import pytest
import sympy
from click.testing import CliRunner

from freebody.cli import command
from freebody.errors import ModelError
from freebody.gallery.equations import find, statements
from freebody.gallery.equations.statement import Approximation, Line, Statement, is_zero, value

ALL = statements()
LETTERS = {
    "ex-6-1": "abcd",
    "ex-6-2": "abcdefghij",
    "ex-6-3": "abcdefghi",
    "ex-6-4": "abcd",
    "ex-6-5": "abcdefghijklm",
}
PARTS = {"6.34": "ab", "6.38": "ab", "6.41": "ab", "6.59": "ab", "6.67": "ab", "6.85": "ab"}


def test_no_number_is_left_out():
    expected = []
    for k in range(1, 126):
        number = f"6.{k}"
        expected += [number + part for part in PARTS[number]] if number in PARTS else [number]
    expected += [f"{example} ({c})" for example, letters in LETTERS.items() for c in letters]
    assert sorted(ALL) == sorted(expected)
    assert all(s.number == number and s.about and s.call for number, s in ALL.items())


@pytest.mark.parametrize("number", ALL)
def test_verdict_is_proven(number):
    """No statement is left unproven; of a misprint, print and right form differ in numbers too."""
    statement = ALL[number]
    found = statement.finding
    assert found.lines and found.verdict != "unproven"
    if found.verdict in ("holds", "definition"):
        assert all(is_zero(line.residual) for line in found.lines)
    if found.verdict == "misprint":
        for i in found.wrong:
            assert abs(_at_random(found.lines[i].residual)) > 1e-6
    assert f"verdict: {statement.verdict}" in statement.text()
    assert "\\begin{aligned}" in statement.latex()


def _at_random(expression):
    """A value at numbers that are not special: each atom gets its own, functions of time included."""
    expression = sympy.sympify(expression)
    atoms = sorted(expression.atoms(sympy.Derivative, sympy.core.function.AppliedUndef), key=str)
    expression = expression.xreplace({a: sympy.Rational(31 + 7 * k, 53 + 3 * k) for k, a in enumerate(atoms)})
    symbols = sorted(expression.free_symbols, key=str)
    return float(
        expression.subs([(x, sympy.Rational(13 + 11 * k, 29 + 2 * k)) for k, x in enumerate(symbols)])
    )


def test_approximations_say_how_good_they_are():
    rough = [s for s in ALL.values() if s.finding.verdict == "approximation"]
    assert len(rough) >= 8
    for statement in rough:
        assert re.search(r"error of order [12] in \w+, relative \d\.\de[-+]\d+ at", statement.verdict)


def test_the_order_of_an_error_is_measured():
    x = sympy.Symbol("x")
    for power in (1, 2, 3):
        exact = sympy.exp(x)
        series = sum(x**k / sympy.factorial(k) for k in range(power))
        one = Approximation(sympy.Symbol("e"), exact, series, x, sympy.Rational(1, 10), {})
        assert one.order == power
        assert one.relative_error == pytest.approx(
            (math.exp(0.1) - float(series.subs(x, 0.1))) / math.exp(0.1)
        )


def test_the_referee_is_not_blind():
    """A sign, a factor or a subscript that is changed is found out; a wrong claim of the library's two sides too."""
    x, y = sympy.symbols("x y")
    right = (x + y) ** 2
    for wrong in ((x - y) ** 2, 2 * right, (x + x) ** 2):
        verdict = Statement("1", "", "", lambda wrong=wrong: [value(x, wrong, right)]).finding
        assert verdict.verdict == "misprint" and verdict.wrong == (0,)
    same = Statement("1", "", "", lambda: [value(x, x**2 + 2 * x * y + y**2, right)])
    assert same.finding.verdict == "holds"
    under = Statement("1", "", "", lambda: [value(x, x**2, right)], condition=("y = 0", lambda: {y: 0}))
    assert under.finding.verdict == "holds under a condition" and under.verdict == "holds if y = 0"
    broken = Statement("1", "", "", lambda: [Line(sympy.Eq(x, y), x - y, sympy.Eq(x, x, evaluate=False))])
    assert broken.finding.verdict == "unproven"


def test_right_forms_against_independent_closed_forms():
    """Bearing reactions of the tilted disk by numbers, worked out from Euler's equations by hand."""
    m, R, L, g, beta, omega, t = 20.0, 0.2, 0.6, 9.81, math.radians(5), 100.0, 0.012
    # M_x = -(m R²/4) ω² sin β cos β in body axes; M_X = M_x cos θ = (R_BY - R_AY) L/2, R_AY + R_BY = m g
    moment = -m * R**2 / 4 * omega**2 * math.sin(beta) * math.cos(beta) * math.cos(omega * t)
    expected = {"R_AY": m * g / 2 - moment / L, "R_BY": m * g / 2 + moment / L}
    lines = {str(line.derived.lhs): line.derived.rhs for line in ALL["6.66"].finding.lines}
    values = {"m": m, "R": R, "L": L, "g": g, "beta": beta, "omega": omega, "t": t}
    for name, number in expected.items():
        put = {x: values[str(x)] for x in lines[name].free_symbols}
        assert float(lines[name].subs(put)) == pytest.approx(number, rel=1e-12)


def test_command():
    run = lambda *words: CliRunner().invoke(command, ["chapter", *words])  # noqa: E731
    table = run().output
    assert all(f"\n{number:<12}" in "\n" + table for number in ALL)
    assert table.rstrip().endswith("freebody chapter 6.66")
    one = run("6.66").output
    assert "R_BX = " in one and "verdict: misprint in lines 3 and 4 of 4" in one
    data = json.loads(run("6.66", "--json").output)
    assert data["number"] == "6.66" and data["residuals"][0] == "0" != data["residuals"][2]
    assert len(json.loads(run("ex-6-5", "--json").output)) == 13
    assert "\\text{derived}" in run("6.120", "--latex").output


@pytest.mark.slow
def test_all_as_data():
    found = json.loads(CliRunner().invoke(command, ["chapter", "--json"]).output)
    assert [data["number"] for data in found] == list(ALL)
    assert all(len(data["residuals"]) == len(data["printed"]) > 0 for data in found)


def test_numbers_are_found_as_people_write_them():
    assert [s.number for s in find("(6.66)")] == ["6.66"]
    assert [s.number for s in find("6.34")] == ["6.34a", "6.34b"]
    assert [s.number for s in find("ex-6-1d")] == ["ex-6-1 (d)"]
    assert len(find("ex-6-5")) == 13
    with pytest.raises(ModelError, match="Expected the number of an equation of the chapter, 6.1 to 6.125"):
        find("6.126")
