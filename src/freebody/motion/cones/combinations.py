"""Whether several motions, or none, satisfy the laws of a few contacts, in compiled code: Painlevé's paradoxes.

Where no theorem says that the motion is the only one (`uniqueness`), every combination of modes is tried. With λ and
r = A λ + c,

    open      λ = 0                                       r_N >= 0
    stick     r_N = 0, r_T = 0                            λ_N >= 0, |λ_T| <= μ_s λ_N
    slip d    r_N = 0, λ_T = -μ d λ_N                     λ_N >= 0, r_T·d >= 0     (the latter if it begins)

is a system of linear equations, if every direction d is known: of a contact that slides, and of one with a single
tangent. Two solutions are the same motion if their rates are: δ·Aδ = 0 for the difference δ of their forces.

Sources: C. Glocker, F. Pfeiffer, Multibody Dynamics with Unilateral Contacts (1996), chapters 5-8;
F. Génot, B. Brogliato, New results on Painlevé paradoxes (1999).
"""

from __future__ import annotations

import math

from ...native.instructions import compiled, greater, lesser, root
from .contacts import AWAY, FORWARDS, PRESSED, Contacts
from .elimination import solved
from .newton import factor
from .uniqueness import SMALL, behind, is_held

MOST = 1 << 8
"""Largest number of combinations that are tried."""
SAME = 1e-8
"""Difference of two motions, relative to the greatest rate, up to which they are the same."""
LOOSE, REFINED = 1e-13, 4
"""δ of the least solution x = Sᵀ (S Sᵀ + δ)⁻¹ g, relative to S Sᵀ, and how often what is left of g is solved for."""


@compiled
def is_smooth(it: Contacts, i: int) -> int:
    """Return 1 if a contact has no friction, else 0."""
    return 1 if it.tangents[i] == 0 or it.static[i] == 0.0 else 0


@compiled
def choices(it: Contacts, i: int) -> int:
    """Return the number of modes of a contact; one whose normal force is given is not open."""
    return (4 if is_smooth(it, i) == 0 and it.slides[i] == 0 else 2) - is_held(it, i)


@compiled
def combinations(it: Contacts) -> int:
    """Return the number of combinations; 0 if there are too many, or if a direction of slip is unknown."""
    count = 1
    for i in range(it.contacts):
        if it.tangents[i] == 2 and is_smooth(it, i) == 0 and it.slides[i] == 0:
            return 0
        count = count * choices(it, i)
        if count > MOST:
            return 0
    return count


ROUNDED = 2.0**-44
"""Violation of a law that may be round-off, as in `places.ROUNDED`."""


@compiled
def motions(it: Contacts) -> int:
    """Return the number of different motions, 2 if there are several.

    The modes of the first are those of ``tried`` from the number of contacts on; if there are several, those of a
    second one begin ``tried``.
    """
    count = search(it, SMALL)
    if count == 2 and search(it, ROUNDED) == 1:  # large friction amplifies round-off in the inequalities
        return 1
    return search(it, SMALL) if count == 2 else count


@compiled
def shares_move(it: Contacts) -> int:
    """Return 1 if one of two motions leaves forces open that move the machine, as where contacts with different
    coefficients slide; else 0.

    The motions are two of many then, between which the shares of the forces decide.
    """
    for _ in range(2):
        missed(it)
        count = unknowns(it, SAME * typical_rate(it))
        if rank_of_answers(it, count, 1) > rank_of_answers(it, count, 0):
            return 1
        for i in range(it.contacts):
            it.tried[i], it.tried[it.contacts + i] = it.tried[it.contacts + i], it.tried[i]
    return 0


@compiled
def rank_of_answers(it: Contacts, count: int, whole: int) -> int:
    """Return the rank of what the unknown forces of the combination ``tried`` add to the rates that are zero.

    With ``whole`` 1 to all rates.
    """
    G, rows = it.normal, it.rows if whole != 0 else count
    for p in range(count * count):
        G[p] = 0.0
    for a in range(rows):
        row = a if whole != 0 else it.place[a]
        for p in range(count):
            it.best[p] = answer_to(it, p, row)
        for p in range(count):
            for q in range(count):
                G[p * count + q] += it.best[p] * it.best[q]
    return factor(G, count, it.factors, SMALL, it.left, it.order)


@compiled
def take_first(it: Contacts) -> None:
    """Set forces and rates to those of the first motion."""
    for i in range(it.contacts):
        it.tried[i] = it.tried[it.contacts + i]
    missed(it)


