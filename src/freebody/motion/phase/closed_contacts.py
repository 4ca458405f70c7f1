"""The motion of a machine whose contacts are in given modes, in compiled code: modes are data.

Closed contacts are conditions beside those of the machine itself, all with rows G, and forces λ along rows K:

    M u' = f + Kᵀ λ,   G u' = -γ      =>      (G M⁻¹ Kᵀ) λ = -γ - G M⁻¹ f,     M = L D Lᵀ

    stick     rows of N, T             K = G
    slip      row of N                 K = W_N - μ d W_T,   d the direction of slip;  μ = 0: K = G

Only independent conditions (active ones) are imposed. The forces of the others are those of contacts of equal
compliance, in the range of the rows. With S = G M⁻¹ Kᵀ and Q = G M⁻¹ Gᵀ over active and all conditions,

    slip      λ = Qᵀ ν,   S Qᵀ ν = r           no slip    λ = W Qᵀ ν,   Q W Qᵀ ν = r,   r = -γ - G M⁻¹ f

where W = 1 gives the normal forces, and then W = N of the same contact for friction: N is least in norm, and T is the
least in Σ |T|²/N.

Every function but the first ones has the signature of a kernel, f(t, y, c, out); y = (q, u, work, heat of friction). c
is described in `places`. A new set of modes is another table of integers for the same code.
"""

from __future__ import annotations

from ...native.instructions import Integers, Reals, bits, call, compiled, integers_at, lesser, root, shifted
from .elimination import solved
from .places import (
    ACTIVE,
    ALL_OWN,
    ALONG,
    AT,
    CALLED,
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
    ENDING,
    ENDING_SIZE,
    ENDINGS,
    EXPRESSIONS,
    FIRST,
    FORCE_AT,
    FREE_AT,
    G_AT,
    GAP,
    GROUP_AT,
    GROUPS,
    INVERSE_AT,
    IS_ACTIVE,
    K_AT,
    L_AT,
    LAMBDA_AT,
    LAW,
    LINE_CONE,
    LINE_STOP,
    LOAD_AT,
    MACHINE,
    MACHINE_AT,
    MINUS,
    MULTIPLIER_AT,
    N_Q,
    N_U,
    NO_SLIP,
    NORMAL,
    NORMAL_OF,
    ON_SPEEDS,
    ORDER,
    OWN,
    OWN_AT,
    OWN_NUMBER,
    PLACE,
    PLACES,
    PLUS,
    POWER,
    POWER_CONSTANTS,
    REACH,
    REACHES,
    RIGHT_AT,
    ROUNDED,
    ROW,
    ROW_OF,
    ROW_SIZE,
    ROWS,
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
    UDOT_AT,
    V_AT,
    VALUES,
    VALUES_CONSTANTS,
    WATCHED,
    WEIGHT_AT,
    Y_AT,
)

# --- evaluation ----------------------------------------------------------------------------------


@compiled
def evaluated(t: float, y: Reals, c: Reals, T: Integers) -> None:
    """Call the kernel of the machine."""
    call(T[MACHINE], t, y, 0, shifted(c, T[CONSTANTS]), c, T[MACHINE_AT])


@compiled
def looked_at(groups: Integers, t: float, y: Reals, c: Reals, T: Integers) -> None:
    """Call the kernels of some groups of contacts."""
    for i in range(groups[0]):
        g = groups[1 + i]
        call(T[T[GROUPS] + g], t, y, 0, shifted(c, T[CONSTANTS]), c, T[T[GROUP_AT] + g])


@compiled
def contact_at(c: Reals, T: Integers, k: int) -> Reals:
    """Return the outputs of a contact: gap, reaches, μ, μ_s, e, rates, biases."""
    one = T[CONTACT] + CONTACT_SIZE * k
    return shifted(c, T[one + AT])


