"""Reference problems of the field, as `python -m benchmarks references` prints them."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[2]))
problems = pytest.importorskip("benchmarks.problems", reason="benchmarks are not in the package")
sys.path.pop(0)


def test_simple_pendulum() -> None:
    assert problems.pendulum_error(1e-12) < 1e-10


def test_heavy_top_of_the_lie_group_literature() -> None:
    assert problems.lie_top_error(1e-12) < 1e-10


def test_andrews_squeezer_ends_at_the_published_angles() -> None:
    """The published digits are good to about 3e-10: a tolerance of 1e-9 and one of 1e-12 miss them by the same."""
    assert problems.andrews_error(1e-12) < 5e-10


def test_four_bars_pass_their_singular_positions() -> None:
    t = np.linspace(0, 10, 2001)
    angle = problems.four_bars_exact(2, t)
    level = np.flatnonzero(np.diff(np.floor(angle / np.pi)))
    assert level.size == 10  # as often the constraints lose their direction
    speed = np.gradient(angle, t)
    assert abs(angle[0] - np.pi / 2) < 1e-14 and speed[0] == pytest.approx(-1, abs=1e-2)
    assert problems.four_bars_error(2, 10.0, 0.01) < 1e-8


def test_the_exact_four_bars_keep_their_energy() -> None:
    t = np.linspace(0, 3, 3001)
    for n in (1, 2, 40):
        angle = problems.four_bars_exact(n, t)
        rate = np.gradient(angle, t, edge_order=2)[1:-1]
        energy = 0.5 * ((n + 1) / 3 + n) * rate**2 + ((n + 1) / 2 + n) * 9.81 * np.sin(angle[1:-1])
        assert np.ptp(energy) < 1e-4 * energy.max()  # differences of step 1e-3: error h²/6 φ'''
