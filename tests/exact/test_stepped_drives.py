"""Contacts under signals and sampled controllers in time steps: closed forms, and the limit of fine steps."""

from __future__ import annotations

import math

import numpy as np
import pytest

import freebody as fb
from contact_machines import MU, G, M, ball_in_jumping_field, block_kicked_by_a_change, pushed_block

STEPS = {"method": "timestepping"}


def test_a_ramp_makes_a_block_slip_at_the_limit_of_friction():
    """F = 4 t to t = 1.97, then held: in each step T is the mean of -F while it sticks; speeds follow from the sum."""
    bend = 1.97
    s = pushed_block(fb.signal([0, bend, 5], [0, 4 * bend, 4 * bend]))
    motion = fb.simulate(s, 4, step=0.01, **STEPS)
    begin = MU * M * G / 4
    first, second = motion.modes
    assert (first.mode, second.mode) == ("stick", "slip+")
    assert begin - 0.01 <= second.start <= begin
    assert bend in motion.path.times
    t, v = motion.path.times, motion.path.states[:, 2]
    slips = t >= second.start
    v_of = 2 * np.minimum(t, bend) ** 2 / M + 4 * bend / M * np.clip(t - bend, 0, None) - MU * G * t
    np.testing.assert_allclose(v[slips], (v_of - v_of[slips][0])[slips], atol=1e-12)
    still = (motion.path.times[1:] <= second.start) & (motion.path.times[1:] < bend)
    T = motion.course.impulses.contacts[:, 1] / motion.path.lengths
    middles = t[:-1] + motion.path.lengths / 2
    np.testing.assert_allclose(T[still], -4 * middles[still], atol=1e-11)
    assert motion.energy.relative_residual < 1e-12


@pytest.mark.parametrize(("period", "step"), [(0.1, 0.01), (0.1, 0.03), (0.1, 0.25), (0.07, 0.02)])
def test_a_sampled_brake(period, step):
    """F = -c v, held between samples: v_{k+1} = v_k - (μ g + c v_k/m) T, whatever the steps are, until it stops."""
    c, v, read = 1.5, 3.0, []

    def law(t, now):
        read.append((t, now["x'"]))
        return -c * now["x'"]

    motion = fb.simulate(pushed_block((law, period)), 2, initial={"x'": v}, step=step, **STEPS)
    samples = math.ceil(2 / period - 1e-9)
    np.testing.assert_allclose([t for t, _ in read], period * np.arange(samples), rtol=0, atol=1e-15)
    assert set(t for t, _ in read) <= set(motion.path.times.tolist())
    each = math.ceil(period / step - 1e-9)
    whole = round(2 / period) * period == pytest.approx(2, abs=1e-12)
    assert len(motion.path.lengths) == each * samples or not whole
    assert motion.step <= step * (1 + 1e-9)
    np.testing.assert_allclose(motion.path.lengths[: each * (samples - 1)], period / each, rtol=1e-9)
    speeds = [v]
    while speeds[-1] > (MU * G + c * speeds[-1] / M) * period:
        speeds.append(speeds[-1] - (MU * G + c * speeds[-1] / M) * period)
    np.testing.assert_allclose([x for _, x in read[: len(speeds)]], speeds, atol=1e-12)
    assert motion.modes[-1].mode == "stick" and motion["x'"][-1] == pytest.approx(0, abs=1e-15)
    held = np.array([-c * x for _, x in read])
    between = np.abs(motion.t / period - np.round(motion.t / period)) > 1e-9
    at = (motion.t[between] / period).astype(int)
    np.testing.assert_allclose(motion["push"][between], held[at], atol=1e-15)
    at_steps = fb.simulate(
        pushed_block((law, period)), 2, initial={"x'": v}, step=step, times=motion.path.times, **STEPS
    )
    assert at_steps.energy.relative_residual < 1e-12


def test_gravity_that_jumps_is_work():
    s = ball_in_jumping_field(friction=0.2)
    motion = fb.simulate(s, 0.3, initial={"y": 1.1, "x'": 1}, step=1e-3, samples=31, **STEPS)
    assert motion.energy.relative_residual < 1e-12 and not motion.warnings
    jump = G * (1.1 - G * 0.02)
    assert motion.energy.impulses[-1] == pytest.approx(2 * jump - jump, rel=1e-12)
    # without a weight that jumps, all of it is of second order: the fall is exact
    assert motion.at(0.2)["y"] == pytest.approx(1.1 - G * 0.02, rel=1e-13)


