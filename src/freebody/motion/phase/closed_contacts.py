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
from .mode_table import evaluated, table
from .places import (
    ACTIVE,
    ALL_OWN,
    AT,
    AWAY_AT,
    BAND_AT,
    CALLED,
    CLOSED,
    COLUMNS,
    CONDITION,
    CONDITION_SIZE,
    CONDITIONS,
    CONE,
    CONSTANTS,
    CONTACT,
    CONTACT_OF,
    CONTACT_SIZE,
    CONTACTS,
    DERIVED,
    DERIVED_CONSTANTS,
    DIRECTION_AT,
    ENDING,
    ENDING_SIZE,
    ENDINGS,
    EXPRESSIONS,
    FIRST,
    FIXED,
    FORCE_AT,
    FORCE_ROW,
    FREE_AT,
    G_AT,
    GAP,
    HELD,
    HELD_COUNT,
    HOLONOMIC,
    INDEPENDENT,
    KIND,
    KIND_SIZE,
    L_AT,
    LAMBDA_AT,
    LAW,
    LINE_STOP,
    LOAD_AT,
    MACHINE_AT,
    MINUS,
    MULTIPLIER_AT,
    N_Q,
    N_U,
    NEVER,
    NO_SLIP,
    NORMAL,
    NORMAL_OF,
    ORDER,
    OWN,
    OWN_AT,
    OWN_NUMBER,
    PAIR_AT,
    PAIR_COUNT,
    PAIRS,
    PLACE,
    PLACES,
    PLUS,
    POWER,
    POWER_CONSTANTS,
    PUSHED,
    REACH,
    REACHES,
    RIGHT_AT,
    ROUNDED,
    ROW,
    ROW_OF,
    ROW_SIZE,
    ROWS,
    SCALE_AT,
    SEEN_AT,
    SIDE,
    SIGN,
    SLIP,
    SLIPPING,
    SOURCE,
    SPARE_AT,
    SQUARE_AT,
    STARTS,
    STATE_AT,
    STEP_AT,
    STOP,
    STOPPED_SQUARE,
    TANGENTS,
    TOUCHES,
    UDOT_AT,
    VALUES,
    VALUES_CONSTANTS,
    WATCHED,
    WEIGHT_AT,
    Y_AT,
)

# --- evaluation ----------------------------------------------------------------------------------


@compiled
def looked_at(contacts: Integers, t: float, y: Reals, c: Reals, T: Integers) -> None:
    """Call the kernels of some contacts."""
    for i in range(contacts[0]):
        k = contacts[1 + i]
        at = T[T[CONTACT] + CONTACT_SIZE * k + AT]
        call(T[T[TOUCHES] + k], t, y, 0, shifted(c, T[CONSTANTS]), c, at)


@compiled
def gaps_at(t: float, y: Reals, c: Reals, T: Integers) -> None:
    """Call the kernels of the gaps and reaches of all contacts."""
    for p in range(T[PAIR_COUNT]):
        call(T[T[PAIRS] + p], t, y, 0, shifted(c, T[CONSTANTS]), c, T[T[PAIR_AT] + p])


@inlined
def contact_at(c: Reals, T: Integers, k: int) -> Reals:
    """Return the outputs of a contact: gap, reaches, μ, μ_s, e, rates, biases."""
    one = T[CONTACT] + CONTACT_SIZE * k
    return shifted(c, T[one + AT])


@inlined
def rates_of(c: Reals, T: Integers, k: int) -> Reals:
    """Return the gap's rate and the slip velocity of a contact."""
    one = T[CONTACT] + CONTACT_SIZE * k
    return shifted(c, T[one + AT] + T[one + REACHES] + 4)


@inlined
def biases_of(c: Reals, T: Integers, k: int) -> Reals:
    """Return b of d(W u + w)/dt = W u' + b of a contact."""
    one = T[CONTACT] + CONTACT_SIZE * k
    return shifted(c, T[one + AT] + T[one + REACHES] + 5 + T[one + TANGENTS])


