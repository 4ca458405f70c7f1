"""Contacts that stay closed on surfaces that turn: the law of a step for their rates v = W u + w in its middle.

    0 <= Λ_N ⟂ v_N⁺ + a_N + e (v_N⁻ - a_N) >= 0,    -Λ_T in μ Λ_N Sgn(v_T⁺ + a_T)
    a = (3 T - T₋)/2,   a_N = v_N⁻ where that is greater,   T = (v⁻ - v₋)/2

v₋ is v⁺ of the last step, in the middle of that step. The speeds are the same, so v⁻ - v₋ is by what the surfaces turn
from one middle to the next, and T by what they turn in half a step, in the mean. a extrapolates T to this middle. On a
plane, T = a = 0. Where the last steps had other lengths h₋, h₋₋, T and T₋ are those of this length:

    T = h/(h + h₋) (v⁻ - v₋),   a = T + p (T - h/h₋ T₋),   p = (h + h₋)/(h + 2 h₋ + h₋₋)

Work. Where Λ_N > 0, v⁺ = -a - e (v⁻ - a), and Λ (v⁻ + v⁺)/2 = (1 - e) Λ (v⁻ - a)/2 <= 0. Friction that sticks does
Λ_T (v⁻ - a)/2, of either sign. Where it would be positive with the impulse of the last step, changed by what it takes
to remove v⁻ - a, a_T is v⁻, and the work 0 (`set_turns`). So in the next step it is not.

Order. A motion with v⁺ = -v⁻ has 2 T = v⁻ + (v⁻ of the step before), so v⁻ = (3 T - T₋)/2 + O(h³): without slip and
impacts the two laws of a_N are one up to O(h³), the error of Λ_N, and the contact does no work but O(h³) Λ. An error
of v⁻ above a alternates for ever by v⁺ = -v⁻; by the law of a it is gone in two steps, one below a in one step. The
gap changes by O(h³) in a step, and the correction closes it.

A contact that lands or rebounds, and the friction of one that slipped, have a = 0. One that has stayed for a single
step has no T₋, and T for it; one that begins closed has for v₋ the rate at the start, half a step before.

Where more contacts stick than a body has speeds, no motion has all of their v⁺ = -a, and what is left would drive
stresses between them to the limits of friction. So a = 0 where two bodies touch in several contacts, as the feet of a
table: such contacts do work of first order in h. So it is of a turn that opens no more than `CLOSED_GAP` in a step:
such a contact does less than N `CLOSED_GAP` of work.

v⁺ = -v⁻ is the midpoint rule of a condition that holds at the ends of steps: O. Gonzalez, Comput. Methods Appl. Mech.
Engrg. 174 (1999) 165-174.
"""

from __future__ import annotations

from ...native.instructions import Reals, compiled, greater, inlined, root
from ..cones.cone import bound
from ..cones.contact_problem import FIRST, NORMAL, SECOND, Blocks, ContactProblem
from ..cones.islands import Islands, connect
from .stepping_record import BEGINS, CLOSED_GAP, LANDED, OPENS, STAYED, Run


@inlined
def turned(run: Run, stays: int, last: Reals, before: float) -> tuple[float, float]:
    """Return T and its extrapolation of a row with the rates v₋, T₋ and v⁻."""
    both = run.h + run.past[0]
    T = before - last[0] if stays == BEGINS else run.h / both * (before - last[0])
    part = both / (both + (run.past[0] + run.past[1]))
    a = (1.0 + part) * T - part * (run.h / run.past[0]) * last[1] if stays == STAYED else T
    return T, 0.0 if stays == OPENS else a


@compiled
def set_turns(run: Run, islands: Islands) -> None:
    """Set a of all rows, of which `turned` is known and X has been computed."""
    contacts, problem, listed, of, twice = run.contacts, run.problem, 0, -1, 0
    for a in range(problem.count):
        kind, size = problem.kinds[a], 2 if problem.kinds[a] == FIRST else 1
        if contacts.stays[a] == OPENS or kind == SECOND:
            continue
        work, whole = 0.0, 0.0
        for k in range(a, a + size):
            error = contacts.before[k] - contacts.turn[k]
            work += error * (problem.scale[k] * problem.x[k] - error)
            if kind == NORMAL:
                contacts.turn[k] = greater(contacts.turn[k], contacts.before[k])
            whole += contacts.turn[k] * contacts.turn[k]
        flat, normal = 1, a if kind == NORMAL else bound(problem, a)
        if run.h * root(whole) > CLOSED_GAP:
            if listed == 0:
                connect(problem, islands)
                listed = 1
            if normal != of:
                of, twice = normal, touches_twice(problem, islands, normal)
            flat = twice
        for k in range(a, a + size):
            if flat == 1:
                contacts.turn[k] = 0.0
            elif kind != NORMAL and work > 0.0:
                contacts.turn[k] = contacts.before[k]


@compiled
def touches_twice(problem: ContactProblem, islands: Islands, a: int) -> int:
    """Return 1 if another contact joins the blocks of a normal row: one of those of the block with the fewest rows."""
    blocks, rows, at = problem.blocks, problem.rows, islands.at
    first, end = blocks.first[rows[a]], blocks.first[rows[a] + 1]
    if first == end:
        return 0
    b = blocks.pieces[first]
    for p in range(first + 1, end):
        if at[blocks.pieces[p] + 1] - at[blocks.pieces[p]] < at[b + 1] - at[b]:
            b = blocks.pieces[p]
    for i in range(at[b], at[b + 1]):
        k = islands.touching[i]
        if problem.kinds[k] == NORMAL and k != a and joins_alike(blocks, rows[k], rows[a]) == 1:
            return 1
    return 0


@compiled
def joins_alike(blocks: Blocks, r: int, s: int) -> int:
    """Return 1 if two rows have the same blocks, else 0."""
    first, other, count = blocks.first[r], blocks.first[s], blocks.first[r + 1] - blocks.first[r]
    alike = 1 if blocks.first[s + 1] - other == count else 0
    p = 0
    while alike == 1 and p < count:
        alike = 1 if blocks.pieces[first + p] == blocks.pieces[other + p] else 0
        p += 1
    return alike


@inlined
def returned(run: Run, a: int) -> float:
    """Return a + e (v⁻ - a) of a row; a alone by Poisson's law, which is one of impulses."""
    contacts, e = run.contacts, 0.0 if run.expansion.poisson == 1 else run.contacts.rebound[a]
    return contacts.turn[a] + e * (contacts.before[a] - contacts.turn[a])


@compiled
def after(run: Run, a: int) -> float:
    """Return v⁺ of a row."""
    return run.problem.r[a] - returned(run, a)


@inlined
def negligible(run: Run) -> float:
    """Return the rate up to which the residual of the problem leaves open whether it is zero."""
    return 100.0 * greater(run.tolerance, run.problem.residual) * run.problem.reference


@compiled
def lasting(run: Run, a: int) -> int:
    """Return how long the contact of a normal row that presses has stayed closed.

    It opens if it rebounds, or presses by no more than the residual of the problem.
    """
    contacts, problem = run.contacts, run.problem
    if not problem.scale[a] * problem.x[a] > negligible(run):
        return OPENS
    if contacts.rebound[a] * (contacts.before[a] - contacts.turn[a]) < 0.0:
        return OPENS
    if run.expansion.poisson == 1 and contacts.rebound[a] > 0.0:
        return OPENS
    return LANDED if contacts.stays[a] == OPENS else STAYED
