"""Derivatives of starts that constraints leave open, against differences of the motions that such starts give."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

import freebody as fb
from freebody.errors import SimulationError


def epicyclic() -> fb.System:
    """Two freedoms: an arm, a planet on it that meshes with a sun, and a rack on a spring that the sun drives."""
    s = fb.System("epicyclic")
    r1, r2 = s.parameters(r1=0.3, r2=0.2)
    s.gravity = (0, -9.81, 0)
    arm, planet = s.body("arm", fb.slender_bar(1, r1 + r2, axis="x")), s.body("planet", fb.disk(1, r2))
    sun, rack = s.body("sun", fb.disk(3, r1)), s.body("rack", fb.particle(2))
    s.hinge("A", s.ground, arm, to=(-(r1 + r2) / 2, 0, 0), axis="z", coordinate="a")
    s.hinge("P", arm, planet, at=((r1 + r2) / 2, 0, 0), axis="z", coordinate="p")
    turn = s.hinge("S", s.ground, sun, axis="z", coordinate="b")
    rail = s.slider("R", s.ground, rack, axis="x", coordinate="x")
    s.gear(rail, turn, r1, name="teeth")
    s.constrain("r2*p + r1*(b - a) - r1", name="mesh")
    s.spring("k", rail, stiffness=20)
    return s


def wheel() -> fb.System:
    """A thin wheel, let go near the floor, that is moved onto it: its place, its turn and its speeds follow."""
    s = fb.System("wheel")
    R, w = s.parameters(R=0.3, w=-3.0)
    s.gravity = (0, -9.81, 0)
    disk = s.body("disk", fb.disk(2, R))
    s.free("f", s.ground, disk)
    s.rolling("floor", disk, radius=R, axis="z", normal="y")
    return s


def differences(s: Any, name: str, at: float, run: Mapping[str, Any], quantities: list[str]) -> np.ndarray:
    """Central, of sixth order."""

    def of(x: float) -> np.ndarray:
        given = {**run, "values" if name in fb.assemble(s).defaults else "initial": {}}
        key = "values" if name in fb.assemble(s).defaults else "initial"
        given[key] = {**run.get(key, {}), name: x}
        motion = fb.simulate(s, 0.5, tolerance=1e-13, samples=3, **given)
        return np.array([motion[q] for q in quantities])

    h = 1e-3
    return sum(c * (of(at + k * h) - of(at - k * h)) for k, c in ((1, 45), (2, -9), (3, 1))) / (60 * h)


STARTS = [
    # two coordinates of four follow, and two speeds, with least kinetic energy
    (epicyclic, {"initial": {"a": 0.2, "b'": 2.0}}, {"r1": 0.3, "r2": 0.2, "a": 0.2, "b'": 2.0}, ["a", "x'", "p"]),
    # far from closed: steps of the search are cut to length 1
    (
        epicyclic,
        {"initial": {"a'": "3*r1"}, "near": {"p": 9.0, "x": "8*r2", "x'": "r1"}},
        {"r1": 0.3, "r2": 0.2},
        ["b", "x", "a'"],
    ),
    # a quaternion among what follows, from where it was not upright
    (
        wheel,
        {"initial": {"f_wx": "w/9", "f_wz": "w"}, "near": {"f_y": 0.7, "f_e0": 1.0, "f_e1": 0.3, "f_vx": 0.5}},
        {"R": 0.3, "w": -3.0, "f_wx": -1 / 3},
        ["f_x", "f_y", "f_e1", "f_vz"],
    ),
]  # fmt: skip


@pytest.mark.parametrize(("machine", "run", "by", "quantities"), STARTS)
def test_open_starts_against_differences(
    machine: Any, run: dict[str, Any], by: dict[str, float], quantities: list[str]
) -> None:
    s = machine()
    unknowns = [name for name in by if name in run["initial"] or name in ("r1", "r2", "R", "w")]
    if "f_wx" in by:  # named by an expression: asked for as a number
        run = {**run, "initial": {**run["initial"], "f_wx": by["f_wx"]}}
    motion = fb.simulate(s, 0.5, tolerance=1e-12, samples=3, sensitivities=unknowns, **run)
    for name in unknowns:
        found = np.array([motion.sensitivity[q, name] for q in quantities])
        expected = differences(s, name, by[name], run, quantities)
        assert np.allclose(found, expected, rtol=0, atol=2e-8 * (1 + np.abs(expected).max())), name


def test_what_is_asked_for_unnamed_moves_from_where_it_was_found() -> None:
    s = epicyclic()
    motion = fb.simulate(s, 0.5, tolerance=1e-12, samples=3, sensitivities=["x"], initial={"a": 0.2})
    start = motion.at(0.0)
    again = {"initial": {"a": 0.2}, "near": {"b": start["b"], "p": start["p"]}}
    expected = differences(s, "x", start["x"], again, ["b", "p'"])
    found = np.array([motion.sensitivity[q, "x"] for q in ("b", "p'")])
    assert np.allclose(found, expected, rtol=0, atol=2e-8 * (1 + np.abs(expected).max()))


def test_a_start_that_can_not_follow_is_refused() -> None:
    s = epicyclic()
    held = {"a": 0.2, "b": 0.1, "x": "r1*0.1"}
    with pytest.raises(
        SimulationError, match=r"can not follow a change of 'b'.*hold what is named in initial"
    ):
        fb.simulate(s, 0.5, sensitivities=["b"], initial={**held, "b": 0.1})
