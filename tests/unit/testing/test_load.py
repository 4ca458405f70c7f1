"""The battery of loads catches wrong kinds."""

from __future__ import annotations

import random

import pytest

import freebody as fb


class OneSided(fb.Load):
    """A spring that pulls on one of its ends only."""

    first: fb.Point
    second: fb.Point

    def actions(self, at):
        yield fb.PointForce(self.first, at.line(self.first, self.second))


class OffItsLine(fb.Load):
    """Forces in balance, whose moments are not."""

    first: fb.Point
    second: fb.Point

    def actions(self, at):
        yield fb.PointForce(self.first, (0, 3, 1))
        yield fb.PointForce(self.second, (0, -3, -1))


class WrongSign(fb.Load):
    point: fb.Point
    stiffness: fb.Expression

    def actions(self, at):
        yield fb.PointForce(self.point, at(self.stiffness) * at.position(self.point))

    def potential(self, at):
        r = at.position(self.point)
        return at(self.stiffness) * r.dot(r) / 2


class Random(fb.Load):
    point: fb.Point

    def actions(self, at):
        yield fb.PointForce(self.point, (random.random(), 0, 0))


class NotInFiles(fb.Load, kind="test_load_not_in_files"):
    point: fb.Point
    weights: dict

    def actions(self, at):
        yield fb.PointForce(self.point, (self.weights["x"], 0, 0))


class Nowhere(fb.Load):
    """A load that acts on the ground only."""

    factor: fb.Expression
    body: fb.Body

    def actions(self, at):
        yield fb.PointForce(self.body.system.ground.point(1, 0, 0), (at(self.factor), 0, 0))


def caught(kind, message, error=AssertionError, **data):
    with pytest.raises(error, match=message):
        fb.testing.check_load(kind, **data)


def test_wrong_kinds_are_caught():
    law = "expected the sum of its forces and moments on all bodies and zero .Newton's third law. to be equal"
    caught(OneSided, f"OneSided: {law}")
    caught(OffItsLine, f"OffItsLine: {law}")
    caught(WrongSign, "Wrong sign 'x': the gradient of its potential is not its force", fb.FreebodyError)
    caught(Random, "Random 'x': asked twice at one state", fb.FreebodyError)
    caught(NotInFiles, "NotInFiles: its file cannot be written and read again", weights={"x": 1})
    caught(Nowhere, "Nowhere: the load is not drawn. Yield an action at a point or a body")


def test_what_acts_on_one_body_only_on_purpose():
    fb.testing.check_load(OneSided, balanced=False)
