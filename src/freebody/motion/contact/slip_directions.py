"""Directions in which slips in space begin: along the tangential acceleration (in an impact, speed), r_T × d = 0.

    λ = base + B x + Σ N_i e(d_i),    e(d) = n - μ d,    r = A λ + c,    r = 0 on the held rows

The held rows determine x and the normal forces N of held contacts. For a single direction d = (cos a, sin a), Cramer's
rule makes det S · (r_T × d) a trigonometric polynomial of degree 2 in a. Its roots are those of a polynomial of degree
4, so all directions are found. For several directions, Newton's method runs from many starts at once.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

Array = np.ndarray[Any, np.dtype[np.float64]]

SINGULAR = 1e10
"""Condition number above which the held rows count as dependent: they then leave the forces indeterminate."""

STEPS = 40
"""Limit on Newton steps. Each halves the distance to a double root: 24 from 0.5 to round-off of r_T × d."""


@dataclass(frozen=True)
class Sought:
    """A contact whose slip direction is unknown: its row, its friction, and its normal force if that is known."""

    row: int
    friction: float
    given: float | None = None


def directions(
    A: Array,
    c: Array,
    base: Array,
    columns: Sequence[Array],
    rows: Sequence[int],
    sought: Sequence[Sought],
    starts: Array,
) -> list[Array] | None:
    """Return the angles of the directions, one array per solution; None if the held rows are dependent.

    Parameters
    ----------
    base, columns   known forces and the columns of the unknown forces, without the contacts in ``sought``
    rows            rows of r that vanish, including those of held contacts in ``sought``
    starts          initial angles of the search, shape (n, len(sought)); unused for a single direction
    """
    problem = _Problem(A, c, base, columns, list(rows), sought)
    if len(sought) == 1:
        starts = 2 * np.pi * np.arange(5)[:, None] / 5
    S = problem.matrix(starts)[1]
    if S.size and not np.linalg.cond(S).min() < SINGULAR:
        return None
    try:
        if len(sought) == 1:
            value = problem.across(starts)[0]
            h = np.fft.fft(value[:, 0] * np.linalg.det(S)) / 5
            # Σ h_k z^k, k = -2 to 2, times z², highest power first
            roots = np.roots(h[[2, 1, 0, 4, 3]]) if np.abs(h).max() > 0 else np.empty(0)
            starts = np.angle(roots[np.abs(np.abs(roots) - 1) < 1e-3])[:, None]
        found = problem.polished(starts)
    except np.linalg.LinAlgError:
        return None
    distinct: list[Array] = []
    for angles in found:
        if all(np.abs(np.exp(1j * angles) - np.exp(1j * one)).max() >= 1e-7 for one in distinct):
            distinct.append(angles)
    return distinct


class _Problem:
    def __init__(
        self,
        A: Array,
        c: Array,
        base: Array,
        columns: Sequence[Array],
        rows: list[int],
        sought: Sequence[Sought],
    ) -> None:
        self.A, self.c, self.base, self.rows, self.sought = A, c, base, rows, sought
        self.fixed = np.array(columns).reshape(-1, len(c)).T
        self.held = [i for i, one in enumerate(sought) if one.given is None]
        self.at = np.array([one.row for one in sought])

    def _units(self, cos: Array, sin: Array) -> Array:
        """Return the tangential parts of e(d), (n, k, m); with (-sin, cos) as arguments, their derivatives."""
        E = np.zeros((*cos.shape, len(self.c)))
        for i, one in enumerate(self.sought):
            E[:, i, one.row + 1] = -one.friction * cos[:, i]
            E[:, i, one.row + 2] = -one.friction * sin[:, i]
        return E

    def matrix(self, angles: Array) -> tuple[Array, Array, Array]:
        """Return e(d), S and B at each of the angles."""
        E = self._units(np.cos(angles), np.sin(angles))
        for i, one in enumerate(self.sought):
            E[:, i, one.row] = 1.0
        B = np.concatenate(
            [np.broadcast_to(self.fixed, (len(E), *self.fixed.shape)), E[:, self.held].transpose(0, 2, 1)],
            axis=2,
        )
        return E, self.A[self.rows] @ B, B

    def across(self, angles: Array) -> tuple[Array, Array, Array]:
        """Return r_T × d (n, k), its derivatives with respect to the angles (n, k, k), and its round-off (n, k).

        The round-off of a sum of m terms is m eps Σ |term|, that of x = S⁻¹ g is m eps |S⁻¹| (|S| |x| + |g|): Higham,
        Accuracy and Stability of Numerical Algorithms (2002), sections 3.1 and 7.2.
        """
        E, S, B = self.matrix(angles)
        cos, sin = np.cos(angles), np.sin(angles)
        turned = self._units(-sin, cos)
        base = np.broadcast_to(self.base, (len(E), len(self.c))).copy()
        for i, one in enumerate(self.sought):
            if one.given is not None:
                base += one.given * E[:, i]
        goal = -(base @ self.A.T + self.c)[:, self.rows]
        x = np.linalg.solve(S, goal[..., None])[..., 0] if self.rows else np.empty((len(E), 0))
        r = (base + np.einsum("nmj,nj->nm", B, x)) @ self.A.T + self.c
        unsure = np.abs(x)
        if self.rows:
            terms = np.einsum("nij,nj->ni", np.abs(S), unsure) + np.abs(goal)
            unsure = unsure + np.einsum("nij,nj->ni", np.abs(np.linalg.inv(S)), terms)
        size = (np.abs(base) + np.einsum("nmj,nj->nm", np.abs(B), unsure)) @ np.abs(self.A).T + np.abs(self.c)
        round_off = len(self.c) * np.finfo(float).eps * (size[:, self.at + 1] + size[:, self.at + 2])
        first, second = r[:, self.at + 1], r[:, self.at + 2]
        value = second * cos - first * sin
        slope = np.zeros((*value.shape, len(self.sought)))
        slots = self.fixed.shape[1]
        for i, one in enumerate(self.sought):
            N = one.given if one.given is not None else x[:, slots + self.held.index(i), None]
            push = N * turned[:, i]
            if self.rows:
                dx = np.linalg.solve(S, -(push @ self.A.T)[:, self.rows, None])[..., 0]
                push = push + np.einsum("nmj,nj->nm", B, dx)
            change = push @ self.A.T
            slope[:, :, i] = change[:, self.at + 2] * cos - change[:, self.at + 1] * sin
        own = np.arange(len(self.sought))
        slope[:, own, own] -= second * sin + first * cos
        return value, slope, round_off

    def polished(self, angles: Array) -> list[Array]:
        """Return zeros near the starts, by Newton's method, without those not reached in :data:`STEPS` steps.

        At a double root the slope vanishes with r_T × d, and the steps end in noise. There a zero is accepted if
        r_T × d is within its round-off.
        """
        reached = []
        best, least = angles, np.full(len(angles), np.inf)
        for _ in range(STEPS):
            if not len(angles):
                break
            value, slope, round_off = self.across(angles)
            miss = (np.abs(value) / np.maximum(round_off, np.finfo(float).tiny)).max(axis=1)
            closer = miss < least
            best, least = np.where(closer[:, None], angles, best), np.where(closer, miss, least)
            change = -np.einsum("nij,nj->ni", np.linalg.pinv(slope, rcond=1e-8), value)
            angles = angles + np.clip(change, -0.5, 0.5)
            last = np.abs(change).max(axis=1) < 1e-13
            stays = ~last & ~closer & (least <= 1)
            reached += [*angles[last], *best[stays]]
            on = ~(last | stays)
            angles, best, least = angles[on], best[on], least[on]
        return [*reached, *best[least <= 1]]


def newton(function: Callable[[Array], Array | None], x: Array, most: int = 40) -> Array | None:
    """Return a zero of a function of angles near ``x``, or None. The slope is approximated by differences."""
    step = 1e-6
    for _ in range(most):
        value = function(x)
        if value is None:
            return None
        columns = []
        for k in range(len(x)):
            turned = x.copy()
            turned[k] += step
            other = function(turned)
            if other is None:
                return None
            columns.append((other - value) / step)
        change = np.linalg.lstsq(np.array(columns).T, -value, rcond=1e-8)[0]
        change = np.clip(change, -0.5, 0.5)
        x = x + change
        if np.abs(change).max() < 1e-14:
            return x
    return x if np.abs(change).max() < 1e-12 else None
