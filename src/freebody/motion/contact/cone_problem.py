"""The contact problem: forces, or impulses, in exact Coulomb cones, as one value with one residual.

λ are forces and r = A λ + c accelerations of the contacts; in an impact, impulses and speeds just after it.

    normal          min(r_N, λ_N - low) = 0
    tangent         λ_T = P(λ_T - r_T),  P: the nearest point of |T| <= μ λ_N
    known slip d    λ_T = -μ d λ_N
    equality        r = 0

A solution exists and is found for impacts and for small friction; its motion is unique if there is no friction. Where
several motions satisfy these laws, the result is the limit of equal compliance at all contacts, from zero (see
`cone_newton`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...native.loop import made, sibling
from .cone_newton import EQUALITY, FIRST, LINE, NORMAL, SECOND, room
from .cone_record import DEPENDENT, GOAL, Touching, compiled_code, cone

Array = NDArray[np.float64]

_MODULE = sibling(__name__, "cone_newton")


@dataclass(frozen=True)
class ConeSolution:
    """Forces λ and rates r, shape (m,), and the residual relative to the greatest rate."""

    forces: Array
    rates: Array
    residual: float


@dataclass(frozen=True, eq=False)
class ConeProblem:
    """A contact problem r = A λ + c.

    Attributes
    ----------
    A : array (m, m)
        Rates per unit force, symmetric and positive semidefinite.
    c : array (m,)
        Rates without contact forces.
    contacts : sequence of Touching
        A contact at rest has the cone of its static friction, a contact that slides the ray of its kinetic friction.
    low : array (contacts,), optional
        Normal force of each contact that acts in any case; 0 by default.
    equalities : sequence of int
        Rows of conditions r = 0 with forces of any sign, such as the multipliers of a closed loop.
    """

    A: Array
    c: Array
    contacts: Sequence[Touching]
    low: Array | None = None
    equalities: Sequence[int] = ()

    @cached_property
    def _rows(self) -> tuple[list[int], Array, list[int], list[float], list[float]]:
        """Rows, columns of λ = B x as rows, kinds, coefficients of friction and lower limits of the unknowns x."""
        rows, kinds = list(self.equalities), [EQUALITY] * len(self.equalities)
        unit = np.eye(len(self.c))
        columns, mu = list(unit[rows]), [0.0] * len(rows)
        low = list(mu)
        for i, contact in enumerate(self.contacts):
            at, n, d = contact.row, contact.tangents, contact.sliding
            column = unit[at].copy()
            if d is not None:
                column[at + 1 : at + 1 + n] = -contact.friction * d
            count = n if d is None and contact.static > 0 else 0
            rows += range(at, at + 1 + count)
            columns += [column, *unit[at + 1 : at + 1 + count]]
            kinds += [NORMAL, *([], [LINE], [FIRST, SECOND])[count]]
            mu += [0.0] + [contact.static] * count
            low += [0.0 if self.low is None else float(self.low[i])] + [0.0] * count
        return rows, np.array(columns).reshape(-1, len(self.c)), kinds, mu, low

    @cached_property
    def scales(self) -> Array:
        """Rate per unit force of each unknown: A_NN, and the trace of A_TT for friction."""
        rows, _, kinds, _, _ = self._rows
        result = np.abs(self.A.diagonal()[rows])
        for i, kind in enumerate(kinds):
            if kind == SECOND:
                result[i - 1 : i + 1] = result[i - 1] + result[i]
        return result

    def residual(self, forces: Array) -> float:
        """Return the greatest violation of the laws as a rate, relative to the greatest |c_i| or A_ii low_i.

        |min(r_N, s (λ_N - low))|,    s |λ_T - P(λ_T - r_T/s)|,    |r| of an equality
        """
        rows, columns, kinds, mu, low = self._rows
        x, s = forces[rows], self.scales
        r = (self.A @ forces + self.c)[rows]
        size = max(float(np.abs(self.c[rows]).max(initial=0)), float((s * np.abs(low)).max(initial=0)))
        worst = float(np.abs(s * (forces - x @ columns)[rows]).max(initial=0))  # friction off its ray
        for i, kind in enumerate(kinds):
            if kind == EQUALITY:
                worst = max(worst, abs(r[i]))
            elif kind == NORMAL:
                worst = max(worst, abs(min(r[i], s[i] * (x[i] - low[i]))))
            elif kind in (LINE, FIRST):
                T = slice(i, i + (1 if kind == LINE else 2))
                free, limit = s[T] * x[T] - r[T], s[i] * mu[i] * max(x[i - 1], 0.0)
                length = float(np.linalg.norm(free))
                near = free * (limit / length) if length > limit else free
                worst = max(worst, float(np.linalg.norm(s[T] * x[T] - near)))
        return worst / size if size > 0 else 0.0

    def solve(self) -> ConeSolution:
        """Return the solution found from zero. It is one only if its residual is below :data:`cone_record.EXACT`."""
        it = cone(self.A, self.c, self.contacts, 0.0 if self.low is None else self.low, self.equalities)
        compiled_code()["found"](it)
        return ConeSolution(it.forces.copy(), it.after.copy(), it.residual)


def rows_of(A: Array) -> Array:
    """Return H of A = H Hᵀ with as many columns as A has independent directions."""
    m = len(A)
    H = np.zeros((m, m))
    n = _code()["factor"](
        np.ascontiguousarray(A, dtype=float), m, H, DEPENDENT, np.zeros(m), np.zeros(m, dtype=np.int64)
    )
    return H[:, :n]


def from_zero(H: Array, C: Array, c: Array, laws: Any, scales: Array) -> tuple[Array, float, int]:
    """Return x of r = H Cᵀ x + c by `cone_newton`, its residual and the number of Newton steps.

    ``laws`` are the kind, the coefficient of friction and the lower limit of each row.
    """
    m, n = H.shape
    kinds, mu, low = laws
    problem = np.concatenate((H.ravel(), C.ravel(), c, mu, low, scales, np.zeros(m + room(m, n))))
    left = np.zeros(2)
    steps = _code()["solve"](problem, np.array(kinds, dtype=np.int64), m, n, GOAL, left)
    at = 2 * m * n + 4 * m
    return problem[at : at + m], float(left[0]), int(steps)


def eased(A: Array, b: Array, kinds: Any, mu: Array, goal: float) -> Array | None:
    """Return impulses that satisfy the conditions of `polished` to ``goal``, from zero; None if none are found."""
    if not (np.isfinite(A).all() and np.isfinite(b).all()):
        return None
    scales, none = np.abs(A.diagonal()), np.zeros(len(b))
    second = np.flatnonzero(np.asarray(kinds) == SECOND)
    scales[second] += scales[second - 1]
    scales[second - 1] = scales[second]
    H = rows_of(A)
    x = from_zero(H, H, b, (kinds, mu, none), scales)[0]
    if float(np.abs(_conditions(A, b, kinds, mu, x, none)[0]).max(initial=0)) <= goal:
        return x
    return polished(A, b, kinds, mu, x, goal)


def polished(
    A: Array, b: Array, kinds: Any, mu: Array, x: Array, goal: float, most: int = 60, least: Any = 0.0
) -> Array | None:
    """Return impulses near ``x`` that satisfy the conditions to ``goal``; None if none are found.

    ``kinds`` is defined in `cone_newton`. ``least`` gives, for each row, a normal impulse that acts in any
    case: max(least, x - r/s) then replaces max(0, x - r/s).
    """
    least = np.broadcast_to(least, len(x))
    error, slope = _conditions(A, b, kinds, mu, x, least)
    for _ in range(most):
        size = float(np.abs(error).max(initial=0))
        if size <= goal:
            return x
        step = np.linalg.lstsq(slope, -error, rcond=1e-12)[0]
        part, length = 1.0, float(np.linalg.norm(error))
        while True:
            other = x + part * step
            new, bent = _conditions(A, b, kinds, mu, other, least)
            if float(np.linalg.norm(new)) < (1 - 1e-4 * part) * length or part < 1e-3:
                break
            part /= 2
        x, error, slope = other, new, bent
    return x if float(np.abs(error).max(initial=0)) <= goal else None


def _conditions(A: Array, b: Array, kinds: Any, mu: Array, x: Array, least: Array) -> tuple[Array, Array]:
    """Return the residuals of the conditions, as speeds, and their slope."""
    r = A @ x + b
    error, slope = r.copy(), A.copy()
    one = np.eye(len(x))
    for a, kind in enumerate(kinds):
        d = A[a, a]
        if kind == 1:
            if d * (x[a] - least[a]) - r[a] <= 0:
                error[a], slope[a] = d * (x[a] - least[a]), d * one[a]
        elif kind == 2:
            limit, free = mu[a] * max(x[a - 1], 0.0), x[a] - r[a] / d
            if abs(free) > limit:
                sign = np.sign(free)
                error[a] = d * (x[a] - sign * limit)
                slope[a] = d * (one[a] - sign * mu[a] * (x[a - 1] > 0) * one[a - 1])
        elif kind == 3:
            two = slice(a, a + 2)
            s = max(d, A[a + 1, a + 1]) + abs(A[a, a + 1])
            free = x[two] - r[two] / s
            length, limit = float(np.linalg.norm(free)), mu[a] * max(x[a - 1], 0.0)
            if length > limit:
                e = free / length
                turn = limit / length * (np.eye(2) - np.outer(e, e))  # slope of the projection onto the disk
                error[two] = s * (x[two] - limit * e)
                slope[two] = s * (
                    one[two]
                    - mu[a] * (x[a - 1] > 0) * np.outer(e, one[a - 1])
                    - turn @ (one[two] - A[two] / s)
                )
    return error, slope


def _code() -> Any:
    return made(_MODULE, (_MODULE,), ("factor", "solve"), _functions).functions


def _functions() -> dict[str, Any]:
    from . import cone_newton

    return vars(cone_newton)
