"""Derivatives of a phase of contacts along a direction, in compiled code: those of its rates and of its forces.

With u' and λ at the state, and d(...) the derivative along the direction (s, τ, dp) at fixed u' and λ,

    M du' = -d(M u' + h - Q) + Σ λ dG + N W_T d(-μ d) + Kᵀ dλ,      G du' = -d(G u' + γ)

and dN W_N + d(-μ N d) W_T for a normal force N that the state gives (compliant contacts, friction of joints). With an
adhesion A it is N + A that the conditions give and that friction has, and -dA W_N is a load. Resistance to rolling and
spinning has N + A of its contact.

These are the equations of the phase (`closed_contacts`) with other right-hand sides: one solution of them more for each
direction, with the same factors. Dependent conditions follow from the independent ones as long as the direction keeps
to all of them. Where they share their forces, λ = W G w with M w = G_aᵀ ν over independent rows, and

    dλ = dW G w + W (dG w + G dw),      M dw = -dM w + dG_aᵀ ν + G_aᵀ dν

with W = 1, and then, if nothing slips, W = N of these first forces for friction (`closed_contacts`).

The load P = r (|F_a| + |F_b|) of a joint depends on the accelerations and forces that it changes: dP = a + J dP.

Source: E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I (1993), section I.14.
"""

from __future__ import annotations

from ...native.instructions import Reals, compiled, greater, root
from ..cones.elimination import solved
from . import laws
from .bearings import loads_along, solve
from .conditions import NAN, condition_force, force_row, independent
from .contact_outputs import (
    adhesion_of,
    bias_along,
    condition_change,
    condition_load,
    direct,
    force_of,
    forwarded,
    friction,
    load_along,
    moved,
    open_touched,
    product,
    rates_of,
    row_taken,
    static_friction_of,
    touch_along,
)
from .equal_shares import first_shares, mean_normal, product_of_shares, set_weights, unit, weighted
from .phase_kernels import rates
from .phase_record import PhaseData
from .slopes_record import PhaseSlopes


@compiled
def turned(it: PhaseSlopes, phase: PhaseData, k: int, slip: int, j: int) -> float:
    """Return the derivative of the friction of a slip along tangent j, per unit of normal force."""
    change, mu = it.touch[phase.laws_at[k]], friction(phase, k)
    if slip == laws.PLUS:
        return -change
    if slip == laws.MINUS:
        return change
    v, dv = rates_of(phase, k), it.touch[phase.rates_at[k] :]
    speed = root(v[1] * v[1] + v[2] * v[2])
    along = (v[1] * dv[1] + v[2] * dv[2]) / speed
    return -change * v[1 + j] / speed - mu * (dv[1 + j] - v[1 + j] / speed * along) / speed


@compiled
def turn_friction(it: PhaseSlopes, phase: PhaseData) -> None:
    """Add (N + A) W_T d(-μ d) of all contacts that slip to z."""
    spare = phase.spare
    for i in range(phase.conditions):
        if phase.slip[i] != laws.NO_SLIP:
            k = phase.source[i]
            N = force_of(phase, k)[0] + adhesion_of(phase, k)
            for j in range(phase.tangents[k]):
                row_taken(phase, phase.first[k] + 1 + j, spare)
                change = N * turned(it, phase, k, phase.slip[i], j)
                for p in range(it.n):
                    it.z[p] += change * spare[p]


@compiled
def given_change(it: PhaseSlopes, phase: PhaseData, k: int) -> float:
    """Return the derivative of the normal force that the state gives a contact, or its presser; 0 of a rigid one."""
    presser = phase.presser[k]
    if presser < 0:
        return it.touch[phase.laws_at[k] + 4] + it.pressure[k]
    return it.touch[phase.laws_at[presser] + 4] if phase.held[presser] != 0 else 0.0


