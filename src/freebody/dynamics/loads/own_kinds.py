"""What a user's kind of load or contact promises, checked once in a model: its code is a formula of the state.

Recorded twice, the same state gives the same scalars; replayed with numbers, what was recorded is what the code answers
to these numbers; the gradient of a potential is the force; and what depends on accelerations is added mass. Points that
have no values are passed over.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from fractions import Fraction
from numbers import Real
from typing import Any

import numpy as np

from ...describe.loads.action import Action, Couple, PointForce
from ...describe.loads.load import Load
from ...describe.part import Part, line_of
from ...errors import FreebodyError, ModelError, shown
from ...model.model import Model
from ...scalar.algebra import Scalar, floats
from ...scalar.trace import Tape, Traced
from ...space.spatial import Spatial
from ..kinematics import replaced
from ..state import State, rest_coordinates, traced_state
from .power import power_in, virtual_powers

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


def check_inertia(model: Model, load: Load, question: Callable[..., Any], act: Act) -> None:
    """Refuse a load of accelerations that is not F_0(q, u, t) - B(q, t) A with a symmetric B.

    At random accelerations x and y of all links B (x + y) = B x + B y, B is the same at other speeds, and the powers
    y·B x and x·B y are equal.
    """
    if load.is_conservative:
        raise ModelError(
            f"{load.heading} has a potential, and its force depends on accelerations {_line(load, question)}. Make two "
            f"loads of it: one with the potential, and one for the added mass, whose energy is counted by itself."
        )
    rng, size = np.random.default_rng(model.n_q), (len(model.links), 2, 3)
    for state in _states(model):
        x, y = rng.normal(size=size), rng.normal(size=size)
        faster = replaced(state, state.field, state.t, state.q, rng.normal(size=model.n_u).tolist())
        try:
            asked = [act(state.accelerated(_spatial(A))) for A in (0 * x, x, y, x + y)]
            asked += [act(faster.accelerated(_spatial(A))) for A in (0 * x, x)]
            why = _no_inertia(model, state, asked, (_spatial(x), _spatial(y)))
        except (ArithmeticError, ValueError):
            continue
        if why:
            raise ModelError(
                f"{load.heading}: {why} {_line(load, question)}. Accelerations stand in a load as added mass, "
                f"F = F_0 - B A: B depends on positions and time alone and is symmetric, as in "
                f"fb.PointForce(point, -m * at.acceleration(point)). Feedback of a measured acceleration is "
                f"s.controller(...); inertia along a joint is its armature=."
            )


def _no_inertia(
    model: Model, state: State, asked: Sequence[Sequence[Action]], trials: tuple[list[Spatial], list[Spatial]]
) -> str:
    """Return why actions are no added mass, or nothing; they are those at A = 0, x, y, x + y, and 0, x when faster."""
    x, y = trials
    pairs = [
        pair for pair in zip(asked[0], asked[1], strict=True) if not isinstance(pair[0], PointForce | Couple)
    ]
    along = [values_of([action for pair in pairs for action in pair[k : k + 1]]) for k in range(2)]
    values = [np.array(values_of(found), float) for found in asked]
    largest = [*map(abs, np.concatenate(values))]
    if not np.isfinite(largest).all():
        return ""
    base, of_x, of_y, of_both, fast, fast_x = values
    if not _equal(*along):
        return "a force along a joint or on a coordinate depends on accelerations"
    if not _equal(of_both - of_x, of_y - base, largest):
        return "its force is not linear in the accelerations"
    if not _equal(fast_x - fast, of_x - base, largest):
        return "the factor of an acceleration in it depends on the speeds"
    y_of_x, y_of_0, x_of_y, x_of_0 = (
        [float(power_in(model, state, a, A)) for a in asked[k] if isinstance(a, PointForce | Couple)]
        for k, A in ((1, y), (0, y), (2, x), (0, x))
    )
    if not _equal(
        [sum(y_of_x) - sum(y_of_0)], [sum(x_of_y) - sum(x_of_0)], [*y_of_x, *y_of_0, *x_of_y, *x_of_0]
    ):
        return "an acceleration of one point or body has a force on another that has none on the first"
    return ""


def _spatial(rows: Any) -> list[Spatial]:
    return [((a, b, c), (d, e, f)) for (a, b, c), (d, e, f) in rows.tolist()]


def values_of(acting: Iterable[Action]) -> list[Scalar]:
    """Return all components and values of actions."""
    result: list[Scalar] = []
    for action in acting:
        match action:
            case PointForce():
                result += action.force
            case Couple():
                result += action.moment
            case _:
                result.append(action.value)
    return result


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


def _equal(a: Sequence[float], b: Sequence[float], terms: Sequence[float] = ()) -> bool:
    """Return True if numbers differ by no more than round-off of the ``terms`` of which they are sums."""
    size = 1 + max(map(abs, (*a, *b, *terms)), default=0)
    return all(abs(x - y) <= ROUND_OFF * size for x, y in zip(a, b, strict=True))


def _shown(values: Sequence[float]) -> str:
    return f"({', '.join(f'{x:.6g}' for x in values)})"


def _line(part: Part, question: Callable[..., Any]) -> str:
    return line_of(None, question)
