"""A statement of the chapter, and the verdict on it: worked out each time it is asked for, never written down.

A statement holds the formula as it is printed and what the library derives for it. The verdict follows from their
difference in canonical form, which is zero or it is not:

    holds                       the difference is zero
    holds if ...                it is zero once the condition is put in, and not before
    definition                  a name is given; what the library calls so is the same
    approximation               the difference falls as a power of a small quantity; power and size are measured
    misprint                    the difference is not zero, and the form that is derived instead is shown
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import sympy

from ...equations.show import latex_of, text_of
from ...scalar.ring import Ring

_LONGEST = 240

DIGITS = 40
"""Of the numbers that errors of approximations are measured with."""


def is_zero(expression: Any) -> bool:
    """Whether an expression is zero in canonical form.

    >>> x = sympy.Symbol("x")
    >>> is_zero(sympy.sin(2 * x) - 2 * sympy.sin(x) * sympy.cos(x))
    True
    """
    return bool(Ring().from_sympy(sympy.sympify(expression)) == 0)


@dataclass(frozen=True)
class Line:
    """One scalar equation of a statement.

    Attributes
    ----------
    printed : SymPy Eq
        As the chapter has it, or its components where it prints vectors.
    residual : SymPy expression
        Left minus right of the print, less the same of what the library derives: zero if the print is right.
    derived : SymPy Eq
        The equation as the library derives it.
    """

    printed: Any
    residual: Any
    derived: Any

    @cached_property
    def holds(self) -> bool:
        """Whether the residual is canonically zero."""
        return is_zero(self.residual)


def value(symbol: Any, printed: Any, derived: Any) -> Line:
    """A quantity that the chapter gives as one expression and the library as another."""
    return Line(_eq(symbol, printed), printed - derived, _eq(symbol, derived))


def balance(left: Any, right: Any, derived: Any, scale: Any = 1) -> Line:
    """A printed equation against a derived one, ``(left, right)``; ``scale`` times the print is to be the derived."""
    residual = sympy.sympify(scale) * (left - right) - (derived[0] - derived[1])
    return Line(_eq(left, right), residual, _eq(*derived))


def identity(left: Any, right: Any) -> Line:
    """Two sides that the library gives both: they are to be equal."""
    return Line(_eq(left, right), left - right, _eq(left, left))


def _eq(left: Any, right: Any) -> Any:
    return sympy.Eq(left, right, evaluate=False)


@dataclass(frozen=True)
class Approximation:
    """An exact expression, its approximation, and the quantity that is small.

    ``at`` holds numbers for all other symbols; ``small`` is the value that is ordinary in the chapter. ``scale`` is
    what the error is compared with where it is not the exact expression, as for a part that is left out.
    """

    name: Any
    exact: Any
    approximate: Any
    symbol: Any
    small: Any
    at: Mapping[Any, Any]
    scale: Any = None

    def error(self, size: Any) -> Any:
        """The difference at a size of the small quantity."""
        numbers = {k: sympy.N(sympy.sympify(v), DIGITS) for k, v in self.at.items()}
        put = {**numbers, self.symbol: sympy.N(sympy.sympify(size), DIGITS)}
        difference = sympy.sympify(self.exact - self.approximate).xreplace(put)
        return sympy.N(difference, DIGITS)

    @cached_property
    def order(self) -> int:
        """The power of the small quantity that the error falls with: the slope between two small sizes."""
        a, b = (abs(self.error(self.small * sympy.Rational(1, 10**k))) for k in (4, 5))
        return round(float(sympy.log(a / b, 10))) if a and b else 0

    @cached_property
    def relative_error(self) -> float:
        """The error at the ordinary size, divided by the exact value there, or by the scale."""
        numbers = {**self.at, self.symbol: self.small}
        whole = self.exact if self.scale is None else self.scale
        exact = sympy.N(sympy.sympify(whole).xreplace(numbers), DIGITS)
        return float(abs(self.error(self.small) / exact)) if exact else float(abs(self.error(self.small)))

    @cached_property
    def line(self) -> Line:
        """The approximation as a line of its statement."""
        return Line(
            _eq(self.name, self.approximate), self.approximate - self.exact, _eq(self.name, self.exact)
        )


@dataclass(frozen=True)
class Finding:
    """The verdict on a statement.

    Attributes
    ----------
    verdict : "holds", "holds under a condition", "definition", "approximation", "misprint" or "unproven"
    detail : str
        The condition, the error measured, or which lines are misprinted.
    lines : tuple of Line
    wrong : tuple of int
        Lines whose residual is not zero.
    """

    verdict: str
    detail: str
    lines: tuple[Line, ...]
    wrong: tuple[int, ...] = ()


@dataclass(frozen=True)
class Statement:
    """An equation of the chapter.

    Attributes
    ----------
    number : str
        ``"6.27"``, or ``"ex-6-1 (d)"`` for the lettered equation of an example.
    about : str
        What it states, in words.
    call : str
        What of the library produces it or verifies it.
    work : function
        Gives the lines, each with its residual; or approximations.
    condition : tuple, optional
        Words, and a function that gives what to put in (expression -> expression) for the statement to hold.
    defines : bool
        Whether it gives a name to something.
    print_is : str
        Where a vector equation is printed, its form; shown above the components.
    """

    number: str
    about: str
    call: str
    work: Callable[[], Sequence[Line | Approximation]]
    condition: tuple[str, Callable[[], Mapping[Any, Any]]] | None = None
    defines: bool = False
    print_is: str = ""

    @cached_property
    def finding(self) -> Finding:
        """The verdict, derived now."""
        work = tuple(self.work())
        rough = [x for x in work if isinstance(x, Approximation)]
        lines = tuple(x.line if isinstance(x, Approximation) else x for x in work)
        if rough:
            return _approximation(rough, lines)
        wrong = tuple(i for i, line in enumerate(lines) if not line.holds)
        if not wrong:
            return Finding("definition" if self.defines else "holds", "", lines)
        if self.condition is not None:
            words, put = self.condition
            if all(is_zero(sympy.sympify(lines[i].residual).subs(put())) for i in wrong):
                return Finding("holds under a condition", words, lines, wrong)
        if all(is_zero(line.derived.lhs - line.derived.rhs) for line in (lines[i] for i in wrong)):
            return Finding("unproven", "two sides that the library gives differ", lines, wrong)
        return Finding("misprint", _count(wrong, len(lines)), lines, wrong)

    def text(self) -> str:
        """The statement, its verdict and the derivation, as plain text."""
        found = self.finding
        rows = [f"({self.number})  {self.about}", ""]
        if self.print_is:
            rows += [f"  {self.print_is}", ""]
        rows += ["  by components:" if self.print_is else "  as printed:"]
        rows += [f"    {_short(_written(line.printed))}" for line in found.lines]
        rows += ["", f"  by the library: {self.call}"]
        for i, line in enumerate(found.lines):
            if found.verdict == "approximation":
                exact = (
                    _written(line.derived) if line.derived.lhs != line.derived.rhs else "the left side itself"
                )
                rows.append(f"    exactly: {exact}")
            elif i in found.wrong:
                rows.append(f"    line {i + 1}, printed minus derived: {text_of(_tidy(line.residual))}")
            else:
                rows.append(f"    line {i + 1}, printed minus derived: 0")
        if found.verdict == "misprint":
            rows += ["", "  right:"]
            rows += [f"    {_written(_tidied(found.lines[i].derived))}" for i in found.wrong]
        rows += ["", f"  verdict: {self.verdict}"]
        return "\n".join(rows)

    @property
    def verdict(self) -> str:
        """The verdict with its detail, in a line."""
        found = self.finding
        joint = {"holds under a condition": "holds if", "misprint": "misprint in"}.get(
            found.verdict, found.verdict
        )
        if not found.detail:
            return found.verdict
        return (
            f"{joint} {found.detail}"
            if found.verdict in ("holds under a condition", "misprint")
            else (f"{found.verdict}: {found.detail}")
        )

    def latex(self) -> str:
        """Printed and derived forms as LaTeX, one under the other."""
        found = self.finding
        rows = [rf"{latex_of(line.printed)} && \text{{printed}}" for line in found.lines]
        rows += [rf"{latex_of(_tidied(found.lines[i].derived))} && \text{{derived}}" for i in found.wrong]
        return "\\begin{aligned}\n" + " \\\\\n".join(rows) + "\n\\end{aligned}"

    def data(self) -> dict[str, Any]:
        """The same as plain data, for JSON."""
        found = self.finding
        return {
            "number": self.number,
            "about": self.about,
            "call": self.call,
            "verdict": found.verdict,
            "detail": found.detail,
            "printed": [_written(line.printed) for line in found.lines],
            "residuals": [text_of(_tidy(line.residual)) for line in found.lines],
            "derived": [_written(_tidied(line.derived)) for line in found.lines],
        }


def _approximation(rough: Sequence[Approximation], lines: tuple[Line, ...]) -> Finding:
    parts = [
        f"{x.name}: error of order {x.order} in {x.symbol}, relative {x.relative_error:.1e} at {x.symbol} = "
        f"{float(sympy.N(x.small)):.3g}"
        for x in rough
    ]
    if any(x.order < 1 for x in rough):
        return Finding("unproven", "the error does not vanish with the small quantity", lines)
    return Finding("approximation", "; ".join(parts), lines, tuple(range(len(lines))))


def _count(wrong: Sequence[int], total: int) -> str:
    """
    >>> _count([2, 3], 4)
    'lines 3 and 4 of 4'
    """
    if total == 1:
        return ""
    numbers = " and ".join(str(i + 1) for i in wrong)
    return f"line{'s' if len(wrong) > 1 else ''} {numbers} of {total}"


def _tidy(x: Any) -> Any:
    """The canonical form, or it factored: whichever is written shorter."""
    ring = Ring()
    element = ring.from_sympy(sympy.sympify(x))
    if element == 0:
        return sympy.Integer(0)
    plain = ring.to_sympy(element)
    return min(
        (sympy.factor_terms(plain), sympy.factor(plain), sympy.sympify(x)), key=lambda e: len(text_of(e))
    )


def _tidied(equation: Any) -> Any:
    return _eq(_tidy(equation.lhs), _tidy(equation.rhs))


def _short(line: str) -> str:
    """A line without its middle where it is too long to read."""
    return line if len(line) <= _LONGEST else f"{line[: _LONGEST // 2]} ... {line[-_LONGEST // 4 :]}"


def _written(equation: Any) -> str:
    return f"{text_of(equation.lhs)} = {text_of(equation.rhs)}"
