"""Angles of slopes on paper are the angles, named where they are parameters."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import sympy

import freebody as fb
from drawn import groups
from freebody.picture.machine.draw import draw
from freebody.picture.machine.inclinations import angle_with


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
