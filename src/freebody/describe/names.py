"""The names of a system and the SymPy atoms they stand for.

A parameter is a real ``Symbol``; a coordinate is a function of the time ``t`` and its speed the
derivative, the same objects as ``sympy.physics.mechanics.dynamicsymbols`` makes.
"""

from __future__ import annotations

import keyword
import math
import re
import sys
from collections.abc import Iterable
from functools import lru_cache
from typing import Any

import sympy
from sympy.core.function import AppliedUndef

from ..errors import ExpressionError, ModelError, nearest, shown
from ..scalar.algebra import Expression, Scalar
from ..scalar.expression import exact
from ..scalar.parser import parse
from .signal import Placed, Signal
from .table import Changes, Table

TIME = sympy.Symbol("t")
_NOT_REAL = (sympy.I, sympy.oo, -sympy.oo, sympy.zoo, sympy.nan)
_ATOMS = 1 << 14
_IDENTIFIER = re.compile(r"[A-Za-z_][A-Za-z0-9_]*\Z")


@lru_cache(maxsize=_ATOMS)
def rate(atom: Any) -> Any:
    """Return the time derivative of a coordinate or speed.

    ``diff`` takes a millisecond to find that d/dt of dᵏf/dtᵏ is dᵏ⁺¹f/dtᵏ⁺¹.
    """
    function, order = (atom, 0) if isinstance(atom, AppliedUndef) else (atom.expr, atom.derivative_count)
    return sympy.Expr.__new__(sympy.Derivative, function, sympy.Tuple(TIME, order + 1))


def is_identifier(text: str) -> bool:
    """Return True if a text can be a name: ASCII letters, digits and underscores."""
    return bool(_IDENTIFIER.match(text))


def check_name(name: Any, what: str) -> str:
    """Return the name, or raise ModelError if it cannot be a name."""
    if not isinstance(name, str):
        raise ModelError(
            f"Expected a name (text) for the {what}, got {shown(name)}. It comes first, in quotes."
        )
    if not is_identifier(name) or keyword.iskeyword(name):
        raise ModelError(
            f"'{name}' cannot be the name of a {what}: use letters, digits and underscores, "
            f"begin with a letter, and avoid Python's keywords."
        )
    return name


def finite(number: Any, what: str) -> float:
    """Return a number as a float, or raise ModelError if it is beyond the range of floats."""
    try:
        value = float(number)
    except OverflowError:
        value = math.inf
    if not math.isfinite(value):
        shown = str(number)
        shown = shown if len(shown) <= 40 else f"{shown[:20]}…, {len(shown)} characters"
        raise ModelError(f"Expected a finite number for {what}, got {shown}.")
    return value


def _in_range(expression: Scalar, what: str) -> Scalar:
    """Return the expression, or raise ModelError if one of its numbers is beyond the range of floats."""
    numbers = expression.atoms(sympy.Rational) if isinstance(expression, sympy.Basic) else (expression,)
    for number in numbers:
        finite(number, what)
    return expression


