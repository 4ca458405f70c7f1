"""A tyre: the road's force on a wheel that may slip, by a linear law or by Pacejka's magic formula.

With the axle a, the road's normal n, e = (n × a)/|n × a| along the wheel, s = n × e across it, the velocity V of the
centre and V_s of the wheel's lowest point,

    κ = -V_s·e/|V·e|,        σ = -V_s·s/|V·e|        (σ = tan of the slip angle)

    F = F_z (f_e(κ) g(σ) e + f_s(σ) g(κ) s)
    f(x) = C x,   or   f(x) = μ sin(C atan(B x - E (B x - atan(B x))))
    g(x) = cos(atan(B_g x)) = 1/sqrt(1 + (B_g x)²)

F_z is the vertical load, given or of a spring and damper between the road and the wheel's lowest point, which leaves
the road. Camber thrust, aligning moment and the time that slip needs to build up are not described. The slips have no
value for a wheel at rest, V·e = 0.

Source: Pacejka, Tyre and Vehicle Dynamics (2006), §1.2, 4.3.1 and 4.3.2.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from ...errors import ModelError, shown
from ...scalar.algebra import Expression, Scalar, Vector, divide
from ..axes import UNIT, direction
from ..constants import default_value
from ..description import Description
from ..frame import Frame, Point
from ..part import Constant, add
from .action import Action, PointForce
from .load import Load

NORMALS = ("x", "y", "z", "-x", "-y", "-z")


class Tyre(Load, kind="tyre"):
    """A tyre on a plane road: its stiffness along and across, or the peak and the shape (B, C, E) of the formula."""

    point: Point  # centre of the wheel
    axis: Vector  # of the axle, a unit vector in the body's axes
    radius: Constant = 0  # [m]
    lateral: Constant = 0  # C or μ
    lateral_shape: Vector | None = None  # (B, C, E)
    longitudinal: Constant = 0
    longitudinal_shape: Vector | None = None
    interaction: Constant = 0  # B_g
    load: Expression = None  # F_z [N]
    stiffness: Constant = None  # of the spring under the wheel [N/m]
    damping: Constant = 0  # [N s/m]
    normal: str = "y"
    road: Point | None = None

    units = {"radius": "m", "load": "N", "stiffness": "N/m", "damping": "N s/m"}
    noun = "tyre"
    words = {"point": "wheel"}
    switches = ("touches the road", "leaves the road")

    def check(self) -> None:
        """Refuse a tyre without a force, a load of two sources, and a road that is not fixed."""
        system: Any = self.point.body.system
        if self.point.body.is_ground:
            raise ModelError(f"The wheel of {self.title} is the ground. Name the body that rolls.")
        if self.lateral == 0 and self.longitudinal == 0:
            raise ModelError(f"{self.heading} has no force: give lateral= or longitudinal=, or both.")
        if (self.load is None) == (self.stiffness is None):
            raise ModelError(
                f"Expected either load= (the vertical load in N) or stiffness= (of the tyre on the road in N/m) of "
                f"{self.title}, got {'neither' if self.load is None else 'both'}."
            )
        if self.normal not in NORMALS:
            raise ModelError(
                f"Expected 'x', 'y' or 'z', with or without a minus, for the normal of {self.title}, got "
                f"{shown(self.normal)}."
            )
        if self.road is not None and not self.road.body.is_ground:
            raise ModelError(f"The road of {self.title} must be a point of the ground, got a {self.road!r}.")
        for name in ("lateral", "longitudinal", "stiffness", "damping", "radius", "interaction"):
            value = getattr(self, name)
            number = None if value is None else default_value(system, value)
            if number is not None and number < 0:
                raise ModelError(f"Expected 0 or more for {name}= of {self.title}, got {number:g}.")
        if self.stiffness is not None and self.radius == 0:
            raise ModelError(f"{self.heading} stands on the road by its stiffness=, so it needs a radius=.")

    def actions(self, at: Any) -> Iterator[Action]:
        """Yield the force of the road at the wheel's lowest point."""
        body, road = self.point.body, self.road
        sign = -1 if self.normal.startswith("-") else 1
        n = at.vector(tuple(sign * x for x in UNIT[self.normal[-1]]))
        a = at.vector(self.axis, body)
        lean = n.dot(a)
        up = divide(1, at.sqrt(1 - lean * lean)) * (n - lean * a)  # in the wheel's plane
        e = up.cross(a)
        s = n.cross(e)
        height = n.dot(
            at.position(self.point) if road is None else at.position(self.point) - at.position(road)
        )
        v = at.velocity(self.point)
        pressed = 0 * n
        if self.stiffness is None:
            load, arm = at(self.load), at(self.radius)
        else:
            arm = divide(height, n.dot(up))
            depth = at(self.radius) - arm
            push = at(self.stiffness) * depth - at(self.damping) * n.dot(v)
            load = at.where(depth, at.max(push, 0), 0)
            pressed = load * n
        slipping = v - arm * at.angular_velocity(body).cross(up)
        rolling = at.abs(v.dot(e))
        along, across = (divide(-slipping.dot(x), rolling) for x in (e, s))
        force = pressed
        if self.longitudinal != 0:
            size = self._law(at, self.longitudinal, self.longitudinal_shape, along)
            force = force + load * size * self._share(at, across) * e
        if self.lateral != 0:
            size = self._law(at, self.lateral, self.lateral_shape, across)
            force = force + load * size * self._share(at, along) * s
        yield PointForce(at.spot(body, at.position(self.point) - arm * up), force)

    @staticmethod
    def _law(at: Any, factor: Expression, shape: Vector | None, slip: Scalar) -> Scalar:
        """Return the force per load at a slip."""
        if shape is None:
            return at(factor) * slip
        B, C, E = (at(x) for x in shape)
        x = B * slip
        return at(factor) * at.sin(C * at.atan(x - E * (x - at.atan(x))))

    def _share(self, at: Any, other: Scalar) -> Scalar:
        """Return the part of a force that is left beside the slip in the other direction."""
        if self.interaction == 0 or self.lateral == 0 or self.longitudinal == 0:
            return 1
        x = at(self.interaction) * other
        return divide(1, at.sqrt(1 + x * x))


