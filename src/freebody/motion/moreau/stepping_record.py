"""Memory of a run in time steps, shared by Python and the compiled loop (`moreau`). It needs no compiler."""

from __future__ import annotations

from typing import Annotated

from ...native.records import Count, Kernel, Real, Record, Row, Rows, Whole, Wholes, record
from ..cones.contact_problem import Blocks, ContactProblem, Sweeping
from ..families.family_record import Families

NONE, CONTACTS, MASS, CONSTRAINTS, OVERLAP, NOT_FINITE, LOADS, FULL, JAMMED, NO_FRICTION, SLIPS = range(11)
"""Reasons why a step fails; FULL: more pairs of families are closed than there is room for; JAMMED:
no load of a joint agrees with the friction that it bounds; NO_FRICTION: a coefficient below 0 or without a value;
SLIPS: no coefficients agree with the slips."""
OPEN, STICK, SLIP, FORWARDS, BACKWARDS = range(5)
"""Modes of a contact in a step; the last two are the slips in a plane."""
CLOSED_GAP = 1e-10
"""Gap up to which a contact is closed [m]."""
OPENS, BEGINS, LANDED, STAYED = range(4)
"""How long a contact has stayed closed: it may open, begins closed, pressed in the last step, or before that, too."""


@record
class Machine(Record):
    """Kernels of a machine with the constants ``c``, and its state: ``n_q`` coordinates, then ``n`` speeds.

    ``system``    M by blocks, f (n), gaps, reaches, rates of contacts, normal forces that the state gives, and of
                  compliant contacts their generalized forces (n) and power, rates of constraints, φ, then W over G
                  by rows
    ``closing``   gaps, reaches, φ
    ``moving``    q' (n_q), power of the loads
    ``loading``   f (n), which depends on the speeds if ``turning`` is 1
    ``looped``    1 for many bodies (`Kernels.looped`): ``loading``, with the constants ``of_loading``, gives ``bias``,
                  -f by the model's speeds, M follows from the poses of the links,
                  ``system`` and ``closing`` give nothing
    ``order``     model speed at each place in block order
    ``quaternions``    components at which unit quaternions begin; ``turned``: 1 for each component of one
    ``flights``        number of free joints. Of each, ``attitude``: where its quaternion begins in q; ``spin``: where
                       its ω begins among the speeds in block order, before v; ``block``: its block; ``center``: mass
                       centre of its link
    """

    c: Row
    of_loading: Row
    looped: Count
    system: Kernel
    closing: Kernel
    moving: Kernel
    loading: Kernel
    turning: Count
    n_q: Count
    n: Count
    order: Wholes
    bias: Annotated[Row, "n"]
    n_quaternions: Count
    quaternions: Wholes
    turned: Annotated[Wholes, "n_q"]
    flights: Count
    attitude: Annotated[Wholes, "flights"]
    spin: Annotated[Wholes, "flights"]
    block: Annotated[Wholes, "flights"]
    center: Annotated[Rows, "flights", 3]


@record
class Gaps(Record):
    """Gaps of the contacts, reaches (negative: the foot is beyond the end of its side), and conditions φ."""

    outputs: Row
    gap: Row
    reach: Row
    phi: Row


@record
class Contacts(Record):
    """Contacts of a machine, and where they are closed.

    ``tangents``, ``mu``, ``restitution``    of each contact; ``rows``: number of all rows; ``closed``: those of the
                      problem, before the rows of pairs of families
    ``held``          1 if the state gives the normal force and its row is zero: friction of a joint, compliant contacts
    ``adhesion``      pull that each contact bears, and ``pull``, that of the step (`adhere`)
    ``kept``          how long a contact has stayed closed (`curvature`): `OPENS`, or `BEGINS`, `LANDED`, `STAYED`. Its
                      gap is corrected to 0 from both sides; negative: it hangs, and stays open until the next step
    ``stuck``         how long it has stuck, too;  ``last``: v₋ and T₋ of each row
    ``presser``       contact whose normal force bounds what resists its rolling or spinning, -1 for contacts themselves
    ``normal_row``    normal row of each contact in the problem, or -1
    ``reach_of``      contact of each reach; ``seen``: reach and gap at the last place, and ``behind``: 1 if the foot
                      has come around this end behind its side
    ``owner``         contact of each row of the problem; ``rebound``: its restitution in this step
    ``before``        rate of each row of the problem at the beginning of the step
    ``stays``, ``half``, ``turn``    ``kept`` or ``stuck``, T and a of each row
    ``guess``         impulses of all rows in the last step
    """

    count: Count
    rows: Count
    closed: Whole
    reaches: Count
    tangents: Wholes
    mu: Row
    restitution: Row
    held: Wholes
    adhesion: Row
    pull: Row
    kept: Wholes
    stuck: Wholes
    last: Rows
    presser: Wholes
    normal_row: Wholes
    reach_of: Wholes
    seen: Rows
    behind: Wholes
    owner: Annotated[Wholes, "most"]
    rebound: Annotated[Row, "most"]
    before: Annotated[Row, "most"]
    stays: Annotated[Wholes, "most"]
    half: Annotated[Row, "most"]
    turn: Annotated[Row, "most"]
    guess: Annotated[Row, "rows"]


