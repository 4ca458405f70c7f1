"""Arrows of a machine in motion: the loads and reactions on its bodies, each with the point it is drawn at."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ...describe.constraints.constraint import Rolling
from ...describe.loads.action import Action, Couple, JointForce, PointForce
from ...dynamics.kinematics import Spot, poses, rotation
from ...dynamics.loads.actions import accelerating, actions, places
from ...dynamics.loads.added_mass import moving
from ...dynamics.loads.loading import weight
from ...dynamics.loads.power import joint_link
from ...dynamics.motion import transmitting
from ...dynamics.state import State
from ...model.closure import Closure
from ...model.model import Model
from ...scalar.algebra import Scalar, Vector, add, apply, divide, dot, scale

if TYPE_CHECKING:
    from ...motion.kernels.kernels import Kernels


@dataclass(frozen=True)
class Arrow:
    """A force or a moment on a body.

    Attributes
    ----------
    name : str
        Name of the load or joint; for a weight, the name of the body.
    group : str
        ``force`` (loads and weights) or ``reaction``.
    role : str
        ``weight``, ``load``, ``spring``, ``damper``, ``motor``, ``reaction``, ``contact`` or ``friction``; it sets the
        colour.
    kind : str
        ``force`` [N] or ``moment`` [N m].
    body : str
        Body that it acts on.
    at : 3 entries
        Point at which it is drawn, in body axes from the body's origin [m], numbers or expressions.
    number : int
        0 and 1 for the two ends of a spring, damper or torque between bodies.
    moves : bool
        True if it acts at a point that moves over the body (:func:`moving_points`), as where a wheel touches.
    contact : int, optional
        Number of the contact whose normal force or friction it is, drawn where the bodies touch.
    """

    name: str
    group: str
    kind: str
    body: str
    at: Vector
    role: str
    number: int = 0
    moves: bool = False
    contact: int | None = None

    @property
    def key(self) -> str:
        """Unique name of the arrow."""
        return f"{self.group} {self.kind} {self.name} {self.number}"


def arrows(kernels: Kernels) -> tuple[Arrow, ...]:
    """All arrows of a machine: loads in the order of :func:`applied`, then reactions, then forces of contacts."""
    model = kernels.model
    result = [arrow for arrow, _ in _loads(model, None)]
    for name, body, _ in transmitting(model):
        constraint = model.constraints.get(name)
        if isinstance(constraint, Rolling):
            center = constraint.center.components
            result.append(Arrow(name, "reaction", "force", body, center, "contact", moves=True))
            continue
        at = constraint.to if isinstance(constraint, Closure) else model.joints[name].to
        if not isinstance(constraint, Closure) and model.joints[name].pair.free:
            continue
        result += [Arrow(name, "reaction", kind, body, at, "reaction") for kind in ("force", "moment")]
    for k, contact in enumerate(model.contacts):
        body = contact.feature.body.name
        names = [(contact.normal_name, "reaction")]
        if not contact.frictionless:  # the two components of friction in space make one arrow
            planar = len(contact.tangent_names) == 1
            names.append((contact.tangent_names[0] if planar else f"T_{contact.name}", "friction"))
        for name, role in names:
            result.append(Arrow(name, "reaction", "force", body, (0, 0, 0), role, contact=k))
    return tuple(result)


def applied(model: Model, state: State, udot: Sequence[Scalar] | None) -> list[tuple[Arrow, Vector]]:
    """Arrow of every load on a body at accelerations u', with its value in ground axes [N] or [N m]."""
    return _loads(model, moving(model, state, udot))


def _loads(model: Model, state: State | None) -> list[tuple[Arrow, Any]]:
    """Arrow of every load, with its value; without a state the values are None.

    Loads of accelerations have none in a machine with contacts, whose accelerations depend on the modes.
    """
    result: list[tuple[Arrow, Any]] = []
    if any(component != 0 for component in model.gravity):
        for name, place in model.bodies.items():
            if place.mass != 0:
                arrow = Arrow(name, "force", "force", name, place.center, "weight")
                result.append((arrow, state and weight(model, state, place.mass)))
    for name, load in model.loads.items():
        if model.contacts and name in accelerating(model):
            continue
        shown = actions(model, state, name) if state else places(model)[name]
        result += _arrows(model, state, name, load.look.role, shown)
    return result


def _arrows(
    model: Model, state: State | None, name: str, role: str, shown: Sequence[Action]
) -> list[tuple[Arrow, Any]]:
    """Arrow of every action of a load, with its value; a force on a coordinate acts at no point and has none."""
    result: list[tuple[Arrow, Any]] = []
    for k, action in enumerate(shown):
        match action:
            case PointForce(point, force) if not point.body.is_ground:
                moves = isinstance(point, Spot)
                at = model.bodies[point.body.name].center if moves else point.components
                arrow = Arrow(name, "force", "force", point.body.name, at, role, k, moves)
                result.append((arrow, state and force))
            case Couple(body, moment) if not body.is_ground:
                center = model.bodies[body.name].center
                result.append((Arrow(name, "force", "moment", body.name, center, role, k), state and moment))
            case JointForce(joint, value):
                place, number = model.joints[joint.name], joint_link(model, action)
                link = model.links[number]
                if not (link.turns_only or link.slides_only):  # on a screw it is a force and a moment
                    continue
                if state:
                    value = scale(value, apply(rotation(model, state, number), state.vector(link.axis)))
                kind = "moment" if link.turns_only else "force"
                arrow = Arrow(name, "force", kind, place.child, place.to, role, k)
                result.append((arrow, state and value))
    return result


def moving_points(model: Model, state: State) -> dict[str, Vector]:
    """Points of the arrows that move over bodies, in ground axes [m], by the keys of the arrows.

    A rolling wheel touches its plane at c - r (n - (n·a) a) / |n - (n·a) a|, with centre c, radius r and axis a of the
    wheel, and the normal n of the plane.
    """
    postures, result = poses(model, state), {}
    for name in model.loads:
        for k, action in enumerate(actions(model, state, name)):
            match action:
                case PointForce(Spot(body, position)) if not body.is_ground:
                    result[f"force force {name} {k}"] = position
    for name, wheel in model.constraints.items():
        if not isinstance(wheel, Rolling):
            continue
        posture = postures[wheel.center.body.name]
        n = state.vector(wheel.normal[1])
        down = n
        if wheel.axis is not None:
            a = apply(posture.rotation, state.vector(wheel.axis))
            down = add(n, scale(-dot(a, n), a))
        length = state.field.sqrt(dot(down, down))
        center = add(posture.position, apply(posture.rotation, state.vector(wheel.center.components)))
        result[f"reaction force {name} 0"] = add(center, scale(-divide(state(wheel.radius), length), down))
    return result
