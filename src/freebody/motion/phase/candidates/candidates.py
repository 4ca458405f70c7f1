"""Compiled kernels of all candidate contacts of a machine, whatever their modes, and the pattern of their outputs.

    machine    q', D^-½ L⁻¹ f, D^-½, L of M = L D Lᵀ, power of loads, and of its own conditions the residuals, the
               rates, γ and D^-½ L⁻¹ Gᵀ
    pair k     gap and reaches of each contact of two bodies
    contact k  gap, reaches, μ, μ_s, e, μ at rest, given N, adhesion, rates, biases, entries of W of a contact, then of
               what resists its rolling and spinning

f are the generalized forces with u' = 0. The last are called only for contacts that are closed or watched. Solving
with L is left to compiled code (`closed_contacts`), for the rows of the closed contacts alone.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate
from typing import Any, NamedTuple

import numpy as np

from ....dynamics import State, coordinate_rates, traced_state
from ....dynamics.bearing_loads import bearing_loads
from ....dynamics.composite import mass_matrix
from ....dynamics.conditions.constrained import constraint_power
from ....dynamics.conditions.constraints import rows
from ....dynamics.conditions.contact import (
    coefficients,
    contact_layout,
    contact_rows,
    reaches_along,
    rows_of,
    touch,
)
from ....dynamics.conditions.linearized import linearized
from ....dynamics.conditions.mobility import massless
from ....dynamics.conditions.unilateral import NEGLIGIBLE, margins, sizes
from ....dynamics.contact_motion import forced_motion
from ....dynamics.energy import load_power
from ....dynamics.linear import Factorization, entries, is_zero
from ....dynamics.motion import Motion, all_reactions
from ....dynamics.newton_euler import bias, drive_power
from ....model import Model
from ....model.resistance import pressers
from ....scalar.algebra import divide, is_always_zero
from ....scalar.trace import Tape
from ...kernels.kernels import Kernels
from ...kernels.program import Program
from ...ode.dense_output import Array
from ...start.initial import number
from .speed_blocks import SpeedBlocks, speed_blocks, speeds_inward


class ContactPattern(NamedTuple):
    """Places of a contact in the outputs of the kernels.

    ``pair``, ``gap``      pair of bodies, and place of the gap in its outputs; the reaches follow
    ``reaches``            number of reaches
    ``laws``, ``rates``, ``biases``, ``away``    places in the contact's own outputs of μ, of the rates, of their
                           biases and of the rates of the reaches
    """

    pair: int
    gap: int
    reaches: int
    laws: int
    rates: int
    biases: int
    away: int


@dataclass(frozen=True, eq=False)
class Pattern:
    """Places in the outputs of the kernels, the same at every state.

    ``order``      speed at each place of the order of elimination
    ``starts``     first entry of each column of L, and the end; ``below`` has the row of each entry
    ``contacts``   for each contact, by name
    ``rows``       for each row: first entry in ``columns``, number of entries, place of the first in the outputs
    ``columns``    place in the order of elimination of each entry of W
    ``sizes``      number of outputs of each contact; ``pairs``: of each pair of bodies
    ``blocks``     of speeds, that masses and conditions of the machine couple
    ``smooth``     True if gaps and forces run as the state does: all surfaces are planes, and nothing depends on time
    """

    order: tuple[int, ...]
    starts: tuple[int, ...]
    below: tuple[int, ...]
    contacts: tuple[ContactPattern, ...]
    rows: tuple[tuple[int, ...], ...]
    columns: tuple[int, ...]
    sizes: tuple[int, ...]
    pairs: tuple[int, ...]
    blocks: SpeedBlocks
    smooth: bool


def pairs_of(model: Model) -> list[tuple[int, ...]]:
    """Return the contacts between each pair of bodies."""
    result: dict[Any, list[int]] = {}
    for k, contact in enumerate(model.contacts):
        result.setdefault((contact.feature.body.name, contact.surface.body.name), []).append(k)
    return list(map(tuple, result.values()))


def layout_of(model: Model) -> tuple[list[int], list[int], int]:
    """Return the first row and the number of tangents of every contact, and the number of rows."""
    layout = contact_layout(model.contacts)
    first, tangents = [0] * len(model.contacts), [0] * len(model.contacts)
    for place, row in enumerate(layout):
        if row.kind == "N":
            first[row.contact] = place
        else:
            tangents[row.contact] += 1
    return first, tangents, len(layout)


def stretches(model: Model, value: Callable[[Any], Any]) -> list[Any]:
    """Return a number for each row of the contacts: 1, or ρ = μ_2/μ_1 of a second tangent with its own coefficient.

    T_2/ρ and ρ γ_2 obey Coulomb's law of one coefficient (`describe.contacts.anisotropy`): kernels of contacts know
    these, and multiply their row of W by ρ.
    """
    contacts = model.contacts
    return [
        value(contacts[row.contact].stretch) if row.direction == 1 else 1 for row in contact_layout(contacts)
    ]


def stretch_numbers(model: Model, values: Mapping[str, float]) -> Array:
    """Return `stretches` at these values of the parameters."""
    return np.array(stretches(model, lambda x: number(model, values, x, "a ratio of friction")), dtype=float)


def stretched(rows: Sequence[Any], ratio: Any) -> list[Any]:
    """Return rows of one contact, numbers or lists, with the last one, if it is a second tangent, times a ratio."""
    if len(rows) < 3 or is_one(ratio):
        return list(rows)
    last = [ratio * x for x in rows[2]] if isinstance(rows[2], list | tuple) else ratio * rows[2]
    return [*rows[:2], last]


def is_one(ratio: Any) -> bool:
    """Return True for the number 1."""
    return isinstance(ratio, int) and ratio == 1


class Candidates:
    """The kernels of a machine with contacts, compiled when they are first used."""

    def __init__(self, kernels: Kernels) -> None:
        self.kernels = kernels
        self.model: Model = kernels.model
        self.first, self.tangents, self.rows = layout_of(self.model)
        self.own = len(rows(self.model))

    # -- kernels ---------------------------------------------------------------------------------

    def functions(self, state: State) -> Mapping[str, Sequence[Any]]:
        """Return the outputs of the functions of :meth:`program`."""
        model = self.model
        M = Factorization(mass_matrix(model, state))
        idle = [model.speed_names[j] for j, d in zip(M.order, M.D, strict=True) if is_zero(d)]
        if idle:  # as of a slender bar about its axis
            raise massless(model, idle)
        scale = [divide(1, state.field.sqrt(d)) for d in M.D]
        own: list[Any] = []
        held: list[list[int]] = []

        def row(v: Sequence[Any]) -> list[Any]:
            return [a * b for a, b in zip(scale, M.forward(v), strict=True)]

        if self.kernels.active:
            conditions, kinds = linearized(model, state), rows(model)
            active = self.kernels.active
            held = [[j for j, _ in entries(conditions.matrix[i])] for i in active]
            own += [0 if kinds[i].on_speeds else conditions.residual[i] for i in active]
            own += [conditions.rate[i] for i in active] + [conditions.bias[i] for i in active]
            own += [x for i in active for x in row(conditions.matrix[i])]
        place = {j: k for k, j in enumerate(M.order)}
        below = [sorted(column) for column in M.L]
        machine = [
            *coordinate_rates(model, state),
            *row([-x for x in bias(model, state)]),
            *scale,
            *(column[i] for column, order in zip(M.L, below, strict=True) for i in order),
            load_power(model, state),
            *own,
        ]
        gaps: dict[int, tuple[int, int]] = {}
        contacts: list[ContactPattern] = []
        of_rows: list[tuple[int, ...]] = []
        columns: list[int] = []
        pairs: list[list[Any]] = []
        for pair in pairs_of(model):
            pairs.append([])
            for k in pair:
                it = touch(model, state, model.contacts[k])
                gaps[k] = len(pairs) - 1, len(pairs[-1])
                pairs[-1] += [it.gap, *it.reach]
        outputs: list[list[Any]] = []
        tape = state.field
        assert isinstance(tape, Tape)
        moving = {x.index for x in (state.t, *state.q)}
        for k, contact in enumerate(model.contacts):
            it, given = touch(model, state, contact), rows_of(model, state, (contact,))
            ratio = state(contact.stretch)
            rates, biases, matrix = (stretched(x, ratio) for x in (given.rate, given.bias, given.matrix))
            parts = [it.gap, *it.reach], coefficients(model, state, contact), rates, biases
            laws, at_rates, at_biases, _ = accumulate(map(len, parts))
            values = [x for part in parts for x in part]
            for along in matrix:
                W = entries(along)
                of_rows.append((len(columns), len(W), len(values)))
                columns += [place[i] for i, _ in W]
                values += [x for _, x in W]
            contacts.append(ContactPattern(*gaps[k], len(it.reach), laws, at_rates, at_biases, len(values)))
            if any(tape.depends(x, moving) for x in it.reach):
                values += [rate for _, rate, _ in reaches_along(model, state, contact, [0] * model.n_u)]
            else:  # whether the feature of a patch is used
                values += [0] * len(it.reach)
            outputs.append(values)
        self.kernels.cache[Pattern] = Pattern(
            tuple(M.order),
            tuple(np.cumsum([0, *map(len, below)]).tolist()),
            tuple(i for column in below for i in column),
            tuple(contacts),
            tuple(of_rows),
            tuple(columns),
            tuple(map(len, outputs)),
            tuple(map(len, pairs)),
            speed_blocks(
                model.n_u,
                [
                    *speeds_inward(model),
                    *([M.order[i] for i in (k, *column)] for k, column in enumerate(below)),
                ],
                self.speeds_of_groups([[M.order[i] for i in columns[a : a + n]] for a, n, _ in of_rows]),
                held,
            ),
            all(c.presser or (c.law is None and c.surface.endless) for c in model.contacts)
            and not tape.uses(state.t),
        )
        return {
            "machine": machine,
            **{f"pair {p}": values for p, values in enumerate(pairs)},
            **{f"contact {k}": [x for r in group for x in outputs[r]] for k, group in self.groups.items()},
        }

    def program(self) -> Program:
        """Functions ``machine``, ``pair 0``, ``pair 1``, ..., and ``contact 0``, ... of each of `groups`."""
        return self.kernels.program("candidates", self.functions, numbers_are_data=True)

    @cached_property
    def groups(self) -> Mapping[int, Sequence[int]]:
        """Each contact and what resists its rolling and spinning, which closes with it: one kernel for all."""
        of = pressers(self.model.contacts)
        return {
            k: (k, *(r for r, presser in enumerate(of) if presser == k)) for k in range(len(of)) if of[k] < 0
        }

    def speeds_of_groups(self, speeds: Sequence[Sequence[int]]) -> list[list[int]]:
        """Return for each contact the speeds of the rows of all that closes with it; ``speeds`` are those of rows."""
        result: list[list[int]] = [[] for _ in self.first]
        for group in self.groups.values():
            found = {
                j
                for k in group
                for r in range(self.first[k], self.first[k] + 1 + self.tangents[k])
                for j in speeds[r]
            }
            for k in group:
                result[k] = sorted(found)
        return result

    def kernel_of(self, k: int) -> tuple[str, slice]:
        """Return the function with the outputs of a contact, or of a resistance, and their place there."""
        leader = next(leader for leader, group in self.groups.items() if k in group)
        start, size = sum(self.pattern.sizes[leader:k]), self.pattern.sizes[k]
        return f"contact {leader}", slice(start, start + size)

    @property
    def pattern(self) -> Pattern:
        """The pattern of the outputs of :meth:`program`."""
        self.program()
        return self.kernels.cache[Pattern]

    def motion(self, state: State, given: Sequence[Any]) -> Motion:
        """Return the motion with accelerations, contact forces and multipliers that are inputs."""
        n, m = self.model.n_u, self.rows
        return forced_motion(self.model, state, given[:n], self.forces(state, given), given[n + m :])

    def forces(self, state: State, given: Sequence[Any]) -> list[Any]:
        """Return the contact forces among these inputs."""
        at, ratios = self.model.n_u, stretches(self.model, state)
        return [x if is_one(r) else r * x for x, r in zip(given[at : at + self.rows], ratios, strict=True)]

    @property
    def inputs(self) -> int:
        """Number of accelerations, contact forces and multipliers, which follow the state."""
        return self.model.n_u + self.rows + self.own

    @cached_property
    def driven(self) -> bool:
        """True if drives or moving conditions do work."""
        if any(link.one_dof and link.drift != 0 for link in self.model.links):
            return True
        tape = Tape()
        lam = [tape.input(f"multiplier {i}") for i in range(self.own)]
        return not is_always_zero(
            constraint_power(self.model, traced_state(self.model, tape), lam) if lam else 0
        )

    @cached_property
    def moving(self) -> bool:
        """True if something moves with all speeds at zero: a drive, or a surface that depends on time."""
        if any(link.drift != 0 for link in self.model.links):
            return True
        tape = Tape()
        state = traced_state(self.model, tape)
        still = State(self.model, tape, state.t, state.q, [0] * self.model.n_u, state.values)
        return not all(is_always_zero(x) for x in contact_rows(self.model, still).rate)

    def bearings_of(self, state: State, given: Sequence[Any]) -> Mapping[str, Sequence[Any]]:
        """Return the output of :meth:`bearings`."""
        return {"bearings": bearing_loads(self.model, state, self.motion(state, given))}

    def bearings(self) -> Program:
        """Function ``bearings``: lever and forces of every joint whose load bounds its friction."""
        return self.kernels.program("bearings in modes", self.bearings_of, self.inputs)

    def power_of(self, state: State, given: Sequence[Any]) -> Mapping[str, Sequence[Any]]:
        """Return the output of :meth:`power`."""
        it = self.motion(state, given)
        power = drive_power(self.model, state, it.udot, it.loads)
        return {"power": [power + constraint_power(self.model, state, it.multipliers) if self.own else power]}

    def power(self) -> Program:
        """Function ``power`` of drives and of moving conditions [W]."""
        return self.kernels.program("power in modes", self.power_of, self.inputs)

    def reactions(self) -> Program:
        """Function ``reactions`` of every joint, of the state, accelerations, contact forces and multipliers."""

        def functions(state: State, given: Sequence[Any]) -> Mapping[str, Sequence[Any]]:
            result = all_reactions(self.model, state, self.motion(state, given))
            return {"reactions": [x for name in result for vector in result[name] for x in vector]}

        return self.kernels.program("reactions in modes", functions, self.inputs)

    def limits(self) -> Program:
        """Function ``limits``, as :meth:`Kernels.limits` has it."""

        def functions(state: State, given: Sequence[Any]) -> Mapping[str, Sequence[Any]]:
            slack = margins(self.model, state, self.motion(state, given).multipliers)
            size = sizes(self.model, state, self.kernels.active)
            return {"limits": [*slack, *(a + NEGLIGIBLE * b for a, b in zip(slack, size, strict=True))]}

        return self.kernels.program("limits in modes", functions, self.inputs)
