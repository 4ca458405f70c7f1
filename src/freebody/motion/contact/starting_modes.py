"""Modes in which a motion with contacts starts, without the motion. Code is compiled only to decide between ties.

This is the first moment of a run: contacts that approach collide, then the complementarity problem of the
accelerations gives the modes (`modes`).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ...describe.system import System
from ...dynamics.unilateral import MotionWarning
from ...errors import SimulationError
from ...model.model import Model
from ..kernels.kernels import Kernels, kernels_of
from ..ode.dense_output import Array
from ..phase.scene import SMOOTH, Scene, Snapshot
from ..start.initial import initial_state
from ..start.loop_closure import closed_start
from ..start.signals import at_time
from .bounces import lifted
from .complementarity import SLIP, STICK
from .modes import modes_at
from .motion import check_coefficients
from .run import check_apart
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
    work = _Start(kernels, numbers)
    y = np.concatenate([state[: work.n + work.model.n_u], [0, 0]])
    try:
        seen = work.look(0, y)
        check_apart(work, y, seen)
        y, _ = work.collide(0, y, seen)
        y = lifted(work, 0, y)
        modes, _, seen = modes_at(work, 0, y, ("",) * len(work.names))
    except (ArithmeticError, ValueError) as error:
        raise SimulationError(
            f"The contacts of '{work.model.name}' have no direction at its start: {error}. "
            "Choose other initial values, initial=."
        ) from None
    dead = work.dead(modes, seen, y)
    result = {}
    for k, (name, mode) in enumerate(zip(work.names, modes, strict=True)):
        held = k in dead and mode in ("slip+", "slip-")
        result[name] = STICK if held else SLIP if mode == SMOOTH else mode
    return result


class _Start(ContactRun):
    """A run that ends at its start."""

    def __init__(self, kernels: Kernels, values: Mapping[str, float]) -> None:
        none = np.empty(0)
        super().__init__(
            kernels, values, (), (), none, none, "simultaneous", {}, None, scene=_Evaluated(kernels, values)
        )

    def gained(self, t: float, y: Array, seen: Snapshot, impulses: Array) -> float:
        """No ledger is kept."""
        return 0

    def tell(
        self, t: float, name: str, before: Array, after: Array, text: str, warnings: tuple[MotionWarning, ...] = ()
    ) -> None:  # fmt: skip
        """No happening is recorded."""


class _Evaluated(Scene):
    """The contacts as numbers, evaluated without compilation: for one state this is cheaper than a kernel."""

    def __init__(self, kernels: Kernels, values: Mapping[str, float]) -> None:
        super().__init__(kernels)
        self._given = values

    def constants(self, parameters: Array) -> Array:
        """Return the parameters themselves."""
        return parameters

    def at(self, t: float, y: Array, constants: Array) -> Snapshot:
        """Return the contacts at a state."""
        del constants
        return self.evaluated(t, y, self._given)
