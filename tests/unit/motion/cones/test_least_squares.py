"""Newton's method on the laws, and the dual method without friction: their results satisfy the laws."""

import numpy as np
import pytest

from cone_problems import DenseProblem
from freebody.motion.cones.contact_problem import FIRST, NORMAL, SECOND, Dense
from freebody.native import loop


def solved(name, dense, *options):
    """Return the impulses that a method finds from zero, and their residual."""
    dense.from_zero()  # sets the rows
    problem, most = dense.memory, len(dense.b)
    problem.x[:] = 0.0
    room = Dense.made(most=most, squares=most * most)
    loop.code("motion.cones.least_squares", "lay_dense")(problem, room)
    residual = loop.code("motion.cones.least_squares", name)(problem, room, 1e-12, *options)
    return problem.x.copy(), residual


@pytest.mark.parametrize("seed", range(20))
def test_the_dual_method_solves_every_problem_without_friction(seed):
    rng = np.random.default_rng(seed)
    m, n = 12, 5  # more conditions than directions: rows depend on each other
    W = rng.normal(size=(m, n))
    W[6:9] = W[:3] + W[3:6]
    A, b = W @ W.T, W @ rng.normal(size=n) + rng.uniform(0, 1, m)
    x, residual = solved("take_in", DenseProblem(A, b, [NORMAL] * m, [0.0] * m))
    assert residual <= 1e-12
    assert (x >= 0).all()
    assert ((x > 0) <= (np.abs(A @ x + b) < 1e-10)).all()


def test_the_dual_method_says_that_conditions_contradict_each_other():
    A = np.array([[1.0, -1.0], [-1.0, 1.0]])
    _, residual = solved("take_in", DenseProblem(A, [-1.0, -1.0], [NORMAL] * 2, [0.0] * 2))
    assert not residual <= 1.0


@pytest.mark.parametrize("seed", range(8))
def test_the_laws_hold_in_what_newtons_method_finds(seed):
    rng = np.random.default_rng(seed)
    contacts = 4
    W = rng.normal(size=(3 * contacts, 8))
    A, b = W @ W.T, W @ rng.normal(size=8)
    dense = DenseProblem(A, b, [NORMAL, FIRST, SECOND] * contacts, [0.1] * (3 * contacts))
    x, residual = solved("descend", dense, 25)
    assert residual <= 1e-12
    assert dense.rated(x, A @ x + b) <= 2e-12
