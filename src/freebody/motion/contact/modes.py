"""Modes of closed contacts just after an event, from the complementarity problem of their accelerations.

If a law holds with equality (N = 0, |T| = μ_s N, a slip about to begin), the derivatives of the accelerations and
forces along the motion of each candidate decide. These derivatives are exact, computed from the trace.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...errors import SimulationError
from ..phase.places import ROUNDED
from ..phase.scene import KINDS, SMOOTH, Modes, Snapshot
from .complementarity import (
    OPEN,
    SLIP,
    SMALL,
    STICK,
    Array,
    Solution,
    Touching,
    dependent_normals,
    distinct,
    of_equal_compliance,
    painleve,
    solutions,
)
from .slopes import slopes
from .state import ContactRun


def modes_at(work: ContactRun) -> tuple[Modes, Solution | None]:
    """Return modes and forces of the chosen contacts at the present moment, in which no contact approaches.

    Raises
    ------
    SimulationError
        If no set of modes is consistent, or several sets with different motions are (Painlevé).
    """
    it, seen, chosen = work.it, work.seen(), work.chosen()
    t, y = it.t, np.array(it.y)
    if not chosen:
        return (OPEN,) * len(work.names), None
    A, rows, responses, contacts = work.part(seen, chosen, y)
    found = solutions(A, seen.c[rows], contacts)
    kept = [one for one in found if lasts(work, t, y, seen, chosen, contacts, one)]
    if not kept:  # at the limit of friction, but held by the others: the slip never begins
        kept = [one for one in found if lasts(work, t, y, seen, chosen, contacts, one, True)]
    kept = _held(kept, contacts)
    alike = work.alike(contacts, seen, chosen, y)
    groups = distinct(kept, responses, alike=alike)
    if len(groups) > 1:  # inequalities violated by round-off, which large friction amplifies
        groups = distinct([one for one in kept if one.missed <= ROUNDED], responses, alike=alike) or groups
    if len(groups) > 1 and work.shared and dependent_normals(A, contacts):
        kept = of_equal_compliance(A, seen.c[rows], contacts)
        kept = [one for one in kept if lasts(work, t, y, seen, chosen, contacts, one)] or kept
        groups = [kept] if kept else []
    if len(groups) != 1 and all(smooth(one) or one.held for one in contacts):
        # without Coulomb's friction the problem is convex: it has one motion, which ties within round-off hide
        kept = of_equal_compliance(A, seen.c[rows], contacts)
        groups = [kept[:1]] if kept else []
    if len(groups) != 1:
        raise paradox(work, t, y, contacts, A, groups or distinct(found, responses), bool(groups))
    current = [KINDS[mode] for mode in it.before]

    def worth(one: Solution) -> tuple[Any, ...]:
        modes = named(work, chosen, contacts, one)
        same = sum(modes[k] == current[k] for k in range(len(current)))
        sticking = sum(mode == STICK for mode, _ in one.modes)
        # if a slip in space is about to begin, prefer the most contacts that take part
        begins = any(law == "onset" and contacts[i].tangents == 2 for i, law in one.ties)
        pressing = sum(m != OPEN and (i, "normal") not in one.ties for i, (m, _) in enumerate(one.modes))
        return (not begins, -sticking if begins else sticking, pressing, same, -one.rank_lack)

    best = max(groups[0], key=worth)
    return named(work, chosen, contacts, best), best


def named(work: ContactRun, chosen: Sequence[int], contacts: Sequence[Touching], one: Solution) -> Modes:
    """Return the modes of all contacts for a solution of the chosen contacts."""
    modes = [OPEN] * len(work.names)
    for k, contact, (mode, d) in zip(chosen, contacts, one.modes, strict=True):
        rough = not work.model.contacts[k].frictionless
        if mode == SLIP and rough and smooth(contact):
            modes[k] = SMOOTH
        elif mode == SLIP and contact.tangents == 1 and rough:
            modes[k] = "slip-" if d[0] < 0 else "slip+"
        else:
            modes[k] = mode
    return tuple(modes)


def smooth(contact: Touching) -> bool:
    """Return True if the contact has no friction."""
    return contact.tangents == 0 or contact.friction == contact.static == 0


def lasts(
    work: ContactRun,
    t: float,
    y: Array,
    seen: Snapshot,
    chosen: Sequence[int],
    contacts: Sequence[Touching],
    one: Solution,
    limits: bool = False,
) -> bool:
    """Return True if the laws that hold with equality continue to hold, by the derivatives along this motion."""
    if not one.ties:
        return True
    if any(
        mode == SLIP and c.tangents == 2 and c.sliding is None and not smooth(c)
        for c, (mode, _) in zip(contacts, one.modes, strict=True)
    ):
        return True  # in space, slip from rest has no derivative before it has a direction
    a, force = slopes(work, t, y, seen, chosen, contacts, one)
    still = work.still(y)  # at speeds below this everything is constant: any change is round-off
    least_a = max(SMALL * float(np.abs(a).max(initial=0)), still * float(np.abs(seen.c).max(initial=0)))
    least_f = max(
        SMALL * float(np.abs(force).max(initial=0)), still * float(np.abs(one.forces).max(initial=0))
    )
    for i, law in one.ties:
        at, n = contacts[i].row, contacts[i].tangents
        N, T = force[at], force[at + 1 : at + 1 + n]
        if law == "open" and a[at] < -least_a:
            return False
        if law == "normal" and -least_f > N:
            return False
        if law == "cone":
            hold = one.forces[at + 1 : at + 1 + n]
            length = float(np.linalg.norm(hold))
            way = hold / length if length > 0 else None
            growth = float(np.linalg.norm(T)) if way is None else float(way @ T)
            if contacts[i].static * N - growth < -least_f:
                return False
        if law == "onset":
            d = one.modes[i][1]
            growth = float(d @ a[at + 1 : at + 1 + n])
            if growth < -least_a or (growth <= least_a and not limits):
                return False
    return True


def paradox(
    work: ContactRun,
    t: float,
    y: Array,
    contacts: Sequence[Touching],
    A: Array,
    groups: Any,
    several: bool,
) -> SimulationError:
    """Return the error for a state with several consistent motions, or with none."""
    names = (*work.model.coordinate_names, *work.model.speed_names)
    where = ", ".join(f"{n} = {x:.6g}" for n, x in zip(names, y.tolist(), strict=False))
    criteria = ", ".join(f"{c.name}: A_NN - mu d.A_NT = {painleve(A, c):.6g} 1/kg" for c in contacts)
    if several and dependent_normals(A, contacts):
        closed = ", ".join(f"'{c.name}'" for c in contacts)
        return SimulationError(
            f"The normal forces of contacts {closed} of '{work.model.name}' at t = {t:.9g} s are statically "
            f"indeterminate, and each distribution moves the machine differently through its friction. Rest the body "
            f"on fewer contacts (three in space, two in a plane), or take indeterminate='compliance', which "
            f"decides for the limit of equal compliance at all contacts."
        )
    if several:
        sets = " or ".join(
            "(" + ", ".join(f"{c.name}: {m[0]}" for c, m in zip(contacts, g[0].modes, strict=True)) + ")"
            for g in groups
        )
        what = f"{len(groups)} different motions are consistent, {sets}"
    else:
        what = "no set of modes is consistent"
    return SimulationError(
        f"Contacts of '{work.model.name}' at t = {t:.9g} s: {what}. Rigid bodies with Coulomb friction do not "
        f"decide what happens there (Painlevé); the criterion is the normal acceleration per unit of normal force, "
        f"which must be positive: {criteria}. Configuration: {where}. Less friction, or another direction of slip, has "
        f"one motion."
    )


def _held(found: list[Solution], contacts: Sequence[Touching]) -> list[Solution]:
    """Drop slips that begin although static friction, greater than kinetic, can hold with the other modes unchanged."""
    result = []
    for one in found:
        begun = [
            i
            for i, (mode, _) in enumerate(one.modes)
            if mode == SLIP and contacts[i].sliding is None and contacts[i].static > contacts[i].friction
        ]
        if begun and any(
            all(other.modes[i][0] == STICK for i in begun)
            and all(other.modes[i][0] == one.modes[i][0] for i in range(len(contacts)) if i not in begun)
            for other in found
        ):
            continue
        result.append(one)
    return result
