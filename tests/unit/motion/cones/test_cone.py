"""Coulomb's cones: the nearest point, its slope, and the violations that vanish where the laws hold."""

import numpy as np
import pytest

from cone_problems import DenseProblem, code
from freebody.motion.cones.contact_problem import EQUALITY, FIRST, LINE, NORMAL, SECOND

KINDS = [EQUALITY, NORMAL, LINE, NORMAL, FIRST, SECOND]
MU = np.array([0, 0, 0.3, 0, 0.4, 0.4])


def problem(seed, low=0.0):
    rng = np.random.default_rng(seed)
    H = rng.normal(size=(6, 6))
    return DenseProblem(H @ H.T, rng.normal(size=6), KINDS, MU, np.full(6, low)), rng


@pytest.mark.parametrize("seed", range(20))
def test_the_projection_is_the_nearest_point_of_the_disk(seed):
    dense, rng = problem(seed, low=0.2)
    y = 2 * rng.normal(size=6)
    x = dense.projected(y)
    assert x[0] == y[0]
    assert (x[[1, 3]] == np.maximum(0.2, y[[1, 3]])).all()
    limit = 0.4 * x[3]
    assert np.linalg.norm(x[4:]) <= limit * (1 + 1e-15)
    assert abs(x[2]) <= 0.3 * x[1]
    for _ in range(50):  # no other point of the disk is nearer
        p = rng.normal(size=2)
        p *= limit * rng.uniform() / np.linalg.norm(p)
        assert np.linalg.norm(y[4:] - x[4:]) <= np.linalg.norm(y[4:] - p) * (1 + 1e-12)


@pytest.mark.parametrize("seed", range(20))
def test_violations_have_their_slope(seed):
    """Central differences over h have an error of h² and of round-off/h, beside a kink none that is small."""
    dense, rng = problem(seed)
    x, d, h = rng.normal(size=6), rng.normal(size=6), 1e-6

    def violations(x):
        dense.rated(x, dense.A @ x + dense.b)
        return dense.memory.e.copy()

    violations(x)
    slope = np.empty((6, 6))
    code("violation_slopes")(dense.memory, dense.A, slope)
    np.testing.assert_allclose(
        (violations(x + h * d) - violations(x - h * d)) / (2 * h),
        slope @ d,
        atol=1e-8 * np.abs(dense.A).max(),
    )


@pytest.mark.parametrize("seed", range(20))
def test_violations_of_what_resists_rolling_have_their_slope(seed):
    """Two disks and an interval on one normal force."""
    rng = np.random.default_rng(seed)
    H, kinds = rng.normal(size=(6, 6)), [NORMAL, FIRST, SECOND, FIRST, SECOND, LINE]
    dense = DenseProblem(H @ H.T, rng.normal(size=6), kinds, np.array([0, 0.4, 0.4, 0.1, 0.1, 0.2]))
    dense.memory.between[:6] = [0, 0, 0, 2, 0, 4]
    x, d, h, slope = rng.normal(size=6), rng.normal(size=6), 1e-6, np.empty((6, 6))
    x[0] = abs(x[0])

    def violations(x):
        dense.rated(x, dense.A @ x + dense.b)
        return dense.memory.e.copy()

    violations(x)
    code("violation_slopes")(dense.memory, dense.A, slope)
    change = (violations(x + h * d) - violations(x - h * d)) / (2 * h)
    np.testing.assert_allclose(change, slope @ d, atol=1e-8 * np.abs(dense.A).max())


def test_violations_are_those_of_the_laws():
    A, b = np.eye(3), np.array([-2.0, 0.1, 3.0])
    dense = DenseProblem(A, b, [NORMAL, FIRST, SECOND], [0, 0.5, 0.5])
    solution = np.array([2.0, 0, 0])
    solution[1:] = -np.array([0.1, 3.0]) / np.linalg.norm([0.1, 3.0])
    assert dense.rated(solution, A @ solution + b) < 1e-15
    # friction beside its direction, too much friction, a contact that pulls, one that sinks: relative to the rate 3
    turned = solution * [1, -1, 1]
    assert dense.rated(turned, A @ turned + b) == pytest.approx(2 * abs(solution[1]) / 3, rel=0.1)
    assert dense.rated(np.array([2.0, 0, -1.5]), np.zeros(3)) == pytest.approx(0.5 / 3)
    assert dense.rated(np.array([-1.0, 0, 0]), np.zeros(3)) == pytest.approx(1 / 3)
    assert dense.rated(np.zeros(3), np.array([-2.0, 0, 0])) == pytest.approx(2 / 3)
