"""Unit quaternions, scalar first, q = (w, x, y, z) with R_NB.

    q = (cos φ/2, n sin φ/2)                       axis n, angle φ
    R_NB = 1 + 2 w [v]× + 2 [v]× [v]×              v = (x, y, z)
    q̇ = ½ q ∘ (0, ω) = ½ E(q) ω                   ω = w_NB_B, in body axes

The functions above "floats only" accept every scalar type.

Sources: [Wittenburg2008, section 2.1]; [Shuster1993].
"""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from typing import Any

from ..scalar.algebra import HALF, Field, Matrix, Scalar, Vector

Quaternion = tuple[Scalar, Scalar, Scalar, Scalar]


def quaternion_product(p: Quaternion, q: Quaternion) -> Quaternion:
    """p ∘ q: the rotation q followed by the rotation p, as the product of matrices R(p) R(q)."""
    a, b, c, d = p
    w, x, y, z = q
    return (
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    )


def quaternion_conjugate(q: Quaternion) -> Quaternion:
    """The quaternion of the inverse rotation."""
    return (q[0], -q[1], -q[2], -q[3])


def matrix_from_quaternion(q: Quaternion) -> Matrix:
    """R_NB of a unit quaternion, 3 x 3: components in B to components in N."""
    w, x, y, z = q
    x2, y2, z2 = 2 * x, 2 * y, 2 * z
    xx, yy, zz = x2 * x, y2 * y, z2 * z
    xy, xz, yz = x2 * y, x2 * z, y2 * z
    wx, wy, wz = w * x2, w * y2, w * z2
    return (
        (1 - (yy + zz), xy - wz, xz + wy),
        (xy + wz, 1 - (xx + zz), yz - wx),
        (xz - wy, yz + wx, 1 - (xx + yy)),
    )


def quaternion_from_axis_angle(axis: Vector, angle: Scalar, field: Field) -> Quaternion:
    """Unit quaternion of a turn by ``angle`` [rad] about the unit vector ``axis``."""
    half = HALF * angle
    s = field.sin(half)
    return (field.cos(half), s * axis[0], s * axis[1], s * axis[2])


def quaternion_rate(q: Quaternion, w_body: Vector) -> Quaternion:
    """q̇ = ½ E(q) ω of the angular velocity of the child in the parent, components in *child* axes [rad/s]."""
    w, x, y, z = q
    a, b, c = HALF * w_body[0], HALF * w_body[1], HALF * w_body[2]
    return (
        -(x * a) - y * b - z * c,
        w * a + y * c - z * b,
        w * b + z * a - x * c,
        w * c + x * b - y * a,
    )


def quaternion_rate_map(q: Quaternion) -> tuple[Vector, Vector, Vector, Vector]:
    """½ E(q), 4 x 3: angular velocity in child axes [rad/s] to q̇; never singular, inverted by 2 Eᵀ."""
    w, x, y, z = (HALF * c for c in q)
    return ((-x, -y, -z), (w, -z, y), (z, w, -x), (-y, x, w))


def angular_velocity_from_quaternion_rate(q: Quaternion, rate: Quaternion) -> Vector:
    """ω = 2 Eᵀ q̇, in child axes [rad/s]."""
    w, x, y, z = (2 * c for c in q)
    return (
        -(x * rate[0]) + w * rate[1] + z * rate[2] - y * rate[3],
        -(y * rate[0]) - z * rate[1] + w * rate[2] + x * rate[3],
        -(z * rate[0]) + y * rate[1] - x * rate[2] + w * rate[3],
    )


# --- floats only ------------------------------------------------------------------------------


def quaternion_from_matrix(R: Sequence[Sequence[Any]]) -> tuple[float, float, float, float]:
    """The unit quaternion of a rotation matrix of floats; its first nonzero component is positive.

    The largest of the four components is computed first, so that there is no division by a small number
    (Shepperd, J. Guidance and Control 1 (1978) 223-224).
    """
    (a, b, c), (d, e, f), (g, h, i) = ((float(x) for x in row) for row in R)
    trace = a + e + i
    squares = (trace, a, e, i)  # 4 w² - 1, and the same for x, y, z up to a common term
    k = max(range(4), key=squares.__getitem__)
    if k == 0:
        q = (1 + trace, h - f, c - g, d - b)
    elif k == 1:
        q = (h - f, 1 + a - e - i, b + d, c + g)
    elif k == 2:
        q = (c - g, b + d, 1 - a + e - i, f + h)
    else:
        q = (d - b, c + g, f + h, 1 - a - e + i)
    return _canonical(q)


def axis_angle_from_quaternion(q: Sequence[Any]) -> tuple[tuple[float, float, float], float]:
    """Unit axis, and angle in [0, π], of a unit quaternion of floats; (1, 0, 0) and 0 for the identity."""
    w, x, y, z = _canonical(tuple(float(c) for c in q))
    s = math.hypot(x, y, z)
    if s <= sys.float_info.min:
        return (float(1), float(0), float(0)), float(0)
    return (x / s, y / s, z / s), 2 * math.atan2(s, abs(w))  # w < 0 is round-off


def _canonical(q: Sequence[float]) -> tuple[float, float, float, float]:
    """q or -q with unit length, such that the first component beyond round-off is positive."""
    n = math.hypot(*q)
    first = next(c for c in q if abs(c) > 2 * sys.float_info.epsilon * n)
    w, x, y, z = (c / math.copysign(n, first) for c in q)
    return (w, x, y, z)
