"""Derivatives of what controllers sense of contacts, and of the times at which quantities of contacts pass zero."""

import numpy as np
import pytest

import freebody as fb
from freebody.errors import SimulationError

NUMBERS = {"m": 1.0, "g": 9.81, "mu": 0.4, "k": 3.0, "c": 0.2}
EVENTS = [
    fb.event("floor.normal - 13", name="load"),
    fb.event("floor.slip - 0.7", name="slow"),
    fb.event("2*floor.gap - m/25", name="high", direction=-1),
]


def block(static=None, normal=None, restitution=0.3):
    """A block that a law of its contact pushes; its weight grows."""
    s = fb.System("block")
    s.parameters(**NUMBERS, u=0.0)
    s.gravity = (0, "-g", 0)
    body = s.body("b", fb.particle("m"))
    s.chain("plane", s.ground, body, [fb.Slider("x", "x"), fb.Slider("y", "y")])
    law = {"restitution": restitution} if normal is None else {"normal": normal}
    s.contact("floor", body.origin, s.ground.plane(), friction="mu", static_friction=static, **law)
    s.force("F", body.origin, ("u", "-5*t", 0))

    def push(t, x):
        felt = x["c"] * x["N"] + 0.1 * x["T"] + 0.05 * x["margin"] + 0.2 * x["approach"] + 0.3 * x["gap"]
        return felt - x["k"] * x["slip"]

    sensors = {name: f"floor.{name}" for name in ("slip", "gap", "approach", "margin")}
    s.controller(
        push, 0.05, "u", sensors={"N": "floor.normal + 0*t", "T": "floor.tangential + mu*x", **sensors}
    )
    return s


def puck():
    """A ball on a table that turns with the slip it feels, pressed by a spring."""
    s = fb.System("puck")
    s.parameters(**NUMBERS, u=0.0, w=0.0)
    s.gravity = (0, 0, "-g")
    body = s.body("b", fb.sphere("m", 0.1))
    s.chain("move", s.ground, body, [*(fb.Slider(axis, axis) for axis in "xyz"), fb.Hinge("y", "turn")])
    s.contact("floor", body.sphere(0.1), s.ground.plane(normal="z"), friction="mu")
    s.force("F", body.origin, ("u", "w", "-3*t - 10*x"))

    def push(t, x):
        return {
            "u": x["c"] * x["T1"] + 0.1 * x["N"] * t,
            "w": x["k"] / 10 - 0.3 * x["T2"] - 0.1 * x["v1"] - 0.2 * x["v2"],
        }

    names = {"T1": "tangential.1", "T2": "tangential.2", "v1": "slip.1", "v2": "slip.2", "N": "normal"}
    s.controller(push, 0.07, ["u", "w"], sensors={x: f"floor.{name}" for x, name in names.items()})
    return s


@pytest.mark.parametrize(
    ("s", "start", "seen"),
    [
        (block(), {"x'": 2.0, "y": 0.05}, {"load", "high"}),
        (block("mu + 0.1"), {"x'": 2.0}, {"load", "slow"}),
        (block(restitution=0), {"x": 0.1}, {"load"}),
        (block(normal="500*depth*(1 + rate)"), {"x'": 2.0, "y": -0.02}, {"load", "slow"}),
        (puck(), {"x'": 1.0, "y'": -0.5, "z": 0.1, "turn'": 3.0}, set()),
    ],
)
def test_they_are_the_limits_of_differences(s, start, seen):
    given = {"initial": start, "tolerance": 1e-11, "events": [] if s.name == "puck" else EVENTS}
    motion = fb.simulate(s, 0.93, sensitivities=[*NUMBERS], **given)
    state = ["x", "x'", "y'"] if s.name == "block" else ["x", "y", "x'", "y'"]
    times = {one.name: motion.sensitivity.times(one.name) for one in given["events"] if one.name in seen}
    quiet = np.searchsorted(motion.t, [0.02, 0.44, 0.92])
    for j, (name, value) in enumerate(NUMBERS.items()):
        h = 2e-5 * value
        above, below = (fb.simulate(s, 0.93, values={name: value + d}, **given) for d in (h, -h))
        for quantity in state:
            difference = (above[quantity][-1] - below[quantity][-1]) / (2 * h)
            assert motion.sensitivity[quantity, name][-1] == pytest.approx(difference, rel=1e-5, abs=1e-7)
        for what in ("normal", "margin", "slip.1" if s.name == "puck" else "slip", "gap"):
            difference = (above[f"floor.{what}"] - below[f"floor.{what}"])[quiet] / (2 * h)
            found = motion.sensitivity[f"floor.{what}", name][quiet]
            assert found == pytest.approx(difference, rel=1e-5, abs=1e-6, nan_ok=True)
        for event, slopes in times.items():
            apart = [np.array([x.time for x in one.events if x.name == event]) for one in (above, below)]
            assert slopes[:, j] == pytest.approx((apart[0] - apart[1]) / (2 * h), rel=1e-5, abs=1e-7)
            assert len(slopes) > 0


