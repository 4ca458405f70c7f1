"""(b) Forward dynamics: accelerations of chains, per call, per state of a batch, and the time to compile.

Beside the batch stands the machine's arithmetic limit, operations / (additions per second), measured in turns with it:
what else runs on the machine slows both.

The same machine (general mass centres and inertia matrices, hinge axes x, y, x, ...) is given to freebody, Pinocchio
and MuJoCo; their accelerations must agree before anything is timed.
"""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from statistics import median
from typing import Any

import numpy as np

from . import floating_tree
from .chains import alternating_chain, chain_state, mujoco_chain, pinocchio_chain
from .loop import additions, lanes, repeater
from .tables import NOT_INSTALLED, module, per_call, ratio_text, seconds, show, time_text

TREE = "tree"
"""A flying body with six limbs of five hinges: 36 degrees of freedom."""
SIZES = (1, 2, 7, 12, 30, TREE, 100, 300, 1000)
QUICK = (1, 2, 7, 12, 30, TREE)
PEERS_UP_TO = 100  # bodies; longer chains break the peers' own builders off
AGREEMENT = 1e-9
BATCH = 4096
BATCHES = 5  # as many per repeat


class Pinocchio:
    """``aba`` per call: a Python loop of calls, less the same loop on a model without joints.

    The model without joints has the same conversions and the same call; only the recursion is empty.
    """

    def __init__(self, n: int | str) -> None:
        import pinocchio

        self.aba = pinocchio.aba
        self.empty, self.empty_data = pinocchio_chain([])
        self.tree = n == TREE
        if isinstance(n, str):
            self.model, self.data = floating_tree.pinocchio_tree()
            self.q, self.u = floating_tree.pinocchio_state(*floating_tree.state())
        else:
            self.model, self.data = pinocchio_chain(alternating_chain(n))
            self.q, self.u = chain_state(n)
        self.tau = np.zeros(len(self.u))

    def accelerations(self) -> np.ndarray:
        found = self.aba(self.model, self.data, self.q, self.u, self.tau).copy()
        return floating_tree.from_pinocchio(found) if self.tree else found

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

    def __init__(self, n: int | str) -> None:
        import mujoco

        self.mujoco = mujoco
        self.tree = n == TREE
        if isinstance(n, str):
            self.model, self.data = floating_tree.mujoco_tree(timestep=1e-12)
            self.q, self.u = floating_tree.mujoco_state(*floating_tree.state())
        else:
            self.model, self.data = mujoco_chain(alternating_chain(n), timestep=1e-12)
            self.q, self.u = chain_state(n)

    def accelerations(self) -> np.ndarray:
        self.data.qpos[:], self.data.qvel[:] = self.q, self.u
        self.mujoco.mj_forward(self.model, self.data)
        found = self.data.qacc.copy()
        return floating_tree.from_mujoco(found, *floating_tree.state()) if self.tree else found

    def time(self, repeats: int) -> float:
        return per_call(lambda n: self.mujoco.mj_step(self.model, self.data, nstep=n), repeats)


WEIGHTS = {"sincos": 34}
"""Operations of a function in the arithmetic of the others; a division counts as one, although it takes longer."""


def agreement(found: np.ndarray, expected: np.ndarray) -> float:
    """Largest difference relative to the largest acceleration."""
    return float(abs(found - expected).max() / abs(expected).max())


