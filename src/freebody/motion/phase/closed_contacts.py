"""The motion of a machine whose contacts are in given modes, in compiled code: modes are data.

Closed contacts are conditions beside those of the machine itself, all with rows G, and forces λ along rows K:

    M u' = f + Kᵀ λ,   G u' = -γ      =>      (G M⁻¹ Kᵀ) λ = -γ - G M⁻¹ f

    stick     rows of N, T             K = G
    slip      row of N                 K = W_N - μ d W_T,   d the direction of slip;  μ = 0: K = G

Only independent conditions (active ones) are imposed. The forces of the others are those of contacts of equal
compliance, in the range of the rows. With S = G M⁻¹ Kᵀ and Q = G M⁻¹ Gᵀ over active and all conditions,

    slip      λ = Qᵀ ν,   S Qᵀ ν = r           no slip    λ = W Qᵀ ν,   Q W Qᵀ ν = r,   r = -γ - G M⁻¹ f

where W = 1 gives the normal forces, and then W = N of the same contact for friction: N is least in norm, and T is the
least in Σ |T|²/N.

Every function but the first ones has the signature of a kernel, f(t, y, c, out); y = (q, u, work, heat of friction). c
is described in `places`. A new set of modes is another table of integers for the same code.

With M = L D Lᵀ, every row stands as D^-½ L⁻¹ Gᵀ, so that G M⁻¹ Kᵀ are products of rows.
"""

from __future__ import annotations

from ...native.instructions import (
    Integers,
    Reals,
    call,
    compiled,
    greater,
    inlined,
    lesser,
    root,
    shifted,
)
from ..cones.elimination import solved
from . import places
from .mode_table import evaluated, table

# --- evaluation ----------------------------------------------------------------------------------


@compiled
def looked_at(contacts: Integers, t: float, y: Reals, c: Reals, T: Integers) -> None:
    """Call the kernels of some contacts."""
    for i in range(contacts[0]):
        k = contacts[1 + i]
        at = T[T[places.CONTACT] + places.CONTACT_SIZE * k + places.AT]
        call(T[T[places.TOUCHES] + k], t, y, 0, shifted(c, T[places.CONSTANTS]), c, at)


@compiled
def gaps_at(t: float, y: Reals, c: Reals, T: Integers) -> None:
    """Call the kernels of the gaps and reaches of all contacts."""
    for p in range(T[places.PAIR_COUNT]):
        call(T[T[places.PAIRS] + p], t, y, 0, shifted(c, T[places.CONSTANTS]), c, T[T[places.PAIR_AT] + p])


@inlined
def contact_at(c: Reals, T: Integers, k: int) -> Reals:
    """Return the outputs of a contact: gap, reaches, μ, μ_s, e, μ at rest, rates, biases."""
    one = T[places.CONTACT] + places.CONTACT_SIZE * k
    return shifted(c, T[one + places.AT])


@inlined
def rates_of(c: Reals, T: Integers, k: int) -> Reals:
    """Return the gap's rate and the slip velocity of a contact."""
    one = T[places.CONTACT] + places.CONTACT_SIZE * k
    return shifted(c, T[one + places.AT] + T[one + places.REACHES] + 5)


@inlined
def biases_of(c: Reals, T: Integers, k: int) -> Reals:
    """Return b of d(W u + w)/dt = W u' + b of a contact."""
    one = T[places.CONTACT] + places.CONTACT_SIZE * k
    return shifted(c, T[one + places.AT] + T[one + places.REACHES] + 6 + T[one + places.TANGENTS])


@compiled
def forwarded(c: Reals, T: Integers, v: Reals) -> None:
    """Replace v, in the order of elimination, by D^-½ L⁻¹ v."""
    L, scale, starts, below = (
        shifted(c, T[places.L_AT]),
        shifted(c, T[places.SCALE_AT]),
        shifted(T, T[places.STARTS]),
        T[places.PLACES],
    )
    for k in range(T[places.N_U]):
        x = v[k]
        if x != 0.0:
            for p in range(starts[k], starts[k + 1]):
                v[T[below + p]] -= L[p] * x
            v[k] = scale[k] * x


