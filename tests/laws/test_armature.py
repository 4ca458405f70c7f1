"""Armature and rotors of motors against rotors that are bodies of their own, against MuJoCo, and by hand."""

from __future__ import annotations

import numpy as np
import pytest
import sympy

import freebody as fb
from freebody.dynamics import float_state, forward_dynamics, inverse_dynamics, kinetic_energy, mass_matrix
from freebody.dynamics.conditions.loops import articulated_masses, loop_motion, own_speeds
from freebody.dynamics.impulse import (
    blows_on,
    generalized_impulse,
    impulsive_reactions,
    speed_jumps,
)
from freebody.dynamics.kinematics import link_twists
from freebody.dynamics.newton_euler import reactions
from freebody.testing import random_inertia, random_rotation, random_state

EPS = np.finfo(float).eps
EXACT = 2**12 * EPS  # as in test_laws_floats, times the condition of the mass matrix where it is solved
J, RATIO = 0.03, (20, -7, 11)


def arm(explicit, seed=3):
    """Three random bodies in a row on a hinge, a slider and a screw, each with a rotor in the body before it.

    ``explicit``: the rotor is a body with the moment of inertia J about its axis, on a hinge of its own that is geared
    to the joint; the moment of inertia J at rest, which the rotor has there, is taken from the parent.
    """
    rng = np.random.default_rng(seed)
    s = fb.System("arm")
    s.gravity = (1, -2, 3)
    parent, masses, joints = s.ground, [], []
    for i in range(3):
        masses.append((1.5 + i, rng.normal(size=3), random_inertia(rng) + np.eye(3)))
        axis = rng.normal(size=3)
        joints.append(
            (axis / np.linalg.norm(axis), rng.normal(size=3), rng.normal(size=3), random_rotation(rng))
        )
    for i, (kind, ratio) in enumerate(zip(("hinge", "slider", "screw"), RATIO, strict=True)):
        n, at, to, turned = joints[i]
        mass, centre, inertia = masses[i]
        if explicit and i < 2:  # the next joint's rotor stands in this body, about its axis there
            axis, _, _, axes = joints[i + 1]
            out = np.array(axes, float) @ axis
            inertia = inertia - J * np.outer(out, out)
        body = s.body(f"b{i}", fb.MassProperties(mass, centre, inertia))
        given = {"axis": n, "at": at, "to": to, "parent_axes": turned}
        if kind == "screw":
            given["pitch"] = 0.2
        if not explicit:
            given["rotor"] = fb.Rotor(J, ratio=ratio)
        joint = getattr(s, kind)(f"j{i}", parent, body, coordinate=f"q{i}", **given)
        if explicit:
            (q,) = (primitive.coordinate for primitive in joint.primitives)
            # mass and moments across the axis are nothing, as far as the fields of a solid allow it: set below
            s.hinge(
                f"r{i}",
                parent,
                thin(s, f"rotor{i}", n),
                axis=n,
                parent_axes=turned,
                at=at,
                coordinate=ratio * q,
            )
        parent = body
    s.force("F", parent.point(1, 2, 3), (1, -2, 0.5))
    return fb.assemble(s)


def thin(s, name, n):
    """A body whose only inertia is J about the axis n, which no solid has: mass properties by hand."""
    mass = fb.particle(0)
    object.__setattr__(mass, "inertia", tuple(tuple(float(x) for x in row) for row in J * np.outer(n, n)))
    return s.body(name, mass)


def close(a, b, tolerance):
    a, b = np.asarray(a, float), np.asarray(b, float)
    assert np.abs(a - b).max(initial=0) <= tolerance * max(1, np.abs(a).max(initial=0))


@pytest.mark.parametrize("seed", range(4))
def test_a_rotor_is_a_body_geared_to_the_joint(seed):
    short, long = arm(False, seed), arm(True, seed)
    q, u = random_state(short, seed)
    a, b = float_state(short, q, u), float_state(long, q, u)
    M = np.array(mass_matrix(short, a), float)
    close(M, mass_matrix(long, b), EXACT)
    close(kinetic_energy(short, a), kinetic_energy(long, b), EXACT)
    udot = forward_dynamics(short, a)
    close(udot, forward_dynamics(long, b), EXACT * np.linalg.cond(M))
    close(inverse_dynamics(short, a, [1, 2, 3]), inverse_dynamics(long, b, [1, 2, 3]), EXACT)
    program = fb.compile(short.described[0])
    close(program.forward_dynamics(q, u), udot, EXACT * np.linalg.cond(M))
    ground = reactions(short, a, udot)["j0"]
    whole = [np.array(x, float) for x in reactions(long, b, udot)["j0"]]
    # the axis of the first joint carries nothing of its own; the rotor of j0 stands in the ground
    close(ground[0], whole[0], EXACT * np.linalg.cond(M))


