"""The contact problem of few contacts, solved by trying every combination of modes: the tests' own answer.

λ are the contact forces and r = A λ + c the rates of the contacts (accelerations; in an impact, speeds just after it):

    open      λ_N = λ_T = 0                               r_N >= 0
    stick     r_N = 0, r_T = 0                            λ_N >= 0, |λ_T| <= μ_s λ_N
    slip d    r_N = 0, λ_T = -μ d λ_N, r_T = α d          λ_N >= 0, α >= 0     (d known if it already slips)

Every combination is a system of linear equations (in 3-D the direction d is also unknown and is found by Newton's
method). A solution is therefore exact to round-off, and its residual is returned. Because all combinations are tried,
the cases of no solution and of several solutions with different motions (Painlevé) are recognized.

Sources: C. Glocker, F. Pfeiffer, Multibody Dynamics with Unilateral Contacts (1996), chapters 5-8;
F. Génot, B. Brogliato, New results on Painlevé paradoxes (1999).
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cone_problems import ConeProblem, Touching

Array = NDArray[np.float64]

OPEN, STICK, SLIP = "open", "stick", "slip"
SMALL = 1e-10
"""Relative size below which a force or rate is zero and a matrix singular: above the round-off of small systems."""


@dataclass(frozen=True)
class Solution:
    """One consistent set of modes.

    ``modes``      (mode, direction of slip or None) of each contact
    ``forces``     λ, shape (m,); ``rates`` are r, shape (m,)
    ``residual``   greatest violation of the laws above, relative to the greatest force and rate
    ``ties``       (contact, law) pairs whose inequality holds with equality, so that derivatives must decide
    ``missed``     greatest violation of the inequalities alone
    ``rank_lack``  number of forces that the motion does not determine; N is then least in norm, T in Σ |T|²/N
    """

    modes: tuple[tuple[str, Any], ...]
    forces: Array
    rates: Array
    residual: float
    ties: tuple[tuple[int, str], ...]
    rank_lack: int = 0
    missed: float = 0.0


def solutions(A: Array, c: Array, contacts: Sequence[Touching]) -> list[Solution]:
    """All consistent sets of modes of A λ + c, λ the forces."""
    return [
        one
        for modes in itertools.product(*map(_choices, contacts))
        if all(
            (modes[k.presser][0] == OPEN) == (mode == OPEN)
            for k, (mode, _) in zip(contacts, modes, strict=True)
            if k.presser >= 0
        )
        for one in _solved(A, c, contacts, modes)
        if one.residual <= SMALL
    ]


def _choices(contact: Touching) -> list[tuple[str, Any]]:
    """Return the modes of a contact; one whose normal force is given is not open."""
    result = _modes(contact)
    return result[1:] if contact.held else result


def _modes(contact: Touching) -> list[tuple[str, Any]]:
    if contact.tangents == 0 or contact.friction == contact.static == 0:
        return [(OPEN, None), (SLIP, np.zeros(contact.tangents))]
    if contact.sliding is not None:
        return [(OPEN, None), (SLIP, contact.sliding)]
    if contact.tangents == 1:
        return [(OPEN, None), (STICK, None), (SLIP, np.array([1.0])), (SLIP, np.array([-1.0]))]
    return [(OPEN, None), (STICK, None), (SLIP, None)]


def _solved(
    A: Array,
    c: Array,
    contacts: Sequence[Touching],
    modes: Sequence[tuple[str, Any]],
) -> Iterator[Solution]:
    """Yield the solutions of one combination: at most one, or several if slip directions are unknown.

    The search for directions starts from several directions.
    """
    sought = [i for i, (mode, d) in enumerate(modes) if mode == SLIP and d is None]
    if not sought:
        one = _linear(A, c, contacts, modes)
        if one is not None:
            yield one
        return
    starts = np.array(list(_starts(A, c, contacts, modes, sought)))
    columns, rows = unknowns(len(c), contacts, modes)
    looked = [Sought(contacts[i].row, contacts[i].friction) for i in sought]
    found: Any = directions(A, c, np.zeros(len(c)), columns, rows, looked, starts)
    if found is None:
        found = _chosen_directions(A, c, contacts, modes, sought, starts)
    for angles in found:
        one = _linear(A, c, contacts, _turned(modes, sought, angles))
        if one is not None:
            yield one


def _along(A: Array, c: Array, contacts: Sequence[Touching], sought: Sequence[int], forces: Array) -> Array:
    """Return the angles of the slips under these forces; for a contact without slip, opposite to its friction."""
    rates = A @ forces + c
    slow = 1e-6 * float(np.abs(rates).max(initial=0))
    found = []
    for i in sought:
        tangent = slice(contacts[i].row + 1, contacts[i].row + 3)
        v = rates[tangent] if np.linalg.norm(rates[tangent]) > slow else -forces[tangent]
        found.append(np.arctan2(v[1], v[0]))
    return np.array(found)


def _turned(modes: Any, sought: Sequence[int], angles: Array) -> list[tuple[str, Any]]:
    result = list(modes)
    for i, angle in zip(sought, angles, strict=True):
        result[i] = (SLIP, np.array([np.cos(angle), np.sin(angle)]))
    return result


def _starts(A: Array, c: Array, contacts: Any, modes: Any, sought: Sequence[int]) -> Iterator[Array]:
    """Yield angles to start the search from: those of the forces of equal compliance, then evenly spaced ones.

    The latter begin opposite to the sticking force.
    """
    if len(sought) > 1:
        yield _along(A, c, contacts, sought, ConeProblem(A, c, contacts).solve().forces)
    held = [(STICK, None) if i in sought else mode for i, mode in enumerate(modes)]
    one = _linear(A, c, contacts, held)
    first = []
    for i in sought:
        at = contacts[i].row + 1
        T = c[at : at + 2] if one is None else -one.forces[at : at + 2]
        first.append(np.arctan2(T[1], T[0]))
    turns = {1: 8, 2: 6}.get(len(sought), 1)
    for shifts in itertools.product(range(turns), repeat=len(sought)):
        yield np.array(first) + 2 * np.pi * np.array(shifts) / turns


def _chosen_directions(
    A: Array, c: Array, contacts: Any, modes: Any, sought: Sequence[int], starts: Array
) -> Iterator[Array]:
    """Yield slip directions if the forces are indeterminate, by Newton's method with the choice of :func:`balanced`."""

    def across(a: Array) -> Array | None:
        one = _linear(A, c, contacts, _turned(modes, sought, a))
        if one is None:
            return None
        return np.array(
            [
                one.rates[contacts[i].row + 2] * np.cos(x) - one.rates[contacts[i].row + 1] * np.sin(x)
                for i, x in zip(sought, a, strict=True)
            ]
        )

    seen: list[Array] = []
    for start in starts:
        angles = newton(across, start, 40 if len(starts) > 1 else 12)
        if angles is None or any(np.abs(np.exp(1j * angles) - np.exp(1j * a)).max() < 1e-7 for a in seen):
            continue
        seen.append(angles)
        yield angles


