"""Joints by functions: the pose of the child is a function of one coordinate, or of two.

The pose r(q), R(q) is a chain of slides along x, y, z by r and of turns by the angles, so that every algorithm
differentiates it like any displacement: exactly, with the term r''(q) q'² of its curvature. Its motion per unit rate is
the twist Σ ∂y_i/∂q t_i (:mod:`freebody.dynamics.joints.motions`), and the joint transmits what has no power in it.
"""

from __future__ import annotations

from typing import Any

from ...errors import ModelError, shown
from ...scalar.algebra import ZERO, Vector
from ..axes import UNIT, direction
from ..description import Description, declare_coordinate, names_of, varying, vector
from ..frame import closes_loop
from ..names import is_identifier
from ..part import answer
from .hinge import Hinge
from .joining import displacement
from .primitive import Primitive
from .slider import Slider


def displacements_of(
    system: Description, joint: Any
) -> tuple[list[Primitive], tuple[Vector, Vector], dict[str, Any]]:
    """Return the motions of a joint by functions, what is constant in its position, and its names of coordinates."""
    what = joint.title
    if closes_loop(system, joint.child):
        joint.refuse_loop()
    if joint.armature not in (0, None) or joint.rotor is not None:
        raise ModelError(
            f"{joint.heading} is a joint by functions and takes no armature= or rotor=. Give them to a hinge or a "
            f"slider, to which s.constrain couples it."
        )
    names = _declared(system, joint)
    position, turns = _pose(joint, [names_of(system).atoms[text] for text in names])
    components = vector(system, position, f"the position of {what}")
    x, y, z = (0 if varying(system, x) else x for x in components)
    motions: list[Primitive] = [
        Slider(UNIT["xyz"[k]], displacement(system, joint.name, x), at=ZERO)
        for k, x in enumerate(components)
        if varying(system, x)
    ]
    motions += [_turn(system, joint, turn, k) for k, turn in enumerate(_listed(turns, what), start=1)]
    for text in names:
        if not any(text in names_of(system).depends(motion.coordinate, "coordinate") for motion in motions):
            raise ModelError(
                f"The pose of {what} does not depend on its coordinate '{text}'. Give position= or turns= with it, "
                f"such as position=('{text}', '{text}^2', 0)."
            )
    return motions, ((x, y, z), ZERO), {**joint.stored(motions, components), "coordinate": " ".join(names)}


def _pose(joint: Any, coordinates: list[Any]) -> tuple[Any, Any]:
    """Return the position and the turns that a kind says."""
    pose = answer(joint, lambda: joint.pose(*coordinates))
    if not isinstance(pose, tuple) or len(pose) != 2:
        raise ModelError(
            f"Expected a position and turns from the pose of {joint.title}, such as (x, y, 0), [('z', angle)], got "
            f"{shown(pose)}."
        )
    return pose


def _declared(system: Description, joint: Any) -> list[str]:
    """The names of the coordinates, declared if they are new."""
    endings, coordinate = tuple(joint.endings), joint.coordinate
    if coordinate is None:
        coordinate = " ".join(f"{joint.name}_{ending}" for ending in endings) if endings else joint.name
    texts = coordinate.replace(",", " ").split() if isinstance(coordinate, str) else []
    if len(texts) not in ((len(endings),) if endings else (1, 2)) or not all(map(is_identifier, texts)):
        count = "a coordinate, or of two," if not endings else f"{len(endings)} coordinates"
        raise ModelError(
            f"Expected the name of {count} for {joint.title}, such as 'q', got {shown(joint.coordinate)}."
        )
    for text in texts:
        if names_of(system).kinds.get(text) != "coordinate":
            declare_coordinate(system, text)
    return texts


def _listed(turns: Any, what: str) -> list[Any]:
    """The turns, pairs of an axis and an angle."""
    result = [] if isinstance(turns, str) or not hasattr(turns, "__iter__") else list(turns)
    pairs = all(not isinstance(turn, str) and hasattr(turn, "__len__") and len(turn) == 2 for turn in result)
    if not pairs or (not result and turns not in ((), [])):
        raise ModelError(
            f"Expected turns such as [('z', 'q')], axis and angle, for {what}, got {shown(turns)}."
        )
    return result


def _turn(system: Description, joint: Any, turn: Any, k: int) -> Primitive:
    """The hinge of one turn."""
    axis = direction(system, turn[0], f"the axis of turn {k} of {joint.title}")
    angle = system.expression(turn[1], f"the angle of turn {k} of {joint.title}")
    return Hinge(axis, displacement(system, joint.name, angle), at=ZERO)
