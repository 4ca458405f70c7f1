"""Large trees: the looped path against the straight one, on machines of all joints and loads."""

from __future__ import annotations

import gc
from dataclasses import replace

import numpy as np
import pytest

import freebody as fb
from freebody import dynamics
from freebody.dynamics.kinematics import angular_velocity, point_velocity
from freebody.dynamics.loads.loading import load_power
from freebody.dynamics.motion import all_reactions, motion, total_power
from freebody.dynamics.newton_euler import reactions
from freebody.program.arguments import place_of
from freebody.program.large import link_step, tree_loop
from freebody.program.large.link_places import accelerations, sums
from freebody.program.large.tree_loop import LoopedSet
from freebody.program.large.tree_parts import Directions
from freebody.program.products import product_named
from freebody.testing import random_chain, random_inertia, random_state, random_system
from sampled import sampled


def reference(model, q, u, t, values=None):
    """The same functions on floats."""
    s = dynamics.float_state(model, q, u, t, values)
    moving = motion(model, s)
    power = [total_power(model, s, moving)]
    poses = dynamics.poses(model, s)
    return {
        "accelerations": moving.udot,
        "rates": [*dynamics.coordinate_rates(model, s), *moving.udot, *power],
        "energy": [dynamics.kinetic_energy(model, s), dynamics.potential_energy(model, s)],
        "kinetic_energy": [dynamics.kinetic_energy(model, s)],
        "potential_energy": [dynamics.potential_energy(model, s)],
        "poses": [x for b in model.bodies for x in (*poses[b].position, *np.ravel(poses[b].rotation))],
        "postures": [x for b in model.bodies for x in (*np.ravel(poses[b].rotation), *poses[b].position)],
        **moved(model, s),
    }


def moved(model, s):
    found = dynamics.momentum(model, s)
    pairs = []
    for name in model.bodies:
        point = place_of(model, name)
        pairs += [*angular_velocity(model, s, point.body), *point_velocity(model, s, point)]
    return {"velocities": pairs, "momentum": [*found.linear, *found.angular]}


def compare(model, kernels, q, u, t, values=None):
    """To round-off, times the condition of the mass matrix where it is inverted."""
    c = kernels.constants([model.values(values)[p.name] for p in model.parameters])
    s = dynamics.float_state(model, q, u, t, values)
    condition = np.linalg.cond(np.array(dynamics.mass_matrix(model, s), dtype=float)) if model.n_u else 1
    for name, expected in reference(model, q, u, t, values).items():
        found = kernels[name](t, [*q, *u][: kernels[name].state], c)
        expected = np.array(expected, dtype=float)[: len(found)]
        error = np.abs(found - expected).max() / max(1.0, np.abs(expected).max())
        inverted = name in ("accelerations", "rates")
        assert error <= 2e-15 * len(model.links) * (condition if inverted else 1), name


@pytest.mark.parametrize("seed", sampled(range(12), 3))
def test_random_machines(seed):
    model = fb.assemble(random_system(seed, bodies=6, driven=seed % 2 == 0))
    assert tree_loop.applies(model)
    kernels = LoopedSet(model)
    for k in range(2):
        compare(model, kernels, *random_state(model, 10 * seed + k), 0.4)
    q, u = random_state(model, seed)
    forces = np.random.default_rng(seed).normal(size=model.n_u)
    kernels = LoopedSet(model, "forced")
    found = kernels["accelerations"](0.4, [*q, *u, *forces], kernels.constants([]))
    s = dynamics.float_state(model, q, u, 0.4)
    expected = np.array(dynamics.forward_dynamics(model, s, list(forces)), dtype=float)
    assert np.abs(found - expected).max(initial=0) <= 1e-10 * np.abs(expected).max(initial=1)


@pytest.mark.parametrize("seed", sampled(range(12), 3))
def test_forces_from_accelerations_and_mass_matrices(seed):
    """Inverse dynamics, bias and mass matrix of random machines, against the algorithms on floats."""
    back(fb.assemble(random_system(seed, bodies=6, driven=seed % 2 == 0)), seed)