@compiled
def forwarded(c: Reals, T: Integers, v: Reals) -> None:
    """Replace v, in the order of elimination, by D^-½ L⁻¹ v."""
    L, scale, starts, places = shifted(c, T[L_AT]), shifted(c, T[SCALE_AT]), shifted(T, T[STARTS]), T[PLACES]
    for k in range(T[N_U]):
        x = v[k]
        if x != 0.0:
            for p in range(starts[k], starts[k + 1]):
                v[T[places + p]] -= L[p] * x
            v[k] = scale[k] * x


@compiled
def moved(c: Reals, T: Integers, v: Reals, step: Reals) -> None:
    """Set ``step``, in the order of the speeds, to L⁻ᵀ D^-½ v; v is in the order of elimination and is overwritten."""
    L, scale, starts, places = shifted(c, T[L_AT]), shifted(c, T[SCALE_AT]), shifted(T, T[STARTS]), T[PLACES]
    for k in range(T[N_U] - 1, -1, -1):
        x = v[k] * scale[k]
        for p in range(starts[k], starts[k + 1]):
            x -= L[p] * v[T[places + p]]
        v[k] = x
        step[T[T[ORDER] + k]] = x


@compiled
def row_taken(c: Reals, T: Integers, r: int, v: Reals) -> None:
    """Set v to row r of the contacts, in the order of elimination."""
    for k in range(T[N_U]):
        v[k] = 0.0
    one = T[ROW] + ROW_SIZE * r
    columns, W = T[COLUMNS] + T[one], shifted(c, T[one + 2])
    for p in range(T[one + 1]):
        v[T[columns + p]] = W[p]


@compiled
def row_along(c: Reals, T: Integers, r: int, u: Reals) -> float:
    """Return row r of the contacts times u, in the order of the speeds."""
    one = T[ROW] + ROW_SIZE * r
    columns, W, order, total = T[COLUMNS] + T[one], shifted(c, T[one + 2]), T[ORDER], 0.0
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


@compiled
def friction_along(c: Reals, T: Integers, one: int, j: int) -> float:
    """Return the friction of a slipping contact along tangent j, per unit of normal force: -μ d_j, at rest -μ_s d_j."""
    slip, k = T[one + SLIP], T[one + SOURCE]
    at = T[CONTACT] + CONTACT_SIZE * k
    seen = contact_at(c, T, k)
    mu = seen[1 + T[at + REACHES]]
    if slip == FIXED:
        return -seen[2 + T[at + REACHES]] * c[T[DIRECTION_AT] + 2 * k + j]
    if slip == PLUS:
        return -mu
    if slip == MINUS:
        return mu
    v = rates_of(c, T, k)
    return -mu * v[1 + j] / root(v[1] * v[1] + v[2] * v[2])


# --- conditions ----------------------------------------------------------------------------------


@compiled
def rows_made(c: Reals, T: Integers) -> None:
    """Set the rows of G, and of K where it differs from G, of all conditions."""
    n = T[N_U]
    for i in range(T[CONDITIONS]):
        one = T[CONDITION] + CONDITION_SIZE * i
        k, Y = T[one + SOURCE], shifted(c, T[Y_AT] + i * n)
        if k < 0:
            own = shifted(c, T[OWN_AT] + (-1 - k) * (3 + n) + 3)
            for j in range(n):
                Y[j] = own[j]
        else:
            first = T[T[CONTACT] + CONTACT_SIZE * k + FIRST]
            row_taken(c, T, first + T[one + ROW_OF], Y)
            forwarded(c, T, Y)
            if T[one + SLIP] != NO_SLIP:
                spare, K = shifted(c, T[SPARE_AT]), shifted(c, T[one + FORCE_ROW])
                for j in range(n):
                    K[j] = Y[j]
                for j in range(T[T[CONTACT] + CONTACT_SIZE * k + TANGENTS]):
                    row_taken(c, T, first + 1 + j, spare)
                    forwarded(c, T, spare)
                    share = friction_along(c, T, one, j)
                    for p in range(n):
                        K[p] += share * spare[p]