def tyre(
    system: Description,
    name: str,
    wheel: Any,
    *,
    axis: Any,
    radius: Expression = 0,
    lateral: Any = 0,
    longitudinal: Any = 0,
    interaction: Expression = 0,
    load: Expression = None,
    stiffness: Expression = None,
    damping: Expression = 0,
    normal: str = "y",
    road: Any = None,
) -> Load:
    """Add the force of a plane road on the tyre of a wheel that may slip.

    Parameters
    ----------
    name : str
    wheel : Body (its origin) or Point
        Centre of the wheel, on a body that spins, or on one that is only steered (then without ``longitudinal``).
    axis : 'x', 'y', 'z' or three components
        The axle in the body's axes.
    radius : expression [m]
        Height of the centre over the road, or with ``stiffness`` that of the wheel that does not press.
    lateral, longitudinal : expression, or four of them
        Cornering stiffness per load [1/rad] and slip stiffness per load; or (B, C, μ, E) of Pacejka's formula, with the
        peak μ F_z. The slips are the tangent of the slip angle, and κ.
    interaction : expression
        B_g: the force along falls with cos(atan(B_g σ)), that across with cos(atan(B_g κ)); 0 leaves them independent.
    load : expression [N]
        F_z, if it is known. The road's vertical force itself is then not added.
    stiffness, damping : expressions [N/m, N s/m]
        In place of ``load``: the tyre is a spring and damper on the road, which only pushes.
    normal : 'x', 'y', 'z', '-x', '-y' or '-z'
        Ground axis at right angles to the road, pointing from the road to the wheel.
    road : Point of the ground, optional
        A point of the road; by default the ground's origin.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("braked wheel on a trolley of constant speed")
    >>> R, V, C, F, M = s.parameters(R=0.3, V=20.0, C=30.0, F=3000.0, M=500.0)
    >>> trolley, wheel = s.body("trolley", fb.particle(1)), s.body("wheel", fb.disk(10, R))
    >>> run = s.slider("run", s.ground, trolley, at=(0, R, 0), axis="x", coordinate=V * s.t)
    >>> hub = s.hinge("hub", trolley, wheel, axis="z", coordinate="phi")
    >>> road = s.tyre("road", wheel, axis="z", radius=R, longitudinal=C, load=F)
    >>> brake = s.torque("brake", hub, M)
    >>> spin = fb.simulate(s, 5, initial={"phi'": "-V/R"})["phi'"][-1]
    >>> print(abs(round(spin + 20 / 0.3 * (1 - 500 / (0.3 * 30 * 3000)), 6)))  # a slip of M/(R C F)
    0.0
    """
    point = wheel.origin if isinstance(wheel, Frame) else wheel
    if not isinstance(point, Point):
        raise ModelError(f"Expected a body or a point for the wheel of tyre '{name}', got {shown(wheel)}.")
    across, shape = _parts(lateral, f"lateral= of tyre '{name}'")
    along, other = _parts(longitudinal, f"longitudinal= of tyre '{name}'")
    axle = direction(system, axis, f"the axis of tyre '{name}'")
    part = Tyre(
        point, axle, radius, across, shape, along, other, interaction, load, stiffness, damping, normal, road
    )
    return add(system, name, part)


def _parts(law: Any, what: str) -> tuple[Any, Any]:
    """Return the factor and the shape of a law, which is None for a linear one."""
    if not isinstance(law, Sequence) or isinstance(law, str):
        return law, None
    if len(law) != 4:
        raise ModelError(
            f"Expected one stiffness or the four numbers (B, C, μ, E) for {what}, got {shown(law)}."
        )
    B, C, mu, E = law
    return mu, (B, C, E)
