"""Sweep and prune: pairs of members whose bounds along the ground axes overlap.

Bounded members are sorted by their lower bounds along the axis of their greatest spread; the order of the last time is
the first guess. Members without bounds (planes, walls, hollows, sides) are near to every other one.

Source: J. D. Cohen, M. C. Lin, D. Manocha, M. K. Ponamgi, I-COLLIDE, Proc. Symp. Interactive 3D Graphics (1995).
"""

from __future__ import annotations

from ...native.instructions import Reals, compiled, greater, lesser, root
from .family_record import BALL, DRUM, EDGE, OVAL, POSE, SOLID, Families, Members
from .patches import keep_core, lay_core


@compiled
def place(pose: Reals, at: Reals, result: Reals) -> None:
    """Set the place in ground axes of a place in a link."""
    for i in range(3):
        result[i] = pose[9 + i] + pose[3 * i] * at[0] + pose[3 * i + 1] * at[1] + pose[3 * i + 2] * at[2]


@compiled
def bounds(of: Families, margin: float) -> None:
    """Set the bounds of all bounded members, with a margin between two of them."""
    members, poses = of.members, of.links.poses
    for b in range(members.bounded):
        k = members.order[b]
        pose, sizes = poses[POSE * members.link[k] :], members.sizes[members.sizes_at[k] :]
        lower, upper, kind = members.lower[k], members.upper[k], members.bound[k]
        if kind == SOLID:
            lay_core(of, of.one, k)
            keep_core(of, of.one, k)
            for i in range(3):
                lower[i], upper[i] = of.one.corners[i], of.one.corners[i]
                for v in range(of.one.count):
                    lower[i] = lesser(lower[i], of.one.corners[3 * v + i])
                    upper[i] = greater(upper[i], of.one.corners[3 * v + i])
                lower[i] -= of.one.radius + 0.5 * margin
                upper[i] += of.one.radius + 0.5 * margin
        else:
            place(pose, sizes, lower)
            extend(members, k, pose, sizes, margin)


@compiled
def extend(members: Members, k: int, pose: Reals, sizes: Reals, margin: float) -> None:
    """Set the bounds of a member that is no solid, whose middle is in ``lower``."""
    lower, upper, kind = members.lower[k], members.upper[k], members.bound[k]
    for i in range(3):
        R, extent = pose[3 * i :], 0.0
        if kind == BALL:
            extent = sizes[3]
        elif kind == EDGE or kind == DRUM:  # noqa: SIM109
            along = R[0] * sizes[3] + R[1] * sizes[4] + R[2] * sizes[5]
            extent = sizes[6] * root(greater(1.0 - along * along, 0.0))
            if kind == DRUM:
                extent += 0.5 * sizes[7] * abs(along)
        elif kind == OVAL:
            x, y, z = R[0] * sizes[3], R[1] * sizes[4], R[2] * sizes[5]
            extent = root(x * x + y * y + z * z)
        upper[i] = lower[i] + extent + 0.5 * margin
        lower[i] -= extent + 0.5 * margin


@compiled
def choose_axis(members: Members) -> None:
    """Set the axis along which the middles of the bounded members vary most."""
    best = -1.0
    for i in range(3):
        total, square = 0.0, 0.0
        for b in range(members.bounded):
            k = members.order[b]
            x = members.lower[k, i] + members.upper[k, i]
            total += x
            square += x * x
        spread = square - total * total / members.bounded
        if spread > best:
            best, members.axis = spread, i


@compiled
def sort(members: Members) -> None:
    """Sort the bounded members by their lower bounds, from the order of the last time."""
    order, axis = members.order, members.axis
    for b in range(1, members.bounded):
        k, a = order[b], b
        x = members.lower[k, axis]
        while a > 0 and members.lower[order[a - 1], axis] > x:
            order[a] = order[a - 1]
            a -= 1
        order[a] = k


@compiled
def overlap(members: Members, i: int, j: int) -> int:
    """Return 1 if the bounds of two members overlap along the two axes that are not sorted."""
    for k in range(3):
        if k != members.axis and (
            members.lower[i, k] > members.upper[j, k] or members.lower[j, k] > members.upper[i, k]
        ):
            return 0
    return 1