@compiled
def gamma_of(c: Reals, T: Integers, i: int) -> float:
    """Return γ of a condition."""
    one = T[CONDITION] + CONDITION_SIZE * i
    k = T[one + SOURCE]
    if k < 0:
        return c[T[OWN_AT] + (-1 - k) * (3 + T[N_U]) + 2]
    return biases_of(c, T, k)[T[one + ROW_OF]]


@compiled
def shared(c: Reals, T: Integers) -> int:
    """Set λ of all conditions to forces of equal compliance with ``RIGHT``; return 0 if they do not exist, else 1."""
    n, count, active, rows = T[N_U], T[CONDITIONS], T[ACTIVE], shifted(T, T[INDEPENDENT])
    lam, weight = shifted(c, T[LAMBDA_AT]), shifted(c, T[WEIGHT_AT])
    S, Q = shifted(c, T[G_AT]), shifted(c, T[G_AT] + active * count)
    for j in range(count):
        weight[j] = 1.0
        K, Y = force_row(c, T, j), shifted(c, T[Y_AT] + j * n)
        for a in range(active):
            G = shifted(c, T[Y_AT] + rows[a] * n)
            Q[j * active + a] = product(G, Y, n)
            S[j * active + a] = product(G, K, n) if T[SLIPPING] != 0 else Q[j * active + a]
    if weighted(c, T) == 0:
        return 0
    if T[SLIPPING] == 0:
        for j in range(count):
            normal = T[T[CONDITION] + CONDITION_SIZE * j + NORMAL_OF]
            if normal >= 0:
                weight[j] = lam[normal]
        weighted(c, T)  # contacts without load have no friction to share: the first shares remain
    return 1


@compiled
def weighted(c: Reals, T: Integers) -> int:
    """Set λ to W Qᵀ ν with S W Qᵀ ν = r and W = ``WEIGHT``; return 0 and leave λ if S W Qᵀ is singular, else 1."""
    count, active, rows = T[CONDITIONS], T[ACTIVE], shifted(T, T[INDEPENDENT])
    square, nu = shifted(c, T[SQUARE_AT]), shifted(c, T[SQUARE_AT] + active * active)
    copy, lam, weight = shifted(nu, active), shifted(c, T[LAMBDA_AT]), shifted(c, T[WEIGHT_AT])
    S, Q = shifted(c, T[G_AT]), shifted(c, T[G_AT] + active * count)
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
            nu[a] = c[T[RIGHT_AT] + rows[a]]
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
    return shifted(c, T[T[CONDITION] + CONDITION_SIZE * i + FORCE_ROW])


@compiled
def independent(c: Reals, T: Integers, rows: Integers, size: int, sliding: int) -> int:
    """Set λ of the conditions ``rows`` for ``RIGHT``, of the others 0; return 0 if they are not independent, else 1.

    If ``sliding`` is 0, K = G.
    """
    n, lam, square = T[N_U], shifted(c, T[LAMBDA_AT]), shifted(c, T[SQUARE_AT])
    right = shifted(c, T[SQUARE_AT] + T[ACTIVE] * T[ACTIVE])
    if size < T[CONDITIONS]:
        for i in range(T[CONDITIONS]):
            lam[i] = 0.0
    for a in range(size):
        G = shifted(c, T[Y_AT] + rows[a] * n)
        right[a] = c[T[RIGHT_AT] + rows[a]]
        if sliding != 0:
            for b in range(size):
                square[a * size + b] = product(G, force_row(c, T, rows[b]), n)
        else:
            for b in range(a + 1):
                square[a * size + b] = product(G, shifted(c, T[Y_AT] + rows[b] * n), n)
                square[b * size + a] = square[a * size + b]
    if solved(square, size, right) == 0:
        return 0
    for a in range(size):
        lam[rows[a]] = right[a]
    return 1


