"""The functions that end a phase of contacts as they fall through zero, in compiled code."""

from __future__ import annotations

from ...native.instructions import Reals, compiled, greater, lesser, root
from ..kernels import contact_quantities as quantities
from ..kernels.switching import gauge
from . import laws
from .bearings import solve_once
from .conditions import gamma_of
from .contact_outputs import (
    adhesion_of,
    force_of,
    friction,
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
    for a in range(phase.active):
        i = phase.independent[a]
        if phase.source[i] < 0:
            continue
        G, size = phase.G[i], abs(gamma_of(phase, i))
        low, high = phase.low[i], phase.high[i]
        for k in range(low, high):
            size += abs(G[k] * z[k])
        total += size / product(G[low:], G[low:], high - low)
    return total


@compiled
def ending(phase: PhaseData, i: int, size: float) -> float:
    """Return the function of an ending that may come; ``size`` is the round-off of forces."""
    k, law, sign = phase.owner[i], phase.law[i], phase.sign[i]
    seen = phase.gaps[phase.gap_at[k] :]
    if law == laws.GAP:  # a disk that lies flat stands on other points than the lowest
        apart = seen[0] - phase.band[k]
        return greater(apart, -seen[1]) if phase.reaches[k] == 1 else apart
    v, F = rates_of(phase, k), force_of(phase, k)
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
        return v[1] * v[1] + v[2] * v[2] - phase.stopped * phase.stopped
    if law == laws.YIELD:
        return laws.YIELDED_SQUARE - v[1] * v[1] - v[2] * v[2]
    mu = static_friction_of(phase, k)
    most = mu * (F[0] + adhesion_of(phase, k)) + (1.0 + mu) * size
    if law == laws.CONE:
        return most * most - F[1] * F[1] - F[2] * F[2]
    return most - sign * F[1]


@compiled
def quantity(phase: PhaseData, k: int, what: int, j: int, size: float) -> float:
    """Return a quantity of a contact for the user: the functions of endings where these are functions of it."""
    mode, v, F = phase.mode[k], rates_of(phase, k), force_of(phase, k)
    shut = phase.compliant[k] == 0 and (mode != laws.OPEN or phase.dead[k] != 0)
    if shut and (what == quantities.GAP or what == quantities.APPROACH):
        return 0.0
    if what == quantities.GAP:
        gap = phase.gaps[phase.gap_at[k]]
        if phase.compliant[k] == 0:
            gap -= phase.band[k]
        return 0.0 if abs(gap) <= phase.near else gap
    if what == quantities.APPROACH:
        return -v[0]
    if what == quantities.SLIP:
        return 0.0 if mode == laws.STICK or mode == laws.LIMIT else v[1 + j]
    if mode == laws.OPEN:
        return 0.0
    if phase.held[k] != 0:
        size = 0.0
    if what == quantities.NORMAL:
        return F[0] + size
    if what == quantities.TANGENTIAL:
        return F[1 + j]
    mu, load = static_friction_of(phase, k), F[0] + adhesion_of(phase, k)
    if mode == laws.STICK:
        square = 0.0
        for i in range(phase.tangents[k]):
            square += F[1 + i] * F[1 + i]
        return mu * load + (1.0 + mu) * size - root(square)
    return 0.0 if mode == laws.LIMIT else (mu - friction(phase, k)) * load


@compiled
def inputs_found(y: Reals, phase: PhaseData, size: float) -> None:
    """Set the quantities of contacts that the functions of the user take, after the state."""
    n = phase.n_q + phase.n
    for i in range(n):
        phase.inputs[i] = y[i]
    for a in range(phase.asked):
        phase.inputs[n + phase.into[a]] = 0.0
    for a in range(phase.asked):
        k, what, j = phase.of_contact[a], phase.what[a], phase.component[a]
        phase.inputs[n + phase.into[a]] += quantity(phase, k, what, j, size)


@compiled
def watched(t: float, y: Reals, c: Reals, out: Reals) -> None:
    """Set ``out`` to the functions of the user, then to those that end the phase as they fall through zero.

    These are those of laws that switch, of patches, and of contacts.
    """
    phase, size = PhaseData(c), 0.0
    if phase.expressions > 0 and phase.asked == 0:
        phase.values(t, y, phase.values_c, out)
    if phase.conditions > phase.own or phase.held_count > 0:
        solve_once(t, y, phase)
        size = laws.ROUNDED * parts_of_forces(phase)
    gaps_found(t, y, phase)
    if phase.compliant_count > 0 or phase.asked > 0:
        open_touched(t, y, phase)
    if phase.asked > 0:
        inputs_found(y, phase, size)
        if phase.expressions > 0:
            phase.values(t, phase.inputs, phase.values_c, out)
    for k in range(phase.laws if phase.expressions > 0 else 0):
        i = phase.first_law + k
        out[i] = 1.0 if phase.idle[k] != 0 else gauge(phase.sides[k], out[i], phase.bands[k])
    for i in range(phase.endings):
        out[phase.expressions + i] = 1.0 if phase.law[i] == laws.NEVER else ending(phase, i, size)
