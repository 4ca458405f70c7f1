"""Gears in the free-body equations: radial forces of the teeth, and reactions that a mere ratio leaves undetermined.

    F_r = tan(alpha) |f|        positive where the teeth push each other apart

The force f across the teeth follows from the gear's multiplier. The radial force does no work.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import sympy

from ...dynamics.conditions.constraint_forces import separating_force
from ...dynamics.conditions.constraints import radial_names, rows
from ...dynamics.conditions.couplings import couplings
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


def radial_law(e: Derivation, gear: str) -> Scalar:
    """Radial force by the multiplier, canonical."""
    _, size = separating_force(e.model, e.state, e.model.constraints[gear])
    (value,) = (x for row, x in zip(rows(e.model), e.canonical_multipliers, strict=True) if row.owner == gear)
    return size * e.ring.apply("abs", value)


def radial_laws(e: Derivation, gears: Iterable[str]) -> list[tuple[Scalar, Scalar]]:
    """(left, right) of the laws of the radial forces of these gears, canonical."""
    symbols = radial_symbols(e)
    return [(e.ring.generator(symbols[g], "reaction"), radial_law(e, g)) for g in symbols if g in gears]


def undetermined_by_couplings(e: Derivation, joint: str | None = None, body: str | None = None) -> list[str]:
    """Sentences on the reactions of a joint, or of the joints of a body, that mere ratios leave undetermined."""
    joints = {
        name for name, place in e.model.joints.items() if name == joint or body in (place.parent, place.child)
    }
    sentences = []
    for coupling in couplings(e.model, e.state):
        between = [name for name in coupling.joints if name in joints]
        if between:
            sentences.append(
                f"undetermined: how much of {', '.join(between)} the joint bears and how much {coupling.words}, of "
                f"which only the ratio is known: {coupling.reason}"
            )
    return sentences
