"""The contact problem of a step or of its correction, solved by sweeps and by Newton's method in turn."""

from __future__ import annotations

import math

from ...native.instructions import compiled, greater
from ..cones.islands import SMALL_FIRST, Islands, settle, within
from ..cones.sweeps import solve
from .stepping_record import Run

FEW, MORE = 16, 40
"""Sweeps before the first and the second turn of Newton's method."""
TURNS, ANEW, WEARY = 8, 4, 3
"""Turns of sweeps and Newton's method, the one that forgets the impulses of the last step, and the first one that takes
what is close enough."""


@compiled
def impulses(run: Run, islands: Islands, goal: float, enough: float, near: int) -> int:
    """Solve the contact problem to within ``goal`` from x; return 1 on success, else 0.

    A residual `within` reach of it is taken where a turn has not ended, and one of ``enough`` where four have not.
    ``near``: 1 where Newton's method or the dual one needs no sweeps before it.
    """
    problem, most, limit = run.problem, FEW, within(goal, enough)
    if near == 1 and settle(problem, islands, goal, enough, SMALL_FIRST) <= limit:
        return 1
    for turn in range(TURNS):
        if turn == ANEW:
            for a in range(problem.count):
                problem.x[a] = 0.0
        if turn == 1:
            most = MORE
        elif turn > 1:
            most = 8 * most if 8 * most < run.most_sweeps else run.most_sweeps
        if turn == WEARY:
            limit = greater(goal, enough)
        sweeps = solve(problem, run.sweeping, goal, most)
        run.sweeps += sweeps if sweeps >= 0 else most
        run.sweeping.ended = 1 if sweeps >= 0 else 0
        if sweeps >= 0 or (
            math.isfinite(problem.residual) and settle(problem, islands, goal, limit, turn) <= limit
        ):
            return 1
        if problem.stop != 0 or not math.isfinite(problem.residual):
            return 0
    return 0


@compiled
def reached(run: Run, goal: float) -> float:
    """Return the goal that the last result has reached: ``goal``, what is `within` its reach, or what is enough."""
    left, close = run.problem.residual, within(goal, run.enough)
    return goal if left <= goal else (close if left <= close else run.enough)
