"""Directions and orientations, read from what users write."""

from __future__ import annotations

from typing import Any

import sympy

from ..errors import ModelError, shown
from ..scalar.algebra import IDENTITY, Matrix, Vector, cross, dot, multiply, transpose
from ..scalar.expression import exact
from ..space.rotation import Rotation
from .description import Description, varying, vector

UNIT: dict[str, Vector] = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}


def direction(system: Description, axis: Any, what: str) -> Vector:
    """Return the unit vector of ``"x"``, ``"-y"`` or three components of any length but zero."""
    if isinstance(axis, str):
        name = axis.lower().lstrip("+-")
        if name not in UNIT or len(axis) > len(name) + 1:
            raise ModelError(f"Expected 'x', 'y', 'z' or three components for {what}, got '{axis}'.")
        unit = UNIT[name]
        return (-unit[0], -unit[1], -unit[2]) if axis.startswith("-") else unit
    components = vector(system, axis, what)
    for component in components:
        moving = varying(system, component)
        if moving:
            raise ModelError(
                f"A direction fixed in the bodies cannot depend on {', '.join(moving)} ({what})."
            )
    square = sympy.Add(*(sympy.sympify(c) ** 2 for c in components))
    if square == 0:
        raise ModelError(
            f"The axis of {what.removeprefix('the axis of ')} has length zero. Give a direction, such as (0, 0, 1)."
        )
    length = sympy.sqrt(square)
    x, y, z = (exact(sympy.sympify(c) / length) if length != 1 else c for c in components)
    return (x, y, z)


def orientation(system: Description, axes: Any, what: str) -> Matrix:
    """Return a rotation matrix from None (no rotation), a Rotation or nine entries."""
    if axes is None:
        return IDENTITY
    rows: Any = axes.matrix if isinstance(axes, Rotation) else axes
    rows = rows.tolist() if hasattr(rows, "tolist") else rows
    if (
        isinstance(rows, str)
        or not hasattr(rows, "__len__")
        or len(rows) != 3
        or any(isinstance(row, str) or not hasattr(row, "__len__") or len(row) != 3 for row in rows)
    ):
        raise ModelError(f"Expected a Rotation or a 3 x 3 rotation matrix for {what}, got {shown(axes)}.")
    first, second, third = (vector(system, row, what) for row in rows)
    matrix = (first, second, third)
    for entry in (entry for row in matrix for entry in row):
        moving = varying(system, entry)
        if moving:
            raise ModelError(
                f"Axes fixed in the bodies cannot depend on {', '.join(moving)} ({what}). "
                f"A turn that moves is a joint's coordinate."
            )
    if any(isinstance(entry, sympy.Basic) for row in matrix for entry in row):
        error, determinant = _sampled(matrix)
    else:
        products = multiply(matrix, transpose(matrix))
        error = float(max(abs(products[i][j] - IDENTITY[i][j]) for i in range(3) for j in range(3)))
        determinant = float(dot(first, cross(second, third)))
    if error > 1e-12 or determinant < 0:
        raise ModelError(
            f"Expected a rotation matrix for {what}: its rows are orthonormal to {error:.2g} only "
            f"and its determinant is {determinant:.6g}, not 1."
        )
    return matrix


def _sampled(matrix: Matrix) -> tuple[float, float]:
    """Return how far rows of symbols are from orthonormal, and their determinant, with numbers for the symbols."""
    A = sympy.Matrix(matrix)
    sample = {
        symbol: sympy.Rational(i + 2, 3 * i + 7) for i, symbol in enumerate(sorted(A.free_symbols, key=str))
    }
    A = A.subs(sample).evalf(30)
    error = max(abs(float(entry)) for entry in A * A.T - sympy.eye(3))
    determinant = float(A.det())
    return error, determinant
