"""Contact problems given by their matrix, for tests of the compiled functions that solve them.

`DenseProblem` has rows r = A x + b with kinds (`contact_problem`). `ConeProblem` has contacts r = A λ + c, each at rest
or sliding, and equalities:

    normal          min(r_N, λ_N - low) = 0
    tangent         λ_T = P(λ_T - r_T),  P: the nearest point of |T| <= μ λ_N
    known slip d    λ_T = -μ d λ_N
    equality        r = 0
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from freebody.motion.cones import cone, newton
from freebody.motion.cones.collision import compiled_code
from freebody.motion.cones.contact_problem import (
    DEPENDENT,
    EQUALITY,
    FIRST,
    GOAL,
    LINE,
    NORMAL,
    SECOND,
    ContactProblem,
    Newton,
)  # fmt: skip
from freebody.motion.cones.contacts import Contacts, contacts_room
from freebody.native.loop import made

Array = NDArray[np.float64]

SMALL = 1e-12
"""Relative singular value of a Newton step that counts as zero."""
FALLS, SHORTEST = 1e-4, 1e-3
"""Least fall of |e| in a Newton step, relative to what the slope promises, and the shortest part of a step."""


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
        memory = Newton.made(most=max(m, 1), n=n, links=1)
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
    """A compiled function of `newton`, or of `cone`."""
    label, names = (
        "motion.cones.newton",
        ("factor", "solve", "violation", "violation_slopes", "set_scales", "project_all"),
    )
    return made(label, (label,), names, lambda: vars(cone) | vars(newton)).functions[name]


@dataclass(frozen=True)
class Touching:
    """One closed contact of the problem.

    ``held``       True if its normal force is 1 and its normal row is zero
    ``row``        its first row (normal), followed by its ``tangents`` rows (1 planar, 2 spatial, 0 frictionless)
    ``friction``   kinetic coefficient; ``static`` is the static coefficient
    ``sliding``    unit direction of slip, shape (tangents,), if it already slips; None at rest
    ``presser``    for resistance to rolling or spinning, whose normal row is zero: the contact before it that bounds it
    """

    name: str
    row: int
    tangents: int
    friction: float
    static: float
    sliding: NDArray[np.float64] | None = None
    held: bool = False
    presser: int = -1


def contacts_of(
    A: Any, c: Any, contacts: Sequence[Touching], low: Any = 0.0, equalities: Sequence[int] = (), impact: bool = False
) -> Contacts:  # fmt: skip
    """Return contacts in memory of their own.

    In an ``impact``, which does not depend on earlier sticking or sliding, every contact has the cone of its kinetic
    friction.
    """
    k, m = len(contacts), len(c)
    it = contacts_room(k, m)
    it.contacts, it.rows, it.equalities = k, m, len(equalities)
    if m:
        it.A[: m * m], it.given[:m], it.equal[: len(equalities)] = np.ravel(A), c, equalities
    if k:
        it.at[:], it.tangents[:] = [one.row for one in contacts], [one.tangents for one in contacts]
        it.friction[:] = [one.friction for one in contacts]
        it.static[:] = it.friction if impact else [one.static for one in contacts]
        it.least[:] = low
        if not impact:
            it.held[:] = [one.held for one in contacts]
            it.least[it.held == 1] = 1.0
        it.presser[:] = [one.presser for one in contacts]
        it.held[it.presser >= 0] = 1
    for i, one in enumerate(contacts):
        if one.sliding is not None and not impact:
            it.slides[i] = 1
            it.way[2 * i : 2 * i + one.tangents] = one.sliding
    return it


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
    def _dense(self) -> DenseProblem:
        """The problem of the unknowns x, λ = B x, r = A B x + c."""
        rows, columns, kinds, mu, low = self._rows
        part, H = self.A[rows], rows_of(self.A)
        lower = None if self.low is None else low
        return DenseProblem(
            part @ columns.T, self.c[rows], kinds, mu, lower, part[:, rows], (H[rows], columns @ H)
        )

    def residual(self, forces: Array) -> float:
        """Return the greatest violation of the laws as a rate, relative to the greatest |c_i| or A_ii low_i.

        |min(r_N, s (λ_N - low))|,    s |λ_T - P(λ_T - r_T/s)|,    |r| of an equality
        """
        rows, columns, *_ = self._rows
        x, dense = forces[rows], self._dense
        worst = dense.rated(x, (self.A @ forces + self.c)[rows])
        # friction off its ray, or where there is none
        off = float(np.abs(self.A.diagonal() * (forces - x @ columns)).max(initial=0))
        size = dense.memory.reference
        return max(worst, off / size) if size > 0 else worst

    def solve(self) -> ConeSolution:
        """Return the solution found from zero. It is one only if its residual is below :data:`contacts.EXACT`."""
        low = 0.0 if self.low is None else self.low
        it, m = contacts_of(self.A, self.c, self.contacts, low, self.equalities), len(self.c)
        compiled_code()["find"](it)
        return ConeSolution(it.forces[:m].copy(), it.after[:m].copy(), it.residual)
