"""Contact in space as a user meets it: turntable, tippe top, Euler's disk, boxes that tumble, a pile of balls."""

import math

import numpy as np
import pytest

import freebody as fb

G = 9.81


def upright(s, body, **options):
    s.gravity = (0, 0, -G)
    return s.free("f", s.ground, body, **options)


def test_a_ball_on_a_turntable_ends_in_a_circle_of_two_sevenths():
    # rolling on a table that turns with W: v' = (2/7) W k × v, once the slip is over
    s = fb.System("turntable")
    W, mu = s.parameters(Omega=2.0, mu=0.5)
    table, ball = s.body("table", fb.disk(5, 1)), s.body("ball", fb.sphere(1, 0.05))
    s.hinge("axle", s.ground, table, axis="z", coordinate=W * s.t)
    upright(s, ball)
    s.contact("c", ball.sphere(0.05), table.plane(normal="z"), friction=mu)
    motion = fb.simulate(s, 10, initial={"f_x": 0.5, "f_z": 0.05}, tolerance=1e-12)
    assert [m.mode for m in motion.modes] == ["slip", "stick"]
    rolls = motion.modes[1].start
    k = 4 / 7
    times = rolls + 0.1 + math.pi / k * np.array([0, 0.5, 1])  # a quarter and a half of a turn of 2 pi/k
    places = np.array([[motion.at(t)["f_x"], motion.at(t)["f_y"]] for t in times])
    middle = (places[0] + places[2]) / 2
    arms = places - middle
    assert arms[2] == pytest.approx(-arms[0], abs=1e-12)
    assert arms[1] == pytest.approx([-arms[0][1], arms[0][0]], abs=1e-9)
    assert motion.energy.relative_residual < 1e-10


def test_a_tippe_top_stands_on_its_head_and_keeps_jellett_s_constant():
    # the torque of the contact about C has no part along the arm from it: d/dt L·(R n - a axis) = 0, L = I w
    R, a, m = 0.02, 0.006, 0.02
    moment = 0.4 * m * R * R
    s = fb.System("tippe top")
    (mu,) = (s.parameters(mu=0.3),)
    top = s.body("top", fb.MassProperties(m, (0, 0, -a), [[moment, 0, 0], [0, moment, 0], [0, 0, moment]]))
    upright(s, top)
    s.contact("c", top.sphere(R), s.ground.plane(normal="z"), friction=mu)
    lean, spin = 0.1, 150
    start = {
        "f_e0": math.cos(lean / 2), "f_e1": math.sin(lean / 2), "f_z": R,
        "f_wy": spin * math.sin(lean), "f_wz": spin * math.cos(lean),
    }  # fmt: skip
    motion = fb.simulate(s, 3, initial=start, tolerance=1e-11)
    axis = np.asarray(motion.poses["top"].rotation)[:, :, 2]
    assert axis[0, 2] > 0.99
    assert axis[:, 2].min() < -0.8  # the heavy side, below at first, is above
    turned = np.asarray(motion.poses["top"].rotation)
    w = np.einsum("nij,nj->ni", turned, np.array([motion[f"f_w{c}"] for c in "xyz"]).T)
    jellett = np.einsum("ni,ni->n", w, np.array([0, 0, R]) - a * axis)
    assert jellett == pytest.approx(jellett[0], rel=1e-7)
    assert motion.energy.relative_residual < 1e-8
    assert (np.diff(motion.energy.total) <= 1e-12).all()


