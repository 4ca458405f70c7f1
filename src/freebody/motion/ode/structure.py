"""Symplectic Gauss collocation of order 6 with equal steps: in long runs the energy does not drift.

    q' = ∂H/∂P,   P' = -∂H/∂q,        H(q, P) = ½ pᵀ M(q)⁻¹ p + V(q),   p = B(q)ᵀ P,   q' = B(q) u,   u = M⁻¹ p

is integrated in place of (q, u), with the three stages of `collocation`: symplectic, symmetric, of order 6. For a ball
or free joint q holds a unit quaternion e, and P its four momenta. On these the Hamiltonian system is the lift of the
motion on the group. |e|² and e·P are quadratic, so Gauss collocation conserves them to round-off, as it does linear and
angular momentum. The quaternion is never normalised during the run. By backward error analysis the computed states are
those of a machine whose energy differs by O(h⁶), for times that grow exponentially with 1/h. In chaotic motion, if
steps are long compared with its fastest moments, these times are short, and that energy walks at random.

The stages are iterated to round-off and the sums compensated. What remains is a random walk of single round-offs. (q,
P) is carried from step to step. A state between steps is the end of a shorter step. The dense output is cubic: it only
brackets events, which are then located on shorter steps.

Source: E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration (2006), sections VI.4, VII.2, VIII.6, IX.8.
"""

from __future__ import annotations

import math

from ...native.instructions import Integers, Reals, call, compiled, shifted
from . import step_control
from .collocation import NEW_, bound_to
from .layout import BLAME, CONSTANTS, DENSE, KERNELS, POINT, RAW, ROWS, STATE
from .step_control import cubic

STAGES = 3
_bound = bound_to(STAGES, goal=0.0, most=60)
forget, step_from, hold_step, pass_step = (
    _bound[name] for name in ("forget", "step_from", "hold_step", "pass_step")
)
# Rows of length 2w after those of the collocation: (q, P) at the start, at the end, and at the end of the saved step.
BEGIN, FINAL, HELD = 4 * STAGES + 6, 4 * STAGES + 7, 4 * STAGES + 8
# Indices after KERNELS: Hamilton's equations, (q, u) to P, (q, P) to u, and the number of coordinates.
HAMILTON, MOMENTA, SPEEDS, COORDINATES = 0, 1, 2, 3


@compiled
def prepare(
    rates: int, t: float, work: Reals, w: int, n: int, c: Reals, quaternions: Integers, nq: int, integers: Integers
) -> None:  # fmt: skip
    """Compute (q, P) at STATE."""
    block, v, m = ROWS * w, 2 * w, quaternions[nq + KERNELS + COORDINATES]
    constants = shifted(c, quaternions[nq + CONSTANTS])
    begin = block + BEGIN * v
    for i in range(m):
        work[begin + i] = work[STATE * w + i]
    call(quaternions[nq + KERNELS + MOMENTA], t, work, STATE * w, constants, work, begin + m)
    new = block + (4 * STAGES + NEW_) * v
    call(quaternions[nq + KERNELS + HAMILTON], t, work, begin, constants, work, new)
    forget(work, block, v, 2 * m, 1.0)


@compiled
def attempt(
    rates: int, t: float, h: float, work: Reals, w: int, n: int, c: Reals, quaternions: Integers, nq: int,
    relative: Reals, absolute: Reals, integers: Integers,
) -> int:  # fmt: skip
    """Take one step of length ``h`` from STATE to RAW."""
    block, v, m = ROWS * w, 2 * w, quaternions[nq + KERNELS + COORDINATES]
    constants = shifted(c, quaternions[nq + CONSTANTS])
    final = block + FINAL * v
    failed = step_from(
        quaternions[nq + KERNELS + HAMILTON], t, h, work, block + BEGIN * v, final, block, v, 2 * m, constants,
        relative, absolute, n, integers,
    )  # fmt: skip
    if failed == 0:
        for i in range(m):
            work[RAW * w + i] = work[final + i]
        call(quaternions[nq + KERNELS + SPEEDS], t + h, work, final, constants, work, RAW * w + m)
    return failed


@compiled
def judge(
    n: int, work: Reals, w: int, h: float, relative: Reals, absolute: Reals, integers: Integers
) -> float:
    """Return 0, or nan if the state is not finite: the user prescribes the length of the steps."""
    for i in range(n):
        if not math.isfinite(work[RAW * w + i]):
            integers[BLAME] = i
            return math.nan
    return 0.0


@compiled
def densify(
    rates: int, t: float, h: float, work: Reals, w: int, n: int, c: Reals, quaternions: Integers, nq: int
) -> None:
    """Set rows DENSE to DENSE + 2 of the cubic through the states and rates at both ends."""
    cubic(work, w, h, 12)


@compiled
def interpolate(x: float, work: Reals, w: int) -> None:
    """Set row POINT: the cubic at the fraction ``x`` (0 to 1) of the step."""
    z = 1.0 - x
    for i in range(w):
        p = work[(DENSE + 1) * w + i] + x * work[(DENSE + 2) * w + i]
        work[POINT * w + i] = work[STATE * w + i] + x * (work[DENSE * w + i] + z * p)


@compiled
def hold(work: Reals, w: int, n: int) -> None:
    """Save the step while shorter steps are tried."""
    block, v = ROWS * w, 2 * w
    hold_step(work, block, v, v)
    for i in range(v):
        work[block + HELD * v + i] = work[block + FINAL * v + i]


@compiled
def accept(work: Reals, w: int, n: int) -> None:
    """Make the end of the step the next start."""
    block, v = ROWS * w, 2 * w
    pass_step(work, block, v, v)
    for i in range(v):
        work[block + BEGIN * v + i] = work[block + HELD * v + i]


FUNCTIONS = step_control.Functions(
    {
        "prepare": prepare,
        "attempt": attempt,
        "judge": judge,
        "densify": densify,
        "interpolate": interpolate,
        "hold": hold,
        "accept": accept,
    }
)
