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

from ...native.instructions import Integers, Reals, compiled, greater, root, shifted

# Integers: numbers of rows and columns; room for entries of reflections, of R, and of the dependent rows; number of
# reflections; entries of reflections and of R; dependent rows; columns in use and reflections met by the present row.
# Then arrays, in the order of `offset`.
M, N, ROOM, RANK, OF_V, OF_R, REST, TOUCHED, MET = 0, 1, 2, 3, 4, 5, 6, 7, 8
HEAD = 9
# Numbers: part of a row below which it waits for others, and below which it is dependent. Then arrays.
POOR_PART, PART = 0, 1
HEAD_OF_REALS = 2


def integers_needed(m: int, n: int, room: int) -> int:
    """Return the number of integers of the factors."""
    return HEAD + 4 * m + 1 + 5 * n + 6 * (n + 1) + 2 * room


def reals_needed(m: int, n: int, room: int) -> int:
    """Return the number of real numbers of the factors."""
    return HEAD_OF_REALS + 3 * m + 2 * n + 3 * (n + 1) + 3 * room


# -- places -------------------------------------------------------------------------------------------------


@compiled
def chosen_at(f: Integers) -> Integers:
    """For each row, 1 if it is independent of the rows chosen before."""
    return shifted(f, HEAD)


@compiled
def column_of_r_at(f: Integers) -> Integers:
    """For each row, the place of its first entry in R, and after them the numbers of entries."""
    return shifted(f, HEAD + f[M])


@compiled
def dependent_at(f: Integers) -> Integers:
    """The dependent rows."""
    return shifted(f, HEAD + 3 * f[M])


@compiled
def first_at(f: Integers) -> Integers:
    """For each column: the first reflection that touches it, or -1; then 1 if it is a pivot; 1 if the present row
    touches it; the columns that it touches; the reflections that it meets.
    """
    return shifted(f, HEAD + 4 * f[M] + 1)


@compiled
def parent_at(f: Integers) -> Integers:
    """For each reflection: the next one of its front, or -1; then 1 if the present row meets it; its pivot; its row;
    the place of its first entry.
    """
    return shifted(f, HEAD + 4 * f[M] + 1 + 5 * f[N])


@compiled
def columns_of_v_at(f: Integers) -> Integers:
    """Columns of the entries of the reflections; after ``ROOM``, reflections of the entries of R."""
    return shifted(f, HEAD + 4 * f[M] + 1 + 5 * f[N] + 6 * (f[N] + 1))


@compiled
def lengths_at(f: Integers, r: Reals) -> Reals:
    """For each row, its length; then two right sides."""
    return shifted(r, HEAD_OF_REALS)


@compiled
def row_at(f: Integers, r: Reals) -> Reals:
    """The present row by columns; then a vector of the same length."""
    return shifted(r, HEAD_OF_REALS + 3 * f[M])


@compiled
def factors_at(f: Integers, r: Reals) -> Reals:
    """For each reflection: β, and the diagonal of R."""
    return shifted(r, HEAD_OF_REALS + 3 * f[M] + 2 * f[N])


@compiled
def entries_at(f: Integers, r: Reals) -> Reals:
    """Entries of the reflections; after ``ROOM``, those of R; after these, the dependent rows."""
    return shifted(r, HEAD_OF_REALS + 3 * f[M] + 2 * f[N] + 3 * (f[N] + 1))


# -- factors ------------------------------------------------------------------------------------------------


@compiled
def touch(j: int, f: Integers) -> None:
    """Note that the present row has a place in column ``j``, and meets the reflections of its front."""
    n = f[N]
    first = first_at(f)
    mark, touched, path = shifted(first, 2 * n), shifted(first, 3 * n), shifted(first, 4 * n)
    parent = parent_at(f)
    on_path = shifted(parent, n + 1)
    if mark[j] == 0:
        mark[j] = 1
        touched[f[TOUCHED]] = j
        f[TOUCHED] += 1
        k = first[j]
        while k >= 0 and on_path[k] == 0:
            on_path[k] = 1
            path[f[MET]] = k
            f[MET] += 1
            k = parent[k]


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
def reflect(k: int, x: Reals, f: Integers, r: Reals) -> None:
    """Replace x by H_k x."""
    begin = shifted(parent_at(f), 4 * (f[N] + 1))
    columns, v, total = columns_of_v_at(f), entries_at(f, r), 0.0
    for e in range(begin[k], begin[k + 1]):
        total += v[e] * x[columns[e]]
    total *= factors_at(f, r)[k]
    for e in range(begin[k], begin[k + 1]):
        x[columns[e]] -= total * v[e]


