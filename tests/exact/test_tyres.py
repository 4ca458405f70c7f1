"""Tyres against closed forms: the single-track car, constant slip by both laws, a wheel on its spring."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import brentq

import freebody as fb
from freebody.describe.loads.tyre import Tyre
from freebody.errors import ModelError, SimulationError
from freebody.exact import steady_turn

M, J, A, B, V = 1200.0, 1800.0, 1.2, 1.5, 25.0
FRONT, REAR = 8e4, 9e4  # cornering stiffness of an axle [N/rad]
G = 9.81


def car(steer=0, **laws):
    """The single-track car: a body in the plane, and two wheels that are only steered, not spun."""
    s = fb.System("single track")
    car = s.body("car", fb.MassProperties(M, (0, 0, 0), [[J, 0, 0], [0, J, 0], [0, 0, J]]))
    s.planar("road", s.ground, car, coordinate="x y psi")
    front = s.body("front", fb.particle(0))
    s.hinge("steering", car, front, at=(A, 0, 0), axis="z", coordinate=s.expression(steer))
    for name, body, place, C, load in (
        ("front", front, front.origin, FRONT, M * G * B / (A + B)),
        ("rear", car, car.point(-B, 0, 0), REAR, M * G * A / (A + B)),
    ):
        law = laws.get("lateral", C / load)
        s.tyre(f"{name}_tyre", place, axis="y", lateral=law, load=load, normal="z")
        assert body is place.body
    return s


def test_single_track_car_going_straight():
    """Pacejka (1.23): the linear equations of lateral speed v and yaw rate r at the speed V."""
    s = car()
    linear = fb.linearize(s, about={"x": 0, "y": 0, "psi": 0, "x'": V, "y'": 0, "psi'": 0}, values={})
    C, sC, q2 = FRONT + REAR, A * FRONT - B * REAR, A**2 * FRONT + B**2 * REAR
    # y and psi in the ground: v = y' - V psi
    stiffness = np.array([[0, -C], [0, -sC]])
    damping = np.array([[C, sC], [sC, q2]]) / V
    found = [
        np.array(x, float)[1:, 1:]
        for x in (linear.stiffness + linear.circulatory, linear.damping + linear.gyroscopic)
    ]
    assert found[0] == pytest.approx(stiffness, rel=1e-9, abs=1e-6)
    assert found[1] == pytest.approx(damping, rel=1e-9, abs=1e-6)


def test_steady_turn_of_a_small_steering_angle():
    """r = V δ/(L + η V²/g): Pacejka (1.40), with the understeer η."""
    delta = 1e-6
    exact = steady_turn(V, delta, M, (A, FRONT), (B, REAR))
    motion = fb.simulate(car(delta), 12, initial={"x'": V}, tolerance=1e-12)
    # the tyres of a turning car brake it by the squares of its slips
    assert motion["psi'"][-1] == pytest.approx(exact.yaw_rate, rel=1e-8)
    psi, x, y = (motion[name][-1] for name in ("psi", "x'", "y'"))
    assert y * math.cos(psi) - x * math.sin(psi) == pytest.approx(exact.side_speed, rel=1e-6)


PACEJKA = (8.0, 1.4, 1.1, -0.5)


def magic(slip):
    stiffness, shape, peak, curvature = PACEJKA
    x = stiffness * slip
    return peak * math.sin(shape * math.atan(x - curvature * (x - math.atan(x))))


def braked(law, torque, R=0.3, F=3000.0, **options):
    s = fb.System("trolley")
    trolley, wheel = s.body("trolley", fb.particle(1)), s.body("wheel", fb.disk(10, R))
    s.slider("run", s.ground, trolley, at=(0, R, 0), axis="x", coordinate=V * s.t)
    hub = s.hinge("hub", trolley, wheel, axis="z", coordinate="phi")
    s.tyre("road", wheel, axis="z", radius=R, load=F, longitudinal=law, **options)
    s.torque("brake", hub, torque)
    return fb.simulate(s, 3, initial={"phi'": -V / R}, tolerance=1e-11)


@pytest.mark.parametrize("torque", [400.0, -400.0, 850.0])
def test_a_braked_or_driven_wheel_comes_to_the_slip_of_its_torque(torque):
    """R F_z f(κ) = -T, κ = R ω/V - 1."""
    motion = braked(PACEJKA, torque)
    kappa = brentq(lambda x: 0.3 * 3000 * magic(x) + torque, -0.12, 0.12, xtol=1e-15)
    assert -0.3 * motion["phi'"][-1] / V - 1 == pytest.approx(kappa, rel=1e-8)
    assert motion.reactions["run"].force[-1][0] == pytest.approx(torque / 0.3, rel=1e-8)
    assert abs(motion.energy.residual).max() < 1e-9 * abs(motion.energy.kinetic).max()


def test_a_wheel_locks_beyond_the_peak():
    """The greatest torque is μ F_z R; at κ = -1 the wheel stands and slides."""
    motion = braked(PACEJKA, 0.3 * 3000 * 1.1 + 1)
    assert motion["phi'"].max() > 0  # it turns backwards in the end, as nothing holds the brake


def test_interaction_of_both_slips():
    """A wheel that is toed by δ on a trolley: g(κ), g(σ) times the pure forces."""
    delta, R, F, Bg = 0.05, 0.3, 3000.0, 6.0
    s = fb.System("toe")
    trolley, wheel = s.body("trolley", fb.particle(1)), s.body("wheel", fb.disk(10, R, axis="z"))
    s.slider("run", s.ground, trolley, at=(0, R, 0), axis="x", coordinate=V * s.t)
    spin = -1.02 * V * math.cos(delta) / R
    s.hinge(
        "hub", trolley, wheel, parent_axes=fb.Rotation.axis_angle("y", delta), axis="z", coordinate=spin * s.t
    )
    s.tyre("road", wheel, axis="z", radius=R, load=F, lateral=PACEJKA, longitudinal=PACEJKA, interaction=Bg)
    force = -fb.simulate(s, 0.1, samples=2).reactions["run"].force[0]
    sigma, kappa = -math.tan(delta), 0.02
    along, across = (F * magic(x) / math.hypot(1, Bg * y) for x, y in ((kappa, sigma), (sigma, kappa)))
    # e = (cos δ, 0, -sin δ), s = n × e
    c, d = math.cos(delta), math.sin(delta)
    e, side = np.array([c, 0, -d]), np.array([-d, 0, -c])
    v = np.array([V, 0, 0])
    assert -(v @ side) / (v @ e) == pytest.approx(-sigma)
    exact = along * e + F * magic(-sigma) / math.hypot(1, Bg * kappa) * side
    assert force[2] == pytest.approx(exact[2], rel=1e-10)
    assert abs(across) == pytest.approx(abs(F * magic(-sigma) / math.hypot(1, Bg * kappa)))


def test_a_wheel_stands_on_its_spring_and_leaves_the_road():
    """It falls from h: free, then m y'' = k (R - y) - m g; both times are located."""
    R, m, k, h = 0.3, 20.0, 4e4, 0.05
    s = fb.System("drop")
    s.gravity = (0, -G, 0)
    wheel = s.body("wheel", fb.disk(m, R))
    base = s.body("base", fb.particle(0))
    s.slider("forward", s.ground, base, axis="x", coordinate=V * s.t)
    s.slider("up", base, wheel, axis="y", coordinate="y")
    s.tyre("road", wheel, axis="z", radius=R, stiffness=k, lateral=5)
    motion = fb.simulate(s, 0.3, initial={"y": R + h}, tolerance=1e-12)
    touch = math.sqrt(2 * h / G)
    w, u = math.sqrt(k / m), math.sqrt(2 * G * h)
    # R - y = (g/w²)(1 - cos) + (u/w) sin = 0
    leave = touch + brentq(
        lambda t: G / w**2 * (1 - math.cos(w * t)) + u / w * math.sin(w * t),
        0.6 * math.pi / w,
        1.9 * math.pi / w,
    )
    assert [event.time for event in motion.events][:2] == pytest.approx([touch, leave], rel=1e-9)
    assert [str(event).partition(": ")[2].partition(":")[0] for event in motion.events][:2] == [
        "road touches the road", "road leaves the road"
    ]  # fmt: skip
    assert abs(motion.energy.residual).max() < 1e-9


@pytest.mark.parametrize(
    "data",
    [
        {"load": 30, "lateral": 5, "lateral_shape": None},
        {"load": 30, "longitudinal": 2, "lateral": 3, "interaction": 2, "lateral_shape": (2, 1.3, -1)},
    ],
)
def test_battery_of_loads(data):
    fb.testing.check_load(
        Tyre, **{"axis": (0, 0, 1), "radius": 0.3, "stiffness": None, "normal": "y", "road": None, **data}
    )


@pytest.mark.slow
def test_a_wheel_of_a_body_in_space_is_drawn():
    """Its forces are too long for a magnitude: they are drawn by their components."""
    s = fb.System("kart")
    s.gravity = (0, 0, -G)
    frame, wheel = s.body("frame", fb.box(200, (1, 0.5, 0.3))), s.body("wheel", fb.disk(10, 0.3, axis="y"))
    s.free("air", s.ground, frame)
    s.hinge("hub", frame, wheel, axis="y", coordinate="phi")
    laws = {"lateral": PACEJKA, "longitudinal": PACEJKA, "interaction": 6}
    s.tyre("road", wheel, axis="y", radius=0.3, stiffness=1e5, damping=500, normal="z", **laws)
    for picture in (fb.draw(s), fb.free_body_diagram(s, "wheel")):
        assert picture.svg.count("road") >= 3


def test_a_wheel_at_rest_has_no_slip():
    with pytest.raises(
        SimulationError, match="In the last good state 'front_tyre' and 'rear_tyre' has no finite"
    ):
        fb.simulate(car(), 1)


def wheel(**options):
    s = fb.System("refused")
    body = s.body("wheel", fb.disk(1, 0.3))
    s.planar("free", s.ground, body, coordinate="x y phi")
    s.tyre(
        "road",
        options.pop("on", lambda body: body)(body),
        **{"axis": "z", "lateral": 1, "load": 1, **options},
    )


REFUSED = {
    "The wheel of tyre 'road' is the ground": {"on": lambda body: body.system.ground},
    "Tyre 'road' has no force: give lateral= or longitudinal=, or both": {"lateral": 0},
    r"Expected either load= \(the vertical load in N\) or stiffness= .* got neither": {"load": None},
    "got both": {"stiffness": 5, "radius": 1},
    "Expected 'x', 'y' or 'z', with or without a minus, for the normal of tyre 'road', got 'up'": {
        "normal": "up"
    },
    r"Expected one stiffness or the four numbers \(B, C, μ, E\) for lateral= of tyre 'road'": {
        "lateral": (1, 2)
    },
    "Expected 0 or more for lateral= of tyre 'road', got -3": {"lateral": -3},
    "Tyre 'road' stands on the road by its stiffness=, so it needs a radius=": {"stiffness": 3, "load": None},
    "Expected a body or a point for the wheel of tyre 'road', got 3": {"on": lambda body: 3},
}


@pytest.mark.parametrize("words", REFUSED)
def test_refusals(words):
    with pytest.raises(ModelError, match=words):
        wheel(**REFUSED[words])
