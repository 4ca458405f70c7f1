"""Blocks of the inertia, factored within their band, against a dense solver."""

import numpy as np
import pytest

from freebody.native.loop import code

ELIMINATION = "motion.moreau.elimination"


@pytest.mark.parametrize("band", range(6))
def test_a_block_is_solved_within_its_band(band):
    rng = np.random.default_rng(band)
    a = np.tril(np.triu(rng.normal(size=(6, 6)), -band))
    M, b = a @ a.T + np.eye(6), rng.normal(size=6)
    assert code(ELIMINATION, "band")(M.reshape(-1), 6) == band
    L, x = np.full(36, np.nan), np.zeros(6)  # what is outside of the band is not read
    assert code(ELIMINATION, "cholesky")(M.reshape(-1), L, 6, band) == 1
    code(ELIMINATION, "back")(L, 6, band, b, x)
    rounding = np.finfo(float).eps * 6 * np.linalg.cond(M)
    np.testing.assert_allclose(x, np.linalg.solve(M, b), atol=rounding * np.abs(x).max())


def test_a_block_that_is_not_positive_definite_is_told():
    M = np.diag([1.0, -1.0])
    assert code(ELIMINATION, "cholesky")(M.reshape(-1), np.zeros(4), 2, 0) == 0
