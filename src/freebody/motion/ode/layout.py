"""Layout of the memory that the compiled loop and Python share: rows of the work array, and indices of carried numbers.

Nothing in this file needs a compiler. A run with compiled code on the disk does not load one.
"""

from __future__ import annotations

from functools import cache
from itertools import accumulate

import numpy as np
from numpy.typing import NDArray

from ...native.records import WIDTH

# Rows of the work array, each as long as the padded state. Rows 0 to 15 hold the stages (for an implicit method only
# row 0 and row 12: the rates at the start and at the end). The rows of a method itself begin at ROWS.
STATE, ARGUMENT, RAW, ERROR5, ERROR3, DENSE, POINT, END, ROWS = 16, 17, 18, 19, 20, 21, 28, 29, 30

# Status codes that `advance` returns.
RUNNING, FINISHED, TERMINAL, NOT_FINITE, COLLAPSED, DIVERGED, STIFF, UNDEFINED = 0, 1, 2, 3, 4, 5, 6, 11

# Indices of the real numbers that `advance` carries from call to call. If STEP is 0, the first step is chosen at the
# start, for a method of order METHOD_ORDER.
TIME, STEP, OLD_ERROR, UNTIL, MAX_STEP, START, METHOD_ORDER = 0, 1, 2, 3, 4, 5, 6
REALS = 7
# Indices of the integers that `advance` carries: counts, and the component or event function to blame for a failure.
ACCEPTED, REJECTED, EVALUATED, EVENTS, BLAME, AFTER_REJECTION = 0, 1, 2, 3, 4, 5
# Further integers: steps of the whole run; number of steps that the region of stability may have limited; number of
# consecutive steps that it did not limit; steps found stiff; for `sample`, 1 + the step whose states it computed last;
# 1 to stop at a stiff step; 1 for equal steps; number of event functions that must have a value everywhere.
TAKEN, SUSPECT, CALM, STIFFNESS, SAMPLED, STOP_IF_STIFF, FIXED, REQUIRED = 6, 7, 8, 9, 10, 11, 12, 13
INTEGERS = 14

ORDERS = {"dop853": 8, "dop54": 5, "radau": 5, "gauss": 16, "structure": 6, "taylor": 16, "crossing": 16}

SINGLE_STEPS = ("crossing",)
"""Methods whose states between the ends of a step come from the step as a whole."""

MANY_COMPONENTS = 100
"""Size of a state from which a few steps cost more than a look at them."""

MANY = 10_000
"""Number of remaining steps from which a stiff run is stopped: an implicit method is then faster."""

# Indices after the quaternions in `Rates.corrections`: the projection, the number of its outputs, the offset of the
# constants of the method's own kernels, and the addresses of these kernels.
PROJECTION, PROJECTED, CONSTANTS, KERNELS = 0, 1, 2, 3

# Arguments of `run`, each a number or the address of an array. Different in each run: rates, number of quaternions,
# their indices, constants, event functions, their constants, and the number of steps that the buffers hold. Then the
# numbers of components and of event functions, and the length of a row of the work array; the arrays of a run
# (`RUN_ARRAYS`), of which the first `CLEARED_ARRAYS` are set to zero at the start; and the buffers of a piece of it.
RATES, QUATERNIONS, WATCHED, ROOM = slice(0, 4), 1, slice(4, 6), 6
NUMBERS = 10
RUN_ARRAYS = (
    "work", "last", "table", "values", "zeros", "relative", "absolute", "start", "reals", "integers", "directions",
    "terminal",
)  # fmt: skip
CLEARED_ARRAYS = 5
BUFFERS = ("times", "lengths", "states", "event_log", "event_states")

# Event functions are evaluated between PARTS parts of a step, and at one more point close to either end. MARGIN is the
# distance of these two points from the ends, as a fraction of the step: they show the slope there.
PARTS, MARGIN = 8, 0.001
# Numbers per event of a step: fraction of the step, number, sign, and one that REACH or CULPRIT uses.
EVENT_SIZE = 4
# Indices for all event functions together: the fraction of the step up to which they have values (above 1: all of it),
# and the function without a value.
REACH, CULPRIT = 3, 7
LOG_SIZE = 3  # numbers per event of the run: time, number, sign


