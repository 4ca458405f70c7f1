"""Added mass against the same mass as part of a body: every product of the two machines is the same."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from freebody.dynamics import (
    bias,
    float_state,
    forward_dynamics,
    inverse_dynamics,
    kinetic_energy,
    mass_matrix,
    mechanical_power,
)
from freebody.dynamics.composite import mass_diagonal
from freebody.dynamics.impulse import blows_on, generalized_impulse, impulsive_reactions, speed_jumps
from freebody.dynamics.kinematics import link_twists, point_velocity
from freebody.dynamics.loads.loading import load_power
from freebody.dynamics.newton_euler import reactions
from freebody.testing import random_inertia, random_rotation, random_state

EPS = np.finfo(float).eps
EXACT = 2**14 * EPS  # as in test_armature: sums of some hundred products
GRAVITY = (1, -2, 3)


class Cargo(fb.Load, kind="cargo_of_added_mass"):
    """A rigid body on a body, said by its forces: -m (a - g) at its centre, and Euler's moment."""

    body: fb.Body
    centre: fb.Point
    mass: fb.Expression
    inertia: fb.Vector  # principal, along the axes of the body

    def actions(self, at):
        m = at(self.mass)
        yield fb.PointForce(self.centre, -m * (at.acceleration(self.centre) - at.vector(GRAVITY)))
        alpha, w = at.angular_acceleration(self.body, self.body), at.angular_velocity(self.body, self.body)
        A, B, C = map(at, self.inertia)
        Iw = (A * w.x, B * w.y, C * w.z)
        n = at.vector((A * alpha.x, B * alpha.y, C * alpha.z), self.body)
        turning = at.angular_velocity(self.body).cross(at.vector(Iw, self.body))
        yield fb.Couple(self.body, -(n + turning))


def machine(joints, *, added, seed=1, loop=False):
    """Bodies in a row, the middle and the last with cargo: as a load, or as part of the body."""
    rng = np.random.default_rng(seed)
    s = fb.System("cargo")
    s.gravity = GRAVITY
    parent = s.ground
    for i, kind in enumerate(joints):
        solid = fb.MassProperties(1.5 + i, rng.normal(size=3), random_inertia(rng))
        centre, mass = rng.normal(size=3).tolist(), 0.7 + i
        inertia = [2.0, 2.5, 3.5]
        cargo = fb.MassProperties(mass, centre, np.diag(inertia))
        carries = i > 0 or len(joints) == 1
        body = s.body(f"b{i}", solid + cargo if carries and not added else solid)
        given = {"at": rng.normal(size=3), "to": rng.normal(size=3), "parent_axes": random_rotation(rng)}
        if kind in ("hinge", "slider", "driven", "screw", "cylindrical"):
            n = rng.normal(size=3)
            given["axis"] = n / np.linalg.norm(n)
        if kind == "driven":
            s.hinge(f"j{i}", parent, body, coordinate=s.t**2, **given)
        else:
            getattr(s, kind)(f"j{i}", parent, body, **given, **({"pitch": 0.3} if kind == "screw" else {}))
        if carries and added:
            s.add(f"cargo{i}", Cargo(body, body.point(*centre), mass, inertia))
        parent = body
    s.force("F", parent.point(1, 2, 3), (1, -2, 0.5))
    if loop:
        s.constrain("j0 - 2*j1 + j2**2", name="cam")
    return s


def close(a, b, tolerance):
    a, b = np.asarray(a, float), np.asarray(b, float)
    assert np.abs(a - b).max(initial=0) <= tolerance * max(1, np.abs(a).max(initial=0))


CHAINS = [
    ("free",),
    ("hinge", "slider", "screw"),
    ("ball", "universal", "cylindrical"),
    ("free", "hinge", "ball"),
    ("hinge", "driven", "planar"),
    ("driven", "gimbal", "hinge"),
]


