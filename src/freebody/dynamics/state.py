"""A model at an instant: its scalars, and the pose and motion of each joint evaluated once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from typing import TYPE_CHECKING, Any

from ..describe.joints.primitive import Primitive
from ..errors import ModelError, TooManyTermsError
from ..model.model import Link, Model
from ..scalar.algebra import (
    IDENTITY,
    ZERO,
    Expression,
    Field,
    Matrix,
    Scalar,
    Vector,
    add,
    apply,
    apply_transpose,
    cross,
    floats,
    multiply,
    scale,
)
from ..scalar.expression import evaluate
from ..space.quaternion import matrix_from_quaternion
from ..space.spatial import Inertia, Spatial, rigid_inertia
from ..space.turn import matrix_about

if TYPE_CHECKING:
    from ..scalar.polynomial import Ring
    from ..scalar.trace import Tape


class State:
    """Time, coordinates, speeds and parameters of a model as scalars of one field.

    Made by :func:`float_state`, :func:`polynomial_state` or :func:`traced_state`. The quantities of a joint are
    evaluated at first use and stored; otherwise a state never changes.
    """

    def __init__(
        self,
        model: Model,
        field: Field,
        t: Scalar,
        q: Sequence[Scalar],
        u: Sequence[Scalar],
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
        self.accelerations: Sequence[Spatial] | None = None
        """Angular acceleration of each link and acceleration of its origin, in its axes, if loads are to know them."""

    def __call__(self, expression: Expression) -> Scalar:
        """Return the value of an expression of the model's names."""
        return evaluate(expression, self._memo, self.field, self._memo)

    def with_values(self, expression: Expression, values: Mapping[Any, Scalar]) -> Scalar:
        """Return the value of an expression with further symbols, which have these values."""
        names = {**self._memo, **values}
        return evaluate(expression, names, self.field, names)

    def accelerated(self, accelerations: Sequence[Spatial]) -> State:
        """Return the state with these accelerations of the links; its loads are asked anew."""
        result = copy(self)
        result.accelerations = accelerations
        result.cache = {key: self.cache[key] for key in ("postures", "velocities") if key in self.cache}
        return result

    def vector(self, components: Sequence[Expression]) -> Vector:
        """Return the values of three expressions."""
        x, y, z = components
        return (self(x), self(y), self(z))

    def matrix(self, rows: Sequence[Sequence[Expression]]) -> Matrix:
        """Return the values of nine expressions."""
        a, b, c = rows
        return (self.vector(a), self.vector(b), self.vector(c))

    def inertia(self, i: int) -> Inertia:
        """Return the inertia of link ``i`` about its origin, in its axes."""
        if i not in self._inertias:
            link = self.model.links[i]
            self._inertias[i] = rigid_inertia(
                self(link.mass), self.vector(link.center), self.matrix(link.inertia)
            )
        return self._inertias[i]

    def joint(self, i: int) -> tuple[Matrix, Vector, Spatial]:
        """Return the pose of link ``i`` and its motion relative to its parent.

        They are the rotation (parent from link), the position of its origin from the parent's in parent axes, and the
        relative motion in the link's axes.
        """
        if i not in self._joints:
            self._joints[i] = self._evaluate_joint(self.model.links[i])
        return self._joints[i]

    def _evaluate_joint(self, link: Link) -> tuple[Matrix, Vector, Spatial]:
        E, r = self.matrix(link.rotation), self.vector(link.position)
        if link.fixed:
            return (E, r, (ZERO, ZERO))
        if link.pivots:
            return ball_joint(E, r, self.q[link.q : link.q + 4], self.u[link.u : link.u + 3])
        if link.flies:
            return free_joint(E, r, self.q[link.q : link.q + 7], self.u[link.u : link.u + 6])
        n, y = self.vector(link.axis), self(link.displacement)
        turn = matrix_about(n, y, self.field) if link.motion.turns else IDENTITY
        return one_dof_joint(link.motion, E, r, n, self(link.pitch), y, self.rate(link), turn)

    def rate(self, link: Link) -> Scalar:
        """Return dy/dt of a 1-dof link."""
        total = self(link.drift)
        for j, partial in link.partials:
            total = total + self(partial) * self.u[j]
        return total

    def second_rate(self, link: Link, udot: Sequence[Scalar] | None) -> Scalar:
        """Return d²y/dt² of a 1-dof link; with ``udot`` None, the part free of accelerations."""
        total = self(link.bias)
        if udot is not None:
            for j, partial in link.partials:
                total = total + self(partial) * udot[j]
        return total

    def armature(self, i: int) -> tuple[Scalar, ...]:
        """Return the inertia that each speed of link ``i`` alone moves; () if there is none."""
        return tuple(self(x) for x in self.model.links[i].armature)

    def spin(self, i: int) -> tuple[Vector, Vector] | None:
        """Return the angular momentum of rotors in the parent of link ``i`` per unit rate of its displacement.

        Its components are in the parent's axes, and in those of the link. None if there is no rotor.
        """
        link = self.model.links[i]
        if link.rotor == ZERO:
            return None
        s = self.vector(link.rotor)
        of_parent = apply(self.matrix(link.rotation), s)
        if link.slides_only or all(x == 0 for x in cross(link.rotor, link.axis)):
            return of_parent, s  # the joint does not turn it
        return of_parent, apply_transpose(self.joint(i)[0], of_parent)

    def intermediate(self, what: str, of: Any, value: Any) -> Any:
        """Return a velocity, acceleration or force of a link, or span and pull of a load, for further use: unchanged.

        A state that names long quantities returns their names (`symbolic.recursive`).
        """
        return value

    def subspace(self, i: int) -> Spatial:
        """Return the motion of a 1-dof link per unit rate, which is constant in its axes."""
        link = self.model.links[i]
        return unit_motion(link.motion, self.vector(link.axis), self(link.pitch))


