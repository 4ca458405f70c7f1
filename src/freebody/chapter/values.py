"""The value of a print with the library's values for its names."""

from __future__ import annotations

from typing import Any

import sympy

from ..scalar import algebra
from .notation import Node


def evaluate(node: Node, meaning: Any, element: Any = None) -> Any:
    """Return the value of a print with the library's values for its names: a SymPy expression or a column.

    Raises
    ------
    TypeError, sympy.ShapeError
        The print has no value, for example because it adds a scalar and a vector.
    """
    value = lambda n: evaluate(n, meaning, element)  # noqa: E731
    match node.kind:
        case "number":
            return sympy.Rational(node.value)
        case "name":
            return _named(node.value, meaning, element)
        case "sum":
            return _added([(s, value(p)) for s, p in zip(node.value, node.parts, strict=True)])
        case "product":
            return _multiplied([(s, value(p)) for s, p in zip(node.value, node.parts, strict=True)])
        case "cross":
            a, b = (_vector(value(p)) for p in node.parts)
            return sympy.Matrix(algebra.cross(tuple(a), tuple(b)))
        case "dot":
            a, b = (_vector(value(p)) for p in node.parts)
            return sum((x * y for x, y in zip(a, b, strict=True)), sympy.Integer(0))
        case "power":
            base, exponent = (value(p) for p in node.parts)
            return (
                base.dot(base)
                if isinstance(base, sympy.MatrixBase) and exponent == 2
                else _scalar(base) ** exponent
            )
        case "call" if node.value == "det":
            a, b, c, d = (_scalar(value(p)) for p in node.parts)
            return a * d - b * c
        case "call" if node.value in ("int", "between"):
            inside, low, high = (_scalar(value(p)) for p in node.parts)
            x = _named("x", meaning, element)
            if node.value == "int":
                return sympy.integrate(inside, (x, low, high))
            return inside.subs(x, high) - inside.subs(x, low)
        case "call":
            return getattr(sympy, node.value)(_scalar(value(node.parts[0])))
        case "integral":
            return meaning.integral(node, evaluate)
        case "size":
            return sympy.sqrt(value(node.parts[0]).dot(value(node.parts[0])))
        case "rate":
            return sympy.diff(value(node.parts[0]), meaning.time)
        case "group":
            return value(node.parts[0])
    raise TypeError(f"{node.kind} has no value")


def _named(name: str, meaning: Any, element: Any) -> Any:
    for known in (element or {}, meaning.names):
        if name in known:
            return known[name]
    if name.endswith("'"):
        return sympy.diff(_named(name[:-1], meaning, element), meaning.time)
    raise KeyError(name)


def _vector(x: Any) -> Any:
    if not isinstance(x, sympy.MatrixBase):
        raise TypeError("a vector product of numbers")
    return x


def _scalar(x: Any) -> Any:
    if isinstance(x, sympy.MatrixBase):
        raise TypeError("a vector where a number is expected")
    return x


def _added(terms: list[tuple[str, Any]]) -> Any:
    total = None
    for sign, x in terms:
        signed = -x if sign == "-" else x
        if total is not None and isinstance(total, sympy.MatrixBase) != isinstance(signed, sympy.MatrixBase):
            raise TypeError("a sum of a number and a vector")
        total = signed if total is None else total + signed
    return total


def _multiplied(factors: list[tuple[str, Any]]) -> Any:
    total = None
    for sign, x in factors:
        if sign == "/":
            total = total / _scalar(x)
        elif total is not None and isinstance(total, sympy.MatrixBase) and isinstance(x, sympy.MatrixBase):
            raise TypeError("a product of vectors without a sign")
        else:
            total = x if total is None else total * x
    return total