@compiled
def moved(c: Reals, T: Integers, v: Reals, step: Reals) -> None:
    """Set ``step``, in the order of the speeds, to L⁻ᵀ D^-½ v; v is in the order of elimination and is overwritten."""
    L, scale, starts, below = (
        shifted(c, T[places.L_AT]),
        shifted(c, T[places.SCALE_AT]),
        shifted(T, T[places.STARTS]),
        T[places.PLACES],
    )
    for k in range(T[places.N_U] - 1, -1, -1):
        x = v[k] * scale[k]
        for p in range(starts[k], starts[k + 1]):
            x -= L[p] * v[T[below + p]]
        v[k] = x
        step[T[T[places.ORDER] + k]] = x


@compiled
def row_taken(c: Reals, T: Integers, r: int, v: Reals) -> None:
    """Set v to row r of the contacts, in the order of elimination."""
    for k in range(T[places.N_U]):
        v[k] = 0.0
    one = T[places.ROW] + places.ROW_SIZE * r
    columns, W = T[places.COLUMNS] + T[one], shifted(c, T[one + 2])
    for p in range(T[one + 1]):
        v[T[columns + p]] = W[p]


@compiled
def row_along(c: Reals, T: Integers, r: int, u: Reals) -> float:
    """Return row r of the contacts times u, in the order of the speeds."""
    one = T[places.ROW] + places.ROW_SIZE * r
    columns, W, order, total = T[places.COLUMNS] + T[one], shifted(c, T[one + 2]), T[places.ORDER], 0.0
    for p in range(T[one + 1]):
        total += W[p] * u[T[order + T[columns + p]]]
    return total


@inlined
def product(a: Reals, b: Reals, n: int) -> float:
    """Return a · b."""
    total = 0.0
    for k in range(n):
        total += a[k] * b[k]
    return total


@inlined
def positive(mu: float) -> float:
    """Return a coefficient of friction; NAN if a law of friction gives a negative one."""
    return mu if mu >= 0.0 else NAN


@compiled
def friction_along(c: Reals, T: Integers, one: int, j: int) -> float:
    """Return the friction of a slipping contact along tangent j, per unit of normal force: -μ d_j, at rest -μ_s d_j."""
    slip, k = T[one + places.SLIP], T[one + places.SOURCE]
    at = T[places.CONTACT] + places.CONTACT_SIZE * k
    seen = contact_at(c, T, k)
    mu = positive(seen[1 + T[at + places.REACHES]])
    if slip == places.FIXED:
        return -seen[2 + T[at + places.REACHES]] * c[T[places.DIRECTION_AT] + 2 * k + j]
    if slip == places.PLUS:
        return -mu
    if slip == places.MINUS:
        return mu
    v = rates_of(c, T, k)
    return -mu * v[1 + j] / root(v[1] * v[1] + v[2] * v[2])


# --- conditions ----------------------------------------------------------------------------------


@compiled
def rows_made(c: Reals, T: Integers) -> None:
    """Set the rows of G, and of K where it differs from G, of all conditions."""
    n = T[places.N_U]
    for i in range(T[places.CONDITIONS]):
        one = T[places.CONDITION] + places.CONDITION_SIZE * i
        k, Y = T[one + places.SOURCE], shifted(c, T[places.Y_AT] + i * n)
        if k < 0:
            own = shifted(c, T[places.OWN_AT] + (-1 - k) * (3 + n) + 3)
            for j in range(n):
                Y[j] = own[j]
        else:
            first = T[T[places.CONTACT] + places.CONTACT_SIZE * k + places.FIRST]
            row_taken(c, T, first + T[one + places.ROW_OF], Y)
            forwarded(c, T, Y)
            if T[one + places.SLIP] != places.NO_SLIP:
                spare, K = shifted(c, T[places.SPARE_AT]), shifted(c, T[one + places.FORCE_ROW])
                for j in range(n):
                    K[j] = Y[j]
                for j in range(T[T[places.CONTACT] + places.CONTACT_SIZE * k + places.TANGENTS]):
                    row_taken(c, T, first + 1 + j, spare)
                    forwarded(c, T, spare)
                    share = friction_along(c, T, one, j)
                    for p in range(n):
                        K[p] += share * spare[p]


@compiled
def gamma_of(c: Reals, T: Integers, i: int) -> float:
    """Return γ of a condition."""
    one = T[places.CONDITION] + places.CONDITION_SIZE * i
    k = T[one + places.SOURCE]
    if k < 0:
        return c[T[places.OWN_AT] + (-1 - k) * (3 + T[places.N_U]) + 2]
    return biases_of(c, T, k)[T[one + places.ROW_OF]]


