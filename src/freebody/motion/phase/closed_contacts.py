"""The motion of a machine whose contacts are in given modes, in compiled code: modes are data.

Closed contacts are conditions beside those of the machine itself, all with rows G, and forces λ along rows K:

    M u' = f + Kᵀ λ,   G u' = -γ      =>      (G M⁻¹ Kᵀ) λ = -γ - G M⁻¹ f

    stick     rows of N, T             K = G
    slip      row of N                 K = W_N - μ d W_T,   d the direction of slip;  μ = 0: K = G
    rolls     row of N, those of T     K = W_N - δ d W_M    of the normal, beside its friction

Only independent conditions (active ones) are imposed. The forces of the others are those of contacts of equal
compliance, in the range of the rows. With S = G M⁻¹ Kᵀ and Q = G M⁻¹ Gᵀ over active and all conditions,

    slip      λ = Qᵀ ν,   S Qᵀ ν = r           no slip    λ = W Qᵀ ν,   Q W Qᵀ ν = r,   r = -γ - G M⁻¹ f

where W = 1 gives the normal forces, and then W = N of the same contact for friction, and the mean of all N for the
others: Σ N²/mean(N) + Σ |T|²/N is least, in which friction is shared in proportion to N. All W are forces, so that the
units do not matter where normals are not parallel. A moment M that resists rolling counts as the force M/δ, so that its
W is δ² times that. Each island has its own W: W = 1 remains where one of its contacts pulls or slips. An island whose
conditions are independent has λ = S⁻¹ r.

All is in `PhaseData`. A new set of modes is other integers there for the same code.

With M = L D Lᵀ, every row stands as D^-½ L⁻¹ Gᵀ, so that G M⁻¹ Kᵀ are products of rows.
"""

from __future__ import annotations

from ...native.instructions import Reals, compiled
from . import laws
from .conditions import (
    NAN,
    add_in,
    between,
    force_row,
    gamma_of,
    independent,
    loads_made,
    rows_made,
    set_share,
)
from .contact_outputs import (
    adhesion_of,
    force_of,
    forwarded,
    given_force_of,
    moved,
    row_taken,
    static_friction_of,
)
from .equal_shares import shared
from .phase_record import PhaseData


@compiled
def push(phase: PhaseData, z: Reals) -> None:
    """Set the normal forces that the state gives, and the friction of those contacts that slip; add them to z.

    The pull -A of a rigid contact that adheres is added, too: λ = N + A is what its condition gives, and its cone has.
    """
    for closed in range(phase.closed_count):
        k = phase.closed[closed]
        presser = phase.presser[k]
        if presser >= 0 and phase.held[presser] == 0:
            continue  # it is found with its normal force
        if phase.held[k] != 0:
            F = force_of(phase, k)
            F[0] = given_force_of(phase, k) if presser < 0 else force_of(phase, presser)[0]
            if phase.compliant[k] != 0:
                push_along(phase, z, phase.first[k], F[0])
            if phase.pushed[k] != laws.NO_SLIP:
                set_share(phase, k, phase.pushed[k])
                for j in range(phase.tangents[k]):
                    F[1 + j] = F[0] * phase.share[k, j]
                    push_along(phase, z, phase.first[k] + 1 + j, F[1 + j])
        elif phase.adhesive_count > 0:
            push_along(phase, z, phase.first[k], -adhesion_of(phase, k))


@compiled
def push_along(phase: PhaseData, z: Reals, r: int, force: float) -> None:
    """Add a force along a row of the contacts to z."""
    spare = phase.spare
    row_taken(phase, r, spare)
    forwarded(phase, spare, 0, phase.n)
    for i in range(phase.n):
        z[i] += force * spare[i]


@compiled
def balance(phase: PhaseData) -> int:
    """Set accelerations, contact forces and multipliers; return 0 if a condition has lost its independence, else 1."""
    n, count, w, z = phase.n, phase.conditions, phase.step, phase.free
    if phase.held_count + phase.adhesive_count > 0:
        push(phase, z)
    rows_made(phase)
    if phase.slipping != 0:
        loads_made(phase)
    for p in range(n):
        w[p] = z[p]
    for i in range(count):
        phase.right[i] = -(gamma_of(phase, i) + between(phase.G[i], w, phase.low[i], phase.high[i], n))
    good = 1
    if count > phase.active:
        good = shared(phase)
    elif count > 0:
        good = independent(phase, phase.independent, count, phase.slipping)
    for i in range(count):
        x, K, k = phase.lam[i], force_row(phase, i), phase.source[i]
        add_in(phase, i, x, K)
        if k < 0:
            phase.multiplier[phase.number[-1 - k]] = x
        else:
            F = force_of(phase, k)
            F[phase.row_of[i]] = x
            if phase.row_of[i] == 0:
                rub(phase, k, phase.slip[i], x)
                F[0] = x - adhesion_of(phase, k)
                r = k + 1
                while r < phase.contacts and phase.presser[r] == k:
                    rub(phase, r, phase.pushed[r], x)
                    force_of(phase, r)[0] = x
                    r += 1
    moved(phase, w, phase.udot)
    # what sticks without load needs no friction, and has none below 0
    for closed in range(phase.closed_count):
        if static_friction_of(phase, phase.closed[closed]) < 0.0:
            phase.udot[0] = NAN
    return good


@compiled
def rub(phase: PhaseData, k: int, slip: int, normal: float) -> None:
    """Set the friction, or the moments, of a contact that slips, rolls or spins."""
    if slip != laws.NO_SLIP:
        F = force_of(phase, k)
        for j in range(phase.tangents[k]):
            F[1 + j] = normal * phase.share[k, j]