@compiled
def rates_of(c: Reals, T: Integers, k: int) -> Reals:
    """Return the gap's rate and the slip velocity of a contact."""
    one = T[CONTACT] + CONTACT_SIZE * k
    return shifted(c, T[one + AT] + T[one + REACHES] + 4)


@compiled
def biases_of(c: Reals, T: Integers, k: int) -> Reals:
    """Return b of d(W u + w)/dt = W u' + b of a contact."""
    one = T[CONTACT] + CONTACT_SIZE * k
    return shifted(c, T[one + AT] + T[one + REACHES] + 5 + T[one + TANGENTS])


@compiled
def forwarded(c: Reals, T: Integers, v: Reals) -> None:
    """Replace v, in the order of elimination, by L⁻¹ v."""
    L, starts, places = shifted(c, T[L_AT]), T[STARTS], T[PLACES]
    for k in range(T[N_U]):
        if v[k] != 0.0:
            for p in range(T[starts + k], T[starts + k + 1]):
                v[T[places + p]] -= L[p] * v[k]


@compiled
def moved(c: Reals, T: Integers, v: Reals, step: Reals) -> None:
    """Set ``step``, in the order of the speeds, to (D Lᵀ)⁻¹ v; v is in the order of elimination and is overwritten."""
    L, D, starts, places, n = shifted(c, T[L_AT]), shifted(c, T[INVERSE_AT]), T[STARTS], T[PLACES], T[N_U]
    for k in range(n - 1, -1, -1):
        x = v[k] * D[k]
        for p in range(T[starts + k], T[starts + k + 1]):
            x -= L[p] * v[T[places + p]]
        v[k] = x
    for k in range(n):
        step[T[T[ORDER] + k]] = v[k]


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


@compiled
def product(a: Reals, b: Reals, n: int) -> float:
    """Return a · b."""
    total = 0.0
    for k in range(n):
        total += a[k] * b[k]
    return total


@compiled
def friction_along(c: Reals, T: Integers, one: int, j: int) -> float:
    """Return the friction of a slipping contact along tangent j, per unit of normal force: -μ d_j."""
    slip, k = T[one + SLIP], T[one + SOURCE]
    at = T[CONTACT] + CONTACT_SIZE * k
    mu = contact_at(c, T, k)[1 + T[at + REACHES]]
    if slip == PLUS:
        return -mu
    if slip == MINUS:
        return mu
    v = rates_of(c, T, k)
    return -mu * v[1 + j] / root(v[1] * v[1] + v[2] * v[2])


# --- conditions ----------------------------------------------------------------------------------


