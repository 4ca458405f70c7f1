"""Impacts: jumps of the speeds at closed contacts, as contact problems of impulses (`cone_problem`).

    v⁺ = A Λ + v⁻,     A = W M⁻¹ Wᵀ

    Newton     0 <= Λ_N  ⟂  v_N⁺ + e v_N⁻ >= 0          -Λ_T in μ Λ_N Sgn(v_T⁺)
    Poisson    compression: the same with e = 0, impulse Λ_C;
               expansion:   0 <= Λ_E - e Λ_C  ⟂  v_N⁺ >= 0,  -Λ_TE in μ Λ_NE Sgn(v_T⁺)

Either all closed contacts take part at once, including contacts at rest ("simultaneous"), or the contacts collide one
after another, always the fastest approaching contact first ("sequential"). These are two different assumptions; the
rigid-body model does not decide between them.

Newton's law with friction can raise the kinetic energy if the slip reverses (Kane), Poisson's with several contacts
(Glocker), and a wedged body has no rebound at all. The restitution of that impact is then halved until impulses exist
and the energy falls, at last to zero: with e = 0 and no moving surface, ΔT = -Σ μ Λ_N |v_T⁺| - Λ A Λ/2 <= 0.

Sources: J. J. Moreau (1988); C. Glocker, F. Pfeiffer (1996), chapter 8; T. R. Kane, Stanford Mechanics Alumni Club
Newsletter (1984); C. Glocker, Energetic consistency conditions for standard impacts, Multibody System Dynamics (2013).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...errors import SimulationError
from ..cones.collision import compiled_code
from ..cones.contacts import EXACT, Touching, contacts_of
from .complementarity import SMALL, Array

ALIKE = 1e-8
"""Relative difference up to which two outcomes count as the same."""
ORDERS = ("simultaneous", "sequential")
_PASSES = 100_000


@dataclass(frozen=True)
class Impact:
    """The result of an impact.

    Attributes
    ----------
    impulses, after : array (m,)
        Impulses Λ, and speeds of the contacts after the impact.
    energy : float
        Change of the kinetic energy [J].
    part : float
        Part of the restitution that acts; below 1 where the whole would raise the energy or has no solution.
    residual : float
        Greatest violation of the laws, relative to the greatest speed.
    certain : bool
        True if A is regular, so that the motion determines every impulse.
    """

    impulses: Array
    after: Array
    energy: float
    part: float = 1.0
    residual: float = 0.0
    certain: bool = False


def impact(
    A: Array,
    before: Array,
    contacts: Sequence[Touching],
    restitution: Sequence[float],
    laws: Sequence[str],
    order: str = "simultaneous",
    still: float = 0.0,
) -> Impact:
    """Return the impulses of an impact; indeterminate ones are the limit of equal compliance at all contacts.

    Parameters
    ----------
    A                  contact speeds per unit impulse
    before             speeds of the contacts just before the impact
    restitution, laws  e and "newton" or "poisson" for each contact
    still              speed up to which a contact counts as at rest

    Raises
    ------
    SimulationError
        If contacts of both laws collide at once, or if no impulses are found.
    """
    if order == "sequential":
        return _one_by_one(A, before, contacts, restitution, laws, still)
    approaching = np.array([before[c.row] < -still for c in contacts])
    kinds = {law for law, moving in zip(laws, approaching, strict=True) if moving}
    if len(kinds) > 1:
        raise SimulationError(
            "Contacts "
            + ", ".join(f"'{c.name}'" for c in contacts)
            + " collide at once, some by Newton's and some by Poisson's law. Give them the same law: "
            "impact='newton' or 'poisson'."
        )
    it = contacts_of(A, before, contacts, impact=True)
    it.still, it.poisson, it.restitution[:] = still, int(kinds == {"poisson"}), restitution
    compiled_code()["collided"](it)
    residual = it.residual
    if not residual <= EXACT:
        names = ", ".join(f"'{c.name}' ({before[c.row]:.6g} m/s)" for c in contacts)
        raise SimulationError(
            f"No impulses were found that satisfy Coulomb friction at contacts {names} (approach speed along the "
            f"normal), even without restitution: a law is still violated by {residual:.3g} of the greatest speed. Less "
            f"friction, or impacts='sequential', makes the problem easier."
        )
    certain = it.directions == it.rows
    return Impact(
        it.forces[: it.rows].copy(), it.after[: it.rows].copy(), it.energy, it.part, residual, certain
    )


def undetermined(
    A: Array, contacts: Sequence[Touching], impulses: Array, after: Array, responses: Array
) -> bool:
    """Return True if impulses of the same modes distributed otherwise would change the motion."""
    rows: list[int] = []
    columns: list[Array] = []
    unit = np.eye(len(A))
    small = ALIKE * float(np.abs(impulses).max(initial=0))
    for one in contacts:
        at, n = one.row, one.tangents
        if impulses[at] <= small:
            continue
        T, column = impulses[at + 1 : at + 1 + n], unit[at].copy()
        rows.append(at)
        v = after[at + 1 : at + 1 + n]
        if one.friction > 0 and np.linalg.norm(v) > ALIKE * float(np.abs(after).max(initial=0)):
            column[at + 1 : at + 1 + n] = T / impulses[at]
            columns.append(column)
        else:
            rows += range(at + 1, at + 1 + (n if one.friction > 0 else 0))
            columns += [column, *unit[at + 1 : at + 1 + (n if one.friction > 0 else 0)]]
    if not rows:
        return False
    B = np.array(columns)
    _, sizes, right = np.linalg.svd(A[rows] @ B.T)
    loose = right[int((sizes > SMALL * sizes[0]).sum()) :]
    moved = B @ responses
    return bool(np.abs(loose @ moved).max(initial=0) > ALIKE * np.abs(moved).max())


def _one_by_one(
    A: Array, before: Array, contacts: Sequence[Touching], restitution: Sequence[float], laws: Sequence[str],
    still: float,
) -> Impact:  # fmt: skip
    v, total = before.copy(), np.zeros(len(before))
    size = max(float(np.abs(before).max(initial=0)), still)
    part, residual, energy = 1.0, 0.0, 0.0
    for _ in range(_PASSES):
        speeds = [v[c.row] for c in contacts]
        i = int(np.argmin(speeds))
        if speeds[i] >= -max(still, 1e-13 * size):
            return Impact(total, v, energy, part, residual)
        hit = impact(A, v, [contacts[i]], [restitution[i]], [laws[i]], still=still)
        total, v, energy = total + hit.impulses, hit.after, energy + hit.energy
        part, residual = min(part, hit.part), max(residual, hit.residual)
    names = ", ".join(f"'{c.name}'" for c in contacts)
    raise SimulationError(
        f"The sequence of impacts at contacts {names} did not end after {_PASSES} impacts: the fastest contact still "
        f"approaches at {-min(v[c.row] for c in contacts):.3g} m/s. Use impacts='simultaneous'."
    )
