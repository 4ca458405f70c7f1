"""Rows and ladders of closed loops of growing length: processor time of a step against the number of loops.

``row``     N four-bars side by side on the ground, which share cranks (`problems.four_bars`), with singular positions
``ladder``  N four-bars, each on the coupler of the one before; its first second

The slope is that of the logarithms from the size before to this one: 1 for a cost that is linear in N. MuJoCo steps the
same row without contacts; its loops are closed by soft constraints (``connect``), so that it takes no account of
singular positions and its bars drift apart: the time of its step is no time of the same task.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any

from .problems import four_bars, four_bars_start
from .tables import module, show, time_text

SIZES = (1, 2, 5, 10, 20, 40, 100, 200)
QUICK = (1, 10, 40)


def ladder(n: int) -> tuple[Any, dict[str, float]]:
    """``n`` parallelograms of rods of 1 m and 1 kg that hang one below the other, and their start, bent by 0.03."""
    import freebody as fb

    s = fb.System(f"ladder of {n}")
    s.gravity = (0, -9.81, 0)
    base: Any = s.ground
    left, right = (0.0, 0, 0), (1.0, 0, 0)
    start = {}
    for i in range(1, n + 1):
        a, c, b = (
            s.body(f"{name}{i}", fb.slender_bar(1, 1, axis="x")) for name in ("left", "coupler", "right")
        )
        s.hinge(f"A{i}", base, a, at=left, to=(-0.5, 0, 0), axis="z", coordinate=f"a{i}")
        s.hinge(f"B{i}", a, c, at=(0.5, 0, 0), to=(-0.5, 0, 0), axis="z", coordinate=f"c{i}")
        s.hinge(f"D{i}", base, b, at=right, to=(-0.5, 0, 0), axis="z", coordinate=f"b{i}")
        s.hinge(f"C{i}", b, c, at=(0.5, 0, 0), to=(0.5, 0, 0), axis="z")
        base, left, right = c, (-0.5, 0, 0), (0.5, 0, 0)
        angle = -math.pi / 2 + 0.03 * (-1) ** i
        start |= {f"a{i}": angle, f"b{i}": angle, f"c{i}": -angle}
    return s, start


def row(n: int) -> tuple[Any, dict[str, float]]:
    """The row and its start."""
    return four_bars(n), four_bars_start(n)


def measured(machine: tuple[Any, dict[str, float]], until: float, repeats: int) -> tuple[float, float, int]:
    """Seconds of the first result, and of a step of a repeated run (the best), and the number of steps."""
    import freebody as fb

    system, start = machine
    begin = time.process_time()
    motion = fb.simulate(system, until, initial=start)
    first, best = time.process_time() - begin, math.inf
    for _ in range(repeats):
        begin = time.process_time()
        motion = fb.simulate(system, until, initial=start)
        best = min(best, time.process_time() - begin)
    return first, best / motion.steps, motion.steps


def mujoco_step(n: int, repeats: int) -> float:
    """Seconds of a step of the row in MuJoCo."""
    import mujoco

    rod = '<inertial pos="0.5 0 0" mass="1" diaginertia="1e-6 0.08333333 0.08333333"/>'
    bodies, closed = [], []
    for i in range(n + 1):
        hinge = '<joint type="hinge" axis="0 0 1"/>'
        coupler = (
            f'<body name="k{i + 1}" pos="1 0 0" euler="0 0 -1.5707963">{hinge}{rod}</body>' if i < n else ""
        )
        bodies.append(f'<body name="c{i}" pos="{i} 0 0" euler="0 0 1.5707963">{hinge}{rod}{coupler}</body>')
        if i:
            closed.append(f'<connect body1="k{i}" body2="c{i}" anchor="1 0 0"/>')
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><compiler angle="radian"/><option gravity="0 -9.81 0" timestep="0.001"><flag contact="disable"/>'
        f"</option><worldbody>{''.join(bodies)}</worldbody><equality>{''.join(closed)}</equality></mujoco>"
    )
    data, best = mujoco.MjData(model), math.inf
    data.qvel[0] = -1.0
    for _ in range(repeats):
        begin = time.process_time()
        for _ in range(50):
            mujoco.mj_step(model, data)
        best = min(best, (time.process_time() - begin) / 50)
    return best


def main(quick: bool = False, repeats: int = 3, limit: float | None = None) -> None:
    """Print a table for each machine."""
    peer = module("mujoco")
    machines: list[tuple[str, Callable[[int], Any], float]] = [("row", row, 10.0), ("ladder", ladder, 1.0)]
    for name, machine, until in machines:
        lines, before = [], None
        for n in QUICK if quick else SIZES:
            first, step, steps = measured(machine(n), until, repeats)
            slope = "" if before is None else f"{math.log(step / before[1]) / math.log(n / before[0]):.2f}"
            theirs = mujoco_step(n, repeats) if peer is not None and name == "row" else None
            lines.append([
                str(n), time_text(first), str(steps), time_text(step), slope,
                "" if theirs is None else time_text(theirs),
            ])  # fmt: skip
            before = n, step
        show(
            f"{name} of four-bars, {until:g} s",
            ["loops", "first", "steps", "a step", "slope", "MuJoCo"],
            lines,
        )
