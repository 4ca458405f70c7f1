"""The motion between two events as data of compiled code: one set of modes of the contacts.

It has the right-hand side, contact forces, and the functions that end the phase. A phase needs no code of its own: it
is data (`PhaseData`) for the functions of `phase_kernels`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ...model import Model
from ...native import loop
from ..kernels.contact_quantities import Asked, asked_by, watched_program
from ..ode.dense_output import Array, Rates
from .candidates.candidates import Candidates
from .phase_data import DataProgram, phase_data

Modes = tuple[str, ...]
"""Mode of every contact: open, stick, slip+, slip-, slip, smooth, or limit and a direction (:func:`at_limit`)."""

SMOOTH = "smooth"
"""Mode of a closed contact whose friction is zero in this run: the sense of its slip is not watched."""
LIMIT = "limit"
"""Mode of a contact in space at its limit of friction that the others hold at rest: -T/|T| is a fixed direction."""
KINDS = ("open", "stick", "slip+", "slip-", "slip", SMOOTH, LIMIT)
"""Kinds of modes, in the order of their numbers (`laws`)."""
NUMBERS = {kind: number for number, kind in enumerate(KINDS)}
_FUNCTIONS = (
    "rates", "tangent", "projection", "derived", "multipliers", "gap", "reach", "rate", "acceleration", "force",
    "static_friction", "watched", "looked", "set_modes",
)  # fmt: skip
_MODULES = tuple(
    loop.sibling(__name__, name) for name in ("phase_kernels", "projection", "endings", "mode_conditions")
)
_LABEL = _MODULES[0]


def at_limit(direction: Sequence[float]) -> str:
    """Return the mode of a contact at rest at its limit of friction, T = -μ_s N d."""
    return " ".join((LIMIT, *(repr(float(x)) for x in direction)))


def direction_of(mode: str) -> tuple[float, ...]:
    """Return the fixed direction of a mode, empty if it has none."""
    return tuple(map(float, mode.split()[1:]))


def functions() -> dict[str, Any]:
    """Return the compiled functions of this room."""

    def named() -> dict[str, Any]:
        from . import endings, mode_conditions, phase_kernels, projection

        return vars(phase_kernels) | vars(projection) | vars(endings) | vars(mode_conditions)

    return loop.made(_LABEL, _MODULES, _FUNCTIONS, named, passes="few").functions


class Phase:
    """The motion in one set of modes of a `scene.Scene`; the state is (q, u, W, heat)."""

    def __init__(
        self, scene: Any, modes: Modes, active: tuple[int, ...], sides: tuple[float, ...] = ()
    ) -> None:
        self.scene, self.modes, self.active, self.sides = scene, modes, active, sides
        self.model: Model = scene.model
        self.loose: Any = None
        self.shown: Modes = modes
        self.own = scene.kernels.active
        self.conditions = scene.conditions(modes)
        self._programs: dict[Any, DataProgram] = {}

    @property
    def size(self) -> int:
        """Number of components of y."""
        return self.model.n_q + self.model.n_u + 2

    def parameters(self, values: Mapping[str, float]) -> Array:
        """Return the values in the order of the model's parameters."""
        return self.scene.kernels.parameters(values)

    @cached_property
    def spare(self) -> list[int]:
        """Redundant contact conditions: they follow from the others."""
        own = self.scene.candidates.own
        return [i for i in range(own, own + len(self.conditions)) if i not in self.active]

    # -- programs --------------------------------------------------------------------------------

    def _program(self, key: Any, make: Callable[[], DataProgram]) -> DataProgram:
        if key not in self._programs:
            self._programs[key] = make()
        return self._programs[key]

    def motion(self) -> DataProgram:
        """Functions ``rates``, of q, u, work and heat of friction, and ``projection``."""
        moved = self.model.n_q + self.model.n_u
        sizes = {"rates": self.size, "tangent": self.size, "projection": moved}
        return self._program("motion", lambda: self.data(sizes))

    def contact(self) -> DataProgram:
        """Functions ``gap``, ``reach``, ``static_friction`` (E), ``rate``, ``acceleration`` and ``force`` (m)."""
        E = len(self.modes)
        sizes = {
            "gap": E,
            "reach": E,
            "static_friction": E,
            **dict.fromkeys(("rate", "acceleration", "force"), self.scene.rows),
        }
        return self._program("contact", lambda: self.data(sizes))

    def reactions(self) -> DataProgram:
        """Functions ``reactions`` of every joint, and ``multipliers`` of the machine's own conditions."""

        def make() -> DataProgram:
            program = self.scene.candidates.reactions()
            return self.data({"multipliers": self.scene.candidates.own}, derived=("reactions", program))

        return self._program("reactions", make)

    def limits(self) -> DataProgram:
        """Function ``limits``, as :meth:`Kernels.limits` has it."""
        limits = self.scene.candidates.limits
        return self._program("limits", lambda: self.data({}, derived=("limits", limits())))

    def whole(
        self, expressions: Sequence[Any], patches: Any = None, sensed: Sequence[Any] = ()
    ) -> DataProgram:
        """Functions ``rates``, ``projection`` and ``watched`` with room for any modes.

        The last gives the user's expressions, approach and kept of the ``patches`` of the run, if it has any, then the
        functions that end the phase (:attr:`Scene.endings`). It leaves the quantities of contacts that these and those
        ``sensed`` take behind the state in ``inputs``.
        """

        def make() -> DataProgram:
            count, asked = len(expressions) + self.scene.laws, asked_by((*expressions, *sensed))
            values: Any = watched_program(self.scene.kernels, expressions, asked) if count else None
            moved = self.model.n_q + self.model.n_u
            if patches is not None:
                values, count = patches.with_values(values, count), count + patches.functions_count
            sizes = {
                "rates": self.size,
                "tangent": self.size,
                "projection": moved,
                "watched": count + len(self.scene.endings),
            }
            return self.data(
                sizes, values=values, count=count, whole=True, asked=asked, first=len(expressions)
            )

        key = tuple(expressions), tuple(sensed)
        return make() if patches is not None else self._program(key, make)

    def rates_of(self, program: DataProgram, constants: Array) -> Rates:
        """Return the right-hand side, and the projection, of a program with these constants."""
        return Rates(
            program.address("rates"), self.size, constants, self.model.quaternions, program,
            projection=program.address("projection"), projected=program.outputs("projection"),
            method_kernels=(program.address("tangent"),),
        )  # fmt: skip

    def rates(self, parameters: Array) -> Rates:
        """Return the right-hand side with the constants of these parameters."""
        program = self.motion()
        result = Rates(
            program.address("rates"), self.size, program.constants(parameters), self.model.quaternions, program,
            method_kernels=(program.address("tangent"),), recipe=(self.rates, parameters),
        )  # fmt: skip
        if not self.active:
            return result
        return replace(
            result, projection=program.address("projection"), projected=program.outputs("projection")
        )

    # -- data ------------------------------------------------------------------------------------

    def data(
        self,
        outputs: Mapping[str, int],
        derived: tuple[str, Any] | None = None,
        values: Any = None,
        count: int = 0,
        whole: bool = False,
        source: Source | None = None,
        asked: Asked = (),
        first: int = 0,
    ) -> DataProgram:
        """Return compiled functions for these modes.

        Parameters
        ----------
        outputs     function of a phase -> number of its outputs; ``watched`` needs endings
        derived     name and program of a function of the state, accelerations, forces and multipliers
        values      program of the ``count`` functions of the user, and of laws that switch from ``first``
        whole       True for room for any modes
        asked       quantities of contacts that these take
        source      where the functions and the kernels stand; by default, on this computer
        """
        candidates = self.scene.candidates
        code, program, power, bearings = source or Source.here(candidates)
        programs = {"machine": (program, "machine")}
        found = {name: (code(name), size) for name, size in outputs.items()}
        if power is not None:
            programs["power"] = power, "power"
        if bearings is not None:
            programs["bearings"] = bearings, "bearings"
        if values is not None:
            programs["values"] = values, "values"
        if derived is not None:
            name, of_forces = derived
            programs["derived"] = of_forces, name
            found[name] = code("derived"), of_forces.outputs(name)
        data = phase_data(self, programs, "watched" in outputs, whole, asked)
        data.expressions, data.first_law = count, first
        modes = np.array([NUMBERS[mode.partition(" ")[0]] for mode in self.modes], dtype=np.int64)
        active = np.array([i - candidates.own for i in self.active[len(self.own) :]], dtype=np.int64)
        functions()["set_modes"](data, modes, np.zeros_like(modes), active, active.size)
        return DataProgram(found, data, {name: program for name, (program, _) in programs.items()})


class Source(NamedTuple):
    """Address of each function of `phase_kernels`, and programs of the candidates, the power of drives and bearings."""

    code: Callable[[str], int]
    candidates: Any
    power: Any
    bearings: Any

    @classmethod
    def here(cls, candidates: Candidates) -> Source:
        """Return the functions and kernels on this computer."""
        power = candidates.power() if candidates.driven else None
        bearings = candidates.bearings() if any(c.loaded for c in candidates.model.contacts) else None
        return cls(lambda name: functions()[name].address, candidates.program(), power, bearings)
