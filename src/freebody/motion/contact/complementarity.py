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
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import SimulationError
from .newton import polished
from .slip_directions import Sought, directions, newton, relaxed

Array = NDArray[np.float64]

OPEN, STICK, SLIP = "open", "stick", "slip"
WHOLE = 2
"""Largest number of contacts at rest in space for which all combinations with new slip directions are tried."""
GUESSES = 64
"""Largest number of combinations tried if an approximate solution does not decide the modes."""
MOST = 1 << 14
"""Largest number of combinations of modes that are tried; time stepping handles scenes with more contacts."""
SMALL = 1e-10
"""Relative size below which a force or rate is zero and a matrix singular: above the round-off of small systems."""


@dataclass(frozen=True)
class Touching:
    """One closed contact of the problem.

    ``row``        its first row (normal), followed by its ``tangents`` rows (1 planar, 2 spatial, 0 frictionless)
    ``friction``   kinetic coefficient; ``static`` is the static coefficient
    ``sliding``    unit direction of slip, shape (tangents,), if it already slips; None at rest
    """

    name: str
    row: int
    tangents: int
    friction: float
    static: float
    sliding: Array | None = None


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
    """Return all consistent sets of modes.

    Parameters
    ----------
    A : array (m, m)
        Rates per unit force.
    c : array (m,)
        Rates without contact forces.
    contacts : sequence of Touching
    among : sequence of sequences of modes, optional
        The sets to try; by default all combinations.

    Raises
    ------
    SimulationError
        If there are more combinations than :data:`MOST`.
    """
    choices = [_choices(contact) for contact in contacts]
    count = int(np.prod([len(one) for one in choices], dtype=float)) if among is None else 0
    if count > MOST:
        raise SimulationError(
            f"{len(contacts)} contacts closed at once have {count} combinations of modes; at most {MOST} "
            f"are tried. Use method='timestepping' for scenes like this."
        )
    resting = sum(_may_begin(one) for one in choices)
    if among is None and resting > WHOLE:
        return _staged(A, c, contacts, choices)
    return [
        one
        for modes in (itertools.product(*choices) if among is None else among)
        for one in _solved(A, c, contacts, modes)
        if one.residual <= SMALL
    ]


def _staged(A: Array, c: Array, contacts: Sequence[Touching], choices: Any) -> list[Solution]:
    """Return solutions for many contacts at rest in space: sets without new slip, and sets that relaxation suggests.

    The unknown slip directions make a complete search too long. With more than :data:`WHOLE` such contacts, the list
    of solutions may therefore be incomplete.
    """
    known = [[(mode, d) for mode, d in one if not (mode == SLIP and d is None)] for one in choices]
    near = closest(A, c, contacts)
    likely: list[list[tuple[str, Any]]] = []
    every = []
    for (pressed, still), one in zip(undecided(A, c, contacts, near), choices, strict=True):
        free = _may_begin(one)
        closed = [one[1]] * (still is not False) + [(SLIP, None)] * (still is not True) if free else [one[1]]
        likely.append([*closed] * (pressed is not False) + [(OPEN, None)] * (pressed is not True))
        every.append((OPEN, None) if pressed is False else (SLIP, None) if free else one[1])
    guesses = list(itertools.islice(itertools.product(*likely), GUESSES))
    # also the sets with one contact open: if forces are indeterminate, the least in norm may pull at a contact
    fewer = [
        [(OPEN, None) if i == j else mode for j, mode in enumerate(modes)]
        for modes in (every, guesses[0])
        for i in range(len(contacts))
        if modes[i][0] != OPEN
    ]
    found = [one for modes in itertools.product(*known) for one in _solved(A, c, contacts, modes)]
    found = [one for one in found if one.residual <= SMALL]
    for sets in (guesses, [every, *fewer]):
        tried = (
            one for modes in sets for one in _solved(A, c, contacts, modes, near) if one.residual <= SMALL
        )
        if sets is guesses or not found:
            found += itertools.islice(tried, 1)  # all results of one search are near the same solution
    for one in list(found):  # at the friction limit, slip is about to begin opposite to the friction
        limit = {i for i, law in one.ties if law == "cone" and one.forces[contacts[i].row] > 0}
        turned = list(one.modes)
        for i in limit:
            at = contacts[i].row + 1
            T = one.forces[at : at + contacts[i].tangents]
            turned[i] = (SLIP, -T / np.linalg.norm(T))
        begun = _linear(A, c, contacts, turned) if limit else None
        if begun is not None and begun.residual <= SMALL:
            found.append(begun)
    return found


def closest(A: Array, c: Array, contacts: Sequence[Touching], least: Any = None) -> Array:
    """Return forces at or near a solution with exact cones and kinetic friction, as the start of a search.

    ``least`` gives, for each contact, a normal force that acts in any case.
    """
    rows: list[int] = []
    columns: list[Array] = []
    kinds: list[int] = []
    low: list[float] = []
    mu: list[float] = []
    reduced = []
    unit = np.eye(len(c))
    for i, contact in enumerate(contacts):
        at, d, n = contact.row, contact.sliding, contact.tangents
        free = n > 0 and contact.friction > 0 and d is None
        reduced.append(replace(contact, row=len(rows), tangents=n if free else 0))
        column = unit[at].copy()
        if d is not None:
            column[at + 1 : at + 1 + n] = -contact.friction * d
        rows.append(at)
        columns.append(column)
        kinds.append(1)
        mu.append(0.0)
        low.append(0.0 if least is None else float(least[i]))
        if free:
            rows += range(at + 1, at + 1 + n)
            columns += list(unit[at + 1 : at + 1 + n])
            kinds += [2] if n == 1 else [3, 4]
            mu += [contact.friction] * n
            low += [0.0] * n
    B = np.array(columns).T
    S, goal = A[rows] @ B, c[rows]
    normal = [one.row for one in reduced]
    x = relaxed(S, goal, reduced, 100, np.array(low)[normal])
    if (S.diagonal() > 0).all():
        size = float(np.abs(goal).max(initial=0)) + float((np.abs(S) @ np.abs(x)).max(initial=0))
        found = polished(S, goal, kinds, np.array(mu), x, 1e-14 * size, least=np.array(low))
        x = relaxed(S, goal, reduced, 2000, np.array(low)[normal]) if found is None else found
    return B @ x


