"""Branches of steady motions along a parameter, by pseudo-arclength continuation, with folds and bifurcations.

On a branch F(x, p) = 0 with unit tangent t, dp/ds changes sign at a fold, and the determinant of (∂F/∂(x, p); t)
changes sign at a bifurcation.

Source: E. L. Allgower, K. Georg, Introduction to Numerical Continuation Methods (2003), chapters 2, 6 and 8.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...errors import ModelError
from ..printing.lines import Lines, assignments
from .conditions import EPS, Conditions


@dataclass(frozen=True)
class Special(Lines):
    """A fold or a bifurcation, with its parameter and unknowns."""

    kind: str
    parameter: float
    values: dict[str, float]

    def _lines(self) -> list[list[Any]]:
        return [[f"{self.kind} at ", self.parameter, ": ", *assignments(self.values.items())]]


@dataclass(frozen=True)
class Branch(Lines):
    """Steady motions along a parameter.

    Attributes
    ----------
    parameter : str
    parameters : ndarray, shape (n,)
    values : dict of ndarray, shape (n,)
        Unknowns by name.
    stable : tuple of str
        The verdict at each point.
    special : tuple of Special
        Folds (the branch turns back) and bifurcations (another branch crosses), located.
    """

    parameter: str
    parameters: np.ndarray
    values: dict[str, np.ndarray]
    stable: tuple[str, ...]
    special: tuple[Special, ...]

    @property
    def folds(self) -> tuple[Special, ...]:
        """Points where the branch turns back in the parameter."""
        return tuple(point for point in self.special if point.kind == "fold")

    @property
    def bifurcations(self) -> tuple[Special, ...]:
        """Points where another branch crosses."""
        return tuple(point for point in self.special if point.kind == "bifurcation")

    def _lines(self) -> list[list[Any]]:
        """Return its ends and the points where the verdict changes, then its folds and bifurcations."""
        shown = [0, *(k for k in range(1, len(self.stable)) if self.stable[k] != self.stable[k - 1])]
        if len(self.stable) - 1 not in shown:
            shown.append(len(self.stable) - 1)
        lines: list[list[Any]] = [[f"Steady motions over {self.parameter}, {len(self.parameters)} points"]]
        for k in shown:
            at = ((name, float(x[k])) for name, x in self.values.items())
            values = assignments([(self.parameter, float(self.parameters[k])), *at])
            lines.append([*values, f"  {self.stable[k]}"])
        return [*lines, *(line for point in self.special for line in point._lines())]

    def __repr__(self) -> str:
        a, b = self.parameters[0], self.parameters[-1]
        marks = "".join(f", {point.kind} at {point.parameter:.6g}" for point in self.special)
        return f"Branch over {self.parameter} from {a:.6g} to {b:.6g}, {len(self.parameters)} points{marks}"


def follow(
    conditions: Conditions, start: np.ndarray, span: tuple[float, float], direction: int, points: int = 400
) -> tuple[np.ndarray, list[tuple[str, np.ndarray]]]:
    """Return the points z = (unknowns, parameter) of the branch through ``start``, and its folds and bifurcations.

    The last unknown of ``conditions`` is the parameter. Its unit of length is the range; angles have the unit 1, and
    other unknowns are divided by their size.
    """
    curve = _Curve(conditions, start, span)
    h = largest = 1 / np.float64(50)
    z = start
    t = curve.tangent(z, np.append(np.zeros(len(start) - 1), direction))
    path = [z]
    special: list[tuple[str, np.ndarray]] = []
    while len(path) < points:
        new = curve.corrected(z + h * t * curve.scale, t)
        if new is None or np.linalg.norm((new - z) / curve.scale) > 2 * h:
            h = h / 2
            if h < np.sqrt(EPS):
                break
            continue
        after = curve.tangent(new, t)
        if t @ after < 1 - 1 / np.float64(50) and h > largest / 64:
            h = h / 2
            continue
        for kind, test in (("fold", curve.parameter_rate), ("bifurcation", curve.determinant)):
            if test(z, t) * test(new, after) < 0:
                special.append((kind, curve.zero_of(test, z, t, h)))
        z, t = new, curve.rescaled(new, after)
        if not min(span) <= z[-1] <= max(span):
            end = _clipped(conditions, path[-1], z, span)
            if end is not None:
                path.append(end)
            break
        path.append(z)
        h = min(2 * h, largest)
    return np.array(path), _without_crossed_folds(special, curve.scale)


class _Curve:
    """The curve F(z) = 0, with units of the unknowns in which its arclength is measured."""

    def __init__(self, conditions: Conditions, z: np.ndarray, span: tuple[float, float]) -> None:
        self.conditions = conditions
        self._fixed = np.append(conditions.angles[:-1], True)
        self._unit = np.append(np.ones(len(z) - 1), abs(span[1] - span[0]))
        self.scale = self._units_at(z)

    def _units_at(self, z: np.ndarray) -> np.ndarray:
        return np.where(self._fixed, self._unit, np.maximum(1, np.abs(z)))

    def _jacobian(self, z: np.ndarray) -> np.ndarray:
        return self.conditions.jacobian(z) * self.scale

    def rescaled(self, z: np.ndarray, t: np.ndarray) -> np.ndarray:
        """Adapt the units to z, and return the unit tangent t in the new units."""
        before, self.scale = self.scale, self._units_at(z)
        t = t * before / self.scale
        return t / np.linalg.norm(t)

    def tangent(self, z: np.ndarray, before: np.ndarray) -> np.ndarray:
        """Return the unit tangent at z whose angle with the direction ``before`` is not obtuse."""
        t = np.linalg.svd(self._jacobian(z))[2][-1]
        return -t if t @ before < 0 else t

    def parameter_rate(self, z: np.ndarray, t: np.ndarray) -> float:
        """Return dp/ds, whose sign changes at a fold."""
        return float(t[-1])

    def determinant(self, z: np.ndarray, t: np.ndarray) -> float:
        """Return the determinant of (∂F/∂z; t), whose sign changes at a bifurcation."""
        return float(np.linalg.det(np.vstack([_unit_rows(self._jacobian(z)), t])))

    def corrected(self, guess: np.ndarray, t: np.ndarray) -> np.ndarray | None:
        """Return the point of the curve in the plane through a guess normal to t; None if Newton's method fails."""
        z = guess.copy()
        for _ in range(12):
            A = np.vstack([self._jacobian(z), t])
            right = np.append(self.conditions.values(z), t @ ((z - guess) / self.scale))
            try:
                step = np.linalg.solve(A, right)
            except np.linalg.LinAlgError:
                return None
            z = z - step * self.scale
            if not np.isfinite(z).all():
                return None
            if np.abs(step).max() <= 64 * EPS * (1 + np.abs(z / self.scale).max()):
                return z
        return z if np.abs(step).max() <= np.sqrt(EPS) else None

    def zero_of(
        self, test: Callable[[np.ndarray, np.ndarray], float], z: np.ndarray, t: np.ndarray, h: float
    ) -> np.ndarray:
        """Return the point within the step h from z at which ``test`` changes sign, by bisection on the arclength."""
        low, high = 0 * h, h
        at_low = test(z, t)
        best = z
        for _ in range(50):
            mid = (low + high) / 2
            point = self.corrected(z + mid * t * self.scale, t)
            if point is None:
                break
            best = point
            if test(point, self.tangent(point, t)) * at_low > 0:
                low = mid
            else:
                high = mid
        return best


