"""Memory of a phase of contacts, from which its kernels compute (`phase_kernels`). It needs no compiler."""

from __future__ import annotations

from typing import Annotated

from ...native.records import Count, Kernel, Real, Record, Row, Rows, Whole, Wholes, record


@record
class PhaseData(Record):
    """The constants c of the kernels of a phase: kernels that these call, modes as data, and working memory.

    ``n_q``, ``n``              coordinates and speeds
    ``contacts``, ``rows``      candidate contacts, and their rows: normal and tangents of each
    ``pairs``                   pairs of bodies with contacts
    ``own``, ``all_own``        conditions of the machine itself: active ones, and all
    ``endings``                 functions that may end the phase
    ``expressions``             functions of the user before them, and of the ``laws`` that switch, from ``first_law``
    ``sides``, ``bands``, ``idle``    of these laws (`kernels.sided_run`)
    ``asked``, ``inputs``       terms of the quantities of contacts that these take, and q, u and these quantities
                                (`contact_quantities`): ``of_contact``, ``what``, ``component`` and ``into`` of each
                                term;  ``near``: gap that counts as none, at the end of a phase
    ``mode``, ``dead``          mode of each contact, and 1 if the others hold it in place
    ``held_count``              contacts whose normal force the state gives
    ``compliant_count``         those of them with a law of the depth
    ``adhesive_count``          contacts that bear a pull
    ``driven``                  1 if there is a kernel ``power``
    ``loaded_count``            joints whose load bounds their friction
    ``blocks``                  blocks of speeds (`candidates.SpeedBlocks`)

    Kernels, each with its constants:

    ``machine``                 the machine at a state; its outputs begin with ``q_dot``
    ``values``                  functions of the user
    ``power``                   drives and moving conditions
    ``bearings``                of each joint with loaded friction, its lever and the forces at two places
    ``derived``                 a function of the state, accelerations, forces and multipliers
    ``gaps_of``, ``touching``   addresses of kernels: gaps and reaches between the bodies of each pair, and all of each
                                contact and its resistances, which have none, with the constants of ``machine``

    Outputs of ``machine``, one after another:

    ``q_dot``, ``free``         q' and D^-½ L⁻¹ f
    ``scale``, ``L``            D^-½ and L of M = L D Lᵀ, whose columns begin at ``starts`` with rows ``below``;
                                ``order`` has the speed at each place of the order of elimination
    ``load``                    power of loads
    ``residual``, ``rate``, ``gamma``, ``own_G``    of the machine's active conditions; ``number``: of each among all,
                                ``on_coordinates``: 1 for each that restricts coordinates

    Contacts:

    ``gaps``, ``gaps_at``       outputs of the kernels of pairs, and places of the first of each
    ``touch``, ``touch_at``     outputs of the kernels of contacts (gap, reaches, μ, μ_s, e, μ at rest, given N, pull,
                                rates, biases, W, rates of reaches), and places of the first of each
    ``gap_at``                  place of the gap of a contact in ``gaps``; its reaches follow
    ``laws_at``, ``rates_at``, ``biases_at``, ``away_at``    places in ``touch`` of μ, of the rates, of their biases and
                                of the rates of the reaches of a contact
    ``first``, ``tangents``, ``reaches``    first row, number of tangents and of reaches
    ``rough``, ``side``         1 if it may have friction, and the side that it ends or -1
    ``first_end``, ``next_end``    first contact that ends this one, a side, and the next with the same side; else -1
    ``held``, ``pushed``        1 if the state gives its normal force (its normal is no condition), and the direction in
                                which it then slips
    ``compliant``               1 if that is a law of its depth
    ``presser``                 of what resists rolling or spinning: the contact whose normal force bounds it; else -1
    ``loaded``                  contacts that the load of a joint presses;  ``bearing``: outputs of ``bearings``
    ``pressure``                of each contact: that load, else 0;  ``unloaded``: ``free`` without friction under it
    ``loads``, ``at_loads``, ``per_load``, ``newton``, ``newton_step``    these loads, one after another; ``bearing`` at
                                them, and its change with each; equations of Newton's method and their right sides
    ``band``                    gap at which it closes: 0, or the gap at the start if that is negative
    ``direction``               fixed direction of a contact at its limit of friction
    ``share``                   friction of a slip along each tangent, per unit of normal force
    ``entry``, ``entries``, ``W_at``    of each row: place of the first of its entries in ``columns``, their number, and
                                place of their values in ``touch``
    ``columns``                 place in the order of elimination of each entry
    ``only_near``               1 if `phase_kernels.looked` forms rows of near contacts only
    ``closed``, ``closed_count``, ``open``, ``open_count``    the closed contacts and the open ones

    Conditions of the phase, those of the machine first:

    ``conditions``, ``active``, ``independent``    their number, the number of independent ones, and these
    ``holonomics``, ``holonomic``    independent conditions on coordinates
    ``slipping``                1 if a contact slips with friction
    ``source``, ``row_of``      contact, or -1 - the machine's condition; row of the contact
    ``slip``                    direction of slip
    ``normal_of``               condition of the normal of a tangent or -1
    ``islands``                 number of islands: sets of conditions that share no speeds with others
    ``island``, ``members``, ``member_at``, ``active_at``    island of each condition, these by islands, and the first
                                of each island among these and among the independent ones
    ``parent``, ``number_of``   island of each block while conditions join them, and its number
    ``slips_in``, ``weighed``   1 for each island in which a contact slips with friction, and for each whose W is N
    ``low``, ``high``           places in the order of elimination between which a condition has speeds;
                                ``block_low``, ``block_high``: of each block
    ``beside_of``, ``own_block``    blocks of each contact, and of the conditions of the machine
    ``G``, ``force_row``        rows D^-½ L⁻¹ Gᵀ of conditions, then D^-½ L⁻¹ Kᵀ of slipping contacts; the row of K of
                                each condition
    ``right``, ``lam``, ``weight``    right-hand sides, λ, and the diagonal of W
    ``S``, ``Q``                G M⁻¹ Kᵀ and G M⁻¹ Gᵀ; for each condition, a number for each active one of its island
    ``square``, ``given_square``, ``nu``    equations of active conditions with their right-hand sides, these without,
                                and their solution

    ``law``, ``owner``, ``sign``, ``place``    of each ending: its law, contact, sign, and reach or -1

    ``step``, ``spare``         numbers for each speed
    ``base``, ``beside``, ``slowest``    rates at a state, a state beside it, and the least speed of a slip in space
                                (`phase_kernels.tangent`);  ``stopped``: that at which such a slip ends
    ``solved``                  1 if the last state asked for is that of the rates at ``solved_t`` and ``solved_y``
    ``state``                   q and u; ``udot``, ``force`` and ``multiplier`` of all conditions of the machine follow
    """

    n_q: Count
    n: Count
    contacts: Count
    rows: Count
    pairs: Count
    own: Count
    all_own: Count
    endings: Count
    expressions: Count
    laws: Count
    first_law: Count
    sides: Annotated[Row, "laws"]
    bands: Annotated[Row, "laws"]
    idle: Annotated[Wholes, "laws"]
    asked: Count
    held_count: Count
    compliant_count: Count
    adhesive_count: Count
    driven: Count
    loaded_count: Count
    blocks: Count
    machine: Kernel
    values: Kernel
    power: Kernel
    bearings: Kernel
    derived: Kernel
    machine_c: Annotated[Row, "of_machine"]
    values_c: Annotated[Row, "of_values"]
    power_c: Annotated[Row, "of_power"]
    bearings_c: Annotated[Row, "of_bearings"]
    derived_c: Annotated[Row, "of_derived"]
    gaps_of: Annotated[Wholes, "pairs"]
    touching: Annotated[Wholes, "contacts"]
    q_dot: Annotated[Row, "machine_outputs"]
    free: Row
    scale: Row
    L: Row
    load: Row
    residual: Row
    rate: Row
    gamma: Row
    own_G: Rows
    starts: Annotated[Wholes, "after_speeds"]
    below: Annotated[Wholes, "entries_of_L"]
    order: Annotated[Wholes, "n"]
    number: Annotated[Wholes, "own"]
    on_coordinates: Annotated[Wholes, "own"]
    gaps: Annotated[Row, "pair_outputs"]
    gaps_at: Annotated[Wholes, "pairs"]
    touch: Annotated[Row, "contact_outputs"]
    touch_at: Annotated[Wholes, "contacts"]
    of_contact: Annotated[Wholes, "asked"]
    what: Annotated[Wholes, "asked"]
    component: Annotated[Wholes, "asked"]
    into: Annotated[Wholes, "asked"]
    inputs: Annotated[Row, "of_inputs"]
    near: Real
    mode: Annotated[Wholes, "contacts"]
    dead: Annotated[Wholes, "contacts"]
    gap_at: Annotated[Wholes, "contacts"]
    laws_at: Annotated[Wholes, "contacts"]
    rates_at: Annotated[Wholes, "contacts"]
    biases_at: Annotated[Wholes, "contacts"]
    away_at: Annotated[Wholes, "contacts"]
    first: Annotated[Wholes, "contacts"]
    tangents: Annotated[Wholes, "contacts"]
    reaches: Annotated[Wholes, "contacts"]
    rough: Annotated[Wholes, "contacts"]
    side: Annotated[Wholes, "contacts"]
    first_end: Annotated[Wholes, "contacts"]
    next_end: Annotated[Wholes, "contacts"]
    held: Annotated[Wholes, "contacts"]
    compliant: Annotated[Wholes, "contacts"]
    presser: Annotated[Wholes, "contacts"]
    pushed: Annotated[Wholes, "contacts"]
    loaded: Annotated[Wholes, "loaded_count"]
    bearing: Annotated[Row, "of_bearing"]
    pressure: Annotated[Row, "contacts"]
    unloaded: Annotated[Row, "n"]
    loads: Annotated[Row, "loaded_count"]
    at_loads: Annotated[Row, "of_bearing"]
    per_load: Annotated[Rows, "loaded_count", "of_bearing"]
    newton: Annotated[Row, "loaded_squared"]
    newton_step: Annotated[Row, "loaded_count"]
    band: Annotated[Row, "contacts"]
    direction: Annotated[Rows, "contacts", 2]
    share: Annotated[Rows, "contacts", 2]
    entry: Annotated[Wholes, "rows"]
    entries: Annotated[Wholes, "rows"]
    W_at: Annotated[Wholes, "rows"]
    columns: Annotated[Wholes, "entries_of_W"]
    only_near: Whole
    closed: Annotated[Wholes, "contacts"]
    closed_count: Whole
    open: Annotated[Wholes, "contacts"]
    open_count: Whole
    conditions: Whole
    active: Whole
    independent: Annotated[Wholes, "most_conditions"]
    islands: Whole
    island: Annotated[Wholes, "most_conditions"]
    members: Annotated[Wholes, "most_conditions"]
    member_at: Annotated[Wholes, "after_conditions"]
    active_at: Annotated[Wholes, "after_conditions"]
    slips_in: Annotated[Wholes, "most_conditions"]
    weighed: Annotated[Wholes, "most_conditions"]
    parent: Annotated[Wholes, "blocks"]
    number_of: Annotated[Wholes, "blocks"]
    low: Annotated[Wholes, "most_conditions"]
    high: Annotated[Wholes, "most_conditions"]
    block_low: Annotated[Wholes, "blocks"]
    block_high: Annotated[Wholes, "blocks"]
    beside_of: Annotated[Wholes, "of_contacts_twice"]
    own_block: Annotated[Wholes, "own"]
    holonomics: Whole
    holonomic: Annotated[Wholes, "most_conditions"]
    slipping: Whole
    source: Annotated[Wholes, "most_conditions"]
    row_of: Annotated[Wholes, "most_conditions"]
    slip: Annotated[Wholes, "most_conditions"]
    normal_of: Annotated[Wholes, "most_conditions"]
    force_row: Annotated[Wholes, "most_conditions"]
    width: Count
    G: Annotated[Rows, "rows_of_G_and_K", "width"]
    most_conditions: Count
    right: Annotated[Row, "most_conditions"]
    lam: Annotated[Row, "most_conditions"]
    weight: Annotated[Row, "most_conditions"]
    S: Annotated[Rows, "most_conditions", "most_active"]
    equations: Count
    Q: Annotated[Rows, "most_conditions", "equations"]
    square: Annotated[Rows, "most_active", "equations"]
    given_square: Annotated[Rows, "most_active", "equations"]
    nu: Annotated[Row, "equations"]
    law: Annotated[Wholes, "endings"]
    owner: Annotated[Wholes, "endings"]
    sign: Annotated[Wholes, "endings"]
    place: Annotated[Wholes, "endings"]
    step: Annotated[Row, "width"]
    spare: Annotated[Row, "n"]
    base: Annotated[Row, "of_y"]
    beside: Annotated[Row, "of_y"]
    slowest: Real
    stopped: Real
    solved: Whole
    solved_t: Real
    solved_y: Annotated[Row, "of_y"]
    state: Annotated[Row, "extended_state"]
    udot: Row
    force: Row
    multiplier: Row
