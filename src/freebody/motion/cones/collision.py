"""The impulses of one impact in compiled code: Newton's and Poisson's laws over a contact problem."""

from __future__ import annotations

from typing import Any

from ...native.instructions import Reals, compiled, greater
from ...native.loop import made
from .contacts import ACCEPTED, EXACT, Contacts
from .solution import answer, equilibrate, find, lay_out, take
from .uniqueness import is_held

HALVINGS = 5
"""The restitution is halved up to four times, until the energy does not grow, and is zero at last."""


@compiled
def rebounded(it: Contacts, part: float) -> float:
    """Set impulses and speeds for a part of the restitution; return the residual.

    Points of a face that stick at their limits of friction, whose shares are open, are a double zero of the laws: the
    search from zero for less than `EXACT` of the speeds takes a thousand times as long, for shares that move nothing.
    """
    for i in range(it.rows):
        it.forces[i], it.after[i] = 0.0, it.given[i]
    problem = it.problem
    for i in range(problem.count):
        problem.b[i], problem.low[i] = it.unit[i] * it.given[it.place[i]], 0.0
    hold_given(it, it.least)
    if it.poisson == 0:
        at = 0
        for k in range(it.contacts):
            if it.presser[k] >= 0:
                continue
            at = unknown_of(it, k, at)
            if it.given[it.at[k]] < -it.still:
                problem.b[at] += part * it.restitution[k] * it.unit[at] * it.given[it.at[k]]
    residual = answer(it, EXACT)
    take(it)
    for i in range(it.rows):
        it.compressed[i] = it.forces[i]
    if it.poisson != 0:
        at = 0
        for k in range(it.contacts):
            if it.presser[k] >= 0:
                continue
            at = unknown_of(it, k, at)
            problem.low[at] = greater(part * it.restitution[k] * problem.x[at], 0.0)
        for i in range(problem.count):
            problem.b[i] = it.unit[i] * it.after[it.place[i]]
        hold_given(it, it.back)
        residual = greater(residual, answer(it, EXACT))
        take(it)
    return residual


@compiled
def unknown_of(it: Contacts, k: int, at: int) -> int:
    """Return the place of the normal force of a contact among the unknowns, sought from ``at`` on."""
    while it.place[at] != it.at[k]:
        at += 1
    return at


@compiled
def hold_given(it: Contacts, least: Reals) -> None:
    """Let given normal forces, which bound friction and move nothing, act in the problem."""
    at = 0
    for k in range(it.contacts):
        if it.presser[k] >= 0:
            continue
        at = unknown_of(it, k, at)
        if is_held(it, k) != 0:
            it.problem.low[at] = least[k] / it.unit[at]


@compiled
def collided(it: Contacts) -> int:
    """Find the impulses, with the greatest of the parts of the restitution for which the energy does not grow.

    Those with a residual of `ACCEPTED` are taken if none is `EXACT` for any part. Return 0.
    """
    lay_out(it)
    equilibrate(it)
    for trial in range(2 * (1 + HALVINGS)):
        turn, bound = trial % (1 + HALVINGS), EXACT if trial <= HALVINGS else ACCEPTED
        it.part = 0.0 if turn == HALVINGS else 1.0 / (1 << turn)
        it.residual = rebounded(it, it.part)
        it.energy, size = 0.0, 0.0
        for i in range(it.rows):
            it.energy += it.forces[i] * (it.given[i] + it.after[i]) / 2.0  # ΔT = Λ·(v⁻ + v⁺)/2
            size += abs(it.forces[i]) * (abs(it.given[i]) + abs(it.after[i]))
        if it.residual <= bound and it.energy <= EXACT * size:
            return 0
    return 0


def compiled_code() -> Any:
    """Return the functions `find` and `collided` as machine code."""
    label = __name__.partition(".")[2]
    space = {"find": find, "collided": collided}
    return made(label, (label,), tuple(space), lambda: space, passes="few").functions
