"""Forces of closed contacts: on a free body, as reactions, and the friction of contacts that slip."""

from __future__ import annotations

import sympy

from ...dynamics.conditions.constraint_forces import closed_forces, friction_along_tangents, slip_friction
from ...dynamics.conditions.constraints import Row, rows
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
        force = scale(value + state(contact.adhesion), slip_friction(model, state, touching))
        # in 3-D one action has both tangential components
        force = force if sign > 0 else negate(force)
        result.append(Action(contact.friction_name, "friction", force, ZERO, spot.position, by))
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
        shares = friction_components(e, touching, value)
        for name, share in zip(touching.contact.tangent_names, shares, strict=True):
            result[name] = (sympy.Symbol(name, real=True), share, row.owner)
    return result


def friction_components(e: Derivation, touching: Touching, N: Scalar) -> list[Scalar]:
    """Return the components of the friction of a slip under the normal force N."""
    return friction_along_tangents(e.model, e.state, touching, N + e.state(touching.contact.adhesion))


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
            shares = friction_components(e, touching, value)
            for name, share in zip(contact.tangent_names, shares, strict=True):
                parts[name] = e.displayed(share)
            # the condition has the friction of N
            force = add(force, scale(state(contact.adhesion), slip_friction(model, state, touching)))
        f, n = wrench_on_feature(model, state, contact, acting)
        force, moment = add(force, scale(value, f)), add(moment, scale(value, n))
    on = contact.feature.body.name
    return Reaction.of(e, contact.name, (force, moment), on, "the point of contact", parts)
