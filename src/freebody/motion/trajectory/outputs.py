"""Outputs of a motion: quantities over time, and single numbers for the whole run such as a greatest value."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any

import numpy as np
import sympy

from ...dynamics.motion import transmitting
from ...errors import ExpressionError, SimulationError, nearest
from ...model import Model
from ...model.family import contact_named, meant_contact
from ...scalar.algebra import Expression, Scalar, dot

ENERGIES = ("kinetic_energy", "potential_energy", "energy", "work", "work_rate")
"""Outputs that are no expressions of the machine's names: energies of all bodies [J], and the rate of ``work`` [W]."""
REDUCTIONS = ("max", "min", "initial", "final", "range")
"""Numbers of a quantity for the whole run: located to the accuracy of the run, not picked from the output times."""
AT_ENDS = ("initial", "final")
"""Those that need no search."""
OF_CONTACTS = ("gap", "approach", "normal", "tangential", "slip", "margin", "mode")
"""Quantities of a contact, written ``"floor.gap"``; names and units are those of a trajectory's contacts."""
CONTACT_MODES = ("open", "stick", "slip+", "slip-", "slip")
"""Contact modes; results hold their indices."""
TIMELINE = "modes"
"""Output that holds the contact modes with their start and end times."""
AXES = "xyz"
_REACTION = re.compile(r"(.+)\.(force|moment)(?:\.([xyz]))?\Z", re.DOTALL)
_QUANTITY = re.compile(
    rf"(?<![\w.])([^\W\d]\w*(?:\[[^\[\]]*\]\w*)?)\.({'|'.join(OF_CONTACTS)})(?:\.\d+)?(?![\w.])"
)
_CALL = re.compile(r"\s*(\w+)\s*\((.*)\)\s*\Z", re.DOTALL)


@dataclass(frozen=True)
class OfContact:
    """A quantity of the contact with the name ``contact``; for vectors in space, one ``component``."""

    contact: str
    what: str
    component: int = 0

    def unit(self, model: Model) -> str:
        """Return its unit."""
        found = contact_named(model, self.contact)
        assert found is not None, self.contact
        return found.units.get(self.what, "")


@dataclass(frozen=True)
class OfReaction:
    """A quantity of the reaction of a joint: a ``component`` of its ``what``, "force" or "moment", on the child in
    ground axes; without ``component``, its magnitude.
    """

    joint: str
    what: str
    component: int | None = None

    @property
    def unit(self) -> str:
        """Its unit."""
        return "N" if self.what == "force" else "N m"

    def of(self, vector: Sequence[Scalar], sqrt: Callable[[Scalar], Scalar]) -> Scalar:
        """Return the quantity of a force or moment."""
        return sqrt(dot(vector, vector)) if self.component is None else vector[self.component]


Quantity = Expression | OfContact | OfReaction
"""What an output is: an expression, the name of an energy, a quantity of a contact or of a reaction."""


@dataclass(frozen=True)
class Output:
    """Outputs of a motion, or of every lane of a batch.

    ``timed``            names of the quantities over time; ``timed_values`` are their expressions
    ``reduced``          distinct quantities with single numbers; ``reduced_values`` are their expressions
    ``numbers``          name -> (reduction, index among ``reduced``)
    ``timeline``         True if the contact modes are kept, with their start and end times
    """

    timed: tuple[str, ...]
    timed_values: tuple[Quantity, ...]
    reduced: tuple[str, ...]
    reduced_values: tuple[Quantity, ...]
    numbers: Mapping[str, tuple[str, int]]
    timeline: bool = False

    @property
    def values(self) -> tuple[Quantity, ...]:
        """All quantities: expressions, energies by name, quantities of contacts and reactions."""
        return (*self.timed_values, *self.reduced_values)

    @property
    def searches(self) -> bool:
        """True if a quantity is sought between the ends of a motion."""
        return any(how not in AT_ENDS for how, _ in self.numbers.values())

    def is_mode(self, name: str) -> bool:
        """Return True if an output is a contact mode, stored as its index in `CONTACT_MODES`."""
        value = (
            self.timed_values[self.timed.index(name)]
            if name in self.timed
            else self.reduced_values[self.numbers[name][1]]
        )
        return isinstance(value, OfContact) and value.what == "mode"

    def number(self, name: str, reduced: Any) -> Any:
        """Return a number for every lane, from (lanes, quantities, 4) greatest, smallest, first and last values."""
        how, place = self.numbers[name]
        greatest, smallest, first, last = np.moveaxis(reduced[:, place], -1, 0)
        return {
            "max": greatest, "min": smallest, "initial": first, "final": last, "range": greatest - smallest,
        }[how]  # fmt: skip


