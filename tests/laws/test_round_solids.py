"""Laws of spheres and capsules on boxes, hulls and capsules, from event to event."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import freebody as fb
from contact_machines import momenta
from freebody.dynamics import float_state

G = 9.81
R, CORNER = 0.1, ((0, 0, 0.15), (0.2, 0, -0.1), (-0.1, 0.15, -0.1), (-0.1, -0.15, -0.1))
SOLIDS = {
    "ball": (fb.sphere(1, R), lambda b: b.sphere(R)),
    "pill": (fb.cylinder(1, R, 0.4), lambda b: b.capsule((0, 0, -0.15), (0, 0, 0.15), R)),
    "box": (fb.box(1, (0.4, 0.3, 0.2)), lambda b: b.box((0.4, 0.3, 0.2))),
    "stone": (fb.sphere(1, R), lambda b: b.hull(*CORNER)),
    "cube": (fb.box(0.5, (0.2,) * 3), lambda b: b.box((0.2,) * 3)),
}


def thrown(names, floor=True, friction=0.4, restitution=0.3):
    """Two free solids, and a floor."""
    s, shapes = fb.System(" and ".join(names)), []
    s.gravity = (0, 0, -G if floor else 0)
    for label, name in zip("ab", names, strict=True):
        mass, shape = SOLIDS[name]
        body = s.body(label, mass)
        s.free(f"j{label}", s.ground, body)
        shapes.append(shape(body))
    floors = [s.ground.plane(normal="z")] if floor else []
    s.contacts("pile", [*shapes, *floors], friction=friction, restitution=restitution)
    return s


def turned(label, seed):
    return {
        f"j{label}_e{k}": float(x)
        for k, x in enumerate(np.roll(Rotation.random(random_state=seed).as_quat(), 1))
    }


def ledger(motion):
    return np.abs(motion.energy.residual).max()


@pytest.mark.parametrize(
    "names", [("pill", "box"), ("ball", "stone"), pytest.param(("pill", "pill"), marks=pytest.mark.slow)]
)
def test_solids_that_meet_in_flight_keep_their_momenta(names):
    """Newton's third law: forces of friction and of impacts are opposite, at one point."""
    s, rng = thrown(names, floor=False), np.random.default_rng(5)
    start = turned("a", 1) | turned("b", 2) | {"ja_z": 0.8, "ja_x": 0.03}
    start |= {
        f"j{b}_w{c}": float(x) for b in "ab" for c, x in zip("xyz", 3 * rng.normal(size=3), strict=True)
    }
    # speeds are in axes of the body
    quaternion = [start[f"ja_e{k}"] for k in (1, 2, 3, 0)]
    fall = Rotation.from_quat(quaternion).inv().apply([0, 0, -2])
    start |= {f"ja_v{c}": float(x) for c, x in zip("xyz", fall, strict=True)}
    motion = fb.simulate(s, 1, initial=start)
    assert any("impact" in str(event) for event in motion.events)
    model, totals = motion.kernels.model, []
    for y in (motion.states[0], motion.states[-1]):
        state = float_state(model, y[: model.n_q], y[model.n_q : model.n_q + model.n_u])
        linear, angular = np.zeros(3), np.zeros(3)
        for body in s.bodies.values():
            p, spin, centre = momenta(model, state, body)
            linear, angular = linear + p, angular + spin + np.cross(centre, p)
        totals.append(np.r_[linear, angular])
    np.testing.assert_allclose(*totals, atol=1e-8)
    assert ledger(motion) < 1e-9


def sliding(make, ground, start):
    """Return the angle from above at which a body without friction leaves what it slides off, about the x axis."""
    s = fb.System("sliding off")
    s.gravity = (0, 0, -G)
    body = s.body("body", fb.sphere(1, R))
    s.free("air", s.ground, body)
    s.contacts("touch", [make(body)], against=ground(s.ground))
    motion = fb.simulate(s, 1, initial=start, events=[fb.event("air_z + 1", terminal=True)])
    leaves = next(event.time for event in motion.events if "reached 0" in str(event))
    y, z = (float(motion.at(leaves)[name]) for name in ("air_y", "air_z"))
    assert ledger(motion) < 1e-9
    return y, z


