"""One step across a position in which conditions depend on each other: Gauss collocation with stages on the conditions.

Bars of a parallelogram come into line: there two motions meet, and G M⁻¹ Gᵀ is singular. Beside that position, at the
distance s in terms of `dynamics.constrained.hold`, what is off the conditions by e is off by e/s after it was moved
onto them, and turns into accelerations that are off by e/s³: stages that are off by the error of a method make every
step fail, and so the control of the step closes in on that position. But the motion along its branch is smooth. So

    y' = f(P(y)),   P: onto the conditions

is integrated in place of y' = f(y), of which it has the solution, by one step whose stages lie on both sides, each at a
distance. The polynomial through the stages is the motion in between, too: no state near the middle is evaluated, nor
moved onto conditions that do not hold there.
"""

from __future__ import annotations

from ...native.instructions import (
    Integers,
    Reals,
    call,
    compiled,
    greater,
    integers_at,
    reals_at,
    root,
    shifted,
    whole,
)
from ..ode.layout import RAW, ROWS, STATE
from . import gauss, step_control
from .collocation import bound_to

# Of the constants of f(P(y)), before those of f: addresses of f and P, number of components, of those that P gives, of
# quaternions, addresses of the places of these and of room for two states
RATES, ONTO, SIZE, MOVED, TURNING, PLACES, ROOM, OWN = 0, 1, 2, 3, 4, 5, 6, 8

TURNS = 6  # Newton steps of P at most; their error is squared in each
NEAR = 1e-8  # change after which the next one is round-off


@compiled
def along_branch(t: float, y: Reals, c: Reals, out: Reals) -> None:
    """f(P(y)), a kernel."""
    n, moved, nq = whole(c[SIZE]), whole(c[MOVED]), whole(c[TURNING])
    onto, places, state = whole(c[ONTO]), integers_at(whole(c[PLACES])), reals_at(whole(c[ROOM]))
    own = shifted(c, OWN)
    for i in range(n):
        state[i] = y[i]
    change, k = 1.0, 0
    while change > NEAR and k < TURNS:
        call(onto, t, state, 0, own, state, n)
        change = 0.0
        for i in range(moved):
            new = state[n + i]
            change = greater(change, abs(new - state[i]) / (1.0 + abs(new)))
            state[i] = new
        for j in range(nq):
            i = places[j]
            a, b, d, e = state[i], state[i + 1], state[i + 2], state[i + 3]
            size = root(a * a + b * b + d * d + e * e)
            for m in range(4):
                state[i + m] /= size
        k += 1
    call(whole(c[RATES]), t, state, 0, own, out, 0)


@compiled
def approached(
    hold: int, count: int, times: Reals, states: Reals, n: int, c: Reals, room: Reals, limit: float
) -> int:  # fmt: skip
    """Whether s is below a limit at one of ``count`` states, or falls towards it before a step that may hide it; the
    kernel ``hold`` gives s²."""
    before, last = 0.0, 0.0
    for k in range(count):
        call(hold, times[k], states, k * n, c, room, 0)
        s = root(greater(room[0], 0.0))
        if s < limit and (k == 0 or last >= limit):
            return 1
        if (
            k > 1
            and last + (last - before) * (times[k] - times[k - 1]) / (times[k - 1] - times[k - 2]) < limit
        ):
            return 1
        before, last = last, s
    return 0


ROUNDED = 1e-8
"""Change of the stages, in parts of the state, that may be round-off: of accelerations across the branch, which P takes
out again."""
_bound = bound_to(gauss.STAGES, goal=1e-3, most=25, floor=ROUNDED)
step_from = _bound["step_from"]


@compiled
def attempt(
    rates: int, t: float, h: float, work: Reals, w: int, n: int, c: Reals, quaternions: Integers, nq: int,
    relative: Reals, absolute: Reals, integers: Integers,
) -> int:  # fmt: skip
    """The step of length ``h`` from STATE to RAW."""
    return step_from(
        rates, t, h, work, STATE * w, RAW * w, ROWS * w, w, n, c, relative, absolute, n, integers
    )


FUNCTIONS = step_control.Functions({**gauss.FUNCTIONS.method, "WHOLE": 1, "attempt": attempt})
