"""The motion in the middle of a step, from the states at its ends (`free_joints`)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ...model import Model
from ...model.parts import Link
from ...scalar.algebra import Vector, add, apply, apply_transpose, cross, subtract
from ...space.quaternion import matrix_from_quaternion
from ..ode.dense_output import Array
from ..start.initial import number


def center(model: Model, values: Mapping[str, float], link: Link) -> Vector:
    """Return the mass centre of a link, from its origin, in its axes [m]."""
    x, y, z = (number(model, values, c, "a mass centre") for c in link.center)
    return (x, y, z)


def middle_of(model: Model, states: Array, rates: Array, h: float) -> Array:
    """Return q_M = q + h/2 q'(q, u) of each state, with unit quaternions; ``rates`` begin with q'."""
    q = states[:, : model.n_q] + h / 2 * rates[:, : model.n_q]
    for i in model.quaternions:
        q[:, i : i + 4] /= np.linalg.norm(q[:, i : i + 4], axis=1, keepdims=True)
    return q


def mean_motion(
    model: Model, values: Mapping[str, float], middle: Array, begin: Array, end: Array, h: Array
) -> tuple[Array, Array]:
    """Return the speeds ū and the accelerations u' with which the balance of a step holds, from the states at its ends.

    ``middle``   coordinates q_M of each step;  ``h``: its length, of shape (steps, 1)
    """
    n_q = model.n_q
    u, u_new = begin[:, n_q:].copy(), end[:, n_q:].copy()
    flights = [(link, center(model, values, link)) for link in model.links if link.flies]
    for link, c in flights:
        M = _rotation(middle, link)
        for speeds, states in ((u, begin), (u_new, end)):
            w, v = _twist(speeds, link)
            fixed = apply(_rotation(states, link), add(v, cross(w, c)))
            speeds[:, link.u + 3 : link.u + 6] = np.transpose(
                subtract(apply_transpose(M, fixed), cross(w, c))
            )
    mean, rate = (u + u_new) / 2, (u_new - u) / h
    for link, c in flights:
        w, v = _twist(mean, link)
        rate[:, link.u + 3 : link.u + 6] -= np.transpose(cross(w, add(v, cross(w, c))))
    return mean, rate


def _rotation(states: Array, link: Link) -> Any:
    return matrix_from_quaternion(tuple(states[:, link.quaternion : link.quaternion + 4].T))


def _twist(speeds: Array, link: Link) -> tuple[Any, Any]:
    """Return (w, v) of a free joint."""
    return tuple(speeds[:, link.u : link.u + 3].T), tuple(speeds[:, link.u + 3 : link.u + 6].T)
