"""Contacts that share no moving body decide apart: a machine of several islands moves as each of them alone."""

import numpy as np
import pytest

import freebody as fb

G = 9.81
KINDS = ("box", "thrown", "ball", "row", "legs", "pair")


def add_island(s, name, place, seed):
    """Add bodies and contacts with names of their own, at a place along x; return their start."""
    rng = np.random.default_rng(seed)
    kind, floor = KINDS[int(rng.integers(len(KINDS)))], s.ground.plane(normal="z")
    how = {"friction": float(rng.choice([0.1, 0.4, 0.8])), "restitution": float(rng.choice([0.0, 0.5]))}
    m, (a, b, c) = float(rng.uniform(0.5, 3)), rng.uniform(0.1, 0.3, size=3).tolist()
    if kind in ("box", "thrown"):  # it stands on four corners, whose forces are open; or falls
        body = s.body(name, fb.box(m, (a, b, c)))
        s.free(f"{name}_f", s.ground, body)
        s.contact(f"{name}_c", body.corners(size=(a, b, c)), floor, **how)
        start = {
            "x": place,
            "z": c / 2,
            "vx": float(rng.normal()),
            "vy": float(rng.choice([0, 1]) * rng.normal()),
        }
        if kind == "thrown":
            turn = rng.normal(size=4)
            start |= {"z": 0.2, "vz": -2.0, "wx": float(2 * rng.normal())}
            start |= {f"e{k}": float(x) for k, x in enumerate(turn / np.linalg.norm(turn))}
        if rng.random() < 0.5:
            s.force(
                f"{name}_push",
                body.point(0, 0, 0),
                (0.5 * m * G * float(rng.uniform()), 0, 0),
                frame=s.ground,
            )
        return {f"{name}_f_{x}": value for x, value in start.items()}
    if kind == "ball":
        body = s.body(name, fb.sphere(m, a))
        s.free(f"{name}_f", s.ground, body)
        s.contact(f"{name}_c", body.sphere(a), floor, rolling=0.002, spinning=0.001, **how)
        start = {
            "x": place,
            "z": a,
            "vx": float(rng.normal()),
            "wy": float(rng.normal()),
            "wz": float(rng.normal()),
        }
        return {f"{name}_f_{x}": value for x, value in start.items()}
    if kind == "legs":  # a tree: two links that hang, of which the lower one strikes
        upper, lower = (
            s.body(f"{name}_u", fb.box(m, (a, 0.02, 0.02))),
            s.body(f"{name}_l", fb.box(m, (b, 0.02, 0.02))),
        )
        height = (a + b) * float(np.sin(0.3)) + 0.02
        s.hinge(f"{name}_p", s.ground, upper, at=(place, 0, height), to=(-a / 2, 0, 0), axis="y")
        s.hinge(f"{name}_q", upper, lower, at=(a / 2, 0, 0), to=(-b / 2, 0, 0), axis="z")
        s.contact(f"{name}_c", lower.corners((b / 2, -0.01, 0), (b / 2, 0.01, 0)), floor, **how)
        return {f"{name}_p": 0.3, f"{name}_q": 0.2, f"{name}_p'": 2.0}
    result = {}
    balls = [s.body(f"{name}_{k}", fb.sphere(m, a)) for k in range(2)]
    for k, body in enumerate(balls):
        s.free(f"{name}_f{k}", s.ground, body)
        s.contact(f"{name}_c{k}", body.sphere(a), floor, **how)
        result |= {
            f"{name}_f{k}_x": place + 2 * k * a,
            f"{name}_f{k}_z": a,
            f"{name}_f{k}_vy": 0.3 - 0.1 * k,
        }  # or else they roll on without a force between them
    if kind == "row":  # one strikes the other
        s.contact(f"{name}_h", balls[0].sphere(a), balls[1].sphere(a), **how)
        return result | {f"{name}_f0_vx": 1.0}
    s.rope(
        [balls[0].origin, balls[1].origin], 2 * a, name=f"{name}_d", unilateral=False
    )  # a condition of the machine joins them
    return result