def back(model, seed, values=None):
    q, u = random_state(model, seed)
    udot = np.random.default_rng(seed).normal(size=model.n_u)
    s = dynamics.float_state(model, q, u, 0.4, values)
    M = np.array(dynamics.mass_matrix(model, s), dtype=float)
    h = np.array(dynamics.bias(model, s), dtype=float)
    inverse, mass = LoopedSet(model, "inverse"), LoopedSet(model, "mass")
    parameters = [model.values(values)[p.name] for p in model.parameters]
    c, d = inverse.constants(parameters), mass.constants(parameters)
    tau = inverse["inverse_dynamics"](0.4, [*q, *u, *udot], c)
    size = max(
        1.0, np.abs(h).max(initial=0), np.abs(M).sum(axis=1).max(initial=0) * np.abs(udot).max(initial=0)
    )
    bound = 2e-15 * len(model.links) * size
    assert (
        np.abs(tau - np.array(dynamics.inverse_dynamics(model, s, list(udot)), dtype=float)).max(initial=0)
        <= bound
    )
    assert np.abs(inverse["bias"](0.4, [*q, *u], c) - h).max(initial=0) <= bound
    found = mass["mass_matrix"](0.4, q, d).reshape(model.n_u, model.n_u)
    assert np.abs(found - M).max(initial=0) <= 2e-15 * len(model.links) * max(1.0, np.abs(M).max(initial=0))


def flat_machine(seed, normal):
    """Bodies of any shape, off the plane, on hinges and sliders that keep them in it; one is driven."""
    random = np.random.default_rng(seed)
    s = fb.System(f"flat {seed}")
    s.gravity = tuple(random.normal(size=3).tolist())
    a, b = (k for k in range(3) if k != normal)
    bodies = [s.ground]
    for i in range(8):
        body = s.body(f"b{i}", random_body(random))
        parent = bodies[random.integers(len(bodies))]
        at, to = (tuple(x) for x in random.normal(size=(2, 3)).round(2).tolist())
        unit = [0.0, 0.0, 0.0]
        if i % 3 == 2:
            unit[a], unit[b] = 0.6, 0.8
            s.slider(f"j{i}", parent, body, at=at, to=to, axis=tuple(unit), coordinate=f"q{i}")
        else:
            unit[normal] = (-1.0) ** i
            name = "sin(2*t)" if i == 4 else f"q{i}"
            s.hinge(f"j{i}", parent, body, at=at, to=to, axis=tuple(unit), coordinate=name)
        s.force(f"f{i}", body.point(*random.normal(size=3)), tuple(random.normal(size=3)))
        bodies.append(body)
    s.weld("w", bodies[-1], s.body("tool", random_body(random)), at=(0.1, 0.2, 0.3))
    return fb.assemble(s)


def random_body(random):
    """A body whose inertia couples all axes."""
    return fb.MassProperties(1.5, random.normal(size=3).tolist(), random_inertia(random))


@pytest.mark.parametrize("normal", range(3))
@pytest.mark.parametrize("seed", sampled(range(2), 2))
def test_links_that_stay_in_a_plane_leave_out_what_stands_across_it(seed, normal):
    model = flat_machine(seed, normal)
    for mode, plane in (("motion", normal), ("forced", normal), ("inverse", -1), ("reactions", -1)):
        assert LoopedSet(model, mode)._parts.normal == plane
    compare(model, LoopedSet(model), *random_state(model, seed), 0.4)
    back(model, seed)
    joined(model, seed)
    q, u = random_state(model, seed)
    derivatives = LoopedSet(model, directions=Directions("accelerations", 0, model.n_q + model.n_u))
    y, c = np.array([*q, *u]), derivatives.constants([])
    J = derivatives["f"](0.4, y, c).reshape(model.n_u, -1)
    rates, h = LoopedSet(model)["accelerations"], 1e-6
    c = LoopedSet(model).constants([])
    for k in range(y.size):
        step = h * (np.arange(y.size) == k)
        difference = (rates(0.4, y + step, c) - rates(0.4, y - step, c)) / (2 * h)
        assert J[:, k] == pytest.approx(difference, rel=1e-5, abs=1e-5 * (1 + np.abs(J).max()))
    kind, steps = link_step.Kind("hinge", normal, False, True, False, True, normal), ("inward",)
    flat = link_step.compiled_step(kind, steps)
    space = link_step.compiled_step(replace(kind, normal=-1), steps)
    flat, space = (sum(x.compiled.operations["inward"].values()) for x in (flat, space))
    assert 3 * flat < space


