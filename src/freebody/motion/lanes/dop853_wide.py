"""Explicit Runge-Kutta method of order 8 of Dormand and Prince: the step of `dop853` for eight lanes (`lanes_wide`)."""

from __future__ import annotations

from typing import Any

from ...native.arithmetic import WHOLE
from ...native.functions import instruction, unrolled
from ...native.instructions import Reals, compiled
from ...native.row_arithmetic import Eight, all_of
from ..ode.dop853 import E3, E5, METHOD, A, B, C
from ..ode.run import Run
from .instructions_wide import Memory, blend, call_wide, lifted, linear
from .lanes_layout import (
    ARGUMENT,
    END,
    ERROR3,
    ERROR5,
    ERRORS,
    LIMITED,
    MOMENTS,
    RAW,
    ROWS,
    STATE,
    STEPS,
    TIMES,
)

HEIGHT = ROWS
LAST, STABLE = METHOD.last_stage, METHOD.stable

_a = (None, *(linear(row, chained=True) for row in A[1:12]))
_b, _e5, _e3 = (linear(row) for row in (B, E5, E3))


@compiled
def prepare_wide(kernel: int, wide: Reals, w: int, c: Reals, tolerances: Reals) -> None:
    """Do nothing: the rates at STATE are those at the end of the step before."""


@compiled
def stage(kernel: int, fraction: float, k: int, wide: Reals, w: int, c: Reals) -> None:
    """Set row k: the rates at row ARGUMENT, at the fraction ``fraction`` of the step of each lane."""
    places = ROWS * w
    for lane in range(8):
        wide[places + MOMENTS + lane] = wide[places + TIMES + lane] + fraction * wide[places + STEPS + lane]
    call_wide(kernel, wide, places + MOMENTS, wide, ARGUMENT * w, c, wide, k * w)


@compiled
def attempt_wide(kernel: int, wide: Reals, w: int, c: Reals) -> None:
    """Take one step of each lane from STATE, whose rates are row 0 (`dop853.attempt`)."""
    h = ROWS * w + STEPS
    for i in unrolled(1, 12):
        _a[i](wide, w, ARGUMENT, STATE, h)
        stage(kernel, C[i], i, wide, w, c)
    _b(wide, w, RAW, STATE, h)
    _e5(wide, w, ERROR5, -1, h)
    _e3(wide, w, ERROR3, -1, h)


@instruction("Reals", "int", "Reals")
def _judged(builder: Any, wide: Any, w: Any, tolerances: Any) -> None:
    """Set ERRORS to the errors of the steps (`dop853.judge`)."""
    v = Memory(builder, wide)
    fifth, third, doubt = (v.variable(0.0) for _ in range(3))

    def row(k: int, offset: Any) -> Eight:
        return v.load(v.plus(WHOLE(0), offset, k, w))

    with v.rows(w) as offset:
        new, relative = row(RAW, offset), v.load(builder.add(w, offset), tolerances)
        scale = v.load(offset, tolerances) + relative * abs(row(STATE, offset)).greater(abs(new))
        ratio5, ratio3 = abs(row(ERROR5, offset)) / scale, abs(row(ERROR3, offset)) / scale
        doubt.become(doubt.now + new * 0.0 + ratio5 * 0.0 + ratio3 * 0.0)
        fifth.become(ratio5.greater(fifth.now))
        third.become(third.now.greater(ratio3))
    error5, error3 = fifth.now, third.now
    error = error5 * error5 / (error5 * error5 + 0.01 * error3 * error3).root()
    error = error.where((error5 * error5).compared("!=", 0.0), 0.0) + doubt.now
    v.store(error, v.plus(WHOLE(ERRORS), WHOLE(0), ROWS, w))


@compiled
def judge_wide(rates: int, n: int, wide: Reals, w: int, c: Reals, tolerances: Reals) -> None:
    """Set ERRORS to the errors of the steps in units of their tolerances, nan if they are not finite."""
    _judged(wide, w, tolerances)


@instruction("Reals", "int")
def _limited(builder: Any, wide: Any, w: Any) -> None:
    """Set LIMITED to 1 or 0 (`step_control.is_stiff`)."""
    v = Memory(builder, wide)
    above, below, across = (v.variable(0.0) for _ in range(3))

    def change(k: int, j: int, offset: Any) -> Eight:
        return v.load(v.plus(WHOLE(0), offset, k, w)) - v.load(v.plus(WHOLE(0), offset, j, w))

    with v.rows(w) as offset:
        a, b = change(12, LAST, offset), change(END, ARGUMENT, offset)
        for total, product in ((above, a * a), (below, b * b), (across, a * b)):
            total.become(total.now + product)
    h = v.load(v.plus(WHOLE(STEPS), WHOLE(0), ROWS, w))
    limited = below.now.compared(">", 0.0)
    for less, more in (
        (h * across.now, -0.5 * abs(h) * (above.now * below.now).root()),
        (below.now * (STABLE * STABLE), h * h * above.now),
    ):
        limited = builder.and_(limited, less.compared("<", more))
    v.store(Eight(builder, all_of(1.0)).where(limited, 0.0), v.plus(WHOLE(LIMITED), WHOLE(0), ROWS, w))


@compiled
def limit_wide(wide: Reals, w: int) -> None:
    """Mark the steps that are as long as the region of stability allows."""
    _limited(wide, w)


@compiled
def begin_wide(lane: int, n: int, wide: Reals, w: int) -> None:
    """Do nothing: only the state and its rates are carried from step to step."""


@compiled
def tune_wide(lane: int, n: int, wide: Reals, w: int, tolerances: Reals) -> None:
    """Do nothing: no quantity of this method depends on the tolerances."""


@compiled
def accept_wide(wide: Reals, w: int, selected: int) -> None:
    """Make the rates at the end those of the next step."""
    blend(wide, w, 12 * w, 0, selected)


_lift = lifted({k: (False, k) for k in (*range(13), STATE, RAW, END)}, HEIGHT)


@compiled
def lift(lane: int, wide: Reals, w: int, run: Run) -> None:
    """Copy the step of a lane into the memory of a run."""
    _lift(lane, run.n, wide, w, run.k[0], run.k[0], run.width)


FUNCTIONS = {
    "HEIGHT": HEIGHT,
    "prepare_wide": prepare_wide,
    "attempt_wide": attempt_wide,
    "judge_wide": judge_wide,
    "limit_wide": limit_wide,
    "begin_wide": begin_wide,
    "tune_wide": tune_wide,
    "accept_wide": accept_wide,
    "lift": lift,
}