class Freebody:
    """Forward dynamics by the compiled kernel's address in a loop of machine code; batches by ``fb.compile``."""

    def __init__(self, n: int | str) -> None:
        import freebody as fb

        self.n = n
        self.system = self.described()
        self.program = fb.compile(self.system)
        self.q, self.u = floating_tree.state() if isinstance(n, str) else chain_state(n)

    def described(self) -> Any:
        """The machine."""
        from .models import numeric_chain

        return floating_tree.system() if isinstance(self.n, str) else numeric_chain(alternating_chain(self.n))

    def accelerations(self) -> np.ndarray:
        return self.program.forward_dynamics(self.q, self.u)

    def time(self, repeats: int) -> float:
        kernel, constants = (
            self.program.kernel("forward_dynamics"),
            self.program.constants("forward_dynamics"),
        )
        state, out = np.concatenate([self.q, self.u]), np.zeros(len(self.u))
        loop = repeater(kernel.address, state, constants, out)
        loop(1)
        if not agreement(out, self.accelerations()) < AGREEMENT:
            raise ArithmeticError(f"{self.n}: the timed kernel differs from fb.compile's forward dynamics")
        return per_call(loop, repeats)

    def batch_times(self, repeats: int) -> tuple[float, float]:
        """Of one state of a batch, the whole call from Python; and of its operations if all that can add does [s].

        Time of this thread: a batch is long enough for others to get the processor meanwhile.
        """
        random = np.random.default_rng(1)
        q, u = random.uniform(-1, 1, (BATCH, len(self.q))), random.uniform(-1, 1, (BATCH, len(self.u)))
        counts = self.program.kernel("forward_dynamics").operations
        cost = sum(WEIGHTS.get(code, 1) * count for code, count in counts.items())
        self.program.forward_dynamics(q, u)
        times, limits = [], []
        for _ in range(BATCHES * repeats):
            limits.append(cost / additions())
            start = time.thread_time()
            self.program.forward_dynamics(q, u)
            times.append((time.thread_time() - start) / BATCH)
        return median(times), median(limits)

    def compile_time(self, repeats: int) -> float:
        """From the description: assembled, recorded, compiled."""
        import freebody as fb
        from freebody.program.large.link_step import compiled_step

        return seconds(
            lambda: fb.compile(self.system).kernel("forward_dynamics"),
            repeats,
            before=compiled_step.cache_clear,
        )

    def simulation_time(self) -> float:
        """From the description to the first step of a simulation: rates, energies and the integrator."""
        import freebody as fb
        from freebody.program.large.link_step import compiled_step

        compiled_step.cache_clear()
        system = self.described()
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


PEERS = {"pinocchio": Pinocchio, "mujoco": MuJoCo}


def main(quick: bool = False, repeats: int = 5, limit: float = 0.0) -> None:
    """Print the table."""
    del limit
    rows: list[list[Any]] = []
    import freebody as fb

    from .models import numeric_chain

    fb.simulate(numeric_chain(alternating_chain(1)), until=1e-6)  # imports, and the integrator's own code
    for n in QUICK if quick else SIZES:
        with without_cache():
            ours = Freebody(n)
            compile_time = ours.compile_time(repeats if n in (1, 2, 7) else 1)
            ready = ours.simulation_time()
        found = ours.accelerations()
        call, (batch, least) = ours.time(repeats), ours.batch_times(repeats)
        row = [n, time_text(call), time_text(batch), time_text(least), ratio_text(batch, least)]
        row += [time_text(compile_time), time_text(ready)]
        worst: float | None = None
        for name, make in PEERS.items():
            if module(name) is None:
                row += [NOT_INSTALLED, "-", "-"]
                continue
            if isinstance(n, int) and n > PEERS_UP_TO:
                row += ["-", "-", "-"]
                continue
            peer = make(n)
            difference = agreement(found, peer.accelerations())
            if not difference < AGREEMENT:
                raise ArithmeticError(f"{n}: accelerations differ from {name}'s by {difference:.1e}")
            worst = max(worst or 0.0, difference)
            theirs = peer.time(repeats)
            row += [time_text(theirs), ratio_text(theirs, call), ratio_text(theirs, batch)]
        rows.append([*row, "-" if worst is None else f"{worst:.0e}"])
    show(
        "Forward dynamics of chains of n bodies, hinge axes x, y, x, ..., and of a floating tree",
        [
            "n",
            "freebody call",
            "in a batch",
            "limit",
            "above",
            "compile",
            "to simulate",
            "Pinocchio aba",
            "call",
            "batch",
            "MuJoCo step",
            "call",
            "batch",
            "differ",
        ],
        rows,
        [
            f"freebody: kernel called by address in a compiled loop; batch: {BATCH} states by fb.compile, per state;",
            f"limit: operations (sincos as {WEIGHTS['sincos']}) / additions per second, {lanes()} at a time;",
            "above: batch over limit, measured in turns; it can be below 1, as fused products and sums count twice;",
            "tree: a flying body with six limbs of five hinges, 36 degrees of freedom.",
            "compile: from the description, nothing cached; to simulate: to fb.simulate's first step.",
            "call, batch: how many times longer the peer takes than our call, and than one state of our batch.",
            "Pinocchio: loop of aba calls in Python less the same loop on a model without joints (call, conversions).",
            "MuJoCo: mj_step looped in C (nstep), Euler, contacts and constraints off; integration included.",
            "differ: largest difference of the accelerations relative to the largest; above 1e-9 the run stops.",
        ],
    )
