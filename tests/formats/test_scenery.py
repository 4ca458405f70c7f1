"""Scenery and hidden bodies in model files: read as written, and refused where they are wrong."""

from __future__ import annotations

import pytest

import freebody as fb
from freebody.errors import FormatError
from freebody.formats.toml.read import case_from_text
from freebody.formats.toml.write import toml_text
from freebody.picture.machine.shapes import hidden

HEAD = '[parameters]\nR = 0.5\n[bodies.disk]\nsolid = "disk"\nmass = 1\nradius = "R"\n'
JOINT = '[joints.pin]\ntype = "hinge"\nchild = "disk"\ncoordinate = "q"\n'


def test_scenery_and_hidden_bodies_are_kept() -> None:
    s = fb.System("ledge")
    R = s.parameters(R=0.5)
    frame = s.body("frame", fb.particle(0), shape="nothing")
    disk = s.body("disk", fb.disk(1, R))
    s.slider("way", s.ground, frame, coordinate="x")
    s.hinge("pin", frame, disk, coordinate="q")
    s.scenery = fb.box(1, (2 * R, R, 1)).moved((R, -R / 2, 0))
    again = case_from_text(toml_text(s)).system
    assert again.scenery == s.scenery
    assert hidden(fb.assemble(again)) == hidden(fb.assemble(s)) == {"frame"}


@pytest.mark.parametrize(
    ("scenery", "message"),
    [
        ('scenery = "ledge"', "Expected a shape such as"),
        ('scenery = { solid = "bok" }', "Unknown solid 'bok'"),
        ('scenery = { solid = "box", mass = 2, sizes = [1, 1, 1] }', "Expected no mass in a shape"),
    ],
)
def test_scenery_that_is_none(scenery: str, message: str) -> None:
    with pytest.raises(FormatError, match=message):
        case_from_text(f"{scenery}\n{HEAD}{JOINT}")
