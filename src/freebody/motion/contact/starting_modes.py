"""The modes in which a motion with contacts starts, without the motion: nothing is compiled but where laws tie.

What a run does at its first moment: contacts that approach collide, then the complementarity problem of the
accelerations gives the modes (`contact_modes`).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ...describe.system import System
from ...dynamics.state import float_state
from ...dynamics.unilateral import MotionWarning
from ...errors import SimulationError
from ...model.model import Model
from ..kernels.kernels import Kernels, kernels_of
from ..legs.driven import at_time
from ..ode.dense_output import Array
from ..start.initial import initial_state
from ..start.loop_closure import closed_start
from .bounces import lifted
from .complementarity import SLIP, STICK
from .modes import modes_at
from .motion import check_coefficients
from .run import check_apart
from .scene import SMOOTH, Scene, Snapshot
from .state import ContactRun


def starting_modes(
    s: System | Model,
    initial: Mapping[Any, Any] | None = None,
    near: Mapping[Any, Any] | None = None,
    values: Mapping[Any, Any] | None = None,
) -> dict[str, str]:
    """The mode of every element of a contact just after the start; arguments as of `simulate`.

    Raises
    ------
    ModelError, SimulationError
        Parameters without values, a start off the constraints or with bodies in each other, Painlevé's paradoxes.
    """
    # a model is mostly one of this call, and shall not drive out the machines that run again and again
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
            f"The contacts of '{work.model.name}' have no direction at its start: {error}. Begin elsewhere, initial=."
        ) from None
    dead = work.dead(modes, seen, y)
    result = {}
    for k, (name, mode) in enumerate(zip(work.names, modes, strict=True)):
        held = k in dead and mode in ("slip+", "slip-")
        result[name] = STICK if held else SLIP if mode == SMOOTH else mode
    return result


class _Start(ContactRun):
    """The contacts at the start of a run that goes no further."""

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
        """Nothing is told."""


class _Evaluated(Scene):
    """The contacts as numbers, evaluated and not compiled: one state is cheaper than a kernel."""

    def __init__(self, kernels: Kernels, values: Mapping[str, float]) -> None:
        super().__init__(kernels)
        self._given = values

    def constants(self, parameters: Array) -> Array:
        """The values themselves."""
        return parameters

    def at(self, t: float, y: Array, constants: Array) -> Snapshot:
        """The contacts at a state."""
        del constants
        n = self.model.n_q
        state = float_state(self.model, y[:n].tolist(), y[n : n + self.model.n_u].tolist(), t, self._given)
        return self.snapshot(np.array([float(x) for x in self._functions(state)["scene"]]))