def padded(n: int) -> int:
    """Length of a row that holds ``n`` numbers: the next multiple of `WIDTH`.

    >>> padded(1), padded(8), padded(9)
    (8, 8, 16)
    """
    return -(-max(n, 1) // WIDTH) * WIDTH


def most_events(m: int) -> int:
    """Maximum number of events of ``m`` event functions in one step. Between two points each function gives at most
    two, and each point can be a zero.
    """
    return 3 * (PARTS + 2) * m


def rows(method: str, n: int) -> int:
    """Number of rows of the work array of a method for ``n`` components."""
    return ROWS + {"radau": 4 * n + 24, "gauss": 38, "crossing": 38, "structure": 60, "taylor": 22}.get(
        method, 0
    )


# Status codes of `gauss_newton.close`: a start was found; no direction to search in; the coordinates do not converge;
# the speeds contradict the conditions; the factors need more room.
MET, NOWHERE, FAR, TORN, CROWDED = 0, 1, 2, 3, 4
# Its arguments: addresses of kernels; numbers of coordinates, speeds, conditions, quaternions and entries of G;
# addresses of its integers and numbers, of the pattern of G (`sparse_rows.factorize`), of memory, of the factors, and
# of the constants of the kernels.
CONDITIONS, MOTION, MOVED, LEAST = 0, 1, 2, 3
N_COORDINATES, N_SPEEDS, N_CONDITIONS, N_QUATERNIONS, N_ENTRIES = 4, 5, 6, 7, 8
INTEGERS_AT, NUMBERS_AT, PATTERN, ROOM_AT, FACTORS, FACTORS_REAL, OF_PARAMETERS = 9, 10, 11, 12, 13, 14, 15
# Its integers: status; row with the largest residual; 1 if all speeds certainly move masses; maximum number of steps.
# Then for each condition: 1 if it restricts speeds only, and, as a result, 1 if it is independent. For each speed: 1 if
# no coordinate may move along it, and 1 if it keeps its value. Then the indices of the quaternions, and the conditions
# and speeds that take part in the present factors.
STATUS, WORST, HEAVY, STEPS, BY_CONDITION = 0, 1, 2, 3, 4
# Its numbers: acceptable residual; tolerance for dependent rows and columns; part of a row that is small; part of a
# mass below which it may be zero; largest residual and its scale; time. Then (q, u), replaced by the start, and the
# selection of the kernel LEAST.
SMALL, DEPENDENT, POOR, LIGHT, MISSED, SIZE, MOMENT, COORDINATES = 0, 1, 2, 3, 4, 5, 6, 7


@cache
def block(method: str, n: int, m: int) -> tuple[dict[str, slice], NDArray[np.int64], int]:
    """Layout of the block of memory of a run.

    Return the slices of the arrays of `RUN_ARRAYS` and of ``arguments``; the offsets of those arrays from the start of
    the block in bytes; and the size of the block in numbers.
    """
    sizes = (
        rows(method, n) * padded(n), m, (PARTS + 3) * (m + 1), m, most_events(m) * EVENT_SIZE, n, n, n, REALS, INTEGERS,
        m, m, NUMBERS + len(RUN_ARRAYS) + len(BUFFERS),
    )  # fmt: skip
    ends = list(accumulate(sizes))
    begins = [end - size for size, end in zip(sizes, ends, strict=True)]
    places = dict(zip((*RUN_ARRAYS, "arguments"), map(slice, begins, ends), strict=True))
    distances = 8 * np.array(begins[:-1], dtype=np.int64)
    distances.setflags(write=False)
    return places, distances, ends[-1]


def closing(n_q: int, n: int, m: int, entries: int) -> int:
    """Size of the memory of `gauss_newton.close`, for n_q coordinates, n speeds, m conditions and entries of G."""
    return m + entries + 4 * n + n_q
