"""Methods of System that make loads: one-line doors to the classes of the kinds."""

from __future__ import annotations

from typing import Any

from ...errors import ModelError, shown
from ...scalar.algebra import Expression
from ..description import Description, claim, names_of
from ..frame import Frame
from ..joints.joint import Joint, turns_freely
from ..part import add, own_coordinate
from .coordinate_force import CoordinateForce
from .damper import Damper
from .displacement import check_displacement
from .force import Force
from .joint_damper import JointDamper
from .joint_effort import JointEffort
from .joint_spring import JointSpring
from .load import Load
from .spring import Spring
from .spring_law import JointSpringLaw, SpringLaw
from .torque import Torque
from .torsion import TorsionDamper, TorsionSpring


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
    if isinstance(at, Joint):
        return _effort(system, name, at, components, f"force '{name}'", ("slider",))
    return add(system, name, Force(at, components, frame))


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
    if isinstance(on, Joint):
        return _effort(system, name, on, components, f"torque '{name}'", ("hinge", "screw"))
    return add(system, name, Torque(on, components, frame, reaction_on))


def spring(
    system: Description,
    name: str,
    on: Any,
    to: Any = None,
    *,
    stiffness: Expression = None,
    rest: Expression = 0,
    coordinate: int = 0,
    force: Any = None,
) -> Load:
    """Add a spring along a joint's displacement, or straight between two points.

    Parameters
    ----------
    name : str
    on : Joint, or the first Point
    to : Point, optional
        The second point.
    stiffness : expression [N/m], or [N m/rad] on a hinge
        Of a linear spring.
    rest : expression
        Displacement or distance at which the spring force is zero.
    coordinate : int
        Index of the displacement of a joint that has several, counted from 0.
    force : text, expression or table, optional
        In place of ``stiffness``, any law of ``stretch`` (from ``rest``) and its ``rate``, which resists a positive
        stretch: ``"k*stretch + k3*stretch^3 + c*rate*abs(rate)"``, or pairs (stretch, force) that monotone cubics join,
        ``[(-0.1, -8), (0, 0), (0.1, 2)]``.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("hardening spring")
    >>> k, k3, m = s.parameters(k=100.0, k3=2000.0, m=1.0)
    >>> body = s.body("body", fb.particle(m))
    >>> guide = s.slider("guide", s.ground, body, coordinate="x")
    >>> spring = s.spring("spring", guide, force="k*stretch + k3*stretch^3")
    >>> print(fb.equations(s).text())
    m*x'' + k*x + k3*x^3 = 0
    """
    if (stiffness is None) == (force is None):
        raise ModelError(
            f"Expected either stiffness= or force= of spring '{name}', got {'neither' if force is None else 'both'}."
        )
    if force is not None:
        if isinstance(on, Joint):
            return add(system, name, JointSpringLaw(on, force, rest, coordinate))
        return add(system, name, SpringLaw(on, _second(to, f"spring '{name}'"), force, rest))
    if isinstance(on, Joint):
        return add(system, name, JointSpring(on, stiffness, rest, coordinate))
    return add(system, name, Spring(on, _second(to, f"spring '{name}'"), stiffness, rest))


def damper(
    system: Description,
    name: str,
    on: Any,
    to: Any = None,
    *,
    damping: Expression,
    coordinate: int | None = None,
) -> Load:
    """Add a linear damper along a joint's displacement, or straight between two points; ``damping`` in N s/m.

    On a ball or free joint it is a moment against the relative angular velocity, ``damping`` in N m s.
    """
    if isinstance(on, Joint) and turns_freely(on, coordinate):
        return add(system, name, TorsionDamper(on, damping))
    if isinstance(on, Joint):
        return add(system, name, JointDamper(on, damping, 0 if coordinate is None else coordinate))
    return add(system, name, Damper(on, _second(to, f"damper '{name}'"), damping))


def torsion_spring(
    system: Description,
    name: str,
    on: Joint,
    *,
    stiffness: Expression,
    rest: Any = 0,
    coordinate: int | None = None,
) -> Load:
    """Add a linear torsion spring [N m/rad] on an angle of a joint; its moment is zero at the angle ``rest``.

    On a ball or free joint it resists the rotation vector: its moment is ``stiffness`` times the angle of the turn,
    at most π, about the axis of the turn. There ``rest`` is a rotation, that of the child's joint axes in the parent's.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("neck")
    >>> head = s.body("head", fb.sphere(3, 0.1))
    >>> neck = s.ball("neck", s.ground, head)
    >>> s.torsion_spring("muscles", neck, stiffness=2)
    torsion spring 'muscles'
    >>> s.damper("tissue", neck, damping=0.1)
    torsion damper 'tissue'
    """
    what = f"torsion spring '{name}'"
    if not isinstance(on, Joint):
        raise ModelError(f"Expected a joint with an angle for {what}, got {shown(on)}.")
    if turns_freely(on, coordinate):
        return add(system, name, TorsionSpring(on, stiffness, None if rest == 0 else rest))
    angles = [i for i, p in enumerate(on.primitives) if p.displaces and p.turns]
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
    atom = own_coordinate(system, coordinate)
    name = f"Q_{names_of(system).texts[atom]}" if name is None else name
    return add(system, name, CoordinateForce(atom, value))


def _second(point: Any, what: str) -> Any:
    """Return the second point of a straight load, if there is one."""
    if point is None:
        raise ModelError(f"Expected a joint or two points for {what}; the second point (to=) is missing.")
    return point


def _effort(
    system: Description, name: str, joint: Joint, value: Any, what: str, kinds: tuple[str, ...]
) -> Load:
    """Add a force or moment along a joint of one of these kinds."""
    claim(system, name, "load")
    check_displacement(joint, 0, what)
    if len(joint.primitives) != 1 or joint.primitives[0].kind not in kinds:
        raise ModelError(
            f"{what[0].upper()}{what[1:]} acts along a {' or a '.join(kinds)}, but '{joint.name}' is a {joint.type}. "
            f"Act on the body, or use s.generalized_force on one of the joint's coordinates."
        )
    if hasattr(value, "__len__") and not isinstance(value, str):
        raise ModelError(f"Expected one expression for {what} on joint '{joint.name}', got {shown(value)}.")
    return add(system, name, JointEffort(joint, value))
