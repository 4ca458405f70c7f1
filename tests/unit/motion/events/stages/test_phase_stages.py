"""Stages of a phase."""

import math

import pytest

from contact_machines import G, at_start, block_on_feet
from freebody.motion.events import event_run
from freebody.motion.events.code import code
from freebody.native import loop

SET_UP = loop.code("motion.events.setting", "set_up")


def stage(name):
    return loop.code("motion.events.stages.phase_stages", name)


def sliding():
    """The run of a block that slides, with its modes set up."""
    work = at_start(block_on_feet(), speed=1.0)
    assert code("decide")(work.it, work.memory.problem) == 0
    SET_UP(work.it, work.memory.problem)
    return work


def test_rates_are_defined_at_a_finite_state():
    it = sliding().it
    assert stage("is_defined")(it) == 1
    assert it.step[3] == pytest.approx(-0.5 * G, rel=1e-12)
    it.y[3] = math.nan
    assert stage("is_defined")(it) == 0


def test_steps_begin_at_the_state_and_go_to_the_end_of_the_phase():
    work = sliding()
    it, run = work.it, work.memory.steps
    it.t, it.longest = 0.25, 0.125
    stage("begin_steps")(it, run, 0.75)
    assert (run.t, run.start, run.until, run.longest) == (0.25, 0.25, 0.75, 0.125)
    assert (run.initial[: it.n_y] == it.y).all() and it.stage == event_run.FOLLOW


@pytest.mark.parametrize("halting", [0, 1])
def test_a_slip_that_has_only_begun_goes_on_from_the_state_before(halting):
    work = sliding()
    it = work.it
    it.before[:], it.way_before[:] = it.mode, it.way
    it.kept[:], it.begun, it.halting, it.stage = it.y, 0, halting, event_run.HALTED
    kept = it.y.copy()
    it.y[3] = 0.0
    stage("judge")(it, work.memory.steps, work.memory.problem)
    assert (it.y == kept).all()
    assert it.stage == (event_run.FOLLOW if halting else event_run.HALT)
