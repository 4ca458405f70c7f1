"""A bushing: a spring and damper in all six directions between a point of a body and a point of another.

In the axes of the first body, with the displacement d of the second point from the first and the angles α of the second
body about x, the turned y and its own z (as in a gimbal "XYZ", so that angles may be large),

F = -K d - C d',        τ_i = -k_i α_i - c_i α_i',        V = ½ d·K d + ½ Σ k_i α_i²

The moment is Σ τ_i g_i, where g is the basis dual to the three axes; it has the power Σ τ_i α_i'.

Source: the angles are those of :meth:`System.gimbal`; the basis dual to their axes follows from R.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from ...errors import ModelError
from ...scalar.algebra import HALF, FieldVector, Scalar, Vector, divide, multiply, transpose
from ..description import Description, varying
from ..frame import Point
from ..part import add
from .action import Action, Couple, PointForce
from .load import Load
from .straight import check_ends


class Bushing(Load, kind="bushing"):
    """A six-dimensional linear spring and damper between two bodies, along the axes of the first."""

    start: Point
    end: Point
    stiffness: Vector = (0, 0, 0)  # k_x, k_y, k_z [N/m]
    damping: Vector = (0, 0, 0)  # [N s/m]
    turning_stiffness: Vector = (0, 0, 0)  # about x, y, z [N m/rad]
    turning_damping: Vector = (0, 0, 0)  # [N m s/rad]

    units = {
        "stiffness": "N/m", "damping": "N s/m", "turning_stiffness": "N m/rad", "turning_damping": "N m s",
    }  # fmt: skip
    noun = "bushing"
    words = {"start": "from", "end": "to"}

    def check(self) -> None:
        """Refuse two ends on one body, and stiffness that changes during a motion."""
        check_ends(self.start, self.end, self.title)
        system = self.start.body.system
        for name in ("stiffness", "damping", "turning_stiffness", "turning_damping"):
            for value in getattr(self, name):
                moving = varying(system, value)
                if moving:
                    raise ModelError(
                        f"The {name} of {self.title} must be constant, but it depends on {', '.join(moving)}. Write "
                        f"the law as a load of your own (docs/extending.md)."
                    )

    @property
    def is_conservative(self) -> bool:
        """True if it has no damping."""
        return all(x == 0 for x in (*self.damping, *self.turning_damping))

    def _displacement(self, at: Any) -> FieldVector:
        first = self.start.body
        return at.position(self.end, first) - at.position(self.start, first)

    def _turned(self, at: Any) -> tuple[list[Scalar], list[FieldVector]]:
        """Return the three angles and the basis dual to their axes, in the axes of the first body."""
        R = multiply(transpose(at.rotation(self.start.body)), at.rotation(self.end.body))
        a, b, c = R[0][2], R[1][2], R[2][2]  # z of the second body
        across = b * b + c * c  # cos² of the second angle
        root = at.sqrt(across)
        angles = [at.atan2(-b, c), at.atan2(a, root), at.atan2(-R[0][1], R[0][0])]
        dual = [
            (divide(1 - a * a, across), divide(-a * b, across), divide(-a * c, across)),
            (0, divide(c, root), divide(-b, root)),
            (0, divide(b, across), divide(c, across)),
        ]
        return angles, [at.vector(FieldVector(at.field, g)) for g in dual]

    def actions(self, at: Any) -> Iterator[Action]:
        """Yield force and moment on the second body, and their opposites on the first."""
        first, second = self.start.body, self.end.body
        w = at.angular_velocity(first, first)
        if self._slides:
            d = self._displacement(at)
            rate = at.velocity(self.end, first) - at.velocity(self.start, first) - w.cross(d)
            pull = zip(self._values(at, self.stiffness), d, self._values(at, self.damping), rate, strict=True)
            force = at.vector(FieldVector(at.field, _three([-(k * x + c * v) for k, x, c, v in pull])), first)
            yield PointForce(self.end, force)
            yield PointForce(self.start, -force)
            yield Couple(first, -at.vector(d, first).cross(force))
        if self._turns:
            angles, dual = self._turned(at)
            relative = at.angular_velocity(second, first) - w
            moment = at.vector((0, 0, 0))
            stiffness, damping = (
                self._values(at, self.turning_stiffness),
                self._values(at, self.turning_damping),
            )
            for k, c, angle, g in zip(stiffness, damping, angles, dual, strict=True):
                moment = moment - (k * angle + c * g.dot(relative)) * g
            moment = at.vector(moment, first)
            yield Couple(second, moment)
            yield Couple(first, -moment)

    def potential(self, at: Any) -> Scalar:
        """Return ½ d·K d + ½ Σ k_i α_i² [J]."""
        total: Scalar = 0
        if self._slides:
            for k, x in zip(self._values(at, self.stiffness), self._displacement(at), strict=True):
                total = total + HALF * k * x * x
        if self._turns:
            for k, x in zip(self._values(at, self.turning_stiffness), self._turned(at)[0], strict=True):
                total = total + HALF * k * x * x
        return total

    @property
    def _slides(self) -> bool:
        return any(x != 0 for x in (*self.stiffness, *self.damping))

    @property
    def _turns(self) -> bool:
        return any(x != 0 for x in (*self.turning_stiffness, *self.turning_damping))

    def _values(self, at: Any, components: Sequence[Any]) -> list[Scalar]:
        return [at(x) for x in components]


def _three(components: Sequence[Scalar]) -> Vector:
    x, y, z = components
    return (x, y, z)


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

    The angles are those of a gimbal "XYZ" from the first body to the second. They may be large, the second one below
    90°.

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
