"""Memory of a run from event to event, shared by Python and the compiled loop (`event_loop`). It needs no compiler."""

from __future__ import annotations

from typing import Annotated, Any

from ...dynamics.bearing_loads import LOADED
from ...native.records import Count, Kernel, Real, Record, Row, Rows, Whole, Wholes, record
from ..ending import End
from .limits import BOUNCES, RAY

ORDERS = ("simultaneous", "sequential")
"""Orders of the impacts at one moment."""
AT_REST, BESIDE = 1, 2
"""Why a phase is held: contacts are at rest by open forces, or a dead centre is passed."""

# Where the loop goes on.
ARRIVE, COLLIDE, CORRECT, DECIDE, SET_UP, LAUNCH, FOLLOW, HALT, HALTED = range(9)

# Why the loop returns to Python. Numbers below are those of `End`.
(
    GROW,  # more contacts are closed than the contact problem has room for
    LONGER,  # the log is full
    PAUSE,  # progress may be shown
    ASK_KERNELS,  # a law holds with equality, and there are no kernels yet to see what follows (`starting_modes`)
    NO_MOTION,  # no set of modes is consistent
    SEVERAL,  # several motions are consistent
    OPEN_IMPULSES,  # indeterminate impulses are refused if friction makes the motion depend on them
    OPEN_FORCES,  # so are indeterminate forces
    UNDECIDED,  # and their shares beyond the limit of friction
    STRUCK,  # an event that may call a blow
    TOO_MANY,  # changes of modes at one moment, or in the run
    MIXED,  # contacts of both laws collide at once
    NO_IMPULSES,
    SEQUENCE,  # sequential impacts do not end
    LOADED_IMPACT,  # contacts collide in sequence, and the load of a joint bounds its friction
    JAMMED,  # the load of a joint grows with the friction that it bounds
    PASSED_OVER,  # a closing was passed over in a step
    NO_VALUE,  # the gap or the friction of a contact is not a number
    TURNED,  # a change of the sense of slip was passed over
    OTHER_PLACES,  # a patch of solids has other features
    STALLED,  # the steps do not move on
    OTHER_METHOD,  # implicit steps are to take the place of explicit ones, or these of those
    NO_STATE,  # the state at an event is not finite
    PARTED,  # a closed contact left a condition that depended on those of the others as its phase began
) = range(100, 124)

TOO_MANY_STEPS = int(End.TOO_MANY_STEPS)

# How the rows of a phase follow each other: by steps of the method, by one straight step, by implicit steps.
STEPS, STRAIGHT, IMPLICIT = range(3)

# Entries of the log.
PHASE, IMPACT, NOTE, RESTING, CROSSING, TOLD, OTHER_VALUES = range(7)
DEAD = 16
"""Added to the shown mode of a contact that the others hold in place."""
HELD_OPEN = 16
"""Added, in a change of modes, to that of a contact at rest by forces that are open, whose limits are not watched."""

UNSEEN = 2
"""Sign of a function of the user that is not known yet."""

# Why a mode began.
(
    NO_REASON, BLOW, GAP_CLOSED, NORMAL_ZERO, END_OF_SIDE, ONTO_SIDE, SLIP_STOPPED, CONE_REACHED, BOUNCES_BELOW,
    BOUNCES_END, CHANGED, OTHER_FEATURES, RESULTANT, TIPS, SWITCHED,
) = range(15)  # fmt: skip

# Kinds of rest: the limit of a series of bounces, slips that crowd.
SERIES, SLOWED = range(2)


