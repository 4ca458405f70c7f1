"""Laws that every machine obeys, on random machines of floats.

Tolerances: EXACT for algebra, a number of round-offs times the condition of the mass matrix where it is solved;
DIFFERENCE for central differences of fourth order, whose best step h = eps^(1/5) leaves an error of the order h⁴.
"""

from __future__ import annotations

import copy
import dataclasses

import numpy as np
import pytest

import freebody as fb
from freebody.describe.loads.force import Force
from freebody.describe.loads.spring import Spring
from freebody.describe.loads.torque import Torque
from freebody.dynamics import (
    bias,
    coordinate_rates,
    float_state,
    forward_dynamics,
    inverse_dynamics,
    jacobian,
    kinetic_energy,
    mass_matrix,
    mechanical_power,
    momentum,
    poses,
    potential_energy,
    reactions,
)
from freebody.dynamics.kinematics import angular_velocity, point_acceleration, point_position, point_velocity
from freebody.dynamics.momentum import mass_centre
from freebody.testing import (
    JOINTS,
    random_chain,
    random_inertia,
    random_rotation,
    random_state,
    random_system,
)

EPS = np.finfo(float).eps
EXACT = 2**10 * EPS  # of the largest term; recursions over at most five bodies
STEP = EPS ** (1 / 5)
DIFFERENCE = 2**10 * STEP**4
SEEDS = range(12)
T = 0.3


@pytest.fixture(params=[*SEEDS, "solved", "together"])
def machine(request):
    """A random tree of five bodies, loaded; every third with a driven joint, every second with rotors and armature.

    Two have coordinates that are expressions.
    """
    if request.param in COUPLED:
        return Machine(coupled(COUPLED[request.param]), 3)
    seed = request.param
    s = random_system(seed, 5, driven=seed % 3 == 0, armature=seed % 2 == 1)
    return Machine(s, seed)


COUPLED = {
    # the displacements determine the coordinates one after another
    "solved": ["q1 + t**2/3", "2*q2 + sin(q1)", "q3 - q1*q2 + t*q1"],
    # all together only, through the mass matrix
    "together": ["q1 + t**2/3", "q2*q1 + q1", "q3 + q2**2/2"],
}


def coupled(coordinates):
    """Three joints whose displacements are functions of all coordinates and time, with loads of every kind."""
    rng = np.random.default_rng(5)
    s = fb.System("coupled")
    s.gravity = (1, -2, 3)
    s.coordinates("q1 q2 q3")
    parent = s.ground
    for i, (kind, coordinate) in enumerate(zip(("hinge", "slider", "screw"), coordinates, strict=True)):
        body = s.body(f"b{i}", fb.MassProperties(1 + i, rng.normal(size=3), random_inertia(rng)))
        given = {"at": rng.normal(size=3), "to": rng.normal(size=3), "axis": rng.normal(size=3)}
        if kind == "screw":
            given["pitch"] = 0.3
        given["rotor"] = fb.Rotor(0.5, ratio=i + 1)
        joint = getattr(s, kind)(f"j{i}", parent, body, coordinate=s.expression(coordinate), **given)
        s.spring(f"k{i}", joint, stiffness=2, rest=0.2)
        s.damper(f"c{i}", joint, damping=0.5)
        parent = body
    for q in ("q1", "q2", "q3"):
        s.generalized_force(q, f"{q}' - t")
    s.torque("M", s.joints["j0"], "3*sin(t)")
    return s


