"""Conditions on which loads switch (``at.where``), as events that every motion locates."""

from __future__ import annotations

from dataclasses import dataclass

from ...dynamics import State, traced_state
from ...dynamics.loads.actions import conditions
from ...model import Model
from ...scalar.algebra import Expression, Scalar
from ...scalar.trace import Tape, Traced


@dataclass(frozen=True)
class Switch:
    """A condition of a load on which it switches, by its number; it stands where an expression may."""

    load: str
    number: int

    def __str__(self) -> str:
        return f"condition {self.number + 1} of {self.load}"


def value_of(state: State, expression: Expression | Switch) -> Scalar:
    """Return the value of an expression, or of a condition of a load."""
    if isinstance(expression, Switch):
        return conditions(state.model, state, expression.load)[expression.number]
    return state(expression)


def switches(model: Model) -> tuple[Switch, ...]:
    """Return the places at which loads switch, known before any motion."""
    if "switches" not in model.memo:
        state = traced_state(model, Tape())
        model.memo["switches"] = tuple(
            Switch(name, k)
            for name in model.loads
            for k, x in enumerate(conditions(model, state, name))
            if isinstance(x, Traced)
        )
    return model.memo["switches"]