def unknowns(
    m: int, contacts: Sequence[Touching], modes: Sequence[tuple[str, Any]]
) -> tuple[list[Array], list[int]]:
    """Return the columns of B in λ = B x and the rows of r that vanish; a slip of unknown direction has no column.

    A contact whose normal force is given has no column and no row of its normal.
    """
    columns, rows = [], []
    unit = np.eye(m)
    for contact, (mode, d) in zip(contacts, modes, strict=True):
        if mode == OPEN:
            continue
        at, n = contact.row, contact.tangents
        bounded = contact.presser >= 0
        if not contact.held and not bounded:
            rows.append(at)
            normal = len(columns)
        if mode == STICK:
            columns += [unit[r].copy() for r in range(at + (contact.held or bounded), at + 1 + n)]
            rows += range(at + 1, at + 1 + n)
        elif d is not None and not contact.held:
            if not bounded:
                columns.append(unit[at].copy())
            columns[normal][at + 1 : at + 1 + n] = -contact.friction * d
    return columns, rows


def _linear(
    A: Array, c: Array, contacts: Sequence[Touching], modes: Sequence[tuple[str, Any]]
) -> Solution | None:
    """Return forces and rates of one combination; None if its equations have no solution."""
    columns, rows = unknowns(len(c), contacts, modes)
    forces, lack = given_forces(len(c), contacts, modes), 0
    if rows:
        found = balanced(A, c, contacts, np.array(columns).T, rows, forces)
        if found is None:
            return None
        forces, lack = found
    rates = A @ forces + c
    return _judged(A, c, contacts, tuple(modes), forces, rates, rows, lack)


def given_forces(m: int, contacts: Sequence[Touching], modes: Sequence[tuple[str, Any]]) -> Array:
    """Return the forces of contacts whose normal force is given: 1, and in slip -μ d along the tangents."""
    result = np.zeros(m)
    for contact, (mode, d) in zip(contacts, modes, strict=True):
        if contact.held:
            result[contact.row] = 1.0
            if mode == SLIP and d is not None:
                result[contact.row + 1 : contact.row + 1 + contact.tangents] = -contact.friction * d
    return result


