"""The start of a constrained motion: coordinates that close the loops, and speeds that keep them closed.

Named values are kept. The others follow from the constraints.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...dynamics import mass_matrix
from ...dynamics.composite import mass_diagonal
from ...dynamics.conditions.constrained import DEPENDENT, POOR, STEPS, condition_groups, no_direction, not_met
from ...dynamics.conditions.constraints import linearized, rows
from ...dynamics.conditions.mobility import check_mobility
from ...dynamics.state import float_state
from ...errors import SimulationError
from ...model import Model
from ...native import loop
from ..kernels.kernels import Kernels
from ..ode import layout
from .initial import named_numbers
from .sparse_rows import integers_needed, reals_needed


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
    search.run(values, (*search.on_speeds, *immobile, *fixed), (t, *start))
    status, worst, heavy, *_ = search.integers.tolist()
    active, state = search.active(), search.state.copy()
    residual = float(search.numbers[layout.MISSED])
    kernels.cache["closing"] = search
    if status in (layout.NOWHERE, layout.FAR):
        q = state[:n_q].tolist()
        error = no_direction(model, q) if status == layout.NOWHERE else not_met(model, q, t, values, STEPS)[1]
        raise SimulationError(
            f"The initial state is off the constraints of '{model.name}'. {error} Named coordinates keep their "
            f"values: leave some out and they are solved for (near= tells where to look), or pass project=True "
            f"to move all of them to the nearest closed position."
        )
    if not heavy:
        _check_mobility(model, state.tolist(), t, values)
    if status == layout.TORN:
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
    """Memory and arguments of `gauss_newton.close` for one machine, reused by the next search."""

    def __init__(self, kernels: Kernels) -> None:
        model, self.kernels, self.on_speeds = kernels.model, kernels, kernels.on_speeds
        n_q, n, m, nq = model.n_q, model.n_u, len(self.on_speeds), len(model.quaternions)
        self.program = program = kernels.closing()
        pattern = program.pattern
        integers, numbers = (
            layout.BY_CONDITION + 3 * (m + n) + nq,
            layout.COORDINATES + n_q + 2 * n + m,
        )
        flags, size = layout.BY_CONDITION + m, integers + numbers
        self.input_format = struct.Struct(
            f"{flags}q{8 * m}x{2 * n + nq}q{8 * (m + n)}x{layout.COORDINATES + n_q + n}d"
        )
        block = np.zeros(size + layout.closing(n_q, n, m, program.columns.size))
        self.memory = block.data.cast("B")
        self.integers, self.independent = (
            block.view(np.int64)[:flags],
            block.view(np.int64)[flags : flags + m],
        )
        first = integers + layout.COORDINATES
        self.numbers, self.state = block[integers:size], block[first : first + n_q + n]
        addresses = map(program.address, ("conditions", "motion", "moved", "least"))
        base = loop.address(block)
        self.arguments = np.array(
            [*addresses, n_q, n, m, nq, program.columns.size, base, base + 8 * integers, loop.address(pattern),
            base + 8 * size, 0, 0, 0],
            dtype=np.int64,
        )  # fmt: skip
        self.function = loop.code("motion.start.gauss_newton", "close").code
        self.address = loop.address(self.arguments)
        self.values: Mapping[str, float] | None = None
        self._make_room(4 * (m + n + program.columns.size))

    def _make_room(self, room: int) -> None:
        """Make memory for factors with ``room`` entries of each kind."""
        m, n = len(self.on_speeds), self.kernels.model.n_u
        self.room = room
        self.factors = np.zeros(integers_needed(m, n, room), dtype=np.int64)
        self.factors[:3] = m, n, room
        self.factors_real = np.zeros(reals_needed(m, n, room))
        self.arguments[layout.FACTORS : layout.FACTORS_REAL + 1] = (
            loop.address(self.factors),
            loop.address(self.factors_real),
        )

    def run(self, values: Mapping[str, float], flags: Sequence[int], numbers: Sequence[float]) -> None:
        """Solve for the start with these parameters, flags of conditions and speeds, time and state."""
        if self.values != values:
            self.constants = self.program.constants(self.kernels.parameters(values))
            self.values, self.arguments[layout.OF_PARAMETERS] = dict(values), loop.address(self.constants)
        n_q, quaternions = self.kernels.model.n_q, self.kernels.model.quaternions
        largest = max(map(abs, numbers[1 : 1 + n_q]), default=0.0)
        while True:
            self.input_format.pack_into(
                self.memory, 0, layout.MET, 0, 0, STEPS, *flags, *quaternions, DEPENDENT * (1 + largest), DEPENDENT,
                POOR, LIGHT, 0.0, 0.0, *numbers,
            )  # fmt: skip
            self.function(self.address)
            if self.integers[layout.STATUS] != layout.CROWDED:
                return
            self._make_room(2 * self.room)

    def active(self) -> tuple[int, ...]:
        """Return the independent conditions."""
        return tuple(i for i, independent in enumerate(self.independent.tolist()) if independent)


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
