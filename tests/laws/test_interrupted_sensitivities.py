"""Derivatives of motions that constraints hold, and that blows, signals and controllers interrupt, with contacts and
without: they equal differences of motions."""

import numpy as np
import pytest

import freebody as fb
from differences import check_differences

G = 9.81


def four_bar():
    """A four-bar linkage and the guesses that close it."""
    s = fb.System("four-bar")
    g, e, a = s.parameters(g=G, e=0.5, a=0.3)
    s.gravity = (0, -g, 0)
    crank, rod, rocker = (
        s.body(name, fb.slender_bar(m, L, axis="x"))
        for name, m, L in (("crank", 1, a), ("rod", 2, 0.7), ("rocker", 1.5, 0.5))
    )
    s.hinge("A", s.ground, crank, to=(-a / 2, 0, 0), axis="z", coordinate="q1")
    s.hinge("B", crank, rod, at=(a / 2, 0, 0), to=(-0.35, 0, 0), axis="z", coordinate="q2")
    s.hinge("C", rod, rocker, at=(0.35, 0, 0), to=(0.25, 0, 0), axis="z", coordinate="q3")
    s.hinge("D", s.ground, rocker, at=(0.6, 0, 0), to=(-0.25, 0, 0), axis="z")
    return s, {"q1": 1.2, "q1'": 1.0}, {"near": {"q2": -0.8, "q3": -2}}


def stopped():
    s, start, options = four_bar()
    s.stop("end", s.joints["A"], low=0.3, high=2.0, restitution="e")
    return s, start, 1.2, options


def walking(law):
    """The rod has a foot that strikes a floor and rests there."""
    s, start, options = four_bar()
    s.parameters(mu=0.4)
    foot, floor = s.bodies["rod"].point((0.1, -0.3, 0)), s.ground.plane(at=(0, -0.35, 0))
    s.contact("floor", foot, floor, friction="mu", restitution="e", impact=law)
    return s, start | {"q1": 1.3}, 0.5, options


def rough():
    """Friction under the load of a hinge of the loop."""
    s, start, options = four_bar()
    s.parameters(mu=0.3, r=0.03)
    s.friction("dry", s.joints["A"], coefficient="mu", radius="r")
    return s, start, 0.38, options


def rough_loop(joints, law):
    """Friction under the load of hinges of the loop, whose rod is struck, or strikes a floor with its foot."""
    s, start, until, options = walking(law) if law else (*four_bar()[:2], 0.3, four_bar()[2])
    s.parameters(r=0.03, J=0.4, **({} if law else {"mu": 0.3}))
    for joint in joints:
        s.friction(f"dry{joint}", s.joints[joint], coefficient="mu", radius="r")
    hit = fb.blow(0.1, at=s.bodies["rod"].point(0.1, 0, 0), impulse=("J/3", "-J", 0))
    return s, start, until, options if law else {**options, "impulses": [hit]}


def swinging():
    """A pendulum whose length a condition drives, and a wall."""
    s = fb.System("driven")
    g = s.parameters(A=0.1, w=6.0, e=0.7, g=G)[-1]
    s.gravity = (0, -g, 0)
    guide, bob = s.body("guide", fb.particle("1/10")), s.body("bob", fb.particle(1))
    s.slider("along", s.ground, guide, axis="x", coordinate="x")
    s.slider("up", guide, bob, axis="y", coordinate="y")
    s.constrain("x**2 + y**2 - (1 + A*sin(w*t))**2", name="rod")
    s.contact("wall", bob.origin, s.ground.plane(at=(-0.2, 0, 0), normal="x"), restitution="e")
    return s, {"x": 0.6, "x'": 0.0}, 1.5, {"near": {"y": -0.8}}


