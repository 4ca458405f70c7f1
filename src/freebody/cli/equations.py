"""``freebody equations``: print the equations of a model as text or LaTeX."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from .model import find, model_argument

if TYPE_CHECKING:
    from collections.abc import Mapping

    from ..describe.system import System
    from ..symbolic.equations import Equations


@click.command()
@model_argument
@click.option("--latex", is_flag=True, help="Print LaTeX instead of text.")
@click.option(
    "--body", metavar="NAME", help="Print the free-body equations of this body, with its reactions."
)
@click.option(
    "--link",
    metavar="NAME",
    help="As --body, for the body that carries this link of a robot, by the file's name.",
)
@click.option(
    "--mode",
    "modes",
    multiple=True,
    metavar="CONTACT=MODE",
    help="Mode of a contact: open, stick, slip+, slip- or slip; contacts not named are open. If none is given, the "
    "modes in which the motion starts.",
)
@click.option(
    "--form",
    type=click.Choice(("auto", "explicit", "recursive")),
    default="auto",
    show_default=True,
    help="Written out, or as short formulas of named quantities; auto uses these if the equations are too long.",
)
@click.option("--solved", is_flag=True, help="Print the accelerations on the left.")
def equations(
    model: str,
    latex: bool,
    body: str | None,
    link: str | None,
    modes: tuple[str, ...],
    form: str,
    solved: bool,
) -> None:
    """Print the equations of motion of MODEL, or the free-body equations of one body."""
    from ..errors import ModelError, nearest
    from ..motion.contact.equations_at_start import equations as equations_of

    entry = find(model)
    system = entry.build()
    if link is not None:
        body = _carrier(system, link, body)
    if body is not None and body not in system.bodies:
        raise ModelError(f"Expected a body of '{system.name}', got '{body}'; {nearest(body, system.bodies)}")
    for text in modes:
        if text.count("=") != 1:
            raise ModelError(
                f"Expected a contact and its mode, such as floor=stick, for --mode, got '{text}'."
            )
    start = {"initial": entry.start, "near": entry.near} if system.contacts and not modes else {}
    whole = equations_of(system, modes=dict(text.split("=") for text in modes) or None, form=form, **start)
    if body is not None:
        if solved:
            raise ModelError(
                f"Expected --solved without --body, got both: the free body of '{body}' is not solved."
            )
        free_body = whole.free_body(body)
        click.echo(free_body.latex() if latex else free_body.text())
        return
    click.echo(whole.latex(solved=solved) if latex else whole.text(solved=solved))
    if whole.model.constraints and not latex:
        _constraint_forces(whole, entry.near)


def _carrier(system: System, link: str, body: str | None) -> str:
    """Return the body that carries a link of a robot's file."""
    from ..errors import ModelError, nearest

    if body is not None:
        raise ModelError(f"Expected --body or --link, got both: {body} and {link}.")
    if system.reading is None:
        raise ModelError(
            f"Expected a robot's file for --link {link}; the bodies of '{system.name}' are named by --body."
        )
    frames = system.reading.frames
    if link not in frames:
        raise ModelError(f"Expected a link of '{system.name}', got '{link}'; {nearest(link, frames)}")
    carrier: str = frames[link][0].body.name
    if carrier == "ground":
        raise ModelError(f"Link '{link}' is fixed to the ground, which has no equations.")
    return carrier


def _constraint_forces(whole: Equations, near: Mapping[str, Any]) -> None:
    """Print the multipliers, and the indeterminate reactions."""
    from ..errors import ModelError

    matrix = whole.conditions.matrix
    names = [
        name for name, row in zip(whole.condition_names, matrix, strict=True) if any(x != 0 for x in row)
    ]
    click.echo(f"\nConstraint forces (multipliers): {', '.join(names)}")
    places = {name: value for name, value in near.items() if name in whole.model.coordinate_names}
    try:
        indeterminate = whole.indeterminate(places)
    except ModelError:
        return  # `check` says why the machine does not close
    if indeterminate:
        click.echo(f"Indeterminate reactions: {', '.join(indeterminate)}")