def test_events_and_blows_that_a_change_calls():
    s, kick = block_kicked_by_a_change()
    on = fb.event("push - 2 + t - 1", name="on")
    motion = fb.simulate(s, 2, events=[on], impulses=[kick], step=0.01, **STEPS)
    assert [event.time for event in motion.events if event.name in ("on", "kick")] == [1.0, 1.0]
    assert motion["x'"][-1] == pytest.approx(4 / M + 10 / M - MU * G, rel=1e-12)
    ended = fb.simulate(s, 2, events=[fb.event(on.expression, name="on", terminal=True)], step=0.03, **STEPS)
    assert ended.status == "terminal event" and ended.t[-1] == 1 and ended["push"][-1] == 0


def arm(gain=8.0):
    """An arm under gravity, a gust and a sampled PD that drives its tip against a wall."""
    s = fb.System("arm")
    g, tau = s.parameters(g=G, tau=0.0)
    s.gravity = (0, -g, 0)
    bob = s.body("bob", fb.sphere(1, 0.05))
    pin = s.hinge("pin", s.ground, bob, to=(0, 0.5, 0), axis="z", coordinate="theta")
    s.torque("motor", pin, tau)
    s.force("push", bob, (fb.signal([0, 0.333, 1.517, 4], [0, 3, -1, 0], name="gust"), 0, 0))
    s.contact("wall", bob.sphere(0.05), s.ground.plane(at=(0.3, 0, 0), normal="-x"), friction=0.2)
    s.controller(lambda t, x: gain * (1.2 - x["theta"]) - 1.5 * x["theta'"], 0.01, "tau", name="pd")
    return s


def test_an_arm_that_a_controller_presses_to_a_wall():
    """It rests at the wall with the torque of its last sample; before that its error falls with the step."""
    exact = fb.simulate(arm(), 2, samples=41)
    theta = math.asin(0.25 / 0.5)
    errors = []
    for step in (4e-3, 1e-3):
        motion = fb.simulate(arm(), 2, step=step, samples=41, **STEPS)
        assert motion["theta"][-1] == pytest.approx(theta, abs=1e-9)
        assert motion["tau"][-1] == pytest.approx(8 * (1.2 - theta), abs=1e-8)
        N, T = motion.contacts["wall"].normal[-1], motion.contacts["wall"].tangential[-1]
        lever = 0.5 * N * math.cos(theta) - (0.5 * math.sin(theta) + 0.05) * T
        gust = -1 * (
            1 - (2 - motion.path.lengths[-1] / 2 - 1.517) / (4 - 1.517)
        )  # in the middle of the last step
        pull = motion["tau"][-1] + 0.5 * (math.cos(theta) * gust - G * math.sin(theta))
        assert lever == pytest.approx(pull, abs=1e-6)
        errors.append(np.abs(motion["theta"] - exact["theta"]).max())
        assert motion.residual <= 1e-12
    assert errors[1] < errors[0] < 1e-4


def test_the_order_between_impacts_is_two():
    """Errors under a signal that bends beside the steps and a controller fall fourfold with half the step."""

    def pendulum():
        s = fb.System("pendulum")
        s.gravity = (0, -G, 0)
        (tau,) = (s.parameters(tau=0.0),)
        bob = s.body("bob", fb.sphere(1, 0.05))
        pin = s.hinge("pin", s.ground, bob, to=(0, 0.5, 0), axis="z", coordinate="theta")
        s.torque("motor", pin, tau)
        s.torque("gust", pin, fb.signal([0, 0.317, 0.71, 1.3, 2], [0, 3, -2, 1, 0], name="gust"))
        s.controller(lambda t, x: -2 * x["theta"], 0.05, "tau", name="p")
        s.contact("floor", bob.sphere(0.05), s.ground.plane(at=(0, -9, 0), normal="y"))
        return s

    times = np.linspace(0.25, 2, 8)
    exact = fb.simulate(pendulum(), 2, initial={"theta": 1}, tolerance=1e-12).at(times)["theta"]
    first, second = (
        np.linalg.norm(
            fb.simulate(pendulum(), 2, initial={"theta": 1}, step=h, **STEPS).at(times)["theta"] - exact
        )
        for h in (2.5e-3, 1.25e-3)
    )
    assert first / second == pytest.approx(4, rel=0.1)


def test_steps_of_changing_length_keep_what_turns():
    """A ball rolls in a bowl; break points of a signal at random times. The energy drifts by second order only."""
    times = np.concatenate([[0], np.sort(np.random.default_rng(2).uniform(0, 1, 40)), [1.0]])
    drifts = []
    for h in (4e-3, 2e-3):
        s = fb.System("bowl")
        s.gravity = (0, -G, 0)
        ball = s.body("ball", fb.disk(1, 0.1))
        s.planar("p", s.ground, ball, coordinate="x y turn")
        s.contact("bowl", ball.circle(0.1), s.ground.circle(1.0, inside=True), friction=0.8)
        s.force("none", ball, (0 * fb.signal(times, np.zeros(len(times)), name="none"), 0, 0))
        start = {"x": 0.9 * math.sin(1), "y": -0.9 * math.cos(1)}
        motion = fb.simulate(s, 1, initial=start, step=h, **STEPS)
        assert {m.mode for m in motion.modes} == {"stick"}
        drifts.append(np.abs(motion.energy.residual + motion.energy.work).max())
    assert drifts[1] < drifts[0] / 3


