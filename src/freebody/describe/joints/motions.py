"""The motions of a joint in the terms of its system: axes of unit length, anchors, coordinates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from ...errors import ModelError, shown
from ...scalar.algebra import ZERO, Vector
from ..axes import direction
from ..description import Description, varying, vector
from ..frame import closes_loop
from ..part import answer
from .joining import components_of, displacement, own_coordinates, refuse_coordinate
from .pair import along, parallel_turns
from .primitive import Primitive
from .rotor import constant, own_rotor

SUCH_AS = 'such as [fb.Hinge("x"), fb.Hinge("y", at=(0, 0, 1))]'


def resolved(system: Description, joint: Any) -> tuple[list[Primitive], Any]:
    """Return the motions of a joint, and its ``coordinate=`` as files write it."""
    given = _checked(joint, _yielded(joint))
    slots = [k for k, motion in enumerate(given) if motion.coordinate is None and _moves(motion)]
    own = [not given[k].displaces for k in slots]
    values = own_coordinates(system, joint, _names(joint, given, slots), own)
    closes = closes_loop(system, joint.child)
    if closes and any(motion.coordinate is not None for motion in given):
        refuse_coordinate(joint)
    coordinates = {k: motion.coordinate for k, motion in enumerate(given)} | dict(
        zip(slots, values, strict=True)
    )
    several = len(given) > 1
    result = []
    for k, motion in enumerate(given):
        what = f"motion {k + 1} of {joint.title}" if several else joint.title
        at, axis = _place(system, motion, what)
        motion = replace(motion, coordinate=coordinates[k], at=at, axis=axis)
        if not motion.displaces:
            motion = _with_own(system, motion, what, closes)
        elif k not in slots:
            motion = replace(motion, coordinate=displacement(system, joint.name, motion.coordinate))
        result.append(_with_inertia(system, motion, what, k))
    _check_different(result, joint)
    written: Any = tuple(values)
    if own == [True]:
        written = None if values[0] == joint.name else values[0]
    told = {"coordinate": None if closes or not slots else written}
    return result, told | joint.stored(result, ZERO)


def _moves(motion: Primitive) -> bool:
    return motion.displaces or motion.n_speeds > 0


def _yielded(joint: Any) -> Any:
    """Return what a kind yields as its motions, as a list if it can be one."""

    def motions() -> Any:
        found = joint.motions()
        return found if isinstance(found, str | Primitive) or not hasattr(found, "__iter__") else list(found)

    return answer(joint, motions)


def _checked(joint: Any, motions: Any) -> list[Primitive]:
    """Return the motions if they are primitives that can stand in one joint."""
    what = joint.title
    if not isinstance(motions, list):
        raise ModelError(f"Expected a list of motions for {what}, {SUCH_AS}, got {shown(motions)}.")
    if not motions:
        raise ModelError(f"Expected at least one motion for {what}, {SUCH_AS}. Without motion it is s.weld.")
    for motion in motions:
        single = isinstance(motion, Primitive) and (motion.chained or len(motions) == 1)
        if not single:
            raise ModelError(
                f"Expected fb.Hinge, fb.Slider, fb.Screw or fb.Ball in {what}, got {shown(motion)}."
            )
    return motions


def _names(joint: Any, motions: Sequence[Primitive], slots: Sequence[int]) -> list[str]:
    """Return the default names of the coordinates that the motions leave open."""
    endings = tuple(joint.endings)
    if not endings:
        return [joint.name if len(motions) == 1 else f"{joint.name}_{k + 1}" for k in slots]
    if len(endings) != len(slots):
        raise ModelError(
            f"{joint.heading} has {len(slots)} motions without a coordinate of their own, but its class "
            f"{type(joint).__name__} has {len(endings)} endings of names: {', '.join(endings)}. Give one for each."
        )
    return [f"{joint.name}_{ending}" for ending in endings]


def _place(system: Description, motion: Primitive, what: str) -> tuple[Vector, Any]:
    """Return the anchor and the axis of a motion."""
    at = vector(system, (0, 0, 0) if motion.at is None else motion.at, f"the anchor of {what}")
    for component in at:
        moving = varying(system, component)
        if moving:
            raise ModelError(
                f"The anchor of {what} is fixed in the joint and cannot depend on {', '.join(moving)}."
            )
    return at, direction(system, motion.axis, f"the axis of {what}") if motion.displaces else motion.axis


def _with_own(system: Description, motion: Primitive, what: str, closes: bool) -> Primitive:
    """Return a motion with coordinates and speeds of its own, whose prefix its coordinate is."""
    if motion.rotor is not None:
        raise ModelError(f"The ball in {what} takes no rotor=. Make the joint by hinges.")
    some = motion.armature not in ((), 0, None)
    if some and motion.chained:
        one = constant(system, motion.armature, f"the armature of {what}")
        motion = replace(motion, armature=(one,) * motion.n_speeds)
    if not motion.n_speeds:
        return replace(motion, coordinate=None)
    if closes:
        return replace(motion, coordinate=())
    q = components_of(system, motion.coordinate, list(motion.endings), "coordinate")
    components_of(system, motion.coordinate, list(motion.speed_endings), "speed")
    return replace(motion, coordinate=tuple(q))


def _with_inertia(system: Description, motion: Primitive, what: str, k: int) -> Primitive:
    """Return a motion with its pitch, armature and rotor."""
    if not motion.displaces:
        return motion
    result = motion
    if motion.armature != ():
        armature = 0 if motion.armature is None else motion.armature
        some = () if armature == 0 else (constant(system, armature, f"the armature of {what}"),)
        result = replace(result, armature=some)
    if motion.pitch != 0:
        result = replace(result, pitch=constant(system, motion.pitch, f"the pitch of {what}", any_sign=True))
    if motion.rotor is not None:
        if k > 0:
            raise ModelError(
                f"The rotor of {what} would stand on the motion before it, which has no body. Put it on the first "
                f"motion, or give the joint a body there."
            )
        result = replace(result, rotor=own_rotor(system, what, motion.rotor, [result]))
    return result


def _check_different(motions: Sequence[Primitive], joint: Any) -> None:
    """Refuse more motions than a body has, and neighbours that are the same motion."""
    if not all(motion.chained for motion in motions):
        return
    balls = [k for k, motion in enumerate(motions) if not motion.displaces]
    for ball in balls:
        beside = (k for k in (ball - 1, ball + 1) if 0 <= k < len(motions) and motions[k].turns)
        if len(balls) > 1 or any(along(motions[ball].at, motions[k].at, motions[k].axis) for k in beside):
            raise ModelError(
                f"{joint.heading} has a ball, which makes every turn about its point. Leave out other balls, and "
                "turns beside it whose axis goes through that point."
            )
    heads = parallel_turns(motions)
    turns = sum(
        (1 if motion.displaces else 3)
        for k, motion in enumerate(motions)
        if motion.turns and heads[k][0] == k
    )
    slides = sum(not motion.turns for motion in motions) + sum(heads[k][0] != k for k in range(len(motions)))
    if balls:  # other turns displace its point
        turns, slides = 3, slides + turns - 3
    if turns > 3 or slides > 3:
        raise ModelError(
            f"{joint.heading} has {turns} turns about different axes and {slides} displacements beside "
            f"them; a body has at most three of each. Leave some out."
        )
    for k in range(1, len(motions)):
        a, b = motions[k - 1], motions[k]
        same = type(a) is type(b) and b.axis in (a.axis, tuple(-x for x in a.axis))
        if same and (not b.turns or along(b.at, a.at, a.axis)):
            raise ModelError(
                f"Motions {k} and {k + 1} of {joint.title} are the same {b.kind}, so their coordinates cannot be told "
                f"apart. Leave one out, or give it another anchor."
            )
