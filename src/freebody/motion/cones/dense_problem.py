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
from .contact_problem import DEPENDENT, GOAL, ContactProblem, Newton

Array = NDArray[np.float64]

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
    factors : two arrays (m, n), optional
        H and C of A = H Cᵀ; by default H = C.
    """

    A: Array
    b: Array
    kinds: Sequence[int]
    mu: Sequence[float]
    low: Sequence[float] | None = None
    symmetric: Array | None = None
    factors: tuple[Array, Array] | None = None

    @classmethod
    def of(cls, problem: Any) -> DenseProblem:
        """Return the dense form of a problem that is given by the rows of its record."""
        blocks, count = problem.blocks, problem.count
        W, X = np.zeros((2, count, blocks.n))
        for a, r in enumerate(problem.rows[:count]):
            pieces = blocks.pieces[blocks.first[r] : blocks.first[r + 1]]
            columns = [i for b in pieces for i in range(blocks.starts[b], blocks.starts[b + 1])]
            values = slice(blocks.at[r], blocks.at[r + 1])
            W[a, columns], X[a, columns] = problem.W[values], problem.X[values]
        b, kinds, mu, low = (
            row[:count].copy() for row in (problem.b, problem.kinds, problem.mu, problem.low)
        )
        return cls(W @ X.T, b, kinds, mu, low)

    @cached_property
    def memory(self) -> Any:
        """The record of the problem, with room for as many directions as H has, or as there are rows."""
        m, n = len(self.b), len(self.b) if self.factors is None else self.factors[0].shape[1]
        result = ContactProblem.made(most=max(m, 1), n=n)
        result.count = m
        for name, numbers in (("kinds", self.kinds), ("mu", self.mu), ("low", self.low), ("b", self.b)):
            if numbers is not None:
                getattr(result, name)[:m] = numbers
        matrix, square = result.matrix, self.A if self.symmetric is None else self.symmetric
        for k in range(3):
            matrix[: max(m - k, 0), k] = square.diagonal(k)
        np.abs(matrix[:, 0], out=matrix[:, 0])
        code("set_scales")(result)
        result.reference = float(np.abs(self.b).max(initial=0))
        if self.low is not None:
            result.reference = max(result.reference, float((result.scale * np.abs(result.low)).max()))
        return result

    def rated(self, x: Array, rates: Array) -> float:
        """Return the greatest violation of the laws by impulses and rates, relative to the greatest |b| or s low."""
        m, memory = len(self.b), self.memory
        memory.x[:m], memory.r[:m] = x, rates
        return float(code("violation")(memory))

    def from_zero(self) -> tuple[Array, float, int]:
        """Return x by `newton`, its residual, and the number of Newton steps."""
        problem = self.memory
        H = rows_of(self.A) if self.factors is None else self.factors[0]
        m, n = H.shape
        problem.W = problem.X = np.ascontiguousarray(H)
        if self.factors is not None:
            problem.X = np.ascontiguousarray(self.factors[1])
        blocks, rows = problem.blocks, np.arange(m + 1, dtype=np.int64)
        blocks.n, blocks.count, blocks.starts = n, 1, np.array([0, n], dtype=np.int64)
        blocks.pieces, blocks.first, blocks.at = np.zeros(m + 1, dtype=np.int64), rows, n * rows
        problem.rows[:m] = rows[:m]
        memory = Newton.made(most=max(m, 1), n=n)
        steps = code("solve")(problem, memory, GOAL)
        return problem.x[:m].copy(), float(memory.residual), int(steps)

    def polished(self, x: Array, goal: float, most: int = 60) -> Array | None:
        """Return impulses near ``x`` that violate no law by more than the rate ``goal``; None if none are found."""
        error = self._violations(x)
        for _ in range(most):
            if float(np.abs(error).max(initial=0)) <= goal:
                return x
            slope = np.empty_like(self.A)
            code("violation_slopes")(self.memory, self.A, slope)
            step = np.linalg.lstsq(slope, -error, rcond=SMALL)[0]
            part, length = 1.0, float(np.linalg.norm(error))
            while True:
                other = x + part * step
                new = self._violations(other)
                if float(np.linalg.norm(new)) < (1 - FALLS * part) * length or part < SHORTEST:
                    break
                part /= 2
            x, error = other, new
        return x if float(np.abs(error).max(initial=0)) <= goal else None

    def solved(self, goal: float) -> Array | None:
        """Return impulses that violate no law by more than ``goal``, from zero; None if none are found."""
        if not (np.isfinite(self.A).all() and np.isfinite(self.b).all()):
            return None
        x = self.from_zero()[0]
        return x if float(np.abs(self._violations(x)).max(initial=0)) <= goal else self.polished(x, goal)

    def projected(self, x: Array) -> Array:
        """Return the impulses in the cones that are nearest to ``x``, each friction to its own normal impulse."""
        result = np.zeros(max(len(x), 1))
        code("project_all")(self.memory, np.ascontiguousarray(x), result)
        return result[: len(x)]

    def _violations(self, x: Array) -> Array:
        """Return the violations of the laws by x, as rates."""
        self.rated(x, self.A @ x + self.b)
        return np.array(self.memory.e[: len(x)])


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
    from . import cone, newton

    return vars(cone) | vars(newton)
