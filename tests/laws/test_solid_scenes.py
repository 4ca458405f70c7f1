"""What people build of solids: walls, dominoes, cards, boxes over edges; and what is refused."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import freebody as fb
from laws_of_contact import moments, sampled, violations

G = 9.81
BRICK = (0.2, 0.1, 0.1)


def scene(name, solids, friction=0.5, floor=True):
    """Return a machine of free solids: name, mass properties, shape of the body, and their start."""
    s, start = fb.System(name), {}
    s.gravity = (0, 0, -G)
    shapes = [s.ground.plane(normal="z")] if floor else []
    for label, mass, shape, place in solids:
        body = s.body(label, mass)
        s.free(f"j_{label}", s.ground, body)
        shapes.append(shape(body))
        start |= {f"j_{label}_{c}": float(x) for c, x in place.items()}
    s.contacts("pile", shapes, friction=friction)
    return s, start


def brick(label, place, size=BRICK):
    return label, fb.box(2, size), lambda body: body.box(size), place


def moved(s, start, until, step=2e-3):
    return fb.simulate(s, until, initial=start, method="timestepping", step=step)


def test_a_wall_of_bricks_stands():
    bricks = [
        brick(f"b{i}{j}", {"x": (j + 0.25 * (i % 2)) * 0.201, "z": 0.05 + 0.1 * i})
        for i in range(5)
        for j in range(4)
    ]
    motion = moved(*scene("wall", bricks), 0.1)
    assert np.abs(motion.states[-1] - motion.states[0]).max() < 1e-10
    # the floor carries all: the impulses of a step are those of the weights
    last = motion.course.impulses.pairs[-1]
    floor = last[last[:, 10] == 0] if (last[:, 10] == 0).any() else last[last[:, 11] == 0]
    assert floor[:, 0].sum() / motion.step == pytest.approx(20 * 2 * G, rel=1e-9)


def test_the_force_of_a_patch_and_its_gap():
    motion = moved(*scene("two", [brick("a", {"z": 0.05}), brick("b", {"z": 0.15, "x": 0.05})]), 0.02)
    contact = motion.contacts["pile[a,b]"]
    np.testing.assert_allclose(contact.normal[1:], 2 * G, rtol=1e-9)
    np.testing.assert_allclose(contact.gap, 0, atol=1e-12)
    np.testing.assert_allclose(contact.slip, 0, atol=1e-10)


def test_a_box_is_pushed_over_the_edge_and_tips():
    s, start = scene("over", [brick("table", {"z": 0.05}), brick("box", {"z": 0.15, "x": 0.11})])
    motion = moved(s, start, 0.008, step=1e-3)
    inside, _ = scene("on", [brick("table", {"z": 0.05}), brick("box", {"z": 0.15, "x": 0.09})])
    still = moved(inside, start | {"j_box_x": 0.09}, 0.008, step=1e-3)
    # about the edge: m g a = (I + m (a² + h²)) α  with a = 1 cm, h = 5 cm
    alpha = G * 0.01 / ((0.2**2 + 0.1**2) / 12 + 0.01**2 + 0.05**2)
    assert float(motion["j_box_wy"][-1]) == pytest.approx(alpha * 0.008, rel=2e-3)
    assert abs(float(still["j_box_wy"][-1])) < 1e-9


def test_a_box_falls_on_the_edge_of_another_one():
    """An edge across an edge: one point, whose impulse turns both, and momentum is kept without gravity."""
    s, start = scene("edges", [brick("a", {}), brick("b", {"z": 0.2})], floor=False)
    s.gravity = (0, 0, 0)
    # the lower one stands on an edge along x, the upper one hangs over it turned by 90 degrees
    tilt = Rotation.from_rotvec([np.pi / 4, 0, 0])
    turns = {"a": tilt, "b": Rotation.from_rotvec([0, 0, np.pi / 2]) * tilt}
    for name, turn in turns.items():
        start |= {f"j_{name}_e{k}": float(x) for k, x in enumerate(np.roll(turn.as_quat(), 1))}
    fall = turns["b"].inv().apply([0, 0, -1])  # speeds are in axes of the body
    start |= {f"j_b_v{c}": float(x) for c, x in zip("xyz", fall, strict=True)}
    motion = moved(s, start, 0.2)
    logs = [log for log in motion.course.impulses.pairs if len(log)]
    assert len(logs) and len(logs[0]) == 1
    np.testing.assert_allclose(np.abs(logs[0][0, [7, 8]]), 0, atol=1e-9)  # where the edges cross
    np.testing.assert_array_equal(logs[0][:, 7:10], logs[0][:, 12:15])  # forces are opposite at one point
    speeds = [
        2 * sum(turn.apply([float(motion[f"j_{b}_v{c}"][k]) for c in "xyz"]) for b, turn in turns.items())
        for k in (0, -1)
    ]
    np.testing.assert_allclose(speeds, [[0, 0, -2]] * 2, atol=1e-12)  # it hits the middle, and nothing turns


@pytest.mark.slow
def test_dominoes_fall_in_turn():
    size = (0.02, 0.1, 0.2)
    solids = [brick(f"d{k}", {"x": 0.1 * k, "z": 0.1, "wy": 3.0 if k == 0 else 0.0, "vx": 0.3 if k == 0 else 0.0}, size)
              for k in range(4)]  # fmt: skip
    motion = moved(*scene("dominoes", solids), 0.8)
    fallen = [np.abs(motion[f"j_d{k}_e2"]) > 0.2 for k in range(4)]
    first = [float(motion.t[f.argmax()]) if f.any() else np.inf for f in fallen]
    assert np.isfinite(first).all() and (np.diff(first) > 0).all()


def test_capsules_and_stones_rest_on_a_floor():
    corners = [(0, 0, 0), (0.2, 0, 0), (0, 0.2, 0), (0, 0, 0.2)]
    solids = [
        (
            "pill",
            fb.box(1, (0.2, 0.1, 0.1)),
            lambda b: b.capsule((-0.1, 0, 0), (0.1, 0, 0), 0.05),
            {"z": 0.05},
        ),
        ("stone", fb.box(1, (0.2, 0.2, 0.2)), lambda b: b.hull(*corners), {"x": 1.0, "z": 0.0}),
    ]
    motion = moved(*scene("rest", solids), 0.05)
    np.testing.assert_allclose(motion["j_pill_z"], 0.05, atol=1e-10)
    logs = motion.course.impulses.pairs[-1]
    assert len(logs) >= 3
    assert logs[:, 0].sum() / motion.step == pytest.approx(2 * G, rel=0.1)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda s, a, b: s.contact("c", a.box(BRICK), b.box(BRICK)), "touch in patches, which families"),
        (lambda s, a, b: s.contacts("c", [a.box(BRICK), b.circle(1)]), "The box and the circle of the family"),
        (lambda s, a, b: a.box((1, 2)), "Expected three edges"),
        (lambda s, a, b: a.hull((0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)), "four points or more that are not in one"),
        (lambda s, a, b: a.capsule((0, 0, 0), (0, 0, 0), 1), "Start and end of the capsule of body 'a' are the same"),
        (lambda s, a, b: s.contacts("c", [a.drum(0.1, 0.1), b.sphere(1, inside=True)]), "touch a sphere from inside"),
    ],
)  # fmt: skip
def test_what_has_no_law_is_refused(make, said):
    s = fb.System("refused")
    a, b = (s.body(name, fb.box(1, BRICK)) for name in "ab")
    for body in (a, b):
        s.free(f"j{body.name}", s.ground, body)
    with pytest.raises(fb.errors.ModelError, match=said):
        make(s, a, b)


def test_solids_that_begin_inside_each_other_are_refused():
    s, start = scene("inside", [brick("a", {"z": 0.05}), brick("b", {"z": 0.12})])
    with pytest.raises(fb.errors.SimulationError, match=r"has contact 'pile\[a,b\]' 0.03 m deep"):
        moved(s, start, 0.1)


# -- by events -------------------------------------------------------------------------------------------


def ledger(motion):
    return np.abs(motion.energy.residual).max()


def test_boxes_rest_on_each_other_by_events():
    s, start = scene("rest", [brick("a", {"z": 0.05}), brick("b", {"z": 0.15, "x": 0.05})])
    motion = fb.simulate(s, 0.5, initial=start)
    contact = motion.contacts["pile[a,b]"]
    assert np.abs(motion.states - motion.states[0]).max() < 1e-12 and ledger(motion) < 1e-13
    np.testing.assert_allclose(contact.normal, 2 * G, rtol=1e-11)
    np.testing.assert_allclose(contact.gap, 0, atol=1e-12)
    assert set(contact.mode) == {"stick"}
    # corners carry: two of each, for the upper one reaches over the lower one
    parts = [name for name, part in motion.contacts.items() if "[a,b]_" in name and part.mode[0] == "stick"]
    assert len(parts) == 4


def test_a_box_slides_off_over_an_edge_by_events():
    """Slides and tips over the edge: the limit of time steps, which are of first order. It ends on the floor, at rest.

    Steps are compared up to the edge: the moments at which it lands are theirs to a step only.
    """
    s, start = scene(
        "over", [brick("table", {"z": 0.05}), brick("box", {"z": 0.15, "vx": 1.5})], friction=0.3
    )
    whole = fb.simulate(s, 0.6, initial=start)
    assert whole.status == "finished" and ledger(whole) < 1e-8
    assert float(whole["j_box_z"][-1]) == pytest.approx(0.05, abs=1e-10) and float(whole["j_box_x"][-1]) > 0.4
    assert np.abs(whole.at(0.6).u).max() < 1e-10
    assert np.abs(whole["j_box_y"]).max() < 1e-7  # it keeps its symmetry
    motion = fb.simulate(s, 0.14, initial=start)
    assert ledger(motion) < 1e-8
    assert any("other corners and edges" in change.why for change in motion.modes)
    n = len(motion.kernels.model.coordinate_names)
    errors = []
    for step in (4e-4, 1e-4):
        steps = moved(s, start, 0.14, step=step)
        errors.append(np.abs(steps.states[-1, :n] - motion.states[-1, :n]).max())
    assert errors[0] < 2e-3 and errors[1] < 0.5 * errors[0]


def test_the_first_moment_of_tipping_by_events():
    s, start = scene("tips", [brick("table", {"z": 0.05}), brick("box", {"z": 0.15, "x": 0.11})])
    motion = fb.simulate(s, 0.008, initial=start)
    # m g a cos θ = (I + m (a² + h²)) θ'' at θ = 0, with a = 1 cm, h = 5 cm
    alpha = G * 0.01 / ((0.2**2 + 0.1**2) / 12 + 0.01**2 + 0.05**2)
    assert float(motion["j_box_wy"][-1]) == pytest.approx(alpha * 0.008, rel=2e-3)


def test_a_tilted_box_falls_on_another_one_and_comes_to_rest_by_events():
    turn = Rotation.from_rotvec([0.3, 0.4, 0.2]).as_quat()
    place = {"z": 0.35, "x": 0.05} | {f"e{k}": x for k, x in enumerate(np.roll(turn, 1))}
    s, start = scene("fall", [brick("a", {"z": 0.05}), brick("b", place)])
    motion = fb.simulate(s, 0.8, initial=start)
    assert ledger(motion) < 1e-7
    assert float(motion.energy.kinetic[-1]) < 1e-9
    assert float(motion["j_b_z"][-1]) == pytest.approx(0.15, abs=1e-9)  # on the other one, flat


def thrown_on_a_box(seed):
    """A box thrown onto a box on a floor."""
    rng = np.random.default_rng(seed)
    turn = np.roll(Rotation.random(random_state=seed).as_quat(), 1)
    place = {"z": 0.35, "x": 0.05} | {f"e{k}": x for k, x in enumerate(turn)}
    place |= {f"w{c}": x for c, x in zip("xyz", rng.normal(0, 5, 3), strict=True)}
    return scene("thrown", [brick("a", {"z": 0.05}), brick("b", place)], friction=0.4)


def deepest(motion):
    """The greatest depth of two bricks in each other, by separating axes, or in the floor; negative."""
    corners = np.stack(np.meshgrid(*[(-x / 2, x / 2) for x in BRICK]), -1).reshape(-1, 3)
    a, b = (motion.poses[name] for name in "ab")
    result = 0.0
    for i in range(len(motion.t)):
        axes = [*a.rotation[i].T, *b.rotation[i].T]
        axes += [np.cross(x, y) for x in a.rotation[i].T for y in b.rotation[i].T]
        one, other = (corners @ pose.rotation[i].T + pose.position[i] for pose in (a, b))
        normals = [n / np.linalg.norm(n) for n in axes if np.linalg.norm(n) > 1e-6]
        apart = [
            max((one @ n).min() - (other @ n).max(), (other @ n).min() - (one @ n).max()) for n in normals
        ]
        result = min(result, max(apart), one[:, 2].min(), other[:, 2].min())
    return result


def slow(*seeds):
    return [pytest.param(seed, marks=pytest.mark.slow) for seed in seeds]


# refused before: features that change back by round-off as faces meet (13, 65, 68), cones reached again and again
# by noise of the directions of slow slips (140; 33, 139), an impact that is solved to 1.3e-10 of the speeds only (12);
# friction of a fixed direction where open forces hold a body at rest: chatter (235, 312, 530, 576) and a ledger of
# 2e-5 J (516); an open gap that closes by its round-off (252); the side of a steep crossing (600); zeros that only the
# dense output has (257); a place of a patch that a step of the speeds passes (377, 1062), or that comes between two
# points of a step (334, 1314); modes of a rest that ended, whose states between the steps were not finite (1076); slips
# that a straight step turns (1129). Two closed contacts beside each other turned a box by 1e-7 as one was lifted by
# 6e-12 m, 4e-7 J (1062)
@pytest.mark.parametrize(
    "seed",
    [
        13,
        65,
        140,
        600,
        *slow(12, 33, 68, 139, 235, 252, 257, 312, 334, 377, 516, 530, 576, 1076, 1062, 1129, 1314),
    ],
)
def test_a_box_thrown_on_a_box_by_events(seed):
    s, start = thrown_on_a_box(seed)
    motion = fb.simulate(s, 0.8, initial=start)
    assert motion.status == "finished" and ledger(motion) < 1e-7
    assert deepest(motion) > -1e-9


@pytest.mark.slow
def test_many_boxes_thrown_on_a_box_by_events():
    """None is in the other one without a word; most come to their end."""
    finished = 0
    for seed in range(1400, 1440):
        s, start = thrown_on_a_box(seed)
        try:
            motion = fb.simulate(s, 0.8, initial=start)
        except fb.errors.SimulationError:
            continue
        finished += 1
        assert deepest(motion) > -1e-9 and ledger(motion) < 1e-6
    assert finished >= 38


@pytest.mark.parametrize("friction", [0.4, pytest.param(0.7, marks=pytest.mark.slow)])
def test_a_die_on_an_incline_at_the_exact_angle_of_friction(friction):
    """It rests, or slips by the speed at which slips begin (0.7 was refused: a step of the speeds of no length)."""
    s = fb.System("incline")
    slope = np.arctan(friction)
    s.gravity = (G * np.sin(slope), 0, -G * np.cos(slope))
    body = s.body("die", fb.box(0.01, (0.02,) * 3))
    s.free("j", s.ground, body)
    s.contact("c", body.corners(size=(0.02,) * 3), s.ground.plane(normal="z"), friction=friction)
    start = {"j_z": 0.01, "j_e0": float(np.cos(0.3)), "j_e3": float(np.sin(0.3))}
    motion = fb.simulate(s, 0.5, initial=start)
    assert np.abs(motion.states[-1, :7] - motion.states[0, :7]).max() < 1e-7
    assert ledger(motion) < 1e-15


def dominoes(count):
    """A row of stones, of which the first one is pushed."""
    pushed, size = {"wy": 3.0, "vx": 0.3}, (0.02, 0.1, 0.2)
    places = [{"x": 0.1 * k, "z": 0.1} | (pushed if k == 0 else {"wy": 0.0, "vx": 0.0}) for k in range(count)]
    return scene("dominoes", [brick(f"d{k}", place, size) for k, place in enumerate(places)])


@pytest.mark.slow
def test_dominoes_fall_in_turn_by_events():
    s, start = dominoes(4)
    motion = fb.simulate(s, 0.8, initial=start)
    first = [float(motion.t[(np.abs(motion[f"j_d{k}_e2"]) > 0.2).argmax()]) for k in range(4)]
    assert (np.diff(first) > 0).all() and ledger(motion) < 1e-7


def test_dominoes_keep_their_symmetry_by_events():
    """Several impulses solve the problem of a row that falls; those that treat both sides alike are found."""
    s, start = dominoes(5)
    motion = fb.simulate(s, 0.5, initial=start)
    assert ledger(motion) < 1e-9 and len(motion.events) < 100
    assert max(np.abs(motion[f"j_d{k}_{x}"]).max() for k in range(5) for x in ("y", "wx", "wz")) < 1e-9


def test_friction_that_wedges_capsules_needs_few_events():
    """It holds a falling stack at 1 kN for a millisecond, in steps of the speeds, between which nothing opens."""
    s, pills = fb.System("pills"), []
    s.gravity, start = (0, 0, -9.81), {}
    for k in range(4):
        body = s.body(f"c{k}", fb.sphere(1, 0.1))
        s.free(f"j{k}", s.ground, body)
        pills.append(body.capsule((-0.15, 0, 0), (0.15, 0, 0), 0.05))
        start |= {f"j{k}_x": 0.02 * k, f"j{k}_z": 0.1 + 0.15 * k, f"j{k}_wz": 1.0 + k}
    s.contacts("p", [s.ground.plane(normal="z"), *pills], friction=0.4, restitution=0.2)
    motion = fb.simulate(s, 0.21, initial=start)
    held = [one for one in motion.events if 0.2 < one.time < 0.21]
    assert 0 < len(held) < 100  # 8,566 if contacts that press part by round-off of each step
    # inside a straight step the energy is off by its square
    curved = sampled(motion, moments(motion, 100))
    assert curved.energy.relative_residual < 1e-8
    assert violations(curved, {}) == []


def test_a_ball_falls_on_a_capsule_on_a_floor_by_events():
    """The limit of time steps; it rolls off to the side, and the capsule the other way."""
    pill = ("pill", fb.cylinder(1, 0.1, 0.4), lambda b: b.capsule((-0.2, 0, 0), (0.2, 0, 0), 0.1), {"z": 0.1})
    ball = ("ball", fb.sphere(1, 0.1), lambda b: b.sphere(0.1), {"z": 0.4, "x": 0.1, "y": 0.02})
    s, start = scene("roll", [pill, ball])
    motion = fb.simulate(s, 0.5, initial=start)
    assert ledger(motion) < 1e-9
    assert min(one.gap.min() for one in motion.contacts.values()) > -1e-12
    assert float(motion["j_ball_y"][-1]) > 0.03
    errors = [
        np.abs(moved(s, start, 0.5, step).states[-1, :14] - motion.states[-1, :14]).max()
        for step in (4e-3, 1e-3)
    ]
    assert errors[1] < 0.5 * errors[0] < 0.05


def test_a_wall_does_not_move_by_events():
    s, start = scene("wall", [brick(f"b{k}", {"z": 0.05 + 0.1 * k}) for k in range(13)])
    with pytest.raises(
        fb.errors.SimulationError, match="at more than 1200 points, 16 of them for two boxes.*timestepping"
    ):
        fb.simulate(s, 0.1, initial=start)


def test_parallel_edges_that_meet_are_refused_by_events():
    """An edge on an edge, parallel: rigid bodies have no normal there."""
    tilt = np.roll(Rotation.from_rotvec([np.pi / 4, 0, 0]).as_quat(), 1)
    turns = {f"e{k}": x for k, x in enumerate(tilt)}
    s, start = scene(
        "edges", [brick("a", turns), brick("b", {"z": 0.2, "vy": -1.0, "vz": -1.0, **turns})], floor=False
    )
    s.gravity = (0, 0, 0)
    with pytest.raises(
        fb.errors.SimulationError, match=r"Edges of 'pile\[a,b\]' that are parallel, .* meet at t = "
    ):
        fb.simulate(s, 0.2, initial=start)


@pytest.mark.slow
@pytest.mark.parametrize("speed", [0.9, 1.0, 1.2, 1.5, 2.0, 3.0])
@pytest.mark.parametrize("size", [(0.2, 0.08, 0.1), (0.2, 0.1, 0.1), (0.2, 0.12, 0.1), (0.1, 0.08, 0.1)])
def test_boxes_of_any_size_and_speed_go_over_the_edge_by_events(size, speed):
    s, start = scene(
        "over", [brick("table", {"z": 0.05}), brick("box", {"z": 0.15, "vx": speed}, size)], friction=0.3
    )
    motion = fb.simulate(s, 0.8, initial=start)
    assert motion.status == "finished" and motion.energy.relative_residual < 1e-7
    assert np.diff(motion.energy.total).max() < 1e-7 * motion.energy.total[0]
    # it keeps its symmetry: contacts at their limits of friction yield, and none closes as it leaves the table's edge
    assert np.abs(motion["j_box_y"]).max() < 1e-8


def test_a_slip_that_begins_has_the_ledger_of_its_steps_whatever_its_round_off():
    """A box that goes over an edge lands on two corners, which then slip from rest.

    Friction turns a slip that has just begun within 1e-8 s. A first step of 17 ms over it had an error of 5e-7 of the
    energy between its ends, and nothing told: for one of ten starts, by the last digits of their speed.
    """
    s, start = scene(
        "over", [brick("table", {"z": 0.05}), brick("box", {"z": 0.15}, (0.1, 0.08, 0.1))], friction=0.3
    )
    for seed in (6, 7, 9, 12):
        speed = 1.2 + 1e-6 * np.random.default_rng(seed).normal()
        motion = fb.simulate(s, 0.4, initial=start | {"j_box_vx": speed})
        assert any("|T| reached" in str(event) for event in motion.events)
        assert motion.energy.relative_residual < 1e-10
        assert np.abs(motion["j_box_y"]).max() < 1e-9