@compiled
def rows_made(c: Reals, T: Integers) -> None:
    """Set the rows L⁻¹ Gᵀ, D⁻¹ L⁻¹ Gᵀ and L⁻¹ Kᵀ of all conditions."""
    n, D = T[N_U], shifted(c, T[INVERSE_AT])
    for i in range(T[CONDITIONS]):
        one = T[CONDITION] + CONDITION_SIZE * i
        k = T[one + SOURCE]
        Y, V, K = shifted(c, T[Y_AT] + i * n), shifted(c, T[V_AT] + i * n), shifted(c, T[K_AT] + i * n)
        if k < 0:
            own = shifted(c, T[OWN_AT] + (-1 - k) * (3 + n) + 3)
            for j in range(n):
                Y[j] = own[j]
        else:
            row_taken(c, T, T[T[CONTACT] + CONTACT_SIZE * k + FIRST] + T[one + ROW_OF], Y)
            forwarded(c, T, Y)
        for j in range(n):
            V[j] = D[j] * Y[j]
            K[j] = Y[j]
        if T[one + SLIP] != NO_SLIP:
            spare = shifted(c, T[SPARE_AT])
            first = T[T[CONTACT] + CONTACT_SIZE * k + FIRST]
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
    n, count, active = T[N_U], T[CONDITIONS], T[ACTIVE]
    square, nu, lam, weight = (
        shifted(c, T[SQUARE_AT]),
        shifted(c, T[SQUARE_AT] + active * active),
        shifted(c, T[LAMBDA_AT]),
        shifted(c, T[WEIGHT_AT]),
    )
    S, Q = shifted(c, T[G_AT]), shifted(c, T[G_AT] + active * count)
    a = 0
    for i in range(count):
        weight[i] = 1.0
        if T[T[CONDITION] + CONDITION_SIZE * i + IS_ACTIVE] != 0:
            for j in range(count):
                S[a * count + j] = product(shifted(c, T[V_AT] + i * n), shifted(c, T[K_AT] + j * n), n)
                Q[a * count + j] = product(shifted(c, T[V_AT] + i * n), shifted(c, T[Y_AT] + j * n), n)
            a += 1
    for turn in range(1 if T[SLIPPING] != 0 else 2):
        a = 0
        for i in range(count):
            if T[T[CONDITION] + CONDITION_SIZE * i + IS_ACTIVE] != 0:
                nu[a] = c[T[RIGHT_AT] + i]
                for b in range(active):
                    total = 0.0
                    for j in range(count):
                        total += S[a * count + j] * weight[j] * Q[b * count + j]
                    square[a * active + b] = total
                a += 1
        if solved(square, active, nu) == 0:
            return 0
        for j in range(count):
            total = 0.0
            for b in range(active):
                total += nu[b] * Q[b * count + j]
            lam[j] = weight[j] * total
        if turn == 0:
            for j in range(count):
                normal = T[T[CONDITION] + CONDITION_SIZE * j + NORMAL_OF]
                if normal >= 0:
                    weight[j] = lam[normal]
    return 1


@compiled
def independent(c: Reals, T: Integers, positions: int) -> int:
    """Set λ with the active conditions for ``RIGHT``, and 0 for the others; return 0 if they do not exist, else 1.

    If ``positions`` is 1, those that restrict speeds only are left out, and K = G.
    """
    n, count, lam, square = T[N_U], T[CONDITIONS], shifted(c, T[LAMBDA_AT]), shifted(c, T[SQUARE_AT])
    right, K = shifted(c, T[SQUARE_AT] + T[ACTIVE] * T[ACTIVE]), T[Y_AT] if positions >= 1 else T[K_AT]
    size = 0
    for i in range(count):
        lam[i] = 0.0
        if taking_part(T, i, positions) != 0:
            size += 1
    a = 0
    for i in range(count):
        if taking_part(T, i, positions) != 0:
            right[a] = c[T[RIGHT_AT] + i]
            b = 0
            for j in range(count):
                if taking_part(T, j, positions) != 0:
                    square[a * size + b] = product(shifted(c, T[V_AT] + i * n), shifted(c, K + j * n), n)
                    b += 1
            a += 1
    if solved(square, size, right) == 0:
        return 0
    a = 0
    for i in range(count):
        if taking_part(T, i, positions) != 0:
            lam[i] = right[a]
            a += 1
    return 1


@compiled
def taking_part(T: Integers, i: int, positions: int) -> int:
    """Return 1 for an active condition, if ``positions`` is 1 only for one that restricts coordinates; else 0."""
    one = T[CONDITION] + CONDITION_SIZE * i
    k = T[one + SOURCE]
    if T[one + IS_ACTIVE] == 0:
        return 0
    if positions != 1:
        return 1
    if k < 0:
        return 1 - T[T[ON_SPEEDS] - 1 - k]
    return 1 if T[one + ROW_OF] == 0 else 0