@compiled
def push_along(it: PhaseSlopes, phase: PhaseData) -> None:
    """Set the derivatives of the normal forces that the state gives, and of friction by these; add their loads to z.

    Adhesions are such loads, too, and moments that resist rolling and spinning turn, whatever presses them.
    """
    spare = phase.spare
    for i in range(phase.closed_count):
        k = phase.closed[i]
        if phase.held[k] != 0:
            N, change, at, slip = (
                force_of(phase, k)[0],
                given_change(it, phase, k),
                phase.first[k],
                phase.pushed[k],
            )
            it.force[at] = change
            for j in range(phase.tangents[k] if slip != laws.NO_SLIP else 0):
                it.force[at + 1 + j] = change * phase.share[k, j] + N * turned(it, phase, k, slip, j)
            for j in range(1 + phase.tangents[k]):
                row_taken(phase, at + j, spare)
                for p in range(it.n):
                    it.z[p] += it.force[at + j] * spare[p]
        elif phase.adhesive_count > 0:
            row_taken(phase, phase.first[k], spare)
            for p in range(it.n):
                it.z[p] -= it.touch[phase.laws_at[k] + 5] * spare[p]


@compiled
def rubbed(it: PhaseSlopes, phase: PhaseData, k: int, slip: int, change: float) -> None:
    """Set the derivatives of the friction of a slip by those of its normal force, and of its direction."""
    N = force_of(phase, k)[0] + adhesion_of(phase, k)
    for j in range(phase.tangents[k]):
        it.force[phase.first[k] + 1 + j] = change * phase.share[k, j] + N * turned(it, phase, k, slip, j)


@compiled
def lean(t: float, it: PhaseSlopes, phase: PhaseData, forces: Reals, shares: Reals) -> None:
    """Set ``shares`` to W (dG w + G M⁻¹ (-dM w + dG_aᵀ ν)) + dW G w of all conditions, whose forces W G w are shared.

    W changes with its units.
    """
    n, z, w = it.n, it.z, phase.step
    for i in range(phase.conditions):
        phase.right[i] = forces[i] / phase.weight[i]
    independent(phase, phase.independent, phase.active, 0)
    for p in range(n):
        w[p] = 0.0
    for i in range(phase.conditions):
        G = phase.G[i]
        for p in range(n):
            w[p] += phase.lam[i] * G[p]
    moved(phase, w, it.udot)
    for p in range(n):
        it.w[p] = it.udot[p]
    it.machine(t, it.given, it.machine_c, it.q_dot)
    for p in range(n):
        z[p] = -it.inertia[phase.order[p]]
    for i in range(phase.conditions):
        condition_load(it, phase, z, i, phase.lam[i])
    forwarded(phase, z, 0, phase.n)
    for i in range(phase.conditions):
        own = condition_change(it, phase, i, it.udot) + product(phase.G[i], z, n)
        shares[i] = phase.weight[i] * own + forces[i] * unit_change(it, phase, i)


@compiled
def unit_change(it: PhaseSlopes, phase: PhaseData, i: int) -> float:
    """Return the derivative of the `unit` of a condition, relative to it."""
    k = phase.source[i]
    if k < 0 or phase.presser[k] < 0:
        return 0.0
    return 2.0 * it.touch[phase.laws_at[k] + 1] / static_friction_of(phase, k)


@compiled
def shared_change(it: PhaseSlopes, phase: PhaseData, shares: Reals) -> None:
    """Set λ of all conditions to the derivatives of forces of equal compliance for ``right``."""
    for a in range(phase.active):
        phase.right[phase.independent[a]] -= product_of_shares(phase, a, shares)
    weighted(phase)
    for i in range(phase.conditions):
        phase.lam[i] += shares[i]


