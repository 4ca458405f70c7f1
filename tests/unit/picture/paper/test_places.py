"""Laws of places: projections, dimensions, the edge of the sheet, the ground, and the values of plotted curves."""

from __future__ import annotations

import itertools
import math
import random
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

import freebody as fb
from freebody.gallery import entries
from freebody.picture.free_body.free_body_diagram import free_body_diagram
from freebody.picture.machine.draw import draw
from freebody.picture.paper.sheet import Arrow, Circle, Group, Label, Line, flat
from freebody.picture.paper.view import view_of

PLACED = 1e-9
"""Of lengths on paper [pt]: attributes of drawings have twelve digits, a sheet is some 500 wide."""

SPATIAL = ("sec-6-9", "prob-6-18")
PLANAR = ("ex-6-2", "ex-6-5", "prob-6-5", "slider-crank", "four-bar")
TOUCHING = ("ex-6-1", "ex-6-3", "ex-6-4", "prob-6-2", "prob-6-11", "bouncing-ball", "rocking-block")


def groups(drawing: Any, class_: str) -> list[Group]:
    """All groups of a class."""

    def inside(group: Group) -> Any:
        for item in group.items:
            if isinstance(item, Group):
                if item.attributes.get("class") == class_:
                    yield item
                yield from inside(item)

    return list(inside(drawing.sheet.root))


def inked(items: Any) -> list[Any]:
    """The points of lines, heads and round things among them."""
    found = []
    for item in items:
        if isinstance(item, Group):
            found += inked(item.items)
        elif isinstance(item, Arrow):
            found += [item.points, *item.heads()]
        elif isinstance(item, Line):
            found.append(item.points)
        elif isinstance(item, Circle):
            t = np.linspace(0, 2 * np.pi, 49)
            found.append(item.center + item.radius * np.column_stack([np.cos(t), np.sin(t)]))
    return found


def matrix_of(drawing: Any) -> Any:
    return np.array(drawing.sheet.attributes["data-view"].split(), dtype=float).reshape(2, 3)


# --- projections ---------------------------------------------------------------------------------------------------


def tumbling(gravity: tuple[float, float, float], planar: str = "") -> fb.System:
    s = fb.System("tumbling")
    s.gravity = gravity
    body = s.body("body", fb.box(1, (1, 2, 3)))
    if planar:
        s.hinge("pin", s.ground, body, axis=planar, coordinate="q")
    else:
        s.free("flight", s.ground, body)
    return s


@pytest.mark.parametrize("planar", ["", "x", "y", "z"])
@pytest.mark.parametrize("axis", [None, 0, 1, 2])
@pytest.mark.parametrize("sign", [1, -1])
def test_projections_are_orthonormal(planar: str, axis: int | None, sign: int) -> None:
    """Rows of the matrix are unit vectors at right angles, the reader stands on their right-handed side."""
    g = [0.0, 0.0, 0.0]
    if axis is not None:
        g[axis] = 9.81 * sign
    e = fb.equations(tumbling(tuple(g), planar))
    for axonometric in (False, True):
        view = view_of(e.model, e, {}, axonometric)
        assert view.matrix @ view.matrix.T == pytest.approx(np.eye(2), abs=4e-16)
        assert np.cross(view.matrix[0], view.matrix[1]) == pytest.approx(view.toward, abs=4e-16)
        assert np.linalg.norm(view.toward) == pytest.approx(1, abs=4e-16)
        in_plane = bool(planar) and not axonometric and (axis is None or "xyz"[axis] != planar)
        assert view.planar == in_plane
        if in_plane:
            assert abs(view.toward["xyz".index(planar)]) == 1
        if axis is not None:
            # gravity points down the page, and nowhere else
            across, up = view(g)
            assert up < 0 and across == pytest.approx(0, abs=1e-14)


@pytest.mark.parametrize("name", [*PLANAR, *SPATIAL])
def test_drawings_say_the_projection_they_are_in(name: str) -> None:
    """The matrix in the attributes is orthonormal, to the digits it is written with."""
    system = entries()[name].build()
    for drawing in (draw(system), free_body_diagram(system)):
        matrix = matrix_of(drawing)
        assert matrix @ matrix.T == pytest.approx(np.eye(2), abs=1e-11)


# --- dimensions ----------------------------------------------------------------------------------------------------


