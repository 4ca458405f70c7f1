"""Stops, dry friction in joints, and gaps of users, against closed forms."""

import math

import numpy as np
import pytest
from scipy.special import ellipk

import freebody as fb


def block(F=2.0, k=100.0, **law):
    s = fb.System("block on a spring")
    body = s.body("block", fb.particle(1))
    guide = s.slider("guide", s.ground, body, axis="x", coordinate="x")
    s.spring("k", guide, stiffness=k)
    s.friction("dry", guide, force=F, **law)
    return s


def pendulum():
    s = fb.System("pendulum")
    s.gravity = (0, -9.81, 0)
    bob = s.body("bob", fb.particle(1))
    pin = s.hinge("pin", s.ground, bob, to=(0, 1, 0), axis="z", coordinate="theta")
    return s, pin


@pytest.mark.parametrize("method", ["auto", "dop54"])
def test_amplitude_of_a_coulomb_damped_block_falls_by_2_F_over_k_in_each_half_period(method):
    motion = fb.simulate(block(), 3, initial={"x": 0.19}, method=method, tolerance=1e-12)
    times = [event.time for event in motion.events]
    assert times == pytest.approx([math.pi / 10 * n for n in range(1, len(times) + 1)], rel=1e-11)
    turned = [event.state["x"] for event in motion.events]
    assert turned == pytest.approx(
        [0.19 * (-1) ** n - 0.04 * n * (-1) ** n for n in range(1, 6)][: len(turned)]
    )
    # it stops where the spring is weaker than the friction, and stays
    assert motion["x"][-1] == pytest.approx(turned[-1], abs=1e-12) and abs(turned[-1]) <= 0.02
    assert motion.contacts["dry"].tangential[-1] == pytest.approx(100 * turned[-1], abs=1e-9)
    assert motion.modes[-1].mode == "stick"
    assert abs(motion.energy.residual).max() < 1e-10
    assert motion.energy.friction[-1] == pytest.approx(-50 * (0.19**2 - turned[-1] ** 2), rel=1e-9)


@pytest.mark.parametrize(("part", "mode"), [(1 - 1e-9, "stick"), (1 + 1e-9, "slip+"), (-1 - 1e-9, "slip-")])
def test_the_bound_of_stick_is_exact(part, mode):
    s = fb.System("wheel")
    wheel = s.body("wheel", fb.disk(1, 0.3))
    pin = s.hinge("pin", s.ground, wheel, axis="z", coordinate="theta")
    s.torque("M", pin, 3 * part)
    s.friction("dry", pin, torque=3)
    motion = fb.simulate(s, 1)
    assert motion.contacts["dry"].mode[-1] == mode
    assert (motion["theta"][-1] == 0) == (mode == "stick")


def test_static_friction_holds_until_it_is_exceeded():
    s = fb.System("wheel")
    F = s.parameters(F=2.0)
    wheel = s.body("wheel", fb.disk(2, 1))  # J = 1
    pin = s.hinge("pin", s.ground, wheel, axis="z", coordinate="theta")
    s.torque("M", pin, s.t)
    s.friction("dry", pin, torque=F, static=1.5 * F)
    motion = fb.simulate(s, 4, tolerance=1e-12)
    (event,) = motion.events
    assert event.time == pytest.approx(3, rel=1e-12) and "stick → slip +" in str(event)
    # theta'' = t - F from t = 3
    assert motion["theta"][-1] == pytest.approx((2**3 - 1) / 6 - 0.5, rel=1e-9)


def test_a_pendulum_falls_onto_a_stop_in_a_quarter_of_its_period():
    s, pin = pendulum()
    s.stop("wall", pin, low=0, restitution=0.6)
    motion = fb.simulate(s, 6, initial={"theta": 1.0}, tolerance=1e-12)
    impacts = [event for event in motion.events if "impact" in str(event)]
    amplitude, at = 1.0, 0.0
    for k, event in enumerate(impacts[:4]):
        quarter = ellipk(math.sin(amplitude / 2) ** 2) / math.sqrt(9.81)
        at += quarter if k == 0 else 2 * quarter
        assert event.time == pytest.approx(at, rel=1e-10)
        speed = 0.6 * math.sqrt(2 * 9.81 * (1 - math.cos(amplitude)))
        amplitude = math.acos(1 - speed**2 / (2 * 9.81))


