"""Lanes of large trees, eight at a time: the loop over lanes with kernels that loop over links.

The constants of the links would have to be computed for each lane by straight code, which grows with the model: lanes
that differ in parameters run alone, one by one, and so do those in which events, extremes or energies are asked for,
stiff ones, and those that fail, which then tell why.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from ...errors import SimulationError
from ...native.registers import WIDTH
from ...program.fixed import Fixed
from ...program.large.tree_loop import is_large
from ..kernels.kernels import Kernels
from ..kernels.methods import FINE
from ..ode import layout
from .alone import Alone
from .kernels import BatchProgram


def applies(job: Any) -> bool:
    """Whether a batch is run so."""
    model, asked, given = job.kernels.model, job.asked, job.given
    return (
        is_large(model, "forward_dynamics")
        and job.method in ("auto", "dop853")
        and not (job.method == "auto" and job.tolerances.min() < FINE)
        and not (model.contacts or model.controllers or model.signals or job.alone["impulses"])
        and not (job.specs or asked.reduced or any(isinstance(x, str) for x in asked.timed_values))
        and not given.varied[0]
        and job.step is None
        and job.begin != job.end
    )


class Large:
    """Runs of lanes eight at a time, ready to begin."""

    def __init__(self, job: Any, part: Any, loop: Callable[..., Any]) -> None:
        self.job, self.part, self.loop = job, part, loop

    def run(self, todo: Any, between: Callable[[float], None]) -> None:
        """Some lanes, given by number; those that end otherwise than others run once more, alone."""
        job, part = self.job, self.part
        if len(todo) >= WIDTH:
            try:
                states, *_ = job.given.states({}, job.begin, False, job.kernels)
            except SimulationError:  # a lane has no start, and tells why where it runs alone
                Alone(job, part).run(todo, between)
                return
            program = program_of(job.kernels, job.asked.timed_values, job.given.parameters(np.array([0]))[0])
            self.loop(replace(job, states=states), "dop853", part, job.method == "auto", program).run(
                todo, between
            )
            rows = todo - part.low
            todo = todo[~np.isin(part.kept[rows, 0], (layout.FINISHED, -1))]
            part.clear(todo - part.low)
        if len(todo):
            Alone(job, part).run(todo, between)


def program_of(kernels: Kernels, outputs: tuple[Any, ...], parameters: Any) -> BatchProgram:
    """Rates and energy looped over the links, outputs in straight code, for these parameters."""
    motion = kernels.motion()
    c = motion.constants(parameters)
    given = {
        "rates": (motion.compiled.of_rows("rates", shared=True), c),
        "energy": (motion.compiled["energy"], c),
    }
    if outputs:
        asked = kernels.expressions(outputs)
        given["outputs"] = (asked.compiled["values"], asked.constants(parameters))
    return BatchProgram(Fixed(given), 0, 0)
