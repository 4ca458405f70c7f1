"""Laws of contact on random small scenes, from event to event: boxes, disks, wedges, ladders, stacks, tables, balls and
belts, thrown and pushed, with Newton's and Poisson's restitution."""

import numpy as np
import pytest
import sympy

import freebody as fb
from cone_problems import Touching
from contact_machines import momenta
from enumeration import solutions
from freebody.dynamics import float_state
from freebody.dynamics.conditions.contact import touches
from freebody.dynamics.kinematics import point_position
from freebody.motion.start.initial import number

G = 9.81
IN_PLANE = ("box", "disk", "wedge", "stack", "belt", "incline", "ladder", "pair")
IN_SPACE = ("box", "ball", "disk", "three legs", "four legs", "belt", "dropped box", "wedge", "stack")


def laws(rng, bounces, static):
    mu = float(rng.choice([0.0, 0.1, 0.3, 0.6, 1.0]))
    more = mu * float(rng.choice(static))
    e = float(rng.choice(bounces))
    return {
        "friction": mu, "static_friction": more, "restitution": e, "impact": str(rng.choice(["newton", "poisson"])),
    }  # fmt: skip


def moving_belt(s, normal, speed):
    belt = s.body("belt", fb.particle(1))
    s.slider("drive", s.ground, belt, axis="x", coordinate=speed * s.t)
    return belt.plane(normal=normal)


def plane_scene(seed):
    """A scene in the plane, and its start."""
    rng = np.random.default_rng([7, seed])
    kind = IN_PLANE[seed % len(IN_PLANE)]
    how = laws(rng, [0.0, 0.0, 0.3, 0.6, 0.8], [1.0, 1.0, 1.3])
    s = fb.System(f"{kind} {seed}")
    s.gravity = (0, -G, 0)
    m, (w, h) = float(rng.uniform(1, 4)), rng.uniform(0.2, 0.8, size=2).tolist()
    start = {"x'": float(rng.normal()), "phi'": float(3 * rng.normal())}
    floor = s.ground.plane(normal="y")
    body = s.body("body", fb.disk(m, w) if kind == "disk" else fb.box(m, (w, h, 0.3)))
    if kind == "belt":
        floor = moving_belt(s, "y", float(rng.choice([-1, 1]) * rng.uniform(0.3, 2)))
    if kind == "incline":
        a = float(rng.uniform(-0.6, 0.6))
        floor = s.ground.plane(normal=(-np.sin(a), np.cos(a), 0))
    s.planar("plane", s.ground, body, coordinate="x y phi")
    if kind == "disk":
        s.contact("foot", body.circle(w), floor, **how)
        start["y"] = w + float(rng.uniform(0, 0.5))
    else:
        radius = float(np.hypot(w, h)) / 2
        start["phi"] = float(rng.uniform(-3, 3))
        start["y"] = 1.3 * radius + float(rng.choice([0.0, 0.3, 0.8]) * rng.uniform())
        corners = body.corners(size=(w, h))
        if kind == "wedge":
            corners = body.corners((-w / 2, -h / 2, 0), (w / 2, -h / 2, 0), (-w / 2, h / 2, 0))
        s.contact("foot", corners, floor, **how)
        if kind == "ladder":
            s.contact("wall", corners, s.ground.plane(normal="x"), **how)
            start["x"] = radius + float(0.3 * rng.uniform())
    if kind == "stack":
        other = s.body("other", fb.box(m / 2, (0.8 * w, h / 2, 0.3)))
        s.planar("above", s.ground, other, coordinate="x_2 y_2 phi_2")
        top = body.segment((-w / 2, h / 2, 0), (w / 2, h / 2, 0), normal="y")
        s.contact("up", other.corners((-0.4 * w, -h / 4, 0), (0.4 * w, -h / 4, 0)), top, **how)
        start = {
            "y": h / 2, "y_2": 1.25 * h + float(rng.choice([0, 0.1])), "x_2": float(rng.uniform(-0.3, 0.3) * w),
            "x_2'": float(rng.normal() * rng.choice([0, 1])),
        }  # fmt: skip
    if kind == "pair":
        r = float(rng.uniform(0.1, 0.3))
        disk = s.body("other", fb.disk(m, r))
        s.planar("beside", s.ground, disk, coordinate="x_2 y_2 phi_2")
        s.contact("roll", disk.circle(r), floor, **how)
        side = body.segment((-w / 2, -h / 2, 0), (-w / 2, h / 2, 0), normal=(-1, 0, 0))
        s.contact("hit", disk.circle(r), side, **how)
        start = {
            "y": h / 2, "x_2": -w / 2 - r - 0.4, "y_2": r, "x_2'": float(rng.uniform(0.5, 2)),
            "phi_2'": float(rng.normal()),
        }  # fmt: skip
    if rng.random() < 0.5:
        F = float(rng.uniform(0, 0.8) * m * G) * sympy.cos(int(rng.choice([0, 2, 5])) * s.t)
        s.force("push", body.point(0, float(rng.uniform(-h / 2, h / 2)), 0), (F, 0, 0))
    return s, start


