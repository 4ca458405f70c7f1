"""What the loop over lanes and Python agree on: places of addresses, counts and numbers."""

from __future__ import annotations

# addresses of kernels: constants of the parameters, and functions of (t, y)
PROLOGUE, RATES, ENERGY, OUTPUTS, REDUCED, WATCHED, DROPPED = 0, 1, 2, 3, 4, 5, 6
# and for eight lanes: rates, or the series of the motion, and what moves states onto the constraints, or 0; beside a
# series, the rates, or 0 where nothing in them may bend; and where limits alone are watched, these
WIDE, PROJECTION_WIDE, RATES_WIDE, WATCHED_WIDE = 7, 8, 9, 10

# counts: of components, of numbers in a row of the work array and in all of it, of quaternions, parameters, constants,
# events asked for, events watched (rates of extremes are the rest), outputs at a time, times, quantities with extremes,
# steps between two looks at the outputs, steps at most, whether the work is the last component, whether a stiff lane
# stops, residuals of the conditions that were redundant at the start, steps after which tolerances are tightened, or 0
N, WIDTH_OF_ROW, N_WORK, N_QUATERNIONS, N_PARAMETERS, N_CONSTANTS, N_EVENTS, N_WATCHED = (
    0,
    1,
    2,
    3,
    4,
    5,
    6,
    7,
)
N_OUTPUTS, N_TIMES, N_REDUCED, ROOM, LIMIT, WORKS, STIFF_ASKED, N_DROPPED = 8, 9, 10, 11, 12, 13, 14, 15
BUDGET = 16
# number of intervals in which signals are polynomials (1 without signals), and of parameters that differ between them
N_LEGS, N_SETTINGS = 17, 18
# how many of the events asked for, the last ones, are limits of one-sided forces, which a run may begin beyond
N_LIMITS = 19
# of eight lanes, where nothing but limits is watched: the place of their values at the ends of the steps, and of their
# changes in the steps before; else 0
SEEN = 20
SIZES = 21

# numbers of an interval, in a row before its settings: start, end, length of all steps or 0
LEG = 3

# numbers: start and end of the run, longest step, order of the method, relative tolerance below which none is tightened
T0, T1, LONGEST, ORDER, FINEST = 0, 1, 2, 3, 4
OPTIONS = 5

EXTREMES = 4  # numbers kept of a quantity: greatest, smallest, first, last
KEPT = 4  # integers kept of a lane: how it ended, steps, rejected steps, component to blame

# how a lane ends, besides what `layout` names
TOO_MANY, LEFT, STUCK = 7, 8, 14
# finished, and stopped by a terminal event, beyond the limit of a one-sided force
UNPHYSICAL, STOPPED_UNPHYSICAL = 12, 13

# of eight lanes, integers, eight of each: number of the run (-1: none), steps of this leg, rejected steps, suspicions,
# calm steps, whether the step before was rejected, outputs given, whether the step reaches the end, leg, steps of the
# legs before; and the component to blame
RUN, TAKEN, REJECTED, SUSPECT, CALM, AFTER, DONE, ENDS, AT, BEFORE = range(0, 80, 8)
BLAMED = 80
WIDE_COUNTS = 88
# and numbers: error of the step before, longest step of this leg and of those before, start and end of the leg, energy
# at the start of the run, change by a projection that is allowed, the output time that comes next
OLDS, STRIDE, NATURAL, FIRST, LAST_TIME, SIZE, ALLOWED, NEXT = range(0, 64, 8)
WIDE_NUMBERS = 64
# places of eight numbers each after its rows: steps, times and moments of the lanes; errors of the steps; whether
# stability may limit them; which lanes took theirs, or are still projected; changes by that; of `taylor` the lengths
# that the series give, log₂ r / p, and parts of the steps; ends of the steps; whether nothing is to be looked at in a
# step but its error
STEPS, TIMES, MOMENTS, ERRORS, LIMITED, WANTED, CHANGES, LENGTHS, LOGARITHMS, SPANS, AFTERS, EASY = range(
    0, 96, 8
)
WIDE_PLACES = 96
