"""The impulses of one impact in compiled code: Newton's and Poisson's laws over a contact problem (`cone_record`)."""

from __future__ import annotations

from ...native.instructions import compiled, greater
from .cone_record import EXACT, Cone, answered, laid_out, taken

HALVINGS = 5
"""The restitution is halved up to four times, until the energy does not grow, and is zero at last."""


@compiled
def rebounded(it: Cone, part: float) -> float:
    """Set impulses and speeds for a part of the restitution; return the residual."""
    for i in range(it.rows):
        it.forces[i], it.after[i] = 0.0, it.given[i]
    for i in range(it.unknowns):
        it.c[i], it.low[i] = it.given[it.place[i]], 0.0
    if it.poisson == 0:
        at = 0
        for k in range(it.contacts):
            while it.place[at] != it.at[k]:
                at += 1
            if it.given[it.at[k]] < -it.still:
                it.c[at] += part * it.restitution[k] * it.given[it.at[k]]
    residual = answered(it)
    taken(it)
    if it.poisson != 0:
        at = 0
        for k in range(it.contacts):
            while it.place[at] != it.at[k]:
                at += 1
            it.low[at] = greater(part * it.restitution[k] * it.x[at], 0.0)
        for i in range(it.unknowns):
            it.c[i] = it.after[it.place[i]]
        residual = greater(residual, answered(it))
        taken(it)
    return residual


@compiled
def collided(it: Cone) -> None:
    """Find the impulses, with the greatest of the parts of the restitution for which the energy does not grow."""
    laid_out(it)
    for turn in range(1 + HALVINGS):
        it.part = 0.0 if turn == HALVINGS else 1.0 / (1 << turn)
        it.residual = rebounded(it, it.part)
        it.energy, size = 0.0, 0.0
        for i in range(it.rows):
            it.energy += it.forces[i] * (it.given[i] + it.after[i]) / 2.0  # ΔT = Λ·(v⁻ + v⁺)/2
            size += abs(it.forces[i]) * (abs(it.given[i]) + abs(it.after[i]))
        if it.residual <= EXACT and it.energy <= EXACT * size:
            return