@compiled
def push(c: Reals, T: Integers, z: Reals) -> None:
    """Set the forces of the contacts that a normal force of 1 holds, and add the friction of those that slip to z."""
    for k in range(T[CONTACTS]):
        kind, at = T[KIND] + KIND_SIZE * k, T[CONTACT] + CONTACT_SIZE * k
        if T[kind + HELD] != 0:
            F = shifted(c, T[FORCE_AT] + T[at + FIRST])
            F[0] = 1.0
            if T[kind + PUSHED] != NO_SLIP:
                spare = shifted(c, T[SPARE_AT])
                F[1] = -contact_at(c, T, k)[1 + T[at + REACHES]]
                F[1] = F[1] if T[kind + PUSHED] == PLUS else -F[1]
                row_taken(c, T, T[at + FIRST] + 1, spare)
                forwarded(c, T, spare)
                for i in range(T[N_U]):
                    z[i] += F[1] * spare[i]


@compiled
def solve(t: float, y: Reals, c: Reals, T: Integers) -> int:
    """Set accelerations, contact forces and multipliers; return 0 if a condition has lost its independence, else 1."""
    n, count = T[N_U], T[CONDITIONS]
    evaluated(t, y, c, T)
    looked_at(shifted(T, T[CALLED]), t, y, c, T)
    w, z = shifted(c, T[STEP_AT]), shifted(c, T[FREE_AT])
    if T[HELD_COUNT] > 0:
        push(c, T, z)
    rows_made(c, T)
    for i in range(count):
        c[T[RIGHT_AT] + i] = -(gamma_of(c, T, i) + product(shifted(c, T[Y_AT] + i * n), z, n))
    good = 1
    if count > T[ACTIVE]:
        good = shared(c, T)
    elif count > 0:
        good = independent(c, T, shifted(T, T[INDEPENDENT]), count, T[SLIPPING])
    for k in range(n):
        w[k] = z[k]
    for i in range(count):
        one = T[CONDITION] + CONDITION_SIZE * i
        x, K, source = c[T[LAMBDA_AT] + i], shifted(c, T[one + FORCE_ROW]), T[one + SOURCE]
        for k in range(n):
            w[k] += x * K[k]
        if source < 0:
            c[T[MULTIPLIER_AT] + T[T[OWN_NUMBER] - 1 - source]] = x
        else:
            at = T[CONTACT] + CONTACT_SIZE * source
            F = shifted(c, T[FORCE_AT] + T[at + FIRST])
            F[T[one + ROW_OF]] = x
            if T[one + SLIP] != NO_SLIP:
                for j in range(T[at + TANGENTS]):
                    F[1 + j] = x * friction_along(c, T, one, j)
    moved(c, T, w, shifted(c, T[UDOT_AT]))
    return good


# --- kernels of a phase --------------------------------------------------------------------------


@compiled
def rates(t: float, y: Reals, c: Reals, out: Reals) -> None:
    """Set ``out`` to q', u', the power of all that does work, and the heat of friction per second."""
    T = table(c)
    good = solve(t, y, c, T)
    n_q, n = T[N_Q], T[N_U]
    for i in range(n_q):
        out[i] = c[T[MACHINE_AT] + i]
    for i in range(n):
        out[n_q + i] = c[T[UDOT_AT] + i] if good != 0 else NAN
    heat = 0.0
    if T[SLIPPING] != 0:
        for i in range(T[CONDITIONS]):
            one = T[CONDITION] + CONDITION_SIZE * i
            if T[one + SLIP] != NO_SLIP:
                k = T[one + SOURCE]
                v, first = rates_of(c, T, k), T[T[CONTACT] + CONTACT_SIZE * k + FIRST]
                for j in range(T[T[CONTACT] + CONTACT_SIZE * k + TANGENTS]):
                    heat -= c[T[FORCE_AT] + first + 1 + j] * v[1 + j]
    for k in range(T[CONTACTS] if T[HELD_COUNT] > 0 else 0):
        if T[T[KIND] + KIND_SIZE * k + PUSHED] != NO_SLIP:
            heat -= c[T[FORCE_AT] + T[T[CONTACT] + CONTACT_SIZE * k + FIRST] + 1] * rates_of(c, T, k)[1]
    power = c[T[LOAD_AT]]
    if T[POWER] != 0:
        extended(y, c, T)
        call(T[POWER], t, c, T[STATE_AT], shifted(c, T[POWER_CONSTANTS]), out, n_q + n)
        power += out[n_q + n]
    out[n_q + n] = power - heat
    out[n_q + n + 1] = heat


