"""The start of a constrained motion: coordinates that close the loops, and speeds that keep them closed.

Named values are kept. The others follow from the constraints.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...dynamics import mass_matrix
from ...dynamics.constrained import DEPENDENT, POOR, STEPS, condition_groups, no_direction, not_met
from ...dynamics.constraints import linearized, rows
from ...dynamics.mobility import check_mobility, zero_eigenvalue
from ...dynamics.state import float_state
from ...errors import SimulationError
from ...model import Model
from ...native import loop
from ..kernels.kernels import Kernels
from ..ode import layout
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
    search = kernels.cache.pop("closing", None) or _Search(kernels)
    largest = max(map(abs, start[:n_q]), default=0.0)
    search.input_format.pack_into(
        search.memory, 0, layout.MET, 0, 0, STEPS, *search.on_speeds, *immobile, *fixed, *model.quaternions,
        DEPENDENT * (1 + largest), DEPENDENT, POOR, zero_eigenvalue(n), 0.0, 0.0, t, *start,
    )  # fmt: skip
    search.run(values)
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
        masses = mass_matrix(model, float_state(model, state[:n_q].tolist(), state[n_q:].tolist(), t, values))
        check_mobility(model, np.array([[float(x) for x in row] for row in masses]))
    if status == layout.TORN:
        raise SimulationError(
            f"The initial speeds contradict the constraints of '{model.name}': the rate of '{rows(model)[worst].name}' "
            f"is {residual:.3g}, not 0. Name fewer speeds, so that the others can follow, or pass "
            "project=True."
        )
    return state, active


class _Search:
    """Memory and arguments of `gauss_newton.close` for one machine, reused by the next search."""

    def __init__(self, kernels: Kernels) -> None:
        model, self.kernels, self.on_speeds = kernels.model, kernels, kernels.on_speeds
        n_q, n, m, nq = model.n_q, model.n_u, len(self.on_speeds), len(model.quaternions)
        integers, numbers = layout.BY_CONDITION + 2 * (m + n) + nq, layout.COORDINATES + n_q + n
        flags = layout.BY_CONDITION + m
        self.input_format = struct.Struct(f"{flags}q{8 * m}x{2 * n + nq}q{numbers}d")
        size = integers + numbers
        block = np.empty(size + layout.closing(n_q, n, m))
        self.memory = block.data.cast("B")
        self.integers, self.independent = (
            block.view(np.int64)[:flags],
            block.view(np.int64)[flags : flags + m],
        )
        self.numbers, self.state = block[integers:size], block[size - n_q - n : size]
        program, base = kernels.closing(), loop.address(block)
        addresses = map(program.address, ("conditions", "motion", "moved"))
        self.arguments = np.array(
            [*addresses, n_q, n, m, nq, base, base + 8 * integers, base + 8 * size, 0], dtype=np.int64
        )
        self.function = loop.code("motion.start.gauss_newton", "close").code
        self.address = loop.address(self.arguments)
        self.values: Mapping[str, float] | None = None

    def run(self, values: Mapping[str, float]) -> None:
        """Solve for the start with these parameters."""
        if self.values != values:
            self.constants = self.kernels.closing().constants(self.kernels.parameters(values))
            self.values, self.arguments[-1] = dict(values), loop.address(self.constants)
        self.function(self.address)

    def active(self) -> tuple[int, ...]:
        """Return the independent conditions."""
        return tuple(i for i, independent in enumerate(self.independent.tolist()) if independent)


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
    M = np.array([[float(x) for x in row] for row in mass_matrix(model, state)])
    return names_of_dependent(model, G, M, active, nearly)


def names_of_dependent(
    model: Model, G: NDArray[np.float64], M: NDArray[np.float64], active: tuple[int, ...], nearly: float
) -> tuple[str, ...]:
    """Return the names as :func:`nearly_dependent` does, from the matrix of the conditions and the mass matrix."""
    if not (np.isfinite(G).all() and np.isfinite(M).all()):
        return ()
    W = G / np.sqrt(M.diagonal())
    for group in condition_groups(model):  # one row may vanish; the rows of a constraint never all vanish
        size = np.linalg.norm(W[group])
        W[group] /= size if size > 0 else 1.0
    U, s, _ = np.linalg.svd(W[list(active)])
    if not s.size or s[-1] > nearly * s[0]:
        return ()
    parts = np.abs(U[:, -1])
    names = [row.name for row in rows(model)]
    return tuple(names[active[k]] for k in np.flatnonzero(parts > 0.1 * parts.max()))
