"""``freebody chapter``: every equation of the chapter with the verdict of the library."""

from __future__ import annotations

from collections import Counter

import click


@click.command()
@click.argument("number", required=False)
@click.option("--json", "as_json", is_flag=True, help="Print data.")
@click.option("--latex", is_flag=True, help="Print LaTeX of the printed and the derived form.")
def chapter(number: str | None, as_json: bool, latex: bool) -> None:
    """Check the textbook chapter: all its equations, or the equation NUMBER (6.66, "ex-6-1 (d)", ex-6-5).

    The library derives each and compares it with the print: holds, holds under a condition, definition,
    approximation (with its error), or misprint (with the right form).
    """
    from ..chapter import find, statements

    chosen = find(number) if number else list(statements().values())
    if as_json:
        import json

        data = [statement.data() for statement in chosen]
        click.echo(json.dumps(data[0] if number and len(data) == 1 else data, indent=2, ensure_ascii=False))
    elif latex:
        click.echo("\n\n".join(statement.latex() for statement in chosen))
    elif number:
        click.echo("\n\n".join(statement.text() for statement in chosen))
    else:
        _table(chosen)


PLURAL = {"holds": "hold", "definition": "definitions", "approximation": "approximations", "misprint": "misprints",
          "holds under a condition": "hold under a condition"}  # fmt: skip


def _table(chosen: list) -> None:
    """Print the number and verdict of each equation, and below it its statement and the errors of an approximation."""
    counted: Counter[str] = Counter()
    for statement in chosen:
        finding = statement.finding
        counted[finding.verdict] += 1
        rough = finding.verdict == "approximation"
        click.echo(f"{statement.number:<12}{finding.verdict if rough else statement.verdict}")
        for line in (statement.about, *(finding.detail.split("; ") if rough else ())):
            click.echo(f"{'':<14}{line}")
    parts = ", ".join(
        f"{count} {PLURAL.get(verdict, verdict) if count > 1 else verdict}"
        for verdict, count in counted.most_common()
    )
    click.echo(f"\n{len(chosen)} equations: {parts}.")
    click.echo("One with its derivation: freebody chapter 6.66")
