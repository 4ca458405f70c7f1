"""A gust, drag in a wind that swells and dies down, and a puck that touches: kinds of a package of its own."""

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


class Puck(fb.ContactShape, kind="puck"):
    """A ball at a height over the origin of its body."""

    radius: fb.Expression
    height: fb.Expression = 0

    def support(self, at, direction):
        x, y, z = at.place(self.body, (0, 0, self.height))
        r = at(self.radius)
        return x + r * direction[0], y + r * direction[1], z + r * direction[2]
