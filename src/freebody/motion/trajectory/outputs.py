"""What is asked of each lane of a batch: quantities over time, and single numbers such as a greatest value."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any

import numpy as np
import sympy

from ...errors import ExpressionError, SimulationError, nearest
from ...model import Model

ENERGIES = ("kinetic_energy", "potential_energy", "energy", "work", "work_rate")
"""Outputs that are no expressions of the machine's names: of all bodies [J], and the power behind ``work`` [W]."""
REDUCTIONS = ("max", "min", "initial", "final", "range")
"""Of a quantity over the whole run: located to the accuracy of the run, not picked from the output times."""
OF_CONTACTS = ("gap", "normal", "tangential", "slip", "margin", "mode")
"""Quantities of a contact, asked for as ``"floor.gap"``; names and units are those of a trajectory's contacts."""
CONTACT_MODES = ("open", "stick", "slip+", "slip-", "slip")
"""Modes of a contact; their places are their numbers in results."""
TIMELINE = "modes"
"""Output that holds the modes of all contacts from when to when."""
_CALL = re.compile(r"\s*(\w+)\s*\((.*)\)\s*\Z", re.DOTALL)


@dataclass(frozen=True)
class OfContact:
    """A quantity of contact number ``contact``; of vectors in space one ``component``."""

    contact: int
    what: str
    component: int = 0


@dataclass(frozen=True)
class Output:
    """Outputs of a batch.

    ``timed``            names of the quantities over time; ``timed_values`` are their expressions
    ``reduced``          distinct quantities of which single numbers are asked; ``reduced_values`` are their expressions
    ``numbers``          name -> (reduction, place among ``reduced``)
    ``timeline``         whether the modes of contacts are kept, from when to when
    """

    timed: tuple[str, ...]
    timed_values: tuple[Any, ...]
    reduced: tuple[str, ...]
    reduced_values: tuple[Any, ...]
    numbers: Mapping[str, tuple[str, int]]
    timeline: bool = False

    @property
    def values(self) -> tuple[Any, ...]:
        """Everything asked for: expressions, energies by name, quantities of contacts."""
        return (*self.timed_values, *self.reduced_values)

    def is_mode(self, name: str) -> bool:
        """Whether the output of this name is the mode of a contact, kept by its place in `CONTACT_MODES`."""
        value = (
            self.timed_values[self.timed.index(name)]
            if name in self.timed
            else self.reduced_values[self.numbers[name][1]]
        )
        return isinstance(value, OfContact) and value.what == "mode"

    def number(self, name: str, reduced: Any) -> Any:
        """The number of this name in every lane, from (lanes, quantities, 4) greatest, smallest, first, last."""
        how, place = self.numbers[name]
        greatest, smallest, first, last = np.moveaxis(reduced[:, place], -1, 0)
        return {
            "max": greatest, "min": smallest, "initial": first, "final": last, "range": greatest - smallest,
        }[how]  # fmt: skip


def outputs_of(model: Model, outputs: Any, timeline: bool = False) -> Output:
    """What the user asks for; all coordinates and speeds if nothing, and the modes of contacts if there is a
    ``timeline`` of them.

    Parameters
    ----------
    outputs : name, expression, text, sequence of them, or mapping of name to them
        ``"theta"``, ``"L*sin(theta)"``, ``"kinetic_energy"``, ``"max(theta)"``, ``"floor.normal"``, ``"modes"``.

    Raises
    ------
    SimulationError
        An unknown name, with the nearest; one name for two outputs.
    """
    if outputs is None:
        outputs = [*model.coordinate_names, *model.speed_names, *([TIMELINE] if timeline else [])]
    if isinstance(outputs, Mapping):
        items = [(str(name), value) for name, value in outputs.items()]
    else:
        if isinstance(outputs, str | sympy.Basic) or not isinstance(outputs, Sequence):
            outputs = [outputs]
        items = [(model.names.text_of(x), x) for x in outputs]
    if not items:
        raise SimulationError("Expected at least one output, got none.")
    timed: dict[str, Any] = {}
    reduced: dict[Any, tuple[str, int]] = {}
    numbers: dict[str, tuple[str, int]] = {}
    asked = False
    for name, value in items:
        if name in timed or name in numbers:
            raise SimulationError(
                f"The output '{name}' is asked for twice. Leave one out, or name it otherwise."
            )
        if isinstance(value, str) and value == TIMELINE and value not in model.names.atoms and model.contacts:
            if not timeline:
                raise SimulationError(
                    "method='timestepping' keeps no timeline of modes. Ask for the mode at the output times, "
                    f"'{model.contacts[0].name}.mode'."
                )
            asked = True
            continue
        how, inside = reduction(value)
        found = _of_contact(model, inside)
        if found and not how:
            for one in found:
                timed[f"{name}.{one.component + 1}" if len(found) > 1 else name] = one
            continue
        expression = _one(found, how, name, inside) if found else _expression(model, inside, name)
        if how:
            _, place = reduced.setdefault(expression, (str(inside), len(reduced)))
            numbers[name] = (how, place)
        else:
            timed[name] = expression
    return Output(
        tuple(timed), tuple(timed.values()), tuple(text for text, _ in reduced.values()), tuple(reduced), numbers,
        asked,
    )  # fmt: skip


def reduction(value: Any) -> tuple[str, Any]:
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


def _of_contact(model: Model, value: Any) -> tuple[OfContact, ...]:
    """The components of a quantity of a contact, if that is what a text names."""
    if not isinstance(value, str):
        return ()
    name, _, what = value.strip().rpartition(".")
    component = None
    if what.isdigit():
        component = int(what) - 1
        name, _, what = name.rpartition(".")
    names = [contact.name for contact in model.contacts]
    if what not in OF_CONTACTS or not name:
        return ()
    if name not in names:
        known = nearest(name, names) if names else f"'{model.name}' has no contacts."
        raise SimulationError(f"Unknown contact '{name}' in output '{value}'; {known}")
    k = names.index(name)
    count = model.contacts[k].tangents if what in ("tangential", "slip") else 1
    if component is not None and not (count > 1 and 0 <= component < count):
        last = f"a component from 1 to {count}" if count > 1 else f"'{name}.{what}', which has no components"
        raise SimulationError(f"Expected {last}, got the output '{value}'.")
    wanted = range(count) if component is None else (component,)
    return tuple(OfContact(k, what, i) for i in wanted)


def _one(found: tuple[OfContact, ...], how: str, name: str, inside: str) -> OfContact:
    """The quantity of a contact of which a number is asked."""
    if len(found) > 1:
        raise SimulationError(
            f"Expected one component in '{name}', but '{inside}' is a vector in space: ask for '{how}({inside}.1)'."
        )
    if found[0].what == "mode" and how not in ("initial", "final"):
        raise SimulationError(
            f"Expected initial() or final() of a mode, got '{name}': modes have no greatest and no smallest one."
        )
    return found[0]


def _expression(model: Model, value: Any, name: str) -> Any:
    if isinstance(value, str) and value in ENERGIES and value not in model.names.atoms:
        return value
    try:
        return model.names.expression(value, f"output '{name}'")
    except ExpressionError as error:
        near = get_close_matches(value, ENERGIES, n=1) if isinstance(value, str) else []
        more = f" Did you mean '{near[0]}'?" if near else ""
        raise SimulationError(
            "Expected a coordinate, a speed, an energy or an expression of them for an output, or "
            f"{', '.join(f'{how}(...)' for how in REDUCTIONS)} of one. {error}{more}"
        ) from None