@compiled
def shared(c: Reals, T: Integers) -> int:
    """Set λ of all conditions to forces of equal compliance with ``RIGHT``; return 0 if they do not exist, else 1."""
    n, count, active, rows = (
        T[places.N_U],
        T[places.CONDITIONS],
        T[places.ACTIVE],
        shifted(T, T[places.INDEPENDENT]),
    )
    lam, weight = shifted(c, T[places.LAMBDA_AT]), shifted(c, T[places.WEIGHT_AT])
    S, Q = shifted(c, T[places.G_AT]), shifted(c, T[places.G_AT] + active * count)
    for j in range(count):
        weight[j] = 1.0
        K, Y = force_row(c, T, j), shifted(c, T[places.Y_AT] + j * n)
        for a in range(active):
            G = shifted(c, T[places.Y_AT] + rows[a] * n)
            Q[j * active + a] = product(G, Y, n)
            S[j * active + a] = product(G, K, n) if T[places.SLIPPING] != 0 else Q[j * active + a]
    if weighted(c, T) == 0:
        return 0
    if T[places.SLIPPING] == 0:
        for j in range(count):
            normal = T[T[places.CONDITION] + places.CONDITION_SIZE * j + places.NORMAL_OF]
            if normal >= 0:
                weight[j] = lam[normal]
        weighted(c, T)  # contacts without load have no friction to share: the first shares remain
    return 1


@compiled
def weighted(c: Reals, T: Integers) -> int:
    """Set λ to W Qᵀ ν with S W Qᵀ ν = r and W = ``WEIGHT``; return 0 and leave λ if S W Qᵀ is singular, else 1."""
    count, active, rows = T[places.CONDITIONS], T[places.ACTIVE], shifted(T, T[places.INDEPENDENT])
    square, nu = shifted(c, T[places.SQUARE_AT]), shifted(c, T[places.SQUARE_AT] + active * active)
    copy, lam, weight = shifted(nu, active), shifted(c, T[places.LAMBDA_AT]), shifted(c, T[places.WEIGHT_AT])
    S, Q = shifted(c, T[places.G_AT]), shifted(c, T[places.G_AT] + active * count)
    for k in range(active * active):
        square[k] = 0.0
    for j in range(count):  # sums side by side, not one after another
        for a in range(active):
            x = S[j * active + a] * weight[j]
            for b in range(active):
                square[a * active + b] += x * Q[j * active + b]
    for refined in range(
        2
    ):  # S W Qᵀ has the condition of S squared: what is left of r is solved for once more
        for a in range(active):
            nu[a] = c[T[places.RIGHT_AT] + rows[a]]
            if refined != 0:
                for j in range(count):
                    nu[a] -= S[j * active + a] * lam[j]
        for k in range(active * active):
            copy[k] = square[k]
        if solved(copy, active, nu) == 0:
            return 0
        for j in range(count):
            first = lam[j] if refined != 0 else 0.0
            lam[j] = first + weight[j] * product(nu, shifted(Q, j * active), active)
    return 1


@inlined
def force_row(c: Reals, T: Integers, i: int) -> Reals:
    """Return the row of K of a condition."""
    return shifted(c, T[T[places.CONDITION] + places.CONDITION_SIZE * i + places.FORCE_ROW])


@compiled
def independent(c: Reals, T: Integers, rows: Integers, size: int, sliding: int) -> int:
    """Set λ of the conditions ``rows`` for ``RIGHT``, of the others 0; return 0 if they are not independent, else 1.

    If ``sliding`` is 0, K = G.
    """
    n, lam, square = T[places.N_U], shifted(c, T[places.LAMBDA_AT]), shifted(c, T[places.SQUARE_AT])
    right = shifted(c, T[places.SQUARE_AT] + T[places.ACTIVE] * T[places.ACTIVE])
    if size < T[places.CONDITIONS]:
        for i in range(T[places.CONDITIONS]):
            lam[i] = 0.0
    for a in range(size):
        G = shifted(c, T[places.Y_AT] + rows[a] * n)
        right[a] = c[T[places.RIGHT_AT] + rows[a]]
        if sliding != 0:
            for b in range(size):
                square[a * size + b] = product(G, force_row(c, T, rows[b]), n)
        else:
            for b in range(a + 1):
                square[a * size + b] = product(G, shifted(c, T[places.Y_AT] + rows[b] * n), n)
                square[b * size + a] = square[a * size + b]
    if solved(square, size, right) == 0:
        return 0
    for a in range(size):
        lam[rows[a]] = right[a]
    return 1


