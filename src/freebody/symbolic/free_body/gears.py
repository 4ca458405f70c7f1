"""Gears in the free-body equations: the force that presses the teeth apart, and what a bare ratio leaves open.

    F_r = tan(alpha) |F_t|        positive where the teeth push each other apart

The tangential force is that of the multiplier. The radial one does no work; without a pressure angle it is open.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import sympy

from ...dynamics.constraints import radial_names, rows, separating_force
from ...dynamics.indeterminate import joints_between
from ...scalar.algebra import Vector, scale

if TYPE_CHECKING:
    from ..equations import Equations


def radial_symbols(e: Equations) -> dict[str, Any]:
    """The symbol of the radial force of each gear whose pitch point is known, by the gear."""
    return {gear: sympy.Symbol(name, real=True) for gear, name in radial_names(e.model).items()}


def radial_forces(e: Equations, gear: str) -> list[tuple[Any, Vector, Vector]]:
    """(point, force, moment) of the radial force of a gear on its two bodies, in its symbol."""
    value = e.ring.generator(radial_symbols(e)[gear], "reaction")
    pair, _ = separating_force(e.model, e.state, e.model.constraints[gear])
    return [(where, scale(value, force), scale(value, moment)) for where, force, moment in pair]


def radial_law(e: Equations, gear: str) -> Any:
    """The radial force in the multiplier, canonical; None where the pressure angle is not known."""
    _, size = separating_force(e.model, e.state, e.model.constraints[gear])
    if size is None:
        return None
    (value,) = (x for row, x in zip(rows(e.model), e.canonical_multipliers, strict=True) if row.owner == gear)
    return size * e.ring.apply("abs", value)


def radial_laws(e: Equations, gears: Iterable[str]) -> list[tuple[Any, Any]]:
    """(left, right) of the laws of the radial forces of these gears, canonical."""
    found = {gear: radial_law(e, gear) for gear in radial_symbols(e) if gear in gears}
    symbols = radial_symbols(e)
    return [(e.ring.generator(symbols[g], "reaction"), x) for g, x in found.items() if x is not None]


def left_open(
    e: Equations, joint: str | None = None, body: str | None = None, *, radial: bool = True
) -> list[str]:
    """What gears leave open of the reactions of a joint or of the joints of a body, a sentence each.

    Without ``radial``, where a force of its own stands for it, that is left out.
    """
    model = e.model
    held = {name for name, one in model.joints.items() if name == joint or body in (one.parent, one.child)}
    names = radial_names(model)
    sentences = []
    for gear, mesh in model.meshes.items():
        one = model.constraints[gear]
        if isinstance(mesh, str):
            between = [name for name in joints_between(model, one) if name in held]
            if between:
                sentences.append(
                    f"undetermined: how much of {', '.join(between)} the joint bears and how much the teeth of gear "
                    f"'{gear}', of which the ratio alone is known: {mesh}"
                )
        elif radial and one.pressure_angle is None and held & {one.first.name, one.second.name}:
            sentences.append(
                f"undetermined: {names[gear]}, which presses the teeth of gear '{gear}' apart; its pressure_angle "
                f"would tell"
            )
    return sentences