@compiled
def sharing_of(t: float, it: PhaseSlopes, phase: PhaseData) -> int:
    """Prepare the derivatives of shared forces; return 0 if there are none, 1 if W = 1, 2 if that of an island is N."""
    if phase.conditions == phase.active:
        return 0
    for i in range(phase.conditions):
        it.forces[i] = condition_force(phase, i)
    weighed = 0
    for s in range(phase.islands):
        weighed += phase.weighed[s]
    if weighed == 0:
        lean(t, it, phase, it.forces, it.shares)
        return 1
    if first_shares(phase, it.forces, it.weights, it.firsts) == 0:
        set_weights(phase, it.weights)
        return -1
    lean(t, it, phase, it.firsts, it.first_leans)
    set_weights(phase, it.weights)
    lean(t, it, phase, it.forces, it.shares)
    return 2


@compiled
def slope(t: float, it: PhaseSlopes, phase: PhaseData) -> None:
    """Set ``udot`` and ``force`` to the derivatives of the accelerations and forces of a phase that is solved.

    Forces are NAN where contacts without load share them.
    """
    for i in range(phase.closed_count):
        touch_along(t, it, phase, phase.closed[i])
    sharing = sharing_of(t, it, phase)
    for p in range(it.n):
        it.w[p] = phase.udot[p]
    it.machine(t, it.given, it.machine_c, it.q_dot)
    for k in range(it.contacts):
        it.pressure[k] = 0.0
    balanced(it, phase, sharing)
    if phase.loaded_count > 0 and borne(t, it, phase, sharing) == 0:
        it.udot[0] = NAN
    if sharing < 0:
        for r in range(it.rows):
            it.force[r] = NAN


@compiled
def borne(t: float, it: PhaseSlopes, phase: PhaseData, sharing: int) -> int:
    """Find the derivatives of the loads of joints, affine in themselves; return 0 if they have none, else 1.

    Each column of 1 - J is the answer to a load of the size of all.
    """
    m, size = phase.loaded_count, 1.0
    loads_along(t, it, phase, it.loads)
    for i in range(m):
        size = greater(size, abs(it.loads[i]))
    for j in range(m):
        it.pressure[phase.loaded[j]] = size
        balanced(it, phase, sharing)
        it.pressure[phase.loaded[j]] = 0.0
        loads_along(t, it, phase, it.answers)
        for i in range(m):
            it.square[i * m + j] = (1.0 if i == j else 0.0) - (it.answers[i] - it.loads[i]) / size
    if solved(it.square, m, it.loads) == 0:
        return 0
    for i in range(m):
        it.pressure[phase.loaded[i]] = it.loads[i]
    balanced(it, phase, sharing)
    return 1


@compiled
def balanced(it: PhaseSlopes, phase: PhaseData, sharing: int) -> None:
    """Set ``udot`` and ``force`` for the present derivatives of loads."""
    n, z, weight = it.n, it.z, phase.weight
    if sharing == 2:
        for i in range(phase.conditions):
            weight[i] = unit(phase, i)
        goals(it, phase, 1)
        shared_change(it, phase, it.first_leans)
        for i in range(phase.conditions):
            k, change = phase.source[i], mean_normal(phase, phase.island[i], phase.lam, 0.0)
            if phase.normal_of[i] >= 0:
                change = phase.lam[phase.normal_of[i]]
            elif k >= 0 and phase.held[k] != 0:
                change = given_change(it, phase, k)
            change = change * unit(phase, i) if phase.weighed[phase.island[i]] != 0 else 0.0
            it.turns[i] = it.shares[i] + change * it.forces[i] / it.weights[i]
        set_weights(phase, it.weights)
        goals(it, phase, 0)
        shared_change(it, phase, it.turns)
    else:
        goals(it, phase, 0)
        if sharing == 1:
            shared_change(it, phase, it.shares)
        elif phase.active > 0:
            independent(phase, phase.independent, phase.active, phase.slipping)
    for i in range(phase.conditions):
        K = force_row(phase, i)
        for p in range(n):
            z[p] += phase.lam[i] * K[p]
    for i in range(phase.conditions):
        k, x = phase.source[i], phase.lam[i]
        if k < 0:
            it.multiplier[phase.number[-1 - k]] = x
            continue
        pull = it.touch[phase.laws_at[k] + 5] if phase.row_of[i] == 0 else 0.0
        it.force[phase.first[k] + phase.row_of[i]] = x - pull
        if phase.slip[i] != laws.NO_SLIP:
            rubbed(it, phase, k, phase.slip[i], x)
        r = k + 1
        while phase.row_of[i] == 0 and r < phase.contacts and phase.presser[r] == k:
            it.force[phase.first[r]] = x
            if phase.pushed[r] != laws.NO_SLIP:
                rubbed(it, phase, r, phase.pushed[r], x)
            r += 1
    moved(phase, z, it.udot)