@compiled
def search(it: Contacts, small: float) -> int:
    """Return the number of different motions that miss no law by more than ``small``, 2 if there are several."""
    found, k = 0, it.contacts
    for number in range(combinations(it)):
        spell(it, number)
        if missed(it) <= small and gives_way(it, number) == 0:
            if found == 0:
                found = 1
                for i in range(k):
                    it.tried[k + i] = it.tried[i]
                for a in range(it.rows):
                    it.best[a] = it.after[a]
            elif differs(it) != 0:
                return 2
    return found


@compiled
def spell(it: Contacts, number: int) -> None:
    """Write the modes of a combination."""
    left = number
    for i in range(it.contacts):
        n = choices(it, i)
        it.tried[i] = left % n + is_held(it, i)
        left = left // n


@compiled
def gives_way(it: Contacts, number: int) -> int:
    """Return 1 if static friction, greater than kinetic, holds what begins to slip beside the others, else 0."""
    changed, result = 0, 0
    for i in range(it.contacts):
        if it.tried[i] > PRESSED and it.static[i] > it.friction[i]:
            it.tried[i], changed = PRESSED, 1
    if changed != 0:
        result = 1 if missed(it) <= SMALL else 0
        spell(it, number)
        missed(it)
    return result


@compiled
def differs(it: Contacts) -> int:
    """Return 1 if the motion differs from the first one, else 0."""
    size, most = typical_rate(it), 0.0
    for a in range(it.rows):
        size = greater(size, abs(it.best[a]))
        most = greater(most, abs(it.after[a] - it.best[a]))
    return 1 if most > SAME * size else 0


# -- one combination -------------------------------------------------------------------------------------


@compiled
def add_unknown(it: Contacts, count: int, row: int, owner: int) -> int:
    """Append an unknown force, and a rate that is zero; ``owner`` is the contact of a normal force, or -1."""
    it.place[count], it.owner[count] = row, owner
    return count + 1


@compiled
def ray_of(it: Contacts, i: int, j: int) -> float:
    """Return the friction of a contact that slides along tangent j, per unit of normal force."""
    d = 1.0 if it.tried[i] == FORWARDS else -1.0
    if it.slides[i] != 0:
        d = it.way[2 * i + j]
    return -it.friction[i] * d


@compiled
def unknowns(it: Contacts, still: float) -> int:
    """Set the given forces of the combination ``tried``, and list the unknown ones; return their number.

    A slip that begins at a rate of ``still`` or less is none, and its friction anything within the cone.
    """
    count = 0
    for a in range(it.rows):
        it.forces[a] = 0.0
    for i in range(it.contacts):
        if is_held(it, i) != 0 and it.presser[i] < 0:
            it.forces[it.at[i]] = it.least[i]
            for j in range(it.tangents[i] if is_on_ray(it, i) != 0 else 0):
                it.forces[it.at[i] + 1 + j] = it.least[i] * ray_of(it, i, j)
        elif it.presser[i] < 0 and it.tried[i] != AWAY:
            count = add_unknown(it, count, it.at[i], i)
        rests = it.tried[i] == PRESSED or (it.tried[i] > PRESSED and abs(it.after[it.at[i] + 1]) <= still)
        if rests and it.slides[i] == 0 and is_smooth(it, i) == 0 and is_away(it, i) == 0:
            for j in range(it.tangents[i]):
                count = add_unknown(it, count, it.at[i] + 1 + j, -1)
    return count


@compiled
def answer_to(it: Contacts, b: int, row: int) -> float:
    """Return what one unit of an unknown force, with the friction that it brings, adds to a rate."""
    k, result = it.owner[b], it.A[row * it.rows + it.place[b]]
    for s in range(k, behind(it, k) if k >= 0 else k):
        for j in range(it.tangents[s] if is_on_ray(it, s) != 0 else 0):
            result += ray_of(it, s, j) * it.A[row * it.rows + it.at[s] + 1 + j]
    return result


@compiled
def missed(it: Contacts) -> float:
    """Set forces and rates of the combination ``tried``; return by how much a law is violated, relative to 1."""
    count = unknowns(it, -1.0)
    rated(it)
    for a in range(count):
        for b in range(count):
            it.chosen[a * count + b] = answer_to(it, b, it.place[a])
    for _ in range(REFINED):
        if least(it, count) == 0:
            return math.inf
        rated(it)
    name_pressers(it)
    return worst(it, count)


