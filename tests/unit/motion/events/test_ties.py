"""Laws that hold with equality: N and the limit of friction fall to zero together where nothing pushes sideways."""

import numpy as np
import pytest

import freebody as fb


@pytest.mark.parametrize("seed", range(6))
def test_a_contact_of_two_coefficients_is_lifted_off(seed):
    """It opens where the lift is the weight and the adhesion, at rest from the start or after a slip."""
    rng = np.random.default_rng(seed)
    g, mass, lift, pull = 10, rng.uniform(0.5, 2), rng.uniform(30, 60), float(rng.choice([0, 3]))
    s = fb.System("block")
    s.gravity = (0, -g, 0)
    if seed % 2:
        body = s.body("block", fb.box(mass, (0.2, 0.2, 0.2)))
        s.planar("plane", s.ground, body, coordinate="x y turn")
        feature, height, points = body.corners(size=(0.2, 0.2)), 0.1, 2
    else:
        body = s.body("block", fb.particle(mass))
        s.chain("plane", s.ground, body, [fb.Slider("x", "x"), fb.Slider("y", "y")])
        feature, height, points = body.origin, 0.0, 1
    mu = rng.uniform(0.2, 0.6)
    s.contact("floor", feature, s.ground.plane(), friction=mu, static_friction=1.4 * mu, adhesion=pull)
    s.force("lift", body.origin, (0, f"{lift}*t", 0))
    motion = fb.simulate(s, 1, initial={"y": height, "x'": float(rng.choice([0, 0.3]))})
    opens = [one.start for one in motion.modes if one.mode == "open" and one.start > 0]
    assert opens == pytest.approx([(mass * g + points * pull) / lift] * points, rel=1e-9)
    forces = np.array([motion.contacts[name].least[:, 0] for name in motion.contacts])
    assert forces.min() >= -pull * (1 + 1e-9) - 1e-9 * mass * g
