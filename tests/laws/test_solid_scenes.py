"""What people build of solids: walls, dominoes, cards, boxes over edges; and what is refused."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import freebody as fb

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
        (lambda s, a, b: s.contacts("c", [a.box(BRICK), b.sphere(1, inside=True)]), "touch a sphere from inside"),
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


def test_solids_do_not_move_by_events():
    s, start = scene("events", [brick("a", {"z": 0.05}), brick("b", {"z": 0.15})])
    with pytest.raises(fb.errors.SimulationError, match="timestepping"):
        fb.simulate(s, 0.1, initial=start)
