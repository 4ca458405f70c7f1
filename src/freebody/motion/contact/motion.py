"""Simulation of a machine with contacts, from the initial state to the trajectory."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, cast

import numpy as np

from ...errors import SimulationError, nearest
from ..kernels.kernels import Kernels
from ..legs.blow import blows_of, scheduled
from ..legs.failure import failure
from ..ode.dense_output import FAILED, Array, observe
from ..start.arguments import check_forwards
from ..start.initial import number
from ..trajectory.event import EventSpec
from .impacts import ORDERS
from .run import run
from .state import CHOICES, ContactRun
from .trajectory import ContactTrajectory


def touching_motion(
    kernels: Kernels,
    values: Mapping[str, float],
    state: Array,
    begin: float,
    end: float,
    specs: Sequence[EventSpec],
    expressions: Sequence[Any],
    tolerances: Array,
    times: Array | None,
    samples: int | None,
    *,
    order: str,
    indeterminate: str,
    method: str,
    max_step: float | None,
    max_steps: int | None,
    impulses: Any,
    between: Callable[[float], None] | None,
) -> ContactTrajectory:
    """Return the motion of a machine with contacts. The arguments are those of `simulate`, already read.

    Raises
    ------
    SimulationError
        For impossible coefficients, initial states with bodies inside each other, Painlevé's paradoxes, and all that
        `simulate` refuses.
    """
    model = kernels.model
    if order not in ORDERS:
        raise SimulationError(f"Unknown order of impacts {order!r}; {nearest(str(order), ORDERS)}")
    if indeterminate not in CHOICES:
        raise SimulationError(
            f"Expected indeterminate='compliance' (the limit of equal compliance) or 'refuse', got {indeterminate!r}."
        )
    check_forwards(begin, end, "a machine with contacts", "friction and impacts")
    check_coefficients(model, values)
    timed, called = scheduled(kernels, values, blows_of(impulses), begin, end)
    n = model.n_q + model.n_u
    relative = np.concatenate([tolerances[:n], [tolerances[:n].max(initial=1e-12)] * 2])
    absolute = relative.copy()
    work = ContactRun(
        kernels,
        values,
        expressions,
        specs,
        relative,
        absolute,
        order,
        {
            "method": "dop853" if method == "auto" else method,
            "max_step": math.inf if max_step is None else float(max_step),
        },
        max_steps,
        timed,
        called,
        indeterminate == "compliance",
    )
    y = np.concatenate([state[:n], [0.0, 0.0]])
    program = kernels.motion()
    energies = observe(
        program.address("energy"), 2, np.array([begin]), y[None], program.constants(work.parameters)
    )[0]
    size = float(np.abs(energies).max())
    absolute[-2:] *= size if 0 < size < math.inf else 1.0
    try:
        path = run(work, state, begin, end, between)
    except SimulationError as error:
        if work.segments and getattr(error, "trajectory", None) is None:
            error.trajectory = _trajectory(kernels, values, work, None, specs, tolerances, times, samples)  # type: ignore[attr-defined]
        raise
    trajectory = _trajectory(kernels, values, work, path, specs, tolerances, times, samples)
    if path.status in FAILED:
        raise failure(trajectory, cast(Any, path), kernels, end, work.specs)
    return trajectory


def _trajectory(
    kernels: Kernels,
    values: Any,
    work: ContactRun,
    path: Any,
    specs: Any,
    tolerances: Any,
    times: Any,
    samples: Any,
) -> ContactTrajectory:
    from ..trajectory.phases import Phases

    if path is None:
        path = Phases(tuple(work.segments), "failed")
        for change in work.changes:
            change[3] = path.end if change[3] is None else change[3]
    return ContactTrajectory(
        kernels, values, path, specs, tolerances, times, samples, happenings=work.happenings, changes=work.changes,
        unknown=work.indeterminate,
    )  # fmt: skip


def check_coefficients(model: Any, values: Mapping[str, float]) -> None:
    """Raise unless the coefficients of friction and restitution are in their ranges."""
    for c in model.contacts:
        mu = number(model, values, c.friction, f"the friction of contact '{c.name}'")
        static = number(model, values, c.static_friction, f"the static friction of contact '{c.name}'")
        e = number(model, values, c.restitution, f"the restitution of contact '{c.name}'")
        if not mu >= 0:
            raise SimulationError(f"Expected a friction of contact '{c.name}' of at least 0, got {mu:g}.")
        if not static >= mu:
            raise SimulationError(
                f"Expected a static friction of contact '{c.name}' of at least the kinetic one, {mu:g}, got {static:g}."
            )
        if not 0 <= e <= 1:
            raise SimulationError(
                f"Expected a restitution of contact '{c.name}' from 0 (no rebound) to 1 (no loss), got {e:g}."
            )
