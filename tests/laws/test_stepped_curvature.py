"""Laws of time stepping where surfaces curve: contacts that press stay closed, do no work, and are of second order."""

import numpy as np
import pytest

import freebody as fb
from freebody.motion.moreau.stepping_record import CLOSED_GAP

G = 9.81


def dome(family=False, friction=0.8, spin=0.0):
    """A ball on a fixed sphere, a little beside its top, at rest or turning about the normal and rolling along y."""
    s = fb.System("dome")
    s.gravity = (0, 0, -G)
    ball = s.body("ball", fb.sphere(1, 0.1))
    s.free("f", s.ground, ball)
    if family:
        s.contacts("c", [ball.sphere(0.1), s.ground.sphere(1.0)], friction=friction)
    else:
        s.contact("c", ball.sphere(0.1), s.ground.sphere(1.0), friction=friction)
    n = np.array([np.sin(0.1), 0, np.cos(0.1)])
    start = {"f_x": 1.1 * n[0], "f_z": 1.1 * n[2]}
    if spin:
        w = np.cross(n, (0, 0.5, 0)) / 0.1 + spin * n
        start |= {"f_vy": 0.5} | {f"f_w{c}": float(x) for c, x in zip("xyz", w, strict=True)}
    return s, start, "c[ball,ground]" if family else "c"


def bowl(friction):
    s = fb.System("bowl")
    s.gravity = (0, 0, -G)
    ball = s.body("ball", fb.sphere(1, 0.1))
    s.free("f", s.ground, ball)
    s.contact("c", ball.sphere(0.1), s.ground.sphere(1.0, inside=True), friction=friction, restitution=0.4)
    return s, {"f_x": 0.9 * np.sin(0.6), "f_z": -0.9 * np.cos(0.6)}, "c"


def disks():
    """A disk that rolls off another one, which turns."""
    s = fb.System("disks")
    s.gravity = (0, -G, 0)
    disk = s.body("disk", fb.disk(1, 0.1))
    s.planar("p", s.ground, disk, coordinate="x y a")
    wheel = s.body("wheel", fb.disk(2, 0.3))
    s.hinge("h", s.ground, wheel, coordinate="q")
    s.contact("c", disk.circle(0.1), wheel.circle(0.3), friction=0.5)
    return s, {"x": 0.4 * np.sin(0.2), "y": 0.4 * np.cos(0.2)}, "c"


def hill(friction):
    """A wheel that comes over a hill from a valley."""
    s = fb.System("hill")
    s.gravity = (0, -G, 0)
    wheel = s.body("wheel", fb.disk(1, 0.1))
    s.planar("p", s.ground, wheel, coordinate="x y a")
    s.contact("c", wheel.circle(0.1), s.ground.heightline("0.1*cos(2*x)"), friction=friction)
    height, slope = 0.1 * np.cos(2.8), 0.2 * np.sin(2.8)
    n = np.array([-slope, 1]) / np.hypot(1, slope)
    start = {"x": -1.4 + 0.1 * n[0], "y": height + 0.1 * n[1], "x'": 1.9 * n[1], "y'": -1.9 * n[0]}
    return s, start | {"a'": -19.0 if friction else 0.0}, "c"


SCENES = {
    "dome": (dome(), 0.6, 1e-2), "family": (dome(True), 0.6, 1e-2), "smooth": (dome(friction=0.0), 0.5, 1e-2),
    "spun": (dome(friction=2.0, spin=20.0), 0.4, 5e-3), "bowl": (bowl(0.0), 0.8, 1e-2),
    "rolling": (bowl(0.8), 0.8, 1e-2), "disks": (disks(), 0.24, 5e-3), "hill": (hill(0.8), 1.6, 1e-2),
    "slide": (hill(0.0), 1.6, 1e-2),
}  # fmt: skip


@pytest.mark.parametrize("scene", SCENES)
def test_of_second_order_where_surfaces_curve(scene):
    """Position, energy and normal force have a quarter of their errors with half of the step, and contact does no work.

    The force of a step is that of its middle. In the first three steps T and T₋ are not known yet.
    """
    (s, start, name), until, h = SCENES[scene]
    errors = []
    for step in (h, h / 2):
        t = np.linspace(0, until, round(until / step) + 1)
        exact = fb.simulate(s, until, initial=start, times=t, tolerance=1e-11)
        middle = fb.simulate(s, until, initial=start, times=(t[1:] + t[:-1]) / 2, tolerance=1e-11)
        motion = fb.simulate(s, until, initial=start, times=t, method="timestepping", step=step)
        assert np.abs(motion.energy.residual).max() < 1e-12
        total = motion.energy.kinetic + motion.energy.potential
        force = motion[f"{name}.normal"][1:] - middle[f"{name}.normal"]
        n_q = 3 if "f_x" in motion.kernels.model.coordinate_names else 2
        places = np.abs(motion.states[:, :n_q] - exact.states[:, :n_q])
        errors.append([places.max(), np.ptp(total), np.sqrt(np.mean(force[3:] ** 2))])
        # turns that open no more than the closed gap are none: N/2 times the gap, and no more for friction
        works = motion.course.impulses.works[:, 0]
        assert works.max() <= CLOSED_GAP * middle[f"{name}.normal"].max()
    order = np.log2(np.divide(*errors))
    assert (order > 1.8).all(), (order, errors)