def sharing():
    """A box on two feet, which share their friction, and what conditions move with it."""
    s = fb.System("box")
    s.parameters(mu=0.3, F=20.0, m=2.0)
    s.gravity = (0, -G, 0)
    box, other = s.body("box", fb.box("m", (0.4, 0.2, 0.2))), s.body("other", fb.disk(0.5, 0.1))
    s.planar("plane", s.ground, box, coordinate="x y turn")
    s.planar("beside", s.ground, other, coordinate="u v r")
    feet = box.corners((-0.2, -0.1, 0), (0.2, -0.1, 0))
    s.contact("floor", feet, s.ground.plane(), friction="mu", static_friction="1.2*mu")
    s.force("push", box.point((0, 0.02, 0)), ("F*sin(8*t)", 0, 0), frame=s.ground)
    for k, condition in enumerate(("u - x - y/10", "v - y - 0.3*x**2", "r - x/5")):
        s.constrain(condition, name=f"c{k}")
    start = {"x": 0.0, "x'": 0.0, "y": 0.1, "y'": 0.0, "turn": 0.0, "turn'": 0.0}
    return s, start, 1.0, {}


def thrown():
    s = fb.System("rod")
    g = s.parameters(e=0.4, J=0.4, mu=0.3, f=0.5, T=0.218, g=G)[-1]
    s.gravity = (0, -g, 0)
    rod = s.body("rod", fb.slender_bar(1, 0.5, axis="x"))
    s.planar("air", s.ground, rod, coordinate="x y w")
    ends = rod.corners((-0.25, 0, 0), (0.25, 0, 0))
    s.contact("floor", ends, s.ground.plane(), restitution="e", friction="mu")
    return s, rod, {"y": 0.5, "w": 0.5, "w'": 0.1}


def kicked():
    """By an impulse and a moment that depend on the state, where an expression passes zero."""
    s, rod, start = thrown()
    when = fb.event("y - 0.9*f", direction=-1)
    kick = fb.blow(
        when, at=rod.point(0.1, 0, 0), impulse=(0.1, "J + y + x'/5", 0), moment=(0, 0, "J/10"), frame=rod, name="kick"
    )  # fmt: skip
    return s, start, 0.6, {"impulses": [kick]}


def reflected():
    """By a surface in the air, at a time that is a parameter."""
    s, rod, start = thrown()
    wall = fb.blow("T", at=rod.point(0.2, 0, 0), normal=("f", 1, 0), restitution="e", name="wall")
    return s, start, 0.6, {"impulses": [wall]}


def kicked_linkage(contacts):
    s, start, until, options = stopped() if contacts else (*four_bar()[:2], 0.4, four_bar()[2])
    s.parameters(J=0.5)
    rod = s.bodies["rod"]
    kick = fb.blow("0.2 + J/50", at=rod.point(0.1, 0, 0), impulse=("J", 0, 0), frame=rod)
    return s, start, until, {**options, "impulses": [kick]}


def pushed():
    """A box on two feet under a load that two signals give."""
    s = fb.System("box")
    g, mu, A = s.parameters(g=G, mu=0.3, A=8.0)
    s.gravity = (0, -g, 0)
    box = s.body("box", fb.box(2, (0.4, 0.2, 0.2)))
    s.planar("plane", s.ground, box, coordinate="x y w")
    s.contact("feet", box.corners((-0.2, -0.1, 0), (0.2, -0.1, 0)), s.ground.plane(), friction=mu)
    load = fb.signal([0, 0.1, 0.3, 0.35, 0.8, 1.2], [0, 1, -0.3, 1.3, -1, 0.2], name="load")
    steps = fb.signal([0, 0.4, 0.6], [0.1, 1, 0.3], kind="previous", name="steps")
    s.force("push", box.point(0, 0.02, 0), (A * load + A * steps / 10, 0, 0), frame=s.ground)
    return s, {"y": 0.1}, 1.0, {}


class Integrating:
    """A law that remembers, and that limits what it gives."""

    def reset(self):
        self.sum = 0.0

    def __call__(self, t, x):
        error = x["goal"] - x["x"]
        self.sum += error * x["T"]
        return np.clip(x["kp"] * error + x["ki"] * self.sum - x["kd"] * x["v"], -30, 30)


