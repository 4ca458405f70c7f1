"""A model at an instant: its scalars, and the pose and motion of each joint evaluated once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ..errors import ModelError, TooManyTermsError
from ..model.model import Link, Model
from ..scalar.algebra import ZERO, Field, Matrix, Vector, add, apply, floats, multiply, scale
from ..scalar.expression import evaluate
from ..space.quaternion import matrix_from_quaternion
from ..space.spatial import Inertia, Spatial, rigid_inertia
from ..space.turn import matrix_about

if TYPE_CHECKING:
    from ..scalar.polynomial import Ring
    from ..scalar.trace import Tape


class State:
    """Time, coordinates, speeds and parameters of a model as scalars of one field.

    Made by :func:`float_state`, :func:`polynomial_state` or :func:`traced_state`. What is asked of a joint is
    evaluated once and remembered; otherwise a state never changes.
    """

    def __init__(
        self,
        model: Model,
        field: Field,
        t: Any,
        q: Sequence[Any],
        u: Sequence[Any],
        values: Mapping[Any, Any],
    ) -> None:
        self.model = model
        self.field = field
        self.t = t
        self.q = tuple(q)
        self.u = tuple(u)
        self.values = values
        self._memo: dict[Any, Any] = {**values, model.names.atoms["t"]: t}
        self._memo.update(zip((c.symbol for c in model.coordinates), self.q, strict=True))
        self._memo.update(zip((s.symbol for s in model.speeds), self.u, strict=True))
        self._joints: dict[int, tuple[Matrix, Vector, Spatial]] = {}
        self._inertias: dict[int, Inertia] = {}
        self.cache: dict[Any, Any] = {}
        """Results of algorithms on this state, by the algorithm's name."""

    def __call__(self, expression: Any) -> Any:
        """The value of an expression of the model's names."""
        return evaluate(expression, self._memo, self.field, self._memo)

    def vector(self, components: Sequence[Any]) -> Vector:
        """Three expressions evaluated."""
        x, y, z = components
        return (self(x), self(y), self(z))

    def matrix(self, rows: Sequence[Sequence[Any]]) -> Matrix:
        """Nine expressions evaluated."""
        a, b, c = rows
        return (self.vector(a), self.vector(b), self.vector(c))

    def inertia(self, i: int) -> Inertia:
        """Inertia of link ``i`` about its origin, in its axes."""
        if i not in self._inertias:
            link = self.model.links[i]
            self._inertias[i] = rigid_inertia(
                self(link.mass), self.vector(link.center), self.matrix(link.inertia)
            )
        return self._inertias[i]

    def joint(self, i: int) -> tuple[Matrix, Vector, Spatial]:
        """Of link ``i``: rotation (parent from link), position of its origin from the parent's in parent
        axes, and its motion relative to the parent in its own axes."""
        if i not in self._joints:
            self._joints[i] = self._evaluate_joint(self.model.links[i])
        return self._joints[i]

    def _evaluate_joint(self, link: Link) -> tuple[Matrix, Vector, Spatial]:
        E, r = self.matrix(link.rotation), self.vector(link.position)
        if link.kind == "weld":
            return (E, r, (ZERO, ZERO))
        if link.kind == "ball":
            return turned(E, r, self.q[link.q : link.q + 4], self.u[link.u : link.u + 3])
        if link.kind == "free":
            return flown(E, r, self.q[link.q : link.q + 7], self.u[link.u : link.u + 6])
        n = self.vector(link.axis)
        return displaced(
            link.kind, E, r, n, self(link.pitch), self(link.displacement), self.rate(link), self.field
        )

    def rate(self, link: Link) -> Any:
        """dy/dt of a 1-dof link."""
        total = self(link.drift)
        for j, partial in link.partials:
            total = total + self(partial) * self.u[j]
        return total

    def second_rate(self, link: Link, udot: Sequence[Any] | None) -> Any:
        """d²y/dt² of a 1-dof link; with ``udot`` None, the part free of accelerations."""
        total = self(link.bias)
        if udot is not None:
            for j, partial in link.partials:
                total = total + self(partial) * udot[j]
        return total

    def kept(self, what: str, of: Any, value: Any) -> Any:
        """A velocity, acceleration or force of a link, or line and pull of a load, as what follows takes it: unchanged.

        A state in which long quantities are named gives the names (`symbolic.recursive`).
        """
        return value

    def subspace(self, i: int) -> Spatial:
        """Motion of a 1-dof link per unit rate, in its own axes; constant there."""
        link = self.model.links[i]
        n = self.vector(link.axis)
        if link.kind == "slider":
            return (ZERO, n)
        if link.kind == "hinge":
            return (n, ZERO)
        return (n, scale(self(link.pitch), n))


