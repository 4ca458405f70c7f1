"""Laws of patches: the gap of convex solids beside an independent computation, its rate, and Newton's third law."""

import numpy as np
import pytest
from scipy.optimize import nnls
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

import freebody as fb
from freebody.motion.kernels.kernels import kernels_of
from freebody.motion.timestepping.memory import memory_of
from freebody.motion.timestepping.stepped_kernels import stepping
from freebody.native import loop

CLOUD = np.random.default_rng(7).normal(size=(12, 3))
SHAPES = {
    "box": (lambda b: b.box((1, 0.6, 0.4)), 0),
    "cube": (lambda b: b.box((0.8, 0.8, 0.8), at=(0.1, 0, 0)), 0),
    "stone": (lambda b: b.hull(0.4 * CLOUD), 0),
    "wedge": (lambda b: b.hull((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 0.7)), 0),
    "capsule": (lambda b: b.capsule((0, 0, -0.4), (0, 0.1, 0.4), 0.2), 0.2),
    "ball": (lambda b: b.sphere(0.3, at=(0, 0.2, 0)), 0.3),
}
PAIRS = [
    ("box", "cube"), ("stone", "box"), ("wedge", "stone"), ("capsule", "box"), ("capsule", "capsule"),
    ("ball", "wedge"), ("box", "ball"), ("capsule", "ball"),
]  # fmt: skip
ROUNDED = 1e-13
"""Error of distances of a size of 1, computed from some hundred products; nearest points are taken up to 1e-9."""


class Pair:
    """Two free bodies with one shape each, and the compiled geometry of their patch."""

    def __init__(self, first, second):
        s = fb.System("two")
        bodies = [s.body(name, fb.sphere(1, 1)) for name in "ab"]
        for body in bodies:
            s.free(f"f{body.name}", s.ground, body)
        self.shapes = [SHAPES[name][0](body) for name, body in zip((first, second), bodies, strict=True)]
        self.radius = SHAPES[first][1] + SHAPES[second][1]
        s.contacts("pair", self.shapes)
        kernels = kernels_of(s)
        program, shape = stepping(kernels)
        self.run, _, self.owned = memory_of(kernels, {}, program, shape, [], 64)
        self.of = self.run.families

    def at(self, places, turns, limit):
        """Return gap and points (place, normal, gap) of the patch at a state."""
        q = np.concatenate(
            [np.r_[p, np.roll(turn.as_quat(), 1)] for p, turn in zip(places, turns, strict=True)]
        )
        self.run.z[: len(q)] = q
        loop.code("motion.families.narrow_phase", "seek")(self.of, 0.0, self.run.z, limit)
        gap = loop.code("motion.families.patches", "measure")(self.of, 0, 1, limit)
        return gap, np.array(self.of.patch.points[: self.of.patch.count])

    def corners(self, places, turns):
        """Return the corners of both cores in ground axes."""
        result = []
        for shape, place, turn in zip(self.shapes, places, turns, strict=True):
            own = shape.corners if shape.patches else (shape.at,)
            result.append(turn.apply(np.array([[float(x) for x in c] for c in own])) + place)
        return result


def distance(A, B):
    """Return the distance of two hulls, or minus the least way that separates them; by the hull of all differences."""
    D = (A[:, None] - B[None]).reshape(-1, 3)
    # min |D'x|, x >= 0, sum x = 1: least squares with the sum as a further row have the same direction
    x, _ = nnls(np.vstack([D.T, np.ones(len(D))]), np.array([0, 0, 0, 1.0]), maxiter=1000)
    apart = float(np.linalg.norm(D.T @ x) / x.sum())
    if apart > 1e-7 or len(A) < 4 or len(B) < 4:
        return apart
    return float(ConvexHull(D).equations[:, 3].max())


@pytest.mark.parametrize(("first", "second"), PAIRS)
def test_the_gap_is_the_distance_of_the_hulls(first, second):
    pair, rng, overlapped = Pair(first, second), np.random.default_rng(3), 0
    for _ in range(400):
        places = [rng.normal(size=3) * 0.2, rng.normal(size=3) * 0.6]
        turns = [Rotation.random(random_state=rng) for _ in "ab"]
        gap, points = pair.at(places, turns, limit=10.0)
        exact = distance(*pair.corners(places, turns))
        if (
            exact > 1e-7
            or "box" in (first, second)
            and exact < 0
            and first in ("box", "stone")
            and second != "ball"
        ):
            assert gap == pytest.approx(exact - pair.radius, abs=2e-9)
        overlapped += gap < 0
        # the deepest point has the gap
        assert len(points) and points[:, 6].min() == pytest.approx(gap, abs=2e-8)
        np.testing.assert_allclose(np.linalg.norm(points[:, 3:6], axis=1), 1, atol=ROUNDED)
    assert overlapped > 40


