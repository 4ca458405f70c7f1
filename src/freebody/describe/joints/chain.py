"""Joints that are chains of primitive motions: ``s.chain``, with an anchor for each motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from ...errors import ModelError, shown
from ...scalar.algebra import Vector, apply, cross, subtract
from ...scalar.expression import exact
from ..axes import direction, orientation
from ..description import Description, varying, vector
from ..frame import Frame, closes_loop, own_body
from .ball import Ball
from .joining import Ends, add_joint, components_of, own_coordinates, place_on, whole
from .joint import Joint
from .primitive import Primitive
from .rotor import constant, own_rotor


@whole
def chain(
    system: Description, name: str, parent: Frame, child: Frame, motions: Sequence[Primitive], *, at: Any = None,
    to: Any = None, parent_axes: Any = None, child_axes: Any = None,
) -> Joint:  # fmt: skip
    """Add a joint that is a chain of primitive motions, from the parent to the child, without bodies between them.

    With all coordinates zero the joint's points and axes on both bodies coincide, and the anchors stand where they are
    given. Each motion then carries the anchors and axes of the later ones with it, and the child.

    Parameters
    ----------
    name : str
    parent, child : Frame
    motions : sequence of Hinge, Slider, Screw or Ball
        Such as ``[fb.Hinge("x", "roll"), fb.Hinge("y", "pitch", at=(0, 0, L))]``: the axis in joint axes, the
        coordinate (by default NAME_1, NAME_2, …), the anchor ``at`` from the joint's point in joint axes.
    at, to, parent_axes, child_axes : optional
        As for :meth:`hinge`.

    Raises
    ------
    ModelError
        No motions or a joint of another sort among them; two motions that are the same; a chain that closes a loop.

    Examples
    --------
    A hip and a knee in one joint, as robots have them:

    >>> import freebody as fb
    >>> s = fb.System("leg")
    >>> foot = s.body("foot", fb.particle(1))
    >>> s.chain("leg", s.ground, foot, [fb.Hinge("z", "hip"), fb.Hinge("z", "knee", at=(0, -1, 0))], to=(0, 2, 0))
    chain 'leg' (ground -> foot)
    >>> print(fb.equations(s).text())
    2*(1 + cos(knee))*hip'' + (1 + cos(knee))*knee'' - 2*hip'*knee'*sin(knee) - knee'^2*sin(knee) = 0
    (1 + cos(knee))*hip'' + knee'' + hip'^2*sin(knee) = 0
    """
    what = f"chain '{name}'"
    if closes_loop(system, child):
        raise ModelError(
            f"Chain '{name}' closes a loop, which joints of this type cannot. Open the loop elsewhere: declare this "
            f"joint before the one that closes it."
        )
    given = _checked(motions, what)
    named = [_default(motion, name, k, len(given)) for k, motion in enumerate(given, start=1)]
    resolved = [_resolved(system, motion, name, k) for k, motion in enumerate(named, start=1)]
    _check_different(resolved, what)
    place = place_on(system, at, own_body(system, parent, what), f"at= of {what}")
    point = place_on(system, to, own_body(system, child, what), f"to= of {what}")
    first = _moved(place, orientation(system, parent_axes, f"parent_axes= of {what}"), resolved[0].at)
    last = _moved(point, orientation(system, child_axes, f"child_axes= of {what}"), resolved[-1].at)
    ends = Ends(parent, child, first, last, parent_axes, child_axes)
    return add_joint(system, "chain", name, ends, resolved, {"at": place, "to": point})


def _checked(motions: Any, what: str) -> list[Primitive]:
    """The motions as a list of primitives that a chain may have."""
    such_as = 'such as [fb.Hinge("x"), fb.Hinge("y", at=(0, 0, 1))]'
    if isinstance(motions, str | Primitive) or not hasattr(motions, "__iter__"):
        raise ModelError(f"Expected a list of motions for {what}, {such_as}, got {shown(motions)}.")
    result = list(motions)
    if not result:
        raise ModelError(f"Expected at least one motion for {what}, {such_as}. Without motion it is s.weld.")
    for motion in result:
        if not isinstance(motion, Primitive) or not (motion.displaces or isinstance(motion, Ball)):
            raise ModelError(
                f"Expected fb.Hinge, fb.Slider, fb.Screw or fb.Ball in {what}, got {shown(motion)}."
            )
    if sum(isinstance(motion, Ball) for motion in result) and any(
        motion.turns and not isinstance(motion, Ball) for motion in result
    ):
        raise ModelError(
            f"{what[0].upper()}{what[1:]} has a ball, which makes every turn. Leave out its other turns."
        )
    return result


def _default(motion: Primitive, name: str, k: int, count: int) -> Primitive:
    """The motion with a coordinate."""
    own = name if count == 1 else f"{name}_{k}"
    return motion if motion.coordinate is not None else replace(motion, coordinate=own)


def _resolved(system: Description, motion: Primitive, name: str, k: int) -> Primitive:
    """The motion in the system's own terms."""
    what = f"motion {k} of chain '{name}'"
    at = vector(system, (0, 0, 0) if motion.at is None else motion.at, f"the anchor of {what}")
    for component in at:
        moving = varying(system, component)
        if moving:
            raise ModelError(
                f"The anchor of {what} is fixed in the joint and cannot depend on {', '.join(moving)}."
            )
    if not motion.displaces:
        return _ball(system, replace(motion, at=at), what)
    (displacement,) = own_coordinates(system, None, name, motion.coordinate, [name])
    armature = () if motion.armature in ((), 0, None) else (
        constant(system, motion.armature, f"the armature of {what}"),
    )  # fmt: skip
    result = replace(
        motion, axis=direction(system, motion.axis, f"the axis of {what}"), coordinate=displacement, at=at,
        armature=armature,
    )  # fmt: skip
    if motion.pitch != 0:
        result = replace(result, pitch=constant(system, motion.pitch, f"the pitch of {what}", any_sign=True))
    if motion.rotor is not None:
        if k > 1:
            raise ModelError(
                f"The rotor of {what} would stand on the motion before it, which has no body. Put it on the first "
                f"motion, or give the joint a body there."
            )
        result = replace(result, rotor=own_rotor(system, what, motion.rotor, [result]))
    return result


