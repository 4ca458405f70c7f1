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
from .complementarity import OPEN, SLIP, STICK, Array, Solution, Touching, distinct, newton, solutions

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
    size = float(np.abs(compressed.forces @ responses).max(initial=0))
    expanded = _only(found, responses, contacts, before, "the expansion", size)
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
    """Solutions in which each contact is held, or lets go and sticks ("stuck"), slips ("dragged") or is free."""
    held = [contact for contact, (kind, _) in zip(contacts, kinds, strict=True) if kind == "held"]
    modes: list[list[tuple[str, Any]]] = []
    for contact in held:
        if contact.tangents == 0 or contact.friction == 0:
            modes.append([(SLIP, np.zeros(contact.tangents))])
        elif contact.tangents == 2:
            modes.append([(STICK, None), (SLIP, None)])
        else:
            modes.append([(STICK, None), (SLIP, np.array([1.0])), (SLIP, np.array([-1.0]))])
    found = []
    for one in itertools.product(*modes):
        found += _expanded(A, c, contacts, given, kinds, held, one)
    return found


def _expanded(
    A: Array, c: Array, contacts: Sequence[Touching], given: Array, kinds: Sequence[tuple[str, Any]],
    held: Sequence[Touching], modes: Sequence[tuple[str, Any]],
) -> list[Solution]:  # fmt: skip
    stuck = [c_ for c_, (kind, _) in zip(contacts, kinds, strict=True) if kind == "stuck"]
    rows = [one.row + 1 + k for one in stuck for k in range(one.tangents)]
    inverse = np.linalg.pinv(A[np.ix_(rows, rows)], rcond=1e-12) if rows else np.zeros((0, 0))
    # with the tangential impulses of what sticks eliminated, r_T = 0 there
    left = A - A[:, rows] @ inverse @ A[rows] if rows else A
    sought = [i for i, (kind, d) in enumerate(kinds) if kind == "dragged" and d is None]

    def moved(angles: Array) -> tuple[Array, Array, Solution] | None:
        """Forces and rates for given directions of slip of those that let go in space."""
        loads = np.zeros(len(c))
        for i, (contact, (kind, d)) in enumerate(zip(contacts, kinds, strict=True)):
            if kind in ("free", "dragged", "stuck"):
                loads[contact.row] = given[i]
            if kind == "dragged":
                if i in sought:
                    angle = angles[sought.index(i)]
                    d = np.array([np.cos(angle), np.sin(angle)])
                loads[contact.row + 1 : contact.row + 1 + contact.tangents] = -contact.friction * given[i] * d
        base = c + A @ loads
        base = base - A[:, rows] @ inverse @ base[rows] if rows else base
        solved = solutions(left, base, held, [tuple(modes)])
        if not solved:
            return None
        forces = solved[0].forces + loads
        if rows:
            forces[rows] -= inverse @ (c + A @ forces)[rows]
        return forces, c + A @ forces, solved[0]

    def across(angles: Array) -> Array | None:
        one = moved(angles)
        if one is None:
            return None
        at = [contacts[i].row for i in sought]
        return np.array(
            [one[1][k + 2] * np.cos(x) - one[1][k + 1] * np.sin(x) for k, x in zip(at, angles, strict=True)]
        )

    results: list[Solution] = []
    first = np.array([np.arctan2(c[contacts[i].row + 2], c[contacts[i].row + 1]) for i in sought])
    for shifts in itertools.product(range(4), repeat=len(sought)):
        angles = newton(across, first + np.pi / 2 * np.array(shifts)) if sought else first
        one = None if angles is None else moved(angles)
        if one is None or angles is None:
            continue
        forces, rates, solved = one
        turned = list(kinds)
        for i, angle in zip(sought, angles, strict=True):
            turned[i] = ("dragged", np.array([np.cos(angle), np.sin(angle)]))
        if _fits(contacts, given, turned, forces, rates, A, c):
            results.append(Solution(tuple(turned), forces, rates, solved.residual, (), solved.rank_lack))
            if not sought or len(contacts) > 1:  # of one contact all directions are looked for
                break
        if not sought:
            break
    return results


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
        if n and kind in ("held", "stuck") and contact.friction * forces[at] + 1e-10 * scale_f < T:
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
    found: Sequence[Solution],
    responses: Array,
    contacts: Sequence[Touching],
    before: Array,
    what: str,
    size: float = 0.0,
) -> Solution:
    names = ", ".join(f"'{c.name}' ({before[c.row]:.6g} m/s)" for c in contacts)
    if not found:
        raise SimulationError(
            f"No impulses satisfy {what} with Coulomb friction at contacts {names} (approach speed along the normal)."
        )
    groups = distinct(found, responses, size)
    if len(groups) > 1:
        modes = "; ".join(
            ", ".join(f"{c.name}: {m[0]}" for c, m in zip(contacts, g[0].modes, strict=True)) for g in groups
        )
        raise SimulationError(
            f"{len(groups)} different outcomes satisfy {what} with Coulomb friction at contacts {names}: {modes}. "
            f"Rigid bodies do not decide between them; change the friction, or the law (impact='poisson')."
        )
    return min(groups[0], key=lambda one: (one.rank_lack, sum(m[0] == OPEN for m in one.modes)))


def _checked(A: Array, before: Array, impulses: Array, contacts: Sequence[Touching], law: str) -> Impact:
    """ΔT = Λ·(v⁻ + v⁺)/2, which must not be positive."""
    after = A @ impulses + before
    energy = float(impulses @ (before + after)) / 2
    size = float(np.abs(impulses) @ (np.abs(before) + np.abs(after)))
    if energy > 1e-10 * size:
        names = ", ".join(f"'{c.name}'" for c in contacts)
        cure = "impact='poisson'" if law == "newton" else "a smaller restitution"
        raise SimulationError(
            f"The impact at contacts {names} would make energy, {energy:.6g} J: Newton's coefficient of restitution "
            f"with Coulomb friction can do that where the slip reverses (Kane, 1984). Give the contact {cure}."
        )
    return Impact(impulses, after, energy)