def turned(E: Matrix, r: Vector, e: Sequence[Any], w: Sequence[Any]) -> tuple[Matrix, Vector, Spatial]:
    """A ball joint: see :meth:`State.joint`."""
    a, b, c, d = e
    x, y, z = w
    return (multiply(E, matrix_from_quaternion((a, b, c, d))), r, ((x, y, z), ZERO))


def flown(E: Matrix, r: Vector, q: Sequence[Any], u: Sequence[Any]) -> tuple[Matrix, Vector, Spatial]:
    """A free joint: see :meth:`State.joint`."""
    x, y, z, *e = q
    a, b, c, d = e
    R = matrix_from_quaternion((a, b, c, d))
    wx, wy, wz, vx, vy, vz = u
    return (multiply(E, R), add(r, apply(E, (x, y, z))), ((wx, wy, wz), (vx, vy, vz)))


def displaced(
    kind: str, E: Matrix, r: Vector, n: Vector, pitch: Any, y: Any, rate: Any, field: Field
) -> tuple[Matrix, Vector, Spatial]:
    """A hinge, slider or screw with displacement y along n: see :meth:`State.joint`."""
    if kind == "slider":
        return (E, add(r, apply(E, scale(y, n))), (ZERO, scale(rate, n)))
    R = multiply(E, matrix_about(n, y, field))
    if kind == "hinge":
        return (R, r, (scale(rate, n), ZERO))
    advance = scale(pitch, n)
    return (R, add(r, apply(E, scale(y, advance))), (scale(rate, n), scale(rate, advance)))


def float_state(
    model: Model,
    q: Sequence[float] | None = None,
    u: Sequence[float] | None = None,
    t: float = 0,
    values: Mapping[Any, Any] | None = None,
) -> State:
    """A state of Python floats; without ``q`` all coordinates are zero (unit quaternions the identity)."""
    numbers = model.values(values)
    if q is None:
        q = rest_coordinates(model)
    u = [0] * model.n_u if u is None else u
    if len(q) != model.n_q or len(u) != model.n_u:
        raise ModelError(
            f"Expected {model.n_q} coordinates {model.coordinate_names} and {model.n_u} speeds {model.speed_names}, "
            f"got {len(q)} and {len(u)}."
        )
    symbols = {parameter.symbol: numbers[parameter.name] for parameter in model.parameters}
    return State(model, floats, t, [*map(float, q)], [*map(float, u)], symbols)


def rest_coordinates(model: Model) -> list[int]:
    """All coordinates zero, unit quaternions the identity."""
    q = [0] * model.n_q
    for i in model.quaternions:
        q[i] = 1
    return q


def traced_state(model: Model, tape: Tape) -> State:
    """A state of inputs of a recorded program: t, q, u and the parameters, by name."""
    t = tape.input("t")
    q = [tape.input(coordinate.name) for coordinate in model.coordinates]
    u = [tape.input(speed.name) for speed in model.speeds]
    values = {parameter.symbol: tape.input(parameter.name) for parameter in model.parameters}
    return State(model, tape, t, q, u, values)


NAMED = "Give it a name: make it a parameter of its own, with this value. Numbers bear it: fb.simulate, fb.compile."
"""Cure of an expression of parameters that is too long."""


def polynomial_state(model: Model, ring: Ring) -> State:
    """A state of exact symbols."""
    for expression in model.positive:
        try:
            ring.assume_positive(expression)
        except TooManyTermsError as error:
            raise TooManyTermsError(f"In {str(expression)[:60]}: {error.reason}", NAMED) from None
    values = {
        parameter.symbol: ring.generator(parameter.symbol, "parameter") for parameter in model.parameters
    }
    t = ring.generator(model.names.atoms["t"], "time")
    q = [
        ring.generator(c.symbol, "quaternion" if c.kind == "quaternion" else "coordinate")
        for c in model.coordinates
    ]
    u = [ring.generator(speed.symbol, "speed") for speed in model.speeds]
    for i in model.quaternions:
        ring.unit_norm(*q[i : i + 4])
    return State(model, ring, t, q, u, values)
