"""Blows and springs in drawings."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest
import sympy

import freebody as fb
from drawn import groups, scale_of, texts
from freebody.errors import ModelError
from freebody.gallery import entries
from freebody.picture.machine.configuration import configuration
from freebody.picture.machine.draw import draw
from freebody.picture.moving.keyframes import keyframes, paths_of_arrows


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


def test_a_spring_ends_on_the_block_that_it_holds() -> None:
    drawing = draw(entries()["prob-6-16"].build(), near={"x": "L/20"})
    blocks = [g.items[0].points for g in groups(drawing, "body") if len(g.items[0].points) == 4]
    springs = groups(drawing, "spring")
    assert len(blocks) == 1 and len(springs) == 2
    for group in springs:
        points = group.items[0].points
        for block in blocks:
            low, high = block.min(axis=0) + 0.1, block.max(axis=0) - 0.1
            assert not ((points > low) & (points < high)).all(axis=1).any()


def test_a_force_without_a_value_at_rest_is_drawn_along_the_axes_and_moves_over_its_body() -> None:
    s = fb.System("wheel on a road")
    s.gravity = (0, -9.81, 0)
    wheel = s.body("wheel", fb.disk(10, 0.3))
    s.planar("plane", s.ground, wheel, coordinate="x y turn")
    s.tyre("tyre", wheel.origin, axis="z", radius=0.3, longitudinal=10, stiffness=2e5, damping=500)
    drawing = draw(s)
    assert len([one for one in texts(drawing) if "tyre" in one]) == 2  # slip has no value at rest
    assert r"$9.81\,\mathrm{m/s^2}$" in texts(drawing)
    motion = fb.simulate(s, 0.5, initial={"x'": 5, "y": 0.3, "turn'": -10})
    keys = keyframes(motion)
    (path,) = paths_of_arrows(motion, keys).values()
    x, y = keys.states[:, 0], keys.states[:, 1]
    assert path == pytest.approx(np.stack([x, 0 * y, 0 * y], axis=1), abs=1e-12)


def test_the_reaction_of_a_path_is_labelled_by_its_name():
    """Not a wire_q/|a|: what is a/|a| is the sense of the arrow, on the condition a > 0."""
    s = fb.System("bead")
    m, g, a = s.parameters(m=1.0, g=9.81, a=0.5)
    s.gravity = (0, -g, 0)
    bead = s.body("bead", fb.particle(m))
    position = ("a*(p + sin(p))", "-a*cos(p)", 0)
    s.path_joint("wire", s.ground, bead, coordinate="p", position=position)
    svg = fb.free_body_diagram(s, "bead").svg
    assert 'data-symbol="wire_q"' in svg and "a &gt; 0, 1 + cos(p) &gt; 0" in svg


@pytest.mark.parametrize("space", [False, True])
def test_a_damper_of_a_turn_is_a_piston_in_a_bent_pot(space: bool) -> None:
    s = fb.System("door")
    door = s.body("door", fb.box(1, (0.9, 0.05, 1.2)))
    hinge = s.hinge("hinge", s.ground, door, to=(-0.45, 0, 0), axis="z", coordinate="theta")
    s.damper("c", hinge, damping=2)
    drawing = draw(s, at={"theta": 0.4}, axonometric=space)
    (group,) = groups(drawing, "damper")
    pot, head, rod, arm = (item.points for item in group.items[-4:])
    assert len(group.items) == (5 if space else 4)  # in space a shaft reaches it, beside the door
    assert len(head) == 2 and len(pot) > 20
    # both arms end at one point at its axis, and the head lies within the pot
    assert np.linalg.norm(rod[-1] - arm[-1]) < 6.5
    assert (head.min(axis=0) > pot.min(axis=0) - 1e-9).all() and (
        head.max(axis=0) < pot.max(axis=0) + 1e-9
    ).all()
