"""Cylinders with ends on planes: where they stand, slide, roll and tip, in closed form."""

import math

import numpy as np
import pytest

import freebody as fb
from freebody.errors import FormatError, ModelError

G, R, L = 9.81, 0.03, 0.1


def can(slope=0.0, **law):
    """Return a can on a floor that falls towards x."""
    s = fb.System("can")
    s.gravity = (G * math.sin(slope), 0, -G * math.cos(slope))
    body = s.body("can", fb.cylinder(0.3, R, L))
    s.free("air", s.ground, body)
    s.contact("table", body.drum(R, L), s.ground.plane(normal="z"), **law)
    return s


def test_a_can_on_its_side_rolls_down_a_slope():
    """It rolls with x" = 2/3 g sin α about the axis z of the body, which is turned into y."""
    start = {"air_e0": math.sqrt(0.5), "air_e1": math.sqrt(0.5), "air_z": R}
    motion = fb.simulate(can(0.2, friction=0.5), 1, initial=start)
    assert motion["air_x"][-1] == pytest.approx(G * math.sin(0.2) / 3, rel=1e-9)
    assert {m.mode for m in motion.modes if m.contact in ("table_1", "table_2")} == {"stick"}


@pytest.mark.parametrize(("beyond", "falls"), [(0.99, False), (1.01, True)])
def test_a_can_tips_where_its_weight_passes_the_edge(beyond, falls):
    """Tan α = 2 R/L; the point of the end that is farthest down is one of those on which it stands."""
    s = can(math.atan(beyond * 2 * R / L), friction=2)
    motion = fb.simulate(s, 0.3, initial={"air_z": L / 2})
    assert (abs(motion["air_wy"]).max() > 0.01) == falls


def test_a_drum_is_written_and_read(tmp_path):
    s = can(friction=0.4)
    fb.write(s, tmp_path / "can.toml")
    assert 'shape = "drum", radius = 0.03, length = 0.1' in (tmp_path / "can.toml").read_text()
    again = fb.read(tmp_path / "can.toml")
    assert [c.name for c in fb.assemble(again).contacts] == [c.name for c in fb.assemble(s).contacts]


def test_drums_are_a_family_against_planes():
    s = fb.System("cans")
    s.gravity = (0, 0, -G)
    bodies = [s.body(f"c{i}", fb.cylinder(0.3, R, L)) for i in (1, 2)]
    for i, body in enumerate(bodies):
        s.free(f"f{i}", s.ground, body)
    s.contacts("floor", [b.drum(R, L) for b in bodies], against=s.ground.plane(normal="z"), friction=0.4)
    motion = fb.simulate(s, 0.1, initial={"f0_z": L / 2, "f1_z": R, "f1_e0": 1, "f1_e1": 1, "f1_x": 1})
    side = sum(float(motion.contacts[f"floor[c2.{k},ground]"].normal[-1]) for k in (1, 2))
    assert side == pytest.approx(0.3 * G, rel=1e-12)


def test_drums_on_what_has_no_law_are_refused():
    s = can()
    drum, brick = s.bodies["can"].drum(R, L), s.body("brick", fb.box(1, (R, R, R)))
    s.free("flight", s.ground, brick)
    with pytest.raises(
        ModelError,
        match="The drum and the box of contact 'c' are not a supported pair. A drum may touch a plane or sphere.",
    ):
        s.contact("c", drum, brick.box((R, R, R)))
    with pytest.raises(ModelError, match="The drum of contact 'b' cannot touch a sphere from inside."):
        s.contact("b", drum, s.ground.sphere(1, inside=True))
    with pytest.raises(
        ModelError, match="Expected a size of more than 0 for the drum of body 'can', got -1."
    ):
        s.bodies["can"].drum(R, -1)


