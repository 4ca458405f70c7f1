"""Contacts that are at rest or slide, as data of their contact problem."""

from __future__ import annotations

from typing import Annotated

from ...native.records import Count, Real, Record, Row, Whole, Wholes, record
from .contact_problem import ContactProblem, Newton

EXACT = 1e-10
"""Relative residual above which a result is not a solution."""
ACCEPTED = 1e-9
"""Speed by which a contact may violate its laws in an almost degenerate impact or step, such as a pile coming to rest,
relative to the greatest speed in the problem; see the trajectory's residual, or the impact's.

Such a step is sound: its speeds and impulses satisfy M Δu = h f + Wᵀ Λ to round-off, whatever the residual, so
momentum and the ledger do not see it; a contact closes by at most 1e-9 v h in a step, less than the gap that the
correction removes at the end of each (1e-10 m for v h up to 0.1 m), so it cannot add up; and its power, Λ times that
speed, is 1e-9 of the power of the contacts. Of a time step as much is taken as this bound of 1e-10 m allows
(`timestepping.failure.accepted`), up to 1e-8. Newton's method cannot do better there: with forces open in faces and
contacts at the limit of friction, the solution is a double zero, which double precision resolves to the root of its
round-off, 1.5e-8, in the forces, and to about 1e-9 in speeds.
"""


AWAY, PRESSED, FORWARDS, BACKWARDS = range(4)
"""Modes of a combination (`combinations`): open; closed, which is at rest or on a ray that is known; slip that begins,
along the tangent or against it."""


@record
class Contacts(Record):
    """``contacts`` with ``rows`` rates r = A λ + c, after ``equalities`` rows ``equal`` with r = 0.

    ``at``, ``tangents``       first row and number of tangents of each contact
    ``friction``, ``static``   its kinetic and static coefficients
    ``slides``, ``way``        1 if it slides, and along which direction (two numbers)
    ``least``, ``back``        its normal force that acts in any case; in the expansion of an impact
    ``held``                   1 if that is given and moves nothing: friction of a joint, or of a compliant contact
    ``presser``                of what resists rolling or spinning, whose own normal row is zero: the contact before it
                               whose normal force, an unknown, bounds it; else -1
    ``tried``                  modes of two combinations (`combinations`)
    ``given``                  c; speeds just before an impact;  ``compressed``: impulses of its first part
    ``forces``, ``after``      λ and r
    ``problem``                the problem of the unknowns; ``place`` is the row of each in A, ``owner`` its contact,
                               ``unit`` what its rates are multiplied by there, and its forces divided
    ``directions``             number of independent directions of A;  ``most``: limit of the rows
    ``sole``                   1 if A is regular and the solution proven to be the only one
    ``restitution``, ``poisson``, ``still``, ``energy``, ``part``    of an impact (`contact.collision`)
    """

    contacts: Whole
    rows: Whole
    equalities: Whole
    poisson: Whole
    still: Real
    energy: Real
    part: Real
    residual: Real
    directions: Whole
    sole: Whole
    most: Count
    at: Annotated[Wholes, "k"]
    tangents: Annotated[Wholes, "k"]
    slides: Annotated[Wholes, "k"]
    friction: Annotated[Row, "k"]
    static: Annotated[Row, "k"]
    least: Annotated[Row, "k"]
    back: Annotated[Row, "k"]
    held: Annotated[Wholes, "k"]
    presser: Annotated[Wholes, "k"]
    restitution: Annotated[Row, "k"]
    way: Annotated[Row, "k2"]
    tried: Annotated[Wholes, "k2"]
    equal: Annotated[Wholes, "most"]
    A: Annotated[Row, "square"]
    given: Annotated[Row, "most"]
    forces: Annotated[Row, "most"]
    compressed: Annotated[Row, "most"]
    after: Annotated[Row, "most"]
    problem: ContactProblem
    newton: Newton
    place: Annotated[Wholes, "most"]
    owner: Annotated[Wholes, "most"]
    unit: Annotated[Row, "most"]
    starts: Annotated[Wholes, 2]
    pieces: Annotated[Wholes, "ends"]
    first: Annotated[Wholes, "ends"]
    ends: Annotated[Wholes, "ends"]
    H: Annotated[Row, "square"]
    C: Annotated[Row, "square"]
    chosen: Annotated[Row, "square"]
    factors: Annotated[Row, "square"]
    slope: Annotated[Row, "square"]
    normal: Annotated[Row, "square"]
    best: Annotated[Row, "most"]
    left: Annotated[Row, "most"]
    order: Annotated[Wholes, "most"]


def contacts_room(k: int, rows: int) -> Contacts:
    """Return memory for up to ``k`` contacts with up to so many rows."""
    most = max(rows, 1)
    it = Contacts.made(k=k, k2=2 * k, most=most, n=most, square=most * most, ends=most + 1, links=1)
    it.problem.W, it.problem.X = it.H, it.C
    it.presser[:] = -1
    blocks = it.problem.blocks
    blocks.count, blocks.starts, blocks.pieces = 1, it.starts, it.pieces
    blocks.first, blocks.at = it.first, it.ends
    return it
