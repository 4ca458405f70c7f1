"""Gears in the free-body equations: radial forces of the teeth, and reactions that a gear leaves undetermined.

    F_r = tan(alpha) |F_t|        positive where the teeth push each other apart

The tangential force F_t is the gear's multiplier. The radial force does no work; it is undetermined without a pressure
angle.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import sympy

from ...dynamics.conditions.constraints import radial_names, rows, separating_force
from ...dynamics.conditions.indeterminate import joints_between
from ...scalar.algebra import Scalar, Vector, scale
from ..derivation.derivation import Derivation


def radial_symbols(e: Derivation) -> dict[str, sympy.Symbol]:
    """Symbol of the radial force of each gear whose pitch point is known, by the gear's name."""
    return {gear: sympy.Symbol(name, real=True) for gear, name in radial_names(e.model).items()}


def radial_forces(e: Derivation, gear: str) -> list[tuple[Any, Vector, Vector]]:
    """(point, force, moment) of the radial force of a gear on its two bodies, by its symbol."""
    value = e.ring.generator(radial_symbols(e)[gear], "reaction")
    pair, _ = separating_force(e.model, e.state, e.model.constraints[gear])
    return [(point, scale(value, force), scale(value, moment)) for point, force, moment in pair]


def radial_law(e: Derivation, gear: str) -> Scalar | None:
    """Radial force by the multiplier, canonical; None if the pressure angle is not known."""
    _, size = separating_force(e.model, e.state, e.model.constraints[gear])
    if size is None:
        return None
    (value,) = (x for row, x in zip(rows(e.model), e.canonical_multipliers, strict=True) if row.owner == gear)
    return size * e.ring.apply("abs", value)


def radial_laws(e: Derivation, gears: Iterable[str]) -> list[tuple[Scalar, Scalar]]:
    """(left, right) of the laws of the radial forces of these gears, canonical."""
    symbols = radial_symbols(e)
    laws = {gear: radial_law(e, gear) for gear in symbols if gear in gears}
    return [(e.ring.generator(symbols[g], "reaction"), x) for g, x in laws.items() if x is not None]


def undetermined_by_gears(
    e: Derivation, joint: str | None = None, body: str | None = None, *, radial: bool = True
) -> list[str]:
    """Sentences on the reactions of a joint, or of the joints of a body, that gears leave undetermined.

    Without ``radial``, sentences on radial forces are omitted: there the radial force is an unknown of its own.
    """
    model = e.model
    joints = {
        name for name, place in model.joints.items() if name == joint or body in (place.parent, place.child)
    }
    names = radial_names(model)
    sentences = []
    for gear, mesh in model.meshes.items():
        constraint = model.constraints[gear]
        if isinstance(mesh, str):
            between = [name for name in joints_between(model, constraint) if name in joints]
            if between:
                sentences.append(
                    f"undetermined: how much of {', '.join(between)} the joint bears and how much the teeth of gear "
                    f"'{gear}', of which only the ratio is known: {mesh}"
                )
        elif (
            radial
            and constraint.pressure_angle is None
            and joints & {constraint.first.name, constraint.second.name}
        ):
            sentences.append(
                f"undetermined: {names[gear]}, which presses the teeth of gear '{gear}' apart; its pressure_angle "
                f"determines it"
            )
    return sentences