@compiled
def push(c: Reals, T: Integers, z: Reals) -> None:
    """Set the forces of the contacts that a normal force of 1 holds, and add the friction of those that slip to z."""
    for k in range(T[places.CONTACTS]):
        kind, at = T[places.KIND] + places.KIND_SIZE * k, T[places.CONTACT] + places.CONTACT_SIZE * k
        if T[kind + places.HELD] != 0:
            F = shifted(c, T[places.FORCE_AT] + T[at + places.FIRST])
            F[0] = 1.0
            if T[kind + places.PUSHED] != places.NO_SLIP:
                spare = shifted(c, T[places.SPARE_AT])
                F[1] = -positive(contact_at(c, T, k)[1 + T[at + places.REACHES]])
                F[1] = F[1] if T[kind + places.PUSHED] == places.PLUS else -F[1]
                row_taken(c, T, T[at + places.FIRST] + 1, spare)
                forwarded(c, T, spare)
                for i in range(T[places.N_U]):
                    z[i] += F[1] * spare[i]


@compiled
def solve(t: float, y: Reals, c: Reals, T: Integers) -> int:
    """Set accelerations, contact forces and multipliers; return 0 if a condition has lost its independence, else 1."""
    n, count = T[places.N_U], T[places.CONDITIONS]
    evaluated(t, y, c, T)
    looked_at(shifted(T, T[places.CALLED]), t, y, c, T)
    w, z = shifted(c, T[places.STEP_AT]), shifted(c, T[places.FREE_AT])
    if T[places.HELD_COUNT] > 0:
        push(c, T, z)
    rows_made(c, T)
    for i in range(count):
        c[T[places.RIGHT_AT] + i] = -(gamma_of(c, T, i) + product(shifted(c, T[places.Y_AT] + i * n), z, n))
    good = 1
    if count > T[places.ACTIVE]:
        good = shared(c, T)
    elif count > 0:
        good = independent(c, T, shifted(T, T[places.INDEPENDENT]), count, T[places.SLIPPING])
    for k in range(n):
        w[k] = z[k]
    for i in range(count):
        one = T[places.CONDITION] + places.CONDITION_SIZE * i
        x, K, source = (
            c[T[places.LAMBDA_AT] + i],
            shifted(c, T[one + places.FORCE_ROW]),
            T[one + places.SOURCE],
        )
        for k in range(n):
            w[k] += x * K[k]
        if source < 0:
            c[T[places.MULTIPLIER_AT] + T[T[places.OWN_NUMBER] - 1 - source]] = x
        else:
            at = T[places.CONTACT] + places.CONTACT_SIZE * source
            F = shifted(c, T[places.FORCE_AT] + T[at + places.FIRST])
            F[T[one + places.ROW_OF]] = x
            if T[one + places.SLIP] != places.NO_SLIP:
                for j in range(T[at + places.TANGENTS]):
                    F[1 + j] = x * friction_along(c, T, one, j)
    moved(c, T, w, shifted(c, T[places.UDOT_AT]))
    return good


# --- kernels of a phase --------------------------------------------------------------------------


@compiled
def rates(t: float, y: Reals, c: Reals, out: Reals) -> None:
    """Set ``out`` to q', u', the power of all that does work, and the heat of friction per second."""
    T = table(c)
    good = solve(t, y, c, T)
    n_q, n = T[places.N_Q], T[places.N_U]
    for i in range(n_q):
        out[i] = c[T[places.MACHINE_AT] + i]
    for i in range(n):
        out[n_q + i] = c[T[places.UDOT_AT] + i] if good != 0 else NAN
    heat = 0.0
    if T[places.SLIPPING] != 0:
        for i in range(T[places.CONDITIONS]):
            one = T[places.CONDITION] + places.CONDITION_SIZE * i
            if T[one + places.SLIP] != places.NO_SLIP:
                k = T[one + places.SOURCE]
                v, first = rates_of(c, T, k), T[T[places.CONTACT] + places.CONTACT_SIZE * k + places.FIRST]
                for j in range(T[T[places.CONTACT] + places.CONTACT_SIZE * k + places.TANGENTS]):
                    heat -= c[T[places.FORCE_AT] + first + 1 + j] * v[1 + j]
    for k in range(T[places.CONTACTS] if T[places.HELD_COUNT] > 0 else 0):
        if T[T[places.KIND] + places.KIND_SIZE * k + places.PUSHED] != places.NO_SLIP:
            heat -= (
                c[T[places.FORCE_AT] + T[T[places.CONTACT] + places.CONTACT_SIZE * k + places.FIRST] + 1]
                * rates_of(c, T, k)[1]
            )
    power = c[T[places.LOAD_AT]]
    if T[places.POWER] != 0:
        extended(y, c, T)
        call(T[places.POWER], t, c, T[places.STATE_AT], shifted(c, T[places.POWER_CONSTANTS]), out, n_q + n)
        power += out[n_q + n]
    out[n_q + n] = power - heat
    out[n_q + n + 1] = heat


