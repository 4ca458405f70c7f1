"""Places of patches: their gaps are those of the patch, and they change where the patch does."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import freebody as fb
from freebody.motion.contact.state import ContactRun
from freebody.motion.kernels.kernels import kernels_of

SHAPES = {
    "box": lambda b: b.box((1, 0.6, 0.4)),
    "cube": lambda b: b.box((0.8, 0.8, 0.8), at=(0.1, 0, 0)),
    "wedge": lambda b: b.hull((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 0.7)),
}


def run_of(first, second):
    s = fb.System("two")
    bodies = [s.body(name, fb.sphere(1, 1)) for name in "ab"]
    for body in bodies:
        s.free(f"f{body.name}", s.ground, body)
    s.contacts("pair", [SHAPES[name](body) for name, body in zip((first, second), bodies, strict=True)])
    kernels = kernels_of(s).unrolled()
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


@pytest.mark.parametrize(("first", "second"), [("box", "cube"), ("box", "wedge")])
def test_a_place_has_the_gap_and_the_rate_of_the_patch(first, second):
    run, rng, kinds = run_of(first, second), np.random.default_rng(1), set()
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
        kinds.add(run.patches.pairs[0].kinds[deepest])
        assert seen.gap[deepest] == pytest.approx(found[:, 6].min(), abs=1e-9)
        # apart along the way by d, the gap grows by n·d; and the row of the place is its derivative
        step, first_row = 1e-7, run.scene.first[deepest]
        moved = y.copy()
        moved[7:10] += step * way
        speeds = np.zeros(12)
        # the speed of a free body is in its own axes
        speeds[9:] = Rotation.from_quat(np.roll(y[10:14], -1)).inv().apply(way)
        rate = seen.matrix[first_row] @ speeds
        assert (run.look(0.0, moved, values).gap[deepest] - seen.gap[deepest]) / step == pytest.approx(
            rate, abs=1e-6
        )
        run.patches.places[0].clear()
        for names in run.patches.pairs[0].names:
            run.patches.values.update({name: 0.0 for name in names if name.endswith("used")})
    assert len(kinds) >= 2  # corners on faces, and edges on edges


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
