"""Conditions of steady motion in numbers: their values, derivatives and sizes, and Newton's method on them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...scalar.algebra import Scalar
from ...scalar.polynomial import Polynomial, Ring
from ...scalar.substitute import Substitution, arrays

EPS = float(np.finfo(float).eps)
STEPS = 60
"""Most Newton steps."""


class Conditions:
    """Polynomials in some unknowns, with numbers for all other atoms, and their exact derivatives."""

    def __init__(
        self, ring: Ring, pieces: Sequence[Scalar], unknowns: Sequence[Any], numbers: Mapping[Any, Any]
    ) -> None:
        self.ring = ring
        self.pieces = list(pieces)
        self.unknowns = list(unknowns)
        self.numbers = dict(numbers)
        self.slopes = [[ring.derivative(x, a) for a in unknowns] for x in pieces]
        self.angles = np.array([self._is_angle(a) for a in unknowns], dtype=bool)
        self._terms = sum(_length(x) for x in pieces)
        self._slope_terms = sum(_length(x) for row in self.slopes for x in row)

    def _is_angle(self, atom: Any) -> bool:
        unknown = self.ring.find(atom)
        x = self.ring.variable(unknown.index)  # type: ignore[union-attr]
        used = {generator.index: generator for piece in self.pieces for generator in self.ring.used(piece)}
        depending = [generator for generator in used.values() if generator.depends & 1 << unknown.index]  # type: ignore[union-attr]
        return bool(depending) and all(
            generator.kind in ("sin", "cos") and generator.arguments[0] == x for generator in depending
        )

    def _at(self, x: np.ndarray) -> Substitution:
        return Substitution(self.ring, arrays, {**self.numbers, **dict(zip(self.unknowns, x, strict=True))})

    def values(self, x: np.ndarray) -> np.ndarray:
        """Return the values (m, N) at the columns of x (n, N)."""
        self.ring.budget.evaluation(self._terms, x[:1].size)
        at = self._at(x)
        return np.array([np.broadcast_to(at(p), x.shape[1:]) for p in self.pieces], dtype=float)

    def jacobian(self, x: np.ndarray) -> np.ndarray:
        """Return the derivatives (m, n, N) at the columns of x (n, N)."""
        self.ring.budget.evaluation(self._slope_terms, x[:1].size)
        at = self._at(x)
        return np.array(
            [[np.broadcast_to(at(d), x.shape[1:]) for d in row] for row in self.slopes], dtype=float
        )

    def size(self, x: np.ndarray) -> np.ndarray:
        """Return the sum of the absolute terms of each polynomial at one point, plus the effect of round-off of x."""
        at = self._at(x)
        result = []
        near = np.abs(self.jacobian(x)) @ np.maximum(1, np.abs(x)) if len(x) else np.zeros(len(self.pieces))
        for p in self.pieces:
            total = 0
            for monomial, c in p.terms():
                term = abs(c) / p.den
                for index, power in monomial:
                    term = term * abs(float(at.generator(index))) ** power
                total = total + term
            result.append(total)
        return np.array(result, dtype=float) + near

    def newton(self, x: np.ndarray, steps: int = STEPS) -> np.ndarray:
        """Return the columns of x after damped Newton steps; columns that fail are not finite."""
        x = np.array(x, dtype=float)
        active = np.arange(x.shape[1])
        with np.errstate(all="ignore"):
            for _ in range(steps):
                y = x[:, active]
                F, J = self.values(y), np.moveaxis(self.jacobian(y), -1, 0)
                bad = ~np.isfinite(J).all(axis=(1, 2)) | ~np.isfinite(F).all(axis=0)
                J[bad] = np.eye(*J.shape[1:])
                step = -(np.linalg.pinv(J) @ F.T[:, :, None])[:, :, 0].T
                longest = np.maximum(1, np.abs(y).max(axis=0))
                step = step * np.minimum(1, longest / np.maximum(np.abs(step).max(axis=0), EPS * EPS))
                step[:, bad] = np.nan
                x[:, active] = y + step
                active = active[~bad & (np.abs(step) > 2 * EPS * np.abs(y) + EPS * EPS).any(axis=0)]
                if not len(active):
                    break
        return x


def vanishes(conditions: Conditions) -> bool:
    """Return True if conditions without unknowns are zero up to round-off."""
    x = np.zeros((0,))
    value = np.abs(conditions.values(x))
    return bool((value <= 64 * EPS * conditions.size(x)).all())


def _length(x: Scalar) -> int:
    return len(x) if type(x) is Polynomial else 1
