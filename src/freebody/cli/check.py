"""``freebody check``: whether a model can be assembled, and what it then is."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from .model import find
from .table import Grid

if TYPE_CHECKING:
    from ..describe.system import System


@click.command()
@click.argument("model")
def check(model: str) -> None:
    """Assemble MODEL and list its bodies, joints, loads, degrees of freedom and parameters."""
    from ..formats.text import expression_text
    from ..model import assemble

    system = find(model).build()
    assembled = assemble(system)

    def text(value: Any) -> str:
        return expression_text(value, system.names.texts)

    _bodies(system, text)
    _joints(system, text)
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
    click.echo(f"Degrees of freedom: {len(assembled.speeds)}")
    click.echo(f"'{system.name}' is sound.")


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
            displacements += [text(one) for one in (y if isinstance(y, tuple) else (y,)) if one is not None]
        grid.row(name, joint.type, joint.parent.name, joint.child.name, ", ".join(displacements))
    grid.print()


def _parameters(system: System) -> None:
    if not system.parameter_list:
        return
    grid = Grid("Parameter", "Default", "Unit", "About")
    for parameter in system.parameter_list:
        unit, about = system.about.get(parameter.name, ("", ""))
        grid.row(parameter.name, "-" if parameter.default is None else f"{parameter.default:g}", unit, about)
    grid.print()
