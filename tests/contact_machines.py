"""Machines with contacts that drawings and pages are tested on, each with the modes it is drawn in, and the momenta of
their bodies."""

from __future__ import annotations

from typing import Any

import numpy as np

import freebody as fb
from freebody.dynamics.kinematics import angular_velocity, point_position, point_velocity, rotation
from freebody.motion.contact.starting_modes import see
from freebody.motion.contact.state import ContactRun
from freebody.motion.request import Request, problem_of

G = 9.81


def momenta(model, state, body):
    """Momentum, and angular momentum about the mass centre, in ground axes; and the mass centre."""
    mass = model.bodies[body.name]
    center = body.point(*mass.center)
    R = np.array(rotation(model, state, mass.link), dtype=float)
    # the links of bodies that are welded together have one frame; the body's own inertia is about its centre there
    v = np.array([float(x) for x in point_velocity(model, state, center)])
    w = np.array([float(x) for x in angular_velocity(model, state, body)])
    inertia = np.array(mass.inertia, dtype=float)
    C = np.array([float(x) for x in point_position(model, state, center)])
    return float(mass.mass) * v, R @ inertia @ R.T @ w, C


def sliding_body() -> fb.System:
    """A body on two feet, pulled."""
    s = fb.System("sliding_body")
    m, a, b, h, mu, F, g = s.parameters(m=10, a=0.5, b=0.6, h=0.7, mu=0.3, F=50, g=9.81)
    s.gravity = (0, -g, 0)
    box = s.body("box", fb.box(m, (1.4, h, 0.4)))
    s.planar("plane", s.ground, box, coordinate="x y phi")
    floor = s.ground.plane(at=(0, -h / 2, 0), normal="y")
    s.contact("A", box.point(-a, -h / 2, 0), floor, friction=mu)
    s.contact("B", box.point(b, -h / 2, 0), floor, friction=mu)
    s.force("F", box.point(-0.7, h / 4, 0), (F, 0, 0))
    return s


def pulled_disk() -> fb.System:
    """A disk pulled above its centre."""
    s = fb.System("pulled_disk")
    m, R, mu, F, g = s.parameters(m=10, R=0.3, mu=0.2, F=30, g=9.81)
    s.gravity = (0, -g, 0)
    disk = s.body("disk", fb.disk(m, R))
    s.planar("plane", s.ground, disk, coordinate="x y phi")
    s.force("F", disk.origin, (F, 0, 0))
    s.contact(
        "floor", disk.circle(R), s.ground.plane(normal="y", at=(0, -R, 0)), friction=mu, restitution=0.5
    )
    return s


def ladder() -> fb.System:
    """A ladder on a floor and a wall."""
    s = fb.System("ladder")
    m, L, mu, g = s.parameters(m=12, L=3, mu=0.4, g=9.81)
    s.gravity = (0, -g, 0)
    bar = s.body("ladder", fb.slender_bar(m, L, axis="y"))
    s.planar("plane", s.ground, bar, coordinate="x y phi")
    s.contact("floor", bar.point(0, -L / 2, 0), s.ground.plane(), friction=mu)
    s.contact("wall", bar.point(0, L / 2, 0), s.ground.plane(normal="x"), friction=mu)
    return s


def bar_in_cylinder() -> fb.System:
    """A bar in a smooth hollow cylinder."""
    s = fb.System("bar_in_cylinder")
    m, L, R, g = s.parameters(m=3, L=1.2, R=1, g=9.81)
    s.gravity = (0, -g, 0)
    bar = s.body("bar", fb.slender_bar(m, L, axis="x"))
    s.planar("plane", s.ground, bar, coordinate="x y phi")
    hollow = s.ground.circle(R, inside=True)
    s.contact("A", bar.point(-L / 2, 0, 0), hollow)
    s.contact("B", bar.point(L / 2, 0, 0), hollow)
    return s


def falling_rod() -> fb.System:
    """A rod that falls over on a rough floor."""
    s = fb.System("falling_rod")
    m, L, mu, g = s.parameters(m=2, L=1, mu=0.3, g=9.81)
    s.gravity = (0, -g, 0)
    rod = s.body("rod", fb.slender_bar(m, L, axis="y"))
    s.planar("plane", s.ground, rod, coordinate="x y phi")
    s.contact("O", rod.point(0, -L / 2, 0), s.ground.plane(), friction=mu)
    return s