@record
class EventRun(Record):
    """A run of a machine with contacts, from event to event.

    ``n_q``, ``n``, ``n_y``       coordinates, speeds, and components of the state (q, u, work, heat)
    ``contacts``, ``rows``        numbers of contacts and of their rows
    ``moving``, ``energy``        1 if something moves with all speeds at zero, and the kernel of the energy
    ``looked``, ``rates_at``      kernels of all contacts: what decides events, and the rates
    ``rates``, ``projection``, ``accelerations``, ``forces``, ``watched``    kernels of the present phase
    ``ready``                     1 if there are such kernels
    ``sequential``, ``refuse``    1 if contacts collide one after another; if indeterminate forces are refused
    ``events``                    functions of the user; the first ``shown`` are asked for, others call blows
    ``followed``                  1 + number of the function that tells if patches keep their features, or 0
    ``laws``, ``first_law``       laws that switch, and the first one's number among these functions;  ``sided``: their
                                  memory (`kernels.sided_run`)
    ``watch``, ``watch_later``    outputs of ``watched``, now and a moment later
    ``final``                     1 for each function of the user that ends the run
    ``signs``, ``ways``, ``crossed_at``    sign of each, `UNSEEN` before it is known; sign and time of its last event
    ``piece``, ``finding``, ``colliding``    addresses of `step_control.piece`, `contacts.find`, `collision.collided`
    ``looking``, ``phase``        constants of the functions of all contacts, and of the present phase
    ``quaternions``               components at which the ``turned`` unit quaternions begin
    ``side``, ``end_of``          side that a corner ends, or -1, and which end that is
    ``poisson``                   1 for Poisson's law
    ``blocks``, ``starts``, ``beside``    blocks of speeds: their number, the first speed of each, and those of each
                                  contact (`candidates.SpeedBlocks`);  ``owner``: contact of each row
    ``parent``, ``island``        island of each block, and of each contact (`problem`)
    ``holds``, ``condition``      number of conditions of each island, and the first condition of each contact
    ``concerned``, ``members``    contacts of all islands of a problem, in their own order and island by island
    ``presser``                   of what resists rolling or spinning: the contact whose normal force bounds it; else -1
    ``held``, ``compliant``       1 for a contact whose normal force the state gives, and if that is a law of its depth
    ``loaded``, ``loads``         1 for a contact that the load of a joint presses, and their number;  ``load``: that
                                  load at the last decision;  ``unstruck``: forces of these joints without an impact;
                                  ``blown``: impulses of a blow on them;
                                  ``bounds``: memory of the search for their loads in an impact (`broyden`)
    ``rings``, ``ring_edge``, ``ring_first``, ``ring_at``    edges of disks whose points turn while they lie flat: their
                                  number, contact and first point of each, and the place of its cosine and sine in the
                                  parameters
    ``hoisted``                   parameters, with these angles, and the constants that follow them (`kernels.hoisted`)
    ``ending``, ``place``         contact of each ending, and the end of a side or -1

    ``stage``                     where the loop goes on
    ``stale``                     1 if the contacts are to be looked at anew
    ``t``, ``y``, ``target``      the moment, and where the run stops
    ``until``, ``resting``        end of the remaining bounces or of a phase that is held, and 1 while bounces last
    ``most_phases``               limit of the phases
    ``crowd``, ``last``           events at one moment, and the time of the last one
    ``leap``, ``leapt``           length and end of the last step of the speeds alone
    ``holding``, ``checking``     `AT_REST` while a phase has the modes of such a step, until ``until``; 1 at its end.
                                  `BESIDE` while it has modes beside a dead centre
    ``hold``                      length of the last such phase
    ``slowest``, ``creeping``     speed at which slips in space end; 1 while a phase goes on with slower ones (`creep`)
    ``held_*``                    state and log at its start
    ``rested``                    `seen` at the last check of a rest by open forces, not a number where it has ended
    ``impulses``                  work of impacts and blows
    ``implicit``, ``pace``        1 while steps are implicit, since friction of a slow slip in space is stiff; length of
                                  the explicit step that would have come next
    ``stop``                      not 0 pauses the run; another thread writes it
    ``budget``, ``steps_left``    steps and stages until the next pause, and steps until the run is given up
    ``crept``, ``crept_from``     number of steps since a time that is less than `STALL_TIME` ago
    ``worst``                     greatest residual of a decision or an impact so far

    ``seen``                      outputs of `phase_kernels.looked`, whose parts follow
    ``near``, ``still``           gap and speed that are zero;  ``apart``: gaps before a straight step
    ``closed``, ``chosen``        1 for each closed contact; the contacts of the contact problem
    ``adhesive``                  number of contacts that bear a pull
    ``adhering``, ``parted``      1 for each contact whose pull is in the accelerations; for each that opens now
    ``left``                      1 for each contact that begins to leave the end of its side at this moment
    ``met``, ``met_at``           contacts closed at a moment so far;  ``corrected_at``: the last moment at which speeds
                                  were not those of the phase that followed
    ``mode``, ``shown``           modes, and modes as they are shown; ``past``: those before
    ``let_go``                    contacts that have begun to slip under loads of the search for those that agree
    ``tied``, ``ties``            contacts of which a law holds with equality, and their number
    ``ends``                      which of these laws ends: a reason;  ``ended``: before the last of them was found
    ``way``                       direction of a slip that begins;  ``later``: friction of an unloaded joint a moment
                                  later, which gives it
    ``force``, ``choice``         contact forces of the decision, and 1 if shares of open forces chose its motion
    ``active``, ``actives``       independent conditions of contacts;  ``shared``: 1 for each whose forces are open
    ``hit``, ``open``             1 if contacts collided, and if other shares of the impulses would move otherwise
    ``taking``                    contacts whose speed is taken away
    ``decided``                   modes of all islands while the shares of one are found
    ``reason``, ``measure``       why a mode ended, and the friction there
    ``bounce_*``                  the last impacts
    ``list``, ``ray``, ``goal``, ``x``    a system of impulses (`impulses.impelled`)
    """

    n_q: Count
    n: Count
    n_y: Count
    contacts: Count
    rows: Count
    seen_size: Count
    moving: Count
    sequential: Count
    refuse: Count
    events: Count
    asked: Count
    followed: Count
    laws: Count
    first_law: Count
    sided: Row
    piece: Count
    finding: Count
    colliding: Count
    looked: Kernel
    rates_at: Kernel
    rates: Kernel
    projection: Kernel
    accelerations: Kernel
    forces: Kernel
    watched: Kernel
    energy: Kernel
    energy_c: Row
    looking: Row
    phase: Row
    tangents: Annotated[Wholes, "contacts"]
    first: Annotated[Wholes, "contacts"]
    owner: Annotated[Wholes, "rows"]
    blocks: Whole
    starts: Annotated[Wholes, "after_speeds"]
    beside: Annotated[Wholes, "of_contacts_twice"]
    parent: Annotated[Wholes, "after_speeds"]
    holds: Annotated[Wholes, "after_speeds"]
    island: Annotated[Wholes, "contacts"]
    condition: Annotated[Wholes, "contacts"]
    members: Annotated[Wholes, "contacts"]
    concerned: Annotated[Wholes, "contacts"]
    concerned_count: Whole
    rough: Annotated[Wholes, "contacts"]
    side: Annotated[Wholes, "contacts"]
    poisson: Annotated[Wholes, "contacts"]
    presser: Annotated[Wholes, "contacts"]
    held: Annotated[Wholes, "contacts"]
    compliant: Annotated[Wholes, "contacts"]
    loaded: Annotated[Wholes, "contacts"]
    loads: Count
    load: Annotated[Row, "contacts"]
    unstruck: Annotated[Row, "of_bearings"]
    blown: Annotated[Row, "of_bearings"]
    bounds: Annotated[Row, "of_bounds"]
    rings: Count
    ring_edge: Annotated[Wholes, "rings"]
    ring_first: Annotated[Wholes, "rings"]
    ring_at: Annotated[Wholes, "rings"]
    hoisted: Row
    turned: Count
    quaternions: Wholes
    ending: Wholes
    place: Wholes
    final: Wholes
    signs: Wholes
    ways: Wholes
    crossed_at: Row
    watch: Row
    watch_later: Row
    stage: Whole
    stale: Whole
    t: Real
    target: Real
    until: Real
    resting: Whole
    most_phases: Whole
    rest_left: Real
    crowd: Whole
    last: Real
    leap: Real
    leapt: Real
    holding: Whole
    checking: Whole
    hold: Real
    slowest: Real
    creeping: Whole
    held_from: Real
    held_work: Real
    held_marks: Whole
    held_numbers: Whole
    held_rows: Whole
    held_phases: Whole
    impulses: Real
    implicit: Whole
    pace: Real
    budget: Whole
    stop: Whole
    steps_left: Whole
    crept: Whole
    crept_from: Real
    worst: Real
    phases: Whole
    blame: Whole
    hit: Whole
    open: Whole
    spare_count: Whole
    begun: Whole
    first_row: Whole
    crossed: Whole
    halting: Whole
    longest: Real
    y: Annotated[Row, "n_y"]
    start: Annotated[Row, "n_y"]
    kept: Annotated[Row, "n_y"]
    held_state: Annotated[Row, "n_y"]
    trial: Annotated[Row, "n_y"]
    seen: Annotated[Row, "seen_size"]
    rested: Annotated[Row, "seen_size"]
    gap: Row
    reach: Row
    rate: Row
    c: Row
    free: Row
    W: Row
    X: Row
    coefficients: Row
    away: Row
    given: Row
    adhesion: Row
    adhesive: Count
    adhering: Annotated[Wholes, "contacts"]
    parted: Annotated[Wholes, "contacts"]
    near: Real
    still: Real
    closed: Annotated[Wholes, "contacts"]
    chosen: Annotated[Wholes, "contacts"]
    count: Whole
    needed: Whole
    left: Annotated[Wholes, "contacts"]
    met: Annotated[Wholes, "contacts"]
    met_at: Real
    corrected_at: Real
    mode: Annotated[Wholes, "contacts"]
    before: Annotated[Wholes, "contacts"]
    shown: Annotated[Wholes, "contacts"]
    past: Annotated[Wholes, "contacts"]
    dead: Annotated[Wholes, "contacts"]
    taking: Annotated[Wholes, "contacts"]
    decided: Annotated[Wholes, "contacts"]
    ends: Annotated[Wholes, "contacts"]
    ended: Annotated[Wholes, "contacts"]
    shared: Annotated[Wholes, "contacts"]
    tied: Annotated[Wholes, "contacts"]
    let_go: Annotated[Wholes, "contacts"]
    ties: Whole
    ready: Whole
    reason: Annotated[Wholes, "contacts"]
    stopped: Annotated[Wholes, "contacts"]
    stopping: Annotated[Wholes, "contacts"]
    resters: Annotated[Wholes, "contacts"]
    end_of: Annotated[Wholes, "contacts"]
    measure: Annotated[Row, "contacts"]
    apart: Annotated[Row, "contacts"]
    flight: Annotated[Row, "contacts"]
    later: Annotated[Row, "contacts"]
    way: Annotated[Rows, "contacts", 2]
    way_before: Annotated[Rows, "contacts", 2]
    choice: Whole
    force: Annotated[Row, "rows"]
    active: Annotated[Wholes, "rows"]
    actives: Whole
    speeds: Annotated[Row, "rows"]
    list: Annotated[Wholes, "rows"]
    ray: Annotated[Rows, "rows", RAY]
    goal: Annotated[Row, "rows"]
    x: Annotated[Row, "rows"]
    whole: Annotated[Row, "rows"]
    nu: Annotated[Row, "rows"]
    v: Annotated[Row, "n"]
    step: Annotated[Row, "n_y"]
    bounces: Whole
    bounce_time: Annotated[Row, BOUNCES]
    bounce_speed: Annotated[Row, BOUNCES]
    bounce_stuck: Annotated[Wholes, BOUNCES]
    bounced: Annotated[Wholes, "bounce_flags"]
    marks: Wholes
    marks_room: Whole
    marked: Whole
    numbers: Row
    numbers_room: Whole
    numbered: Whole
    times: Row
    lengths: Row
    states: Row
    path_room: Whole
    logged: Whole


