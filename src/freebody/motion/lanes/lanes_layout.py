"""Memory that the loop over lanes and Python share."""

from __future__ import annotations

from typing import Annotated

from ...native.records import Count, Kernel, Real, Record, Row, Rows, Whole, Wholes, record
from ..ending import End
from ..ode.run import Run

# Rows of eight lanes: 0 to 12 hold the rates at the stages of a step (0 at its start, 12 at its end).
STATE, ARGUMENT, RAW, ERROR5, ERROR3, POINT, END, ROWS = 16, 17, 18, 19, 20, 28, 29, 30
# Integers of eight lanes, eight of each: number of the run (-1: none), steps of this leg, rejected steps, steps
# suspected stiff, calm steps, 1 if the step before was rejected, 1 if the step reaches the end, steps of the legs
# before.
RUN, TAKEN, REJECTED, SUSPECT, CALM, AFTER_REJECTION, ENDS, EARLIER_STEPS = range(0, 64, 8)
WIDE_COUNTS = 64
# Numbers of eight lanes: error of the step before, longest step of this leg, end of the leg, admissible change by a
# projection, next output time.
OLD_ERRORS, STRIDE, LEG_END, ALLOWED, NEXT_OUTPUT = range(0, 40, 8)
WIDE_NUMBERS = 40


@record
class Batch(Record):
    """Many runs of one machine, for the loop over lanes.

    ``prologue``            kernel of the constants of the parameters; the others are functions of (t, y)
    ``wide`` ...            addresses for eight lanes: the rates, or the series of the motion; the projection onto the
                            constraints, or 0; the rates if a series may bend, else 0; and the limits if nothing else is
                            watched
    ``n_limits``            number of the user's events, the last ones, that are limits of one-sided forces. A run may
                            begin beyond these
    ``n_watched``           number of event functions in all: events of the user, then rates of extremes
    ``n_reduced``           number of quantities with extremes
    ``n_dropped``           outputs of the kernel of dropped conditions
    ``room``, ``limit``     steps between two checks of the output times; maximum number of steps
    ``works``, ``stop_if_stiff``    1 if the work is the last component; 1 if a stiff lane stops
    ``budget``              number of steps after which tolerances are tightened, or 0
    ``limit_values``        for eight lanes, if only limits are watched: the place of their values at the ends of the
                            steps, and of their changes in the steps before; else 0
    ``t0``, ``t1``          start and end of the runs; ``finest``: smallest relative tolerance after tightening
    ``leg_starts`` ...      intervals in which signals are polynomials: start, end, length of all steps or 0, settings
                            of the signals; ``columns``: indices of the parameters that these settings are
    ``times``               output times in the order of the run
    ``tolerances``          of each component, absolute and relative; the absolute one of the work is multiplied by the
                            energy
    ``initial``, ``parameters``     rows of each lane
    ``values``              outputs of each lane at each time; nan after the end of the lane
    ``reduced``             of each lane and quantity: greatest, smallest, first and last value
    ``event_times``, ``event_counts``    of each lane and event: first and last time, number of occurrences
    ``outcomes``, ``ends``  of each lane: status, steps, rejected steps, component to blame; time of the end
    """

    prologue: Kernel
    energy: Kernel
    outputs: Kernel
    reductions: Kernel
    dropped: Kernel
    watched: Kernel
    wide: Count
    projection_wide: Count
    rates_wide: Count
    watched_wide: Count
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
    room: Count
    limit: Count
    works: Count
    stop_if_stiff: Count
    budget: Count
    limit_values: Count
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
    reduced: Rows
    event_times: Rows
    event_counts: Wholes
    outcomes: Wholes
    ends: Row
    lane_parameters: Annotated[Row, "n_parameters"]
    spare: Annotated[Row, "spare_size"]
    sampled: Annotated[Row, "sampled_size"]


@record
class Lane(Record):
    """One run of a batch.

    ``number``, ``leg``     number of the run, and of its interval between break points of signals
    ``outputs_done``        number of output times that it has passed
    ``steps``               steps of the legs before
    ``energy``              energy at the start of the run
    ``stride``              longest step of the legs before
    """

    number: Whole
    leg: Whole
    outputs_done: Whole
    steps: Whole
    energy: Real
    stride: Real
    run: Run


@record
class EightLanes(Record):
    """Eight lanes side by side (`lanes_wide`): component i of lane l of a row stands at 8 i + l.

    ``rows``        rows of the length ``w`` = 8 n, then places of eight numbers, then what a kernel needs
    ``c``           constants, ``tolerances``: absolute, then relative tolerances
    ``control``, ``counts``    places of eight numbers and of eight integers
    """

    w: Count
    rows: Row
    c: Annotated[Row, "constants"]
    tolerances: Annotated[Row, "tolerances_size"]
    control: Annotated[Row, WIDE_NUMBERS]
    counts: Annotated[Wholes, WIDE_COUNTS]


# Places of what is stored for each quantity, and of what is stored for each lane.
GREATEST, SMALLEST, FIRST, LAST = 0, 1, 2, 3
STATUS, STEPS_TAKEN, STEPS_REJECTED, BLAMED = 0, 1, 2, 3
EXTREMES = 4  # numbers stored per quantity: greatest, smallest, first, last
OUTCOME_SIZE = 4  # integers stored per lane: status, steps, rejected steps, component to blame

# Status codes of a lane, besides those in `layout`.
TOO_MANY, CONTRADICTED = int(End.TOO_MANY_STEPS), int(End.CONTRADICTED)

# Offsets, after the rows, of eight numbers each: steps, times and moments of the lanes; errors of the steps; 1 if
# stability may limit a step; 1 for lanes that took their steps, or are still projected; changes by the projection; for
# `taylor` the lengths from the series, log₂ r / p, and parts of the steps; ends of the steps; 1 if only the error of a
# step has to be examined.
STEPS, TIMES, MOMENTS, ERRORS, LIMITED, SELECTED, CHANGES, LENGTHS, LOGARITHMS, SPANS, AFTERS, EASY = range(
    0, 96, 8
)
WIDE_PLACES = 96
