"""Modes that a step of the speeds leaves."""

import pytest

from contact_machines import G, at_start, block_on_feet
from freebody.motion.phase import laws
from freebody.native import loop

STEP = loop.code("motion.events.speeds.speed_step", "step_of_speeds")
MODES = loop.code("motion.events.speeds.step_modes", "modes_of_step")


@pytest.mark.parametrize(("speed", "mode"), [(1.0, laws.SLIDE_ON), (-1.0, laws.SLIDE_BACK)])
def test_a_slip_has_the_sense_of_its_speed(speed, mode):
    work = at_start(block_on_feet(), speed)
    assert STEP(work.it, work.memory.problem, 1e-7) == 1
    assert MODES(work.it, work.memory.problem) == 0
    assert work.it.mode.tolist() == [mode, mode]


def test_two_feet_at_rest_have_forces_that_may_be_open():
    work = at_start(block_on_feet(load=0.4 * G))
    assert STEP(work.it, work.memory.problem, 1e-7) == 1
    assert MODES(work.it, work.memory.problem) == 1
    assert work.it.mode.tolist() == [laws.STICK, laws.STICK]


def test_a_slip_that_begins_has_no_direction_yet():
    work = at_start(block_on_feet(load=1.1 * G))
    assert STEP(work.it, work.memory.problem, 1e-12) == 1
    assert MODES(work.it, work.memory.problem) == -1
