"""The twelve sequences of Euler angles, always body-fixed (intrinsic), in capitals: "ZXZ", "XYZ", ...

    R_NB = R_i(α) R_j(β) R_k(γ)
    w_NB = α̇ e_i + β̇ e_j' + γ̇ e_k''                each axis as turned by the turns before it

In the axes between the second and the third turn, the map from rates to angular velocity is triangular. Its
inverse therefore needs one division: by sin β if k = i, by cos β if i, j, k differ. The sequence is singular where
this divisor vanishes. The functions above "floats only" accept every scalar type.

Source: [Wittenburg2008, section 2.1].
"""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from typing import Any, NamedTuple

from ..errors import ModelError, shown
from ..scalar.algebra import (
    Field,
    Matrix,
    Scalar,
    Vector,
    apply,
    apply_transpose,
    cross,
    dot,
    multiply,
    transpose,
)
from .entries import AXES
from .turn import matrix_about

SEQUENCES = ("XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX", "XYX", "XZX", "YXY", "YZY", "ZXZ", "ZYZ")

Angles = Sequence[Scalar]


class Singularity(NamedTuple):
    """Singularity of a sequence: index of the ``angle``, ``function`` of it that vanishes, its value ``measure``."""

    angle: int
    function: str
    measure: Scalar


def euler_axes(sequence: str) -> tuple[Vector, Vector, Vector]:
    """The three unit vectors of a sequence, each in the axes just before its turn.

    Raises
    ------
    ModelError
        For a sequence that is none of the twelve; for lower case the message gives the cure.
    """
    if not isinstance(sequence, str) or sequence not in SEQUENCES:
        raise ModelError(_refused(sequence))
    i, j, k = (AXES[letter] for letter in sequence.lower())
    return (i, j, k)


def matrix_from_euler(sequence: str, angles: Angles, field: Field) -> Matrix:
    """R_NB = R_i(α) R_j(β) R_k(γ), 3 x 3, of three angles [rad]."""
    axes = euler_axes(sequence)
    first, second, third = (matrix_about(n, angle, field) for n, angle in zip(axes, angles, strict=True))
    return multiply(multiply(first, second), third)


def euler_rate_map(sequence: str, angles: Angles, field: Field, axes: str = "child") -> Matrix:
    """J, 3 x 3, with w = J (α̇, β̇, γ̇): angle rates to angular velocity [rad/s].

    ``axes`` are the axes of the components of w: ``"child"`` (body axes) or ``"parent"``.
    """
    i, j, k = euler_axes(sequence)
    alpha, beta, gamma = angles
    second = matrix_about(j, beta, field)
    if _in_child(axes):
        third = matrix_about(k, gamma, field)
        columns = (apply_transpose(third, apply_transpose(second, i)), apply_transpose(third, j), k)
    else:
        first = matrix_about(i, alpha, field)
        columns = (i, apply(first, j), apply(first, apply(second, k)))
    return transpose(columns)


def euler_rates(sequence: str, angles: Angles, w: Vector, field: Field, axes: str = "child") -> Vector:
    """(α̇, β̇, γ̇) of an angular velocity w, components in ``"child"`` or ``"parent"`` axes [rad/s].

    Divides by the measure of :func:`euler_singularity`.
    """
    i, j, k = euler_axes(sequence)
    alpha, beta, gamma = angles
    s, c = field.sin(beta), field.cos(beta)
    m = cross(i, j)
    handed = dot(m, k)  # 0 where k = i, else +1 or -1: m = handed * k
    # in the axes between the turns: R_jᵀ i = c i + s m (components of w in the child), R_j k (in the parent)
    if _in_child(axes):
        v = apply(matrix_about(k, gamma, field), w)
        outer_axis, inner_axis, sign = i, k, 1
    else:
        v = apply_transpose(matrix_about(i, alpha, field), w)
        outer_axis, inner_axis, sign = k, i, -1
    if handed == 0:
        outer = sign * dot(v, m) / s
        inner = dot(v, inner_axis) - c * outer
    else:
        outer = dot(v, outer_axis) / c
        inner = dot(v, inner_axis) - handed * s * outer
    middle = dot(v, j)
    return (outer, middle, inner) if sign == 1 else (inner, middle, outer)


def euler_rate_map_inverse(sequence: str, angles: Angles, field: Field, axes: str = "child") -> Matrix:
    """J⁻¹, 3 x 3: angular velocity to angle rates, in closed form; see :func:`euler_rates`."""
    columns = tuple(euler_rates(sequence, angles, unit, field, axes) for unit in AXES.values())
    return transpose(columns)  # type: ignore[arg-type]


def euler_singularity(sequence: str, angles: Angles, field: Field) -> Singularity:
    """The sine or cosine of the second angle, which vanishes where the rate map has no inverse."""
    i, _, k = euler_axes(sequence)
    function = "sin" if i == k else "cos"
    return Singularity(1, function, field.apply(function, angles[1]))


# --- floats only ------------------------------------------------------------------------------

# Below this measure the first and the third axis are parallel within round-off.
PARALLEL = 16 * sys.float_info.epsilon


def euler_from_matrix(sequence: str, R: Sequence[Sequence[Any]]) -> tuple[float, float, float]:
    """The three angles [rad] of a rotation matrix of floats.

    The second angle is in [0, π] for sequences such as ZXZ and in [-π/2, π/2] for sequences such as XYZ, the
    other two are in [-π, π]. At the singularity, where only their sum or difference is defined, the *third is
    zero* and the first is the whole turn.
    """
    i, j, k = ("XYZ".index(letter) for letter in _checked(sequence))
    n = 3 - i - j  # the axis e_i × e_j = e e_n
    e = 1 if (j - i) % 3 == 1 else -1
    r = [[float(x) for x in row] for row in R]
    if k == i:
        measure = math.hypot(r[i][j], r[i][n])
        beta = math.atan2(measure, r[i][i])
        alpha = math.atan2(r[j][i], -e * r[n][i])
    else:
        measure = math.hypot(r[i][i], r[i][j])
        beta = math.atan2(e * r[i][n], measure)
        alpha = math.atan2(-e * r[j][n], r[n][n])
    if measure <= PARALLEL:
        return (math.atan2(e * r[n][j], r[j][j]), beta, float(0))
    # the third angle from the rotation that remains after the first: it compensates the round-off of the first,
    # so that the angles reproduce the matrix within round-off close to the singularity too
    ca, sa = math.cos(alpha), math.sin(alpha)
    cosine = ca * r[j][j] + sa * e * r[n][j]
    if k == i:
        return (alpha, beta, math.atan2(-(ca * e * r[j][n] + sa * r[n][n]), cosine))
    return (alpha, beta, e * math.atan2(ca * r[j][i] + sa * e * r[n][i], cosine))


def _checked(sequence: str) -> str:
    euler_axes(sequence)
    return sequence


def _in_child(axes: str) -> bool:
    if axes not in ("child", "parent"):
        raise ModelError(f"Expected axes 'child' or 'parent' for the angular velocity, got {shown(axes)}.")
    return axes == "child"


def _refused(sequence: Any) -> str:
    """Message about a sequence that is none of the twelve."""
    if isinstance(sequence, str) and sequence.upper() in SEQUENCES:
        return (
            f"Expected a body-fixed (intrinsic) sequence in capitals, got '{sequence}': lower case is "
            f"SciPy's space-fixed sequence. The same rotation is '{sequence[::-1].upper()}' with the angles "
            f"in reverse order; for body-fixed angles write '{sequence.upper()}'."
        )
    return f"Expected one of the 12 sequences {', '.join(SEQUENCES)}, got {shown(sequence)}."
