"""Laws of what a drawing measures: dimensions, inclinations, lines of action; and of what stands still in it."""

from __future__ import annotations

import math
import random
from typing import Any

import numpy as np
import pytest
import sympy

import freebody as fb
from freebody.errors import ModelError
from freebody.gallery import entries
from freebody.picture.machine.configuration import configuration
from freebody.picture.machine.draw import draw
from freebody.picture.machine.inclinations import angle_with
from freebody.picture.paper.placing import inside
from freebody.picture.paper.sheet import Arrow, Circle, Group, Label, Line, flat, overlap

PLACED = 1e-8
"""Of lengths on paper [pt]: attributes of drawings have twelve digits."""


def groups(drawing: Any, class_: str) -> list[Group]:
    """All groups of a class, or of two classes of which it is the first."""

    def within(group: Group) -> Any:
        for item in group.items:
            if isinstance(item, Group):
                if item.attributes.get("class", "").split()[:1] == [class_]:
                    yield item
                yield from within(item)

    return list(within(drawing.sheet.root))


def scale_of(drawing: Any) -> float:
    return float(drawing.sheet.attributes["data-scale"])


def view_of(drawing: Any) -> Any:
    return np.array(drawing.sheet.attributes["data-view"].split(), dtype=float).reshape(2, 3)


def texts(drawing: Any) -> list[str]:
    return [item.tex for item in flat(drawing.sheet.root) if isinstance(item, Label)]


def as_drawn(name: str) -> tuple[Any, Any, Any]:
    """A system of the gallery, its drawing as the gallery shows it, and its configuration."""
    entry = entries()[name]
    s = entry.build()
    e = fb.equations(s)
    near = {key: x for key, x in entry.near.items() if key in e.model.coordinate_names}
    at = dict(entry.drawn) or None
    return s, draw(e, near=near, at=at), configuration(e.model, at, near=near)


# --- dimensions ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", list(entries()))
def test_a_dimension_is_parallel_to_what_it_measures_and_as_long(name: str) -> None:
    """Its arrow lies along an axis of the body as projected, and is as long as the labelled expression."""
    _, drawing, now = as_drawn(name)
    matrix, scale = view_of(drawing), scale_of(drawing)
    for group in groups(drawing, "dimension"):
        if "data-axis" not in group.attributes:
            continue
        body, axis = group.attributes["data-axis"].rsplit(" ", 1)
        R, _ = now.posture(body)
        along = scale * float(group.attributes["data-value"]) * matrix @ R[:, "xyz".index(axis)]
        (arrow,) = (item for item in group.items if isinstance(item, Arrow))
        assert arrow.points[-1] - arrow.points[0] == pytest.approx(along, abs=PLACED * scale), group.title
        first, second = (item for item in group.items[:2])
        for lead in (first, second):
            assert (lead.points[-1] - lead.points[0]) @ along == pytest.approx(0, abs=PLACED * scale**2)


@pytest.mark.parametrize("name", list(entries()))
def test_labels_are_apart_as_the_gallery_draws_them(name: str) -> None:
    _, drawing, _ = as_drawn(name)
    labels = [item for item in flat(drawing.sheet.root) if isinstance(item, Label)]
    for i, label in enumerate(labels):
        for other in labels[i + 1 :]:
            assert overlap(label.box, other.box) == 0, (label.tex, other.tex)


@pytest.mark.parametrize(
    ("name", "symbols"),
    [
        ("ex-6-1", r"L, H, D, \beta"), ("ex-6-3", "h, R"), ("ex-6-4", r"\beta, R"), ("sec-6-6", r"L, R, \beta"),
        ("sec-6-9", "L, R"), ("prob-6-1", r"\mathrm{length}, \beta"), ("prob-6-2", r"\mathrm{lf}, \mathrm{lr}, h"),
        ("prob-6-3", "l, h"), ("prob-6-5", r"b, h, \alpha"), ("prob-6-6", "L, R"), ("prob-6-7", "R"),
        ("prob-6-10", "R, r, R - r"), ("prob-6-12", r"2 a, L, \beta"), ("prob-6-13", r"L, R, e, \beta"),
        ("prob-6-14", "s"), ("prob-6-18", "R, h"), ("prob-6-20", "h"), ("four-bar", "a, b, c, d"),
        ("two-gears", "r_{1}, r_{2}, r_{1} + r_{2}"), ("whipple-bicycle", "c, w + c, r_{F}, r_{R}"),
        ("rocking-block", "b, h"), ("tumbling-body", "a, b, c"),
    ],
)  # fmt: skip
def test_the_lengths_and_angles_of_a_problem_are_in_its_drawing(name: str, symbols: str) -> None:
    _, drawing, _ = as_drawn(name)
    shown = {tex.replace(" ", "") for tex in texts(drawing)}
    missing = [tex for tex in symbols.split(", ") if f"${tex}$".replace(" ", "") not in shown]
    assert not missing, sorted(shown)