def block_on_incline() -> fb.System:
    """A block on an inclined plane."""
    s = fb.System("block_on_incline")
    m, a, h, mu, beta, g = s.parameters(m=2, a=0.3, h=0.3, mu=0.3, beta="25deg", g=9.81)
    s.gravity = (0, -g, 0)
    block = s.body("block", fb.box(m, (2 * a, h, 0.2)))
    s.planar("plane", s.ground, block, coordinate="x y phi")
    plane = s.ground.plane(normal=("-sin(beta)", "cos(beta)", 0))
    s.contact("feet", block.corners((-a, -h / 2, 0), (a, -h / 2, 0)), plane, friction=mu)
    return s


def ball_on_plane() -> fb.System:
    """A ball on a plane, in space."""
    s = fb.System("ball_on_plane")
    m, R, mu, g = s.parameters(m=1, R=0.1, mu=0.3, g=9.81)
    s.gravity = (0, 0, -g)
    ball = s.body("ball", fb.sphere(m, R))
    s.free("flight", s.ground, ball)
    s.contact("floor", ball.sphere(R), s.ground.plane(normal="z"), friction=mu)
    return s


def add_bouncing_ball(s: fb.System) -> None:
    """Add a ball that bounces without loss along y, under the machine's parameter g."""
    ball = s.body("ball", fb.particle(1))
    s.slider("fall", s.ground, ball, axis="y", coordinate="y")
    s.force("weight", ball, (0, "-g", 0))
    s.contact("floor", ball.point(0, 0, 0), s.ground.plane(normal="y"), friction=0, restitution=1)


def seesaw() -> fb.System:
    """A block that slides on a hinged board: both sides of a contact move."""
    s = fb.System("seesaw")
    M, m, L, h, mu, g = s.parameters(M=8, m=2, L=2, h=0.2, mu=0.4, g=9.81)
    s.gravity = (0, -g, 0)
    board = s.body("board", fb.slender_bar(M, L, axis="x"))
    s.hinge("pin", s.ground, board, axis="z", coordinate="beta")
    block = s.body("block", fb.box(m, (2 * h, h, h)))
    s.planar("plane", s.ground, block, coordinate="x y phi")
    top = board.segment((-L / 2, 0, 0), (L / 2, 0, 0), normal="y")
    s.contact("feet", block.corners((-h, -h / 2, 0), (h, -h / 2, 0)), top, friction=mu)
    return s


DRAWN: list[tuple[Any, dict[str, Any]]] = [
    (sliding_body, {"A": "slip+", "B": "slip+"}),
    (pulled_disk, {"floor": "stick"}),
    (pulled_disk, {"floor": "slip+"}),
    (ladder, {"floor": "slip+", "wall": "slip-"}),
    (bar_in_cylinder, {"A": "slip", "B": "slip"}),
    (falling_rod, {"O": "stick"}),
    (falling_rod, {"O": "slip-"}),
    (block_on_incline, {"feet": "stick"}),
    (seesaw, {"feet": "slip-"}),
    (ball_on_plane, {"floor": "stick"}),
    (ball_on_plane, {"floor": ("slip", ("0.6", "0.8"))}),
]

DISK = """\
name = "disk"
gravity = [0, "-g", 0]
[parameters]
m = 10
R = 0.3
mu = 0.2
g = 9.81
[bodies.disk]
solid = "disk"
mass = "m"
radius = "R"
[joints.plane]
type = "planar"
child = "disk"
coordinate = ["x", "y", "phi"]
[contacts.floor]
feature = { body = "disk", shape = "circle", radius = "R" }
surface = { shape = "plane", normal = "y" }
friction = "mu"
[initial]
y = "R"
"x'" = 3
[run]
until = 0.2
"""
"""A model file: a disk thrown along a floor."""


def rough_pendulum(mu, r, length=1.0):
    """A bar that hangs on a pin of radius r, whose friction the load of the pin bounds."""
    s = fb.System("pendulum")
    s.gravity = (0, -9.81, 0)
    bar = s.body("bar", fb.slender_bar(2, length, axis="y"))
    pin = s.hinge("pin", s.ground, bar, to=(0, length / 2, 0), axis="z", coordinate="theta")
    s.friction("dry", pin, coefficient=mu, radius=r)
    return s


G, M, MU = 9.81, 2.0, 0.3