NAN = float("nan")


@inlined
def extended(y: Reals, c: Reals, T: Integers) -> None:
    """Write the state before the accelerations, forces and multipliers."""
    for i in range(T[N_Q] + T[N_U]):
        c[T[STATE_AT] + i] = y[i]


@compiled
def derived(t: float, y: Reals, c: Reals, out: Reals) -> None:
    """Call a kernel of the state, accelerations, contact forces and multipliers."""
    T = table(c)
    solve(t, y, c, T)
    extended(y, c, T)
    call(T[DERIVED], t, c, T[STATE_AT], shifted(c, T[DERIVED_CONSTANTS]), out, 0)


@compiled
def multipliers(t: float, y: Reals, c: Reals, out: Reals) -> None:
    """Set ``out`` to the multipliers of all conditions of the machine itself."""
    T = table(c)
    solve(t, y, c, T)
    for i in range(T[ALL_OWN]):
        out[i] = c[T[MULTIPLIER_AT] + i]


@compiled
def force(t: float, y: Reals, c: Reals, out: Reals) -> None:
    """Set ``out`` to the forces of all contacts."""
    T = table(c)
    solve(t, y, c, T)
    for r in range(T[ROWS]):
        out[r] = c[T[FORCE_AT] + r]


@compiled
def acceleration(t: float, y: Reals, c: Reals, out: Reals) -> None:
    """Set ``out`` to the derivatives of the rates of all contacts."""
    T = table(c)
    solve(t, y, c, T)
    looked_at(shifted(T, T[WATCHED]), t, y, c, T)
    for k in range(T[CONTACTS]):
        one, b = T[CONTACT] + CONTACT_SIZE * k, biases_of(c, T, k)
        for j in range(1 + T[one + TANGENTS]):
            r = T[one + FIRST] + j
            out[r] = row_along(c, T, r, shifted(c, T[UDOT_AT])) + b[j]


@compiled
def gap(t: float, y: Reals, c: Reals, out: Reals) -> None:
    """Set ``out`` to the gaps of all contacts."""
    T = table(c)
    gaps_at(t, y, c, T)
    for k in range(T[CONTACTS]):
        out[k] = c[T[T[CONTACT] + CONTACT_SIZE * k + SEEN_AT]]


@compiled
def rate(t: float, y: Reals, c: Reals, out: Reals) -> None:
    """Set ``out`` to the rates of all contacts."""
    T = table(c)
    looked_at(shifted(T, T[CALLED]), t, y, c, T)
    looked_at(shifted(T, T[WATCHED]), t, y, c, T)
    for k in range(T[CONTACTS]):
        one = T[CONTACT] + CONTACT_SIZE * k
        for j in range(1 + T[one + TANGENTS]):
            out[T[one + FIRST] + j] = rates_of(c, T, k)[j]


