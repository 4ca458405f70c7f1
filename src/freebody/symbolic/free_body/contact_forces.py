"""Forces of closed contacts: on a free body, as reactions, and the friction of contacts that slip."""

from __future__ import annotations

import sympy

from ...dynamics.conditions.constraints import (
    Row,
    closed_forces,
    friction_of_slip,
    rows,
    slip_direction,
    slip_friction,
)
from ...dynamics.conditions.contact import touch, wrench_on_feature
from ...dynamics.kinematics import Spot
from ...model.contact_modes import Touching
from ...scalar.algebra import ZERO, Scalar, add, negate, scale
from ..derivation.derivation import Derivation
from .action import Action
from .reaction import Reaction


def contact_actions(e: Derivation, body: str, touching: Touching, row: Row, value: Scalar) -> list[Action]:
    """Forces of one condition of a contact on a body: N or T, and sliding friction as a multiple of N."""
    model, state, contact = e.model, e.state, touching.contact
    geometry = touch(model, state, contact)
    if contact.feature.body.name == body:
        spot, sign, other = Spot(contact.feature.body, geometry.on_feature), 1, contact.surface.body
    elif contact.surface.body.name == body:
        spot, sign, other = Spot(contact.surface.body, geometry.on_surface), -1, contact.feature.body
    else:
        return []
    by = f"contact '{contact.name}', {other.name}"
    direction = (
        geometry.normal
        if row.name == contact.normal_name
        else geometry.tangents[contact.tangent_names.index(row.name)]
    )
    result = [Action(row.name, "reaction", scale(sign * value, direction), ZERO, spot.position, by)]
    if touching.slips and not contact.frictionless:
        force = scale(value, slip_friction(model, state, touching))
        # in 3-D one action has both tangential components
        result.append(
            Action(
                contact.friction_name,
                "friction",
                force if sign > 0 else negate(force),
                ZERO,
                spot.position,
                by,
            )
        )
    return result


def sliding_friction(e: Derivation) -> dict[str, tuple[sympy.Symbol, Scalar, str]]:
    """(symbol, value -μ N d, contact) of each friction component of the slipping contacts, by its name."""
    result = {}
    for row, value in zip(rows(e.model), e.canonical_multipliers, strict=True):
        touching = e.model.constraints[row.owner]
        if not isinstance(touching, Touching) or not touching.slips or touching.contact.frictionless:
            continue
        if not touching.contact.held and row.name != touching.contact.normal_name:
            continue
        mu = friction_of_slip(e.model, e.state, touching)
        along = slip_direction(e.model, e.state, touching)
        for name, d in zip(touching.contact.tangent_names, along, strict=True):
            result[name] = (sympy.Symbol(name, real=True), -(mu * value * d), row.owner)
    return result


def contact_reaction(e: Derivation, touching: Touching) -> Reaction:
    """Force of a closed contact on its feature, by its unknown components."""
    contact, model, state = touching.contact, e.model, e.state
    force, moment, parts = ZERO, ZERO, {}
    own = [
        (row, symbol)
        for row, symbol in zip(rows(model), e.multipliers, strict=True)
        if row.owner == contact.name
    ]
    for (row, symbol), acting in zip(own, closed_forces(model, state, touching), strict=True):
        value = e.ring.generator(symbol, "reaction")
        parts[row.name] = e.displayed(value)
        if touching.slips and not contact.frictionless:
            mu = friction_of_slip(model, state, touching)
            for name, d in zip(contact.tangent_names, slip_direction(model, state, touching), strict=True):
                parts[name] = e.displayed(-(mu * value * d))
        f, n = wrench_on_feature(model, state, contact, acting)
        force, moment = add(force, scale(value, f)), add(moment, scale(value, n))
    return Reaction(
        joint=contact.name,
        force=e.column(force),
        moment=e.column(moment),
        on=contact.feature.body.name,
        about="the point of contact",
        frame="ground",
        components=parts,
    )