def test_forces_where_displacements_are_expressions():
    back(fb.assemble(described()), 3, {"m": 2.5, "L": 0.4, "k": 0.7})


@pytest.mark.parametrize("seed", sampled(range(12), 3))
def test_reactions_and_jacobians(seed):
    """Reactions in the motion and at given accelerations, Jacobian of every body, against the algorithms on floats."""
    joined(fb.assemble(random_system(seed, bodies=6, driven=seed % 2 == 0)), seed)


def joined(model, seed, values=None):
    q, u = random_state(model, seed)
    udot = np.random.default_rng(seed).normal(size=model.n_u)
    s = dynamics.float_state(model, q, u, 0.4, values)
    parameters = [model.values(values)[p.name] for p in model.parameters]
    condition = np.linalg.cond(np.array(dynamics.mass_matrix(model, s), dtype=float)) if model.n_u else 1
    natural, given = LoopedSet(model, "reactions"), LoopedSet(model, "reactions_at")
    assert natural["multipliers"](0.4, [*q, *u], natural.constants(parameters)).size == 0
    for kernels, y, expected, by in (
        (natural, [*q, *u], all_reactions(model, s, motion(model, s)), condition),
        (given, [*q, *u, *udot], reactions(model, s, list(udot)), 1),
    ):
        found = kernels["reactions"](0.4, y, kernels.constants(parameters))
        numbers = np.array([[*f, *n] for f, n in expected.values()], dtype=float).ravel()
        bound = 2e-15 * len(model.links) * by * max(1.0, np.abs(numbers).max())
        assert np.abs(found - numbers).max() <= bound
    for name in model.bodies:
        point = place_of(model, name)
        kernels = LoopedSet(model, "jacobian", point)
        found = kernels["jacobian"](0.4, q, kernels.constants(parameters))
        J = np.array(dynamics.jacobian(model, s, point), dtype=float).ravel()
        assert np.abs(found - J).max(initial=0) <= 2e-15 * len(model.links) * max(
            1.0, np.abs(J).max(initial=0)
        )


def test_reactions_where_displacements_are_expressions():
    joined(fb.assemble(described()), 3, {"m": 2.5, "L": 0.4, "k": 0.7})


def described():
    """Parameters, absolute angles, a driven hinge, springs at points and a screw."""
    s = fb.System("described")
    m, L, g, k = s.parameters(m=1.2, L=0.7, g=9.0, k=3.0)
    s.gravity = (0, "-g", 0)
    a, b = s.coordinates("a b")
    one, two = s.body("one", fb.slender_bar(m, L, axis="y")), s.body("two", fb.box(2 * m, (L, L / 2, L / 3)))
    three, four = s.body("three", fb.disk(m, L, axis="x")), s.body("four", fb.particle(m))
    s.hinge("A", s.ground, one, to=(0, L / 2, 0), axis="z", coordinate=a)
    s.hinge("B", one, two, at=(0, -L / 2, 0), axis="z", coordinate=b - a)
    s.hinge("C", two, three, at=(0, 0, L), axis="x", coordinate="sin(3*t)")
    thread = s.screw("D", three, four, axis=(0, 3, 4), pitch=0.1, coordinate="z")
    s.spring("S", thread, stiffness=k)
    s.spring("rope", s.ground.point(0, 1, 0), four.point(0, L, 0), stiffness=k, rest=L)
    s.damper("dash", one.point(1, 0, 0), three.point(0, 1, 0), damping=0.3)
    s.generalized_force(b, "k*sin(a) - b'")
    return s


