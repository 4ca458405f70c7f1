"""Memory of the derivatives of a phase of contacts (`phase_slopes`). It needs no compiler."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any

from ...dynamics.bearing_loads import LOADED
from ...native.records import Count, Kernel, Record, Row, Rows, Wholes, record
from ..ode.dense_output import Array
from .candidates.candidate_slopes import bearing_slopes, candidate_slopes


@record
class PhaseSlopes(Record):
    """The constants c of the kernels of a phase with its derivatives by unknowns.

    ``phase``                   `PhaseData`
    ``unknowns``, ``symbols``   numbers of unknowns, and of parameters among them
    ``touches``                 number of outputs of all contacts
    ``seeds``                   change of each of these parameters with each unknown
    ``shifts``                  τ of each unknown: the s_j are derivatives along times that move with it
    ``machine``, ``touching``   kernels of `candidate_slopes`, with the constants ``machine_c``
    ``residuals``, ``speeds``   kernels of the machine's own conditions and of their rates, with the same constants;
                                ``change``: their outputs
    ``given``                   their inputs: (q, u), ``w``, the direction ``s``, then ``rest``: τ and dp
    ``q_dot``, ``bias``, ``inertia``, ``gamma``, ``own_G``    outputs of ``machine``, one after another
    ``touch``                   outputs of the contacts, at the places of those of their own kernels
    ``udot``, ``force``, ``multiplier``    derivatives of the accelerations, contact forces and multipliers
    ``z``                       numbers for each speed
    ``forces``, ``firsts``      λ of each condition, and those that W = 1 gives; ``weights``: the last W
    ``shares``, ``first_leans``, ``turns``    what these change at once, and with W
    ``pressure``                derivatives of the loads of joints, of each contact
    ``bearings``, ``bearing``   kernel of `bearing_slopes`, and its outputs; its inputs ``borne``: (q, u), accelerations
                                and forces, the direction, and their derivatives ``ways``
    ``loads``, ``answers``, ``square``    derivatives of the loads of joints, and 1 - J of their equations
    """

    n_q: Count
    n: Count
    rows: Count
    conditions: Count
    own: Count
    all_own: Count
    unknowns: Count
    symbols: Count
    contacts: Count
    touches: Count
    phase: Row
    machine: Kernel
    machine_c: Annotated[Row, "of_machine"]
    touching: Annotated[Wholes, "contacts"]
    residuals: Kernel
    speeds: Kernel
    change: Annotated[Row, "own"]
    bearings: Kernel
    bearings_c: Annotated[Row, "of_bearings"]
    seeds: Annotated[Rows, "unknowns", "most_symbols"]
    shifts: Annotated[Row, "unknowns"]
    given: Annotated[Row, "inputs"]
    w: Row
    s: Row
    rest: Row
    q_dot: Annotated[Row, "machine_outputs"]
    bias: Row
    inertia: Row
    gamma: Row
    own_G: Row
    touch: Annotated[Row, "contact_outputs"]
    udot: Annotated[Row, "n"]
    force: Annotated[Row, "rows"]
    multiplier: Annotated[Row, "all_own"]
    z: Annotated[Row, "n"]
    forces: Annotated[Row, "conditions"]
    firsts: Annotated[Row, "conditions"]
    weights: Annotated[Row, "conditions"]
    shares: Annotated[Row, "conditions"]
    first_leans: Annotated[Row, "conditions"]
    turns: Annotated[Row, "conditions"]
    pressure: Annotated[Row, "contacts"]
    borne: Annotated[Row, "of_borne"]
    ways: Row
    bearing: Annotated[Row, "of_bearing"]
    loads: Annotated[Row, "loaded"]
    answers: Annotated[Row, "loaded"]
    square: Annotated[Row, "loaded_squared"]


def phase_slopes(
    scene: Any, phase: Array, parameters: Array, symbols: Sequence[Any], seeds: Array, shifts: Array
) -> PhaseSlopes:
    """Return the constants of a phase with derivatives; ``phase`` are those of the phase alone."""
    model, pattern = scene.model, scene.candidates.pattern
    program, n, n_q, m = candidate_slopes(scene.candidates, symbols), model.n_u, model.n_q, len(symbols)
    constants, loaded = program.constants(parameters), len(scene.loaded)
    bearings = bearing_slopes(scene.candidates, symbols) if loaded else None
    of_bearings = bearings.constants(parameters) if bearings else constants[:0]
    own, all_own = len(scene.kernels.active), scene.candidates.own
    at, size = n_q + n, n + scene.rows + all_own
    it = PhaseSlopes.made(
        n_q=n_q, n=n, own=own, all_own=all_own, rows=scene.rows, unknowns=len(seeds), symbols=m,
        contacts=len(scene.first), most_symbols=max(m, 1), of_machine=constants.size, inputs=2 * n_q + 3 * n + 1 + m,
        machine_outputs=n_q + 2 * n + own * (1 + n), contact_outputs=sum(pattern.sizes), touches=sum(pattern.sizes),
        conditions=all_own + scene.rows, of_bearings=of_bearings.size, of_borne=2 * (at + size) + 1 + m,
        of_bearing=2 * LOADED * loaded, loaded=loaded, loaded_squared=loaded * loaded,
    )  # fmt: skip
    if bearings:
        it.bearings, it.bearings_c[: of_bearings.size] = bearings.address("bearings"), of_bearings
    it.ways = it.borne[2 * at + size + 1 + m :]
    it.machine_c[: constants.size] = constants
    it.machine, it.phase = program.address("machine"), phase
    it.residuals, it.speeds = program.address("residuals"), program.address("rates")
    for k in scene.candidates.groups:
        it.touching[k] = program.address(f"contact {k}")
    for j, row in enumerate(seeds):
        it.seeds[j, :m] = row
    it.shifts[:] = shifts
    for name, at in (("w", n_q + n), ("s", n_q + 2 * n), ("rest", 2 * n_q + 3 * n)):
        setattr(it, name, it.given[at:])
    it.bias, it.inertia, it.gamma = (it.q_dot[n_q + k * n :] for k in range(3))
    it.own_G = it.gamma[own:]
    return it
