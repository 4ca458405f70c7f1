"""The compiled start of constrained machines: least squares, independent rows, and the start itself."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from freebody.dynamics.constrained import DEPENDENT, POOR, closed_coordinates, independent_of
from freebody.errors import SimulationError
from freebody.motion.kernels.kernels import kernels_of
from freebody.motion.ode import layout
from freebody.motion.start.loop_closure import closed_start
from freebody.native import loop

EPS = np.finfo(float).eps


@pytest.mark.parametrize(
    ("m", "n", "rank"),
    [(3, 3, 3), (5, 2, 2), (2, 5, 2), (6, 4, 3), (4, 7, 2), (1, 1, 0), (0, 3, 0), (3, 0, 0)],
)
def test_shortest_of_the_least_squares(m, n, rank):
    """As the singular values give it, of any shape and rank; contradictions included."""
    rng = np.random.default_rng(m + 10 * n)
    a = rng.normal(size=(m, rank)) @ rng.normal(size=(rank, n))
    b = rng.normal(size=m)
    expected = np.linalg.pinv(a, rcond=1e-9) @ b
    x = np.full(n, np.nan)
    loop.code("motion.start.gauss_newton", "least")(
        a.ravel().copy(), m, n, b.copy(), x, 1e-9, np.empty(4 * n + n * n)
    )
    condition = np.prod(np.linalg.svd(a, compute_uv=False)[[0, rank - 1]] ** [1, -1]) if rank else 1
    assert np.abs(x - expected).max(initial=0) <= 100 * EPS * condition**2 * (
        1 + np.abs(expected).max(initial=0)
    )


@pytest.mark.parametrize(
    ("poor", "chosen"), [(0.0, (0, 1, 3, 6)), (1e-6, (0, 1, 3, 6)), (1e-2, (0, 1, 3, 5))]
)
def test_independent_rows_are_those_of_numpy(poor, chosen):
    """A row that is nearly dependent gives way to a later one."""
    rng = np.random.default_rng(3)
    for _ in range(20):
        G = rng.normal(size=(7, 5))
        G[2], G[4], G[5] = 3 * G[0], 0, G[0] - 2 * G[1] + poor * G[6]
        M = np.diag(rng.uniform(0.1, 10, 5))
        kept, basis = np.full(7, 9), np.empty(30)
        loop.code("motion.start.gauss_newton", "independent")(
            G.ravel().copy(), M.ravel(), 7, 5, kept, POOR, DEPENDENT, basis
        )
        assert tuple(np.flatnonzero(kept)) == independent_of(G, M) == chosen
        assert set(kept) <= {0, 1}


@pytest.mark.parametrize("n", [0, 1, 4, 60])
def test_the_trace_of_an_inverse_bounds_the_least_eigenvalue(n):
    """Within a factor n: also of a row of masses, whose determinant is nothing beside it."""
    rng = np.random.default_rng(n)
    A = 0.4 * rng.normal(size=(n, n))
    A = A @ A.T + np.eye(n)
    factor = loop.code("motion.start.gauss_newton", "cholesky")
    trace = loop.code("motion.start.gauss_newton", "inverse_trace")
    L = A.ravel().copy()
    factor(L, n)
    found = trace(L, n, np.empty(n))
    assert found == pytest.approx(np.trace(np.linalg.inv(A)), rel=1e-12)
    if n:
        least = np.linalg.eigvalsh(A)[0]
        assert least / n <= 1 / found <= least * (1 + n * EPS)
        L = -A.ravel()
        factor(L, n)
        assert not trace(L, n, np.empty(n)) < np.inf


def four_bar(axis="z"):
    """Bars of 0.1, 0.3 and 0.2 m on a base of 0.3 m; of the joints in one plane three conditions are redundant."""
    s = fb.System("four-bar")
    bars = [s.body(name, fb.slender_bar(4 * L, L)) for name, L in (("a", 0.1), ("b", 0.3), ("c", 0.2))]
    s.hinge("A", s.ground, bars[0], to=(-0.05, 0, 0), axis=axis, coordinate="alpha")
    s.hinge("B", bars[0], bars[1], at=(0.05, 0, 0), to=(-0.15, 0, 0), axis=axis, coordinate="beta")
    s.hinge("D", s.ground, bars[2], at=(0.3, 0, 0), to=(-0.1, 0, 0), axis=axis, coordinate="psi")
    s.hinge("C", bars[2], bars[1], at=(0.1, 0, 0), to=(0.15, 0, 0), axis=axis)
    return s


@pytest.mark.parametrize("project", [False, True])
def test_a_start_is_that_of_the_search_in_python(project):
    kernels = kernels_of(four_bar())
    model = kernels.model
    given, near = {"alpha": 0.4, "alpha'": 3.0}, {"beta": 1.0, "psi": 1.8}
    y, active = closed_start(kernels, kernels.values(None), given, near, 0.0, project)
    held = () if project else (model.speed_names.index("alpha'"),)
    q = closed_coordinates(model, [0.4, 1.0, 1.8], values=kernels.values(None), fixed=held)
    assert y[:3] == pytest.approx(q, abs=20 * EPS)
    assert len(active) == 2
    if not project:
        assert y[0] == 0.4
        assert y[3] == 3.0
    alpha, beta, psi = y[:3]
    x = 0.1 * np.cos(alpha) + 0.3 * np.cos(alpha + beta) - 0.3 - 0.2 * np.cos(psi)
    z = 0.1 * np.sin(alpha) + 0.3 * np.sin(alpha + beta) - 0.2 * np.sin(psi)
    assert abs(x) + abs(z) < 8 * EPS
    a, b, c = y[3:]
    rate = (
        -0.1 * np.sin(alpha) * a - 0.3 * np.sin(alpha + beta) * (a + b) + 0.2 * np.sin(psi) * c,
        0.1 * np.cos(alpha) * a + 0.3 * np.cos(alpha + beta) * (a + b) - 0.2 * np.cos(psi) * c,
    )
    assert np.abs(rate).max() < 100 * EPS


def test_speeds_of_a_projected_start_lose_least_energy():
    """Of all speeds on the constraints those nearest in kinetic energy: what is left is M-orthogonal to the motion."""
    kernels = kernels_of(four_bar())
    given = {"alpha": 0.4, "alpha'": 3.0, "beta'": 1.0, "psi'": -2.0}
    y, _ = closed_start(kernels, kernels.values(None), given, {"beta": 1.0, "psi": 1.8}, 0.0, True)
    from freebody.dynamics import mass_matrix
    from freebody.dynamics.state import float_state

    state = float_state(kernels.model, y[:3].tolist(), y[3:].tolist())
    M = np.array([[float(x) for x in row] for row in mass_matrix(kernels.model, state)])
    assert y[3:] @ M @ (np.array([3.0, 1.0, -2.0]) - y[3:]) == pytest.approx(0, abs=1e-14)


def test_a_search_leaves_nothing_to_the_next():
    """In the memory of one of other parameters, of one that failed, and of one that was asked to move everything."""

    def start(kernels, L=None, alpha=0.4, **options):
        numbers = kernels.values(None if L is None else {"L": L})
        given = {"alpha": alpha, "alpha'": 3.0}
        return closed_start(
            kernels, numbers, given, {"beta": 1.0, "psi": 1.8}, 0.0, options.get("project", False)
        )

    def scaled():
        s = fb.System("four-bar")
        L = s.parameters(L=0.1)
        bars = [s.body(name, fb.slender_bar(1, k * L)) for name, k in (("a", 1), ("b", 3), ("c", 2))]
        s.hinge("A", s.ground, bars[0], to=(-L / 2, 0, 0), coordinate="alpha")
        s.hinge("B", bars[0], bars[1], at=(L / 2, 0, 0), to=(-3 * L / 2, 0, 0), coordinate="beta")
        s.hinge("D", s.ground, bars[2], at=(0.3, 0, 0), to=(-L, 0, 0), coordinate="psi")
        s.hinge("C", bars[2], bars[1], at=(L, 0, 0), to=(3 * L / 2, 0, 0))
        return kernels_of(s)

    kernels = scaled()
    first, held = start(kernels)
    kept = first.copy()
    other, _ = start(kernels, L=0.12)
    assert np.array_equal(other, start(scaled(), L=0.12)[0])
    with pytest.raises(SimulationError, match="off the constraints"):
        start(kernels, L=0.01)
    start(kernels, alpha=0.5, project=True)
    again, still = start(kernels)
    assert np.array_equal(again, kept)
    assert np.array_equal(first, kept)
    assert held == still


def test_memory_of_the_search():
    """As large as `close` cuts it: (G, φ) twice, M, the factors of `least`, and vectors."""
    n_q, n, m = 7, 6, 9
    positions = n + m + m * n + m * n + m + n + n_q + 4 * n + n * n
    speeds = m + m * n + n * n + n * n + m * n + m + n + 4 * n + n * n
    assert layout.closing(n_q, n, m) >= max(positions, speeds, m + m * n + 2 * n * n + n)


@pytest.mark.parametrize("n", [1, 5, 12])
def test_factors_of_matrices_with_zeros(n):
    """Arrow and band: L Lᵀ = M to the round-off of n products, with zeros where M begins with zeros."""
    rng = np.random.default_rng(n)
    L = np.tril(rng.normal(size=(n, n))) * (np.abs(np.subtract.outer(range(n), range(n))) < 3)
    L[-1] = rng.normal(size=n)
    np.fill_diagonal(L, rng.uniform(1, 2, n))
    M = L @ L.T
    factor = M.copy()
    loop.code("motion.start.gauss_newton", "cholesky")(factor, n)
    assert (
        np.abs(np.tril(factor) @ np.tril(factor).T - M).max()
        <= 4 * n * np.finfo(float).eps * M.diagonal().max()
    )
    assert (np.tril(factor)[:-1][np.tril(L)[:-1] == 0] == 0).all()
    bad = M.copy()
    bad[0, 0] = -1.0
    loop.code("motion.start.gauss_newton", "cholesky")(bad, n)
    assert np.isnan(bad[0, 0])
