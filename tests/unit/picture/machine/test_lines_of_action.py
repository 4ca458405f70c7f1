"""A force and a couple that are a force on a fixed line are drawn on that line."""

from __future__ import annotations

import random

import numpy as np
import pytest
import sympy

import freebody as fb
from drawn import PLACED, groups, scale_of, texts
from freebody.picture.machine.draw import draw
from freebody.picture.paper.sheet import Arrow


@pytest.mark.parametrize("seed", range(4))
def test_a_force_and_a_couple_are_drawn_on_their_line(seed: int) -> None:
    """The line of the arrow is at the height h above the floor on paper, and h is dimensioned."""
    rng = random.Random(seed)
    radius, height = rng.uniform(0.2, 0.5), rng.uniform(0.02, 0.9)
    s = fb.System("pulled")
    R, h, F = s.parameters(R=radius, h=height, F=3.0)
    s.gravity = (0, -9.81, 0)
    disk = s.body("disk", fb.disk(1, R))
    s.planar("plane", s.ground, disk, at=(0, R, 0), coordinate="x y phi")
    s.contact("floor", disk.circle(R), s.ground.plane(), friction=1)
    s.force("F", disk.origin, (F, 0, 0))
    s.torque("moved", disk, (0, 0, -F * (h - R)))
    drawing = draw(s)
    (load,) = groups(drawing, "load")
    (arrow,) = load.items
    assert arrow.points[:, 1] == pytest.approx(scale_of(drawing) * height, abs=PLACED * scale_of(drawing))
    (group,) = (g for g in groups(drawing, "dimension") if g.attributes.get("data-load") == "moved")
    (line,) = (item for item in group.items if isinstance(item, Arrow))
    assert np.ptp(line.points[:, 1]) == pytest.approx(scale_of(drawing) * height)
    assert group.attributes["data-symbol"] == "h" and "$F$" in texts(drawing)


def test_a_couple_of_its_own_is_drawn_as_one() -> None:
    """A couple that is no constant arm times the force stays a couple."""
    s = fb.System("turned")
    F, T = s.parameters(F=3.0, T=1.0)
    disk = s.body("disk", fb.disk(1, 1))
    s.planar("plane", s.ground, disk, coordinate="x y phi")
    s.force("F", disk.origin, (F, 0, 0))
    s.torque("T", disk, (0, 0, T * sympy.cos(s.expression("phi"))))
    assert {g.attributes["data-load"] for g in groups(draw(s), "load")} == {"F", "T"}
