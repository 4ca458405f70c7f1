"""Phases that are held up to a time."""

import numpy as np
import pytest

from contact_machines import at_start, block_on_feet
from freebody.motion.events import event_run, limits
from freebody.native import loop


def held(name):
    return loop.code("motion.events.speeds.held_phases", name)


def test_a_rest_is_held_for_four_times_as_long_each_time_up_to_a_limit():
    it = at_start(block_on_feet()).it
    it.hold, lengths = limits.LONGEST, []
    for _ in range(6):
        held("hold_longer")(it)
        lengths.append(it.until - it.t)
    assert lengths == pytest.approx([min(4.0**k * 1e-6, 1e-3) for k in range(1, 7)], rel=1e-12)
    it.target = 1.0
    assert held("end_of_phase")(it) == it.until
    it.holding = 0
    assert held("end_of_phase")(it) == 1.0


def test_a_phase_that_was_held_too_long_begins_anew_and_is_held_for_a_part():
    it = at_start(block_on_feet()).it
    held("keep_start")(it)
    start, it.hold = it.y.copy(), 1e-3
    it.t, it.logged = 1e-3, 3
    it.y[:] = np.arange(8)
    held("hold_shorter")(it, 8.0)
    assert (it.y == start).all() and it.t == 0 and it.logged == 0
    assert it.until == it.hold == 1e-3 / 8 and it.stage == event_run.LAUNCH