def test_prescribed_motion_and_families():
    """A table that shakes by a cubic signal under a family of balls, beside the motion by events."""

    def table():
        s = fb.System("table")
        s.gravity = (0, 0, -G)
        times = np.linspace(0, 1, 11)
        shake = fb.signal(times, 0.05 * np.sin(7 * times), "cubic", name="shake")
        plate = s.body("plate", fb.box(5, (1, 1, 0.1)))
        s.slider("rail", s.ground, plate, axis="x", coordinate=shake)
        start, shapes = {}, [plate.plane(at=(0, 0, 0.05), normal="z")]
        for i in range(2):
            ball = s.body(f"b{i}", fb.sphere(1, 0.1))
            s.free(f"f{i}", s.ground, ball)
            shapes.append(ball.sphere(0.1))
            start |= {f"f{i}_x": 0.3 * i, f"f{i}_z": 0.15 + 0.02 * i}
        s.contacts("pile", shapes, friction=0.3)
        return s, start

    s, start = table()
    exact = fb.simulate(s, 1, initial=start, samples=11)
    errors = []
    for h in (2e-3, 5e-4):
        motion = fb.simulate(s, 1, initial=start, samples=11, step=h, **STEPS)
        ends = [max(abs(motion[f"f{i}_x"][-1] - exact[f"f{i}_x"][-1]) for i in range(2))]
        errors.append(max(ends))
        gap = motion.contacts["pile[b0,plate]"].gap
        assert np.abs(gap).max() < 1e-9
        slip = motion.contacts["pile[b0,plate]"].slip
        of_events = exact.contacts["pile[plate,b0]"].slip
        np.testing.assert_allclose(slip[-1], of_events[-1], atol=20 * h)
    assert errors[1] < errors[0] < 1e-2 or errors[0] < 1e-6


def test_file_and_lanes(tmp_path):
    motion = fb.simulate(arm(), 0.5, step=2e-3, **STEPS)
    motion.save(tmp_path / "arm.nc")
    again = fb.Trajectory.load(tmp_path / "arm.nc")
    for name in ("tau", "gust_c0", "theta"):
        np.testing.assert_array_equal(again[name], motion[name])
    np.testing.assert_array_equal(again.energy.work, motion.energy.work)
    lanes = fb.simulate(
        arm(),
        0.5,
        values={"g": np.array([G, 1.6])},
        outputs=["theta", "tau"],
        times=[0.1, 0.5],
        step=2e-3,
        **STEPS,
    )
    np.testing.assert_array_equal(
        lanes["tau"].values[0], [motion["tau"][np.searchsorted(motion.t, t)] for t in (0.1, 0.5)]
    )
    assert list(lanes["status"].values) == ["finished", "finished"]


def test_what_is_refused():
    s = pushed_block((lambda t, x: 1.0, 1e-9))
    with pytest.raises(
        fb.errors.SimulationError, match="period of 1e-09 s of controller 'law'.*Sample less often"
    ):
        fb.simulate(s, 1, step=0.01, **STEPS)
    s = pushed_block((lambda t, x: 1 / 0, 0.5))
    with pytest.raises(
        fb.errors.SimulationError, match="Controller 'law' failed at t = 0 s: ZeroDivisionError"
    ):
        fb.simulate(s, 1, step=0.01, **STEPS)
    s = pushed_block(fb.signal(np.linspace(0, 1, 1001), np.zeros(1001)))
    with pytest.raises(
        fb.errors.SimulationError, match="at most 500 steps, got step = 0.01 s and 999 break points"
    ):
        fb.simulate(s, 1, step=0.01, max_steps=500, **STEPS)
    s = fb.System("pile")
    (k,) = (s.parameters(k=0.1),)
    balls = [s.body(f"b{i}", fb.sphere(1, 0.1)) for i in range(2)]
    for i, ball in enumerate(balls):
        s.free(f"f{i}", s.ground, ball)
    s.contacts("pile", [ball.sphere(0.1) for ball in balls], friction=k)
    s.controller(lambda t, x: 0.2, 0.1, "k", name="oil")
    with pytest.raises(
        fb.errors.SimulationError, match="'oil' sets 'k', which occurs in a mass, a dimension"
    ):
        fb.simulate(s, 1, initial={"f1_x": 1}, step=0.01, **STEPS)
