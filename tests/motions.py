"""Motions of every kind, and that two of them are the same to the bit."""

from __future__ import annotations

import numpy as np

import freebody as fb


def pendulum(**options):
    s = fb.System("pendulum")
    m, L, g, c = s.parameters(m=1.0, L=2.0, g=9.81, c=0.1)
    s.gravity = (0, -g, 0)
    bar = s.body("bar", fb.slender_bar(m, L, axis="y"))
    pin = s.hinge("pin", s.ground, bar, to=(0, L / 2, 0), axis="z", coordinate="theta")
    s.damper("d", pin, damping=c)
    return s


def plain(method="auto", **options):
    return fb.simulate(
        pendulum(),
        1,
        initial={"theta": 1, "theta'": 0.1},
        events=["theta", fb.event("theta'", name="turn")],
        method=method,
        **options,
    )


def gyroscope(method="structure"):
    s = fb.System("top")
    m, a, b = s.parameters(m=1.0, a=0.2, b=0.5)
    s.gravity = (0, 0, "-9.81")
    body = s.body("top", fb.cylinder(m, a, b))
    s.ball("tip", s.ground, body, to=(0, 0, -b))
    return fb.simulate(
        s,
        0.3,
        initial={"tip_wz": 20, "tip_wx": 1},
        method=method,
        **({"step": 0.01} if method == "structure" else {}),
    )


def driven():
    s = pendulum()
    torque = s.parameters(tau=0.0)
    s.torque("motor", s.bodies["bar"], (0, 0, torque))
    s.controller(lambda t, x: -3 * x["theta"], 0.05, "tau")
    return fb.simulate(s, 0.5, initial={"theta": 1}, events=["theta'"])


def signalled():
    s = pendulum()
    push = fb.signal([0, 0.3, 1], [0.0, 2.0, -1.0])
    s.torque("motor", s.bodies["bar"], (0, 0, 2 * push))
    return fb.simulate(s, 0.8)


def struck():
    s = pendulum()
    bar = s.bodies["bar"]
    return fb.simulate(
        s, 1, initial={"theta": 1}, impulses=[fb.blow(0.5, at=bar.point(0, -1, 0), impulse=(1, 0, 0))]
    )


def sensitive():
    return plain(sensitivities=["m", "theta"])


def four_bar():
    s = fb.System("four-bar")
    s.gravity = (0, "-9.81", 0)
    crank, coupler, rocker = (
        s.body(n, fb.slender_bar(1, L, axis="x")) for n, L in (("a", 1), ("b", 3), ("c", 2))
    )
    s.hinge("A", s.ground, crank, to=("-1/2", 0, 0), axis="z", coordinate="q1")
    s.hinge("B", crank, coupler, at=("1/2", 0, 0), to=("-3/2", 0, 0), axis="z", coordinate="q2")
    s.hinge("C", coupler, rocker, at=("3/2", 0, 0), to=(1, 0, 0), axis="z", coordinate="q3")
    s.hinge("D", s.ground, rocker, at=(3, 0, 0), to=(-1, 0, 0), axis="z")
    return fb.simulate(s, 0.3, initial={"q1": 0.5}, near={"q2": 0.3, "q3": -1.5}, events=["q1"])


def ball(**options):
    s = fb.System("ball")
    g, R, mu = s.parameters(g=9.81, R=0.1, mu=0.2)
    s.gravity = (0, -g, 0)
    disk = s.body("disk", fb.disk(1, R))
    s.planar("plane", s.ground, disk, coordinate="x y phi")
    s.contact("floor", disk.circle(R), s.ground.plane(), friction=mu, restitution=0.5)
    return fb.simulate(
        s, 1, initial={"y": 0.3, "x'": 1}, events=[fb.event("x - 0.2", name="passed")], **options
    )


def stepped():
    return ball(method="timestepping", step=0.002)


def switched():
    """A mass between two stops with springs and dampers, with its derivatives."""
    s = fb.System("switched")
    s.parameters(k=100.0, c=3.0)
    mass = s.body("mass", fb.particle(2))
    rail = s.slider("rail", s.ground, mass, axis="x", coordinate="x")
    s.stop("wall", rail, low=-0.1, high=0.1, stiffness="k", damping="c")
    return fb.simulate(s, 1, initial={"x'": 1.0}, sensitivities=["k", "x'"])


def stopped():
    """A leg whose foot lands on a floor, with two tangents, and whose knee has a stop, with none."""
    s = fb.System("leg")
    s.gravity = (0, 0, -9.81)
    hip, shank = s.body("hip", fb.box(1, (0.2, 0.1, 0.1))), s.body("shank", fb.box(0.5, (0.05, 0.05, 0.4)))
    s.free("f", s.ground, hip)
    knee = s.hinge("knee", hip, shank, to=(0, 0, 0.2), axis="y", coordinate="phi")
    s.stop("end", knee, low=-0.3, high=0.3)
    s.contact("floor", shank.point(0, 0, -0.2), s.ground.plane(normal="z"), friction=0.5)
    return fb.simulate(s, 0.3, initial={"f_z": 0.45, "phi": 0.1})


MOTIONS = {
    "plain": plain,
    **{f"plain {m}": lambda m=m: plain(m) for m in ("dop853", "dop54", "radau", "gauss", "taylor")},
    "structure": gyroscope,
    "quaternions": lambda: gyroscope("dop853"),
    "controller": driven,
    "signal": signalled,
    "blow": struck,
    "sensitivities": sensitive,
    "switched": switched,
    "series of sensitivities": lambda: plain("taylor", sensitivities=["L"]),
    "loop": four_bar,
    "contact": ball,
    "contact and stop": stopped,
    "time stepping": stepped,
}


def assert_same(a, b):
    """To the bit: what was computed, what lies between the steps, and what follows."""
    inside = np.linspace(a.t[0], a.t[-1], 17)
    assert type(a) is type(b)
    assert repr(a) == repr(b)
    assert np.array_equal(a.t, b.t)
    assert a.names == b.names
    assert a.values == b.values
    for name in a.names:
        assert np.array_equal(a[name], b[name])
        assert np.array_equal(a.at(inside)[name], b.at(inside)[name])
    for part in ("kinetic", "potential", "work", "residual"):
        assert np.array_equal(getattr(a.energy, part), getattr(b.energy, part)), part
    for name, reaction in a.reactions.items():
        assert np.array_equal(reaction.force, b.reactions[name].force)
        assert np.array_equal(reaction.moment, b.reactions[name].moment)
        assert (reaction.on, reaction.about) == (b.reactions[name].on, b.reactions[name].about)
    for name, force in a.multipliers.items():
        assert np.array_equal(force, b.multipliers[name])
    assert list(map(str, a.events)) == list(map(str, b.events))
    assert [event.state for event in a.events] == [event.state for event in b.events]
    assert a.indeterminate == b.indeterminate
    first = a.names[0]
    assert np.array_equal(a[f"{first}^2 + t"], b[f"{first}^2 + t"])
    for name, contact in a.contacts.items():
        for part in ("gap", "normal", "tangential", "slip", "margin", "least"):
            assert np.array_equal(getattr(contact, part), getattr(b.contacts[name], part), equal_nan=True)
        assert list(contact.mode) == list(b.contacts[name].mode)
        assert str(a.modes) == str(b.modes)
    if a.course.derivatives is not None:
        for key in a.sensitivity:
            assert np.array_equal(a.sensitivity[key], b.sensitivity[key])
    assert a.data.identical(b.data)
