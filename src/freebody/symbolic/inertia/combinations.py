"""Columns of the regressor that are combinations of columns before them, and the coefficients.

Which columns depend on which is found at random places, as many as there are columns, modulo a prime. The
coefficients are then solved for exactly, with the symbols of the machine. If joints move independently, what the
inertia of a body shares with that of others passes through its carrier: a column depends on a few columns of its body
and of the neighbours, whose own combinations are then put in. Otherwise, it is solved for in all columns before it.

Random places may show a column as dependent that is not, if they are roots of a polynomial. A prime of 61 binary digits
makes that less likely than a fault of the processor.

Axes that are rounded decimals are no rotation exactly, and exact numbers of such a machine would show combinations as
independent. It is reduced in floating point.

Sources: P. Wensing, G. Niemeyer, J.-J. Slotine, A geometric characterization of observability in inertial parameter
identification (2024); J. Schwartz, Fast probabilistic algorithms for verification of polynomial identities (1980);
E. Bareiss, Sylvester's identity and multistep integer-preserving Gaussian elimination (1968).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import Any

import numpy as np
import sympy
from flint import fmpz, nmod_mat

from ...dynamics.conditions.constrained import closed_coordinates
from ...dynamics.conditions.linearized import linearized
from ...dynamics.regressor import PARAMETERS, parameter_names, regressor
from ...dynamics.state import float_state
from ...errors import ModelError
from ...model.model import GROUND, Model
from ...scalar.algebra import IDENTITY, divide, dot, multiply, transpose
from ..derivation.canonical_model import CanonicalModel
from .random_place import NoRootError, Place, Placed

FIRST = 2**61
"""Primes are the next ones below."""
MOST_OPEN = 100
"""Most random configurations that do not close the loops of a machine."""
LONG = 10**9
"""Whole numbers beyond it come from rounded decimals."""
LEAST = math.sqrt(np.finfo(float).eps)
"""Fraction below which a number is round-off: half of its digits."""


def rounded_joint(canonical: CanonicalModel) -> str:
    """Return the first joint whose axes are rounded numbers, or "".

    They are a rotation or a unit vector, but not exactly, or have roots of numbers with more than nine digits.
    """
    state, ring = canonical.state, canonical.ring
    for link in canonical.model.links:
        E, n = state.matrix(link.rotation), state.vector(link.axis)
        if multiply(E, transpose(E)) != IDENTITY or link.one_dof and dot(n, n) != 1:
            return link.joint
        for x in (*n, *(x for row in E for x in row)):
            for g in ring.used(x) if hasattr(x, "ring") else ():
                if g.kind == "sqrt" and not g.depends and float(g.arguments[0]) > LONG:
                    return link.joint
    return ""


def combinations_in_floats(
    model: Model, values: Mapping[str, float] | None
) -> tuple[tuple[int, ...], dict[int, dict[int, Any]]]:
    """Return the independent columns and the coefficients of the others, from random states in floating point.

    Of a machine with constraints the forces are those on its independent speeds, Nᵀ Y, in states that fulfil them.

    A column is dependent if what the columns before it leave of it is less than the square root of round-off of the
    longest column of its kind: of masses, first moments or moments of inertia.

    Raises
    ------
    ModelError
        If no random configuration closes the loops.
    """
    rng = np.random.default_rng(0)
    rows: list[Any] = []
    count, failures = len(parameter_names(model)), 0
    while len(rows) < count + model.n_u:
        q = rng.normal(size=model.n_q)
        for i in model.quaternions:
            q[i : i + 4] /= np.linalg.norm(q[i : i + 4])
        t = rng.uniform()
        if model.constraints:
            try:
                q = np.array(closed_coordinates(model, [*q], t, values))
            except ModelError:
                failures += 1
                if failures > MOST_OPEN:
                    raise
                continue
        u, udot = rng.normal(size=(2, model.n_u))
        N = np.eye(model.n_u)
        if model.constraints:
            N, u, udot = _in_constraints(model, q, u, udot, t, values)
        state = float_state(model, [*q], [*u], t, values)
        rows += [*(N.T @ np.array([[*map(float, row)] for row in regressor(model, state, [*udot])]))]
    Y = np.array(rows)
    sizes = np.linalg.norm(Y, axis=0).reshape(-1, len(PARAMETERS))
    kinds = np.repeat(
        np.array([sizes[:, k].max() for k in (slice(1), slice(1, 4), slice(4, None))]), (1, 3, 6)
    )
    least = LEAST * np.tile(kinds, len(sizes))
    independent: list[int] = []
    basis = np.zeros((len(Y), 0))
    dependent = []
    for j, column in enumerate(Y.T):
        rest = column
        for _ in range(2):  # once more, since the first projection leaves round-off
            rest = rest - basis @ (basis.T @ rest)
        size = np.linalg.norm(rest)
        if size <= least[j]:
            dependent.append(j)
        else:
            independent.append(j)
            basis = np.column_stack([basis, rest / size])
    C = np.linalg.lstsq(Y[:, independent], Y[:, dependent], rcond=None)[0]
    return tuple(independent), {
        j: {k: sympy.Float(float(c)) for k, c in zip(independent, column, strict=True) if abs(c) > LEAST}
        for j, column in zip(dependent, C.T, strict=True)
    }


def _in_constraints(
    model: Model, q: Any, u: Any, udot: Any, t: float, values: Mapping[str, float] | None
) -> tuple[Any, Any, Any]:
    """Return the motions N that keep the constraints, G N = 0, and the nearest speeds and accelerations that do."""

    def conditions(u: Any) -> Any:
        return linearized(model, float_state(model, [*q], [*u], t, values))

    G = np.array(conditions(u).matrix, float).reshape(-1, model.n_u)
    u = u - np.linalg.lstsq(G, np.array(conditions(u).rate, float), rcond=LEAST)[0]
    gamma = np.array(conditions(u).bias, float)
    udot = udot - np.linalg.lstsq(G, G @ udot + gamma, rcond=LEAST)[0]
    _, s, Vt = np.linalg.svd(G)
    return Vt[(s > LEAST * s.max(initial=0)).sum() :].T, u, udot


class Columns:
    """Columns of the regressor at random places, and their combinations."""

    def __init__(self, canonical: CanonicalModel) -> None:
        self.canonical = canonical
        self.count = len(parameter_names(canonical.model))
        self.prime = FIRST
        self.machine: dict[int, Any] = {}
        rows = None
        while rows is None:
            rows = self._modulo(self._next_prime())
        self._modular = rows
        independent, supports = self._dependence(range(self.count))
        self.independent = dict.fromkeys(independent)
        self._rows: list[list[Any]] = []
        """Rows with symbols."""
        self._residues: dict[tuple[int, int], Any] = {}
        """Their entries modulo the prime."""
        self._place = Place(canonical, 0, self.prime, self.machine)
        self._seed = 0
        self.combinations: dict[int, dict[int, Any]] = {}
        self._combine(supports)

    def _next_prime(self) -> int:
        """Return the next prime of the form 4 n + 3."""
        self.prime -= 4 if self.prime % 4 == 3 else 1
        while not fmpz(self.prime).is_probable_prime():
            self.prime -= 4
        return self.prime

    def _modulo(self, prime: int) -> list[list[int]] | None:
        """Return as many rows modulo a prime as there are columns, or None if a constant has no root there."""
        rows: list[list[int]] = []
        self.machine, seed = {}, 0
        while len(rows) < self.count:
            seed += 1
            try:
                at = self._at(Place(self.canonical, seed, prime, self.machine))
            except NoRootError as missing:
                if missing.args[0]:
                    return None
                continue
            rows += [[*map(int, row)] for row in at]
        return rows

    def _at(self, place: Place) -> list[list[Any]]:
        """Return the rows of the regressor at a place."""
        model = self.canonical.model
        udot = [place(x) for x in self.canonical.udot]
        return [[*row] for row in regressor(model, Placed(self.canonical.state, place), udot)]

    def _dependence(self, columns: Sequence[int]) -> tuple[list[int], dict[int, list[int]]]:
        """Return those of the columns that are independent, and those of them of which each other one is made."""
        pivots, supports = self._reduced([[row[j] for j in columns] for row in self._modular])
        return [columns[i] for i in pivots], {
            columns[i]: [columns[k] for k in support] for i, support in supports.items()
        }

    def _reduced(self, rows: Sequence[Sequence[int]]) -> tuple[list[int], dict[int, list[int]]]:
        """Return the independent columns of a matrix, and those of them of which each other column is made."""
        flat = [x for row in rows for x in row]
        reduced, rank = nmod_mat(len(rows), len(rows[0]), flat, self.prime).rref()
        pivots: list[int] = []
        supports = {}
        for j in range(len(rows[0])):
            if len(pivots) < rank and reduced[len(pivots), j] != 0:
                pivots.append(j)
            else:
                supports[j] = [k for i, k in enumerate(pivots) if reduced[i, j] != 0]
        return pivots, supports

    def _combine(self, among_all: Mapping[int, list[int]]) -> None:
        """Find the combination of every dependent column, from columns near it, or from ``among_all`` before it."""
        carriers = carriers_of(self.canonical.model)
        size = len(PARAMETERS)
        for body, carrier in enumerate(carriers):
            near = {body, carrier, *(b for b, c in enumerate(carriers) if c == body)}
            columns = [size * b + k for b in sorted(near) if 0 <= b <= body for k in range(size)]
            _, among_near = self._dependence(columns)
            for j in range(size * body, size * (body + 1)):
                if j not in self.independent:
                    support = among_near.get(j, among_all[j])
                    self.combinations[j] = self._substituted(support, self._with_symbols(j, support))

    def _substituted(self, support: Sequence[int], values: Sequence[Any]) -> dict[int, Any]:
        """Return a combination of columns as one of independent columns."""
        total: dict[int, Any] = {}
        for k, c in zip(support, values, strict=True):
            parts = {k: 1} if k in self.independent else self.combinations[k]
            for i, d in parts.items():
                total[i] = total.get(i, 0) + c * d
        return {i: c for i, c in sorted(total.items()) if c != 0}

    def _with_symbols(self, j: int, support: list[int]) -> list[Any]:
        """Solve for the coefficients of column ``j``, in as many rows that are independent modulo the prime."""
        if not support:
            return []
        while True:
            rows = [i for i, row in enumerate(self._rows) if any(row[k] != 0 for k in support)]
            if len(rows) >= len(support):
                chosen, _ = self._reduced([[self._residue(i, k) for i in rows] for k in support])
                if len(chosen) == len(support):
                    break
            self._seed += 1
            # what depends on coordinates and has no inverse there is passed over
            with suppress(ZeroDivisionError):
                self._rows += self._at(Place(self.canonical, self._seed))
        return solved([[self._rows[rows[i]][k] for k in (*support, j)] for i in chosen])

    def _residue(self, i: int, k: int) -> int:
        if (i, k) not in self._residues:
            self._residues[i, k] = int(self._place(self._rows[i][k]))
        return self._residues[i, k]


def carriers_of(model: Model) -> list[int]:
    """Return the number of the body that carries each body, in the order of the bodies; -1 for the ground."""
    last: dict[int, int] = {GROUND: -1}
    """The body on each link, or else that of the link which carries it."""
    on_link = {place.link: number for number, place in enumerate(model.bodies.values())}
    for i, link in enumerate(model.links):
        last[i] = on_link.get(i, last[link.parent])
    return [
        on_link[place.link]
        if on_link.get(place.link, number) != number
        else last[model.links[place.link].parent]
        if place.link != GROUND
        else -1
        for number, place in enumerate(model.bodies.values())
    ]


def combinations_with_symbols(canonical: CanonicalModel) -> tuple[tuple[int, ...], dict[int, dict[int, Any]]]:
    """Return the independent columns and the coefficients of the others, with the machine's symbols."""
    columns = Columns(canonical)
    shown = {
        j: {k: canonical.displayed(c) for k, c in combination.items()}
        for j, combination in columns.combinations.items()
    }
    return tuple(columns.independent), shown


def solved(rows: list[list[Any]]) -> list[Any]:
    """Solve n equations with their right sides in the last column, by elimination without fractions (Bareiss 1968)."""
    n, before = len(rows), 1
    rows = [[*row] for row in rows]
    for k in range(n - 1):
        pivot = min((i for i in range(k, n) if rows[i][k] != 0), key=lambda i: _length(rows[i][k]))
        rows[k], rows[pivot] = rows[pivot], rows[k]
        for i in range(k + 1, n):
            for j in range(k + 1, n + 1):
                rows[i][j] = divide(rows[i][j] * rows[k][k] - rows[i][k] * rows[k][j], before)
            rows[i][k] = 0
        before = rows[k][k]
    values: list[Any] = [0] * n
    for i in reversed(range(n)):
        rest = rows[i][n]
        for j in range(i + 1, n):
            rest = rest - rows[i][j] * values[j]
        values[i] = divide(rest, rows[i][i])
    return values


def _length(x: Any) -> int:
    return len(x) if hasattr(x, "ring") else 0