@pytest.mark.parametrize("seed", [0, 1])
def test_thrown_cans_keep_their_energy_by_events(seed):
    """What stands on an end and what lies on its side touches at different points: never at both."""
    rng = np.random.default_rng(seed)
    turn, spin = rng.normal(size=4), rng.normal(size=3) * 6
    start = {f"air_e{k}": float(x) for k, x in enumerate(turn / np.linalg.norm(turn))}
    start |= {f"air_w{k}": float(x) for k, x in zip("xyz", spin, strict=True)}
    motion = fb.simulate(
        can(friction=0.4, restitution=0.2), 1, initial={**start, "air_z": 0.2, "air_vx": 0.5}
    )
    assert motion.energy.relative_residual < 1e-9
    lies = [motion.contacts[f"table_{end}"].normal > 0 for end in (1, 2)]
    stands = [motion.contacts[f"table_{end}_{k}"].normal > 0 for end in (1, 2) for k in (1, 2, 3, 4)]
    assert np.any(lies, axis=0).any()
    assert not (np.any(lies, axis=0) & np.any(stands, axis=0)).any()


def on_a_drum(axis="z", **law):
    """Return a ball on a drum of the ground."""
    s = fb.System("ball on a drum")
    s.gravity = (0, 0, -G)
    ball = s.body("ball", fb.sphere(1, BALL))
    s.free("air", s.ground, ball)
    s.contact("drum", ball.sphere(BALL), s.ground.drum(RADIUS, LENGTH, axis=axis), **law)
    return s


BALL, RADIUS, LENGTH = 0.1, 0.3, 1.0


def test_the_gap_of_a_sphere_and_a_drum_is_the_distance_to_its_solid():
    """Beside the wall, over an end and beside the rim, also on the axis; the drum is the surface or the feature."""
    rng = np.random.default_rng(0)
    s, tried = on_a_drum(), 0
    s.contact("turned", s.ground.drum(RADIUS, LENGTH), s.bodies["ball"].sphere(BALL))
    for x, y, z in (*rng.normal(size=(15, 3)), (0, 0, 2), (RADIUS, 0, 1), (1, 0, LENGTH / 2)):
        distance = math.hypot(max(abs(z) - LENGTH / 2, 0), max(math.hypot(x, y) - RADIUS, 0))
        if distance > BALL:
            motion = fb.simulate(s, 1e-9, initial={"air_x": x, "air_y": y, "air_z": z})
            gaps = [motion.contacts[name].gap[0] for name in ("drum", "turned")]
            assert gaps == pytest.approx([distance - BALL] * 2, abs=1e-14)
            tried += 1
    assert tried > 10


def test_a_ball_slides_over_the_rim_of_a_drum_and_leaves_it():
    """N = m (g cos φ - v²/r) about the rim: it flies from cos φ = (2 + v₀²/(g r))/3 on."""
    v = 0.4
    motion = fb.simulate(
        on_a_drum(), 1, initial={"air_z": LENGTH / 2 + BALL, "air_x": RADIUS - 0.1, "air_vx": v}
    )
    leaves = next(m for m in motion.modes if m.mode == "open")
    cosine = (2 + v**2 / (G * BALL)) / 3
    at = motion.at(leaves.start)
    assert at["air_z"] == pytest.approx(LENGTH / 2 + BALL * cosine, abs=1e-9)
    assert at["air_x"] == pytest.approx(RADIUS + BALL * math.sqrt(1 - cosine**2), abs=1e-9)
    on_end = motion["air_x"] < RADIUS
    assert motion.contacts["drum"].normal[on_end] == pytest.approx(G, abs=1e-9)
    assert motion.energy.relative_residual < 1e-9


@pytest.mark.parametrize(
    ("near", "how"), [(1e-9, {}), (1e-4, {"method": "timestepping", "step": 1e-3})], ids=["events", "steps"]
)
def test_a_ball_rolls_along_a_drum_that_lies(near, how):
    """It slides for 2 v/(7 μ g) and keeps 5/7 of its speed along the top of the wall, alone and in a family."""
    s = on_a_drum(axis="x", friction=0.5)
    s.contacts("again", [s.ground.drum(RADIUS, LENGTH, axis="x", at=(0, 5, 0)), s.bodies["ball"].sphere(BALL)],
               friction=0.5)  # fmt: skip
    for y, name in ((0, "drum"), (5, "again[ground,ball]")):
        start = {"air_z": RADIUS + BALL, "air_vx": 0.7, "air_y": y, "air_x": -0.2}
        motion = fb.simulate(s, 0.3, initial=start, **how)
        slides = 2 * 0.7 / (7 * 0.5 * G)
        x = -0.2 + 0.7 * slides - 0.5 * G * slides**2 / 2 + 0.5 * (0.3 - slides)
        assert motion["air_x"][-1] == pytest.approx(x, abs=near)
        assert motion["air_z"][-1] == pytest.approx(RADIUS + BALL, abs=1e-9)
        assert motion.contacts[name].normal[-1] == pytest.approx(G, rel=1e-9)


