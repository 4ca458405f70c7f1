"""Lanes of machines that the compiled loop over lanes can not run: each by `simulate`, with the same machine code.

These are machines with contacts, blows or sampled controllers, trees so large that they are looped over, and methods of
which there is no loop over lanes. A lane is the run alone; of its trajectory is kept what was asked for. Parameters are
constants of the machine code: nothing is derived or compiled again for another lane, but the equations of contact
modes that no lane has had before.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from contextlib import nullcontext
from threading import Lock
from typing import Any

import numpy as np

from ...errors import FreebodyError
from ..lanes import lanes_layout as at
from ..legs.failure import culprit
from ..ode import dense_output, layout
from ..single import single_motion
from ..trajectory.extremes import extremes, values
from .threads import share

CODES = {
    dense_output.FINISHED: layout.FINISHED,
    dense_output.TERMINAL: layout.TERMINAL,
    dense_output.NOT_FINITE: layout.NOT_FINITE,
    dense_output.COLLAPSED: layout.COLLAPSED,
    dense_output.DIVERGED: layout.DIVERGED,
    dense_output.UNDEFINED: layout.UNDEFINED,
    dense_output.TOO_MANY_STEPS: at.TOO_MANY,
    dense_output.CONTRADICTED: at.LEFT,
    dense_output.STUCK: at.STUCK,
}
NO_START, REFUSED = 9, 10
REASON = "reason"
"""Variable that tells why a lane failed."""


_ONE = Lock()
"""Of lanes that share what Python keeps: phases of contacts, memories of controllers."""


class Alone:
    """Runs of lanes one by one, ready to begin."""

    def __init__(self, job: Any, part: Any) -> None:
        self.job, self.part = job, part

    def run(self, todo: Any, between: Callable[[float], None]) -> None:
        """All lanes of the part, or those given by number."""
        job, part = self.job, self.part
        lanes = np.arange(part.low, part.high, dtype=np.int64) if todo is None else todo
        threads = max(1, min(job.threads, len(lanes))) if self._threads() else 1
        if threads > 1:  # whatever is compiled is compiled once
            self.chunk(lanes[:1])
            between(float(part.low + 1))
        first = 1 if threads > 1 else 0
        share(
            lanes[first:], lambda some, _: self.chunk(some), [None] * threads, 1, 1 << 16,
            lambda done: between(float(part.low + first + done)),
        )  # fmt: skip

    def _threads(self) -> bool:
        """Whether threads gain anything: between the events of contacts, and in controllers, is Python."""
        model = self.job.kernels.model
        return not model.controllers and (not model.contacts or self.job.method == "timestepping")

    def chunk(self, lanes: Any) -> None:
        """Run some lanes, given by number, and put what they left where it belongs."""
        for lane in lanes:
            with nullcontext() if self._threads() else _ONE:
                self.lane(int(lane))

    def lane(self, lane: int) -> None:
        """Run one lane."""
        job, row = self.job, lane - self.part.low
        given, reason = job.given, ""
        motion: Any = None
        try:
            motion = single_motion(
                job.machine, job.end, initial=given.initial_of(lane), values=given.values_of(lane), start=job.begin,
                times=job.wanted, progress=False, **job.alone,
            )  # fmt: skip
        except FreebodyError as error:
            motion, reason = getattr(error, "trajectory", None), str(error)
        if motion is not None and motion.interrupted:
            raise KeyboardInterrupt
        if job.texts:
            passed = () if motion is None or reason else motion.warnings
            self.part.texts[row, -1] = reason or " ".join(map(str, passed))
        if motion is None:
            self.part.kept[row] = (NO_START, 0, 0, 0)
            return
        status = motion.path.status
        blame = culprit(motion.path, motion.kernels) if status in dense_output.FAILED else 0
        self.keep(row, motion)
        self.part.ends[row] = motion.path.end
        self.part.kept[row] = (CODES.get(status, REFUSED), motion.steps, motion.path.rejected, blame)

    def keep(self, row: int, motion: Any) -> None:
        """What was asked for of a motion."""
        job, part = self.job, self.part
        asked = job.asked
        if asked.timed:
            first, last = sorted((motion.path.start, motion.path.end))
            known = (job.wanted >= first) & (job.wanted <= last)
            part.values[row, known] = values(motion, asked.timed_values)
        if asked.reduced:
            part.reduced[row] = extremes(motion, asked.reduced_values)
        for crossing in motion.path.crossings:
            e = crossing.number
            if job.specs[e].terminal and crossing.time == job.begin:
                continue  # it ends no run, and is not what ends this one
            if part.counts[row, e] == 0:
                part.event_times[row, e, 0] = crossing.time
            part.event_times[row, e, 1] = crossing.time
            part.counts[row, e] += 1
        names = [spec.name for spec in job.specs]
        for one in motion.warnings:
            for e in (names.index(one.event), names.index(one.event) + job.limits):
                for begin, _ in one.spans:
                    if part.counts[row, e] == 0:
                        part.event_times[row, e, 0] = begin
                    part.event_times[row, e, 1] = begin
                    part.counts[row, e] += 1
        if asked.timeline:
            told = [[c.contact, c.mode, c.start, c.end, c.why] for c in motion.modes]
            part.texts[row, 0] = json.dumps(told)
