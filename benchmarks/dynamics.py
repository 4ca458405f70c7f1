"""(b) Forward dynamics: accelerations of chains, per call, per state of a batch, and the time to compile.

The same chain (general mass centres and inertia matrices, hinge axes x, y, x, ...) is given to freebody, Pinocchio
and MuJoCo; their accelerations must agree before anything is timed.
"""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from .chains import alternating_chain, chain_state, mujoco_chain, pinocchio_chain
from .loop import repeater
from .tables import NOT_INSTALLED, module, per_call, ratio_text, seconds, show, time_text

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


class Freebody:
    """Forward dynamics by the compiled kernel's address in a loop of machine code; batches by ``fb.compile``."""

    def __init__(self, n: int) -> None:
        import freebody as fb

        from .models import numeric_chain

        self.n = n
        self.system = numeric_chain(alternating_chain(n))
        self.program = fb.compile(self.system)
        self.q, self.u = chain_state(n)

    def compiled(self) -> Any:
        from .models import forward_dynamics_kernels

        return forward_dynamics_kernels(self.system)

    def accelerations(self) -> np.ndarray:
        return self.program.forward_dynamics(self.q, self.u)

    def time(self, repeats: int) -> float:
        kernels = self.compiled()
        kernel, constants = kernels["accelerations"], np.ascontiguousarray(kernels.constants([]), dtype=float)
        state, out = np.concatenate([self.q, self.u]), np.zeros(self.n)
        loop = repeater(kernel.address, state, constants, out)
        loop(1)
        if not agreement(out, self.accelerations()) < AGREEMENT:
            raise ArithmeticError(
                f"{self.n} bodies: the timed kernel differs from fb.compile's forward dynamics"
            )
        return per_call(loop, repeats)

    def batch_time(self, repeats: int) -> float:
        """Of the whole call from Python."""
        q, u = np.random.default_rng(1).uniform(-1, 1, (2, BATCH, self.n))
        self.program.forward_dynamics(q, u)
        return seconds(lambda: self.program.forward_dynamics(q, u), repeats) / BATCH

    def compile_time(self, repeats: int) -> float:
        return seconds(self.compiled, repeats)

    def simulation_time(self) -> float:
        """From the description to the first step of a simulation: rates, energies and the integrator."""
        import freebody as fb

        from .models import numeric_chain

        system = numeric_chain(alternating_chain(self.n))
        start = time.perf_counter()
        fb.simulate(system, until=1e-6)
        return time.perf_counter() - start


@contextmanager
def without_cache() -> Iterator[None]:
    """Compile anew: no object code is taken from the disk."""
    before = os.environ.get("FREEBODY_CACHE")
    os.environ["FREEBODY_CACHE"] = "off"
    try:
        yield
    finally:
        if before is None:
            del os.environ["FREEBODY_CACHE"]
        else:
            os.environ["FREEBODY_CACHE"] = before


COLUMNS = (
    "n", "freebody call", "in a batch", "compile", "to simulate",
    "Pinocchio aba", "ratio", "MuJoCo step", "ratio", "differ",
)  # fmt: skip
PEERS = {"pinocchio": Pinocchio, "mujoco": MuJoCo}


def main(quick: bool = False, repeats: int = 5, limit: float = 0.0) -> None:
    """Print the table."""
    del limit
    rows: list[list[Any]] = []
    import freebody as fb

    from .models import numeric_chain

    fb.simulate(numeric_chain(alternating_chain(1)), until=1e-6)  # imports, and the integrator's own code
    for n in (1, 2, 7, 30) if quick else SIZES:
        with without_cache():
            ours = Freebody(n)
            compile_time = ours.compile_time(1 if n > 10 else repeats)
            ready = ours.simulation_time()
        found = ours.accelerations()
        call, batch = ours.time(repeats), ours.batch_time(repeats)
        row = [n, time_text(call), time_text(batch), time_text(compile_time), time_text(ready)]
        worst = 0.0
        for name, make in PEERS.items():
            if module(name) is None:
                row += [NOT_INSTALLED, "-"]
                continue
            peer = make(n)
            difference = agreement(found, peer.accelerations())
            if not difference < AGREEMENT:
                raise ArithmeticError(f"{n} bodies: accelerations differ from {name}'s by {difference:.1e}")
            worst = max(worst, difference)
            theirs = peer.time(repeats)
            row += [time_text(theirs), ratio_text(theirs, call)]
        rows.append([*row, f"{worst:.0e}"])
    show(
        "Forward dynamics of chains of n bodies, hinge axes x, y, x, ...",
        [
            "n",
            "freebody call",
            "in a batch",
            "compile",
            "to simulate",
            "Pinocchio aba",
            "ratio",
            "MuJoCo step",
            "ratio",
            "differ",
        ],
        rows,
        [
            f"freebody: kernel called by address in a compiled loop; batch: {BATCH} states by fb.compile, per state;",
            "compile: from the description, nothing cached; to simulate: to fb.simulate's first step.",
            "Pinocchio: loop of aba calls in Python less the same loop on a model without joints (call, conversions).",
            "MuJoCo: mj_step looped in C (nstep), Euler, contacts and constraints off; integration included.",
            "differ: largest difference of the accelerations relative to the largest; above 1e-9 the run stops.",
        ],
    )
