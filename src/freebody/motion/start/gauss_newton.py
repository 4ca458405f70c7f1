"""The start of a constrained motion, in compiled code: coordinates by Gauss-Newton steps, then speeds.

    φ(q) = 0        q ← q + q'(q, δ),    G δ = -φ with |δ| least, no |δ_i| above 1
    ψ = G u + g     u ← u + δ,           G δ = -ψ with δᵀ M δ least

If the conditions contradict each other, both are least-squares solutions. They are found from orthogonal factors,

    G P = Q [R11 R12; 0 0],    [R11 R12]ᵀ = Z [S; 0]

with Householder reflections and the longest remaining column first. Dependent conditions and speeds then leave columns
that are zero but for round-off.

Source: G. H. Golub, C. F. Van Loan, Matrix Computations (4th ed., 2013), sections 5.1, 5.4 and 5.5.
"""

from __future__ import annotations

import math

from ...native.instructions import (
    Integers,
    Reals,
    call,
    compiled,
    greater,
    integers_at,
    reals_at,
    root,
    shifted,
    whole,
)
from ..ode.layout import (
    BY_CONDITION,
    COORDINATES,
    DEPENDENT,
    FAR,
    HEAVY,
    LIGHT,
    MET,
    MISSED,
    MOMENT,
    NOWHERE,
    POOR,
    SIZE,
    SMALL,
    STATUS,
    STEPS,
    TORN,
    WORST,
)


@compiled
def reflector(a: Reals, m: int, n: int, k: int, d: Reals) -> float:
    """Reflector of column ``k`` of ``a`` (m, n): put v in place from row k on, and a_kk of the triangle in ``d``;
    return 2 / vᵀv.
    """
    s = 0.0
    for i in range(k, m):
        s += a[i * n + k] * a[i * n + k]
    length, first = root(s), a[k * n + k]
    d[k] = -length if first > 0.0 else length
    a[k * n + k] = first - d[k]
    return 0.0 if length == 0.0 else 1.0 / (length * (length + abs(first)))


@compiled
def reflect(a: Reals, m: int, n: int, k: int, beta: float, b: Reals, columns: int, column: int) -> None:
    """Reflect column ``column`` of ``b`` (m, columns) by v, which is column ``k`` of ``a``."""
    s = 0.0
    for i in range(k, m):
        s += a[i * n + k] * b[i * columns + column]
    s *= beta
    for i in range(k, m):
        b[i * columns + column] -= s * a[i * n + k]


@compiled
def least(a: Reals, m: int, n: int, b: Reals, x: Reals, small: float, room: Reals) -> None:
    """Find the shortest ``x`` with least |a x - b|; overwrite ``a`` (m, n) and ``b``.

    A column is round-off if its remaining length is below ``small`` times the length of the longest column. ``room``
    holds 4 n + n n numbers.
    """
    order, d, solution, rest = room, shifted(room, n), shifted(room, 2 * n), shifted(room, 4 * n)
    for j in range(n):
        order[j] = j
    rank, longest, continuing = 0, 0.0, True
    while continuing and rank < m and rank < n:
        largest, best = -1.0, rank
        for j in range(rank, n):
            s = 0.0
            for i in range(rank, m):
                s += a[i * n + j] * a[i * n + j]
            if s > largest:
                largest, best = s, j
        if rank == 0:
            longest = largest
        if largest <= small * small * longest:
            continuing = False
        else:
            if best != rank:
                for i in range(m):
                    exchanged = a[i * n + rank]
                    a[i * n + rank] = a[i * n + best]
                    a[i * n + best] = exchanged
                exchanged = order[rank]
                order[rank] = order[best]
                order[best] = exchanged
            beta = reflector(a, m, n, rank, d)
            for j in range(rank + 1, n):
                reflect(a, m, n, rank, beta, a, n, j)
            reflect(a, m, n, rank, beta, b, 1, 0)
            rank += 1
    for j in range(n):  # factorize [R11 R12]ᵀ, then solve Sᵀ w = Qᵀ b, x = P Z [w; 0]
        for k in range(rank):
            rest[j * rank + k] = 0.0 if j < k else (d[k] if j == k else a[k * n + j])
        solution[j] = 0.0
    betas = shifted(solution, n)
    for k in range(rank):
        betas[k] = reflector(rest, n, rank, k, d)
        for j in range(k + 1, rank):
            reflect(rest, n, rank, k, betas[k], rest, rank, j)
    for k in range(rank):
        s = b[k]
        for i in range(k):
            s -= rest[i * rank + k] * solution[i]
        solution[k] = s / d[k]
    for k in range(rank - 1, -1, -1):
        reflect(rest, n, rank, k, betas[k], solution, 1, 0)
    for j in range(n):
        x[whole(order[j])] = solution[j]


