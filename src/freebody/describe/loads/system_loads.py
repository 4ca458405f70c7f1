"""Methods of System that make loads: forces, torques, springs, dampers, generalized forces."""

from __future__ import annotations

from typing import Any

from ...errors import ModelError, nearest, shown
from ...scalar.algebra import Expression, Scalar
from ..description import Description, claim, coordinates_of, names_of, varying, vector
from ..frame import Frame, Point, own_body, own_point
from ..joints.joint import Joint
from .load import Damper, Force, GeneralizedForce, JointDamper, JointForce, JointSpring, Load, Spring, Torque


def force(system: Description, name: str, at: Any, components: Any, *, frame: Frame | None = None) -> Load:
    """Add a force at a point of a body, or the force of a motor along a slider.

    Parameters
    ----------
    name : str
    at : Point, Body (its origin) or Joint (a slider)
    components : three expressions [N] (one, for a joint)
        Expressions of coordinates, speeds, time and parameters; components in ground axes unless ``frame`` is given.
    frame : Frame, optional
        The body in whose axes the components are given.
    """
    what = f"force '{name}'"
    claim(system, name, "load")
    if isinstance(at, Joint):
        return _joint_force(system, name, at, components, what, ("slider",))
    point = own_point(system, at, what)
    if point.body.is_ground:
        raise ModelError(
            f"Force '{name}' acts on the ground, which nothing moves: it would have no effect. Name a point of a body."
        )
    axes = system.ground if frame is None else own_body(system, frame, what)
    return _store(system, Force(name, point, vector(system, components, what), axes))


def torque(
    system: Description,
    name: str,
    on: Any,
    components: Any,
    *,
    frame: Frame | None = None,
    reaction_on: Frame | None = None,
) -> Load:
    """Add a couple on a body, or the moment of a motor along a hinge or a screw.

    Parameters
    ----------
    name : str
    on : Frame or Joint (a hinge)
    components : three expressions [N m] (one, for a joint, conjugate to its angle)
    frame : Frame, optional
        The body in whose axes the components are given; by default ground axes.
    reaction_on : Frame, optional
        The body on which the opposite couple acts; by default the ground.
    """
    what = f"torque '{name}'"
    claim(system, name, "load")
    if isinstance(on, Joint):
        return _joint_force(system, name, on, components, what, ("hinge", "screw"))
    body = own_body(system, on, what)
    axes = system.ground if frame is None else own_body(system, frame, what)
    opposite = None if reaction_on is None else own_body(system, reaction_on, what)
    if body is opposite or (body.is_ground and opposite is None):
        where = (
            "the ground, which nothing moves" if body.is_ground else f"'{body.name}' and so does its opposite"
        )
        raise ModelError(
            f"Torque '{name}' acts on {where}: it would have no effect. Name the body that turns, or another one as "
            f"reaction_on."
        )
    return _store(system, Torque(name, body, vector(system, components, what), axes, opposite))


def spring(
    system: Description,
    name: str,
    on: Any,
    to: Any = None,
    *,
    stiffness: Expression,
    rest: Expression = 0,
    coordinate: int = 0,
) -> Load:
    """Add a linear spring along a joint's displacement, or straight between two points.

    Parameters
    ----------
    name : str
    on : Joint, or the first Point
    to : Point, optional
        The second point.
    stiffness : expression [N/m], or [N m/rad] on a hinge
    rest : expression
        Displacement or distance at which the spring force is zero.
    coordinate : int
        Index of the displacement of a joint that has several, counted from 0.
    """
    what = f"spring '{name}'"
    claim(system, name, "load")
    k = _constant(system, stiffness, f"the stiffness of {what}")
    free = _constant(system, rest, f"the rest length of {what}")
    if isinstance(on, Joint):
        joint, index = _displacement(system, on, coordinate, what)
        return _store(system, JointSpring(name, joint, index, k, free))
    return _store(system, Spring(name, *_ends(system, on, to, what), k, free))


def damper(
    system: Description, name: str, on: Any, to: Any = None, *, damping: Expression, coordinate: int = 0
) -> Load:
    """Add a linear damper along a joint's displacement, or straight between two points; ``damping`` in N s/m."""
    what = f"damper '{name}'"
    claim(system, name, "load")
    c = _constant(system, damping, f"the damping of {what}")
    if isinstance(on, Joint):
        joint, index = _displacement(system, on, coordinate, what)
        return _store(system, JointDamper(name, joint, index, c))
    return _store(system, Damper(name, *_ends(system, on, to, what), c))


