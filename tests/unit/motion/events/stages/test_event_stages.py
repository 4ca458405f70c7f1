"""Stages at an event."""

import pytest

from contact_machines import G, at_start, block_on_feet
from freebody.motion.events import event_run, limits
from freebody.motion.ode.layout import RUNNING
from freebody.motion.phase import laws
from freebody.native import loop


def stage(name):
    return loop.code("motion.events.stages.event_stages", name)


@pytest.mark.parametrize(("later", "crowd"), [(limits.CROWD / 2, 4), (limits.CROWD * 2, 0)])
def test_events_crowd_where_they_follow_each_other_at_once(later, crowd):
    it = at_start(block_on_feet()).it
    it.last, it.crowd, it.most_phases = 0.0, 3, 10
    it.t = later
    assert stage("arrive")(it) == RUNNING
    assert it.crowd == crowd and it.last == later and it.stage == event_run.COLLIDE


def test_events_that_do_not_end_are_too_many():
    it = at_start(block_on_feet()).it
    it.last, it.crowd, it.most_phases = 0.0, limits.ENDLESS, 10
    assert stage("arrive")(it) == event_run.TOO_MANY


@pytest.mark.parametrize(("load", "mode"), [(0.4 * G, laws.STICK), (-1.1 * G, laws.SLIDE_BACK)])
def test_a_decision_finds_the_modes_that_are_set_up_next(load, mode):
    work = at_start(block_on_feet(load))
    work.it.stage = event_run.DECIDE
    assert stage("decision")(work.it, work.memory.problem) == RUNNING
    assert work.it.mode.tolist() == [mode, mode] and work.it.stage == event_run.SET_UP