@compiled
def reduced(i: int, f: Integers, r: Reals) -> int:
    """Reflect the present row, and put its entries of R in place; return 1 if the room is too small.

    The row is in place by columns, and its columns are touched.
    """
    n, room = f[N], f[ROOM]
    first = first_at(f)
    mark, touched, path = (
        shifted(first, 2 * n),
        shifted(first, 3 * n),
        shifted(first, 4 * n),
    )
    parent = parent_at(f)
    pivot, begin = shifted(parent, 2 * (n + 1)), shifted(parent, 4 * (n + 1))
    columns, x = columns_of_v_at(f), row_at(f, r)
    places, values = shifted(columns, room), shifted(entries_at(f, r), room)
    of_row = column_of_r_at(f)
    sort(path, f[MET])
    of_row[i] = f[OF_R]
    if f[OF_R] + f[MET] > room:
        return 1
    for p in range(f[MET]):
        k = path[p]
        for e in range(begin[k], begin[k + 1]):
            j = columns[e]
            if mark[j] == 0:
                mark[j] = 1
                touched[f[TOUCHED]] = j
                f[TOUCHED] += 1
        reflect(k, x, f, r)
        places[f[OF_R] + p], values[f[OF_R] + p] = k, x[pivot[k]]
    shifted(of_row, f[M])[i] = f[MET]
    return 0


@compiled
def remainder(f: Integers, r: Reals) -> float:
    """Return the length of the present row in columns that are no pivots."""
    n = f[N]
    first, x, total = first_at(f), row_at(f, r), 0.0
    retired, touched = shifted(first, n), shifted(first, 3 * n)
    for p in range(f[TOUCHED]):
        j = touched[p]
        if retired[j] == 0:
            total += x[j] * x[j]
    return root(total)


@compiled
def choose(i: int, length: float, f: Integers, r: Reals) -> int:
    """Add the reflection of the present row, whose remainder has this length; return 1 if the room is too small."""
    n, k, filled = f[N], f[RANK], f[OF_V]
    first, x = first_at(f), row_at(f, r)
    retired, touched, path = shifted(first, n), shifted(first, 3 * n), shifted(first, 4 * n)
    parent = parent_at(f)
    pivot, of_row, begin = (
        shifted(parent, 2 * (n + 1)),
        shifted(parent, 3 * (n + 1)),
        shifted(parent, 4 * (n + 1)),
    )
    columns, v, beta = columns_of_v_at(f), entries_at(f, r), factors_at(f, r)
    if filled + f[TOUCHED] > f[ROOM]:
        return 1
    best, largest = -1, -1.0
    for p in range(f[TOUCHED]):
        j = touched[p]
        if retired[j] == 0 and abs(x[j]) > largest:
            best, largest = j, abs(x[j])
    begin[k] = filled
    for p in range(f[TOUCHED]):
        j = touched[p]
        if retired[j] == 0:
            columns[filled], v[filled] = j, x[j]
            if j == best:
                v[filled] += length if x[j] > 0.0 else -length
            if first[j] < 0:
                first[j] = k
            filled += 1
    begin[k + 1] = filled
    beta[k] = 1.0 / (length * (length + largest))
    beta[n + 1 + k] = -length if x[best] > 0.0 else length
    retired[best], pivot[k], of_row[k], parent[k] = 1, best, i, -1
    for p in range(f[MET]):
        if parent[path[p]] < 0:
            parent[path[p]] = k
    f[OF_V] = filled
    f[OF_R] += f[MET]
    f[RANK] = k + 1
    chosen_at(f)[i] = 1
    return 0


@compiled
def begin_row(
    i: int, G: Reals, pattern: Integers, free: Integers, scale: Reals, f: Integers, r: Reals
) -> int:
    """Put row ``i`` at unit length in place of the present row, reflected; return 1 if the room is too small."""
    n = f[N]
    first, x = first_at(f), row_at(f, r)
    mark, touched, path = shifted(first, 2 * n), shifted(first, 3 * n), shifted(first, 4 * n)
    on_path, columns = shifted(parent_at(f), n + 1), shifted(pattern, f[M] + 1)
    for p in range(f[TOUCHED]):
        x[touched[p]], mark[touched[p]] = 0.0, 0
    for p in range(f[MET]):
        on_path[path[p]] = 0
    f[TOUCHED], f[MET] = 0, 0
    length = lengths_at(f, r)[i]
    for e in range(pattern[i], pattern[i + 1]):
        j = columns[e]
        if free[j] != 0:
            touch(j, f)
            x[j] += G[e] * scale[j] / length
    return reduced(i, f, r)


