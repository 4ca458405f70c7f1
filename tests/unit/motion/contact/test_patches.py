"""Places of patches: their gaps are those of the patch, and they change where the patch does."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import freebody as fb
from freebody.errors import SimulationError
from freebody.model.patched import CORNER_ON_EDGE, EDGE_ON_CORNER
from freebody.motion.contact.state import ContactRun
from freebody.motion.kernels.kernels import kernels_of

SHAPES = {
    "box": lambda b: b.box((1, 0.6, 0.4)),
    "cube": lambda b: b.box((0.8, 0.8, 0.8), at=(0.1, 0, 0)),
    "wedge": lambda b: b.hull((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 0.7)),
    "ball": lambda b: b.sphere(0.3, at=(0, 0.2, 0)),
    "pill": lambda b: b.capsule((0, 0, -0.4), (0, 0.1, 0.4), 0.2),
    "pin": lambda b: b.capsule((0, 0, -0.4), (0, 0, 0.4), 0.2),
}


def run_of(first, second):
    s = fb.System("two")
    bodies = [s.body(name, fb.sphere(1, 1)) for name in "ab"]
    for body in bodies:
        s.free(f"f{body.name}", s.ground, body)
    s.contacts("pair", [SHAPES[name](body) for name, body in zip((first, second), bodies, strict=True)])
    kernels = kernels_of(s).by_events()
    return ContactRun(kernels, kernels.model.values({}))


def touching(run, rng):
    """Return a state in which the solids touch: the second one is moved along the axis between them."""
    patches, y = run.patches, np.zeros(26)
    y[3:7], y[10:14] = (np.roll(Rotation.random(random_state=rng).as_quat(), 1) for _ in "ab")
    way = rng.normal(size=3)
    way /= np.linalg.norm(way)
    low, high = 0.0, 5.0
    for _ in range(60):
        middle = (low + high) / 2
        y[7:10] = middle * way
        patches.look(0.0, y)
        it = patches.it
        gap = patches.functions["measure"](it.families, it.first[0], it.second[0], np.inf)
        low, high = (low, middle) if gap > 0 else (middle, high)
    return y, way


def moving(y, u, h):
    """Return the state of two free bodies after a time h from y with speeds u, each in its own axes."""
    result = y.copy()
    for at, way in ((0, 0), (7, 6)):
        w, v = u[way : way + 3], u[way + 3 : way + 6]
        turn = Rotation.from_quat(np.roll(y[at + 3 : at + 7], -1))
        result[at : at + 3] += h * turn.apply(v)
        result[at + 3 : at + 7] = np.roll((turn * Rotation.from_rotvec(h * w)).as_quat(), 1)
    return result


@pytest.mark.parametrize(
    ("first", "second", "kinds"),
    [
        ("box", "cube", 2), ("box", "wedge", 2), ("ball", "box", 3), ("wedge", "ball", 3), ("pill", "box", 4),
        ("wedge", "pill", 4), ("pill", "pill", 4),
    ],
)  # fmt: skip
def test_a_place_has_the_gap_and_the_rate_of_the_patch(first, second, kinds):
    run, rng, seen_kinds = run_of(first, second), np.random.default_rng(1), set()
    for _ in range(60):
        y, way = touching(run, rng)
        y[14:] = rng.normal(size=12)
        assert run.patches.changed(0.0, y)
        values = run.kernels.parameters(run.patches.values)
        (places,) = run.patches.places
        found = run.patches.it.families.patch.points[: run.patches.it.families.patch.count]
        seen = run.look(0.0, y, values)
        used = seen.reach > 0
        assert sorted(np.flatnonzero(used)) == sorted(places)
        deepest = min(places, key=lambda k: seen.gap[k])
        seen_kinds.add(run.patches.pairs[0].kinds[deepest])
        assert seen.gap[deepest] == pytest.approx(found[:, 6].min(), abs=1e-9)
        # the row of the place is the derivative of its gap along any motion
        for u in (rng.normal(size=12), rng.normal(size=12)):
            gaps = [run.look(0.0, moving(y, u, h), values).gap[deepest] for h in (-1e-5, 1e-5)]
            rate = seen.matrix[run.scene.first[deepest]] @ u
            assert (gaps[1] - gaps[0]) / 2e-5 == pytest.approx(rate, abs=1e-7)
        run.patches.places[0].clear()
        for names in run.patches.pairs[0].names:
            run.patches.values.update({name: 0.0 for name in names if name.endswith("used")})
    assert len(seen_kinds) >= kinds


@pytest.mark.parametrize(("first", "second"), [("ball", "box"), ("pill", "box"), ("pill", "pill")])
def test_the_order_of_two_solids_does_not_matter(first, second):
    run, turned, rng = run_of(first, second), run_of(second, first), np.random.default_rng(2)
    for _ in range(20):
        y, _ = touching(run, rng)
        other = np.r_[y[7:14], y[:7], np.zeros(12)]
        gaps, rows = [], []
        for one, state in ((run, y), (turned, other)):
            one.patches.changed(0.0, state)
            seen = one.look(0.0, state, one.kernels.parameters(one.patches.values))
            deepest = min(one.patches.places[0], key=lambda k: seen.gap[k])
            gaps.append(seen.gap[deepest])
            rows.append(seen.matrix[one.scene.first[deepest]])
        assert gaps[0] == pytest.approx(gaps[1], abs=1e-12)
        np.testing.assert_allclose(rows[0], np.r_[rows[1][6:], rows[1][:6]], atol=1e-9)


def test_parallel_capsules_touch_at_the_ends_of_what_they_have_in_common():
    run = run_of("pin", "pin")
    y = np.zeros(26)
    y[3] = y[10] = 1
    y[7:10] = 0, 0.4, 0.3  # beside each other, 0.5 of their lengths
    assert run.patches.changed(0.0, y)
    (places,) = run.patches.places
    assert {run.patches.pairs[0].kinds[place] for place in places} == {CORNER_ON_EDGE, EDGE_ON_CORNER}
    seen = run.look(0.0, y, run.kernels.parameters(run.patches.values))
    np.testing.assert_allclose(seen.gap[list(places)], 0, atol=1e-15)
    y[7] = 1e-3
    run.patches.look(0.0, y)
    assert run.patches.functions["follow"](run.patches.it) == -1  # both stay


def test_the_features_are_kept_until_the_patch_has_other_ones():
    run = run_of("box", "cube")
    y = np.zeros(26)
    y[3] = y[10] = 1
    y[7:10] = -0.05, 0, 0.6  # the cube on the box, over both of its ends in y
    patches, it = run.patches, run.patches.it
    assert patches.changed(0.0, y) and not patches.changed(0.0, y)
    follow = patches.functions["follow"]
    assert follow(it) == -1 and it.result[1] == 1
    y[7] += 1e-3
    patches.look(0.0, y)
    assert follow(it) == -1  # it slides, and its edges cross those of the box elsewhere
    y[7] += 0.3
    patches.look(0.0, y)
    assert follow(it) == 0 and it.result[1] == -1  # two corners are beyond the end of the box
    assert patches.changed(0.0, y)
    assert follow(it) == -1


def test_a_pair_that_is_apart_has_no_places():
    run = run_of("box", "cube")
    y = np.zeros(26)
    y[3] = y[10] = 1
    y[9] = 0.7
    patches = run.patches
    assert not patches.changed(0.0, y)
    patches.functions["follow"](patches.it)
    assert patches.it.result[0] == pytest.approx(0.1, abs=1e-15) and patches.it.used[0] == -1
    assert (run.look(0.0, y, run.parameters).reach < 0).all()


def test_solids_that_have_sunk_into_each_other_are_refused():
    """As where a place was passed over; their features could go on, and nothing else would tell."""
    run = run_of("box", "cube")
    y = np.zeros(26)
    y[3] = y[10] = 1
    y[7:10] = -0.05, 0, 0.6  # the cube on the box
    assert run.patches.changed(0.0, y)
    y[7:10] = 0.25, 0, 0.6 - 1e-3  # beyond the end of the box
    message = (
        r"solids of 'pair\[a,b\]' are 0.001 m in each other at t = 0.2 s: a place where they touch was passed"
    )
    with pytest.raises(SimulationError, match=message):
        run.patches.changed(0.2, y)
    y[7] = -0.05  # also with the same features
    with pytest.raises(SimulationError, match="0.001 m in each other"):
        run.patches.changed(0.2, y)


@pytest.mark.parametrize("closed", [True, False])
def test_an_edge_almost_flat_on_a_face_keeps_the_crossing_at_which_it_is_closed(closed):
    """Its other end comes down: the patch has one crossing of the two sides of the face, that which is deeper."""
    run = run_of("box", "cube")
    patches, it, y = run.patches, run.patches.it, np.zeros(26)
    upright = Rotation.from_rotvec([0, np.pi / 4, 0])  # an edge of the cube, along y, is below

    def tilted(angle, height):
        turn = Rotation.from_rotvec([angle, 0, 0]) * upright
        y[3], y[10:14] = 1, np.roll(turn.as_quat(), 1)
        y[7:10] = [0, 0, 0.4 * np.sqrt(2) + height] - turn.apply([0.1, 0, 0])
        patches.look(0.0, y)
        return patches._gap(0)

    def touching(angle):
        height = 0.5
        for _ in range(4):
            height -= tilted(angle, height) / np.cos(angle)
        return tilted(angle, height)

    assert abs(touching(1e-3)) < 1e-15 and patches.changed(0.0, y)
    (first,) = patches.places[0].values()
    it.mode[it.contact[0]] = int(closed)
    assert abs(touching(-1e-9)) < 1e-9 and patches.changed(0.1, y)
    places = list(patches.places[0].values())
    assert len(places) == 1 + closed and (first in places) == closed and len(set(places)) == len(places)
    assert patches.functions["follow"](it) == -1
    it.mode[:] = 0
    touching(-0.5)  # far from the side on which it was
    patches.changed(0.2, y)
    assert first not in patches.places[0].values()


def test_a_tie_of_features_is_decided_once():
    """A corner of a tilted cube passes the edge of a box: at one moment corrections move it back and forth."""
    for seed in range(6):
        run, rng = run_of("box", "cube"), np.random.default_rng(seed)
        tilt = Rotation.from_rotvec([*1e-3 * rng.normal(size=2), rng.uniform(0.2, 1.2)])
        corners = tilt.apply(0.4 * np.array([(x, y, -1) for x in (-1, 1) for y in (-1, 1)]) + [0.1, 0, 0])
        lowest, y = corners[corners[:, 2].argmin()], np.zeros(26)
        y[3], y[10:14] = 1, np.roll(tilt.as_quat(), 1)
        y[7:10] = np.array([0, 0.3 * np.sign(lowest[1]), 0.2]) - lowest  # the corner on an edge of the top
        inside, outside = y.copy(), y.copy()
        inside[8] -= 1e-6 * np.sign(lowest[1])
        outside[8] += 1e-6 * np.sign(lowest[1])
        before = features_at(run, inside)
        while (middle := (inside[8] + outside[8]) / 2) not in (inside[8], outside[8]):
            (inside if features_at(run, [*y[:8], middle, *y[9:]]) == before else outside)[8] = middle
        patches = run.patches
        patches.changed(0.0, inside)
        changes = [patches.changed(1.0, (inside, outside)[k % 2]) for k in range(12)]
        assert sum(changes) == 2  # the features outside, then those inside with what stays of the others


def features_at(run, y):
    """Return the features of the patch of a pair at a state."""
    run.patches.look(0.0, y)
    it = run.patches.it
    run.patches.functions["measure"](it.families, it.first[0], it.second[0], 2 * it.limit[0])
    patch = it.families.patch
    return {tuple(one) for one in patch.features[: 4 * patch.count].reshape(-1, 4).tolist()}
