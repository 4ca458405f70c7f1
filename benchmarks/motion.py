"""(c) Motion: heavy top for 10 s, tumbling body for 100 s; error against 30-digit references, and time."""

from __future__ import annotations

import statistics
import time
from functools import partial
from typing import Any

import numpy as np

from .motion_peers import (
    drake_motion,
    mujoco_motion,
    numbers,
    orientation_error,
    quaternion_of_angles,
    scipy_motion,
)
from .references import references
from .tables import NOT_INSTALLED, module, show, time_text

TITLES = {
    "heavy_top": "Heavy top, spin 100 rad/s, let go from rest at 60°, 10 s",
    "tumbling": "Tumbling body, moments 1, 2, 3, turning about the middle axis at 3 rad/s, 100 s",
}


def freebody_motion(name: str, motion: dict[str, Any]) -> Any:
    """``run(tolerance)`` -> (seconds of ``fb.simulate``, quaternions); the machine code is made beforehand."""
    import freebody as fb

    from .models import heavy_top, tumbling_body

    p = numbers(motion)
    times = motion["times"]
    if name == "heavy_top":
        system: Any = heavy_top(motion["parameters"])
        initial = {"theta": float(np.arccos(p["cos_theta0"])), "phi'": p["spin"]}
    else:
        system = tumbling_body(motion["parameters"])
        initial = dict(zip(("turn_wx", "turn_wy", "turn_wz"), p["w0"], strict=True))

    def run(tolerance: float) -> tuple[float, np.ndarray]:
        begin = time.perf_counter()
        trajectory = fb.simulate(system, until=times[-1], initial=initial, tolerance=tolerance)
        elapsed = time.perf_counter() - begin
        at = trajectory.at(times)
        if name == "heavy_top":
            return elapsed, quaternion_of_angles(
                *(np.asarray(at[angle]) for angle in ("psi", "theta", "phi"))
            )
        return elapsed, np.stack([np.asarray(at[f"turn_e{i}"]) for i in range(4)], axis=-1)

    run(1e-3)
    return run


def runs_of(name: str, motion: dict[str, Any], quick: bool) -> list[tuple[str, str, str | None, Any]]:
    """(who, setting, module it needs, call) of every run; freebody's first."""
    tolerances = (1e-6, 1e-9, 1e-12)
    ours = freebody_motion(name, motion)
    runs: list[tuple[str, str, str | None, Any]] = []
    for tolerance in (*tolerances, 1e-14):
        runs.append(("freebody", f"tolerance {tolerance:.0e}", None, partial(ours, tolerance)))
    for tolerance in tolerances:
        call = partial(scipy_motion, name, motion, tolerance)
        runs.append(("SciPy DOP853 on lambdified SymPy", f"tolerance {tolerance:.0e}", "scipy", call))
    for step in (1e-3,) if quick else (1e-3, 1e-4):
        runs.append(
            ("MuJoCo RK4", f"step {step:.0e} s", "mujoco", partial(mujoco_motion, name, motion, step))
        )
    for label, scheme, accuracy in (
        ("Drake, default RK3", "runge_kutta3", 1e-3),
        ("Drake RK5", "runge_kutta5", 1e-12),
    ):
        call = partial(drake_motion, name, motion, accuracy, scheme)
        runs.append((label, f"accuracy {accuracy:.0e}", "pydrake", call))
    return runs


def measured(call: Any, motion: dict[str, Any], repeats: int) -> tuple[float, float]:
    """(error, median seconds) of one run."""
    outcomes = [call()]
    while len(outcomes) < repeats and outcomes[0][0] < 1:  # long runs vary little
        outcomes.append(call())
    error = orientation_error(outcomes[0][1], motion["quaternions"])
    return error, statistics.median(outcome[0] for outcome in outcomes)


def main(quick: bool = False, repeats: int = 5, limit: float = 0.0) -> None:
    """Print a table for each motion."""
    del limit
    for name, motion in references().items():
        rows: list[list[Any]] = []
        mine: list[tuple[float, float]] = []
        for label, setting, needs, call in runs_of(name, motion, quick):
            if needs is not None and module(needs) is None:
                rows.append([label, setting, NOT_INSTALLED, "-", "-", "-"])
                continue
            error, seconds = measured(call, motion, repeats)
            if label == "freebody":
                mine.append((error, seconds))
                ratio = "-"
            else:  # our cheapest run that is at least as accurate as this one
                equal = [ours_seconds for ours_error, ours_seconds in mine if ours_error <= error]
                ratio = f"{seconds / min(equal):.3g}×" if equal else "-"
            per_second = seconds / motion["times"][-1]
            rows.append([label, setting, f"{error:.1e}", time_text(seconds), time_text(per_second), ratio])
        show(
            TITLES[name],
            ["", "setting", "error (rad)", "time", "per simulated s", "against ours"],
            rows,
            [
                "error: largest angle between attitudes at ten times, against a 30-digit reference (references.py).",
                "against ours: time over that of our cheapest run with an equal or smaller error. Describing and",
                "compiling are outside the clock for everybody; ours is the whole fb.simulate call.",
            ],
        )
