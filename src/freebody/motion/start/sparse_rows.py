"""Sparse rows G, factorized in their order: which are independent, and the shortest solution of G δ = b.

    (G S)ᵀ = H_1 H_2 ... H_r R        H_k = 1 - β_k v_k v_kᵀ (Householder), S a diagonal scale of the columns

Each row is brought to unit length and reflected by the H_k of the columns that it shares with earlier rows. What then
remains of it, in columns that are no pivots yet, is its part that is independent of them. A row of which enough remains
adds a reflection and takes one of these columns as its pivot; the others of these columns form a front. Rows that touch
a front meet its reflections and no others: in a row of loops the fronts have constant width, and the cost is linear.

If rows are dependent, δ solves the equations of least squares with the multiples C of the chosen rows,

    v = b_a + Γᵀ (1 + Γ Γᵀ)⁻¹ (b_d - Γ b_a),   Γ = C in rows of their own lengths,   δ = S H_1 ... H_r R⁻ᵀ v.

Source: T. A. Davis, Direct Methods for Sparse Linear Systems (2006), chapter 5; M. T. Heath, Some extensions of an
algorithm for sparse linear least squares problems, SIAM J. Sci. Stat. Comput. 3 (1982) 223 (dependent columns).
"""

from __future__ import annotations

from ...native.instructions import Integers, Reals, compiled, greater, root
from .closing_record import SparseRows

# -- factors ------------------------------------------------------------------------------------------------


@compiled
def touch(j: int, rows: SparseRows) -> None:
    """Note that the present row has a place in column ``j``, and meets the reflections of its front."""
    if rows.marked[j] == 0:
        mark(j, rows)
        k = rows.first[j]
        while k >= 0 and rows.met[k] == 0:
            rows.met[k] = 1
            rows.path[rows.meets] = k
            rows.meets += 1
            k = rows.next[k]


@compiled
def mark(j: int, rows: SparseRows) -> None:
    """Note that the present row has a place in column ``j``."""
    rows.marked[j] = 1
    rows.touched[rows.touches] = j
    rows.touches += 1


@compiled
def sort(a: Integers, count: int) -> None:
    """Sort by shells of shrinking width."""
    gap = count // 2
    while gap > 0:
        for i in range(gap, count):
            x, k = a[i], i
            while k >= gap and a[k - gap] > x:
                a[k] = a[k - gap]
                k -= gap
            a[k] = x
        gap = gap // 2


@compiled
def reflect(k: int, x: Reals, rows: SparseRows) -> None:
    """Replace x by H_k x."""
    total = 0.0
    for e in range(rows.starts_v[k], rows.starts_v[k + 1]):
        total += rows.v[e] * x[rows.columns_v[e]]
    total *= rows.beta[k]
    for e in range(rows.starts_v[k], rows.starts_v[k + 1]):
        x[rows.columns_v[e]] -= total * rows.v[e]


@compiled
def reduced(i: int, rows: SparseRows) -> int:
    """Reflect the present row, and put its entries of R in place; return 1 if the room is too small.

    The row is in place by columns, and its columns are touched.
    """
    sort(rows.path, rows.meets)
    filled = rows.starts_r[i] = rows.filled_r
    if filled + rows.meets > rows.room_of_factors:
        return 1
    for p in range(rows.meets):
        k = rows.path[p]
        for e in range(rows.starts_v[k], rows.starts_v[k + 1]):
            if rows.marked[rows.columns_v[e]] == 0:
                mark(rows.columns_v[e], rows)
        reflect(k, rows.x, rows)
        rows.rows_r[filled + p], rows.values[filled + p] = k, rows.x[rows.pivot[k]]
    rows.count_r[i] = rows.meets
    return 0


@compiled
def remainder(rows: SparseRows) -> float:
    """Return the length of the present row in columns that are no pivots."""
    total = 0.0
    for p in range(rows.touches):
        j = rows.touched[p]
        if rows.retired[j] == 0:
            total += rows.x[j] * rows.x[j]
    return root(total)


@compiled
def choose(i: int, length: float, rows: SparseRows) -> int:
    """Add the reflection of the present row, whose remainder has this length; return 1 if the room is too small."""
    k, filled, x = rows.rank, rows.filled_v, rows.x
    if filled + rows.touches > rows.room_of_factors:
        return 1
    best, largest = -1, -1.0
    for p in range(rows.touches):
        j = rows.touched[p]
        if rows.retired[j] == 0 and abs(x[j]) > largest:
            best, largest = j, abs(x[j])
    rows.starts_v[k] = filled
    for p in range(rows.touches):
        j = rows.touched[p]
        if rows.retired[j] == 0:
            rows.columns_v[filled], rows.v[filled] = j, x[j]
            if j == best:
                rows.v[filled] += length if x[j] > 0.0 else -length
            if rows.first[j] < 0:
                rows.first[j] = k
            filled += 1
    rows.starts_v[k + 1] = filled
    rows.beta[k] = 1.0 / (length * (length + largest))
    rows.diagonal[k] = -length if x[best] > 0.0 else length
    rows.retired[best], rows.pivot[k], rows.of_row[k], rows.next[k] = 1, best, i, -1
    for p in range(rows.meets):
        if rows.next[rows.path[p]] < 0:
            rows.next[rows.path[p]] = k
    rows.filled_v = filled
    rows.filled_r += rows.meets
    rows.rank = k + 1
    rows.chosen[i] = 1
    return 0


