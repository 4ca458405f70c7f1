"""What closes within the microsecond of a straight step at the end of a slip."""

import numpy as np
import pytest

import freebody as fb
from contact_machines import G, landing, puck_and_ball

SPEED = 1e-3


# a slip of 1e-8 m/s ends within 1 µs, 0.5 µs and 0.1 µs
@pytest.mark.parametrize(
    ("friction", "before"), [(1e-3, 1.1e-6), (2e-3, 3e-7), (2e-3, 1e-8), (1e-2, 1e-7), (1e-2, 1e-8)]
)
def test_a_ball_lands_while_a_slip_ends(friction, before):
    """It bounces, and the puck comes to rest at v/(μ g), with all its points at once."""
    stops = SPEED / (friction * G)
    s, start = puck_and_ball(friction, stops - before)
    motion = fb.simulate(s, 1.5 * stops, initial=start | {"p_vx": SPEED})
    assert landing(motion) == pytest.approx(stops - before, abs=1e-12)
    assert motion.contacts["bounce"].gap.min() > -1e-12
    assert float(motion["p_x"][-1]) == pytest.approx(SPEED * stops / 2, rel=1e-9)
    assert np.abs(motion.states[-1, 14:20]).max() < 1e-15
    assert np.abs(motion.energy.residual).max() < 1e-14


@pytest.mark.parametrize(
    ("attitude", "turn"),
    [
        (
            (0.3775018696407647, -0.2332590491067826, -0.41181289106823443, -0.7959225447099416),
            (-4.978310865370224, -4.725460968575537, 9.130456548090484),
        ),
        (
            (-0.4288668035493946, 0.07728230778201314, 0.8938969754809538, 0.10511378093862937),
            (-41.281114754343804, 8.368493412049792, -7.882580708324051),
        ),
    ],
)
def test_a_slip_fades_while_bounces_end(attitude, turn):
    """Two dice of 10,000: one corner slips by 1e-11 m/s, to and fro, while the bounces of another one end."""
    s = fb.System("die")
    s.gravity = (0, 0, -9.81)
    die = s.body("die", fb.box(0.01, (0.02, 0.02, 0.02)))
    s.free("f", s.ground, die)
    corners = die.corners(size=(0.02, 0.02, 0.02))
    s.contact("floor", corners, s.ground.plane(normal="z"), friction=0.4, restitution=0.4)
    start = {"f_z": 0.3} | {f"f_e{i}": x for i, x in enumerate(attitude)}
    motion = fb.simulate(s, 1, initial=start | dict(zip(("f_wx", "f_wy", "f_wz"), turn, strict=True)))
    assert abs(motion.path.states[-1][7:13]).max() < 1e-12
    assert motion.energy.relative_residual < 1e-8
    assert 0 <= motion.residual <= 1e-9  # `cones.contacts.ACCEPTED`