class Machine:
    def __init__(self, s, seed):
        self.system, self.seed = s, seed
        self.model = fb.assemble(s)
        self.q, self.u = random_state(self.model, seed)
        self.rng = np.random.default_rng(seed + 100)
        self.udot = [float(x) for x in self.rng.normal(size=self.model.n_u)]

    def state(self, q=None, u=None, t=T):
        return float_state(self.model, self.q if q is None else q, self.u if u is None else u, t)

    def along(self, h, udot=None):
        """The state a little later on a motion with the accelerations ``udot``."""
        udot = self.udot if udot is None else udot
        rates = coordinate_rates(self.model, self.state())
        q = [a + h * b for a, b in zip(self.q, rates, strict=True)]
        u = [a + h * b for a, b in zip(self.u, udot, strict=True)]
        return self.state(q, u, T + h)

    def rate(self, function):
        """d/dt of a function of the state along the motion, by central difference."""
        h = STEP / max(1, *map(abs, self.udot))  # a faster motion is seen in a shorter time
        f = {k: np.asarray(function(self.along(k * h)), float) for k in (-2, -1, 1, 2)}
        return (8 * (f[1] - f[-1]) - (f[2] - f[-2])) / (12 * h)


def close(a, b, tolerance, scale=0):
    a, b = np.asarray(a, float), np.asarray(b, float)
    size = max(1, np.abs(a).max(initial=0), np.abs(b).max(initial=0), scale)
    assert np.abs(a - b).max(initial=0) <= tolerance * size


def matrix(model, state):
    return np.array(mass_matrix(model, state), float).reshape(model.n_u, model.n_u)


def test_kinetic_energy_is_half_u_M_u():
    for seed in SEEDS:
        m = Machine(random_system(seed, 5, armature=seed % 2 == 1), seed)
        state = m.state()
        u = np.array(m.u)
        close(u @ matrix(m.model, state) @ u / 2, kinetic_energy(m.model, state), EXACT)


def test_mass_matrix_is_symmetric_and_positive_definite(machine):
    M = matrix(machine.model, machine.state())
    assert (M == M.T).all()
    assert (np.linalg.eigvalsh(M) > 0).all()


def test_forward_dynamics_undoes_inverse_dynamics(machine):
    model, state = machine.model, machine.state()
    forces = inverse_dynamics(model, state, machine.udot)
    M = matrix(model, state)
    condition = np.linalg.cond(M) if len(M) else 1
    close(forward_dynamics(model, state, forces), machine.udot, EXACT * condition)


def test_motion_needs_no_further_force(machine):
    model, state = machine.model, machine.state()
    udot = forward_dynamics(model, state)
    scale = np.abs(matrix(model, state) @ np.array(udot)).max(initial=0)
    M = matrix(model, state)
    condition = np.linalg.cond(M) if len(M) else 1
    close(inverse_dynamics(model, state, udot), [0] * model.n_u, EXACT * condition, scale)


def test_mass_matrix_is_the_slope_of_inverse_dynamics(machine):
    model, state = machine.model, machine.state()
    M, h = matrix(model, state), np.array(bias(model, state), float)
    for j in range(model.n_u):
        unit = [int(k == j) for k in range(model.n_u)]
        close(np.array(inverse_dynamics(model, state, unit), float) - h, M[:, j], EXACT, np.abs(h).max())


def test_mass_matrix_is_the_inverse_slope_of_articulated_bodies(machine):
    model, state = machine.model, machine.state()
    M, rest = matrix(model, state), np.array(forward_dynamics(model, state), float)
    for j in range(model.n_u):
        unit = [int(k == j) for k in range(model.n_u)]
        slope = np.array(forward_dynamics(model, state, unit), float) - rest
        close(M @ slope, unit, EXACT * np.linalg.cond(M), np.abs(M).max() * np.abs(rest).max())


def test_energy_changes_by_the_power_of_loads_and_drives(machine):
    model = machine.model
    machine.udot = list(forward_dynamics(model, machine.state()))

    def energy(state):
        return kinetic_energy(model, state) + potential_energy(model, state)

    power = mechanical_power(model, machine.state(), machine.udot)
    close(machine.rate(energy), power, DIFFERENCE, 10 * abs(energy(machine.state())))


