"""(d2) Piles of spheres, all pairs, in steps of 2 ms: a family of contacts beside MuJoCo's elliptic cone."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from .tables import NOT_INSTALLED, module, show, time_text

RADIUS, MU, STEP = 0.05, 0.5, 2e-3


def places(n: int) -> Any:
    """Return the centres of n spheres in layers of squares, a little displaced, half as wide as high."""
    side, rng = max(2, int(np.ceil((n / 2) ** (1 / 3)))), np.random.default_rng(1)
    k = np.arange(n)
    x, y, layer = k % side, k // side % side, k // side**2
    grid = np.stack([x - (side - 1) / 2, y - (side - 1) / 2, layer], axis=1) * 2.2 * RADIUS
    return grid + [0, 0, 1.05 * RADIUS] + rng.uniform(-0.1, 0.1, (n, 3)) * [RADIUS, RADIUS, 0]


def pile(n: int) -> tuple[Any, dict[str, float]]:
    """Return a machine of n spheres over a floor, and its start."""
    import freebody as fb

    s, start = fb.System("pile"), {}
    s.gravity = (0, 0, -9.81)
    shapes = [s.ground.plane(normal="z")]
    for i, place in enumerate(places(n)):
        body = s.body(f"b{i}", fb.sphere(1, RADIUS))
        s.free(f"f{i}", s.ground, body)
        shapes.append(body.sphere(RADIUS))
        start |= {f"f{i}_{c}": float(x) for c, x in zip("xyz", place, strict=True)}
    s.contacts("pile", shapes, friction=MU)
    return s, start


def ours(n: int, until: float) -> tuple[float, float, Any]:
    """Return seconds of the first step with all that is made before it, seconds of a step, and the motion."""
    import freebody as fb

    s, start = pile(n)
    options = {"initial": start, "method": "timestepping", "step": STEP}
    fb.assemble(s)
    begin = time.process_time()
    fb.simulate(s, STEP, **options)
    first = time.process_time() - begin
    begin = time.process_time()
    motion = fb.simulate(s, until, **options)
    return first, (time.process_time() - begin) / (until / STEP), motion


def mujoco_pile(n: int, until: float) -> tuple[float, float]:
    """Return seconds of a step, and the greatest penetration."""
    import mujoco

    bodies = "".join(
        f'<body pos="{x} {y} {z}"><freejoint/><geom type="sphere" size="{RADIUS}" mass="1"/></body>'
        for x, y, z in places(n)
    )
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{STEP}" cone="elliptic"/><default><geom condim="3" friction="{MU} 0 0"/></default>'
        f'<worldbody><geom type="plane" size="0 0 1"/>{bodies}</worldbody></mujoco>'
    )
    data, deepest, seconds = mujoco.MjData(model), 0.0, 0.0
    for _ in range(round(until / STEP)):
        begin = time.process_time()
        mujoco.mj_step(model, data)
        seconds += time.process_time() - begin
        deepest = max(deepest, -float(data.contact.dist.min(initial=0.0)))
    return seconds / (until / STEP), deepest


def main(quick: bool = False, repeats: int = 1, limit: float = 0.0) -> None:
    """Print the table."""
    del repeats, limit
    table = []
    for n in (60, 300) if quick else (60, 300, 1000):
        until = 0.3 if n == 1000 else 1.0
        first, step, motion = ours(n, until)
        row = [n, time_text(first), time_text(step), f"{motion.residual:.0e}", f"{motion.depth:.0e}"]
        if module("mujoco") is None:
            table.append([*row, NOT_INSTALLED, "-", "-"])
        else:
            theirs, deepest = mujoco_pile(n, until)
            table.append([*row, time_text(theirs), f"{deepest:.0e}", f"{theirs / step:.3g}×"])
    show(
        "Piles of spheres, all pairs, steps of 2 ms (processor time)",
        ["spheres", "first step", "step", "residual", "depth (m)", "MuJoCo step", "depth (m)", "theirs/ours"],
        table,
        [
            "first step: with the code and the memory made for it. Means over 1 s, of 1,000 spheres over 0.3 s."
        ],
    )
