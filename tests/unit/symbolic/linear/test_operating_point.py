"""Floats in `about=` meet a condition but for their rounding."""

from __future__ import annotations

import math

import pytest
import sympy

import freebody as fb
from freebody.errors import ModelError


def pendulum():
    s = fb.System("pendulum")
    m, L, g = s.parameters(m=1.0, L=2.0, g=9.81)
    s.gravity = (0, -g, 0)
    bar = s.body("bar", fb.slender_bar(m, L, axis="y"))
    s.hinge("pin", s.ground, bar, to=(0, L / 2, 0), coordinate="theta")
    return s


def bead():
    """A particle on a circle, x² + y² = a²."""
    s = fb.System("bead")
    m, g, a = s.parameters(m=1.0, g=9.81, a=1.0)
    s.gravity = (0, -g, 0)
    cart = s.body("cart", fb.particle(m))
    s.slider("x", s.ground, cart, axis="x", coordinate="x")
    s.slider("y", cart, s.body("bead", fb.particle(m)), axis="y", coordinate="y")
    s.constrain("x^2 + y^2 - a^2")
    return s


@pytest.mark.parametrize("theta", [math.pi, math.pi + 3e-15, math.pi * (1 - 1e-15)])
def test_an_angle_that_is_pi_but_for_rounding(theta):
    stiffness = fb.linearize(pendulum(), about={"theta": theta}).K[0]
    values = {sympy.Symbol(name): x for name, x in {"m": 1, "L": 2, "g": 9.81}.items()}
    named = {symbol: values[sympy.Symbol(symbol.name)] for symbol in stiffness.free_symbols}
    assert float(stiffness.subs(named)) == pytest.approx(-9.81, rel=1e-14)


@pytest.mark.parametrize("theta", [3.14159, 0.3, math.pi + 1e-6])
def test_an_angle_that_is_not_is_refused(theta):
    with pytest.raises(ModelError, match="is not an equilibrium"):
        fb.linearize(pendulum(), about={"theta": theta})


def test_texts_are_exact():
    with pytest.raises(ModelError, match="is not an equilibrium"):
        fb.linearize(pendulum(), about={"theta": "3.141592653589793"})


@pytest.mark.parametrize("about", [{"x": 3e-15, "y": -1.0}, {"x": 0.0, "y": -1 - 3e-15}])
def test_a_position_on_a_circle_but_for_rounding(about):
    stiffness = fb.linearize(bead(), about=about, independent=["x"]).numeric({}).K
    assert stiffness.item() == pytest.approx(9.81, rel=1e-12)


def test_a_position_off_the_circle_is_refused():
    with pytest.raises(ModelError, match="does not satisfy the constraints of 'bead'"):
        fb.linearize(bead(), about={"x": 0.0, "y": -1.1}, independent=["x"])