def test_expressions_of_all_kinds():
    model = fb.assemble(described())
    kernels = LoopedSet(model)
    assert kernels.works
    for values in (None, {"m": 2.5, "L": 0.4, "k": 0.0}):
        compare(model, kernels, [0.3, -0.4, 0.2], [1.0, 0.5, -0.7], 0.8, values)


def test_what_can_not_be_looped_over():
    s = fb.System("sum")
    p, q = s.coordinates("p q")
    body = s.body("x", fb.particle(1))
    other = s.body("y", fb.particle(1))
    s.slider("X", s.ground, body, axis="x", coordinate="p + q")
    s.slider("Y", s.ground, other, axis="x", coordinate="p - q")
    assert not tree_loop.applies(fb.assemble(s))


@pytest.mark.parametrize("seed", range(4))
def test_forces_with_armature_couplings_and_loops(seed):
    """From accelerations to forces, neither shared coordinates nor armature nor closed loops stand in the way."""
    random = np.random.default_rng(seed)
    s = fb.System("coupled")
    s.gravity = (1, -2, 3)
    p, q = s.coordinates("p q")
    a, b, c, d, e = (s.body(x, random_body(random)) for x in "abcde")
    at = [tuple(x) for x in random.normal(size=(6, 3)).round(2).tolist()]
    s.free("float", s.ground, a, armature=0.4) if seed % 2 else s.ball("pivot", s.ground, a, armature=0.3)
    s.hinge("one", a, b, at=at[0], axis=(0.6, 0, 0.8), coordinate="p + q", armature=0.7)
    s.slider("two", b, c, at=at[1], axis="y", coordinate="p - q**2/4", armature=0.2)
    s.hinge("three", a, d, at=at[2], axis="x", coordinate="sin(t)")
    s.hinge("four", d, e, at=at[3], axis="z", armature=0.1)
    s.spring("bow", b.point(*at[4]), e.point(*at[5]), stiffness=3)
    s.ball("closing", c, e, at=at[4], to=at[5])
    model = fb.assemble(s)
    assert tree_loop.applies(model, "inverse") and not tree_loop.applies(model)
    back(model, seed)


def test_rotors_that_stand_in_moving_bodies_are_not_looped_over():
    s = fb.System("geared")
    a = s.body("a", fb.sphere(1, 1))
    s.hinge("one", s.ground, a, axis="z", rotor=fb.Rotor(0.01, ratio=9))
    assert tree_loop.applies(fb.assemble(s), "mass")
    b = s.body("b", fb.sphere(1, 1))
    s.hinge("two", a, b, axis="x", rotor=fb.Rotor(0.01, ratio=9))
    assert not tree_loop.applies(fb.assemble(s), "mass")


@pytest.fixture
def small(monkeypatch):
    """Every tree counts as large."""
    monkeypatch.setattr(tree_loop, "BODIES", 1)


