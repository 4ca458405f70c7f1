"""Closed-form roots of the equations that remain after elimination: quadratic factors, also in the squared unknown."""

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
"""Most unknowns of a system of equations that SymPy is asked to solve."""
MOST_DEGREE = 4
"""Highest degree of such a system."""


def roots(
    rows: Sequence[Row], ring: Any, parameters: set[str], symbols: Mapping[str, Any]
) -> list[dict[str, Any]]:
    """Return every real solution of the rows for their unknowns, as SymPy expressions by key.

    Parameters
    ----------
    rows : sequence of Row
        At least as many as there are unknowns.
    ring : Ring
    parameters : set of str
        Keys in the rows that are not unknowns.
    symbols : mapping
        SymPy symbol of each key.

    Raises
    ------
    ModelError
        No closed form is known; the message has the degree and the unknowns.
    """
    if not rows:
        return [{}]
    unknowns = sorted({v for row in rows for v in row.unknowns} - parameters)
    if len(unknowns) == 1 and len(rows) == 1:
        return [{unknowns[0]: root} for root in _univariate(rows[0], unknowns[0], ring, symbols)]
    degree = max(sum(n for _, n in monomial) for row in rows for monomial in row.terms)
    if len(unknowns) > MOST_UNKNOWNS or degree > MOST_DEGREE:
        raise _refusal(rows, unknowns, degree)
    system = [_expression(row, symbols) for row in rows]
    try:
        solutions = sympy.solve(system, [symbols[v] for v in unknowns], dict=True)
    except NotImplementedError:
        raise _refusal(rows, unknowns, degree) from None
    result = []
    for solution in solutions:
        values = {v: solution.get(symbols[v]) for v in unknowns}
        if any(value is None for value in values.values()):
            raise _refusal(rows, unknowns, degree)
        if not any(value.is_real is False for value in values.values()):
            result.append(values)
    return result


def _refusal(rows: Sequence[Row], unknowns: Sequence[str], degree: int) -> ModelError:
    titles = ", ".join(f"'{row.name}'" for row in rows)
    return ModelError(
        f"No closed form is known: the remaining equations have degree {degree} in {', '.join(unknowns)} (from "
        f"{titles}). Give one of them a value by where, or solve with numbers."
    )


def _expression(row: Row, symbols: Mapping[str, Any]) -> Any:
    """Left side of a row as a SymPy expression."""
    total = sympy.Integer(0)
    for monomial, c in row.terms.items():
        factor = c.ring.to_sympy(c.num) / c.ring.to_sympy(c.den)
        for v, n in monomial:
            factor *= symbols[v] ** n
        total += factor
    return total


def _univariate(row: Row, v: str, ring: Any, symbols: Mapping[str, Any]) -> list[Any]:
    """Real roots of an equation in one unknown."""
    coefficients: dict[int, Ratio] = {}
    for monomial, c in row.terms.items():
        n = sum(k for _, k in monomial)
        coefficients[n] = c
    low = min(coefficients)
    solutions: list[Any] = [sympy.Integer(0)] if low else []
    coefficients = {n - low: c for n, c in coefficients.items()}
    step = 2 if all(n % 2 == 0 for n in coefficients) else 1
    squares = {n // step: c for n, c in coefficients.items()}
    degree = max(squares)
    if degree == 0:
        return solutions
    if degree <= 2:
        values = _quadratic(squares, ring)
    else:
        values = _by_factors(row, v, ring, symbols)
        step = 1
    for value in values:
        if step == 2:
            root = sympy.sqrt(value)
            solutions += [] if root.is_real is False else [root] if root == 0 else [root, -root]
        else:
            solutions.append(value)
    unique: list[Any] = []
    for value in solutions:
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
    # the sign of the factor outside is arbitrary, since both roots are returned
    half = ratio_displayed((outside / (2 * c2)).tidy(), ring)
    return [middle + sign * half * sympy.sqrt(inside) for sign in (1, -1)]


def _root(square: Ratio, ring: Any) -> tuple[Ratio, Any]:
    """Return (a, b) with √square = ±a √b, where b is a square-free SymPy expression."""
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
    """Return the number and the factors of an element, with sin² in place of (1 - cos)(1 + cos)."""
    x.num = ring.promoted(x.num)
    constant, factors = x.num.factor()
    sign, factors = with_sines(ring, factors)
    return Fraction(sign * int(constant), x.den), [
        (element(ring, ring.promoted(f), 1, ring.support(f)), n) for f, n in factors
    ]


def sympy_fraction(x: sympy.Rational) -> Fraction:
    """Return a SymPy rational as a Fraction."""
    return Fraction(int(x.p), int(x.q))


def _by_factors(row: Row, v: str, ring: Any, symbols: Mapping[str, Any]) -> list[Any]:
    """Roots of a polynomial of degree three or more: roots of its factors, or real algebraic numbers."""
    x = symbols[v]
    expression = sympy.numer(sympy.together(_expression(row, symbols)))
    solutions: list[Any] = []
    for factor, _ in sympy.factor_list(expression, x)[1]:
        polynomial = sympy.Poly(factor, x)
        if not polynomial.free_symbols_in_domain:
            solutions += polynomial.real_roots(multiple=False, radicals=False) and [
                root for root, _ in polynomial.real_roots(multiple=False)
            ]
        elif polynomial.degree() <= 2:
            solutions += sympy.roots(polynomial, multiple=True)
        else:
            raise _refusal([row], [v], polynomial.degree())
    return solutions
