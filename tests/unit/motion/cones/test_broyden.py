"""Numbers that agree with what follows from them, where repeating the function diverges."""

import numpy as np
import pytest

from freebody.motion.cones.broyden import TURNS
from freebody.native.loop import code


def found(f, n):
    """The P at which f(P) = P to round-off, and the number of turns."""
    begin, missed, take = (code("motion.cones.broyden", name) for name in ("begin", "missed", "take"))
    memory = np.full(n * (5 + n), np.nan)
    begin(memory, n)
    for turn in range(TURNS):
        P = memory[:n].copy()
        values = f(P)
        if max(missed(memory, n, i, float(values[i])) for i in range(n)) <= 1e-14 * np.abs(values).max():
            return P, turn
        take(memory, n)
    return P, TURNS


@pytest.mark.parametrize("seed", range(5))
def test_affine_functions_with_a_great_slope_have_their_numbers(seed):
    rng = np.random.default_rng(seed)
    P, slope = rng.uniform(1, 2, 4), -np.abs(rng.normal(size=(4, 4))) @ np.diag([3.0, 0, 0, 0])
    result, turns = found(lambda x: P + slope @ (x - P), 4)
    assert turns <= 12
    np.testing.assert_allclose(result, P, rtol=1e-12)


def test_a_slope_below_minus_one_that_ends_at_zero():
    result, turns = found(lambda x: np.maximum(3 - 5 * x, 0), 1)
    assert turns < 20 and abs(result[0] - 0.5) < 1e-14


def test_a_slope_above_one_that_ends_leads_upwards():
    result, turns = found(lambda x: np.minimum(1 + 1.5 * x, 40), 1)
    assert turns < 20 and abs(result[0] - 40) < 1e-12


def test_what_falls_from_above_itself_to_below_has_none():
    assert found(lambda x: np.where(x < 1, 2.0, 0.0), 1)[1] == TURNS
