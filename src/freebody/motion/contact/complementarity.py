"""Contact as a numerical complementarity problem, solved by trying every combination of modes.

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
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..cones.cone_problem import ConeProblem
from ..cones.contacts import EXACT, Touching
from .slip_directions import Sought, directions, newton

Array = NDArray[np.float64]

OPEN, STICK, SLIP = "open", "stick", "slip"
WHOLE = 2
"""Largest number of contacts at rest in space for which all combinations with new slip directions are tried."""
MOST = 1 << 8
"""Largest number of combinations of modes that are tried."""
NEAR, LIMIT = 1e-6, 1e-3
"""Residual of forces that are near a solution, and the part by which friction is below its limit near it."""
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


def solutions(A: Array, c: Array, contacts: Sequence[Touching], among: Any = None) -> list[Solution]:
    """Return all consistent sets of modes; beyond :data:`WHOLE` and :data:`MOST`, some.

    Parameters
    ----------
    A : array (m, m)
        Rates per unit force.
    c : array (m,)
        Rates without contact forces.
    contacts : sequence of Touching
    among : sequence of sequences of modes, optional
        The sets to try; by default all combinations.
    """
    choices = [_choices(contact) for contact in contacts]
    count = math.prod(map(len, choices))
    if among is None:
        many = count > MOST or sum(map(_may_begin, choices)) > WHOLE
        if many:
            return of_equal_compliance(A, c, contacts) or at_limits(A, c, contacts)
    return [
        one
        for modes in (itertools.product(*choices) if among is None else among)
        for one in _solved(A, c, contacts, modes)
        if one.residual <= SMALL
    ]


def of_equal_compliance(A: Array, c: Array, contacts: Sequence[Touching]) -> list[Solution]:
    """Return the solution that is the limit of equal compliance at all contacts; none if there is none.

    Contacts at the limit of friction without slip follow in a second solution, in which their slip begins against it.
    Slip has the kinetic friction: contacts whose static friction is exceeded are released, and the problem is solved
    anew until all that slip are.
    """
    laws = list(contacts)
    while True:
        found = ConeProblem(A, c, laws).solve()
        if not found.residual <= EXACT:
            return []
        modes = _modes_of(found.forces, found.rates, c, contacts)
        released = [
            i
            for i, (one, (mode, d)) in enumerate(zip(laws, modes, strict=True))
            if mode == SLIP and one.sliding is None and one.static > one.friction
        ]
        if not released:
            break
        for i in released:
            laws[i] = replace(laws[i], static=laws[i].friction)
    _, rows = unknowns(len(c), contacts, modes)
    columns, _ = unknowns(
        len(c), contacts, [(STICK, None) if m == SLIP and d is None else (m, d) for m, d in modes]
    )
    S = A[rows] @ np.array(columns).T if rows else np.zeros((0, 0))
    lack = len(rows) - int(np.linalg.matrix_rank(S, tol=SMALL * np.abs(S).max(initial=1e-300))) if rows else 0
    one = _judged(A, c, contacts, tuple(modes), found.forces, found.rates, rows, lack)
    # a sum of forces that moves nothing may have brought contacts at rest to their cones: share them anew
    shared = _linear(A, c, contacts, modes) if lack else None
    if shared is not None and shared.residual <= SMALL:
        one = shared
    result = [one]
    limit = {i for i, law in one.ties if law == "cone" and one.forces[contacts[i].row] > 0}
    turned = list(modes)
    for i in limit:
        at = contacts[i].row + 1
        T = one.forces[at : at + contacts[i].tangents]
        turned[i] = (SLIP, -T / np.linalg.norm(T))
    begun = _linear(A, c, contacts, turned) if limit else None
    if begun is not None and begun.residual <= SMALL:
        result.append(begun)
    return result


def at_limits(A: Array, c: Array, contacts: Sequence[Touching]) -> list[Solution]:
    """Return solutions near the forces of equal compliance where these are not found to round-off.

    They are not where contacts are at the limit of friction and share forces: both cone and slip vanish there. Each of
    these contacts may stick or begin to slip; the others have the modes of the forces.
    """
    found = ConeProblem(A, c, contacts).solve()
    if not found.residual <= NEAR:
        return []
    choices: list[list[tuple[str, Any]]] = []
    for contact, (mode, d) in zip(contacts, _modes_of(found.forces, found.rates, c, contacts), strict=True):
        at, n = contact.row, contact.tangents
        T = float(np.linalg.norm(found.forces[at + 1 : at + 1 + n]))
        rests = mode != OPEN and n > 0 and contact.sliding is None and contact.friction > 0
        if rests and contact.static * found.forces[at] - T <= LIMIT * T:
            begins = [(SLIP, None)] if n > 1 else [(SLIP, np.array([s])) for s in (1.0, -1.0)]
            choices.append([(STICK, None), *begins])
        else:
            choices.append([(mode, d)])
    if math.prod(map(len, choices)) > MOST:
        return []
    return solutions(A, c, contacts, itertools.product(*choices))


def _modes_of(forces: Array, rates: Array, c: Array, contacts: Sequence[Touching]) -> list[tuple[str, Any]]:
    """Return the modes of the contacts under forces that solve their problem."""
    small = 1e-9 * float(np.abs(forces).max(initial=0))
    slow = 1e-9 * max(float(np.abs(c).max(initial=0)), float(np.abs(rates).max(initial=0)))
    result: list[tuple[str, Any]] = []
    for contact in contacts:
        at, n = contact.row, contact.tangents
        v = rates[at + 1 : at + 1 + n]
        speed = float(np.linalg.norm(v))
        if forces[at] <= small and not contact.held:
            result.append((OPEN, None))
        elif n == 0 or contact.friction == contact.static == 0:
            result.append((SLIP, np.zeros(n)))
        elif contact.sliding is not None:
            result.append((SLIP, contact.sliding))
        else:
            result.append((SLIP, v / speed) if speed > slow else (STICK, None))
    return result


def _may_begin(choices: Sequence[tuple[str, Any]]) -> bool:
    """Return True if the choices include a slip whose direction is unknown."""
    return any(mode == SLIP and d is None for mode, d in choices)


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
        if not contact.held:
            rows.append(at)
        if mode == STICK:
            columns += list(unit[at + contact.held : at + 1 + n])
            rows += range(at + 1, at + 1 + n)
        elif d is not None and not contact.held:
            e = unit[at].copy()
            e[at + 1 : at + 1 + n] = -contact.friction * d
            columns.append(e)
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
        if not contact.held:
            slack.append((i, "normal", forces[at] * f))
        if mode == STICK:
            T = float(np.linalg.norm(forces[at + 1 : at + 1 + n]))
            slack.append((i, "cone", (contact.static * forces[at] - T) * f))
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


def dependent_normals(A: Array, contacts: Sequence[Touching]) -> bool:
    """Return True if the motion does not determine how the contacts share the normal forces."""
    normals = [c.row for c in contacts if not c.held]
    sizes = np.linalg.svd(A[np.ix_(normals, normals)], compute_uv=False)
    return bool(normals) and bool(sizes[-1] <= SMALL * sizes[0])


def painleve(A: Array, contact: Touching) -> float:
    """Return the normal rate per unit normal force in slip, A_NN - μ d·A_NT: Painlevé's paradoxes need it <= 0."""
    at, n = contact.row, contact.tangents
    if contact.sliding is None:
        return float(A[at, at] - contact.friction * np.linalg.norm(A[at, at + 1 : at + 1 + n]))
    return float(A[at, at] - contact.friction * (A[at, at + 1 : at + 1 + n] @ contact.sliding))