def outputs_of(model: Model, outputs: Any, timeline: bool = False) -> Output:
    """Return the outputs that an argument ``outputs=`` names.

    None stands for all coordinates and speeds, and the contact modes if there is a ``timeline`` of them.

    Parameters
    ----------
    outputs : name, expression, text, sequence of them, or mapping of name to them
        ``"theta"``, ``"L*sin(theta)"``, ``"kinetic_energy"``, ``"max(theta)"``, ``"floor.normal"`` or
        ``"N_floor"``, ``"floor.slip"``, ``"pin"``, ``"pin.force.y"``, ``"pin.moment"``, ``"modes"``.

    Raises
    ------
    SimulationError
        An unknown name, with the nearest known one; one name for two outputs.
    """
    if outputs is None:
        outputs = [*model.state_names, *([TIMELINE] if timeline else [])]
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
    has_timeline = False
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
            has_timeline = True
            continue
        how, inside = reduction(value)
        parts = quantity_of(model, inside)
        if parts and not how:
            for last, part in parts.items():
                timed[f"{name}{last}"] = part
            continue
        expression = (
            _single_component(parts, how, name, inside) if parts else _expression(model, inside, name)
        )
        if how:
            _, place = reduced.setdefault(expression, (str(inside), len(reduced)))
            numbers[name] = (how, place)
        else:
            timed[name] = expression
    return Output(
        tuple(timed), tuple(timed.values()), tuple(text for text, _ in reduced.values()), tuple(reduced), numbers,
        has_timeline,
    )  # fmt: skip


def reduction(value: Any) -> tuple[str, Any]:
    """Return ("max", "theta") for "max(theta)", and ("", value) for a value that is no reduction."""
    call = _CALL.match(value) if isinstance(value, str) else None
    if call is None or call[1] not in REDUCTIONS:
        return "", value
    depth = 0
    for letter in call[2]:
        depth += (letter in "([") - (letter in ")]")
        if depth < 0 or (letter == "," and depth == 0):
            return "", value  # max(a, b), or max(a) + (b)
    return call[1], call[2].strip()


def quantity_of(model: Model, value: Any, where: str = "") -> Mapping[str, OfContact | OfReaction]:
    """Return the quantities of a contact or of a reaction that a text names; empty for other values.

    ``where`` says in errors what names it, if it is no output.
    """
    return _of_contact(model, value, where or f"output '{value}'") or _of_reaction(model, value)


def force_named(model: Model, name: str) -> tuple[str, str, int] | None:
    """Return contact, quantity and component of a force by its own name, such as "N_floor"; None for other names."""
    for contact in model.contacts:
        if name == contact.normal_name:
            return contact.name, "normal", 0
        if name in contact.tangent_names:
            return contact.name, "tangential", contact.tangent_names.index(name)
    return None


