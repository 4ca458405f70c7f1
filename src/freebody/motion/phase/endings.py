"""The functions that end a phase of contacts as they fall through zero, in compiled code."""

from __future__ import annotations

from ...native.instructions import Reals, compiled, greater, lesser
from . import laws
from .bearings import solve
from .closed_contacts import gamma_of
from .contact_outputs import (
    adhesion_of,
    force_of,
    gaps_found,
    given_force_of,
    open_touched,
    product,
    rates_of,
    static_friction_of,
)
from .phase_record import PhaseData


@compiled
def parts_of_forces(phase: PhaseData) -> float:
    """Return the sum of the parts of the forces of all closed contacts, each as if it were the only condition:

    λ_i = -(γ_i + Σ_j w_j f_j)/(G M⁻¹ Gᵀ)_ii,      of which |γ_i| and all |w_j f_j| are summed
    """
    z, total = phase.free, 0.0
    for a in range(phase.own, phase.active):
        i = phase.independent[a]
        G, size = phase.G[i], abs(gamma_of(phase, i))
        for k in range(phase.n):
            size += abs(G[k] * z[k])
        total += size / product(G, G, phase.n)
    return total


@compiled
def ending(phase: PhaseData, i: int, size: float) -> float:
    """Return the function of an ending; ``size`` is the round-off of forces."""
    k, law, sign = phase.owner[i], phase.law[i], phase.sign[i]
    seen, v, F = phase.gaps[phase.gap_at[k] :], rates_of(phase, k), force_of(phase, k)
    if law == laws.NEVER:
        return 1.0
    if law == laws.GAP:
        return seen[0] - phase.band[k]
    if law == laws.PRESS:  # inside, after its law would have pulled: as it presses again
        return greater(seen[0] - phase.band[k], -given_force_of(phase, k))
    if law == laws.RELEASE:
        return lesser(-seen[0], given_force_of(phase, k))
    if law == laws.NORMAL:
        return F[0] + adhesion_of(phase, k) + size
    if law == laws.REACH:
        return seen[1 + phase.place[i]]
    if law == laws.SIDE:
        return -seen[1 + phase.place[i]]
    if law == laws.LINE_STOP:
        return sign * v[1]
    if law == laws.STOP:
        return v[1] * v[1] + v[2] * v[2] - laws.STOPPED_SQUARE
    if law == laws.YIELD:
        return laws.YIELDED_SQUARE - v[1] * v[1] - v[2] * v[2]
    mu = static_friction_of(phase, k)
    most = mu * (F[0] + adhesion_of(phase, k)) + (1.0 + mu) * size
    if law == laws.CONE:
        return most * most - F[1] * F[1] - F[2] * F[2]
    return most - sign * F[1]


@compiled
def watched(t: float, y: Reals, c: Reals, out: Reals) -> None:
    """Set ``out`` to the functions of the user, then to the functions that end the phase as they fall through zero."""
    phase, size = PhaseData(c), 0.0
    if phase.expressions > 0:
        phase.values(t, y, phase.values_c, out)
    if phase.conditions > phase.own or phase.held_count > 0:
        solve(t, y, phase)
        size = laws.ROUNDED * parts_of_forces(phase)
    gaps_found(t, y, phase)
    if phase.compliant_count > 0:
        open_touched(t, y, phase)
    for i in range(phase.endings):
        out[phase.expressions + i] = ending(phase, i, size)
