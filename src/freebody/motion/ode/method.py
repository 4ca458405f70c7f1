"""What a method of integration is, as a value, and what several methods share."""

from __future__ import annotations

from typing import NamedTuple

from ...native.instructions import Compiled, compiled
from .run import OneRun, Run


class Method(NamedTuple):
    """A method as a value. Its functions are compiled; those that are None have nothing to do.

    ``attempt``       (run, h) -> 0, or 1 if the iteration diverges: one step of length h from y, whose rates are k[0],
                      to y_new
    ``judge``         (run, h) -> error ε of the step in units of the tolerance, nan if it is not finite
    ``densify``       (run): prepares `interpolate`; k[12] holds the rates at the end of the step
    ``interpolate``   (run, x): sets the row point at the fraction x of the step
    ``prepare``       (run, fresh): called before the first step from a new start, in the lanes in which fresh holds
    ``hold``          (run): saves an accepted step, since shorter steps may be tried before `accept`
    ``accept``        (run, good): where good, the step was taken, and y is its end
    ``expect``        (run, length): called after prepare, where the state so far from the start is known: the row end,
                      with its rates in k[12]; an iteration may begin from it
    ``length``        (run) -> length of the next step, if lengths follow from the state at their start; nan if there is
                      none. No error has to be judged then, and the rates at the end of a step are not needed
    ``limited``       (run, h) -> whether stability limits the step; for a method with ``length``
    ``lift``          (run, lane, one): copies the step of a lane, except for its states, into the memory of one run;
                      for methods that take the steps of eight lanes at once
    ``alpha``, ``beta``, ``safety``, ``smallest``, ``greatest``    constants of the control
    ``cost``          evaluations of f in attempt; 0 for a method that counts its own
    ``last_stage``, ``stable``  last stage, whose time is that of the end, of an explicit method, and the end of its
                      region of stability on the negative axis; 0 for a method that is not watched for stiffness
    ``single_step``   True if there is only one step. Its error is judged whatever its length, and states inside it come
                      from the dense output, which is as accurate as its end
    """

    name: str
    order: int
    attempt: Compiled
    judge: Compiled
    interpolate: Compiled
    densify: Compiled | None = None
    prepare: Compiled | None = None
    hold: Compiled | None = None
    accept: Compiled | None = None
    expect: Compiled | None = None
    length: Compiled | None = None
    limited: Compiled | None = None
    lift: Compiled | None = None
    alpha: float = 0.125
    beta: float = 0.0
    safety: float = 0.9
    smallest: float = 1.0 / 3.0
    greatest: float = 6.0
    cost: int = 0
    last_stage: int = 0
    stable: float = 0.0
    single_step: bool = False


@compiled
def cubic(run: Run, last: int) -> None:
    """Set dense[0] to dense[2] of the cubic through the states and rates at both ends; k[last] are those at the end."""
    for i in range(run.width):
        difference = run.y_new[i] - run.y[i]
        run.dense[0, i] = difference
        run.dense[1, i] = run.h * run.k[0, i] - difference
        run.dense[2, i] = 2.0 * difference - run.h * (run.k[last, i] + run.k[0, i])


@compiled
def lift_stages(run: Run, lane: int, one: OneRun) -> None:
    """Copy the rates at the stages of a lane into the memory of one run."""
    for i in range(run.n):
        for j in range(13):
            one.k[j, i] = run.k[j, i][lane]
