"""What the motions of a joint leave free between its two bodies: the joint as a kinematic pair.

Closed loops, drawings and files ask the pair, and compare no names of joints: a further kind of joint is one class.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ...scalar.algebra import ZERO, Vector, cross, dot, subtract
from ...scalar.expression import exact
from .primitive import Primitive


@dataclass(frozen=True)
class Pair:
    """A kinematic pair.

    Attributes
    ----------
    turns, slides : int
        Numbers of independent turns and displacements. Turns about parallel axes are one turn, and their differences
        displace; the turn of a screw displaces too, and counts as both.
    threaded : bool
        True if a turn and a displacement are one motion, as in a screw.
    path : bool
        True if the displacements are functions of the joint's own coordinates, which make one motion.
    anchored : bool
        True if the axes of the motions do not tell what the joint transmits: turns about different points,
        displacements after turns, or displacements that are not at right angles.
    """

    turns: int = 0
    slides: int = 0
    threaded: bool = False
    path: bool = False
    anchored: bool = False

    @property
    def holds(self) -> bool:
        """True if the joint holds a point of the child on a point, a line or a curve of the parent."""
        return self.anchored or self.slides < 2

    @property
    def free(self) -> bool:
        """True if the joint transmits nothing."""
        return self.turns == 3 and self.slides == 3

    @property
    def spherical(self) -> bool:
        """True if the child turns about a point, and about more than one axis."""
        return self.turns > 1 and self.slides == 0 and not self.anchored

    @property
    def revolute(self) -> bool:
        """True if the child turns about one axis, and does nothing else."""
        return self.turns == 1 and self.slides == 0 and not self.anchored

    @property
    def prismatic(self) -> bool:
        """True if the child is displaced along one axis, and does nothing else."""
        return self.turns == 0 and self.slides == 1 and not self.anchored

    @property
    def guided(self) -> bool:
        """True if a point of the child stays on a straight guide of the parent."""
        return self.slides == 1 and not (self.anchored or self.threaded)

    @property
    def planar(self) -> bool:
        """True if a point of the child stays in a plane of the parent."""
        return self.slides == 2 and not self.anchored

    @property
    def rigid(self) -> bool:
        """True if there is no motion."""
        return self.turns == 0 and self.slides == 0

    @property
    def closes(self) -> bool:
        """True if the conditions of a closed loop can be those of this joint."""
        return not (self.anchored or self.slides > 2)


def pair_of(motions: Sequence[Primitive], path: bool = False) -> Pair:
    """Return the pair that a chain of motions makes."""
    heads = parallel_turns(motions)
    turns = slides = 0
    for k, motion in enumerate(motions):
        if motion.turns and heads[k][0] == k:
            turns += 1 if motion.displaces else motion.n_speeds if not motion.slides else 3
        if motion.slides:
            slides += 1 if motion.displaces else 3
        elif motion.turns and heads[k][0] != k:
            slides += 1
    turns, slides = min(turns, 3), slides + max(turns - 3, 0)  # beside a ball, turns displace its point
    threaded = any(motion.displaces and motion.turns and motion.slides for motion in motions)
    return Pair(turns, slides, threaded, path, path or _anchored(motions, heads))


def _anchored(motions: Sequence[Primitive], heads: Sequence[tuple[int, int]]) -> bool:
    """True if a motion does not carry the joint's point along its axis only."""
    anchors = {motion.at or ZERO for motion in motions}
    turned = False
    slides: list[Vector] = []
    for motion in motions:
        if motion.slides and (turned or any(exact(dot(motion.axis, axis)) != 0 for axis in slides)):
            return True
        turned = turned or motion.turns
        slides += [motion.axis] if motion.slides and not motion.turns else []
    return len(anchors) > 1 or any(first != k for k, (first, _) in enumerate(heads))


def parallel_turns(motions: Sequence[Primitive]) -> tuple[tuple[int, int], ...]:
    """Return for each motion (first, sign): the first of the turns about parallel axes that it continues, in the
    same or the opposite sense; itself if it begins them or does not turn.

    The axes of turns stay parallel if no other turn stands between them.
    """
    result: list[tuple[int, int]] = []
    head = -1
    for k, motion in enumerate(motions):
        result.append((k, 1))
        if not motion.turns:
            continue
        if head >= 0 and motion.displaces and motions[head].displaces:
            sign = next((s for s in (1, -1) if motion.axis == tuple(s * x for x in motions[head].axis)), 0)
            if sign:
                result[k] = (head, sign)
                continue
        head = k
    return tuple(result)


def along(a: Vector, b: Vector, axis: Vector) -> bool:
    """Return True if two anchors stand on one line along the axis."""
    return all(exact(x) == 0 for x in cross(subtract(a, b), axis))
