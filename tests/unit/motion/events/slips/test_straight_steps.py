"""A straight step goes on with the accelerations at its start, and ends where a contact closes."""

import numpy as np
import pytest

import freebody as fb
from contact_machines import G
from freebody.motion.contact.starting_modes import see
from freebody.motion.contact.state import ContactRun
from freebody.motion.request import Request, problem_of
from freebody.native import loop


@pytest.mark.parametrize("height", [4e-7, 2e-6])
def test_a_straight_step_ends_where_a_point_lands(height):
    """It falls by v s + g s²/2, and lands within the microsecond or not."""
    s = fb.System("falling point")
    point = s.body("point", fb.particle(1))
    s.slider("rail", s.ground, point, axis="y", coordinate="y")
    s.contact("floor", point.point(0, 0, 0), s.ground.plane(normal="y"))
    work = ContactRun.of(problem_of(Request(s, 1)), np.full(4, 1e-9), np.full(4, 1e-9))
    it, speed = work.it, 1.0
    see(work, np.array([height, -speed, 0, 0]))
    it.start[:], it.step[:] = it.y, [0, -G, 0, 0]
    passed = loop.code("motion.events.slips.straight_steps", "go_straight")(it, 1e-6)
    lands = (np.sqrt(speed**2 + 2 * G * height) - speed) / G
    assert passed == pytest.approx(min(lands, 1e-6), abs=1e-6 / 2**32 + 1e-15)
    assert it.t == passed and it.y[1] == -speed - G * passed
    assert it.y[0] == pytest.approx(height - speed * passed - G * passed**2 / 2, abs=1e-21)