def balanced(
    A: Array, c: Array, contacts: Sequence[Touching], B: Array, rows: list[int], base: Array
) -> tuple[Array, int] | None:
    """Return forces base + B x for which the ``rows`` of the rates vanish, and the number of indeterminate forces.

    If forces are indeterminate, those of contacts of equal compliance are chosen, x = A_rows ν. Where the motion does
    not depend on them, N is then least in norm, and T has the least Σ |T|²/N.
    """
    size = np.sqrt(np.abs(A.diagonal()[rows]))
    if not (size > 0).all():
        return None
    goal = -(c + A @ base)[rows]
    S = A[rows] @ B
    scaled, lack = S / size[:, None], 0
    # greatest entry of each column: large for slip with a large friction coefficient
    size_x = np.abs(scaled).max(axis=0, initial=SMALL)
    scaled /= size_x
    if abs(np.linalg.det(scaled)) > 1e-3:  # entries are about 1: far from singular
        x = np.linalg.solve(scaled, goal / size)
    else:
        x, _, rank, _ = np.linalg.lstsq(scaled, goal / size, rcond=SMALL)
        lack = len(rows) - int(rank)
    square = A[np.ix_(rows, rows)]
    if lack and not np.array_equal(
        S, square
    ):  # friction of slip: N of equal compliance, the range of the rows
        x = square @ (np.linalg.pinv(S @ square, rcond=SMALL) @ goal)
    elif lack:
        x = np.linalg.pinv(S, rcond=SMALL) @ goal
        weights = np.ones(len(rows))
        for contact in contacts:
            at = [j for j, row in enumerate(rows) if contact.row < row <= contact.row + contact.tangents]
            if at:
                weights[at] = max(float((base + B @ x)[contact.row]), 0.0)
        if (weights > 0).all():
            root = np.sqrt(weights)
            x = root * (np.linalg.pinv(S * root, rcond=SMALL) @ goal)
    else:
        x = x / size_x
        x = x - np.linalg.solve(scaled, (S @ x - goal) / size) / size_x
    return base + B @ x, lack


def _judged(
    A: Array, c: Array, contacts: Any, modes: Any, forces: Array, rates: Array, rows: Any, lack: int
) -> Solution:
    most_force = max(float(np.abs(forces).max(initial=0)), float(_typical(A, c)))
    most_rate = max(float(np.abs(c).max(initial=0)), float((np.abs(A) @ np.abs(forces)).max(initial=0)))
    f, r = 1 / most_force if most_force > 0 else 1.0, 1 / most_rate if most_rate > 0 else 1.0
    slack: list[tuple[int, str, float]] = []
    worst = float(np.abs(rates[rows]).max(initial=0)) * r if rows else 0.0
    for i, (contact, (mode, d)) in enumerate(zip(contacts, modes, strict=True)):
        at, n = contact.row, contact.tangents
        if mode == OPEN:
            slack.append((i, "open", rates[at] * r))
            continue
        presses = at if contact.presser < 0 else contacts[contact.presser].row
        if not contact.held and contact.presser < 0:
            slack.append((i, "normal", forces[at] * f))
        if mode == STICK:
            T = float(np.linalg.norm(forces[at + 1 : at + 1 + n]))
            slack.append((i, "cone", (contact.static * forces[presses] - T) * f))
        elif n and contact.sliding is None and contact.friction > 0:
            slack.append((i, "onset", float(d @ rates[at + 1 : at + 1 + n]) * r))
    missed = max((-value for _, _, value in slack), default=0.0)
    ties = tuple((i, law) for i, law, value in slack if value <= SMALL)
    return Solution(modes, forces, rates, max(worst, missed), ties, lack, missed)


def _typical(A: Array, c: Array) -> float:
    """Return a typical force: the greatest of the forces that would each cancel one rate alone."""
    diagonal = np.abs(A.diagonal())
    one = diagonal > 0
    return float((np.abs(c[one]) / diagonal[one]).max(initial=0))


