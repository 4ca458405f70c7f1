"""What contacts do in the last step that has been done, as sensors of controllers read it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np

from ..ending import End
from ..kernels.contact_quantities import Asked
from ..ode.dense_output import Rates
from ..phase.candidates import stretch_numbers
from .course import InSteps
from .intervals import Intervals
from .pair_motion import PairLog
from .steps import Impulses, Stepping, Steps


def touched(run: Any, asked: Asked) -> dict[Any, float]:
    """Return quantities of contacts: gap and speeds at the end of the last step, and the mean forces in it.

    Before the first step no force has acted: forces and margins are 0, as the margin of an open contact is.
    """
    k, model, numbers = run.done, run.model, dict(run.problem.numbers)
    some, log = slice(max(k - 1, 0), k), run.log
    times, states = run.grid.times[some.start : k + 1], run.states[some.start : k + 1]
    entries = log.entries[log.ends[some.start] : log.ends[k]]
    did = Impulses(
        run.impulses[some, : run.rows] * stretch_numbers(model, numbers), run.impulses[some, run.rows :],
        run.works[some], run.moved[some], run.modes[some], {}, PairLog(entries, np.array([0, len(entries)])),
    )  # fmt: skip
    rates = Rates(0, states.shape[1], run.memory.machine.c, tuple(model.quaternions))
    path = Steps(rates, times, run.grid.lengths[some], states, (), End.FINISHED, 0, 0, len(states))
    at_once = Intervals(np.zeros(1, dtype=np.int64), run.values.parameters[None], np.zeros(1))
    course = InSteps(
        run.kernels, numbers, path, did, Stepping(run.grid.longest, 0.0, 0.0, 0.0, 0),
        (run.first, run.tangents), at_once,
    )  # fmt: skip
    contacts = course.contacts(SimpleNamespace(t=times[-1:], states=states[-1:]))  # type: ignore[arg-type]
    return {terms: sum(_number(contacts[name], what, j) for name, what, j in terms) for terms in asked}


def _number(contact: Any, what: str, component: int) -> float:
    """Return a quantity of a contact, or a component of it, at the end of the step."""
    value = float(np.ravel(getattr(contact, what)[0])[component])
    return 0.0 if what == "margin" and not np.isfinite(value) else value
