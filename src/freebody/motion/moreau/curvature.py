"""Contacts that stay closed on surfaces that turn: the law of a step for their normal rates.

    0 <= Λ ⟂ v⁺ + a + e (v⁻ - a) >= 0,     a = max(v⁻, (3 T - T₋)/2),     T = (v⁻ - v₋)/2         v = W u + w at q_M

v₋ is the rate v⁺ at the end of the last step, in the middle of that step. The speeds are the same, so v⁻ - v₋ is what
the surfaces turn between the two middles: T, in the mean, in half a step. (3 T - T₋)/2 extrapolates it to the middle of
this step.

Contact does no work: v⁺ = -a - e (v⁻ - a) where Λ > 0, and Λ (v⁻ + v⁺)/2 = (1 - e) Λ (v⁻ - a)/2 <= 0.

A smooth motion does not lose energy either, but for terms beyond the order of the method. With v⁺ = -v⁻ the next
v⁻ is 2 T - v⁻: the mean of two successive v⁻ is T, and v⁻ = (3 T - T₋)/2 + O(h³) stays so. Without the second term of
a, an error ε = v⁻ - (3 T - T₋)/2 would alternate for ever. With it, one below zero is gone in a step, and one above in
two. So the impulse has an error of O(h³), the force one of O(h²), and so has the gap that the correction closes, of
O(h³) in a step. On a plane T = 0, v⁻ = 0, and a = 0.

A contact that has opened, or rebounds, has a = 0, and the law v⁺ + e v⁻ >= 0 of an impact. One that lands has no T₋ in
the next step, and takes T for it; one that begins closed has for v₋ the rate at the start, half a step before.

Source of v⁺ = -v⁻, which holds a gap and its energy: O. Gonzalez, Comput. Methods Appl. Mech. Engrg. 174 (1999) 165-174.
"""

from __future__ import annotations

from ...native.instructions import Reals, compiled, greater, inlined, lesser, root
from ..cones.contact_problem import LINE, NORMAL, SECOND
from .stepping_record import BEGINS, LANDED, OPENS, STAYED, Contacts, Run


@inlined
def turned(stays: int, kind: int, last: Reals, before: float) -> tuple[float, float]:
    """Return T and a."""
    T = before - last[0] if stays == BEGINS else 0.5 * (before - last[0])
    a = 1.5 * T - 0.5 * last[1] if stays == STAYED else T
    a = greater(a, before) if kind == NORMAL else a
    return T, 0.0 if stays == OPENS else a


@inlined
def returned(contacts: Contacts, a: int) -> float:
    """Return a + e (v⁻ - a) of a row."""
    return contacts.turn[a] + contacts.rebound[a] * (contacts.before[a] - contacts.turn[a])


@compiled
def after(run: Run, a: int) -> float:
    """Return v⁺ of a row."""
    return run.problem.r[a] - returned(run.contacts, a)


@compiled
def lasting(contacts: Contacts, a: int) -> int:
    """Return how long the contact of a normal row that presses has stayed closed: if it rebounds, it opens."""
    if contacts.rebound[a] * (contacts.before[a] - contacts.turn[a]) < 0.0:
        return OPENS
    return LANDED if contacts.stays[a] == OPENS else STAYED


@compiled
def mirror(run: Run, a: int) -> None:
    """Let v⁺ = -v⁻ of the tangents of a contact, the first of which is row ``a``, where friction would do work."""
    contacts, problem = run.contacts, run.problem
    work, size_of_turn, size_of_error = 0.0, 0.0, 0.0
    size = 1 if problem.kinds[a] <= LINE else 2
    if problem.kinds[a] == SECOND:
        return
    for k in range(size):
        error = contacts.before[a + k] - contacts.turn[a + k]
        size_of_turn += contacts.turn[a + k] * contacts.turn[a + k]
        size_of_error += error * error
        work += error * (problem.scale[a + k] * problem.x[a + k] - error)
    if problem.kinds[a] > NORMAL and work > 0.0:
        for k in range(size):
            contacts.turn[a + k] = contacts.before[a + k]
    if run.h * root(size_of_turn) <= 1e-10:
        for k in range(size):
            contacts.turn[a + k] = 0.0
