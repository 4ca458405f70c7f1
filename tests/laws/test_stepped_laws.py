"""Laws of time stepping on random machines with loops, drives and contacts: in every step the momentum of each body is
in balance with its reactions, contact forces and weight, conditions hold, and the ledger closes with the step."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import freebody as fb
from contact_machines import momenta
from freebody.dynamics import coordinate_rates, float_state
from freebody.dynamics.conditions.contact import contact_rows, touches
from freebody.dynamics.kinematics import point_position, rotation
from freebody.model import assemble
from freebody.testing import random_state, random_system

JOINTS = ("hinge", "slider", "cylindrical", "universal", "ball", "planar", "free", "screw")


def machine(seed, *, loop, driven=False):
    """A random tree with a ball joint that closes a loop, a foot that stands on a plane, and two spheres that touch."""
    s = random_system(seed, 5, JOINTS, loads=False, driven=driven)
    rng = np.random.default_rng(1000 + seed)
    bare = assemble(s)
    q, u = random_state(bare, seed)
    state = float_state(bare, q, u, 0.0)

    def seen_from(body, place):
        """Components of a place in the axes of a body."""
        R = np.array(rotation(bare, state, bare.bodies[body.name].link), dtype=float)
        start = np.array([float(x) for x in point_position(bare, state, s.bodies[body.name].origin)])
        return tuple((R.T @ (place - start)).tolist())

    named = [s.bodies[name] for name in bare.bodies if name != "ground"]
    where = [np.array([float(x) for x in point_position(bare, state, b.origin)]) for b in named]
    i, j = rng.choice(len(named), size=2, replace=False)
    if loop:
        meet = (where[i] + where[j]) / 2 + rng.normal(size=3)
        s.ball("loop", named[i], named[j], at=seen_from(named[i], meet), to=seen_from(named[j], meet))
    k, m = rng.choice(len(named), size=2, replace=False)
    n = rng.normal(size=3)
    n /= np.linalg.norm(n)
    foot = where[k] - 0.3 * n
    s.contact("foot", named[k].sphere(0.3), s.ground.plane(at=tuple(foot), normal=tuple(n)), friction=0.1)
    apart = float(np.linalg.norm(where[k] - where[m]))
    s.contact("pair", named[k].sphere(0.4 * apart), named[m].sphere(0.6 * apart), friction=0.2)
    whole = assemble(s)  # towards the plane
    if float(contact_rows(whole, float_state(whole, q, u, 0.0)).rate[0]) > 0:
        u = [-x for x in u]
    start = dict(zip(bare.coordinate_names, q, strict=True)) | dict(zip(bare.speed_names, u, strict=True))
    return s, start


def in_axes_of(model, q, state):
    """The speeds of a state after a turn to the orientations at q, in which mass centres keep their velocities."""
    u = state[model.n_q :].copy()
    for link in model.links:
        if link.flies:
            i, c = link.quaternion, np.array([float(x) for x in link.center])
            there, here = (Rotation.from_quat(np.roll(place[i : i + 4], -1)) for place in (q, state))
            more = np.cross(u[link.u : link.u + 3], c)
            u[link.u + 3 : link.u + 6] = (
                there.inv().apply(here.apply(u[link.u + 3 : link.u + 6] + more)) - more
            )
    return u


def balance(s, motion, step):
    """What the balance of every body lacks in one step, in parts of the greatest force and moment there."""
    model, h = motion.kernels.model, motion.step
    y, after = (
        motion.path.states[step],
        motion.path.states[step + 1] - motion.course.impulses.corrections[step],
    )
    n, t = model.n_q, motion.path.times[step]

    def at(q, u, time):
        return float_state(model, list(map(float, q)), list(map(float, u)), float(time))

    first = at(y[:n], y[n:], t)
    q = y[:n] + h / 2 * np.array([float(x) for x in coordinate_rates(model, first)])
    for i in model.quaternions:
        q[i : i + 4] /= np.linalg.norm(q[i : i + 4])
    begin, end = (in_axes_of(model, q, state) for state in (y, after))
    now, then = at(q, begin, t + h / 2), at(q, end, t + h / 2)
    mean = (begin + end) / 2
    rate = np.array([float(x) for x in coordinate_rates(model, at(q, mean, t + h / 2))])
    e = 1e-6
    forth, back = (
        at(q + k * rate, in_axes_of(model, q + k * rate, np.concatenate([q, mean])), t + h / 2 + k)
        for k in (e, -e)
    )
    forces = {name: np.zeros(3) for name in model.bodies}
    moments = {name: np.zeros(3) for name in model.bodies}
    centers = {name: momenta(model, now, s.bodies[name])[2] for name in model.bodies}

    def press(body, place, force, moment):
        if body.name in forces:
            forces[body.name] += force
            moments[body.name] += moment + np.cross(place - centers[body.name], force)

    for name, reaction in motion.reactions.items():
        joint = s.joints[name]
        place = np.array([float(x) for x in point_position(model, now, joint.child.point(*joint.to))])
        press(joint.child, place, reaction.force[step + 1], reaction.moment[step + 1])
        press(joint.parent, place, -reaction.force[step + 1], -reaction.moment[step + 1])
    for contact, it in zip(model.contacts, touches(model, now), strict=True):
        found = motion.contacts[contact.name]
        T = np.atleast_1d(found.tangential[step + 1])
        force = found.normal[step + 1] * np.array(it.normal, dtype=float)
        force = force + sum(x * np.array(d, dtype=float) for x, d in zip(T, it.tangents, strict=True))
        press(contact.feature.body, np.array(it.on_feature, dtype=float), force, np.zeros(3))
        press(contact.surface.body, np.array(it.on_surface, dtype=float), -force, np.zeros(3))
    worst = 0.0
    size = max(1.0, *(float(np.abs(r.force[step + 1]).max()) for r in motion.reactions.values()))
    for name in model.bodies:
        body = s.bodies[name]
        P, P1, P_, P0 = (momenta(model, x, body) for x in (now, then, forth, back))
        weight = float(model.bodies[name].mass) * np.array([float(g) for g in model.gravity])
        lacks = (P1[0] - P[0]) / h + (P_[0] - P0[0]) / (2 * e) - forces[name] - weight
        turns = (P1[1] - P[1]) / h + (P_[1] - P0[1]) / (2 * e) - moments[name]
        worst = max(worst, float(np.abs(lacks).max()), float(np.abs(turns).max()) / 3)
    return worst / size


# with and without a loop (even or not), with and without drives (from 3 on)
@pytest.mark.parametrize(
    "seed", [0, 1, 3, 4, *(pytest.param(k, marks=pytest.mark.slow) for k in (2, 5, 7, 8, 9))]
)
def test_every_body_is_in_balance_in_every_step(seed):
    loop = seed % 2 == 0
    s, start = machine(seed, loop=loop, driven=seed >= 3)
    h, count = 1e-3, 30
    motion = fb.simulate(
        s,
        h * count,
        initial=start,
        project=loop,
        method="timestepping",
        step=h,
        times=h * np.arange(count + 1),
    )
    assert motion.residual <= 1e-12
    assert any((one.mode != "open").any() for one in motion.contacts.values())
    # differences over 1e-6 leave 1e-9 of the velocities
    assert max(balance(s, motion, k) for k in range(count)) < 1e-6


def test_quaternions_stay_of_length_one_whatever_the_order_of_their_joints():
    s, start = machine(4, loop=False)
    motion = fb.simulate(s, 0.03, initial=start, method="timestepping", step=1e-3)
    places = motion.kernels.model.quaternions
    assert list(places) != sorted(places)
    for i in places:
        assert np.abs(np.linalg.norm(motion.path.states[:, i : i + 4], axis=1) - 1).max() < 1e-15


@pytest.mark.parametrize("seed", [1, 4, 6])
def test_energy_and_conditions_of_a_run(seed):
    loop = seed % 2 == 0
    s, start = machine(seed, loop=loop, driven=True)
    left = []
    for h in (2e-3, 1e-3, 5e-4):
        motion = fb.simulate(
            s, 0.2, initial=start, project=loop, method="timestepping", step=h, samples=round(0.2 / h) + 1
        )
        assert motion.depth <= 1e-10
        for name, contact in motion.contacts.items():
            assert contact.normal.min() >= 0
            mu = {"foot": 0.1, "pair": 0.2}[name]
            T = np.linalg.norm(contact.tangential, axis=1)
            assert (mu * contact.normal * (1 + 1e-12) >= T).all()
            stuck = contact.mode == "stick"
            assert (contact.mode[contact.normal == 0] == "open").all() and (
                contact.margin[stuck] >= -1e-9
            ).all()
        if loop and h == 5e-4:
            a, b = (motion.poses[body.name] for body in (s.joints["loop"].parent, s.joints["loop"].child))
            ends = [
                p.position + p.rotation @ np.array([float(x) for x in place])
                for p, place in ((a, s.joints["loop"].at), (b, s.joints["loop"].to))
            ]
            assert np.abs(ends[0] - ends[1]).max() < 1e-9
        left.append(abs(motion.energy.residual[-1]) / motion.energy.kinetic.max())
    # of first order, also where drives and constraints work
    assert left[2] < 0.02 and left[2] < 0.45 * left[0] + 1e-9


def tumbling(seed, gravity=(0, 0, 0)):
    """A body of random inertia far above a plane, a random start; odd seeds: a joint beside its mass centre."""
    rng = np.random.default_rng(seed)
    s = fb.System("tumbling")
    s.gravity = gravity
    a, b, c = rng.uniform(0.05, 1, 3)
    body = s.body(
        "body",
        fb.box(rng.uniform(0.1, 10), (a, b, c)).rotated(Rotation.random(random_state=seed).as_matrix()),
    )
    s.free("f", s.ground, body, to=tuple(seed % 2 * rng.normal(size=3)))
    s.contact("floor", body.point(0, 0, 0), s.ground.plane(at=(0, 0, -1e6), normal="z"))
    start = {f"f_v{x}": float(v) for x, v in zip("xyz", rng.normal(size=3), strict=True)}
    spin = rng.normal(size=3)
    return s, start, spin / np.linalg.norm(spin)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("spin", [1.0, 250.0, 2500.0])
def test_a_free_body_keeps_its_energy_and_its_momenta(seed, spin):
    s, start, axis = tumbling(seed)
    start |= {f"f_w{x}": spin * float(w) for x, w in zip("xyz", axis, strict=True)}
    motion = fb.simulate(s, 10, initial=start, method="timestepping", step=1e-3, samples=11)
    model, n = motion.kernels.model, motion.kernels.model.n_q
    found = []
    for t in motion.t:
        y = motion.path.states[round(t / 1e-3)]
        state = float_state(model, y[:n].tolist(), y[n:].tolist(), float(t))
        P, H, _ = momenta(model, state, s.bodies["body"])
        found.append([*P, *H])
    found = np.array(found)
    # 10,000 steps, each with a round-off of some units of 1e-16 in the energy norm of the whole motion
    T, m = motion.energy.kinetic, float(model.bodies["body"].mass)
    assert np.abs(T / T[0] - 1).max() < 1e-10
    assert np.abs(found[:, :3] - found[0, :3]).max() < 1e-10 * np.sqrt(2 * T[0] * m)
    assert np.abs(found[:, 3:] - found[0, 3:]).max() < 1e-10 * np.linalg.norm(found[0, 3:])
    assert not motion.warnings


@pytest.mark.parametrize("seed", range(3))
def test_of_second_order_in_flight(seed):
    s, start, axis = tumbling(seed, gravity=(0, 0, -9.81))
    start |= {f"f_w{x}": 10 * float(w) for x, w in zip("xyz", axis, strict=True)}
    exact = fb.simulate(s, 1, initial=start, tolerance=1e-12).at(1)
    errors = []
    for h in (4e-3, 2e-3, 1e-3):
        y = fb.simulate(s, 1, initial=start, method="timestepping", step=h).path.states[-1]
        errors.append(np.abs(y - np.concatenate([exact.q, exact.u])).max())
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert (abs(orders - 2) < 0.1).all(), (errors, orders)


def ball_over_floor(mass, e=0.0):
    s = fb.System("ball")
    s.gravity = (0, 0, -9.81)
    ball = s.body("ball", fb.sphere(mass, 0.1))
    s.free("f", s.ground, ball)
    s.contact("floor", ball.sphere(0.1), s.ground.plane(normal="z"), restitution=e)
    return s


def test_what_lifts_bodies_out_of_each_other_is_a_named_work(tmp_path):
    """A ball lands between two steps. The correction lifts it by m g Δz; as it flies, it takes that from the speed."""
    s = ball_over_floor(2)
    times = np.linspace(0, 0.5, 51)  # the ends of the steps
    motion = fb.simulate(s, 0.5, initial={"f_z": 0.5}, method="timestepping", step=1e-2, times=times)
    energy, changes = motion.energy, motion.course.impulses.corrections
    n_q = motion.kernels.model.n_q
    lifted, slowed = changes[:, 2], changes[:, n_q + list(motion.kernels.model.speed_names).index("f_vz")]
    landing, stopping = np.flatnonzero(lifted)
    assert 0 < lifted.sum() < 2 * 1e-2 * np.sqrt(2 * 9.81 * 0.4)  # v h for each of two steps
    assert slowed[landing] > 0 and slowed[stopping] == 0
    work = np.diff(energy.correction)
    assert work[landing] == pytest.approx(0, abs=1e-14)
    assert work[stopping] == pytest.approx(2 * 9.81 * lifted[stopping], rel=1e-12)
    np.testing.assert_allclose(energy.residual, 0, atol=1e-13)
    motion.save(tmp_path / "ball.nc")
    loaded = fb.Trajectory.load(tmp_path / "ball.nc")
    np.testing.assert_array_equal(loaded.energy.correction, energy.correction)
    smooth = fb.simulate(s, 0.5, initial={"f_z": 0.5})
    assert smooth.energy.correction is None


@pytest.mark.parametrize("e, until", [(0.0, 1), (0.5, 2), (0.8, 4), (0.95, 12), (1.0, 5)])
@pytest.mark.parametrize("h, mass", [(1e-3, 2.0), (7e-3, 0.01)])
def test_a_ball_bounces_without_a_gain_until_it_rests(e, until, h, mass):
    """No step makes energy, as where it lands between two middles and is lifted; the bounces end, or never lose any."""
    count = round(until / h)
    motion = fb.simulate(
        ball_over_floor(mass, e), count * h, initial={"f_z": 0.5}, method="timestepping", step=h,
        times=np.linspace(0, count * h, count + 1),
    )  # fmt: skip
    total = motion.energy.kinetic + motion.energy.potential
    assert np.diff(total).max() <= 1e-14 * total[0] and not motion.warnings
    if e == 1:
        assert np.ptp(total) <= 1e-12 * total[0]
    else:
        assert abs(motion["f_vz"][-1]) <= 1e-13 and abs(motion.contacts["floor"].gap[-1]) <= 1e-10


@pytest.mark.parametrize("e", [0.0, 0.5, 0.95, 1.0])
@pytest.mark.parametrize("seed, h", [(0, 1e-3), (1, 4e-3)])
def test_balls_that_bounce_on_each_other_gain_nothing(seed, h, e):
    rng = np.random.default_rng(seed)
    s, start = fb.System("balls"), {}
    s.gravity = (0, 0, -9.81)
    shapes, masses = [], 10 ** rng.uniform(-1, 1, size=4)
    for i, m in enumerate(masses):
        ball = s.body(f"b{i}", fb.sphere(float(m), 0.1))
        s.free(f"f{i}", s.ground, ball)
        shapes.append(ball.sphere(0.1))
        x, y = rng.normal(size=2) * 0.02
        start |= {f"f{i}_x": float(x), f"f{i}_y": float(y), f"f{i}_z": 0.15 + 0.25 * i}
    s.contacts("all", [*shapes, s.ground.plane(normal="z")], restitution=e, friction=0)
    count = round(2 / h)
    motion = fb.simulate(
        s, 2, initial=start, method="timestepping", step=h, times=np.linspace(0, 2, count + 1)
    )
    total = motion.energy.kinetic + motion.energy.potential
    # an approach up to g h is left as it is: such a contact is at most v h deep, and lifts by no more than m (g h)²
    left = float(masses.sum()) * (9.81 * h) ** 2 if e < 0.9 else 0.0
    assert np.diff(total).max() <= left + 1e-13 * np.ptp(motion.energy.potential)
    if e == 1:
        assert np.ptp(total) <= 1e-12 * total[0]
