"""What becomes of derivatives where a load switches: the rates jump at a time that moves with the unknowns.

A law switches where e(t, y, p) passes zero, as at a stop with a damper, or -k sign(x). With f the rates on both sides,

    dt/dp = -De/ė,    De = ∂e/∂y s + ∂e/∂p,    s⁺ = s⁻ + (f⁻ - f⁺) dt/dp

where ė is that before. Where the rates do not jump, s goes on.

Source: M. A. Aizerman, F. R. Gantmakher, On the stability of periodic motions (1958).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...dynamics import State
from ...errors import SimulationError
from ...scalar.algebra import Scalar
from ...scalar.derivative import forward, reverse
from ...scalar.trace import Tape, Traced
from ..kernels.program import Program, at_state, at_states
from ..ode.dense_output import Array

CURE = "End the run before, ask for other unknowns, or take differences of runs with values= that differ."
ALIKE = 1e-9
"""Relative size of e, of its rate, and of a jump that count as none."""
EPS = float(np.finfo(float).eps)


@dataclass(frozen=True, eq=False)
class SwitchingLaws:
    """The laws of a machine that switch, at given values of the parameters.

    ``program``   function `switches` of (t, y): e, ∂e/∂t, ∂e/∂y, ∂e/∂p of each unknown, Σ |∂u'/∂sign(e)| of each law
    ``texts``     e of each law;  ``moved``, ``unknowns``: numbers of (q, u) and of unknowns
    ``seeds``     change of each of the unknowns of the program with each unknown, if these are others
    """

    program: Program
    texts: tuple[str, ...]
    constants: Array
    moved: int
    unknowns: int
    seeds: Array | None = None

    def at(self, t: float, y: Array) -> Array:
        """Return what the program gives at a state, one row for each law."""
        found = at_state(self.program, "switches", t, y[: self.moved], self.constants)
        return self._by_unknowns(found.reshape(len(self.texts), -1))

    def _by_unknowns(self, rows: Array) -> Array:
        """Return rows with the derivatives by the unknowns."""
        if self.seeds is None:
            return rows
        first = 2 + self.moved
        by = rows[:, first:-1] @ self.seeds.T
        return np.hstack([rows[:, :first], by, rows[:, -1:]])

    def along(self, times: Array, states: Array, slopes: Array) -> tuple[Array, Array, Array]:
        """Return e, De by each unknown and the jump of each law at times; ``slopes`` are s, (times, unknowns, y)."""
        n = self.moved
        found = at_states(self.program, "switches", times, states[:, :n], self.constants)
        found = self._by_unknowns(found.reshape(len(times) * len(self.texts), -1))
        found = found.reshape(len(times), len(self.texts), -1)
        De = np.einsum("tli,tji->tlj", found[:, :, 2 : 2 + n], slopes[:, :, :n]) + found[:, :, 2 + n : -1]
        return found[:, :, 0], De, found[:, :, -1]

    def beside(self, law: int, t: float, y: Array, side: float) -> tuple[float, Array]:
        """Return the nearest time and state at which e has a sign."""
        e, slope = self.at(t, y)[law, 0], self.at(t, y)[law, 1 : 2 + self.moved]
        size = float(slope @ slope)
        change = EPS * (abs(slope[0] * t) + float(np.abs(slope[1:]) @ np.abs(y[: self.moved])))
        if e * side > 0 or size == 0:
            return t, y
        for k in range(64):
            step = (side * change * 2.0**k - e) / size
            moved = y.copy()
            moved[: self.moved] += step * slope[1:]
            time = t + step * slope[0]
            if self.at(time, moved)[law, 0] * side > 0:
                return time, moved
        return t, y


def law_outputs(
    tape: Tape,
    state: State,
    udot: Sequence[Scalar],
    pairs: Sequence[tuple[Any, Any]],
    unknowns: Sequence[Any],
) -> list[Scalar]:
    """Return e, ∂e/∂t, ∂e/∂(q, u), ∂e/∂p of each unknown, and Σ |∂u'/∂sign(e)|, of each (sign, e)."""
    result = list[Scalar]()
    symbols = [x.symbol for x in unknowns if x.symbol is not None]
    by = [state.t, *state.q, *state.u, *(state.values[x] for x in symbols)]
    count = len(by) - len(symbols)
    for sign, e in pairs:
        jump: Scalar = 0
        for slope in forward(tape, udot, [sign], [1]):
            jump = jump + (tape.apply("abs", slope) if isinstance(slope, Traced) else abs(slope))
        gradient = list(reverse(tape, e, by))
        rest = iter(gradient[count:])
        of_unknowns = [0 if x.symbol is None else next(rest) for x in unknowns]
        result += [e, *gradient[:count], *of_unknowns, jump]
    return result


