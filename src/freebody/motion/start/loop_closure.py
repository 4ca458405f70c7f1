"""The start of a constrained motion: coordinates that close the loops, and speeds that keep them closed.

Named values are kept. The others follow from the constraints.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...dynamics import mass_matrix
from ...dynamics.composite import mass_diagonal
from ...dynamics.conditions.constrained import DEPENDENT, POOR, STEPS, condition_groups, no_direction, not_met
from ...dynamics.conditions.constraints import rows
from ...dynamics.conditions.linearized import linearized
from ...dynamics.conditions.mobility import check_mobility
from ...dynamics.state import float_state
from ...errors import SimulationError
from ...model import Model
from ...native import loop
from ..kernels.kernels import Kernels
from .closing_record import CROWDED, FAR, NOWHERE, TORN, Closing, sizes_of_closing
from .initial import named_numbers


def closed_start(
    kernels: Kernels,
    values: Mapping[str, float],
    initial: Mapping[Any, Any],
    near: Mapping[Any, Any],
    t: float,
    project: bool,
) -> tuple[NDArray[np.float64], tuple[int, ...]]:
    """Return a state (q, u) on the constraints, and the conditions that are independent there (`gauss_newton`).

    Raises
    ------
    SimulationError
        Named values contradict the constraints. The message states the violated condition and its residual.
    """
    model = kernels.model
    start, named = named_numbers(model, values, initial)
    if near:
        guess, guessed = named_numbers(model, values, near, "near")
        for i in guessed.keys() - named:
            start[i] = guess[i]
    n_q, n = model.n_q, model.n_u
    immobile, fixed = [0] * n, [0] * n
    if not project:
        for i in named:
            for j in model.moved_by[i] if i < n_q else ():
                immobile[j] = 1
            if i >= n_q:
                fixed[i - n_q] = 1
    try:
        search = kernels.cache.pop("closing", None) or _Search(kernels)
    except ZeroDivisionError:  # a pivot of M that is 0 in every state
        _check_mobility(model, start, t, values)
        raise
    search.run(values, immobile, fixed, t, start)
    memory = search.memory
    status, worst, heavy, residual = memory.status, memory.worst, memory.heavy, memory.missed
    active, state = tuple(np.flatnonzero(memory.independent).tolist()), memory.state[: n_q + n].copy()
    kernels.cache["closing"] = search
    if status in (NOWHERE, FAR):
        q = state[:n_q].tolist()
        error = no_direction(model, q) if status == NOWHERE else not_met(model, q, t, values, STEPS)[1]
        raise SimulationError(
            f"The initial state is off the constraints of '{model.name}'. {error} Named coordinates keep their "
            f"values: leave some out and they are solved for (near= tells where to look), or pass project=True "
            f"to move all of them to the nearest closed position."
        )
    if not heavy:
        _check_mobility(model, state.tolist(), t, values)
    if status == TORN:
        raise SimulationError(
            f"The initial speeds contradict the constraints of '{model.name}': the rate of '{rows(model)[worst].name}' "
            f"is {residual:.3g}, not 0. Name fewer speeds, so that the others can follow, or pass "
            "project=True."
        )
    return state, active


def _check_mobility(model: Model, state: Sequence[float], t: float, values: Mapping[str, float]) -> None:
    """Refuse a state (q, u) in which some speeds move no mass."""
    masses = mass_matrix(model, float_state(model, state[: model.n_q], state[model.n_q :], t, values))
    check_mobility(model, np.array([[float(x) for x in row] for row in masses]))


class _Search:
    """Memory of `gauss_newton.close` for one machine, reused by the next search."""

    def __init__(self, kernels: Kernels) -> None:
        self.kernels, self.program = kernels, kernels.closing()
        self.function = loop.code("motion.start.gauss_newton", "close").code
        self.values: Mapping[str, float] | None = None
        m, n = self.program.shape
        self._make(4 * (m + n + self.program.columns.size))

    def _make(self, room: int) -> None:
        """Make the memory, with room for so many entries of the factors of each kind."""
        model, program = self.kernels.model, self.program
        m, n, entries = *program.shape, program.columns.size
        sizes = sizes_of_closing(model.n_q, n, m, len(model.quaternions), entries, room)
        self.memory = memory = Closing.made(**sizes)
        for name in ("conditions", "motion", "moved", "least"):
            setattr(memory, name, program.address(name))
        equip(memory, self.kernels.on_speeds, model.quaternions, program.pattern)
        if self.values is not None:
            memory.c = self.constants

    def run(
        self, values: Mapping[str, float], immobile: Sequence[int], fixed: Sequence[int], t: float,
        start: Sequence[float],
    ) -> None:  # fmt: skip
        """Solve for the state from a start with these parameters, and with flags of the speeds (`Closing`)."""
        if self.values != values:
            self.memory.c = self.constants = self.program.constants(self.kernels.parameters(values))
            self.values = dict(values)
        largest = max(map(abs, start[: self.kernels.model.n_q]), default=0.0)
        while True:
            memory = self.memory
            memory.t, memory.near = t, DEPENDENT * (1 + largest)
            memory.immobile[:], memory.fixed[:], memory.state[: len(start)] = immobile, fixed, start
            self.function(memory.address)
            if memory.status != CROWDED:
                return
            self._make(2 * memory.rows.room_of_factors)


def equip(
    memory: Closing, on_speeds: Sequence[int], quaternions: Sequence[int], pattern: NDArray[np.int64]
) -> None:
    """Write the tolerances, and what the search reads of a machine: the kinds and the pattern of its conditions."""
    memory.dependent, memory.poor, memory.light, memory.most_steps = DEPENDENT, POOR, LIGHT, STEPS
    memory.on_speeds[:], memory.quaternions[:] = on_speeds, quaternions
    memory.rows.starts[:], memory.rows.columns[:] = np.split(pattern, [memory.n_conditions + 1])


LIGHT = 1e-8
"""Part of a mass below which, after other speeds are left free to follow, it is checked by eigenvalues."""
NEARLY = 0.05
"""Ratio of singular values of the conditions, each constraint at unit length, below which a run is said to have stopped
at a singular position."""


def nearly_dependent(
    model: Model, state: Any, active: tuple[int, ...], nearly: float = NEARLY
) -> tuple[str, ...]:
    """Return the names of conditions that are nearly dependent on each other at a state; none if all are well
    separated.
    """
    G = np.array([[float(x) for x in row] for row in linearized(model, state).matrix])
    masses = np.array([float(x) for x in mass_diagonal(model, state)])
    places = np.nonzero(G)
    return names_of_dependent(model, Entries(G[places], *places), masses, active, nearly)


class Entries(NamedTuple):
    """Entries of a sparse matrix, with the row and the column of each."""

    values: NDArray[np.float64]
    rows: NDArray[np.int64]
    columns: NDArray[np.int64]


FEW = 100
"""Number of conditions up to which their matrix is kept with its zeros."""
TURNS = 200
"""Greatest number of steps of a power iteration."""


def names_of_dependent(
    model: Model, G: Entries, masses: NDArray[np.float64], active: tuple[int, ...], nearly: float
) -> tuple[str, ...]:
    """Return the names as :func:`nearly_dependent` does, from the matrix of the conditions and the diagonal of M.

    The least singular vector comes from inverse iteration with factors of W Wᵀ, W the conditions of unit length. They
    are sparse for many conditions; for a few SciPy's sparse matrices take longer to import than to use.
    """
    if not active or not (np.isfinite(G.values).all() and np.isfinite(masses).all()):
        return ()
    # one row may vanish; the rows of a constraint never all vanish
    groups = np.array([[i, k] for k, group in enumerate(condition_groups(model)) for i in group])
    group_of = groups[np.argsort(groups[:, 0]), 1][G.rows]
    entries = G.values / np.sqrt(masses)[G.columns]
    sizes = np.sqrt(np.bincount(group_of, entries * entries))[group_of]
    entries = np.divide(entries, sizes, out=entries, where=sizes > 0)
    W: Any
    shape = (len(groups), masses.size)
    if len(active) <= FEW:
        W = np.zeros(shape)
        W[G.rows, G.columns] = entries
        W = W[list(active)]
        A = W @ W.T
    else:
        from scipy.sparse import csr_array
        from scipy.sparse.linalg import splu

        W = csr_array((entries, (G.rows, G.columns)), shape=shape)[list(active)]
        A = (W @ W.T).tocsc()
    start = 1 + 1 / (1 + np.arange(len(active)))  # has a part along every vector of a row of equal loops
    largest, x = 0.0, start
    for _ in range(TURNS):
        x = A @ (x / np.linalg.norm(x))
        last, largest = largest, float(np.linalg.norm(x))
        if not largest > last * (1 + nearly / 10):
            break
    shift = np.finfo(float).eps * largest
    x = start
    if len(active) <= FEW:
        A[np.diag_indices_from(A)] += shift
        solve = partial(np.linalg.solve, A)
    else:
        A.setdiag(A.diagonal() + shift)
        solve = splu(A).solve
    for _ in range(TURNS):
        last_x, x = x, solve(x)
        x /= np.linalg.norm(x)
        if abs(last_x @ x) > 1 - 1e-12:
            break
    if not np.linalg.norm(W.T @ x) <= nearly * math.sqrt(largest):
        return ()
    parts = np.abs(x)
    names = [row.name for row in rows(model)]
    return tuple(names[active[k]] for k in np.flatnonzero(parts > 0.1 * parts.max()))