def test_rotors_in_a_struck_machine():
    """Jumps of the speeds, and the impulse in the ground's hinge, which is about that of rotors as bodies."""
    results = []
    for explicit in (False, True):
        model = arm(explicit)
        state = float_state(model, *random_state(model, 2))
        blow = (model.described[0].bodies["b2"].point(1, 0, 2), (3, -1, 2), (1, 1, -2))
        hits = blows_on(model, state, [blow])
        jump, _ = speed_jumps(model, state, generalized_impulse(model, state, hits))
        impulses = impulsive_reactions(model, state, link_twists(model, state, jump), hits)
        results.append((*jump, *impulses["j0"][0]))
        if not explicit:  # about the axis of the hinge no moment is left
            axis = np.array(model.links[0].rotation, float) @ np.array(model.links[0].axis, float)
            assert abs(axis @ np.array(impulses["j0"][1], float)) < 2**20 * EPS
    close(*results, 2**20 * EPS)


XML = """
<mujoco><option gravity="1 -2 3"/><worldbody><body pos="0.1 0.2 0.3">{first}
<inertial pos="0.1 -0.2 0.3" mass="2" fullinertia="1.2 1.4 1.6 0.1 0.2 -0.1"/>
<body pos="0.4 -0.1 0.2">{second}<inertial pos="-0.3 0.2 0.1" mass="1.5" fullinertia="0.8 0.7 0.9 -0.1 0.05 0.1"/>
</body></body></worldbody></mujoco>"""
KINDS = {
    "hinge": '<joint type="hinge" axis="0 0.6 0.8" armature="0.7"/>',
    "slider": '<joint type="slide" axis="0 0.6 0.8" armature="0.7"/>',
    "ball": '<joint type="ball" armature="0.7"/>',
    "free": '<joint type="free" armature="0.7"/>',
}