def test_bounces_on_a_stop_end_as_their_geometric_series_does():
    s = fb.System("ball on a rod")
    s.gravity = (0, 0, -10)
    ball = s.body("ball", fb.particle(2))
    rod = s.slider("rod", s.ground, ball, axis="z", coordinate="z")
    s.stop("floor", rod, low=s.parameters(h=0.25), restitution=0.5)
    motion = fb.simulate(s, 3, initial={"z": 1.5}, tolerance=1e-12)
    fall = math.sqrt(2 * 1.25 / 10)
    assert motion.events[0].time == pytest.approx(fall, rel=1e-11)
    assert motion.modes[-1].mode == "closed"
    assert motion.events[-1].time == pytest.approx(fall * (1 + 2 * 0.5 / (1 - 0.5)), rel=1e-11)
    assert motion.contacts["floor"].normal[-1] == pytest.approx(20, rel=1e-12)
    assert motion["z"][-1] == pytest.approx(0.25, abs=1e-12)


def test_a_free_pair_keeps_its_momentum_at_a_stop_between_them():
    s = fb.System("pair")
    a, b = s.body("a", fb.particle(1)), s.body("b", fb.particle(3))
    s.slider("left", s.ground, a, axis="x", coordinate="x1")
    s.slider("right", s.ground, b, axis="x", coordinate="x2")
    s.stop("bumper", "x2 - x1", low=0.5, restitution=0.5)
    motion = fb.simulate(s, 2, initial={"x1": 0, "x2": 1.5, "x1'": 2})
    v1, v2 = motion["x1'"], motion["x2'"]
    assert v1 + 3 * v2 == pytest.approx(2, rel=1e-14)
    assert motion.events[0].time == pytest.approx(0.5, rel=1e-12)
    assert v2[-1] - v1[-1] == pytest.approx(0.5 * 2, rel=1e-12)


def test_a_pendulum_with_friction_in_its_pin_loses_torque_times_angle():
    s, pin = pendulum()
    s.friction("dry", pin, torque=0.4)
    motion = fb.simulate(s, 8, initial={"theta": 1.2}, tolerance=1e-12)
    turned = [1.2, *(event.state["theta"] for event in motion.events)]
    for before, after in zip(turned, turned[1:], strict=False):
        lost = 9.81 * (math.cos(after) - math.cos(before))
        assert lost == pytest.approx(0.4 * abs(after - before), rel=1e-9)
    assert abs(motion.energy.residual).max() < 1e-9


def test_a_compliant_stop_is_half_an_oscillation():
    s = fb.System("buffer")
    body = s.body("block", fb.particle(1))
    guide = s.slider("guide", s.ground, body, axis="x", coordinate="x")
    s.stop("buffer", guide, low=0, stiffness=400)
    motion = fb.simulate(s, 1, initial={"x": 0.5, "x'": -2}, tolerance=1e-12)
    assert [event.time for event in motion.events] == pytest.approx([0.25, 0.25 + math.pi / 20], rel=1e-9)
    assert motion["x"].min() == pytest.approx(-0.1, abs=1e-3)
    assert motion["x'"][-1] == pytest.approx(2, rel=1e-9)


def test_time_steps_tend_to_the_events():
    s, pin = pendulum()
    s.stop("wall", pin, low=0, restitution=0.6)
    s.friction("dry", pin, torque=0.3)
    start = {"theta": 1.0}
    by_events = fb.simulate(s, 1.5, initial=start)["theta"][-1]
    off = [
        abs(fb.simulate(s, 1.5, initial=start, method="timestepping", step=h)["theta"][-1] - by_events)
        for h in (2e-3, 2e-4)
    ]
    assert off[0] < 2e-2 and off[1] < 2e-3