@compiled
def cholesky(M: Reals, n: int) -> None:
    """Replace ``M`` by its lower factor, which is nan if ``M`` is not positive definite."""
    for i in range(n):
        first = 0  # entries before the first of a row stay zero
        while first < i and M[i * n + first] == 0.0:
            first += 1
        for j in range(first, i + 1):
            s = M[i * n + j]
            for k in range(first, j):
                s -= M[i * n + k] * M[j * n + k]
            M[i * n + j] = root(s) if i == j else s / M[j * n + j]


@compiled
def inverse_trace(L: Reals, n: int, x: Reals) -> float:
    """Return the trace of (L Lᵀ)⁻¹: Σ |x|² over the solutions x of L x = e for all unit vectors e."""
    total = 0.0
    for j in range(n):
        for i in range(j, n):
            s = 1.0 if i == j else 0.0
            for k in range(j, i):
                s -= L[i * n + k] * x[k]
            x[i] = s / L[i * n + i]
            total += x[i] * x[i]
    return total


@compiled
def independent(
    G: Reals, M: Reals, m: int, n: int, chosen: Integers, poor: float, small: float, basis: Reals
) -> None:  # fmt: skip
    """Find the independent rows of ``G``, earlier rows first, measured by the diagonal of ``M``.

    A row of which less than the part ``poor`` remains is kept only if no later row is better. A row of which less than
    ``small`` remains is dependent. ``basis`` holds n (n + 1) numbers: at most n rows are independent.
    """
    count, row, largest = 0, shifted(basis, n * n), 0.0
    for i in range(m):
        s = 0.0
        for j in range(n):
            s += G[i * n + j] * G[i * n + j] / M[j * n + j]
        largest = greater(largest, root(s))
        chosen[i] = 0
    for turn in range(2):
        least_part = poor if turn == 0 else small
        for i in range(m):
            s = 0.0
            for j in range(n):
                row[j] = G[i * n + j] / root(M[j * n + j])
                s += row[j] * row[j]
            length, remainder = root(s), 0.0
            if chosen[i] == 0 and length > least_part * largest and count < n:
                for j in range(n):
                    row[j] /= length
                for _ in range(2):
                    for k in range(count):
                        s = 0.0
                        for j in range(n):
                            s += basis[k * n + j] * row[j]
                        for j in range(n):
                            row[j] -= s * basis[k * n + j]
                for j in range(n):
                    remainder += row[j] * row[j]
                remainder = root(remainder)
                # the round-off of a short row has any direction: compare the rest with the largest row, too
                if remainder > least_part and remainder * length > small * largest:
                    for j in range(n):
                        basis[count * n + j] = row[j] / remainder
                    chosen[i] = 1
                    count += 1


@compiled
def positions(
    conditions: int, moved: int, t: float, y: Reals, n_q: int, n: int, m: int, c: Reals, on_speeds: Integers,
    immobile: Integers, quaternions: Integers, nq: int, numbers: Reals, steps: int, room: Reals,
) -> int:  # fmt: skip
    """Replace the coordinates in ``y`` by coordinates that satisfy the conditions on coordinates.

    Return MET, NOWHERE or FAR.
    """
    residuals = room
    G = shifted(residuals, m)
    a = shifted(G, m * n)
    b = shifted(a, m * n)
    x = shifted(b, m)
    rates = shifted(x, n)
    least_room = shifted(rates, n_q)
    best, stalled = math.inf, 0
    for _ in range(steps):
        for j in range(n):
            y[n_q + j] = 0.0
        call(conditions, t, y, 0, c, residuals, 0)
        rows, columns, size, finite = 0, 0, 0.0, True
        for i in range(m):
            if on_speeds[i] == 0:
                finite = finite and math.isfinite(residuals[i])
                size = greater(size, abs(residuals[i]))
                b[rows] = -residuals[i]
                columns = 0
                for j in range(n):
                    if immobile[j] == 0:
                        finite = finite and math.isfinite(G[i * n + j])
                        columns += 1
                rows += 1
        if not finite:
            return NOWHERE
        stalled = stalled + 1 if size >= best else 0
        best = size if size < best else best
        if size == 0.0 or (stalled >= 2 and size < numbers[SMALL]):
            return MET
        k = 0
        for i in range(m):
            for j in range(n):
                if on_speeds[i] == 0 and immobile[j] == 0:
                    a[k] = G[i * n + j]
                    k += 1
        least(a, rows, columns, b, x, numbers[DEPENDENT], least_room)
        length = 1.0
        for j in range(columns):
            length = greater(length, abs(x[j]))
        k = 0
        for j in range(n):
            if immobile[j] == 0:
                y[n_q + j] = x[k] / length
                k += 1
        call(moved, t, y, 0, c, rates, 0)
        for i in range(n_q):
            y[i] += rates[i]
        for k in range(nq):
            i = quaternions[k]
            length = root(y[i] * y[i] + y[i + 1] * y[i + 1] + y[i + 2] * y[i + 2] + y[i + 3] * y[i + 3])
            for j in range(4):
                y[i + j] /= length
    for j in range(n):
        y[n_q + j] = 0.0
    call(conditions, t, y, 0, c, residuals, 0)
    size = 0.0
    for i in range(m):
        if on_speeds[i] == 0:
            size = greater(size, abs(residuals[i]))
    return MET if size < numbers[SMALL] else FAR


