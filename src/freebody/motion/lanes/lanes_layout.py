"""Layout of the memory that the loop over lanes and Python share: indices of addresses, counts and numbers."""

from __future__ import annotations

from ..ending import End

# Addresses of kernels: constants of the parameters, and functions of (t, y).
PROLOGUE, RATES, ENERGY, OUTPUTS, REDUCED, WATCHED, DROPPED = 0, 1, 2, 3, 4, 5, 6
# For eight lanes: the rates, or the series of the motion; the projection onto the constraints, or 0; the rates if a
# series may bend, else 0; and the limits if nothing else is watched.
WIDE, PROJECTION_WIDE, RATES_WIDE, WATCHED_WIDE = 7, 8, 9, 10

# Counts: components; numbers in a row of the work array, and in all of it; quaternions; parameters; constants; events
# of the user; event functions in all (the others are rates of extremes); outputs at a time; times; quantities with
# extremes; steps between two checks of the output times; maximum number of steps. Flags: 1 if the work is the last
# component; 1 if a stiff lane stops. Then the outputs of the kernel of dropped conditions, and the number of steps
# after which tolerances are tightened, or 0.
N, WIDTH_OF_ROW, N_WORK, N_QUATERNIONS, N_PARAMETERS, N_CONSTANTS, N_EVENTS, N_WATCHED = range(8)
N_OUTPUTS, N_TIMES, N_REDUCED, ROOM, LIMIT, WORKS, STOP_STIFF_LANES, N_DROPPED = range(8, 16)
BUDGET = 16
# Number of intervals in which signals are polynomials (1 without signals), and of parameters that differ between them.
N_LEGS, N_SETTINGS = 17, 18
# Number of the user's events, the last ones, that are limits of one-sided forces. A run may begin beyond these.
N_LIMITS = 19
# For eight lanes, if only limits are watched: the offset of their values at the ends of the steps, and of their changes
# in the steps before; else 0.
LIMIT_VALUES = 20
SIZES = 21

# Numbers of an interval, in a row before its settings: start, end, prescribed length of steps or 0.
LEG = 3

# Numbers: start and end of the run, longest step, order of the method, smallest relative tolerance after tightening.
T0, T1, LONGEST, ORDER, FINEST = 0, 1, 2, 3, 4
OPTIONS = 5

EXTREMES = 4  # numbers stored per quantity: greatest, smallest, first, last
OUTCOME_SIZE = 4  # integers stored per lane: status, steps, rejected steps, component to blame

# Status codes of a lane, besides those in `layout`.
TOO_MANY, CONTRADICTED = int(End.TOO_MANY_STEPS), int(End.CONTRADICTED)

# Integers of eight lanes, eight of each: number of the run (-1: none), steps of this leg, rejected steps, steps
# suspected stiff, calm steps, 1 if the step before was rejected, outputs computed, 1 if the step reaches the end, leg,
# steps of the legs before; then the component to blame.
RUN, TAKEN, REJECTED, SUSPECT, CALM, AFTER_REJECTION, OUTPUTS_DONE, ENDS, LEG_INDEX, EARLIER_STEPS = range(
    0, 80, 8
)
WIDE_BLAME = 80
WIDE_COUNTS = 88
# Numbers of eight lanes: error of the step before, longest step of this leg and of those before, start and end of the
# leg, energy at the start of the run, admissible change by a projection, next output time.
OLD_ERRORS, STRIDE, PREVIOUS_STRIDE, LEG_START, LEG_END, ENERGY_SCALE, ALLOWED, NEXT_OUTPUT = range(0, 64, 8)
WIDE_NUMBERS = 64
# Offsets, after the rows, of eight numbers each: steps, times and moments of the lanes; errors of the steps; 1 if
# stability may limit a step; 1 for lanes that took their steps, or are still projected; changes by the projection; for
# `taylor` the lengths from the series, log₂ r / p, and parts of the steps; ends of the steps; 1 if only the error of a
# step has to be examined.
STEPS, TIMES, MOMENTS, ERRORS, LIMITED, SELECTED, CHANGES, LENGTHS, LOGARITHMS, SPANS, AFTERS, EASY = range(
    0, 96, 8
)
WIDE_PLACES = 96
