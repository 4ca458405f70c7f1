"""Combinations of columns: as many as the rank of the regressor leaves, and they give the same forces."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

import freebody as fb
from freebody.symbolic.inertia.combinations import solved
from freebody.testing import random_state
from unloaded_machines import coupled, unloaded

BALL = fb.MassProperties(1, (0, 0, 0), ((1, 0, 0), (0, 1, 0), (0, 0, 1)))


def at_random(model, count):
    states = [random_state(model, seed) for seed in range(count)]
    udot = np.random.default_rng(1).normal(size=(count, model.n_u))
    return (*(np.array(x) for x in zip(*states, strict=True)), udot)


@pytest.mark.parametrize("case", [0, 2, 5, 8, "coupled"])
def test_the_rank_of_the_regressor_and_the_same_forces(case):
    model = fb.assemble(coupled() if case == "coupled" else unloaded(case))
    base, program = fb.base_parameters(model), fb.compile(model)
    q, u, udot = at_random(model, 10 * len(model.bodies))
    t = np.random.default_rng(2).uniform(0, 9, len(q))  # drives move at other times
    Y = program.regressor(q, u, udot, t).reshape(-1, 10 * len(model.bodies))
    sizes = np.linalg.norm(Y, axis=0)
    s = np.linalg.svd(Y / np.where(sizes > 0, sizes, 1), compute_uv=False)
    n = len(base.names)
    assert n == np.sum(s > s[0] * len(Y) * np.finfo(float).eps)
    K = base.matrix()
    assert K.shape == (n, Y.shape[1]) and (K[:, list(base.columns)] == np.eye(n)).all()
    gap = np.abs(Y[:, list(base.columns)] @ K - Y).max()
    assert gap <= 1e3 * np.finfo(float).eps * np.abs(Y).max() * np.abs(K).max()


def test_an_angle_as_a_parameter_stays_in_the_coefficients():
    s = fb.System("bent")
    s.parameters("alpha a")
    s.gravity = (0, 0, "-9.81")
    first, second = s.body("first", BALL), s.body("second", BALL)
    s.hinge("one", s.ground, first, axis=(1, 0, 0))
    s.hinge("two", first, second, axis=("sin(alpha)", 0, "cos(alpha)"), at=("a", 0, 0))
    base = fb.base_parameters(s)
    K, values = base.matrix({"alpha": 0.3, "a": 0.7}), {"alpha": 0.3, "a": 0.7}
    program = fb.compile(s)
    Y = program.regressor(*at_random(program.model, 9), values=values)
    assert np.abs(Y[..., list(base.columns)] @ K - Y).max() < 1e-13 * np.abs(Y).max()
    assert any(x.free_symbols for terms in base.combinations.values() for x in terms.values())


def test_elimination_without_fractions():
    rng = np.random.default_rng(0)
    for n in range(1, 6):
        A, x = rng.integers(-9, 9, (n, n)), rng.integers(-9, 9, n)
        if n > 1:
            A[0, 0] = 0
        rows = [[*map(int, row), int(b)] for row, b in zip(A, A @ x, strict=True)]
        assert solved(rows) == [Fraction(int(k)) for k in x]
