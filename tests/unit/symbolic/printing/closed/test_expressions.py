"""Frequencies and responses in print: what is printed is short, and equals the expressions."""

from __future__ import annotations

import pickle

import sympy

import freebody as fb
from freebody.symbolic.printing.closed.expressions import Expressions


def pendulum(damped: bool = False) -> fb.System:
    s = fb.System("pendulum")
    m, L, g, c = s.parameters(m=1, L=2, g=9.81, c=1)
    s.gravity = (0, -g, 0)
    bar = s.body("bar", fb.slender_bar(m, L, axis="y"))
    pin = s.hinge("pin", s.ground, bar, to=(0, L / 2, 0), axis="z", coordinate="theta")
    if damped:
        s.damper("c", pin, damping=c)
    return s


def test_a_list_of_frequencies_is_a_list_that_prints_as_a_book_does() -> None:
    frequencies = fb.linearize(pendulum()).natural_frequencies()
    assert isinstance(frequencies, list) and isinstance(frequencies, Expressions)
    assert str(frequencies) == repr(frequencies) == "[sqrt(3*g/(2*L))]"
    assert frequencies.latex() == r"\sqrt{\frac{3 g}{2 L}}"
    (w,) = frequencies
    assert sympy.simplify(w**2 - sympy.sympify("3*g/(2*L)", {x.name: x for x in w.free_symbols})) == 0
    assert pickle.loads(pickle.dumps(frequencies)) == frequencies


def test_a_response_has_its_frequencies_in_closed_form() -> None:
    response = fb.linearize(pendulum()).response({"theta": "1/10"})
    assert response.text() == "theta(t) = cos(sqrt(3*g/(2*L))*t)/10"
    assert (
        r"\theta(t) &= " in response.latex()
        and r"\cos\left(\sqrt{\frac{3 g}{2 L}} t\right)" in response.latex()
    )


def test_a_damped_response_as_printed_is_the_response() -> None:
    response = fb.linearize(pendulum(damped=True)).response({"theta": "1/10"})
    printed = response.text().removeprefix("theta(t) = ").replace("^", "**")
    names = {x.name: x for x in response["theta"].free_symbols}
    at = {"m": 1.1, "L": 2.3, "g": 9.7, "c": 1.3, "t": 0.7}
    values = {names[name]: sympy.Rational(str(value)) for name, value in at.items()}
    difference = (sympy.sympify(printed, names) - response["theta"]).xreplace(values)
    assert abs(sympy.N(difference, 30)) < 1e-25
    assert "exp(-3*c*t/(2*m*L^2))" in printed.replace("**", "^")


def test_complex_roots_print_as_sympy_does() -> None:
    assert str(Expressions([sympy.I])) == "[I]"
