"""(d) Contact: slip or no slip, penetration, drift and time, beside MuJoCo and Drake with their default settings.

The times are those of the figures that were asked for, each beside its bound. Robots come with packages
(``pip install '.[robots]'``).
"""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from . import mujoco_peer, robots
from .contact_peers import drake_block, mujoco_block, mujoco_coins, mujoco_disk, mujoco_fall, mujoco_rod
from .tables import NOT_INSTALLED, module, show, time_text

G = 9.81
MU = 0.4
STEP = 1e-3
COIN = 0.012, 0.002
RESISTANCE, REST = 2e-4, 8.0
"""Resistance of coins to rolling and spinning [m], without which they roll for ever, and when all lie at rest [s]."""


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


def coin() -> Any:
    """A coin of 5 g, 24 mm wide and 2 mm thick, whose two circular edges touch a floor, with resistance to turns."""
    import freebody as fb

    s = fb.System("coin")
    s.gravity = (0, 0, -G)
    body = s.body("coin", fb.cylinder(0.005, *COIN))
    s.free("f", s.ground, body)
    laws = {"friction": 0.4, "restitution": 0.4, "rolling": RESISTANCE, "spinning": RESISTANCE}
    for name, z in (("head", COIN[1] / 2), ("tail", -COIN[1] / 2)):
        edge = body.circle(COIN[0], at=(0, 0, z), axis="z")
        s.contact(name, edge, s.ground.plane(normal="z"), **laws)
    return s


def throws(count: int) -> list[dict[str, float]]:
    """Starts 0.3 m above the floor, turned at random and turning."""
    rng, result = np.random.default_rng(1), []
    for _ in range(count):
        turn, spin = rng.normal(size=4), 20 * rng.normal(size=3)
        names = (*(f"f_e{k}" for k in range(4)), *(f"f_w{c}" for c in "xyz"))
        numbers = (*(turn / np.linalg.norm(turn)), *spin)
        result.append({"f_z": 0.3} | {name: float(x) for name, x in zip(names, numbers, strict=True)})
    return result


def robot(name: str) -> tuple[Path, Any, dict[str, float]] | None:
    """Return the file of a robot, its machine over a floor, and a start 5 cm above it; None if it is not installed."""
    import freebody as fb

    files = robots.files() if name.endswith(".urdf") else mujoco_peer.files()
    path = next((path for path in files if path.parts[-len(Path(name).parts) :] == Path(name).parts), None)
    if path is None:
        return None
    s = fb.read(path, base="free", contacts="floor", symbols="none")
    start = fb.on_floor(s, initial=s.reading.initial)
    height = next(key for key in start if key.endswith("_z"))
    return path, s, start | {height: start[height] + 0.05}


def timed(call: Callable[[], float], repeats: int) -> float:
    """Median of the seconds that a call reports."""
    call()
    return statistics.median(call() for _ in range(max(3, repeats)))


def ours(system: Any, until: float, starts: Sequence[Any], **options: Any) -> Callable[[], float]:
    """Mean seconds of the whole ``fb.simulate`` call."""
    import freebody as fb

    def call() -> float:
        begin = time.process_time()
        for start in starts:
            fb.simulate(system, until, initial=start, **options)
        return (time.process_time() - begin) / len(starts)

    return call


def at_rest(system: Any, until: float, starts: Sequence[Any]) -> str:
    """How many of the throws lie at rest in the end."""
    import freebody as fb

    ends = [fb.simulate(system, until, initial=start).at(until).u for start in starts]
    return f"{sum(abs(u).max() < 1e-9 for u in ends)} of {len(ends)} at rest after {until:g} s"


def ledger(system: Any, until: float, starts: Sequence[Any]) -> str:
    """Greatest residual of the energy, relative to the greatest kinetic energy."""
    import freebody as fb

    motions = [fb.simulate(system, until, initial=start) for start in starts]
    return f"{max(abs(m.energy.residual).max() / m.energy.kinetic.max() for m in motions):.0e}"


def figures(quick: bool, repeats: int) -> None:
    """Print the times, each beside its bound; of disk and rod per simulated second."""
    theta = 1e-3
    fall = {"y": 0.75 * math.cos(theta), "x": -0.75 * math.sin(theta), "theta": theta}
    coins = throws(10 if quick else 40)
    steps = {"method": "timestepping", "step": 2 * STEP}
    rows = []

    def row(label: str, wanted: float, scene: Any, until: float, starts: Any, theirs: Any, per: float = 1.0,
            **options: Any) -> None:  # fmt: skip
        if scene is None:
            rows.append([label, NOT_INSTALLED, time_text(wanted), "-", "-"])
            return
        mine = timed(ours(scene, until, starts, **options), repeats) / per
        peer = (
            NOT_INSTALLED if module("mujoco") is None else "-" if theirs is None else timed(theirs, repeats)
        )
        exact = "-" if options else ledger(scene, until, starts)
        rows.append([label, time_text(mine), time_text(wanted), exact, time_text(peer)])

    for label, force in (("rolls (30 N)", 30.0), ("slips (250 N)", 250.0)):
        peer = partial(mujoco_disk, force, 10.0, STEP)
        row(f"pulled disk, {label}", 5e-5, disk(force), 10.0, [{"y": 0.3}], peer, 10.0)
    peer = partial(mujoco_rod, theta, 4.0, STEP)
    row("falling rod, sticks, slips, hits, rests", 3e-4, rod(), 4.0, [fall], peer, 4.0)
    peer = partial(mujoco_coins, COIN, RESISTANCE, coins, REST, STEP)
    row(
        f"coin of two circular edges, thrown, {at_rest(coin(), REST, coins)}", 0.05, coin(), REST, coins, peer
    )
    quadruped, humanoid = robot("go1_description/urdf/go1.urdf"), robot("dm_control/suite/humanoid.xml")
    _, s, start = quadruped or (None, None, {})
    row("Go1 dropped, 0.5 s", 2.0, s, 0.5, [start], None)
    path, s, start = humanoid or (Path(), None, {})
    peer = partial(mujoco_fall, path, 0.05, 1.0, 2 * STEP)
    row("humanoid dropped, 1 s", 5.0, s, 1.0, [start], peer)
    row("humanoid dropped, 1 s, time steps of 2 ms", 0.2, s, 1.0, [start], peer, **steps)
    show(
        "Time of motions with contacts, by events unless said otherwise (processor time)",
        ["", "freebody, tolerance 1e-9", "wanted", "ledger", "MuJoCo"],
        rows,
        [
            "ours: the whole fb.simulate call, machine code made before; disk and rod per simulated second, the coin "
            "mean of its throws.",
            "MuJoCo: mj_step in a loop of its own rollout, defaults, 1 ms; humanoid 2 ms. Ledger: greatest residual of "
            "the energy over the greatest kinetic energy.",
        ],
    )


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
    figures(quick, repeats)
