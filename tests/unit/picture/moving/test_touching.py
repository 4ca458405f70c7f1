"""Surfaces of the ground in an animation: where contacts touch them, and walls on their other side."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from freebody.describe.shapes.circle import Circle
from freebody.describe.shapes.cylinder import Cylinder
from freebody.describe.shapes.segment import Segment
from freebody.dynamics.state import float_state
from freebody.picture.moving.touching import distinct, surface_parts

X, Z = (1, 0, 0), (0, 0, 1)


@pytest.fixture(scope="module")
def state():
    s = fb.System("drop")
    s.hinge("pin", s.ground, s.body("drop", fb.particle(1)), to=(0, 1, 0), axis="z")
    return float_state(fb.assemble(s))


@pytest.mark.parametrize("inside", [False, True])
@pytest.mark.parametrize(("shape", "height"), [(Circle, 4.0), (Cylinder, None)])
def test_a_round_wall_ends_at_its_radius(state, shape, height, inside):
    """A circle is a ring, four times as wide as thick; a cylinder reaches 0.3 of the size to each side."""
    size = 2.0
    (part,) = surface_parts(state, shape(None, (1, 2, 3), X, 0.5, inside), (-1.0, 1.0), size)
    radii, along = np.array(part["profile"]).T
    wall = radii.max() - radii.min()
    assert (radii.min() if inside else radii.max()) == 0.5 and 0 < wall < 0.02 * size
    assert np.ptp(along) == pytest.approx(0.6 * size if height is None else height * wall)
    assert along.max() == -along.min() and part["at"] == [1, 2, 3]
    w, x, y, z = part["turn"]
    axis = (2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y))  # of the profile: z
    assert axis == pytest.approx(X)


def test_a_side_is_a_rod_between_its_ends(state):
    (part,) = surface_parts(
        state, Segment(None, (0, 0, 0), (3, 4, 0), (0.6, 0.8, 0), (-0.8, 0.6, 0), 5), (0, 1), 1.0
    )
    assert part["length"] == pytest.approx(5) and part.center == pytest.approx([1.5, 2, 0])
    assert part.axes[:, 2] == pytest.approx([0.6, 0.8, 0])


def test_planes_are_drawn_once():
    floor = {"normal": [0, 0, 1], "at": [0, 0, 0]}
    same, above, tilted = (
        {**floor, "at": [5, 6, 0]},
        {**floor, "at": [0, 0, 0.1]},
        {**floor, "normal": [0, 0.6, 0.8]},
    )
    assert distinct([floor, same, above, tilted], 1.0) == [floor, above, tilted]


def test_a_tin_is_shown_by_the_edges_of_its_ends(state):
    s = fb.System("tin")
    wall = s.ground.drum(0.5, 2, axis="x", at=(1, 2, 3), inside=True).members[0]
    parts = surface_parts(state, wall, (-1.0, 1.0), 1.0)
    assert [part["at"] for part in parts] == [[0, 2, 3], [2, 2, 3]]
    for part in parts:
        radii, heights = zip(*part["profile"], strict=True)
        assert min(radii) == 0.5 and max(radii) > 0.5 and max(heights) < 0.1
