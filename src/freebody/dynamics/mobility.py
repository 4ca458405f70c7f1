"""Whether every degree of freedom moves some mass: the mass matrix must be positive definite.

It is scaled to ones on its diagonal, so that the smallest eigenvalue is free of units; the eigenvector names the
coordinates that together move nothing.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..errors import ModelError
from ..model.model import Model
from .composite import mass_matrix
from .state import State, float_state

# A scaled mass matrix of n bodies is known to about n eps; what is smaller is zero.
EPSILONS = 1 << 10


def massless_motion(model: Model, state: State) -> tuple[str, ...]:
    """Names of the speeds that together move no mass at a state of floats; empty if there are none."""
    if model.n_u == 0:
        return ()
    M = np.array([[float(entry) for entry in row] for row in mass_matrix(model, state)])
    diagonal = M.diagonal()
    if (diagonal <= 0).any():
        return (model.speed_names[int(diagonal.argmin())],)
    scale = np.sqrt(diagonal)
    values, vectors = np.linalg.eigh(M / np.outer(scale, scale))
    if values[0] > EPSILONS * np.finfo(float).eps * len(M):
        return ()
    share = np.abs(vectors[:, 0])
    return tuple(model.speed_names[i] for i in np.flatnonzero(share > share.max() / len(M)))


def check_mobility(model: Model, values: Mapping[Any, Any] | None = None) -> None:
    """Refuse a model in which some motion meets no inertia, in every configuration.

    The mass matrix is formed at one configuration drawn at random, where it is singular with probability
    zero unless it is singular everywhere.

    Raises
    ------
    ModelError
        The coordinates that move no mass, by name.
    """
    rng = np.random.default_rng(6)
    q = rng.uniform(1, 2, size=model.n_q)
    for start in model.quaternions:
        q[start : start + 4] /= np.linalg.norm(q[start : start + 4])
    names = massless_motion(
        model, float_state(model, q.tolist(), rng.uniform(1, 2, size=model.n_u).tolist(), values=values)
    )
    if names:
        moves = ", ".join(f"'{name}'" for name in names)
        raise ModelError(
            f"The mass matrix is singular: changing {moves} moves no mass, in any configuration. "
            f"Give a body that moves with it mass or moment of inertia, or remove the coordinate."
        )
