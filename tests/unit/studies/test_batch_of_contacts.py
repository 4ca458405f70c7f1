"""Batches of machines with contacts: numbers for the ends of a motion, and lanes without outputs."""

from __future__ import annotations

import numpy as np

import freebody as fb
from freebody.errors import SimulationError
from freebody.motion.batch.alone import Alone


def ball() -> fb.System:
    """A ball that bounces on a floor."""
    s = fb.System("ball")
    s.gravity = (0, -9.81, 0)
    body = s.body("ball", fb.disk(1, 0.1))
    s.planar("rail", s.ground, body, coordinate="x y turn")
    s.contact("floor", body.circle(0.1), s.ground.plane(normal="y"), friction=0.3, restitution=0.5)
    return s


def test_ends_of_lanes_are_those_of_the_motion() -> None:
    heights = np.array([0.5, 0.8])
    found = fb.simulate(ball(), 2, initial={"y": heights}, outputs=["initial(y)", "final(y)", "final(x)"])
    for k, height in enumerate(heights):
        alone = fb.simulate(ball(), 2, initial={"y": float(height)})
        assert found["initial(y)"][k] == height
        assert found["final(y)"][k] == alone["y"][-1]
        assert found["steps"][k] == alone.steps


def test_a_lane_without_outputs_is_refused_by_itself(monkeypatch) -> None:
    keep = Alone.keep

    def broken(self, row, motion):
        if row == 1:
            raise SimulationError("No such state.")
        keep(self, row, motion)

    monkeypatch.setattr(Alone, "keep", broken)
    found = fb.simulate(ball(), 0.1, initial={"y": np.array([0.5, 0.6, 0.7])}, outputs=["final(y)"])
    assert found.status.values.tolist() == ["finished", "refused", "finished"]
    assert "No such state." in str(found.reason.values[1])