# -- tins ---------------------------------------------------------------------------------------

INNER, DEEP = 0.3, 0.5
SIZE = (0.1, 0.2, 0.12)
STEPS = {"method": "timestepping", "step": 2e-3}


def in_a_tin(kind="box", axis="z", family=False, hollow=None, **laws):
    """Return a body in a tin of the ground."""
    s = fb.System("tin")
    s.gravity = (0, 0, -G)
    body = s.body("b", fb.box(1, SIZE))
    s.free("f", s.ground, body)
    ends = (-0.06, 0, 0), (0.06, 0, 0)
    shape = {
        "point": lambda: body.point(0.01, 0.02, 0), "sphere": lambda: body.sphere(0.05),
        "box": lambda: body.box(SIZE), "corners": lambda: body.corners(size=SIZE),
        "capsule": lambda: body.capsule(*ends, 0.04), "segment": lambda: body.segment(*ends, normal="z"),
    }[kind]()  # fmt: skip
    tin = hollow(s) if hollow else s.ground.drum(INNER, DEEP, axis=axis, inside=True)
    if family:
        s.contacts("tin", [shape, tin], **laws)
    else:
        s.contact("tin", shape, tin, **laws)
    return s


def test_the_gaps_in_a_tin_are_the_distances_to_its_wall_and_ends():
    rng = np.random.default_rng(1)
    s = in_a_tin("sphere")
    for x, y, z in rng.uniform(-0.15, 0.15, size=(5, 3)).tolist():
        motion = fb.simulate(s, 1e-9, initial={"f_x": x, "f_y": y, "f_z": z})
        gaps = [motion.contacts[f"tin_{k}"].gap[0] for k in (1, 2, 3)]
        wanted = [INNER - math.hypot(x, y), DEEP / 2 + z, DEEP / 2 - z]
        assert gaps == pytest.approx([distance - 0.05 for distance in wanted], abs=1e-14)


THROWN = {"f_vx": 0.8, "f_vy": 0.5, "f_wx": 1.0, "f_wz": 0.5}


@pytest.mark.parametrize(
    ("kind", "options"),
    [
        ("box", STEPS),
        ("capsule", STEPS),
        ("sphere", {}),
        *(pytest.param(kind, {}, marks=pytest.mark.slow) for kind in ("point", "box", "capsule", "segment")),
        *(pytest.param(kind, STEPS, marks=pytest.mark.slow) for kind in ("point", "sphere", "segment")),
    ],
)
def test_bodies_thrown_in_a_tin_stay_in_it(kind, options):
    """One by one and in a family: the same motion, no gap below zero, the ledger of energy closes."""
    found = []
    for family in (False, True):
        s = in_a_tin(kind, family=family, friction=0.3, restitution=0.4)
        motion = fb.simulate(s, 1, initial=THROWN, **options)
        assert motion.energy.relative_residual < 1e-9
        found.append(motion)
    one, other = found
    allowed = (
        1e-5 if options else 1e-300
    )  # by events to the bit; impacts at corners multiply the residual of a step
    assert np.abs(one.states - other.states).max() < allowed
    assert min(float(c.gap.min()) for c in one.contacts.values()) > -1e-9
    assert any((c.normal > 0).any() for c in one.contacts.values())


