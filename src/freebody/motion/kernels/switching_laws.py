"""Laws that switch on a speed, and motions that would stick on such a law.

    F = -c sign(e),   e(t, q, u)        ė₊, ė₋: the rate of e if the sign is +1 and -1
    ė₊ < 0 < ė₋                         both sides lead back to e = 0

There the machine cannot leave e = 0 to either side. It stays, under a force between -c and +c that the law does not
state, and an integrator takes ever shorter steps back and forth. A run stops at the first state from which, over
several steps, both sides lead back and e moves by less than either side alone would move it. No motion on one side does
that.

Source: A. F. Filippov, Differential Equations with Discontinuous Righthand Sides (1988), section 4.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from ...dynamics import State, coordinate_rates
from ...dynamics.motion import motion
from ...scalar.algebra import Scalar
from ...scalar.derivative import forward
from ...scalar.trace import CODES, Tape, Traced
from ..ending import End
from ..ode.dense_output import Array, observe
from ..ode.integration import Halt
from .kernels import Kernels
from .program import Program

WINDOWS = (8, 32)
"""Numbers of steps over which the change of e is compared with that on either side. The motion sticks from the first of
these steps that starts within one step of e = 0."""


@dataclass(frozen=True)
class Switching:
    """The laws of a machine that switch on a speed.

    ``program``  function ``laws`` of (t, y): e, ė, ∂ė/∂sign and the sign of each law
    ``texts``    e of each law
    """

    program: Program
    texts: tuple[str, ...]

    def halt(self, parameters: Array) -> Halt:
        """Return the function that stops a run at the first state from which it sticks."""
        address, constants = self.program.address("laws"), self.program.constants(parameters)
        count = 4 * len(self.texts)

        def first(times: Array, states: Array) -> tuple[int, End, int] | None:
            laws = observe(address, count, times, states, constants).reshape(len(times), -1, 4)
            e, rate, slope, sign = np.moveaxis(laws, -1, 0)
            fall, rise = -(rate + slope * (1 - sign)), rate - slope * (1 + sign)
            pull = np.minimum(fall, rise)  # rate towards e = 0 on the side that leads back more slowly
            candidates = [
                candidate for steps in WINDOWS if (candidate := _first(times, e, pull, steps)) is not None
            ]
            if not candidates:
                return None
            row, law = min(candidates)
            return row, End.STUCK, law

        return first


def _first(times: Array, e: Array, pull: Array, steps: int) -> tuple[int, int] | None:
    if len(times) <= steps:
        return None
    span = np.abs(times[steps:] - times[:-steps])
    least = sliding_window_view(pull, steps + 1, axis=0).min(axis=-1)
    reach = sliding_window_view(np.abs(e), steps + 1, axis=0).max(axis=-1)
    # e = 0 to the last bit is a state of rest that the law itself allows, since sign(0) = 0
    rows, laws = np.nonzero((least > 0) & (reach > 0) & (reach < least * span[:, None] / 2))
    if not rows.size:
        return None
    row, law = int(rows[0]), int(laws[0])
    window = slice(row, row + steps)
    near = np.abs(e[window, law]) <= pull[window, law] * np.abs(np.diff(times[row : row + steps + 1]))
    return row + int(np.argmax(near)), law


def sticking(kernels: Kernels, parameters: Array) -> Halt | None:
    """Return the function that stops a run that sticks on a law; None if no law switches on a speed."""
    laws = switching(kernels)
    return None if laws is None else laws.halt(parameters)


def switching(kernels: Kernels) -> Switching | None:
    """Return the laws that switch on a speed; None if there are none, or if the rates are looped over links."""
    if kernels.operations is None or "sign" not in kernels.operations:
        return None
    if "switching" not in kernels.cache:
        kernels.cache["switching"] = _recorded(kernels)
    laws: Switching | None = kernels.cache["switching"]
    return laws


def _recorded(kernels: Kernels) -> Switching | None:
    model, texts = kernels.model, []

    def functions(state: State) -> dict[str, list[Scalar]]:
        tape = state.field
        assert isinstance(tape, Tape)
        qdot, udot = coordinate_rates(model, state), motion(model, state, kernels.active).udot
        variables, rates = [state.t, *state.q, *state.u], [1, *qdot, *udot]
        laws: list[Scalar] = []
        for i in tape.used(udot):
            if tape.op[i] != CODES["sign"]:
                continue
            sign, e = tape.scalar(i), tape.scalar(tape.a[i])
            (rate,) = forward(tape, [e], variables, rates)
            (slope,) = forward(tape, [rate], [sign], [1])
            if isinstance(slope, Traced) or slope != 0:
                laws += [e, rate, slope, sign]
                texts.append(str(tape.to_sympy(e)))
        return {"laws": laws}

    program = kernels.program("switching", functions)
    return Switching(program, tuple(texts)) if texts else None
