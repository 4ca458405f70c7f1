"""Laws of contact on random small scenes, from event to event: boxes, disks, wedges, ladders, stacks, tables, balls and
belts, thrown and pushed, with Newton's and Poisson's restitution."""

import numpy as np
import pytest

import freebody as fb
from cone_problems import Touching
from contact_machines import momenta
from contact_scenes import G, plane_scene, space_scene
from enumeration import solutions
from freebody.dynamics import float_state
from freebody.dynamics.conditions.contact import touches
from freebody.dynamics.kinematics import point_position
from freebody.motion.start.initial import number


def pressed(s, motion, k):
    """Momentum and moment of momentum of every body at an output time, and the force and moment on it."""
    model, n = motion.kernels.model, motion.kernels.model.n_q
    y = motion.states[k]
    state = float_state(
        model, y[:n].tolist(), y[n : n + model.n_u].tolist(), float(motion.t[k]), motion.values
    )
    bodies = {name: momenta(model, state, s.bodies[name]) for name in model.bodies if name != "belt"}
    weight = np.array([float(g) for g in model.gravity])
    loads = {name: [float(model.bodies[name].mass) * weight, np.zeros(3)] for name in bodies}

    def press(body, place, force):
        if body.name in loads:
            loads[body.name][0] = loads[body.name][0] + force
            loads[body.name][1] = loads[body.name][1] + np.cross(place - bodies[body.name][2], force)

    for contact, it in zip(model.contacts, touches(model, state), strict=True):
        N, *T = motion.contacts[contact.name].least[k]
        force = N * np.array(it.normal, dtype=float)
        force = force + sum(x * np.array(d, dtype=float) for x, d in zip(T, it.tangents, strict=True))
        press(contact.feature.body, np.array(it.on_feature, dtype=float), force)
        press(contact.surface.body, np.array(it.on_surface, dtype=float), -force)
    for load in s.loads.values():
        force = np.array([float(state(x)) for x in load.components])
        if load.frame is not None and load.frame.name in model.bodies:
            force = np.asarray(motion.poses[load.frame.name].rotation)[k] @ force
        place = np.array([float(x) for x in point_position(model, state, load.point)])
        press(load.point.body, place, force)
    return bodies, loads


def check(s, start, until, seed):
    """All laws on one motion."""
    motion = fb.simulate(s, until, initial=start, indeterminate="compliance", samples=1601)
    driven = "belt" in s.bodies
    size = G * sum(float(x.mass) for x in motion.kernels.model.bodies.values())
    energy = motion.energy
    scale = float(np.abs(energy.total).max())
    # hundreds of steps of 1e-9 each; where a slip passes close to zero its direction turns within one
    assert energy.relative_residual < 3e-7
    if not driven:
        assert np.diff(energy.impulses).max(initial=0) <= 1e-12 * scale
        assert np.diff(energy.friction).max(initial=0) <= 1e-9 * scale
    for contact in motion.kernels.model.contacts:
        one = motion.contacts[contact.name]
        N, T = one.least[:, 0], one.least[:, 1:]
        mu = number(motion.kernels.model, motion.values, contact.static_friction, "a coefficient of friction")
        open_ = one.mode == "open"
        assert N.min() >= -1e-8 * size
        # a slip that begins slowly has the direction of its first 1e-9 m/s
        assert (np.linalg.norm(T, axis=1) - mu * N).max() <= 1e-6 * size
        assert (N[open_] == 0).all()
        assert np.abs(one.gap[~open_]).max(initial=0) < 1e-10
        assert np.einsum("ni,ni->n", T, one.slip.reshape(T.shape)).max() <= 1e-7 * size
        if not contact.name.startswith(("up", "hit")):  # what came around the end of a side is behind it
            assert one.gap.min() > -1e-10
    # momentum over two output times with no event between, by Simpson's rule
    events, t = np.array([event.time for event in motion.events]), motion.t
    calm = [i for i in range(len(t) - 2) if not ((events >= t[i]) & (events <= t[i + 2])).any()]
    for i in np.random.default_rng(seed).permutation(calm)[:8]:
        (p, first), (_, middle), (after, last) = (pressed(s, motion, k) for k in (i, i + 1, i + 2))
        for name in p:
            for j in (0, 1):
                mean = (first[name][j] + 4 * middle[name][j] + last[name][j]) / 6
                change = (after[name][j] - p[name][j]) / (t[i + 2] - t[i])
                np.testing.assert_allclose(change, mean, atol=1e-4 * size)


