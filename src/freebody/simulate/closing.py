"""The start of a constrained motion: coordinates that close the loops, speeds that keep them closed.

What the user names is held; what follows from the constraints is solved for.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..dynamics import mass_matrix
from ..dynamics.constrained import DEPENDENT, POOR, STEPS, no_direction, not_met
from ..dynamics.constraints import linearized, rows
from ..dynamics.mobility import check_mobility, light
from ..dynamics.state import float_state
from ..errors import SimulationError
from ..model import Model
from . import layout, loop
from .initial import named_numbers
from .kernels import Kernels

SOURCES = ("loop.py", "gauss_newton.py", "machine.py", "translation.py", "rows.py", "layout.py")
"""Modules that the search is made of."""


def closed_start(
    kernels: Kernels,
    values: Mapping[str, float],
    initial: Mapping[Any, Any],
    near: Mapping[Any, Any],
    t: float,
    project: bool,
) -> tuple[NDArray[np.float64], tuple[int, ...]]:
    """State (q, u) on the constraints, and the conditions that are independent there (`gauss_newton`).

    Raises
    ------
    SimulationError
        Named values that contradict the constraints: which condition is missed, and by how much.
    """
    model = kernels.model
    start, named = named_numbers(model, values, initial)
    if near:
        guess, guessed = named_numbers(model, values, near, "near")
        for i in guessed.keys() - named:
            start[i] = guess[i]
    n_q, n, m = model.n_q, model.n_u, len(kernels.on_speeds)
    held, fixed = [0] * n, [0] * n
    if not project:
        for j in _held(model, named):
            held[j] = 1
        for i in named:
            if i >= n_q:
                fixed[i - n_q] = 1
    largest = max(map(abs, start[:n_q]), default=0.0)
    asked = (layout.MET, 0, 0, STEPS, *kernels.on_speeds, *[0] * m, *held, *fixed, *model.quaternions)
    integers, numbers = (
        np.array(asked, dtype=np.int64),
        np.array([DEPENDENT * (1 + largest), DEPENDENT, POOR, light(n), 0.0, 0.0, t, *start]),
    )
    program = kernels.closing()
    loop.code("gauss_newton", "close", SOURCES)(
        program.address("conditions"), program.address("motion"), program.address("moved"), n_q, n, m,
        len(model.quaternions), integers, numbers, program.constants(kernels.parameters(values)),
        np.empty(layout.closing(n_q, n, m)),
    )  # fmt: skip
    status, worst, heavy, _, *flags = integers.tolist()
    state = numbers[layout.COORDINATES :]
    q, u = state[:n_q].tolist(), state[n_q:].tolist()
    if status in (layout.NOWHERE, layout.FAR):
        error = no_direction(model, q) if status == layout.NOWHERE else not_met(model, q, t, values, STEPS)[1]
        raise SimulationError(
            f"The initial state is off the constraints of '{model.name}'. {error} Coordinates that are named stay as "
            f"given: leave some out and they are solved for (near= tells where to look), or pass project=True "
            f"to move all of them to the nearest closed position."
        )
    if not heavy:
        masses = mass_matrix(model, float_state(model, q, u, t, values))
        check_mobility(model, np.array([[float(x) for x in row] for row in masses]))
    if status == layout.TORN:
        raise SimulationError(
            f"The initial speeds contradict the constraints of '{model.name}': the rate of '{rows(model)[worst].name}' "
            f"is {numbers[layout.MISSED]:.3g}, not 0. Name fewer speeds, so that the others can follow, or pass "
            "project=True."
        )
    return state, tuple(i for i in range(m) if flags[m + i])


NEARLY = 0.05
"""Ratio of singular values of the conditions, at unit length, below which a run that stopped has locked up."""


def nearly_dependent(model: Model, state: Any, active: tuple[int, ...]) -> tuple[str, ...]:
    """Names of the conditions that are nearly dependent on each other at a state; none where all are well apart."""
    G = np.array([[float(x) for x in row] for row in linearized(model, state).matrix])[list(active)]
    M = np.array([[float(x) for x in row] for row in mass_matrix(model, state)])
    if not (np.isfinite(G).all() and np.isfinite(M).all()):
        return ()
    W = G / np.sqrt(M.diagonal())
    W /= np.linalg.norm(W, axis=1, keepdims=True)
    U, s, _ = np.linalg.svd(W)
    if not s.size or s[-1] > NEARLY * s[0]:
        return ()
    parts = np.abs(U[:, -1])
    names = [row.name for row in rows(model)]
    return tuple(names[active[k]] for k in np.flatnonzero(parts > 0.1 * parts.max()))


def _held(model: Model, named: Iterable[int]) -> tuple[int, ...]:
    """Speeds along which nothing may move, since their coordinates are named."""
    held: set[int] = set()
    for i in named:
        if i >= model.n_q:
            continue
        coordinate = model.coordinates[i]
        if coordinate.kind == "scalar":
            held.add(model.speed_names.index(coordinate.name + "'"))
            continue
        sizes = {"free": 7, "ball": 4}
        link = next(one for one in model.links if 0 <= one.q <= i < one.q + sizes.get(one.kind, 0))
        start = link.u if coordinate.kind == "quaternion" else link.u + 3
        held.update(range(start, start + 3))
    return tuple(sorted(held))
