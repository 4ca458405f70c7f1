"""Methods of System that make loads: one-line doors to the classes of the kinds."""

from __future__ import annotations

from typing import Any

import sympy

from ...errors import ModelError, shown
from ...scalar.algebra import Expression
from ...scalar.expression import exact
from ..description import Description, claim, names_of
from ..frame import Frame
from ..joints.joint import Joint
from .bushing import Bushing
from .cable import Cable
from .coordinate_force import CoordinateForce
from .damper import Damper
from .displacement import check_displacement
from .drag import Drag
from .force import Force
from .gravitation import Gravitation
from .joint_damper import JointDamper
from .joint_effort import JointEffort
from .joint_spring import JointSpring
from .load import Load, add, own_coordinate
from .motor import Motor
from .spring import Spring
from .spring_law import JointSpringLaw, SpringLaw
from .torque import Torque


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
    system: Description, name: str, on: Any, to: Any = None, *, damping: Expression, coordinate: int = 0
) -> Load:
    """Add a linear damper along a joint's displacement, or straight between two points; ``damping`` in N s/m."""
    if isinstance(on, Joint):
        return add(system, name, JointDamper(on, damping, coordinate))
    return add(system, name, Damper(on, _second(to, f"damper '{name}'"), damping))


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
    atom = own_coordinate(system, coordinate)
    name = f"Q_{names_of(system).texts[atom]}" if name is None else name
    return add(system, name, CoordinateForce(atom, value))


def drag(
    system: Description,
    name: str,
    at: Any,
    *,
    quadratic: Expression = 0,
    linear: Expression = 0,
    turning: Expression = 0,
    wind: Any = (0, 0, 0),
) -> Load:
    """Add the drag of a fluid at a point of a body: -(c + k |v|) v, v the velocity relative to the wind.

    Parameters
    ----------
    name : str
    at : Point, or Body (its mass centre)
    quadratic : expression
        k = ½ ρ C_d A [N s²/m²].
    linear : expression
        Stokes' c, 6 π μ R of a small sphere [N s/m].
    turning : expression
        Stokes' moment per angular velocity, 8 π μ R³ of a small sphere [N m s].
    wind : three expressions
        Velocity of the fluid in ground axes [m/s].

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("falling ball")
    >>> m, g, k = s.parameters(m=1.0, g=9.81, k=0.1)
    >>> s.gravity = (0, -g, 0)
    >>> ball = s.body("ball", fb.particle(m))
    >>> guide = s.slider("guide", s.ground, ball, axis="-y", coordinate="y")
    >>> air = s.drag("air", ball, quadratic=k)
    >>> print(fb.equations(s).text())
    m*y'' - m*g = -k*y'*abs(y')
    """
    place = at.point(*at.mass_properties.center) if getattr(at, "mass_properties", None) is not None else at
    return add(system, name, Drag(place, quadratic, linear, turning, wind))


def motor(
    system: Description,
    name: str,
    joint: Joint,
    *,
    stall_torque: Expression = None,
    no_load_speed: Expression = None,
    electric: Any = None,
    ratio: Expression = 1,
    inertia: Expression = 0,
    coordinate: int = 0,
) -> Load:
    """Add a motor on a joint, behind a gear; its stator stands in the joint's parent, whose mass contains the rotor's.

    Parameters
    ----------
    name : str
    joint : Joint
    stall_torque : expression
        T_s, torque of the standing rotor [N m]; a function of time or of a signal if the motor is switched.
    no_load_speed : expression
        Rate ω_0 at which the torque has fallen to zero [rad/s]; without it the torque is T_s at every speed.
    electric : (V, k, R), in place of these two
        Voltage [V], constant [N m/A] and resistance [ohm] of a direct-current motor: T_s = k V/R, ω_0 = V/k.
    ratio : expression
        n, turns of the rotor per turn of the joint; on a slider, radians per metre.
    inertia : expression
        J of the rotor [kg m²]: n² J along the joint, and the moments of its spin on the parent.
    coordinate : int
        Index of the displacement of a joint that has several, counted from 0.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("crane")
    >>> I, T, w, n, J = s.parameters(I=2.0, T=0.5, w=300.0, n=50, J=1e-4)
    >>> arm = s.body("arm", fb.MassProperties(1, (0, 0, 0), [[I, 0, 0], [0, I, 0], [0, 0, I]]))
    >>> pin = s.hinge("pin", s.ground, arm, coordinate="q")
    >>> drive = s.motor("drive", pin, stall_torque=T, no_load_speed=w, ratio=n, inertia=J)
    >>> print(fb.equations(s).text())
    (I + J*n^2)*q'' = T*n*(1 - n*q'/w)
    """
    what = f"motor '{name}'"
    if (electric is None) == (stall_torque is None):
        raise ModelError(
            f"Expected stall_torque= of {what}, with no_load_speed= if the torque falls with the speed, or "
            f"electric=(V, k, R); got {'neither' if electric is None else 'both'}."
        )
    if electric is not None:
        if not isinstance(electric, list | tuple) or len(electric) != 3:
            raise ModelError(
                f"Expected electric=(voltage, constant, resistance) of {what}, got {shown(electric)}."
            )
        V, k, R = (system.expression(x, what) for x in electric)
        return add(system, name, Motor(joint, _quotient(k * V, R), _quotient(k * k, R), ratio, inertia, coordinate))
    slope: Any = 0
    if no_load_speed is not None:
        slope = _quotient(system.expression(stall_torque, what), system.expression(no_load_speed, what))
    return add(system, name, Motor(joint, stall_torque, slope, ratio, inertia, coordinate))


