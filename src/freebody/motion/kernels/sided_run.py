"""Memory of a run whose laws switch: their sides, and what decides where they go on (`switching`).

It needs no compiler. `sides` says what a law and its side are.
"""

from __future__ import annotations

from typing import Annotated, Any

from ...native.records import Count, Kernel, Real, Record, Row, Rows, Whole, Wholes, record
from ..ode.dense_output import Array
from .hoisted import Hoisted

IN_A_ROW = 64
"""Number of switches in a row that are looked at together."""
QUICK = 1e-9
"""Part of a run within which so many switches show that they come ever faster."""
LEAST = 1e-300
"""Band of a law at rest: its e leaves zero where it passes this."""

# What is to be judged of a side (`switching.judge`).
HOLDS, ENTERED, TURNED, RESTED = range(4)


@record
class SidedRun(Record):
    """The laws of a machine that switch, in a run.

    ``laws``, ``n_q``, ``n``, ``n_y``    numbers of laws, coordinates, speeds, and components of the state
    ``hoisted``              the sides, and the constants that follow them (`hoisted.Hoisted`)
    ``sides``                1, -1, or 0 of a law whose e stays zero
    ``bands``                how far an e may be beyond zero before its law switches: 0, or what counts as round-off
    ``e``, ``e_c``           kernel of (q, u, u'): e, ė and ë of every law (`sides.Sides`)
    ``jumps``, ``order``     of each law (`sides.Law`)
    ``idle``                 1 for each law on which the rates do not depend with the sides of the others
    ``judging``              what is to be judged of a side: `HOLDS` for none
    ``sense``                -1 in a run backwards in time
    ``argument``, ``seen``   (q, u, u'), and e, ė and ë there
    ``stuck``                the law that stays at its switch, or -1
    ``recent``               1 + number of the law, time, and 1 if e is round-off, of the last switches; ``count``: of
                             these;  ``in_a_row``, ``quick``: number and time of those that are too many
    ``relative``, ``noise``  tolerance of each component; change of each e that these allow

    The trace of the rates (`sides.Flow`): ``code``, ``first`` and ``second`` of each of its ``nodes``; ``known``: 1 if
    it follows from the sides, and its ``value``; nodes of the sides, of the e, and of the ``outputs``; ``needed``: 1 if
    these depend on it.
    """

    laws: Count
    n_q: Count
    n: Count
    n_y: Count
    hoisted: Row
    sides: Row
    bands: Annotated[Row, "laws"]
    e: Kernel
    e_c: Row
    jumps: Annotated[Wholes, "laws"]
    order: Annotated[Wholes, "laws"]
    idle: Annotated[Wholes, "laws"]
    judging: Annotated[Wholes, "laws"]
    sense: Real
    argument: Annotated[Row, "of_argument"]
    seen: Annotated[Row, "of_seen"]
    stuck: Whole
    count: Whole
    in_a_row: Whole
    quick: Real
    recent: Annotated[Wholes, IN_A_ROW]
    recent_quiet: Annotated[Wholes, IN_A_ROW]
    recent_time: Annotated[Row, IN_A_ROW]
    relative: Annotated[Row, "n_y"]
    noise: Annotated[Row, "laws"]
    nodes: Count
    outputs_count: Count
    code: Annotated[Wholes, "nodes"]
    first: Annotated[Wholes, "nodes"]
    second: Annotated[Wholes, "nodes"]
    known: Annotated[Wholes, "nodes"]
    value: Annotated[Row, "nodes"]
    needed: Annotated[Wholes, "nodes"]
    side_nodes: Annotated[Wholes, "laws"]
    e_nodes: Annotated[Wholes, "laws"]
    output_nodes: Annotated[Wholes, "outputs_count"]


def sided_run(sides: Any, n_y: int, hoisted: Hoisted, e: int, constants: Array) -> SidedRun:
    """Return the memory of a run with the laws ``sides`` (`sides.Sides`), which are the last parameters.

    ``e`` is the address of the kernel of the laws, with these constants.
    """
    model, flow, laws = sides.whole.model, sides.flow, sides.laws
    n_q, n = model.n_q, model.n_u
    s = SidedRun.made(
        laws=len(laws), n_q=n_q, n=n, n_y=n_y,
        of_argument=n_q + 2 * n, of_seen=3 * len(laws), nodes=len(flow.code), outputs_count=len(flow.outputs),
    )  # fmt: skip
    s.hoisted, s.sides = hoisted.memory, hoisted.parameters[len(model.parameters) :]
    s.jumps[:], s.order[:] = [law.jumps for law in laws], [law.order for law in laws]
    s.code[:], s.first[:], s.second[:], s.known[:] = flow.code, flow.first, flow.second, flow.known
    s.value[:], s.side_nodes[:], s.e_nodes[:] = flow.value, flow.inputs, flow.switching
    s.output_nodes[:] = flow.outputs
    s.e, s.e_c, s.in_a_row = e, constants, IN_A_ROW
    return s


@record
class SidedLoop(Record):
    """A run in legs between the switches of its laws (`sided_loop`).

    ``run``, ``inner``, ``sided``    memory of the whole run, of the steps of a leg, and of its laws
    ``piece``, ``piece_room``        address of the loop of the method, and the number of steps between two looks
    ``values``, ``values_c``         kernel of the functions of the user and of all e
    ``events``, ``directions``, ``final``    number of these functions; direction in which each is asked for, and 1 if
                                     it ends the run;  ``signs``, ``ways``, ``crossed_at``: its sign, and the sign and
                                     time of its last event;  ``law_of``: the law whose e it is, or -1
    ``ends``                         1 where such an event has ended the run
    ``step``, ``longest_step``       length of equal steps; the longest step of the leg
    ``steps``, ``begun``             number of steps and start of the leg
    ``legs``, ``leg_rows``, ``leg_sides``    legs that begin in this piece, and the row of the first state and the sides
                                     of each
    """

    run: Row
    inner: Row
    sided: Row
    piece: Count
    piece_room: Count
    values: Kernel
    values_c: Row
    events: Count
    directions: Annotated[Wholes, "events"]
    final: Annotated[Wholes, "events"]
    signs: Annotated[Wholes, "events"]
    ways: Annotated[Wholes, "events"]
    law_of: Annotated[Wholes, "events"]
    crossed_at: Annotated[Row, "events"]
    seen: Annotated[Row, "watched"]
    rates: Annotated[Row, "n"]
    ends: Whole
    step: Real
    longest_step: Real
    steps: Whole
    begun: Real
    legs: Whole
    leg_rows: Wholes
    leg_sides: Rows