@pytest.mark.parametrize("joints", CHAINS, ids="-".join)
def test_numbers(joints):
    a, b = (fb.assemble(machine(joints, added=added)) for added in (True, False))
    q, u = random_state(a, 3)
    one, two = float_state(a, q, u, 0.3), float_state(b, q, u, 0.3)
    M = np.array(mass_matrix(a, one), float)
    tolerance = EXACT * np.linalg.cond(M)
    close(M, mass_matrix(b, two), EXACT)
    close(mass_diagonal(a, one), np.diag(M), EXACT)
    close(bias(a, one), bias(b, two), EXACT)
    close(kinetic_energy(a, one), kinetic_energy(b, two), EXACT)
    udot = forward_dynamics(a, one)
    close(udot, forward_dynamics(b, two), tolerance)
    trial = np.random.default_rng(5).normal(size=len(u)).tolist()
    close(inverse_dynamics(a, one, trial), inverse_dynamics(b, two, trial), EXACT)
    for name, (force, moment) in reactions(a, one, udot).items():
        close(force, reactions(b, two, udot)[name][0], tolerance)
        close(moment, reactions(b, two, udot)[name][1], tolerance)


@pytest.mark.parametrize("joints", CHAINS, ids="-".join)
def test_energy(joints):
    """The power of the cargo is that of its weight: d(T + V)/dt of the machine with bodies, less dV/dt of the cargo."""
    a, b = (fb.assemble(machine(joints, added=added)) for added in (True, False))
    q, u = random_state(a, 3)
    one, two = float_state(a, q, u, 0.3), float_state(b, q, u, 0.3)
    udot = forward_dynamics(b, two)
    weight = 0.0
    for i in range(len(joints)):
        if i > 0 or len(joints) == 1:
            load = a.loads[f"cargo{i}"]
            weight += (0.7 + i) * float(np.dot(GRAVITY, point_velocity(a, one, load.centre)))
    close(load_power(a, one), load_power(b, two) + weight, EXACT)
    close(mechanical_power(a, one, udot), mechanical_power(b, two, udot) + weight, EXACT * 2**6)


@pytest.mark.parametrize("joints", [CHAINS[1], CHAINS[3]], ids="-".join)
def test_struck(joints):
    results = []
    for added in (True, False):
        model = fb.assemble(machine(joints, added=added))
        state = float_state(model, *random_state(model, 2))
        hits = blows_on(
            model, state, [(model.described[0].bodies["b2"].point(1, 0, 2), (3, -1, 2), (1, 1, -2))]
        )
        jump, _ = speed_jumps(model, state, generalized_impulse(model, state, hits))
        impulses = impulsive_reactions(model, state, link_twists(model, state, jump), hits)
        results.append([*jump, *(x for pair in impulses.values() for v in pair for x in v)])
    close(*results, 2**20 * EPS)


@pytest.mark.parametrize(
    ("joints", "loop"),
    [(CHAINS[1], False), pytest.param(CHAINS[2], False, marks=pytest.mark.slow), (CHAINS[1], True)],
)
def test_motion(joints, loop):
    """Compiled code, its ledger and reactions, also with a loop."""
    a, b = (machine(joints, added=added, loop=loop) for added in (True, False))
    q, u = random_state(fb.assemble(a), 3)
    programs = [fb.compile(s) for s in (a, b)]
    if not loop:
        close(programs[0].forward_dynamics(q, u), programs[1].forward_dynamics(q, u), 2**20 * EPS)
        close(
            programs[0].forward_dynamics([q, q], [u, u]),
            programs[1].forward_dynamics([q, q], [u, u]),
            2**20 * EPS,
        )
    close(programs[0].mass_matrix(q), programs[1].mass_matrix(q), EXACT)
    tolerance = 1e-10
    motions = [fb.simulate(s, 0.5, tolerance=tolerance) for s in (a, b)]
    for name in fb.assemble(a).coordinate_names:
        close(motions[0][name][-1], motions[1][name][-1], 1e4 * tolerance)
    assert np.abs(motions[0].energy.residual).max() < 1e3 * tolerance
    close(motions[0].reactions["j0"].force[-1], motions[1].reactions["j0"].force[-1], 1e5 * tolerance)


