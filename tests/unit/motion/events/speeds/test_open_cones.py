"""Open forces of contacts at rest, and their cones."""

import pytest

from contact_machines import G, at_start, block_on_feet
from freebody.motion.events.code import code
from freebody.motion.phase import laws
from freebody.native import loop

SET_UP = loop.code("motion.events.setting", "set_up")
OPEN = loop.code("motion.events.speeds.open_cones", "has_open_forces")
BEYOND = loop.code("motion.events.speeds.open_cones", "beyond_cones")


def held(load, modes=(laws.STICK, laws.STICK)):
    """The run of a block below a load, in modes."""
    work = at_start(block_on_feet(load))
    assert code("decide")(work.it, work.memory.problem) == 0
    work.it.mode[:] = modes
    SET_UP(work.it, work.memory.problem)
    return work.it


def test_friction_of_two_feet_is_open_and_that_of_one_is_not():
    assert OPEN(held(0)) == 1
    assert OPEN(held(0, (laws.STICK, laws.OPEN))) == 0


# shares in proportion to N are at their limits together, at μ m g
@pytest.mark.parametrize(("part", "beyond"), [(0.8, 0), (0.95, 1)])
def test_shares_near_their_cone_are_found(part, beyond):
    """A tenth of the limit is left, or less."""
    assert BEYOND(held(part * G), 0.1, 0) == beyond
    assert BEYOND(held(part * G), -1e-10, 0) == 0
