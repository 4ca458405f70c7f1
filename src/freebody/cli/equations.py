"""``freebody equations``: the equations of a model as text or LaTeX."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from .model import find

if TYPE_CHECKING:
    from collections.abc import Mapping

    from ..symbolic.equations import Equations


@click.command()
@click.argument("model")
@click.option("--latex", is_flag=True, help="Print LaTeX instead of text.")
@click.option("--body", metavar="NAME", help="The free-body equations of this body, reactions included.")
@click.option(
    "--mode",
    "modes",
    multiple=True,
    metavar="CONTACT=MODE",
    help="What a contact does: open, stick, slip+, slip- or slip; those not named are open. If none is given, the "
    "modes in which the motion starts.",
)
@click.option(
    "--form",
    type=click.Choice(("auto", "explicit", "recursive")),
    default="auto",
    show_default=True,
    help="Written out, or in named quantities, short formulas each; auto names them where the equations fit no page.",
)
def equations(model: str, latex: bool, body: str | None, modes: tuple[str, ...], form: str) -> None:
    """Print the equations of motion of MODEL, or the free-body equations of one body."""
    from ..errors import ModelError, nearest
    from ..motion.contact.equations_at_start import equations as equations_of

    found = find(model)
    system = found.build()
    if body is not None and body not in system.bodies:
        raise ModelError(f"Expected a body of '{system.name}', got '{body}'; {nearest(body, system.bodies)}")
    for given in modes:
        if given.count("=") != 1:
            raise ModelError(
                f"Expected a contact and its mode, such as floor=stick, for --mode, got '{given}'."
            )
    start = {"initial": found.start, "near": found.near} if system.contacts and not modes else {}
    whole = equations_of(system, modes=dict(given.split("=") for given in modes) or None, form=form, **start)
    product: Any = whole if body is None else whole.free_body(body)
    click.echo(product.latex() if latex else product.text())
    if whole.model.constraints and body is None and not latex:
        _constraint_forces(whole, found.near)


def _constraint_forces(whole: Equations, near: Mapping[str, Any]) -> None:
    """The multipliers, and which reactions no motion determines."""
    from ..errors import ModelError

    matrix = whole.conditions.matrix
    live = [name for name, row in zip(whole.condition_names, matrix, strict=True) if any(x != 0 for x in row)]
    click.echo(f"\nConstraint forces (multipliers): {', '.join(live)}")
    places = {name: value for name, value in near.items() if name in whole.model.coordinate_names}
    try:
        indeterminate = whole.indeterminate(places)
    except ModelError:
        return  # `check` says why the machine does not close
    if indeterminate:
        click.echo(f"Indeterminate reactions: {', '.join(indeterminate)}")
