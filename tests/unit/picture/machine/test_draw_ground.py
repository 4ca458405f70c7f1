"""Gear wheels: their pitch circles touch."""

from __future__ import annotations

import numpy as np
import pytest

from drawn import groups, scale_of
from freebody.gallery import entries
from freebody.picture.machine.draw import draw


@pytest.mark.parametrize("ratio", [0.4, 1.0, 2.3])
def test_pitch_circles_touch_at_the_pitch_point(ratio: float) -> None:
    s = entries()["two-gears"].build()
    drawing = draw(s, values={"r_2": 0.1 * ratio, "r_1": 0.1})
    circles = []
    for group in groups(drawing, "gear"):
        _, pitch = group.items
        centre = pitch.points[:-1].mean(axis=0)
        radius = float(np.linalg.norm(pitch.points[0] - centre))
        circles.append((centre, radius))
    (a, r), (b, q) = circles
    assert np.linalg.norm(b - a) == pytest.approx(r + q, rel=1e-3)
    assert r / scale_of(drawing) == pytest.approx(0.1, rel=1e-3) and q / r == pytest.approx(ratio, rel=1e-3)
    # between the teeth of a wheel one does not see its disk
    assert all(not g.items for g in groups(drawing, "body"))
