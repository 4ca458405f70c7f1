"""Random machines of up to three bodies in a plane, with laws of contact that events and time steps both know."""

import numpy as np

import freebody as fb
from contact_scenes import moving_belt

GROUNDS = ("flat", "slope", "road", "belt", "bowl")
BOWL = 3.0


def ground(s, rng, kind):
    """Return the shape on which the bodies land, and its height at x."""
    if kind == "slope":
        a = rng.uniform(-0.4, 0.4)
        return s.ground.plane(normal=(np.sin(a), np.cos(a), 0)), lambda x: 0.6
    if kind == "road":
        high, wave = rng.uniform(0.02, 0.08), rng.uniform(1, 2.5)
        return s.ground.heightline(f"{high:.3f}*cos({wave:.3f}*x)"), lambda x: 0.1
    if kind == "belt":
        return moving_belt(s, "y", round(rng.uniform(-2, 2), 2)), lambda x: 0.0
    if kind == "bowl":
        return s.ground.circle(BOWL, at=(0, BOWL, 0), inside=True), lambda x: BOWL - np.sqrt(BOWL**2 - x**2)
    return s.ground.plane(normal="y"), lambda x: 0.0


def vary(law, rng):
    """Make friction greater at rest, or a law of slip, as the event-driven motion knows it."""
    mu, kind = law["friction"], rng.choice(["static", "stribeck", "viscous"])
    if kind == "static":
        law["static_friction"] = mu * float(rng.uniform(1.1, 1.8))
    elif kind == "stribeck":
        law["friction"] = f"{mu:.4f} + {0.4 * mu:.4f}*exp(-slip/{rng.uniform(0.05, 0.3):.4f})"
    else:
        law["friction"] = f"{mu:.4f} + {rng.uniform(0.02, 0.2):.4f}*slip"


def drive(s, body, rng):
    """Push a body by a signal, and turn it by a sampled controller."""
    times = np.concatenate([[0.0], np.sort(rng.uniform(0.05, 0.95, 5)), [2.0]])
    gust = fb.signal(times, rng.uniform(-8, 8, 7), str(rng.choice(["linear", "previous"])), name="gust")
    s.force("gusts", body.origin, (gust, 0, 0))
    s.parameters(held=0.0)
    s.torque("motor", body, (0, 0, s.expression("held")))
    gain, rate = float(rng.uniform(0.1, 0.5)), "a0'"
    s.controller(
        lambda t, x: gain * (2 * np.sin(5 * t) - x[rate]), float(rng.uniform(0.01, 0.05)), "held", name="pd"
    )


def varied_scene(seed):
    """A scene of `mixed_scene` whose friction varies, with a signal and a controller."""
    return mixed_scene(seed, varied=np.random.default_rng([31, seed]))


def poisson_scene(seed):
    """A scene of `mixed_scene` whose contacts rebound by Poisson's law."""
    return mixed_scene(seed, bounce={"restitution": 0.3, "impact": "poisson"})