def undecided(
    A: Array, c: Array, contacts: Sequence[Touching], forces: Array, least: Any = None
) -> list[tuple[bool | None, bool | None]]:
    """Return, for each contact, whether it presses and whether it sticks under forces that are nearly a solution.

    None marks an answer that these forces do not decide. A contact presses if its normal force exceeds ``least``.
    """
    rates = A @ forces + c
    small = 1e-6 * float(np.abs(forces).max(initial=0))
    slow = 1e-6 * max(float(np.abs(c).max(initial=0)), float((np.abs(A) @ np.abs(forces)).max(initial=0)))
    found: list[tuple[bool | None, bool | None]] = []
    for i, contact in enumerate(contacts):
        at, n = contact.row, contact.tangents
        pressed = forces[at] - (0.0 if least is None else least[i]) > small
        drawn = float(np.linalg.norm(forces[at + 1 : at + 1 + n]))
        slips = float(np.linalg.norm(rates[at + 1 : at + 1 + n])) > slow
        holds = bool(drawn < contact.friction * forces[at] - small)
        found.append((
            None if not pressed and not rates[at] > slow else bool(pressed),
            None if not holds and not slips else holds,
        ))  # fmt: skip
    return found


def _may_begin(choices: Sequence[tuple[str, Any]]) -> bool:
    """Return True if the choices include a slip whose direction is unknown."""
    return any(mode == SLIP and d is None for mode, d in choices)


def _choices(contact: Touching) -> list[tuple[str, Any]]:
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
    near: Array | None = None,
) -> Iterator[Solution]:
    """Yield the solutions of one combination: at most one, or several if slip directions are unknown.

    The search for directions starts from those of the forces ``near`` or, without them, from several directions.
    """
    sought = [i for i, (mode, d) in enumerate(modes) if mode == SLIP and d is None]
    if not sought:
        one = _linear(A, c, contacts, modes)
        if one is not None:
            yield one
        return
    if near is None:
        starts = np.array(list(_starts(A, c, contacts, modes, sought)))
    else:
        starts = np.array([_along(A, c, contacts, sought, near)])
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
    """Yield angles to start the search from: those of the relaxed forces, then opposite to the sticking force and
    evenly spaced around the circle from there.
    """
    if len(sought) > 1:
        yield _along(A, c, contacts, sought, closest(A, c, contacts))
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
    """Return the columns of B in λ = B x and the rows of r that vanish; a slip of unknown direction has no column."""
    columns, rows = [], []
    unit = np.eye(m)
    for contact, (mode, d) in zip(contacts, modes, strict=True):
        if mode == OPEN:
            continue
        at, n = contact.row, contact.tangents
        rows.append(at)
        if mode == STICK:
            columns += list(unit[at : at + 1 + n])
            rows += range(at + 1, at + 1 + n)
        elif d is not None:
            e = unit[at].copy()
            e[at + 1 : at + 1 + n] = -contact.friction * d
            columns.append(e)
    return columns, rows


def _linear(
    A: Array, c: Array, contacts: Sequence[Touching], modes: Sequence[tuple[str, Any]]
) -> Solution | None:
    """Return forces and rates of one combination; None if its equations have no solution."""
    columns, rows = unknowns(len(c), contacts, modes)
    forces, lack = np.zeros(len(c)), 0
    if rows:
        found = balanced(A, c, contacts, np.array(columns).T, rows, forces)
        if found is None:
            return None
        forces, lack = found
    rates = A @ forces + c
    return _judged(A, c, contacts, tuple(modes), forces, rates, rows, lack)


def balanced(
    A: Array, c: Array, contacts: Sequence[Touching], B: Array, rows: list[int], base: Array
) -> tuple[Array, int] | None:
    """Return forces base + B x for which the ``rows`` of the rates vanish, and the number of indeterminate forces.

    If forces are indeterminate, N is least in the norm of all forces, and T then has the least Σ |T|²/N.
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
    if lack:
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


def least_of(found: Sequence[Solution], A: Array, contacts: Sequence[Touching]) -> list[Solution]:
    """Return the solutions with normal forces least in norm if these are indeterminate; otherwise all solutions."""
    normals = [c.row for c in contacts]
    sizes = np.linalg.svd(A[np.ix_(normals, normals)], compute_uv=False)
    if not found or sizes[-1] > SMALL * sizes[0]:
        return list(found)
    norms = [float(np.linalg.norm(one.forces[normals])) for one in found]
    return [one for one, norm in zip(found, norms, strict=True) if norm <= min(norms) * (1 + SMALL)]


def painleve(A: Array, contact: Touching) -> float:
    """Return the normal rate per unit normal force in slip, A_NN - μ d·A_NT: Painlevé's paradoxes need it <= 0."""
    at, n = contact.row, contact.tangents
    if contact.sliding is None:
        return float(A[at, at] - contact.friction * np.linalg.norm(A[at, at + 1 : at + 1 + n]))
    return float(A[at, at] - contact.friction * (A[at, at + 1 : at + 1 + n] @ contact.sliding))
