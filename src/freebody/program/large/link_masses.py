"""Masses of the links as given motions need them: mass m, first moment h and second moment Σ = Σ dm ρ ρᵀ.

A motion with the acceleration a of a link's origin and the turning Ω = [α]× + [w]×² (the acceleration of the point at ρ
is a + Ω ρ) needs

    F = m a + Ω h,    N = h × a + axial(Ω Σ),    axial(B)_i = B_kj - B_jk    (i, j, k in turn)

about the origin. Masses on the axis of a hinge move alike with both of its bodies. Their m, h and Σ along the axis n,
which are m, h·n and n·Σn of the link, are counted to the parent, so that three numbers of the link vanish, as base
parameters of a robot do without them. The forces along the joints stay; the wrenches that joints transmit do not, so
reactions take the masses as they are.

Sources: M. Gautier, W. Khalil, Direct calculation of minimum set of inertial parameters of serial robots (1990);
J. Y. S. Luh, M. W. Walker, R. P. C. Paul, On-line computational scheme for mechanical manipulators (1980).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...dynamics.kinematics import turning
from ...model.model import GROUND, Link
from ...scalar.algebra import Matrix, Scalar, Vector, add, apply, apply_transpose, cross, scale
from ...space.spatial import Spatial

COUNT = 10
"""Numbers of a link: m, h (3), Σ (Σ_xx, Σ_xy, Σ_xz, Σ_yy, Σ_yz, Σ_zz)."""
UPPER = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))


def is_bare(links: Sequence[Link], i: int, axis: int) -> bool:
    """Return whether the masses on the axis of a link's joint are counted to its parent.

    Nothing is counted to a link without mass, whose step would grow more than this one's shrinks.
    """
    parent = links[i].parent
    heavy = parent == GROUND or links[parent].mass != 0 or links[parent].body is not None
    return links[i].turns_only and axis >= 0 and heavy


def counted(
    links: Sequence[Link], constants: Sequence[Sequence[float]], bare: Sequence[int]
) -> list[list[float]]:
    """Return the numbers of all links from their constants (`link_step.constants_of`).

    ``bare`` has the axis of the links whose masses on the axis are counted to the parent, and -1 for the others.
    """
    masses = []
    for c in constants:
        center, J = np.array(c[17:20]), np.array(c[20:29]).reshape(3, 3)
        second = np.trace(J) / 2 * np.eye(3) - J + c[16] * np.outer(center, center)
        masses.append([c[16], c[16] * center, second])
    for i in range(len(links) - 1, -1, -1):
        k = bare[i]
        if k < 0:
            continue
        m, h, second = masses[i]
        along, twice = h[k], second[k, k]
        if links[i].parent != GROUND:
            r, n = np.array(constants[i][9:12]), np.array(constants[i][0:9]).reshape(3, 3)[:, k]
            parent, across = masses[links[i].parent], along * np.outer(r, n)
            parent[0] += m
            parent[1] = parent[1] + m * r + along * n
            parent[2] = parent[2] + m * np.outer(r, r) + across + across.T + twice * np.outer(n, n)
        masses[i][0] = h[k] = second[k, k] = 0.0
    return [[m, *h, *(second[j, k] for j, k in UPPER)] for m, h, second in masses]


def of(numbers: Sequence[Scalar], bare: int) -> tuple[Scalar, Vector, Matrix]:
    """Return m, h and Σ of a link, with the zeros of a link whose masses on the axis ``bare`` are the parent's."""
    x = [*numbers]
    if bare >= 0:
        for k in (0, 1 + bare, 4 + UPPER.index((bare, bare))):
            x[k] = 0
    return x[0], (x[1], x[2], x[3]), ((x[4], x[5], x[6]), (x[5], x[7], x[8]), (x[6], x[8], x[9]))


def needed(mass: tuple[Scalar, Vector, Matrix], B: Matrix, a: Vector) -> Spatial:
    """Return the wrench (N, F) that a motion needs; B is the turning."""
    m, h, second = mass
    axial: list[Scalar] = []
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        x = B[k][i] * second[i][j] - B[j][i] * second[i][k]
        x = x + B[k][j] * second[j][j] - B[j][k] * second[k][k]
        axial.append(x + (B[k][k] - B[j][j]) * second[j][k])
    return (add((axial[0], axial[1], axial[2]), cross(h, a)), add(scale(m, a), apply(B, h)))


def accelerated(
    R: Matrix, r: Vector, vJ: Spatial, rate: Spatial, above: tuple[Vector, Vector, Vector, Matrix]
) -> tuple[Vector, Vector, Vector, Matrix]:
    """Return α, a of the origin, w and the turning of a link, in its axes, from those of its parent.

    R, r are pose and vJ the motion of the joint; ``rate`` is the derivative of vJ at fixed directions in the link.
    """
    alpha_P, a_P, w_P, B_P = above
    turn, shift = vJ
    w_in = apply_transpose(R, w_P)
    w = add(w_in, turn)
    alpha = add(add(apply_transpose(R, alpha_P), cross(w_in, turn)), rate[0])
    a = add(apply_transpose(R, add(a_P, apply(B_P, r))), add(cross(add(w_in, w), shift), rate[1]))
    return (alpha, a, w, turning(w, alpha))
