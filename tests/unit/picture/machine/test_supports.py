"""What stands still in a drawing, and what only seems to: supports, scenery, hidden frames."""

from __future__ import annotations

import random

import numpy as np
import pytest

import freebody as fb
from drawn import groups, scale_of, texts
from freebody.errors import ModelError
from freebody.gallery import entries
from freebody.picture.machine.draw import draw
from freebody.picture.paper.placing import inside
from freebody.picture.paper.sheet import Circle, Line


@pytest.mark.parametrize("joint", ["ball", "gimbal", "hinge"])
@pytest.mark.parametrize("seed", range(3))
def test_a_joint_that_carries_nothing_has_no_bracket(joint: str, seed: int) -> None:
    """At the mass centre without weight it only counts coordinates; with weight or beside it, it is a support."""
    rng = random.Random(seed)
    inertia = ((2, 0, 0), (0, rng.uniform(2, 3), 0), (0, 0, rng.uniform(2, 3)))
    for offset, g, floats_free in ((0, 0, True), (rng.uniform(0.1, 1), 0, False), (0, 9.81, False)):
        s = fb.System("satellite")
        s.gravity = (0, -g, 0)
        body = s.body("body", fb.MassProperties(rng.uniform(1, 5), (0, 0, 0), inertia), shape=fb.sphere(1, 1))
        getattr(s, joint)(
            "C", s.ground, body, to=(offset, 0, 0), **({"axis": "z"} if joint == "hinge" else {})
        )
        (group,) = groups(draw(s), "joint")
        hatched = len([item for item in group.items if isinstance(item, Line) and not item.closed]) > 2
        assert hatched != floats_free
        assert any(isinstance(item, Circle) for item in group.items)


def test_scenery_is_drawn_in_its_place_and_hatched_inside() -> None:
    s = entries()["prob-6-8"].build()
    drawing = draw(s, at={"theta": "20deg"})
    (group,) = groups(drawing, "scenery")
    outline, *hatching = group.items
    x, y = outline.points.min(axis=0) / scale_of(drawing), outline.points.max(axis=0) / scale_of(drawing)
    assert [*x, *y] == pytest.approx([0, -0.25, 0.625, 0], abs=1e-9)
    middles = np.array([line.points.mean(axis=0) for line in hatching])
    assert len(hatching) > 10 and inside(outline.points, middles).all()
    # the disk stands on the corner O, not in the ledge
    disk = next(g for g in drawing.sheet.root.items if g.attributes.get("data-body") == "disk")
    rim = disk.items[0].points / scale_of(drawing)
    assert np.linalg.norm(rim, axis=1).min() < 0.02 and "$O$" in texts(drawing)


def test_scenery_is_a_solid() -> None:
    s = fb.System("ledge")
    with pytest.raises(ModelError, match="Expected a solid for the scenery of 'ledge'"):
        s.scenery = "ledge"
    s.free("air", s.ground, s.body("ball", fb.sphere(1, 1)))
    s.scenery = fb.box(1, (1, 1, 1))
    assert fb.assemble(s).scenery.kind == "box"
    s.scenery = None
    assert fb.assemble(s).scenery is None


def test_a_hidden_frame_is_not_drawn_but_its_coordinates_are() -> None:
    drawing = draw(entries()["prob-6-10"].build())
    bodies = {g.attributes["data-body"] for g in groups(drawing, "body")}
    assert bodies == {"disk"} and r"$\theta$" in texts(drawing)


def test_a_heightline_is_drawn_through_the_foot_of_a_wheel() -> None:
    """Under the whole wheel, and no farther than to its ends; the dot of the contact lies on the line."""
    s = fb.System("road")
    s.gravity = (0, -9.81, 0)
    wheel = s.body("wheel", fb.disk(1, 0.2))
    s.planar("plane", s.ground, wheel, coordinate="x y turn")
    s.contact("road", wheel.circle(0.2), s.ground.heightline("0.1*cos(3*x)", between=(-0.1, 3)))
    s.contact("far", wheel.circle(0.2), s.ground.heightline("0.2*x", between=(8, 9)))
    drawing = draw(s, at=fb.on_floor(s, initial={"x": 0.05}))
    lines = [item.points for group in groups(drawing, "plane") for item in group.items]
    line, other = sorted(lines, key=len)[-1:-3:-1]
    assert len(line) > 20 > len(other)
    (dot,) = groups(drawing, "contact")
    scale = scale_of(drawing)
    at = dot.items[0].center
    assert np.abs(line - at).sum(axis=1).min() < 0.02 * scale
    foot = 0.05
    for _ in range(50):  # foot - R f'/w = 0.05
        foot = 0.05 + 0.2 * (slope := -0.3 * np.sin(3 * foot)) / np.hypot(1, slope)
    assert (at[0] - line[:, 0].min()) / scale == pytest.approx(foot + 0.1, abs=1e-6)
    assert line[:, 0].max() > at[0] + (0.25 - foot) * scale
