"""The machine at a state, as a load or a contact sees it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from numbers import Real
from typing import Any

from ...describe.frame import Frame, Point
from ...describe.part import Part
from ...errors import ModelError, nearest, shown
from ...model.model import GROUND, Link, Model
from ...scalar.algebra import (
    FUNCTIONS,
    HALF,
    ZERO,
    Expression,
    FieldVector,
    Matrix,
    Scalar,
    Vector,
    apply,
    apply_transpose,
    three,
)
from ...space.spatial import Spatial
from ..contact_geometry import Touch, normal_force, touch_of_shapes, velocity_over
from ..kinematics import (
    Spot,
    accelerated,
    angular_velocity,
    place_of,
    point_position,
    point_velocity,
    rotation,
)
from ..state import State


class Instant:
    """The machine at a state, as a load sees it; :class:`freebody.Load` lists what it gives."""

    def __init__(self, model: Model, state: State, load: Part) -> None:
        self._model = model
        self._state = state
        self._load = load
        self.field = state.field
        self.conditions: list[Scalar] = []
        """Conditions of :meth:`where` so far."""
        self.asked_accelerations = False
        """True once an acceleration has been asked for."""

    def __call__(self, expression: Expression) -> Scalar:
        """Return the value of an expression of the system's names, or of a text with them; a value is itself."""
        if isinstance(expression, str):
            expression = self._model.names.expression(expression, self._load.title)
        is_value = not isinstance(expression, Real) and not hasattr(expression, "free_symbols")
        return expression if is_value else self._state(expression)

    def of(self, expression: Expression, values: Mapping[Any, Scalar]) -> Scalar:
        """Return the value of an expression with symbols of its own, which have these values."""
        return self._state.with_values(expression, values)

    def where(self, condition: Scalar, a: Scalar, b: Scalar) -> Scalar:
        """Return a if the condition is greater than zero, else b; both are computed.

        A motion locates the times at which the condition passes through zero; there the value is (a + b)/2.
        """
        self.conditions.append(condition)
        return b + (a - b) * (1 + self._state.field.apply("sign", condition)) * HALF

    def __getattr__(self, function: str) -> Callable[..., Scalar]:
        """Return a function of scalars: ``at.sqrt``, ``at.tanh``, ``at.atan2``."""
        if function not in FUNCTIONS:
            names = [*FUNCTIONS, *(name for name in dir(type(self)) if not name.startswith("_"))]
            raise AttributeError(f"the machine at a state has no '{function}'; {nearest(function, names)}")
        return partial(self._state.field.apply, function)

    @property
    def t(self) -> Scalar:
        """Time [s]."""
        return self._state.t

    def vector(self, components: Any, frame: Any = None) -> FieldVector:
        """Return three components in the axes of a body (by default the ground) as a vector in ground axes.

        The components are expressions or values, or they are a vector of values.
        """
        v = (
            components.components
            if isinstance(components, FieldVector)
            else three(tuple(map(self, components)))
        )
        return self._of(v if self._is_ground(frame) else apply(self.rotation(frame), v))

    def rotation(self, body: Any) -> Matrix:
        """Return the rotation matrix R_NB of a body."""
        return rotation(self._model, self._state, self._place(body)[0])

    def position(self, point: Any, frame: Any = None) -> FieldVector:
        """Return the position of a point from the ground's origin [m]."""
        return self._in(point_position(self._model, self._state, self._point(point)), frame)

    def spot(self, body: Any, position: Any) -> Spot:
        """Return the place on a body that is at a position now, in ground axes; it may move over the body."""
        self._place(body)
        return Spot(body, three(position))

    def velocity(self, point: Any, frame: Any = None) -> FieldVector:
        """Return the velocity of a point in the ground [m/s]."""
        return self._in(point_velocity(self._model, self._state, self._point(point)), frame)

    def angular_velocity(self, body: Any, frame: Any = None) -> FieldVector:
        """Return the angular velocity of a body in the ground [rad/s]."""
        self._place(body)
        return self._in(angular_velocity(self._model, self._state, body), frame)

    def acceleration(self, point: Any, frame: Any = None) -> FieldVector:
        """Return the acceleration of a point in the ground [m/s²]."""
        links = self._accelerations()
        return self._in(accelerated(self._model, self._state, self._point(point), links), frame)

    def angular_acceleration(self, body: Any, frame: Any = None) -> FieldVector:
        """Return the angular acceleration of a body in the ground [rad/s²]."""
        links, (link, _) = self._accelerations(), self._place(body)
        alpha = ZERO if link == GROUND else apply(rotation(self._model, self._state, link), links[link][0])
        return self._in(alpha, frame)

    def _accelerations(self) -> Sequence[Spatial]:
        """Return the accelerations of the links, which the actions of loads alone know."""
        self.asked_accelerations = True
        if self._state.accelerations is None:
            raise ModelError(
                f"{self._load.heading}: only the actions of a load may ask for accelerations, since gaps, potentials "
                f"and forces of contacts are functions of positions and speeds. Leave the acceleration out here; "
                f"the kinetic energy of added mass is counted by itself."
            )
        return self._state.accelerations

    def line(self, start: Any, end: Any) -> FieldVector:
        """Return the vector from a point to another [m]; long formulas give it a name."""
        d = self.position(end) - self.position(start)
        return self._of(self._state.intermediate("line", self._load.name, d.components))

    def named(self, force: Any) -> FieldVector:
        """Return a vector unchanged; long formulas give it the name of the load."""
        return self._of(self._state.intermediate("pull", self._load.name, three(force)))

    def pressed(self, contact: Any) -> tuple[Touch, Vector, Scalar]:
        """Return the geometry of a contact that touches, v_P - v_Q, and the force that the state presses it with [N].

        That is the normal force of a compliant contact, and the adhesion of a rigid one.
        """
        model, state = self._model, self._state
        return (
            touch_of_shapes(model, state, contact),
            velocity_over(model, state, contact),
            normal_force(model, state, contact, touching=True)
            if contact.compliant
            else state(contact.adhesion),
        )

    def displacement(self, joint: Any, index: int = 0) -> Scalar:
        """Return a displacement of a joint [m] or [rad]; ``index`` counts those of a joint that has several."""
        return self._state(self._link(joint, index).displacement)

    def rate(self, joint: Any, index: int = 0) -> Scalar:
        """Return the rate of a displacement of a joint [m/s] or [rad/s]."""
        return self._state.rate(self._link(joint, index))

    def _of(self, v: Vector) -> FieldVector:
        return FieldVector(self._state.field, v)

    def _in(self, v: Vector, frame: Any) -> FieldVector:
        """Return a vector, given in ground axes, in the axes of a body."""
        return self._of(v if self._is_ground(frame) else apply_transpose(self.rotation(frame), v))

    def _is_ground(self, frame: Any) -> bool:
        return frame is None or self._place(frame)[0] == GROUND

    def _point(self, point: Any) -> Point | Spot:
        point = point.origin if isinstance(point, Frame) else point
        if not isinstance(point, Point | Spot):
            raise ModelError(f"{self._load.heading}: expected a point of a body, got {shown(point)}.")
        self._place(point.body)
        return point

    def _place(self, body: Any) -> tuple[int, Vector]:
        return own_place(self._model, self._load, body)

    def _link(self, joint: Any, index: int) -> Link:
        return self._model.links[own_link(self._model, self._load, joint, index)]


def own_place(model: Model, load: Part, body: Any) -> tuple[int, Vector]:
    """Return the link of a body of this machine, and the origin of the body on it."""
    if not isinstance(body, Frame):
        raise ModelError(f"{load.heading}: expected a body, got {shown(body)}.")
    if body.system is not model.described[0] or not (body.is_ground or body.name in model.bodies):
        raise ModelError(
            f"{load.heading}: body '{body.name}' belongs to another system than '{model.name}'. Take bodies and points "
            f"from the data of the load."
        )
    return place_of(model, body)


def own_link(model: Model, load: Part, joint: Any, index: int) -> int:
    """Return the link that a displacement of a joint moves."""
    name = getattr(joint, "name", "")
    place = model.joints.get(name)
    if place is None or model.described[0].joints.get(name) is not joint:
        closes = getattr(joint, "closes", False)
        why = "closes a loop and has no displacement" if closes else f"is not a joint of '{model.name}'"
        raise ModelError(f"{load.heading}: {shown(joint)} {why}. Name a joint of the tree.")
    if not 0 <= index < len(place.links) or not model.links[place.links[index]].one_dof:
        raise ModelError(f"{load.heading}: {shown(joint)} has no displacement {shown(index)}.")
    return place.links[index]