class Bowl(fb.Gap):
    """A point in a bowl z = c (x² + y²)/2 of the ground."""

    point: fb.Point
    curvature: fb.Expression

    def gap(self, at):
        x, y, z = at.position(self.point)
        c = at(self.curvature)
        return (z - c * (x * x + y * y) / 2) / at.sqrt(1 + c * c * (x * x + y * y))

    def normal(self, at):
        x, y, _ = at.position(self.point)
        c = at(self.curvature)
        n = at.vector((0, 0, 1)) - c * x * at.vector((1, 0, 0)) - c * y * at.vector((0, 1, 0))
        n = n / n.norm()
        yield fb.PointForce(self.point, n)
        yield fb.PointForce(at.spot(self.point.body.system.ground, at.position(self.point)), -n)


def test_a_marble_circles_in_a_bowl_of_a_user():
    s = fb.System("marble")
    s.gravity = (0, 0, -9.81)
    marble = s.body("marble", fb.sphere(0.1, 0.01))
    s.free("air", s.ground, marble)
    s.add("bowl", Bowl(marble.origin, 2))
    w = math.sqrt(2 * 9.81)
    motion = fb.simulate(s, 2, initial={"air_x": 0.3, "air_z": 0.09, "air_vy": 0.3 * w}, tolerance=1e-11)
    assert motion["air_x"][-1] == pytest.approx(0.3 * math.cos(2 * w), abs=1e-9)
    N = 0.1 * math.hypot(9.81, w**2 * 0.3)
    assert motion.contacts["bowl"].normal == pytest.approx(np.full(len(motion.t), N), rel=1e-9)


def test_a_stop_and_friction_in_one_joint():
    """Where the arm rests on its stop, the torque of friction may have any value within its bound."""
    s = fb.System("arm")
    s.gravity = (0, -10, 0)
    bar = s.body("bar", fb.slender_bar(1, 1, axis="x"))
    pin = s.hinge("pin", s.ground, bar, to=(-0.5, 0, 0), axis="z", coordinate="th")
    s.stop("bumper", pin, low="-60deg", high="30deg", restitution=0.5)
    s.friction("dry", pin, torque=0.1)
    motion = fb.simulate(s, until=10, initial={"th": 0.4}, tolerance=1e-9)
    assert motion["th"][-1] == pytest.approx(-math.pi / 3, abs=1e-9)
    assert abs(motion["th'"][-1]) < 1e-12
    assert motion.indeterminate == ("N_bumper_low", "T_dry")


def test_a_stop_that_bears_nothing_any_more_leaves_the_friction_to_hold():
    """As a force of 2 cos t turns away from the stop, stop and friction bear zero: round-off decides nothing."""
    s = fb.System("cart")
    cart = s.body("cart", fb.particle(1))
    guide = s.slider("guide", s.ground, cart, axis="x", coordinate="x")
    s.force("push", cart.origin, ("2*cos(t)", 0, 0))
    s.stop("end", guide, high=0)
    s.friction("dry", guide, force=3, static=3.5)
    motion = fb.simulate(s, 6)
    assert np.abs(motion.states[:, :2]).max() == 0
    assert (
        np.abs(motion.states[:, 2:]).max() < 6 * np.finfo(float).eps
    )  # work and heat, of speeds in round-off
    assert set(motion.contacts["dry"].mode) == {"stick"}


def test_a_stop_that_does_not_rebound_takes_part_in_an_impact_by_poissons_law():
    """A block reaches its stop as a ball hits it: the stop takes all, and e of the ball's impulse comes back."""
    s = fb.System("block and ball")
    block, ball = s.body("block", fb.box(3, (0.2, 0.2, 0.2))), s.body("ball", fb.sphere(1, 0.1))
    guide = s.slider("guide", s.ground, block, axis="x", coordinate="x")
    s.slider("rail", s.ground, ball, axis="x", coordinate="y")
    s.stop("end", guide, high=0)
    back = block.plane(at=(-0.1, 0, 0), normal="-x")
    s.contact("hit", ball.sphere(0.1), back, restitution=0.5, impact="poisson")
    motion = fb.simulate(s, 2, initial={"x": -1, "x'": 1, "y": -2.2, "y'": 2})
    assert [event.time for event in motion.events][:1] == [pytest.approx(1, abs=1e-12)]
    assert motion["y'"][-1] == pytest.approx(-1, abs=1e-12)
    assert motion["x'"][-1] == pytest.approx(0, abs=1e-12)