@pytest.mark.parametrize(("first", "second"), PAIRS)
def test_the_rate_of_the_gap_is_that_of_the_points(first, second):
    pair, rng, compared = Pair(first, second), np.random.default_rng(4), 0
    for _ in range(40):
        places = [rng.normal(size=3) * 0.2, rng.normal(size=3) * 0.7]
        turns = [Rotation.random(random_state=rng) for _ in "ab"]
        v, w = rng.normal(size=(2, 2, 3))
        eps = 1e-6

        def moved(t, v=v, w=w, places=places, turns=turns):
            return (
                [p + t * x for p, x in zip(places, v, strict=True)],
                [Rotation.from_rotvec(t * x) * turn for x, turn in zip(w, turns, strict=True)],
            )

        ends = [pair.at(*moved(t), limit=10.0) for t in (-eps, eps)]
        gap, points = pair.at(places, turns, limit=10.0)
        deepest = points[points[:, 6].argmin()]
        x, n = deepest[:3], deepest[3:6]
        speed = [v[k] + np.cross(w[k], x - places[k]) for k in range(2)]
        measured = (ends[1][0] - ends[0][0]) / (2 * eps)
        curved = abs(ends[1][0] + ends[0][0] - 2 * gap) / eps  # the nearest feature changes in between
        if curved < 1e-4:
            assert n @ (speed[0] - speed[1]) == pytest.approx(measured, abs=1e-4)
            compared += 1
    assert compared > 30


def test_a_face_that_sinks_at_its_edges_has_its_points_where_they_stay_closed():
    """Two edges separate better than the face: with a limit they touch at one point, and others would fall."""
    pair, rng, alone = Pair("box", "cube"), np.random.default_rng(6), 0
    measure_cores = loop.code("motion.families.patches", "measure_cores")
    for _ in range(100):
        place = [np.zeros(3), [0.3 + 0.1 * rng.normal(), 0.2, 0.6]]
        level = Rotation.from_rotvec([0, 0, rng.normal()])
        turns = [Rotation.identity(), Rotation.from_rotvec([*2e-5 * rng.normal(size=2), 0]) * level]
        narrow, points = pair.at(place, turns, 1e-3)
        wide = measure_cores(pair.of, 1, 1e300, 1e-4)
        face = np.array(pair.of.patch.points[: pair.of.patch.count])
        assert wide == narrow
        assert len(face) >= 3 and face[:, 6].min() == pytest.approx(wide, abs=1e-8)
        alone += len(points) == 1
        turns[1] = Rotation.from_rotvec([0.1, 0.1, 0]) * level  # beyond `TILT` it makes no difference
        points = pair.at(place, turns, 1e300)[1]
        measure_cores(pair.of, 1, 1e300, 1e-4)
        np.testing.assert_array_equal(points, pair.of.patch.points[: pair.of.patch.count])
    assert alone > 10


@pytest.mark.parametrize("even", [0.0, 0.02])
def test_what_a_wider_search_leaves_is_what_a_narrower_one_finds(even):
    """Points, gaps and numbers, also where edges and corners beside a face carry; points keep their numbers."""
    pair, rng, compared = Pair("box", "cube"), np.random.default_rng(5), 0
    pairs, y = pair.of.pairs, pair.run.z
    find, nearer, seek = (
        loop.code("motion.families.narrow_phase", name) for name in ("find", "nearer", "seek")
    )

    def found():
        slots = pairs.slots[: pairs.count]
        return pairs.ids[: pairs.count].copy(), pairs.touch[slots].copy()

    for k in range(200):
        flat = Rotation.from_rotvec([0, 0, rng.normal()]) if k % 2 else Rotation.random(random_state=rng)
        tilt = Rotation.from_rotvec(1e-2 * rng.normal(size=3))
        pair.at(
            [np.zeros(3), [0.3, 0.2, 0.6 + 0.02 * rng.normal()]], [Rotation.identity(), tilt * flat], 0.01
        )
        pair.of.patch.even = even
        seek(pair.of, 0.0, y, 0.01)
        ids, touch = found()
        pair.of.patch.even = 0.0
        find(pair.of, 0.0, y, 0.05)
        wide = pairs.ids[: pairs.count].copy()
        pair.of.patch.even = even
        nearer(pair.of, 0.0, y, 0.01)
        again, same = found()
        np.testing.assert_array_equal(again, ids)
        np.testing.assert_array_equal(same, touch)
        assert even or len(ids) <= 1 or set(ids) <= set(wide)
        compared += len(ids)
    assert compared > 100
