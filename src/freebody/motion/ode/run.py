"""Memory of a run, shared by Python and the compiled loop: a step with its rows, and the search for events in it.

Nothing in this file needs a compiler. A run with compiled code on the disk does not load one.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, NamedTuple

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
from .layout import ORDERS

STAGES = 13
"""Number of rows for the rates at the stages of a step; an implicit method uses 0 and 12, at its start and its end."""

# Event functions are evaluated between PARTS parts of a window of the step, and at one more point close to either end.
# MARGIN is the distance of these two points from the ends, as a fraction of the window: they show the slope there.
PARTS, MARGIN = 8, 0.001
BEFORE, ROWS, EVENLY = PARTS + 3, PARTS + 4, PARTS + 1


def at_margin(parts: int) -> tuple[float, ...]:
    """Return the weights by which the polynomial through the values at the ends of the parts gives that at MARGIN.

    >>> at_margin(1)
    (0.999, 0.001)
    """
    ends, x = range(parts + 1), parts * MARGIN
    return tuple(math.prod((x - j) / (k - j) for j in ends if j != k) for k in ends)


AT_MARGIN = at_margin(PARTS)
CLEAR = 16.0
"""Multiple of its error within which a function may have zeros that the points do not show: a vibration is resolved by
six points in a period."""
COEFFICIENTS = ORDERS["taylor"] + 1
"""Number of coefficients of a series."""


@record_of_lanes
class Search(Record):
    """Event functions g(t, y, c), and the search for their zeros in a step (`event_search`).

    ``zero_x``, ``zero_number``, ``zero_sign``    events of the step in order of time: fraction of the step, number of
                                                  the function, sign after the zero
    ``guarded``              number of functions, the last ones, which the loop from event to event guards by itself
    ``unjudged``             1 for each function of which a search need not show how it runs between its points
    ``reach``, ``culprit``   fraction of the step up to which all required functions have values (2: all of it), and the
                             function without a value
    ``seen``, ``span``       fraction of the step that has been searched (1 between two steps), and length of the next
                             window
    ``differences``, ``decay``    differences of the values of a function, and how they decay (`error_between`)
    ``has_slopes``, ``slopes``    1 if the slopes of the functions at the start of the window are known, and these [1/s]
    ``smooth``               1 if all functions run as the state does, which the ends of windows may show (`window`)
    ``past_length``          length of the window before [s], 0 if there is none
    ``unresolved``           number of shortest windows of the step that do not resolve a function
    ``table``     values at the points of the window, and the fraction of the step; then, in row BEFORE, those at the
                  start of the window before
    ``signs``     last nonzero sign of each function, 0 until there is one
    ``log``       times, numbers, signs and states of the events of this piece of the run
    """

    functions: Kernel
    c: Row
    count: Count
    guarded: Count
    unjudged: Annotated[Wholes, "count"]
    reach: Real
    seen: Real
    span: Real
    unresolved: Whole
    decay: Real
    differences: Annotated[Row, EVENLY]
    has_slopes: Whole
    slopes: Annotated[Row, "count"]
    smooth: Count
    past_length: Real
    culprit: Whole
    directions: Annotated[Wholes, "count"]
    terminal: Annotated[Wholes, "count"]
    signs: Annotated[Wholes, "count"]
    table: Annotated[Rows, ROWS, "columns"]
    g: Annotated[Row, "count"]
    zero_x: Annotated[Row, "zeros"]
    zero_number: Annotated[Wholes, "zeros"]
    zero_sign: Annotated[Wholes, "zeros"]
    log_times: Row
    log_numbers: Wholes
    log_signs: Wholes
    log_states: Rows


@record_of_lanes
class Run(Record):
    """A run y' = f(t, y, c), at a step of length h from the state y at t.

    ``until``, ``longest``, ``start``    end of the run, longest step, and start of the run
    ``old_error``       error of the step before
    ``allowed``, ``trend``    length that its error allowed, 0 without one, and its ratio to that of the step before it
    ``accepted``, ``events``             steps and events of this piece of the run; ``taken``: steps of the whole run
    ``blame``           component or event function to blame for a failure
    ``suspect``, ``calm``, ``stiffness`` steps that the region of stability may have limited; consecutive steps that it
                        did not limit; steps that are stiff
    ``sampled``         1 + the step whose states were computed last
    ``stop_if_stiff``, ``fixed``         1 to stop at a stiff step; 1 for steps of equal length
    ``required``        number of event functions that must have a value everywhere
    ``after``, ``last`` end of the step; 1 if the run ends there
    ``quaternions``     components at which unit quaternions begin
    ``projection``      moves a state onto the constraints, or None
    ``own``             memory of the method
    ``k``               rates at the stages: k[0] at y, k[12] at the end
    ``y_new``, ``end``  end of the step, as the method gives it, and on the constraints
    ``dense``, ``point``    coefficients of the dense output, and a state inside the step
    ``error``           error of the step
    ``reached``         fraction of the step whose state, of a shorter step, ``point`` is; -1 if it is another
    ``base``, ``beside``    fraction of the step at the end of its first shorter step, -1 without; state there, its
                        rates, and theirs
    ``times`` ...       buffers for ``room`` steps: time, length and state at the start of each, then the end
    """

    t: Real
    h: Real
    old_error: Real
    until: Real
    longest: Real
    start: Real
    accepted: Whole
    rejected: Whole
    evaluated: Whole
    events: Whole
    blame: Whole
    after_rejection: Whole
    taken: Whole
    suspect: Whole
    calm: Whole
    stiffness: Whole
    sampled: Whole
    stop_if_stiff: Whole
    fixed: Whole
    required: Whole
    allowed: Real
    trend: Real
    after: Real
    error: Real
    reached: Real
    base: Real
    last: Whole
    rates: Kernel
    c: Row
    quaternions: Wholes
    n_quaternions: Count
    projection: Kernel
    projected: Count
    n: Count
    width: Count
    own: Row
    initial: Annotated[Row, "n"]
    relative: Annotated[Row, "n"]
    absolute: Annotated[Row, "n"]
    k: Annotated[Rows, STAGES, "width"]
    y: Annotated[Row, "width"]
    argument: Annotated[Row, "width"]
    y_new: Annotated[Row, "width"]
    error5: Annotated[Row, "width"]
    error3: Annotated[Row, "width"]
    dense: Annotated[Rows, 6, "width"]
    point: Annotated[Row, "width"]
    beside: Annotated[Rows, 3, "width"]
    end: Annotated[Row, "width"]
    search: Search
    room: Whole
    times: Row
    lengths: Row
    states: Rows


if TYPE_CHECKING:
    OneRun = Run
else:
    OneRun = Alone(Run)  # the memory of one run, in a function of lanes


class Counts(NamedTuple):
    """The counts of a run, which are 0 at its start."""

    accepted: int = 0
    rejected: int = 0
    evaluated: int = 0
    events: int = 0
    blame: int = 0
    after_rejection: int = 0
    taken: int = 0
    suspect: int = 0
    calm: int = 0
    stiffness: int = 0
    sampled: int = 0


NUMBERS = (
    "t", "h", "old_error", "until", "longest", "start", *Counts._fields, "stop_if_stiff", "fixed", "required",
)  # fmt: skip
"""What is written at the start of a run."""


@record
class Collocation(Record):
    """Memory of `gauss`, for S stages of an equation z' = f(t, z, c) with rows of the length v.

    ``z``, ``z_new``              start and end of the step
    ``stages``                    rates at the stages
    ``series``, ``before``, ``saved``    coefficients of the rates in this step, in the one before, in the saved one
    ``carry``, ``rounding``, ``saved_rounding``    rounding error of the sum before this step, in it, in the saved one
    ``length_before``, ``length``, ``saved_length``    lengths of these steps
    ``continues``                 1 if there is a step before
    """

    f: Kernel
    c: Row
    n: Count
    v: Count
    length_before: Real
    length: Real
    saved_length: Real
    continues: Whole
    z: Row
    z_new: Row
    stages: Annotated[Rows, "S", "v"]
    series: Annotated[Rows, "S", "v"]
    before: Annotated[Rows, "S", "v"]
    saved: Annotated[Rows, "S", "v"]
    argument: Annotated[Row, "v"]
    new: Annotated[Row, "v"]
    carry: Annotated[Row, "v"]
    rounding: Annotated[Row, "v"]
    saved_rounding: Annotated[Row, "v"]


@record
class Hamiltonian(Record):
    """Memory of `structure`: z = (q, P) at the start and the end of a step, and at the end of the saved step.

    ``momenta``, ``velocities``    kernels of (q, u) to P, and of (q, P) to u
    ``coordinates``                number of coordinates
    """

    momenta: Kernel
    velocities: Kernel
    coordinates: Count
    collocation: Collocation
    z: Annotated[Row, "v"]
    z_new: Annotated[Row, "v"]
    saved: Annotated[Row, "v"]


@record
class Newton(Record):
    """Memory of `radau`.

    ``derivative``                f'(y) v, a kernel of (y, v)
    ``z``, ``before``, ``saved``  stages of this step, of the one before, of the saved one; ``w`` = T⁻¹ z
    ``length_before``, ``length``, ``saved_length``    lengths of these steps; 0 if there is none before
    ``factored``                  length of the step of the factors, or 0
    ``fresh``, ``good``           1 if J is that of the start; 1 if it serves for the next step, too
    ``turns``                     turns of the iteration of the last step
    ``J``                         ∂f/∂y by columns; ``real``, ``re``, ``im``: factors of γ/h - J and of (α + iβ)/h - J
    """

    derivative: Kernel
    c: Row
    length_before: Real
    length: Real
    saved_length: Real
    factored: Real
    fresh: Whole
    good: Whole
    turns: Whole
    z: Annotated[Rows, 3, "width"]
    saved: Annotated[Rows, 3, "width"]
    before: Annotated[Rows, 3, "width"]
    w: Annotated[Rows, 3, "width"]
    f: Annotated[Rows, 3, "width"]
    sides: Annotated[Rows, 3, "width"]
    pair: Annotated[Row, "pair_size"]
    pivots: Annotated[Wholes, "n"]
    complex_pivots: Annotated[Wholes, "n"]
    J: Annotated[Rows, "n", "width"]
    real: Annotated[Rows, "n", "width"]
    re: Annotated[Rows, "n", "width"]
    im: Annotated[Rows, "n", "width"]


@record
class Branch(Record):
    """Constants of f(P(y)), of `crossing`: kernels and constants of f and P, and memory for y and P(y)."""

    rates: Kernel
    projection: Kernel
    n: Count
    projected: Count
    n_quaternions: Count
    quaternions: Annotated[Wholes, "n_quaternions"]
    c: Annotated[Row, "n_constants"]
    state: Annotated[Row, "n"]
    moved: Annotated[Row, "n"]


@record_of_lanes
class Series(Record):
    """Memory of `taylor`.

    ``coefficients``    kernel of the series of the motion; ``bends``: 1 if a function in the rates may bend, which the
                        series does not show
    ``lost``, ``loses`` rounding error of the sum before this step, and in it
    ``coarsest``, ``logarithm``       r, and log₂ r^(1/p)
    ``error``           error of a step that continued past a bend
    """

    coefficients: Kernel
    bends: Count
    c: Row
    width: Count
    coarsest: Real
    logarithm: Real
    error: Real
    lost: Annotated[Row, "width"]
    loses: Annotated[Row, "width"]
    terms: Annotated[Rows, COEFFICIENTS, "width"]
