"""The explicit Runge-Kutta method of order 5(4) of Dormand and Prince, for coarse tolerances.

    k_i = f(t + c_i h, y + h Σ_j a_ij k_j),   i = 0 ... 6,        y(t + h) = y + h Σ_j b_j k_j

The error is the difference from the embedded result of order 4. The dense output has order 4. A step needs seven
evaluations of f, and its start an eighth; a step of order 8 needs twelve. At relative accuracies coarser than about
1e-5 this method is the cheaper.

Source: E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I (1993), sections II.5 (table 5.2)
and II.6.
"""

from __future__ import annotations

from ...native.functions import unrolled
from ...native.instructions import Real, compiled, greater, where
from ...native.rows import chain, combination
from .method import Method, cubic, lift_stages
from .run import Run
from .step_control import Functions

C = (0.0, 0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0)
A = (
    (),
    (1 / 5,),
    (3 / 40, 9 / 40),
    (44 / 45, -56 / 15, 32 / 9),
    (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729),
    (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656),
)
B = (35 / 384, 0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84)
E = (71 / 57600, 0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40)
D = (
    -12715105075 / 11282082432, 0, 87487479700 / 32700410799, -10690763975 / 1880347072, 701980252875 / 199316789632,
    -1453857185 / 822651844, 69997945 / 29380423,
)  # fmt: skip


@compiled
def attempt(run: Run, h: Real) -> int:
    """Take one step of length ``h`` from y, whose rates are k[0], to y_new, with its error."""
    for i in unrolled(1, 6):
        run.argument[:] = run.y + h * chain(A[i], run.k)
        run.rates(run.t + C[i] * h, run.argument, run.c, run.k[i])
    run.y_new[:] = run.y + h * combination(B, run.k)
    run.rates(run.t + h, run.y_new, run.c, run.k[6])
    run.error5[:] = h * combination(E, run.k)
    return 0


@compiled
def judge(run: Run, h: Real) -> Real:
    """Return the error ε of the step in units of the tolerance, nan if it is not finite."""
    error: Real = 0.0
    doubt: Real = 0.0
    blame = run.blame
    for i in range(run.n):
        new, old = abs(run.y_new[i]), abs(run.y[i])
        ratio = abs(run.error5[i]) / (run.absolute[i] + run.relative[i] * greater(new, old))
        doubt += 0.0 * new + 0.0 * ratio
        blame = where(ratio > error, i, blame)
        error = greater(ratio, error)
    run.blame = blame
    return error + doubt


@compiled
def densify(run: Run) -> None:
    """Compute the dense output of the step."""
    cubic(run, 6)
    run.dense[3][:] = run.h * combination(D, run.k)


@compiled
def interpolate(run: Run, x: float) -> None:
    """Set the row point: the dense output at the fraction ``x`` (0 to 1) of the step."""
    z = 1.0 - x
    for i in range(run.width):
        p = run.dense[2, i] + z * run.dense[3, i]
        run.point[i] = run.y[i] + x * (run.dense[0, i] + z * (run.dense[1, i] + x * p))


BETA = 0.04
METHOD = Method(
    name="dop54", order=5, attempt=attempt, judge=judge, densify=densify, interpolate=interpolate, lift=lift_stages,
    alpha=0.2 - 0.75 * BETA, beta=BETA, smallest=0.2, greatest=10.0, cost=6, last_stage=5, stable=3.25,
)  # fmt: skip
FUNCTIONS = Functions(METHOD)
