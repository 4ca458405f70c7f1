"""Derivatives of the jump of speeds at a blow, against the law of the free rod and of a pendulum."""

import numpy as np
import pytest

import freebody as fb


def rod(on_pin=False):
    s = fb.System("rod")
    s.parameters(m=2.0, L=1.2, J=0.7, b=0.4, e=0.6)
    body = s.body("rod", fb.slender_bar("m", "L", axis="y"))
    if on_pin:
        s.hinge("pin", s.ground, body, to=(0, "L/2", 0), axis="z", coordinate="q")
    else:
        s.planar("air", s.ground, body, coordinate="x y q")
    return s, body


def test_an_impulse_on_a_free_rod():
    """Δx' = J/m, Δq' = -12 b J/(m L²)."""
    s, body = rod()
    kick = fb.blow(0.25, at=body.point(0, "b", 0), impulse=("J", 0, 0))
    names = ["J", "b", "m", "L"]
    motion = fb.simulate(s, 0.5, impulses=[kick], sensitivities=names, samples=2, tolerance=1e-12)
    turn = -12 * 0.4 * 0.7 / (2 * 1.2**2)
    expected = {
        "J": (1 / 2, turn / 0.7),
        "b": (0, turn / 0.4),
        "m": (-0.7 / 4, -turn / 2),
        "L": (0, -2 * turn / 1.2),
    }
    for name, (x, q) in expected.items():
        assert motion.sensitivity["x'", name][-1] == pytest.approx(x, abs=1e-12)
        assert motion.sensitivity["q'", name][-1] == pytest.approx(q, abs=1e-12)
        assert motion.sensitivity["q", name][-1] == pytest.approx(0.25 * q, abs=1e-12)


def test_a_bar_on_a_pin_that_hits_a_surface():
    """n·v = b q' cos q for n = x at b below the pin: q'+ = -e q', at a time that the angle gives, q = f."""
    s, body = rod(on_pin=True)
    s.parameters(f=0.2)
    wall = fb.blow(
        fb.event("q - f", direction=1), at=body.point(0, "L/2 - b", 0), normal=(-1, 0, 0), restitution="e"
    )
    motion = fb.simulate(
        s,
        1,
        initial={"q'": 0.5},
        impulses=[wall],
        sensitivities=["e", "f", "q'", "b"],
        samples=2,
        tolerance=1e-12,
    )
    # q = f - e w (t - f/w)
    expected = {"e": -0.5 * (1 - 0.4), "f": 1 + 0.6, "q'": -0.6, "b": 0.0}
    for name, value in expected.items():
        assert motion.sensitivity["q", name][-1] == pytest.approx(value, abs=1e-11), name
    assert motion["q"][-1] == pytest.approx(0.2 - 0.3 * 0.6) and np.isfinite(motion.energy.relative_residual)
