"""Memory that the loop over lanes and Python share."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from ...native.records import (
    Alone,
    Count,
    Kernel,
    Real,
    Record,
    Row,
    Rows,
    Whole,
    Wholes,
    record,
    record_of_lanes,
)
from ..ending import End
from ..ode.run import Run


@record
class Batch(Record):
    """Many runs of one machine, for the loop over lanes.

    ``prologue``            kernel of the constants of the parameters; the others are functions of (t, y)
    ``n_limits``            number of the user's events, the last ones, that are limits of one-sided forces. A run may
                            begin beyond these
    ``n_watched``           number of event functions in all: events of the user, then rates of extremes
    ``n_reduced``           number of quantities with extremes
    ``n_dropped``           outputs of the kernel of dropped conditions
    ``limit``               maximum number of steps
    ``works``, ``stop_if_stiff``    1 if the work is the last component; 1 if a stiff lane stops
    ``budget``              number of steps after which tolerances are tightened, or 0
    ``near_limits``         1 if nothing is watched but limits: their values at the ends of the steps of all lanes tell
                            where to look closer (`lanes.near_limit`)
    ``t0``, ``t1``          start and end of the runs; ``finest``: smallest relative tolerance after tightening
    ``leg_starts`` ...      intervals in which signals are polynomials: start, end, length of all steps or 0, settings
                            of the signals; ``columns``: indices of the parameters that these settings are
    ``times``               output times in the order of the run
    ``tolerances``          of each component, absolute and relative; the absolute one of the work is multiplied by the
                            energy
    ``initial``, ``parameters``     rows of each lane
    ``values``              outputs of each lane at each time; nan after the end of the lane
    ``greatest``, ``smallest``, ``first``, ``last``    of each lane: values of each quantity with extremes
    ``event_times``, ``event_counts``    of each lane and event: first and last time, number of occurrences
    ``status``, ``blame``, ``ends``    of each lane: how it ended, the component to blame, the time
    ``steps``, ``rejected`` of each lane: numbers of steps
    """

    prologue: Kernel
    energy: Kernel
    outputs: Kernel
    reductions: Kernel
    dropped: Kernel
    watched: Kernel
    n_parameters: Count
    n_constants: Count
    n_events: Count
    n_limits: Count
    n_watched: Count
    n_outputs: Count
    n_times: Count
    n_reduced: Count
    n_dropped: Count
    n_legs: Count
    n_settings: Count
    limit: Count
    works: Count
    stop_if_stiff: Count
    budget: Count
    near_limits: Count
    t0: Real
    t1: Real
    longest: Real
    order: Real
    finest: Real
    leg_starts: Row
    leg_ends: Row
    leg_steps: Row
    settings: Rows
    columns: Wholes
    times: Row
    tolerances: Row
    initial: Rows
    parameters: Rows
    values: Row
    greatest: Rows
    smallest: Rows
    first: Rows
    last: Rows
    event_times: Rows
    event_counts: Wholes
    status: Wholes
    steps: Wholes
    rejected: Wholes
    blame: Wholes
    ends: Row
    lane_parameters: Annotated[Row, "n_parameters"]
    spare: Annotated[Row, "spare_size"]


@record_of_lanes
class Lane(Record):
    """A lane, or eight side by side, with their runs.

    ``number``, ``leg``     number of the run, -1 without one, and of its interval between break points of signals
    ``outputs_done``        number of output times that it has passed; ``next_output``: the time of the next
    ``steps``               steps of the legs before
    ``energy``              energy at the start of the run
    ``stride``, ``longest`` longest step of the legs before, and of this one
    """

    number: Whole
    leg: Whole
    outputs_done: Whole
    steps: Whole
    energy: Real
    stride: Real
    longest: Real
    next_output: Real
    run: Run


if TYPE_CHECKING:
    OneLane = Lane
else:
    OneLane = Alone(Lane)  # the memory of one lane, in a function of eight

# Status codes of a lane, besides those in `layout`.
TOO_MANY, CONTRADICTED = int(End.TOO_MANY_STEPS), int(End.CONTRADICTED)
