"""Finite deviations from a state or a motion in the coordinates of the linear equations, and states from deviations.

scalar: q = q0 + ξ        ball: e = e0 ∘ exp(ξ/2)        free: p = p0 + R0 ξ_d
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...dynamics.conditions.constrained import closed_coordinates
from ...dynamics.conditions.linearized import linearized
from ...dynamics.state import State
from ...model.model import Model
from ...scalar.algebra import apply, floats
from ...space.quaternion import matrix_from_quaternion, quaternion_conjugate, quaternion_product
from .linear_model import LinearModel
from .operating_point import tangent_drift, tangent_names

Array = NDArray[np.float64]


def displaced(model: Model, q0: Sequence[float], xi: Sequence[float]) -> list[float]:
    """Return the coordinates at a deviation ``xi`` from ``q0``."""
    names = tangent_names(model)
    result = [float(x) for x in q0]
    for i, name in enumerate(model.coordinate_names):
        if model.coordinates[i].kind == "scalar":
            result[i] += float(xi[names.index(name)])
    for link in model.links:
        if not link.own:
            continue
        start = link.quaternion
        e0: Any = tuple(result[start : start + 4])
        turn = np.asarray(xi[link.u : link.u + 3], dtype=float)
        half = float(np.linalg.norm(turn)) / 2
        # sin(h)/h at h = 0 is 1; np.sinc is sin(pi x)/(pi x)
        vector = turn / 2 * np.sinc(half / np.pi)
        if link.flies:
            shift: Any = tuple(float(x) for x in xi[link.u + 3 : link.u + 6])
            way = apply(matrix_from_quaternion(e0), shift)
            result[link.q : link.q + 3] = [
                a + b for a, b in zip(result[link.q : link.q + 3], way, strict=True)
            ]
        result[start : start + 4] = quaternion_product(e0, (float(np.cos(half)), *vector.tolist()))
    return result


def deviations(model: Model, q0: Array, q: Array) -> Array:
    """Return the deviations (n, n_u) of coordinates ``q`` (n, n_q) from ``q0`` of the same shape."""
    names = tangent_names(model)
    result = np.zeros((len(q), model.n_u))
    for i, name in enumerate(model.coordinate_names):
        if model.coordinates[i].kind == "scalar":
            result[:, names.index(name)] = q[:, i] - q0[:, i]
    for link in model.links:
        if not link.own:
            continue
        start = link.quaternion
        e0: Any = tuple(q0[:, start + k] for k in range(4))
        e: Any = tuple(q[:, start + k] for k in range(4))
        turned = np.array(quaternion_product(quaternion_conjugate(e0), e))
        turned = turned * np.where(turned[0] < 0, -1, 1)  # e and -e are the same turn: take the shorter one
        size = np.linalg.norm(turned[1:], axis=0)
        half = np.arctan2(size, turned[0])
        result[:, link.u : link.u + 3] = (2 * turned[1:] / np.sinc(half / np.pi)).T
        if link.flies:
            R0: Array = np.array(matrix_from_quaternion(e0))  # (3, 3, n)
            way = (q - q0)[:, link.q : link.q + 3]
            result[:, link.u + 3 : link.u + 6] = np.einsum("ijn,ni->nj", R0, way)
    return result


def start_of(
    linear: LinearModel, xi: Sequence[float], rates: Sequence[float]
) -> tuple[list[float], list[float]]:
    """Return the state (q, u) at deviations ξ (with the carried ones) and rates ξ' of linear equations.

    For a machine with constraints, the dependent coordinates follow from φ = 0 and the dependent speeds from ψ = 0.
    """
    model = linear.model
    q0 = [float(linear.point[name]) for name in model.coordinate_names]
    u0 = np.array([float(linear.point[name]) for name in model.speed_names])
    p, w = np.asarray(xi, dtype=float), np.asarray(rates, dtype=float)
    if not model.constraints:
        u = u0 + w - np.array(tangent_drift(model, u0.tolist()), dtype=float) @ p
        return displaced(model, q0, p.tolist()), u.tolist()
    terms, choice = linear.canonical, linear.canonical["chosen"]
    T, S, P, to_rates = (np.array(terms[key], dtype=float) for key in ("T", "S", "P", "to_rates"))
    p = np.concatenate([p, np.zeros(T.shape[1] - len(p))])  # carried deviations, zero by default
    v = w - to_rates @ p
    fixed_speeds = [*choice.speeds, *choice.carried]
    numbers = {parameter.symbol: linear.values[parameter.name] for parameter in model.parameters}
    q = closed_coordinates(
        model, displaced(model, q0, (T @ p).tolist()), values=linear.values, fixed=fixed_speeds
    )
    u = u0 + S @ v + P @ p
    state = State(model, floats, 0, q, u.tolist(), numbers)
    conditions = linearized(model, state)
    dependent, active = list(choice.dependent_speeds), list(choice.active)
    G = np.array(conditions.matrix, dtype=float).reshape(-1, model.n_u)[active]
    u[dependent] -= np.linalg.solve(G[:, dependent], np.array(conditions.rate, dtype=float)[active])
    return q, u.tolist()
