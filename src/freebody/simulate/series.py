"""Steps by Taylor series: the rates of a model as expressions of heyoka, and the steps it makes of them.

Source: F. Biscani, D. Izzo, Revisiting high-order Taylor methods for astrodynamics and celestial mechanics (2021).
"""

from __future__ import annotations

import copy
import operator
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..dynamics import coordinate_rates, traced_state
from ..dynamics.motion import motion, total_power
from ..errors import SimulationError
from ..scalar.trace import ADD, CONST, DIV, INPUT, MUL, NAMES, NEG, SUB, Tape, Traced
from .kernels import Kernels

Array = NDArray[np.float64]
AT_ONCE = 1000
"""Steps made before the loop goes along them: what is made beyond a terminal event is in vain."""
_ANALYTIC = frozenset(
    (
        "sin",
        "cos",
        "tan",
        "asin",
        "acos",
        "atan",
        "sinh",
        "cosh",
        "tanh",
        "sqrt",
        "exp",
        "log",
        "atan2",
        "pow",
    )
)


def heyoka() -> Any:
    """The package; a refusal that says how to get it where it is not installed."""
    try:
        import heyoka as package
    except ImportError:
        raise SimulationError(
            'method="taylor" needs the package heyoka, which is not installed. pip install "freebody[taylor]" installs '
            'it; method="gauss" reaches the same tolerances without it.'
        ) from None
    return package


def integrator(kernels: Kernels, tolerance: float) -> Any:
    """heyoka's integrator of the model, compiled once for each tolerance."""
    key = ("taylor", tolerance)
    if key not in kernels._programs:
        package = heyoka()
        tape, model = Tape(), kernels.model
        state = traced_state(model, tape)
        moving = motion(model, state, kernels.active)
        outputs = [*coordinate_rates(model, state), *moving.udot]
        if kernels.works:
            outputs.append(total_power(model, state, moving))
        y = package.make_vars(*(f"y{i}" for i in range(len(outputs))))
        y = [y] if len(outputs) == 1 else y
        given = {x.index: v for x, v in zip([*state.q, *state.u], y, strict=False)}
        given.update((state.values[p.symbol].index, package.par[i]) for i, p in enumerate(model.parameters))
        given[state.t.index] = package.time
        rates = expressions(package, tape, outputs, given)
        kernels._programs[key] = package.taylor_adaptive(
            list(zip(y, rates, strict=True)),
            [0.0] * len(y),
            pars=[0.0] * len(model.parameters),
            tol=tolerance,
            compact_mode=len(tape.used(outputs)) > 1000,
        )
    return kernels._programs[key]


def expressions(package: Any, tape: Tape, outputs: Sequence[Any], given: dict[int, Any]) -> list[Any]:
    """Outputs of a tape as expressions of heyoka."""
    table = dict(given)
    for i in tape.used(outputs):
        code, a, b = tape.op[i], tape.a[i], tape.b[i]
        if i in table:
            continue
        if code == CONST:
            table[i] = package.expression(float(tape.constants[a]))
        elif code in _ARITHMETIC:
            table[i] = _ARITHMETIC[code](table[a], table[b])
        elif code == NEG:
            table[i] = -table[a]
        elif code != INPUT and NAMES[code] in _ANALYTIC:
            operands = [table[x] for x in (a, b) if x >= 0]
            table[i] = (
                operands[0] ** operands[1]
                if NAMES[code] == "pow"
                else getattr(package, NAMES[code])(*operands)
            )
        else:
            raise SimulationError(
                f"'{NAMES[code]}' has no Taylor series where it bends, so that method=\"taylor\" can not follow it. "
                'Use method="dop853" or "gauss".'
            )
    return [table[x.index] if type(x) is Traced else package.expression(float(x)) for x in outputs]


_ARITHMETIC: dict[int, Any] = {ADD: operator.add, SUB: operator.sub, MUL: operator.mul, DIV: operator.truediv}


class Series:
    """The steps of one run: rows of time, length and the coefficients of each component."""

    def __init__(
        self,
        kernels: Kernels,
        parameters: Array,
        tolerance: float,
        state: Array,
        start: float,
        until: float,
        longest: float,
    ) -> None:
        self.made = copy.deepcopy(integrator(kernels, tolerance))
        self.made.pars[:] = parameters
        self.made.time = start
        self.made.state[:] = state
        self.until, self.longest = until, longest
        self.terms = self.made.order + 1
        self.table = np.empty((0, 2 + state.size * self.terms))
        self.count = 0
        self.ended = start == until

    def more(self) -> int:
        """Up to `AT_ONCE` steps more; how many."""
        if self.ended:
            return 0
        outcome, _, _, steps, dense, _ = self.made.propagate_until(
            self.until, max_delta_t=self.longest, max_steps=AT_ONCE, c_output=True
        )
        self.ended = "step_limit" not in str(outcome)
        if dense is None:
            return 0
        times, coefficients = np.asarray(dense.times), np.asarray(dense.tcs)
        new = len(times) - 1
        if self.count + new > len(self.table):
            larger = np.empty((max(2 * len(self.table), self.count + new), self.table.shape[1]))
            larger[: self.count] = self.table[: self.count]
            self.table = larger
        rows = self.table[self.count : self.count + new]
        rows[:, 0], rows[:, 1] = times[:-1], np.diff(times)
        rows[:, 2:] = coefficients.reshape(new, -1)
        self.count += new
        return new

    @property
    def others(self) -> tuple[int, ...]:
        """Address of the table, number of steps, numbers per component: what the loop is told."""
        return (self.table.ctypes.data, self.count, self.terms)
