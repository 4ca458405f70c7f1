"""The loads by which the turning of a free body depends on its speeds, as a part of its equations in a step.

    f_ω = -ω × J ω,   D = h/2 ∂f_ω/∂ω = h/2 ([J ω]× - [ω]× J),     M w = p + D w + …,   w = u⁺ - u,   p = h f(ū) - D w

The answers to impulses are X = (M - D)⁻¹ Wᵀ then, and what is left of e = h f(ū) - D w - p is of second order in w: two
to four contact problems a step in place of six. With c = M⁻¹ D of the three columns of ω, and c_ω its upper rows,

    (M - D)⁻¹ = (1 + C [1 0]) M⁻¹,     C = c (1 - c_ω)⁻¹

A body that is coupled to others by joints or constraints has D = 0, and so have all where a contact has no friction:
the dual method (`cones.dual`) needs answers that are symmetric.
"""

from __future__ import annotations

from ...native.instructions import Reals, compiled, room
from ..cones.block_rows import BODY
from ..cones.contact_problem import NORMAL, ContactProblem
from .elimination import block_back
from .stepping_record import Run

FAR = 0.5
"""Greatest sum of a row of c_ω: beyond it a step turns too far for a first guess, and D = 0."""


@compiled
def set_spins(run: Run, u: Reals) -> int:
    """Set D and C of all free bodies at speeds, where they are not zero; return the number of these."""
    machine, of, blocks, count = run.machine, run.elimination, run.problem.blocks, 0
    leave_spins(run)
    if machine.turning == 0 or run.constraints > 0 or has_friction(run.problem) == 0:
        return 0
    for k in range(machine.flights):
        b = machine.block[k]
        if blocks.starts[b + 1] - blocks.starts[b] == BODY:
            of.spins[b] = turned_by(run, k, b, u[blocks.starts[b] :])
            count += of.spins[b]
    return count


@compiled
def leave_spins(run: Run) -> None:
    """Let all D be zero, as for displacements."""
    for b in range(run.problem.blocks.count):
        run.elimination.spins[b] = 0


@compiled
def has_friction(problem: ContactProblem) -> int:
    """Return 1 if each contact has tangents."""
    for a in range(problem.count):
        last = 1 if a + 1 == problem.count else 0
        if problem.kinds[a] <= NORMAL and (last == 1 or problem.kinds[a + 1] <= NORMAL):
            return 0
    return 1


@compiled
def turned_by(run: Run, k: int, b: int, w: Reals) -> int:
    """Set D and C of the free joint ``k``, which is block b and turns by ω; return 0 if they are left zero, else 1."""
    of, M = run.elimination, run.M[run.problem.blocks.squares[b] :]
    D, C, c = of.D[b], of.C[b], run.machine.center[k]
    J, L, column, m, some = room(9), room(3), room(6), M[BODY * BODY - 1], 0
    square = c[0] * c[0] + c[1] * c[1] + c[2] * c[2]
    for i in range(3):
        for j in range(3):
            J[3 * i + j] = M[BODY * i + j] + m * c[i] * c[j]
        J[4 * i] -= m * square
        L[i] = J[3 * i] * w[0] + J[3 * i + 1] * w[1] + J[3 * i + 2] * w[2]
    for j in range(3):
        p, q = (j + 1) % 3, (j + 2) % 3
        for i in range(3):
            r, s = (i + 1) % 3, (i + 2) % 3
            D[3 * i + j] = -0.5 * run.h * (w[r] * J[3 * s + j] - w[s] * J[3 * r + j])
        D[3 * p + j] += 0.5 * run.h * L[q]
        D[3 * q + j] -= 0.5 * run.h * L[p]
        for i in range(3):
            some = 1 if D[3 * i + j] != 0.0 else some
            column[i], column[3 + i] = D[3 * i + j], 0.0
        block_back(of, b, column, column)
        for i in range(BODY):
            C[3 * i + j] = column[i]
    return some if some == 0 else closed(C)


@compiled
def closed(C: Reals) -> int:
    """Replace c by c (1 - c_ω)⁻¹; return 0 where a step turns too far for that, else 1."""
    A, B = room(9), room(9)
    for i in range(3):
        if not abs(C[3 * i]) + abs(C[3 * i + 1]) + abs(C[3 * i + 2]) < FAR:
            return 0
    for i in range(9):
        A[i] = (1.0 if i % 4 == 0 else 0.0) - C[i]
    for i in range(3):
        for j in range(3):
            p, q, r, s = (i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3
            B[3 * j + i] = A[3 * p + r] * A[3 * q + s] - A[3 * p + s] * A[3 * q + r]
    det = A[0] * B[0] + A[1] * B[3] + A[2] * B[6]
    for i in range(BODY):
        x, y, z = C[3 * i] / det, C[3 * i + 1] / det, C[3 * i + 2] / det
        for j in range(3):
            C[3 * i + j] = x * B[j] + y * B[3 + j] + z * B[6 + j]
    return 1


@compiled
def take_spins(run: Run) -> None:
    """Take D w from the residual e of the loads."""
    blocks, of = run.problem.blocks, run.elimination
    for b in range(blocks.count):
        if of.spins[b] != 0:
            first, D = blocks.starts[b], of.D[b]
            x, y, z = (
                run.free[first] + run.problem.v[first],
                run.free[first + 1] + run.problem.v[first + 1],
                run.free[first + 2] + run.problem.v[first + 2],
            )
            for i in range(3):
                run.loads.e[first + i] -= D[3 * i] * x + D[3 * i + 1] * y + D[3 * i + 2] * z
