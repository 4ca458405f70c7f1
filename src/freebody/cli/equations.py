"""``freebody equations``: the equations of a model as text or LaTeX."""

from __future__ import annotations

from typing import Any

import click

from .model import find


@click.command()
@click.argument("model")
@click.option("--latex", is_flag=True, help="Print LaTeX instead of text.")
@click.option("--body", metavar="NAME", help="The free-body equations of this body, reactions included.")
def equations(model: str, latex: bool, body: str | None) -> None:
    """Print the equations of motion of MODEL, or the free-body equations of one body."""
    from ..equations import equations as equations_of
    from ..errors import ModelError, nearest

    system = find(model).build()
    if body is not None and body not in system.bodies:
        raise ModelError(f"Expected a body of '{system.name}', got '{body}'; {nearest(body, system.bodies)}")
    whole = equations_of(system)
    product: Any = whole if body is None else whole.free_body(body)
    click.echo(product.latex() if latex else product.text())
