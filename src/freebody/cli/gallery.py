"""``freebody gallery``: list the systems that can be run by name."""

from __future__ import annotations

import click


@click.command()
@click.option("--json", "as_json", is_flag=True, help="Print JSON instead of a table.")
def gallery(as_json: bool) -> None:
    """List the systems of the gallery with the questions that each answers."""
    from ..gallery import entries

    gallery_entries = entries()
    if as_json:
        import json

        listed = [
            {"name": e.name, "aliases": list(e.aliases), "title": e.title, "asks": list(e.asks)}
            for e in gallery_entries.values()
        ]
        click.echo(json.dumps(listed, indent=2, ensure_ascii=False))
        return
    from .table import Grid

    grid = Grid("Name", "System", "Asked")
    for entry in gallery_entries.values():
        grid.row("\n".join((entry.name, *entry.aliases)), entry.title, "\n".join(entry.asks))
    grid.print()
    click.echo("Run one: freebody run NAME")
