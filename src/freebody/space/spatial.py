"""Motion and force vectors, and the inertia that maps one to the other (6-D, angular part first).

A motion (w, v) is the angular velocity of a frame and the velocity of its origin. A force (n, f) is the
moment about the origin and the force. Both are pairs of vectors of any scalar type.

Source: Featherstone, Rigid Body Dynamics Algorithms (2008), chapter 2.
"""

from __future__ import annotations

from ..scalar.algebra import (
    IDENTITY,
    Matrix,
    Scalar,
    Vector,
    add,
    add_matrices,
    apply,
    apply_transpose,
    congruence,
    cross,
    dot,
    multiply,
    outer,
    scale,
    skew,
    subtract,
    subtract_matrices,
    transpose,
)

Spatial = tuple[Vector, Vector]
ZERO6: Spatial = ((0, 0, 0), (0, 0, 0))


def plus(a: Spatial, b: Spatial) -> Spatial:
    """a + b."""
    return (add(a[0], b[0]), add(a[1], b[1]))


def minus(a: Spatial, b: Spatial) -> Spatial:
    """a - b."""
    return (subtract(a[0], b[0]), subtract(a[1], b[1]))


def times(s: Scalar, a: Spatial) -> Spatial:
    """s a."""
    return (scale(s, a[0]), scale(s, a[1]))


def power(motion: Spatial, force: Spatial) -> Scalar:
    """Power of a force in a motion, w·n + v·f."""
    return dot(motion[0], force[0]) + dot(motion[1], force[1])


def motion_to_child(R_PC: Matrix, p_PC_P: Vector, V_P: Spatial) -> Spatial:
    """A motion, given at the parent's origin in parent axes, at the child's origin in child axes."""
    w, v = V_P
    return (apply_transpose(R_PC, w), apply_transpose(R_PC, add(v, cross(w, p_PC_P))))


def force_to_parent(R_PC: Matrix, p_PC_P: Vector, F_C: Spatial) -> Spatial:
    """A force, given at the child's origin in child axes, at the parent's origin in parent axes."""
    n, f = apply(R_PC, F_C[0]), apply(R_PC, F_C[1])
    return (add(n, cross(p_PC_P, f)), f)


def motion_cross(V: Spatial, S: Spatial) -> Spatial:
    """V × S: rate of a motion vector carried along with V (Featherstone 2.31)."""
    return (cross(V[0], S[0]), add(cross(V[0], S[1]), cross(V[1], S[0])))


def force_cross(V: Spatial, F: Spatial) -> Spatial:
    """V ×* F: rate of a force vector carried along with V (Featherstone 2.32)."""
    return (add(cross(V[0], F[0]), cross(V[1], F[1])), cross(V[0], F[1]))


Inertia = tuple[Scalar, Vector, Matrix]
"""Rigid inertia: mass m, first moment h = m c, moment of inertia about the origin."""


def rigid_inertia(mass: Scalar, center: Vector, inertia_C: Matrix) -> Inertia:
    """Inertia about the origin from the inertia about the mass centre: I_O = I_C + m (c·c 1 - c cᵀ)."""
    h = scale(mass, center)
    c2 = dot(center, h)
    steiner = subtract_matrices(tuple(scale(c2, row) for row in IDENTITY), outer(center, h))  # type: ignore[arg-type]
    return (mass, h, add_matrices(inertia_C, steiner))


def momentum_of(I_O: Inertia, V: Spatial) -> Spatial:
    """Angular momentum about the origin, and momentum: (I_O w + h × v, m v - h × w)."""
    m, h, J = I_O
    w, v = V
    return (add(apply(J, w), cross(h, v)), subtract(scale(m, v), cross(h, w)))


def inertia_sum(A: Inertia, B: Inertia) -> Inertia:
    """Inertia of two bodies welded together."""
    return (A[0] + B[0], add(A[1], B[1]), add_matrices(A[2], B[2]))


def inertia_to_parent(R_PC: Matrix, p_PC_P: Vector, I_C: Inertia) -> Inertia:
    """An inertia, given about the child's origin in child axes, about the parent's origin in parent axes.

    With h' = R h:  J' = R J Rᵀ + 2 p·h' 1 - p h'ᵀ - h' pᵀ + m (p·p 1 - p pᵀ).
    """
    m, h, J = I_C
    h_P = apply(R_PC, h)
    mp = scale(m, p_PC_P)
    p = p_PC_P
    total = add(h_P, mp)  # first moment about the parent's origin
    diagonal = dot(p, h_P) + dot(p, total)
    shift = add_matrices(outer(p, total), outer(h_P, p))
    spread: Matrix = ((diagonal, 0, 0), (0, diagonal, 0), (0, 0, diagonal))
    return (m, total, add_matrices(congruence(R_PC, J), subtract_matrices(spread, shift)))


Blocks = tuple[Matrix, Matrix, Matrix]
"""Symmetric 6 x 6 inertia of an articulated body: [[J, H], [Hᵀ, M]]."""


def blocks(I_O: Inertia) -> Blocks:
    """A rigid inertia as a symmetric 6 x 6 matrix: H = h×, M = m 1."""
    m, h, J = I_O
    return (J, skew(h), ((m, 0, 0), (0, m, 0), (0, 0, m)))


def blocks_times(A: Blocks, V: Spatial) -> Spatial:
    """A V."""
    J, H, M = A
    return (add(apply(J, V[0]), apply(H, V[1])), add(apply_transpose(H, V[0]), apply(M, V[1])))


def blocks_sum(A: Blocks, B: Blocks) -> Blocks:
    """A + B."""
    return (add_matrices(A[0], B[0]), add_matrices(A[1], B[1]), add_matrices(A[2], B[2]))


def blocks_less_outer(A: Blocks, U: Spatial, W: Spatial) -> Blocks:
    """A - U Wᵀ, where U Wᵀ is symmetric."""
    n, f = U
    a, b = W
    J = symmetric_difference(A[0], n, a)
    M = symmetric_difference(A[2], f, b)
    return (J, subtract_matrices(A[1], outer(n, b)), M)


def symmetric_difference(A: Matrix, x: Vector, y: Vector) -> Matrix:
    """A - x yᵀ for a symmetric result."""
    xx, xy, xz = A[0][0] - x[0] * y[0], A[0][1] - x[0] * y[1], A[0][2] - x[0] * y[2]
    yy, yz, zz = A[1][1] - x[1] * y[1], A[1][2] - x[1] * y[2], A[2][2] - x[2] * y[2]
    return ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))


def blocks_to_parent(R_PC: Matrix, p_PC_P: Vector, A: Blocks) -> Blocks:
    """X* A X: an articulated inertia, given in the child's frame, about the parent's origin in parent axes.

    With J, H, M turned into parent axes:  M' = M,  H' = H + p× M,  J' = J + p× Hᵀ - H' p×.
    """
    J, H, M = A
    M = congruence(R_PC, M)
    H = multiply(multiply(R_PC, H), transpose(R_PC))
    J = congruence(R_PC, J)
    if all(isinstance(x, int) and x == 0 for x in p_PC_P):
        return (J, H, M)
    P = skew(p_PC_P)
    H_P = add_matrices(H, multiply(P, M))
    T, Q = multiply(P, transpose(H)), multiply(H_P, P)
    xx, xy, xz = (J[0][k] + T[0][k] - Q[0][k] for k in range(3))
    yy, yz = (J[1][k] + T[1][k] - Q[1][k] for k in (1, 2))
    zz = J[2][2] + T[2][2] - Q[2][2]
    return (((xx, xy, xz), (xy, yy, yz), (xz, yz, zz)), H_P, M)
