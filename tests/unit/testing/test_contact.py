"""The battery of contacts catches wrong kinds."""

from __future__ import annotations

import pytest

import freebody as fb


class Floor(fb.Gap):
    """A point over the plane y = height."""

    point: fb.Point
    height: fb.Expression
    directions = 1

    def gap(self, at):
        return at.position(self.point).y - at(self.height)

    def pair(self, at, force):
        yield fb.PointForce(self.point, force)
        yield fb.PointForce(
            at.spot(self.point.body.system.ground, at.position(self.point)), tuple(-x for x in force)
        )

    def normal(self, at):
        return self.pair(at, (0, 1, 0))

    def tangents(self, at):
        return (self.pair(at, (1, 0, 0)),)


class Tilted(Floor):
    def normal(self, at):
        return self.pair(at, (1, 1, 0))


class Pulling(Floor):
    def normal(self, at):
        return self.pair(at, (0, -1, 0))


class OneSided(Floor):
    def normal(self, at):
        yield fb.PointForce(self.point, (0, 1, 0))


class Elsewhere(Floor):
    """Its opposite force acts at another place."""

    def pair(self, at, force):
        yield fb.PointForce(self.point, force)
        yield fb.PointForce(self.point.body.system.ground.point(9, 0, 0), tuple(-x for x in force))


class NotInFiles(Floor, kind="test_gap_not_in_files"):
    weights: dict


def test_a_right_kind_passes():
    fb.testing.check_contact(Floor, friction=0.3)


@pytest.mark.parametrize(
    ("kind", "message"),
    [
        (Tilted, "Tilted: expected the power of the normal force and the rate of the gap to be equal"),
        (Pulling, "Pulling: expected the power of the normal force and the rate of the gap to be equal"),
        (OneSided, "OneSided: expected force 0 of contact 'x' and its opposite to be equal"),
        (Elsewhere, "Elsewhere: expected force 0 of contact 'x' and its opposite to be equal"),
        (NotInFiles, "NotInFiles: its file cannot be written and read again"),
    ],
)
def test_wrong_kinds_are_caught(kind, message):
    data = {"weights": {}} if kind is NotInFiles else {}
    with pytest.raises(AssertionError, match=message):
        fb.testing.check_contact(kind, friction=0.3, **data)
