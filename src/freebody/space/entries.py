"""Conversion of numbers, vectors and matrices that a user gives.

An int, Fraction or float stays unchanged, NumPy's and SymPy's numbers are converted to these, and any other SymPy
expression stays an expression. A name in a text stands for the parameter of that name: it becomes the real symbol
that a system makes for it. Only a system can check that the parameter exists.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from fractions import Fraction
from numbers import Integral, Real
from typing import Any

import sympy

from ..errors import ExpressionError, MassError, ModelError, shown
from ..scalar.algebra import Expression, Field, Matrix, Scalar, Vector, floats
from ..scalar.expression import exact
from ..scalar.parser import CONSTANTS, FUNCTIONS, parse

AXES: dict[str, Vector] = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}


class _Parameters(dict[str, Any]):
    """Mapping that contains every name that is no function and no constant, as a parameter."""

    def __contains__(self, name: object) -> bool:
        known = name in FUNCTIONS or name in CONSTANTS
        return isinstance(name, str) and name.isidentifier() and not known

    def __getitem__(self, name: str) -> Any:
        return sympy.Symbol(name, real=True)


def number(value: Expression, what: str = "a number", error: type[ModelError] = ModelError) -> Scalar:
    """Return one entry as an int, Fraction, float or, if it is none of these, as a SymPy expression.

    >>> number(sympy.Rational(1, 2)), number(2), number(sympy.Symbol("m") / 2)
    (Fraction(1, 2), 2, m/2)
    >>> number("2*a")
    2*a
    """
    # most entries are whole numbers, floats or symbols, and the other questions take longer
    if type(value) is int:
        return _of_floats(value, what, error)
    if type(value) is float:
        return _finite(value, what, error)
    if isinstance(value, sympy.Symbol):
        return value
    if isinstance(value, str):
        try:
            return number(parse(value, _Parameters()), what, error)
        except ExpressionError as problem:
            raise error(f"Expected {what} as a number or an expression of parameters: {problem}") from None
    if isinstance(value, bool) or value is None or getattr(value, "ndim", False):
        raise error(f"Expected {what} as a number or a SymPy expression, got {shown(value)}.")
    if isinstance(value, (int, Fraction)):
        return _of_floats(exact(value), what, error)
    if isinstance(value, Integral) and not isinstance(value, sympy.Basic):
        return int(value)
    if isinstance(value, Real) and not isinstance(value, sympy.Basic) or type(value).__module__ == "numpy":
        return _finite(float(value), what, error)
    try:
        expression = sympy.sympify(value, strict=True)
    except (sympy.SympifyError, TypeError):
        raise error(f"Expected {what} as a number or a SymPy expression, got {shown(value)}.") from None
    if not isinstance(expression, sympy.Expr):
        raise error(f"Expected {what} as a number or a SymPy expression, got {shown(value)}.")
    if expression.is_Float:
        return _finite(float(expression), what, error)
    if expression.is_number and expression.is_finite is False or expression is sympy.nan:
        raise error(f"Expected {what} to be finite, got {expression}.")
    return _of_floats(exact(expression), what, error) if expression.is_Rational else expression


def _of_floats(value: Any, what: str, error: type[ModelError]) -> Any:
    try:
        float(value)
    except OverflowError:
        raise error(f"Expected a finite number for {what}, got one beyond the range of floats.") from None
    return value


def _finite(value: float, what: str, error: type[ModelError]) -> float:
    if value - value != 0:
        raise error(f"Expected {what} to be finite, got {value}.")
    return value


def exact_number(value: Expression, what: str = "a number", error: type[ModelError] = MassError) -> Scalar:
    """Return :func:`number` with each float, inside expressions too, as the decimal it prints as.

    >>> exact_number(0.1), exact_number(0.5 * sympy.Symbol("m"))
    (Fraction(1, 10), m/2)
    """
    entry = number(value, what, error)
    if type(entry) is int:
        return entry
    if isinstance(entry, sympy.Expr) and (decimals := entry.atoms(sympy.Float)):
        entry = entry.xreplace({f: sympy.Rational(str(f)) for f in decimals})
    return exact(entry)


def vector(value: Any, what: str, error: type[ModelError] = ModelError, entry: Any = number) -> Vector:
    """Return three entries."""
    items = _items(value)
    if items is None or len(items) != 3:
        got = shown(value) if items is None else f"{len(items)} components"
        raise error(f"Expected three components of {what}, got {got}.")
    x, y, z = (
        entry(item, f"component {axis} of {what}", error) for axis, item in zip("xyz", items, strict=True)
    )
    return (x, y, z)


def matrix(value: Any, what: str, error: type[ModelError] = ModelError, entry: Any = number) -> Matrix:
    """Return three rows of three entries."""
    rows = _items(value)
    inner = None if rows is None else [_items(row) for row in rows]
    if inner is None or len(inner) != 3 or any(row is None or len(row) != 3 for row in inner):
        raise error(f"Expected {what} with shape (3, 3), got {_shape(value, inner)}.")
    a, b, c = (
        tuple(entry(item, f"entry ({i + 1}, {j + 1}) of {what}", error) for j, item in enumerate(row or ()))
        for i, row in enumerate(inner)
    )
    return (a, b, c)


def direction(axis: Any, what: str, error: type[ModelError] = ModelError) -> Vector:
    """Return the vector of an axis given by a letter or by three components of any length but zero."""
    if isinstance(axis, str):
        if axis not in AXES:
            raise error(f"Expected {what} as 'x', 'y', 'z' or three components, got '{axis}'.")
        return AXES[axis]
    n = vector(axis, what, error)
    if all(component == 0 for component in n):
        raise error(f"Expected {what} of a length that is not zero, got (0, 0, 0).")
    return n


def value_of(entry: Scalar) -> Any:
    """Return the entry as a plain real number, or None if it contains symbols or is not real.

    >>> value_of(Fraction(1, 2)), value_of(sympy.Symbol("m"))
    (Fraction(1, 2), None)
    """
    if isinstance(entry, (int, Fraction, float)):
        return entry
    if entry.free_symbols or entry.atoms(sympy.core.function.AppliedUndef):
        return None
    value = complex(entry)
    return value.real if value.imag == 0 else None


def negative(entry: Scalar) -> bool:
    """True if the entry is a number below zero."""
    value = value_of(entry)
    return value is not None and value < 0


def plain(entry: Scalar) -> Scalar:
    """Return a SymPy rational as an int or Fraction, anything else unchanged."""
    return exact(entry) if isinstance(entry, sympy.Expr) and entry.is_Rational else entry


def reciprocal(entry: Scalar) -> Scalar:
    """Exact 1/x (Python's quotient of two ints is a float)."""
    return 1 / entry if is_symbolic(entry) else 1 / Fraction(entry)


def is_symbolic(*entries: Any) -> bool:
    """True if any entry is a SymPy expression."""
    return any(isinstance(entry, sympy.Basic) for entry in entries)


def text(entry: Scalar) -> str:
    """Text of an entry for people: short fractions stay fractions.

    >>> text(Fraction(1, 3)), text(Fraction(1, 10)), text(Fraction("0.1234567890123456789"))
    ('1/3', '0.1', '0.123457')
    """
    if isinstance(entry, Fraction):
        decimal = f"{float(entry):.6g}"
        return decimal if Fraction(decimal) == entry or entry.denominator > 10000 else str(entry)
    return f"{entry:.6g}" if isinstance(entry, float) else str(entry)


def substitution(values: Mapping[Any, Any]) -> Any:
    """Return a function that replaces the symbols of an entry by numbers; keys are symbols or their names."""
    by_name = {str(key): exact_number(value, f"the value of {key}") for key, value in values.items()}

    def put(entry: Any) -> Any:
        if not isinstance(entry, sympy.Basic):
            return entry
        atoms = entry.free_symbols | entry.atoms(sympy.core.function.AppliedUndef)
        return plain(entry.xreplace({a: sympy.sympify(by_name[str(a)]) for a in atoms if str(a) in by_name}))

    return put


class Expressions(Field):
    """The field of SymPy expressions."""

    def constant(self, value: int | Fraction | float | str) -> Scalar:
        """The number as a SymPy number."""
        return getattr(sympy, value) if isinstance(value, str) else sympy.sympify(exact(value))

    def apply(self, function: str, *arguments: Scalar) -> Scalar:
        """SymPy's ``function`` of expressions."""
        names = {"abs": "Abs", "pow": "Pow", "min": "Min", "max": "Max"}
        return plain(getattr(sympy, names.get(function, function))(*arguments))


expressions = Expressions()


def common_field(*entries: Any) -> tuple[Field, tuple[Any, ...]]:
    """The field of all entries, and the entries in it: expressions if any entry is one, else floats."""
    if not is_symbolic(*entries):
        return floats, entries
    return expressions, tuple(plain(sympy.sympify(exact(entry))) for entry in entries)


def _items(value: Any) -> list[Any] | None:
    """Entries of a sequence, array or matrix; None for anything else."""
    if isinstance(value, (str, bytes)):
        return None
    if hasattr(value, "tolist"):  # numpy.ndarray, sympy.Matrix
        value = value.tolist()
    if not isinstance(value, Iterable):
        return None
    items = list(value)
    if items and all(isinstance(item, list) and len(item) == 1 for item in items):
        return [item[0] for item in items]  # a column matrix
    return items


def _shape(value: Any, rows: list[list[Any] | None] | None) -> str:
    if rows is None:
        return shown(value)
    lengths = {None if row is None else len(row) for row in rows}
    if lengths == {None} or not rows:
        return f"an array with shape ({len(rows)},)"
    if len(lengths) == 1:
        return f"an array with shape ({len(rows)}, {lengths.pop()})"
    return f"rows of different lengths: {shown(value)}"