NAN = float("nan")


@inlined
def extended(y: Reals, c: Reals, T: Integers) -> None:
    """Write the state before the accelerations, forces and multipliers."""
    for i in range(T[places.N_Q] + T[places.N_U]):
        c[T[places.STATE_AT] + i] = y[i]


@compiled
def derived(t: float, y: Reals, c: Reals, out: Reals) -> None:
    """Call a kernel of the state, accelerations, contact forces and multipliers."""
    T = table(c)
    solve(t, y, c, T)
    extended(y, c, T)
    call(T[places.DERIVED], t, c, T[places.STATE_AT], shifted(c, T[places.DERIVED_CONSTANTS]), out, 0)


@compiled
def multipliers(t: float, y: Reals, c: Reals, out: Reals) -> None:
    """Set ``out`` to the multipliers of all conditions of the machine itself."""
    T = table(c)
    solve(t, y, c, T)
    for i in range(T[places.ALL_OWN]):
        out[i] = c[T[places.MULTIPLIER_AT] + i]


@compiled
def force(t: float, y: Reals, c: Reals, out: Reals) -> None:
    """Set ``out`` to the forces of all contacts."""
    T = table(c)
    solve(t, y, c, T)
    for r in range(T[places.ROWS]):
        out[r] = c[T[places.FORCE_AT] + r]


@compiled
def acceleration(t: float, y: Reals, c: Reals, out: Reals) -> None:
    """Set ``out`` to the derivatives of the rates of all contacts."""
    T = table(c)
    solve(t, y, c, T)
    looked_at(shifted(T, T[places.WATCHED]), t, y, c, T)
    for k in range(T[places.CONTACTS]):
        one, b = T[places.CONTACT] + places.CONTACT_SIZE * k, biases_of(c, T, k)
        for j in range(1 + T[one + places.TANGENTS]):
            r = T[one + places.FIRST] + j
            out[r] = row_along(c, T, r, shifted(c, T[places.UDOT_AT])) + b[j]


@compiled
def gap(t: float, y: Reals, c: Reals, out: Reals) -> None:
    """Set ``out`` to the gaps of all contacts."""
    T = table(c)
    gaps_at(t, y, c, T)
    for k in range(T[places.CONTACTS]):
        out[k] = c[T[T[places.CONTACT] + places.CONTACT_SIZE * k + places.SEEN_AT]]


@compiled
def static_friction(t: float, y: Reals, c: Reals, out: Reals) -> None:
    """Set ``out`` to the coefficients of static friction of all contacts."""
    T = table(c)
    looked_at(shifted(T, T[places.CALLED]), t, y, c, T)
    looked_at(shifted(T, T[places.WATCHED]), t, y, c, T)
    for k in range(T[places.CONTACTS]):
        out[k] = contact_at(c, T, k)[2 + T[T[places.CONTACT] + places.CONTACT_SIZE * k + places.REACHES]]


@compiled
def rate(t: float, y: Reals, c: Reals, out: Reals) -> None:
    """Set ``out`` to the rates of all contacts."""
    T = table(c)
    looked_at(shifted(T, T[places.CALLED]), t, y, c, T)
    looked_at(shifted(T, T[places.WATCHED]), t, y, c, T)
    for k in range(T[places.CONTACTS]):
        one = T[places.CONTACT] + places.CONTACT_SIZE * k
        for j in range(1 + T[one + places.TANGENTS]):
            out[T[one + places.FIRST] + j] = rates_of(c, T, k)[j]


