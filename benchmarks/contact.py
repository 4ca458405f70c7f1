"""(d) Contact: slip or no slip, penetration, drift and time, beside MuJoCo and Drake with their default settings."""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Callable
from typing import Any

from .contact_peers import drake_block, mujoco_block, mujoco_disk, mujoco_rod
from .tables import NOT_INSTALLED, module, show, time_text

G = 9.81
MU = 0.4
STEP = 1e-3


def block(angle: float) -> Any:
    """A box of 2 kg on an incline, gravity turned by its angle."""
    import freebody as fb

    s = fb.System("incline")
    s.gravity = (G * math.sin(angle), -G * math.cos(angle), 0)
    box = s.body("box", fb.box(2, (1, 0.2, 1)))
    s.planar("rail", s.ground, box, coordinate="x y turn")
    feet = box.corners((-0.5, -0.1, 0), (0.5, -0.1, 0))
    s.contact("foot", feet, s.ground.plane(normal="y"), friction=MU)
    return s


def disk(force: float, height: float = 0.4) -> Any:
    """A disk of 10 kg and radius 0.3 m, pulled along the floor at a height (Example 6.3)."""
    import freebody as fb

    s = fb.System("disk")
    s.gravity = (0, -G, 0)
    body = s.body("disk", fb.disk(10, 0.3))
    s.planar("rail", s.ground, body, coordinate="x y turn")
    s.contact("floor", body.circle(0.3), s.ground.plane(normal="y"), friction=0.2)
    s.force("F", body.origin, (force, 0, 0))
    s.torque("tau", body, (0, 0, -force * (height - 0.3)))
    return s


def rod() -> Any:
    """A rod of 2 kg and 1.5 m that falls on a rough floor (Problem 6.11)."""
    import freebody as fb

    s = fb.System("rod")
    s.gravity = (0, -G, 0)
    bar = s.body("bar", fb.slender_bar(2, 1.5, axis="y"))
    s.planar("rail", s.ground, bar, coordinate="x y theta")
    s.contact("tip", bar.corners((0, -0.75, 0), (0, 0.75, 0)), s.ground.plane(normal="y"), friction=0.3)
    return s


def our_block(angle: float, until: float, **options: Any) -> tuple[float, float, float]:
    """(displacement, last acceleration, greatest penetration)."""
    import freebody as fb

    motion = fb.simulate(block(angle), until, initial={"y": 0.1}, samples=1001, **options)
    v, t = motion["x'"], motion.t
    depth = max(float(-one.gap.min()) for one in motion.contacts.values())
    return float(motion["x"][-1]), float((v[-1] - v[500]) / (t[-1] - t[500])), max(0.0, depth)


Run = Callable[[float, float], tuple[float, float, float]]


def incline(who: str, run: Run, long: float) -> list[list[Any]]:
    """Rows of one engine: 0.1 % below and above the angle of friction."""
    rows = []
    for part in (0.999, 1.001):
        angle = math.atan(MU) * part
        exact = max(0.0, G * (math.sin(angle) - MU * math.cos(angle)))
        _, a, depth = run(angle, 2.0)
        slips = abs(a) > 0.5 * G * (math.sin(math.atan(MU) * 1.001) - MU * math.cos(math.atan(MU) * 1.001))
        right = "right" if slips == (part > 1) else "wrong"
        drift = f"{abs(run(angle, long)[0]):.1e}" if part < 1 else "-"
        rows.append(
            [
                who, f"{100 * (part - 1):+.1f} %", f"{'slips' if slips else 'sticks'}: {right}",
                f"{abs(a - exact):.1e}", f"{depth:.1e}", drift,
            ]
        )  # fmt: skip
    return rows


def timed(call: Callable[[], float], repeats: int) -> float:
    """Median of the seconds that a call reports."""
    call()
    return statistics.median(call() for _ in range(max(3, repeats)))


def ours(system: Any, until: float, **options: Any) -> Callable[[], float]:
    """Seconds of the whole ``fb.simulate`` call, per simulated second."""
    import freebody as fb

    def call() -> float:
        begin = time.perf_counter()
        fb.simulate(system, until, **options)
        return (time.perf_counter() - begin) / until

    return call


def main(quick: bool = False, repeats: int = 5, limit: float = 0.0) -> None:
    """Print the tables."""
    del limit
    long = 10.0 if quick else 100.0
    rows = incline("freebody", our_block, long)
    rows += incline(
        "freebody, time stepping 1 ms",
        lambda angle, until: our_block(angle, until, method="timestepping", step=STEP),
        long,
    )
    for who, needs, run in (
        ("MuJoCo, defaults, 1 ms", "mujoco", lambda angle, until: mujoco_block(angle, until, STEP, MU)),
        (
            "MuJoCo, elliptic cone, 1 ms", "mujoco",
            lambda angle, until: mujoco_block(angle, until, STEP, MU, elliptic=True),
        ),
        ("Drake, defaults, 1 ms", "pydrake", lambda angle, until: drake_block(angle, until, STEP, MU)),
    ):  # fmt: skip
        if module(needs) is None:
            rows.append([who, NOT_INSTALLED, "-", "-", "-", "-"])
        else:
            rows += incline(who, run, long)
    show(
        f"Block on an incline at the angle of friction, mu = {MU}",
        [
            "", "angle beside atan mu", "decision", "acceleration error (m/s²)", "penetration (m)",
            f"drift in {long:g} s (m)",
        ],
        rows,
        [
            "decision: slips if it accelerates at more than half of what it should at +0.1 %. Drift: of the block that",
            "should stay. Penetration: of the contact points; of Drake's box, its centre.",
        ],
    )  # fmt: skip

    theta = 1e-3
    fall = {"y": 0.75 * math.cos(theta), "x": -0.75 * math.sin(theta), "theta": theta}
    pulled = {"y": 0.3}
    cases: list[tuple[str, Callable[[], float], Callable[[], float]]] = [
        (
            "pulled disk, rolls (30 N)",
            ours(disk(30.0), 10.0, initial=pulled),
            lambda: mujoco_disk(30.0, 10.0, STEP),
        ),
        (
            "pulled disk, slips (250 N)",
            ours(disk(250.0), 10.0, initial=pulled),
            lambda: mujoco_disk(250.0, 10.0, STEP),
        ),
        (
            "falling rod, sticks, slips, hits, rests",
            ours(rod(), 4.0, initial=fall),
            lambda: mujoco_rod(theta, 4.0, STEP),
        ),
    ]
    table = []
    for label, mine, theirs in cases:
        a = timed(mine, repeats)
        b = timed(theirs, repeats) if module("mujoco") is not None else None
        table.append(
            [
                label,
                time_text(a),
                NOT_INSTALLED if b is None else time_text(b),
                "-" if b is None else f"{b / a:.3g}×",
            ]
        )
    show(
        "Time per simulated second",
        ["", "freebody, tolerance 1e-9", "MuJoCo, defaults, 1 ms", "theirs/ours"],
        table,
        [
            "ours: the whole fb.simulate call, machine code made before; MuJoCo: mj_step in a loop of its own rollout."
        ],
    )
