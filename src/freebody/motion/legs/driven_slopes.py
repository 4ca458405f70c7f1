"""Derivatives of what sampled controllers set: their functions are called again, with dual numbers.

    u_k = f(t_k, y(t_k), p),      du_k = ∂f/∂t τ + ∂f/∂y σ + ∂f/∂p

with the changes τ of the time of the sample and σ of the state then. A function that branches does so by values, as in
the run; its memory, such as the sum of an integral law, carries derivatives from sample to sample.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from ...describe.controller import Controller
from ...dynamics.state import State
from ...errors import NoDerivativesError, SimulationError
from ...model import Model
from ...scalar.algebra import floats
from ...scalar.dual import DualField, NumericDual, slope_of, value_of
from ..ode.dense_output import Array
from ..request import Problem
from .driven import Drives
from .sensitivity import slopes_of

AGAIN = 1e-6
"""Relative difference up to which a controller gives the same number again."""


def dual_of(value: float, slopes: Iterable[float]) -> Any:
    """Return a dual number with derivatives by every unknown; the number if all are zero."""
    return DualField(floats).dual(float(value), {j: float(d) for j, d in enumerate(slopes) if d != 0})


def dual_state(model: Model, t: Any, y: Sequence[Any], values: Sequence[Any]) -> State:
    """Return a state of dual numbers; ``y`` is (q, u), ``values`` those of all parameters."""
    symbols = dict(zip((p.symbol for p in model.parameters), values, strict=True))
    return State(model, DualField(floats), t, y[: model.n_q], y[model.n_q :], symbols)


def inputs_of(model: Model) -> list[Any]:
    """Return the symbols of the parameters that controllers set."""
    names = [name for controller in model.controllers for name in controller.inputs]
    return [p.symbol for name in names for p in model.parameters if p.name == name]


class DifferentiatedDrives(Drives):
    """The signals and controllers of a run that is over, with derivatives by its unknowns.

    ``periods_along``   derivatives of the period of each controller, (controllers, unknowns)
    """

    def __init__(self, problem: Problem, unknowns: Sequence[Any]) -> None:
        p, self.count = problem, len(unknowns)
        super().__init__(p.kernels, p.numbers, p.begin, p.end, p.most_steps)
        self.periods_along = np.array(
            [slopes_of(self.model, unknowns, p.numbers, one.period) for one in self.model.controllers]
        )
        self.numbers: dict[str, Any]
        for unknown, seed in zip(unknowns, np.eye(self.count), strict=True):
            if unknown.symbol is not None:
                self.numbers[unknown.name] = NumericDual(dual_of(self.numbers[unknown.name], seed))

    def times_along(self, t: float) -> list[tuple[str, Array]]:
        """Return the derivatives of the time t by each unknown, of everything that changes then, with its name."""
        result, n = [], len(self.periods)
        for time, i, k in self._next:
            if time <= self._soon(t):
                if i < n:
                    name = f"a sample of controller '{self.model.controllers[i].name}'"
                else:
                    name = f"a break point of signal '{self.model.signals[i - n].signal.name}'"
                result.append((name, k * self.periods_along[i] if i < n else np.zeros(self.count)))
        return result

    def follow(self, t: float, y: Array, sigma: Array, tau: Array, values: Mapping[str, float]) -> None:
        """Apply the changes at t to the state y, with the derivatives of both; ``values`` are those of the run.

        Raises
        ------
        SimulationError
            A controller whose function has no derivatives, or that gives other values than in the run.
        """
        time = _numeric(dual_of(t, tau))
        state = [_numeric(dual_of(x, s)) for x, s in zip(y, sigma.T, strict=True)]
        self._change(self._due(t), time, np.array(state, dtype=object))
        for controller in self.model.controllers:
            for name in controller.inputs:
                was, now = values[name], value_of(self.numbers[name])
                if abs(now - was) > AGAIN * max(1.0, abs(was)):
                    raise SimulationError(
                        f"Controller '{controller.name}' gave {was:g} for '{name}' at t = {t:.9g} s, and {now:g} when "
                        "its function was called once more for the derivatives of sensitivities=. It remembers "
                        "something of another run: give it a method reset(), which is called when a run begins."
                    )

    def along(self, symbols: Sequence[Any]) -> Array:
        """Return the derivatives of the present values of parameters by each unknown, (unknowns, symbols)."""
        name_of = {p.symbol: p.name for p in self.model.parameters}
        names = [name_of[symbol] for symbol in symbols]
        return np.array(
            [[float(slope_of(self.numbers[x], j)) for x in names] for j in range(self.count)]
        ).reshape(self.count, len(names))

    def _sensed(self, i: int, t: Any, y: Any) -> dict[str, Any]:
        of_contacts = self._sensors[i][2]
        values = [_plain(self.numbers[p.name]) for p in self.model.parameters]
        state = dual_state(self.model, _plain(t), [_plain(x) for x in y], values)
        numbers = self.touched() if of_contacts else {}
        return {
            name: _numeric(
                of_contacts[name].value(state, numbers) if name in of_contacts else state(expression)
            )
            for name, expression in self.model.controllers[i].sensors
        }

    def _failed(self, controller: Controller, t: float, error: Exception) -> SimulationError:
        return NoDerivativesError(
            f"Controller '{controller.name}' has no derivatives by the unknowns of sensitivities= at t = "
            f"{value_of(t):.9g} s: {type(error).__name__}: {error}. Its function is called with numbers that carry "
            "derivatives: take arithmetic and NumPy's functions, such as np.sin(x), which keep them, in place of math, "
            "float() and round(), and leave out solvers. Or take differences of runs with values= that differ."
        )

    def _number(self, value: Any) -> Any:
        return value if type(value) is NumericDual else float(value)


def _numeric(x: Any) -> Any:
    """Return a number for the function of a user."""
    return NumericDual(x) if type(x) not in (int, float) and type(x) is not NumericDual else x


def _plain(x: Any) -> Any:
    """Return a number for algorithms on scalars."""
    return x.dual if type(x) is NumericDual else x
