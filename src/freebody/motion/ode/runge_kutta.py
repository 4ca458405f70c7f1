"""The compiled functions of a user's explicit Runge-Kutta method (`tableau`).

The dense output is the cubic through the states and rates at both ends of a step; it finds events only.
"""

from __future__ import annotations

from typing import Any

from ...native.functions import unrolled
from ...native.instructions import Parts, Real
from ...native.rows import chain, combination
from .dop54 import judge
from .method import Method, cubic, lift_stages
from .run import Run
from .step_control import Functions
from .tableau import RungeKutta

part = Parts()

A: Any = None
B: Any = None
C: Any = None
E: Any = None
COUNT: Any = None
WITH_END: Any = None
"""Coefficients of the method, in the functions below; number of its stages; whether the error uses the rates at the
end."""


@part
def attempt(run: Run, h: Real) -> int:
    """Take one step of length ``h`` from y, whose rates are k[0], to y_new, with its error."""
    for i in unrolled(1, COUNT):
        run.argument[:] = run.y + h * chain(A[i], run.k)
        run.rates(run.t + C[i] * h, run.argument, run.c, run.k[i])
    run.y_new[:] = run.y + h * combination(B, run.k)
    if WITH_END:
        run.rates(run.t + h, run.y_new, run.c, run.k[COUNT])
    run.error5[:] = h * combination(E, run.k)
    return 0


@part
def densify(run: Run) -> None:
    """Compute the dense output of the step."""
    cubic(run, 12)


@part
def interpolate(run: Run, x: float) -> None:
    """Set the row point: the dense output at the fraction ``x`` (0 to 1) of the step."""
    z = 1.0 - x
    for i in range(run.width):
        run.point[i] = run.y[i] + x * (run.dense[0, i] + z * (run.dense[1, i] + x * run.dense[2, i]))


def functions(tableau: RungeKutta) -> Functions:
    """Return the compiled functions of a method."""
    count = len(tableau.weights)
    space = {
        **globals(), "A": ((), *tableau.stages), "B": tableau.weights, "C": tableau.nodes, "E": tableau.errors,
        "COUNT": count, "WITH_END": len(tableau.embedded) > count,
    }  # fmt: skip
    bound = part.bound(space)
    beta = 0.2 / tableau.order
    ends = count > 1 and abs(tableau.nodes[-1] - 1.0) < 1e-12
    return Functions(
        Method(
            name=tableau.name, order=tableau.order, attempt=bound["attempt"], judge=judge,
            densify=bound["densify"], interpolate=bound["interpolate"], lift=lift_stages,
            alpha=1.0 / tableau.order - 0.75 * beta, beta=beta, smallest=0.2, greatest=10.0,
            cost=count - 1 + (len(tableau.embedded) > count),
            last_stage=count - 1 if ends else 0, stable=tableau.stable if ends else 0.0,
        )
    )  # fmt: skip
