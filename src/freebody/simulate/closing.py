"""The start of a constrained motion: coordinates that close the loops, speeds that keep them closed.

What the user names is held; what follows from the constraints is solved for.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..dynamics import mass_matrix
from ..dynamics.constrained import closed_coordinates, independent_of
from ..dynamics.constraints import linearized, rows
from ..dynamics.mobility import check_mobility
from ..dynamics.state import float_state
from ..errors import ModelError, SimulationError
from ..model import Model
from .initial import named_state
from .kernels import Kernels, Program
from .path import Path, observe

MISSED = 1e-9
"""Residual, relative to the sizes in it, beyond which a start does not satisfy the constraints."""


DRIFTED = 1e-6
"""Residual beyond which a condition left out as redundant is seen not to follow from the others."""


def closed_start(
    model: Model,
    values: Mapping[str, float],
    initial: Mapping[Any, Any],
    near: Mapping[Any, Any],
    t: float,
    project: bool,
    kernels: Kernels | None = None,
) -> tuple[NDArray[np.float64], tuple[int, ...]]:
    """State (q, u) on the constraints, and the conditions that are independent there.

    With ``kernels`` the conditions are evaluated in machine code.

    Raises
    ------
    SimulationError
        Named values that contradict the constraints: which condition is missed, and by how much.
    """
    y, named = named_state(model, values, initial)
    guess, guessed = named_state(model, values, near, "near")
    for i in guessed - named:
        y[i] = guess[i]
    q, u = y[: model.n_q].tolist(), y[model.n_q :]
    held = () if project else _held(model, named)
    try:
        look = None if kernels is None else _Looking(kernels, values, t)
        q = closed_coordinates(model, q, t, values, held, look=look)
    except ModelError as error:
        raise SimulationError(
            f"The initial state is off the constraints of '{model.name}'. {error} Coordinates that are named stay as "
            f"given: leave some out and they are solved for (near= tells where to look), or pass project=True "
            f"to move all of them to the nearest closed position."
        ) from None
    if look is None:
        state = float_state(model, q, u.tolist(), t, values)
        given = linearized(model, state)
        G = np.array([[float(x) for x in row] for row in given.matrix]).reshape(-1, model.n_u)
        psi = np.array([float(x) for x in given.rate])
        M = np.array([[float(x) for x in row] for row in mass_matrix(model, state)])
    else:
        G, psi, M = look.motion(q, u)
    check_mobility(model, M)
    active = independent_of(G, M)
    fixed = [] if project else [i - model.n_q for i in sorted(named) if i >= model.n_q]
    y[: model.n_q] = q
    y[model.n_q :] = _speeds(model, G, psi, M, u, fixed)
    return y, active


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


class _Looking:
    """The conditions at a configuration, by the compiled functions of :meth:`Kernels.closing`."""

    def __init__(self, kernels: Kernels, values: Mapping[str, float], t: float) -> None:
        self.n_u = kernels.model.n_u
        self.program = kernels.closing()
        self.constants = self.program.constants(kernels.parameters(values))
        self.t = np.array([float(t)])

    def _of(self, name: str, q: Any, u: Any) -> Any:
        y = np.concatenate([q, u])[None]
        return observe(self.program.address(name), self.program.outputs(name), self.t, y, self.constants)[0]

    def __call__(self, q: list[float]) -> tuple[Any, Any]:
        """Residuals and G."""
        u = np.zeros(self.n_u)
        return self._of("residual", q, u), self._of("matrix", q, u).reshape(-1, self.n_u)

    def motion(self, q: Any, u: Any) -> tuple[Any, Any, Any]:
        """G, ψ and M."""
        G = self._of("matrix", q, u).reshape(-1, self.n_u)
        return G, self._of("rate", q, u), self._of("mass", q, u).reshape(self.n_u, self.n_u)


def check_redundant(kernels: Kernels, program: Program, path: Path) -> None:
    """Conditions that were redundant at the start must hold along the whole motion.

    Raises
    ------
    SimulationError
        They do not: the start was a singular position, where the machine could have gone either way.
    """
    names = kernels.dropped
    if not names:
        return
    count = 2 * len(names)
    missed = np.abs(
        observe(program.address("dropped"), count, path.times, path.states, path.rates.constants)
    ) / (1 + np.abs(path.states).max(axis=1, keepdims=True))
    late = np.flatnonzero((missed > DRIFTED).any(axis=1))
    if len(late):
        k = int(late[0])
        worst = int(missed[k].argmax())
        raise SimulationError(
            f"The constraint '{names[worst // 2]}' of '{kernels.model.name}' followed from the others at the start, "
            f"but at t = {path.times[k]:.6g} s it does not. The start is a singular position, such as bars in line, "
            f"from which the machine can move in more ways than elsewhere. Start a little beside it."
        )


def _held(model: Model, named: set[int]) -> tuple[int, ...]:
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


def _speeds(model: Model, G: Any, psi: Any, M: Any, u: Any, fixed: list[int]) -> Any:
    """Speeds with G u + g = 0 that change the motion of the masses least, those ``fixed`` unchanged."""
    free = [j for j in range(model.n_u) if j not in fixed]
    root = np.linalg.cholesky(M[np.ix_(free, free)])
    step = np.linalg.solve(root.T, -np.linalg.pinv(np.linalg.solve(root, G[:, free].T).T, rcond=MISSED) @ psi)
    result = u.copy()
    result[free] += step
    left = psi + G[:, free] @ step
    size = 1 + np.abs(G).max(initial=0) * np.abs(result).max(initial=0)
    worst = int(np.abs(left).argmax()) if len(left) else 0
    if len(left) and abs(left[worst]) > MISSED * size:
        raise SimulationError(
            f"The initial speeds contradict the constraints of '{model.name}': the rate of '{rows(model)[worst].name}' "
            f"is {left[worst]:.3g}, not 0. Name fewer speeds, so that the others can follow, or pass project=True."
        )
    return result