def test_a_box_rests_on_four_corners_on_the_wall_and_swings_like_a_pendulum():
    """N = m g/(4 cos β), sin β = a/(2 R); without friction θ" = -m g l sin θ/(m l² + J)."""
    s = in_a_tin(axis="x")
    b, l = math.asin(SIZE[1] / 2 / INNER), math.sqrt(INNER**2 - SIZE[1] ** 2 / 4) - SIZE[2] / 2  # noqa: E741
    motion = fb.simulate(s, 0.1, initial={"f_z": -l})
    forces = [float(c.normal[-1]) for c in motion.contacts.values() if c.normal[-1] > 0]
    assert forces == pytest.approx([G / 4 / math.cos(b)] * 4, rel=1e-12)
    J, first = (SIZE[1] ** 2 + SIZE[2] ** 2) / 12, 0.2
    start = {"f_z": -l * math.cos(first), "f_y": l * math.sin(first)}
    start |= {"f_e0": math.cos(first / 2), "f_e1": math.sin(first / 2)}
    motion = fb.simulate(s, 1, initial=start)
    at = motion.at(1)
    speed = at["f_wx"]
    energy = speed**2 * (l * l + J) / 2 - G * l * math.cos(2 * math.atan2(at["f_e1"], at["f_e0"]))
    assert energy == pytest.approx(-G * l * math.cos(first), rel=1e-9)
    assert at["f_y"] == pytest.approx(l * math.sin(2 * math.atan2(at["f_e1"], at["f_e0"])), abs=1e-9)


def test_a_pile_of_boxes_in_a_tin():
    """Boxes touch each other in patches, and the tin by their corners."""
    s = fb.System("pile")
    s.gravity = (0, 0, -G)
    bodies = [s.body(f"b{k}", fb.box(1, SIZE)) for k in range(3)]
    start = {}
    for k, body in enumerate(bodies):
        s.free(f"f{k}", s.ground, body)
        start |= {f"f{k}_z": 0.14 * (k - 1), f"f{k}_vx": 1.0 - k}
    s.contacts("pile", [*(b.box(SIZE) for b in bodies), s.ground.drum(0.2, DEEP, inside=True)], friction=0.4)
    motion = fb.simulate(s, 0.5, initial=start, samples=26, **STEPS)
    assert motion.energy.relative_residual < 1e-12 and motion.depth < 1e-9
    for k in range(3):
        at = motion.at(0.5)
        assert math.hypot(at[f"f{k}_x"], at[f"f{k}_y"]) < 0.2


def test_boxes_touch_bowls_and_pipes_with_their_corners():
    """On a pipe like on a tin; in a bowl all four normals meet in its middle, and their forces are open."""
    for hollow, h in (
        (lambda s: s.ground.cylinder(INNER, inside=True, axis="x"), SIZE[1] / 2),
        (lambda s: s.ground.sphere(INNER, inside=True), math.hypot(*SIZE[:2]) / 2),
    ):
        s, l = in_a_tin(hollow=hollow), math.sqrt(INNER**2 - h**2) - SIZE[2] / 2  # noqa: E741
        motion = fb.simulate(s, 0.1, initial={"f_z": -l})
        forces = [float(c.normal[-1]) for c in motion.contacts.values() if c.mode[-1] != "open"]
        assert motion["f_z"][-1] == pytest.approx(-l, abs=1e-12) and len(forces) == 4
        if h == SIZE[1] / 2:
            assert forces == pytest.approx([G / 4 / math.sqrt(1 - (h / INNER) ** 2)] * 4, rel=1e-12)
        else:
            assert np.isnan(forces).all()


def test_a_tin_is_written_and_read(tmp_path):
    s = in_a_tin(axis="x", friction=0.4)
    fb.write(s, tmp_path / "tin.toml")
    assert 'length = 0.5, axis = "x", inside = true' in (tmp_path / "tin.toml").read_text()
    again = fb.read(tmp_path / "tin.toml")
    assert [c.name for c in fb.assemble(again).contacts] == [c.name for c in fb.assemble(s).contacts]
    with pytest.raises(FormatError, match="bodies of such a file touch planes of the ground"):
        fb.write(s, tmp_path / "tin.mjcf")


def test_what_does_not_fit_in_a_tin_is_refused():
    s = can()
    tin, body = s.ground.drum(1, 1, inside=True), s.bodies["can"]
    with pytest.raises(ModelError, match="The drum of contact 'c' cannot touch a drum from inside."):
        s.contact("c", body.drum(R, L), tin)
    with pytest.raises(ModelError, match="The plane of contact 'c' cannot touch a drum from inside."):
        s.contact("c", body.plane(normal="z"), tin)
    with pytest.raises(
        ModelError, match="The feature of contact 'c' is the inside of a drum. Exchange feature"
    ):
        s.contact("c", tin, body.point(0, 0, 0))
    with pytest.raises(ModelError, match="has the radius 2 and does not fit inside a drum of radius 1"):
        s.contact("c", body.sphere(2), tin)
