"""A machine as a live motion: its functions on one tape, and its memory.

    beginning    y(start) of p                  conditions   expressions of p that must be positive
    rates        y' of (t, y)                   observation  what a caller wants to see of (t, y)
    projection   onto the conditions            answering    numbers of p and of y(start)
    events       event functions of (t, y)      energies     T and V, which scale the tolerance of the work

and, of a machine with constraints, the four functions of `gauss_newton.close`. One prologue computes the constants of
all.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from ...dynamics import State, coordinate_rates, kinetic_energy, potential_energy
from ...dynamics.conditions.constrained import (
    moved_onto,
)
from ...dynamics.conditions.constraints import rows
from ...dynamics.motion import motion, total_power
from ...scalar.algebra import Scalar
from ...scalar.trace import Traced
from ...space.rotation import Rotation
from ..kernels.hoisted import Hoisted
from ..kernels.reading import expression_of
from ..kernels.sides import laws_of, sided_kernels, sides_of, unsided
from ..kernels.switches import value_of
from ..ode.memory import sizes, watch
from ..start.closing_record import sizes_of_closing
from ..start.initial import named_numbers, quaternions_by_joint
from ..start.loop_closure import equip
from ..trajectory.contact_expressions import refuse_of_contacts
from ..trajectory.event import expressions_of
from .memory import Live
from .setting import Setting
from .touching_machine import PIECE, SIZES, TouchingMachine

ROOM_OF_FACTORS = 8
"""Room for factors of the conditions, as a multiple of the entries of the conditions and of their rows and columns."""

Observed = Callable[[State, Any, Sequence[Scalar]], Sequence[Scalar]]
"""Outputs at a state, from the state, the accelerations and multipliers there, and the forces of contacts."""


class LiveMachine:
    """A machine as a live motion.

    Attributes
    ----------
    functions : dict
        Name -> outputs on the tape.
    names : tuple of str
        Parameters, without those that the motion writes itself.
    named : dict
        Place of each component of the state whose start the setting names -> expression or number.
    """

    def __init__(
        self, setting: Setting, observed: Observed, answers: Callable[[State], Sequence[Scalar]]
    ) -> None:
        self.setting = setting
        kernels = setting.kernels
        self.model = model = kernels.model
        self.names = tuple(model.given(dict(model.defaults)))
        self.sides = sides_of(kernels)
        self.tape, self.state, self.parameters = sided_kernels(kernels).recorded()
        tape, state = self.tape, self.state
        self.kinds = rows(model)
        m, n = len(self.kinds), model.n_u
        # laws that switch are those of the loop from event to event, also without contacts
        self.touching = TouchingMachine(setting) if model.contacts or self.sides is not None else None
        self.size = model.n_q + n + 2 if self.touching is not None else kernels.size
        count = self.touching.scene.candidates.inputs if self.touching is not None else 0
        selecting = n + m if kernels.active else 0
        # what follows the state: a selection of conditions, or accelerations, contact forces and multipliers
        self.given = [tape.input(f"given {k}") for k in range(max(count, selecting))]
        selection = self.given[:selecting]
        self.inputs: list[Traced] = [*state.q, *state.u, *self.given]
        self.named = self._named()
        self.functions = self._functions(observed, answers)
        if kernels.active:
            self.functions |= self._closing(selection)

    def _named(self) -> dict[int, Any]:
        """Expression or number of each component whose start is named."""
        setting, model = self.setting, self.model
        numbers, names = named_numbers(model, setting.values, setting.initial)
        quaternions = quaternions_by_joint(model)
        result: dict[int, Any] = {}
        for i, key in names.items():
            value = setting.initial[key]
            name = model.names.text_of(key)
            if name in quaternions:
                part = None if isinstance(value, Rotation) else value[i - quaternions[name]]
                value = numbers[i] if part is None else part
            result[i] = expression_of(model, value, f"the initial value of '{name}'")
        return result

    def _functions(
        self, observed: Observed, answers: Callable[[State], Sequence[Scalar]]
    ) -> dict[str, list[Scalar]]:
        """Outputs of the functions of every machine."""
        model, setting = self.model, self.setting
        moving = self._moving(observed)
        state = unsided(self.state)
        start: list[Scalar] = [
            state(self.named[i]) if i in self.named else x for i, x in enumerate(map(float, setting.state))
        ]
        events = expressions_of(model, setting.specs)
        refuse_of_contacts(events)
        result: dict[str, list[Scalar]] = {
            "beginning": [*start, *[0] * (self.size - len(start))],
            "conditions": [state(x) for x in model.assumed],
            "answering": list(answers(state)),
            "events": [*(value_of(state, x) for x in events), *laws_of(self.state)],
            **moving,
        }
        if self.size > len(start):
            result["energies"] = [kinetic_energy(model, state), potential_energy(model, state)]
        return {name: outputs for name, outputs in result.items() if outputs or name == "rates"}

    def _moving(self, observed: Observed) -> dict[str, list[Scalar]]:
        """Outputs of the functions that move the machine, and of what a caller wants to see."""
        model, state, kernels = self.model, self.state, self.setting.kernels
        if self.touching is not None:
            laws = {} if self.sides is None else self.sides.functions(state, self.given[: model.n_u])
            return {**laws, **self.touching.functions(state, self.given, observed)}
        moving = motion(model, state, kernels.active)
        rates = [*coordinate_rates(model, state), *moving.udot]
        power = [total_power(model, state, moving)] if kernels.works else []
        result = {"rates": [*rates, *power], "observation": list(observed(state, moving, ()))}
        if kernels.active:
            result["projection"] = moved_onto(model, state, kernels.active)
        return result

    def _closing(self, selection: Sequence[Scalar]) -> dict[str, list[Scalar]]:
        """Outputs of the functions of `gauss_newton.close`; those of the conditions are called ``residuals`` here."""
        places, functions = self.setting.kernels.closing_functions(self.state, selection)
        starts = np.searchsorted([i for i, _ in places], np.arange(len(self.kinds) + 1))
        self.pattern = np.array([*starts, *(j for _, j in places)], dtype=np.int64)
        self.entries = len(places)
        return {"residuals": functions.pop("conditions"), **functions}

    @property
    def state_names(self) -> tuple[str, ...]:
        """Names of the components of the state."""
        if self.touching is None:
            return self.setting.kernels.names
        return (*self.model.state_names, "work", "heat of friction")

    # -- memory -----------------------------------------------------------------------------------------------

    def memory(self, addresses: Mapping[str, int], constants: int) -> Live:
        """Return the memory of the motion, for functions at these addresses with so many constants."""
        setting, kernels, model = self.setting, self.setting.kernels, self.model
        count = {name: len(outputs) for name, outputs in self.functions.items()}
        touching, size = self.touching, self.size
        room = setting.most_steps if touching is None else PIECE
        watched = len(setting.specs) + (0 if touching is None else touching.endings)
        of_run = sizes(size, watched)
        asked, of_contacts = bool(setting.specs), dict.fromkeys(SIZES, 0)
        if touching is not None:
            of_contacts = touching.sizes(addresses, constants, of_run["zeros"])
        live = Live.made(
            **of_run,
            **self._sizes_of_closing(),
            **of_contacts,
            n_events=len(setting.specs),
            n_parameters=len(self.names),
            n_outputs=count.get("observation", 0),
            n_answers=count.get("answering", 0),
            n_positive=count.get("conditions", 0),
            n_constants=constants,
            n_state=model.n_q + model.n_u,
            projected=model.n_q + model.n_u,
            room_of_frames=setting.most_frames,
            room_of_steps=room,
            rows_of_steps=room + 1,
            room_of_piece=(room + 1) * (2 + size),
            room_of_events=(setting.most_steps if touching else room) + of_run["zeros"] if asked else 0,
        )
        live.parameters[:] = kernels.parameters(setting.values)[: live.parameters.size]
        live.initial[: model.n_q + model.n_u] = setting.state
        live.start, live.until = setting.begin, setting.until
        live.most_steps, live.most_frames, live.dense = setting.most_steps, setting.most_frames, 1
        live.prologue = addresses["prologue"]
        of_phases = () if touching is None else (touching.of_phase, touching.of_looking)
        places = 1 + sum(len(data.programs) for data in of_phases)
        self.hoisted = Hoisted.made(numbers=len(self.parameters), most_programs=places)
        self.hoisted.parameters[: len(model.parameters)] = kernels.parameters(setting.values)
        live.hoisted = self.hoisted.memory
        for name in ("beginning", "conditions", "answering", "observation", "energies"):
            setattr(live, name, addresses.get(name, 0))
        if touching is None:
            self._equip(live, addresses)
        else:
            touching.equip(live, addresses, self.hoisted)
        if kernels.active:
            self._fill_closing(live, addresses)
        return live

    def _equip(self, live: Live, addresses: Mapping[str, int]) -> None:
        """Write what the run reads of the machine."""
        run, setting = live.run, self.setting
        live.quaternions[:] = self.model.quaternions
        run.rates, run.projection = addresses["rates"], addresses.get("projection", 0)
        run.c, run.quaternions = live.constants, live.quaternions
        run.longest = np.inf
        live.tolerances[:] = setting.relative
        run.times, run.lengths, run.states = live.step_times, live.step_lengths, live.step_states
        search, specs = run.search, setting.specs
        run.required = len(specs)
        directions, terminal = [spec.direction for spec in specs], [spec.terminal for spec in specs]
        watch(search, addresses.get("events", 0), live.constants, directions, terminal)
        search.log_times, search.log_numbers = live.event_times, live.event_numbers
        search.log_signs, search.log_states = live.event_signs, live.event_states

    def _sizes_of_closing(self) -> dict[str, int]:
        """Sizes of the memory of `gauss_newton.close`; none for a machine without constraints."""
        model, m = self.model, len(self.kinds)
        n_q, n, quaternions = model.n_q, model.n_u, len(model.quaternions)
        if not self.setting.kernels.active:
            return {**dict.fromkeys(sizes_of_closing(0, 0, 0, 0, 0, 0), 0), "n_quaternions": quaternions}
        return sizes_of_closing(
            n_q, n, m, quaternions, self.entries, ROOM_OF_FACTORS * (m + n + self.entries)
        )

    def _fill_closing(self, live: Live, addresses: Mapping[str, int]) -> None:
        """Write what `gauss_newton.close` reads. Named coordinates and speeds keep their values."""
        model, closing = self.model, live.closing
        live.independent[list(self.setting.kernels.active)] = 1
        for i in self.named:
            if i < model.n_q:
                closing.immobile[list(model.moved_by[i])] = 1
            else:
                closing.fixed[i - model.n_q] = 1
        equip(closing, [row.on_speeds for row in self.kinds], model.quaternions, self.pattern)
        closing.conditions = addresses["residuals"]
        closing.motion, closing.moved = addresses["motion"], addresses["moved"]
        closing.least, closing.c = addresses["least"], live.constants
