"""Panels of a sheet are moved apart, each by as little as its neighbours need."""

import numpy as np

from freebody.picture.free_body.composition import separation
from freebody.picture.paper.sheet import overlap


def test_boxes_that_overlap_are_moved_apart_by_a_gap():
    random = np.random.default_rng(4)
    corners = random.uniform(0, 60, (6, 2))
    boxes = [
        (x, y, x + w, y + h) for (x, y), (w, h) in zip(corners, random.uniform(20, 50, (6, 2)), strict=True)
    ]
    shifts = separation(boxes, 4.0)
    edges = np.array([-2, -2, 2, 2])
    moved = [np.array(box) + np.tile(by, 2) + edges for box, by in zip(boxes, shifts, strict=True)]
    assert max(overlap(a, b) for i, a in enumerate(moved) for b in moved[:i]) <= 1e-6
    np.testing.assert_allclose(np.sum(shifts, axis=0), 0, atol=1e-9)  # each pair moves by equal halves


def test_boxes_that_are_apart_stay():
    assert not np.any(separation([(0, 0, 10, 10), (20, 0, 30, 10)], 8.0))
