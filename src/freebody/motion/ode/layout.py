"""What the compiled loop and Python agree on: rows of the work array, and places of what is carried.

Nothing here needs a compiler, so that a run whose code lies on the disk does not load one.
"""

from __future__ import annotations

from functools import cache
from itertools import accumulate

import numpy as np
from numpy.typing import NDArray

from ...native.registers import WIDTH

# rows of the work array, each as long as the padded state; rows 0 to 15 hold the stages (of an implicit method only
# row 0 and row 12, the rates at the start and at the end), and from ROWS on a method has rows of its own
STATE, ARGUMENT, RAW, ERROR5, ERROR3, DENSE, POINT, END, ROWS = 16, 17, 18, 19, 20, 21, 28, 29, 30

# what `advance` reports
RUNNING, FINISHED, TERMINAL, NOT_FINITE, COLLAPSED, DIVERGED, STIFF, UNDEFINED = 0, 1, 2, 3, 4, 5, 6, 11

# places in the array of real numbers that `advance` carries from one call to the next; a STEP of 0 is chosen at the
# start, for a method OF_ORDER
TIME, STEP, OLD_ERROR, UNTIL, MAX_STEP, START, OF_ORDER = 0, 1, 2, 3, 4, 5, 6
REALS = 7
# places in its array of integers: counts, and the component, or event function, that is to blame for a stop
ACCEPTED, REJECTED, EVALUATED, EVENTS, BLAME, AFTER_REJECTION = 0, 1, 2, 3, 4, 5
# steps of the whole run; steps that the region of stability may have limited, and calm ones in a row; steps found
# stiff; whether to stop there; whether all steps have one length; how many event functions must have a value everywhere
TAKEN, SUSPECT, CALM, STIFFNESS, ASKED, FIXED, NAMED = 6, 7, 8, 9, 10, 11, 12
INTEGERS = 13

ORDERS = {"dop853": 8, "dop54": 5, "radau": 5, "gauss": 16, "structure": 6, "taylor": 16, "crossing": 16}

MANY = 10_000
"""Steps that a stiff run would still take, from which on it is worth stopping: an implicit method is then faster."""

# places after the quaternions in what a loop is told of the kernels: projection, number of its outputs, and a second
# program of the method: the place of its constants among those of the rates, and its kernels
PROJECTION, PROJECTED, CONSTANTS, KERNELS = 0, 1, 2, 3

# What `run` is told, a number or the address of an array each: rates, number of quaternions, their places, constants,
# event functions, their constants, and number of steps that the buffers hold, which differ from run to run; numbers of
# components and of event functions, length of a row of the work array; then arrays that last a run (`IN_BLOCK`), of
# which a run begins with zeros in the first `CLEARED`; and the buffers of a piece of it
RATES, QUATERNIONS, WATCHED, ROOM = slice(0, 4), 1, slice(4, 6), 6
NUMBERS = 10
IN_BLOCK = (
    "work", "last", "table", "values", "found", "relative", "absolute", "start", "reals", "integers", "directions",
    "terminal",
)  # fmt: skip
CLEARED = 5
BUFFERS = ("times", "lengths", "states", "event_log", "event_states")

PARTS = 8  # of a step at which event functions are looked at, besides one point close to either end
MARGIN = 0.001  # distance of those two points from the ends, as a part of the step: they show the slope there
FOUND = 4  # numbers that describe an event of a step: part of the step, number, sign, and one for REACH and CULPRIT
# of all event functions: up to which part of the step they have values (beyond 1: all of it), and which does not
REACH, CULPRIT = 3, 7
LOGGED = 3  # numbers that describe an event of the run: time, number, sign


def padded(n: int) -> int:
    """Length of a row that holds ``n`` numbers: the next multiple of `WIDTH`.

    >>> padded(1), padded(8), padded(9)
    (8, 8, 16)
    """
    return -(-max(n, 1) // WIDTH) * WIDTH


def most_events(m: int) -> int:
    """Of ``m`` event functions in one step: between two points each is recorded at most twice, and each point can
    be a zero."""
    return 3 * (PARTS + 2) * m


def rows(method: str, n: int) -> int:
    """Rows of the work array of a method for ``n`` components."""
    return ROWS + {"radau": 4 * n + 24, "gauss": 38, "crossing": 38, "structure": 60, "taylor": 22}.get(
        method, 0
    )


# What `gauss_newton.close` reports: there is a start; else no direction, coordinates that are not met, speeds that
# contradict the conditions
MET, NOWHERE, FAR, TORN = 0, 1, 2, 3
# Its integers: that, the row that is missed most, whether all speeds are sure to move masses, steps at most; then, by
# condition, 1 for those on speeds only and, as a result, for independent ones; by speed, 1 where nothing moves along it
# and where it keeps its value; and the places of quaternions
STATUS, WORST, HEAVY, STEPS, BY_CONDITION = 0, 1, 2, 3, 4
# Its numbers: the residual that will do, what is round-off of a row or column, what is little of a row, the eigenvalue
# of a mass that is none, what is missed and of how much, the time; then (q, u), which become those of the start
SMALL, DEPENDENT, POOR, LIGHT, MISSED, SIZE, MOMENT, COORDINATES = 0, 1, 2, 3, 4, 5, 6, 7


@cache
def block(method: str, n: int, m: int) -> tuple[dict[str, slice], NDArray[np.int64], int]:
    """Of one block of memory for a run: where the arrays of `IN_BLOCK` lie, and ``told``; the distances of those arrays
    from its start in bytes; and its size in numbers."""
    sizes = (
        rows(method, n) * padded(n), m, (PARTS + 3) * (m + 1), m, most_events(m) * FOUND, n, n, n, REALS, INTEGERS,
        m, m, NUMBERS + len(IN_BLOCK) + len(BUFFERS),
    )  # fmt: skip
    ends = list(accumulate(sizes))
    begins = [end - size for size, end in zip(sizes, ends, strict=True)]
    places = dict(zip((*IN_BLOCK, "told"), map(slice, begins, ends), strict=True))
    distances = 8 * np.array(begins[:-1], dtype=np.int64)
    distances.setflags(write=False)
    return places, distances, ends[-1]


def closing(n_q: int, n: int, m: int) -> int:
    """Numbers in the memory of `gauss_newton.close`, for n_q coordinates, n speeds and m conditions."""
    return 2 * m * (1 + n) + 3 * n * n + 7 * n + n_q
