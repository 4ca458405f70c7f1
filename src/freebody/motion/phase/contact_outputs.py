"""What the kernels of a machine and of its contacts give at a state, by contact and by row, in compiled code."""

from __future__ import annotations

from ...native.functions import components
from ...native.instructions import Integers, Real, Reals, Row, call, compiled, inlined
from .phase_record import PhaseData
from .slopes_record import PhaseSlopes


@inlined
def extended(y: Reals, phase: PhaseData) -> None:
    """Write the state before the accelerations, forces and multipliers."""
    for i in range(phase.n_q + phase.n):
        phase.state[i] = y[i]


@inlined
def evaluated(t: float, y: Reals, phase: PhaseData) -> None:
    """Call the kernel of the machine."""
    phase.machine(t, y, phase.machine_c, phase.q_dot)


@compiled
def touched(contacts: Integers, count: int, t: float, y: Reals, phase: PhaseData) -> None:
    """Call the kernels of some contacts."""
    for i in range(count):
        k = contacts[i]
        if phase.touching[k] != 0:  # what resists rolling and spinning comes with its contact
            call(phase.touching[k], t, y, 0, phase.machine_c, phase.touch, phase.touch_at[k])


@inlined
def closed_touched(t: float, y: Reals, phase: PhaseData) -> None:
    """Call the kernels of the closed contacts: what is solved is no longer that of the last state."""
    phase.solved = 0
    touched(phase.closed, phase.closed_count, t, y, phase)


@inlined
def open_touched(t: float, y: Reals, phase: PhaseData) -> None:
    """Call the kernels of the open contacts."""
    touched(phase.open, phase.open_count, t, y, phase)


@compiled
def gaps_found(t: float, y: Reals, phase: PhaseData) -> None:
    """Call the kernels of the gaps and reaches of all contacts."""
    for p in range(phase.pairs):
        call(phase.gaps_of[p], t, y, 0, phase.machine_c, phase.gaps, phase.gaps_at[p])


# --- contacts ------------------------------------------------------------------------------------


@inlined
def friction(phase: PhaseData, k: int) -> float:
    """Return μ of the slip of a contact."""
    return phase.touch[phase.laws_at[k]]


@inlined
def static_friction_of(phase: PhaseData, k: int) -> float:
    """Return μ_s of a contact."""
    return phase.touch[phase.laws_at[k] + 1]


@inlined
def given_force_of(phase: PhaseData, k: int) -> float:
    """Return the normal force of a contact that the state gives, or the load of a joint, or 0."""
    return phase.touch[phase.laws_at[k] + 4] + phase.pressure[k]


@inlined
def adhesion_of(phase: PhaseData, k: int) -> float:
    """Return the pull that a contact bears."""
    return phase.touch[phase.laws_at[k] + 5]


@inlined
def rates_of(phase: PhaseData, k: int) -> Reals:
    """Return the gap's rate and the slip velocity of a contact."""
    return phase.touch[phase.rates_at[k] :]


@inlined
def biases_of(phase: PhaseData, k: int) -> Reals:
    """Return b of d(W u + w)/dt = W u' + b of a contact."""
    return phase.touch[phase.biases_at[k] :]


@inlined
def force_of(phase: PhaseData, k: int) -> Reals:
    """Return the normal force and the friction of a contact."""
    return phase.force[phase.first[k] :]


# --- rows ----------------------------------------------------------------------------------------


@inlined
def places_of(phase: PhaseData, one: int, other: int) -> tuple[int, int]:
    """Return between which places in the order of elimination two blocks of speeds are."""
    low, high = phase.block_low, phase.block_high
    return (
        low[one] if low[one] < low[other] else low[other],
        high[one] if high[one] > high[other] else high[other],
    )


@compiled
def forwarded(phase: PhaseData, v: Reals, low: int, high: int) -> None:
    """Replace v, in the order of elimination, by D^-½ L⁻¹ v, from ``low`` up to ``high``: it is zero elsewhere."""
    L, below = phase.L, phase.below
    if phase.starts[phase.n] == 0:  # M is diagonal: a free body
        for k in range(low, high):
            v[k] *= phase.scale[k]
        return
    for k in range(low, high):
        x = v[k]
        if x != 0.0:
            for p in range(phase.starts[k], phase.starts[k + 1]):
                v[below[p]] -= L[p] * x
            v[k] = phase.scale[k] * x


@compiled
def moved(phase: PhaseData, v: Reals, step: Reals) -> None:
    """Set ``step``, in the order of the speeds, to L⁻ᵀ D^-½ v; v is in the order of elimination and is overwritten."""
    moved_in(phase, v, step, 0, phase.n)


