"""The contact problem of a step or of its correction, solved by sweeps and by Newton's method in turn."""

from __future__ import annotations

import math

from ...native.instructions import compiled, greater, inlined, lesser
from ..cones.islands import SMALL_FIRST, Islands, settle
from ..cones.sweeps import solve
from .pairs import faced
from .stepping_record import Run

FEWER, FEW, MORE = 8, 16, 40
"""Sweeps before the first turns of Newton's method for faces on faces, whose forces are open, so that Newton's method
gains more than sweeps do; for others before its first turn, and before its second one."""
CLOSER, CLOSE = 10.0, 100.0
"""Multiples of the tolerance of a step at which a search that is slow ends, of others and of faces on faces: more than
round-off may be left of rows that are nearly alike."""
TURNS, ANEW, WEARY = 8, 4, 3
"""Turns of sweeps and Newton's method, the one that forgets the impulses of the last step, and the first one that takes
what is close enough."""


@compiled
def impulses(run: Run, islands: Islands, goal: float, enough: float, near: int) -> int:
    """Solve the contact problem to within ``goal`` from x; return 1 on success, else 0.

    A residual `close` to it is taken where two turns have not ended, of faces on faces, whose forces are open, where
    one has not, and one of ``enough`` where four have not.
    ``near``: 1 where Newton's method or the dual one needs no sweeps before it.
    """
    problem, many, faces = run.problem, FEW, faced(run)
    fair = close(run, goal, enough, CLOSE) if faces == 1 else goal
    limit = fair
    if near == 1 and settle(problem, islands, goal, fair, enough, SMALL_FIRST) <= fair:
        return 1
    for turn in range(TURNS):
        if turn == ANEW:
            for a in range(problem.count):
                problem.x[a] = 0.0
        if turn == 1:
            many, fair = MORE, close(run, goal, enough, CLOSE if faces == 1 else CLOSER)
            limit = fair
        elif turn > 1:
            many = 8 * many if 8 * many < run.most_sweeps else run.most_sweeps
        most = FEWER if faces == 1 and turn < ANEW else many
        if turn == WEARY:
            limit = greater(goal, enough)
        sweeps = solve(problem, run.sweeping, goal, most)
        run.sweeps += sweeps if sweeps >= 0 else most
        run.sweeping.ended = 1 if sweeps >= 0 else 0
        if sweeps >= 0 or (
            math.isfinite(problem.residual) and settle(problem, islands, goal, fair, limit, turn) <= limit
        ):
            return 1
        if problem.stop != 0 or not math.isfinite(problem.residual):
            return 0
    return 0


@compiled
def reached(run: Run, goal: float) -> float:
    """Return the goal that the last result has reached: ``goal``, what is `close` to it, or what is enough."""
    left, fair = run.problem.residual, close(run, goal, run.enough, CLOSE)
    return goal if left <= goal else (fair if left <= fair else run.enough)


@inlined
def close(run: Run, goal: float, enough: float, part: float) -> float:
    """Return a multiple of the tolerance, at most ``enough`` and at least the goal, at which a slow search ends."""
    return greater(goal, lesser(enough, part * run.tolerance))