def test_formulas():
    """Equal equations of motion, energies, reactions and linear theory, as canonical polynomials."""
    from sympy import simplify

    texts = []
    for added in (True, False):
        s = fb.System("pendulum")
        m, M, L, g = s.parameters(m=1.0, M=2.0, L=0.5, g=9.81)
        s.gravity = (0, -g, 0)
        cart = s.body("cart", fb.particle(M))
        bob = s.body("bob", fb.particle(m))
        s.slider("guide", s.ground, cart, axis="x", coordinate="x")
        s.hinge("pin", cart, bob, to=(0, L, 0), axis="z", coordinate="theta")
        if added:
            s.add("water", Sphere(bob.origin, m))
        else:
            more = s.body("more", fb.particle(m))
            s.weld("glue", bob, more)
            s.force("lift", more.origin, (0, m * g, 0))
        e = fb.equations(s)
        linear = fb.linearize(s)
        texts.append((e.mass_matrix, e.energy.kinetic, linear.M, linear.K, e.reactions["guide"].force))
    for one, two in zip(*texts, strict=True):
        assert simplify(one - two).is_zero_matrix if hasattr(one, "shape") else simplify(one - two) == 0


class Sphere(fb.Load):
    """The water that moves with a body, -m a."""

    point: fb.Point
    mass: fb.Expression

    def actions(self, at):
        yield fb.PointForce(self.point, -at(self.mass) * at.acceleration(self.point))


def test_a_ball_that_bounces_in_water():
    """At an impact the added mass keeps its share of the momentum: a ball rises to e² of its height."""
    s = fb.System("ball")
    s.gravity = (0, -9.81, 0)
    ball = s.body("ball", fb.sphere(2, 0.1))
    s.planar("air", s.ground, ball)
    s.add("water", Sphere(ball.center, 3))
    s.contact("floor", ball.sphere(0.1), s.ground.plane(normal="y"), friction=0, restitution=0.5)
    motion = fb.simulate(s, 1.2, initial={"air_y": 1.1}, tolerance=1e-10)
    fall = 9.81 * 2 / 5
    first = (2 / fall) ** 0.5
    assert motion.events[0].time == pytest.approx(first, rel=1e-9)
    speed = 0.5 * fall * first
    top = motion.at(first + speed / fall)["air_y"]
    assert top == pytest.approx(0.1 + speed**2 / (2 * fall), rel=1e-8)
    assert abs(motion.energy.residual).max() < 1e-8


@pytest.mark.parametrize(
    ("action", "why"),
    [
        (lambda self, at: fb.PointForce(self.point, -at.acceleration(self.point).norm() * at.vector((1, 0, 0))),
         "is not linear in the accelerations"),
        (lambda self, at: fb.PointForce(self.point, -at.velocity(self.point).norm() * at.acceleration(self.point)),
         "depends on the speeds"),
        (lambda self, at: fb.PointForce(self.point, -1 * at.acceleration(self.other)),
         "has a force on another"),
        (lambda self, at: fb.JointForce(self.joint, -at.acceleration(self.point).x),
         "force along a joint"),
    ],
)  # fmt: skip
def test_what_is_no_added_mass_is_refused(action, why):
    class Sensor(fb.Load):
        point: fb.Point
        other: fb.Point
        joint: fb.Joint

        def actions(self, at):
            yield action(self, at)

    s = machine(("hinge", "ball"), added=False)
    b0, b1 = s.bodies.values()
    s.add("sensor", Sensor(b1.point(1, 0, 0), b0.point(0, 1, 0), s.joints["j0"]))
    with pytest.raises(
        fb.FreebodyError, match=f"(?s)Sensor 'sensor': .*{why}.*test_added_mass.*s.controller"
    ):
        fb.equations(s).text()


def test_potentials_and_gaps_have_no_accelerations():
    class Heavy(Sphere):
        def potential(self, at):
            return at.acceleration(self.point).x

    s = machine(("hinge", "ball"), added=False)
    s.add("heavy", Heavy(s.bodies["b1"].origin, 1))
    with pytest.raises(fb.FreebodyError, match=r"(?s)Heavy 'heavy'.*potential.*Make two loads"):
        fb.equations(s).text()

    class Nearing(fb.Gap):
        point: fb.Point

        def gap(self, at):
            return at.acceleration(self.point).z

        def normal(self, at):
            yield fb.PointForce(self.point, (0, 0, 1))

    s = machine(("hinge", "ball"), added=False)
    s.add("nearing", Nearing(s.bodies["b1"].origin))
    with pytest.raises(
        fb.FreebodyError, match=r"(?s)Nearing 'nearing': only the actions of a load.*Leave the acc"
    ):
        fb.simulate(s, 0.1)


def test_the_battery():
    fb.testing.check_load(Sphere)
    fb.testing.check_load(Cargo, balanced=False)