def test_velocities_are_rates_of_positions(machine):
    model, state = machine.model, machine.state()
    for body in machine.system.bodies.values():
        point = body.point(*map(float, machine.rng.normal(size=3).round(3)))
        close(
            machine.rate(lambda x, p=point: point_position(model, x, p)),
            point_velocity(model, state, point),
            DIFFERENCE,
            10,
        )
        close(
            machine.rate(lambda x, p=point: point_velocity(model, x, p)),
            point_acceleration(model, state, point, machine.udot),
            DIFFERENCE,
            100,
        )
        # dR/dt = [w]x R
        R = np.array(poses(model, state)[body.name].rotation, float)
        W = machine.rate(lambda x, b=body: poses(model, x)[b.name].rotation) @ R.T
        close([W[2, 1], W[0, 2], W[1, 0]], angular_velocity(model, state, body), DIFFERENCE, 10)


def test_unit_quaternions_keep_their_length(machine):
    rates = coordinate_rates(machine.model, machine.state())
    for i in machine.model.quaternions:
        close(np.dot(machine.q[i : i + 4], rates[i : i + 4]), 0, EXACT)


def test_jacobian_gives_the_velocity_beyond_that_of_the_drives(machine):
    model, state = machine.model, machine.state()
    still = machine.state(u=[0] * model.n_u)
    for body in machine.system.bodies.values():
        point = body.point(0.3, -0.7, 0.2)
        J = np.array(jacobian(model, state, point), float).reshape(6, model.n_u)
        moving = (*angular_velocity(model, state, body), *point_velocity(model, state, point))
        driven = (*angular_velocity(model, still, body), *point_velocity(model, still, point))
        close(J @ np.array(machine.u) + np.array(driven, float), moving, EXACT)


def test_translation_theorem_and_momentum_of_each_body(machine):
    """H_0 = r_C x p + H_C with H_C = R I_C Rᵀ w + spin of rotors, from poses and velocities of points only."""
    model, state = machine.model, machine.state()
    for name, body in machine.system.bodies.items():
        mass = body.mass_properties
        r = np.array(point_position(model, state, body.center), float)
        p = mass.mass * np.array(point_velocity(model, state, body.center), float)
        R = np.array(poses(model, state)[name].rotation, float)
        H_C = R @ np.array(mass.inertia, float) @ R.T @ np.array(angular_velocity(model, state, body), float)
        for link in model.links:
            if link.parent == model.bodies[name].link and any(link.rotor):
                spin = np.array(link.rotation, float) @ np.array(link.rotor, float)
                H_C = H_C + R @ spin * state.rate(link)
        about_0 = momentum(model, state, bodies={name})
        about_C = momentum(model, state, about=tuple(r), bodies={name})
        scale = np.abs(r).max() * np.abs(p).max()
        close(about_0.linear, p, EXACT)
        close(about_C.angular, H_C, EXACT, scale)
        close(about_0.angular, np.cross(r, p) + H_C, EXACT, scale)


def test_momentum_of_the_whole_is_that_of_its_mass_centre(machine):
    model, state = machine.model, machine.state()
    mass, _ = mass_centre(model, state)
    velocity = machine.rate(lambda x: mass_centre(model, x)[1])
    close(momentum(model, state).linear, mass * velocity, DIFFERENCE, 10)


