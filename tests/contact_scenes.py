"""Random small scenes with contacts: boxes, disks, wedges, ladders, stacks, tables, balls and belts, thrown and pushed,
with Newton's and Poisson's restitution."""

import numpy as np
import sympy

import freebody as fb

G = 9.81
IN_PLANE = ("box", "disk", "wedge", "stack", "belt", "incline", "ladder", "pair")
IN_SPACE = ("box", "ball", "disk", "three legs", "four legs", "belt", "dropped box", "wedge", "stack")


def laws(rng, bounces, static):
    mu = float(rng.choice([0.0, 0.1, 0.3, 0.6, 1.0]))
    more = mu * float(rng.choice(static))
    e = float(rng.choice(bounces))
    return {
        "friction": mu, "static_friction": more, "restitution": e, "impact": str(rng.choice(["newton", "poisson"])),
    }  # fmt: skip


def moving_belt(s, normal, speed):
    belt = s.body("belt", fb.particle(1))
    s.slider("drive", s.ground, belt, axis="x", coordinate=speed * s.t)
    return belt.plane(normal=normal)


def plane_scene(seed):
    """A scene in the plane, and its start."""
    rng = np.random.default_rng([7, seed])
    kind = IN_PLANE[seed % len(IN_PLANE)]
    how = laws(rng, [0.0, 0.0, 0.3, 0.6, 0.8], [1.0, 1.0, 1.3])
    s = fb.System(f"{kind} {seed}")
    s.gravity = (0, -G, 0)
    m, (w, h) = float(rng.uniform(1, 4)), rng.uniform(0.2, 0.8, size=2).tolist()
    start = {"x'": float(rng.normal()), "phi'": float(3 * rng.normal())}
    floor = s.ground.plane(normal="y")
    body = s.body("body", fb.disk(m, w) if kind == "disk" else fb.box(m, (w, h, 0.3)))
    if kind == "belt":
        floor = moving_belt(s, "y", float(rng.choice([-1, 1]) * rng.uniform(0.3, 2)))
    if kind == "incline":
        a = float(rng.uniform(-0.6, 0.6))
        floor = s.ground.plane(normal=(-np.sin(a), np.cos(a), 0))
    s.planar("plane", s.ground, body, coordinate="x y phi")
    if kind == "disk":
        s.contact("foot", body.circle(w), floor, **how)
        start["y"] = w + float(rng.uniform(0, 0.5))
    else:
        radius = float(np.hypot(w, h)) / 2
        start["phi"] = float(rng.uniform(-3, 3))
        start["y"] = 1.3 * radius + float(rng.choice([0.0, 0.3, 0.8]) * rng.uniform())
        corners = body.corners(size=(w, h))
        if kind == "wedge":
            corners = body.corners((-w / 2, -h / 2, 0), (w / 2, -h / 2, 0), (-w / 2, h / 2, 0))
        s.contact("foot", corners, floor, **how)
        if kind == "ladder":
            s.contact("wall", corners, s.ground.plane(normal="x"), **how)
            start["x"] = radius + float(0.3 * rng.uniform())
    if kind == "stack":
        other = s.body("other", fb.box(m / 2, (0.8 * w, h / 2, 0.3)))
        s.planar("above", s.ground, other, coordinate="x_2 y_2 phi_2")
        top = body.segment((-w / 2, h / 2, 0), (w / 2, h / 2, 0), normal="y")
        s.contact("up", other.corners((-0.4 * w, -h / 4, 0), (0.4 * w, -h / 4, 0)), top, **how)
        start = {
            "y": h / 2, "y_2": 1.25 * h + float(rng.choice([0, 0.1])), "x_2": float(rng.uniform(-0.3, 0.3) * w),
            "x_2'": float(rng.normal() * rng.choice([0, 1])),
        }  # fmt: skip
    if kind == "pair":
        r = float(rng.uniform(0.1, 0.3))
        disk = s.body("other", fb.disk(m, r))
        s.planar("beside", s.ground, disk, coordinate="x_2 y_2 phi_2")
        s.contact("roll", disk.circle(r), floor, **how)
        side = body.segment((-w / 2, -h / 2, 0), (-w / 2, h / 2, 0), normal=(-1, 0, 0))
        s.contact("hit", disk.circle(r), side, **how)
        start = {
            "y": h / 2, "x_2": -w / 2 - r - 0.4, "y_2": r, "x_2'": float(rng.uniform(0.5, 2)),
            "phi_2'": float(rng.normal()),
        }  # fmt: skip
    if rng.random() < 0.5:
        F = float(rng.uniform(0, 0.8) * m * G) * sympy.cos(int(rng.choice([0, 2, 5])) * s.t)
        s.force("push", body.point(0, float(rng.uniform(-h / 2, h / 2)), 0), (F, 0, 0))
    return s, start


