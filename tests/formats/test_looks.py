"""Shapes and colours of bodies in model files."""

from __future__ import annotations

import pytest

import freebody as fb
from freebody.errors import FormatError
from freebody.formats.toml.read import case_from_text
from freebody.formats.toml.write import toml_text
from freebody.picture.machine.shapes import colors, shapes


def machine() -> fb.System:
    s = fb.System("looks")
    m, L = s.parameters(m=2.0, L=0.5)
    s.body("cart", fb.particle(m), shape=fb.box(1, (L, 0.2, 0.3)).moved((0, L / 2, 0)), color="#0072B2")
    s.body("wheel", fb.disk(m, L), color="#d55e00")
    s.body("plain", fb.slender_bar(m, L, axis="y"))
    turned = fb.Rotation.axis_angle("x", "30deg")
    frame = fb.cylinder(m, L, 1).rotated(turned) + fb.box(1, (1, 2, 3)).moved((1, 0, 0)) - fb.sphere(0.1, 0.1)
    s.body("frame", frame)
    s.body("bare", fb.MassProperties(1, (0, 0, 0), ((1, 0, 0), (0, 1, 0), (0, 0, 1))), color="#123456")
    for i, name in enumerate(s.bodies):
        s.slider(f"j{i}", s.ground, s.bodies[name], axis="x", coordinate=f"x{i}")
    return s


def test_shapes_and_colours_are_kept():
    s = machine()
    again = case_from_text(toml_text(s)).system
    model, other = fb.assemble(s), fb.assemble(again)
    assert colors(other) == colors(model) == {"cart": "#0072B2", "wheel": "#d55e00", "bare": "#123456"}
    for name in model.bodies:
        mine, theirs = (one.bodies[name].properties.shape for one in (model, other))
        assert mine == theirs, name
    for name, pieces in shapes(model).items():
        for a, b in zip(pieces, shapes(other)[name], strict=True):
            assert (a.kind, a.dimensions, a.hole) == (b.kind, b.dimensions, b.hole)
            assert a.center.tolist() == b.center.tolist() and a.axes.tolist() == b.axes.tolist()


def test_the_shape_has_no_part_in_the_mass():
    s = machine()
    again = fb.assemble(case_from_text(toml_text(s)).system)
    assert again.bodies["cart"].mass == again.names.atoms["m"]
    assert all(x == 0 for row in again.bodies["cart"].inertia for x in row)


def test_a_solid_of_its_own_is_not_written_twice():
    text = toml_text(machine())
    assert "shape" not in text.partition("[bodies.wheel]")[2].partition("[bodies.plain]")[0]
    assert "shape" not in text.partition("[bodies.plain]")[2].partition("[bodies.frame]")[0]


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ('color = "red"', "#0072B2"),
        ("color = 7", "color"),
        ('shape = "box"', "Expected a shape such as"),
        ("shape = []", "Expected a shape such as"),
        ('shape = { solid = "bocks", sizes = [1, 1, 1] }', "Unknown solid 'bocks'"),
        ('shape = { solid = "box" }', "sizes"),
        ('shape = { solid = "box", sizes = [1, 1, 1], mass = 2 }', "no mass in a shape"),
        ('shape = { solid = "box", sizes = [1, 1, 1], colour = "x" }', "colour"),
        ('shape = [{ solid = "sphere", radius = 1, hole = 3 }]', "true or false"),
        ('shape = { solid = "sphere", radius = -1 }', "radius"),
    ],
)
def test_nonsense_is_refused(line: str, words: str):
    with pytest.raises(FormatError) as found:
        case_from_text(f'name = "x"\n[bodies.b]\nsolid = "particle"\nmass = 1\n{line}\n')
    assert words in str(found.value)
