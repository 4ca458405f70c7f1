"""Linear equations in numbers as text and LaTeX: six digits, terms in the order ξ'', ξ', ξ."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from ..printing.latex import latex_name, latex_number
from ..printing.show import aligned

Rows = Sequence[tuple[list[tuple[float, str, int]], list[tuple[float, str, int]]]]
"""Left and right side of each equation: (coefficient, name, dots)."""


def rows_of(linear: Any) -> Rows:
    """Return the terms of the equations of a numeric model."""
    terms = linear.canonical
    result = []
    for i in range(len(linear.coordinates)):
        left = [
            (float(x), name, dots)
            for key, dots in (("M", 2), ("C", 1), ("K", 0))
            for x, name in zip(terms[key][i], linear.coordinates, strict=True)
        ]
        if linear.carried:
            left += [
                (float(x), name, 0) for x, name in zip(terms["K_carried"][i], linear.carried, strict=True)
            ]
        result.append(
            (left, [(float(x), name, 0) for x, name in zip(terms["B"][i], linear.inputs, strict=True)])
        )
    for name, E, E_rates in zip(linear.carried, terms.get("E", ()), terms.get("E_rates", ()), strict=True):
        follow = zip(E, (*linear.coordinates, *linear.carried), strict=True)
        rates = zip(E_rates, linear.coordinates, strict=True)
        right = [(float(x), other, 0) for x, other in follow] + [(float(x), other, 1) for x, other in rates]
        result.append(([(float(1), name, 1)], right))
    return result


def text(rows: Rows) -> str:
    """Return the equations as plain text, a line each."""
    return "\n".join(f"{_sum(a, _text, _digits, '*')} = {_sum(b, _text, _digits, '*')}" for a, b in rows)


def latex(rows: Rows) -> str:
    """Return the equations as a LaTeX ``aligned`` block."""
    lines = [
        " &= ".join(_sum(side, latex_name, latex_number, " ") for side in (left, right))
        for left, right in rows
    ]
    return aligned(lines)


def _live(terms: Sequence[tuple[float, str, int]]) -> list[tuple[float, str, int]]:
    return [(x, name, dots) for x, name, dots in terms if f"{x:.6g}" not in ("0", "-0")]


def _sum(
    terms: Sequence[tuple[float, str, int]],
    write: Callable[[str, int], str],
    number: Callable[[float], str],
    times: str,
) -> str:
    result = ""
    for x, name, dots in _live(terms):
        size = number(abs(x))
        term = write(name, dots) if size == "1" else f"{size}{times}{write(name, dots)}"
        sign = ("-" if x < 0 else "") if not result else " - " if x < 0 else " + "
        result += sign + term
    return result or "0"


def _digits(x: float) -> str:
    return f"{x:.6g}"


def _text(name: str, dots: int) -> str:
    return name + "'" * dots