def test_program_switches_by_itself(monkeypatch):
    s = described()
    straight = fb.compile(s)
    random = np.random.default_rng(2)
    N = 300
    Q, U, t, m = (
        random.normal(size=(N, 3)),
        random.normal(size=(N, 3)),
        random.uniform(size=N),
        random.uniform(1, 2, N),
    )
    calls = {
        "forward_dynamics": (Q, U, t), "kinetic_energy": (Q, U, t), "potential_energy": (Q, t), "mass_matrix": (Q, t),
        "bias": (Q, U, t), "inverse_dynamics": (Q, U, Q - U, t),
    }  # fmt: skip
    expected = {name: getattr(straight, name)(*given, m=m) for name, given in calls.items()}
    poses = straight.poses(Q, t, m=m)
    tau = [0.3, -0.2, 0.5]
    pushed = straight.forward_dynamics(Q, U, t, forces=tau, m=m)
    monkeypatch.setattr(tree_loop, "BODIES", 1)
    program, threaded = fb.compile(s), fb.compile(s, threads=2)
    for name, given in calls.items():
        found = getattr(program, name)(*given, m=m)
        assert found == pytest.approx(expected[name], rel=1e-11, abs=1e-11)
        assert np.array_equal(found, getattr(threaded, name)(*given, m=m))
        assert np.array_equal(found[3], getattr(program, name)(*(x[3] for x in given), m=m[3]))
    loops = program.poses(Q, t, m=m)
    for name, posture in loops.items():
        assert posture.rotation == pytest.approx(poses[name].rotation, abs=1e-13)
        assert posture.position == pytest.approx(poses[name].position, abs=1e-13)
    forced = program.forward_dynamics(Q, U, t, forces=tau, m=m)
    assert forced == pytest.approx(pushed, rel=1e-11, abs=1e-11)
    assert {key for key, (made, _) in program._sets.items() if isinstance(made, tree_loop.LoopedKernel)} == {
        "forward_dynamics", "forced_dynamics", "kinetic_energy", "potential_energy", "poses", "mass_matrix", "bias",
        "inverse_dynamics",
    }  # fmt: skip
    assert program.describe("forward_dynamics").startswith("forward_dynamics: ")
    kernel = program.kernel("forward_dynamics", batch=True)
    c, Y = program.constants("forward_dynamics", m=m[0]), np.concatenate([Q, U], axis=1)
    rows = kernel.batch(t, Y, c)
    assert np.array_equal(rows, kernel.batch(t, Y, np.tile(c, (N, 1))))
    assert np.array_equal(rows[9], kernel(t[9], Y[9], c))
    assert kernel.lanes_address


def test_simulation_switches_by_itself(monkeypatch):
    def run():
        s = random_system(2, bodies=5, joints=("ball", "hinge", "slider"), driven=True)
        return fb.simulate(s, until=0.5, tolerance=1e-10)

    straight = run()
    monkeypatch.setattr(tree_loop, "BODIES", 1)
    loops = run()
    assert "large" in loops.kernels.programs
    assert loops.states[-1] == pytest.approx(straight.states[-1], rel=1e-7, abs=1e-7)
    last = straight.kernels.model.bodies.keys()
    assert set(last) == {f"b{i}" for i in range(5)}


def test_a_chain_of_two_hundred_bodies():
    model = fb.assemble(random_chain(1, 200))
    assert tree_loop.is_large(model)
    q, u = random_state(model, 0)
    u = [x / 10 for x in u]
    found = fb.compile(model).forward_dynamics(q, u)
    s = dynamics.float_state(model, q, u)
    expected = np.array(dynamics.forward_dynamics(model, s))
    assert np.abs(found - expected).max() <= 1e-9 * np.abs(expected).max()
    # Newton-Euler of these accelerations leaves no force
    left = np.array(dynamics.inverse_dynamics(model, s, list(found)))
    scale = np.abs(np.array(dynamics.bias(model, s))).max()
    assert np.abs(left).max() <= 1e-9 * scale


def hanging(n, stiffness=0):
    """A chain of n bodies, with a spring from the ground to its middle."""
    s = fb.System("hanging chain")
    s.gravity = (0, 0, -9.81)
    k = s.parameters(k=stiffness)
    parent = s.ground
    for i in range(n):
        body = s.body(f"b{i}", fb.box(1.0 + i / n, (0.1, 0.2, 0.3)))
        s.hinge(f"h{i}", parent, body, to=(0, 0, 0.3), axis="xy"[i % 2], coordinate=f"q{i}")
        parent = body
    s.spring("spring", s.ground.point(0.1, 0, 0), s.bodies[f"b{n // 2}"].point(0, 0, 0), stiffness=k)
    return s