@compiled
def projection(t: float, y: Reals, c: Reals, out: Reals) -> None:
    """Set ``out`` to (q, u) moved onto the active conditions by one Newton step for q, then one for u.

    The state after a step is off by the local error. The error of a Newton step is the square of that, so one step
    reaches round-off.
    """
    T = table(c)
    n_q, n = T[N_Q], T[N_U]
    if T[ACTIVE] == 0:
        for i in range(n_q + n):
            out[i] = y[i]
        return
    evaluated(t, y, c, T)
    looked_at(shifted(T, T[CALLED]), t, y, c, T)
    corrected(c, T, 0)
    state = shifted(c, T[STATE_AT])
    for i in range(n_q):
        state[i] = y[i]
        out[i] = y[i]
    for i in range(n):
        state[n_q + i] = c[T[UDOT_AT] + i]
    evaluated(t, state, c, T)
    for i in range(n_q):
        out[i] = y[i] + c[T[MACHINE_AT] + i]
        state[i] = out[i]
    for i in range(n):
        state[n_q + i] = y[n_q + i]
    evaluated(t, state, c, T)
    looked_at(shifted(T, T[CALLED]), t, state, c, T)
    corrected(c, T, 1)
    for i in range(n):
        out[n_q + i] = y[n_q + i] + c[T[UDOT_AT] + i]


@compiled
def corrected(c: Reals, T: Integers, speeds: int) -> None:
    """Set ``UDOT`` to the least step that cancels the residuals of active conditions, or their rates (``speeds`` 1)."""
    n = T[N_U]
    rows_made(c, T)
    for i in range(T[CONDITIONS]):
        one = T[CONDITION] + CONDITION_SIZE * i
        k = T[one + SOURCE]
        if k < 0:
            c[T[RIGHT_AT] + i] = -c[T[OWN_AT] + (-1 - k) * (3 + n) + speeds]
        elif speeds == 0:
            c[T[RIGHT_AT] + i] = -contact_at(c, T, k)[0]
        else:
            c[T[RIGHT_AT] + i] = -rates_of(c, T, k)[T[one + ROW_OF]]
    rows, size = shifted(T, T[INDEPENDENT]), T[ACTIVE]
    if speeds == 0:
        rows, size = shifted(T, T[HOLONOMIC] + 1), T[T[HOLONOMIC]]
    good = independent(c, T, rows, size, 0)
    w = shifted(c, T[STEP_AT])
    for k in range(n):
        w[k] = 0.0 if good != 0 else NAN
    for a in range(size):
        x, Y = c[T[LAMBDA_AT] + rows[a]], shifted(c, T[Y_AT] + rows[a] * n)
        for k in range(n):
            w[k] += x * Y[k]
    moved(c, T, w, shifted(c, T[UDOT_AT]))


# --- endings -------------------------------------------------------------------------------------


@compiled
def parts_of_forces(c: Reals, T: Integers) -> float:
    """Return the sum of the parts of the forces of all closed contacts, each as if it were the only condition:

    λ_i = -(γ_i + Σ_j w_j f_j)/(G M⁻¹ Gᵀ)_ii,      of which |γ_i| and all |w_j f_j| are summed
    """
    n, z, total, rows = T[N_U], shifted(c, T[FREE_AT]), 0.0, shifted(T, T[INDEPENDENT])
    for a in range(T[OWN], T[ACTIVE]):
        Y = shifted(c, T[Y_AT] + rows[a] * n)
        size = abs(gamma_of(c, T, rows[a]))
        for k in range(n):
            size += abs(Y[k] * z[k])
        total += size / product(Y, Y, n)
    return total


