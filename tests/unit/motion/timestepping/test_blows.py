"""Blows against a surface in time steps: those of motions by events, to first order in the step."""

from typing import Any

import numpy as np
import pytest

import freebody as fb
from freebody.errors import SimulationError

STEPS = {"method": "timestepping", "step": 1e-3}


def ball(g=10.0, mass=2):
    s = fb.System("ball")
    s.gravity = (0, -g, 0)
    body = s.body("ball", fb.particle(mass))
    s.chain("plane", s.ground, body, [fb.Slider("x", "x"), fb.Slider("y", "y")])
    return s, body


def linkage():
    """A double pendulum whose end a bar joins to the ground: a loop."""
    s = fb.System("linkage")
    s.gravity = (0, -10, 0)
    a, b, c = (s.body(name, fb.slender_bar(1, 1, axis="x")) for name in "abc")
    s.hinge("A", s.ground, a, to=(-0.5, 0, 0), axis="z", coordinate="p")
    s.hinge("B", a, b, at=(0.5, 0, 0), to=(-0.5, 0, 0), axis="z", coordinate="q")
    s.hinge("C", s.ground, c, at=(1.2, 0, 0), to=(-0.5, 0, 0), axis="z", coordinate="r")
    s.hinge("D", b, c, at=(0.5, 0, 0), to=(0.5, 0, 0), axis="z")
    return s, b, {"p": 2.0, "p'": -1.0}, {"q": -1.5, "r": 1.2}


@pytest.mark.parametrize("restitution", [0, 0.4, 1])
@pytest.mark.parametrize("kind", ["ball", "linkage"])
def test_a_surface_by_time_and_by_a_condition(kind, restitution):
    if kind == "ball":
        s, body = ball()
        run: dict[str, Any] = {"initial": {"y": 0.3, "x'": 1, "y'": -1.0}}
        at, normal, condition = body.origin, (0.6, 0.8, 0), "y"
    else:
        s, body, start, near = linkage()
        run = {"initial": start, "near": near}
        at, normal, condition = body.point(0.1, 0, 0), (-1, -0.3, 0), "p - 1.95"
    for when in (0.05, fb.event(condition, direction=-1)):
        blow = fb.blow(when, at=at, normal=normal, restitution=restitution, name="wall")
        exact = fb.simulate(s, 0.25, impulses=[blow], **run)
        off = []
        for step in (2e-3, 1e-3, 5e-4):
            steps = fb.simulate(s, 0.25, impulses=[blow], method="timestepping", step=step, **run)
            off.append(np.abs(steps.at(0.25).u - exact.at(0.25).u).max())
            assert [x.name for x in steps.events if x.name == "wall"] == ["wall"]
        assert off[-1] < 20 * 5e-4 and (off[-1] < 0.6 * off[0] or off[-1] < 1e-9)


def test_blows_at_one_time_act_in_their_order():
    """Without loads the speeds are those of motions by events to round-off."""
    s, body = ball(g=0)
    kick = fb.blow(0.1, at=body, impulse=(-4, 0, 0))
    wall = fb.blow(0.1, at=body, normal=(3, 4, 0), restitution=0.5)
    found = []
    for blows in ([kick, wall], [wall, kick]):
        run = {"initial": {"y": 1, "x'": 1, "y'": -3}, "impulses": blows}
        exact, steps = fb.simulate(s, 0.2, **run), fb.simulate(s, 0.2, **run, **STEPS)
        np.testing.assert_allclose(steps.at(0.2).u, exact.at(0.2).u, rtol=1e-14)
        assert steps.energy.work[-1] == pytest.approx(exact.energy.work[-1], rel=1e-12)
        found.append(steps.at(0.2).u)
    assert np.abs(found[0] - found[1]).max() > 0.1


def test_contacts_answer_in_the_step_of_the_blow():
    """A block that a wall throws back on a floor rubs on by Coulomb's law."""
    s, body = ball()
    s.contact("floor", body.origin, s.ground.plane(), friction=0.5)
    wall = fb.blow(fb.event("x - 0.4", direction=1), at=body, normal=(-1, 0, 0), restitution=0.5, name="wall")
    motion = fb.simulate(s, 1, initial={"x'": 3}, impulses=[wall], **STEPS)
    v = 0.5 * np.sqrt(9 - 2 * 5 * 0.4)
    assert motion["x"][-1] == pytest.approx(0.4 - v * v / 10, abs=5e-3)
    assert motion["x'"][-1] == pytest.approx(0, abs=1e-12)
    assert motion.contacts["floor"].normal == pytest.approx(20)


def test_it_calls_where_the_point_approaches():
    """A rebound that ends its step behind the surface passes it once more, outwards, and is no second impact."""
    s, body = ball()
    for start in np.linspace(0.5, 0.51, 7):
        wall = fb.blow("y", at=body, normal=(0, 1, 0), restitution=0.2, name="wall")
        motion = fb.simulate(
            s, 0.35, initial={"y": float(start)}, impulses=[wall], method="timestepping", step=1e-2
        )
        assert [x.name for x in motion.events] == ["wall"] and motion["y'"].max() > 0.4


def test_what_comes_to_rest_is_a_contact():
    s, body = ball()
    wall = fb.blow(fb.event("y", direction=-1), at=body, normal=(0, 1, 0), restitution=0.5, name="wall")
    with pytest.raises(
        SimulationError,
        match=r"The blow 'wall' falls again and again from t = 1.3\d* s on: loads turn its rebound round within a step "
        r"of 0.001 s. A surface on which something comes to rest is a contact: s.contact\(..., restitution=e\)",
    ):
        fb.simulate(s, 2, initial={"y": 1}, impulses=[wall], **STEPS)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"normal": (0, -1, 0), "restitution": 0}, "No impact: .* moves along the normal at 1.* m/s"),
        ({"normal": (0, 1, 0), "restitution": 1.5}, "restitution from 0 to 1, got 3/2"),
        (
            {"normal": (0, 0, 1), "restitution": 0},
            "can change its velocity along the normal: the joints hold it",
        ),
        ({"normal": (0, 0, 0), "restitution": 0}, "a direction for the normal"),
        ({"normal": (0, 1, 0)}, "normal= and restitution= together"),
        ({"impulse": (0, 1, 0), "restitution": 0.5}, "normal= and restitution= together"),
    ],
)
def test_refusals(options, said):
    s, body = ball()
    with pytest.raises(SimulationError, match=f"The blow 'wall' at t = 0.1 s cannot be applied: .*{said}"):
        fb.simulate(s, 0.2, impulses=[fb.blow(0.1, at=body, name="wall", **options)], **STEPS)
