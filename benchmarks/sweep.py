"""(d) A sweep: heavy tops, each with its own start and spin, beside SciPy's DOP853 on the same machine code."""

from __future__ import annotations

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


def scipy_runs(system: Any, theta: np.ndarray, spin: np.ndarray) -> tuple[float, int, np.ndarray]:
    """(seconds, evaluations, final states) of SciPy's runs, one after another, on the machine code of freebody."""
    from scipy.integrate import solve_ivp

    from freebody.simulate.kernels import kernels_of

    kernels = kernels_of(system)
    program = kernels.motion()
    kernel = program.compiled["rates"]
    c = program.constants(kernels.parameters(kernels.model.values({})))
    names = list(kernels.names)
    last, evaluations = [], 0

    def rates(t: float, y: np.ndarray) -> np.ndarray:
        return kernel.unchecked(t, y, c)

    begin = time.process_time()
    for a, b in zip(theta, spin, strict=True):
        y = np.zeros(len(names))
        y[names.index("theta")], y[names.index("phi'")] = a, b
        found = solve_ivp(rates, (0.0, SPAN), y, method="DOP853", rtol=TOLERANCE, atol=TOLERANCE)
        evaluations += found.nfev
        last.append(found.y[:, -1])
    asked = [names.index(name) for name in OUTPUTS]
    return time.process_time() - begin, evaluations, np.array(last)[:, asked]


def main(quick: bool = False, repeats: int = 5, limit: float = 0.0) -> None:
    """Print the table."""
    del limit
    import freebody as fb

    system = heavy_top(TOP)
    lanes = 4_000 if quick else LANES
    few = 20 if quick else 100
    theta, spin = starts(lanes)

    def ours(count: int, threads: int, clock: Any = time.process_time) -> tuple[float, Any]:
        begin = clock()
        found = fb.simulate(
            system, SPAN, initial={"theta": theta[:count], "phi'": spin[:count]}, tolerance=TOLERANCE,
            outputs=OUTPUTS, times=[SPAN], threads=threads, progress=False,
        )  # fmt: skip
        return clock() - begin, found

    ours(few, 1)
    mine, theirs = [], []
    for _ in range(max(1, repeats)):  # in turn, so that other work on the machine meets both
        mine.append(ours(20 * few, 1)[0] / (20 * few))
        seconds, evaluations, last = scipy_runs(system, theta[:few], spin[:few])
        theirs.append(seconds / few)
    one, other = float(np.median(mine)), float(np.median(theirs))
    whole, data = ours(lanes, _processors(), time.perf_counter)
    exact = ours_at(system, theta[:few], spin[:few])
    mine_error = np.abs(np.stack([data[name][:few, -1] for name in OUTPUTS], axis=-1) - exact).max()
    other_error = np.abs(last - exact).max()
    ended = int((data.status == "finished").sum())
    show(
        f"{lanes} heavy tops for {SPAN:g} s at {TOLERANCE:g}",
        ["", "processor time per trajectory", "worst error", "all"],
        [
            ["freebody, fb.simulate with arrays", time_text(one), f"{mine_error:.1e}", f"{whole:.1f} s"],
            ["SciPy DOP853 on the same machine code", time_text(other), f"{other_error:.1e}", "-"],
            ["ratio", f"{other / one:.0f}×", "", ""],
        ],
        [
            f"processor time: median of {len(mine)} repeats of {20 * few} and {few} runs, on one core, in turn.",
            f"all: {lanes} trajectories on {_processors()} processors, {ended} of them finished; SciPy's would take",
            f"{other * lanes / 60:.0f} core minutes. SciPy evaluates the rates {evaluations / few:.0f} times each.",
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


def _processors() -> int:
    import os

    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
