"""``freebody draw``: draw a machine or the free-body diagrams of its bodies."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from .model import Number, Setting, find, model_argument, settings_of


@click.command()
@model_argument
@click.option(
    "--body",
    metavar="NAME",
    help="Body of the free-body diagram, or `all`; the whole machine is drawn if not given.",
)
@click.option(
    "--at",
    "place",
    metavar="TIME|NAME=VALUE",
    multiple=True,
    help="Time of the motion [s], or a coordinate such as theta=30deg (repeatable).",
)
@click.option(
    "--mode",
    "modes",
    metavar="symbolic|scale|blank|CONTACT=MODE",
    multiple=True,
    help="Mode of the arrows (scale needs a time of the motion), or of a contact, such as floor=stick (repeatable).",
)
@click.option(
    "--until",
    type=Number(),
    help="Length of the run [s], for a time beyond the run of the model.",
)
@click.option("--dimensions/--no-dimensions", default=None, help="Show lengths.")
@click.option("--set", "settings", type=Setting(), multiple=True, help="Value of a parameter (repeatable).")
@click.option(
    "-o",
    "--output",
    metavar="FILE",
    type=click.Path(dir_okay=False, path_type=Path),
    help="File to write: .svg, .pdf, .png or .tex (TikZ); MODEL.svg in this folder if not given.",
)
def draw(
    model: str,
    body: str | None,
    place: tuple[str, ...],
    modes: tuple[str, ...],
    until: float | None,
    dimensions: bool | None,
    settings: tuple[tuple[str, str], ...],
    output: Path | None,
) -> None:
    """Draw MODEL, or the free-body diagram of one of its bodies.

    \b
    freebody draw four-bar -o four_bar.pdf
    freebody draw ex-6-5 --body bar --at theta=30deg
    freebody draw ex-6-5 --body all --at 0.5        to scale, 0.5 s after the start
    freebody draw disk.toml --body disk --mode floor=stick
    """
    from ..describe.description import names_of
    from ..errors import ModelError, nearest
    from ..picture.free_body.free_body_diagram import free_body_diagram
    from ..picture.machine.draw import draw as drawn
    from ..picture.paper.drawing import FORMATS

    entry = find(model)
    system = entry.build()
    if body is not None and body != "all" and body not in system.bodies:
        raise ModelError(
            f"--body: expected a body of '{system.name}' or 'all', got '{body}'; "
            f"{nearest(body, [*system.bodies, 'all'])}"
        )
    stem = Path(entry.name).stem + ("" if body is None else f"-{body}")
    path = Path(f"{stem}.svg") if output is None else output
    if path.suffix.lower() not in FORMATS:
        raise click.UsageError(
            f"-o: expected a file name that ends in {', '.join(FORMATS)}, got '{path.name}'."
        )
    mode, contacts = _modes(modes)
    values = settings_of(system, settings)
    options: dict[str, Any] = {"values": values}
    at, time = _place(place)
    if contacts:
        if time is not None:
            raise click.UsageError(
                "--mode CONTACT=MODE: at a time of the motion, the motion gives the contact modes."
            )
        options["modes"] = contacts
    if mode == "scale" and time is None:
        raise click.UsageError("--mode scale: arrows to scale need a time of the motion; add it as --at 0.5.")
    if time is not None:
        _check_within(entry, time, until)
        outcome = entry.run(values, max(time, 1e-9), None)
        system, options = outcome.system, {"trajectory": outcome.trajectory, "at": time}
    else:
        options["at"] = {**entry.drawn, **at} or None
        options["values"] = {**entry.enlarged, **values}
        names = {name for name, kind in names_of(system).kinds.items() if kind in ("coordinate", "joint")}
        near = {**_contact_start(entry, system), **entry.near}
        options["near"] = {name: value for name, value in near.items() if name in names and name not in at}
    if time is None and not contacts and body is not None and system.contacts:
        options["initial"] = {**_contact_start(entry, system), **at}
    if dimensions is not None:
        options["dimensions"] = dimensions
    if body is None:
        if mode is not None:
            raise click.UsageError("--mode is for free-body diagrams: add --body.")
        if time is None and entry.blows is not None:
            options["impulses"] = entry.blows(system)
        picture = drawn(system, **options)
    else:
        picture = free_body_diagram(system, body, mode=mode, **options)
    picture.save(path)
    click.echo(f"Wrote {path}")


def _check_within(entry: Any, time: float, until: float | None) -> None:
    """Raise if a time is not within the run."""
    length = entry.until if until is None else until
    if length is None:
        raise click.UsageError(f"--at: {entry.name} has no length of its run; add --until {time:g}.")
    if time > length:
        cure = f"add --until {time:g} for a longer run" if until is None else "--until ends before it"
        raise click.UsageError(
            f"--at: expected a time within the run of {entry.name}, 0 to {length:g} s, got {time:g} s; {cure}."
        )


def _contact_start(entry: Any, system: Any) -> dict[str, Any]:
    """Initial values of a machine with contacts: bodies that may touch are drawn near them."""
    return dict(entry.start) if system.contacts else {}


def _modes(texts: tuple[str, ...]) -> tuple[str | None, dict[str, str]]:
    """Mode of the arrows, and modes of contacts by name."""
    contacts: dict[str, str] = {}
    arrows: list[str] = []
    for text in texts:
        name, sign, value = text.partition("=")
        if sign:
            contacts[name.strip()] = value.strip()
        elif text in ("symbolic", "scale", "blank"):
            arrows.append(text)
        else:
            raise click.UsageError(
                f"--mode: expected symbolic, scale, blank, or a contact's mode such as floor=stick, got '{text}'."
            )
    if len(arrows) > 1:
        raise click.UsageError(f"--mode: expected one mode of the arrows, got {', '.join(arrows)}.")
    return (arrows[0] if arrows else None), contacts


def _place(texts: tuple[str, ...]) -> tuple[dict[str, str], float | None]:
    """Coordinates by name, or a time [s]."""
    at: dict[str, str] = {}
    times: list[float] = []
    for text in texts:
        name, sign, value = text.partition("=")
        if sign:
            at[name.strip()] = value.strip()
        else:
            times.append(Number("s").convert(text, None, None))
    if len(times) > 1 or (times and at):
        raise click.UsageError("--at: expected one time, or coordinates by name, not both.")
    if times and times[0] < 0:
        raise click.UsageError(f"--at: expected a time of 0 s or later, got {times[0]:g} s.")
    return at, times[0] if times else None
