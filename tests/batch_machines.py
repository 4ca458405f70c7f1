"""Machines that batches are tested on."""

from __future__ import annotations

import freebody as fb


def four_bar() -> fb.System:
    """A crank of 1 m, a coupler and a rocker on two pins, in the vertical plane."""
    s = fb.System("four-bar")
    s.gravity = (0, -9.81, 0)
    a, b, c = (s.body(name, fb.slender_bar(1, L, axis="x")) for name, L in (("a", 1), ("b", 3), ("c", 2)))
    s.hinge("A", s.ground, a, to=(-0.5, 0, 0), axis="z", coordinate="q1")
    s.hinge("B", a, b, at=(0.5, 0, 0), to=(-1.5, 0, 0), axis="z", coordinate="q2")
    s.hinge("D", s.ground, c, at=(3, 0, 0), to=(-1, 0, 0), axis="z", coordinate="q3")
    s.hinge("C", b, c, at=(1.5, 0, 0), to=(1, 0, 0), axis="z")
    return s


CLOSED = {"q1": 1.0, "q2": -0.7, "q3": 1.2}
"""Near a place in which the four-bar closes."""


def pendulum(drive: str = "m*sin(3*t)") -> fb.System:
    """A bar of 2 m with a damper, driven by a moment."""
    s = fb.System("pendulum")
    m, length, g, c = s.parameters(m=1.0, L=2.0, g=9.81, c=0.0)
    s.gravity = (0, -g, 0)
    bar = s.body("bar", fb.slender_bar(m, length, axis="y"))
    pin = s.hinge("pin", s.ground, bar, to=(0, length / 2, 0), axis="z", coordinate="theta")
    s.damper("c", pin, damping=c)
    s.torque("drive", bar, (0, 0, drive))
    return s


def cart() -> fb.System:
    """A cart of 2 kg on a spring and a damper, stiff where k = 1e6 and c = 1e5."""
    s = fb.System("cart")
    k, c = s.parameters(k=1.0, c=1.0)
    guide = s.slider("guide", s.ground, s.body("cart", fb.particle(2)), axis="x", coordinate="x")
    s.spring("spring", guide, stiffness=k)
    s.damper("damper", guide, damping=c)
    return s


def rail() -> fb.System:
    """√(x²) is |x|, but its series at x > 0 is x, which goes on behind the bend as if there were none."""
    s = fb.System("spring along a rail")
    block = s.body("block", fb.particle(1))
    s.slider("rail", s.ground, block, axis="x", coordinate="x")
    s.spring("k", s.ground.origin, block.origin, stiffness=100, rest=0.3)
    return s
