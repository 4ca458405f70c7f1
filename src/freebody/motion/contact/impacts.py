"""Impacts: jumps of the speeds at closed contacts, as complementarity problems of impulses.

    v⁺ = A Λ + v⁻,     A = W M⁻¹ Wᵀ

    Newton     0 <= Λ_N  ⟂  v_N⁺ + e v_N⁻ >= 0          -Λ_T in μ Λ_N Sgn(v_T⁺)
    Poisson    compression: the same with e = 0, impulse Λ_C;
               expansion:   0 <= Λ_E - e Λ_C  ⟂  v_N⁺ >= 0,  -Λ_TE in μ Λ_NE Sgn(v_T⁺)

Either all closed contacts take part at once, including contacts at rest ("simultaneous"), or the contacts collide one
after another, always the fastest approaching contact first ("sequential"). These are two different assumptions; the
rigid-body model does not decide between them.

Sources: J. J. Moreau (1988); C. Glocker, F. Pfeiffer (1996), chapter 8.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...errors import SimulationError
from .complementarity import (
    GUESSES,
    OPEN,
    SLIP,
    STICK,
    WHOLE,
    Array,
    Solution,
    Touching,
    balanced,
    closest,
    distinct,
    least_of,
    solutions,
    undecided,
)
from .slip_directions import Sought, directions, newton

Kind = tuple[bool, str, Any]
"""State of a contact in expansion: True if it is held (r_N = 0), its mode (stick or slip), and its slip direction."""
ALIKE = 1e-8
"""Relative difference up to which two outcomes count as the same."""
ORDERS = ("simultaneous", "sequential")
_PASSES = 100_000


@dataclass(frozen=True)
class Impact:
    """Impulses Λ, shape (m,), speeds of the contacts after the impact, and the change of kinetic energy [J]."""

    impulses: Array
    after: Array
    energy: float


def impact(
    A: Array,
    before: Array,
    contacts: Sequence[Touching],
    restitution: Sequence[float],
    laws: Sequence[str],
    responses: Array,
    order: str = "simultaneous",
    still: float = 0.0,
    least: bool = False,
) -> Impact:
    """Return the impulses of an impact.

    Parameters
    ----------
    A, responses       contact speeds, and speeds of the machine, per unit impulse
    before             speeds of the contacts just before the impact
    restitution, laws  e and "newton" or "poisson" for each contact
    still              speed up to which a contact counts as at rest
    least              choose the impulses least in norm if they are indeterminate

    Raises
    ------
    SimulationError
        If there is no solution, if several lead to different motions, or if the kinetic energy would grow.
    """
    # an impact does not depend on earlier sticking: the kinetic coefficient of friction applies throughout
    contacts = [replace(c, sliding=None, static=c.friction) for c in contacts]
    if order == "sequential":
        return _one_by_one(A, before, contacts, restitution, laws, responses, still)
    approaching = [before[c.row] < -still for c in contacts]
    if any(law == "poisson" for law, a in zip(laws, approaching, strict=True) if a):
        if any(law != "poisson" for law, a in zip(laws, approaching, strict=True) if a):
            raise SimulationError(
                "Contacts "
                + ", ".join(f"'{c.name}'" for c in contacts)
                + " collide at once, some by Newton's and some by Poisson's law. Give them the same law: "
                "impact='newton' or 'poisson'."
            )
        return _poisson(A, before, contacts, restitution, responses, still, least)
    c = before.copy()
    for one, e, moving in zip(contacts, restitution, approaching, strict=True):
        if moving:
            c[one.row] += e * before[one.row]
    found = solutions(A, c, contacts)
    chosen = _only(found, A, responses, contacts, before, "Newton's law of impact", still, least)
    return _checked(A, before, chosen.forces, contacts, "newton")


def _poisson(
    A: Array, before: Array, contacts: Sequence[Touching], restitution: Sequence[float], responses: Array,
    still: float, least: bool,
) -> Impact:  # fmt: skip
    first = solutions(A, before, contacts)
    compressed = _only(first, A, responses, contacts, before, "the compression", still, least)
    middle = A @ compressed.forces + before
    given = np.array([e * compressed.forces[c.row] for c, e in zip(contacts, restitution, strict=True)])
    found = _expansions(A, middle, contacts, given)
    size = float(np.abs(compressed.forces @ responses).max(initial=0))
    expanded = _only(found, A, responses, contacts, before, "the expansion", still, least, size)
    return _checked(A, before, compressed.forces + expanded.forces, contacts, "poisson")


def _expansions(A: Array, c: Array, contacts: Sequence[Touching], given: Array) -> list[Solution]:
    """Return solutions in which the impulses ``given`` act in any case: λ_N = given + x, 0 <= x ⟂ r_N >= 0.

    Each contact is held (r_N = 0) or lets go (x = 0), and sticks or slips. All combinations are tried. If more than
    :data:`WHOLE` contacts in space may slip in an unknown direction, only two kinds of combinations are tried: those
    without such a slip, and at most :data:`GUESSES` suggested by relaxation.
    """
    choices: list[list[Kind]] = []
    for contact, p in zip(contacts, given, strict=True):
        plain = contact.tangents == 0 or contact.friction == 0
        ways: list[Any] = [None] if contact.tangents == 2 else [np.array([1.0]), np.array([-1.0])]
        rough = [(STICK, None), *((SLIP, d) for d in ways)]
        modes = [(SLIP, np.zeros(contact.tangents))] if plain else rough
        choices.append([(True, *mode) for mode in modes])
        choices[-1] += [(False, *mode) for mode in modes] if p > 0 else [(False, OPEN, None)]
    sought = sum(any(mode == SLIP and d is None for _, mode, d in one) for one in choices)
    near = closest(A, c, contacts, given) if sought else given
    whole = itertools.product(*choices)
    if sought <= WHOLE:
        return [one for kinds in whole for one in _expanded(A, c, contacts, given, kinds, near)]
    likely: list[list[Kind]] = []
    for (pressed, still), one in zip(undecided(A, c, contacts, near, given), choices, strict=True):
        same = [kind for kind in one if pressed is None or kind[0] == pressed]
        likely.append([kind for kind in same if still is None or (kind[1] == STICK) == still] or same)
    guesses = itertools.islice(itertools.product(*likely), GUESSES)
    steady = [[kind for kind in one if not (kind[1] == SLIP and kind[2] is None)] for one in choices]
    return [
        one
        for kinds in [*guesses, *itertools.product(*steady)]
        for one in _expanded(A, c, contacts, given, kinds, near)
    ]


def _expanded(
    A: Array, c: Array, contacts: Sequence[Touching], given: Array, kinds: Sequence[Kind], near: Array
) -> list[Solution]:
    """Return the solutions of one combination, with all slip directions that are found."""
    sought = [i for i, (_, mode, d) in enumerate(kinds) if mode == SLIP and d is None]

    def system(turned: Sequence[Kind]) -> tuple[Array, list[Array], list[int]]:
        """Return the known impulses, the columns of the unknown impulses and the rows of the speeds that vanish."""
        base, columns, rows = np.zeros(len(c)), [], []
        unit = np.eye(len(c))
        for contact, p, (held, mode, d) in zip(contacts, given, turned, strict=True):
            if mode == OPEN:
                continue
            at, n = contact.row, contact.tangents
            e = unit[at].copy()
            if mode == SLIP and d is not None:
                e[at + 1 : at + 1 + n] = -contact.friction * d
            if held:
                rows.append(at)
            if mode == SLIP and d is None:
                continue
            if held:
                columns.append(e)
            else:
                base += p * e
            if mode == STICK:
                columns += list(unit[at + 1 : at + 1 + n])
                rows += range(at + 1, at + 1 + n)
        return base, columns, rows

    def moved(turned: Sequence[Kind]) -> tuple[Array, int] | None:
        base, columns, rows = system(turned)
        return balanced(A, c, contacts, np.array(columns).T, rows, base) if rows else (base, 0)

    def turned_by(angles: Array) -> list[Kind]:
        turned = list(kinds)
        for i, angle in zip(sought, angles, strict=True):
            turned[i] = (turned[i][0], SLIP, np.array([np.cos(angle), np.sin(angle)]))
        return turned

    def across(angles: Array) -> Array | None:
        one = moved(turned_by(angles))
        if one is None:
            return None
        v = A @ one[0] + c
        at = [contacts[i].row for i in sought]
        return np.array(
            [v[k + 2] * np.cos(x) - v[k + 1] * np.sin(x) for k, x in zip(at, angles, strict=True)]
        )

    def starts() -> Iterator[Array]:
        for x, sign in ((near, -1), (c, 1)):
            first = np.array(
                [np.arctan2(sign * x[contacts[i].row + 2], sign * x[contacts[i].row + 1]) for i in sought]
            )
            turns = 6 if sign > 0 and len(sought) <= WHOLE else 1
            for shifts in itertools.product(range(turns), repeat=len(sought)):
                yield first + 2 * np.pi / turns * np.array(shifts)

    found: Any = [np.empty(0)]
    if sought:
        looked = [
            Sought(contacts[i].row, contacts[i].friction, None if kinds[i][0] else float(given[i]))
            for i in sought
        ]
        begin = list(starts())
        found = directions(A, c, *system(kinds), looked, np.array(begin))
        if found is None:
            found = (x for x in (newton(across, start) for start in begin) if x is not None)
    results: list[Solution] = []
    for angles in found:
        turned = turned_by(angles)
        one = moved(turned)
        if one is None:
            continue
        forces, lack = one
        rates = A @ forces + c
        if _fits(contacts, given, turned, forces, rates, A, c):
            modes = tuple(
                (mode if held or mode == OPEN else f"let go, {mode}", d) for held, mode, d in turned
            )
            results.append(Solution(modes, forces, rates, 0.0, (), lack))
    return results


def _fits(
    contacts: Sequence[Touching], given: Array, kinds: Any, forces: Array, rates: Array, A: Array, c: Array
) -> bool:
    scale_f = max(float(np.abs(forces).max(initial=0)), 1e-300)
    scale_r = max(float(np.abs(c).max(initial=0)), float((np.abs(A) @ np.abs(forces)).max(initial=0)))
    for contact, p, (held, mode, d) in zip(contacts, given, kinds, strict=True):
        at, n = contact.row, contact.tangents
        T = float(np.linalg.norm(forces[at + 1 : at + 1 + n]))
        off = float(np.abs(rates[at + 1 : at + 1 + n]).max(initial=0))
        if rates[at] < -1e-10 * scale_r or (held and rates[at] > 1e-10 * scale_r):
            return False
        if held and forces[at] < p - 1e-10 * scale_f:
            return False
        if mode == STICK and (contact.friction * forces[at] + 1e-10 * scale_f < T or off > 1e-10 * scale_r):
            return False
        if mode == SLIP and n and d is not None and d @ rates[at + 1 : at + 1 + n] < -1e-10 * scale_r:
            return False
    return True


def _one_by_one(
    A: Array,
    before: Array,
    contacts: Sequence[Touching],
    restitution: Sequence[float],
    laws: Sequence[str],
    responses: Array,
    still: float,
) -> Impact:
    v, total = before.copy(), np.zeros(len(before))
    size = max(float(np.abs(before).max(initial=0)), still)
    for _ in range(_PASSES):
        speeds = [v[c.row] for c in contacts]
        i = int(np.argmin(speeds))
        if speeds[i] >= -max(still, 1e-13 * size):
            return _checked(A, before, total, contacts, "sequential")
        hit = impact(A, v, [contacts[i]], [restitution[i]], [laws[i]], responses, still=still)
        total, v = total + hit.impulses, hit.after
    names = ", ".join(f"'{c.name}'" for c in contacts)
    raise SimulationError(
        f"The sequence of impacts at contacts {names} did not end after {_PASSES} impacts: the fastest contact still "
        f"approaches at {-min(v[c.row] for c in contacts):.3g} m/s. Use impacts='simultaneous'."
    )


def _only(
    found: Sequence[Solution],
    A: Array,
    responses: Array,
    contacts: Sequence[Touching],
    before: Array,
    what: str,
    still: float,
    least: bool,
    size: float = 0.0,
) -> Solution:
    """Return the only solution; motions whose speeds differ by less than ``still`` count as the same."""
    names = ", ".join(f"'{c.name}' ({before[c.row]:.6g} m/s)" for c in contacts)
    if not found:
        raise SimulationError(
            f"No impulses satisfy {what} with Coulomb friction at contacts {names} (approach speed along the normal)."
        )
    groups = distinct(found, responses, max(size, still / ALIKE), ALIKE)
    if len(groups) > 1 and least:
        groups = distinct(least_of(found, A, contacts), responses, max(size, still / ALIKE), ALIKE)
    if len(groups) > 1:
        modes = "; ".join(
            ", ".join(f"{c.name}: {m[0]}" for c, m in zip(contacts, g[0].modes, strict=True)) for g in groups
        )
        raise SimulationError(
            f"{len(groups)} different outcomes satisfy {what} with Coulomb friction at contacts {names}: {modes}. "
            f"Rigid bodies do not decide between them. Change the friction or the law (impact='poisson')"
            + ("." if len(least_of(found, A, contacts)) == len(found) else ", or use indeterminate='least'.")
        )
    return min(groups[0], key=lambda one: (one.rank_lack, sum(m[0] == OPEN for m in one.modes)))


def _checked(A: Array, before: Array, impulses: Array, contacts: Sequence[Touching], law: str) -> Impact:
    """Return the impact with its change of kinetic energy ΔT = Λ·(v⁻ + v⁺)/2; raise an error if this is positive."""
    after = A @ impulses + before
    energy = float(impulses @ (before + after)) / 2
    size = float(np.abs(impulses) @ (np.abs(before) + np.abs(after)))
    if energy > 1e-10 * size:
        names = ", ".join(f"'{c.name}'" for c in contacts)
        cure = "impact='poisson'" if law == "newton" else "a smaller restitution"
        raise SimulationError(
            f"The impact at contacts {names} would create energy, {energy:.6g} J: Newton's coefficient of restitution "
            f"with Coulomb friction can do that if the slip reverses (Kane, 1984). Give the contact {cure}."
        )
    return Impact(impulses, after, energy)