def space_scene(seed):
    """A scene in space, and its start."""
    rng = np.random.default_rng([11, seed])
    kind = IN_SPACE[seed % len(IN_SPACE)]
    how = laws(rng, [0.0, 0.0, 0.3, 0.6], [1.0])
    s = fb.System(f"{kind} {seed}")
    s.gravity = (0, 0, -G)
    m, (a, b, c) = float(rng.uniform(1, 4)), rng.uniform(0.2, 0.6, size=3).tolist()
    start = {f"f_v{x}": float(rng.normal()) for x in "xy"} | {
        f"f_w{x}": float(2 * rng.normal()) for x in "xyz"
    }
    solid = {"ball": fb.sphere(m, a), "disk": fb.disk(m, a)}.get(kind, fb.box(m, (a, b, c)))
    body = s.body("body", solid)
    floor = moving_belt(s, "z", float(rng.uniform(0.3, 2))) if kind == "belt" else s.ground.plane(normal="z")
    s.free("f", s.ground, body)
    down = [(x * a / 2, y * b / 2, -c / 2) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    feet = {
        "ball": lambda: body.sphere(a),
        "disk": lambda: body.circle(a, axis="z"),
        "box": lambda: body.corners(size=(a, b, c)),
        "dropped box": lambda: body.corners(size=(a, b, c)),
        "three legs": lambda: body.corners(
            *[(a * np.cos(x) / 2, a * np.sin(x) / 2, -c / 2) for x in (0.3, 2.4, 4.6)]
        ),
        "wedge": lambda: body.corners(*down, (0, -b / 2, c / 2), (0, b / 2, c / 2)),
    }.get(kind, lambda: body.corners(*down))()
    s.contact("foot", feet, floor, **how)
    start["f_z"] = a + 0.3
    if kind == "disk":
        tilt = float(rng.uniform(0.3, 1.3))
        start["f"] = (float(np.cos(tilt / 2)), float(np.sin(tilt / 2)), 0, 0)
    elif kind in ("box", "wedge"):
        turn = rng.normal(size=4)
        start |= {"f_z": 0.7, "f": tuple((turn / np.linalg.norm(turn)).tolist())}
    elif kind == "dropped box":
        start["f_z"] = 0.6
    elif kind != "ball" and rng.random() < 0.5:  # it stands, and slides and turns
        start |= {"f_z": c / 2, "f_wx": 0.0, "f_wy": 0.0}
    if kind == "stack":
        ball = s.body("other", fb.sphere(m / 2, 0.1))
        s.free("g", s.ground, ball)
        s.contact("up", ball.sphere(0.1), body.plane(at=(0, 0, c / 2), normal="z"), **how)
        start = {"f_z": c / 2, "g_z": c + 0.1, "g_vx": float(0.3 * rng.normal()), "g_wy": float(rng.normal())}
    if rng.random() < 0.5:
        F = float(rng.uniform(0, 0.8) * m * G) * sympy.cos(int(rng.choice([0, 2, 5])) * s.t)
        angle = float(rng.uniform(0, 6))
        at = body.point(0, 0, float(rng.uniform(-c / 2, c / 2)))
        s.force("push", at, (F * np.cos(angle), F * np.sin(angle), 0), frame=s.ground)
    return s, start
