"""Families of steady motions: roots of F(x) = 0 that are not isolated.

At a root with k = dim ker ∂F/∂x > 0, either roots coincide or they form a family. It is a family of dimension k if
Gauss-Newton steps of that rank from x + c, with c in the kernel, end beside x at roots of the same rank (constant rank
theorem); near a multiple root there is no such root. One root of each connected piece is kept: two roots are joined if
the straight line between them, corrected to the conditions, has no gap.

Source: E. L. Allgower, K. Georg, Introduction to Numerical Continuation Methods (2003), chapters 2 and 15.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .conditions import EPS, Conditions

PACE = 1 / 64
"""Length of a step along the kernel, in radians and in units of the unknowns' sizes."""
NEIGHBOURS = 8
"""Number of nearest members that a member is compared with."""
PARTS = 16
"""Number of parts of a line between two members."""
STEPS = 8
"""Number of Gauss-Newton steps back to the conditions, from a distance of at most one step along the kernel."""


def dimension(conditions: Conditions, x: np.ndarray, fixed: np.ndarray) -> int:
    """Return the dimension of the family of the root x, 0 if it is isolated; ``fixed`` marks constant unknowns."""
    frame = _Frame.at(conditions, x[:, None], fixed)
    with np.errstate(all="ignore"):
        rank = frame.rank(x)
        if rank == frame.n:
            return 0
        _, _, V = np.linalg.svd(frame.jacobian(x[:, None])[0])
        directions = np.vstack([V[rank:], -V[rank:]]).T
        ends = frame.corrected(frame.moved(x[:, None], PACE * directions), rank)
        return max(
            (deficiency(conditions, end, fixed) for end in ends.T if _is_root(conditions, end)), default=0
        )


def deficiency(conditions: Conditions, x: np.ndarray, fixed: np.ndarray) -> int:
    """Return the dimension of the kernel at a root, which is that of its family if the root has one."""
    with np.errstate(all="ignore"):
        frame = _Frame.at(conditions, x[:, None], fixed)
        return frame.n - frame.rank(x)


def representatives(
    conditions: Conditions, members: Sequence[np.ndarray], fixed: np.ndarray, kernel: int
) -> list[int]:
    """Return the index of one root of each connected piece: the root with the smallest unknowns."""
    x = np.array(members).T
    count = x.shape[1]
    frame = _Frame.at(conditions, x, fixed)
    unit = frame.all_units[:, None]
    neighbours = set()
    for i in range(count):
        away = np.linalg.norm(_way(conditions, x[:, [i]], x) / unit, axis=0)
        neighbours |= {(min(i, int(j)), max(i, int(j))) for j in np.argsort(away)[1 : NEIGHBOURS + 1]}
    pairs = sorted(neighbours)
    piece = list(range(count))

    def first_of(i: int) -> int:
        while piece[i] != i:
            i = piece[i]
        return i

    for (i, j), joined in zip(pairs, _joined(frame, x, pairs, frame.n - kernel), strict=True):
        if joined:
            piece[max(first_of(i), first_of(j))] = min(first_of(i), first_of(j))
    result: dict[int, int] = {}
    for i in sorted(range(count), key=lambda i: float(np.abs(x[:, i] / unit[:, 0]).sum())):
        result.setdefault(first_of(i), i)
    return sorted(result.values())


def _joined(frame: _Frame, x: np.ndarray, pairs: Sequence[tuple[int, int]], rank: int) -> list[bool]:
    """Return for each pair of members True if a path on the conditions connects them."""
    if not pairs:
        return []
    first, last = (x[:, [pair[k] for pair in pairs]] for k in (0, 1))
    way = _way(frame.conditions, first, last)
    line = first[:, :, None] + way[:, :, None] * (np.arange(PARTS + 1) / PARTS)
    with np.errstate(all="ignore"):
        walked = frame.corrected(line.reshape(len(x), -1), rank).reshape(line.shape)
        unit = frame.all_units[:, None]
        length = np.linalg.norm(way / unit, axis=0)
        gaps = np.linalg.norm(np.diff(walked, axis=2) / unit[:, :, None], axis=0).max(axis=1)
        return [bool(gap <= 2 * total / PARTS) for gap, total in zip(gaps, length, strict=True)]


@dataclass(frozen=True)
class _Frame:
    """Conditions divided by the sizes of their terms, and unknowns by their own sizes, to determine ranks."""

    conditions: Conditions
    moving: np.ndarray
    all_units: np.ndarray
    sizes: np.ndarray

    @classmethod
    def at(cls, conditions: Conditions, x: np.ndarray, fixed: np.ndarray) -> _Frame:
        """Return the frame at columns of x."""
        units = np.where(conditions.angles, 1, np.maximum(1, np.abs(x).max(axis=1)))
        with np.errstate(all="ignore"):
            sizes = np.max([conditions.size(column) for column in x.T], axis=0)
        return cls(conditions, np.flatnonzero(~fixed), units, np.maximum(sizes, EPS * EPS))

    @property
    def n(self) -> int:
        """Number of unknowns that move."""
        return len(self.moving)

    def moved(self, x: np.ndarray, steps: np.ndarray) -> np.ndarray:
        """Return x plus steps (n, N) of the unknowns that move."""
        whole = np.zeros((len(self.all_units), steps.shape[1]))
        whole[self.moving] = steps * self.all_units[self.moving, None]
        return np.asarray(x + whole)

    def jacobian(self, x: np.ndarray) -> np.ndarray:
        """Return the derivatives (N, m, n) at the columns of x; zero if there is none, as for ``|y|`` at y = 0."""
        J = np.moveaxis(self.conditions.jacobian(x)[:, self.moving], -1, 0)
        J = J * self.all_units[self.moving] / self.sizes[:, None]
        return np.where(np.isfinite(J).all(axis=(1, 2))[:, None, None], J, 0)

    def rank(self, x: np.ndarray) -> int:
        """Return the rank of the derivatives at a root; full if they do not exist."""
        if not self.n or not np.isfinite(self.conditions.jacobian(x)).all():
            return self.n
        size = np.linalg.svd(self.jacobian(x[:, None])[0], compute_uv=False)
        return int((size > np.sqrt(EPS) * size.max(initial=0)).sum())

    def corrected(self, x: np.ndarray, rank: int) -> np.ndarray:
        """Return the columns of x after Gauss-Newton steps of that rank, which do not move along a family."""
        for _ in range(STEPS):
            U, size, V = np.linalg.svd(self.jacobian(x), full_matrices=False)
            F = (self.conditions.values(x) / self.sizes[:, None]).T
            inner = np.einsum("kij,ki->kj", U[:, :, :rank], F) / size[:, :rank]
            step = -np.einsum("kji,kj->ik", V[:, :rank], inner)
            x = self.moved(x, np.clip(np.nan_to_num(step), -PACE * 4, PACE * 4))
        return x


def _way(conditions: Conditions, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return b - a, with angles in the shorter direction."""
    d = b - a
    return np.where(conditions.angles[:, None], np.pi - np.mod(np.pi - d, 2 * np.pi), d)


def _is_root(conditions: Conditions, x: np.ndarray) -> bool:
    return bool((np.abs(conditions.values(x)) <= 1024 * EPS * conditions.size(x)).all())
