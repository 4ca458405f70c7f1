"""One step across a position in which conditions depend on each other: Gauss collocation with stages on the conditions.

Bars of a parallelogram come into line. There two motions meet, and G M⁻¹ Gᵀ is singular. Near that position, at the
distance s in terms of `constrained.independence`, a state that is off the conditions by e is off by e/s after its
projection onto them, and its accelerations are off by e/s³. Stages with the error of a method then make every step
fail, and the step-size control stalls before that position. But the motion along its branch is smooth. So

    y' = f(P(y)),   P: onto the conditions

is integrated in place of y' = f(y), which has the same solution, by one step whose stages lie on both sides, each at a
distance. The polynomial through the stages is also the motion between them. No state near the middle is evaluated, or
moved onto conditions that are dependent there.
"""

from __future__ import annotations

from ...native.instructions import Reals, call, compiled, greater, root
from . import gauss
from .gauss import bound_to
from .run import Branch, Collocation, Run
from .states import to_unit
from .step_control import Functions

MOST_ITERATIONS = 6  # maximum number of Newton steps of P; each squares the error
NEAR = 1e-8  # change after which the next change is round-off


@compiled
def along_branch(t: float, y: Reals, c: Reals, out: Reals) -> None:
    """Evaluate f(P(y)), as a kernel."""
    branch = Branch(c)
    state, moved, change, k = branch.state, branch.moved, 1.0, 0
    for i in range(branch.n):
        state[i] = y[i]
    while change > NEAR and k < MOST_ITERATIONS:
        branch.projection(t, state, branch.c, moved)
        change = 0.0
        for i in range(branch.projected):
            change = greater(change, abs(moved[i] - state[i]) / (1.0 + abs(moved[i])))
            state[i] = moved[i]
        to_unit(state, branch.quaternions, branch.n_quaternions)
        k += 1
    branch.rates(t, state, branch.c, out)


@compiled
def approached(
    hold: int, count: int, times: Reals, states: Reals, n: int, c: Reals, room: Reals, limit: float
) -> int:  # fmt: skip
    """Return 1 if s is below a limit at one of ``count`` states, or falls towards it before a step that may hide it.

    The kernel ``hold`` gives s².
    """
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
"""Change of the stages, relative to the state, that may be round-off: of accelerations across the branch, which P
removes again."""
_bound = bound_to(gauss.STAGES, goal=1e-3, most=25, floor=ROUNDED)
step_from = _bound["step_from"]


@compiled
def attempt(run: Run, h: float) -> int:
    """Take the step of length ``h`` from y to y_new."""
    return step_from(run, Collocation(run.own), h)


METHOD = gauss.METHOD._replace(name="crossing", attempt=attempt, single_step=True)
FUNCTIONS = Functions(METHOD)