def test_euler_s_disk_keeps_its_steady_turn_where_it_rolls():
    # the centre at rest, tilted by t: W² sin t = 4 g/R with the angular velocity W sin t along the line to the contact
    R, tilt = 0.04, 0.3
    s = fb.System("Euler's disk")
    (mu,) = (s.parameters(mu=0.5),)
    disk = s.body("disk", fb.disk(0.4, R))
    upright(s, disk)
    s.contact("c", disk.circle(R), s.ground.plane(normal="z"), friction=mu)
    W = math.sqrt(4 * G / (R * math.sin(tilt)))
    start = {
        "f_e0": math.cos(tilt / 2), "f_e1": math.sin(tilt / 2), "f_z": R * math.sin(tilt),
        "f_wy": W * math.sin(tilt),
    }  # fmt: skip
    motion = fb.simulate(s, 1, initial=start, tolerance=1e-12)
    assert [m.mode for m in motion.modes.of("c")] == ["stick"]
    assert motion["f_z"] == pytest.approx(R * math.sin(tilt), rel=1e-8)
    assert motion.energy.relative_residual < 1e-11
    flat = fb.simulate(s, 0.2, initial={**start, "f_wy": 0.2 * W * math.sin(tilt)}, values={"mu": 0.01})
    assert np.diff(flat.energy.total).max() < 1e-9
    assert flat.contacts["c"].gap.min() > -1e-12


@pytest.fixture(scope="module")
def box():
    s = fb.System("box")
    mu, e = s.parameters(mu=0.5, e=0.3)
    body = s.body("box", fb.box(3, (0.3, 0.5, 0.4)))
    upright(s, body)
    feet = body.corners(size=(0.3, 0.5, 0.4))
    s.contact("foot", feet, s.ground.plane(normal="z"), friction=mu, restitution=e, impact="poisson")
    return s


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 3, 4, 5, 7, 9, 10, 11])
def test_energy_never_grows_as_a_box_tumbles_in_space(box, seed):
    rng = np.random.default_rng(seed)
    values = {"mu": rng.choice([0.0, 0.2, 0.6, 1.0]), "e": rng.choice([0.0, 0.3, 0.6, 0.8])}
    rng.normal(size=4)
    start = {"f_z": 1.0, "f_vx": 2 * rng.normal(), **{f"f_w{c}": 3 * rng.normal() for c in "xyz"}}
    motion = fb.simulate(box, 2, initial=start, values=values)
    assert motion.energy.relative_residual < 1e-8
    assert np.diff(motion.energy.total).max() < 1e-8 * motion.energy.total[0]
    assert (np.diff(motion.energy.impulses) <= 1e-12).all()
    assert (np.diff(motion.energy.friction) <= 1e-9).all()
    size = 3 * G
    for one in motion.contacts.values():
        assert one.gap.min() > -1e-11
        N, T = one.least[:, 0], np.linalg.norm(one.least[:, 1:], axis=1)
        assert N.min() >= -1e-9 * size
        # a slip that begins slowly has the direction of its first 1e-9 m/s
        assert (values["mu"] * N + 1e-6 * size >= T).all()
        assert (np.einsum("ni,ni->n", one.least[:, 1:], one.slip) <= 1e-9 * size).all()


def test_a_pile_of_balls_in_a_bowl_by_time_stepping():
    s = fb.System("pile")
    (mu,) = (s.parameters(mu=0.4),)
    s.gravity = (0, 0, -G)
    bowl = s.ground.sphere(1.0, at=(0, 0, 1.0), inside=True)
    balls, start = [], {}
    for i in range(6):
        ball = s.body(f"b{i}", fb.sphere(1, 0.1))
        s.free(f"f{i}", s.ground, ball)
        s.contact(f"w{i}", ball.sphere(0.1), bowl, friction=mu)
        for j, other in enumerate(balls):
            s.contact(f"c{j}_{i}", ball.sphere(0.1), other.sphere(0.1), friction=mu)
        balls.append(ball)
        turn = 2.4 * i
        start |= {
            f"f{i}_x": 0.12 * math.cos(turn),
            f"f{i}_y": 0.12 * math.sin(turn),
            f"f{i}_z": 0.3 + 0.22 * i,
        }
    motion = fb.simulate(s, 3, initial=start, method="timestepping", step=2e-3)
    assert motion.residual <= 1e-12
    assert motion.depth < 1e-9
    # most of what it had is gone; the bowl carries the weight, up to what the slow roll of the pile adds
    assert motion.energy.total[-1] < 0.2 * motion.energy.total[0]
    up = sum(motion.contacts[f"w{i}"].normal[-1] for i in range(6))
    assert up >= 6 * G * 0.9


