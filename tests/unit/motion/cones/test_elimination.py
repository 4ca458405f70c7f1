"""Elimination in blocks against a dense solver, with and without entries far from the diagonal."""

import numpy as np
import pytest

from freebody.motion.cones.contact_problem import Blocks
from freebody.native.loop import code

ELIMINATION = "motion.cones.elimination"


@pytest.mark.parametrize("seed", range(5))
def test_blocks_are_eliminated_as_a_whole_matrix_is(seed):
    rng = np.random.default_rng(seed)
    sizes = rng.integers(1, 7, 9)
    starts = np.concatenate([[0], np.cumsum(sizes)])
    n, reach = int(starts[-1]), np.minimum(np.arange(9) + rng.integers(1, 4, 9), 9)
    last = np.maximum.accumulate(reach)
    a = np.zeros((n, n))
    for b in range(9):
        i, k = starts[b], starts[last[b]]
        a[i:k, i : starts[b + 1]] = rng.normal(size=(k - i, sizes[b]))
        a[i : starts[b + 1], i:k] = rng.normal(size=(sizes[b], k - i))
    a += 4 * n**0.5 * np.diag(rng.choice([-1, 1], n))  # pivots from other blocks are not looked for
    x, factors = rng.normal(size=n), a.copy()
    blocks = Blocks.made()
    blocks.n, blocks.count, blocks.starts = n, 9, starts
    ends, order, found = starts[last], np.zeros(n, dtype=np.int64), a @ x
    assert code(ELIMINATION, "factored")(factors.reshape(-1), blocks, ends, order) == 1
    code(ELIMINATION, "substitute")(factors.reshape(-1), blocks, ends, order, found)
    rounding = np.finfo(float).eps * n * np.linalg.cond(a)
    np.testing.assert_allclose(found, x, atol=rounding * np.abs(x).max())


def test_one_block_takes_pivots_from_its_rows_and_a_singular_one_is_told():
    a = np.array([[0.0, 2.0], [3.0, 1.0]])
    blocks = Blocks.made()
    blocks.n, blocks.count, blocks.starts = 2, 1, np.array([0, 2])
    ends, order, x = np.array([2]), np.zeros(2, dtype=np.int64), np.array([4.0, 5.0])
    factors = a.copy()
    assert code(ELIMINATION, "factored")(factors.reshape(-1), blocks, ends, order) == 1
    code(ELIMINATION, "substitute")(factors.reshape(-1), blocks, ends, order, x)
    np.testing.assert_allclose(a @ x, [4, 5], rtol=1e-15)
    assert code(ELIMINATION, "factored")(np.array([1.0, 2.0, 2.0, 4.0]), blocks, ends, order) == 0