@pytest.mark.slow
def test_each_use_is_looped_from_a_number_of_bodies_of_its_own(monkeypatch):
    """Where loops are as fast as straight code, which takes long to compile; both agree to round-off."""
    random = np.random.default_rng(4)
    calls = {"forward_dynamics": 2, "poses": 1, "bias": 2, "derivatives": 2}
    found = {}
    for n, loops in ((9, set()), (12, {"derivatives"}), (40, {"derivatives", "forward_dynamics", "bias"})):
        program = fb.compile(hanging(n, 10.0))
        state = (random.uniform(-0.5, 0.5, n), random.uniform(-0.1, 0.1, n))
        for name, inputs in calls.items():
            if n < 40 or name != "derivatives":
                found[n, name] = (state[:inputs], getattr(program, name)(*state[:inputs]), name in loops)
        made = {key: one for key, (one, _) in program._sets.items()}
        assert {key for key, one in made.items() if isinstance(one, tree_loop.LoopedKernel)} == loops & set(
            made
        )
        for name in made:
            assert ("looped over" in program.describe(name)) == (name in loops)
    monkeypatch.setattr(tree_loop, "SOONER", {})
    for (n, name), (state, expected, is_looped) in found.items():
        monkeypatch.setattr(tree_loop, "BODIES", 10**9 if is_looped else 1)
        other = getattr(fb.compile(hanging(n, 10.0)), name)(*state)
        pairs = zip(*(x.values() if name == "poses" else (x,) for x in (other, expected)), strict=True)
        for x, y in pairs:
            for one, two in zip(x, y, strict=True):
                assert np.abs(one - two).max() <= 1e-8 * (1 + np.abs(two).max()), (n, name)


def test_what_straight_parts_of_a_looped_model_do_is_counted():
    """Series ask whether anything in the rates may bend: the length of a spring is a root."""
    from freebody.motion.kernels.kernels import kernels_of
    from freebody.motion.kernels.methods import may_bend

    kernels = kernels_of(fb.assemble(hanging(40)))
    assert isinstance(kernels.motion().compiled, LoopedSet) and kernels.operations["sqrt"] == 1
    assert may_bend(kernels)


def test_a_kernel_keeps_what_it_needs(small):
    """Tables and steps live as long as any kernel that uses them."""
    s = described()
    program = fb.compile(s)
    kernel, c = program.kernel("forward_dynamics"), program.constants("forward_dynamics")
    expected = kernel(0.8, [0.3, -0.4, 0.2, 1.0, 0.5, -0.7], c)
    del program
    link_step.compiled_step.cache_clear()
    gc.collect()
    assert np.array_equal(kernel(0.8, [0.3, -0.4, 0.2, 1.0, 0.5, -0.7], c), expected)


def test_welded_bodies_have_no_state(small):
    s = fb.System("post")
    s.gravity = (0, 0, -10)
    s.weld("weld", s.ground, s.body("post", fb.particle(2)), at=(1, 2, 3))
    program = fb.compile(s)
    assert program.forward_dynamics([], []).shape == (0,)
    assert program.poses([])["post"].position.tolist() == [1, 2, 3]
    assert program.potential_energy([]) == 60
    assert program.derivatives([], []).by_q.shape == (0, 0)
    assert program.mass_matrix([]).shape == (0, 0)
    assert program.forward_dynamics(np.zeros((9, 0)), np.zeros((9, 0))).shape == (9, 0)
    assert fb.simulate(s, 1, method="radau").states.shape[1] == 0


def test_the_power_of_loads_needs_no_accelerations():
    """Of a machine with driven joints, whose forces are not known without them."""
    model = fb.assemble(random_system(0, bodies=7, driven=True))
    looped = LoopedSet(model, "motion")
    q, u = random_state(model, 3)
    found = looped["moving"](0.3, np.array([*q, *u]), looped.constants(np.zeros(0)))
    assert found[-1] == pytest.approx(
        float(load_power(model, dynamics.float_state(model, q, u, 0.3))), rel=1e-12
    )