@compiled
def solve(t: float, y: Reals, c: Reals, T: Integers) -> int:
    """Set accelerations, contact forces and multipliers; return 0 if a condition has lost its independence, else 1."""
    n, count = T[N_U], T[CONDITIONS]
    evaluated(t, y, c, T)
    looked_at(shifted(T, T[CALLED]), t, y, c, T)
    w, z, F = shifted(c, T[STEP_AT]), shifted(c, T[FREE_AT]), shifted(c, T[FORCE_AT])
    rows_made(c, T)
    for i in range(count):
        c[T[RIGHT_AT] + i] = -(gamma_of(c, T, i) + product(shifted(c, T[V_AT] + i * n), z, n))
    good = 1
    if count > T[ACTIVE]:
        good = shared(c, T)
    elif count > 0:
        good = independent(c, T, 0)
    for k in range(n):
        w[k] = z[k]
    for r in range(T[ROWS]):
        F[r] = 0.0
    for i in range(T[ALL_OWN]):
        c[T[MULTIPLIER_AT] + i] = 0.0
    for i in range(count):
        one = T[CONDITION] + CONDITION_SIZE * i
        x, K, source = c[T[LAMBDA_AT] + i], shifted(c, T[K_AT] + i * n), T[one + SOURCE]
        for k in range(n):
            w[k] += x * K[k]
        if source < 0:
            c[T[MULTIPLIER_AT] + T[T[OWN_NUMBER] - 1 - source]] = x
        else:
            at = T[CONTACT] + CONTACT_SIZE * source
            first = T[at + FIRST]
            F[first + T[one + ROW_OF]] = x
            if T[one + SLIP] != NO_SLIP:
                for j in range(T[at + TANGENTS]):
                    F[first + 1 + j] = x * friction_along(c, T, one, j)
    moved(c, T, w, shifted(c, T[UDOT_AT]))
    return good


# --- kernels of a phase --------------------------------------------------------------------------


@compiled
def table(c: Reals) -> Integers:
    """Return the table of integers of a phase."""
    return integers_at(bits(c[0]))


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
    power = c[T[LOAD_AT]]
    if T[POWER] != 0:
        extended(y, c, T)
        call(T[POWER], t, c, T[STATE_AT], shifted(c, T[POWER_CONSTANTS]), out, n_q + n)
        power += out[n_q + n]
    out[n_q + n] = power - heat
    out[n_q + n + 1] = heat


NAN = float("nan")


@compiled
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
    looked_at(shifted(T, T[CALLED]), t, y, c, T)
    looked_at(shifted(T, T[WATCHED]), t, y, c, T)
    for k in range(T[CONTACTS]):
        out[k] = contact_at(c, T, k)[0]


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
    evaluated(t, y, c, T)
    looked_at(shifted(T, T[CALLED]), t, y, c, T)
    corrected(c, T, 1)
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
    corrected(c, T, 2)
    for i in range(n):
        out[n_q + i] = y[n_q + i] + c[T[UDOT_AT] + i]


@compiled
def corrected(c: Reals, T: Integers, way: int) -> None:
    """Set ``UDOT`` to the least step that cancels the residuals (``way`` 1) or the rates (2) of active conditions."""
    n = T[N_U]
    rows_made(c, T)
    for i in range(T[CONDITIONS]):
        one = T[CONDITION] + CONDITION_SIZE * i
        k = T[one + SOURCE]
        if k < 0:
            own = T[OWN_AT] + (-1 - k) * (3 + n)
            c[T[RIGHT_AT] + i] = -c[own] if way == 1 else -c[own + 1]
        elif way == 1:
            c[T[RIGHT_AT] + i] = -contact_at(c, T, k)[0]
        else:
            c[T[RIGHT_AT] + i] = -rates_of(c, T, k)[T[one + ROW_OF]]
    good = independent(c, T, way)
    w = shifted(c, T[STEP_AT])
    for k in range(n):
        w[k] = 0.0 if good != 0 else NAN
    for i in range(T[CONDITIONS]):
        x, Y = c[T[LAMBDA_AT] + i], shifted(c, T[Y_AT] + i * n)
        if x != 0.0:
            for k in range(n):
                w[k] += x * Y[k]
    moved(c, T, w, shifted(c, T[UDOT_AT]))


# --- endings -------------------------------------------------------------------------------------


