"""Random machines of all shapes and laws of contact, thrown on all kinds of ground, with hinges, stops and friction.

Each draws what the others do not combine: a drum with a soft law beside an ellipsoid that adheres to a turntable.
"""

from random import Random
from typing import Any

import freebody as fb

GROUNDS = ("plane", "plane", "tilt", "turntable", "bowl", "ball", "family", "family")
SHAPES = {
    "bowl": ("sphere", "point", "box", "capsule"),
    "ball": ("sphere", "point"),
    "family": ("sphere", "box", "capsule"),
}
ALL_SHAPES = ("sphere", "box", "capsule", "point", "disk", "drum", "ellipsoid")
SOFT = ("1e4*depth", "1e5*depth^1.5", "1e5*depth^1.5*(1+0.5*rate)")


def thrown(seed: int) -> tuple[fb.System, dict[str, float]]:
    """A machine, and its start."""
    draw = Random(seed)
    s = fb.System(f"mixed {seed}")
    s.gravity = (0, 0, -9.81)
    ground = draw.choice(GROUNDS)
    if ground == "turntable":
        table = s.body("tab", fb.box(1, (1, 1, 0.1)))
        s.hinge("run", s.ground, table, axis="z", coordinate=draw.choice(["1.5*t", "0.3*sin(9*t)"]))
    count, last, start, shapes = draw.choice([1, 1, 2, 2, 3]), None, {}, []
    for i in range(count):
        kind = draw.choice(SHAPES.get(ground, ALL_SHAPES))
        m, R = round(draw.uniform(0.2, 3), 2), round(draw.uniform(0.05, 0.2), 3)
        body, shape = _body(s, f"b{i}", kind, m, R)
        if last is None or draw.random() < 0.6:
            s.free(f"f{i}", s.ground, body)
            start |= {f"f{i}_x": -0.6 + 0.6 * i + draw.uniform(-0.05, 0.05)}
            start |= {f"f{i}_y": draw.uniform(-0.1, 0.1), f"f{i}_z": draw.uniform(0.6, 1.0)}
            start |= {f"f{i}_v{c}": draw.uniform(-1, 1) for c in "xy"}
            start |= {f"f{i}_w{c}": draw.uniform(-8, 8) for c in "xyz"}
        else:
            _join(s, i, draw, last, body)
        if ground == "family":
            shapes.append(shape)
        else:
            laws = _laws(draw)
            if ground in ("bowl", "ball") and laws.pop("along", None):
                laws["friction"] = 0.3
            rolls = kind in ("sphere", "point") and draw.random() < 0.3
            if rolls and "normal" not in laws and "along" not in laws:
                laws |= {"rolling": 0.002, "spinning": 0.001}
            surface = {
                "plane": lambda: s.ground.plane(normal="z"),
                "tilt": lambda: s.ground.plane(normal=(0.2, 0.1, 1)),
                "turntable": lambda: table.plane(normal="z"),
                "bowl": lambda: s.ground.sphere(2, at=(0, 0, 2), inside=True),
                "ball": lambda: s.ground.sphere(1.5, at=(0, 0, -1.5)),
            }[ground]
            s.contact(f"c{i}", shape, surface(), **laws)
        last = body
    if ground == "family":
        s.contacts("F", [*shapes, s.ground.plane(normal="z")], **_laws(draw, family=True))
    return s, start


def _body(s: fb.System, name: str, kind: str, m: float, R: float) -> tuple[Any, Any]:
    mass, shape = {
        "sphere": (fb.sphere(m, R), lambda body: body.sphere(R)),
        "box": (fb.box(m, (2 * R, R, 1.5 * R)), lambda body: body.box((2 * R, R, 1.5 * R))),
        "capsule": (fb.box(m, (2 * R, R, R)), lambda body: body.capsule((-R, 0, 0), (R, 0, 0), R / 2)),
        "point": (fb.box(m, (2 * R, R, 1.5 * R)), lambda body: body.point(R / 2, R / 4, 0)),
        "disk": (fb.disk(m, R), lambda body: body.circle(R)),
        "drum": (fb.cylinder(m, R, 1.5 * R), lambda body: body.drum(R, 1.5 * R)),
        "ellipsoid": (fb.ellipsoid(m, (R, 0.8 * R, 1.2 * R)), lambda body: body.ellipsoid((R, 0.8 * R, 1.2 * R))),
    }[kind]  # fmt: skip
    body = s.body(name, mass)
    return body, shape(body)


def _join(s: fb.System, i: int, draw: Random, last: Any, body: Any) -> None:
    more = draw.randrange(6)
    if more < 4:
        joint = s.hinge(f"h{i}", last, body, at=(0.35, 0, 0), axis=draw.choice("yz"), coordinate=f"a{i}")
    else:
        joint = s.ball(f"h{i}", last, body, at=(0.35, 0, 0))
    if more == 0:
        s.stop(f"st{i}", joint, low=-0.5, high=0.5, restitution=draw.choice([0, 0.4]))
    if more == 1:
        s.friction(f"fr{i}", joint, torque=round(draw.uniform(0.05, 1), 2))
    if more == 2:
        s.friction(f"fr{i}", joint, coefficient=0.3, radius=0.02)


def _laws(draw: Random, family: bool = False) -> dict[str, Any]:
    kind = draw.randrange(8)
    laws: dict[str, Any] = {}
    if 1 <= kind <= 3:
        laws["friction"] = round(draw.uniform(0.05, 1.2), 2)
    else:
        laws = {
            0: {"friction": 0},
            4: {"friction": "0.2+0.2*exp(-slip/0.1)"},
            5: {"friction": 0.3, "static_friction": 0.45},
            6: {"friction": "0.3+0.05*slip"},
            7: {"friction": 0.5} if family else {"friction": (0.2, 0.4), "along": "x"},
        }[kind]
    kind = draw.randrange(6)
    if kind == 0:
        laws["restitution"] = round(draw.uniform(0.1, 0.9), 2)
    if kind == 1:
        laws |= {"restitution": 0.5, "impact": "poisson"}
    if kind == 2 and draw.random() < 0.5 and not family:
        laws["adhesion"] = round(draw.uniform(0.1, 5), 2)
    if kind == 3 and draw.random() < 0.5 and not family:
        laws["normal"] = draw.choice(SOFT)
    return laws