def ball_joint(
    E: Matrix, r: Vector, e: Sequence[Scalar], w: Sequence[Scalar]
) -> tuple[Matrix, Vector, Spatial]:
    """Return pose and motion of a ball joint, as :meth:`State.joint`."""
    a, b, c, d = e
    x, y, z = w
    return (multiply(E, matrix_from_quaternion((a, b, c, d))), r, ((x, y, z), ZERO))


def free_joint(
    E: Matrix, r: Vector, q: Sequence[Scalar], u: Sequence[Scalar]
) -> tuple[Matrix, Vector, Spatial]:
    """Return pose and motion of a free joint, as :meth:`State.joint`."""
    x, y, z, *e = q
    a, b, c, d = e
    R = matrix_from_quaternion((a, b, c, d))
    wx, wy, wz, vx, vy, vz = u
    return (multiply(E, R), add(r, apply(E, (x, y, z))), ((wx, wy, wz), (vx, vy, vz)))


def unit_motion(motion: type[Primitive], n: Vector, pitch: Scalar) -> Spatial:
    """Return the motion per unit rate of a displacement along n: a turn, a slide, or a turn that advances."""
    if not motion.turns:
        return (ZERO, n)
    return (n, scale(pitch, n) if motion.slides else ZERO)


def one_dof_joint(
    motion: type[Primitive],
    E: Matrix,
    r: Vector,
    n: Vector,
    pitch: Scalar,
    y: Scalar,
    rate: Scalar,
    turn: Matrix,
) -> tuple[Matrix, Vector, Spatial]:
    """Return pose and motion of a hinge, slider or screw with displacement y along n, as :meth:`State.joint`.

    ``turn`` is the rotation about n by y, of those that turn.
    """
    if not motion.turns:
        return (E, add(r, apply(E, scale(y, n))), (ZERO, scale(rate, n)))
    R = multiply(E, turn)
    if not motion.slides:
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
    """Return a state of Python floats; without ``q`` all coordinates are zero (unit quaternions the identity)."""
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


def state_at(model: Model, y: Any, t: float = 0, values: Mapping[Any, Any] | None = None) -> State:
    """Return a state of Python floats from an array that begins with (q, u)."""
    n_q, n = model.n_q, model.n_q + model.n_u
    return float_state(model, y[:n_q].tolist(), y[n_q:n].tolist(), t, values)


def rest_coordinates(model: Model) -> list[int]:
    """Return all coordinates as zero, unit quaternions as the identity."""
    q = [0] * model.n_q
    for i in model.quaternions:
        q[i] = 1
    return q


def traced_state(model: Model, tape: Tape) -> State:
    """Return a state of inputs of a recorded program: t, q, u and the parameters, by name."""
    t = tape.input("t")
    q = [tape.input(coordinate.name) for coordinate in model.coordinates]
    u = [tape.input(speed.name) for speed in model.speeds]
    values = {parameter.symbol: tape.input(parameter.name) for parameter in model.parameters}
    return State(model, tape, t, q, u, values)


NAME_CURE = "Give it a name: make it a parameter of its own, with this value. Numbers bear it: fb.simulate, fb.compile."
"""Cure for an expression of parameters that is too long."""


def polynomial_state(model: Model, ring: Ring) -> State:
    """Return a state of exact symbols."""
    for expression in model.positive:
        try:
            ring.assume_positive(expression)
        except TooManyTermsError as error:
            raise TooManyTermsError(f"In {str(expression)[:60]}: {error.reason}", NAME_CURE) from None
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
