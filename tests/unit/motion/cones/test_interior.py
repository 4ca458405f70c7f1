"""The interior point method comes near to a solution from zero in a bounded number of steps, also with open forces."""

import numpy as np
import pytest

from cone_problems import DenseProblem
from freebody.motion.cones.contact_problem import FIRST, LINE, NORMAL, SECOND, Newton
from freebody.native import loop

NEAR, STEPS = 1e-3, 20


def approached(A, b, kinds, mu):
    """Return a problem with what the method finds from zero, its residual and its number of factors."""
    dense = DenseProblem(A, b, kinds, mu)
    dense.from_zero()  # sets the rows
    problem = dense.memory
    memory = Newton.made(most=len(b), n=problem.blocks.n, links=1)
    assert loop.code("motion.cones.interior", "is_served")(problem) == 1
    loop.code("motion.cones.interior", "begin")(problem, memory.path, 0.1, 1.0)
    left = loop.code("motion.cones.interior", "go_on")(problem, memory, NEAR, STEPS)
    return dense, memory, left


@pytest.mark.parametrize("tangents", [[LINE], [FIRST, SECOND]], ids=["plane", "space"])
@pytest.mark.parametrize("contacts", [2, 8, 16])
@pytest.mark.parametrize("seed", range(4))
def test_it_comes_near_and_the_laws_of_its_result_are_solved_from_there(tangents, contacts, seed):
    rng = np.random.default_rng(seed)
    kinds = [NORMAL, *tangents] * contacts
    W = rng.normal(size=(len(kinds), 12))  # with 8 and 16 contacts more rows than directions: forces are open
    W[:: 1 + len(tangents), 0] = 1.0  # a direction in which all open, so that there is a solution
    A, b = W @ W.T, W @ rng.normal(size=12)
    dense, memory, left = approached(A, b, kinds, [0.3] * len(b))
    assert left <= NEAR
    assert memory.factored <= STEPS
    x, mu = dense.memory.x, 0.3
    for a in range(0, len(b), 1 + len(tangents)):  # inside the cones
        assert x[a] > 0 and np.linalg.norm(x[a + 1 : a + 1 + len(tangents)]) < mu * x[a]
    descend = loop.code("motion.cones.descent", "descend")
    assert descend(dense.memory, memory, 1e-12, 1e-12, 20, 1.0, 0) <= 1e-12
    x = dense.memory.x[: len(b)]
    assert dense.rated(x, A @ x + b) <= 2e-12


def test_a_block_that_slides_has_the_friction_that_slows_it():
    # m v' = -g h with g h = 1, v_T = 2 before, and mu = 0.5: N = 1, T = -0.5, v_T = 1.5
    dense, _, left = approached(np.eye(3), np.array([-1.0, 2.0, 0.0]), [NORMAL, FIRST, SECOND], [0, 0.5, 0.5])
    assert left <= NEAR
    assert dense.memory.x[:3] == pytest.approx([1.0, -0.5, 0.0], abs=3 * NEAR)


def test_what_resists_rolling_and_contacts_without_friction_are_not_served():
    of = loop.code("motion.cones.interior", "is_served")
    dense = DenseProblem(np.eye(3), np.array([-1.0, 0.0, 0.0]), [NORMAL, LINE, LINE], [0, 0.5, 0.1])
    dense.from_zero()
    dense.memory.between[2] = 1  # bounded by the same normal impulse as the friction
    assert of(dense.memory) == 0
    dense.memory.between[2] = 0
    dense.memory.low[0] = 0.5  # a normal impulse that is given
    assert of(dense.memory) == 0
    bare = DenseProblem(np.eye(2), np.array([-1.0, 0.0]), [NORMAL, NORMAL], [0, 0])
    bare.from_zero()
    assert of(bare.memory) == 0
