"""The explicit Runge-Kutta method of order 8(5,3) of Dormand and Prince.

    k_i = f(t + c_i h, y + h Σ_j a_ij k_j),   i = 0 ... 11
    y(t + h) = y + h Σ_j b_j k_j                         order 8
    h Σ_j e5_j k_j,  h Σ_j e3_j k_j                      differences from embedded results of order 5 and 3
    k_12 = f(t + h, y(t + h))
    h Σ_j d_ij k_j                                       rows 3 to 5 of the dense output, of order 6

The estimate of the error

    ε = |h| e5² / sqrt(e5² + e3²/100),   e = max_i |error_i| / (a_i + r_i max(|y_i|, |y_i(t + h)|))

uses the greatest component and not the mean, so that a tolerance holds for every coordinate of a large machine. The
next step is h · 0.9 ε^-(1/8 - β/5) ε_old^β, between h/3 and 6h.

A row of coefficients maps the number of a stage to its coefficient. A stage that is not listed has the coefficient
zero.

Source: E. Hairer, S. P. Norsett, G. Wanner, "Solving Ordinary Differential Equations I: Nonstiff Problems", 2nd
edition, Springer 1993, sections II.4 (control), II.5 (method) and the authors' program DOP853. Their dense output of
order 7 takes three more stages. The one here takes none: at every x it satisfies the conditions of all orders up to 6,
which leave one coefficient free, that of k_7. At the lengths of steps its error is as small (decision 300).
"""

from __future__ import annotations

from collections.abc import Mapping

from ...native.functions import components, unrolled
from ...native.instructions import Real, compiled, greater, root, where
from ...native.rows import chain, combination
from .method import Method, cubic, lift_stages
from .run import Run
from .step_control import Functions

C = (
    0.0, 0.05260015195876773, 0.0789002279381516, 0.1183503419072274,
    0.2816496580927726, 0.3333333333333333, 0.25, 0.3076923076923077,
    0.6512820512820513, 0.6, 0.8571428571428571, 1.0,
)  # fmt: skip

A: tuple[Mapping[int, float], ...] = (
    {},
    {0: 0.05260015195876773},
    {0: 0.0197250569845379, 1: 0.0591751709536137},
    {0: 0.02958758547680685, 2: 0.08876275643042054},
    {0: 0.2413651341592667, 2: -0.8845494793282861, 3: 0.924834003261792},
    {0: 0.037037037037037035, 3: 0.17082860872947386, 4: 0.12546768756682242},
    {0: 0.037109375, 3: 0.17025221101954405, 4: 0.06021653898045596, 5: -0.017578125},
    {0: 0.03709200011850479, 3: 0.17038392571223998, 4: 0.10726203044637328, 5: -0.015319437748624402,
     6: 0.008273789163814023},
    {0: 0.6241109587160757, 3: -3.3608926294469414, 4: -0.868219346841726, 5: 27.59209969944671, 6: 20.154067550477894,
     7: -43.48988418106996},
    {0: 0.47766253643826434, 3: -2.4881146199716677, 4: -0.590290826836843, 5: 21.230051448181193,
     6: 15.279233632882423, 7: -33.28821096898486, 8: -0.020331201708508627},
    {0: -0.9371424300859873, 3: 5.186372428844064, 4: 1.0914373489967295, 5: -8.149787010746927, 6: -18.52006565999696,
     7: 22.739487099350505, 8: 2.4936055526796523, 9: -3.0467644718982196},
    {0: 2.273310147516538, 3: -10.53449546673725, 4: -2.0008720582248625, 5: -17.9589318631188, 6: 27.94888452941996,
     7: -2.8589982771350235, 8: -8.87285693353063, 9: 12.360567175794303, 10: 0.6433927460157636},
)  # fmt: skip
B = {0: 0.054293734116568765, 5: 4.450312892752409, 6: 1.8915178993145003, 7: -5.801203960010585, 8: 0.3111643669578199,
 9: -0.1521609496625161, 10: 0.20136540080403034, 11: 0.04471061572777259}  # fmt: skip