@compiled
def speeds(
    u: Reals, G: Reals, psi: Reals, M: Reals, m: int, n: int, fixed: Integers, numbers: Reals, integers: Integers,
    room: Reals,
) -> int:  # fmt: skip
    """Replace the speeds in ``u`` by speeds that satisfy all conditions. The ``fixed`` speeds do not change.

    Return MET or TORN.
    """
    L = room
    a = shifted(L, n * n)
    b = shifted(a, m * n)
    x = shifted(b, m)
    least_room = shifted(x, n)
    count, k = 0, 0
    for i in range(n):
        if fixed[i] == 0:
            count += 1
            for j in range(n):
                if fixed[j] == 0:
                    L[k] = M[i * n + j]
                    k += 1
    cholesky(L, count)
    for i in range(m):  # G L⁻ᵀ, by rows
        k = 0
        for j in range(n):
            if fixed[j] == 0:
                s = G[i * n + j]
                for p in range(k):
                    s -= L[k * count + p] * a[i * count + p]
                a[i * count + k] = s / L[k * count + k]
                k += 1
        b[i] = -psi[i]
    least(a, m, count, b, x, numbers[DEPENDENT], least_room)
    for k in range(count - 1, -1, -1):
        s = x[k]
        for p in range(k + 1, count):
            s -= L[p * count + k] * x[p]
        x[k] = s / L[k * count + k]
    k = 0
    for j in range(n):
        if fixed[j] == 0:
            u[j] += x[k]
            for i in range(m):
                psi[i] += G[i * n + j] * x[k]
            k += 1
    largest, fastest, worst = 0.0, 0.0, 0
    for j in range(n):
        fastest = greater(fastest, abs(u[j]))
        for i in range(m):
            largest = greater(largest, abs(G[i * n + j]))
    for i in range(m):
        if abs(psi[i]) > abs(psi[worst]):
            worst = i
    integers[WORST] = worst
    numbers[MISSED], numbers[SIZE] = 0.0, 1.0 + largest * fastest
    if m > 0:
        numbers[MISSED] = psi[worst]
    return TORN if abs(numbers[MISSED]) > numbers[DEPENDENT] * numbers[SIZE] else MET


@compiled
def close(arguments: Integers) -> None:
    """Move coordinates and speeds onto the constraints, and find which conditions are independent there.

    ``arguments`` holds the addresses of three kernels of (q, u), which give (φ, G), (ψ, G, M) and q'; the numbers of
    coordinates, speeds, conditions and quaternions; and the addresses of the integers and numbers that are passed in
    and returned (`layout`), of working memory (`layout.closing`) and of the constants of the kernels.
    """
    conditions, motion, moved, n_q, n, m, nq = (
        arguments[0],
        arguments[1],
        arguments[2],
        arguments[3],
        arguments[4],
        arguments[5],
        arguments[6],
    )
    integers, numbers = integers_at(arguments[7]), reals_at(arguments[8])
    room, c = reals_at(arguments[9]), reals_at(arguments[10])
    on_speeds = shifted(integers, BY_CONDITION)
    chosen = shifted(on_speeds, m)
    immobile = shifted(chosen, m)
    fixed = shifted(immobile, n)
    quaternions = shifted(fixed, n)
    t, state, u = numbers[MOMENT], shifted(numbers, COORDINATES), room
    after_u = shifted(room, n)
    for j in range(n):
        u[j] = state[n_q + j]
    integers[STATUS] = positions(
        conditions, moved, t, state, n_q, n, m, c, on_speeds, immobile, quaternions, nq, numbers, integers[STEPS],
        after_u,
    )  # fmt: skip
    for j in range(n):
        state[n_q + j] = u[j]
    if integers[STATUS] != MET:
        return
    psi = after_u
    call(motion, t, state, 0, c, psi, 0)
    G = shifted(psi, m)
    M = shifted(G, m * n)
    rest = shifted(M, n * n)
    # 1 / (least eigenvalue) is the greatest eigenvalue of the inverse, which is at most the trace of the inverse
    for i in range(n):
        for j in range(n):
            rest[i * n + j] = M[i * n + j] / root(M[i * n + i] * M[j * n + j])
    cholesky(rest, n)
    integers[HEAVY] = 1 if inverse_trace(rest, n, shifted(rest, n * n)) * numbers[LIGHT] < 1.0 else 0
    independent(G, M, m, n, chosen, numbers[POOR], numbers[DEPENDENT], rest)
    integers[STATUS] = speeds(shifted(state, n_q), G, psi, M, m, n, fixed, numbers, integers, rest)