@compiled
def is_on_ray(it: Contacts, i: int) -> int:
    """Return 1 if the friction of a contact in the combination is that of a known slip, else 0."""
    return 1 if it.tried[i] > PRESSED or (it.tried[i] == PRESSED and it.slides[i] != 0) else 0


@compiled
def is_away(it: Contacts, i: int) -> int:
    """Return 1 for resistance to rolling or spinning of a contact that is open in the combination, else 0."""
    return 1 if it.presser[i] >= 0 and it.tried[it.presser[i]] == AWAY else 0


@compiled
def name_pressers(it: Contacts) -> None:
    """Write the normal force that bounds resistance to rolling and spinning on its normal row, which moves nothing."""
    for i in range(it.contacts):
        if it.presser[i] >= 0:
            it.forces[it.at[i]] = it.forces[it.at[it.presser[i]]]


@compiled
def rated(it: Contacts) -> None:
    """Set the rates of the forces."""
    for a in range(it.rows):
        r = it.given[a]
        for b in range(it.rows):
            r += it.A[a * it.rows + b] * it.forces[b]
        it.after[a] = r


@compiled
def least(it: Contacts, count: int) -> int:
    """Add the least forces that cancel the rates of the combination; return 0 if there are none, else 1."""
    S, N, left = it.chosen, it.normal, it.left
    for a in range(count):
        left[a] = -it.after[it.place[a]]
        size = 0.0
        for b in range(count):
            size += S[a * count + b] * S[a * count + b]
        it.H[a] = 1.0 / root(size) if size > 0.0 else 1.0  # each equation has the size 1
    for a in range(count):
        left[a] *= it.H[a]
        for b in range(count):
            N[a * count + b] = LOOSE if a == b else 0.0
            for j in range(count):
                N[a * count + b] += it.H[a] * S[a * count + j] * S[b * count + j] * it.H[b]
    if solved(N, count, left) == 0:
        return 0
    for b in range(count):
        x = 0.0
        for a in range(count):
            x += it.H[a] * S[a * count + b] * left[a]
        it.forces[it.place[b]] += x
        k = it.owner[b]
        for s in range(k, behind(it, k) if k >= 0 else k):
            for j in range(it.tangents[s] if is_on_ray(it, s) != 0 else 0):
                it.forces[it.at[s] + 1 + j] += ray_of(it, s, j) * x
    return 1


@compiled
def worst(it: Contacts, count: int) -> float:
    """Return the greatest violation of a law."""
    r, f = 1.0 / greater(typical_rate(it), TINY), 1.0 / greater(typical_force(it), TINY)
    result = 0.0
    for a in range(count):
        result = greater(result, r * abs(it.after[it.place[a]]))
    for i in range(it.contacts):
        at, n = it.at[i], it.tangents[i]
        if is_away(it, i) != 0:
            continue
        if it.tried[i] == AWAY:
            slack = r * it.after[at]
        else:
            slack = 0.0 if is_held(it, i) != 0 else f * it.forces[at]
            if it.tried[i] > PRESSED:
                slack = lesser(
                    slack, r * (it.after[at + 1] if it.tried[i] == FORWARDS else -it.after[at + 1])
                )
            elif it.slides[i] == 0 and is_smooth(it, i) == 0:
                square = 0.0
                for j in range(n):
                    square += it.forces[at + 1 + j] * it.forces[at + 1 + j]
                slack = lesser(slack, f * (it.static[i] * it.forces[at] - root(square)))
        result = greater(result, -slack)
    return result if math.isfinite(result) else math.inf


TINY = 1e-300
"""Size of forces and rates where all are zero."""


@compiled
def typical_force(it: Contacts) -> float:
    """Return the greatest force, of the solution or of those that would each cancel one rate alone."""
    m, result = it.rows, 0.0
    for a in range(m):
        result = greater(result, abs(it.forces[a]))
        if abs(it.A[a * m + a]) > 0.0:
            result = greater(result, abs(it.given[a] / it.A[a * m + a]))
    return result


@compiled
def typical_rate(it: Contacts) -> float:
    """Return the greatest rate without forces, or sum of what the forces add to a rate."""
    m, result = it.rows, 0.0
    for a in range(m):
        size = 0.0
        for b in range(m):
            size += abs(it.A[a * m + b] * it.forces[b])
        result = greater(result, greater(size, abs(it.given[a])))
    return result
