"""Modes of forces that are not solved to round-off: cone and slip both vanish at the limit of friction."""

import numpy as np
import pytest

from cone_problems import Touching, contacts_of
from freebody.motion.cones.collision import compiled_code
from freebody.motion.cones.contacts import EXACT
from freebody.motion.events.decision import AMPLIFIED, NEAR
from freebody.motion.phase import laws
from freebody.native import loop


def at_the_limit(rng, count):
    """Contacts between three bodies and the ground, each at rest with |T| = μ N."""
    W = np.zeros((3 * count, 18))
    for k in range(count):
        first, second = rng.permutation(4)[:2]
        for body, sign in ((first, 1), (second, -1)):
            if body < 3:
                x, y, z = rng.normal(size=3)
                J = sign * np.hstack([np.eye(3), [[0, z, -y], [-z, 0, x], [y, -x, 0]]])
                W[3 * k : 3 * k + 3, 6 * body : 6 * body + 6] = J[[2, 0, 1]]
    N, turn, mu = rng.uniform(0.1, 1, count), rng.uniform(0, 2 * np.pi, count), rng.uniform(0.05, 1)
    forces = np.column_stack([N, mu * N * np.cos(turn), mu * N * np.sin(turn)]).ravel()
    A = W @ W.T
    contacts = [Touching(f"c{k}", 3 * k, 2, mu, mu) for k in range(count)]
    return contacts_of(A, -A @ forces, contacts)


@pytest.fixture(scope="module")
def near():
    """Problems whose solutions are not exact, but near enough to show modes."""
    rng, result = np.random.default_rng(0), []
    for _ in range(600):
        it = at_the_limit(rng, int(rng.integers(4, 9)))
        compiled_code()["find"](it)
        if EXACT < it.residual <= NEAR:
            result.append(it)
    return result


def test_near_solutions_show_contacts_at_rest_or_a_slip_against_their_friction(near):
    """e = s T - P(s T - r) bounds the part of r square to T by |e|, twice while |r| <= s |T|: it has no other way."""
    mode, at_rest = loop.code("motion.events.decision", "mode_of"), 0
    for it in near:
        small = 2 * it.residual * it.problem.reference
        for k in range(it.contacts):
            (T_1, T_2), (r_1, r_2) = (x[3 * k + 1 : 3 * k + 3] for x in (it.forces, it.after))
            at_rest += mode(it, k) == laws.STICK
            assert abs(T_1 * r_2 - T_2 * r_1) <= small * np.hypot(T_1, T_2)
            if mode(it, k) == laws.SLIDE:
                assert T_1 * r_1 + T_2 * r_2 < 0
    assert at_rest


def test_what_is_zero_grows_with_the_residual(near):
    rounded = loop.code("motion.events.decision", "rounded")
    for it in near:
        assert rounded(it, 1e-9) == AMPLIFIED * it.residual
    exact = at_the_limit(np.random.default_rng(1), 1)
    compiled_code()["find"](exact)
    assert exact.residual <= EXACT and rounded(exact, 1e-9) == 1e-9
