"""Random machines in space with contacts: pendulums, pairs, quadrupeds, grippers, loops, carts and ropes.

Numbers are parameters, so that machines of one build share their code.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import sympy

import freebody as fb
from contact_scenes import moving_belt

G = 9.81
LAWS = ("plain", "plain", "static", "stribeck", "across")
SOFT = (
    "k_{0}*depth**1.5",
    "k_{0}*depth**1.5*(1 + c_{0}*rate)",
    "k_{0}*depth + c_{0}*k_{0}/100*rate",
)


@dataclass
class Machine:
    """A machine, its start, and what its contacts obey.

    ``kinetic``  coefficients of friction along both tangents at a slip speed, by the name of a contact
    ``steps``    False if time steps do not know its laws
    """

    system: fb.System
    rng: np.random.Generator
    until: float = 0.8
    start: dict[str, Any] = field(default_factory=dict)
    values: dict[str, float] = field(default_factory=dict)
    kinetic: dict[str, Callable[[Any], tuple[Any, Any]]] = field(default_factory=dict)
    steps: bool = True
    impact: str = ""

    def draw(self, name: str, low: float, high: float) -> Any:
        """Return a parameter with a random value."""
        self.values[name] = round(float(self.rng.uniform(low, high)), 3)
        return self.system.parameters(**{name: self.values[name]})

    def chance(self, p: float) -> bool:
        """Return True with a probability."""
        return bool(self.rng.random() < p)

    def throw(self, joint: str, at: tuple[float, float, float], tilt: float, speed: float = 1.0) -> None:
        """Let a free joint start at a place, turned and thrown at random."""
        turn = np.array([1, *(tilt * self.rng.normal(size=3))])
        self.start |= {f"{joint}_{x}": float(v) for x, v in zip("xyz", at, strict=True)}
        self.start[joint] = tuple((turn / np.linalg.norm(turn)).tolist())
        self.start |= {f"{joint}_v{x}": float(speed * self.rng.normal()) for x in "xyz"}
        self.start |= {f"{joint}_w{x}": float(2 * speed * self.rng.normal()) for x in "xyz"}

    def touch(self, name: str, shape: Any, surface: Any, soft: float = 0.0, across: bool = False) -> None:
        """Add a contact with a random law, compliant with a probability; ``across`` allows two coefficients."""
        kind, symbol = str(self.rng.choice(LAWS)), self.draw(f"mu_{name}", 0.05, 0.9)
        law, mu = dict[str, Any](friction=symbol), self.values[f"mu_{name}"]
        self.kinetic[name] = lambda v: (mu, mu)
        if kind == "static":
            law["static_friction"], self.steps = 1.3 * symbol, False
        elif kind == "stribeck":
            self.draw(f"more_{name}", 0.1, 0.4), self.draw(f"vs_{name}", 0.05, 0.5)
            law["friction"], self.steps = f"mu_{name} + more_{name}*exp(-slip/vs_{name})", False
            more, v_s = self.values[f"more_{name}"], self.values[f"vs_{name}"]
            self.kinetic[name] = lambda v: (mu + more * np.exp(-v / v_s),) * 2
        elif kind == "across" and across:
            law |= {"friction": (symbol, self.draw(f"other_{name}", 0.05, 0.9)), "along": "x"}
            other = self.values[f"other_{name}"]
            self.kinetic[name] = lambda v: (mu, other)
        if self.chance(soft):
            self.draw(f"k_{name}", 1e4, 1e5), self.draw(f"c_{name}", 0.1, 1)
            law["normal"] = str(self.rng.choice(SOFT)).format(name)
        elif self.chance(0.4):
            e, impact = self.draw(f"e_{name}", 0, 0.7), str(self.rng.choice(["newton", "newton", "poisson"]))
            self.impact = self.impact or impact  # contacts that collide at once have one law
            law |= {"restitution": e, "impact": self.impact}
            self.steps &= law["impact"] == "newton"
        self.system.contact(name, shape, surface, **law)

    def rub(self, name: str, joint: Any, slides: bool = False) -> None:
        """Add dry friction to a joint, up to a force or under its load."""
        if self.chance(0.5):
            law = {"force" if slides else "torque": self.draw(f"T_{name}", 0.02, 0.5)}
        else:
            law = {"coefficient": self.draw(f"mu_{name}", 0.05, 0.5)}
            if not slides:
                law["radius"] = self.draw(f"r_{name}", 0.005, 0.03)
                if self.chance(0.3):
                    law["length"] = self.draw(f"L_{name}", 0.1, 0.4)
        self.system.friction(name, joint, **law)

    def floor(self) -> Any:
        """Return the ground, level or inclined, or a moving belt."""
        kind = str(self.rng.choice(["level", "level", "inclined", "belt"]))
        if kind == "belt":
            return moving_belt(self.system, "z", self.draw("belt_speed", -2, 2))
        if kind == "inclined":
            tilt = self.draw("tilt", -0.4, 0.4)
            return self.system.ground.plane(normal=(sympy.sin(tilt), 0, sympy.cos(tilt)))
        return self.system.ground.plane(normal="z")


def pendulums(m: Machine) -> None:
    """Two pendulums, spherical or in two links, that hit planes and each other."""
    s, balls = m.system, []
    wall = s.ground.plane(at=(m.draw("wall", 0.4, 0.8), 0, 0), normal="-x")
    for i in range(2):
        at = (0, 0.3 * i, 1)
        size = m.draw(f"l{i}", 0.3, 0.5)
        turn, reach = float(m.rng.uniform(0.9, 1.4)), m.values[f"l{i}"] / 2 + 0.23
        link = s.body(f"link{i}", fb.cylinder(m.draw(f"m{i}", 0.5, 2), 0.03, size))
        if m.chance(0.5):
            joint = s.ball(f"b{i}", s.ground, link, at=at, to=(0, 0, size / 2))
            if m.chance(0.7):
                s.friction(f"dry{i}", joint, torque=m.draw(f"T{i}", 0.02, 0.3))
            if m.chance(0.3):
                s.stop(f"stop{i}", joint, high=m.draw(f"h{i}", 1.45, 2))
            m.start |= {f"b{i}_w{x}": float(4 * m.rng.normal()) for x in "xyz"}
            m.start[f"b{i}"] = (float(np.cos(turn / 2)), 0, float(np.sin(turn / 2)), 0)
        else:
            joint = s.hinge(f"b{i}", s.ground, link, at=at, to=(0, 0, size / 2), axis="y", coordinate=f"a{i}")
            m.rub(f"dry{i}", joint)
            m.start |= {f"a{i}": turn, f"a{i}'": float(4 * m.rng.normal())}
        end = link
        if m.chance(0.5):
            reach = m.values[f"l{i}"] + 0.38
            end = s.body(f"second{i}", fb.cylinder(m.draw(f"n{i}", 0.3, 1), 0.03, 0.3))
            axis = "x" if m.chance(0.5) else "y"
            knee = s.hinge(
                f"k{i}", link, end, at=(0, 0, -size / 2), to=(0, 0, 0.15), axis=axis, coordinate=f"k{i}"
            )
            m.rub(f"dryk{i}", knee)
            if m.chance(0.5):
                s.stop(f"stopk{i}", knee, low=-1, high=0.5, restitution=m.draw(f"e{i}", 0, 0.6))
            m.start[f"k{i}'"] = float(4 * m.rng.normal())
        balls.append(end.sphere(0.08, at=(0, 0, -0.15)))
        m.touch(f"wall{i}", balls[-1], wall, soft=0.2)
        m.touch(f"floor{i}", balls[-1], s.ground.plane(at=(0, 0, 1 - 0.9 * reach), normal="z"), soft=0.2)
    m.touch("meet", *balls)


def pair(m: Machine) -> None:
    """Two boxes or capsules with a joint between them, thrown on a floor or belt."""
    s, floor, parts = m.system, m.floor(), []
    for i in range(2):
        mass = m.draw(f"m{i}", 0.5, 3)
        if m.chance(0.5):
            sizes = tuple(m.draw(f"s{i}{x}", 0.15, 0.4) for x in "abc")
            body = s.body(f"b{i}", fb.box(mass, sizes))
            shape, soft = body.corners(size=sizes), 0.25
        else:
            length, radius = m.draw(f"l{i}", 0.2, 0.5), m.draw(f"r{i}", 0.03, 0.1)
            body = s.body(f"b{i}", fb.cylinder(mass, radius, length))
            shape = body.capsule((0, 0, -length / 2), (0, 0, length / 2), radius)
            soft = 0.0  # the ends of a side have no such law
        parts.append(body)
        m.touch(f"c{i}", shape, floor, soft=soft, across=True)
    s.free("f", s.ground, parts[0])
    m.throw("f", (0, 0, 0.9), 0.5)
    if m.chance(0.4):
        joint = s.ball("j", *parts, at=(0.3, 0, 0), to=(-0.3, 0, 0))
        if m.chance(0.6):
            s.friction("dry", joint, torque=m.draw("T", 0.05, 0.5))
        m.start |= {f"j_w{x}": float(2 * m.rng.normal()) for x in "xyz"}
    else:
        joint = s.hinge(
            "j", *parts, at=(0.3, 0, 0), to=(-0.3, 0, 0), axis=str(m.rng.choice(list("xyz"))), coordinate="a"
        )
        if m.chance(0.7):
            m.rub("dry", joint)
        if m.chance(0.5):
            s.stop("stop", joint, low=-0.8, high=0.8)
        if m.chance(0.5):
            s.spring("spring", joint, stiffness=m.draw("k", 1, 30))
        m.start["a'"] = float(3 * m.rng.normal())


def quadruped(m: Machine) -> None:
    """A trunk on four legs of one or two hinges, with springs, stops and dry friction, thrown on a floor."""
    s, floor = m.system, m.floor()
    a, b = m.draw("a", 0.2, 0.4), m.draw("b", 0.12, 0.25)
    trunk = s.body("trunk", fb.box(m.draw("M", 3, 12), (2 * a, 2 * b, 0.1)))
    s.free("f", s.ground, trunk)
    m.throw("f", (0, 0, 0.75), 0.15, 0.6)
    knees, dry, stops = m.chance(0.5), str(m.rng.choice(["none", "torque", "load"])), m.chance(0.4)
    stiff, mass = m.draw("stiff", 20, 200), m.draw("m", 0.2, 1)
    law = {}
    if dry == "torque":
        law = {"torque": m.draw("T", 0.1, 2)}
    elif dry == "load":
        law = {"coefficient": m.draw("mu_joint", 0.05, 0.5), "radius": m.draw("r_joint", 0.005, 0.03)}
    for i, (x, y) in enumerate(((1, 1), (1, -1), (-1, 1), (-1, -1))):
        leg = s.body(f"leg{i}", fb.cylinder(mass, 0.02, 0.2))
        hip = s.hinge(f"h{i}", trunk, leg, at=(x * a, y * b, 0), to=(0, 0, 0.1), axis="y", coordinate=f"h{i}")
        joints, foot = [("h", hip)], leg
        if knees:
            foot = s.body(f"shank{i}", fb.cylinder(mass / 2, 0.02, 0.2))
            knee = s.hinge(f"k{i}", leg, foot, at=(0, 0, -0.1), to=(0, 0, 0.1), axis="y", coordinate=f"k{i}")
            joints.append(("k", knee))
        for name, joint in joints:
            s.spring(f"spring_{name}{i}", joint, stiffness=stiff, rest=0.3 if name == "h" else -0.6)
            if law:
                s.friction(f"dry_{name}{i}", joint, **law)
            if stops:
                s.stop(f"stop_{name}{i}", joint, low=-1, high=1)
            m.start[f"{name}{i}"] = 0.3 if name == "h" else -0.6
        m.touch(f"foot{i}", foot.sphere(0.03, at=(0, 0, -0.1)), floor, soft=0.1, across=True)
    if m.chance(0.3):
        m.touch("trunk", trunk.corners(size=(2 * a, 2 * b, 0.1)), floor)


def gripper(m: Machine) -> None:
    """Two fingers on rails that close on a ball or a box, and lift it."""
    s = m.system
    palm = s.body("palm", fb.particle(1))
    lift = s.slider("lift", s.ground, palm, axis="z", at=(0, 0, 0.5), coordinate="z")
    s.spring("up", lift, stiffness=m.draw("k_up", 100, 400), rest=m.draw("up", 0, 0.3))
    s.damper("down", lift, damping=20)
    m.rub("dry_lift", lift, slides=True)
    thing = s.body("thing", fb.sphere(m.draw("m", 0.2, 1), 0.08))
    s.free("f", s.ground, thing)
    m.throw("f", (0, 0, 0.45), 0.4, 0.3)
    box = m.chance(0.5)
    shape = thing.corners(size=(0.1, 0.14, 0.1)) if box else thing.sphere(0.08)
    for i, side in enumerate((1, -1)):
        finger = s.body(f"finger{i}", fb.box(0.5, (0.05, 0.05, 0.3)))
        if m.chance(0.7):
            joint = s.slider(f"rail{i}", palm, finger, at=(side * 0.3, 0, 0), axis="x", coordinate=f"x{i}")
            m.rub(f"dry{i}", joint, slides=True)
            s.force(f"close{i}", finger.origin, (-side * m.draw(f"F{i}", 5, 40), 0, 0))
        else:
            joint = s.hinge(
                f"turn{i}",
                palm,
                finger,
                at=(side * 0.25, 0, 0.2),
                to=(0, 0, 0.2),
                axis="y",
                coordinate=f"x{i}",
            )
            m.rub(f"dry{i}", joint)
            s.torque(f"close{i}", finger, (0, side * m.draw(f"F{i}", 1, 8), 0), reaction_on=palm)
        m.touch(
            f"grip{i}",
            shape,
            finger.plane(at=(-side * 0.025, 0, 0), normal="-x" if side > 0 else "x"),
            soft=0.3,
        )
    m.touch("floor", shape, s.ground.plane(at=(0, 0, 0.2), normal="z"))


def linkage(m: Machine) -> None:
    """A four-bar linkage that carries a leg, whose foot strikes a floor."""
    s = m.system
    crank, coupler, rocker = (
        s.body(n, fb.slender_bar(m.draw(f"m_{n}", 0.5, 2), L, axis="x"))
        for n, L in (("crank", 0.4), ("coupler", 0.9), ("rocker", 0.7))
    )
    A = s.hinge("A", s.ground, crank, to=(-0.2, 0, 0), axis="y", coordinate="q1")
    B = s.hinge("B", crank, coupler, at=(0.2, 0, 0), to=(-0.45, 0, 0), axis="y", coordinate="q2")
    C = s.hinge("C", coupler, rocker, at=(0.45, 0, 0), to=(0.35, 0, 0), axis="y", coordinate="q3")
    s.hinge("D", s.ground, rocker, at=(0.9, 0, 0), to=(-0.35, 0, 0), axis="y")
    for name, joint in (("A", A), ("B", B), ("C", C)):
        if m.chance(0.4):
            m.rub(f"dry{name}", joint)
    leg = s.body("leg", fb.cylinder(m.draw("m_leg", 0.3, 1), 0.02, 0.4))
    if m.chance(0.5):
        hip = s.hinge("hip", coupler, leg, to=(0, 0, 0.2), axis=str(m.rng.choice(["x", "y"])), coordinate="h")
        m.rub("dry_hip", hip)
        m.start["h'"] = float(2 * m.rng.normal())
    else:
        hip = s.ball("hip", coupler, leg, to=(0, 0, 0.2))
        m.start |= {f"hip_w{x}": float(2 * m.rng.normal()) for x in "xyz"}
    level = s.ground.plane(at=(0, 0, m.draw("level", -0.7, -0.4)), normal="z")
    m.touch("foot", leg.sphere(0.03, at=(0, 0, -0.2)), level, soft=0.3)
    s.torque("motor", crank, (0, m.draw("motor", -6, 6), 0))
    m.start |= {"q1": -1.2, "q1'": float(3 * m.rng.normal())}


def cart(m: Machine) -> None:
    """A cart on three or four wheels with dry axles, thrown on a floor or driven over it."""
    s, floor, R = m.system, m.floor(), m.draw("R", 0.08, 0.15)
    box = s.body("box", fb.box(m.draw("M", 2, 8), (0.6, 0.3, 0.1)))
    s.free("f", s.ground, box)
    m.throw("f", (0, 0, 0.5), 0.05, 0.8)
    places = ((0.25, 0.2), (0.25, -0.2), (-0.25, 0.2), (-0.25, -0.2))
    if m.chance(0.4):
        places = ((0.25, 0.2), (0.25, -0.2), (-0.25, 0.0))
    for i, (x, y) in enumerate(places):
        wheel = s.body(f"wheel{i}", fb.cylinder(m.draw(f"m{i}", 0.2, 1), R, 0.02, axis="y"))
        axle = s.hinge(f"axle{i}", box, wheel, at=(x, y, -0.05), axis="y", coordinate=f"w{i}")
        m.rub(f"dry{i}", axle)
        m.start[f"w{i}'"] = float(5 * m.rng.normal())
        m.touch(f"rim{i}", wheel.circle(R, axis="y"), floor)
    if m.chance(0.4):
        s.torque("motor", s.bodies["wheel0"], (0, m.draw("motor", -2, 2), 0), reaction_on=box)


def ropes(m: Machine) -> None:
    """A body that hangs on ropes which go slack, over a floor."""
    s, floor = m.system, m.floor()
    sizes = (0.3, 0.2, 0.15)
    body = s.body("body", fb.box(m.draw("m", 0.5, 3), sizes))
    s.free("f", s.ground, body)
    m.throw("f", (0, 0, 0.8), 0.3, 1.2)
    for i, (x, y, z) in enumerate(
        ((0.15, 0.1, 0.075), (-0.15, 0.1, 0.075), (0, -0.1, 0.075))[: m.rng.integers(1, 4)]
    ):
        ends = [s.ground.point(1.5 * x, 1.5 * y, 1.6), body.point(x, y, z)]
        s.rope(
            ends, m.draw(f"L{i}", 0.9, 1.3), name=f"rope{i}", taut=False, restitution=m.draw(f"e{i}", 0, 0.5)
        )
    m.touch("c", body.corners(size=sizes), floor, soft=0.2, across=True)
    if m.chance(0.6):
        bob = s.body("bob", fb.sphere(m.draw("bob", 0.2, 1), 0.06))
        s.free("g", s.ground, bob)
        m.throw("g", (0, 0.1, 0.4), 0.3, 0.8)
        ends = [body.point(0, 0, -0.075), bob.origin]
        s.rope(ends, m.draw("L", 0.5, 0.7), name="cord", taut=False, restitution=m.draw("e", 0, 0.5))
        m.touch("ball", bob.sphere(0.06), floor, soft=0.2)


KINDS = {one.__name__: one for one in (pendulums, pair, quadruped, gripper, linkage, cart, ropes)}


def machine(kind: str, seed: int) -> Machine:
    """Return the machine of a kind and seed."""
    system = fb.System(f"{kind} {seed}")
    system.gravity = (0, 0, -G)
    rng = np.random.default_rng([17, list(KINDS).index(kind), seed])
    made = Machine(system, rng)
    KINDS[kind](made)
    return made