@compiled
def begin_row(i: int, G: Reals, scale: Reals, rows: SparseRows) -> int:
    """Put row ``i`` at unit length in place of the present row, reflected; return 1 if the room is too small."""
    for p in range(rows.touches):
        rows.x[rows.touched[p]], rows.marked[rows.touched[p]] = 0.0, 0
    for p in range(rows.meets):
        rows.met[rows.path[p]] = 0
    rows.touches = rows.meets = 0
    for e in range(rows.starts[i], rows.starts[i + 1]):
        j = rows.columns[e]
        if rows.free[j] != 0:
            touch(j, rows)
            rows.x[j] += G[e] * scale[j] / rows.length[i]
    return reduced(i, rows)


@compiled
def begin_factors(G: Reals, scale: Reals, rows: SparseRows) -> float:
    """Set the lengths of the rows, and the factors of none; return the largest length."""
    for j in range(rows.n_columns):
        rows.first[j], rows.retired[j], rows.marked[j], rows.x[j], rows.met[j] = -1, 0, 0, 0.0, 0
    rows.rank = rows.filled_v = rows.filled_r = rows.rests = rows.touches = rows.meets = 0
    largest = 0.0
    for i in range(rows.n_rows):
        rows.chosen[i], square = 0, 0.0
        if rows.taking_part[i] != 0:
            for e in range(rows.starts[i], rows.starts[i + 1]):
                j = rows.columns[e]
                if rows.free[j] != 0:
                    square += G[e] * scale[j] * (G[e] * scale[j])
        rows.length[i] = root(square)
        largest = greater(largest, rows.length[i])
    return largest


@compiled
def factorize(G: Reals, scale: Reals, rows: SparseRows) -> int:
    """Factorize the rows that take part, in their free columns; return 1 if the room is too small.

    A row of which less than ``poor`` remains is chosen only if no later row is better; one of which less than ``least``
    remains is dependent.
    """
    largest, length = begin_factors(G, scale, rows), rows.length
    for turn in range(2):
        least = rows.poor if turn == 0 else rows.least
        for i in range(rows.n_rows):
            if rows.chosen[i] == 0 and length[i] > least * largest and rows.rank < rows.n_columns:
                if begin_row(i, G, scale, rows) != 0:
                    return 1
                rest = remainder(rows)
                # the round-off of a short row has any direction: compare the rest with the largest row, too
                apart = rest > least and rest * length[i] > rows.least * largest
                if apart and choose(i, rest, rows) != 0:
                    return 1
    for i in range(rows.n_rows):
        if rows.chosen[i] == 0 and length[i] > rows.least * largest:
            if begin_row(i, G, scale, rows) != 0:
                return 1
            rows.filled_r += rows.meets
            rows.dependent[rows.rests] = i
            rows.rests += 1
    return 0


# -- solutions ----------------------------------------------------------------------------------------------


@compiled
def multiples(i: int, gamma: Reals, rows: SparseRows) -> None:
    """Set the multiples of the chosen rows, in order, that make dependent row ``i``, each in its own length."""
    for k in range(rows.rank):
        gamma[k] = 0.0
    for e in range(rows.starts_r[i], rows.starts_r[i] + rows.count_r[i]):
        gamma[rows.rows_r[e]] = rows.values[e]
    for k in range(rows.rank - 1, -1, -1):
        if gamma[k] != 0.0:
            gamma[k] /= rows.diagonal[k]
            c = rows.of_row[k]
            for e in range(rows.starts_r[c], rows.starts_r[c] + rows.count_r[c]):
                gamma[rows.rows_r[e]] -= rows.values[e] * gamma[k]
            gamma[k] *= rows.length[i] / rows.length[c]


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
def balanced(b: Reals, rows: SparseRows) -> int:
    """Replace the right sides of the chosen rows by those of least squares over all rows; return 1 if the room is too
    small.
    """
    count, rank = rows.rests, rows.rank
    if count * (rank + count + 1) > rows.room_of_factors:
        return 1
    gamma = rows.dense
    W, d = gamma[count * rank :], gamma[count * (rank + count) :]
    for p in range(count):
        multiples(rows.dependent[p], gamma[p * rank :], rows)
        d[p] = b[rows.dependent[p]]
        for k in range(rank):
            d[p] -= gamma[p * rank + k] * b[rows.of_row[k]]
        for q in range(p + 1):
            s = 1.0 if p == q else 0.0
            for k in range(rank):
                s += gamma[p * rank + k] * gamma[q * rank + k]
            W[p * count + q] = s
    cholesky(W, count)
    for p in range(count):
        for q in range(p):
            d[p] -= W[p * count + q] * d[q]
        d[p] /= W[p * count + p]
    for p in range(count - 1, -1, -1):
        for q in range(p + 1, count):
            d[p] -= W[q * count + p] * d[q]
        d[p] /= W[p * count + p]
        for k in range(rank):
            b[rows.of_row[k]] += gamma[p * rank + k] * d[p]
    return 0


@compiled
def shortest(b: Reals, x: Reals, scale: Reals, rows: SparseRows) -> int:
    """Find ``x`` with the least |G x - b| and, of these, the shortest |S⁻¹ x|; overwrite ``b``. Return 1 if the room is
    too small.
    """
    if rows.rests > 0 and balanced(b, rows) != 0:
        return 1
    for j in range(rows.n_columns):
        x[j] = 0.0
    for k in range(rows.rank):
        c = rows.of_row[k]
        s = b[c] / rows.length[c]
        for e in range(rows.starts_r[c], rows.starts_r[c] + rows.count_r[c]):
            s -= rows.values[e] * rows.z[rows.rows_r[e]]
        rows.z[k] = s / rows.diagonal[k]
        x[rows.pivot[k]] = rows.z[k]
    for k in range(rows.rank - 1, -1, -1):
        reflect(k, x, rows)
    for j in range(rows.n_columns):
        x[j] *= scale[j]
    return 0