def _of_contact(model: Model, value: Any, where: str) -> Mapping[str, OfContact]:
    """Return the components of the quantity of a contact that a text names, by what is added to the text: ".1" and
    ".2", or nothing if there is one; empty for other values. "N_floor" is "floor.normal", and "T_floor" likewise.
    """
    if not isinstance(value, str):
        return {}
    text = value.strip()
    force = force_named(model, text)
    if force is not None:
        return {"": OfContact(*force)}
    name, _, what = text.rpartition(".")
    component = None
    if what.isdigit():
        component = int(what) - 1
        name, _, what = name.rpartition(".")
    if not name:
        return {}
    found = contact_named(model, name)
    if found is None or what not in OF_CONTACTS:
        _refuse_expressions(model, text, where)
    if what not in OF_CONTACTS:
        if found is not None:
            raise SimulationError(
                f"Unknown quantity '{what}' of contact '{name}'; {nearest(what, OF_CONTACTS)}"
            )
        return {}
    if found is None:
        raise SimulationError(f"Unknown contact '{name}' in {where}; {meant_contact(model, name)}")
    k, count = found.name, found.tangents if what in ("tangential", "slip") else 1
    if count == 0:
        raise SimulationError(
            f"Expected a contact with tangents for '{value}', but '{name}' has none: nothing slips there. Its "
            f"quantities are {', '.join(x for x in OF_CONTACTS if x not in ('tangential', 'slip', 'margin'))}."
        )
    if component is not None and not (count > 1 and 0 <= component < count):
        last = f"a component from 1 to {count}" if count > 1 else f"'{name}.{what}', which has no components"
        raise SimulationError(f"Expected {last}, got the output '{value}'.")
    if component is not None or count == 1:
        return {"": OfContact(k, what, component or 0)}
    return {f".{i + 1}": OfContact(k, what, i) for i in range(count)}


def _refuse_expressions(model: Model, text: str, where: str) -> None:
    """Raise for an expression in which a quantity of a contact is a part."""
    for part in _QUANTITY.finditer(text):
        if part[0] != text and contact_named(model, part[1]) is not None:
            raise SimulationError(
                f"Expected '{part[0]}' by itself in {where}: outputs take no expressions of quantities of contacts. "
                "Ask for it, and compute with its numbers; events take such expressions."
            )


def _of_reaction(model: Model, value: Any) -> Mapping[str, OfReaction]:
    """Return the quantities of a reaction that a text names, by what is added to the text: "pin" is the magnitude of
    the force, "pin.moment.z" a component, and "pin.force" has three, ".x", ".y" and ".z"; empty for other values.
    """
    if not isinstance(value, str) or value in model.names.atoms:
        return {}
    joints = {name for name, *_ in transmitting(model)}
    text = value.strip()
    if text in joints:
        return {"": OfReaction(text, "force")}
    found = _REACTION.match(text)
    if found is None or found[1] not in joints:
        return {}
    joint, what, axis = found.groups()
    if axis:
        return {"": OfReaction(joint, what, AXES.index(axis))}
    return {f".{axis}": OfReaction(joint, what, i) for i, axis in enumerate(AXES)}


def _single_component(parts: Mapping[str, Quantity], how: str, name: str, inside: str) -> Quantity:
    """Return the quantity of a contact or a reaction that a reduction takes."""
    first, *others = parts.items()
    if others:
        raise SimulationError(
            f"Expected one component in '{name}', but '{inside}' is a vector in space: ask for "
            f"'{how}({inside}{first[0]})'."
        )
    value = first[1]
    if isinstance(value, OfContact) and value.what == "mode" and how not in AT_ENDS:
        raise SimulationError(
            f"Expected initial() or final() of a mode, got '{name}': modes have no greatest and no smallest one."
        )
    return value


def _expression(model: Model, value: Expression, name: str) -> Expression:
    """Return the expression of an output, or the name of an energy."""
    if isinstance(value, str) and value in ENERGIES and value not in model.names.atoms:
        return value
    try:
        return model.names.expression(value, f"output '{name}'")
    except ExpressionError as error:
        near = get_close_matches(value, ENERGIES, n=1) if isinstance(value, str) else []
        more = f" Did you mean '{near[0]}'?" if near else ""
        raise SimulationError(
            "Expected a coordinate, a speed, an energy or an expression of them for an output, a joint for the size of "
            "its force, or "
            f"{', '.join(f'{how}(...)' for how in REDUCTIONS)} of one. {error}{more}"
        ) from None