@pytest.mark.parametrize("seed", SEEDS)
def test_reactions_and_weight_are_the_rate_of_momentum_of_every_body(seed):
    """dp/dt = Σ R + m g,  dH_0/dt = Σ (M + r x R) + r_C x m g: the loads that act are reactions and weight only."""
    m = Machine(random_system(seed, 5, loads=False, driven=seed % 2 == 0), seed)
    model, state = m.model, m.state()
    m.udot = list(forward_dynamics(model, state))
    all_reactions = reactions(model, state, m.udot)
    g = np.array(m.system.gravity, float)
    ground = []
    for name, body in m.system.bodies.items():
        force = body.mass_properties.mass * g
        moment = np.cross(np.array(point_position(model, state, body.center), float), force)
        for joint in m.system.joints.values():
            sign = (joint.child is body) - (joint.parent is body)
            R, M = (np.array(x, float) for x in all_reactions[joint.name])
            r = np.array(point_position(model, state, joint.child.point(*joint.to)), float)
            force = force + sign * R
            moment = moment + sign * (M + np.cross(r, R))
            if joint.parent.is_ground and joint.child is body:
                ground.append((R, M + np.cross(r, R)))
        scale = 10 * max(np.abs(force).max(), np.abs(moment).max(), 10)
        close(m.rate(lambda x, n=name: momentum(model, x, bodies={n}).linear), force, DIFFERENCE, scale)
        close(m.rate(lambda x, n=name: momentum(model, x, bodies={n}).angular), moment, DIFFERENCE, scale)
    # and of the whole machine: only the ground's reactions and the weight are left
    mass, r_C = mass_centre(model, state)
    force = sum(R for R, _ in ground) + mass * g
    moment = sum(M for _, M in ground) + np.cross(np.array(r_C, float), mass * g)
    scale = 10 * max(np.abs(force).max(), np.abs(moment).max(), 10)
    close(m.rate(lambda x: momentum(model, x).linear), force, DIFFERENCE, scale)
    close(m.rate(lambda x: momentum(model, x).angular), moment, DIFFERENCE, scale)


@pytest.mark.parametrize("kind", [kind for kind in JOINTS if kind != "weld"])
def test_a_reaction_does_no_work_in_a_free_joint(kind):
    """Power of the reaction through the joint, from the relative velocity of the two points and bodies."""
    s = random_system(7, 3, joints=[kind], branching=False)
    m = Machine(s, 7)
    state = m.state()
    result = reactions(m.model, state, m.udot)  # for any motion, not only the natural one
    for name, joint in s.joints.items():
        R, M = result[name]
        here, there = joint.child.point(*joint.to), joint.parent.point(*joint.at)
        v_child = np.array(point_velocity(m.model, state, here), float)
        w_parent = np.array(angular_velocity(m.model, state, joint.parent), float)
        arm = np.array(point_position(m.model, state, here), float) - np.array(
            point_position(m.model, state, there), float
        )
        v_parent = np.array(point_velocity(m.model, state, there), float) + np.cross(w_parent, arm)
        w = np.array(angular_velocity(m.model, state, joint.child), float) - w_parent
        size = np.abs(R).max() + np.abs(M).max() if kind != "free" else 0
        close(np.dot(R, v_child - v_parent) + np.dot(M, w), 0, EXACT, 10 * size)


def test_reactions_of_the_natural_motion_are_those_of_any_motion(machine):
    """What the short form leaves out is zero on the motion."""
    model, state = machine.model, machine.state()
    udot = forward_dynamics(model, state)
    long, short = (reactions(model, state, udot, natural=natural) for natural in (False, True))
    M = matrix(model, state)
    condition = np.linalg.cond(M) if len(M) else 1
    size = max((abs(x) for pair in long.values() for v in pair for x in v), default=0)
    for name in model.joints:
        close(long[name], short[name], EXACT * condition, size)


def changed(joint, **fields):
    """Return a copy of a joint of a system, with other places."""
    result = copy.copy(joint)
    for name, value in fields.items():
        object.__setattr__(result, name, value)
    return result


def moved(seed, rotation, shift):
    """The random machine with its ground end carried to another place: everything fixed in the ground moves along."""
    s = random_system(seed, 4)
    R, p = np.array(rotation), np.array(shift)

    def vector(v):
        return tuple(float(x) for x in R @ np.array(v, float))

    def place(c):
        return tuple(float(x) for x in p + R @ np.array(c, float))

    def at(point):
        return s.ground.point(*place(point.components)) if point.body.is_ground else point

    for name, joint in s.joints.items():
        if joint.parent.is_ground:
            axes = tuple(tuple(map(float, row)) for row in R @ np.array(joint.parent_axes, float))
            s.joints[name] = changed(joint, at=place(joint.at), start=place(joint.start), parent_axes=axes)
    for name, load in s.loads.items():
        if hasattr(load, "joint"):
            s.loads[name] = dataclasses.replace(load, joint=s.joints[load.joint.name])
        elif isinstance(load, Force | Torque):
            if load.frame is None:
                s.loads[name] = dataclasses.replace(load, components=vector(load.components))
        elif hasattr(load, "start"):
            s.loads[name] = dataclasses.replace(load, start=at(load.start), end=at(load.end))
    s.gravity = vector(s.gravity)
    return s


