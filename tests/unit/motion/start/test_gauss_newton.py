"""The compiled start of constrained machines: least squares, independent rows, and the start itself."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from freebody.dynamics.conditions.constrained import closed_coordinates
from freebody.errors import SimulationError
from freebody.motion.kernels.kernels import kernels_of
from freebody.motion.start.loop_closure import closed_start

EPS = np.finfo(float).eps


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


def test_factors_that_need_more_room_get_it():
    """The search begins again with twice the room, and gives the same start."""
    kernels = kernels_of(four_bar())
    arguments = (
        kernels,
        kernels.values(None),
        {"alpha": 0.4, "alpha'": 3.0},
        {"beta": 1.0, "psi": 1.8},
        0.0,
        False,
    )
    first, active = closed_start(*arguments)
    kernels.cache["closing"]._make(1)
    again, still = closed_start(*arguments)
    assert kernels.cache["closing"].memory.rows.room_of_factors > 1
    assert np.array_equal(first, again)
    assert active == still