@pytest.mark.parametrize("seed", [1, 19, 4, 6, 7, 10, 13, 24])
def test_scenes_in_the_plane(seed):
    check(*plane_scene(seed), 2.5, seed)


@pytest.mark.parametrize("seed", [1, 2, 4, 5, 14, 21])
def test_scenes_in_space(seed):
    check(*space_scene(seed), 2.0, seed)


def test_a_rest_at_its_limit_ends_with_its_forces():
    """Three feet stop at |T| = μ N under a push that grows: 0.3 ms later it is 1e-3 N more than they can hold."""
    s, start = space_scene(30)
    rng = np.random.default_rng(1)
    start = {
        name: x * (1 + 2e-15 * rng.integers(-4, 5)) if isinstance(x, float) else x
        for name, x in start.items()
    }
    check(s, start, 2.0, 30)


def test_disks_that_meet_and_would_be_apart_again_within_a_step():
    """The third disk bounces off the second, and would fall through it between two points of a step of 1.6 s."""
    s = fb.System("corner")
    s.gravity = (0, -G, 0)
    walls = [("f", "y", 0), ("w", "x", 0), ("v", "-x", 1.46)]
    sides = [(name, s.ground.plane(at=(at, 0, 0), normal=normal)) for name, normal, at in walls]
    law = {"friction": 0.4, "restitution": 0.25, "impact": "poisson"}
    disks = []
    for k, (m, R) in enumerate(
        zip((1.196428, 0.768612, 1.125997), (0.188276, 0.150541, 0.19137), strict=True)
    ):
        body = s.body(f"d{k}", fb.disk(m, R))
        s.planar(f"p{k}", s.ground, body, coordinate=f"x{k} y{k} w{k}")
        for name, side in sides:
            s.contact(f"{name}{k}", body.circle(R), side, **law)
        for j, other in enumerate(disks):
            s.contact(f"c{j}{k}", body.circle(R), other, **law)
        disks.append(body.circle(R))
    start = {
        "x0": 0.3,
        "y0": 0.637636,
        "x0'": -0.206663,
        "w0'": 4.065329,
        "x1": 0.72,
        "y1": 0.605033,
        "x1'": 0.782242,
    }
    start |= {"w1'": -11.82576, "x2": 1.14, "y2": 0.80969, "x2'": 1.319755, "w2'": -11.496556}
    motion = fb.simulate(s, 2, initial=start)
    assert motion.status == "finished" and motion.energy.relative_residual < 1e-8
    assert min(one.gap.min() for one in motion.contacts.values()) > -1e-12


def motions(problem):
    """All sets of modes that satisfy the laws of a contact problem of the loop, by trying each."""
    contacts = []
    for i in range(problem.contacts):
        n = int(problem.tangents[i])
        way = np.array(problem.way[2 * i : 2 * i + n]) if problem.slides[i] else None
        coefficients = float(problem.friction[i]), float(problem.static[i])
        contacts.append(Touching(f"c{i}", int(problem.at[i]), n, *coefficients, way))
    m = problem.rows
    return solutions(np.array(problem.A[: m * m]).reshape(m, m), np.array(problem.given[:m]), contacts)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(60))
def test_all_scenes_in_the_plane(seed):
    try:
        check(*plane_scene(seed), 2.5, seed)
    except fb.errors.SimulationError as error:
        # a box struck at rest may tip about one foot or slide on both (3); three contacts that slide jam (11)
        several, none = (x in str(error) for x in ("different motions are consistent", "no set of modes is"))
        assert (several or none) and seed in (3, 11), error
        found = motions(error.trajectory.course.history.work.memory.problem)
        assert len(found) > 1 if several else not found


REFUSED = ("shared in proportion to N, has reached", "no set of modes is consistent", "would create energy")
"""Friction that nothing determines at its limit; and Newton's law where the slip reverses (Kane)."""


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(40))
def test_all_scenes_in_space(seed):
    try:
        check(*space_scene(seed), 2.0, seed)
    except fb.errors.SimulationError as error:
        assert any(reason in str(error) for reason in REFUSED), error
