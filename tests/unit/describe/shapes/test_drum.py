"""Cylinders with ends on planes: where they stand, slide, roll and tip, in closed form."""

import math

import numpy as np
import pytest

import freebody as fb
from freebody.errors import ModelError

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
