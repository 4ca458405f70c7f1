"""Kinds of a package of its own: two loads, two joints, a contact, a shape and a method of integration."""

import sympy

import freebody as fb

NOTHING = None


class Gust(fb.Load, kind="gust"):
    """-k |v - w| (v - w) with the wind w (1 + sin(ω t))/2."""

    point: fb.Point
    factor: fb.Expression  # k
    wind: fb.Vector  # w, at its strongest
    rate: fb.Expression = 1  # ω

    units = {"factor": "N s^2/m^2", "wind": "m/s", "rate": "rad/s"}

    def actions(self, at):
        strength = (1 + at.sin(at(self.rate) * at.t)) / 2
        v = at.velocity(self.point) - strength * at.vector(self.wind)
        yield fb.PointForce(self.point, -at(self.factor) * v.norm() * v)


class Water(fb.Load, kind="water"):
    """The water that a sphere of the displaced mass ρ V moves along: ρ V/2."""

    point: fb.Point
    displaced: fb.Expression  # ρ V [kg]

    def actions(self, at):
        yield fb.PointForce(self.point, -at(self.displaced) / 2 * at.acceleration(self.point))


class Bowl(fb.Gap, kind="bowl"):
    """A point in a bowl of the ground, z = c (x² + y²)/2, with friction."""

    point: fb.Point
    curvature: fb.Expression  # c

    directions = 2

    def _shape(self, at):
        """The place, and the normal with the third component 1."""
        p, c = at.position(self.point), at(self.curvature)
        return p, at.vector((0, 0, 1)) - c * p.x * at.vector((1, 0, 0)) - c * p.y * at.vector((0, 1, 0))

    def gap(self, at):
        p, n = self._shape(at)
        return (p.z - at(self.curvature) * (p.x * p.x + p.y * p.y) / 2) / n.norm()

    def _pair(self, at, v):
        ground = self.point.body.system.ground
        yield fb.PointForce(self.point, v / v.norm())
        yield fb.PointForce(at.spot(ground, at.position(self.point)), -v / v.norm())

    def normal(self, at):
        yield from self._pair(at, self._shape(at)[1])

    def tangents(self, at):
        _, n = self._shape(at)
        first = n.cross((0, 1, 0))
        return self._pair(at, first), self._pair(at, n.cross(first))


class Puck(fb.ContactShape, kind="puck"):
    """A ball at a height over the origin of its body."""

    radius: fb.Expression
    height: fb.Expression = 0

    def support(self, at, direction):
        x, y, z = at.place(self.body, (0, 0, self.height))
        r = at(self.radius)
        return x + r * direction[0], y + r * direction[1], z + r * direction[2]


class Leg(fb.Joint, kind="leg"):
    """A hip and a knee in one joint, with a thigh without mass between them."""

    thigh: fb.Expression  # length [m]

    endings = ("hip", "knee")

    def motions(self):
        yield fb.Hinge("z")
        yield fb.Hinge("z", at=(0, -self.thigh, 0))


class Cycloid(fb.Joint, kind="cycloid"):
    """A bead on the cycloid x = a (φ + sin φ), y = -a cos φ, which turns with its tangent by φ/2."""

    radius: fb.Expression  # a [m]

    endings = ("phi",)

    def pose(self, phi):
        a = self.radius
        return (a * (phi + sympy.sin(phi)), -a * sympy.cos(phi), 0), [("z", phi / 2)]


bogacki = fb.RungeKutta(  # of Bogacki and Shampine, order 3(2)
    "bogacki",
    order=3,
    stages=[[1 / 2], [0, 3 / 4]],
    weights=[2 / 9, 1 / 3, 4 / 9],
    embedded=[7 / 24, 1 / 4, 1 / 3, 1 / 8],
)
