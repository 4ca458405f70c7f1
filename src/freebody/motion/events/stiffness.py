"""When explicit steps are to follow implicit ones, in compiled code: friction of a slow slip in space is stiff.

The direction of a slip of the speed v follows the load at the rate λ = μ N / (m v). From rest, where μ_s N is reached,
v grows from zero with the square of time, and explicit steps, h < 6/λ, are thousands. Implicit ones grow with v.
"""

from __future__ import annotations

from ...native.instructions import compiled
from ..ode.run import Newton, Run
from .moment import largest

TURNS = 8
"""Number of turns of the power method: the fastest rate of stiff friction is far above the next."""
STABLE = 12.0
"""h λ up to which explicit steps cost less: those of `dop853` are stable up to 6, and take half the evaluations."""


@compiled
def is_slow(run: Run) -> int:
    """Return 1 if the present implicit steps are short enough for an explicit method, else 0.

    λ is the greatest eigenvalue of the derivative of the rates, by the power method.
    """
    own, n, x, y = Newton(run.own), run.n, run.argument, run.error3
    for i in range(n):
        x[i] = 1.0
    fastest = 0.0
    for _ in range(TURNS):
        size = largest(x, n)
        if not size > 0.0:
            return 1
        for i in range(n):
            y[i] = 0.0
        for k in range(n):
            for i in range(n):
                y[i] += own.J[k, i] * x[k] / size
        fastest = largest(y, n)
        for i in range(n):
            x[i] = y[i]
    return 1 if abs(run.h) * fastest < STABLE else 0