E5 = {0: 0.01312004499419488, 5: -1.2251564463762044, 6: -0.4957589496572502, 7: 1.6643771824549864,
 8: -0.35032884874997366, 9: 0.3341791187130175, 10: 0.08192320648511571, 11: -0.022355307863886294}  # fmt: skip
E3 = {**B, 0: -0.18980075407240762, 8: -0.4226823213237919, 11: 0.02265179219836082}  # fmt: skip
D = (
    {0: -3.92723247556964, 5: -34.456227744019685, 6: 30.623075878077934, 8: -26.56299993961385, 9: 32.6762334305924,
     10: 0.8627187906713195, 11: 1.11776539319049, 12: -0.33333333332897663},
    {0: 2.5320890444247435, 5: 16.35076979471521, 6: -17.703618983975748, 8: 0.9002856868977598, 9: 1.134442974735883,
     10: -6.458276795664525, 11: -3.755691721128684, 12: 6.999999999995363},
    {0: 5.009557910198367, 5: 102.46513929617508, 6: -73.67299172103395, 8: 102.25402453967453,
     9: -134.83173705008815, 10: 1.469819056059229, 11: 0.41729908012461747, 12: -3.1111111111097576},
)  # fmt: skip


@compiled
def attempt(run: Run, h: Real) -> int:
    """Take one step of length ``h`` from y, whose rates are k[0], to y_new, with both errors."""
    for i in unrolled(1, 12):
        run.argument[:] = run.y + h * chain(A[i], run.k)
        run.rates(run.t + C[i] * h, run.argument, run.c, run.k[i])
    run.y_new[:] = run.y + h * combination(B, run.k)
    run.error5[:] = h * combination(E5, run.k)
    run.error3[:] = h * combination(E3, run.k)
    return 0


@compiled
def judge(run: Run, h: Real) -> Real:
    """Return the error ε of the step in units of the tolerance, nan if it is not finite."""
    e5: Real = 0.0
    e3: Real = 0.0
    doubt: Real = 0.0
    blame = run.blame
    for i in range(run.n):
        new = run.y_new[i]
        scale = run.absolute[i] + run.relative[i] * greater(abs(run.y[i]), abs(new))
        ratio5, ratio3 = abs(run.error5[i]) / scale, abs(run.error3[i]) / scale
        doubt += 0.0 * new + 0.0 * ratio5 + 0.0 * ratio3
        blame = where(ratio5 > e5, i, blame)
        e5, e3 = greater(ratio5, e5), greater(e3, ratio3)
    run.blame = blame
    return where(e5 * e5 == 0.0, 0.0, e5 * e5 / root(e5 * e5 + 0.01 * e3 * e3)) + doubt


@compiled
def densify(run: Run) -> None:
    """Compute the dense output of the step, whose rates at the end are k[12]."""
    cubic(run, 12)
    for i in unrolled(3, 6):
        run.dense[i][:] = run.h * combination(D[i - 3], run.k)


@compiled
def interpolate(run: Run, x: float) -> None:
    """Set the row point: the dense output at the fraction ``x`` (0 to 1) of the step."""
    z = 1.0 - x
    for i in components(run.width):
        p = run.dense[3, i] + x * (run.dense[4, i] + z * run.dense[5, i])
        p = run.dense[1, i] + x * (run.dense[2, i] + z * p)
        run.point[i] = run.y[i] + x * (run.dense[0, i] + z * p)


BETA = 0.04
METHOD = Method(
    name="dop853", order=8, attempt=attempt, judge=judge, densify=densify, interpolate=interpolate, lift=lift_stages,
    alpha=0.125 - 0.2 * BETA, beta=BETA, cost=11, last_stage=11, stable=6.1,
)  # fmt: skip
FUNCTIONS = Functions(METHOD)
