"""Sparse factors of rows: least squares, independent rows, and room that follows the width of the loops."""

from __future__ import annotations

import numpy as np
import pytest

from freebody.dynamics.conditions.constrained import DEPENDENT, POOR, independent_of
from freebody.motion.start.closing_record import SparseRows, sizes_of_rows
from freebody.native import loop

EPS = np.finfo(float).eps


class Factors:
    """G with the entries that are not zero, and its factors."""

    def __init__(
        self, G, scale=None, poor=DEPENDENT, small=DEPENDENT, room=None, free=None, taking_part=None
    ):
        self.m, self.n = m, n = G.shape
        rows, columns = np.nonzero(G)
        self.entries = np.ascontiguousarray(G[rows, columns])
        self.scale = np.ones(n) if scale is None else scale
        room = 4 * (m + n) * (m + n) if room is None else room
        self.rows = SparseRows.made(**sizes_of_rows(m, n, self.entries.size, room))
        self.rows.starts[:], self.rows.columns[:] = np.searchsorted(rows, range(m + 1)), columns
        self.rows.poor, self.rows.least = poor, small
        self.rows.taking_part[:] = 1 if taking_part is None else taking_part
        self.rows.free[:] = 1 if free is None else free
        self.crowded = loop.code("motion.start.sparse_rows", "factorize")(self.entries, self.scale, self.rows)

    @property
    def chosen(self):
        return tuple(np.flatnonzero(self.rows.chosen).tolist())

    def shortest(self, b):
        x = np.full(self.n, np.nan)
        assert not loop.code("motion.start.sparse_rows", "shortest")(b.copy(), x, self.scale, self.rows)
        return x


@pytest.mark.parametrize(
    ("m", "n", "rank"),
    [(3, 3, 3), (5, 2, 2), (2, 5, 2), (6, 4, 3), (4, 7, 2), (1, 1, 0), (0, 3, 0), (3, 0, 0), (9, 8, 5)],
)
def test_shortest_of_the_least_squares(m, n, rank):
    """As the singular values give it, of any shape and rank; contradictions included."""
    rng = np.random.default_rng(m + 10 * n)
    G = rng.normal(size=(m, rank)) @ rng.normal(size=(rank, n))
    b = rng.normal(size=m)
    expected = np.linalg.pinv(G, rcond=1e-9) @ b
    factors = Factors(G)
    assert len(factors.chosen) == rank
    singular = np.linalg.svd(G, compute_uv=False)
    condition = singular[0] / singular[rank - 1] if rank else 1
    error = np.abs(factors.shortest(b) - expected).max(initial=0)
    assert error <= 100 * EPS * condition**2 * (1 + np.abs(expected).max(initial=0))


@pytest.mark.parametrize("seed", range(30))
def test_sparse_and_dense_results_are_the_same(seed):
    """Random rows of few entries, some of them multiples, sums or zeros; columns and rows left out."""
    rng = np.random.default_rng(seed)
    m, n = rng.integers(1, 14, 2)
    G = rng.normal(size=(m, n)) * (rng.random((m, n)) < 0.35)
    if m > 3:
        G[m // 2], G[-1] = 2 * G[0] - G[1], 0
    scale, free = rng.uniform(0.5, 2, n), (rng.random(n) < 0.8).astype(np.int64)
    taking_part = (rng.random(m) < 0.8).astype(np.int64)
    factors = Factors(G, scale, free=free, taking_part=taking_part)
    left = G * taking_part[:, None] * free
    b = rng.normal(size=m) * taking_part
    expected = scale * (np.linalg.pinv(left * scale, rcond=1e-10) @ b)
    assert len(factors.chosen) == np.linalg.matrix_rank(left * scale, tol=1e-9)
    singular = np.linalg.svd((left * scale)[list(factors.chosen)], compute_uv=False)
    condition = singular[0] / singular[-1] if singular.size else 1.0
    error = np.abs(factors.shortest(b) - expected).max(initial=0)
    assert error <= 1000 * EPS * condition**2 * (1 + np.abs(expected).max(initial=0))


@pytest.mark.parametrize(
    ("poor", "chosen"), [(0.0, (0, 1, 3, 6)), (1e-6, (0, 1, 3, 6)), (1e-2, (0, 1, 3, 5))]
)
def test_independent_rows_are_those_of_numpy(poor, chosen):
    """A row that is nearly dependent gives way to a later one."""
    rng = np.random.default_rng(3)
    for _ in range(20):
        G = rng.normal(size=(7, 5))
        G[2], G[4], G[5] = 3 * G[0], 0, G[0] - 2 * G[1] + poor * G[6]
        M = np.diag(rng.uniform(0.1, 10, 5))
        factors = Factors(G, 1 / np.sqrt(M.diagonal()), POOR, DEPENDENT)
        assert factors.chosen == independent_of(G, M) == chosen


def chain(loops):
    """Rows of a row of four-bars: two conditions of each loop, three speeds, of which it shares two with others."""
    rng = np.random.default_rng(loops)
    G = np.zeros((2 * loops, 2 * loops + 1))
    for i in range(loops):
        G[2 * i : 2 * i + 2, 2 * i : 2 * i + 3] = rng.normal(size=(2, 3))
    return G


def test_the_width_of_the_factors_does_not_grow_with_the_row():
    counts = {}
    for loops in (20, 40, 80):
        factors = Factors(chain(loops))
        counts[loops] = np.array([factors.rows.rank, factors.rows.filled_v, factors.rows.filled_r])
        assert factors.chosen == tuple(range(2 * loops))
    growth = (counts[80] - counts[40], counts[40] - counts[20])
    assert (growth[0] == 2 * growth[1]).all()
    assert counts[80][1] <= 80 * 2 * 6


def test_too_little_room_is_told():
    assert Factors(chain(5), room=8).crowded == 1
    assert Factors(chain(5), room=8 * 16).crowded == 0


@pytest.mark.parametrize("n", [1, 5, 12])
def test_factors_of_matrices_with_zeros(n):
    """Arrow and band: L Lᵀ = M to the round-off of n products, with zeros where M begins with zeros."""
    rng = np.random.default_rng(n)
    L = np.tril(rng.normal(size=(n, n))) * (np.abs(np.subtract.outer(range(n), range(n))) < 3)
    L[-1] = rng.normal(size=n)
    np.fill_diagonal(L, rng.uniform(1, 2, n))
    M = L @ L.T
    factor = M.copy()
    loop.code("motion.start.sparse_rows", "cholesky")(factor, n)
    assert np.abs(np.tril(factor) @ np.tril(factor).T - M).max() <= 4 * n * EPS * M.diagonal().max()
    assert (np.tril(factor)[:-1][np.tril(L)[:-1] == 0] == 0).all()
    bad = M.copy()
    bad[0, 0] = -1.0
    loop.code("motion.start.sparse_rows", "cholesky")(bad, n)
    assert np.isnan(bad[0, 0])