class Names:
    """Symbols by name, their kinds, and expressions of them read from the user's text."""

    def __init__(self) -> None:
        self.kinds: dict[str, str] = {"t": "time"}
        self.atoms: dict[str, Any] = {"t": TIME}
        self.texts: dict[Any, str] = {TIME: "t"}
        self.changes = Changes()
        self.signals: dict[Any, Placed] = Table(self.changes)
        self._accelerations: set[Any] = set()

    def text_of(self, key: Any) -> str:
        """Return the name that a text or an atom stands for, or how any other object prints."""
        if isinstance(key, str):
            return key
        return self.texts.get(key, str(key)) if isinstance(key, sympy.Basic) else repr(key)

    def mark(self) -> int:
        """Return the number of names, a mark for :meth:`forget`."""
        return len(self.kinds)

    def forget(self, mark: int) -> None:
        """Remove the names made since ``mark``."""
        for text in list(self.kinds)[mark:]:
            del self.kinds[text]
            atom = self.atoms.pop(text, None)
            self.texts.pop(atom, None)
        for signal in [signal for signal in self.signals if signal.name not in self.kinds]:
            del self.signals[signal]

    def _claim(self, name: str, kind: str) -> None:
        if name in self.kinds:
            raise ModelError(
                f"The name '{name}' is taken: it is already a {self.kinds[name]} of this system. Choose another name."
            )
        self.kinds[name] = kind

    def _register(self, text: str, atom: Any, kind: str) -> Any:
        self.atoms[text] = atom
        self.texts[atom] = text
        self.kinds.setdefault(text, kind)
        return atom

    def parameter(self, name: str) -> sympy.Symbol:
        """Add a parameter and return its symbol."""
        check_name(name, "parameter")
        self._claim(name, "parameter")
        return self._register(name, sympy.Symbol(name, real=True), "parameter")

    def coordinate(self, name: str) -> Any:
        """Add a coordinate, whose speed is ``name'``, and return its function of time."""
        check_name(name, "coordinate")
        self._claim(name, "coordinate")
        atom = sympy.Function(name)(TIME)
        self._register(name, atom, "coordinate")
        self._register(name + "'", rate(atom), "speed")
        self._accelerations.add(rate(rate(atom)))
        return atom

    def component(self, name: str, kind: str) -> Any:
        """Add a component of a quaternion, a position, or an angular or linear velocity, and return its atom."""
        check_name(name, kind)
        self._claim(name, kind)
        return self._register(name, sympy.Function(name)(TIME), kind)

    def _with_pieces(self, expression: Any) -> Any:
        """Return an expression with each signal replaced by the polynomial of its piece; new signals get symbols."""
        if not isinstance(expression, sympy.Basic):
            return expression
        signals = sorted(expression.atoms(Signal), key=lambda signal: signal.dummy_index)
        for signal in signals:
            if signal in self.signals:
                continue
            self._claim(signal.name, "signal")
            endings = ["_start"] * (signal.degree > 0) + [f"_c{k}" for k in range(signal.degree + 1)]
            for ending in endings:
                self._claim(signal.name + ending, "signal")
            symbols = tuple(sympy.Symbol(signal.name + ending, real=True) for ending in endings)
            for symbol in symbols:
                self._register(symbol.name, symbol, "signal")
            if signal.degree == 0:
                value = symbols[0]
            else:
                x = TIME - symbols[0]
                value = sum(c * x**k for k, c in enumerate(symbols[1:]))
            self.atoms[signal.name] = value  # the text stands for the polynomial
            self.signals[signal] = Placed(signal, symbols, value)
        if not signals:
            return expression
        return expression.xreplace({signal: self.signals[signal].expression for signal in signals})

    def rough(self, expression: Scalar) -> list[str]:
        """Return the names of the signals in an expression that are not twice differentiable."""
        return sorted(signal.name for signal in self._signals_in(expression) if not signal.smooth)

    def signal_named(self, name: str) -> Signal:
        """Return the signal in use that has this name."""
        return next(signal for signal in self.signals if signal.name == name)

    def _signals_in(self, expression: Any) -> list[Any]:
        symbols = expression.free_symbols if isinstance(expression, sympy.Basic) else set()
        return [signal for signal, placed in self.signals.items() if symbols.intersection(placed.symbols)]

    def expression(self, value: Expression, what: str) -> Scalar:
        """Return a number as int or Fraction; text and SymPy objects as a SymPy expression of known names.

        Raises
        ------
        ExpressionError
            Unknown names (the message offers the nearest known one), complex or infinite numbers.
        """
        if type(value) is int and value.bit_length() < sys.float_info.max_exp:
            return value
        if isinstance(value, sympy.Basic) and value in self.texts:
            return value
        if isinstance(value, str):
            try:
                return _in_range(exact(parse(value, self.atoms)), what)
            except ExpressionError as error:
                raise ExpressionError(f"In {what}: {error}") from None
        try:
            result = exact(value)
        except (sympy.SympifyError, TypeError, AttributeError, ValueError) as error:
            if isinstance(error, ExpressionError):
                raise ExpressionError(f"In {what}: {error}") from None
            raise ExpressionError(
                f"In {what}: expected a number, a SymPy expression or text, got {shown(value)}."
            ) from None
        result = self._with_pieces(result)
        if not isinstance(result, sympy.Basic):
            return _in_range(result, what)
        if not isinstance(result, sympy.Expr) or result.has(*_NOT_REAL):
            raise ExpressionError(f"In {what}: expected a real expression, got '{result}'.")
        self._check_atoms(result, what)
        return result

    def _check_atoms(self, expression: Any, what: str) -> None:
        if expression in self.texts:
            return
        if (
            expression.is_Symbol
            or expression.is_Derivative
            or isinstance(expression, sympy.core.function.AppliedUndef)
        ):
            if expression in self._accelerations:
                raise ExpressionError(
                    f"In {what}: the acceleration {expression} cannot stand in an expression; "
                    f"a load may depend on coordinates, speeds, time and parameters."
                )
            text = (
                str(expression.func) if expression.args and not expression.is_Derivative else str(expression)
            )
            if text in self.kinds:
                raise ExpressionError(
                    f"In {what}: '{expression}' has the name of a {self.kinds[text]} of this system but is another "
                    f"SymPy object. Use the object that the system returned, or the text '{text}'."
                )
            raise ExpressionError(f"In {what}: unknown symbol '{text}'; {nearest(text, self._plain())}")
        for argument in expression.args:
            self._check_atoms(argument, what)

    def _plain(self) -> Iterable[str]:
        return [name for name in self.atoms if not name.endswith("'")]

    def depends(self, expression: Scalar, *kinds: str) -> list[str]:
        """Return the names of the given kinds that an expression contains."""
        if not isinstance(expression, sympy.Basic):
            return []
        if expression in self.texts:
            name = self.texts[expression]
            if self.kinds[name] == "signal":
                return [name.rpartition("_")[0]] if "time" in kinds else []
            return [name] if self.kinds[name] in kinds else []
        return sorted({name for part in expression.args for name in self.depends(part, *kinds)})
