"""The variational equations of a machine whose loads switch, on one side of every switch.

A law that switches has sign(e). Here each sign is a constant of the run, so that the rates are smooth up to the switch
and beyond it, and e passes zero as any event does. At a switch the run goes on with the other sign (`switch_slopes`).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...dynamics import State
from ...dynamics.motion import motion
from ...program.kernels import compile_tape
from ...scalar.algebra import Scalar
from ...scalar.trace import Tape
from ..kernels.kernels import Kernels
from ..kernels.program import Program
from ..kernels.sides import SidedTape, Sides, sides_of
from ..kernels.switches import value_of
from ..ode.dense_output import Array, Rates, Watch
from .switch_slopes import SwitchingLaws, law_outputs, laws_of, switching_laws
from .variation import Functions, Variation


class SidedVariation(Variation):
    """The programs of a machine and of its variational equations; their parameters are followed by the signs."""

    kind = "sided variation"

    def _tape(self) -> Tape:
        return SidedTape()

    def _rates_of_state(self, state: State) -> list[Scalar]:
        tape = state.field
        assert isinstance(tape, SidedTape)
        tape.sided = True
        rates = super()._rates_of_state(state)
        tape.sided = False
        return rates

    def _constants(self, tape: Tape) -> list[Scalar]:
        assert isinstance(tape, SidedTape)
        return [side for side, _ in tape.sides.values()]

    def _others(self, state: State) -> Functions:
        """Return the function ``switches``; the texts of all e go to the cache of the machine."""
        tape = state.field
        assert isinstance(tape, SidedTape)
        tape.sided = True
        udot = motion(self.kernels.model, state, self.kernels.active).udot
        tape.sided = False
        self.kernels.cache[self._texts] = tuple(str(tape.to_sympy(e)) for _, e in tape.sides.values())
        pairs = list(tape.sides.values())
        return {"switches": law_outputs(tape, state, udot, pairs, self.unknowns)}

    @property
    def _texts(self) -> str:
        return f"sides {self._names}"

    def laws(self, parameters: Array) -> SwitchingLaws:
        """Return the laws that switch, at values of the parameters and signs."""
        program = self.program()  # it finds the texts
        return laws_of(self, program, self.kernels.cache[self._texts], parameters)

    def at(self, parameters: Array, signs: Array, method: str) -> tuple[Array, Rates]:
        """Return parameters with signs, and the rates there."""
        both = np.concatenate([parameters, signs])
        return both, self.rates(both, method)

    def watching(self, specs: Sequence[Any], expressions: Sequence[Any], parameters: Array) -> Watch:
        """Return the events of the user, and after them those at which a law switches, which end a leg."""
        key = ("watched with sides", tuple(expressions))
        programs = self.kernels.programs
        if key not in programs:
            tape, state, y, _, own = self._traced()
            self._rates_of_state(state)
            values = [value_of(state, x) for x in expressions]
            assert isinstance(tape, SidedTape)
            values += [e for _, e in tape.sides.values()]
            compiled = compile_tape(tape, {"values": values}, state.t, y, [*own, *self._constants(tape)])
            programs[key] = Program(compiled)
        program = programs[key]
        count = program.outputs("values") - len(specs)
        directions, terminal = [spec.direction for spec in specs], [spec.terminal for spec in specs]
        return Watch(
            program.address("values"), (*directions, *[0] * count), (*terminal, *[True] * count),
            program.constants(parameters), program,
        )  # fmt: skip


def with_signs(source: Any, parameters: Array, given: Sequence[Any]) -> tuple[Any, Array]:
    """Return programs, and parameters followed by the signs of a leg, if a file gives any.

    Raises
    ------
    ValueError
        They are not those of the loads of the machine that switch.
    """
    signs = np.array(given, dtype=float)
    if not signs.size or not isinstance(source, Variation | Kernels):
        return source, parameters
    laws: SwitchingLaws | Sides | None
    if isinstance(source, Variation):
        laws, allowed = switching_laws(source, parameters), [-1, 1]
    else:
        laws, allowed = sides_of(source), [-1, 0, 1]
    if laws is None or signs.shape != (len(laws.texts),) or not np.isin(signs, allowed).all():
        raise ValueError("the signs of its loads are not those of the machine")
    numbers = np.concatenate([parameters, signs])
    if isinstance(source, Variation):
        return SidedVariation(source.kernels, source.unknowns), numbers
    assert isinstance(laws, Sides)
    return laws.kernels, numbers