HUNG = (0.7, -0.4)
"""The pin of the bar, off the origin."""


def measured(seed: int) -> tuple[Any, dict[str, float], float]:
    """A bar of random length on a hinge, pushed and pulled at random points; its points along it, its angle."""
    rng = random.Random(seed)
    length, angle = rng.uniform(0.4, 3), rng.uniform(-3, 3)
    places = {
        "pin": rng.uniform(-0.5, -0.3),
        "P point": rng.uniform(0.1, 0.3),
        "C": 0.0,
        "end 1": 0.5,
        "end -1": -0.5,
    }
    along = {name: part * length for name, part in places.items()}
    s = fb.System("bar")
    s.gravity = (0, -9.81, 0)
    m, L, p, c = s.parameters(m=2, L=length, p=along["pin"], c=along["P point"])
    bar = s.body("bar", fb.slender_bar(m, L, axis="x"))
    s.hinge("pin", s.ground, bar, at=(*HUNG, 0), to=(p, 0, 0), coordinate="theta")
    s.force("P", bar.point(c, 0, 0), (0, 5, 0))
    return free_body_diagram(s, "bar", at={"theta": angle}, dimensions=True), along, angle


@pytest.mark.parametrize("seed", range(8))
def test_dimension_lines_are_parallel_to_what_they_measure_and_as_long(seed: int) -> None:
    drawing, along, angle = measured(seed)
    scale = float(drawing.sheet.attributes["data-scale"])
    d = np.array([math.cos(angle), math.sin(angle)])
    found = groups(drawing, "dimension")
    assert len(found) >= 2
    ends = []
    for group in found:
        first, second = group.title.removeprefix("from ").split(" to ")
        (arrow,) = (item for item in group.items if isinstance(item, Arrow))
        way = arrow.points[-1] - arrow.points[0]
        distance = scale * (along[second] - along[first])
        assert arrow.head in ("both", "inward") and way == pytest.approx(distance * d, abs=PLACED * scale)
        ends.append((arrow.points[0], arrow.points[-1]))
        # the lines that lead to it stand at right angles on it, and each points to its point of the bar
        base = scale * np.array(HUNG)
        for name, line in zip((first, second), (x for x in group.items if isinstance(x, Line)), strict=True):
            lead = line.points[-1] - line.points[0]
            assert lead @ d == pytest.approx(0, abs=PLACED * scale)
            away = (line.points[0] - base) @ d
            assert away == pytest.approx(scale * (along[name] - along["pin"]), abs=PLACED * scale)
    # one chain: each begins where the last one ends
    for (_, end), (start, _) in itertools.pairwise(ends):
        assert start == pytest.approx(end, abs=PLACED * scale)
    total = (ends[-1][1] - ends[0][0]) @ d / scale
    assert total == pytest.approx(max(along.values()) - min(min(along.values()), along["pin"]), rel=0.05)


@pytest.mark.parametrize("radius", [0.1, 0.7, 5.0])
def test_a_radius_is_as_long_as_it_is(radius: float) -> None:
    s = fb.System("wheel")
    R = s.parameters(R=radius)
    wheel = s.body("wheel", fb.disk(1, R))
    s.planar("plane", s.ground, wheel, coordinate="x y q")
    drawing = free_body_diagram(s, "wheel", at={"x": 2.0, "y": -1.0}, dimensions=True)
    scale = float(drawing.sheet.attributes["data-scale"])
    (group,) = groups(drawing, "dimension")
    (arrow,) = group.items
    assert group.attributes["data-symbol"] == "R"
    assert np.linalg.norm(arrow.points[-1] - arrow.points[0]) == pytest.approx(scale * radius, rel=1e-9)
    outline = np.vstack(inked(groups(drawing, "outline")[0].items))
    # it begins at the centre and ends on the rim
    centre = (outline.min(axis=0) + outline.max(axis=0)) / 2
    assert arrow.points[0] == pytest.approx(centre, abs=1e-3 * scale * radius)


# --- the sheet -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", [*PLANAR, *SPATIAL])
def test_nothing_is_outside_the_sheet(name: str) -> None:
    system = entries()[name].build()
    for drawing in (draw(system), free_body_diagram(system, dimensions=True)):
        x0, y0, x1, y1 = drawing.sheet.box
        low, high = np.array([x0, y0]), np.array([x1, y1])
        points = np.vstack(inked(drawing.sheet.root.items))
        assert (points >= low - PLACED).all() and (points <= high + PLACED).all()
        for item in flat(drawing.sheet.root):
            if isinstance(item, Label):
                a = item.box
                assert x0 <= a[0] and y0 <= a[1] and a[2] <= x1 and a[3] <= y1, item.tex


