"""Contacts in the symbolic equations: a machine in given modes, and the forces of its contacts on a free body."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import sympy

from ...dynamics.constraints import Linearized, rows, slip_friction
from ...dynamics.contact import touch
from ...dynamics.kinematics import Spot
from ...errors import ModelError
from ...model.contact import Touching, in_modes
from ...model.model import Model
from ...scalar.algebra import ZERO, add, dot, negate, scale
from .reaction import Reaction

if TYPE_CHECKING:
    from ..equations import Equations
    from .free_body import Action


def model_in_modes(model: Model, modes: Mapping[str, Any] | None) -> Model:
    """The machine in modes; with None the machine with all contacts open."""
    if modes is None:
        return model
    if not isinstance(modes, Mapping):
        raise ModelError(f'Expected modes by contact, such as {{"floor": "stick"}}, got {modes!r}.')
    return in_modes(model, modes)


def modes_of(model: Model) -> dict[str, str]:
    """The mode of every contact, in a word: open, stick or slip."""
    result = {contact.name: "open" for contact in model.contacts}
    for name, one in model.constraints.items():
        if isinstance(one, Touching):
            result[name] = "slip" if one.slips else "stick"
            if one.direction in ((1,), (-1,)):
                result[name] += "+" if one.direction == (1,) else "-"
    return result


def contact_actions(e: Equations, body: str, touching: Touching, row: Any, value: Any) -> list[Action]:
    """Forces of one row of a contact on a body: N or T, and sliding friction as a multiple of N."""
    from .free_body import Action

    model, state, contact = e.model, e.state, touching.contact
    it = touch(model, state, contact)
    if contact.feature.body.name == body:
        spot, sign, other = Spot(contact.feature.body, it.on_feature), 1, contact.surface.body
    elif contact.surface.body.name == body:
        spot, sign, other = Spot(contact.surface.body, it.on_surface), -1, contact.feature.body
    else:
        return []
    by = f"contact '{contact.name}', {other.name}"
    along = (
        it.normal if row.name == contact.normal_name else it.tangents[contact.tangent_names.index(row.name)]
    )
    result = [Action(row.name, "reaction", scale(sign * value, along), ZERO, spot.position, by)]
    if touching.slips and not contact.frictionless:
        force = scale(value, slip_friction(model, state, touching))
        # in 3-D both tangential components stand on one line
        name = contact.tangent_names[0] if contact.tangents == 1 else contact.normal_name.replace("N", "T", 1)
        result.append(Action(name, "friction", force if sign > 0 else negate(force), ZERO, spot.position, by))
    return result


def sliding_friction(e: Equations) -> dict[str, tuple[Any, Any, str]]:
    """(symbol, value -μ N d, contact) of each component of friction where a contact slips, by its name."""
    result = {}
    for row, value in zip(rows(e.model), e.canonical_multipliers, strict=True):
        touching = e.model.constraints[row.owner]
        if not isinstance(touching, Touching) or not touching.slips or touching.contact.frictionless:
            continue
        force = scale(value, slip_friction(e.model, e.state, touching))
        tangents = touch(e.model, e.state, touching.contact).tangents
        for name, t in zip(touching.contact.tangent_names, tangents, strict=True):
            result[name] = (sympy.Symbol(name, real=True), dot(force, t), row.owner)
    return result


def contact_reaction(e: Equations, touching: Touching) -> Reaction:
    """Force of a closed contact on its feature, in its unknowns."""
    contact = touching.contact
    force, parts = ZERO, {}
    for row, symbol in zip(rows(e.model), e.multipliers, strict=True):
        if row.owner != contact.name:
            continue
        value = e.ring.generator(symbol, "reaction")
        parts[row.name] = e.displayed(value)
        for action in contact_actions(e, contact.feature.body.name, touching, row, value):
            force = add(force, action.force)
            if action.kind == "friction":
                along = touch(e.model, e.state, contact).tangents
                for name, t in zip(contact.tangent_names, along, strict=True):
                    parts[name] = e.displayed(dot(action.force, t))
    return Reaction(
        joint=contact.name,
        force=e.column(force),
        moment=e.column(ZERO),
        on=contact.feature.body.name,
        about="the point of contact",
        frame="ground",
        components=parts,
    )


def sticking_only(conditions: Linearized, what: str) -> None:
    """Refuse what rests on forces along their own conditions, which sliding friction is not.

    Raises
    ------
    ModelError
        A contact that slips with friction.
    """
    names = [one.contact.name for _, one in conditions.touching if one.slips and not one.contact.frictionless]
    if names:
        raise ModelError(
            f"{what} is not offered while contact '{names[0]}' slips with friction: its force does not act along its "
            f"condition. Let it stick or be open, or ask equations(...) and simulate."
        )
