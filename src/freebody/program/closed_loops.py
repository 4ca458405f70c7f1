"""Closed loops in numbers: actuator forces for a motion, accelerations that keep loops closed, singular positions.

    M u' + h = S τ + Gᵀ λ,   G u' + γ = 0,   G N = 0      =>      (Nᵀ S) τ = Nᵀ (M u' + h)

S selects the coordinates on which actuators act. With as many actuators as degrees of freedom τ is unique; with more,
the smallest τ is taken. Where Nᵀ S is singular, the actuators cannot hold the machine: a dead point (lock-up). Where G
itself loses rank, the machine has more freedom than elsewhere: a branch.

Source: Featherstone, Rigid Body Dynamics Algorithms (2008), §8.12; Gosselin and Angeles, IEEE Trans. Robotics and
Automation 6 (1990) 281 (the two kinds of singular positions).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..dynamics.conditions.constraints import rows
from ..errors import ModelError, nearest
from ..model import Model

Array = NDArray[np.float64]

OPEN = 1e-7
"""Largest violation of the conditions by accelerations, relative to the largest term: round-off of a run's values."""
SINGULAR = 1e-9
"""Ratio of singular values below which a position is singular: a smaller ratio is round-off."""


@dataclass(frozen=True)
class Singularity:
    """How near a position is to a singular one. Made by :meth:`Program.singularity`.

    Attributes
    ----------
    kind : str
        ``"regular"``; ``"branch"``: conditions depend on each other here and not elsewhere, so that the machine can
        move on in more ways than one; ``"lock-up"``: the actuators cannot move or hold the machine here.
    ratio : float
        Ratio of the smallest to the largest singular value: 0 at a singular position, at most 1.
    conditions : tuple of str
        Conditions that depend on each other (nearly so, if the position is regular).
    speeds : tuple of str
        Speeds of the additional motion, or of the motion that remains while the actuators stand still.
    """

    kind: str
    ratio: float
    conditions: tuple[str, ...]
    speeds: tuple[str, ...]

    def __str__(self) -> str:
        """Return the result as a sentence."""
        if self.kind == "branch":
            return (
                f"branch: {' and '.join(self.conditions)} depend on each other here, and "
                f"{', '.join(self.speeds)} are free beyond the usual motion"
            )
        if self.kind == "lock-up":
            return f"lock-up: {', '.join(self.speeds)} can move while the actuators stand still"
        return f"regular: ratio of singular values {self.ratio:.3g}"


def chosen(model: Model, actuators: Any) -> list[int]:
    """Places of speeds, by the names of speeds, coordinates or joints; "all" stands for all speeds."""
    if isinstance(actuators, str):
        if actuators == "all":
            return list(range(model.n_u))
        actuators = actuators.replace(",", " ").split()
    if not isinstance(actuators, Iterable):
        actuators = [actuators]
    places = {name: i for i, name in enumerate(model.speed_names)}
    places |= {name[:-1]: i for name, i in places.items() if name.endswith("'")}
    result = []
    for actuator in actuators:
        text = getattr(actuator, "name", None) or model.names.text_of(actuator)
        if text not in places and text in model.joints:
            links = [model.links[k] for k in model.joints[text].links]
            free = [j for link in links for j, _ in link.partials]
            if len(free) == 1:
                text = model.speed_names[free[0]]
        if text not in places:
            raise ModelError(
                f"Expected coordinates with an actuator, got '{text}'; {nearest(text, [*places, *model.joints])}"
            )
        if places[text] in result:
            raise ModelError(f"The actuator '{text}' is named twice.")
        result.append(places[text])
    if not result:
        raise ModelError("Expected at least one coordinate with an actuator, or actuators='all'.")
    return result


def actuator_forces(
    model: Model, tau: Array, G: Array, gamma: Array, udot: Array, places: list[int]
) -> Array:
    """Forces of the actuators, shape (..., number of actuators), by the equation of the module."""
    violation = np.abs(np.einsum("...ij,...j->...i", G, udot) + gamma)
    size = 1 + np.einsum("...ij,...j->...i", np.abs(G), np.abs(udot)) + np.abs(gamma)
    if violation.size and not (violation <= OPEN * size).all():
        worst = np.unravel_index(np.argmax(violation / size), violation.shape)
        raise ModelError(
            f"The accelerations do not keep the constraints of '{model.name}': one condition is violated by "
            f"{violation[worst]:.3g}. Give those of some coordinates to accelerations(q, u, given={{...}}), which "
            "finds the rest."
        )
    N = _free(model, G)
    A = np.swapaxes(N, -1, -2)[..., places]
    b = np.einsum("...ji,...j->...i", N, tau)
    s = np.linalg.svd(A, compute_uv=False)
    f = N.shape[-1]
    names = ", ".join(model.speed_names[i].rstrip("'") for i in places)
    if len(places) < f:
        raise ModelError(
            f"Expected at least {f} actuators for the {f} degrees of freedom of '{model.name}', got {len(places)}: "
            f"{names}."
        )
    if f and not (s[..., f - 1] > SINGULAR * s[..., 0]).all():
        raise ModelError(
            f"Actuators on {names} cannot hold '{model.name}' in this position: it is locked up, since it can move "
            "while they stand still. program.singularity(q, actuators=...) tells which coordinates move."
        )
    return np.einsum("...ij,...j->...i", np.linalg.pinv(A, rcond=SINGULAR), b)


