"""A bushing on a plane joint: its force across the plane is zero, which is no arrow, and slides take arrays."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb


def test_it_is_drawn_and_linearized_along_a_motion():
    s = fb.System("mount")
    block = s.body("block", fb.box(80, (0.6, 0.5, 0.4)))
    s.planar("plane", s.ground, block, coordinate="x y turn")
    places = s.ground.point(-0.2, -0.3, 0), block.point(-0.2, -0.3, 0)
    s.bushing("rubber", *places, stiffness=(4e4, 9e4, 4e4), turning_stiffness=(300, 300, 300))
    motion = fb.simulate(s, 0.1, initial={"x": 0.01})
    drawing = fb.draw(s, trajectory=motion, at=0.05).svg
    assert drawing.count('data-load="rubber"') == 3 and "nan" not in drawing  # x, y, and the couple
    linear = fb.linearize(s, about=motion, values={})
    assert linear.K[0][:2, :2] == pytest.approx(np.diag([4e4, 9e4]), rel=1e-9, abs=1e-6)
