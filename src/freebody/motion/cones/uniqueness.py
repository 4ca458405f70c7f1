"""Whether the motion that solves a contact problem is the only one, and determines its forces, in compiled code."""

from __future__ import annotations

from ...native.instructions import Reals, compiled, greater, root
from .block_rows import dot
from .contacts import Contacts
from .newton import factor

SMALL = 1e-10
"""Part of a row of A below which it depends on others."""


@compiled
def unique(contacts: Contacts, n: int) -> int:
    """Return 1 if it is proven that no two motions satisfy the laws, whatever c is, else 0; A = H Hᵀ has rank n.

    For the differences δ of the forces of two solutions, A = H Hᵀ and w = Hᵀ δ, the laws of normal and friction give

        w·w = δ·A δ <= Σ μ |δN| |H_T w| <= Σ wᵀ (α PᵀP + μ² H_TᵀH_T/α) w/2     for every α > 0 in each term

    with δN = P w, P = H_N (HᵀH)⁻¹, if no forces in balance have normal parts. The sum is over the frictions, and over
    the moments that a normal force bounds. So w = 0 where the greatest eigenvalue is below 2; α = |μ H_T|/|P| makes the
    trace of each term least. Friction with a given bound is monotone: it adds nothing to the sum. A contact at rest has
    its static friction; what slips under it is released to its kinetic friction afterwards (`decision`).
    """
    m, most = contacts.rows, 0.0
    for i in range(contacts.contacts):
        most = greater(most, bound_by(contacts, i))
    if most == 0.0:
        return 1
    if normal_parts(contacts, n) == 0:
        return 0
    H, P, M = contacts.factors, contacts.H, contacts.normal
    for p in range(n * n):
        M[p] = 0.0
    for p in range(n):
        M[p * n + p] = 2.0
    for i in range(contacts.contacts):
        a, mu, p, along = contacts.at[i], bound_by(contacts, i), contacts.presser[i], 0.0
        normal = P[contacts.at[p if p >= 0 else i] * m :]
        for r in range(a + 1, a + 1 + contacts.tangents[i]):
            along += mu * mu * dot(H[r * m :], H[r * m :], n)
        if along > 0.0:
            part = root(along / dot(normal, normal, n))
            subtract(M, normal, part, n)
            for r in range(a + 1, a + 1 + contacts.tangents[i]):
                subtract(M, H[r * m :], mu * mu / part, n)
    return definite(M, n)


@compiled
def bound_by(contacts: Contacts, i: int) -> float:
    """Return the coefficient by which a normal force that is an unknown bounds the friction of a contact, or 0."""
    if is_held(contacts, i) != 0 and contacts.presser[i] < 0:
        return 0.0
    return contacts.friction[i] if contacts.slides[i] != 0 else contacts.static[i]


@compiled
def behind(contacts: Contacts, i: int) -> int:
    """Return the place after a contact and what resists its rolling and spinning, which follows it."""
    last = i + 1
    while last < contacts.contacts and contacts.presser[last] == i:
        last += 1
    return last


@compiled
def is_held(contacts: Contacts, i: int) -> int:
    """Return 1 if a contact has no normal force of its own that moves something, such as the friction of a joint."""
    return contacts.held[i]


@compiled
def held(contacts: Contacts) -> int:
    """Return the number of contacts without a normal force of their own that moves something."""
    result = 0
    for i in range(contacts.contacts):
        result += is_held(contacts, i)
    return result


@compiled
def normal_parts(contacts: Contacts, n: int) -> int:
    """Set the rows of P; return 0 if forces in balance have normal parts, else 1."""
    m, H, G, P = contacts.rows, contacts.factors, contacts.slope, contacts.H
    for p in range(n):
        for q in range(p + 1):
            G[p * n + q] = 0.0
    for r in range(m):
        row = H[r * m :]
        for p in range(n):
            for q in range(p + 1 if row[p] != 0.0 else 0):
                G[p * n + q] += row[p] * row[q]
    if definite(G, n) == 0:
        return 0
    for i in range(contacts.contacts):
        a = contacts.at[i]
        for p in range(n):
            P[a * m + p] = H[a * m + p]
        if is_held(contacts, i) != 0:
            continue
        divide(G, P[a * m :], n)
        if n < m - held(contacts) and abs(1.0 - dot(P[a * m :], H[a * m :], n)) > root(SMALL):
            return 0
    return 1


