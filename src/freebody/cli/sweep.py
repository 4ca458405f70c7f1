"""``freebody sweep``: simulate a model at every combination of some of its values: a study of a grid."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from .model import model_argument
from .study import run_lanes, runs_motions


@click.command()
@model_argument
@runs_motions
@click.option("-o", "--out", "store", type=click.Path(path_type=Path), default=None, metavar="FILE",
              help="x.nc or x.zarr for the results; a stopped sweep continues from it.")  # fmt: skip
def sweep(model: str, store: Path | None, **options: Any) -> None:
    """Simulate MODEL at every combination of values, and write the motions to one file."""
    if not options["vary"]:
        raise click.UsageError("Expected what varies: --vary NAME=FROM:TO:COUNT.")
    run_lanes(model, {**options, "sample": (), "n": None, "by": None, "seed": None}, None, store)
