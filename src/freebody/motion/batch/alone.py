"""Lanes of machines that the compiled loop over lanes cannot run: each is a single motion, with the same machine code.

These are machines with contacts, blows or sampled controllers, trees so large that kernels loop over their links, and
methods for which there is no loop over lanes. Of the trajectory of a lane, the outputs are kept. Parameters are
constants of the machine code: nothing is derived or compiled again for another lane.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import replace
from functools import partial
from threading import Lock
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import FreebodyError, SimulationError
from ..ending import FAILED, STATUS, End
from ..legs.failure import culprit
from ..legs.sensitivity import Sensitivity
from ..ode.dense_output import Crossing
from ..route import route_of_one
from ..trajectory.extremes import extremes, values
from ..trajectory.progress import Halt, HaltedError
from ..trajectory.trajectory import Trajectory
from .job import Job
from .results import Results
from .threads import share

_ONE_AT_A_TIME = Lock()
"""Held by lanes that share Python objects: states of controllers."""


class Alone:
    """Lanes, ready to run one by one."""

    def __init__(self, job: Job, results: Results) -> None:
        self.job, self.results, self.halt = job, results, Halt()

    def run(self, lanes: NDArray[np.int64], between: Callable[[float], None]) -> None:
        """Run lanes, given by number."""
        job, low = self.job, self.results.low
        threads = max(1, min(job.threads, len(lanes))) if self._parallel() else 1
        first = 1 if threads > 1 else 0  # the first lane compiles what all lanes need
        halt = self.halt.press if self._parallel() else None
        for some, before in ((lanes[:first], low), (lanes[first:], low + first)):

            def done(count: int, before: int = before) -> None:
                between(float(before + count))

            share(some, lambda part, _: self.chunk(part), [None] * threads, 1, 1 << 16, done, halt)

    def _parallel(self) -> bool:
        """Return True if threads gain time: controllers are handled in Python."""
        return not self.job.kernels.model.controllers

    def chunk(self, lanes: NDArray[np.int64]) -> None:
        """Run some lanes, given by number, and put their results in place."""
        for lane in lanes:
            if self.halt.pressed:
                raise HaltedError
            with nullcontext() if self._parallel() else _ONE_AT_A_TIME:
                self.lane(int(lane))

    def lane(self, lane: int) -> None:
        """Run one lane."""
        job, results, row = self.job, self.results, lane - self.results.low
        reason = ""
        motion: Trajectory | None = None
        try:
            initial, numbers = job.lanes.initial_of(lane), job.lanes.given_to(lane)
            progress = self.halt if self._parallel() else False
            request = replace(job.request, initial=initial, values=numbers, progress=progress)
            motion = route_of_one(request)(request)
        except FreebodyError as error:
            motion, reason = getattr(error, "trajectory", None), str(error)
        if motion is not None and motion.interrupted:
            raise KeyboardInterrupt
        if job.texts:
            warnings = () if motion is None or reason else motion.warnings
            results.texts[row, -1] = reason or " ".join(map(str, warnings))
        if motion is None:
            results.status[row] = End.NO_START
            return
        if job.unknowns:
            missing = self.keep_slopes(row, motion)
            results.texts[row, -1] = " ".join(filter(None, (results.texts[row, -1], missing)))
        path = motion.path
        blame = culprit(path, motion.kernels) if path.status in FAILED else 0
        ended = path.status if path.status in STATUS else End.REFUSED
        try:
            self.keep(row, motion)
        except SimulationError as error:  # a state of a run that broke off, or a quantity without extremes
            ended = End.REFUSED
            results.texts[row, -1] = " ".join(filter(None, (results.texts[row, -1], str(error))))
        results.end_times[row] = path.end
        results.status[row], results.blame[row] = ended, blame
        results.steps[row], results.rejected[row] = motion.steps, path.rejected

    def keep(self, row: int, motion: Trajectory) -> None:
        """Put the outputs of a motion, and the times of its events, in place."""
        job, results, outputs = self.job, self.results, self.job.outputs
        if outputs.timed:
            results.values[row, self.reached(motion)] = values(motion, outputs.timed_values)
        if outputs.reduced:
            results.reduced[row] = extremes(motion, outputs)
        for crossing in self.asked(motion):
            self._count(row, crossing.number, crossing.time)
        names = [spec.name for spec in job.specs]
        for warning in motion.warnings:
            event = names.index(warning.event)
            for begin, _ in warning.spans:
                self._count(row, event, begin)
                self._count(row, event + job.limits, begin)
        if outputs.timeline:
            changes = [[c.contact, c.mode, c.start, c.end, c.why] for c in motion.modes]
            results.texts[row, 0] = json.dumps(changes)

    def keep_slopes(self, row: int, motion: Trajectory) -> str:
        """Put the derivatives in place; return why some of them do not exist, and are nan."""
        outputs, slopes = self.job.outputs, self.results.slopes
        sensitivity: Sensitivity = motion.sensitivity
        numbers, missing = sensitivity.numbers, []

        def put(name: str, place: Any, derivatives: Callable[[], Any]) -> None:
            try:
                slopes[name][row, *place] = derivatives()
            except SimulationError as error:
                missing.append(str(error))

        reached = self.reached(motion)
        for name, value in zip(outputs.timed, outputs.timed_values, strict=True):
            put(f"d({name})", (reached,), partial(sensitivity.of_value, value))
        for name, (how, place) in outputs.numbers.items():
            put(f"d({name})", (), partial(numbers.number, how, outputs.reduced_values[place], name))
        put("d(end)", (), lambda: numbers.end)
        events: dict[int, list[Crossing]] = {}
        for crossing in self.asked(motion):
            events.setdefault(crossing.number, []).append(crossing)
        for k, crossings in events.items():
            put("d(event_time)", (k,), partial(numbers.event, crossings[0]))
            put("d(event_last)", (k,), partial(numbers.event, crossings[-1]))
        return " ".join(dict.fromkeys(missing))

    def reached(self, motion: Trajectory) -> Any:
        """Return a mask of the output times that a motion has reached."""
        first, last = sorted((motion.path.start, motion.path.end))
        return (self.job.times >= first) & (self.job.times <= last)

    def asked(self, motion: Trajectory) -> list[Crossing]:
        """Return the events of the user, without switches of loads and without those that did not end the run."""
        job, result = self.job, []
        for crossing in motion.path.crossings:
            if crossing.number < len(job.specs) - job.limits:
                spec = job.specs[crossing.number]
                if not (spec.terminal and crossing.time == job.begin):
                    result.append(crossing)
        return result

    def _count(self, row: int, event: int, time: float) -> None:
        """Count an event at a time."""
        results = self.results
        if results.counts[row, event] == 0:
            results.event_times[row, event, 0] = time
        results.event_times[row, event, 1] = time
        results.counts[row, event] += 1
