"""The dual method without friction: its results satisfy the laws, also where conditions depend on each other."""

import numpy as np
import pytest

from cone_problems import DenseProblem
from freebody.motion.cones.contact_problem import NORMAL, Dense
from freebody.native import loop


def solved(dense, guess=0.0):
    """Return the impulses that the method finds from zero or a guess, and their residual."""
    dense.from_zero()  # sets the rows
    problem, most = dense.memory, len(dense.b)
    problem.x[:] = guess
    room = Dense.made(most=most, squares=most * most, n=problem.blocks.n)
    residual = loop.code("motion.cones.dual", "take_in")(problem, room, 1e-12, 0)
    return problem.x.copy(), residual


@pytest.mark.parametrize("seed", range(20))
def test_the_dual_method_solves_every_problem_without_friction(seed):
    rng = np.random.default_rng(seed)
    m, n = 12, 5  # more conditions than directions: rows depend on each other
    W = rng.normal(size=(m, n))
    W[6:9] = W[:3] + W[3:6]
    A, b = W @ W.T, W @ rng.normal(size=n) + rng.uniform(0, 1, m)
    x, residual = solved(DenseProblem(A, b, [NORMAL] * m, [0.0] * m))
    assert residual <= 1e-12
    assert (x >= 0).all()
    assert ((x > 0) <= (np.abs(A @ x + b) < 1e-10)).all()
    for guess in (x, rng.uniform(-1, 1, m), np.ones(m)):  # the rows that it holds first change nothing
        other, residual = solved(DenseProblem(A, b, [NORMAL] * m, [0.0] * m), guess)
        assert residual <= 1e-12
        assert (other >= 0).all() and np.abs(A @ (other - x)).max() < 1e-9


def test_the_dual_method_says_that_conditions_contradict_each_other():
    A = np.array([[1.0, -1.0], [-1.0, 1.0]])
    _, residual = solved(DenseProblem(A, [-1.0, -1.0], [NORMAL] * 2, [0.0] * 2))
    assert not residual <= 1.0


@pytest.mark.parametrize("seed", range(5))
def test_a_problem_with_the_rows_of_the_last_one_begins_with_its_factor(seed):
    rng = np.random.default_rng(seed)
    m, n = 12, 5
    W = rng.normal(size=(m, n))
    A, inside = W @ W.T, W @ rng.normal(size=n) + rng.uniform(0, 1, m)
    dense = DenseProblem(A, inside, [NORMAL] * m, [0.0] * m)
    dense.from_zero()
    problem, room = dense.memory, Dense.made(most=m, squares=m * m, n=dense.memory.blocks.n)
    solve = loop.code("motion.cones.dual", "take_in")
    problem.x[:] = 0.0
    assert solve(problem, room, 1e-12, 0) <= 1e-12
    for change in (1.0, 0.1, 0.0):  # of the rates: other conditions press, nearly the same, and the same
        problem.b[:m] = inside + change * (W @ rng.normal(size=n))
        assert solve(problem, room, 1e-12, 1) <= 1e-12
        x = problem.x[:m].copy()
        problem.x[:] = 0.0
        assert solve(problem, room, 1e-12, 0) <= 1e-12
        assert (x >= 0).all() and np.abs(A @ (x - problem.x[:m])).max() < 1e-9