def _ball(system: Description, motion: Primitive, what: str) -> Primitive:
    """The ball with coordinates of its own."""
    if motion.armature not in ((), 0, None) or motion.rotor is not None:
        raise ModelError(
            f"The ball in {what} takes no armature= or rotor=. Make the joint by s.ball, or by hinges."
        )
    q = components_of(system, motion.coordinate, ["e0", "e1", "e2", "e3"], "coordinate")
    components_of(system, motion.coordinate, ["wx", "wy", "wz"], "speed")
    return replace(motion, coordinate=tuple(q))


def _moved(place: Vector, axes: Any, anchor: Vector) -> Vector:
    x, y, z = (exact(a + b) for a, b in zip(place, apply(axes, anchor), strict=True))
    return (x, y, z)


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


def _check_different(motions: Sequence[Primitive], what: str) -> None:
    """Refuse more motions than a body has, and neighbours that are the same motion."""
    heads = parallel_turns(motions)
    turns = sum(
        (1 if motion.displaces else 3)
        for k, motion in enumerate(motions)
        if motion.turns and heads[k][0] == k
    )
    slides = sum(not motion.turns for motion in motions) + sum(heads[k][0] != k for k in range(len(motions)))
    if turns > 3 or slides > 3:
        raise ModelError(
            f"{what[0].upper()}{what[1:]} has {turns} turns about different axes and {slides} displacements beside "
            f"them; a body has at most three of each. Leave some out."
        )
    for k in range(1, len(motions)):
        a, b = motions[k - 1], motions[k]
        same = type(a) is type(b) and b.axis in (a.axis, tuple(-x for x in a.axis))
        if same and (not b.turns or _along(b.at, a.at, a.axis)):
            raise ModelError(
                f"Motions {k} and {k + 1} of {what} are the same {b.kind}, so their coordinates cannot be told apart. "
                f"Leave one out, or give it another anchor."
            )


def _along(a: Vector, b: Vector, axis: Vector) -> bool:
    """True if two anchors stand on one line along the axis."""
    return all(exact(x) == 0 for x in cross(subtract(a, b), axis))
