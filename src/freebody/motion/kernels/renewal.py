"""Constants of kernels follow the parameters that a run writes, in compiled code."""

from __future__ import annotations

from ...native.instructions import call, compiled, reals_at
from .hoisted import Hoisted


@compiled
def renew(hoisted: Hoisted) -> None:
    """Let the constants of all programs follow the parameters."""
    p = hoisted.parameters
    for k in range(hoisted.programs):
        call(hoisted.prologues[k], 0.0, p, 0, p, reals_at(hoisted.places[k]), 0)
