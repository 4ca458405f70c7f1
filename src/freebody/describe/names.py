"""The names of a system and the SymPy atoms they stand for.

A parameter is a real ``Symbol``; a coordinate is a function of the time ``t`` and its speed the
derivative, the same objects as ``sympy.physics.mechanics.dynamicsymbols`` makes.
"""

from __future__ import annotations

import keyword
import math
import re
from collections.abc import Iterable
from functools import lru_cache
from typing import Any

import sympy

from ..errors import ExpressionError, ModelError, nearest, shown
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
    """The time derivative of a coordinate or speed, which SymPy takes a millisecond to make."""
    return atom.diff(TIME)


def is_identifier(text: str) -> bool:
    """Whether a text can be a name: letters, digits and underscores, ASCII."""
    return bool(_IDENTIFIER.match(text))


def check_name(name: Any, what: str) -> str:
    """The name, if it can be one."""
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
    """A number as a float, if it is within the range of floats."""
    try:
        value = float(number)
    except OverflowError:
        value = math.inf
    if not math.isfinite(value):
        shown = str(number)
        shown = shown if len(shown) <= 40 else f"{shown[:20]}…, {len(shown)} characters"
        raise ModelError(f"Expected a finite number for {what}, got {shown}.")
    return value


def _of_floats(expression: Any, what: str) -> Any:
    """The expression, if its numbers are within the range of floats."""
    numbers = expression.atoms(sympy.Rational) if isinstance(expression, sympy.Basic) else (expression,)
    for one in numbers:
        finite(one, what)
    return expression


class Names:
    """Symbols by name: what each is, and the text of the user read against them."""

    def __init__(self) -> None:
        self.kinds: dict[str, str] = {"t": "time"}
        self.atoms: dict[str, Any] = {"t": TIME}
        self.texts: dict[Any, str] = {TIME: "t"}
        self.changes = Changes()
        self.signals: dict[Any, Placed] = Table(self.changes)
        self._accelerations: set[Any] = set()

    def text_of(self, key: Any) -> str:
        """The name that a text or an atom stands for; of anything else, what it prints as."""
        if isinstance(key, str):
            return key
        return self.texts.get(key, str(key)) if isinstance(key, sympy.Basic) else repr(key)

    def mark(self) -> int:
        """How many names there are, to return to by :meth:`forget`."""
        return len(self.kinds)

    def forget(self, mark: int) -> None:
        """Take back the names made since ``mark``."""
        for text in list(self.kinds)[mark:]:
            del self.kinds[text]
            atom = self.atoms.pop(text, None)
            self.texts.pop(atom, None)
        for signal in [one for one in self.signals if one.name not in self.kinds]:
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
        """A new parameter."""
        check_name(name, "parameter")
        self._claim(name, "parameter")
        return self._register(name, sympy.Symbol(name, real=True), "parameter")

    def coordinate(self, name: str) -> Any:
        """A new coordinate; its speed is ``name'``."""
        check_name(name, "coordinate")
        self._claim(name, "coordinate")
        atom = sympy.Function(name)(TIME)
        self._register(name, atom, "coordinate")
        self._register(name + "'", rate(atom), "speed")
        self._accelerations.add(rate(rate(atom)))
        return atom

    def component(self, name: str, kind: str) -> Any:
        """A component of a quaternion, a position or an angular or linear velocity."""
        check_name(name, kind)
        self._claim(name, kind)
        return self._register(name, sympy.Function(name)(TIME), kind)

    def _placed(self, expression: Any) -> Any:
        """An expression in which signals are the polynomials of their pieces; new ones get symbols for these."""
        if not isinstance(expression, sympy.Basic):
            return expression
        found = sorted(expression.atoms(Signal), key=lambda one: one.dummy_index)
        for one in found:
            if one in self.signals:
                continue
            self._claim(one.name, "signal")
            endings = ["_start"] * (one.degree > 0) + [f"_c{k}" for k in range(one.degree + 1)]
            for ending in endings:
                self._claim(one.name + ending, "signal")
            symbols = tuple(sympy.Symbol(one.name + ending, real=True) for ending in endings)
            for symbol in symbols:
                self._register(symbol.name, symbol, "signal")
            if one.degree == 0:
                value = symbols[0]
            else:
                x = TIME - symbols[0]
                value = sum(c * x**k for k, c in enumerate(symbols[1:]))
            self.atoms[one.name] = value  # the text stands for the polynomial
            self.signals[one] = Placed(one, symbols, value)
        return (
            expression.xreplace({one: self.signals[one].expression for one in found}) if found else expression
        )

    def rough(self, expression: Any) -> list[str]:
        """Names of the signals in an expression that are no twice differentiable functions of time."""
        return sorted(one.name for one in self._signals_in(expression) if not one.smooth)

    def signal_named(self, name: str) -> Signal:
        """A signal in use."""
        return next(one for one in self.signals if one.name == name)

    def _signals_in(self, expression: Any) -> list[Any]:
        symbols = expression.free_symbols if isinstance(expression, sympy.Basic) else set()
        return [one for one, placed in self.signals.items() if symbols.intersection(placed.symbols)]

    def expression(self, value: Any, what: str) -> Any:
        """A number as int or Fraction, text and SymPy as a SymPy expression of known names.

        Raises
        ------
        ExpressionError
            Unknown names (the nearest known one is offered), complex or infinite numbers.
        """
        if isinstance(value, str):
            try:
                return _of_floats(exact(parse(value, self.atoms)), what)
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
        result = self._placed(result)
        if not isinstance(result, sympy.Basic):
            return _of_floats(result, what)
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

    def depends(self, expression: Any, *kinds: str) -> list[str]:
        """Names of the given kinds that stand in an expression."""
        if not isinstance(expression, sympy.Basic):
            return []
        if expression in self.texts:
            name = self.texts[expression]
            if self.kinds[name] == "signal":
                return [name.rpartition("_")[0]] if "time" in kinds else []
            return [name] if self.kinds[name] in kinds else []
        return sorted({name for part in expression.args for name in self.depends(part, *kinds)})