def moved(islands):
    """Return the motion of a machine of these islands, each of a name, a place and a seed."""
    s, start = fb.System("islands"), {}
    s.gravity = (0, 0, -G)
    for one in islands:
        start |= add_island(s, *one)
    return fb.simulate(s, 0.1, initial=start, samples=101, tolerance=1e-11)


def check(seed):
    """Compare what a machine does with what its islands do; return the number of events of all."""
    rng = np.random.default_rng([3, seed])
    islands = [(f"i{k}", 2.0 * k, [seed, int(rng.integers(1000)), k]) for k in range(int(rng.integers(2, 5)))]
    whole, times = moved(islands), []
    for one in islands:
        alone = moved([one])
        times += [event.time for event in alone.events]
        for name in alone.kernels.model.state_names:
            assert np.abs(whole[name] - alone[name]).max() < 1e-7, (seed, one, name)
        for name, contact in alone.contacts.items():
            other = whole.contacts[name]
            assert (np.array(contact.mode) != np.array(other.mode)).sum() <= 2, (seed, one, name)
            same = np.array(contact.mode) == np.array(other.mode)
            size = 1 + np.abs(contact.least).max()
            assert np.abs(contact.least - other.least)[same].max() < 1e-5 * size, (seed, one, name)
    found = np.array([event.time for event in whole.events])
    # those of one moment are one event; series of bounces end at heights relative to the greatest coordinate
    for one, others in ((found, times), (times, found)):
        assert all(np.abs(np.array(others) - t).min() < 1e-6 for t in one), seed
    return len(times)


def test_islands_decide_as_machines_of_their_own():
    assert sum(check(seed) for seed in range(3)) > 0


@pytest.mark.slow
def test_many_islands_decide_as_machines_of_their_own():
    assert sum(check(seed) for seed in range(3, 30)) > 0


def test_friction_is_shared_by_loads_where_another_island_slips():
    """A box stands on four corners beside one that slides. A push k t, above its mass centre, loads corners unequally.

    T/N = k t/(m g) at each of them, so all reach μ at t_0 = μ m g/k, and x = k (t - t_0)³/(6 m) from there.
    """
    s, (m, mu, k) = fb.System("boxes"), (2.0, 0.4, 20.0)
    s.gravity = (0, 0, -G)
    s.parameters(k=k)
    start = {"f1_vx": 5.0}
    for i in range(2):
        box = s.body(f"b{i}", fb.box(m, (0.4, 0.3, 0.2)))
        s.free(f"f{i}", s.ground, box)
        s.contact(f"c{i}", box.corners(size=(0.4, 0.3, 0.2)), s.ground.plane(normal="z"), friction=mu)
        start |= {f"f{i}_z": 0.1, f"f{i}_y": float(i)}
        if i == 0:
            s.force("push", box.point(0, 0, 0.05), ("k*t", 0, 0), frame=s.ground)
    start_of_slip = mu * m * G / k
    motion = fb.simulate(s, 0.6, initial=start, samples=61, sensitivities=["k"])
    t, points = motion.t, [c for name, c in motion.contacts.items() if name.startswith("c0")]
    corners = [c for c in points if c.gap[0] == 0]
    rests = (t > 0) & (t < start_of_slip)
    forces = np.array([c.least[rests] for c in corners])
    friction = np.linalg.norm(forces[..., 1:], axis=2)
    assert len(corners) == 4 and np.ptp(forces[:, -1, 0]) > 0.1 * m * G
    np.testing.assert_allclose(friction / forces[..., 0], np.tile(k * t[rests] / (m * G), (4, 1)), rtol=1e-9)
    assert any(abs(event.time - start_of_slip) < 1e-9 for event in motion.events)
    tau = np.maximum(t - start_of_slip, 0)
    np.testing.assert_allclose(motion["f0_x"], k * tau**3 / (6 * m), atol=1e-8)
    slope = tau**3 / (6 * m) + tau**2 * start_of_slip / (2 * m)
    np.testing.assert_allclose(motion.sensitivity["f0_x", "k"], slope, atol=1e-7)