@compiled
def watched(t: float, y: Reals, c: Reals, out: Reals) -> None:
    """Set ``out`` to the functions of the user, then to the functions that end the phase as they fall through zero."""
    T = table(c)
    if T[EXPRESSIONS] > 0:
        call(T[VALUES], t, y, 0, shifted(c, T[VALUES_CONSTANTS]), out, 0)
    size = 0.0
    if T[CONDITIONS] > T[OWN] or T[HELD_COUNT] > 0:
        solve(t, y, c, T)
        size = ROUNDED * parts_of_forces(c, T)
    gaps_at(t, y, c, T)
    for i in range(T[ENDINGS]):
        one = T[ENDING] + ENDING_SIZE * i
        k, law, sign, place = T[one + CONTACT_OF], T[one + LAW], T[one + SIGN], T[one + PLACE]
        at = T[CONTACT] + CONTACT_SIZE * k
        seen, v = shifted(c, T[at + SEEN_AT]), rates_of(c, T, k)
        F, mu = shifted(c, T[FORCE_AT] + T[at + FIRST]), contact_at(c, T, k)[2 + T[at + REACHES]]
        value = 1.0
        if law == NEVER:
            pass
        elif law == GAP:
            value = seen[0] - c[T[BAND_AT] + k]
        elif law == NORMAL:
            value = F[0] + size
        elif law == REACH:
            value = seen[1 + place]
        elif law == SIDE:
            value = -seen[1 + place]
        elif law == LINE_STOP:
            value = sign * v[1]
        elif law == STOP:
            value = v[1] * v[1] + v[2] * v[2] - STOPPED_SQUARE
        else:
            most = mu * F[0] + (1.0 + mu) * size
            value = most - sign * F[1]
            if law == CONE:
                value = most * most - F[1] * F[1] - F[2] * F[2]
        out[T[EXPRESSIONS] + i] = value


# --- all contacts at one moment ------------------------------------------------------------------


@compiled
def looked(t: float, y: Reals, c: Reals, out: Reals) -> None:
    """Set ``out`` to what decides events: gaps, least reaches, rates, W u' + b without contact forces, u' so, W, the
    change of u' per unit of each contact force, μ, μ_s, e, and the least rates of reaches that are zero. The machine's
    own conditions are enforced.
    """
    T = table(c)
    n, E, m = T[N_U], T[CONTACTS], T[ROWS]
    solve(t, y, c, T)
    looked_at(shifted(T, T[WATCHED]), t, y, c, T)
    free = shifted(out, 2 * E + 2 * m)
    for k in range(n):
        free[k] = c[T[UDOT_AT] + k]
    W, X, size = shifted(free, n), shifted(free, n + m * n), 1.0
    more = shifted(X, m * n)
    for k in range(T[N_Q]):
        size = greater(size, 1.0 + abs(y[k]))
    spare = shifted(c, T[SPARE_AT])
    for k in range(E):
        one, seen = T[CONTACT] + CONTACT_SIZE * k, contact_at(c, T, k)
        v, b, reaches = rates_of(c, T, k), biases_of(c, T, k), T[one + REACHES]
        out[k], out[E + k] = seen[0], INFINITE
        more[3 * E + k] = INFINITE
        for j in range(reaches):
            out[E + k] = lesser(out[E + k], seen[1 + j])
            if abs(seen[1 + j]) <= CLOSED * size:
                more[3 * E + k] = lesser(more[3 * E + k], c[T[one + AWAY_AT] + j])
        for j in range(3):
            more[3 * k + j] = seen[1 + reaches + j]
        for j in range(1 + T[one + TANGENTS]):
            r = T[one + FIRST] + j
            out[2 * E + r] = v[j]
            out[2 * E + m + r] = row_along(c, T, r, free) + b[j]
            row_taken(c, T, r, spare)
            for p in range(n):
                W[r * n + T[T[ORDER] + p]] = spare[p]
            forwarded(c, T, spare)
            for i in range(T[CONDITIONS]):
                c[T[RIGHT_AT] + i] = -product(shifted(c, T[Y_AT] + i * n), spare, n)
            if T[ACTIVE] > 0 and independent(c, T, shifted(T, T[INDEPENDENT]), T[ACTIVE], 0) != 0:
                for i in range(T[CONDITIONS]):
                    for p in range(n):
                        spare[p] += c[T[LAMBDA_AT] + i] * c[T[Y_AT] + i * n + p]
            moved(c, T, spare, shifted(X, r * n))


INFINITE = float("inf")