def _free(model: Model, G: Array) -> Array:
    """Basis N of the motions that the conditions allow, shape (..., n, n - m)."""
    m, n = G.shape[-2:]
    if m == 0:
        return np.broadcast_to(np.eye(n), (*G.shape[:-2], n, n))
    _, s, V = np.linalg.svd(G)
    if not (s[..., -1] > SINGULAR * s[..., 0]).all():
        raise ModelError(
            f"Conditions of '{model.name}' that are independent elsewhere depend on each other in this position: it is "
            "singular, and forces in it are not determined. program.singularity(q) tells which."
        )
    return np.swapaxes(V[..., m:, :], -1, -2)


def completed(model: Model, G: Array, gamma: Array, places: list[int], prescribed: Array) -> Array:
    """Accelerations that keep the conditions and are prescribed at ``places``, shape (n_u,)."""
    n = model.n_u
    E = np.zeros((len(places), n))
    E[np.arange(len(places)), places] = 1.0
    A, b = np.vstack([G, E]), np.concatenate([-gamma, prescribed])
    udot, _, rank, _ = np.linalg.lstsq(A, b, rcond=SINGULAR)
    names = ", ".join(model.speed_names[i] for i in places)
    if rank < n:
        raise ModelError(
            f"Accelerations of {names or 'nothing'} leave {n - rank} degree{'s' if n - rank > 1 else ''} of freedom of "
            f"'{model.name}' open here. Name more, or others where this position is a dead point of these."
        )
    if not np.abs(A @ udot - b).max(initial=0) <= OPEN * (1 + np.abs(b).max(initial=0)):
        raise ModelError(f"The accelerations given for {names} contradict the constraints of '{model.name}'.")
    return udot


def singularity(
    model: Model, G: Array, M: Array, usual: int, active: Sequence[int], places: list[int] | None
) -> Singularity:
    """Return how near a position is to a singular one.

    ``G`` has the rows of all conditions, of which ``usual`` are independent in general, and ``active`` is a set of
    independent rows. ``places`` are those of the actuators; None looks for branches only.
    """
    names = [row.name for row in rows(model)]
    scale = 1 / np.sqrt(np.maximum(M.diagonal(), np.finfo(float).tiny))
    W = G * scale
    lengths = np.linalg.norm(W, axis=1, keepdims=True)
    W = np.divide(W, lengths, out=np.zeros_like(W), where=lengths > 0)
    n = model.n_u
    if usual:
        U, s, V = np.linalg.svd(W)
        ratio = float(s[usual - 1] / s[0]) if s[0] > 0 else 0.0
        if ratio <= SINGULAR or places is None:
            # the independent conditions that take part in the smallest singular value
            left_vectors = np.linalg.svd(W[list(active)])[0]
            parts = _large(np.abs(left_vectors[:, -1]))
            return Singularity(
                "branch" if ratio <= SINGULAR else "regular",
                ratio,
                tuple(names[active[k]] for k in parts),
                tuple(model.speed_names[k] for k in _large(np.abs(V[usual - 1] * scale))),
            )
    elif places is None:
        return Singularity("regular", 1.0, (), ())
    E = np.zeros((len(places or ()), n))
    E[np.arange(len(places or ())), places or []] = 1.0
    _, s, V = np.linalg.svd(np.vstack([W[list(active)], E]))
    ratio = float(s[n - 1] / s[0]) if len(s) >= n else 0.0
    speeds = tuple(model.speed_names[k] for k in _large(np.abs(V[n - 1] * scale)))
    return Singularity("lock-up" if ratio <= SINGULAR else "regular", ratio, (), speeds)


def _large(parts: Array) -> list[int]:
    """Places of the parts that are more than round-off."""
    return [int(k) for k in np.flatnonzero(parts > 1e-6 * parts.max(initial=0))]
