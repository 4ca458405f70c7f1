"""Names for groups of parameters: the equations are the same, shorter, and as a book prints them."""

from __future__ import annotations

import pytest
import sympy

import freebody as fb
from freebody.errors import ModelError
from freebody.gallery import entries
from freebody.scalar.element import is_zero
from freebody.symbolic.printing.closed.abbreviations import abbreviated, groups
from freebody.symbolic.printing.closed.form import closed_form
from freebody.symbolic.printing.closed.operations import operations

MOMENTS = {"I_xi": "m*(R**2/4 + L**2)", "I_zeta": "m*R**2/2"}


@pytest.fixture(scope="module")
def top():
    return fb.equations(entries()["sec-6-9"].build())


def test_the_equations_of_the_top_are_those_of_the_book(top):
    assert top.text(names=MOMENTS).splitlines()[1:] == [
        "I_xi*theta'' - (I_xi - I_zeta)*psi'^2*sin(theta)*cos(theta) + I_zeta*psi'*phi'*sin(theta) "
        "- m*L*g*sin(theta) = 0",
        "I_zeta*(psi''*cos(theta) + phi'' - psi'*theta'*sin(theta)) = 0",
        "where",
        "  I_xi = m*(R^2/4 + L^2)",
        "  I_zeta = m*R^2/2",
    ]
    assert r"I_{\xi} &= m \left(\frac{1}{4} R^{2} + L^{2}\right)" in top.latex(names=MOMENTS)
    assert "I_xi" not in top.text()
    assert 'data-tex="I_{' in top.html(names=MOMENTS)


@pytest.mark.parametrize(
    ("name", "names"),
    [
        ("sec-6-9", MOMENTS),
        ("prob-6-15", {"J_1": "(m1/3 + m2)*L1**2", "c": "m2*L1*L2/2"}),
        ("ex-6-5", {"m_0": "M + m"}),
    ],
)
def test_named_equations_are_the_equations(name, names):
    """With the groups in place of their names, every side is the same element of the ring."""
    e = fb.equations(entries()[name].build())
    shown, used = abbreviated(e.balances, groups(e, names), e.ring)
    assert used
    written = {symbol: e.ring.to_sympy(used[symbol.name]) for symbol in _symbols(e, used)}
    for pair, before in zip(shown, e.balances, strict=True):
        for x, y in zip(pair, before, strict=True):
            assert e.ring.from_sympy(sympy.sympify(_sympy(e, x)).xreplace(written)) == y


def _sympy(e, x):
    return x if isinstance(x, int) else e.ring.to_sympy(x)


def _symbols(e, used):
    return [g.atom for g in e.ring.generators if g.atom is not None and str(g.atom) in used]


def test_a_name_that_makes_nothing_shorter_is_not_used(top):
    assert top.text(names={"V": "g*L**3"}) == top.text()


@pytest.mark.parametrize("key", ["psi'_fast", "Omega_min", "Omega_sleeping"])
def test_named_answers_are_the_answers(top, key):
    """Parameters that divide are eliminated, too, and the named answer is the one in the parameters."""
    m, R, L, g, theta, spin = (
        top.model.names.atoms[name] for name in ("m", "R", "L", "g", "theta_0", "Omega_zeta")
    )
    I_xi, I_zeta = sympy.symbols("I_xi I_zeta", positive=True)
    book = {
        "psi'_fast": (I_zeta * spin + sympy.sqrt((I_zeta * spin) ** 2 - 4 * I_xi * m * g * L * sympy.cos(theta)))
        / (2 * I_xi * sympy.cos(theta)),
        "Omega_min": 2 * sympy.sqrt(I_xi * m * g * L * sympy.cos(theta)) / I_zeta,
        "Omega_sleeping": 2 * sympy.sqrt(I_xi * m * g * L) / I_zeta,
    }[key]  # fmt: skip
    meant = {I_xi: m * (R**2 / 4 + L**2), I_zeta: m * R**2 / 2}
    x = top.ring.from_sympy(book.xreplace(meant))
    (((shown, _),), used) = abbreviated([(x, 0)], groups(top, MOMENTS), top.ring, closed=True)
    assert set(used) == {"I_xi", "I_zeta"}
    assert is_zero(shown - top.ring.from_sympy(book))
    assert is_zero(top.ring.from_sympy(top.ring.to_sympy(shown).xreplace(meant)) - x)
    assert operations(*closed_form(shown, top.ring)) < operations(*closed_form(x, top.ring))


def test_names_that_cannot_be_used_are_refused(top):
    with pytest.raises(
        ModelError, match="Expected a new name for a group of parameters, got 'theta', which is a coord"
    ):
        top.text(names={"theta": "m*R**2"})
    with pytest.raises(
        ModelError, match="Expected at most 4 names for groups of parameters, got 5: a, b, c, d, e"
    ):
        top.text(names=dict.fromkeys("abcde", "m*R**2"))
    with pytest.raises(
        ModelError, match="Expected a sum or product of parameters with a power of .* 'c', got sin"
    ):
        top.text(names={"c": "sin(m)"})
    with pytest.raises(
        ModelError, match="Expected no names= for equations solved for the accelerations, got I_xi"
    ):
        top.text(names={"I_xi": MOMENTS["I_xi"]}, solved=True)
    recursive = fb.equations(entries()["sec-6-9"].build(), form="recursive")
    with pytest.raises(ModelError, match="Expected no names= for equations in recursive form, got I_xi"):
        recursive.latex(names={"I_xi": MOMENTS["I_xi"]})
