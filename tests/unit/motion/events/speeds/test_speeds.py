"""Motion by steps of the speeds that follow each other."""

import pytest

from contact_machines import G, at_start, block_on_feet
from freebody.motion.events import event_run, limits
from freebody.native import loop

PASS = loop.code("motion.events.speeds.speeds", "decided_by_speeds")


def test_steps_grow_to_twice_their_length_up_to_the_longest():
    work = at_start(block_on_feet(), speed=1.0)
    it, lengths = work.it, []
    for _ in range(6):
        before = it.t
        assert PASS(it, work.memory.problem, 1.0) == 1
        lengths.append(it.t - before)
    assert lengths == pytest.approx([1e-7, 2e-7, 4e-7, 8e-7, 1e-6, 1e-6], rel=1e-9)
    assert it.y[3] == pytest.approx(1 - 0.5 * G * it.t, abs=1e-14)
    assert it.stage == event_run.ARRIVE


def test_a_step_beyond_the_end_is_not_passed():
    work = at_start(block_on_feet(), speed=1.0)
    assert PASS(work.it, work.memory.problem, limits.SHORTEST / 2) == 0
    assert work.it.t == 0


def test_feet_at_rest_are_held():
    work = at_start(block_on_feet(load=0.4 * G))
    assert PASS(work.it, work.memory.problem, 1.0) == 1
    assert work.it.holding == event_run.AT_REST
    assert work.it.until - work.it.t == pytest.approx(limits.LONGEST, rel=1e-9)