@record
class Elimination(Record):
    """Factors of the inertia and of the constraints (`elimination`).

    ``contact_rows``    rows of W, before those of G
    ``L``     L Lᵀ = M by blocks, ``band``: of each;  ``K`` = M⁻¹ Gᵀ by rows;  ``S``: factor of ``GK`` = G K
    ``sigma``           change of -λ per impulse of each row of the problem
    ``rates``, ``share``    numbers of the constraints
    ``spins``           1 for a block whose loads by its turning are in its equations;  ``D``, ``C``: of these (`spin`)
    """

    blocks: Blocks
    contact_rows: Count
    L: Annotated[Row, "squares"]
    band: Annotated[Wholes, "blocks"]
    K: Annotated[Rows, "constraints", "n"]
    S: Annotated[Row, "conditions"]
    GK: Annotated[Row, "conditions"]
    sigma: Annotated[Rows, "most", "constraints"]
    rates: Annotated[Row, "constraints"]
    share: Annotated[Row, "constraints"]
    spins: Annotated[Wholes, "blocks"]
    D: Annotated[Rows, "blocks", 9]
    C: Annotated[Rows, "blocks", 18]


@record
class Loads(Record):
    """Impulse p of the loads in a step, and its residual e = h f(ū) - p.

    ``rest``             p - h f(u), from which the next step begins
    ``Me``               M⁻¹ e;  ``e_old``, ``Me_old``: before the last change of p
    ``changes``          number of changes of p by e
    ``motion``           size of the motion, to which e is compared;  ``first_error``: |e|/√motion at the first p
    """

    p: Annotated[Row, "n"]
    rest: Annotated[Row, "n"]
    f: Annotated[Row, "n"]
    e: Annotated[Row, "n"]
    Me: Annotated[Row, "n"]
    e_old: Annotated[Row, "n"]
    Me_old: Annotated[Row, "n"]
    motion: Real
    first_error: Real
    changes: Whole


@record
class Bearings(Record):
    """Joints whose load bounds their friction (`bearings`).

    ``count``, ``loaded``    their number, and their contacts
    ``forces``               kernel of their levers and forces, with the constants ``c``, of ``motion``: the state, then
                             (u⁺ - u)/h, Λ/h and λ/h of all conditions
    ``number``               of each constraint of the steps among all conditions
    ``outputs``              of ``forces``
    """

    count: Count
    forces: Kernel
    c: Row
    loaded: Annotated[Wholes, "joints"]
    number: Annotated[Wholes, "constraints"]
    motion: Annotated[Row, "moving"]
    outputs: Annotated[Row, "of_bearings"]


@record
class Friction(Record):
    """Laws of friction that are greater at rest, or vary (`friction`).

    ``varies``       their number
    ``of_contacts``, ``of_families``    kernel of the coefficients (of slip, at rest) of each, with the constants ``c``,
                     of (q, u, slip speed); 0 for a single number
    ``given``, ``found``        arguments and result of a kernel
    ``passes``, ``mu``, ``miss``    for the normal row of each contact: passes in this step, -1 in an impact;
                     coefficient of the last one, and by how much its law missed that
    ``turns``        passes of all in this step, -1 before the first
    ``failure``, ``blame``      why there are none at its start, or NONE; row that this is of, or that missed most
    ``residual``     what is left of all misses, as a rate relative to the reference
    """

    varies: Count
    of_contacts: Wholes
    of_families: Wholes
    c: Row
    given: Row
    found: Annotated[Row, 2]
    passes: Annotated[Wholes, "most"]
    mu: Annotated[Row, "most"]
    miss: Annotated[Row, "most"]
    turns: Whole
    failure: Whole
    blame: Whole
    residual: Real