MODES = {
    "motion": 0, "forced": 1, "inverse": 1, "reactions": 0, "reactions_at": 1, "mass": 0,
}  # fmt: skip


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (1, 2, 3))])
def test_eight_states_at_a_time_are_the_same_bits(mode, seed):
    """Rows of every kernel, of which the last eight are not full, with shared and with own parameters."""
    model = fb.assemble(described() if seed == 3 else random_system(seed, bodies=7, driven=seed % 2 == 0))
    many = 21
    random = np.random.default_rng(seed)
    states = [random_state(model, 100 * seed + k) for k in range(many)]
    Y = np.array([[*q, *u, *random.normal(size=MODES[mode] * model.n_u)] for q, u in states])
    t = random.uniform(size=many)
    P = random.uniform(1, 2, size=(many, len(model.parameters)))
    one = LoopedSet(model, mode)
    for name, kernel in one.kernels.items():
        rows = Y[:, : kernel.state]
        shared = one.of_rows(name, shared=True).batch(t, rows, one.constants(P[0]))
        own = one.of_rows(name, shared=False).batch(t, rows, one.constants(P))
        for k in range(many):
            assert np.array_equal(shared[k], kernel(t[k], rows[k], one.constants(P[0]))), name
            assert np.array_equal(own[k], kernel(t[k], rows[k], one.constants(P[k]))), name


BY = {
    "forward_dynamics": "q u", "forced_dynamics": "q u forces", "inverse_dynamics": "q u udot", "bias": "q u",
    "kinetic_energy": "q u", "potential_energy": "q", "momentum": "q u", "velocities": "q u", "poses": "q",
    "reactions": "q u", "reactions_at": "q u udot", "mass_matrix": "q",
}  # fmt: skip


FAST = ("forward_dynamics", "mass_matrix")


@pytest.mark.parametrize(
    "product", [name if name in FAST else pytest.param(name, marks=pytest.mark.slow) for name in BY]
)
@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_derivatives_loop_over_links(monkeypatch, product, seed):
    """Eight directions at a time through the same loops, against the derivatives of the straight code's trace.

    Along a quaternion, where its length changes, a rotation has no derivative but that of a formula: the columns by q
    are compared along q' = B u.
    """
    model = fb.assemble(described() if seed == 2 else random_system(seed, bodies=5, driven=seed % 2 == 0))
    random = np.random.default_rng(seed)
    q, u = random_state(model, seed)
    given = {"q": q, "u": u, "udot": random.normal(size=model.n_u), "forces": random.normal(size=model.n_u)}
    names = product_named(model, product).inputs
    arguments = [given[name] for name in names]
    M = fb.compile(model).mass_matrix(q)
    B = fb.compile(model).derivative("coordinate_rates", "u")(q, u, 0.4)
    expected = {by: fb.compile(model).derivative(product, by)(*arguments, 0.4) for by in BY[product].split()}
    monkeypatch.setattr(tree_loop, "BODIES", 1)
    program = fb.compile(model)
    for by, E in expected.items():
        found = program.derivative(product, by)(*arguments, 0.4)
        assert isinstance(program._sets[f"{product}_by_{by}"][0], tree_loop.LoopedKernel)
        bound = 1e-14 * len(model.links) * np.linalg.cond(M) ** 2 * max(1, np.abs(E).max(initial=0))
        assert found.shape == E.shape
        difference = (found - E) @ B if by == "q" else found - E
        assert np.abs(difference).max(initial=0) <= bound
        rows = [np.array([x, x]) for x in arguments]
        assert np.array_equal(program.derivative(product, by)(*rows, 0.4), np.array([found, found]))


def test_what_of_derivatives_is_straight_and_what_is_not(small):
    s = described()
    program = fb.compile(s)
    q, u = [0.3, -0.4, 0.2], [1.0, 0.5, -0.7]
    both = program.derivatives(q, u, 0.8)
    assert np.array_equal(both.by_q, program.derivative("forward_dynamics", "q")(q, u, 0.8))
    assert np.array_equal(both.by_u, program.derivative("forward_dynamics", "u")(q, u, 0.8))
    turned = program.derivative("forward_dynamics", "displacement")(q, u, 0.8)
    assert np.array_equal(turned, both.by_q)
    program.derivative("forward_dynamics", "m")(q, u, 0.8)
    program.derivative("mass_matrix", "q")(q, 0.8)
    kinds = {key: isinstance(made, tree_loop.LoopedKernel) for key, (made, _) in program._sets.items()}
    assert kinds == {key: key != "forward_dynamics_by_m" for key in kinds}


