"""What is given in a wrong place is shown by the user's names, never as a dataclass or an address."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import pytest

import freebody as fb
from freebody.model import assemble

UGLY = re.compile(r"[A-Za-z]\(\w+=|<|0x[0-9a-f]{6}|Body\(|Fraction\(")


def machine(name: str) -> Any:
    s = fb.System(name)
    s.gravity = (0, -9.81, 0)
    disk = s.body("disk", fb.disk(1, 0.3))
    s.planar("plane", s.ground, disk, coordinate="x y turn")
    return s, disk


def things() -> dict[str, Any]:
    """One of each kind of what users hold, of another system; and some that nobody would give."""
    s, b = machine("other")
    floor = s.contact("floor", b.circle(0.3), s.ground.plane(), friction=0.2)
    model = assemble(s)
    found = {
        "system": s, "body": b, "ground": s.ground, "point": b.point(0.1, 0, 0), "mass": fb.disk(1, 0.3),
        "solid": fb.disk(1, 0.3).shape, "joint": s.joints["plane"], "contact": floor, "model": model,
        "element": model.contacts[0], "motion": fb.simulate(s, 0.01, initial={"y": 0.3}), "sphere": b.sphere(0.1),
        "ellipsoid": b.ellipsoid((1, 1, 2)), "circle": b.circle("1/3"), "cylinder": b.cylinder(0.1),
        "flat": b.plane(), "segment": b.segment((0, 0, 0), (1, 0, 0), normal="y"),
        "corners": b.corners(size=(0.1, 0.1)), "line": s.ground.heightline("x**2"),
        "points": [b.point(0, 0, 0), b.sphere(1)], "none": None, "function": lambda t: t, "nothing": object(),
    }  # fmt: skip
    s.force("push", b.point(0, 0, 0), (1, 0, 0))
    s.spring("spring", b.point(0, 0, 0), s.ground.point(0, 1, 0), stiffness=1, rest=1)
    return {**found, "push": s.loads["push"], "spring": s.loads["spring"]}


def calls() -> Iterator[tuple[str, Any]]:
    """Calls of a fresh machine, with one argument that is given."""
    o = lambda disk: disk.circle(0.3)  # noqa: E731
    yield "contact name", lambda s, d, x: s.contact(x, o(d), s.ground.plane())
    yield "feature", lambda s, d, x: s.contact("c", x, s.ground.plane())
    yield "surface", lambda s, d, x: s.contact("c", o(d), x)
    for option in ("friction", "static_friction", "restitution", "impact"):
        yield option, lambda s, d, x, k=option: s.contact("c", o(d), s.ground.plane(), **{k: x})
    for maker in ("sphere", "circle", "cylinder"):
        yield maker, lambda s, d, x, k=maker: getattr(d, k)(x)
        for option in ("at", "inside"):
            yield f"{maker} {option}", lambda s, d, x, k=maker, o=option: getattr(d, k)(0.1, **{o: x})
    yield "axis", lambda s, d, x: d.circle(0.1, axis=x)
    yield "half axes", lambda s, d, x: d.ellipsoid(x)
    yield "normal", lambda s, d, x: d.plane(normal=x)
    yield "place", lambda s, d, x: d.plane(at=x)
    yield "start", lambda s, d, x: d.segment(x, (1, 0, 0), normal="y")
    yield "side", lambda s, d, x: d.segment((0, 0, 0), (1, 0, 0), normal=x)
    yield "corners", lambda s, d, x: d.corners(x)
    yield "size", lambda s, d, x: d.corners(size=x)
    yield "height", lambda s, d, x: d.heightline(x)
    yield "point of", lambda s, d, x: d.point(x)
    yield "point", lambda s, d, x: s.force("f", x, (1, 0, 0))
    yield "force", lambda s, d, x: s.force("f", d.point(0, 0, 0), x)
    yield "torque on", lambda s, d, x: s.torque("f", x, 1)
    yield "spring", lambda s, d, x: s.spring("f", x, s.ground.point(0, 0, 0), stiffness=1, rest=0)
    yield "stiffness", lambda s, d, x: s.spring("f", d.point(0, 0, 0), s.ground, stiffness=x, rest=0)
    yield "parent", lambda s, d, x: s.hinge("h", x, s.body("b", fb.sphere(1, 1)))
    yield "child", lambda s, d, x: s.hinge("h", s.ground, x)
    yield "to", lambda s, d, x: s.hinge("h", s.ground, s.body("b", fb.sphere(1, 1)), to=x)
    yield "hinge axis", lambda s, d, x: s.hinge("h", s.ground, s.body("b", fb.sphere(1, 1)), axis=x)
    yield "mass", lambda s, d, x: s.body("b", x)
    yield "gear", lambda s, d, x: s.gear("g", x, s.joints["plane"], ratio=2)
    yield "rope", lambda s, d, x: s.rope("r", x, length=1)
    yield "rolling", lambda s, d, x: s.rolling("r", x, radius=0.3)
    yield "gravity", lambda s, d, x: setattr(s, "gravity", x)
    yield "fb.sphere", lambda s, d, x: fb.sphere(x, 1)
    yield "fb.box", lambda s, d, x: fb.box(1, x)


GIVEN = things()


@pytest.mark.parametrize(("argument", "call"), list(calls()), ids=[name for name, _ in calls()])
def test_messages_show_names(argument: str, call: Any) -> None:
    refused = 0
    for kind, thing in GIVEN.items():
        s, disk = machine("mine")
        try:
            call(s, disk, thing)
        except fb.FreebodyError as error:
            refused += 1
            assert not UGLY.search(str(error)), f"{argument}, {kind}: {error}"
            assert len(str(error)) < 800, f"{argument}, {kind}: {error}"
    assert refused >= len(GIVEN) / 2


@pytest.mark.parametrize("kind", GIVEN)
def test_what_users_hold_shows_itself_by_names(kind: str) -> None:
    if kind not in ("function", "nothing", "none"):
        assert not UGLY.search(repr(GIVEN[kind])), repr(GIVEN[kind])


def test_the_words() -> None:
    s, disk = machine("mine")
    with pytest.raises(fb.FreebodyError, match=r"got force 'push'\.$"):
        s.contact("c", GIVEN["push"], s.ground.plane())
    with pytest.raises(fb.FreebodyError, match=r"got the circle of body 'disk'\.$"):
        s.force("f", disk.circle(0.3), (1, 0, 0))
    with pytest.raises(fb.FreebodyError, match=r"got contact 'floor'\."):
        s.hinge("h", GIVEN["contact"], disk)
    with pytest.raises(fb.FreebodyError, match=r"got planar 'plane' \(ground -> disk\)"):
        s.contact("c", GIVEN["joint"], s.ground.plane())
    with pytest.raises(fb.FreebodyError, match="got an object"):
        s.force("f", object(), (1, 0, 0))
