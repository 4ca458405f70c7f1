"""Text of expressions, in the language that `scalar.parser` reads."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Any

import sympy
from sympy.printing.str import StrPrinter

from ..errors import FormatError
from ..scalar.algebra import Expression, Scalar
from ..scalar.expression import RATIOS

# SymPy's class -> our name, for those that differ
_NAMES = {"Abs": "abs", "Min": "min", "Max": "max"}
_SAME = {
    "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh",
    "log", "sign", "sqrt", "exp",
}  # fmt: skip


class _Printer(StrPrinter):
    """SymPy's printer with the names of a system; it refuses anything that a file cannot hold."""

    def __init__(self, texts: Mapping[Any, str]) -> None:
        super().__init__({"order": None})
        self.texts = texts

    def _print(self, expr: Any, **kwargs: Any) -> str:
        if expr in self.texts:
            return self.texts[expr]
        return super()._print(expr, **kwargs)

    def _print_Function(self, expr: Any) -> str:
        if expr.func in RATIOS:
            return f"({self._print(RATIOS[expr.func](*expr.args))})"
        name = type(expr).__name__
        name = _NAMES.get(name, name)
        if name not in (*_SAME, *_NAMES.values()):
            raise FormatError(f"Expected an expression that a model file can hold, got '{expr}'.")
        return f"{name}({', '.join(map(self._print, expr.args))})"

    _print_Max = _print_Min = _print_Abs = _print_Function

    def _print_Derivative(self, expr: Any) -> str:
        raise FormatError(f"Expected an expression that a model file can hold, got '{expr}'.")

    def _print_Symbol(self, expr: Any) -> str:
        raise FormatError(f"Expected an expression of the system's own names, got the symbol '{expr}'.")

    def _print_Exp1(self, expr: Any) -> str:
        del expr
        return "exp(1)"

    def _print_Pow(self, expr: Any, rational: bool = False) -> str:
        # the parser never yields (-1)**(1/2) and the like, so a square root is the only power with a name
        if expr.exp is sympy.S.Half:
            return f"sqrt({self._print(expr.base)})"
        return super()._print_Pow(expr, rational=rational)

    def _print_Rational(self, expr: Any) -> str:
        return f"{expr.p}/{expr.q}"


def expression_text(expression: Expression, texts: Mapping[Any, str]) -> str:
    """Return an expression as text over the system's names.

    Parameters
    ----------
    expression : int, Fraction, float or SymPy expression
    texts : mapping of SymPy atom to str
        Names of all symbols, coordinates and speeds.

    Raises
    ------
    FormatError
        Symbols without a name, functions outside the language.

    Examples
    --------
    >>> t, k = sympy.symbols("t k")
    >>> x = sympy.Function("x")(t)
    >>> expression_text(-k*x.diff(t)/3 + abs(x), {k: "k", x: "x", x.diff(t): "x'"})
    "-k*x'/3 + abs(x)"
    """
    return _Printer(texts).doprint(sympy.sympify(expression))


def toml_number(value: Scalar) -> int | float | None:
    """Return a number that TOML holds exactly, such as 0.1 for 1/10, or None if there is none, as for 1/3.

    >>> toml_number(Fraction(1, 10)), toml_number(3), toml_number(Fraction(1, 3))
    (0.1, 3, None)
    """
    if isinstance(value, sympy.Rational):
        value = Fraction(int(value.p), int(value.q))
    if isinstance(value, int | Fraction):
        if value == int(value) and abs(int(value)) < 2**63:
            return int(value)
        try:
            decimal = float(value)
        except OverflowError:
            return None
        return decimal if Fraction(repr(decimal)) == value else None
    return None
