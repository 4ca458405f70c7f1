"""Principal moments and axes of inertia, with a definite choice where they are not unique.

R_BPᵀ I R_BP = diag(I_1, I_2, I_3),  I_1 <= I_2 <= I_3
"""

from __future__ import annotations

import sys
from typing import Any, NamedTuple

import sympy

from ..errors import MassError
from ..scalar.algebra import Matrix, Scalar, Vector, cross, negate, transpose
from .entries import is_symbolic, value_of
from .rotation import Rotation

# Two principal moments closer than this, in units of the largest, count as equal: their axes are arbitrary.
DEGENERATE = 64 * sys.float_info.epsilon


class PrincipalAxes(NamedTuple):
    """``moments`` (I_1, I_2, I_3) [kg m²] and ``axes`` R_BP, whose columns are the axes in body axes."""

    moments: Vector
    axes: Rotation


def principal_axes(inertia: Matrix, positive: tuple[Any, ...] = ()) -> PrincipalAxes:
    """Principal moments in ascending order, and the proper rotation R_BP to their axes.

    A diagonal matrix is only sorted, exactly and with symbols too. Moments whose order depends on the symbols
    stay in the order of the body axes, and so do equal moments. For a full matrix of numbers, a unique axis
    points along its largest component. The first axis of two equal moments lies as near to a body axis as
    possible. Three equal moments give the body axes.

    Raises
    ------
    MassError
        For a matrix with symbols that is not diagonal.
    """
    if not (inertia[0][1] or inertia[0][2] or inertia[1][2]):
        return _sorted_diagonal((inertia[0][0], inertia[1][1], inertia[2][2]), positive)
    values = [[value_of(x) for x in row] for row in inertia]
    if any(x is None for row in values for x in row):
        raise MassError(
            "Expected numbers, or a diagonal inertia matrix with symbols, got symbols off the diagonal: the "
            "principal moments are roots of a cubic. Put numbers for the symbols: .at({...}).principal()."
        )
    import numpy

    A = numpy.array(values, float)
    moments, columns = numpy.linalg.eigh(A)
    size = abs(A).max()
    low, high = (moments[1] - moments[0] <= DEGENERATE * size, moments[2] - moments[1] <= DEGENERATE * size)
    if low and high:
        axes = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
    elif low:
        third = _pointed(columns[:, 2])
        first = _nearest_body_axis(third)
        axes = (first, cross(third, first), third)
    else:
        first = _pointed(columns[:, 0])
        second = _nearest_body_axis(first) if high else _pointed(columns[:, 1])
        axes = (first, second, cross(first, second))
    I1, I2, I3 = (float(x) for x in moments)
    return PrincipalAxes((I1, I2, I3), Rotation.trusted(transpose(axes)))


def _sorted_diagonal(moments: Vector, positive: tuple[Any, ...]) -> PrincipalAxes:
    order = [0, 1, 2]
    for _ in range(2):  # two passes of a bubble sort; a pair that cannot be compared stays
        for i in (0, 1):
            if _above(moments[order[i]], moments[order[i + 1]], positive):
                order[i], order[i + 1] = order[i + 1], order[i]
    units: list[Vector] = [(1, 0, 0), (0, 1, 0), (0, 0, 1)]
    even = order in ([0, 1, 2], [1, 2, 0], [2, 0, 1])
    if not even:  # exchange two equal moments rather than reverse an axis
        for i in (0, 1):
            if moments[order[i]] == moments[order[i + 1]]:
                order[i], order[i + 1] = order[i + 1], order[i]
                even = True
                break
    axes = [units[i] for i in order]
    if not even:
        axes[2] = negate(axes[2])
    return PrincipalAxes(
        (moments[order[0]], moments[order[1]], moments[order[2]]),
        Rotation.trusted(transpose((axes[0], axes[1], axes[2]))),
    )


def _above(a: Scalar, b: Scalar, positive: tuple[Any, ...]) -> bool:
    """True if a > b is certain, with the symbols in ``positive`` above zero."""
    if not is_symbolic(a, b):
        return bool(a > b)
    assumed = {s: sympy.Symbol(s.name, positive=True) for s in map(_lone_symbol, positive) if s is not None}
    difference = sympy.factor(sympy.sympify(a - b).xreplace(assumed))
    return difference.is_positive is True


def _lone_symbol(expression: Any) -> Any:
    """The symbol in ``m`` or ``2 a``, which is positive because the expression is; None for other expressions."""
    coefficient, rest = expression.as_coeff_Mul()
    return rest if rest.is_Symbol and coefficient > 0 else None


def _pointed(column: Any) -> Vector:
    """The unit vector, reversed if its largest component (the first of equal components) is negative."""
    x, y, z = (float(c) for c in column)
    sizes = [abs(x), abs(y), abs(z)]
    largest = next(i for i in range(3) if sizes[i] >= max(sizes) * (1 - DEGENERATE))
    return (x, y, z) if (x, y, z)[largest] > 0 else (-x, -y, -z)


def _nearest_body_axis(n: Vector) -> Vector:
    """The unit vector normal to n that lies nearest to a body axis; of equally near axes x, then y, comes first."""
    sizes = [abs(component) for component in n]
    i = next(i for i in range(3) if sizes[i] <= min(sizes) + DEGENERATE)
    p = tuple((1 if j == i else 0) - n[i] * n[j] for j in range(3))
    length = (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]) ** (1 / 2)
    return (p[0] / length, p[1] / length, p[2] / length)