def mixed_scene(seed, varied=None, bounce=None):
    """A scene, its start and the coordinates to compare.

    Disks, eccentric disks and boxes are thrown, with adhesion, springs, forces and couples; with a random generator
    ``varied`` also with laws of friction that vary, and driven; ``bounce``: law of the impacts of all.
    """
    rng = np.random.default_rng([13, seed])
    kind = str(rng.choice(GROUNDS))
    s = fb.System(f"{kind} {seed}")
    s.gravity = (0, -9.81, 0)
    floor, height = ground(s, rng, kind)
    bodies, disks, start = [], [], {}
    for i in range(rng.integers(1, 4)):
        what = "disk" if kind == "road" else str(rng.choice(["disk", "box", "eccentric"]))
        x = -1.5 + 1.2 * i + rng.uniform(-0.1, 0.1)
        body = s.body(f"b{i}", fb.box(3, (0.5, 0.3, 0.2)) if what == "box" else fb.disk(2, 0.2))
        s.planar(f"p{i}", s.ground, body, coordinate=f"x{i} y{i} a{i}")
        start |= {
            f"x{i}": x, f"y{i}": rng.uniform(0.6, 1.2) + height(x), f"a{i}": rng.uniform(-1, 1),
            f"x{i}'": rng.uniform(-2, 2), f"y{i}'": rng.uniform(-1, 1), f"a{i}'": rng.uniform(-5, 5),
        }  # fmt: skip
        law = {"friction": float(rng.uniform(0.05, 0.9))}
        if rng.random() < 0.25:
            law["adhesion"] = float(rng.uniform(1, 20))
        if rng.random() < 0.15 and what != "box":
            law["rolling"] = float(rng.uniform(0.002, 0.03))
        if rng.random() < 0.25:
            law["restitution"] = float(rng.uniform(0, 0.5))
        if varied is not None:
            vary(law, varied)
        law |= bounce or {}
        offset = (0.03, 0, 0) if what == "eccentric" else (0, 0, 0)
        shape = body.corners(size=(0.5, 0.3)) if what == "box" else body.circle(0.2, at=offset)
        s.contact(f"c{i}", shape, floor, **law)
        if i > 0:
            join = rng.random()
            if join < 0.3:
                ends = bodies[-1].point(0, 0.1, 0), body.point(0, 0.1, 0)
                s.spring(f"k{i}", *ends, stiffness=float(rng.uniform(10, 200)), rest=1.2)
            elif join > 0.5 and what == "disk" and disks[-1] is not None:
                s.contact(f"d{i}", disks[-1], shape, friction=float(rng.uniform(0.05, 0.9)))
        bodies.append(body)
        disks.append(shape if what == "disk" else None)
    if rng.random() < 0.4:
        force = f"{rng.uniform(-20, 20):.2f}*sin({rng.uniform(2, 8):.2f}*t)"
        s.force("F", bodies[0].origin, (force, 0, 0))
    if rng.random() < 0.3:
        s.torque("M", bodies[-1], (0, 0, float(rng.uniform(-3, 3))))
    if varied is not None:
        drive(s, bodies[0], varied)
    return s, start, [name for name in start if not name.endswith("'")]


def legged_scene(seed):
    """A scene, its start and the coordinates to compare: a trunk with a leg, its knee with a stop and dry friction."""
    rng = np.random.default_rng([29, seed])
    s = fb.System(f"leg {seed}")
    s.gravity = (0, 0, -9.81)
    floor = s.ground.plane(normal="z")
    trunk = s.body("trunk", fb.box(3, (0.3, 0.3, 0.2)))
    thigh, shank = (s.body(name, fb.cylinder(0.5, 0.03, 0.3)) for name in ("thigh", "shank"))
    s.free("f", s.ground, trunk)
    s.hinge("hip", trunk, thigh, at=(0, 0, -0.1), to=(0, 0, 0.15), axis="y", coordinate="h")
    knee = s.hinge("knee", thigh, shank, at=(0, 0, -0.15), to=(0, 0, 0.15), axis="y", coordinate="k")
    if rng.random() < 0.6:
        s.stop("bent", knee, low=0, high=2.2)
    if rng.random() < 0.6:
        s.friction("dry", knee, torque=float(rng.uniform(0.1, 1)))
    s.contact("foot", shank.sphere(0.04, at=(0, 0, -0.15)), floor, friction=float(rng.uniform(0.05, 0.9)))
    s.contact("body", trunk.corners(size=(0.3, 0.3, 0.2)), floor, friction=float(rng.uniform(0.05, 0.9)))
    turn = np.array([1, *(0.2 * rng.normal(size=3))])
    start = {"f_z": 0.8, "f": tuple((turn / np.linalg.norm(turn)).tolist()), "k": 0.5}
    start |= {name: float(rng.normal()) for name in ("f_vx", "f_wy", "f_wz")}
    return s, start, ("f_x", "f_y", "f_z", "k")
