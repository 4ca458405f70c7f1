"""What closes within the microsecond of a straight step, at the start and at the end of a slip."""

import numpy as np
import pytest

import freebody as fb

G, RADIUS, SPEED = 9.81, 0.1, 1e-3


def puck_and_ball(friction, lands, pull=None, **more):
    """A puck that stands on four points, and a ball beside it that lands at a time."""
    s = fb.System("beside")
    s.gravity = (0, 0, -G)
    floor = s.ground.plane(normal="z")
    size = (0.1, 0.1, 0.02)
    puck, ball = s.body("puck", fb.box(1, size)), s.body("ball", fb.sphere(1, RADIUS))
    s.free("p", s.ground, puck)
    s.free("b", s.ground, ball)
    s.contact("feet", puck.corners(size=size), floor, friction=friction, **more)
    s.contact("bounce", ball.sphere(RADIUS), floor, restitution=0.5)
    if pull is not None:
        s.force("pull", puck.point(0, 0, -size[2] / 2), (f"{pull}*t", 0, 0), frame=s.ground)
    return s, {"p_z": size[2] / 2, "b_x": 1, "b_z": RADIUS + G * lands**2 / 2}


def landing(motion):
    """Return the time of the ball's first impact."""
    return next(float(one.time) for one in motion.events if "bounce" in str(one))


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


def test_a_ball_lands_while_a_slip_begins():
    """The pull k t exceeds μ_s m g; 0.2 µs later the ball lands, before the slip has 4e-8 m/s."""
    static, friction, k = 0.11, 0.1, 10.0
    begins = static * G / k
    s, start = puck_and_ball(friction, begins + 2e-7, pull=k, static_friction=static)
    until = begins + 0.05
    motion = fb.simulate(s, until, initial=start)
    assert landing(motion) == pytest.approx(begins + 2e-7, abs=1e-12)
    assert motion.contacts["bounce"].gap.min() > -1e-12
    # v = (k/2)(t² - t0²) - μ g (t - t0)
    speed = k / 2 * (until**2 - begins**2) - friction * G * (until - begins)
    assert float(motion["p_vx"][-1]) == pytest.approx(speed, abs=1e-9)
    assert np.abs(motion.energy.residual).max() < 1e-12


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