@pytest.mark.parametrize(
    ("make", "ground", "radius"),
    [
        (lambda b: b.sphere(R), lambda g: g.box((1, 0.4, 0.4), at=(0, -0.2, -0.2)), R),
        (lambda b: b.sphere(R), lambda g: g.hull((0, 0, 0), (0, -1, 0.01), (1, -1, -1), (-1, -1, -1)), R),
        (
            lambda b: b.capsule((-0.2, 0, 0), (0.2, 0, 0), R),
            lambda g: g.box((1, 0.4, 0.4), at=(0, -0.2, -0.2)),
            R,
        ),
        (
            lambda b: b.capsule((-0.2, 0, 0), (0.2, 0, 0), R),
            lambda g: g.capsule((-0.1, 0, 0), (0.3, 0, 0), R),
            2 * R,
        ),
        (lambda b: b.capsule((-0.2, 0, 0), (0.2, 0, 0), R), lambda g: g.box((0.1, 0.4, 0.4), at=(0, -0.2, -0.2)), R),
    ],
    ids=["ball on an edge", "ball on a corner", "pill on an edge", "pill on a pill", "pill on a short edge"],
)  # fmt: skip
def test_what_slides_off_without_friction_leaves_where_its_weight_no_longer_turns_it(make, ground, radius):
    """From rest at θ₀:  m v² = 2 m g r (cos θ₀ - cos θ) = m g r cos θ  at  cos θ = 2/3 cos θ₀."""
    begin = 0.2
    y, z = sliding(make, ground, {"air_y": radius * np.sin(begin), "air_z": radius * np.cos(begin)})
    assert np.hypot(y, z) == pytest.approx(radius, abs=1e-10)
    assert z / radius == pytest.approx(2 / 3 * np.cos(begin), abs=1e-7)


THROWS = [
    ("stone", "pill", 20),
    ("pill", "box", 44),
    ("pill", "box", 53),
    ("pill", "box", 4),
    ("pill", "box", 68),
    ("ball", "stone", 23),
]


@pytest.mark.parametrize(
    ("above", "below", "seed"),
    [("pill", "box", 0), *(pytest.param(*throw, marks=pytest.mark.slow) for throw in THROWS)],
)
def test_thrown_round_solids_keep_the_ledger(above, below, seed):
    """The first one rattles between capsule, box and floor, by impacts that follow each other closer than times differ.

    In others the nearest features change back by round-off: an edge over a corner, a capsule over two edges of a face.
    In 68 the capsule rolls about the line through two contacts at which it sticks, by forces along it that are open.
    """
    s, rng = thrown((above, below)), np.random.default_rng(seed)
    low = {"ball": 0.1, "pill": 0.3, "box": 0.27, "stone": 0.27}
    start = {"jb_z": low[below] + 0.001, "ja_z": 2 * low[below] + low[above] + 0.05}
    for label in "ba":
        q = np.roll(Rotation.random(random_state=rng).as_quat(), 1)
        start |= {f"j{label}_e{k}": float(x) for k, x in enumerate(q)}
    for c in "xy":
        start |= {f"ja_{c}": float(rng.uniform(-0.1, 0.1)), f"ja_v{c}": float(rng.normal() / 2)}
    start |= {f"ja_w{c}": float(4 * rng.normal()) for c in "xyz"}
    motion = fb.simulate(s, 1.5, initial=start)
    assert motion.status == "finished" and ledger(motion) < 1e-8
    assert min(one.gap.min() for name, one in motion.contacts.items() if "_" not in name) > -1e-9


# refused before, or without an end: low bounces of the box, which the capsule carries, gave slips to contacts that
# stick, again and again (24, 32, 134), until modes were endless (31) or none was consistent (93); so did the end of a
# slip (116)
@pytest.mark.parametrize(
    "seed", [31, *(pytest.param(k, marks=pytest.mark.slow) for k in (24, 32, 93, 116, 134))]
)
def test_a_box_rattles_on_a_capsule_to_the_end(seed):
    s, rng = thrown(("box", "pill"), friction=0.8, restitution=0.5), np.random.default_rng(seed)
    start = {"jb_z": 0.301, "ja_z": 0.92}
    for label in "ba":
        q = np.roll(Rotation.random(random_state=rng).as_quat(), 1)
        start |= {f"j{label}_e{k}": float(x) for k, x in enumerate(q)}
        spin = 2 * rng.normal(size=3)
        start |= {f"j{label}_w{c}": float(x) for c, x in zip("xyz", spin, strict=True)}
    motion = fb.simulate(s, 1, initial=start, max_steps=8000)
    assert motion.status == "finished" and ledger(motion) < 1e-8


SIZES = {"pill": 0.25, "box": 0.27, "cube": 0.175}