@record
class Expansion(Record):
    """Memory of `expansion`.

    ``poisson``    1 if restitution is by Poisson's law;  ``chosen``: 1 if the contacts that expand are known
    ``x``, ``b``, ``low``    impulses of the compression, and its problem;  ``back``: e Λ_C
    """

    poisson: Count
    chosen: Whole
    x: Annotated[Row, "most"]
    b: Annotated[Row, "most"]
    low: Annotated[Row, "most"]
    back: Annotated[Row, "most"]


@record
class Displaced(Record):
    """Contacts that press in a displacement, by ascending numbers (`correction.number`), and their ``impulses`` in all
    displacements of a correction together.
    """

    count: Whole
    numbers: Annotated[Wholes, "most"]
    impulses: Annotated[Row, "most"]


@record
class Run(Record):
    """A run in steps of length h from the state y; ``past``: lengths of the last step and of the one before.

    ``times``              time at the start of each step
    ``steps``, ``done``    steps to do, and done;  ``failure``: why the next one fails, or NONE
    ``tolerance``, ``most_sweeps``    of the contact problem of a step;  ``accepted``, ``most_accepted``: limits of
                           ``enough``, the residual with which it is taken where its search would be long
    ``states``, ``impulses``, ``works``, ``moved``, ``modes``    a row for each step: state at its end; impulses of
                           contacts and constraints; work of contacts and blows, of loads and constraints; change of the
                           state by the correction at its end; mode of each contact
    ``log``, ``logged``    an entry for each pair of families that presses; their number, and the room;
                           ``log_end``: their number after each step; ``resisted``: 1 if they tell of resistance
                           to rolling and spinning, too
    ``blow``               generalized impulse J of blows in the next step
    ``residual``, ``sweeps``, ``depth``    greatest residual, number of sweeps, greatest depth at the end of a step
    ``reduced``            number of steps whose restitution was reduced, since it would have made energy
    ``overlap``            what a failed correction leaves
    ``displaced``          contacts that press in the last displacement, with which the next one begins;  ``first``: in
                           the first one of the last correction
    ``expected``           depths up to which a correction first looks for pairs, in its first, second and later turns
    ``borne``              impulses of the rows of a displacement in those before it;  ``factored``: 1 if the dual
                           method has a factor of these rows
    ``u``, ``free``, ``u_new``, ``u_mean``    speeds; their change without contact impulses; new and mean speeds
    ``z``                  a state inside or at the end of the step;  ``rate``, ``first_rate``: q' and power
    ``lam``                impulses of the constraints
    ``outputs``            of the kernel ``system``: M, f, ``now`` (gaps, φ), ``rates``, ``given`` (normal forces of the
                           state), ``pressed`` (their generalized forces, of compliant contacts), ``pressing`` (the
                           power of these), ``constraint_rates``, W
    """

    h: Real
    times: Row
    past: Annotated[Row, 2]
    tolerance: Real
    accepted: Real
    most_accepted: Real
    enough: Real
    most_sweeps: Whole
    steps: Whole
    done: Whole
    failure: Whole
    residual: Real
    sweeps: Whole
    reduced: Whole
    depth: Real
    overlap: Real
    constraints: Count
    holonomic: Count
    machine: Machine
    families: Families
    contacts: Contacts
    elimination: Elimination
    displaced: Displaced
    first: Displaced
    borne: Annotated[Row, "most"]
    factored: Whole
    expected: Annotated[Row, 3]
    problem: ContactProblem
    sweeping: Sweeping
    loads: Loads
    bearings: Bearings
    friction: Friction
    expansion: Expansion
    y: Row
    states: Rows
    log: Rows
    log_room: Whole
    resisted: Count
    logged: Whole
    log_end: Wholes
    impulses: Rows
    works: Rows
    moved: Rows
    modes: Wholes
    blow: Annotated[Row, "n"]
    u: Annotated[Row, "n"]
    free: Annotated[Row, "n"]
    u_new: Annotated[Row, "n"]
    u_mean: Annotated[Row, "n"]
    momentum: Annotated[Row, "n"]
    z: Annotated[Row, "state"]
    rate: Annotated[Row, "q_and_power"]
    first_rate: Annotated[Row, "q_and_power"]
    lam: Annotated[Row, "constraints"]
    outputs: Row
    M: Row
    f: Row
    now: Gaps
    rates: Row
    given: Row
    pressed: Row
    pressing: Row
    constraint_rates: Row
    W: Row
    end: Gaps
