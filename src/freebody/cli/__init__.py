"""The ``freebody`` command, one module per subcommand.

The commands import the rest of the library when they run, so that ``freebody --help`` does not wait for the compiler.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from typing import Any

import click

from ..errors import FreebodyError, nearest
from ..version import VERSION
from .analyze import analyze
from .chapter import chapter
from .check import check
from .draw import draw
from .equations import equations
from .export import export
from .gallery import gallery
from .report import report
from .run import run
from .study import study
from .sweep import sweep
from .view import view

__all__ = ["command", "main"]


class Commands(click.Group):
    """Commands by name; the error for an unknown name offers the nearest."""

    def resolve_command(self, ctx: click.Context, args: list[str]) -> Any:
        """Return the command that the arguments name."""
        if not args[0].startswith("-") and self.get_command(ctx, args[0]) is None:
            ctx.fail(f"No such command '{args[0]}'; {nearest(args[0], self.commands)}")
        return super().resolve_command(ctx, args)


@click.group(cls=Commands, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(VERSION, prog_name="freebody")
def command() -> None:
    """Rigid-body dynamics from the free-body diagram to the equation, the number and the picture.

    MODEL is a name that `freebody gallery` lists, or the path of a .toml model file or of a robot in .urdf or .xml
    (MJCF).
    """


for subcommand in (
    gallery,
    run,
    sweep,
    study,
    report,
    view,
    equations,
    export,
    analyze,
    check,
    draw,
    chapter,
):
    command.add_command(subcommand)


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line; exit code 0, 2 after an error, 130 after Ctrl-C.

    Parameters
    ----------
    arguments : sequence of str, optional
        By default the arguments of the process.
    """
    try:
        code = command.main(arguments, prog_name="freebody", standalone_mode=False)
    except (
        click.exceptions.NoArgsIsHelpError
    ) as error:  # `freebody` without arguments prints its help and is no error
        error.show()
        code = 0
    except click.ClickException as error:
        error.show()
        code = 2
    except FreebodyError as error:
        click.echo(f"Error: {error}", err=True)
        code = 2
    except (KeyboardInterrupt, click.Abort):
        click.echo("Stopped.", err=True)
        code = 130
    except BrokenPipeError:  # the reader, such as `head`, has ended
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        code = 0
    except (OSError, MemoryError) as error:
        click.echo(f"Error: {str(error) or type(error).__name__}", err=True)
        code = 2
    sys.exit(code if isinstance(code, int) else 0)
