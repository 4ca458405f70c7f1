"""Loads of a user's own: kinds that no file of the package names."""

from __future__ import annotations

import freebody as fb


class Drag(fb.Load, kind="test_drag"):
    """-k |v| v at a point of a body."""

    point: fb.Point
    factor: fb.Expression  # k [N s²/m²]

    def actions(self, at):
        v = at.velocity(self.point)
        yield fb.PointForce(self.point, -at(self.factor) * v.norm() * v)


class Gravitation(fb.Load, kind="test_gravitation"):
    """Attraction of two points, with its potential -G/d."""

    first: fb.Point
    second: fb.Point
    strength: fb.Expression  # G m1 m2 [N m²]

    def actions(self, at):
        d = at.line(self.first, self.second)
        force = at.named(at(self.strength) / d.norm() ** 3 * d)
        yield fb.PointForce(self.first, force)
        yield fb.PointForce(self.second, -force)

    def potential(self, at):
        return -at(self.strength) / at.line(self.first, self.second).norm()


class Everything(fb.Load, kind="test_everything"):
    """One action of each sort, from all that a load may ask."""

    body: fb.Body
    point: fb.Point
    joint: fb.Joint
    wind: fb.Vector
    c: fb.Expression
    strong: bool = False

    look = fb.Look(role="damper")

    def actions(self, at):
        c = at(self.c) * (2 if self.strong else 1)
        v = at.velocity(self.point, frame=self.body) - self.wind_in_body(at)
        yield fb.Couple(
            self.body, -c * at.angular_velocity(self.body) + at.position(self.point).cross((1, 0, 0))
        )
        yield fb.PointForce(self.point, at.vector(-c * v / 2 + v.dot(v) * v, self.body))
        yield fb.JointForce(
            self.joint, -c * at.tanh(at.rate(self.joint)) - at.sin(at.displacement(self.joint))
        )
        yield fb.GeneralizedForce(self.joint.primitives[0].coordinate, c * at.t)

    def wind_in_body(self, at):
        R = at.rotation(self.body)
        w = at.vector(self.wind)
        return [sum(R[i][k] * w[i] for i in range(3)) for k in range(3)]
