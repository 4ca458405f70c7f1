"""The contact problem, one value for the solvers of this room: rates r and impulses x of rows in Coulomb's cones.

    r = b + W v,    v = Σ_a X_a x_a

    equality    r = 0
    normal      min(r, x - low) = 0
    tangent     x_T = P(x_T - r_T),    P: the nearest point of |T| <= μ x_N

r are speeds and x impulses, or accelerations and forces. The tangent rows of a contact follow its normal row, friction
first, then those of resistance to rolling and spinning, whose limit is a length times the same x_N. A row is
stored over whole blocks of the speeds v, so that a problem of n bodies has of the order of n numbers; a dense problem
has one block.

`cone` has the projection P and the residual; `sweeps` and `newton` solve the problem. This file needs no compiler.
"""

from __future__ import annotations

from typing import Annotated

from ...native.records import Count, Real, Record, Row, Rows, Whole, Wholes, record

EQUALITY, NORMAL, LINE, FIRST, SECOND = range(5)
"""Kinds of rows: LINE is the only tangent of the normal row before it, FIRST and SECOND are two tangents of it."""


GOAL = 1e-15
"""Relative residual at which the search ends; without progress it also ends at `newton.ENOUGH`."""
DEPENDENT = 1e-13
"""Part of a row's diagonal below which the row depends on the others."""


@record
class Blocks(Record):
    """Rows over blocks of speeds.

    ``starts``    first speed of each block, then their number; ``squares``: first entry of each block of a matrix
    ``pieces``    blocks of the rows; those of row r begin at ``first[r]``, its values at ``at[r]``
    """

    n: Whole
    count: Whole
    starts: Wholes
    squares: Wholes
    pieces: Wholes
    first: Wholes
    at: Wholes


@record
class ContactProblem(Record):
    """A contact problem of ``count`` rows.

    ``rows``      row of W and X that each row of the problem is
    ``between``   rows between a tangent and the normal row that bounds it: 0 for friction, more for rolling resistance
    ``scale``     rate per unit impulse, by which both are compared: A_NN; of two tangents a bound on those of A_TT
    ``reference`` rate to which the residual is relative
    ``matrix``    A_aa, then A_ab for the rows b of the same contact behind a, with A = W Xᵀ
    ``v``         Σ X x;  ``r``: rates;  ``e``: violations of the laws, as rates
    ``residual``  greatest violation of a law in the last result, relative to the reference
    ``stop``      not 0 ends sweeps and Newton's method without a result; another thread writes it
    """

    blocks: Blocks
    count: Whole
    reference: Real
    residual: Real
    stop: Whole
    W: Row
    X: Row
    rows: Annotated[Wholes, "most"]
    kinds: Annotated[Wholes, "most"]
    between: Annotated[Wholes, "most"]
    mu: Annotated[Row, "most"]
    low: Annotated[Row, "most"]
    scale: Annotated[Row, "most"]
    b: Annotated[Row, "most"]
    x: Annotated[Row, "most"]
    r: Annotated[Row, "most"]
    e: Annotated[Row, "most"]
    matrix: Annotated[Rows, "most", 3]
    v: Annotated[Row, "n"]


PAIRS = 12
"""Number of stored differences of sweeps."""


@record
class Sweeping(Record):
    """Memory of `sweeps`.

    ``speeds``, ``impulses``    of one contact: its rates without its own impulses, and its new impulses
    ``before``                  x before a sweep
    ``f``, ``f_old``, ``g_old``    change of x by a sweep, that by the sweep before, and x after that
    ``df``, ``dg``, ``norms``    last differences of f and of g, and |Δf|²
    ``pairs``                   number of the differences found for this A; other b have the same ones
    ``ended``                   1 if the last sweeps ended with a result
    """

    pairs: Whole
    ended: Whole
    speeds: Annotated[Row, 3]
    impulses: Annotated[Row, 3]
    before: Annotated[Row, "most"]
    f: Annotated[Row, "most"]
    f_old: Annotated[Row, "most"]
    g_old: Annotated[Row, "most"]
    df: Annotated[Rows, PAIRS, "most"]
    dg: Annotated[Rows, PAIRS, "most"]
    norms: Annotated[Row, PAIRS]


@record
class Trial(Record):
    """A try of `newton`: y - r/ε, λ at it, and F(v)."""

    free: Annotated[Row, "most"]
    x: Annotated[Row, "most"]
    F: Annotated[Row, "n"]


@record
class Path(Record):
    """Memory of `interior`.

    ``x``, ``z``, ``dx``, ``dz``    forces and rates inside their cones, and their changes in a step
    ``miss``, ``q``, ``scaling``    ρ and q; η⁻² and the tangential part of the scaling of each contact
    ``bends``, ``short``            1 with the slope of |z_T|, else 0; number of short steps in a row
    """

    x: Annotated[Row, "most"]
    z: Annotated[Row, "most"]
    dx: Annotated[Row, "most"]
    dz: Annotated[Row, "most"]
    miss: Annotated[Row, "most"]
    q: Annotated[Row, "most"]
    scaling: Annotated[Row, "most"]
    bends: Real
    short: Whole


@record
class Links(Record):
    """Blocks that are linked in a matrix of blocks (`elimination.link`).

    ``blocks``    a row of as many numbers as there are blocks for each of them: later blocks, in ascending order
    ``later``     number of these
    """

    blocks: Annotated[Wholes, "links"]
    later: Annotated[Wholes, "n"]


@record
class Newton(Record):
    """Memory of `newton`.

    ``residual``, ``softest``    least residual so far; limit of the compliance
    ``y``, ``v``                 multipliers, and the solution of F(v) = 0
    ``best``, ``past``, ``moved``    λ of the least residual; λ of the round before; change in a round
    ``here``, ``there``          at v, and at a trial of the line search
    ``path``                     of the interior point method
    ``G``, ``J``, ``step``       -∂λ/∂r H, stored as the rows of H; F' or its factors; the step
    ``kept``, ``factored``       compliance of the factors, 0 without any; number of factorizations
    ``links``, ``order``         links of the blocks of F', and its row exchanges (`elimination.factored`)
    """

    residual: Real
    softest: Real
    y: Annotated[Row, "most"]
    best: Annotated[Row, "most"]
    past: Annotated[Row, "most"]
    moved: Annotated[Row, "most"]
    v: Annotated[Row, "n"]
    tried: Annotated[Row, "n"]
    step: Annotated[Row, "n"]
    here: Trial
    there: Trial
    path: Path
    G: Annotated[Rows, "most", "n"]
    J: Annotated[Rows, "n", "n"]
    kept: Real
    factored: Whole
    links: Links
    order: Annotated[Wholes, "n"]


@record
class Dense(Record):
    """Memory of `dual`.

    ``most``             limit on the rows of a problem
    ``U``                factor of W Xᵀ of the rows that are held, Uᵀ U
    ``entries``, ``w``   numbers for one row: beside those that are held; of its speeds;  ``beside``: 1 for its blocks
    ``held``             number of the rows that are held
    ``place``, ``among``      place of a row among those that are held, or -1; row at a place
    """

    most: Count
    held: Whole
    U: Annotated[Row, "squares"]
    entries: Annotated[Row, "most"]
    w: Annotated[Row, "n"]
    beside: Annotated[Wholes, "n"]
    place: Annotated[Wholes, "most"]
    among: Annotated[Wholes, "most"]