@compiled
def parts_of_forces(c: Reals, T: Integers) -> float:
    """Return the sum of the parts of the forces of all closed contacts, each as if it were the only condition:

        λ_i = -(γ_i + Σ_j w_j f_j)/(G M⁻¹ Gᵀ)_ii,      of which |γ_i| and all |w_j f_j| are summed
    """
    n, z, total = T[N_U], shifted(c, T[FREE_AT]), 0.0
    for i in range(T[OWN], T[CONDITIONS]):
        if T[T[CONDITION] + CONDITION_SIZE * i + IS_ACTIVE] != 0:
            V, Y = shifted(c, T[V_AT] + i * n), shifted(c, T[Y_AT] + i * n)
            size = abs(gamma_of(c, T, i))
            for k in range(n):
                size += abs(V[k] * z[k])
            total += size / product(V, Y, n)
    return total


@compiled
def watched(t: float, y: Reals, c: Reals, out: Reals) -> None:
    """Set ``out`` to the functions of the user, then to the functions that end the phase as they fall through zero."""
    T = table(c)
    if T[EXPRESSIONS] > 0:
        call(T[VALUES], t, y, 0, shifted(c, T[VALUES_CONSTANTS]), out, 0)
    size = 0.0
    if T[CONDITIONS] > T[OWN]:
        solve(t, y, c, T)
        size = ROUNDED * parts_of_forces(c, T)
    looked_at(shifted(T, T[WATCHED]), t, y, c, T)
    for i in range(T[ENDINGS]):
        one = T[ENDING] + ENDING_SIZE * i
        k, law, sign, place = T[one + CONTACT_OF], T[one + LAW], T[one + SIGN], T[one + PLACE]
        seen, v = contact_at(c, T, k), rates_of(c, T, k)
        at = T[CONTACT] + CONTACT_SIZE * k
        F, mu = shifted(c, T[FORCE_AT] + T[at + FIRST]), seen[2 + T[at + REACHES]]
        value = 0.0
        if law == GAP:
            value = seen[0]
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
    change of u' per unit of each contact force, and μ, μ_s, e. The machine's own conditions are enforced.
    """
    T = table(c)
    n, E, m = T[N_U], T[CONTACTS], T[ROWS]
    solve(t, y, c, T)
    looked_at(shifted(T, T[WATCHED]), t, y, c, T)
    free = shifted(out, 2 * E + 2 * m)
    for k in range(n):
        free[k] = c[T[UDOT_AT] + k]
    W, X = shifted(free, n), shifted(free, n + m * n)
    spare, D = shifted(c, T[SPARE_AT]), shifted(c, T[INVERSE_AT])
    for k in range(E):
        one, seen = T[CONTACT] + CONTACT_SIZE * k, contact_at(c, T, k)
        v, b, reaches = rates_of(c, T, k), biases_of(c, T, k), T[one + REACHES]
        out[k], out[E + k] = seen[0], INFINITE
        for j in range(reaches):
            out[E + k] = lesser(out[E + k], seen[1 + j])
        for j in range(3):
            out[2 * E + 2 * m + n + 2 * m * n + 3 * k + j] = seen[1 + reaches + j]
        for j in range(1 + T[one + TANGENTS]):
            r = T[one + FIRST] + j
            out[2 * E + r] = v[j]
            out[2 * E + m + r] = row_along(c, T, r, free) + b[j]
            row_taken(c, T, r, spare)
            for p in range(n):
                W[r * n + T[T[ORDER] + p]] = spare[p]
            forwarded(c, T, spare)
            for i in range(T[CONDITIONS]):
                c[T[RIGHT_AT] + i] = -product(shifted(c, T[V_AT] + i * n), spare, n)
            if T[CONDITIONS] > 0 and independent(c, T, 2) != 0:
                for i in range(T[CONDITIONS]):
                    for p in range(n):
                        spare[p] += c[T[LAMBDA_AT] + i] * c[T[Y_AT] + i * n + p]
            moved(c, T, spare, shifted(X, r * n))


INFINITE = float("inf")
