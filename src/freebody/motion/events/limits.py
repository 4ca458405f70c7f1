"""Limits of sizes, times and numbers in a run from event to event."""

from __future__ import annotations

from ..phase.laws import STOPPED

STILL = 1e-10
"""Speed, relative to 1 m/s or the greatest speed, below which a contact does not approach, slip or leave."""
SMALL = 1e-10
"""Relative size below which a force or rate is zero and a matrix singular: above the round-off of small systems."""
NOISE = 1e-14
"""Round-off of a slip velocity, relative to 1 m/s or the greatest speed."""
LOW = 1e-15
"""Height of a flight, relative to 1 m or the greatest coordinate, that is lost in round-off."""
SUMMED = 1e-13
"""Height of a flight, relative to 1 m or the greatest coordinate, below which bounces are summed."""
NUDGE = 4 * STOPPED
"""Initial speed of a slip in space that begins without acceleration, above the speed at which slips end [m/s]."""
MOMENT = 1e-5
"""Time after which a motion shows whether laws that hold with equality go on, at speeds below 1 m/s or 1 rad/s [s]."""
BRIEFEST = 1e-11
"""Shortest such time [s]: it is half as long after each of several events at one moment."""
CROWD = 1e-7
"""Time between two events below which they count as simultaneous [s]."""
PHASES = 100_000
"""Largest number of phases of one run."""
ENDLESS = 200
"""Number of mode changes at one moment above which they are refused as endless."""
CROWDED = 16
"""Number of events at one moment after which slow slips in space are decided together."""
LONGEST = 1e-6
"""Greatest length of a straight step [s]; a slip that would take longer to begin, or longer than a contact needs to
return, is nudged."""
SHORTEST = LONGEST / 10
"""Length of the first step of the speeds alone [s]."""
BRIEF = LONGEST / 100
"""Length of the step of the speeds before slips that creep [s]."""
HELD = 1000 * LONGEST
"""Greatest length of a phase in which contacts are at rest by forces that are open at their limits [s]."""
CLOSE = 1e-3
"""Part of a cone that open forces need to be within it for it to be watched; else they would soon be at it again."""
SLOW = 10 * STOPPED
"""Slip speed in space below which a body comes to rest at all its contacts at once, where events crowd [m/s]."""
RAY = 7
"""Greatest number of rows behind a normal row whose forces its own bounds: two of friction, and those of resistance to
rolling and spinning."""
BOUNCES = 40
"""Number of impacts that are remembered, in search of cycles."""
PERIOD = 6
"""Greatest number of impacts of a cycle."""
PASSES = 100_000
"""Largest number of sequential impacts at one moment."""
NO_PAUSE = 1 << 60
"""A budget that does not end."""
PIECE = 16
"""Number of steps between two looks at the memory, at a wish to stop, and at what makes steps implicit. A step of
solids that lie on each other takes milliseconds, with all its events; with 256 the bits and times were the same."""
STALL, STALL_TIME = 20_000, 1e-4
"""Number of steps within a time [s] at which a run does not move on: rates of 1e9 1/s, which no rigid body has. A state
is held there between motions that lead back to it, such as the tilts of a disk that lies flat on its edge."""
CREEPS = 1_000
"""Number of such steps after which a slip that fades is decided by speeds."""
GROWN = 100.0
"""Factor by which a force grows before a jam: N is proportional to the time left, or to its root, to the power -1, and
steps collapse at round-off of that time."""
