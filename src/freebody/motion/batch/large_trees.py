"""Lanes of large trees, eight at a time: the loop over lanes with kernels that loop over links.

The constants of the links would have to be computed for each lane by straight code, which grows with the model. Lanes
therefore run alone, one by one, if they differ in parameters; if events, extremes or energies are asked for; if they
are stiff; and if they fail, so that they tell why.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import SimulationError
from ...native.records import WIDTH
from ...program.fixed import Fixed
from ..ending import End
from ..kernels.kernels import Kernels
from ..ode.dense_output import Array
from .alone import Alone
from .job import Job
from .kernels import BatchProgram
from .lane_loop import LaneLoop
from .results import Results


class LargeTrees:
    """Lanes of a large tree, ready to run eight at a time."""

    def __init__(self, job: Job, results: Results) -> None:
        self.job, self.results = job, results

    def run(self, lanes: NDArray[np.int64], between: Callable[[float], None]) -> None:
        """Run lanes, given by number; those that do not finish run again, alone."""
        job, results = self.job, self.results
        if len(lanes) >= WIDTH:
            try:
                states, *_ = job.lanes.states({}, job.begin, False, job.kernels)
            except SimulationError:  # a lane without a start tells why if it runs alone
                Alone(job, results).run(lanes, between)
                return
            parameters = job.lanes.parameters(np.array([0]))[0]
            program = program_of(job.kernels, job.outputs.timed_values, parameters)
            LaneLoop(
                replace(job, states=states),
                "dop853",
                results,
                until_stiff=job.request.method == "auto",
                program=program,
            ).run(lanes, between)
            ended = results.status[lanes - results.low]
            lanes = lanes[~np.isin(ended, (End.FINISHED, End.WAITING))]
            results.clear(lanes - results.low)
        if len(lanes):
            Alone(job, results).run(lanes, between)


def program_of(kernels: Kernels, outputs: tuple[Any, ...], parameters: Array) -> BatchProgram:
    """Return the program for these parameters: rates and energy looped over the links, outputs as straight code."""
    motion = kernels.motion()
    constants = motion.constants(parameters)
    functions = {
        "rates": (motion.compiled.of_rows("rates", shared=True), constants),
        "energy": (motion.compiled["energy"], constants),
    }
    if outputs:
        program = kernels.expressions(outputs)
        functions["outputs"] = (program.compiled["values"], program.constants(parameters))
    return BatchProgram(Fixed(functions), 0, 0)
