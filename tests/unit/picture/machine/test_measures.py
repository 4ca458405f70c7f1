"""Laws of dimensions: parallel to what they measure, as long, and there; labels apart."""

from __future__ import annotations

import pytest

import freebody as fb
from drawn import PLACED, as_drawn, groups, scale_of, texts, view_of
from freebody.gallery import entries
from freebody.picture.machine.draw import draw
from freebody.picture.paper.sheet import Arrow, Label, flat, overlap
from sampled import sampled


@pytest.mark.parametrize("name", sampled(entries(), 3, ("whipple-bicycle",)))
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


@pytest.mark.parametrize("name", sampled(entries(), 3, ("whipple-bicycle",)))
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
        ("sec-6-9", "L, R"), ("prob-6-1", r"L, \beta"), ("prob-6-2", "l_{f}, l_{r}, h"),
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
