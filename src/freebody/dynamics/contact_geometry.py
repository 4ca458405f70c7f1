"""The geometry of a contact of two shapes at a state, and the normal force of a compliant one, for any scalar.

P on the feature and Q on the surface are the nearest points, n is the unit normal from Q to P, and

    g = n·(r_P - r_Q),     g' = n·(v_P - v_Q),     N = N(d, d'),  d = -g
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ..describe.contacts.normal_law import DEPTH, RATE
from ..describe.shapes.shape import law
from ..model.contact import Contact
from ..model.model import GROUND, Model
from ..scalar.algebra import (
    IDENTITY,
    Field,
    Scalar,
    Vector,
    add,
    apply,
    apply_transpose,
    cross,
    divide,
    dot,
    is_always_zero,
    negate,
    scale,
    subtract,
)
from .kinematics import Spot, link_postures, place_of, point_velocity, rotation
from .state import State


@dataclass(frozen=True)
class Touch:
    """Geometry of one contact element, in ground axes [m].

    Attributes
    ----------
    gap : scalar
        Distance; negative if the bodies overlap.
    normal : Vector
        Unit normal from the surface to the feature.
    tangents : tuple of Vector
        One in a planar machine, else two; (t1, t2, n) is right-handed.
    on_feature, on_surface : Vector
        The points P and Q.
    reach : tuple of scalars
        For sides with ends: all are 0 or more if the foot of the contact lies between the ends.
    """

    gap: Scalar
    normal: Vector
    tangents: tuple[Vector, ...]
    on_feature: Vector
    on_surface: Vector
    reach: tuple[Scalar, ...] = ()

    @property
    def both_reaches(self) -> tuple[Scalar, Scalar]:
        """Two reaches, 1 where there is none."""
        first, second = (*self.reach, 1, 1)[:2]
        return first, second

    @property
    def undirected(self) -> bool:
        """True if the normal is 0 whatever the values: the shapes have a common centre or axis, and no direction."""
        return all(is_always_zero(x) for x in self.normal)


def touch_of_shapes(model: Model, state: State, contact: Contact) -> Touch:
    """Return the geometry of a contact of two shapes; it is evaluated once per state."""
    key = ("touch", contact.name)
    if key not in state.cache:
        state.cache[key] = _touch(model, state, contact)
    return state.cache[key]


def _touch(model: Model, state: State, contact: Contact) -> Touch:
    feature, surface = contact.feature, contact.surface
    at, swapped = Geometry(model, state, contact.name), contact.swapped
    first, second = (surface, feature) if swapped else (feature, surface)
    known = law(first, second)
    assert known is not None, contact
    P, Q, n, gap, reach = known(at, first, second)
    if swapped:
        P, Q, n = Q, P, negate(n)
    return Touch(gap, n, _tangents(at, contact, n), P, Q, reach)


def velocity_over(model: Model, state: State, contact: Contact) -> Vector:
    """Return the velocity of the feature over the surface where two shapes touch, v_P - v_Q."""
    it = touch_of_shapes(model, state, contact)
    return subtract(
        point_velocity(model, state, Spot(contact.feature.body, it.on_feature)),
        point_velocity(model, state, Spot(contact.surface.body, it.on_surface)),
    )


def normal_force(model: Model, state: State, contact: Contact, touching: bool = False) -> Scalar:
    """Return the normal force of a compliant contact; ``touching`` says that its depth is not negative.

    Otherwise a negative depth counts as 0.
    """
    values = law_values(model, state, contact)
    return state.with_values(contact.normal_force, values if touching else pressing(state, values))


def law_values(model: Model, state: State, contact: Contact) -> dict[Any, Scalar]:
    """Return the depth of a contact and its rate, by their names in a law of the normal force."""
    it = touch_of_shapes(model, state, contact)
    return {DEPTH: -it.gap, RATE: -dot(it.normal, velocity_over(model, state, contact))}


def pressing(state: State, values: Mapping[Any, Scalar]) -> dict[Any, Scalar]:
    """Return these values with 0 for a negative depth."""
    depth = values[DEPTH]
    return {**values, DEPTH: (depth + state.field.apply("abs", depth)) / 2}


class Geometry:
    """The machine at a state, as the shapes of :mod:`freebody.describe.shapes` ask for it."""

    def __init__(self, model: Model, state: State, name: str) -> None:
        self.model, self.state, self.field, self.name = model, state, state.field, name

    def __call__(self, expression: Any) -> Scalar:
        """Return the value of an expression."""
        return self.state(expression)

    def of(self, expression: Any, values: Mapping[Any, Scalar]) -> Scalar:
        """Return the value of an expression with values for names of its own."""
        return self.state.with_values(expression, values)

    def place(self, body: Any, components: Sequence[Scalar]) -> Vector:
        """Return the position, in ground axes, of a place given in body axes."""
        link, origin = place_of(self.model, body)
        p = self.state.vector(tuple(a + b for a, b in zip(origin, components, strict=True)))
        if link == GROUND:
            return p
        posture = link_postures(self.model, self.state)[link]
        return add(posture.position, apply(posture.rotation, p))

    def turned(self, body: Any, components: Sequence[Any]) -> Vector:
        """Return a direction, given in body axes by expressions, in ground axes."""
        link, _ = place_of(self.model, body)
        return apply(rotation(self.model, self.state, link), self.state.vector(components))

    def within(self, body: Any, v: Vector) -> Vector:
        """Return a direction, given in ground axes, in body axes."""
        link, _ = place_of(self.model, body)
        return apply_transpose(rotation(self.model, self.state, link), v)

    def outward(self, body: Any, v: Vector) -> Vector:
        """Return a direction, given in body axes by values, in ground axes."""
        link, _ = place_of(self.model, body)
        return apply(rotation(self.model, self.state, link), v)


def _tangents(at: Geometry, contact: Contact, n: Vector) -> tuple[Vector, ...]:
    if contact.planar is not None:
        return (cross(n, contact.planar),)
    if contact.along is not None:
        a = at.turned(contact.surface.body, contact.along)
        level = subtract(a, scale(dot(a, n), n))
        first = scale(divide(1, at.field.sqrt(dot(level, level))), level)
        return first, cross(n, first)
    shape = max((contact.surface, contact.feature), key=lambda shape: shape.precedence)
    if shape.precedence > 0:
        return shape.tangents(at, n, shape is contact.feature)
    return _upright(at.field, n, contact.upright)


def _upright(field: Field, n: Vector, up: Vector) -> tuple[Vector, Vector]:
    """Return the axes at right angles to ``up``, turned with it, or with its opposite, to n the short way.

    Source: T. Duff and others, Building an orthonormal basis, revisited, J. Computer Graphics Techniques 6 (2017) 1-8.
    """
    k = up.index(1)
    e1, e2 = IDENTITY[(k + 1) % 3], IDENTITY[(k + 2) % 3]
    x, y, z = dot(n, e1), dot(n, e2), dot(n, up)
    side = field.apply("sign", z)
    s = side + 1 - side * side  # 1 at z = 0
    share = divide(1, 1 + s * z)
    first = add(add(scale(1 - x * x * share, e1), scale(-(x * y * share), e2)), scale(-(s * x), up))
    second = add(add(scale(-(s * x * y * share), e1), scale(s * (1 - y * y * share), e2)), scale(-y, up))
    return first, second