@pytest.mark.parametrize("first", KINDS)
@pytest.mark.parametrize("second", ["hinge", "slider", "ball"])
def test_armature_is_that_of_mujoco(first, second):
    mujoco = pytest.importorskip("mujoco")
    s = fb.System("mujoco")
    s.gravity = (1, -2, 3)
    inertias = (
        ((1.2, 0.1, 0.2), (0.1, 1.4, -0.1), (0.2, -0.1, 1.6)),
        ((0.8, -0.1, 0.05), (-0.1, 0.7, 0.1), (0.05, 0.1, 0.9)),
    )
    one = s.body("one", fb.MassProperties(2, (0.1, -0.2, 0.3), inertias[0]))
    two = s.body("two", fb.MassProperties(1.5, (-0.3, 0.2, 0.1), inertias[1]))
    for name, kind, ends, at in (
        ("a", first, (s.ground, one), (0.1, 0.2, 0.3)),
        ("b", second, (one, two), (0.4, -0.1, 0.2)),
    ):
        axis = {"axis": (0, 0.6, 0.8)} if kind in ("hinge", "slider") else {}
        getattr(s, kind)(name, *ends, at=None if kind == "free" else at, armature=0.7, **axis)
    model = fb.assemble(s)
    q, u = random_state(model, 5)
    peer = mujoco.MjModel.from_xml_string(XML.format(first=KINDS[first], second=KINDS[second]))
    data = mujoco.MjData(peer)
    data.qpos[:] = q
    udot = list(forward_dynamics(model, float_state(model, q, u)))
    qvel, qacc = list(u), list(udot)
    if (
        first == "free"
    ):  # MuJoCo: slides in ground axes, before the turns; ours: turns, then slides in body axes
        w, x, y, z = q[3:7]
        R = np.array(
            [
                [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
                [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
                [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
            ]
        )
        turn, slide = np.array(u[:3]), np.array(u[3:6])
        second_rate = R @ (np.array(udot[3:6]) + np.cross(turn, slide))
        qvel[:6], qacc[:6] = [*(R @ slide), *turn], [*second_rate, *udot[:3]]
    data.qvel[:] = qvel
    mujoco.mj_forward(peer, data)
    close(qacc, data.qacc, 1e-12)


def test_armature_of_motors_is_that_of_pinocchio():
    """The rotor of a motor behind a gear of ratio n counts J n², Pinocchio's rotorInertia rotorGearRatio²."""
    pin = pytest.importorskip("pinocchio")
    rotor, ratio = np.array([2e-4, 5e-5]), np.array([90.0, -120.0])
    s, peer, parent = fb.System("arm"), pin.Model(), 0
    s.gravity, bodies = (0, -9.81, 0), [s.ground]
    peer.gravity = pin.Motion(np.array([0, -9.81, 0]), np.zeros(3))
    for i in range(2):
        bodies.append(s.body(f"b{i}", fb.MassProperties(1.5 + i, (0.3, 0.1, -0.2), np.diag([0.5, 0.6, 0.7]))))
        s.hinge(f"h{i}", *bodies[-2:], at=(0.4 * i, 0, 0.1), axis="yz"[i], armature=rotor[i] * ratio[i] ** 2)
        joint = (pin.JointModelRY, pin.JointModelRZ)[i]()
        parent = peer.addJoint(parent, joint, pin.SE3(np.eye(3), np.array([0.4 * i, 0, 0.1])), f"h{i}")
        about = np.diag([0.5, 0.6, 0.7]).astype(float)
        peer.appendBodyToJoint(
            parent, pin.Inertia(1.5 + i, np.array([0.3, 0.1, -0.2]), about), pin.SE3.Identity()
        )
    peer.rotorInertia, peer.rotorGearRatio = rotor, ratio
    peer.armature = peer.rotorInertia * peer.rotorGearRatio**2
    model = fb.assemble(s)
    q, u = random_state(model, 5)
    M = np.array(mass_matrix(model, float_state(model, q, u)), float)
    data = peer.createData()
    upper = np.triu(pin.crba(peer, data, np.array(q)))
    close(np.triu(M), upper, 1e-12)
    udot = forward_dynamics(model, float_state(model, q, u))
    close(udot, pin.aba(peer, data, np.array(q), np.array(u), np.zeros(2)), 1e-12)


def test_loops_with_rotors():
    """A four-bar with rotors in the ground and in its crank, by one recursion over the links."""
    s = fb.System("four-bar")
    s.gravity = (0, -9, 0)
    bars = [s.body(f"bar{i}", fb.box(2, (length, 0.1, 0.2))) for i, length in enumerate((1, 2, 1.5))]
    crank, coupler, rocker = bars
    s.hinge("A", s.ground, crank, to=(-0.5, 0, 0), rotor=fb.Rotor(0.02, ratio=9))
    s.hinge("B", crank, coupler, at=(0.5, 0, 0), to=(-1, 0, 0), rotor=fb.Rotor(0.01, ratio=-30))
    s.hinge("D", s.ground, rocker, at=(2, 0, 0), to=(-0.75, 0, 0), armature=0.4)
    s.hinge("C", coupler, rocker, at=(1, 0, 0), to=(0.75, 0, 0))
    motion = fb.simulate(s, 2, initial={"A": 1.2, "A'": 2.0}, near={"B": -1, "D": 1.5})
    assert np.abs(motion.energy.residual).max() < 1e-7
    model = fb.assemble(s)
    q, u = [1.2, -1.0, 1.5], [2.0, 0.5, -0.3]
    state = float_state(model, q, u)
    speeds = own_speeds(model)
    G = [[1.0, 2.0, 0.5], [0.3, -1.0, 1.0]]
    f, g = [1.0, 2.0, 3.0], [0.1, 0.2]
    M = np.array(mass_matrix(model, state), float)
    rates, forces = loop_motion(model, state, speeds, f, G, g)
    close(M @ np.array(rates) - np.array(G).T @ np.array(forces), f, EXACT * np.linalg.cond(M))
    close(np.array(G) @ np.array(rates), g, EXACT * np.linalg.cond(M))
    masses = articulated_masses(model, state, speeds)
    close(masses, [1 / np.linalg.inv(M[:2, :2])[0, 0], M[1, 1], M[2, 2]], EXACT * np.linalg.cond(M))


def test_the_reflected_inertia_is_that_of_the_book():
    """(I + J n²) θ'' = T: the motor's rotor turns n times as fast, and the gear transmits n times its torque."""
    s = fb.System("arm")
    m, L, r, n, T = s.parameters("m L r n T")
    bar = s.body("bar", fb.slender_bar(m, L, axis="x"))
    pin = s.hinge("pin", s.ground, bar, to=(-L / 2, 0, 0), coordinate="theta", rotor=fb.Rotor(r, ratio=n))
    s.torque("T", pin, n * T)
    (equation,) = fb.equations(s).motion
    theta = s.expression("theta").diff(s.t, 2)
    expected = (m * L**2 / 3 + r * n**2) * theta - n * T
    assert sympy.expand(equation.lhs - equation.rhs - expected) == 0


def test_the_spin_of_a_rotor_turns_its_carrier():
    """A rotor about x in a turntable about z: M_y = J n φ' ψ' is in the bearings, and nothing along z."""
    s = fb.System("turntable")
    psi, phi = s.coordinates("psi phi")
    table = s.body("table", fb.disk(4, 1, axis="z"))
    arm = s.body("arm", fb.box(1, (1, 1, 1)))
    s.hinge("shaft", s.ground, table, coordinate=psi)
    s.hinge("pin", table, arm, axis="x", coordinate=phi, rotor=fb.Rotor("3", ratio=5))
    e = fb.equations(s)
    about = e.free_body("table").moment_form(table.center)
    assert about.proven
    rate = about.terms["rate of the rotors' spin"]
    t = s.t
    expected = sympy.Matrix(
        [
            15 * (phi.diff(t, 2) * sympy.cos(psi) - phi.diff(t) * psi.diff(t) * sympy.sin(psi)),
            15 * (phi.diff(t, 2) * sympy.sin(psi) + phi.diff(t) * psi.diff(t) * sympy.cos(psi)),
            0,
        ]
    )
    assert sympy.simplify(rate - expected) == sympy.zeros(3, 1)