@compiled
def goals(it: PhaseSlopes, phase: PhaseData, first: int) -> None:
    """Set ``right`` of all conditions, and z, for the forces of the phase, or those of the ``first`` shares (1)."""
    n, z = it.n, it.z
    for p in range(n):
        i = phase.order[p]
        z[p] = -(it.bias[i] + it.inertia[i])
    for i in range(phase.closed_count):
        k = phase.closed[i]
        F = force_of(phase, k)
        for j in range(1 + phase.tangents[k]):
            load_along(it, phase, z, phase.first[k] + j, F[j])
    for i in range(phase.own):
        condition_load(it, phase, z, i, condition_force(phase, i))
    for i in range(phase.conditions if first != 0 else 0):
        condition_load(it, phase, z, i, it.firsts[i] - it.forces[i])
    for r in range(it.rows):
        it.force[r] = 0.0
    turn_friction(it, phase)
    push_along(it, phase)
    forwarded(phase, z, 0, phase.n)
    for i in range(phase.conditions):
        phase.right[i] = -(bias_along(it, phase, i) + product(phase.G[i], z, n))


@compiled
def varied(t: float, y: Reals, c: Reals, out: Reals) -> None:
    """Set ``out`` to the rates of (q, u, work, heat), then of the derivatives of (q, u) by each unknown.

    With a shift θ they are those of y(t + θ p, p), which are s + θ y'.
    """
    it = PhaseSlopes(c)
    phase, n_q, n = PhaseData(it.phase), it.n_q, it.n
    rates(t, y, it.phase, out)
    at = n_q + n + 2
    for j in range(it.unknowns):
        direct(it, y, phase.udot, y[at:])
        it.rest[0] = it.shifts[j]
        for m in range(it.symbols):
            it.rest[1 + m] = it.seeds[j, m]
        slope(t, it, phase)
        for i in range(n_q):
            out[at + i] = it.q_dot[i]
        for i in range(n):
            out[at + n_q + i] = it.udot[i]
        at += n_q + n


@compiled
def slopes(t: float, y: Reals, c: Reals, out: Reals) -> None:
    """Set ``out`` to the derivatives of q', u', the contact forces, and the outputs of all contacts along a direction.

    y holds q, u, work, heat, then the direction s, τ, dp.
    """
    it = PhaseSlopes(c)
    phase, n_q, n = PhaseData(it.phase), it.n_q, it.n
    solve(t, y, phase)
    open_touched(t, y, phase)
    at = n_q + n + 2
    direct(it, y, phase.udot, y[at:])
    for m in range(1 + it.symbols):
        it.rest[m] = y[at + n_q + n + m]
    slope(t, it, phase)
    for i in range(phase.open_count):
        touch_along(t, it, phase, phase.open[i])
    for i in range(n_q):
        out[i] = it.q_dot[i]
    for i in range(n):
        out[n_q + i] = it.udot[i]
    for r in range(it.rows):
        out[n_q + n + r] = it.force[r]
    at = n_q + n + it.rows
    for i in range(it.touches):
        out[at + i] = it.touch[i]
