"""Tilts of hinge lines in space, as projected."""

from __future__ import annotations

import math

import pytest

from drawn import groups, view_of
from freebody.gallery import entries
from freebody.picture.machine.draw import draw


@pytest.mark.parametrize("tilt", [10.0, 35.0])
def test_the_tilt_of_a_hinge_line_is_its_angle_from_the_vertical(tilt: float) -> None:
    s = entries()["prob-6-5"].build()
    drawing = draw(s, values={"alpha": math.radians(tilt)})
    (group,) = groups(drawing, "inclination")
    # the two sides are projections of unit vectors along the hinge line and along the vertical
    first, second = (item.points[1] - item.points[0] for item in group.items[:2])
    matrix = view_of(drawing)
    axis = matrix @ [-math.sin(math.radians(tilt)), math.cos(math.radians(tilt)), 0]
    up = matrix @ [0, 1, 0]
    assert first / second[1] * up[1] == pytest.approx(axis) and second[0] == pytest.approx(0, abs=1e-9)