def event_run(scene: Any, n_y: int) -> EventRun:
    """Return the memory of a run with these contacts, without a log."""
    model, E, m = scene.model, len(scene.first), scene.rows
    n = model.n_u
    seen = 9 * E + 2 * m + n + 2 * m * n
    it = EventRun.made(
        n_q=model.n_q,
        n=n,
        n_y=n_y,
        rings=len(model.rings),
        contacts=E,
        rows=m,
        seen_size=seen,
        after_speeds=n + 1,
        of_contacts_twice=2 * E,
        bounce_flags=BOUNCES * E,
        of_bearings=LOADED * len(scene.loaded),
        of_bounds=2 * len(scene.loaded) * (5 + 2 * len(scene.loaded)),
    )
    at = 0
    for name, size in (
        ("gap", E), ("reach", E), ("rate", m), ("c", m), ("free", n), ("W", m * n), ("X", m * n),
        ("coefficients", 4 * E), ("away", E), ("given", E), ("adhesion", E),
    ):  # fmt: skip
        setattr(it, name, it.seen[at : at + size])
        at += size
    it.tangents[:], it.first[:] = scene.tangents, scene.first
    it.owner[:] = [k for k, count in enumerate(scene.tangents) for _ in range(1 + count)]
    it.blocks, it.starts[1:] = 1, n
    it.rough[:] = [not c.frictionless for c in model.contacts]
    it.poisson[:] = [c.impact == "poisson" for c in model.contacts]
    it.presser[:] = scene.presser
    it.held[:], it.compliant[:], it.adhesive = scene.held, scene.compliant, sum(scene.adhesive)
    it.loaded[list(scene.loaded)], it.loads = 1, len(scene.loaded)
    it.side[:] = -1
    for k, ((side, place),) in scene.ends.items():
        it.side[k], it.end_of[k] = side, place
    names = [parameter.name for parameter in model.parameters]
    it.ring_edge[:] = [ring.edge for ring in model.rings]
    it.ring_first[:] = [ring.first for ring in model.rings]
    it.ring_at[:] = [names.index(ring.names[0]) for ring in model.rings]
    return it
