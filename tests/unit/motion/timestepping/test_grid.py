"""The times of steps: equal between stops, none longer than asked for."""

import numpy as np
import pytest

from freebody.errors import SimulationError
from freebody.motion.timestepping.grid import grid_of


def test_without_stops_all_steps_are_equal():
    grid = grid_of(0.5, 2.0, 0.1, (), 1000)
    assert grid.count == 15 and grid.longest == pytest.approx(0.1, rel=1e-12) and grid.first.tolist() == [0]
    np.testing.assert_array_equal(grid.times[:-1], 0.5 + grid.lengths[0] * np.arange(15))
    assert grid.times[-1] == 2.0
    assert grid_of(0, 1, 0.3, (), 1000).count == 4  # shorter than asked for, none is longer
    assert grid_of(1, 1, 0.3, (), 1000).count == 0 and grid_of(1, 1, 0.3, (), 1000).longest == 0.3


def test_random_stops_end_steps():
    rng = np.random.default_rng(5)
    for _ in range(50):
        stops = np.sort(rng.uniform(0.01, 0.99, rng.integers(0, 20)))
        step = rng.uniform(1e-3, 0.3)
        grid = grid_of(0, 1, step, stops.tolist(), 10**6)
        assert grid.times[0] == 0 and grid.times[-1] == 1 and len(grid.times) == grid.count + 1
        np.testing.assert_array_equal(grid.times[grid.first], np.concatenate([[0], stops]))
        np.testing.assert_allclose(np.diff(grid.times), grid.lengths, rtol=0, atol=1e-15)
        assert grid.lengths.max() <= step * (1 + 1e-9)
        spans = np.diff(np.concatenate([[0], stops, [1]]))
        assert (np.diff(np.append(grid.first, grid.count)) <= np.ceil(spans / step)).all()
        for time in rng.uniform(0, 1, 20):
            k = grid.step_at(time)
            assert grid.times[k] <= time <= grid.times[k + 1]
        assert grid.step_at(1.0) == grid.count - 1


def test_too_many_steps():
    with pytest.raises(
        SimulationError, match=r"at most 10 steps, got step = 0.05 s, which makes 20. Take a longer"
    ):
        grid_of(0, 1, 0.05, (), 10)
    with pytest.raises(
        SimulationError, match=r"got step = 0.5 s and 19 break points and samples, .* makes 20"
    ):
        grid_of(0, 1, 0.5, np.linspace(0, 1, 21)[1:-1].tolist(), 10)
