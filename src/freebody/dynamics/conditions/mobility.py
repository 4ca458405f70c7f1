"""Check that every degree of freedom moves some mass: the mass matrix must be positive definite.

The matrix is scaled to ones on its diagonal, so that the smallest eigenvalue has no unit. The eigenvector names the
coordinates that together move nothing.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...errors import MassError, ModelError
from ...model.model import Model
from ...scalar.algebra import floats
from ...scalar.expression import evaluate
from ..composite import mass_matrix
from ..state import State

# A scaled mass matrix of n bodies is exact to about n eps; smaller eigenvalues are zero.
EPSILONS = 1 << 10


def zero_eigenvalue(n: int) -> float:
    """Return the bound below which an eigenvalue of a scaled mass matrix (n, n) is zero: nothing moves."""
    return EPSILONS * sys.float_info.epsilon * n


def massless_motion(model: Model, state: State) -> tuple[str, ...]:
    """Return the names of the speeds that together move no mass at a state of floats; empty if there are none."""
    return _idle(model, np.array([[float(entry) for entry in row] for row in mass_matrix(model, state)]))


def check_mobility(model: Model, M: Any) -> None:
    """Raise ModelError for a mass matrix of numbers with speeds that move no mass, which leave forces undefined.

    Raises
    ------
    ModelError
        The message names the speeds.
    """
    idle = _idle(model, M)
    if idle:
        raise massless(model, idle)


def massless(model: Model, idle: Sequence[str]) -> ModelError:
    """Return the error for speeds that together move no mass."""
    speeds = " and ".join(map(repr, idle))
    return ModelError(
        f"{speeds} {'moves' if len(idle) == 1 else 'together move'} no mass of '{model.name}' at these values "
        "if the constraints are left out: the mass matrix is singular and gives no accelerations and forces. Give "
        "the moving bodies a mass or a moment of inertia above 0, or describe them by the coordinate that the "
        "constraints leave free; where Euler angles are singular, use another sequence of angles or a ball joint."
    )


def _idle(model: Model, M: Any) -> tuple[str, ...]:
    """Return the names of the speeds that together move no mass."""
    if len(M) == 0 or not np.isfinite(M).all():
        return ()
    diagonal = M.diagonal()
    if (diagonal <= 0).any():
        return (model.speed_names[int(diagonal.argmin())],)
    scale = np.sqrt(diagonal)
    values, vectors = np.linalg.eigh(M / np.outer(scale, scale))
    if values[0] > zero_eigenvalue(len(M)):
        return ()
    share = np.abs(vectors[:, 0])
    return tuple(model.speed_names[i] for i in np.flatnonzero(share > share.max() / len(M)))


def check_bodies(model: Model, values: Mapping[str, float]) -> None:
    """Raise MassError for values of parameters that make a body impossible: a negative mass, moment or dimension.

    Raises
    ------
    MassError
        The message names the body, the test that failed and by how much.
    """
    symbols = {parameter.symbol: values[parameter.name] for parameter in model.parameters}

    def number(x: Any) -> float:
        return float(x if isinstance(x, int | float) else evaluate(x, symbols, floats, symbols))

    for name, place in model.bodies.items():
        properties = place.properties
        if properties is None:
            continue
        numbers = [number(x) for x in (place.mass, *properties.positive)]
        inertia = [[number(x) for x in row] for row in place.inertia]
        principal = not any(x for i, row in enumerate(inertia) for j, x in enumerate(row) if i != j)
        moments = sorted(inertia[i][i] for i in range(3)) if principal else np.linalg.eigvalsh(inertia)
        # a quick check of floats; the mass properties decide and give the message
        if min(numbers, default=0) < 0 or moments[0] < 0 or moments[0] + moments[1] < moments[2]:
            try:
                properties.check(values)
            except MassError as error:
                raise MassError(f"Body '{name}': {error}") from None
