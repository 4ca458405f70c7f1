"""Closed-form roots of the equations that elimination leaves: factors of degree two, and squares of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

import sympy

from ...errors import ModelError
from ...scalar.element import Polynomial, element
from ...scalar.ratio import Ratio
from ...scalar.roots import with_sines
from ..printing.fractions import ratio_displayed
from ..printing.systems import Row

MOST_UNKNOWNS = 3
MOST_DEGREE = 4


def roots(
    rows: Sequence[Row], ring: Any, given: set[str], symbols: Mapping[str, Any]
) -> list[dict[str, Any]]:
    """Every real solution of the rows for their unknowns, as SymPy expressions by key.

    Parameters
    ----------
    rows : sequence of Row
        As many as they have unknowns, or more.
    ring : Ring
    given : set of str
        Keys that are no unknowns.
    symbols : mapping
        SymPy symbol of each key.

    Raises
    ------
    ModelError
        No closed form is known: with the degree and the unknowns.
    """
    if not rows:
        return [{}]
    unknowns = sorted({v for row in rows for v in row.unknowns} - given)
    if len(unknowns) == 1 and len(rows) == 1:
        return [{unknowns[0]: root} for root in _univariate(rows[0], unknowns[0], ring, symbols)]
    degree = max(sum(n for _, n in monomial) for row in rows for monomial in row.terms)
    if len(unknowns) > MOST_UNKNOWNS or degree > MOST_DEGREE:
        raise _refusal(rows, unknowns, degree)
    system = [_expression(row, symbols) for row in rows]
    try:
        found = sympy.solve(system, [symbols[v] for v in unknowns], dict=True)
    except NotImplementedError:
        raise _refusal(rows, unknowns, degree) from None
    result = []
    for solution in found:
        values = {v: solution.get(symbols[v]) for v in unknowns}
        if any(value is None for value in values.values()):
            raise _refusal(rows, unknowns, degree)
        if not any(value.is_real is False for value in values.values()):
            result.append(values)
    return result


def _refusal(rows: Sequence[Row], unknowns: Sequence[str], degree: int) -> ModelError:
    titles = ", ".join(f"'{row.name}'" for row in rows)
    return ModelError(
        f"No closed form is known: what is left is of degree {degree} in {', '.join(unknowns)} (from {titles}). "
        f"Give one of them a value by where, or solve it with numbers."
    )


def _expression(row: Row, symbols: Mapping[str, Any]) -> Any:
    total = sympy.Integer(0)
    for monomial, c in row.terms.items():
        factor = c.ring.to_sympy(c.num) / c.ring.to_sympy(c.den)
        for v, n in monomial:
            factor *= symbols[v] ** n
        total += factor
    return total


def _univariate(row: Row, v: str, ring: Any, symbols: Mapping[str, Any]) -> list[Any]:
    coefficients: dict[int, Ratio] = {}
    for monomial, c in row.terms.items():
        n = sum(k for _, k in monomial)
        coefficients[n] = c
    low = min(coefficients)
    found: list[Any] = [sympy.Integer(0)] if low else []
    coefficients = {n - low: c for n, c in coefficients.items()}
    step = 2 if all(n % 2 == 0 for n in coefficients) else 1
    squares = {n // step: c for n, c in coefficients.items()}
    degree = max(squares)
    if degree == 0:
        return found
    if degree <= 2:
        values = _quadratic(squares, ring)
    else:
        values = _by_factors(row, v, ring, symbols)
        step = 1
    for value in values:
        if step == 2:
            root = sympy.sqrt(value)
            found += [] if root.is_real is False else [root] if root == 0 else [root, -root]
        else:
            found.append(value)
    unique: list[Any] = []
    for value in found:
        if value.is_real is not False and value not in unique:
            unique.append(value)
    return unique


def _quadratic(c: Mapping[int, Ratio], ring: Any) -> list[Any]:
    zero = Ratio(ring, 0)
    c0, c1, c2 = (c.get(k, zero) for k in range(3))
    if not c2:
        return [ratio_displayed((-c0 / c1).tidy(), ring)]
    square = (c1 * c1 - 4 * (c2 * c0)).tidy()
    if not square:
        return [ratio_displayed((-c1 / (2 * c2)).tidy(), ring)]
    outside, inside = _root(square, ring)
    if inside == 1:
        return [ratio_displayed(((-c1 + sign * outside) / (2 * c2)).tidy(), ring) for sign in (1, -1)]
    middle = ratio_displayed((-c1 / (2 * c2)).tidy(), ring)
    # either sign of the part outside serves: both roots are returned
    half = ratio_displayed((outside / (2 * c2)).tidy(), ring)
    return [middle + sign * half * sympy.sqrt(inside) for sign in (1, -1)]


def _root(square: Ratio, ring: Any) -> tuple[Ratio, Any]:
    """(a, b) with √square = ±a √b; b is a SymPy expression without squares."""
    x = square.num * square.den
    number, factors = (x, []) if type(x) is not Polynomial else _factored(ring, x)
    outside = Ratio(ring, 1, square.den)
    inside: Any = 1
    for f, n in factors:
        outside = outside * f ** (n // 2)
        inside = inside * f ** (n % 2)
    exact = sympy.sqrt(sympy.Rational(number.numerator, number.denominator))
    if exact.is_Rational:
        outside = outside * sympy_fraction(exact)
        return outside, ring.to_sympy(inside) if type(inside) is Polynomial else sympy.Integer(inside)
    return outside, sympy.Rational(number.numerator, number.denominator) * (
        ring.to_sympy(inside) if type(inside) is Polynomial else inside
    )


def _factored(ring: Any, x: Polynomial) -> tuple[Any, list[tuple[Any, int]]]:
    """Number and factors of an element, (1 - cos)(1 + cos) as a square of the sine."""
    x.num = ring.promoted(x.num)
    constant, found = x.num.factor()
    sign, left = with_sines(ring, found)
    return Fraction(sign * int(constant), x.den), [
        (element(ring, ring.promoted(f), 1, ring.support(f)), n) for f, n in left
    ]


def sympy_fraction(x: Any) -> Any:
    """A SymPy rational as a Fraction."""
    return Fraction(int(x.p), int(x.q))


def _by_factors(row: Row, v: str, ring: Any, symbols: Mapping[str, Any]) -> list[Any]:
    """Roots of a polynomial of degree three or more: of its factors, or real algebraic numbers."""
    x = symbols[v]
    expression = sympy.numer(sympy.together(_expression(row, symbols)))
    found: list[Any] = []
    for factor, _ in sympy.factor_list(expression, x)[1]:
        polynomial = sympy.Poly(factor, x)
        if not polynomial.free_symbols_in_domain:
            found += polynomial.real_roots(multiple=False, radicals=False) and [
                root for root, _ in polynomial.real_roots(multiple=False)
            ]
        elif polynomial.degree() <= 2:
            found += sympy.roots(polynomial, multiple=True)
        else:
            raise _refusal([row], [v], polynomial.degree())
    return found
