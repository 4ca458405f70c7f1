"""What contacts do in the last step that has been done, as sensors of controllers read it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np

from ..kernels.contact_quantities import Asked
from .intervals import Intervals


def touched(run: Any, asked: Asked) -> dict[Any, float]:
    """Return quantities of contacts: gap and speeds at the end of the last step, and the mean forces in it.

    Before the first step no force has acted: forces and margins are 0, as the margin of an open contact is.
    """
    k = run.done
    last = slice(max(k - 1, 0), k)
    times, states = run.grid.times[last.start : k + 1], run.states[last.start : k + 1]
    present = Intervals(np.zeros(1, dtype=np.int64), run.values.parameters[None], np.zeros(1))
    course = run.course(last, times, states, present)
    contacts = course.contacts(SimpleNamespace(t=times[-1:], states=states[-1:]))
    return {terms: sum(_number(contacts[name], what, j) for name, what, j in terms) for terms in asked}


def _number(contact: Any, what: str, component: int) -> float:
    """Return a quantity of a contact, or a component of it, at the end of the step."""
    value = float(np.ravel(getattr(contact, what)[0])[component])
    return 0.0 if what == "margin" and not np.isfinite(value) else value