def held():
    """A box on a rough floor that a controller moves; its sensor depends on a parameter."""
    s = fb.System("box")
    g, mu, u, *_ = s.parameters(g=G, mu=0.1, u=0.0, goal=0.3, kp=60.0, ki=20.0, kd=6.0, T=0.01)
    s.gravity = (0, -g, 0)
    box = s.body("box", fb.box(2, (0.4, 0.2, 0.2)))
    s.planar("plane", s.ground, box, coordinate="x y w")
    s.contact("feet", box.corners((-0.2, -0.1, 0), (0.2, -0.1, 0)), s.ground.plane(), friction=mu)
    s.force("push", box.point(0, 0.02, 0), (u, 0, 0), frame=s.ground)
    s.controller(Integrating(), "T", "u", sensors={"v": "x' + 0.1*mu*x"}, name="law")
    return s, {"y": 0.1, "x'": 0.1}, 0.595, {}


def hopping():
    """A leg that a controller stretches: its foot leaves the floor and lands."""
    s = fb.System("leg")
    g = s.parameters(e=0.2, k=900.0, c=8.0, u=0.0, L=0.3, g=G)[-1]
    s.gravity = (0, -g, 0)
    foot, mass = s.body("foot", fb.particle(0.3)), s.body("mass", fb.particle(2))
    s.slider("rail", s.ground, foot, axis="y", coordinate="y")
    s.force("drive", s.slider("leg", foot, mass, axis="y", coordinate="z"), "u")
    s.contact("floor", foot.origin, s.ground.plane(), restitution="e")

    def law(t, x):
        return x["k"] * (x["L"] + 0.05 * np.sin(25 * t) - x["z"]) - x["c"] * x["z'"]

    s.controller(law, 0.004, "u")
    return s, {"y": 0.05, "z": 0.3}, 0.5, {}


def free():
    """A cart with a pendulum, without contacts, under a controller and a blow."""
    s = fb.System("cart")
    s.parameters(k=40.0, c=3.0, u=0.0, J=0.2)
    s.gravity = (0, -G, 0)
    cart, bar = s.body("cart", fb.particle(2)), s.body("bar", fb.slender_bar(0.5, 0.6, axis="y"))
    rail = s.slider("rail", s.ground, cart, axis="x", coordinate="x")
    s.hinge("pin", cart, bar, to=(0, 0.3, 0), axis="z", coordinate="q")
    s.force("push", rail, "u")
    s.controller(lambda t, x: -x["k"] * x["x"] - x["c"] * x["x'"], 0.01, "u", name="law")
    return s, {"x": 0.2, "q": 0.3}, 0.995, {"impulses": [fb.blow(0.3, at=bar.origin, impulse=("J", 0, 0))]}


@pytest.mark.parametrize(
    ("scene", "given", "names"),
    [
        (stopped, (), ("g", "e", "a", "q1'")),
        (rough, (), ("mu", "r", "g")),
        (rough_loop, ("A", "newton"), ("mu", "r", "e")),
        (rough_loop, ("AB", None), ("mu", "J", "a")),
        pytest.param(rough_loop, ("BC", "newton"), ("mu", "r", "e", "a"), marks=pytest.mark.slow),
        pytest.param(rough_loop, ("C", None), ("mu", "r", "J", "q1'"), marks=pytest.mark.slow),
        (kicked, (), ("J", "f", "e", "w'")),
        (pushed, (), ("A", "mu")),
        (held, (), ("kp", "ki", "mu", "T", "x'")),
        (free, (), ("k", "J", "x")),
        pytest.param(walking, ("newton",), ("g", "e", "a", "q1"), marks=pytest.mark.slow),
        pytest.param(walking, ("poisson",), ("e", "mu", "a"), marks=pytest.mark.slow),
        pytest.param(swinging, (), ("A", "w", "e", "x"), marks=pytest.mark.slow),
        pytest.param(sharing, (), ("mu", "F", "m"), marks=pytest.mark.slow),
        pytest.param(reflected, (), ("f", "e", "g", "T"), marks=pytest.mark.slow),
        pytest.param(kicked_linkage, (True,), ("J", "a", "g", "e"), marks=pytest.mark.slow),
        pytest.param(kicked_linkage, (False,), ("J", "a", "q1"), marks=pytest.mark.slow),
        pytest.param(hopping, (), ("k", "c", "L", "e", "z"), marks=pytest.mark.slow),
    ],
)
def test_slopes_are_differences(scene, given, names):
    s, start, until, options = scene(*given)
    check_differences(s, until, names, start, **options)