def over_a_capsule(shape, swapped=False, **laws):
    """A ball or a point above a capsule of radius 0.1 along x, from 0 to 0.4."""
    s = fb.System("capsule")
    s.gravity = (0, 0, -G)
    body = s.body("ball", fb.sphere(1, 0.05))
    s.free("f", s.ground, body)
    shapes = (
        body.sphere(0.05) if shape == "sphere" else body.point(0, 0, 0),
        s.ground.capsule((0, 0, 0), (0.4, 0, 0), 0.1),
    )
    s.contact("c", *(shapes[::-1] if swapped else shapes), **laws)
    return s


@pytest.mark.parametrize("speed", [0.2, 0.5])
def test_a_bead_leaves_the_round_end_of_a_capsule_where_its_weight_no_longer_holds_it(speed):
    # m g cos θ = m v²/R with v² = v0² + 2 g R (1 - cos θ):  cos θ = 2/3 + v0²/(3 g R)
    motion = fb.simulate(over_a_capsule("point"), 1, initial={"f_x": 0.3, "f_z": 0.1, "f_vx": speed})
    assert [(m.contact, m.mode) for m in motion.modes if m.start > 0] == [
        ("c", "open"), ("c_end", "slip"), ("c_end", "open")
    ]  # fmt: skip
    onto, off = motion.modes[-2].start, motion.modes[-1].start
    assert onto == pytest.approx(0.1 / speed, rel=1e-9)
    assert motion.at(off)["f_z"] / 0.1 == pytest.approx(2 / 3 + speed**2 / (3 * G * 0.1), abs=1e-8)


@pytest.mark.parametrize("swapped", [False, True])
def test_a_ball_rolls_along_a_capsule_and_over_its_end(swapped):
    start = {"f_x": 0.2, "f_z": 0.15, "f_vx": -1.0, "f_wy": -20.0}
    motion = fb.simulate(over_a_capsule("sphere", swapped, friction=0.4), 0.3, initial=start)
    modes = [(m.contact, m.mode) for m in motion.modes if m.start > 0]
    assert modes[:3] == [("c", "open"), ("c_start", "stick"), ("c_start", "slip")]
    assert motion.modes[3].start == pytest.approx(0.2, rel=1e-9)
    centre = np.stack([motion[f"f_{x}"] for x in "xyz"], axis=1)
    foot = np.clip(centre[:, :1], 0, 0.4) * [1, 0, 0]
    assert np.linalg.norm(centre - foot, axis=1).min() > 0.15 - 1e-12
    assert motion.energy.relative_residual < 1e-8


def test_a_cylinder_on_its_side_rolls_down_on_the_circles_of_its_ends():
    """It rolls with 2/3 g sin a, from a fall onto its side too, and both circles bear half of its weight."""
    s = fb.System("log")
    slope = 0.2
    s.gravity = (0, -9.81 * math.sin(slope), -9.81 * math.cos(slope))
    log = s.body("log", fb.cylinder(1, 0.1, 0.4, axis="x"))
    s.free("air", s.ground, log)
    for name, x in (("left", -0.2), ("right", 0.2)):
        end = log.circle(0.1, at=(x, 0, 0), axis="x")
        s.contact(name, end, s.ground.plane(normal="z"), friction=0.5)
    motion = fb.simulate(s, 1, initial={"air_z": 0.1}, tolerance=1e-11)
    assert motion["air_y"][-1] == pytest.approx(-9.81 * math.sin(slope) / 3, rel=1e-9)
    for one in (motion.contacts["left"], motion.contacts["right"]):
        assert one.mode[-1] == "stick"
        assert one.normal[-1] == pytest.approx(9.81 * math.cos(slope) / 2, rel=1e-9)
    fallen = fb.simulate(s, 1, initial={"air_z": 0.2, "air_wz": 0.5})
    assert [fallen.contacts[name].mode[-1] for name in ("left", "right")] == ["stick", "stick"]
    assert fallen["air_z"][-1] == pytest.approx(0.1, abs=1e-9)
