"""Rotation matrices of a turn about an axis, for every scalar type.

    R(n, φ) = n nᵀ + cos φ (1 - n nᵀ) + sin φ [n]×          (Rodrigues)

Source: [Wittenburg2008, section 2.1].
"""

from __future__ import annotations

from ..scalar.algebra import (
    IDENTITY,
    Field,
    Matrix,
    Scalar,
    Vector,
    add,
    outer,
    scale,
    skew,
    subtract_matrices,
)


def matrix_about(axis: Vector, angle: Scalar, field: Field) -> Matrix:
    """R_NB of a body turned by ``angle`` [rad] about the unit vector ``axis``, 3 x 3.

    With an axis of plain integers, such as (0, 0, 1), the zeros and ones of the matrix are exact.
    """
    return matrix_from_sine(axis, field.sin(angle), field.cos(angle))


def matrix_from_sine(axis: Vector, sine: Scalar, cosine: Scalar) -> Matrix:
    """R_NB of a turn from the sine and cosine of its angle, 3 x 3."""
    along = outer(axis, axis)
    across = subtract_matrices(IDENTITY, along)
    turned = skew(axis)
    a, b, c = (add(along[i], add(scale(cosine, across[i]), scale(sine, turned[i]))) for i in range(3))
    return (a, b, c)
