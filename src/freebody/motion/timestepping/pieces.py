"""The course of some steps of a run, and the quantities of contacts in it that events and sensors take.

They are those of the outputs, without what is round-off in a step: 0 are the gap of a rigid contact that closes or
stays closed, the slip of one that sticks, and the margin of one that is open, or slips with one coefficient.
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np

from ...dynamics.conditions.constraints import rows as conditions
from ...model.contact import Contact, friction_varies
from ...model.family import contact_named
from ...model.model import Model
from ..ending import End
from ..families.faces import FAR
from ..kernels.contact_quantities import Asked
from ..moreau.stepping_record import CLOSED_GAP
from ..ode.dense_output import Array, Crossing, Rates
from ..phase.candidates.candidates import stretch_numbers
from .course import InSteps
from .steps import IMPULSES, Impulses, Stepping, Steps


def course_of(run: Any, first: int, last: int, stop: Crossing | None = None) -> InSteps:
    """Return the course of the steps of a run from ``first`` to before ``last``, the last of which ``stop`` may cut."""
    model, numbers, memory, some = run.model, run.problem.numbers, run.memory, slice(first, last)
    states, moments = run.states[first : last + 1], run.grid.times[first : last + 1]
    impulses, works, corrections = (part[some] for part in (run.impulses, run.works, run.moved))
    pairs = run.log.between(first, last)
    if stop is not None:  # within a step: keep its part up to the event
        part = (stop.time - moments[-2]) / run.grid.lengths[last - 1]
        states, moments = (
            np.concatenate([states[:-1], stop.state[None]]),
            np.append(moments[:-1], stop.time),
        )
        impulses, works, corrections = impulses.copy(), works.copy(), corrections.copy()
        corrections[-1] = 0  # that of this step is at its end
        impulses[-1] *= part
        works[-1] *= part
        pairs[-1][:, IMPULSES] *= part
    constraints = np.zeros((len(impulses), len(conditions(model))))
    constraints[:, run.shape.held] = impulses[:, run.rows :]
    did = Impulses(
        impulses[:, : run.rows] * stretch_numbers(model, numbers), constraints, works, corrections, run.modes[some],
        {k - first: told for k, told in run.blows.items() if first <= k < last}, pairs,
    )  # fmt: skip
    seen = 0, states.shape[1], memory.machine.c, tuple(model.quaternions)
    rates = Rates(*seen, run.program, recipe=(Rates, *seen))
    path = Steps(rates, moments, run.grid.lengths[some], states, (), End.FINISHED, 0, 0, len(states))
    sweeps = memory.sweeps / max(run.done, 1)
    stepping = Stepping(run.grid.longest, memory.residual, memory.depth, sweeps, memory.reduced)
    intervals = run.values.intervals().between(first, last)
    return InSteps(run.kernels, dict(numbers), path, did, stepping, (run.first, run.tangents), intervals)


def with_contacts(course: InSteps, asked: Asked) -> Array:
    """Return the states at the ends of the steps of a course, each followed by quantities of contacts.

    They are those of the step that ends there; at the start of a run, those of its first step.
    """
    times, states = course.path.times, course.path.states
    if not asked:
        return states
    model, motion = course.kernels.model, SimpleNamespace(t=times, states=states)
    contacts = course.contacts(motion)  # type: ignore[arg-type]
    sums = [
        np.sum([_quantity(model, contacts[name], name, what, j) for name, what, j in terms], axis=0)
        for terms in asked
    ]
    return np.column_stack([states, *sums])


def touched(run: Any, asked: Asked) -> dict[Any, float]:
    """Return quantities of contacts: gap and speeds at the end of the last step, and the mean forces in it.

    Before the first step no force has acted: forces and margins are 0, as the margin of an open contact is.
    """
    course = course_of(run, max(run.done - 1, 0), run.done)
    numbers = with_contacts(course, asked)[-1, -len(asked) :]
    return dict(zip(asked, numbers.tolist(), strict=True))


def _quantity(model: Model, motion: Any, name: str, what: str, component: int) -> Array:
    """Return a quantity of a contact."""
    value: Array = getattr(motion, what)
    value = value if value.ndim == 1 else value[:, component]
    contact, is_open = cast(Contact, contact_named(model, name)), motion.mode == "open"
    if what == "gap" and not contact.compliant:
        return np.where(~is_open | (np.abs(value) <= CLOSED_GAP), 0.0, np.minimum(value, FAR))
    if what == "slip":
        return np.where(motion.mode == "stick", 0.0, value)
    if what == "margin":
        zero = is_open if friction_varies(model, contact) else motion.mode != "stick"
        return np.where(zero, 0.0, value)
    return np.where(is_open, 0.0, value) if what in ("normal", "tangential") else value