# features that alternate, at one moment, with those of the same point (5174, 5317); a crossing that comes from behind
# its edges and was to close at the depth that it had there (5331); capsules that cross almost parallel, whose closed
# contact turns fast beside slow slips: a step of the speeds was wrong by 8e-8 J (5140)
@pytest.mark.parametrize(
    ("names", "seed", "friction", "restitution"),
    [
        (("pill", "box"), 5174, 0.8, 0.3),
        (("box", "pill"), 5331, 0.4, 0.0),
        pytest.param(("pill", "pill"), 5140, 0.1, 0.0, marks=pytest.mark.slow),
        pytest.param(("cube", "box"), 5317, 0.4, 0.0, marks=pytest.mark.slow),
    ],
)
def test_solids_thrown_at_a_floor_and_each_other_keep_the_ledger(names, seed, friction, restitution):
    s, rng = thrown(names, friction=friction, restitution=restitution), np.random.default_rng([263, seed])
    start, z = {}, 0.02
    for label, name in zip("ba", names[::-1], strict=True):
        z += SIZES[name] + 0.01
        q = np.roll(Rotation.random(random_state=rng).as_quat(), 1)
        start |= {f"j{label}_e{k}": float(x) for k, x in enumerate(q)} | {f"j{label}_z": z}
        start |= {f"j{label}_{c}": float(0.03 * rng.normal()) for c in "xy"}
        start |= {f"j{label}_w{c}": float(4 * rng.normal()) for c in "xyz"}
        start |= {f"j{label}_v{c}": float(0.5 * rng.normal()) for c in "xyz"}
        z += SIZES[name] + 0.02
    motion = fb.simulate(s, 1, initial=start)
    assert motion.status == "finished" and ledger(motion) < 1e-8


def test_a_capsule_comes_to_rest_on_a_box():
    """Thrown askew, it lies on the face at its two ends at last."""
    s = fb.System("rest")
    s.gravity = (0, 0, -G)
    pill = s.body("pill", fb.cylinder(1, R, 0.5))
    s.free("air", s.ground, pill)
    s.contacts(
        "touch",
        [pill.capsule((0, 0, -0.15), (0, 0, 0.15), R)],
        against=s.ground.box((2, 2, 0.2)),
        friction=0.5,
    )
    lying = np.roll(Rotation.from_rotvec([1.3, 0, 0]).as_quat(), 1)
    start = {f"air_e{k}": float(x) for k, x in enumerate(lying)} | {"air_z": 0.3}
    motion = fb.simulate(s, 1.5, initial=start)
    assert ledger(motion) < 1e-9 and float(motion.energy.kinetic[-1]) < 1e-12
    assert float(motion["air_z"][-1]) == pytest.approx(0.2, abs=1e-9)
    forces = [
        part.normal[-1] for name, part in motion.contacts.items() if "]_" in name and part.mode[-1] != "open"
    ]
    np.testing.assert_allclose(forces, [G / 2, G / 2], rtol=1e-6)


def test_a_ball_rolls_from_a_box_onto_its_edge_as_the_limit_of_time_steps():
    s = fb.System("roll")
    s.gravity = (0, 0, -G)
    ball = s.body("ball", fb.sphere(1, R))
    s.free("air", s.ground, ball)
    s.contacts("touch", [ball.sphere(R)], against=s.ground.box((1, 1, 0.2)), friction=0.6)
    start = {"air_x": 0.45, "air_z": 0.2, "air_vx": 0.3, "air_wy": 3.0}
    motion = fb.simulate(s, 0.3, initial=start)
    assert ledger(motion) < 1e-10
    errors = [
        np.abs(
            fb.simulate(s, 0.3, initial=start, method="timestepping", step=step).states[-1, :7]
            - motion.states[-1, :7]
        ).max()
        for step in (2e-3, 5e-4)
    ]
    assert errors[1] < 0.5 * errors[0] < 5e-3


def test_a_batch_of_patches_is_the_single_runs():
    s = thrown(("ball", "box"))
    speeds, start = np.array([0.0, 0.7, -1.2]), {"ja_z": 0.6, "jb_z": 0.1, "ja_x": 0.1}
    data = fb.simulate(s, 0.6, initial={**start, "ja_vx": speeds}, outputs=["ja_x", "jb_z"], samples=7)
    for k, speed in enumerate(speeds):
        alone = fb.simulate(s, 0.6, initial={**start, "ja_vx": float(speed)}, samples=7)
        for name in ("ja_x", "jb_z"):
            np.testing.assert_array_equal(data[name][k], alone[name])
