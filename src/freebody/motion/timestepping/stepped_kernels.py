"""Compiled code of time stepping (`moreau.march`), and the sparsity of its matrices.

Speeds coupled by the mass matrix or a constraint form a block; a row of W is stored over the blocks of its two bodies.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...describe.contacts.coefficients import SLIP
from ...dynamics import State, coordinate_rates, mass_matrix
from ...dynamics.bearing_loads import bearing_loads
from ...dynamics.conditions.constraints import rows
from ...dynamics.conditions.contact import contact_rows, given_normal_force, touch, touches
from ...dynamics.conditions.linearized import linearized
from ...dynamics.contact_geometry import Touch
from ...dynamics.contact_motion import forced_motion
from ...dynamics.energy import load_power
from ...dynamics.kinematics import Spot
from ...dynamics.linear import combined
from ...dynamics.motion import all_reactions
from ...dynamics.newton_euler import bias, drive_power
from ...model import Model
from ...model.contact import Contact, friction_varies
from ...model.resistance import pressers
from ...scalar.algebra import ZERO
from ...scalar.trace import Traced
from ..kernels.kernels import Kernels
from ..kernels.program import Program
from ..phase.candidates.candidates import layout_of, stretched
from ..phase.candidates.speed_blocks import coupled_speeds, speeds_inward

Whole = Any  # array of int64


@dataclass(frozen=True, eq=False)
class Shape:
    """Sparsity of the matrices, the same in every step, in the form that `moreau.march` takes.

    ``held``       the active conditions: first the ``holonomic`` conditions on coordinates, then those on speeds
    ``order``      model speed at each position in block order
    ``blocks``     first position of each block
    ``squares``    first entry of each block in the stored M
    ``pieces``     blocks of the rows of W over G; the blocks of row r begin at ``row_first[r]``, its values at
                   ``row_at[r]``
    ``reach_of``   contact of each reach
    ``turning``    True if the loads f depend on the speeds
    """

    held: tuple[int, ...]
    holonomic: int
    order: Whole
    blocks: Whole
    squares: Whole
    pieces: Whole
    row_first: Whole
    row_at: Whole
    reach_of: Whole
    turning: bool


def _places(row: Sequence[Any]) -> list[int]:
    """Return the places of the numbers of a row that are not zero."""
    return [j for j, x in enumerate(row) if isinstance(x, Traced) or x != 0]


def _shape(
    model: Model, coupled: Sequence[Sequence[int]], moved: Sequence[Sequence[int]], held: Sequence[int],
    reaches: Sequence[int], turning: bool,
) -> Shape:  # fmt: skip
    """Return the shape for the speeds of which M or G couple some, and those that each row of W and G has."""
    groups = coupled_speeds(model.n_u, coupled)
    block_of = {i: k for k, group in enumerate(groups) for i in group}
    first, tangents, m = layout_of(model)
    over = [sorted({block_of[j] for j in speeds}) for speeds in moved]
    for at, count in zip(first, tangents, strict=True):  # all rows of a contact cover the same blocks
        whole = sorted({k for r in range(at, at + 1 + count) for k in over[r]})
        over[at : at + 1 + count] = [whole] * (1 + count)
    groups_of: dict[str, list[int]] = {}
    for at, count, contact in zip(first, tangents, model.contacts, strict=True):
        groups_of.setdefault(contact.presser or contact.name, []).extend(range(at, at + 1 + count))
    for places in groups_of.values():  # so do those of what resists its rolling
        whole = sorted({k for r in places for k in over[r]})
        for r in places:
            over[r] = whole
    sizes = [len(group) for group in groups]

    def starts(lengths: Any) -> Whole:
        return np.concatenate([[0], np.cumsum(np.array(list(lengths), dtype=np.int64))]).astype(np.int64)

    kinds = rows(model)
    return Shape(
        tuple(held),
        sum(not kinds[i].on_speeds for i in held),
        np.array([i for group in groups for i in group], dtype=np.int64),
        starts(sizes),
        starts(size * size for size in sizes),
        np.array([k for one in over for k in one], dtype=np.int64),
        starts(len(one) for one in over),
        starts(sum(sizes[k] for k in one) for one in over),
        np.array([k for k, count in enumerate(reaches) for _ in range(count)], dtype=np.int64),
        turning,
    )


def _depend(outputs: Sequence[Any], inputs: Sequence[Any]) -> bool:
    """Return True if an output depends on an input."""
    traced = [x for x in outputs if isinstance(x, Traced)]
    if not traced:
        return False
    needed = set(traced[0].tape.used(traced))
    return any(isinstance(x, Traced) and x.index in needed for x in inputs)


def stepping(kernels: Kernels) -> tuple[Program, Shape]:
    """Return the functions ``system``, ``closing``, ``moving``, ``loading`` (`stepping_record`) and their shape.

    The program of a looped machine has ``moving`` only.
    """
    model = kernels.model
    looped = kernels.looped()
    if looped is not None:
        return looped[0], _shape(model, speeds_inward(model), [], (), (), True)
    kinds = rows(model)
    held = sorted(kernels.active, key=lambda i: (kinds[i].on_speeds, i))
    holonomic = [i for i in held if not kinds[i].on_speeds]
    shapes: dict[str, Shape] = kernels.__dict__.setdefault("_shapes", {})

    def functions(state: State) -> Mapping[str, Sequence[Any]]:
        given, conditions = contact_rows(model, state), linearized(model, state)
        reaches = [one.reach for one in _touches(model, state)]
        M, W, G = mass_matrix(model, state), list(given.matrix), [conditions.matrix[i] for i in held]
        f, gap, rate = [-x for x in bias(model, state)], list(given.gap), list(given.rate)
        rate, W = _stretched(model, state, rate), _stretched(model, state, W)
        N, pressed, power = [_given(model, state, contact) for contact in model.contacts], [0] * model.n_u, 0
        pressed_by = pressers(model.contacts)
        for k, (r, contact) in enumerate(zip(layout_of(model)[0], model.contacts, strict=True)):
            if pressed_by[k] >= 0:
                gap[k] = gap[pressed_by[k]]
            if contact.compliant:  # its normal force is a load: no impulse is to be found along its normal
                pressed, power = combined(pressed, [N[k]], [W[r]]), power + N[k] * rate[r]
                W[r], rate[r], gap[k] = (0,) * model.n_u, 0, state.field.apply("max", gap[k], 0)
        turning = _depend(f, state.u)
        coupled, moved = ([_places(row) for row in matrix] for matrix in ([*M, *G], [*W, *G]))
        coupled += speeds_inward(model)
        shape = _shape(model, coupled, moved, held, [len(one) for one in reaches], turning)
        shapes["stepping"] = shape
        groups = [shape.order[a:b].tolist() for a, b in zip(shape.blocks, shape.blocks[1:], strict=False)]
        closing = [*gap, *(x for one in reaches for x in one)]
        residuals = [conditions.residual[i] for i in holonomic]
        ranges = zip(shape.row_first.tolist(), shape.row_first[1:].tolist(), strict=False)
        return {
            "system": [
                *(M[i][j] for group in groups for i in group for j in group),
                *(f[i] for i in shape.order),
                *closing,
                *rate,
                *N,
                *(pressed[i] for i in shape.order),
                power,
                *(conditions.rate[i] for i in held),
                *residuals,
                *(
                    row[j]
                    for row, (a, b) in zip([*W, *G], ranges, strict=True)
                    for k in shape.pieces[a:b]
                    for j in groups[k]
                ),
            ],
            "closing": [*closing, *residuals],
            "moving": [*coordinate_rates(model, state), load_power(model, state)],
            "loading": [f[i] for i in shape.order] if turning else [],
        }

    return kernels.program("stepping", functions), shapes["stepping"]


def _stretched(model: Model, state: State, rows: Sequence[Any]) -> list[Any]:
    """Return the rows of all contacts, with second tangents that have a coefficient of their own times their ratio."""
    result: list[Any] = []
    for at, count, contact in zip(*layout_of(model)[:2], model.contacts, strict=True):
        result += stretched(rows[at : at + 1 + count], state(contact.stretch))
    return result


def _given(model: Model, state: State, contact: Contact) -> Any:
    """Return the normal force that the state gives: of a compliant contact that is deep and whose law does not pull."""
    N = given_normal_force(model, state, contact)
    if not contact.compliant:
        return N
    deep = (1 + state.field.apply("sign", -touch(model, state, contact).gap)) / 2
    return deep * state.field.apply("max", N, 0)


def _touches(model: Model, state: State) -> list[Touch]:
    """Return the geometry of the contacts. A point on which a disk stands that lies flat touches at any tilt.

    By events it gives way to the edge, beside which it has nothing to hold. A step goes on beyond the lowest point of
    the edge, which runs round ever faster as the disk lies down, and what it leaves then is held by the others.
    """
    return [
        replace(one, reach=()) if contact.stands else one
        for one, contact in zip(touches(model, state), model.contacts, strict=True)
    ]


FRICTION = "laws of friction"
"""Key of the program of `laws_of_friction`."""


def laws_of_friction(kernels: Kernels) -> tuple[Program | None, dict[str, str]]:
    """Return functions of (q, u, slip speed) that give the coefficients in slip and at rest, and their names.

    They are named by contact or family; one with a single number has none.
    """
    model = kernels.model
    laws = {contact.name: contact for contact in model.contacts}
    laws |= {family.name: family.representatives[0] for family in model.families if family.representatives}
    chosen = {name: law for name, law in laws.items() if friction_varies(model, law)}
    names = {name: f"friction {k}" for k, name in enumerate(chosen)}

    def functions(state: State, given: Sequence[Any]) -> Mapping[str, Sequence[Any]]:
        return {
            names[name]: [state.with_values(law.friction, {SLIP: given[0]}), state(law.static_friction)]
            for name, law in chosen.items()
        }

    return (kernels.program(FRICTION, functions, 1) if chosen else None), names


def gaps(kernels: Kernels) -> Program:
    """Return the functions ``gap`` (E), ``reach`` (two of each contact, 1 where it has none) and ``rate`` (m)."""

    def functions(state: State) -> Mapping[str, Sequence[Any]]:
        given = contact_rows(kernels.model, state)
        reaches = [x for one in _touches(kernels.model, state) for x in one.both_reaches]
        return {"gap": list(given.gap), "reach": reaches, "rate": list(given.rate)}

    return kernels.program("gaps", functions)


def mean_reactions(kernels: Kernels) -> Program:
    """Return the functions ``reactions`` (force and moment of each joint) and ``drive`` (power of drives) of a step.

    Their arguments are the state (q_M, u) of the step, then (u⁺ - u)/h, the contact forces Λ/h and the multipliers λ/h
    of all conditions; last, for each of `bodies_in_families`, the force of its families and its moment about the
    ground's origin.
    """
    model = kernels.model
    _, _, m = layout_of(model)
    n, count, bodies = model.n_u, len(rows(model)), bodies_in_families(model)

    def functions(state: State, given: Sequence[Any]) -> Mapping[str, Sequence[Any]]:
        end = n + m + count
        pressed = [
            (Spot(body, ZERO), tuple(given[k : k + 3]), tuple(given[k + 3 : k + 6]))
            for body, k in zip(bodies.values(), range(end, end + 6 * len(bodies), 6), strict=True)
        ]
        moving = forced_motion(model, state, given[:n], given[n : n + m], given[n + m : end], pressed)
        found = all_reactions(model, state, moving)
        return {
            "reactions": [x for name in found for vector in found[name] for x in vector],
            "drive": [drive_power(model, state, moving.udot, moving.loads)],
        }

    return kernels.program("mean reactions", functions, n + m + count + 6 * len(bodies))


def mean_bearings(kernels: Kernels) -> Program:
    """Return the function ``bearings`` of a step: the levers and forces of joints whose load bounds their friction."""
    model = kernels.model
    n, m, count = model.n_u, layout_of(model)[2], len(rows(model))

    def functions(state: State, given: Sequence[Any]) -> Mapping[str, Sequence[Any]]:
        moving = forced_motion(model, state, given[:n], given[n : n + m], given[n + m :])
        return {"bearings": bearing_loads(model, state, moving)}

    return kernels.program("mean bearings", functions, n + m + count)


def bodies_in_families(model: Model) -> dict[str, Any]:
    """Return the bodies that have members of families, by name, without the ground."""
    shapes = [member.shape for family in model.families for member in family.members]
    return {shape.body.name: shape.body for shape in shapes if not shape.body.is_ground}
