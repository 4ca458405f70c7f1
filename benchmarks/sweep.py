"""(d) A sweep: heavy tops, each with its own start and spin, beside a process pool of SciPy's DOP853.

The pool has a process on each processor, and its rates are freebody's machine code: faster than any a user would write.
"""

from __future__ import annotations

import multiprocessing
import os
import time
from typing import Any

import numpy as np

from .models import heavy_top
from .references import TOP
from .tables import show, time_text

OUTPUTS = ["psi", "theta", "phi", "psi'", "theta'", "phi'"]
LANES, SPAN, TOLERANCE = 100_000, 10.0, 1e-9


def starts(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Inclination and spin of every top."""
    rng = np.random.default_rng(1)
    return rng.uniform(0.3, 1.3, count), rng.uniform(80.0, 150.0, count)


class Worker:
    """A process of the pool: the rates, made once."""

    def __init__(self) -> None:
        from freebody.motion.kernels.kernels import kernels_of

        kernels = kernels_of(heavy_top(TOP))
        program = kernels.motion()
        self.kernel = program.compiled["rates"]
        self.constants = program.constants(kernels.parameters(kernels.model.values({})))
        self.names = list(kernels.names)

    def rates(self, t: float, y: np.ndarray) -> np.ndarray:
        return self.kernel.unchecked(t, y, self.constants)

    def run(self, start: tuple[float, float]) -> tuple[float, int, np.ndarray]:
        """(processor seconds, evaluations, final state) of one trajectory."""
        from scipy.integrate import solve_ivp

        y = np.zeros(len(self.names))
        y[self.names.index("theta")], y[self.names.index("phi'")] = start
        begin = time.process_time()
        found = solve_ivp(self.rates, (0.0, SPAN), y, method="DOP853", rtol=TOLERANCE, atol=TOLERANCE)
        seconds = time.process_time() - begin
        return seconds, found.nfev, found.y[[self.names.index(name) for name in OUTPUTS], -1]


worker: Worker


def prepare(ready: Any) -> None:
    """Make the worker of this process and wait for the others."""
    global worker
    worker = Worker()
    worker.run((0.5, 100.0))
    ready.wait()


def work(start: tuple[float, float]) -> tuple[float, int, np.ndarray]:
    """A trajectory in a process of the pool."""
    return worker.run(start)


def pool_runs(
    theta: np.ndarray, spin: np.ndarray, repeats: int
) -> tuple[list[float], list[float], int, np.ndarray]:
    """Wall and mean processor seconds per trajectory of each repeat, evaluations of one, final states."""
    context, count = multiprocessing.get_context("spawn"), processors()
    ready = context.Barrier(count + 1)
    jobs = list(zip(theta.tolist(), spin.tolist(), strict=True))
    wall, processor = [], []
    with context.Pool(count, prepare, (ready,)) as pool:
        ready.wait()
        for _ in range(repeats):
            begin = time.perf_counter()
            found = pool.map(work, jobs, chunksize=max(1, len(jobs) // (4 * count)))
            wall.append((time.perf_counter() - begin) / len(jobs))
            processor.append(float(np.mean([seconds for seconds, _, _ in found])))
    evaluations = sum(n for _, n, _ in found) // len(jobs)
    return wall, processor, evaluations, np.array([last for _, _, last in found])


def main(quick: bool = False, repeats: int = 5, limit: float = 0.0) -> None:
    """Print the table."""
    del limit
    import freebody as fb

    system = heavy_top(TOP)
    lanes = 4_000 if quick else LANES
    few = 100 if quick else 400
    theta, spin = starts(lanes)

    def ours(count: int, threads: int, clock: Any = time.process_time) -> tuple[float, Any]:
        begin = clock()
        found = fb.simulate(
            system, SPAN, initial={"theta": theta[:count], "phi'": spin[:count]}, tolerance=TOLERANCE,
            outputs=OUTPUTS, times=[SPAN], threads=threads, progress=False,
        )  # fmt: skip
        return clock() - begin, found

    ours(few, 1)
    many = min(5 * few, lanes)
    mine = [ours(many, 1)[0] / many for _ in range(max(1, repeats))]
    wall, processor, evaluations, last = pool_runs(theta[:few], spin[:few], max(1, repeats))
    one, other, elapsed = (float(np.median(times)) for times in (mine, processor, wall))
    whole, data = ours(lanes, processors(), time.perf_counter)
    exact = ours_at(system, theta[:few], spin[:few])
    mine_error = np.abs(np.stack([data[name][:few, -1] for name in OUTPUTS], axis=-1) - exact).max()
    other_error = np.abs(last - exact).max()
    ended = int((data.status == "finished").sum())
    pool = f"pool of {processors()} processes of SciPy DOP853 on the same machine code"
    show(
        f"{lanes} heavy tops for {SPAN:g} s at {TOLERANCE:g}",
        ["", "processor time per trajectory", "worst error", "all, elapsed"],
        [
            ["freebody, fb.simulate with arrays", time_text(one), f"{mine_error:.1e}", f"{whole:.1f} s"],
            [pool, time_text(other), f"{other_error:.1e}", f"{elapsed * lanes:.0f} s, extrapolated"],
            ["ratio", f"{other / one:.0f}×", "", f"{elapsed * lanes / whole:.0f}×"],
        ],
        [
            f"processor time: one core's, median of {len(mine)} repeats; ours over {many} trajectories at once,",
            f"SciPy's over {few} in the pool, summed in its processes without what the pool itself takes.",
            f"all, elapsed: {lanes} trajectories on {processors()} processors, {ended} of ours finished; the pool's",
            f"from its {few}, processes and code being ready. SciPy evaluates the rates {evaluations} times each.",
            f"worst error: of angles and their rates at {SPAN:g} s over {few} trajectories, against runs at 1e-14.",
        ],
    )


def ours_at(system: Any, theta: np.ndarray, spin: np.ndarray) -> np.ndarray:
    """Final states of high accuracy."""
    import freebody as fb

    data = fb.simulate(
        system, SPAN, initial={"theta": theta, "phi'": spin}, tolerance=1e-14, method="gauss", outputs=OUTPUTS,
        times=[SPAN], progress=False,
    )  # fmt: skip
    return np.stack([data[name][:, -1] for name in OUTPUTS], axis=-1)


def processors() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