@compiled
def projection(t: float, y: Reals, c: Reals, out: Reals) -> None:
    """Set ``out`` to (q, u) moved onto the active conditions by one Newton step for q, then one for u.

    The state after a step is off by the local error. The error of a Newton step is the square of that, so one step
    reaches round-off.
    """
    T = table(c)
    n_q, n = T[places.N_Q], T[places.N_U]
    if T[places.ACTIVE] == 0:
        for i in range(n_q + n):
            out[i] = y[i]
        return
    evaluated(t, y, c, T)
    looked_at(shifted(T, T[places.CALLED]), t, y, c, T)
    corrected(c, T, 0)
    state = shifted(c, T[places.STATE_AT])
    for i in range(n_q):
        state[i] = y[i]
        out[i] = y[i]
    for i in range(n):
        state[n_q + i] = c[T[places.UDOT_AT] + i]
    evaluated(t, state, c, T)
    for i in range(n_q):
        out[i] = y[i] + c[T[places.MACHINE_AT] + i]
        state[i] = out[i]
    for i in range(n):
        state[n_q + i] = y[n_q + i]
    evaluated(t, state, c, T)
    looked_at(shifted(T, T[places.CALLED]), t, state, c, T)
    corrected(c, T, 1)
    for i in range(n):
        out[n_q + i] = y[n_q + i] + c[T[places.UDOT_AT] + i]


@compiled
def corrected(c: Reals, T: Integers, speeds: int) -> None:
    """Set ``UDOT`` to the least step that cancels the residuals of active conditions, or their rates (``speeds`` 1)."""
    n = T[places.N_U]
    rows_made(c, T)
    for i in range(T[places.CONDITIONS]):
        one = T[places.CONDITION] + places.CONDITION_SIZE * i
        k = T[one + places.SOURCE]
        if k < 0:
            c[T[places.RIGHT_AT] + i] = -c[T[places.OWN_AT] + (-1 - k) * (3 + n) + speeds]
        elif speeds == 0:
            c[T[places.RIGHT_AT] + i] = -contact_at(c, T, k)[0]
        else:
            c[T[places.RIGHT_AT] + i] = -rates_of(c, T, k)[T[one + places.ROW_OF]]
    rows, size = shifted(T, T[places.INDEPENDENT]), T[places.ACTIVE]
    if speeds == 0:
        rows, size = shifted(T, T[places.HOLONOMIC] + 1), T[T[places.HOLONOMIC]]
    good = independent(c, T, rows, size, 0)
    w = shifted(c, T[places.STEP_AT])
    for k in range(n):
        w[k] = 0.0 if good != 0 else NAN
    for a in range(size):
        x, Y = c[T[places.LAMBDA_AT] + rows[a]], shifted(c, T[places.Y_AT] + rows[a] * n)
        for k in range(n):
            w[k] += x * Y[k]
    moved(c, T, w, shifted(c, T[places.UDOT_AT]))


# --- endings -------------------------------------------------------------------------------------


@compiled
def parts_of_forces(c: Reals, T: Integers) -> float:
    """Return the sum of the parts of the forces of all closed contacts, each as if it were the only condition:

    λ_i = -(γ_i + Σ_j w_j f_j)/(G M⁻¹ Gᵀ)_ii,      of which |γ_i| and all |w_j f_j| are summed
    """
    n, z, total, rows = T[places.N_U], shifted(c, T[places.FREE_AT]), 0.0, shifted(T, T[places.INDEPENDENT])
    for a in range(T[places.OWN], T[places.ACTIVE]):
        Y = shifted(c, T[places.Y_AT] + rows[a] * n)
        size = abs(gamma_of(c, T, rows[a]))
        for k in range(n):
            size += abs(Y[k] * z[k])
        total += size / product(Y, Y, n)
    return total