def _without_crossed_folds(
    special: list[tuple[str, np.ndarray]], scale: np.ndarray
) -> list[tuple[str, np.ndarray]]:
    """Remove folds at points where another branch crosses: these are bifurcations (pitchforks)."""
    crossed = [z for kind, z in special if kind == "bifurcation"]
    return [
        (kind, z)
        for kind, z in special
        if kind != "fold" or not any(np.linalg.norm((z - c) / scale) < np.cbrt(EPS) for c in crossed)
    ]


def _unit_rows(A: np.ndarray) -> np.ndarray:
    return A / np.maximum(np.linalg.norm(A, axis=1, keepdims=True), EPS * EPS)


def _clipped(
    conditions: Conditions, a: np.ndarray, b: np.ndarray, span: tuple[float, float]
) -> np.ndarray | None:
    """Return the point of the branch at the end of the range, between a and b."""
    end = min(span) if b[-1] < min(span) else max(span)
    if b[-1] == a[-1]:
        return None
    z = a + (b - a) * (end - a[-1]) / (b[-1] - a[-1])
    for _ in range(12):
        step = np.linalg.pinv(conditions.jacobian(z)[:, :-1]) @ conditions.values(z)
        z[:-1] = z[:-1] - step
    return z if np.isfinite(z).all() else None


def check_span(span: Any) -> tuple[float, float]:
    """Return a range as two different finite numbers; raise if it is none."""
    try:
        a, b = (float(x) for x in span)
    except (TypeError, ValueError):
        raise ModelError(
            f"Expected a range of two numbers to continue over, such as (1, 5), got {span!r}."
        ) from None
    if not np.isfinite([a, b]).all() or a == b:
        raise ModelError(f"Expected a range of two different finite numbers to continue over, got {span!r}.")
    return a, b