def test_a_mass_centre_midway_does_not_divide_a_length() -> None:
    """The length of a box on two feet is one dimension; off the middle, there are two."""
    for shift, expected in ((0, ["$L$"]), ("L/5", [r"$\frac{3}{10} L$", r"$\frac{7}{10} L$"])):
        s = fb.System("block")
        L = s.parameters(L=2.0)
        body = s.body("block", fb.box(1, (L, 1, 1)).moved((s.expression(shift), 0, 0)), shape=fb.particle(1))
        s.planar("plane", s.ground, body, to=(shift, 0, 0), coordinate="x y theta")
        for name, x in (("A", -L / 2), ("B", L / 2)):
            s.contact(name, body.point(x, "-1/2", 0), s.ground.plane(), friction=0)
        found = [group.attributes["data-symbol"] for group in groups(draw(s), "dimension")]
        assert sorted(f"${tex}$" for tex in found) == expected


# --- inclinations --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("angle", [-50, -12, 8, 30, 64])
@pytest.mark.parametrize("named", [True, False])
def test_the_arc_of_a_slope_spans_its_angle(angle: float, named: bool) -> None:
    s = fb.System("slope")
    s.gravity = (0, -9.81, 0)
    beta: Any = s.parameters(beta=math.radians(angle)) if named else sympy.pi * angle / 180
    disk = s.body("disk", fb.disk(1, 0.2))
    s.planar("plane", s.ground, disk, coordinate="x y phi")
    normal = (-sympy.sin(beta), sympy.cos(beta), 0)
    s.contact("floor", disk.circle(0.2), s.ground.plane(normal=normal), friction=1)
    (group,) = groups(draw(s), "inclination")
    level, arc = group.items
    corner = level.points[0]
    radii = np.linalg.norm(arc.points - corner, axis=1)
    assert radii == pytest.approx(radii[0])
    a, b = (p - corner for p in (arc.points[0], arc.points[-1]))
    assert math.acos(a @ b / radii[0] ** 2) == pytest.approx(math.radians(abs(angle)))
    assert a[1] == pytest.approx(0, abs=1e-9)
    assert group.attributes["data-symbol"] == (r"\beta" if named else rf"{abs(angle)}^\circ")


def test_an_angle_is_named_only_if_it_is_a_parameter() -> None:
    F, a, b = sympy.symbols("F a b")
    assert angle_with(F * sympy.cos(a), F * sympy.sin(a)) == a
    assert angle_with(sympy.Integer(3), sympy.Integer(3)) == sympy.pi / 4
    assert angle_with(a, b) is None and angle_with(F * sympy.cos(a), F * sympy.sin(b)) is None


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


# --- lines of action -----------------------------------------------------------------------------------------------


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


# --- blows ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(3))
def test_a_blow_ends_at_the_point_that_is_struck(seed: int) -> None:
    rng = random.Random(seed)
    s = fb.System("bar")
    bar = s.body("bar", fb.slender_bar(1, 2, axis="y"))
    s.hinge("pin", s.ground, bar, to=(0, 1, 0), coordinate="theta")
    J, reach, angle = s.parameters(J=2.0, reach=rng.uniform(-1, 1), angle=rng.uniform(0, 6))
    point = bar.point(0, reach, 0)
    drawing = draw(s, impulses={"J": (point, (J * sympy.cos(angle), J * sympy.sin(angle), 0))})
    (group,) = groups(drawing, "impulse")
    (arrow,) = group.items
    values = {p.name: p.default for p in fb.assemble(s).parameters}
    now = configuration(fb.assemble(s))
    assert arrow.tip == pytest.approx(scale_of(drawing) * now.point(point)[:2])
    d = (arrow.points[1] - arrow.points[0]) / np.linalg.norm(arrow.points[1] - arrow.points[0])
    assert d == pytest.approx([math.cos(values["angle"]), math.sin(values["angle"])])
    assert r"$\hat{J}$" in texts(drawing)


def test_blows_that_cannot_be_drawn() -> None:
    s = entries()["ex-6-2"].build()
    bar = s.bodies["bar"]
    with pytest.raises(
        ModelError, match="Expected a point of a body of 'hinged_bar' for the impulse 'J', got 3"
    ):
        draw(s, impulses={"J": (3, (1, 0, 0))})
    with pytest.raises(
        ModelError, match="Expected an impulse 'J' that the drawing can show, got zero in its view"
    ):
        draw(s, impulses={"J": (bar.origin, (0, 0, 1))})


# --- supports and scenery ------------------------------------------------------------------------------------------


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
    s.scenery = fb.box(1, (1, 1, 1))
    assert fb.assemble(s).scenery.kind == "box" if s.bodies else s.scenery is not None
    s.scenery = None
    assert s.scenery is None


def test_a_hidden_frame_is_not_drawn_but_its_coordinates_are() -> None:
    drawing = draw(entries()["prob-6-10"].build())
    bodies = {g.attributes["data-body"] for g in groups(drawing, "body")}
    assert bodies == {"disk"} and r"$\theta$" in texts(drawing)


# --- gears ---------------------------------------------------------------------------------------------------------


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


def test_a_spring_ends_on_the_block_that_it_holds() -> None:
    drawing = draw(entries()["prob-6-16"].build(), near={"x": "L/20"})
    blocks = [g.items[0].points for g in groups(drawing, "body") if len(g.items[0].points) == 4]
    springs = groups(drawing, "spring")
    assert len(blocks) == 2 and len(springs) == 2
    for group in springs:
        points = group.items[0].points
        for block in blocks:
            low, high = block.min(axis=0) + 0.1, block.max(axis=0) - 0.1
            assert not ((points > low) & (points < high)).all(axis=1).any()
