"""Gear wheels: their pitch circles touch; rings, racks, and lines of teeth in space."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from drawn import groups, scale_of, view_of
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


def pair(axes, places, ratio, **angles):
    s = fb.System("pair")
    one, two = s.body("one", fb.disk(1, 0.1, axis=axes[0])), s.body("two", fb.disk(1, 0.2, axis=axes[1]))
    first = s.hinge("first", s.ground, one, at=places[0], axis=axes[0], coordinate="p")
    second = s.hinge("second", s.ground, two, at=places[1], axis=axes[1], coordinate="q")
    s.gear(first, second, ratio, name="mesh", **angles)
    return s


def test_a_ring_has_no_fill_and_is_drawn_before_the_wheel_that_turns_in_it() -> None:
    s = fb.System("inner")
    one, ring = s.body("one", fb.disk(1, 0.1)), s.body("ring", fb.ring(1, 0.3))
    first = s.hinge("first", s.ground, one, at=(0.2, 0, 0), coordinate="p")
    s.gear(first, s.hinge("second", s.ground, ring, coordinate="q"), 3, name="mesh")
    outer, inner = groups(draw(s), "gear")
    assert outer.items[0].style.fill == "none" and inner.items[0].style.fill != "none"
    a, b = (float(np.ptp(group.items[1].points[:, 0])) for group in (outer, inner))
    assert a / b == pytest.approx(3, rel=1e-2)


def test_a_rack_has_teeth_at_the_pitch_point() -> None:
    s = fb.System("rack")
    bar, pinion = s.body("bar", fb.box(2, (1, 0.1, 0.1))), s.body("pinion", fb.disk(1, 0.1))
    slide = s.slider("slide", s.ground, bar, axis="x", coordinate="x")
    s.gear(slide, s.hinge("turn", s.ground, pinion, at=(0, 0.15, 0), coordinate="p"), 0.1, name="teeth")
    drawing = draw(s)
    wheel, rack = sorted(
        (group.items[1].points for group in groups(drawing, "gear")), key=lambda line: -len(line)
    )
    # the circle is drawn as a polygon
    assert np.abs(wheel[:, 1] - rack[0, 1]).min() < 0.1 and rack[0, 1] == rack[1, 1]


@pytest.mark.parametrize(
    ("axes", "places", "ratio", "helix", "threads"),
    [
        ("zz", [(0, 0, 0), (0.3, 0, 0)], -2, 0.4, 12),
        ("xy", [(0.2, 0, 0), (0, 0.1, 0)], -2, 0.0, 2),
        ("xy", [(0, 0, 0.3), (0, 0, 0)], -30, 1.5, 2),
    ],
)  # fmt: skip
def test_in_space_lines_of_teeth_stand_on_the_pitch_circles(axes, places, ratio, helix, threads) -> None:
    """Those that face the reader: of wheels half, of bevel wheels fewer; threads of a worm."""
    found = groups(draw(pair(axes, places, ratio, helix_angle=helix)), "gear")
    assert len(found) == 2
    assert all(len(group.items) > 1 for group in found) or axes == "xy"
    assert sum(len(group.items) - 1 for group in found) >= threads


def test_teeth_of_bevel_wheels_end_at_their_pitch_circles() -> None:
    """They run from the circle towards the apex: inside the circle on paper, where the reader sees the cones."""
    drawing = draw(entries()["bevel-gears"].build())
    for group in groups(drawing, "gear"):
        *teeth, pitch = group.items
        assert len(teeth) > 5
        chord = np.linalg.norm(np.diff(pitch.points, axis=0), axis=1).max()
        for tooth in teeth:
            distances = np.linalg.norm(pitch.points - tooth.points[0], axis=1)
            assert distances.min() <= chord / 2 + 1e-9


def test_teeth_reach_over_the_cylinder_that_bears_them() -> None:
    """Threads of a worm from end to end, and teeth over the width of a wheel."""
    drawing = draw(entries()["worm-gear"].build())
    view = view_of(drawing)
    worm, wheel = groups(drawing, "gear")
    for group, axis, length in ((worm, (1.0, 0.0, 0.0), 6 * 0.03), (wheel, (0.0, 1.0, 0.0), 0.03)):
        along = view @ axis
        way = along / np.linalg.norm(along)
        whole = np.ptp(np.concatenate([tooth.points for tooth in group.items[:-1]]) @ way)
        assert whole >= scale_of(drawing) * length * np.linalg.norm(along) - 1e-6
