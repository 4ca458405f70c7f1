"""A gust, drag in a wind that swells and dies down, a bowl, and a puck that touches: kinds of a package of its own."""

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


class Bowl(fb.Gap, kind="bowl"):
    """A point in a bowl of the ground, z = c (x² + y²)/2, with friction."""

    point: fb.Point
    curvature: fb.Expression  # c

    directions = 2

    def _slopes(self, at):
        x, y, z = at.position(self.point)
        c = at(self.curvature)
        return c * x, c * y, z - c * (x * x + y * y) / 2

    def gap(self, at):
        a, b, height = self._slopes(at)
        return height / at.sqrt(1 + a * a + b * b)

    def _pair(self, at, direction):
        ground = self.point.body.system.ground
        yield fb.PointForce(self.point, direction)
        yield fb.PointForce(at.spot(ground, at.position(self.point)), -direction)

    def normal(self, at):
        a, b, _ = self._slopes(at)
        n = at.vector((0, 0, 1)) - a * at.vector((1, 0, 0)) - b * at.vector((0, 1, 0))
        yield from self._pair(at, n / n.norm())

    def tangents(self, at):
        a, b, _ = self._slopes(at)
        first = at.vector((1, 0, 0)) + a * at.vector((0, 0, 1))
        n = at.vector((0, 0, 1)) - a * at.vector((1, 0, 0)) - b * at.vector((0, 1, 0))
        second = n.cross(first)
        return self._pair(at, first / first.norm()), self._pair(at, second / second.norm())


class Puck(fb.ContactShape, kind="puck"):
    """A ball at a height over the origin of its body."""

    radius: fb.Expression
    height: fb.Expression = 0

    def support(self, at, direction):
        x, y, z = at.place(self.body, (0, 0, self.height))
        r = at(self.radius)
        return x + r * direction[0], y + r * direction[1], z + r * direction[2]