@compiled
def watched(t: float, y: Reals, c: Reals, out: Reals) -> None:
    """Set ``out`` to the functions of the user, then to the functions that end the phase as they fall through zero."""
    T = table(c)
    if T[places.EXPRESSIONS] > 0:
        call(T[places.VALUES], t, y, 0, shifted(c, T[places.VALUES_CONSTANTS]), out, 0)
    size = 0.0
    if T[places.CONDITIONS] > T[places.OWN] or T[places.HELD_COUNT] > 0:
        solve(t, y, c, T)
        size = places.ROUNDED * parts_of_forces(c, T)
    gaps_at(t, y, c, T)
    for i in range(T[places.ENDINGS]):
        one = T[places.ENDING] + places.ENDING_SIZE * i
        k, law, sign, place = (
            T[one + places.CONTACT_OF],
            T[one + places.LAW],
            T[one + places.SIGN],
            T[one + places.PLACE],
        )
        at = T[places.CONTACT] + places.CONTACT_SIZE * k
        seen, v = shifted(c, T[at + places.SEEN_AT]), rates_of(c, T, k)
        F, mu = (
            shifted(c, T[places.FORCE_AT] + T[at + places.FIRST]),
            contact_at(c, T, k)[2 + T[at + places.REACHES]],
        )
        value = 1.0
        if law == places.NEVER:
            pass
        elif law == places.GAP:
            value = seen[0] - c[T[places.BAND_AT] + k]
        elif law == places.NORMAL:
            value = F[0] + size
        elif law == places.REACH:
            value = seen[1 + place]
        elif law == places.SIDE:
            value = -seen[1 + place]
        elif law == places.LINE_STOP:
            value = sign * v[1]
        elif law == places.STOP:
            value = v[1] * v[1] + v[2] * v[2] - places.STOPPED_SQUARE
        else:
            most = mu * F[0] + (1.0 + mu) * size
            value = most - sign * F[1]
            if law == places.CONE:
                value = most * most - F[1] * F[1] - F[2] * F[2]
        out[T[places.EXPRESSIONS] + i] = value


# --- all contacts at one moment ------------------------------------------------------------------


@compiled
def looked(t: float, y: Reals, c: Reals, out: Reals) -> None:
    """Set ``out`` to what decides events: gaps, least reaches, rates, W u' + b without contact forces, u' so, W, the
    change of u' per unit of each contact force, μ, μ_s, e, μ at rest, and the least rates of reaches that are zero.

    The machine's own conditions are enforced.
    """
    T = table(c)
    n, E, m = T[places.N_U], T[places.CONTACTS], T[places.ROWS]
    solve(t, y, c, T)
    looked_at(shifted(T, T[places.WATCHED]), t, y, c, T)
    free = shifted(out, 2 * E + 2 * m)
    for k in range(n):
        free[k] = c[T[places.UDOT_AT] + k]
    W, X, size = shifted(free, n), shifted(free, n + m * n), 1.0
    more = shifted(X, m * n)
    for k in range(T[places.N_Q]):
        size = greater(size, 1.0 + abs(y[k]))
    spare = shifted(c, T[places.SPARE_AT])
    for k in range(E):
        one, seen = T[places.CONTACT] + places.CONTACT_SIZE * k, contact_at(c, T, k)
        v, b, reaches = rates_of(c, T, k), biases_of(c, T, k), T[one + places.REACHES]
        out[k], out[E + k] = seen[0], INFINITE
        more[4 * E + k] = INFINITE
        for j in range(reaches):
            out[E + k] = lesser(out[E + k], seen[1 + j])
            if abs(seen[1 + j]) <= places.CLOSED * size:
                more[4 * E + k] = lesser(more[4 * E + k], c[T[one + places.AWAY_AT] + j])
        for j in range(4):
            more[4 * k + j] = seen[1 + reaches + j]
        for j in range(1 + T[one + places.TANGENTS]):
            r = T[one + places.FIRST] + j
            out[2 * E + r] = v[j]
            out[2 * E + m + r] = row_along(c, T, r, free) + b[j]
            row_taken(c, T, r, spare)
            for p in range(n):
                W[r * n + T[T[places.ORDER] + p]] = spare[p]
            forwarded(c, T, spare)
            for i in range(T[places.CONDITIONS]):
                c[T[places.RIGHT_AT] + i] = -product(shifted(c, T[places.Y_AT] + i * n), spare, n)
            if (
                T[places.ACTIVE] > 0
                and independent(c, T, shifted(T, T[places.INDEPENDENT]), T[places.ACTIVE], 0) != 0
            ):
                for i in range(T[places.CONDITIONS]):
                    for p in range(n):
                        spare[p] += c[T[places.LAMBDA_AT] + i] * c[T[places.Y_AT] + i * n + p]
            moved(c, T, spare, shifted(X, r * n))


INFINITE = float("inf")
