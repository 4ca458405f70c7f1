"""Starts on a floor: the lowest place touches, whatever carries it and however the floor lies."""

from __future__ import annotations

import math

import numpy as np
import pytest

import freebody as fb
from freebody.errors import ModelError


def gaps(s: fb.System, initial: dict) -> np.ndarray:
    motion = fb.simulate(s, 1e-3, initial=initial)
    return np.array([contact.gap[0] for contact in motion.contacts.values()])


def legged(**base: object) -> tuple[fb.System, list]:
    """A trunk with two legs on hinges, whose feet and trunk may touch a floor."""
    s = fb.System("legged")
    s.gravity = (0, 0, -9.81)
    trunk = s.body("trunk", fb.box(3, (0.4, 0.2, 0.1)))
    shapes = [trunk.corners(size=(0.4, 0.2, 0.1))]
    for side in (-1, 1):
        leg = s.body(f"leg{side}".replace("-1", "0"), fb.slender_bar(1, 0.5, axis="z"))
        s.hinge(f"hip{side}".replace("-1", "0"), trunk, leg, at=(0, 0.1 * side, 0), to=(0, 0, 0.25), axis="y",
                coordinate=f"q{side}".replace("-1", "0"))  # fmt: skip
        shapes.append(leg.sphere(0.04, at=(0, 0, -0.25)))
    return s, [trunk, shapes]


@pytest.mark.parametrize(
    "start", [{}, {"q0": 0.3, "q1": -1.2}, {"q0": 2.0, "q1": 2.5, "base_z": 7.0, "base_x": 1.0}]
)
@pytest.mark.parametrize("plane", [{}, {"at": (0, 0, -2)}, {"normal": (0, 3, 4), "at": (0.5, 0, 0)}])
def test_the_lowest_place_touches(start, plane):
    s, (trunk, shapes) = legged()
    s.free("base", s.ground, trunk)
    floor = s.ground.plane(**{"normal": "z", **plane})
    for k, shape in enumerate(shapes):
        s.contact(f"c{k}", shape, floor, friction=0.5)
    found = fb.on_floor(s, initial=start)
    assert abs(gaps(s, found).min()) < 1e-14
    assert {key: x for key, x in found.items() if key != "base_z"} == {
        k: x for k, x in start.items() if k != "base_z"
    }


def test_a_base_whose_axes_are_turned_rises_against_gravity():
    s, (trunk, shapes) = legged()
    s.free("base", s.ground, trunk, parent_axes=fb.Rotation.euler("ZXZ", 0.3, 0.8, -0.2))
    s.contact("c", shapes[1], s.ground.plane(normal="z"))
    found = fb.on_floor(s)
    x = [found.get(f"base_{a}", 0.0) for a in "xyz"]
    height = fb.compile(s).poses(
        fb.assemble(s).rest[: fb.assemble(s).n_q]
    )  # the machine itself is not changed
    assert height["trunk"][1] == pytest.approx([0, 0, 0], abs=1e-15)
    assert abs(gaps(s, found).min()) < 1e-14
    R = np.array(fb.Rotation.euler("ZXZ", 0.3, 0.8, -0.2).matrix, float)
    assert R @ x == pytest.approx([0, 0, (R @ x)[2]], abs=1e-15)


def test_slides_in_the_ground_carry_a_planar_machine():
    s = fb.System("hopper")
    s.gravity = (0, -9.81, 0)
    body = s.body("body", fb.disk(1, 0.2))
    s.planar("base", s.ground, body, coordinate="x y turn")
    s.contact("floor", body.circle(0.2), s.ground.plane(normal=(1, 1, 0)))
    found = fb.on_floor(s, initial={"x": 0.5})
    assert found == {"x": 0.5, "y": pytest.approx(0.2 * math.sqrt(2) - 0.5)}


def test_each_of_several_bodies_stands_on_the_floor():
    s = fb.System("two")
    s.gravity = (0, 0, -9.81)
    for name, radius in (("a", 0.1), ("b", 0.3)):
        ball = s.body(name, fb.sphere(1, radius))
        s.free(f"air_{name}", s.ground, ball)
        s.contact(f"c_{name}", s.ground.plane(normal="z"), ball.sphere(radius))  # the floor is the feature
    assert fb.on_floor(s) == {"air_a_z": pytest.approx(0.1), "air_b_z": pytest.approx(0.3)}


def test_values_and_atoms_are_taken():
    s = fb.System("ball")
    s.gravity = (0, 0, -9.81)
    r = s.parameters(r=0.1)
    ball = s.body("ball", fb.sphere(1, 0.1))
    z = s.coordinates("z")
    s.slider("up", s.ground, ball, axis="z", coordinate=z)
    s.contact("c", ball.sphere(r), s.ground.plane(normal="z"))
    assert fb.on_floor(s, initial={z: 4}, values={"r": 0.25}) == {"z": 0.25}
    assert fb.on_floor(fb.assemble(s)) == {"z": 0.1}


def test_what_has_no_floor_is_refused():
    s, (trunk, shapes) = legged()
    s.free("base", s.ground, trunk)
    with pytest.raises(
        ModelError, match="Expected a body of 'legged' that a free joint or slides let move along"
    ):
        fb.on_floor(s)
    s.contact("c", shapes[1], s.ground.plane(normal="z"))
    s.gravity = (0, 0, 0)
    with pytest.raises(
        ModelError, match="Expected gravity in 'legged', which says where its floor is. Set s.gravity"
    ):
        fb.on_floor(s)
    s, (trunk, shapes) = legged()
    s.weld("base", s.ground, trunk)
    s.contact("c", shapes[1], s.ground.plane(normal="z"))
    with pytest.raises(
        ModelError, match=r"got none. A robot's file: fb.read\(path, base='free', contacts='floor'\)"
    ):
        fb.on_floor(s)
