"""Where a quantity is greatest in phases: at zeros of its rate, and on both sides of every jump."""

from types import SimpleNamespace

import numpy as np
import pytest

from freebody.motion.ending import End
from freebody.motion.trajectory.peaks import peaks
from freebody.motion.trajectory.phases import Phases


def phase(start, end, steps=4):
    times = np.linspace(start, end, steps + 1)
    path = SimpleNamespace(times=times, start=times[0], end=times[-1], steps=steps, curved=True)
    return SimpleNamespace(path=path)


def test_zeros_of_the_rate_and_ends_of_phases():
    """x = sin t up to 4, and 2 + cos t from there."""
    first, second = phase(0.0, 4.0), phase(4.0, 8.0)
    path = Phases((first, second), End.FINISHED)

    def course(t, segment):
        x, rate = (np.sin(t), np.cos(t)) if segment is first else (2 + np.cos(t), -np.sin(t))
        return np.stack([x, rate], axis=1)

    inside = {(one.time, one.value) for one in peaks(path, course, 1, "x") if one.end == 0}
    assert sorted(inside) == [pytest.approx((np.pi / 2, 1)), pytest.approx((2 * np.pi, 3))]
    ends = [(one.time, one.value) for one in peaks(path, course, 1, "x") if one.end]
    assert ends == [
        (0, 0),
        (4, pytest.approx(np.sin(4))),
        (4, pytest.approx(2 + np.cos(4))),
        (8, pytest.approx(2 + np.cos(8))),
    ]
    lowest = [one for one in peaks(path, course, -1, "x") if one.end == 0]
    assert lowest == []  # the least value, sin 4, is at the end of the first phase