def passed(
    laws: SwitchingLaws,
    law: int,
    moment: tuple[float, Array, Array, float],
    rates: Sequence[Array],
    least: float,
) -> tuple[Array, Array]:
    """Return dt/dp, and the jump f⁻ - f⁺ of the rates, at a switch.

    ``moment`` is the time, the state, the s_j and the sign that e takes; ``rates`` are f⁻ and f⁺; ``least`` is the rate
    of e up to which it only touches zero (`least_rate`).

    Raises
    ------
    SimulationError
        e only touches zero, the motion sticks on the law, or another law switches at this time.
    """
    t, y, s, side = moment
    n = laws.moved
    f = [x[:n] for x in rates]
    row = laws.at(t, y)[law]
    speeds = [float(row[1] + row[2 : 2 + n] @ x) for x in f]
    jump = f[0] - f[1]
    if np.abs(jump).max(initial=0.0) <= ALIKE * np.abs(f).max(initial=0.0):
        return np.zeros(len(s)), np.zeros(n)
    De = s[:, :n] @ row[2 : 2 + n] + row[2 + n : -1]
    if not side * speeds[0] > least:
        raise _refused(laws, law, t, f"it only touches zero there, with the rate {speeds[0]:.2g}")
    if not side * speeds[1] > 0:
        raise _refused(laws, law, t, "both sides lead back to it, and the motion sticks")
    check_others(laws, law, t, y, s, f[0])
    return -De / speeds[0], jump


def least_rate(laws: SwitchingLaws, law: int, times: Array, states: Array, tolerance: float) -> float:
    """Return the rate of e up to which it only touches zero, as far as the errors of a run tell.

    An error δ of e changes its rate by ë δ/ė, and ë is of the size of e/T².
    """
    zero = np.zeros((len(times), 1, laws.moved))
    e = laws.along(times, states, np.repeat(zero, laws.unknowns, axis=1))[0][:, law]
    return 1e2 * float(np.sqrt(tolerance) * np.abs(e).max() / max(abs(times[-1] - times[0]), EPS))


def check_others(laws: SwitchingLaws, law: int, t: float, y: Array, s: Array, f: Array) -> None:
    """Refuse a time at which a law switches beside ``law`` (-1: at the start), and would not if an unknown changed."""
    n, rows = laws.moved, laws.at(t, y)
    De = rows[:, 2 : 2 + n] @ s[:, :n].T + rows[:, 2 + n : -1]
    speeds = np.abs(rows[:, 1] + rows[:, 2 : 2 + n] @ f[:n])
    near = np.abs(rows[:, 0]) <= ALIKE * (1 + abs(t)) * speeds
    other = near & (rows[:, -1] > 0) & (np.abs(De).max(axis=1) > 0)
    for k in np.flatnonzero(other):
        if k != law:
            what = "it is zero at the start" if law < 0 else f"{laws.texts[law]} passes zero at the same time"
            raise _refused(laws, int(k), t, what)


def refuse_jumps(
    laws: SwitchingLaws, times: Array, states: Array, slopes: Array, passed: Sequence[tuple[int, float]] = ()
) -> None:
    """Refuse steps in which the rates jump at a time that moves with the unknowns, except those ``passed``, (law, time)
    at the end of a step.
    """
    e, De, jump = laws.along(times, states, slopes)
    moves = np.abs(De).max(axis=2) > 0
    beyond = (e[:-1] * e[1:] < 0) & ((jump[:-1] > 0) | (jump[1:] > 0)) & (moves[:-1] | moves[1:])
    for law, time in passed:
        beyond[times[1:] == time, law] = False
    rows, found = np.nonzero(beyond)
    if rows.size:
        what = f"the rates jump there, before t = {times[rows[0] + 1]:.6g} s"
        raise _refused(laws, int(found[0]), float(times[rows[0]]), what)


def _refused(laws: SwitchingLaws, law: int, t: float, what: str) -> SimulationError:
    return SimulationError(
        f"The motion has no derivatives by the unknowns of sensitivities= after t = {t:.9g} s, where a law switches as "
        f"{laws.texts[law]} passes zero: {what}. {CURE}"
    )


def laws_of(variation: Any, program: Program, texts: tuple[str, ...], parameters: Array) -> SwitchingLaws:
    """Return the laws of a machine that switch, of which a program with its parameters tells."""
    model = variation.kernels.model
    constants, moved = program.constants(parameters), model.n_q + model.n_u
    return SwitchingLaws(program, texts, constants, moved, len(variation.unknowns))


def switching_laws(variation: Any, parameters: Array) -> SwitchingLaws | None:
    """Return the laws of a machine that switch; None if there are none."""
    found = variation.switches()
    if found is None:
        return None
    program, texts = found
    return laws_of(variation, program, texts, parameters)
