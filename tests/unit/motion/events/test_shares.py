"""Shares of forces that a motion leaves open, as a decision takes them."""

import numpy as np
import pytest

import freebody as fb
from freebody.motion.contact.starting_modes import see
from freebody.motion.contact.state import ContactRun
from freebody.motion.events.code import code
from freebody.motion.phase import laws
from freebody.motion.request import Request, problem_of
from freebody.native import loop


@pytest.mark.parametrize("loaded", [False, True])
def test_a_stop_that_would_pull_opens_and_nothing_else_is_written(loaded):
    """A torque away from a stop is held by dry friction: half of it would be a pull. What came before is kept.

    No other contact presses, or one does.
    """
    s = fb.System("arm at its stop")
    arm = s.body("arm", fb.slender_bar(1, 1, axis="y"))
    joint = s.hinge("pin", s.ground, arm, axis="z", coordinate="q")
    s.stop("end", joint, high=0)
    s.friction("dry", joint, torque=1.0)
    s.torque("T", arm, (0, 0, -0.8))
    if loaded:
        block = s.body("block", fb.particle(1))
        s.slider("rail", s.ground, block, axis="y", coordinate="y")
        s.force("weight", block, (0, -9.81, 0))
        s.contact("floor", block.point(0, 0, 0), s.ground.plane(normal="y"))
    size = 6 if loaded else 4
    work = ContactRun.of(problem_of(Request(s, 1)), np.full(size, 1e-9), np.full(size, 1e-9))
    it, names = work.it, list(work.names)
    see(work, np.zeros(size))
    contacts, stop, dry = work.memory.problem, names.index("end"), names.index("dry")
    assert code("decide")(it, contacts) == 0
    it.mode[stop], it.mode[dry], it.before[:] = laws.SLIDE, laws.STICK, 7
    assert loop.code("motion.events.shares", "share")(it, contacts) == 1
    assert it.mode[stop] == laws.OPEN and it.mode[dry] == laws.STICK
    assert it.speeds[it.first[stop]] == 0 and it.speeds[it.first[dry] + 1] == pytest.approx(0.8, rel=1e-12)
    assert (it.before == 7).all()
