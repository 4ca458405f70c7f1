"""Reference problems of the field, as `python -m benchmarks references` prints them."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

import freebody as fb

sys.path.insert(0, str(Path(__file__).parents[2]))
problems = pytest.importorskip("benchmarks.problems", reason="benchmarks are not in the package")
minimal = pytest.importorskip("benchmarks.minimal", reason="benchmarks are not in the package")
sys.path.pop(0)


def test_simple_pendulum() -> None:
    assert problems.pendulum_reached(1e-12).error < 1e-10


def test_heavy_top_of_the_lie_group_literature() -> None:
    assert problems.lie_top_reached(1e-12).error < 1e-10


def test_andrews_squeezer_ends_at_the_published_angles() -> None:
    """The published digits are good to about 3e-10: dop853 at 1e-13 and gauss at 1e-14 agree to 1e-14."""
    assert problems.andrews_reached(1e-12).error < 5e-10


def test_four_bars_pass_their_singular_positions() -> None:
    t = np.linspace(0, 10, 2001)
    angle = minimal.four_bars(2, t)
    level = np.flatnonzero(np.diff(np.floor(angle / np.pi)))
    assert level.size == 10  # as often the constraints lose their direction
    speed = np.gradient(angle, t)
    assert abs(angle[0] - np.pi / 2) < 1e-14 and speed[0] == pytest.approx(-1, abs=1e-2)
    # how near a step comes to such a position, and so what round-off makes of it, is chance: the middle of many steps
    errors = [problems.four_bars_reached(2, 10.0, float(h)).error for h in np.linspace(0.008, 0.0125, 41)]
    assert np.median(errors) < 1e-7


def test_the_exact_four_bars_keep_their_energy() -> None:
    t = np.linspace(0, 3, 3001)
    for n in (1, 2, 40):
        angle = minimal.four_bars(n, t)
        rate = np.gradient(angle, t, edge_order=2)[1:-1]
        energy = 0.5 * ((n + 1) / 3 + n) * rate**2 + ((n + 1) / 2 + n) * 9.81 * np.sin(angle[1:-1])
        assert np.ptp(energy) < 1e-4 * energy.max()  # differences of step 1e-3: error h²/6 φ'''


def test_ten_four_bars_pass_a_singular_position() -> None:
    """Ten loops, of which all but one lose a constraint when the cranks are level, at 0.7 s."""
    assert minimal.four_bars(10, 1.0) < 0 < minimal.four_bars(10, 0.5)
    assert problems.four_bars_reached(10, 1.0, 0.04).error < 1e-8


def test_curve_of_bricards_configurations_closes() -> None:
    """The last rod ends on the sixth hinge, whose axis, along x, it carries; equal to round-off of five turns."""
    for w in np.linspace(0, 2 * np.pi, 41):
        _, _, ends, axes = minimal.bricard_shape(w)
        assert np.abs(ends[-1] - [0, 0, 1]).max() < 1e-14
        assert np.abs(axes[:, 0] - [1, 0, 0]).max() < 1e-14


def test_bricards_mechanism_moves() -> None:
    """Five angles, five conditions of closure, one degree of freedom, against one equation of motion."""
    assert problems.bricard_reached(1e-12).error < 1e-10


def test_flyball_governor() -> None:
    """Springs of 8e5 N/m with dampers of 4e4 N s/m, through the first second, against two equations of motion."""
    assert problems.flyball_reached(1e-12, 1.0).error < 1e-11


def test_ledgers_of_bricards_mechanism_and_of_the_governor() -> None:
    """Energy constant in the one; in the other only dampers take some, and what they take is what is missing."""
    start = {f"q{i}": 0.0 for i in range(1, 6)} | {f"q{i}'": 0.0 for i in range(1, 6)}
    mechanism = fb.simulate(problems.bricard(), 5, initial=start, tolerance=1e-10, samples=41).energy
    assert np.ptp(mechanism.kinetic + mechanism.potential) < 1e-8 * mechanism.kinetic.max()
    start = {"phi": 0.0, "phi'": 2 * np.pi, "s": 0.5, "alpha1": np.pi / 6, "alpha2": np.pi / 6}
    governor = fb.simulate(problems.flyball(), 2, initial=start, tolerance=1e-10, samples=41).energy
    assert governor.work[-1] < -1e-5 and np.all(np.diff(governor.work) <= 0)
    assert np.abs(governor.residual).max() < 1e-8 * governor.kinetic.max()
