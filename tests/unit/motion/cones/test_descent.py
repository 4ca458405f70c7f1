"""Newton's method on the laws in the speeds: what it finds satisfies them, also where forces are open."""

import numpy as np
import pytest

from cone_problems import DenseProblem
from freebody.motion.cones.contact_problem import FIRST, LINE, NORMAL, SECOND, Newton, Sweeping
from freebody.native import loop


@pytest.mark.parametrize("kinds", [[NORMAL], [NORMAL, LINE], [NORMAL, FIRST, SECOND]])
@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize(
    "augmented", [0, 1]
)  # the limit of friction of the normal force, or of that and its rate
def test_the_laws_hold_in_what_it_finds_after_a_few_sweeps(kinds, seed, augmented):
    rng = np.random.default_rng(seed)
    m, n = 4 * len(kinds), 8  # with two tangents more rows than directions: forces are open
    W = rng.normal(size=(m, n))
    A, b = W @ W.T, W @ rng.normal(size=n)
    dense = DenseProblem(A, b, kinds * 4, [0.1] * m)
    dense.from_zero()  # sets the rows
    problem = dense.memory
    problem.x[:] = 0.0
    loop.code("motion.cones.sweeps", "solve")(problem, Sweeping.made(most=m), 1e-12, 8)
    memory = Newton.made(most=m, n=problem.blocks.n, links=1)
    descend = loop.code("motion.cones.descent", "descend")
    assert descend(problem, memory, 1e-12, 1e-12, 12, 1.0, augmented) <= 1e-12
    x = problem.x[:m]
    assert dense.rated(x, A @ x + b) <= 2e-12
    assert memory.factored <= 6


def test_what_solves_the_problem_stays():
    dense = DenseProblem(np.eye(2), np.array([-1.0, 0.0]), [NORMAL, LINE], [0, 0.5])
    dense.from_zero()
    before = dense.memory.x.copy()
    memory = Newton.made(most=2, n=dense.memory.blocks.n, links=1)
    descend = loop.code("motion.cones.descent", "descend")
    assert descend(dense.memory, memory, 1e-12, 1e-12, 12, 1.0, 0) <= 1e-12
    assert (dense.memory.x == before).all() and memory.factored == 0
