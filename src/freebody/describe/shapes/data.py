"""Data of shapes, checked: lengths, directions and places in a body."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import sympy

from ...errors import ModelError, shown
from ...scalar.algebra import Expression, Scalar, Vector
from ...scalar.expression import exact
from ..axes import direction
from ..constants import constant, default_value
from ..description import positive_in, take_as_positive, vector
from ..frame import Frame


def length(body: Frame, size: Expression, what: str) -> Scalar:
    """Return a length greater than zero; a parameter as length becomes known to be positive."""
    expression = constant(body.system, size, f"the size of {what}")
    value = default_value(body.system, expression)
    if value is not None and value <= 0:
        raise ModelError(f"Expected a size of more than 0 for {what}, got {value:g}.")
    if isinstance(expression, sympy.Symbol):
        take_as_positive(body.system, expression)
    return expression


def flag(value: Any, what: str) -> bool:
    """Return a truth value."""
    if not isinstance(value, bool):
        raise ModelError(f"Expected inside=True or inside=False for {what}, got {shown(value)}.")
    return value


def unit_vector(body: Frame, normal: Any, what: str) -> Vector:
    """Return the unit vector along a direction; (-sin b, cos b, 0) is taken as it is, without a square root."""
    if not isinstance(normal, str):
        components = vector(body.system, normal, what)
        square = sympy.Add(*(sympy.sympify(c) ** 2 for c in components))
        if square.free_symbols and sympy.simplify(square) == 1:
            direction(body.system, normal, what)  # checks the components
            return components
    return direction(body.system, normal, what)


def sum_of(a: Sequence[Any], b: Sequence[Any]) -> Vector:
    """Return the sum of two vectors, exactly."""
    x, y, z = (exact(sympy.sympify(p) + q) for p, q in zip(a, b, strict=True))
    return (x, y, z)


def root_of(body: Frame, square: Any) -> Any:
    """Return the square root, simplified by the dimensions known to be positive."""
    dummies = {s: sympy.Dummy(str(s), positive=True) for s in square.free_symbols & positive_in(body.system)}
    root = sympy.sqrt(sympy.factor(square.xreplace(dummies)))
    return root.xreplace({dummy: symbol for symbol, dummy in dummies.items()})


def text_of(components: Vector) -> str:
    """Return three components in words."""
    return f"({', '.join(map(str, components))})"