def distinct(
    found: Sequence[Solution], responses: Array, size: float = 0.0, alike: float = 1e-8
) -> list[list[Solution]]:
    """Return the solutions grouped by the motion that they give.

    Parameters
    ----------
    responses : array (m, n_u)
        Accelerations (speeds) of the machine per unit force (impulse).
    size : float
        Size of the motions to which ``alike`` refers, if greater than that of the solutions themselves.
    alike : float
        Relative difference up to which two motions count as the same.
    """
    groups: list[tuple[Array, list[Solution]]] = []
    moved = [one.forces @ responses for one in found]
    size = max([size, *(float(np.abs(x).max(initial=0)) for x in moved)])
    for x, one in zip(moved, found, strict=True):
        for y, group in groups:
            if np.abs(x - y).max(initial=0) <= alike * size:
                group.append(one)
                break
        else:
            groups.append((x, [one]))
    return [group for _, group in groups]


# -- directions in which slips in space begin ------------------------------------------------------------
#
# They are along the tangential acceleration (in an impact, speed), r_T × d = 0.
#
#    λ = base + B x + Σ N_i e(d_i),    e(d) = n - μ d,    r = A λ + c,    r = 0 on the held rows
#
# The held rows determine x and the normal forces N of held contacts. For a single direction d = (cos a, sin a),
# Cramer's rule makes det S · (r_T × d) a trigonometric polynomial of degree 2 in a. Its roots are those of a polynomial
# of degree 4, so all directions are found. For several directions, Newton's method runs from many starts at once.

SINGULAR = 1e10
"""Condition number above which the held rows count as dependent: they then leave the forces indeterminate."""

STEPS = 40
"""Limit on Newton steps. Each halves the distance to a double root: 24 from 0.5 to round-off of r_T × d."""


@dataclass(frozen=True)
class Sought:
    """A contact whose slip direction is unknown: its row, its friction, and its normal force if that is known."""

    row: int
    friction: float
    given: float | None = None


def directions(
    A: Array,
    c: Array,
    base: Array,
    columns: Sequence[Array],
    rows: Sequence[int],
    sought: Sequence[Sought],
    starts: Array,
) -> list[Array] | None:
    """Return the angles of the directions, one array per solution; None if the held rows are dependent.

    Parameters
    ----------
    base, columns   known forces and the columns of the unknown forces, without the contacts in ``sought``
    rows            rows of r that vanish, including those of held contacts in ``sought``
    starts          initial angles of the search, shape (n, len(sought)); unused for a single direction
    """
    problem = _Problem(A, c, base, columns, list(rows), sought)
    if len(sought) == 1:
        starts = 2 * np.pi * np.arange(5)[:, None] / 5
    S = problem.matrix(starts)[1]
    if S.size and not np.linalg.cond(S).min() < SINGULAR:
        return None
    try:
        if len(sought) == 1:
            value = problem.across(starts)[0]
            h = np.fft.fft(value[:, 0] * np.linalg.det(S)) / 5
            # Σ h_k z^k, k = -2 to 2, times z², highest power first
            roots = np.roots(h[[2, 1, 0, 4, 3]]) if np.abs(h).max() > 0 else np.empty(0)
            starts = np.angle(roots[np.abs(np.abs(roots) - 1) < 1e-3])[:, None]
        found = problem.polished(starts)
    except np.linalg.LinAlgError:
        return None
    distinct: list[Array] = []
    for angles in found:
        if all(np.abs(np.exp(1j * angles) - np.exp(1j * one)).max() >= 1e-7 for one in distinct):
            distinct.append(angles)
    return distinct


