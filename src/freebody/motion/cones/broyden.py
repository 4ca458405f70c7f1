"""Numbers that agree with what follows from them, P = f(P), by Broyden's method, in compiled code.

With r = f(P) - P, each turn takes P + H r. H begins as 1, so that the first turns are those of P ← f(P), and is then
corrected by what a step s has changed: H y = -s, y = the change of r. Where f is affine it ends after 2 n turns at most
(D. M. Gay, SIAM J. Numer. Anal. 16 (1979) 623), however great its slopes are.

No P is below zero, and no f(P). Where a step would lead there although f(P) > P, f grows faster than P: what agrees, if
anything, lies above, and P takes f(P).

Source: C. G. Broyden, A class of methods for solving nonlinear simultaneous equations, Math. Comp. 19 (1965) 577.
"""

from __future__ import annotations

from ...native.instructions import Reals, compiled, greater

TURNS = 200
"""Turns after which there are no such numbers."""


@compiled
def begin(memory: Reals, n: int) -> None:
    """Begin at P = 0. The ``memory`` has P, r, the last step s, the last r, sᵀ H, and H."""
    for i in range(n * (5 + n)):
        memory[i] = 0.0
    for i in range(n):
        memory[n * (5 + i) + i] = 1.0


@compiled
def missed(memory: Reals, n: int, i: int, value: float) -> float:
    """Note f(P) of a number; return by how much it differs from P."""
    memory[n + i] = value - memory[i]
    return abs(memory[n + i])


@compiled
def take(memory: Reals, n: int) -> None:
    """Take the next P; none is below zero."""
    P, r, s, last, H = memory, memory[n:], memory[2 * n :], memory[3 * n :], memory[5 * n :]
    correct(r, s, last, memory[4 * n :], H, n)
    for i in range(n):
        step = 0.0
        for j in range(n):
            step += H[i * n + j] * r[j]
        if step < -P[i]:
            step = greater(r[i], -P[i])
        s[i], last[i] = step, r[i]
        P[i] += s[i]


@compiled
def correct(r: Reals, s: Reals, last: Reals, along: Reals, H: Reals, n: int) -> None:
    """Let H y = -s, by H + (-s - H y)(sᵀ H)/(sᵀ H y). Before the first step s is zero, and H stays."""
    product = 0.0
    for j in range(n):
        along[j] = 0.0
        for i in range(n):
            along[j] += s[i] * H[i * n + j]
        product += along[j] * (r[j] - last[j])
    if product == 0.0:
        return
    for i in range(n):
        change = -s[i]
        for j in range(n):
            change -= H[i * n + j] * (r[j] - last[j])
        for j in range(n):
            H[i * n + j] += change / product * along[j]
