"""What is asked of each lane of a batch: quantities over time, and single numbers such as a greatest value."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy

from ..errors import ExpressionError, SimulationError, nearest
from ..model import Model
from .batch_kernels import ENERGIES

REDUCTIONS = ("max", "min", "initial", "final", "range")
"""Of a quantity over the whole run: located to the accuracy of the run, not picked from the output times."""
_CALL = re.compile(r"\s*(\w+)\s*\((.*)\)\s*\Z", re.DOTALL)


@dataclass(frozen=True)
class Output:
    """Outputs of a batch.

    ``timed``            names of the quantities over time; ``timed_values`` are their expressions
    ``reduced``          distinct quantities of which single numbers are asked; ``reduced_values`` are their expressions
    ``numbers``          name -> (reduction, place among ``reduced``)
    """

    timed: tuple[str, ...]
    timed_values: tuple[Any, ...]
    reduced: tuple[str, ...]
    reduced_values: tuple[Any, ...]
    numbers: Mapping[str, tuple[str, int]]

    def number(self, name: str, reduced: Any) -> Any:
        """The number of this name in every lane, from (lanes, quantities, 4) greatest, smallest, first, last."""
        how, place = self.numbers[name]
        greatest, smallest, first, last = np.moveaxis(reduced[:, place], -1, 0)
        return {
            "max": greatest, "min": smallest, "initial": first, "final": last, "range": greatest - smallest,
        }[how]  # fmt: skip


def outputs_of(model: Model, outputs: Any) -> Output:
    """What the user asks for; all coordinates and speeds if nothing.

    Parameters
    ----------
    outputs : name, expression, text, sequence of them, or mapping of name to them
        ``"theta"``, ``"L*sin(theta)"``, ``"kinetic_energy"``, ``"max(theta)"``.

    Raises
    ------
    SimulationError
        An unknown name, with the nearest; one name for two outputs.
    """
    if outputs is None:
        outputs = [*model.coordinate_names, *model.speed_names]
    if isinstance(outputs, Mapping):
        items = [(str(name), value) for name, value in outputs.items()]
    else:
        if isinstance(outputs, str | sympy.Basic) or not isinstance(outputs, Sequence):
            outputs = [outputs]
        texts = model.names.texts
        items = [(x if isinstance(x, str) else texts.get(x, str(x)), x) for x in outputs]
    if not items:
        raise SimulationError("Expected at least one output, got none.")
    timed: dict[str, Any] = {}
    reduced: dict[Any, tuple[str, int]] = {}
    numbers: dict[str, tuple[str, int]] = {}
    for name, value in items:
        if name in timed or name in numbers:
            raise SimulationError(
                f"The output '{name}' is asked for twice. Leave one out, or name it otherwise."
            )
        how, inside = _reduction(value)
        expression = _expression(model, inside, name)
        if how:
            _, place = reduced.setdefault(expression, (str(inside), len(reduced)))
            numbers[name] = (how, place)
        else:
            timed[name] = expression
    return Output(
        tuple(timed), tuple(timed.values()), tuple(text for text, _ in reduced.values()), tuple(reduced), numbers
    )  # fmt: skip


def _reduction(value: Any) -> tuple[str, Any]:
    """("max", "theta") of "max(theta)", ("", value) of what is no reduction."""
    found = _CALL.match(value) if isinstance(value, str) else None
    if found is None or found[1] not in REDUCTIONS:
        return "", value
    depth = 0
    for letter in found[2]:
        depth += (letter == "(") - (letter == ")")
        if depth < 0 or (letter == "," and depth == 0):
            return "", value  # max(a, b), or max(a) + (b)
    return found[1], found[2].strip()


def _expression(model: Model, value: Any, name: str) -> Any:
    if isinstance(value, str) and value in ENERGIES and value not in model.names.atoms:
        return value
    try:
        return model.names.expression(value, f"output '{name}'")
    except ExpressionError as error:
        known = [*model.coordinate_names, *model.speed_names, *ENERGIES]
        more = f" {nearest(value, known)}" if isinstance(value, str) and value.isidentifier() else ""
        raise SimulationError(
            f"Expected a coordinate, a speed, an energy or an expression of them for an output. {error}{more}"
        ) from None
