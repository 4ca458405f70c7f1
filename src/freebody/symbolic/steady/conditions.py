"""Conditions of steady motion in numbers: their values, derivatives and sizes, and Newton's method on them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

import numpy as np

from ...scalar.algebra import Scalar
from ...scalar.polynomial import Polynomial, Ring
from ...scalar.substitute import Substitution, arrays

EPS = float(np.finfo(float).eps)
STEPS = 60
"""Most Newton steps."""
BLOCK = 2**20
"""Most products of terms and columns that are in memory together."""


class _Table:
    """The terms of polynomials as arrays: their coefficients, and for each generator its powers in the terms."""

    def __init__(self, polynomials: Sequence[Scalar]) -> None:
        coefficients: list[float] = []
        places: dict[int, list[tuple[int, int]]] = {}
        self.first = []  # term of each polynomial
        for x in polynomials:
            self.first.append(len(coefficients))
            terms, den = (x.terms() or [((), 0)], x.den) if type(x) is Polynomial else ([((), x)], 1)
            for monomial, c in terms:
                for generator, power in monomial:
                    places.setdefault(generator, []).append((len(coefficients), power))
                coefficients.append(float(Fraction(c) / den))
        self.coefficients = np.array(coefficients)
        self.powers = [(generator, *np.array(found).T) for generator, found in places.items()]

    def values(self, at: Substitution, shape: tuple[int, ...], absolute: bool = False) -> np.ndarray:
        """Return the sum of the terms of each polynomial, or of their absolute values, for unknowns of this shape."""
        products = np.multiply.outer(self.coefficients, np.ones(shape))
        for generator, rows, powers in self.powers:
            base = np.broadcast_to(np.asarray(at.generator(generator), dtype=float), shape)
            products[rows] *= base ** powers.reshape(-1, *[1] * len(shape))
        if not self.first:
            return products
        return np.add.reduceat(np.abs(products) if absolute else products, self.first, axis=0)


class Conditions:
    """Polynomials in some unknowns, with numbers for all other atoms, and their exact derivatives."""

    def __init__(
        self, ring: Ring, pieces: Sequence[Scalar], unknowns: Sequence[Any], numbers: Mapping[Any, Any]
    ) -> None:
        self.ring = ring
        self.pieces = list(pieces)
        self.unknowns = list(unknowns)
        self.numbers = dict(numbers)
        self.angles = np.array([self._is_angle(a) for a in unknowns], dtype=bool)
        self._pieces = _Table(pieces)
        self._slopes = _Table([ring.derivative(x, a) for x in pieces for a in unknowns])

    def _is_angle(self, atom: Any) -> bool:
        unknown = self.ring.find(atom)
        x = self.ring.variable(unknown.index)  # type: ignore[union-attr]
        used = {generator.index: generator for piece in self.pieces for generator in self.ring.used(piece)}
        depending = [generator for generator in used.values() if generator.depends & 1 << unknown.index]  # type: ignore[union-attr]
        return bool(depending) and all(
            generator.kind in ("sin", "cos") and generator.arguments[0] == x for generator in depending
        )

    def _evaluated(self, table: _Table, x: np.ndarray, absolute: bool = False) -> np.ndarray:
        """Return the values (m, N) of polynomials at the columns of x (n, N)."""
        terms = len(table.coefficients)
        self.ring.budget.evaluation(terms, x[:1].size)
        blocks = [x] if x.ndim == 1 else np.array_split(x, 1 + terms * x.shape[1] // BLOCK, axis=1)
        result = []
        for block in blocks:
            numbers = {**self.numbers, **dict(zip(self.unknowns, block, strict=True))}
            result.append(table.values(Substitution(self.ring, arrays, numbers), block.shape[1:], absolute))
        return result[0] if len(result) == 1 else np.concatenate(result, axis=1)

    def values(self, x: np.ndarray) -> np.ndarray:
        """Return the values (m, N) at the columns of x (n, N)."""
        return self._evaluated(self._pieces, x)

    def jacobian(self, x: np.ndarray) -> np.ndarray:
        """Return the derivatives (m, n, N) at the columns of x (n, N)."""
        shape = (len(self.pieces), len(self.unknowns), *x.shape[1:])
        return self._evaluated(self._slopes, x).reshape(shape)

    def size(self, x: np.ndarray) -> np.ndarray:
        """Return the sum of the absolute terms of each polynomial at one point, plus the effect of round-off of x."""
        return self._evaluated(self._pieces, x, absolute=True) + np.abs(self.jacobian(x)) @ np.maximum(
            1, np.abs(x)
        )

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
                # at a double root slope and value are both round-off, and their quotient is anything
                step[:, (np.abs(F) <= EPS * self._evaluated(self._pieces, y, absolute=True)).all(axis=0)] = 0
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
