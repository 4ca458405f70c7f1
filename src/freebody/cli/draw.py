"""``freebody draw``: the machine, or the free-body diagrams of its bodies, as a picture."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from .model import Number, Setting, find, settings_of


@click.command()
@click.argument("model")
@click.option(
    "--body", metavar="NAME", help="The free-body diagram of this body, or `all`; the machine if not given."
)
@click.option(
    "--at",
    "place",
    metavar="TIME|NAME=VALUE",
    multiple=True,
    help="A time of the motion [s], or a coordinate such as theta=30deg (repeatable).",
)
@click.option(
    "--mode",
    "modes",
    metavar="symbolic|scale|blank|CONTACT=MODE",
    multiple=True,
    help="Of the arrows (to scale at a time of the motion); or of a contact, such as floor=stick (repeatable).",
)
@click.option(
    "--until",
    type=Number(),
    help="Length of the run [s], for a time of it beyond the one that the model names.",
)
@click.option("--dimensions/--no-dimensions", default=None, help="Whether lengths are written.")
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

    found = find(model)
    system = found.build()
    if body is not None and body != "all" and body not in system.bodies:
        raise ModelError(
            f"--body: expected a body of '{system.name}' or 'all', got '{body}'; "
            f"{nearest(body, [*system.bodies, 'all'])}"
        )
    stem = Path(found.name).stem + ("" if body is None else f"-{body}")
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
            raise click.UsageError("--mode CONTACT=MODE: at a time of the motion, contacts have its modes.")
        options["modes"] = contacts
    if mode == "scale" and time is None:
        raise click.UsageError("--mode scale: arrows to scale are those of a time; add it as --at 0.5.")
    if time is not None:
        _check_within(found, time, until)
        outcome = found.run(values, max(time, 1e-9), None)
        system, options = outcome.system, {"trajectory": outcome.trajectory, "at": time}
    else:
        options["at"] = at or None
        known = {name for name, kind in names_of(system).kinds.items() if kind in ("coordinate", "joint")}
        near = {**_standing(found, system), **found.near}
        options["near"] = {name: value for name, value in near.items() if name in known and name not in at}
    if time is None and not contacts and body is not None and system.contacts:
        options["initial"] = {**_standing(found, system), **at}
    if dimensions is not None:
        options["dimensions"] = dimensions
    if body is None:
        if mode is not None:
            raise click.UsageError("--mode is of free-body diagrams: add --body.")
        picture = drawn(system, **options)
    else:
        picture = free_body_diagram(system, body, mode=mode, **options)
    picture.save(path)
    click.echo(f"Wrote {path}")


def _check_within(found: Any, time: float, until: float | None) -> None:
    """A time is of the run that the model names, or of the one that is asked for."""
    length = found.until if until is None else until
    if length is None:
        raise click.UsageError(f"--at: {found.name} names no length of its run; add --until {time:g}.")
    if time > length:
        cure = f"add --until {time:g} for a longer one" if until is None else "--until ends before it"
        raise click.UsageError(
            f"--at: expected a time within the run of {found.name}, 0 to {length:g} s, got {time:g} s; {cure}."
        )


def _standing(found: Any, system: Any) -> dict[str, Any]:
    """The start of the run, near which bodies that may touch are drawn; they would be hard to place else."""
    if not system.contacts:
        return {}
    return dict(found.case.initial if hasattr(found, "case") else found.start)


def _modes(given: tuple[str, ...]) -> tuple[str | None, dict[str, str]]:
    """The mode of the arrows, and those of contacts."""
    contacts: dict[str, str] = {}
    arrows: list[str] = []
    for one in given:
        name, sign, value = one.partition("=")
        if sign:
            contacts[name.strip()] = value.strip()
        elif one in ("symbolic", "scale", "blank"):
            arrows.append(one)
        else:
            raise click.UsageError(
                f"--mode: expected symbolic, scale, blank, or a contact's mode such as floor=stick, got '{one}'."
            )
    if len(arrows) > 1:
        raise click.UsageError(f"--mode: expected one mode of the arrows, got {', '.join(arrows)}.")
    return (arrows[0] if arrows else None), contacts


def _place(given: tuple[str, ...]) -> tuple[dict[str, str], float | None]:
    """Coordinates by name, or one time."""
    at: dict[str, str] = {}
    times: list[float] = []
    for one in given:
        name, sign, value = one.partition("=")
        if sign:
            at[name.strip()] = value.strip()
        else:
            times.append(Number("s").convert(one, None, None))
    if len(times) > 1 or (times and at):
        raise click.UsageError("--at: expected one time, or coordinates by name, not both.")
    if times and times[0] < 0:
        raise click.UsageError(f"--at: expected a time of 0 s or later, got {times[0]:g} s.")
    return at, times[0] if times else None
