"""(d2) Piles of spheres and a wall of bricks, all pairs, in steps of 2 ms: families beside MuJoCo's elliptic cone."""

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
    bodies = "".join(
        f'<body pos="{x} {y} {z}"><freejoint/><geom type="sphere" size="{RADIUS}" mass="1"/></body>'
        for x, y, z in places(n)
    )
    return _mujoco(bodies, until, {})


def _mujoco(bodies: str, until: float, speeds: dict[int, float]) -> tuple[float, float]:
    """Return seconds of a step of bodies over a plane, with some speeds at the start, and the greatest penetration."""
    import mujoco

    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{STEP}" cone="elliptic" tolerance="1e-10"/>'
        f'<default><geom condim="3" friction="{MU} 0 0"/></default>'
        f'<worldbody><geom type="plane" size="0 0 1"/>{bodies}</worldbody></mujoco>'
    )
    data, deepest, seconds = mujoco.MjData(model), 0.0, 0.0
    for k, speed in speeds.items():
        data.qvel[k] = speed
    for _ in range(round(until / STEP)):
        begin = time.process_time()
        mujoco.mj_step(model, data)
        seconds += time.process_time() - begin
        deepest = max(deepest, -float(data.contact.dist.min(initial=0.0)))
    return seconds / (until / STEP), deepest


BRICK = (0.2, 0.1, 0.1)


def wall_places() -> list[tuple[float, float, float]]:
    """Return the centres of 5 × 4 bricks."""
    return [((j + 0.25 * (i % 2)) * 0.201, 0.0, 0.05 + 0.1 * i) for i in range(5) for j in range(4)]


SPEEDS = (4.0, 4.5, 5.0, 5.5, 6.0)
"""Speeds of the ball [m/s]: a wall that falls is chaotic, and no single one tells much."""


def our_wall(until: float) -> tuple[float, float, float]:
    """Return seconds of a step of a wall of bricks that a ball hits, the greatest residual, and the depth."""
    import freebody as fb

    s, start = fb.System("wall"), {}
    s.gravity = (0, 0, -9.81)
    shapes: list[Any] = [s.ground.plane(normal="z")]
    for i, place in enumerate(wall_places()):
        body = s.body(f"b{i}", fb.box(2, BRICK))
        s.free(f"f{i}", s.ground, body)
        shapes.append(body.box(BRICK))
        start |= {f"f{i}_{c}": x for c, x in zip("xyz", place, strict=True)}
    ball = s.body("ball", fb.sphere(5, 0.1))
    s.free("air", s.ground, ball)
    s.contacts("wall", [*shapes, ball.sphere(0.1)], friction=MU)
    start |= {"air_x": 0.4, "air_y": -0.6, "air_z": 0.3}
    options: dict[str, Any] = {"method": "timestepping", "step": STEP}
    fb.simulate(s, STEP, initial=start, **options)
    begin = time.process_time()
    motions = [fb.simulate(s, until, initial=start | {"air_vy": speed}, **options) for speed in SPEEDS]
    seconds = (time.process_time() - begin) / (until / STEP * len(SPEEDS))
    return seconds, max(m.residual for m in motions), max(m.depth for m in motions)


def mujoco_wall(until: float) -> tuple[float, float]:
    """Return seconds of a step of that wall, and the greatest penetration."""
    half = " ".join(str(x / 2) for x in BRICK)
    bodies = "".join(
        f'<body pos="{x} {y} {z}"><freejoint/><geom type="box" size="{half}" mass="2"/></body>'
        for x, y, z in wall_places()
    )
    ball = '<body pos="0.4 -0.6 0.3"><freejoint/><geom type="sphere" size="0.1" mass="5"/></body>'
    found = [_mujoco(bodies + ball, until, {-5: speed}) for speed in SPEEDS]
    return sum(seconds for seconds, _ in found) / len(found), max(depth for _, depth in found)


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
    until = 0.2 if quick else 1.0
    step, residual, depth = our_wall(until)
    row = ["wall of 20 bricks, hit", "-", time_text(step), f"{residual:.0e}", f"{depth:.0e}"]
    if module("mujoco") is None:
        table.append([*row, NOT_INSTALLED, "-", "-"])
    else:
        theirs, deepest = mujoco_wall(until)
        table.append([*row, time_text(theirs), f"{deepest:.0e}", f"{theirs / step:.3g}×"])
    show(
        "Piles of spheres and a wall, all pairs, steps of 2 ms (processor time)",
        ["spheres", "first step", "step", "residual", "depth (m)", "MuJoCo step", "depth (m)", "theirs/ours"],
        table,
        [
            "first step: with the code and the memory made for it. Means over 1 s; 1,000 spheres 0.3 s; of the wall "
            f"over {len(SPEEDS)} speeds of the ball, too.",
            "MuJoCo: the same masses, sizes, friction and steps, elliptic cones, Newton's method to 1e-10, contacts as "
            "soft as by default.",
        ],
    )