class _Problem:
    def __init__(
        self,
        A: Array,
        c: Array,
        base: Array,
        columns: Sequence[Array],
        rows: list[int],
        sought: Sequence[Sought],
    ) -> None:
        self.A, self.c, self.base, self.rows, self.sought = A, c, base, rows, sought
        self.fixed = np.array(columns).reshape(-1, len(c)).T
        self.held = [i for i, one in enumerate(sought) if one.given is None]
        self.at = np.array([one.row for one in sought])

    def _units(self, cos: Array, sin: Array) -> Array:
        """Return the tangential parts of e(d), (n, k, m); with (-sin, cos) as arguments, their derivatives."""
        E = np.zeros((*cos.shape, len(self.c)))
        for i, one in enumerate(self.sought):
            E[:, i, one.row + 1] = -one.friction * cos[:, i]
            E[:, i, one.row + 2] = -one.friction * sin[:, i]
        return E

    def matrix(self, angles: Array) -> tuple[Array, Array, Array]:
        """Return e(d), S and B at each of the angles."""
        E = self._units(np.cos(angles), np.sin(angles))
        for i, one in enumerate(self.sought):
            E[:, i, one.row] = 1.0
        B = np.concatenate(
            [np.broadcast_to(self.fixed, (len(E), *self.fixed.shape)), E[:, self.held].transpose(0, 2, 1)],
            axis=2,
        )
        return E, self.A[self.rows] @ B, B

    def across(self, angles: Array) -> tuple[Array, Array, Array]:
        """Return r_T × d (n, k), its derivatives with respect to the angles (n, k, k), and its round-off (n, k).

        The round-off of a sum of m terms is m eps Σ |term|, that of x = S⁻¹ g is m eps |S⁻¹| (|S| |x| + |g|): Higham,
        Accuracy and Stability of Numerical Algorithms (2002), sections 3.1 and 7.2.
        """
        E, S, B = self.matrix(angles)
        cos, sin = np.cos(angles), np.sin(angles)
        turned = self._units(-sin, cos)
        base = np.broadcast_to(self.base, (len(E), len(self.c))).copy()
        for i, one in enumerate(self.sought):
            if one.given is not None:
                base += one.given * E[:, i]
        goal = -(base @ self.A.T + self.c)[:, self.rows]
        x = np.linalg.solve(S, goal[..., None])[..., 0] if self.rows else np.empty((len(E), 0))
        r = (base + np.einsum("nmj,nj->nm", B, x)) @ self.A.T + self.c
        unsure = np.abs(x)
        if self.rows:
            terms = np.einsum("nij,nj->ni", np.abs(S), unsure) + np.abs(goal)
            unsure = unsure + np.einsum("nij,nj->ni", np.abs(np.linalg.inv(S)), terms)
        size = (np.abs(base) + np.einsum("nmj,nj->nm", np.abs(B), unsure)) @ np.abs(self.A).T + np.abs(self.c)
        round_off = len(self.c) * np.finfo(float).eps * (size[:, self.at + 1] + size[:, self.at + 2])
        first, second = r[:, self.at + 1], r[:, self.at + 2]
        value = second * cos - first * sin
        slope = np.zeros((*value.shape, len(self.sought)))
        slots = self.fixed.shape[1]
        for i, one in enumerate(self.sought):
            N = one.given if one.given is not None else x[:, slots + self.held.index(i), None]
            push = N * turned[:, i]
            if self.rows:
                dx = np.linalg.solve(S, -(push @ self.A.T)[:, self.rows, None])[..., 0]
                push = push + np.einsum("nmj,nj->nm", B, dx)
            change = push @ self.A.T
            slope[:, :, i] = change[:, self.at + 2] * cos - change[:, self.at + 1] * sin
        own = np.arange(len(self.sought))
        slope[:, own, own] -= second * sin + first * cos
        return value, slope, round_off

    def polished(self, angles: Array) -> list[Array]:
        """Return zeros near the starts, by Newton's method, without those not reached in :data:`STEPS` steps.

        At a double root the slope vanishes with r_T × d, and the steps end in noise. There a zero is accepted if
        r_T × d is within its round-off.
        """
        reached = []
        best, least = angles, np.full(len(angles), np.inf)
        for _ in range(STEPS):
            if not len(angles):
                break
            value, slope, round_off = self.across(angles)
            miss = (np.abs(value) / np.maximum(round_off, np.finfo(float).tiny)).max(axis=1)
            closer = miss < least
            best, least = np.where(closer[:, None], angles, best), np.where(closer, miss, least)
            change = -np.einsum("nij,nj->ni", np.linalg.pinv(slope, rcond=1e-8), value)
            angles = angles + np.clip(change, -0.5, 0.5)
            last = np.abs(change).max(axis=1) < 1e-13
            stays = ~last & ~closer & (least <= 1)
            reached += [*angles[last], *best[stays]]
            on = ~(last | stays)
            angles, best, least = angles[on], best[on], least[on]
        return [*reached, *best[least <= 1]]


def newton(function: Callable[[Array], Array | None], x: Array, most: int = 40) -> Array | None:
    """Return a zero of a function of angles near ``x``, or None. The slope is approximated by differences."""
    step = 1e-6
    for _ in range(most):
        value = function(x)
        if value is None:
            return None
        columns = []
        for k in range(len(x)):
            turned = x.copy()
            turned[k] += step
            other = function(turned)
            if other is None:
                return None
            columns.append((other - value) / step)
        change = np.linalg.lstsq(np.array(columns).T, -value, rcond=1e-8)[0]
        change = np.clip(change, -0.5, 0.5)
        x = x + change
        if np.abs(change).max() < 1e-14:
            return x
    return x if np.abs(change).max() < 1e-12 else None
