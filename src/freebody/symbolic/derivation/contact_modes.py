"""Contact modes of the machine whose equations are derived."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...dynamics.conditions.linearized import Linearized
from ...errors import ModelError
from ...model.contact_modes import Pressing, Sliding, Touching, in_modes
from ...model.model import Model


def model_in_modes(model: Model, modes: Mapping[str, Any] | None) -> Model:
    """Return the model with its contacts in the given modes; with None, the model itself, all contacts open."""
    if modes is None:
        return model
    if not isinstance(modes, Mapping):
        raise ModelError(f'Expected modes by contact, such as {{"floor": "stick"}}, got {modes!r}.')
    return in_modes(model, modes)


def check_modes_are_chosen(model: Model, question: str) -> None:
    """Refuse a machine with contacts whose modes were not chosen: its contacts are neither closed nor said to be open.

    Raises
    ------
    ModelError
        With the call that chooses the modes.
    """
    if model.families:
        raise ModelError(
            f"Expected contacts by s.contact for {question}, got the family '{model.families[0].name}' of "
            f"'{model.name}', whose contacts are those of a motion. Describe those that are closed by s.contact, or "
            "leave the family out."
        )
    if not model.contacts or any(
        isinstance(x, Touching | Sliding | Pressing)
        for x in (*model.constraints.values(), *model.loads.values())
    ):
        return
    first = {c.owner: c for c in reversed(model.contacts)}
    modes = {
        c.name if c.law is not None and c.law.one_at_a_time else owner: c.slipping
        if c.frictionless
        else "stick"
        for owner, c in reversed(first.items())
    }
    raise ModelError(
        f"Expected the modes of the contacts for {question}, got '{model.name}' without any. Pass its equations in "
        f'place of the system: {question}(fb.equations(s, modes={modes}), ...); "open" leaves a contact out.'
    )


def modes_of(model: Model) -> dict[str, str]:
    """Mode of every contact by its name: "open", "stick", "slip", "slip+" or "slip-"."""
    result = {contact.name: "open" for contact in model.contacts}
    for name, constraint in model.constraints.items():
        if isinstance(constraint, Touching):
            result[name] = constraint.contact.slipping if constraint.slips else "stick"
            if constraint.direction in ((1,), (-1,)):
                result[name] += "+" if constraint.direction == (1,) else "-"
    for contact in model.contacts:
        pressed = isinstance(model.loads.get(contact.normal_name), Pressing)
        if contact.held and contact.name not in model.constraints:
            load = model.loads.get(contact.friction_name) if contact.tangents else None
            if isinstance(load, Sliding):
                result[contact.name] = {(1,): "slip+", (-1,): "slip-"}.get(load.direction, "slip")
            elif pressed:
                result[contact.name] = contact.slipping
    return result


def modes_in_words(model: Model) -> str:
    """Contacts and their modes in one line, such as ``floor stick, wall open``."""
    return ", ".join(f"{name} {mode}" for name, mode in modes_of(model).items())


def sticking_only(conditions: Linearized, what: str) -> None:
    """Refuse a method that needs every contact force to act along its own condition, as sliding friction does not.

    Raises
    ------
    ModelError
        A contact that slips with friction.
    """
    names = [
        touching.contact.name
        for _, touching in conditions.touching
        if touching.slips and not touching.contact.frictionless
    ]
    if names:
        raise ModelError(
            f"{what} is not offered while contact '{names[0]}' slips with friction: its force does not act along its "
            f"condition. Let it stick or be open, or ask equations(...) and simulate."
        )
