"""The explicit Runge-Kutta method of order 5(4) of Tsitouras, for coarse tolerances.

    k_i = f(t + c_i h, y + h Σ_j a_ij k_j),   i = 0 ... 6,        y(t + h) = y + h Σ_j b_j k_j
    y(t + x h) = y + h Σ_i (r_i1 x + r_i2 x² + r_i3 x³ + r_i4 x⁴) k_i

The error is the difference from the embedded result of order 4, and the dense output has order 4. The stages are those
of `dop54`, with coefficients for which the terms of order 6 of the error are smaller.

Source: C. Tsitouras, Runge-Kutta pairs of order 5(4) satisfying only the first column simplifying assumption, Computers
and Mathematics with Applications 62 (2011), 770-775.
"""

from __future__ import annotations

from ...native.functions import unrolled
from ...native.instructions import Real, compiled
from ...native.rows import chain, combination
from .dop54 import judge
from .method import Method, lift_stages
from .run import Run
from .step_control import Functions

C = (0.0, 0.161, 0.327, 0.9, 0.9800255409045097, 1.0)
A = (
    (),
    (0.161,),
    (-0.008480655492356989, 0.335480655492357),
    (2.8971530571054935, -6.359448489975075, 4.3622954328695815),
    (5.325864828439257, -11.748883564062828, 7.4955393428898365, -0.09249506636175525),
    (5.86145544294642, -12.92096931784711, 8.159367898576159, -0.071584973281401, -0.028269050394068383),
)
B = (
    0.09646076681806523, 0.01, 0.4798896504144996, 1.379008574103742, -3.290069515436081, 2.324710524099774,
)  # fmt: skip
E = (
    -0.00178001105222577714, -0.0008164344596567469, 0.007880878010261995, -0.1447110071732629, 0.5823571654525552,
    -0.45808210592918697, 1 / 66,
)  # fmt: skip
R = (
    (1.0,),
    (
        -2.763706197274826,
        0.1317,
        3.9302962368947516,
        -12.411077166933676,
        37.50931341651104,
        -27.896526289197286,
        1.5,
    ),
    (
        2.9132554618219126,
        -0.2234,
        -5.941033872131505,
        30.33818863028232,
        -88.1789048947664,
        65.09189467479366,
        -4.0,
    ),
    (
        -1.0530884977290216,
        0.1017,
        2.490627285651253,
        -16.548102889244902,
        47.37952196281928,
        -34.87065786149661,
        2.5,
    ),
)


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
def densify(run: Run) -> None:
    """Compute the dense output of the step."""
    for i in unrolled(4):
        run.dense[i][:] = run.h * combination(R[i], run.k)


@compiled
def interpolate(run: Run, x: float) -> None:
    """Set the row point: the dense output at the fraction ``x`` (0 to 1) of the step."""
    for i in range(run.width):
        p = run.dense[2, i] + x * run.dense[3, i]
        run.point[i] = run.y[i] + x * (run.dense[0, i] + x * (run.dense[1, i] + x * p))


BETA = 0.04
METHOD = Method(
    name="tsit5", order=5, attempt=attempt, judge=judge, densify=densify, interpolate=interpolate, lift=lift_stages,
    alpha=0.2 - 0.75 * BETA, beta=BETA, smallest=0.2, greatest=10.0, cost=6, last_stage=5, stable=3.45,
)  # fmt: skip
FUNCTIONS = Functions(METHOD)
