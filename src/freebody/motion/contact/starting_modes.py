"""Modes in which a motion with contacts starts, without the motion. Code is compiled only to decide between ties.

This is the first moment of a run: contacts that approach collide, then the complementarity problem of the
accelerations gives the modes (`decision`).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ...describe.system import System
from ...errors import SimulationError
from ...model.model import Model
from ..events import event_run
from ..events.code import code
from ..kernels.kernels import Kernels, kernels_of
from ..ode.dense_output import Array
from ..phase.phase import KINDS, SMOOTH, Modes
from ..phase.scene import Scene
from ..start.initial import initial_state
from ..start.loop_closure import closed_start
from ..start.signals import at_time
from .memory import Watched
from .motion import check_coefficients
from .run import check_apart, refusal
from .state import ContactRun


def starting_modes(
    s: System | Model,
    initial: Mapping[Any, Any] | None = None,
    near: Mapping[Any, Any] | None = None,
    values: Mapping[Any, Any] | None = None,
) -> dict[str, str]:
    """Return the mode of every contact element just after the start. The arguments are those of `simulate`.

    Raises
    ------
    ModelError, SimulationError
        For parameters without values, initial values that violate the constraints, bodies inside each other,
        Painlevé's paradoxes.
    """
    # a Model is mostly made for this call only, and must not push machines that run often out of the cache
    kernels = kernels_of(s) if isinstance(s, System) else Kernels(s)
    numbers = at_time(kernels.model, kernels.values(values), 0)
    if kernels.model.constraints:
        state, active = closed_start(kernels, numbers, initial or {}, near or {}, 0, False)
        kernels = kernels.holding(active)
    else:
        state = initial_state(kernels.model, numbers, initial or {})
    check_coefficients(kernels.model, numbers)
    work = ContactRun(kernels, numbers, Scene(kernels))
    try:
        modes, dead = _modes(work, np.concatenate([state[: work.n + work.n_u], [0, 0]]))
    except (ArithmeticError, ValueError) as error:
        raise SimulationError(
            f"The contacts of '{work.model.name}' have no value at its start: {error}. "
            "Choose other initial values, initial=."
        ) from None
    result = {}
    for contact, mode, held in zip(work.model.contacts, modes, dead, strict=True):
        rests = held and mode in ("slip+", "slip-")
        result[contact.name] = contact.shown("stick" if rests else "slip" if mode == SMOOTH else mode)
    return result


def _modes(work: ContactRun, y: Array) -> tuple[Modes, list[int]]:
    """Return the modes after the impacts at the start, and which contacts the others hold."""
    it = work.it
    see(work, y)
    check_apart(work, y, work.seen())
    said(work, code("strike")(it, work.memory.problem))
    y[work.n : work.n + work.n_u] += it.whole @ work.seen().responses
    it.hit, leaving = 0, 1
    while leaving != 0:
        see(work, y)
        why = code("decide")(it, work.memory.problem)
        if why == event_run.ASK_KERNELS:
            work.memory.equip(work.parameters, Watched("dop853"))
            leaving = 1
            continue
        said(work, why)
        leaving = code("begin_to_leave")(it)
        if leaving < 0:
            work.memory.equip(work.parameters, Watched("dop853"))
    code("find_dead")(it, work.memory.problem)
    return tuple(KINDS[mode] for mode in it.mode), it.dead.tolist()


def said(work: ContactRun, reason: int) -> None:
    """Raise the error of a reason, if there is one."""
    if reason:
        raise refusal(work, reason)


def see(work: ContactRun, y: Array) -> None:
    """Look at the contacts at the start, and find those that are closed."""
    it = work.it
    it.y[:] = y
    it.seen[:], it.adhering[:] = work.scene.outputs(0, y, work.values), 0
    code("find_closed")(it)
    code("choose_all")(it)