def test_stiff_trees_loop_over_links_for_their_matrices(monkeypatch):
    """Radau with the tangent of the loops, and with that of straight code."""

    def run():
        return fb.simulate(described(), until=0.2, initial={"a": 0.3}, method="radau", tolerance=1e-8)

    straight = run()
    monkeypatch.setattr(tree_loop, "BODIES", 1)
    loops = run()
    assert isinstance(loops.kernels.programs["tangent"].compiled, LoopedSet)
    assert loops.kernels.works
    assert loops.states[-1] == pytest.approx(straight.states[-1], rel=1e-6, abs=1e-6)


def test_a_lane_does_not_touch_its_neighbours():
    """NaN, infinite and huge states beside others, and the eight lanes by their address."""
    model = fb.assemble(random_system(4, bodies=9))
    one = LoopedSet(model)
    c = one.constants([])
    Y = np.array([[x for part in random_state(model, k) for x in part] for k in range(16)])
    kernel = one.of_rows("rates", shared=True)
    expected = kernel.batch(0.3, Y, c)
    Y[5], Y[6, 0], Y[9, -1] = np.nan, 1e300, np.inf
    found = kernel.batch(0.3, Y, c)
    kept = [k for k in range(16) if k not in (5, 6, 9)]
    assert np.array_equal(found[kept], expected[kept])
    assert np.isnan(found[5]).all()
    assert np.array_equal(found, one["rates"].batch(0.3, Y, c), equal_nan=True)


def test_the_code_does_not_grow_with_the_model():
    """Compile time as what is compiled: a chain ten times as long has the same code, and longer tables."""
    sizes = []
    for n in (30, 300):
        s = fb.System("chain")
        s.gravity = (0, 0, -9.81)
        parent = s.ground
        for k in range(n):
            body = s.body(f"b{k}", fb.box(1.0 + k / n, (0.1, 0.2, 1)))
            s.hinge(f"h{k}", parent, body, at=(0, 0, -k / n), axis="xy"[k % 2])
            parent = body
        model = fb.assemble(s)
        sizes.append([LoopedSet(model, lanes=lanes).size for lanes in (1, 8)])
    assert sizes[0] == pytest.approx(sizes[1], rel=0.01)


def test_places_are_used_again():
    """What stands where, followed through the loops of random trees: all read what was meant for them."""
    random = np.random.default_rng(0)
    chain = [*range(-1, 99)]
    assert sums(chain, (), 0, 27).end == 27 * 4  # zeros, aside, two of links
    assert accelerations(chain, False, 0)[1] == 6 * 3
    for _ in range(20):
        parents = [int(random.integers(-1, i)) if i else -1 for i in range(40)]
        tips = [{k for k, parent in enumerate(parents) if parent == i} for i in range(40)]
        kept = {int(k) for k in random.integers(0, 40, size=3)}
        found = sums(parents, kept, 5, 27)
        there = {place: set() for place in range(found.cleared, found.aside, 27)}
        for i in range(39, -1, -1):
            assert there[found.of[i]] == tips[i]
            there[found.passed[i]] = {i}
            if found.added[i] >= 0:
                there[found.added[i]] = there[found.added[i]] | {i}
        assert all(there[found.of[i]] == tips[i] for i in kept)
        assert max(found.of) + 27 <= found.end
        places, end = accelerations(parents, False, 5)
        here = {places[-1]: -1}
        for i, parent in enumerate(parents):
            assert here[places[parent]] == parent
            assert places[i] != places[parent]
            here[places[i]] = i
        assert max(places) + 6 == end
        assert len(set(accelerations(parents, True, 5)[0])) == 41
