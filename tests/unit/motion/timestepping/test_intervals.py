"""Intervals of a motion in steps, in each of which the parameters keep their values."""

import numpy as np

from contact_machines import pushed_block
from freebody.motion.kernels.kernels import kernels_of
from freebody.motion.legs.driven import Drives
from freebody.motion.timestepping.grid import grid_of
from freebody.motion.timestepping.intervals import Intervals, Values


def test_parts_and_steps():
    one = Intervals(np.array([0, 4, 9]), np.arange(3.0)[:, None], np.array([0.0, 2.0, -1.0]))
    assert one.of_steps([0, 3, 4, 8, 9, 20]).tolist() == [0, 0, 1, 1, 2, 2]
    assert list(one.parts(0, 12)) == [(0, 0, 4), (1, 4, 9), (2, 9, 12)]
    assert list(one.parts(5, 9)) == [(1, 5, 9)]
    assert list(one.parts(9, 10)) == [(2, 9, 10)]
    assert one.work_until([0, 4, 10]).tolist() == [0.0, 2.0, 1.0]
    assert one.between(0, 9).first.tolist() == [0, 4] and one.between(0, 0).first.tolist() == [0]
    some = one.between(6, 10)  # the jump at its start is that of an earlier step
    assert some.first.tolist() == [0, 3] and some.parameters.tolist() == [[1.0], [2.0]]
    assert some.jumps.tolist() == [0.0, -1.0] and one.between(4, 5).first.tolist() == [0]


def test_values_change_once_at_each_sample():
    calls = []
    s = pushed_block((lambda t, x: calls.append(t) or 3.0 * t, 0.25))
    kernels = kernels_of(s)
    numbers = kernels.values(None)
    drives = Drives(kernels, numbers, 0.0, 1.0, 1000)
    assert drives.stops() == [0.25, 0.5, 0.75]
    grid = grid_of(0.0, 1.0, 0.1, drives.stops(), 1000)
    values = Values(kernels, numbers, drives, grid.first)
    y = np.zeros(4)
    for k in range(grid.count):
        assert values.change(k, grid.times[k], y) == (k in grid.first)
        assert not values.change(k, grid.times[k], y)
        assert values.numbers["push"] == 3 * calls[-1]
    assert calls == [0.0, 0.25, 0.5, 0.75] and values.next_change() == np.inf
    found = values.intervals()
    assert found.first.tolist() == grid.first.tolist() and not found.jumps.any()
    assert [found.numbers(kernels, int(k))["push"] for k in found.first] == [0.0, 0.75, 1.5, 2.25]
