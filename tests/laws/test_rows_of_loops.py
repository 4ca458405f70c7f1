"""Rows and ladders of random loops: sparse elimination gives the dense results, and the motion keeps the laws."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from freebody.dynamics import float_state, mass_matrix
from freebody.dynamics.composite import mass_diagonal
from freebody.dynamics.conditions.constrained import articulated_diagonal, constrained_dynamics, deep_speeds
from freebody.dynamics.conditions.linearized import linearized
from freebody.dynamics.newton_euler import bias
from freebody.motion.kernels.kernels import kernels_of
from freebody.motion.start.loop_closure import closed_start

EPS = np.finfo(float).eps


def machine(kind, loops, seed):
    """Loops of random bars, each beside the one before (row), or on its coupler (ladder), and coordinates nearby."""
    random = np.random.default_rng(seed)
    s = fb.System(f"{kind} of {loops}")
    s.gravity = (0, -9.81, 0)
    near = {}

    def bar(name, length):
        return s.body(name, fb.slender_bar(float(random.uniform(0.5, 2)), length, axis="x"))

    base, left, right, crank = s.ground, 0.0, 1.0, None
    long = 1.0
    for i in range(1, loops + 1):
        a, b, c = random.uniform(0.9, 1.1, 3).round(3).tolist()
        coupler, rocker = bar(f"coupler{i}", c), bar(f"rocker{i}", b)
        if crank is None:
            crank, long = bar(f"crank{i}", a), a
            s.hinge(f"A{i}", base, crank, at=(left, 0, 0), to=(-a / 2, 0, 0), coordinate=f"a{i}")
            near[f"a{i}"] = -1.3
        s.hinge(f"B{i}", crank, coupler, at=(long / 2, 0, 0), to=(-c / 2, 0, 0), coordinate=f"c{i}")
        s.hinge(f"D{i}", base, rocker, at=(right, 0, 0), to=(-b / 2, 0, 0), coordinate=f"b{i}")
        s.hinge(f"C{i}", coupler, rocker, at=(c / 2, 0, 0), to=(b / 2, 0, 0))
        near |= {f"c{i}": 1.3, f"b{i}": -1.3}
        if kind == "row":
            crank, long, right = rocker, b, right + 1.0
        else:
            base, left, right, crank = coupler, -c / 2, c / 2, None
    return s, near


CASES = [(kind, loops, seed) for kind in ("row", "ladder") for loops in (1, 3, 7) for seed in (1, 2)]


def start(s, near, seed):
    kernels = kernels_of(s)
    speeds = np.random.default_rng(seed).uniform(-1, 1, kernels.model.n_u)
    initial = dict(zip(kernels.model.speed_names, speeds.tolist(), strict=True))
    y, active = closed_start(kernels, kernels.values(None), initial, near, 0.0, True)
    n_q = kernels.model.n_q
    return kernels.model, y, active, float_state(kernels.model, y[:n_q].tolist(), y[n_q:].tolist()), speeds


@pytest.mark.parametrize(("kind", "loops", "seed"), CASES)
def test_elimination_in_order_gives_the_dense_results(kind, loops, seed):
    s, near = machine(kind, loops, seed)
    model, y, active, state, speeds = start(s, near, seed)
    assert len(active) == 2 * loops
    M = np.array(mass_matrix(model, state), dtype=float)
    conditions = linearized(model, state)
    rows_of_active = list(active)  # the others, across the plane of the loops, hold identically
    G = np.array(conditions.matrix, dtype=float)[rows_of_active]
    gamma, h = (
        np.array(conditions.bias, dtype=float)[rows_of_active],
        np.array(bias(model, state), dtype=float),
    )
    m, condition = len(G), np.linalg.cond(M) * np.linalg.cond(G) ** 2
    K = np.block([[M, -G.T], [G, np.zeros((m, m))]])
    dense = np.linalg.solve(K, np.concatenate([-h, -gamma]))
    accelerations, multipliers = constrained_dynamics(model, state, active)
    sparse = np.array([*accelerations, *(multipliers[i] for i in rows_of_active)], dtype=float)
    assert np.abs(sparse - dense).max() <= 10 * EPS * condition * (1 + np.abs(dense).max())
    # the start: on the conditions, and the least change of the motion
    assert np.abs(np.array(conditions.residual, dtype=float)).max() < 100 * EPS * loops
    u = y[model.n_q :]
    nearest = np.linalg.solve(K, np.concatenate([M @ speeds, np.zeros(m)]))[: len(u)]
    assert np.abs(u - nearest).max() <= 10 * EPS * condition * (1 + np.abs(nearest).max())
    assert np.abs(G @ u).max() <= 100 * EPS * (1 + np.abs(G).max() * np.abs(u).max())


@pytest.mark.parametrize(("kind", "loops", "seed"), CASES)
def test_masses_of_speeds(kind, loops, seed):
    """The diagonal of M; and its pivots, whose product is the determinant in any order."""
    s, near = machine(kind, loops, seed)
    model, _, _, state, _ = start(s, near, seed)
    M = np.array(mass_matrix(model, state), dtype=float)
    assert np.array(mass_diagonal(model, state)) == pytest.approx(M.diagonal(), rel=100 * EPS)
    pivots = np.array(articulated_diagonal(model, state), dtype=float)
    assert (pivots > 0).all()
    assert np.log(pivots).sum() == pytest.approx(np.linalg.slogdet(M)[1], abs=1e-10)
    if kind == "ladder" and loops == 7:
        assert deep_speeds(model) is not None


@pytest.mark.parametrize("kind", ["row", "ladder"])
def test_the_motion_keeps_its_laws(kind):
    """The energy, and the conditions on coordinates and on speeds, to round-off."""
    s, near = machine(kind, 5, 3)
    motion = fb.simulate(s, 0.5, initial={"a1": -1.2}, near=near, tolerance=1e-11)
    assert np.abs(motion.energy.residual).max() < 1e-9
    model = kernels_of(s).model
    for t in (0.0, 0.25, 0.5):
        at = motion.at(t)
        q, u = ([float(at[name]) for name in names] for names in (model.coordinate_names, model.speed_names))
        conditions = linearized(model, float_state(model, q, u, t))
        assert max(abs(float(x)) for x in conditions.residual) < 1e-13
        assert max(abs(float(x)) for x in conditions.rate) < 1e-12 * (1 + max(map(abs, u)))
