"""Loads that depend on the speeds, as those of a turning body: the impulse p = h f(ū) that agrees with its own ū.

    p → p + r e,   e = h f(ū(p)) - p,   r = argmin |e + r Δe/r_last|

ū(p) solves the contacts. r is 1, and less where bodies turn far in a step; Δe is the last change of e. The norms are
those of the kinetic energy.

Source: J. Barzilai, J. M. Borwein, IMA J. Numer. Anal. 8 (1988) 141-148 (r).
"""

from __future__ import annotations

from ...native.instructions import compiled, greater, lesser, root
from ..cones.block_rows import dot
from .configuration import answers
from .elimination import block_back
from .spin import set_spins, take_spins
from .stepping_record import Run

SHORTEST = 1e-4
"""Least r."""
TINY = 1e-300


@compiled
def imbalance(run: Run, trials: int) -> float:
    """Set e = h f - p and M⁻¹ e; return |e| relative to the motion, √(e·M⁻¹e / (u·M u + p·M⁻¹p)), p of trial 0."""
    loads, blocks = run.loads, run.problem.blocks
    if trials == 0:
        loads.motion = size_of_motion(run)
    for i in range(blocks.n):
        loads.e[i] = run.h * (loads.f[i] + run.pressed[i]) - loads.p[i]
    take_spins(run)
    for b in range(blocks.count):
        first = blocks.starts[b]
        block_back(run.elimination, b, loads.e[first:], loads.Me[first:])
    return root(dot(loads.e, loads.Me, blocks.n) / loads.motion)


@compiled
def spun(run: Run) -> int:
    """Set D to that of the mean speeds, and p to h f - D w, which leaves no e; return 0 if all D are zero, else 1."""
    loads = run.loads
    if set_spins(run, run.u_mean) == 0:
        return 0
    answers(run, run.constraints)
    for i in range(run.machine.n):
        loads.e[i] = run.h * (loads.f[i] + run.pressed[i])
    take_spins(run)
    for i in range(run.machine.n):
        loads.p[i] = loads.e[i]
    return 1


@compiled
def size_of_motion(run: Run) -> float:
    """Return u·M u + p·M⁻¹ p."""
    loads, blocks, whole = run.loads, run.problem.blocks, TINY
    for b in range(blocks.count):
        first, size = blocks.starts[b], blocks.starts[b + 1] - blocks.starts[b]
        block_back(run.elimination, b, loads.p[first:], loads.Me[first:])
        whole += dot(loads.p[first:], loads.Me[first:], size)
        M = run.M[blocks.squares[b] :]
        for i in range(size):
            whole += run.u[first + i] * dot(M[i * size :], run.u[first:], size)
    return whole


@compiled
def change_loads(run: Run, r: float, trials: int) -> float:
    """Add r e to p, with the r that minimizes |e + r Δe/r_last| (1 the first time); return r.

    After the first trial p is what its speeds demand, where bodies turn.
    """
    loads, n = run.loads, run.machine.n
    if trials == 1 and spun(run) == 1:
        return r
    loads.changes += 1
    if loads.changes > 1:
        along_e, whole = 0.0, 0.0
        for i in range(n):
            change = loads.e_old[i] - loads.e[i]
            along_e += change * loads.Me_old[i]
            whole += change * (loads.Me_old[i] - loads.Me[i])
        r = 1.0 if whole == 0.0 else lesser(1.0, greater(SHORTEST, r * along_e / whole))
    for i in range(n):
        loads.e_old[i], loads.Me_old[i] = loads.e[i], loads.Me[i]
        loads.p[i] += r * loads.e[i]
    return r
