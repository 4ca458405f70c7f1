"""Newton's method on the contact problem of a time step: the laws hold, whatever the problem."""

import numpy as np
import pytest

from cone_problems import DenseProblem, rows_of


@pytest.mark.parametrize("tangents", [1, 2])
@pytest.mark.parametrize("seed", range(1, 7))
def test_the_laws_hold_in_what_it_finds(tangents, seed):
    rng = np.random.default_rng(seed)
    contacts, n = 5, 8  # more rows than speeds: impulses are not determined
    size = 1 + tangents
    kinds = np.array([0, 0] + ([1, 2] if tangents == 1 else [1, 3, 4]) * contacts)
    W = rng.normal(size=(2 + contacts * size, n))
    A, b = W @ W.T, W @ rng.normal(size=n)
    mu = np.full(len(b), 0.4)
    # a start as sweeps leave it: a solution of another problem near by, or nothing
    x = DenseProblem(A, b, kinds, mu).polished(np.zeros(len(b)), 1e-12 * np.abs(b).max(), most=400)
    assert x is not None
    r = A @ x + b
    small = 1e-11 * np.abs(b).max()
    assert np.abs(r[:2]).max() < small
    for at in range(2, len(b), size):
        N, T, v = x[at], x[at + 1 : at + size], r[at + 1 : at + size]
        scale = small / A[at, at]
        assert scale + N > 0
        assert r[at] > -small
        assert abs(N * r[at]) < 1e-9
        assert np.linalg.norm(T) <= 0.4 * max(N, 0) + 10 * scale
        if np.linalg.norm(v) > 1e-8:  # slip: against it, at the limit
            assert pytest.approx(-0.4 * N * v / np.linalg.norm(v), abs=1e-8) == T


def test_rows_have_as_many_columns_as_directions():
    rng = np.random.default_rng(1)
    for n in (1, 3, 6):
        W = rng.normal(size=(9, n))
        A = W @ W.T
        H = rows_of(A)
        assert H.shape == (9, n)
        np.testing.assert_allclose(H @ H.T, A, atol=1e-12 * A.max())
