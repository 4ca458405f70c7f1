"""Round shapes on lines of heights: a Lagrangian of their own, a pendulum, a plane, a bead, and where they take off."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import ellipk

import freebody as fb

G, R, MASS = 9.81, 0.2, 2.0
TIGHT = {"tolerance": 1e-12}


def wheel(line, *, friction=2.0, radius=R, **ends):
    s = fb.System("wheel")
    s.gravity = (0, -G, 0)
    disk = s.body("disk", fb.disk(MASS, radius))
    s.planar("plane", s.ground, disk, coordinate="x y turn")
    s.contact("road", disk.circle(radius), s.ground.heightline(line, **ends), friction=friction)
    return s


class Sine:
    """y = a cos(k x): place of the centre of a wheel, its path, and the curvature of the line by the foot p."""

    a, k = 0.1, 3.0
    text = "0.1*cos(3*x)"

    def slope(self, p):
        return -self.a * self.k * np.sin(self.k * p)

    def width(self, p):
        return np.hypot(1, self.slope(p))

    def centre(self, p):
        f, w = self.a * np.cos(self.k * p), self.width(p)
        return p - R * self.slope(p) / w, f + R / w

    def curvature(self, p):
        return -self.a * self.k**2 * np.cos(self.k * p) / self.width(p) ** 3

    def path(self, p):
        """Return dσ/dp of the path of the centre."""
        return (1 - R * self.curvature(p)) * self.width(p)

    def foot(self, x):
        p = x
        for _ in range(60):
            p = p - (self.centre(p)[0] - x) / (self.path(p) / self.width(p))
        return p


@pytest.mark.parametrize("rolls", [True, False])
def test_a_disk_on_a_sine_road_in_the_arc_of_its_centre(rolls):
    """T = ½ (m + I/R²) σ'², V = m g y: the time from place to place is a quadrature."""
    road, start = Sine(), 0.3
    s = wheel(road.text, friction=2.0 if rolls else 0.0)
    x, y = road.centre(start)
    v = 1.0
    along = np.array([1, road.slope(start)]) / road.width(start) * v
    begin = {"x": x, "y": y, "x'": along[0], "y'": along[1], "turn'": -v / R * rolls}
    m = fb.simulate(s, 1.5, initial=begin, **TIGHT)
    assert [one.mode for one in m.modes] == ["stick" if rolls else "slip"]
    share = 1 / 1.5 if rolls else 1.0  # m / (m + I/R²)
    end = road.foot(m["x"][-1])

    def pace(p):
        return road.path(p) / np.sqrt(v**2 + 2 * share * G * (y - road.centre(p)[1]))

    assert quad(pace, start, end, epsabs=1e-13, epsrel=1e-13)[0] == pytest.approx(1.5, abs=1e-10)
    assert np.abs(m.contacts["road"].gap).max() < 1e-13
    assert np.abs(m.energy.residual).max() < 1e-9
    # N = m (g n_y + κ v²/(1 - R κ)) with the speed of the centre
    speed = np.hypot(m["x'"][-1], m["y'"][-1])
    bend = road.curvature(end)
    force = MASS * (G / road.width(end) + bend * speed**2 / (1 - R * bend))
    if not rolls:
        assert m.contacts["road"].normal[-1] == pytest.approx(force, rel=1e-9)


def test_a_disk_in_a_round_dip_is_a_pendulum():
    """y = -√(B² - x²): the centre is at the end of a pendulum of the length 3/2 (B - R)."""
    B, angle = 1.0, 0.7
    s = wheel("-sqrt(1 - x^2)", between=(-0.9, 0.9))
    begin = {"x": (B - R) * np.sin(angle), "y": -(B - R) * np.cos(angle)}
    quarter = np.sqrt(1.5 * (B - R) / G) * ellipk(np.sin(angle / 2) ** 2)
    m = fb.simulate(s, 4 * quarter, initial=begin, events=[fb.event("x")], **TIGHT)
    passes = [one.time for one in m.events if one.name == "x"]
    assert passes == pytest.approx([quarter, 3 * quarter], abs=1e-9)
    assert (m["x"][-1], m["y"][-1]) == pytest.approx((begin["x"], begin["y"]), abs=1e-9)


def test_a_straight_line_is_a_plane():
    slope = 0.3
    line = wheel("0.3*x", friction=0.05)
    plane = fb.System("wheel on a plane")
    plane.gravity = (0, -G, 0)
    disk = plane.body("disk", fb.disk(MASS, R))
    plane.planar("plane", plane.ground, disk, coordinate="x y turn")
    n = (-slope / np.hypot(1, slope), 1 / np.hypot(1, slope), 0)
    plane.contact("road", disk.circle(R), plane.ground.plane(normal=n), friction=0.05)
    begin = {"x": 0, "y": 0.5, "x'": 1, "turn'": 3}
    a, b = (fb.simulate(s, 1, initial=begin, **TIGHT) for s in (line, plane))
    assert [one.mode for one in a.modes] == [one.mode for one in b.modes]
    for name in ("x", "y", "turn", "x'", "turn'"):
        assert a[name][-1] == pytest.approx(b[name][-1], abs=1e-9)


def test_a_small_wheel_without_friction_is_a_bead():
    """The place differs by what the radius is, and by its square after extrapolation."""
    bead = fb.System("bead")
    bead.gravity = (0, -G, 0)
    body = bead.body("disk", fb.disk(MASS, R))
    bead.planar("plane", bead.ground, body, coordinate="x y turn")
    bead.contact("road", body.origin, bead.ground.heightline(Sine.text))
    small = 1e-3

    def place(s, radius):
        m = fb.simulate(s, 1, initial={"x": 0, "y": 0.1 + radius, "x'": 0.5}, **TIGHT)
        return np.array([m["x"][-1], m["y"][-1]])

    one, two = (place(wheel(Sine.text, friction=0, radius=r), r) for r in (small, 2 * small))
    assert np.abs(one - place(bead, 0)).max() < 3 * small
    assert np.abs(2 * one - two - place(bead, 0)).max() < 20 * small**2


def test_a_wheel_takes_off_where_nothing_presses_it():
    """g n_y = -κ v²/(1 - R κ) of the centre, after which its path is a parabola."""
    road = Sine()
    s = wheel(road.text, friction=0)
    start, v = -0.6, 4.0
    x0, y0 = road.centre(start)
    along = np.array([1, road.slope(start)]) / road.width(start) * v
    begin = {"x": x0, "y": y0, "x'": along[0], "y'": along[1]}
    modes = fb.simulate(s, 1, initial=begin, **TIGHT).modes
    assert [one.mode for one in modes[:2]] == ["slip", "open"] and modes[1].why == "N reached 0"
    m = fb.simulate(s, modes[0].end, initial=begin, **TIGHT)
    x, y = m["x"][-1], m["y"][-1]
    p, square = road.foot(x), v**2 + 2 * G * (y0 - y)
    bend = road.curvature(p)
    assert G / road.width(p) == pytest.approx(-bend * square / (1 - R * bend), rel=1e-9)