@compiled
def moved_in(phase: PhaseData, v: Reals, step: Reals, low: int, high: int) -> None:
    """Set ``step`` as `moved` does, from ``low`` up to ``high``: v is zero elsewhere."""
    L, below = phase.L, phase.below
    for k in range(high - 1, low - 1, -1):
        x = v[k] * phase.scale[k]
        for p in range(phase.starts[k], phase.starts[k + 1]):
            x -= L[p] * v[below[p]]
        v[k] = x
        step[phase.order[k]] = x


@compiled
def row_taken(phase: PhaseData, r: int, v: Reals) -> None:
    """Set v to row r of the contacts, in the order of elimination."""
    row_taken_in(phase, r, v, 0, phase.n)


@inlined
def row_taken_in(phase: PhaseData, r: int, v: Reals, low: int, high: int) -> None:
    """Set v to row r of the contacts as `row_taken` does, from ``low`` up to ``high``: it is zero elsewhere."""
    for k in range(low, high):
        v[k] = 0.0
    columns, W = phase.columns[phase.entry[r] :], phase.touch[phase.W_at[r] :]
    for p in range(phase.entries[r]):
        v[columns[p]] = W[p]


@inlined
def row_added(phase: PhaseData, r: int, part: float, v: Reals) -> None:
    """Add a part of row r of the contacts to v, in the order of elimination."""
    columns, W = phase.columns[phase.entry[r] :], phase.touch[phase.W_at[r] :]
    for p in range(phase.entries[r]):
        v[columns[p]] += part * W[p]


@compiled
def row_along(phase: PhaseData, r: int, u: Reals) -> float:
    """Return row r of the contacts times u, in the order of the speeds."""
    columns, W, total = phase.columns[phase.entry[r] :], phase.touch[phase.W_at[r] :], 0.0
    for p in range(phase.entries[r]):
        total += W[p] * u[phase.order[columns[p]]]
    return total


@inlined
def product(a: Reals, b: Reals, n: int) -> float:
    """Return a · b."""
    total = 0.0
    for k in range(n):
        total += a[k] * b[k]
    return total


@inlined
def inner(a: Row, b: Row, n: int) -> float:
    """Return a · b of rows of a record, eight components at a time."""
    total: Real = 0.0
    for k in components(n):
        total += a[k] * b[k]
    return total


# --- derivatives of rows --------------------------------------------------------------------------


@compiled
def load_along(it: PhaseSlopes, phase: PhaseData, z: Reals, r: int, force: float) -> None:
    """Add a force along the derivative of a row of the contacts to z."""
    columns, W = phase.columns[phase.entry[r] :], it.touch[phase.W_at[r] :]
    for p in range(phase.entries[r]):
        z[columns[p]] += force * W[p]


@compiled
def row_change(it: PhaseSlopes, phase: PhaseData, r: int, w: Reals) -> float:
    """Return the derivative of a row of the contacts times w, with w fixed, in the order of the speeds."""
    columns, W, total = phase.columns[phase.entry[r] :], it.touch[phase.W_at[r] :], 0.0
    for p in range(phase.entries[r]):
        total += W[p] * w[phase.order[columns[p]]]
    return total


@compiled
def condition_load(it: PhaseSlopes, phase: PhaseData, z: Reals, i: int, force: float) -> None:
    """Add a force along the derivative of G of a condition to z."""
    k = phase.source[i]
    if k >= 0:
        load_along(it, phase, z, phase.first[k] + phase.row_of[i], force)
    else:
        G = it.own_G[(-1 - k) * it.n :]
        for p in range(it.n):
            z[p] += force * G[phase.order[p]]


@compiled
def condition_change(it: PhaseSlopes, phase: PhaseData, i: int, w: Reals) -> float:
    """Return the derivative of G of a condition times w, with w fixed, in the order of the speeds."""
    k = phase.source[i]
    if k >= 0:
        return row_change(it, phase, phase.first[k] + phase.row_of[i], w)
    return product(it.own_G[(-1 - k) * it.n :], w, it.n)


@compiled
def bias_along(it: PhaseSlopes, phase: PhaseData, i: int) -> float:
    """Return the derivative of G u' + γ of a condition, with u' fixed."""
    k, change = phase.source[i], condition_change(it, phase, i, phase.udot)
    return change + (it.touch[phase.biases_at[k] + phase.row_of[i]] if k >= 0 else it.gamma[-1 - k])


@compiled
def direct(it: PhaseSlopes, y: Reals, w: Reals, s: Reals) -> None:
    """Write the state, w, and the direction of q and u."""
    for i in range(it.n_q + it.n):
        it.given[i], it.s[i] = y[i], s[i]
    for i in range(it.n):
        it.w[i] = w[i]


@compiled
def touch_along(t: float, it: PhaseSlopes, phase: PhaseData, k: int) -> None:
    """Call the kernel of a contact, which has the outputs of what resists its rolling and spinning, too."""
    if it.touching[k] != 0:
        call(it.touching[k], t, it.given, 0, it.machine_c, it.touch, phase.touch_at[k])
