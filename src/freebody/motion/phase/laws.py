"""Modes of contacts, their directions of slip and the laws of their endings as numbers, and the tolerances of these.

Python and compiled code share them. This file needs no compiler.
"""

from __future__ import annotations

OPEN, STICK, SLIDE_ON, SLIDE_BACK, SLIDE, SMOOTH, LIMIT = range(7)
"""Modes of a contact: open, stick, slip along its only tangent or against it, slip, slip without friction in this run,
and at rest at its limit of friction."""
NO_SLIP, ALONG, PLUS, MINUS, FIXED = range(5)
"""Directions of slip: none or without friction, along the slip velocity, along the tangent, against it, or fixed: a
contact at rest at its limit of friction."""
GAP, NORMAL, CONE, LINE_CONE, STOP, LINE_STOP, REACH, SIDE, NEVER, PRESS, RELEASE, YIELD = range(12)
"""Laws of endings. A compliant contact closes by PRESS and opens by RELEASE; YIELD is the slip of one at its limit of
friction. The place of a reach is its number, of other laws -1."""

ROUNDED = 2.0**-44
"""Round-off of a contact force relative to the sum of its parts: 256 units in the last place.

A sum of n parts, or the solution of n equations by elimination, has an error of n units in the last place of Σ|parts|
(Higham, Accuracy and Stability, 2002, chapters 4 and 10). The value therefore suits machines of up to some hundred
speeds and closed contacts. Contacts with almost dependent rows lose more digits, by the condition number of A, and are
not covered. With this ε, contact ends at N < -ε P and stick ends at |T| > μ N + ε (1 + μ) P, where P is the sum of the
parts of all closed contacts. A load exactly at a limit then causes one decision only: the present law continues at
equality.
"""
STOPPED, RESOLVED = 1e-8, 10.0
"""Slip speed in space below which the slip ends with one straight step [m/s]: the first, or the second times the
tolerance of speeds. Steps pass zero unseen from less: friction turns back within the step, an error of a part of it."""
YIELDED_SQUARE = (4 * STOPPED) ** 2
"""Square of the speed at which a contact that is at its limit of friction slips, since the others do not hold it."""
CLOSED = 1e-10
"""Gap, relative to 1 m or the greatest coordinate, below which a contact is closed."""
NEARBY = 1e-3
"""Gap, relative to 1 m or the greatest coordinate, up to which a decision may ask for the rows of a contact: those that
are closed, or have parted a little beside a dead centre (1e-6)."""
DEPENDENT = 1e-10
"""Part of a row of A above which it counts as independent of others."""
