"""``freebody export``: write a model's functions as C, CasADi, NumPy or JAX."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from .model import find, model_argument


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
def export(model: str, languages: tuple[str, ...], products: tuple[str, ...], out: Path) -> None:
    """Write the functions of MODEL (dynamics, mass matrix, forces, ...) for other programs."""
    from ..program.program import compile_system

    if not languages:
        raise click.UsageError("Expected a language: --c, --casadi, --numpy or --jax.")
    program = compile_system(find(model).build())
    out.mkdir(parents=True, exist_ok=True)
    for language in dict.fromkeys(languages):
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
