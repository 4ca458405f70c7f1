"""Sweeps solve the same problem as Newton's method: the laws hold, and where the motion is unique it is the same."""

import numpy as np
import pytest

from cone_problems import DenseProblem
from freebody.motion.cones.contact_problem import FIRST, LINE, NORMAL, SECOND, Sweeping
from freebody.native import loop

MOST = 20_000


def swept(dense, tolerance=1e-12):
    """Impulses by sweeps from zero, their residual, and the number of sweeps."""
    dense.from_zero()  # sets the rows
    problem = dense.memory
    problem.x[:] = 0.0
    used = loop.code("motion.cones.sweeps", "solve")(
        problem, Sweeping.made(most=len(dense.b)), tolerance, MOST
    )
    return problem.x.copy(), problem.residual, used


@pytest.mark.parametrize("kinds", [[NORMAL], [NORMAL, LINE], [NORMAL, FIRST, SECOND]])
@pytest.mark.parametrize("seed", range(8))
def test_sweeps_and_newton_agree(kinds, seed):
    rng = np.random.default_rng(seed)
    contacts, m = 4, 4 * len(kinds)
    W = rng.normal(size=(m, m + 3))
    A, b = W @ W.T, W @ rng.normal(size=m + 3)
    mu = 0.05 if len(kinds) > 1 else 0.0  # little friction: the solution is unique
    dense = DenseProblem(A, b, kinds * contacts, [mu] * m)
    by_newton, left, _ = dense.from_zero()
    x, residual, used = swept(dense)
    assert used >= 0
    assert residual <= 1e-12 and left <= 1e-11
    assert dense.rated(x, A @ x + b) <= 2e-12
    np.testing.assert_allclose(x, by_newton, atol=1e-9 * np.abs(x).max(initial=1e-3))


def test_rows_without_friction_press_from_any_low_on():
    """In displacements a pull that a later one takes back is a least push: sweeps stayed at zero, below it."""
    rng = np.random.default_rng(3)
    W = rng.normal(size=(6, 9))
    A, b, low = W @ W.T, W @ rng.normal(size=9), [0.3, -0.2, 0.1, 0.0, 0.5, -0.1]
    dense = DenseProblem(A, b, [NORMAL] * 6, [0.0] * 6, low)
    x, residual, used = swept(dense)
    assert used > 0 and residual <= 1e-12
    r = A @ x + b
    assert (x >= low).all() and r.min() >= -1e-11
    assert np.minimum(r, x - low) == pytest.approx(0.0, abs=1e-11)


RESISTING = [NORMAL, FIRST, SECOND, FIRST, SECOND, LINE]
"""A contact with friction, that resists rolling and spinning."""
BETWEEN = [0, 0, 0, 2, 0, 4]


@pytest.mark.parametrize("seed", range(8))
def test_sweeps_and_newton_agree_on_what_resists_rolling(seed):
    rng = np.random.default_rng(seed)
    contacts, m = 3, 18
    W = rng.normal(size=(m, m + 3))
    A, b = W @ W.T, W @ rng.normal(size=m + 3)
    dense = DenseProblem(A, b, RESISTING * contacts, [0.05] * m)
    dense.memory.between[:m] = BETWEEN * contacts
    by_newton, left, _ = dense.from_zero()
    x, residual, used = swept(dense)
    assert used >= 0
    assert residual <= 1e-12 and left <= 1e-11
    r = A @ x + b
    for a in range(0, m, 6):
        limit = 0.05 * x[a]
        assert min(x[a], r[a]) == pytest.approx(0, abs=1e-11)
        for part in (slice(a + 1, a + 3), slice(a + 3, a + 5), slice(a + 5, a + 6)):
            T, v = x[part], r[part]
            assert np.linalg.norm(T) <= limit * (1 + 1e-9) + 1e-12
            slips = np.linalg.norm(v) > 1e-9
            assert not slips or np.allclose(T * np.linalg.norm(v), -limit * v, atol=1e-9)
    np.testing.assert_allclose(x, by_newton, atol=1e-9 * np.abs(x).max(initial=1e-3))


def test_sweeps_find_what_a_wedge_shares():
    """Two walls that hold a body against a load: more impulses than freedoms, and no laws broken."""
    W = np.array([[0.6, 0.8], [0.8, -0.6], [-0.6, 0.8], [0.8, 0.6]])  # normal, tangent of each wall
    dense = DenseProblem(W @ W.T, W @ [0.3, -2.0], [NORMAL, LINE] * 2, [0.5] * 4)
    x, residual, used = swept(dense)
    assert used >= 0 and residual <= 1e-12
    assert np.abs(W.T @ x + [0.3, -2.0]).max() < 1e-12  # it stays


def test_a_problem_without_a_solution_is_said_to_have_none():
    """One freedom, along which friction presses harder than the normal opens: r_N = s - 1, r_T = 100 + 3 s, and slip
    allows only s = x_N (1 - 3 μ) <= 0."""
    dense = DenseProblem(np.outer([1.0, 3], [1, 3]), np.array([-1.0, 100]), [NORMAL, LINE], [0, 2.0])
    _, residual, used = swept(dense)
    assert used == -1
    assert not residual <= 1e-12
