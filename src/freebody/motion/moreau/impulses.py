"""The contact problem of a step or of its correction, solved by sweeps and by Newton's method in turn."""

from __future__ import annotations

import math

from ...native.instructions import compiled, lesser
from ..cones.islands import SMALL_FIRST, Islands, settle
from ..cones.sweeps import solve
from .stepping_record import Run

FEW, MORE = 16, 40
"""Sweeps before the first and the second turn of Newton's method."""
TURNS, ANEW, PATIENT, WEARY = 8, 4, 1, 3
"""Turns of sweeps and Newton's method, the one that forgets the impulses of the last step, and the first ones that take
what is close to the goal, and what is close enough."""
CLOSE = 10.0
"""Multiple of the goal that is close to it: more than round-off may be left of rows that are nearly alike."""


@compiled
def impulses(run: Run, islands: Islands, goal: float, enough: float, near: int) -> int:
    """Solve the contact problem to within ``goal`` from x; return 1 on success, else 0.

    A residual close to it is taken where two turns have not ended, and one of ``enough`` where four have not.
    ``near``: 1 where Newton's method or the dual one needs no sweeps before it.
    """
    problem, most = run.problem, FEW
    if near == 1 and settle(problem, islands, goal, enough, SMALL_FIRST) <= goal:
        return 1
    for turn in range(TURNS):
        if turn == ANEW:
            for a in range(problem.count):
                problem.x[a] = 0.0
        if turn == 1:
            most = MORE
        elif turn > 1:
            most = 8 * most if 8 * most < run.most_sweeps else run.most_sweeps
        limit = enough if turn >= WEARY else lesser(enough, CLOSE * goal)
        sweeps = solve(problem, run.sweeping, goal, most)
        run.sweeps += sweeps if sweeps >= 0 else most
        run.sweeping.ended = 1 if sweeps >= 0 else 0
        if sweeps >= 0 or (
            math.isfinite(problem.residual) and settle(problem, islands, goal, limit, turn) <= goal
        ):
            return 1
        if turn >= PATIENT and problem.residual <= limit:
            return 1
        if problem.stop != 0 or not math.isfinite(problem.residual):
            return 0
    return 0