@compiled
def divide(factors: Reals, x: Reals, n: int) -> None:
    """Replace x by the solution of L Lᵀ y = x, with the factors of `definite`."""
    for p in range(n):
        x[p] = (x[p] - dot(factors[p * n :], x, p)) / factors[p * n + p]
    for p in range(n - 1, -1, -1):
        x[p] /= factors[p * n + p]
        for q in range(p):
            x[q] -= factors[p * n + q] * x[p]


@compiled
def subtract(M: Reals, x: Reals, part: float, n: int) -> None:
    """Subtract ``part`` x xᵀ from a matrix."""
    for p in range(n):
        for q in range(n):
            M[p * n + q] -= part * x[p] * x[q]


@compiled
def definite(M: Reals, n: int) -> int:
    """Return 1 if a symmetric matrix is positive definite, else 0; overwrite its lower half by Cholesky's factor L."""
    for k in range(n):
        if not M[k * n + k] > 0.0:
            return 0
        pivot = root(M[k * n + k])
        for i in range(k, n):
            M[i * n + k] /= pivot
        for i in range(k + 1, n):
            for j in range(k + 1, i + 1):
                M[i * n + j] -= M[i * n + k] * M[j * n + k]
    return 1


@compiled
def alone(contacts: Contacts) -> int:
    """Return 1 if all contacts slide, or have no friction, and every principal minor of S is positive, else 0.

    S are the normal rates per unit of the forces along the rays; the forces are then unique, whatever c is (R. Cottle,
    J.-S. Pang, R. Stone, The Linear Complementarity Problem, theorem 3.3.7).
    """
    m, k, S = contacts.rows, contacts.contacts, contacts.H
    for i in range(k):
        if contacts.slides[i] == 0 and contacts.tangents[i] > 0 and contacts.static[i] > 0.0:
            return 0
        for j in range(k):
            S[i * k + j] = contacts.A[contacts.at[i] * m + contacts.at[j]]
            for s in range(j, behind(contacts, j)):
                for d in range(contacts.tangents[s] if contacts.slides[s] != 0 else 0):
                    ray = -contacts.friction[s] * contacts.way[2 * s + d]
                    S[i * k + j] += ray * contacts.A[contacts.at[i] * m + contacts.at[s] + 1 + d]
            if is_held(contacts, i) != 0 or is_held(contacts, j) != 0:  # a given force
                S[i * k + j] = 1.0 if i == j else 0.0
    if k > 8:
        return 0
    for chosen in range(1, 1 << k):
        if minor(contacts, S, k, chosen) == 0:
            return 0
    return 1


@compiled
def minor(contacts: Contacts, S: Reals, k: int, chosen: int) -> int:
    """Return 1 if a principal minor of S is positive, well above its round-off, else 0."""
    part, n, sign = contacts.slope, 0, 1.0
    for i in range(k):
        if (chosen >> i) & 1 != 0:
            q = 0
            for j in range(k):
                if (chosen >> j) & 1 != 0:
                    contacts.normal[n * k + q] = S[i * k + j] / root(abs(S[i * k + i] * S[j * k + j]))
                    q += 1
            n += 1
    for i in range(n):
        for j in range(n):
            part[i * n + j] = contacts.normal[i * k + j]
    for c in range(n):
        p = c
        for i in range(c + 1, n):
            if abs(part[i * n + c]) > abs(part[p * n + c]):
                p = i
        if not abs(part[p * n + c]) > SMALL:
            return 0
        if p != c:
            sign = -sign
            for j in range(n):
                part[p * n + j], part[c * n + j] = part[c * n + j], part[p * n + j]
        sign = sign if part[c * n + c] > 0.0 else -sign
        for i in range(c + 1, n):
            x = part[i * n + c] / part[c * n + c]
            for j in range(c, n):
                part[i * n + j] -= x * part[c * n + j]
    return 1 if sign > 0.0 else 0


@compiled
def depend(contacts: Contacts) -> int:
    """Return 1 if the motion does not determine how the contacts share the normal forces, else 0."""
    k, m, S = contacts.contacts, contacts.rows, contacts.H
    for i in range(k):
        for j in range(k):
            S[i * k + j] = contacts.A[contacts.at[i] * m + contacts.at[j]]
    independent = factor(S, k, contacts.factors, SMALL, contacts.left, contacts.order)
    return 1 if independent < k - held(contacts) else 0
