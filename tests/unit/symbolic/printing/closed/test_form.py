"""Closed forms: what is printed equals the element exactly, is counted as it is printed, and looks as in a book."""

from __future__ import annotations

import random
import re

import pytest
import sympy as sp

from freebody.scalar.element import is_zero
from freebody.scalar.polynomial import Ring
from freebody.symbolic.printing.closed.form import LONGEST, closed_form
from freebody.symbolic.printing.closed.operations import operations
from freebody.symbolic.printing.display import latex, text
from freebody.symbolic.printing.grouped import Grouped
from freebody.symbolic.printing.text import Text

operations_of_text = pytest.importorskip(
    "benchmarks.formulas", reason="benchmarks are not in the package"
).operations

m, L, R, h, mu, g = POSITIVE = sp.symbols("m L R h mu g", positive=True)
a, b, c, F = ANY = sp.symbols("a b c F", real=True)
ANGLES = beta, theta_0, theta_1 = sp.symbols("beta theta_0 theta_1", real=True)


def ring_of() -> Ring:
    ring = Ring()
    for x in (*POSITIVE, *ANY, *ANGLES):
        ring.generator(x, "parameter")
    return ring


BOOK = {
    # roots join, without roots in denominators of numbers
    "-sqrt(3*g/L)": -sp.sqrt(3 * g / L),
    "2*sqrt(g/(7*R))": 2 * sp.sqrt(7) * sp.sqrt(g) * sp.sqrt(R) / (7 * R),
    "sqrt(33)*m*g/21": m * g * sp.sqrt(33) / 21,
    "sqrt(2)*m*g/4": m * g / (2 * sp.sqrt(2)),
    "sqrt(2*L*g/(2*L^2 + R^2))": sp.sqrt(2 * L * g / (2 * L**2 + R**2)),
    "m*g/sqrt(L^2 + R^2)": m * g / sp.sqrt(L**2 + R**2),
    # one sign
    "3*m*R*mu*g/(3*R - 2*h)": -3 * R * g * m * mu / (2 * h - 3 * R),
    "m*g*(7*cos(theta_1) - 4*cos(theta_0))/3": -m * g * (4 * sp.cos(theta_0) / 3 - 7 * sp.cos(theta_1) / 3),
    # common factors in front, fractions combined
    "g*(R*cos(beta) - h*sin(beta))/(2*(R^2 + h^2))":
        g * R * sp.cos(beta) / (2 * (R**2 + h**2)) - g * h * sp.sin(beta) / (2 * (R**2 + h**2)),
    "F*(mu*sin(beta) + cos(beta))/m - mu*g": mu * F * sp.sin(beta) / m + F * sp.cos(beta) / m - mu * g,
    "m*(L^2 + R^2/4)": m * (R**2 / 4 + L**2),
    # squares
    "m*g*(1 - 3*sin(beta))^2/4": m * g * (10 - 6 * sp.sin(beta) - 9 * sp.cos(beta) ** 2) / 4,
    "sqrt((m*a - h*b)^2 + c^2)": sp.sqrt(a**2 * m**2 - 2 * a * b * m * h + b**2 * h**2 + c**2),
    # like angles, tangents, absolute values
    "m*R^2*sin(2*beta)/8": m * R**2 * sp.sin(beta) * sp.cos(beta) / 4,
    "m*sin(beta)*cos(beta)": m * sp.sin(beta) * sp.cos(beta),
    "g*(2*mu - 1/tan(beta))": 2 * mu * g - g * sp.cos(beta) / sp.sin(beta),
    "2*abs(a*b)/(7*g)": 2 * sp.Abs(a) * sp.Abs(b) / (7 * g),
    "g/abs(a)": g * sp.Abs(a) / a**2,
    "atan(3*mu)": -sp.atan(-3 * mu),
}  # fmt: skip


@pytest.mark.parametrize("shown", BOOK)
def test_a_book_prints(shown: str) -> None:
    ring = ring_of()
    assert text(ring.from_sympy(BOOK[shown]), ring) == shown


def test_what_is_known_positive_keeps_its_side() -> None:
    """1/(R - h) does not become -1/(h - R), whichever of them the ring has."""
    for x in (-g / (R - h), g / (h - R)):
        ring = ring_of()
        assert text(ring.from_sympy(x), ring) == "g/(h - R)"
        ring = ring_of()
        ring.assume_positive(R - h)
        assert text(ring.from_sympy(x), ring) == "-g/(R - h)"


