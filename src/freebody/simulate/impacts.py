"""Impacts: jumps of the speeds at closed contacts, by complementarity of impulses.

    v⁺ = A Λ + v⁻,     A = W M⁻¹ Wᵀ

    Newton     0 <= Λ_N  ⟂  v_N⁺ + e v_N⁻ >= 0          -Λ_T in μ Λ_N Sgn(v_T⁺)
    Poisson    compression: the same with e = 0, impulse Λ_C;
               expansion:   0 <= Λ_E - e Λ_C  ⟂  v_N⁺ >= 0,  -Λ_TE in μ Λ_NE Sgn(v_T⁺)

All contacts that are closed take part at once, those at rest too ("simultaneous"), or one after another, always the one
that approaches fastest ("sequential"): two different assumptions, between which rigid bodies do not decide.

Sources: J. J. Moreau (1988); C. Glocker, F. Pfeiffer (1996), chapter 8.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..errors import SimulationError
from .complementarity import OPEN, SLIP, STICK, Array, Solution, Touching, distinct, solutions

ORDERS = ("simultaneous", "sequential")
_PASSES = 100_000


@dataclass(frozen=True)
class Impact:
    """Impulses Λ, shape (m,), speeds of the contacts after it, and the change of kinetic energy [J]."""

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
) -> Impact:
    """The impulses of an impact.

    Parameters
    ----------
    A, responses       contact speeds, and speeds of the machine, per unit impulse
    before             speeds of the contacts just before
    restitution, laws  e, and "newton" or "poisson", of each contact
    still              speed up to which a contact is at rest

    Raises
    ------
    SimulationError
        No solution, several with different motions, or one in which energy would grow.
    """
    # an impact has no memory of sticking: one coefficient of friction, the kinetic one
    contacts = [replace(c, sliding=None, static=c.friction) for c in contacts]
    if order == "sequential":
        return _one_by_one(A, before, contacts, restitution, laws, responses, still)
    approaching = [before[c.row] < -still for c in contacts]
    if any(law == "poisson" for law, a in zip(laws, approaching, strict=True) if a):
        if any(law != "poisson" for law, a in zip(laws, approaching, strict=True) if a):
            raise SimulationError(
                "Contacts "
                + ", ".join(f"'{c.name}'" for c in contacts)
                + " collide at once, some by Newton's and some by Poisson's law. Give them one law: impact='newton' "
                "or 'poisson'."
            )
        return _poisson(A, before, contacts, restitution, responses)
    c = before.copy()
    for one, e, moving in zip(contacts, restitution, approaching, strict=True):
        if moving:
            c[one.row] += e * before[one.row]
    chosen = _only(solutions(A, c, contacts), responses, contacts, before, "Newton's law of impact")
    return _checked(A, before, chosen.forces, contacts, "newton")


def _poisson(
    A: Array, before: Array, contacts: Sequence[Touching], restitution: Sequence[float], responses: Array
) -> Impact:
    compressed = _only(solutions(A, before, contacts), responses, contacts, before, "the compression")
    middle = A @ compressed.forces + before
    given = np.array([e * compressed.forces[c.row] for c, e in zip(contacts, restitution, strict=True)])
    found = _expansions(A, middle, contacts, given)
    expanded = _only(found, responses, contacts, before, "the expansion")
    return _checked(A, before, compressed.forces + expanded.forces, contacts, "poisson")


def _expansions(A: Array, c: Array, contacts: Sequence[Touching], given: Array) -> list[Solution]:
    """Solutions in which the impulses ``given`` act in any case: λ_N = given + x, 0 <= x ⟂ r_N >= 0.

    With x as the unknown this is the problem of `solutions` but for friction, which also acts on what is given: each
    contact that lets go (x = 0) sticks or slips under it, so these are tried as loads, one combination at a time.
    """
    result: list[Solution] = []
    kinds: list[list[tuple[str, Any]]] = []
    for contact, p in zip(contacts, given, strict=True):
        plain = contact.tangents == 0 or contact.friction == 0
        directions: list[Any] = [None] if contact.tangents == 2 else [np.array([1.0]), np.array([-1.0])]
        kinds.append([("held", None)])
        if p > 0:
            kinds[-1] += (
                [("free", np.zeros(contact.tangents))]
                if plain
                else [("stuck", None), *(("dragged", d) for d in directions)]
            )
        else:
            kinds[-1].append(("off", None))
    for combination in itertools.product(*kinds):
        result += _expansion(A, c, contacts, given, combination)
    return result


def _expansion(
    A: Array, c: Array, contacts: Sequence[Touching], given: Array, kinds: Sequence[tuple[str, Any]]
) -> list[Solution]:
    loads = np.zeros(len(c))
    trial, modes = [], []
    stuck = [i for i, (kind, _) in enumerate(kinds) if kind == "stuck"]
    for i, (contact, (kind, d)) in enumerate(zip(contacts, kinds, strict=True)):
        n = contact.tangents
        if kind in ("free", "dragged", "stuck"):
            loads[contact.row] = given[i]
        if kind == "dragged":
            if d is None:
                # in space: along the slip that is left if this contact sticks not; found by sweeping directions
                return _dragged(A, c, contacts, given, kinds, i)
            loads[contact.row + 1 : contact.row + 1 + n] = -contact.friction * given[i] * d
    # what sticks under its given impulse: rows r_T = 0
    base = c + A @ loads
    if stuck:
        rows = [contacts[i].row + 1 + k for i in stuck for k in range(contacts[i].tangents)]
        # eliminate their tangential impulses from the problem of the others
        S = A[np.ix_(rows, rows)]
        K = A[:, rows] @ np.linalg.pinv(S, rcond=1e-12)
        A_left, base = A - K @ A[rows], base - K @ base[rows]
    else:
        A_left, K, rows = A, None, []
    for contact, (kind, _) in zip(contacts, kinds, strict=True):
        if kind == "held":
            trial.append(contact)
            plain = contact.tangents == 0 or contact.friction == 0
            one: list[tuple[str, Any]] = (
                [(SLIP, np.zeros(contact.tangents))]
                if plain
                else [(STICK, None), (SLIP, None)]
                if contact.tangents == 2
                else [(STICK, None), (SLIP, np.array([1.0])), (SLIP, np.array([-1.0]))]
            )
            modes.append(one)
    found = []
    for one in solutions(A_left, base, trial, list(itertools.product(*modes))):
        forces = one.forces + loads
        if rows:
            total = c + A @ forces
            forces[rows] = forces[rows] - np.linalg.pinv(A[np.ix_(rows, rows)], rcond=1e-12) @ total[rows]
        rates = c + A @ forces
        if _fits(contacts, given, kinds, forces, rates, A, c):
            found.append(Solution(tuple(kinds), forces, rates, one.residual, (), one.rank_lack))
    return found


def _dragged(
    A: Array, c: Array, contacts: Sequence[Touching], given: Array, kinds: Any, i: int
) -> list[Solution]:
    """Directions of slip of a contact in space whose normal impulse is given, by iteration to r_T = α d."""
    at = contacts[i].row + 1
    d = c[at : at + 2]
    if not np.linalg.norm(d) > 0:
        return []
    d = d / np.linalg.norm(d)
    for _ in range(200):
        trial = list(kinds)
        trial[i] = ("dragged", d)
        loads = np.zeros(len(c))
        loads[contacts[i].row] = given[i]
        loads[at : at + 2] = -contacts[i].friction * given[i] * d
        v = (c + A @ loads)[at : at + 2]
        length = float(np.linalg.norm(v))
        if not length > 0:
            return []
        change = float(np.abs(v / length - d).max())
        d = v / length
        if change < 1e-15:
            break
    trial = list(kinds)
    trial[i] = ("dragged", d)
    return _expansion(A, c, contacts, given, trial)


def _fits(
    contacts: Sequence[Touching], given: Array, kinds: Any, forces: Array, rates: Array, A: Array, c: Array
) -> bool:
    scale_f = max(float(np.abs(forces).max(initial=0)), 1e-300)
    scale_r = max(float(np.abs(c).max(initial=0)), float((np.abs(A) @ np.abs(forces)).max(initial=0)))
    for contact, p, (kind, d) in zip(contacts, given, kinds, strict=True):
        at, n = contact.row, contact.tangents
        T = float(np.linalg.norm(forces[at + 1 : at + 1 + n]))
        if kind != "held" and rates[at] < -1e-10 * scale_r:
            return False
        if kind == "held" and forces[at] < p - 1e-10 * scale_f:
            return False
        if n and kind in ("held", "stuck") and T > contact.friction * forces[at] + 1e-10 * scale_f:
            return False
        if kind == "dragged" and n and d is not None and d @ rates[at + 1 : at + 1 + n] < -1e-10 * scale_r:
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
        hit = impact(A, v, [contacts[i]], [restitution[i]], [laws[i]], responses)
        total, v = total + hit.impulses, hit.after
    names = ", ".join(f"'{c.name}'" for c in contacts)
    raise SimulationError(
        f"Impacts one after another at contacts {names} did not end after {_PASSES}: the fastest still approaches at "
        f"{-min(v[c.row] for c in contacts):.3g} m/s. Take impacts='simultaneous'."
    )


def _only(
    found: Sequence[Solution], responses: Array, contacts: Sequence[Touching], before: Array, what: str
) -> Solution:
    names = ", ".join(f"'{c.name}' ({before[c.row]:.6g} m/s)" for c in contacts)
    if not found:
        raise SimulationError(
            f"No impulses satisfy {what} with Coulomb friction at contacts {names} (approach speed along the normal)."
        )
    groups = distinct(found, responses)
    if len(groups) > 1:
        modes = "; ".join(
            ", ".join(f"{c.name}: {m[0]}" for c, m in zip(contacts, g[0].modes, strict=True)) for g in groups
        )
        raise SimulationError(
            f"{len(groups)} different outcomes satisfy {what} with Coulomb friction at contacts {names}: {modes}. "
            f"Rigid bodies do not decide between them; change the friction, or the law (impact='poisson')."
        )
    return min(groups[0], key=lambda one: (one.rank_lack, sum(m[0] == OPEN for m in one.modes)))


def _checked(
    A: Array, before: Array, impulses: Array, contacts: Sequence[Touching], law: str
) -> Impact:
    """ΔT = Λ·(v⁻ + v⁺)/2, which must not be positive."""
    after = A @ impulses + before
    energy = float(impulses @ (before + after)) / 2
    size = float(np.abs(impulses) @ (np.abs(before) + np.abs(after)))
    if energy > 1e-10 * size:
        names = ", ".join(f"'{c.name}'" for c in contacts)
        cure = "impact='poisson'" if law == "newton" else "a smaller restitution"
        raise SimulationError(
            f"The impact at contacts {names} would make energy, {energy:.6g} J: Newton's coefficient of restitution with "
            f"Coulomb friction can do that where the slip reverses (Kane, 1984). Give the contact {cure}."
        )
    return Impact(impulses, after, energy)
