"""The law of a spring or damper: an expression of `stretch` and `rate`, or a table of (stretch, force).

A table is joined by monotone cubics p_i (Fritsch & Carlson): where the values rise, the curve rises. In each interval
[x_i, x_i+1], with the part of the stretch within it s_i = min(max(x, x_i), x_i+1),

f = f_0 + Σ (p_i(s_i) - f_i) + m_0 min(x - x_0, 0) + m_n max(x - x_n, 0)

a formula without branches whose derivative is that of the cubic; beyond the table the slope at its end goes on.

Source: Fritsch & Carlson, Monotone piecewise cubic interpolation, SIAM J. Numer. Anal. 17 (1980) 238.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

import sympy

from ...errors import ExpressionError, ModelError, shown
from ...scalar.algebra import HALF, Scalar
from ...scalar.expression import exact
from ...scalar.parser import parse
from ..description import Description, names_of, varying

STRETCH, RATE = sympy.symbols("stretch rate", real=True)
"""The names by which the expression of a law knows what it depends on."""

Choice = Callable[[Scalar, Scalar], Scalar]
"""The least or the greatest of two scalars."""

MOST = 200
"""Most points of a table."""


@dataclass(frozen=True)
class Law:
    """A law f(stretch, rate); made by :func:`law_of`.

    ``expression`` is of the names of the system and STRETCH, RATE; ``table`` has pairs (stretch, force), else is empty.
    """

    expression: Any = 0
    table: tuple[tuple[Any, Any], ...] = ()

    @property
    def has_rate(self) -> bool:
        """True if the law depends on the rate of the stretch."""
        return RATE in getattr(self.expression, "free_symbols", ())

    @property
    def is_conservative(self) -> bool:
        """True if the law has a potential: a table, or a polynomial of the stretch with constant coefficients."""
        return bool(self.table) or self._energy is not None

    @cached_property
    def _energy(self) -> Any:
        """∫ f ds of a polynomial of the stretch, else None."""
        expression = sympy.sympify(self.expression)
        if self.has_rate or any(
            a.args for a in expression.atoms(sympy.core.function.AppliedUndef, sympy.Derivative)
        ):
            return None
        if sympy.Symbol("t") in expression.free_symbols or not expression.is_polynomial(STRETCH):
            return None
        return sympy.Poly(expression, STRETCH).integrate(STRETCH).as_expr()

    def force(self, at: Any, stretch: Scalar, rate: Scalar) -> Scalar:
        """Return f."""
        if not self.table:
            return at.of(self.expression, {STRETCH: stretch, RATE: rate})
        (first, f), (last, _) = self.table[0], self.table[-1]
        m = self._slopes
        total = f + m[0] * at.min(stretch - first, 0) + m[-1] * at.max(stretch - last, 0)
        for i, (a, b, _, s) in enumerate(self._pieces(at.min, at.max, stretch)):
            total = total + s * (m[i] + s * (b + s * a))
        return total

    def energy(self, at: Any, stretch: Scalar) -> Scalar:
        """Return ∫ f ds from 0."""
        if not self.table:
            return at.of(self._energy, {STRETCH: stretch, RATE: 0})
        return self._integral(at.min, at.max, stretch) - self._integral(min, max, Fraction(0))

    def _integral(self, least: Choice, most: Choice, x: Scalar) -> Scalar:
        """∫ f ds from the first place of the table."""
        (first, f), (last, _) = self.table[0], self.table[-1]
        m = self._slopes
        before, beyond = least(x - first, 0), most(x - last, 0)
        total = f * (x - first) + HALF * (m[0] * before * before + m[-1] * beyond * beyond)
        for i, (a, b, rise, s) in enumerate(self._pieces(least, most, x)):
            part = s * s * (m[i] / 2 + s * (b / 3 + s * (a / 4)))
            total = total + part + rise * most(x - self.table[i + 1][0], 0)
        return total

    def _pieces(self, least: Choice, most: Choice, x: Scalar) -> list[tuple[Any, Any, Any, Scalar]]:
        """Third and second coefficient, rise and s - x_i of each interval."""
        result = []
        m = self._slopes
        for i, ((x_0, f_0), (x_1, f_1)) in enumerate(zip(self.table, self.table[1:], strict=False)):
            h = Fraction(x_1 - x_0)
            chord = (f_1 - f_0) / h
            a, b = (m[i] + m[i + 1] - 2 * chord) / h**2, (3 * chord - 2 * m[i] - m[i + 1]) / h
            result.append((a, b, f_1 - f_0, least(most(x - x_0, 0), h)))
        return result

    @cached_property
    def _slopes(self) -> list[Fraction]:
        """Slopes of the monotone cubics at the places of the table: harmonic means of the chords."""
        pairs = list(zip(self.table, self.table[1:], strict=False))
        h = [Fraction(b[0] - a[0]) for a, b in pairs]
        chords = [(b[1] - a[1]) / width for (a, b), width in zip(pairs, h, strict=True)]
        inner = []
        for i in range(1, len(chords)):
            left, right = chords[i - 1], chords[i]
            if left * right <= 0:
                inner.append(Fraction(0))
            else:
                w, v = 2 * h[i] + h[i - 1], h[i] + 2 * h[i - 1]
                inner.append((w + v) / (w / left + v / right))
        return [chords[0], *inner, chords[-1]]


def law_of(system: Description, value: Any, what: str) -> Law:
    """Return the law that an expression or a table describes.

    Raises
    ------
    ModelError
        A table whose places do not rise, or of less than two points; an expression of unknown names.
    """
    if isinstance(value, Law):
        return value
    if isinstance(value, Sequence) and not isinstance(value, str):
        return Law(table=_table(system, value, what))
    names = names_of(system)
    taken = [symbol.name for symbol in (STRETCH, RATE) if symbol.name in names.atoms]
    if taken:
        raise ModelError(
            f"The law of {what} is an expression of `stretch` and `rate`, but this system has a "
            f"{names.kinds[taken[0]]} '{taken[0]}'. Give that another name."
        )
    if isinstance(value, str):
        try:
            return Law(exact(parse(value, {**names.atoms, "stretch": STRETCH, "rate": RATE})))
        except ExpressionError as error:
            raise ExpressionError(f"In the law of {what}: {error}") from None
    try:
        known = exact(value)
    except sympy.SympifyError:
        raise ModelError(
            f"Expected the law of {what} as an expression of stretch and rate, such as '20*stretch', or as a table of "
            f"pairs (stretch, force), got {shown(value)}."
        ) from None
    plain = {STRETCH: sympy.Integer(1), RATE: sympy.Integer(1)}
    if isinstance(known, sympy.Basic):
        system.expression(known.xreplace(plain), what)  # it refuses unknown names
    return Law(known)


def _table(system: Description, value: Sequence[Any], what: str) -> tuple[tuple[Any, Any], ...]:
    pairs = [
        tuple(pair) if isinstance(pair, Sequence) and not isinstance(pair, str) else pair for pair in value
    ]
    if not 2 <= len(pairs) <= MOST or any(not isinstance(pair, tuple) or len(pair) != 2 for pair in pairs):
        raise ModelError(
            f"Expected a table of 2 to {MOST} pairs (stretch, force) for {what}, such as [(0, 0), (0.1, 5)], got "
            f"{shown(value)}."
        )
    rows = [tuple(system.expression(x, f"the table of {what}") for x in pair) for pair in pairs]
    for x in (x for row in rows for x in row):
        if not isinstance(x, int | Fraction):
            moving = varying(system, x)
            kind = f"which depends on {', '.join(moving)}" if moving else "a parameter"
            raise ModelError(
                f"Expected numbers in the table of {what}, got '{x}', {kind}. Scale it by an expression."
            )
    for (a, _), (b, _) in zip(rows, rows[1:], strict=False):
        if not a < b:
            raise ModelError(
                f"Expected rising places in the table of {what}, got {float(a):g} and then {float(b):g}."
            )
    return tuple((Fraction(x), Fraction(f)) for x, f in rows)
