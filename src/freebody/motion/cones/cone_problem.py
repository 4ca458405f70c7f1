"""The contact problem of a set of contacts, each at rest or sliding: forces, or impulses, in exact Coulomb cones.

λ are forces and r = A λ + c accelerations of the contacts; in an impact, impulses and speeds just after it.

    normal          min(r_N, λ_N - low) = 0
    tangent         λ_T = P(λ_T - r_T),  P: the nearest point of |T| <= μ λ_N
    known slip d    λ_T = -μ d λ_N
    equality        r = 0

Its unknowns x, λ = B x, are those of a `DenseProblem`. A solution exists and is found for impacts and for small
friction; its motion is unique if there is no friction. Where several motions satisfy these laws, the result is the
limit of equal compliance at all contacts, from zero (see `newton`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .collision import compiled_code
from .contact_problem import EQUALITY, FIRST, LINE, NORMAL, SECOND
from .contacts import Touching, contacts_of
from .dense_problem import Array, DenseProblem, rows_of


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
