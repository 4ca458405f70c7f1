"""Time stepping where contacts share few freedoms, or an edge all but lies flat."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from freebody.motion.contact.cone_problem import _conditions, eased


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
        x = eased(A, b, kinds, mu, goal)
        if x is None:
            continue
        solved += 1
        assert np.abs(_conditions(A, b, kinds, mu, x, np.zeros(len(b)))[0]).max() <= goal
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


@pytest.mark.parametrize("until", [0.1, 0.14])
def test_steps_that_make_energy_say_so(until):
    start = {"f_z": 5, "f_wx": 20.0, "f_wz": 250.0}  # in the air: nothing gives it energy
    motion = fb.simulate(coin(), until, initial=start, method="timestepping", step=1e-3)
    (said,) = motion.warnings
    assert motion.status == "finished, not physical"
    assert said.event == "energy"
    assert said.value == pytest.approx(motion.energy.residual.max(), rel=1e-6)
    assert "turn by" in said.cure and "a step=" in said.cure
    short = fb.simulate(coin(), until, initial=start, method="timestepping", step=1e-5)
    assert not short.warnings
    assert short.status == "finished"


def test_a_run_that_breaks_of_made_energy_names_it():
    start = {"f_z": 5, "f_wx": 20.0, "f_wz": 250.0}
    with pytest.raises(fb.FreebodyError, match=r"the steps make energy.* take a step=.* Then: ") as caught:
        fb.simulate(coin(), 0.4, initial=start, method="timestepping", step=1e-3)
    assert caught.value.trajectory.status == "failed, not physical"


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
