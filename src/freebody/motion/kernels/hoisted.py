"""Parameters that a run writes, and the constants of kernels that follow them (`renewal`). It needs no compiler.

A run writes the sides of laws that switch (`switching`) and the angles of disks that lie flat (`events.rings`).
"""

from __future__ import annotations

from typing import Annotated

from ...native.records import Record, Row, Whole, Wholes, address, record
from ..ode.dense_output import Array


@record
class Hoisted(Record):
    """Constants that are hoisted from the kernels of a run.

    ``parameters``             values of the parameters, then the sides of laws that switch
    ``prologues``, ``places``    of each of the ``programs``: address of the function that gives its constants, and
                               address of these
    """

    parameters: Annotated[Row, "numbers"]
    programs: Whole
    prologues: Annotated[Wholes, "most_programs"]
    places: Annotated[Wholes, "most_programs"]


def add_constants(hoisted: Hoisted, prologue: int, constants: Array) -> None:
    """Let constants, an array that stays where it is, follow the parameters."""
    k = hoisted.programs
    hoisted.prologues[k], hoisted.places[k], hoisted.programs = prologue, address(constants), k + 1