def test_a_ball_leaves_a_dome_where_its_force_vanishes():
    s, start, _ = dome()
    start |= {"f_vx": 1.0 * np.cos(0.1), "f_vz": -1.0 * np.sin(0.1), "f_wy": 10.0}
    exact = fb.simulate(s, 1.2, initial=start)
    left = next(change.start for change in exact.modes if change.mode == "open")
    h = 1e-3
    motion = fb.simulate(s, 1.2, initial=start, method="timestepping", step=h, samples=1201)
    closed = motion.contacts["c"].mode != "open"
    # the force of a step is that of its middle, and the last one lies in the step before it vanishes
    assert abs(motion.t[np.flatnonzero(closed)[-1]] - left) < 2 * h
    assert closed[1 : round(left / h) - 2].all()


def feet(count, inside, friction, family):
    """A table on feet that are balls, which slides and turns on a dome or in a bowl."""
    s = fb.System("table")
    s.gravity = (0, 0, -G)
    table = s.body("table", fb.box(1, (0.3, 0.3, 0.1)))
    s.free("f", s.ground, table)
    angles = 2 * np.pi * np.arange(count) / count
    balls = [table.sphere(0.02, at=(0.15 * float(np.cos(a)), 0.15 * float(np.sin(a)), -0.05)) for a in angles]
    ground = s.ground.sphere(1.0, at=(0, 0, 1.0 if inside else -1.0), inside=inside)
    if family:
        s.contacts("c", balls, against=ground, friction=friction)
    else:
        for k, ball in enumerate(balls):
            s.contact(f"c{k}", ball, ground, friction=friction)
    reach = np.sqrt((0.98 if inside else 1.02) ** 2 - 0.15**2)
    height = 0.05 + (1 - reach if inside else reach - 1)
    return s, {"f_z": float(height), "f_vx": 0.8, "f_wz": 2.0}


@pytest.mark.parametrize("count", [4, 5])
@pytest.mark.parametrize(
    "inside, friction, family", [(True, 0.3, False), (False, 0.3, True), (True, 0.0, True)]
)
def test_more_feet_than_can_touch_at_once(count, inside, friction, family):
    """Their gaps cannot all be pulled shut: a contact pulls by no more than its own force can in a step."""
    s, start = feet(count, inside, friction, family)
    motion = fb.simulate(s, 0.3, initial=start, method="timestepping", step=2e-3)
    assert motion.depth <= CLOSED_GAP and motion.residual <= 1e-12


@pytest.mark.parametrize("family", [False, True])
@pytest.mark.parametrize("seed, h", [(0, 2e-3), (1, 1e-3)])
def test_a_box_with_friction_gains_nothing_where_it_bounces(family, seed, h):
    rng = np.random.default_rng(seed)
    s = fb.System("box")
    s.gravity = (0, 0, -G)
    box = s.body("box", fb.box(1, (0.3, 0.2, 0.1)))
    s.free("f", s.ground, box)
    floor = s.ground.plane(normal="z")
    if family:
        s.contacts("c", [box.box((0.3, 0.2, 0.1)), floor], friction=0.4, restitution=1.0)
    else:
        for k, (x, y, z) in enumerate(np.ndindex(2, 2, 2)):
            corner = box.point(0.3 * (x - 0.5), 0.2 * (y - 0.5), 0.1 * (z - 0.5))
            s.contact(f"c{k}", corner, floor, friction=0.4, restitution=1.0)
    start = {"f_z": 0.4} | {f"f_w{c}": float(w) for c, w in zip("xyz", 3 * rng.normal(size=3), strict=True)}
    motion = fb.simulate(s, 2, initial=start, method="timestepping", step=h)
    works = motion.course.impulses.works[:, 0]
    # several points of a face do work of first order in h: 6e-6 J in one of 2000 steps (`curvature`)
    most = 1e-5 if family else 1e-12 * motion.energy.potential[0]
    assert works.max() <= most and works.sum() < -1
