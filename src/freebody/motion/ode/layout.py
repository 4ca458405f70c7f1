"""Codes and limits that the compiled loop and Python share; layout of the memory of `gauss_newton.close`.

Nothing in this file needs a compiler. A run with compiled code on the disk does not load one.
"""

from __future__ import annotations

from ..ending import End

# Status codes that `advance` returns: the numbers of `End`.
RUNNING, FINISHED, TERMINAL, NOT_FINITE = (
    int(end) for end in (End.RUNNING, End.FINISHED, End.TERMINAL, End.NOT_FINITE)
)
COLLAPSED, DIVERGED, STIFF, UNDEFINED, UNRESOLVED = (
    int(end) for end in (End.COLLAPSED, End.DIVERGED, End.STIFF, End.UNDEFINED, End.UNRESOLVED)
)

EXPLICIT: dict[str, int] = {"dop853": 8, "dop54": 5, "tsit5": 5}
"""Explicit methods, which need nothing but the rates, and their orders. A new one is a file, and a place in this
list; a user's own method is a value (`tableau.RungeKutta`)."""
ORDERS = {**EXPLICIT, "radau": 5, "gauss": 16, "structure": 6, "taylor": 16, "crossing": 16}
"""All methods and their orders (`step_control.Method`); each is the file of its name."""

SINGLE_STEPS = ("crossing",)
"""Methods whose states between the ends of a step come from the step as a whole."""

MANY_COMPONENTS = 100
"""Size of a state from which a few steps cost more than a look at them."""

MANY = 10_000
"""Number of remaining steps from which a stiff run is stopped: an implicit method is then faster."""

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


def closing(n_q: int, n: int, m: int, entries: int) -> int:
    """Size of the memory of `gauss_newton.close`, for n_q coordinates, n speeds, m conditions and entries of G."""
    return m + entries + 4 * n + n_q
