"""(b) Forward dynamics: accelerations of chains, per call, per state of a batch, and the time to compile.

The same chain (general mass centres and inertia matrices, hinge axes x, y, x, ...) is given to freebody, Pinocchio
and MuJoCo; their accelerations must agree before anything is timed.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .chains import alternating_chain, chain_state, mujoco_chain, pinocchio_chain
from .tables import per_call

SIZES = (1, 2, 7, 30, 100)
AGREEMENT = 1e-9
BATCH = 4096


class Pinocchio:
    """``aba`` per call: a Python loop of calls, less the same loop on a model without joints.

    The model without joints has the same conversions and the same call; only the recursion is empty.
    """

    def __init__(self, n: int) -> None:
        import pinocchio

        self.aba = pinocchio.aba
        self.model, self.data = pinocchio_chain(alternating_chain(n))
        self.empty, self.empty_data = pinocchio_chain([])
        self.q, self.u = chain_state(n)
        self.tau = np.zeros(n)

    def accelerations(self) -> np.ndarray:
        return self.aba(self.model, self.data, self.q, self.u, self.tau).copy()

    def time(self, repeats: int) -> float:
        nothing = np.zeros(0)

        def loop(model: Any, data: Any, *arguments: Any) -> Any:
            aba = self.aba

            def calls(n: int) -> None:
                for _ in range(n):
                    aba(model, data, *arguments)

            return calls

        full = per_call(loop(self.model, self.data, self.q, self.u, self.tau), repeats)
        overhead = per_call(loop(self.empty, self.empty_data, nothing, nothing, nothing), repeats)
        return full - overhead


class MuJoCo:
    """``mj_step`` per step, looped in C (``nstep``): Euler, contacts and constraints off, a step of 1e-12 s."""

    def __init__(self, n: int) -> None:
        import mujoco

        self.mujoco = mujoco
        self.model, self.data = mujoco_chain(alternating_chain(n), timestep=1e-12)
        self.q, self.u = chain_state(n)

    def accelerations(self) -> np.ndarray:
        self.data.qpos[:], self.data.qvel[:] = self.q, self.u
        self.mujoco.mj_forward(self.model, self.data)
        return self.data.qacc.copy()

    def time(self, repeats: int) -> float:
        return per_call(lambda n: self.mujoco.mj_step(self.model, self.data, nstep=n), repeats)


def agreement(found: np.ndarray, expected: np.ndarray) -> float:
    """Largest difference relative to the largest acceleration."""
    return float(abs(found - expected).max() / abs(expected).max())