@pytest.mark.parametrize("seed", SEEDS)
def test_motion_does_not_depend_on_where_the_ground_frame_is(seed):
    rng = np.random.default_rng(seed)
    there = moved(seed, random_rotation(rng), rng.normal(size=3))
    assert any(isinstance(load, Spring) for load in there.loads.values())
    a, b = Machine(random_system(seed, 4), seed), Machine(there, seed)
    M = matrix(a.model, a.state())
    condition = np.linalg.cond(M)
    close(M, matrix(b.model, b.state()), EXACT)
    close(forward_dynamics(a.model, a.state()), forward_dynamics(b.model, b.state()), EXACT * condition)


@pytest.mark.parametrize("seed", SEEDS)
def test_motion_does_not_depend_on_the_order_of_description(seed):
    s = random_system(seed, 5)
    s.bodies = dict(reversed(s.bodies.items()))
    s.joints = dict(reversed(s.joints.items()))
    s.loads = dict(reversed(s.loads.items()))
    a, b = Machine(random_system(seed, 5), seed), Machine(s, seed)
    assert a.model.coordinate_names == b.model.coordinate_names
    condition = np.linalg.cond(matrix(a.model, a.state()))
    close(matrix(a.model, a.state()), matrix(b.model, b.state()), EXACT)
    close(forward_dynamics(a.model, a.state()), forward_dynamics(b.model, b.state()), EXACT * condition)


@pytest.mark.parametrize("seed", SEEDS)
def test_motion_does_not_depend_on_the_names(seed):
    """Bodies, joints, loads and coordinates under other names, in another alphabetical order."""
    a = random_system(seed, 4)
    b = fb.System("renamed")
    b.gravity = a.gravity
    bodies = {"ground": b.ground}
    for name, body in a.bodies.items():
        bodies[name] = b.body(f"z{9 - int(name[1:])}", body.mass_properties)
    for name, joint in a.joints.items():
        given = {
            "at": joint.at,
            "to": joint.to,
            "parent_axes": joint.parent_axes,
            "child_axes": joint.child_axes,
        }
        given |= {key: getattr(joint, key) for key in ("axis", "pitch") if hasattr(joint, key)}
        new = f"y{9 - int(name[1:])}"
        made = getattr(b, joint.type)(new, bodies[joint.parent.name], bodies[joint.child.name], **given)
        assert made.name == new
    for load in a.loads.values():
        assert load.name  # the loads are left out on both sides
    a.loads.clear()
    one, two = Machine(a, seed), Machine(b, seed)
    condition = np.linalg.cond(matrix(one.model, one.state()))
    close(matrix(one.model, one.state()), matrix(two.model, two.state()), 0)
    close(
        forward_dynamics(one.model, one.state()), forward_dynamics(two.model, two.state()), EXACT * condition
    )


def test_cost_of_forward_dynamics_is_linear_in_the_number_of_bodies():
    """Counted in operations of the recorded program, so that no clock is asked."""
    from freebody.dynamics import traced_state
    from freebody.scalar.trace import Tape

    def operations(links):
        model, tape = fb.assemble(random_chain(1, links)), Tape()
        forward_dynamics(model, traced_state(model, tape))
        return len(tape)

    five, ten, twenty = map(operations, (5, 10, 20))
    assert twenty - ten <= 2.2 * (ten - five)


def test_coupled_machines_are_what_they_say():
    assert fb.assemble(coupled(COUPLED["solved"])).order is not None
    assert fb.assemble(coupled(COUPLED["together"])).order is None
