"""Time stepping where contacts share few freedoms, or an edge all but lies flat."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import freebody as fb
from cone_problems import DenseProblem


def face(n, seed):
    """A, b and rows of n corners of one face of a body, pressed on at random; more contacts than freedoms."""
    rng = np.random.default_rng(seed)
    W = []
    for k in range(n):
        x, y = np.cos(2 * np.pi * k / n), np.sin(2 * np.pi * k / n)
        for e in ((0, 0, 1), (1, 0, 0), (0, 1, 0)):
            W.append([*np.cross((x, y, -0.5), e), *e])
    W = np.array(W)
    A = W @ np.diag(rng.uniform(0.5, 2, 6)) @ W.T
    b = W @ rng.normal(size=6)
    # a rebound in the normals alone, by which not all corners can stick
    b[::3] += 0.4 * (W @ rng.normal(size=6))[::3] * rng.integers(0, 2)
    return A, b, np.tile([1, 3, 4], n), np.full(3 * n, rng.uniform(0.1, 1))


@pytest.mark.parametrize("n", [2, 4, 12])
def test_laws_hold_for_corners_of_one_face(n):
    solved = 0
    for seed in range(20):
        A, b, kinds, mu = face(n, seed)
        goal = 1e-11 * np.abs(b).max()
        problem = DenseProblem(A, b, kinds, mu)
        x = problem.solved(goal)
        if x is None:
            continue
        solved += 1
        assert problem.rated(x, A @ x + b) <= 1e-11
        assert (x[::3] >= 0).all()
        assert (np.hypot(x[1::3], x[2::3]) <= mu[0] * x[::3] * (1 + 1e-9) + goal).all()
    assert solved >= 19


def coin(mu=0.3, e=0.4, R=0.012, h=0.002):
    """Two circular edges over a plane."""
    s = fb.System("coin")
    s.gravity = (0, 0, -9.81)
    body = s.body("coin", fb.cylinder(0.005, R, h))
    s.free("f", s.ground, body)
    floor = s.ground.plane(normal="z")
    for name, z in (("bottom", -h / 2), ("top", h / 2)):
        s.contact(name, body.circle(R, axis="z", at=(0, 0, z)), floor, friction=mu, restitution=e)
    return s


@pytest.mark.parametrize(
    "start", [{"f_z": 0.001}, {"f_z": 0.3, "f_wy": 3.0}, {"f_z": 0.1, "f_wz": 20.0, "f_wx": 1e-3}]
)
def test_a_coin_of_two_edges_comes_to_lie_flat(start):
    motion = fb.simulate(coin(), 0.5, initial=start, method="timestepping", step=1e-3)
    assert motion.status == "finished"
    assert motion["f_z"][-1] == pytest.approx(0.001, abs=1e-9)


def test_the_end_of_a_stepped_run_is_within_it():
    for until, step in ((0.5, 1e-3), (0.7, 1e-3), (1.1, 3e-3), (0.3, 1e-4)):
        motion = fb.simulate(coin(), until, initial={"f_z": 0.01}, method="timestepping", step=step)
        assert motion.t[-1] == until
        assert motion.at(until)["f_z"] == pytest.approx(motion["f_z"][-1])


def stiff():
    """A mass on a spring with k h²/m = 9 for h = 1 ms: beyond 4 the steps gain energy."""
    s = fb.System("stiff")
    s.gravity = (0, 0, -9.81)
    body = s.body("stone", fb.particle(1))
    rail = s.slider("rail", s.ground, body, axis="z", coordinate="z")
    s.spring("spring", rail, stiffness=9e6)
    s.contact("floor", body.point(0, 0, 0), s.ground.plane(at=(0, 0, -1e300), normal="z"))
    return s


def test_steps_that_make_energy_say_so():
    motion = fb.simulate(stiff(), 0.01, initial={"z'": 1e-3}, method="timestepping", step=1e-3)
    (warning,) = motion.warnings
    assert motion.status == "finished, not physical"
    assert warning.event == "energy"
    assert warning.value == pytest.approx(motion.energy.residual.max(), rel=1e-6)
    assert warning.cure == "Take a step shorter than 0.001 s, or method='auto'."
    short = fb.simulate(stiff(), 0.01, initial={"z'": 1e-3}, method="timestepping", step=1e-4)
    assert not short.warnings
    assert short.status == "finished"


def test_a_run_that_breaks_of_made_energy_names_it():
    with pytest.raises(fb.FreebodyError, match=r"the steps make energy.* Take a step.* Then: ") as caught:
        fb.simulate(stiff(), 2, initial={"z'": 1e-3}, method="timestepping", step=1e-3)
    assert caught.value.trajectory.status == "failed, not physical"


def test_bodies_that_turn_four_times_in_a_step_are_refused():
    start = {"f_z": 5, "f_wx": 20.0, "f_wz": 25e3}
    with pytest.raises(
        fb.FreebodyError, match=r"No mean speeds agree .* 'coin' at t = 0 s.* Take a shorter step"
    ):
        fb.simulate(coin(), 0.4, initial=start, method="timestepping", step=1e-3)


def test_a_coin_that_comes_to_rest_makes_no_energy():
    motion = fb.simulate(coin(), 0.5, initial={"f_z": 0.1, "f_wx": 5.0}, method="timestepping", step=1e-4)
    assert not motion.warnings


@pytest.mark.parametrize("force", ["0", "6*sin(5*t)"])
def test_a_box_at_rest_or_pushed_makes_no_energy(force):
    s = fb.System("box")
    s.gravity = (0, -9.81, 0)
    box = s.body("box", fb.box(1, (0.2, 0.1, 0.1)))
    s.planar("plane", s.ground, box, coordinate="x y turn")
    s.contact("floor", box.corners(size=(0.2, 0.1)), s.ground.plane(), friction=0.3)
    s.force("F", box.origin, (force, 0, 0))
    motion = fb.simulate(s, 2, initial={"y": 0.05}, method="timestepping", step=1e-3)
    assert motion.status == "finished"


def thrown(kind, seed):
    """A die of eight corners, or a coin of 24 corners or two edges, over a plane, and a random throw."""
    rng = np.random.default_rng(seed)
    start = {
        f"f_e{i}": float(x)
        for i, x in enumerate(Rotation.random(random_state=seed).as_quat(scalar_first=True))
    }
    start |= {f"f_w{x}": float(v) for x, v in zip("xyz", 20 * rng.normal(size=3), strict=True)}
    start |= {f"f_v{x}": float(v) for x, v in zip("xyz", 0.5 * rng.normal(size=3), strict=True)}
    if kind == "edges":
        return coin(), start | {"f_z": 0.05}
    s = fb.System(kind)
    s.gravity = (0, 0, -9.81)
    body = s.body(
        kind, fb.box(0.005, (0.016, 0.016, 0.016)) if kind == "die" else fb.cylinder(0.005, 0.012, 0.002)
    )
    s.free("f", s.ground, body)
    angles = 2 * np.pi * np.arange(12) / 12
    places = [(0.012 * np.cos(a), 0.012 * np.sin(a), z) for a in angles for z in (-0.001, 0.001)]
    corners = body.corners(size=(0.016,) * 3) if kind == "die" else body.corners(*places)
    s.contact("floor", corners, s.ground.plane(normal="z"), friction=0.3, restitution=0.4)
    return s, start | {"f_z": 0.05}


@pytest.mark.parametrize("kind", ["die", "coin", "edges"])
@pytest.mark.parametrize("seeds", [range(4), pytest.param(range(4, 40), marks=pytest.mark.slow)])
def test_every_throw_comes_to_its_end(kind, seeds):
    for seed in seeds:
        s, start = thrown(kind, seed)
        motion = fb.simulate(s, 1, initial=start, method="timestepping", step=1e-3)
        assert motion.status == "finished"
        assert motion.residual <= 1e-9
        assert (
            motion.energy.kinetic[-1] + motion.energy.potential[-1]
            < motion.energy.kinetic[0] + motion.energy.potential[0]
        )