def gravitation(
    system: Description, name: str, body: Frame, toward: Any = None, *, parameter: Expression, extended: bool = False
) -> Load:
    """Add the attraction of a body to a point: μ m/r², with the moment of the gradient of the field if ``extended``.

    Parameters
    ----------
    name : str
    body : Body
    toward : Point, or Body (its mass centre), optional
        What attracts, and is attracted; by default the ground's origin.
    parameter : expression
        μ: the constant of gravitation times the mass that attracts [m³/s²].
    extended : bool
        If true, the moment of inertia takes part, to second order in the body's size over the distance.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("satellite")
    >>> m, mu = s.parameters(m=1.0, mu=398600.4418)
    >>> moon = s.body("moon", fb.particle(m))
    >>> orbit = s.free("orbit", s.ground, moon)
    >>> s.gravitation("earth", moon, parameter=mu)
    gravitation 'earth'
    """
    if toward is None:
        toward = system.ground.origin  # type: ignore[attr-defined]
    elif getattr(toward, "mass_properties", None) is not None:
        toward = toward.point(*toward.mass_properties.center)
    return add(system, name, Gravitation(body, toward, parameter, bool(extended)))


def bushing(
    system: Description,
    name: str,
    start: Any,
    to: Any,
    *,
    stiffness: Any = (0, 0, 0),
    damping: Any = (0, 0, 0),
    turning_stiffness: Any = (0, 0, 0),
    turning_damping: Any = (0, 0, 0),
) -> Load:
    """Add a linear spring and damper in all six directions between points of two bodies, along the axes of the first.

    The angles are those of a gimbal "XYZ" from the first body to the second; they may be large, the second one up to 90°.

    Parameters
    ----------
    name : str
    start, to : Point or Body (its origin)
    stiffness, damping : three expressions
        Along x, y, z of the first body [N/m], [N s/m].
    turning_stiffness, turning_damping : three expressions
        About x, y, z [N m/rad], [N m s/rad].

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("mount")
    >>> engine = s.body("engine", fb.box(80, (0.6, 0.5, 0.4)))
    >>> free = s.free("free", s.ground, engine)
    >>> s.bushing("rubber", s.ground, engine, stiffness=(2e5, 2e5, 6e5), turning_stiffness=(900, 900, 400))
    bushing 'rubber'
    """
    return add(system, name, Bushing(start, to, stiffness, damping, turning_stiffness, turning_damping))


def cable(
    system: Description, name: str, start: Any, to: Any, *, stiffness: Expression, length: Expression, damping: Expression = 0
) -> Load:
    """Add an elastic cable between two points: it pulls when it is longer than ``length``, and never pushes.

    Parameters
    ----------
    name : str
    start, to : Point
    stiffness : expression [N/m]
    length : expression [m]
        Its length without tension. A rope that does not stretch is :meth:`rope`.
    damping : expression [N s/m]
        Of the taut cable.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("bungee")
    >>> m, g, k, L = s.parameters(m=70.0, g=9.81, k=100.0, L=20.0)
    >>> s.gravity = (0, -g, 0)
    >>> jumper = s.body("jumper", fb.particle(m))
    >>> fall = s.slider("fall", s.ground, jumper, axis="-y", coordinate="y")
    >>> rope = s.cable("rope", s.ground.origin, jumper.origin, stiffness=k, length=L)
    >>> print(fb.simulate(s, 3, initial={"y": 1.0}).events)
    t = 1.96815 s: rope becomes taut: rises through zero
    """
    return add(system, name, Cable(start, to, stiffness, length, damping))


def _quotient(a: Any, b: Any) -> Any:
    """Return a/b of expressions, exact."""
    return exact(sympy.sympify(a) / sympy.sympify(b))


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
