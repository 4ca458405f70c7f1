"""A contact problem of few rows, r = A x + b, with every entry of A, and Newton's method for it.

`newton` finds a solution from zero, in compiled code. `DenseProblem.polished` is the semismooth Newton method on the
laws themselves, e(x) = s x - P(s x - r) = 0 (`cone`): a step to round-off from a solution near by.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...native.loop import made, sibling
from ...native.records import Record
from .contact_problem import ContactProblem, Newton

Array = NDArray[np.float64]

GOAL = 1e-15
"""Relative residual at which the search ends; without progress it also ends at `newton.ENOUGH`."""
DEPENDENT = 1e-13
"""Part of a row's diagonal below which the row depends on the others."""
SMALL = 1e-12
"""Relative singular value of a Newton step that counts as zero."""
FALLS, SHORTEST = 1e-4, 1e-3
"""Least fall of |e| in a Newton step, relative to what the slope promises, and the shortest part of a step."""
_MODULE = sibling(__name__, "newton")
_CODE = ("factor", "solve", "violation", "violation_slopes", "set_scales", "project_all")


@dataclass(frozen=True, eq=False)
class DenseProblem:
    """A contact problem r = A x + b.

    Attributes
    ----------
    A : array (m, m)
        Rates per unit impulse.
    b : array (m,)
        Rates without impulses.
    kinds, mu, low : sequences of m numbers
        Kind, coefficient of friction and lower limit of each row (`contact_problem`).
    symmetric : array (m, m), optional
        Matrix whose diagonal blocks give the scales; A by default, which may have no positive diagonal for slip.
    """

    A: Array
    b: Array
    kinds: Sequence[int]
    mu: Sequence[float]
    low: Sequence[float] | None = None
    symmetric: Array | None = None

    @cached_property
    def memory(self) -> Any:
        """The record of the problem."""
        m = len(self.b)
        result = ContactProblem.made(most=max(m, 1), n=0)
        result.count = m
        for name, numbers in (("kinds", self.kinds), ("mu", self.mu), ("low", self.low), ("b", self.b)):
            if numbers is not None:
                getattr(result, name)[:m] = numbers
        matrix = self.A if self.symmetric is None else self.symmetric
        for k in range(3):
            result.matrix[: max(m - k, 0), k] = matrix.diagonal(k)
        result.matrix[:, 0] = np.abs(result.matrix[:, 0])
        code("set_scales")(result)
        least = (result.scale * np.abs(result.low)).max()
        result.reference = max(float(np.abs(self.b).max(initial=0)), float(least))
        return result

    def rated(self, x: Array, rates: Array) -> float:
        """Return the greatest violation of the laws by impulses and rates, relative to the greatest |b_i| or s low_i."""
        m, memory = len(self.b), self.memory
        memory.x[:m], memory.r[:m] = x, rates
        return float(code("violation")(memory))

    def from_zero(self, H: Array | None = None, C: Array | None = None) -> tuple[Array, float, int]:
        """Return x by `newton`, its residual, and the number of Newton steps. A = H Cᵀ; by default H = C."""
        H = rows_of(self.A) if H is None else H
        C = H if C is None else C
        m, n = H.shape
        problem = _with_rows(self.memory, H, C)
        memory = Newton.made(most=max(m, 1), n=n)
        steps = code("solve")(problem, memory, GOAL)
        return problem.x[:m].copy(), float(memory.residual), int(steps)

    def polished(self, x: Array, goal: float, most: int = 60) -> Array | None:
        """Return impulses near ``x`` that violate no law by more than the rate ``goal``; None if none are found."""
        error, slope = self._laws(x)
        for _ in range(most):
            if float(np.abs(error).max(initial=0)) <= goal:
                return x
            step = np.linalg.lstsq(slope, -error, rcond=SMALL)[0]
            part, length = 1.0, float(np.linalg.norm(error))
            while True:
                other = x + part * step
                new, bent = self._laws(other)
                if float(np.linalg.norm(new)) < (1 - FALLS * part) * length or part < SHORTEST:
                    break
                part /= 2
            x, error, slope = other, new, bent
        return x if float(np.abs(error).max(initial=0)) <= goal else None

    def eased(self, goal: float) -> Array | None:
        """Return impulses that violate no law by more than ``goal``, from zero; None if none are found."""
        if not (np.isfinite(self.A).all() and np.isfinite(self.b).all()):
            return None
        x = self.from_zero()[0]
        if float(np.abs(self._laws(x)[0]).max(initial=0)) <= goal:
            return x
        return self.polished(x, goal)

    def projected(self, x: Array) -> Array:
        """Return the impulses in the cones that are nearest to ``x``, each friction to its own normal impulse."""
        m = len(self.b)
        result = np.zeros(max(m, 1))
        code("project_all")(self.memory, np.ascontiguousarray(x), result)
        return result[:m]

    def _laws(self, x: Array) -> tuple[Array, Array]:
        """Return the violations of the laws by x, as rates, and their slope."""
        m, slope = len(self.b), np.empty_like(self.A)
        self.rated(x, self.A @ x + self.b)
        code("violation_slopes")(self.memory, self.A, slope)
        return self.memory.e[:m].copy(), slope


def _with_rows(problem: Any, H: Array, C: Array) -> Any:
    """Return a copy of a problem with the rows of H and C in one block."""
    m, n = H.shape
    result = ContactProblem.made(most=max(m, 1), n=n)
    for name in ("kinds", "mu", "low", "scale", "b"):
        getattr(result, name)[:] = getattr(problem, name)
    result.count, result.reference = m, problem.reference
    result.W, result.X = np.ascontiguousarray(H), np.ascontiguousarray(C)
    result.rows[:m] = np.arange(m)
    blocks = result.blocks
    blocks.count, blocks.starts = 1, np.array([0, n], dtype=np.int64)
    blocks.pieces, blocks.first = np.zeros(max(m, 1), dtype=np.int64), np.arange(m + 1, dtype=np.int64)
    blocks.at = n * blocks.first
    return result


def rows_of(A: Array) -> Array:
    """Return H of A = H Hᵀ with as many columns as A has independent directions."""
    m = len(A)
    H = np.zeros((m, m))
    n = code("factor")(
        np.ascontiguousarray(A, dtype=float), m, H, DEPENDENT, np.zeros(m), np.zeros(m, dtype=np.int64)
    )
    return H[:, :n]


def code(name: str) -> Any:
    """Return a compiled function of `newton`, or of `cone`."""
    return made(_MODULE, (_MODULE,), _CODE, _functions).functions[name]


def _functions() -> dict[str, Any]:
    from . import newton

    return vars(newton)
