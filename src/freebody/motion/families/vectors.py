"""Vectors in space, and their components in the axes of a link: the columns of a matrix R, stored row by row."""

from __future__ import annotations

from ...native.instructions import Reals, inlined


@inlined
def along(n: Reals, x: Reals) -> float:
    """Return n·x."""
    return n[0] * x[0] + n[1] * x[1] + n[2] * x[2]


@inlined
def vector(p: Reals, q: Reals) -> tuple[float, float, float]:
    """Return the vector from p to q."""
    return q[0] - p[0], q[1] - p[1], q[2] - p[2]


@inlined
def cross(x: float, y: float, z: float, u: float, v: float, w: float) -> tuple[float, float, float]:
    """Return (x, y, z) × (u, v, w)."""
    return y * w - z * v, z * u - x * w, x * v - y * u


@inlined
def from_axes(R: Reals, i: int, x: float, y: float, z: float) -> float:
    """Return component i of R (x, y, z), which is in ground axes."""
    return R[3 * i] * x + R[3 * i + 1] * y + R[3 * i + 2] * z


@inlined
def in_axes(R: Reals, i: int, x: float, y: float, z: float) -> float:
    """Return component i of Rᵀ (x, y, z), which is in the axes of the link."""
    return R[i] * x + R[3 + i] * y + R[6 + i] * z