def test_a_run_that_a_force_ends():
    """N = m g + 5 t is 13 at t = (13 - m g)/5."""
    event = fb.event("floor.normal - 13", terminal=True)
    motion = fb.simulate(block(), 2, initial={"x'": 2.0}, events=[event], sensitivities=["m", "g"])
    assert motion.sensitivity["final(t)", "m"] == pytest.approx(-9.81 / 5, rel=1e-9)
    assert motion.sensitivity["final(t)", "g"] == pytest.approx(-1 / 5, rel=1e-9)


def test_a_margin_at_rest():
    """μ (m g + 5 t) - k t = 1 at t = (μ m g - 1)/(k - 5 μ)."""
    s = fb.System("block")
    s.parameters(**NUMBERS)
    s.gravity = (0, "-g", 0)
    body = s.body("b", fb.particle("m"))
    s.chain("plane", s.ground, body, [fb.Slider("x", "x"), fb.Slider("y", "y")])
    s.contact("floor", body.origin, s.ground.plane(), friction="mu")
    s.force("F", body.origin, ("-k*t", "-5*t", 0))
    motion = fb.simulate(s, 4.5, events=["floor.margin - 1"], sensitivities=["m", "mu", "k"])
    m, g, mu, k, _ = NUMBERS.values()
    part, time = k - 5 * mu, (mu * m * g - 1) / (k - 5 * mu)
    expected = [mu * g / part, m * g / part + 5 * time / part, -time / part]
    assert motion.sensitivity.times("floor.margin - 1") == pytest.approx(np.array([expected]), rel=1e-9)
    sticks = (motion.t > 0) & (motion.contacts["floor"].mode == "stick")
    assert sticks.sum() > 100
    assert motion.sensitivity["floor.margin", "mu"][sticks] == pytest.approx(
        m * g + 5 * motion.t[sticks], rel=1e-9
    )
    assert motion.sensitivity["floor.margin", "k"][sticks] == pytest.approx(-motion.t[sticks], rel=1e-9)
    slips = motion.contacts["floor"].mode == "slip-"
    assert slips.any() and not motion.sensitivity["floor.margin", "mu"][slips].any()  # μ_s N - |T| = 0


def test_a_jump_is_the_time_of_a_contact():
    s = block()
    motion = fb.simulate(
        s,
        0.3,
        initial={"x'": 2.0, "y": 0.05},
        events=[fb.event("floor.slip - 1", name="jump")],
        sensitivities=["m"],
    )
    with pytest.raises(
        SimulationError, match="'jump' to pass through zero .* it jumps over it. Watch for another"
    ):
        motion.sensitivity.times("jump")


def test_the_size_of_friction_has_no_derivative_at_zero():
    s = fb.System("block")
    s.parameters(a=0.0, u=0.0)
    s.gravity = (0, -9.81, 0)
    body = s.body("b", fb.particle(1))
    s.chain("plane", s.ground, body, [fb.Slider("x", "x"), fb.Slider("y", "y")])
    s.contact("floor", body.origin, s.ground.plane(), friction=0.5)
    s.force("F", body.origin, ("a + u", 0, 0))
    s.controller(lambda t, x: x["left"], 0.1, "u", sensors={"left": "floor.margin"})
    with pytest.raises(
        SimulationError, match="contact 'floor' begins to bear friction, of which the margin has the"
    ):
        fb.simulate(s, 0.05 + 0.1, sensitivities=["a"])