@compiled
def factorize(
    G: Reals, pattern: Integers, taking_part: Integers, free: Integers, scale: Reals, f: Integers, r: Reals
) -> int:  # fmt: skip
    """Factorize the rows that take part, in their free columns; return 1 if the room is too small.

    A row of which less than POOR_PART remains is chosen only if no later row is better; one of which less than PART
    remains is dependent. ``pattern`` holds the place of the first entry of each row, then the columns of the entries.
    """
    m, n = f[M], f[N]
    first, chosen, length = first_at(f), chosen_at(f), lengths_at(f, r)
    columns, x, on_path = shifted(pattern, m + 1), row_at(f, r), shifted(parent_at(f), n + 1)
    for j in range(n):
        first[j], first[n + j], first[2 * n + j], x[j], on_path[j] = -1, 0, 0, 0.0, 0
    f[RANK], f[OF_V], f[OF_R], f[REST], f[TOUCHED], f[MET] = 0, 0, 0, 0, 0, 0
    largest = 0.0
    for i in range(m):
        chosen[i], length[i] = 0, 0.0
        if taking_part[i] != 0:
            for e in range(pattern[i], pattern[i + 1]):
                if free[columns[e]] != 0:
                    part = G[e] * scale[columns[e]]
                    length[i] += part * part
        length[i] = root(length[i])
        largest = greater(largest, length[i])
    for turn in range(2):
        least = r[POOR_PART] if turn == 0 else r[PART]
        for i in range(m):
            if chosen[i] == 0 and length[i] > least * largest and f[RANK] < n:
                if begin_row(i, G, pattern, free, scale, f, r) != 0:
                    return 1
                rest = remainder(f, r)
                # the round-off of a short row has any direction: compare the rest with the largest row, too
                apart = rest > least and rest * length[i] > r[PART] * largest
                if apart and choose(i, rest, f, r) != 0:
                    return 1
    for i in range(m):
        if chosen[i] == 0 and length[i] > r[PART] * largest:
            if begin_row(i, G, pattern, free, scale, f, r) != 0:
                return 1
            f[OF_R] += f[MET]
            dependent_at(f)[f[REST]] = i
            f[REST] += 1
    return 0


# -- solutions ----------------------------------------------------------------------------------------------


@compiled
def multiples(i: int, gamma: Reals, f: Integers, r: Reals) -> None:
    """Set the multiples of the chosen rows, in order, that make dependent row ``i``, each in its own length."""
    n = f[N]
    of_row, begin = shifted(parent_at(f), 3 * (n + 1)), column_of_r_at(f)
    places, values = shifted(columns_of_v_at(f), f[ROOM]), shifted(entries_at(f, r), f[ROOM])
    diagonal, length, count = shifted(factors_at(f, r), n + 1), lengths_at(f, r), shifted(begin, f[M])
    for k in range(f[RANK]):
        gamma[k] = 0.0
    for e in range(begin[i], begin[i] + count[i]):
        gamma[places[e]] = values[e]
    for k in range(f[RANK] - 1, -1, -1):
        if gamma[k] != 0.0:
            gamma[k] /= diagonal[k]
            c = of_row[k]
            for e in range(begin[c], begin[c] + count[c]):
                gamma[places[e]] -= values[e] * gamma[k]
            gamma[k] *= length[i] / length[c]


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
def balanced(b: Reals, f: Integers, r: Reals) -> int:
    """Replace the right sides of the chosen rows by those of least squares over all rows; return 1 if the room is too
    small.
    """
    count, rank = f[REST], f[RANK]
    if count * (rank + count + 1) > f[ROOM]:
        return 1
    of_row, rows = shifted(parent_at(f), 3 * (f[N] + 1)), dependent_at(f)
    gamma = shifted(entries_at(f, r), 2 * f[ROOM])
    W = shifted(gamma, count * rank)
    d = shifted(W, count * count)
    for p in range(count):
        multiples(rows[p], shifted(gamma, p * rank), f, r)
        d[p] = b[rows[p]]
        for k in range(rank):
            d[p] -= gamma[p * rank + k] * b[of_row[k]]
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
            b[of_row[k]] += gamma[p * rank + k] * d[p]
    return 0


@compiled
def shortest(b: Reals, x: Reals, scale: Reals, f: Integers, r: Reals) -> int:
    """Find ``x`` with the least |G x - b| and, of these, the shortest |S⁻¹ x|; overwrite ``b``. Return 1 if the room is
    too small.
    """
    n = f[N]
    parent = parent_at(f)
    pivot, of_row, begin = shifted(parent, 2 * (n + 1)), shifted(parent, 3 * (n + 1)), column_of_r_at(f)
    places, values = shifted(columns_of_v_at(f), f[ROOM]), shifted(entries_at(f, r), f[ROOM])
    diagonal, length, count = shifted(factors_at(f, r), n + 1), lengths_at(f, r), shifted(begin, f[M])
    z = shifted(row_at(f, r), n)
    if f[REST] > 0 and balanced(b, f, r) != 0:
        return 1
    for j in range(n):
        x[j] = 0.0
    for k in range(f[RANK]):
        c = of_row[k]
        s = b[c] / length[c]
        for e in range(begin[c], begin[c] + count[c]):
            s -= values[e] * z[places[e]]
        z[k] = s / diagonal[k]
        x[pivot[k]] = z[k]
    for k in range(f[RANK] - 1, -1, -1):
        reflect(k, x, f, r)
    for j in range(n):
        x[j] *= scale[j]
    return 0
