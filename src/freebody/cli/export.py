"""``freebody export``: write a model's functions as C, CasADi, NumPy or JAX, and the model itself as URDF or MJCF."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from .model import Setting, find, model_argument, settings_of

ENDINGS = {"urdf": ".urdf", "mjcf": ".xml"}
"""Endings of the files of robots."""


@click.command()
@model_argument
@click.option("--c", "languages", flag_value="c", multiple=True, help="C99: one source file and its header.")
@click.option(
    "--casadi",
    "languages",
    flag_value="casadi",
    multiple=True,
    help="One file NAME.casadi for casadi.Function.load.",
)
@click.option(
    "--numpy", "languages", flag_value="numpy", multiple=True, help="A Python module of NumPy functions."
)
@click.option("--jax", "languages", flag_value="jax", multiple=True, help="A Python module of JAX functions.")
@click.option("--urdf", "languages", flag_value="urdf", multiple=True, help="The machine as a robot in URDF.")
@click.option(
    "--mjcf", "languages", flag_value="mjcf", multiple=True, help="The machine as a model of MuJoCo."
)
@click.option(
    "--set",
    "settings",
    type=Setting(),
    multiple=True,
    metavar="NAME=VALUE",
    help="Value of a parameter, in URDF and MJCF.",
)
@click.option(
    "--product",
    "products",
    multiple=True,
    metavar="NAME",
    help="A function, such as mass_matrix or forward_dynamics_by_q; several times for several. By default all.",
)
@click.option(
    "-o", "--out", type=click.Path(file_okay=False, path_type=Path), default=Path("."), metavar="DIR",
    show_default="this folder", help="Folder for the files.",
)  # fmt: skip
def export(
    model: str,
    languages: tuple[str, ...],
    settings: tuple[tuple[str, str], ...],
    products: tuple[str, ...],
    out: Path,
) -> None:
    """Write the functions of MODEL (dynamics, mass matrix, forces, ...), or MODEL itself, for other programs."""
    from ..formats import write
    from ..program.export.recording import identifier
    from ..program.program import compile_system

    if not languages:
        raise click.UsageError("Expected a language: --c, --casadi, --numpy, --jax, --urdf or --mjcf.")
    system = find(model).build()
    values = settings_of(system, settings)
    out.mkdir(parents=True, exist_ok=True)
    program: Any = None
    for language in dict.fromkeys(languages):
        if language in ENDINGS:
            path = out / f"{identifier(system.name)}{ENDINGS[language]}"
            write(system, path, values=values)
            click.echo(path)
            continue
        program = program or compile_system(system)
        written: Any = getattr(program, f"to_{language}")(*products)
        paths = _saved(written, out) if language == "casadi" else written.write(out)
        for path in paths:
            click.echo(path)


def _saved(functions: Any, folder: Path) -> list[Path]:
    """Save CasADi's functions, and return their files."""
    paths = [folder / f"{name}.casadi" for name in functions]
    for path, function in zip(paths, functions.values(), strict=True):
        function.save(str(path))
    return paths