def test_roots_join_over_a_cosine_known_positive() -> None:
    x = sp.pi / sp.sqrt((a * m - b * sp.cos(beta)) * sp.cos(beta) / h)
    ring = ring_of()
    ring.assume_positive(sp.cos(beta))
    assert text(ring.from_sympy(x), ring) == "pi*sqrt(h/((m*a - b*cos(beta))*cos(beta)))"


def check(x: object, ring: Ring) -> None:
    """The closed form is the element, exactly; its length is that of its text."""
    form = closed_form(x, ring)
    if form is None:
        return
    tree, inside = form
    back = inside.from_sympy(Grouped(inside).sum(tree))
    expected = x if inside is ring else inside.from_sympy(ring.to_sympy(x))
    assert is_zero(back - expected), Text(inside).sum(tree)
    assert operations(tree, inside) == operations_of_text(Text(inside).sum(tree))


@pytest.mark.parametrize("shown", BOOK)
def test_it_is_the_element(shown: str) -> None:
    ring = ring_of()
    check(ring.from_sympy(BOOK[shown]), ring)


def drawn(draw: random.Random, depth: int = 2) -> sp.Expr:
    """A random formula of products, sums, quotients, roots, sines and absolute values."""
    if depth == 0:
        factors = draw.sample(
            [*POSITIVE, *ANY, sp.sin(beta), sp.cos(beta), sp.cos(theta_0)], draw.randint(1, 3)
        )
        exponents = [draw.choice((1, 1, 2)) for _ in factors]
        number = sp.Rational(draw.choice((-3, -1, 1, 2, 6)), draw.choice((1, 2, 3)))
        return number * sp.Mul(*(x**e for x, e in zip(factors, exponents, strict=True)))
    one, other = drawn(draw, depth - 1), drawn(draw, depth - 1)
    kind = draw.choice("++*/ra")
    if kind == "+":
        return one + other
    if kind == "*":
        return one * other
    if kind == "/":
        return one / (other + draw.choice(POSITIVE)) if other != 0 else one
    if kind == "r":
        return one * sp.sqrt(draw.choice(POSITIVE) * draw.choice(POSITIVE) / draw.choice((2, 3, R**2 + L**2)))
    return one * sp.Abs(draw.choice(ANY)) / draw.choice(ANY) ** 2


@pytest.mark.parametrize("seed", range(60))
def test_random_formulas_are_the_element(seed: int) -> None:
    ring = ring_of()
    x = ring.from_sympy(drawn(random.Random(seed)))
    check(x, ring)


def test_unknown_signs_keep_their_roots() -> None:
    """sqrt(a) sqrt(b) is no sqrt(a b) where both may be negative; with one unknown sign the real roots agree."""
    ring = ring_of()
    assert text(ring.from_sympy(sp.sqrt(a) * sp.sqrt(b)), ring).count("sqrt") == 2
    assert text(ring.from_sympy(sp.sqrt(a) * sp.sqrt(g)), ring) == "sqrt(g*a)"


def test_all_prints_have_the_same_form() -> None:
    ring = ring_of()
    x = ring.from_sympy(-sp.sqrt(3 * g / L))
    assert latex(x, ring) == r"-\sqrt{\frac{3 g}{L}}"


def test_long_elements_and_moving_ones_are_arranged_as_equations() -> None:
    ring = ring_of()
    names = [sp.Symbol(f"p{i}", real=True) for i in range(LONGEST + 1)]
    total = ring.from_sympy(sp.Add(*(n * g for n in names)))
    assert closed_form(total, ring) is None and text(total, ring) == Text(ring).show(total)
    q = sp.Function("q")(sp.Symbol("t"))
    moving = ring.from_sympy(m * q.diff() * g + m * g)
    assert text(moving, ring) == Text(ring).show(moving) == "m*g*q' + m*g"
    assert text(moving, ring, closed=True) == "m*g*(q' + 1)"


@pytest.mark.parametrize(("sign", "n"), [(1, 2), (-1, 2), (1, 12), (-1, 12)])
def test_numbers_stay_numbers(sign: int, n: int) -> None:
    ring = ring_of()
    assert text(sp.Integer(sign * n), ring) == str(sign * n)
    assert re.fullmatch(r"-?2\*sqrt\(3\)|-?sqrt\(2\)", text(ring.from_sympy(sign * sp.sqrt(n)), ring))