def torsion_spring(
    system: Description,
    name: str,
    on: Joint,
    *,
    stiffness: Expression,
    rest: Expression = 0,
    coordinate: int | None = None,
) -> Load:
    """Add a linear torsion spring [N m/rad] on an angle of a joint; its moment is zero at the angle ``rest``."""
    what = f"torsion spring '{name}'"
    if not isinstance(on, Joint):
        raise ModelError(f"Expected a joint with an angle for {what}, got {shown(on)}.")
    angles = [i for i, p in enumerate(on.primitives) if p.kind in ("hinge", "screw")]
    if not angles:
        raise ModelError(
            f"{on.type} '{on.name}' has no angle for {what}; a spring along it is made by s.spring."
        )
    index = angles[0] if coordinate is None else coordinate
    if not isinstance(index, int) or index not in angles:
        raise ModelError(
            f"Displacement {shown(index)} of {on.type} '{on.name}' is not an angle; angles: {angles}."
        )
    return spring(system, name, on, stiffness=stiffness, rest=rest, coordinate=index)


def generalized_force(system: Description, coordinate: Any, value: Any, *, name: str | None = None) -> Load:
    """Add a force conjugate to a coordinate: its power is ``value`` times the coordinate's speed."""
    if isinstance(coordinate, str) and coordinate not in coordinates_of(system):
        raise ModelError(f"Unknown coordinate '{coordinate}'; {nearest(coordinate, coordinates_of(system))}")
    atom = system.expression(coordinate, "the coordinate of a generalized force")
    if atom not in coordinates_of(system).values():
        raise ModelError(
            f"Expected a coordinate of this system, got '{atom}'. Coordinates of ball and free joints take "
            f"forces and torques on the body instead."
        )
    name = f"Q_{names_of(system).texts[atom]}" if name is None else name
    claim(system, name, "load")
    return _store(
        system, GeneralizedForce(name, atom, system.expression(value, f"generalized force '{name}'"))
    )


def _store(system: Description, load: Load) -> Load:
    system.loads[load.name] = load
    return load


def _constant(system: Description, value: Expression, what: str) -> Scalar:
    expression = system.expression(value, what)
    moving = varying(system, expression)
    if moving:
        raise ModelError(
            f"{what[0].upper()}{what[1:]} must be constant, but it depends on {', '.join(moving)}. "
            f"Write the law as a force or a generalized force instead."
        )
    return expression


def _ends(system: Description, start: Any, end: Any, what: str) -> tuple[Point, Point]:
    if end is None:
        raise ModelError(f"Expected a joint or two points for {what}; the second point (to=) is missing.")
    a, b = own_point(system, start, what), own_point(system, end, what)
    if a.body is b.body:
        raise ModelError(
            f"Both ends of {what} are on '{a.body.name}', so it does nothing. Put one end on another body."
        )
    return a, b


def _displacement(system: Description, joint: Joint, index: int, what: str) -> tuple[Joint, int]:
    if system.joints.get(joint.name) is not joint:
        raise ModelError(
            f"{what[0].upper()}{what[1:]}: joint '{joint.name}' belongs to another system than '{system.name}'. "
            f"Name a joint of this one."
        )
    kinds = [p.kind for p in joint.primitives]
    if kinds[0] in ("ball", "free", "weld"):
        raise ModelError(
            f"{joint.type[0].upper()}{joint.type[1:]} '{joint.name}' has no single displacement for {what} to act "
            f"along. Act between two points, or by a torque on the body."
        )
    if not isinstance(index, int) or not 0 <= index < len(kinds):
        raise ModelError(
            f"Joint '{joint.name}' has {len(kinds)} displacements (0 to {len(kinds) - 1}), got {shown(index)} for "
            f"{what}."
        )
    return joint, index


def _joint_force(
    system: Description, name: str, joint: Joint, value: Any, what: str, kinds: tuple[str, ...]
) -> Load:
    joint, index = _displacement(system, joint, 0, what)
    if len(joint.primitives) != 1 or joint.primitives[0].kind not in kinds:
        raise ModelError(
            f"{what[0].upper()}{what[1:]} acts along a {' or a '.join(kinds)}, but '{joint.name}' is a {joint.type}. "
            f"Act on the body, or use s.generalized_force on one of the joint's coordinates."
        )
    if hasattr(value, "__len__") and not isinstance(value, str):
        raise ModelError(f"Expected one expression for {what} on joint '{joint.name}', got {shown(value)}.")
    return _store(system, JointForce(name, joint, index, system.expression(value, what)))