def space_scene(seed):
    """A scene in space, and its start."""
    rng = np.random.default_rng([11, seed])
    kind = IN_SPACE[seed % len(IN_SPACE)]
    how = laws(rng, [0.0, 0.0, 0.3, 0.6], [1.0])
    s = fb.System(f"{kind} {seed}")
    s.gravity = (0, 0, -G)
    m, (a, b, c) = float(rng.uniform(1, 4)), rng.uniform(0.2, 0.6, size=3).tolist()
    start = {f"f_v{x}": float(rng.normal()) for x in "xy"} | {
        f"f_w{x}": float(2 * rng.normal()) for x in "xyz"
    }
    solid = {"ball": fb.sphere(m, a), "disk": fb.disk(m, a)}.get(kind, fb.box(m, (a, b, c)))
    body = s.body("body", solid)
    floor = moving_belt(s, "z", float(rng.uniform(0.3, 2))) if kind == "belt" else s.ground.plane(normal="z")
    s.free("f", s.ground, body)
    down = [(x * a / 2, y * b / 2, -c / 2) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    feet = {
        "ball": lambda: body.sphere(a),
        "disk": lambda: body.circle(a, axis="z"),
        "box": lambda: body.corners(size=(a, b, c)),
        "dropped box": lambda: body.corners(size=(a, b, c)),
        "three legs": lambda: body.corners(
            *[(a * np.cos(x) / 2, a * np.sin(x) / 2, -c / 2) for x in (0.3, 2.4, 4.6)]
        ),
        "wedge": lambda: body.corners(*down, (0, -b / 2, c / 2), (0, b / 2, c / 2)),
    }.get(kind, lambda: body.corners(*down))()
    s.contact("foot", feet, floor, **how)
    start["f_z"] = a + 0.3
    if kind == "disk":
        tilt = float(rng.uniform(0.3, 1.3))
        start["f"] = (float(np.cos(tilt / 2)), float(np.sin(tilt / 2)), 0, 0)
    elif kind in ("box", "wedge"):
        turn = rng.normal(size=4)
        start |= {"f_z": 0.7, "f": tuple((turn / np.linalg.norm(turn)).tolist())}
    elif kind == "dropped box":
        start["f_z"] = 0.6
    elif kind != "ball" and rng.random() < 0.5:  # it stands, and slides and turns
        start |= {"f_z": c / 2, "f_wx": 0.0, "f_wy": 0.0}
    if kind == "stack":
        ball = s.body("other", fb.sphere(m / 2, 0.1))
        s.free("g", s.ground, ball)
        s.contact("up", ball.sphere(0.1), body.plane(at=(0, 0, c / 2), normal="z"), **how)
        start = {"f_z": c / 2, "g_z": c + 0.1, "g_vx": float(0.3 * rng.normal()), "g_wy": float(rng.normal())}
    if rng.random() < 0.5:
        F = float(rng.uniform(0, 0.8) * m * G) * sympy.cos(int(rng.choice([0, 2, 5])) * s.t)
        angle = float(rng.uniform(0, 6))
        at = body.point(0, 0, float(rng.uniform(-c / 2, c / 2)))
        s.force("push", at, (F * np.cos(angle), F * np.sin(angle), 0), frame=s.ground)
    return s, start


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
