"""A gust: drag in a wind that swells and dies down, as a load of a package of its own."""

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
