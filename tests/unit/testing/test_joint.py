"""The battery of joints: every kind passes it, and wrong kinds are caught."""

from __future__ import annotations

import itertools
import random

import pytest
import sympy

import freebody as fb
from freebody.describe.joints.joint import KINDS

COUNT = itertools.count(1)
DATA = {
    "chain": {"parts": [fb.Slider("x"), fb.Hinge("y", at=(0, 1, 0)), fb.Hinge((1, 2, 2))]},
    "path_joint": {"coordinate": "u v", "position": ("u", "v^2", "u*v"), "turns": [("z", "u"), ("x", "v")]},
    "universal": {"axis": ((1, 2, 2), "y")},
    "screw": {"axis": (2, 1, 2)},
}


@pytest.mark.parametrize("kind", [k for k in KINDS.values() if k.__module__.startswith("freebody.")])
@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.slow)])
def test_every_kind_passes(kind, seed):
    fb.testing.check_joint(kind, seed, **DATA.get(kind.kind, {}))


def test_armature_and_a_rotor_pass():
    fb.testing.check_joint(KINDS["hinge"], rotor=fb.Rotor("1/4", ratio=3, axis=(1, 2, 2)))
    fb.testing.check_joint(KINDS["free"], armature=(2, 3))


class Leg(fb.Joint, kind="test_leg"):
    thigh: fb.Expression
    endings = ("hip", "knee")

    def motions(self):
        yield fb.Hinge("z")
        yield fb.Hinge("z", at=(0, -self.thigh, 0))


class SlotAndBall(fb.Joint, kind="test_slot_and_ball"):
    axis: fb.Vector

    def motions(self):
        yield fb.Slider(self.axis)
        yield fb.Ball()


class Surface(fb.Joint, kind="test_surface"):
    radius: fb.Expression
    endings = ("u", "v")

    def pose(self, u, v):
        R = self.radius
        return (R * sympy.cos(u) * sympy.cos(v), R * sympy.sin(u) * sympy.cos(v), R * sympy.sin(v)), [
            ("z", u),
            ("y", -v),
        ]


@pytest.mark.parametrize("kind", [Leg, SlotAndBall, Surface])
def test_own_kinds_pass(kind):
    fb.testing.check_joint(kind)


def test_names_of_coordinates():
    s = fb.System("names")
    a, b, c = (s.body(name, fb.box(1, (1, 2, 3))) for name in "abc")
    s.add("left", Leg(s.ground, a, 1))
    s.add("right", Leg(s.ground, b, 1, coordinate="p q"))
    s.add("joint", SlotAndBall(s.ground, c, (1, 2, 2)))
    assert fb.assemble(s).coordinate_names == (
        "left_hip", "left_knee", "p", "q", "joint_1", "joint_2_e0", "joint_2_e1", "joint_2_e2", "joint_2_e3",
    )  # fmt: skip
    with pytest.raises(fb.FreebodyError, match="Expected 2 coordinates for joint 'x', got 1: p"):
        s.add("x", Leg(s.ground, s.body("d", fb.particle(1)), 1, coordinate=["p"]))


# --- what is wrong is caught --------------------------------------------------------------------


class Random(fb.Joint):
    def motions(self):
        yield fb.Hinge("z", at=(random.random(), 0, 0))


class Counting(fb.Joint):
    def pose(self, q):
        return (next(COUNT) * q, q**2, 0), []


class SameMotion(fb.Joint):
    endings = ("u", "v")

    def pose(self, u, v):
        return (u + v, 0, 0), [("z", u + v)]


class NotInFiles(fb.Joint, kind="test_not_in_files"):
    lengths: list = (1, 2)

    def motions(self):
        yield fb.Hinge("z", at=(self.lengths[0], 0, 0))


class OtherAfterAFile(fb.Joint, kind="test_other_after_a_file"):
    length: fb.Expression

    def motions(self):
        yield fb.Hinge("z", at=(self.length, 0, 0))
        yield fb.Hinge("z", at=(0, 0, 0))

    def stored(self, motions, position):
        return {"length": 2 * self.length}


@pytest.mark.parametrize(
    ("kind", "message", "data"),
    [
        (Random, "Random: expected the same motions of the same data, got .* Motions are functions of the fields", {}),
        (Counting, "Counting: expected the same motions of the same data", {}),
        (SameMotion, "SameMotion: expected a positive definite mass matrix.*make the same motion, or one", {}),
        (NotInFiles, "NotInFiles: its file cannot be written and read again: .*is list", {"lengths": [1, 2]}),
        (OtherAfterAFile, "OtherAfterAFile: expected what it does before and after a file to be equal, got", {}),
    ],
    ids=lambda x: getattr(x, "__name__", ""),
)  # fmt: skip
def test_wrong_kinds_are_caught(kind, message, data):
    with pytest.raises(AssertionError, match=message):
        fb.testing.check_joint(kind, **data)


def test_data_that_cannot_be_drawn_are_asked_for():
    class WithText(fb.Joint):
        shape: str

        def motions(self):
            yield fb.Hinge("z")

    with pytest.raises(
        fb.FreebodyError, match=r"Expected data for 'shape' of WithText: check_joint\(WithText, shape="
    ):
        fb.testing.check_joint(WithText)
