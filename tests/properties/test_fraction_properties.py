"""Fractions of sines and cosines that are equal print alike, however they were written and whatever was read before."""

from __future__ import annotations

import random

import pytest
import sympy
from sympy import cos, cosh, sin, sinh, tan, tanh

from freebody.scalar.half_angles import half_angles
from freebody.scalar.polynomial import Ring
from freebody.scalar.ratio import Ratio
from freebody.symbolic.printing.display import displayed, latex, text
from freebody.symbolic.printing.fractions import ratio_displayed, ratio_latex, ratio_text
from sampled import sampled

A, B = sympy.symbols("a b")
T = sympy.Symbol("t")
X, Y = sympy.Function("x")(T), sympy.Function("y")(T)
PLACES = ({X: 0.7, Y: -1.1, A: 1.3, B: 0.4}, {X: 1.9, Y: 0.3, A: -0.6, B: 2.2})


def _ring() -> Ring:
    ring = Ring()
    for atom, kind in ((A, "parameter"), (B, "parameter"), (X, "coordinate"), (Y, "coordinate")):
        ring.generator(atom, kind)
    return ring


def _sine(rng: random.Random, name: str, x: sympy.Expr, fractions: bool) -> sympy.Expr:
    """sin x, cos x, sinh x or cosh x by an identity."""
    t = (tanh if name.endswith("h") else tan)(x / 2)
    s, c = (sinh, cosh) if name.endswith("h") else (sin, cos)
    sign = -1 if name.endswith("h") else 1
    other = rng.choice([Y, 2 * x])
    if name.startswith("sin"):
        forms = [
            s(x), s(x + other) * c(other) - c(x + other) * s(other), (1 - c(x)) * (1 + c(x)) * sign / s(x),
            c(x) * (tanh if sign < 0 else tan)(x),
        ]  # fmt: skip
        halves = [2 * t / (1 + sign * t**2), 2 * s(x / 2) * c(x / 2), 3 * s(x / 3) - 4 * sign * s(x / 3) ** 3]
    else:
        forms = [
            c(x), c(x + other) * c(other) + sign * s(x + other) * s(other), (1 - sign * s(x) ** 2) / c(x),
            (sign + sign * c(2 * x)) / (2 * sign * c(x)),
        ]  # fmt: skip
        halves = [
            (1 - sign * t**2) / (1 + sign * t**2),
            2 * c(x / 2) ** 2 - 1,
            4 * c(x / 3) ** 3 - 3 * c(x / 3),
        ]
    return rng.choice(forms + halves if fractions else forms)


def _pair(rng: random.Random, angles: list[sympy.Expr], hyperbolic: bool) -> tuple[sympy.Expr, sympy.Expr]:
    """One fraction, straight and in disguise."""
    names = ("sinh", "cosh") if hyperbolic else ("sin", "cos")

    def polynomial(terms: int) -> tuple[sympy.Expr, sympy.Expr]:
        straight, disguised = sympy.Integer(0), sympy.Integer(0)
        for _ in range(terms):
            c = rng.choice([1, 2, -1, A, B, -3])
            name, x = rng.choice(names), rng.choice(angles)
            n = rng.choice([0, 1, 1, 2])
            straight += c * getattr(sympy, name)(x) ** n
            product = sympy.Integer(1)
            for _ in range(n):
                product *= _sine(rng, name, x, len(angles) == 1 and not x.is_Add)
            disguised += c * product
        return straight, disguised

    (n, n2), (d, d2), (e, e2) = polynomial(rng.randint(1, 3)), polynomial(rng.randint(1, 2)), polynomial(2)
    s, c = (getattr(sympy, name)(angles[0]) for name in names)
    if any(abs(float(x.subs(place))) < 1e-6 for x in (d, e, e2, d2, c, s) for place in PLACES):
        return _pair(rng, angles, hyperbolic)
    if half_angles(_ring().from_sympy(n / d)) is None:  # nothing stays below
        return _pair(rng, angles, hyperbolic)
    disguised = rng.choice([n2 / d2, n2 * e2 / (d2 * e), n2 * (1 + s) / (d2 * (1 + s)), (n2 + e * d2) / d2 - e2,
                            n2 * s / (d2 * s), (n2 * c / d2) / c])  # fmt: skip
    return n / d, disguised


def _ratio(ring: Ring, x: sympy.Expr) -> Ratio:
    x = x.replace(tan, lambda y: sin(y) / cos(y)).replace(tanh, lambda y: sinh(y) / cosh(y))
    top, below = sympy.fraction(sympy.together(x))
    return Ratio(ring, ring.from_sympy(top), ring.from_sympy(below)).tidy()


CASES = [
    ([X], False),
    ([X, 2 * X], False),
    ([X / 2, X], False),
    ([X, Y], False),
    ([X - Y], False),
    ([X], True),
]


@pytest.mark.parametrize("seed", sampled(range(10), 3))
@pytest.mark.parametrize(("angles", "hyperbolic"), CASES, ids=["x", "2x", "x/2", "x y", "x - y", "sinh"])
def test_equal_fractions_print_alike(angles, hyperbolic, seed):
    rng = random.Random(f"{angles} {hyperbolic} {seed}")
    straight, disguised = _pair(rng, angles, hyperbolic)
    first, second, both = _ring(), _ring(), _ring()
    one, other = first.from_sympy(straight), second.from_sympy(disguised)
    assert half_angles(one) and half_angles(other)
    assert text(one, first) == text(other, second)
    assert latex(one, first) == latex(other, second)
    assert both.from_sympy(disguised) == both.from_sympy(straight)
    assert text(both.from_sympy(straight), both) == text(one, first)
    assert displayed(one, first) == displayed(other, second)
    p, q = _ratio(first, straight), _ratio(second, disguised)
    assert ratio_text(p, first) == ratio_text(q, second)
    assert ratio_latex(p, first) == ratio_latex(q, second)
    for place in PLACES:  # and they are still what was written
        value = float(straight.subs(place))
        assert float(displayed(one, first).subs(place)) == pytest.approx(value, rel=1e-9, abs=1e-9)
        assert float(ratio_displayed(q, second).subs(place)) == pytest.approx(value, rel=1e-9, abs=1e-9)
