"""Speeds of free joints within a step: velocities of mass centres, in axes that do not turn.

A free joint has the speeds (ω, v) in the axes of its link, in which its loads have the terms -m ω × v: they belong to
the axes, not to the body. Within a step, v stands for

    a = R_Mᵀ R (v + ω × c) - ω × c         at the start, and a⁺ with R⁺ at the end
    M (a⁺ - a) = h (f(ā) + M S(ā)) + …     S = ω × (v + ω × c) in the rows of v

with the mass centre c of the link: v + ω × c keeps its direction in the axes of q_M. A body in flight keeps its
momentum to round-off without iteration. In (ω, v + ω × c) its inertia is J about c, and m, so that R_Mᵀ R leaves its
energy alone. What else the link carries changes neither.
"""

from __future__ import annotations

from ...native.instructions import Reals, compiled, inlined
from .stepping_record import Machine, Run


@inlined
def turned(e: Reals, way: float, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Return a vector turned by a unit quaternion, or back, ``way`` 1 or -1."""
    s = way * e[0]
    a, b, c = 2.0 * (e[2] * z - e[3] * y), 2.0 * (e[3] * x - e[1] * z), 2.0 * (e[1] * y - e[2] * x)
    return (
        x + s * a + e[2] * c - e[3] * b,
        y + s * b + e[3] * a - e[1] * c,
        z + s * c + e[1] * b - e[2] * a,
    )


@inlined
def lever(machine: Machine, k: int, u: Reals) -> tuple[float, float, float]:
    """Return ω × c of a free joint."""
    c, w = machine.center[k], u[machine.spin[k] :]
    return w[1] * c[2] - w[2] * c[1], w[2] * c[0] - w[0] * c[2], w[0] * c[1] - w[1] * c[0]


@compiled
def fix(machine: Machine, q: Reals, u: Reals) -> None:
    """Replace v by the velocity of the mass centre in the axes of the joint's parent, at the coordinates q."""
    for k in range(machine.flights):
        v = u[machine.spin[k] + 3 :]
        a, b, c = lever(machine, k, u)
        v[0], v[1], v[2] = turned(q[machine.attitude[k] :], 1.0, v[0] + a, v[1] + b, v[2] + c)


@compiled
def release(machine: Machine, q: Reals, u: Reals) -> None:
    """Replace the velocity of the mass centre in the axes of the joint's parent by v, at the coordinates q."""
    for k in range(machine.flights):
        v = u[machine.spin[k] + 3 :]
        a, b, c = lever(machine, k, u)
        x, y, z = turned(q[machine.attitude[k] :], -1.0, v[0], v[1], v[2])
        v[0], v[1], v[2] = x - a, y - b, z - c


@inlined
def turning(machine: Machine, k: int, u: Reals) -> tuple[float, float, float]:
    """Return S = ω × (v + ω × c) of a free joint: the rate of v by the turning of its axes."""
    w = u[machine.spin[k] :]
    a, b, c = lever(machine, k, u)
    x, y, z = w[3] + a, w[4] + b, w[5] + c
    return w[1] * z - w[2] * y, w[2] * x - w[0] * z, w[0] * y - w[1] * x


@compiled
def add_turning(run: Run, u: Reals, f: Reals) -> None:
    """Add M S(u) to the loads f."""
    machine, blocks = run.machine, run.problem.blocks
    for k in range(machine.flights):
        x, y, z = turning(machine, k, u)
        b = machine.block[k]
        first, size = blocks.starts[b], blocks.starts[b + 1] - blocks.starts[b]
        M, at = run.M[blocks.squares[b] :], machine.spin[k] + 3 - first
        for i in range(size):
            row = M[i * size + at :]
            f[first + i] += row[0] * x + row[1] * y + row[2] * z
