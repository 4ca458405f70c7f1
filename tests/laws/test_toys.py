"""Toys of contact mechanics: a house of cards, Newton's cradle, a ball in a bowl."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.special import ellipk

import freebody as fb

G = 9.81
LENGTH, WIDTH, THICK, LEAN = 0.09, 0.06, 0.001, np.radians(15)


def house_of_cards(friction, roof=True):
    """Cards that lean on each other with their upper edges, two by two, and one across two such pairs."""
    s, start = fb.System("house of cards"), {}
    s.gravity = (0, 0, -G)
    shapes, turn = [s.ground.plane(normal="z")], Rotation.from_rotvec([0, LEAN, 0])

    def card(name, x, z, angle):
        body = s.body(name, fb.box(0.002, (THICK, WIDTH, LENGTH)))
        s.free(name, s.ground, body)
        shapes.append(body.box((THICK, WIDTH, LENGTH)))
        q = np.roll(Rotation.from_rotvec([0, angle, 0]).as_quat(), 1)
        start.update({f"{name}_e{k}": float(value) for k, value in enumerate(q)})
        start.update({f"{name}_x": float(x), f"{name}_z": float(z)})

    top, foot = turn.apply([THICK / 2, 0, LENGTH / 2]), turn.apply([THICK / 2, 0, -LENGTH / 2])
    for i, x in enumerate((0, 0.06) if roof else (0,)):
        card(f"left{i}", x - top[0], -foot[2], LEAN)
        card(f"right{i}", x + top[0], -foot[2], -LEAN)
    if roof:
        height = turn.apply([-THICK / 2, 0, LENGTH / 2])[2] - foot[2]
        card("roof", 0.03, height + THICK / 2, np.pi / 2)
    s.contacts("house", shapes, friction=friction)
    return s, start


def moved(motion):
    coordinates = motion.states[:, : len(motion.kernels.model.coordinate_names)]
    return np.abs(coordinates - coordinates[0]).max()


@pytest.mark.parametrize(("friction", "stands"), [(0.4, True), (0.1, False)])
def test_a_house_of_cards_stands_or_falls(friction, stands):
    s, start = house_of_cards(friction)
    motion = fb.simulate(s, 0.1, initial=start, method="timestepping", step=1e-3)
    assert moved(motion) < 1e-12 if stands else moved(motion) > 1e-3


@pytest.mark.parametrize("roof", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_a_house_of_cards_stands_by_events(roof):
    s, start = house_of_cards(0.4, roof)
    motion = fb.simulate(s, 0.1, initial=start)
    assert moved(motion) < 1e-12 and len(motion.events) == 0


def test_newtons_cradle_swings_at_its_ends_in_turn():
    """Equal elastic balls on strings: one after another, the impact passes to the last one."""
    s, r = fb.System("Newton's cradle"), 0.1
    s.gravity = (0, -G, 0)
    balls = [s.body(f"ball{k}", fb.sphere(1, r)) for k in range(5)]
    for k, ball in enumerate(balls):
        s.hinge(
            f"string{k}", s.ground, ball, at=(2 * r * k, 0, 0), to=(0, 1, 0), axis="z", coordinate=f"q{k}"
        )
    for k in range(4):
        s.contact(f"c{k}", balls[k + 1].sphere(r), balls[k].sphere(r), restitution=1)
    motion = fb.simulate(s, 2.1, initial={"q0": -0.5}, impacts="sequential")
    assert np.abs(motion.energy.residual).max() < 1e-8
    t, first, last = motion.t, motion["q0"], motion["q4"]
    swing = 4 * np.sqrt((1 + 2 / 5 * r**2) / G) * ellipk(np.sin(0.25) ** 2)  # I = m (L² + 2/5 r²), L = 1
    assert motion.at(swing / 2)["q4"] == pytest.approx(0.5, abs=1e-4)
    assert motion.at(swing)["q0"] == pytest.approx(-0.5, abs=1e-4)
    assert np.abs(first[(t > 0.3 * swing) & (t < 0.7 * swing)]).max() < 5e-3
    assert np.abs(last[(t < 0.2 * swing) | (t > 0.8 * swing)]).max() < 5e-3


def test_a_ball_rolls_in_a_bowl_as_a_pendulum():
    """θ'² = 10/7 g/(R - r) (cos θ - cos θ₀), so that its period is 4 √(7 (R - r)/(5 g)) K(sin θ₀/2)."""
    s, r, R, begin = fb.System("ball in a bowl"), 0.1, 1.0, 0.6
    s.gravity = (0, 0, -G)
    ball = s.body("ball", fb.sphere(1, r))
    s.free("air", s.ground, ball)
    s.contact("bowl", ball.sphere(r), s.ground.sphere(R, inside=True), friction=0.5)
    start = {"air_x": (R - r) * np.sin(begin), "air_z": -(R - r) * np.cos(begin)}
    period = 4 * np.sqrt(7 * (R - r) / (5 * G)) * ellipk(np.sin(begin / 2) ** 2)
    motion = fb.simulate(s, period, initial=start, events=[fb.event("air_x", name="lowest")])
    crossed = [event.time for event in motion.events if event.name == "lowest"]
    np.testing.assert_allclose(crossed, [period / 4, 3 * period / 4], rtol=1e-8)
    np.testing.assert_allclose(motion.contacts["bowl"].gap, 0, atol=1e-12)
    assert set(motion.contacts["bowl"].mode) == {"stick"} and np.abs(motion.energy.residual).max() < 1e-8
    assert float(motion["air_x"][-1]) == pytest.approx(start["air_x"], abs=1e-8)
