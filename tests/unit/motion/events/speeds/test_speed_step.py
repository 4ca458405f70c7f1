"""A short step of the speeds alone has the contact problem of its own."""

import pytest

from contact_machines import G, at_start, block_on_feet
from freebody.native import loop

STEP = loop.code("motion.events.speeds.speed_step", "step_of_speeds")
LENGTH = 1e-7


def test_a_slip_slows_by_friction_and_heats():
    """u⁺ = u - μ g h, and the heat is μ m g times the way."""
    work = at_start(block_on_feet(), speed=1.0)
    it = work.it
    assert STEP(it, work.memory.problem, LENGTH) == 1
    after = 1 - 0.5 * G * LENGTH
    assert it.t == LENGTH and it.y[3] == pytest.approx(after, abs=1e-15)
    assert it.y[0] == pytest.approx(LENGTH * (1 + after) / 2, rel=1e-14)
    assert it.y[7] == pytest.approx(0.5 * 2 * G * it.y[0], rel=1e-8)


@pytest.mark.parametrize("part", [0.9, 1.1])
def test_a_body_stays_at_rest_up_to_the_limit_of_friction(part):
    work = at_start(block_on_feet(load=part * 0.5 * 2 * G))
    assert STEP(work.it, work.memory.problem, LENGTH) == 1
    assert work.it.y[3] == pytest.approx(max(part - 1, 0) * 0.5 * G * LENGTH, abs=1e-15)


def test_nothing_is_passed_where_nothing_touches():
    work = at_start(block_on_feet())
    work.it.closed[:] = 0
    work.it.gap[:] = 1.0
    before = work.it.y.copy()
    assert STEP(work.it, work.memory.problem, LENGTH) == 0
    assert work.it.t == 0 and (work.it.y == before).all()
