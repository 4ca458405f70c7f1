"""What a user's kind of load or contact promises, checked once in a model: its code is a formula of the state.

Recorded twice, the same state gives the same scalars; replayed with numbers, what was recorded is what the code answers
to these numbers; and the gradient of a potential is the force. Points that have no values are passed over.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from numbers import Real
from typing import Any

import numpy as np

from ...describe.loads.action import Action
from ...describe.loads.load import Load
from ...describe.part import Part, line_of
from ...errors import FreebodyError, ModelError, shown
from ...model.model import Model
from ...scalar.algebra import Scalar, floats
from ...scalar.trace import Tape, Traced
from ..state import State, rest_coordinates, traced_state
from .power import virtual_powers

ROUND_OFF = Fraction(1, 2**30)
"""Greatest difference of equal values, relative to the largest."""
TRIALS = 4
"""Random states at which a kind is asked."""

Ask = Callable[[State], Sequence[Scalar]]
Act = Callable[[State], Sequence[Action]]


def check_kind(
    model: Model, part: Part, question: Callable[..., Any], ask: Ask, act: Act | None = None
) -> None:
    """Refuse answers that are no function of the state, that branch on values, or a potential of another force.

    Parameters
    ----------
    question : method of the part
    ask : function of a state
        It returns the values that the method answers.
    act : function of a state, optional
        It returns the actions that the method answers.
    """
    tape = Tape()
    first, second = (ask(traced_state(model, tape)) for _ in range(2))
    for value in first:
        if not isinstance(value, Traced | Real):
            raise ModelError(
                f"{part.heading}: expected a number, got {shown(value)} {_line(part, question)}. Return one scalar, "
                f"such as a component of a vector, v.x, or its length, v.norm()."
            )
    if len(first) != len(second) or any(
        tape.node(a).index != tape.node(b).index for a, b in zip(first, second, strict=True)
    ):
        raise ModelError(
            f"{part.heading}: asked twice at one state, it answers two things {_line(part, question)}, so that it is "
            f"not a function of the state. Take what changes from `at`, or from the fields of the part: no random "
            f"numbers, no clock, no memory of earlier calls; a signal is fb.signal."
        )
    for state in _states(model):
        numbers = _numbers(ask, state)
        recorded = None if numbers is None else _replayed(tape, first, state)
        if numbers is None or recorded is None:
            continue
        if not _equal(numbers, recorded):
            raise ModelError(
                f"{part.heading}: recorded as a formula its value is {_shown(recorded)}, but asked with numbers it is "
                f"{_shown(numbers)} {_line(part, question)}: it branches on a value. A formula has no if, no == and no "
                f"`and`; at.where(x, a, b), at.sign, at.min and at.max serve instead."
            )
    if isinstance(part, Load) and part.is_conservative and act is not None:
        _check_potential(model, part, act)


def _check_potential(model: Model, load: Load, act: Act) -> None:
    """Refuse a potential whose gradient is not the force."""
    for state in _states(model):
        try:
            force, gradient = virtual_powers(model, state, load, state.u, act(state))
        except (ArithmeticError, ValueError):
            continue
        if math.isfinite(force) and math.isfinite(gradient) and not _equal([force], [gradient]):
            raise ModelError(
                f"{load.heading}: the gradient of its potential is not its force {_line(load, load.potential)}. In a "
                f"random motion its actions have the power {force:.6g} W, and -dV/dt is {gradient:.6g} W. Correct the "
                f"sign or the factor of one of them; a load without a potential is one without this method."
            )


def _states(model: Model) -> Iterator[State]:
    """Yield random states of numbers, and the state of rest with all coordinates zero."""
    rng = np.random.default_rng(model.n_q)
    defaults = {p.symbol: p.default for p in model.parameters}
    for trial in range(TRIALS + 1):
        q, u = rng.normal(size=model.n_q), rng.normal(size=model.n_u)
        for start in model.quaternions:
            q[start : start + 4] /= np.linalg.norm(q[start : start + 4])
        t = float(rng.uniform())
        if trial == TRIALS:
            q, u, t = np.array(rest_coordinates(model), float), np.zeros(model.n_u), float(0)
        values = {symbol: float(rng.uniform()) + 1 if x is None else x for symbol, x in defaults.items()}
        yield State(model, floats, t, q.tolist(), u.tolist(), values)


def _numbers(ask: Ask, state: State) -> list[float] | None:
    """Return the answer at a state of numbers; None if it has no value there."""
    try:
        numbers = [float(x) for x in ask(state)]
    except (ArithmeticError, ValueError) as error:
        if isinstance(error, FreebodyError):
            raise
        return None
    return numbers if all(map(math.isfinite, numbers)) else None


def _replayed(tape: Tape, scalars: Sequence[Scalar], state: State) -> list[float] | None:
    """Return recorded scalars with the numbers of a state."""
    model = state.model
    values = {"t": state.t, **dict(zip(model.coordinate_names, state.q, strict=True))}
    values |= dict(zip(model.speed_names, state.u, strict=True))
    values |= {p.name: state.values[p.symbol] for p in model.parameters}
    inputs = {name: float(values[name]) for name in tape.inputs}
    try:
        return [float(x) for x in tape.evaluate(list(scalars), inputs)]
    except (ArithmeticError, ValueError):
        return [math.nan for _ in scalars]


def _equal(a: Sequence[float], b: Sequence[float]) -> bool:
    size = 1 + max(map(abs, (*a, *b)), default=0)
    return all(abs(x - y) <= ROUND_OFF * size for x, y in zip(a, b, strict=True))


def _shown(values: Sequence[float]) -> str:
    return f"({', '.join(f'{x:.6g}' for x in values)})"


def _line(part: Part, question: Callable[..., Any]) -> str:
    return line_of(None, question)
