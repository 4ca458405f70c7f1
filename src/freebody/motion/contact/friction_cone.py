"""Friction cones of several contacts: impulses of compliant contacts, their slope, and the distance to a boundary.

With free = y - r/ε, the impulses are

    x_N = max(0, free_N),    x_T = the point of the disk |x_T| <= μ x_N nearest to free_T
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..ode.dense_output import Array


class FrictionCones:
    """The laws of the contacts as functions of ``free`` = y - r/ε: the impulses of compliant contacts and their slope.

    ``kinds`` and ``mu`` have one entry per row, as in :func:`freebody.motion.contact.newton.polished`.
    """

    def __init__(self, kinds: Any, mu: Array) -> None:
        kinds = np.asarray(kinds)
        self.normal = np.flatnonzero(kinds == 1)
        first = np.flatnonzero((kinds == 2) | (kinds == 3))
        self.of = first - 1  # the normal row of each contact with friction
        self.mu = np.asarray(mu, dtype=float)[first]
        # a contact with a single tangent has no second row: its index points to an extra zero row after the last
        self.tangents = np.stack([first, np.where(kinds[first] == 3, first + 1, len(kinds))])

    def impulses(self, free: Array) -> Array:
        """Return x: normal impulses cut off at zero, friction projected onto the disk |x_T| <= μ x_N."""
        x = np.zeros(len(free) + 1)
        x[self.normal] = np.maximum(free[self.normal], 0.0)
        T = np.append(free, 0.0)[self.tangents]
        limit, length = self.mu * x[self.of], np.hypot(*T)
        x[self.tangents] = T * np.where(length > limit, limit / np.where(length > 0, length, 1.0), 1.0)
        return x[:-1]

    def reach(self, x: Array, d: Array) -> float:
        """Return the factor t at which x + t d first brings a contact to the boundary of its cone; 0 if none does.

        |T + t dT| = μ (N + t dN)  or  N + t dN = 0
        """
        N, dN = x[self.of], d[self.of]
        T, dT = np.append(x, 0.0)[self.tangents], np.append(d, 0.0)[self.tangents]
        a = (dT * dT).sum(axis=0) - (self.mu * dN) ** 2
        h = (T * dT).sum(axis=0) - self.mu**2 * N * dN
        c = np.minimum((T * T).sum(axis=0) - (self.mu * N) ** 2, 0.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            root = np.sqrt(np.maximum(h * h - a * c, 0.0))
            # the smallest positive root of a t² + 2 h t + c = 0, with c <= 0
            cone = np.where(h > 0, -c / (h + root), np.where(a > 0, (root - h) / a, np.inf))
            lift = np.where(d[self.normal] < 0, -x[self.normal] / d[self.normal], np.inf)
        inside = (N > 0) & (c < -1e-12 * (self.mu * N) ** 2)
        ends = np.concatenate([cone[inside], lift[x[self.normal] > 0]])
        ends = ends[np.isfinite(ends) & (ends > 0)]
        return float(ends.min()) if len(ends) else 0.0

    def slope(self, free: Array) -> Array:
        """Return the derivative ∂x/∂(y - r/ε) of :meth:`impulses`."""
        n = len(free)
        D = np.zeros((n + 1, n + 1))
        pressed = free[self.normal] > 0
        D[self.normal, self.normal] = pressed
        x_N, (p, q) = np.maximum(free[self.of], 0.0), self.tangents
        T = np.append(free, 0.0)[self.tangents]
        limit, length = self.mu * x_N, np.hypot(*T)
        out = length > limit
        size = np.where(length > 0, length, 1.0)
        e, share = T / size, np.where(out, limit / size, 1.0)
        for i, row in enumerate((p, q)):
            for j, column in enumerate((p, q)):
                D[row, column] = share * ((i == j) - np.where(out, e[i] * e[j], 0.0))
            D[row, self.of] = np.where(out & (free[self.of] > 0), self.mu * e[i], 0.0)
        return D[:-1, :-1]
