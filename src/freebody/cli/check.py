"""``freebody check``: assemble a model and list what it consists of."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from ..errors import ModelError
from .model import find, model_argument
from .table import Grid

if TYPE_CHECKING:
    from collections.abc import Mapping

    from ..describe.system import System
    from ..model import Model


@click.command()
@model_argument
def check(model: str) -> None:
    """Assemble MODEL and list its bodies, joints, constraints, contacts, loads, degrees of freedom and parameters."""
    from ..formats.text import expression_text
    from ..model import assemble

    entry = find(model)
    system = entry.build()
    assembled = assemble(system)

    def text(value: Any) -> str:
        from ..describe.contacts.normal_law import OWN_NAMES
        from ..describe.description import names_of

        return expression_text(value, {**names_of(system).texts, **OWN_NAMES})

    if system.reading is not None:
        click.echo(f"{system.reading}\n")
    _bodies(system, text)
    _joints(system, text)
    _constraints(system, text)
    _contacts(system, text)
    _families(assembled, text)
    if system.loads:
        grid = Grid("Load", "Kind")
        for name, load in system.loads.items():
            grid.row(name, type(load).__name__)
        grid.print()
    if any(component != 0 for component in system.gravity):
        click.echo(f"Gravity: ({', '.join(map(text, system.gravity))})\n")
    _parameters(system)
    coordinates = ", ".join(coordinate.name for coordinate in assembled.coordinates)
    click.echo(f"Coordinates: {coordinates or 'none'}")
    if not assembled.constraints:
        click.echo(f"Degrees of freedom: {len(assembled.speeds)}")
        _length(assembled)
        click.echo(f"'{system.name}' is sound.")
        return
    _freedom(assembled, entry.near)
    _length(assembled)
    click.echo(f"'{system.name}' is sound.")


def _length(model: Model) -> None:
    """Print the length of equations of motion that are too long to be written out."""
    from ..scalar.budget import shown
    from ..symbolic.equations import equations
    from ..symbolic.length_bound import most_terms

    if equations(model).form == "recursive":
        click.echo(
            f"Equations of motion: up to {shown(most_terms(model))} terms written out; printed recursively. "
            "Formulas for reactions and free bodies may be too long."
        )


def _bodies(system: System, text: Any) -> None:
    grid = Grid("Body", "Mass", "Mass centre (body axes)")
    for name, body in system.bodies.items():
        mass = body.mass_properties
        assert mass is not None
        grid.row(name, text(mass.mass), f"({', '.join(map(text, mass.center))})")
    grid.print()


def _joints(system: System, text: Any) -> None:
    grid = Grid("Joint", "Type", "Parent", "Child", "Coordinates")
    for name, joint in system.joints.items():
        displacements = []
        for primitive in joint.primitives:
            y = primitive.coordinate
            displacements += [text(x) for x in (y if isinstance(y, tuple) else (y,)) if x is not None]
        if joint.closes:
            displacements = ["closes a loop"]
        grid.row(name, joint.type, joint.parent.name, joint.child.name, ", ".join(displacements))
    grid.print()


def _constraints(system: System, text: Any) -> None:
    if not system.constraints:
        return
    from ..describe.constraints.constraint import Gear, Rolling, Rope

    grid = Grid("Constraint", "Kind", "Keeps")
    for name, constraint in system.constraints.items():
        if isinstance(constraint, Gear):
            law = f"{constraint.first.name} = {text(constraint.ratio)} * {constraint.second.name}"
        elif isinstance(constraint, Rope):
            law = f"length {text(constraint.length)} over {len(constraint.points)} points"
        elif isinstance(constraint, Rolling):
            law = f"{constraint.center.body.name} rolling, radius {text(constraint.radius)}"
            if constraint.friction is not None:
                law += f", friction {text(constraint.friction)}"
        else:
            law = f"{text(constraint.expression)} = 0"
        if getattr(constraint, "unilateral", False):
            law += ", one-sided"
        grid.row(name, type(constraint).__name__, law)
    grid.print()


def _contacts(system: System, text: Any) -> None:
    if not system.contacts:
        return
    grid = Grid("Contact", "Feature", "Surface", "Friction", "Restitution")
    for name, pair in system.contacts.items():
        grid.row(name, *pair.parts, *_laws(pair, text))
    grid.print()


def _laws(pair: Any, text: Any) -> tuple[str, str]:
    """Return the friction, and the other laws, of a contact or of a family of contacts."""
    from ..describe.contacts.coefficients import at_rest

    friction = text(pair.friction)
    if getattr(pair, "along", None) is not None:
        friction += f" along ({', '.join(map(text, pair.along))}), {text(pair.friction_across)} across"
    if pair.static_friction not in (None, at_rest(pair.friction)):
        friction += f", static {text(pair.static_friction)}"
    bounce = text(pair.restitution) + (f" ({pair.impact})" if pair.restitution != 0 else "")
    law = getattr(pair, "normal_force", None)
    bounce = bounce if law is None else f"N = {text(law)}"
    for law in ("adhesion", "rolling", "spinning"):
        if getattr(pair, law, 0) != 0:
            bounce += f", {law} {text(getattr(pair, law))}"
    return friction, bounce


def _families(model: Model, text: Any) -> None:
    if not model.families:
        return
    from ..model.family import text_of_members

    grid = Grid("Family of contacts", "Members", "Friction", "Restitution")
    for family in model.families:
        grid.row(family.name, text_of_members(family), *_laws(family.law, text))
    grid.print()


def _freedom(model: Model, near: Mapping[str, Any]) -> None:
    """Print the degrees of freedom of a machine with constraints, in a closed configuration with default values."""
    from ..dynamics.conditions.constrained import closed_coordinates, independent_rows
    from ..dynamics.conditions.constraints import rows
    from ..dynamics.conditions.indeterminate import indeterminate
    from ..dynamics.conditions.unilateral import NEGLIGIBLE, limits, margins, sizes
    from ..dynamics.motion import motion
    from ..dynamics.state import float_state
    from ..motion.start.initial import named_state

    kinds = rows(model)
    click.echo(f"Constraint forces: {', '.join(row.name for row in kinds)}")
    numbers = model.values()
    start, _ = named_state(model, numbers, near, "near")
    try:
        q = closed_coordinates(model, start[: model.n_q].tolist(), values=numbers)
    except ModelError as error:
        click.echo(f"Degrees of freedom: unknown. {error}")
        return
    state = float_state(model, q, values=numbers)
    active = independent_rows(model, state)
    shape = sum(not kinds[i].on_speeds for i in active)
    place = ", ".join(f"{name} = {x:.6g}" for name, x in zip(model.coordinate_names, q, strict=True))
    click.echo(f"Closed position: {place}")
    click.echo(
        f"Degrees of freedom there: {model.n_u - len(active)} ({model.n_u} speeds, {len(active)} independent "
        f"constraints{f', {len(active) - shape} of them on speeds only' if shape < len(active) else ''})"
    )
    forces = margins(model, state, motion(model, state, active).multipliers)
    for limit, margin, size in zip(limits(model), forces, sizes(model, state, active), strict=True):
        if margin + NEGLIGIBLE * size < 0:
            click.echo(
                f"Warning: at rest there {limit.what} ('{limit.constraint}', {margin:.6g} N). {limit.law}. {limit.cure}"
            )
    unknown = indeterminate(model, state)
    if unknown:
        click.echo(f"Indeterminate reactions: {', '.join(unknown)}")


def _parameters(system: System) -> None:
    from ..describe.description import about_of, parameters_of

    if not parameters_of(system):
        return
    grid = Grid("Parameter", "Default", "Unit", "About")
    for parameter in parameters_of(system):
        unit, about = about_of(system).get(parameter.name, ("", ""))
        grid.row(parameter.name, "-" if parameter.default is None else f"{parameter.default:g}", unit, about)
    grid.print()
