"""Tests that a body can have a mass and an inertia; each message names the failed condition and by how much it fails.

Every dm adds ``(y²+z², x²+z², x²+y²) dm`` to the moments. About any three perpendicular axes, therefore, no moment
is negative and none is larger than the sum of the other two. For the principal axes this condition is also
sufficient (Wittenburg, Dynamics of Multibody Systems, 2nd ed., 2008, section 3.1).
"""

from __future__ import annotations

import sys
from typing import Any

import sympy

from ..errors import MassError
from ..scalar.algebra import Matrix, Scalar, Vector
from .entries import is_symbolic, text, value_of

# Round-off of a product of three matrices, in units of the largest entry.
TOLERANCE = 32 * sys.float_info.epsilon

_AXES = "xyz"
_CURE = "Check the unit, the order of the axes, and that the inertia is about the mass centre."


def symmetric(A: Matrix) -> Matrix:
    """Return the matrix with its upper triangle mirrored; raise MassError if it is not symmetric."""
    bound = _bound(A)
    for i, j in ((0, 1), (0, 2), (1, 2)):
        difference = A[i][j] - A[j][i]
        if is_symbolic(difference):
            difference = sympy.cancel(difference)
        value = value_of(difference)
        if value is None or abs(value) > bound:
            by = "" if value is None else f", a difference of {text(abs(value))}"
            raise MassError(
                f"Expected a symmetric inertia matrix, got {text(A[i][j])} at ({i + 1}, {j + 1}) and "
                f"{text(A[j][i])} at ({j + 1}, {i + 1}){by}. Give both entries minus the product of inertia."
            )
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = A
    return ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))


def check_mass(mass: Scalar) -> None:
    """Refuse a mass below zero. Inertia without mass is allowed: a flywheel whose mass is counted elsewhere."""
    value = value_of(mass)
    if value is None:
        if not getattr(mass, "free_symbols", None):
            raise MassError(f"Expected a mass that is a real number, got {mass}.")
        return
    if value < 0:
        raise MassError(f"Expected a mass that is not negative, got {text(mass)} kg. Check its sign.")


def check_inertia(A: Matrix) -> None:
    """Refuse moments that no body can have, as far as the entries are numbers."""
    bound = _bound(A)
    diagonal = (A[0][0], A[1][1], A[2][2])
    for i, moment in enumerate(diagonal):
        value = value_of(moment)
        if value is not None and value < -bound:
            raise MassError(
                f"Expected moments of inertia that are not negative, got {text(moment)} about {_AXES[i]}. "
                + _CURE
            )
    _triangle(diagonal, "moments of inertia about x, y, z", bound)
    values = [[value_of(x) for x in row] for row in A]
    if any(x is None for row in values for x in row) or not (A[0][1] or A[0][2] or A[1][2]):
        return
    import numpy

    moments = [float(x) for x in numpy.linalg.eigvalsh(numpy.array(values, float))]
    if moments[0] < -bound:
        raise MassError(
            f"Expected principal moments of inertia that are not negative, got {_listed(moments)}. The "
            f"products of inertia are too large for the moments {_listed(diagonal)}: check their sign and "
            "their unit."
        )
    _triangle(tuple(moments), "principal moments of inertia", bound)


def _triangle(moments: Vector | tuple[float, ...], what: str, bound: Any) -> None:
    """Refuse moments of which one exceeds the sum of the others."""
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        a, b, c = moments[i], moments[j], moments[k]
        excess: Any = a - b - c
        if is_symbolic(excess):
            terms = sympy.Add.make_args(excess)
            if excess.free_symbols and all(term.as_coeff_Mul()[1].is_Atom for term in terms):
                continue  # a sum of symbols is no number
            excess = sympy.cancel(excess)
        value = value_of(excess)
        if value is not None and value > bound:
            if is_symbolic(a, b, c):
                reason = f"{text(a)} exceeds ({text(b)}) + ({text(c)}) by {text(excess)}"
            else:
                reason = f"no body has {text(a)} > {text(b)} + {text(c)}, too large by {text(excess)}"
            raise MassError(
                f"Expected {what} that satisfy the triangle inequality, got {_listed(moments)}: {reason}. "
                + _CURE
            )


def _bound(A: Matrix) -> float:
    """Round-off of the entries."""
    values = [value_of(x) for row in A for x in row]
    return TOLERANCE * max((float(abs(v)) for v in values if v is not None), default=0)


def _listed(values: Any) -> str:
    return "(" + ", ".join(map(text, values)) + ")"