# --- the ground ----------------------------------------------------------------------------------------------------


def rolling(radius: float, wheels: int) -> fb.System:
    """Wheels of one size that roll on the plane, side by side."""
    s = fb.System("rolling")
    s.gravity = (0, -9.81, 0)
    for k in range(wheels):
        wheel = s.body(f"wheel_{k}", fb.disk(1, radius))
        s.planar(f"plane_{k}", s.ground, wheel, coordinate=f"x_{k} y_{k} q_{k}")
        s.rolling(f"roll_{k}", wheel, radius=radius, axis="z", normal="y")
    return s


@pytest.mark.parametrize(("radius", "wheels"), [(0.1, 1), (3.0, 1), (0.3, 2)])
def test_the_ground_ends_beyond_the_wheels_that_roll_on_it(radius: float, wheels: int) -> None:
    places = {f"x_{k}": 2.5 * radius * k for k in range(wheels)} | {f"y_{k}": radius for k in range(wheels)}
    beyond(draw(rolling(radius, wheels), near=places))


@pytest.mark.parametrize("name", TOUCHING)
def test_the_ground_ends_beyond_what_stands_on_it(name: str) -> None:
    beyond(draw(entries()[name].build()))


def beyond(drawing: Any) -> None:
    """Along its edge the ground reaches farther than every body, and every body is on its free side."""
    (plane,) = groups(drawing, "plane")[:1]
    edge = max(
        (x.points for x in plane.items if isinstance(x, Line)), key=lambda p: np.linalg.norm(p[-1] - p[0])
    )
    along = (edge[-1] - edge[0]) / np.linalg.norm(edge[-1] - edge[0])
    bodies = np.vstack([p for one in groups(drawing, "body") for p in inked(one.items)])
    reach = sorted((edge @ along).tolist())
    assert reach[0] < (bodies @ along).min() and (bodies @ along).max() < reach[-1]
    height = (bodies - edge[0]) @ np.array([-along[1], along[0]])
    hatching = np.vstack([x.points for x in plane.items if isinstance(x, Line)]) - edge[0]
    below = hatching @ np.array([-along[1], along[0]])
    side = -np.sign(below[np.argmax(np.abs(below))])
    # a bar is drawn 8 pt wide about the line that touches
    assert (side * height).min() > -4


# --- plots ---------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def motion() -> fb.Trajectory:
    return fb.simulate(entries()["ex-6-5"].build(), 3, initial={"theta": 0.7})


@pytest.mark.parametrize("name", ["theta", "x", "theta'", "x'", "sin(theta)"])
def test_a_plotted_curve_has_the_values_of_the_motion(motion: fb.Trajectory, name: str) -> None:
    """Every vertex of a curve is a moment of the motion and its value there, and the curve reaches to both ends."""
    ax = Figure().subplots()
    motion.plot(name, ax=ax)
    line = max(ax.lines, key=lambda one: len(one.get_xdata()))
    x, y = np.asarray(line.get_xdata(), float), np.asarray(line.get_ydata(), float)
    assert (x[0], x[-1]) == (motion.t[0], motion.t[-1]) and len(x) >= len(motion.t)
    shared = np.isin(x, motion.t)
    assert y[shared] == pytest.approx(np.asarray(motion[name])[np.isin(motion.t, x)], rel=1e-12, abs=1e-12)


def test_a_drawing_is_of_the_place_it_was_asked_for() -> None:
    """Ends of a turned bar on paper are the ends of the bar, by the projection and scale that the drawing states."""
    drawing, along, angle = measured(3)
    scale = float(drawing.sheet.attributes["data-scale"])
    d = np.array([math.cos(angle), math.sin(angle)])
    outline = (np.vstack(inked(groups(drawing, "outline")[0].items)) / scale - HUNG) @ d
    assert outline.min() == pytest.approx(along["end -1"] - along["pin"], abs=6 / scale)
    assert outline.max() == pytest.approx(along["end 1"] - along["pin"], abs=6 / scale)
