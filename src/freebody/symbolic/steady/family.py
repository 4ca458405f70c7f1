"""Families of steady motions: roots of F(x) = 0 that are not isolated.

At a root with k = dim ker ∂F/∂x > 0 either roots coincide, or they form a family. It is a family of dimension k where
Gauss-Newton steps of that rank, begun at x + c for c in the kernel, end beside x at roots of the same rank (constant
rank theorem); beside a multiple root there is none. Of each connected piece one root is kept: roots are joined where
the straight line between them, put back on the conditions, has no gap.

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
PLACES = 16
"""Parts of a line between two members."""
STEPS = 8
"""Gauss-Newton steps back to the conditions, from as far as a step along the kernel."""


def dimension(one: Conditions, x: np.ndarray, held: np.ndarray) -> int:
    """Of the family of roots that x belongs to, 0 for an isolated one; ``held`` marks unknowns left as they are."""
    frame = _Frame.at(one, x[:, None], held)
    with np.errstate(all="ignore"):
        rank = frame.rank(x)
        if rank == frame.n:
            return 0
        _, _, V = np.linalg.svd(frame.jacobian(x[:, None])[0])
        directions = np.vstack([V[rank:], -V[rank:]]).T
        ends = frame.corrected(frame.moved(x[:, None], PACE * directions), rank)
        return max((deficiency(one, end, held) for end in ends.T if _is_root(one, end)), default=0)


def deficiency(one: Conditions, x: np.ndarray, held: np.ndarray) -> int:
    """Dimension of the kernel at a root: that of its family, if it belongs to one."""
    with np.errstate(all="ignore"):
        frame = _Frame.at(one, x[:, None], held)
        return frame.n - frame.rank(x)


def representatives(
    one: Conditions, members: Sequence[np.ndarray], held: np.ndarray, kernel: int
) -> list[int]:
    """Places of one of each connected piece of roots with such kernels: that with the smallest unknowns."""
    x = np.array(members).T
    count = x.shape[1]
    frame = _Frame.at(one, x, held)
    unit = frame.all_units[:, None]
    chosen = set()
    for i in range(count):
        away = np.linalg.norm(_way(one, x[:, [i]], x) / unit, axis=0)
        chosen |= {(min(i, int(j)), max(i, int(j))) for j in np.argsort(away)[1 : NEIGHBOURS + 1]}
    pairs = sorted(chosen)
    piece = list(range(count))

    def first_of(i: int) -> int:
        while piece[i] != i:
            i = piece[i]
        return i

    for (i, j), joined in zip(pairs, _joined(frame, x, pairs, frame.n - kernel), strict=True):
        if joined:
            piece[max(first_of(i), first_of(j))] = min(first_of(i), first_of(j))
    kept: dict[int, int] = {}
    for i in sorted(range(count), key=lambda i: float(np.abs(x[:, i] / unit[:, 0]).sum())):
        kept.setdefault(first_of(i), i)
    return sorted(kept.values())


def _joined(frame: _Frame, x: np.ndarray, pairs: Sequence[tuple[int, int]], rank: int) -> list[bool]:
    """Whether each pair of members can be walked between on the conditions."""
    if not pairs:
        return []
    first, last = (x[:, [pair[k] for pair in pairs]] for k in (0, 1))
    way = _way(frame.one, first, last)
    line = first[:, :, None] + way[:, :, None] * (np.arange(PLACES + 1) / PLACES)
    with np.errstate(all="ignore"):
        walked = frame.corrected(line.reshape(len(x), -1), rank).reshape(line.shape)
        unit = frame.all_units[:, None]
        length = np.linalg.norm(way / unit, axis=0)
        gaps = np.linalg.norm(np.diff(walked, axis=2) / unit[:, :, None], axis=0).max(axis=1)
        return [bool(gap <= 2 * total / PLACES) for gap, total in zip(gaps, length, strict=True)]


@dataclass(frozen=True)
class _Frame:
    """Conditions over the sizes of their terms, and unknowns over their own, so that a rank can be told."""

    one: Conditions
    moving: np.ndarray
    all_units: np.ndarray
    sizes: np.ndarray

    @classmethod
    def at(cls, one: Conditions, x: np.ndarray, held: np.ndarray) -> _Frame:
        """The frame at columns of x."""
        units = np.where(one.angles, 1, np.maximum(1, np.abs(x).max(axis=1)))
        with np.errstate(all="ignore"):
            sizes = np.max([one.size(column) for column in x.T], axis=0)
        return cls(one, np.flatnonzero(~held), units, np.maximum(sizes, EPS * EPS))

    @property
    def n(self) -> int:
        """Number of unknowns that move."""
        return len(self.moving)

    def moved(self, x: np.ndarray, steps: np.ndarray) -> np.ndarray:
        """x with steps (n, N) of the unknowns that move."""
        whole = np.zeros((len(self.all_units), steps.shape[1]))
        whole[self.moving] = steps * self.all_units[self.moving, None]
        return np.asarray(x + whole)

    def jacobian(self, x: np.ndarray) -> np.ndarray:
        """(N, m, n) at the columns of x; zero where there is none, as for ``|y|`` at y = 0."""
        J = np.moveaxis(self.one.jacobian(x)[:, self.moving], -1, 0)
        J = J * self.all_units[self.moving] / self.sizes[:, None]
        return np.where(np.isfinite(J).all(axis=(1, 2))[:, None, None], J, 0)

    def rank(self, x: np.ndarray) -> int:
        """Of the derivatives at one root; full where they do not exist."""
        if not self.n or not np.isfinite(self.one.jacobian(x)).all():
            return self.n
        size = np.linalg.svd(self.jacobian(x[:, None])[0], compute_uv=False)
        return int((size > np.sqrt(EPS) * size.max(initial=0)).sum())

    def corrected(self, x: np.ndarray, rank: int) -> np.ndarray:
        """Columns of x after Gauss-Newton steps of that rank, which do not slide along a family."""
        for _ in range(STEPS):
            U, size, V = np.linalg.svd(self.jacobian(x), full_matrices=False)
            F = (self.one.values(x) / self.sizes[:, None]).T
            inner = np.einsum("kij,ki->kj", U[:, :, :rank], F) / size[:, :rank]
            step = -np.einsum("kji,kj->ik", V[:, :rank], inner)
            x = self.moved(x, np.clip(np.nan_to_num(step), -PACE * 4, PACE * 4))
        return x


def _way(one: Conditions, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """b - a, angles the shorter way round."""
    d = b - a
    return np.where(one.angles[:, None], np.pi - np.mod(np.pi - d, 2 * np.pi), d)


def _is_root(one: Conditions, x: np.ndarray) -> bool:
    return bool((np.abs(one.values(x)) <= 1024 * EPS * one.size(x)).all())