def pushed_block(force, mu=MU, static=None, sensors=None):
    """A block on a floor, pushed along it by a signal or by a controller, given by its function and period."""
    s = fb.System("block")
    s.gravity = (0, -G, 0)
    body = s.body("block", fb.particle(M))
    s.chain("plane", s.ground, body, [fb.Slider("x", "x"), fb.Slider("y", "y")])
    s.contact("floor", body.origin, s.ground.plane(), friction=mu, static_friction=static)
    if isinstance(force, tuple):
        function, period = force
        (push,) = (s.parameters(push=0.0),)
        s.controller(function, period, "push", sensors=sensors, name="law")
        force = push
    s.force("F", body.origin, (force, 0, 0))
    return s


def ball_in_jumping_field(**laws):
    """A ball over a floor; gravity is twice as strong from t = 0.2 s on."""
    s = fb.System("ball")
    g = s.parameters(g=G)
    s.gravity = (0, -g, 0)
    s.controller(lambda t, _: G if t < 0.19 else 2 * G, 0.2, "g", name="field")
    ball = s.body("ball", fb.disk(1, 0.1))
    s.planar("plane", s.ground, ball, coordinate="x y turn")
    s.contact("floor", ball.circle(0.1), s.ground.plane(), **laws)
    return s


def block_kicked_by_a_change():
    """A pushed block, and a blow when its push jumps to 10 N at t = 1 s."""
    s = pushed_block((lambda t, _: 0.0 if t < 0.95 else 10.0, 0.5))
    kick = fb.blow("push - 5 + t - 1", at=s.bodies["block"], impulse=(4, 0, 0), name="kick")
    return s, kick


def tumbling_box() -> fb.System:
    """A box on four corners, and a ball on its arm."""
    s = fb.System("tumbling box")
    s.gravity = (0.3, -0.2, -9.81)
    box, arm = (
        s.body("box", fb.box(2, (0.4, 0.3, 0.2)).moved((0.01, 0.02, 0.03))),
        s.body("arm", fb.box(1, (0.5, 0.1, 0.1))),
    )
    s.free("f", s.ground, box)
    s.hinge("h", box, arm, at=(0.2, 0, 0), to=(-0.25, 0, 0), axis="y", coordinate="h")
    floor = s.ground.plane(normal="z")
    s.contact(
        "c", box.corners(*[(x, y, -0.1) for x in (-0.2, 0.2) for y in (-0.15, 0.15)]), floor, friction=0.5
    )
    s.contact("s", arm.sphere(0.05, at=(0.2, 0, 0)), floor, friction=0.2)
    return s


def puck_and_ball(friction, lands, pull=None, **more):
    """A puck that stands on four points, and a ball beside it that lands at a time."""
    s, radius = fb.System("beside"), 0.1
    s.gravity = (0, 0, -G)
    floor = s.ground.plane(normal="z")
    size = (0.1, 0.1, 0.02)
    puck, ball = s.body("puck", fb.box(1, size)), s.body("ball", fb.sphere(1, radius))
    s.free("p", s.ground, puck)
    s.free("b", s.ground, ball)
    s.contact("feet", puck.corners(size=size), floor, friction=friction, **more)
    s.contact("bounce", ball.sphere(radius), floor, restitution=0.5)
    if pull is not None:
        s.force("pull", puck.point(0, 0, -size[2] / 2), (f"{pull}*t", 0, 0), frame=s.ground)
    return s, {"p_z": size[2] / 2, "b_x": 1, "b_z": radius + G * lands**2 / 2}


def landing(motion):
    """Return the time of the ball's first impact."""
    return next(float(one.time) for one in motion.events if "bounce" in str(one))


def block_on_feet(load: float = 0.0, right: float = 0.5) -> fb.System:
    """A block of 2 kg that slides on two feet with μ = 0.5, below a load along the floor."""
    s = fb.System("block on feet")
    s.gravity = (0, -G, 0)
    block = s.body("block", fb.box(2, (1, 0.2, 0.5)))
    s.planar("plane", s.ground, block, coordinate="x y phi")
    floor = s.ground.plane(normal="y", at=(0, -0.1, 0))
    for name, x in (("left", -0.5), ("right", right)):
        s.contact(name, block.point(x, -0.1, 0), floor, friction=0.5)
    s.force("load", block.point(0, -0.1, 0), (load, 0, 0))
    return s


def at_start(s: fb.System, speed: float = 0.0) -> Any:
    """A run of a block on feet at a speed, with its contacts looked at."""
    work = ContactRun.of(problem_of(Request(s, 1)), np.full(8, 1e-9), np.full(8, 1e-9))
    see(work, np.array([0, 0, 0, speed, 0, 0, 0, 0]))
    return work
