"""Contacts under signals and sampled controllers: closed forms of blocks and disks, between the events of contacts."""

from __future__ import annotations

import math

import numpy as np
import pytest

import freebody as fb
from contact_machines import MU, G, M, ball_in_jumping_field, block_kicked_by_a_change, pushed_block


def test_a_ramp_makes_a_block_slip_at_the_limit_of_friction():
    """F = 4 t to t = 2, then 8 N: slip from F = μ m g, v = ∫ (F/m - μ g) dt."""
    s = pushed_block(fb.signal([0, 2, 5], [0, 8, 8]))
    motion = fb.simulate(s, 4, samples=401)
    begin = MU * M * G / 4
    (first, second) = motion.modes
    assert (first.mode, second.mode) == ("stick", "slip+")
    assert second.start == pytest.approx(begin, abs=1e-9)

    def speed(t):
        early = np.clip(t, begin, 2)
        return (
            (2 * (early**2 - begin**2) / M)
            - MU * G * (early - begin)
            + np.clip(t - 2, 0, None) * (8 / M - MU * G)
        )

    np.testing.assert_allclose(motion["x'"], speed(motion.t), atol=1e-9)
    T = motion.contacts["floor"].tangential
    before = motion.t < begin
    np.testing.assert_allclose(T[before], -4 * motion.t[before], atol=1e-9)
    assert motion.energy.relative_residual < 1e-9


def test_a_step_of_a_signal_changes_the_modes_at_once():
    s = pushed_block(fb.signal([0, 1, 2], [0, 10, 0], "previous"))
    motion = fb.simulate(s, 3, samples=301)
    assert [(m.mode, m.why) for m in motion.modes][:2] == [
        ("stick", "the start"), ("slip+", "a change of a signal or controller")
    ]  # fmt: skip
    top = 10 / M - MU * G
    stop = 2 + top / (MU * G)
    assert motion.modes[1].start == 1
    assert motion.modes[2].mode == "stick" and motion.modes[2].start == pytest.approx(stop, abs=1e-9)
    assert motion["x"][-1] == pytest.approx(top / 2 + top**2 / (2 * MU * G), rel=1e-9)


def test_a_sampled_brake():
    """F = -c v, held between samples: v_{k+1} = v_k - (μ g + c v_k/m) h, until the block stops."""
    c, h, v = 1.5, 0.1, 3.0
    read = []

    def law(t, now):
        read.append((t, now["x'"]))
        return -c * now["x'"]

    s = pushed_block((law, h))
    motion = fb.simulate(s, 2, initial={"x'": v}, samples=201)
    t, speeds = 0.0, [v]
    while True:
        a = MU * G + c * v / M
        if v - a * h < 0:
            stop = t + v / a
            break
        v, t = v - a * h, t + h
        speeds.append(v)
    np.testing.assert_allclose([x for _, x in read[: len(speeds)]], speeds, atol=1e-9)
    assert motion.modes[-1].mode == "stick" and motion.modes[-1].start == pytest.approx(stop, abs=1e-9)
    assert len(read) == 20 and motion["x'"][-1] == pytest.approx(0, abs=1e-12)
    # held in the rest of its interval, it sticks with the last force of the brake
    still = (motion.t > stop) & (motion.t < math.ceil(stop / h) * h - 1e-9)
    np.testing.assert_allclose(motion.contacts["floor"].tangential[still], c * speeds[-1], atol=1e-9)
    assert motion.energy.relative_residual < 1e-9


def test_gravity_that_jumps_is_work():
    """A ball falls with g, then with 2 g: the jump of its potential is in the ledger."""
    s = ball_in_jumping_field(restitution=0.5)
    motion = fb.simulate(s, 1, initial={"y": 1.1}, samples=101)
    v, y = G * 0.2, 1 - G * 0.02
    hit = 0.2 + (math.sqrt(v * v + 4 * G * y) - v) / (2 * G)
    assert motion.happenings[0].time == pytest.approx(hit, rel=1e-10)
    assert motion.energy.relative_residual < 1e-9


def test_events_and_blows_that_a_change_calls():
    """The function of an event jumps through zero where a controller changes its input; so may that of a blow."""
    s, kick = block_kicked_by_a_change()
    motion = fb.simulate(s, 2, events=[fb.event("push - 2 + t - 1", name="on")], impulses=[kick])
    assert [event.time for event in motion.events if event.name in ("on", "kick")] == [1.0, 1.0]
    assert motion["x'"][-1] == pytest.approx(4 / M + 10 / M - MU * G, rel=1e-9)
    ended = fb.simulate(s, 2, events=[fb.event("push - 2 + t - 1", name="on", terminal=True)])
    assert ended.status == "terminal event" and ended.t[-1] == 1


def test_a_saved_motion_has_the_values_of_each_phase(tmp_path):
    s = pushed_block(fb.signal([0, 1, 2], [0, 10, 0], "previous"))
    motion = fb.simulate(s, 3, samples=31)
    motion.save(tmp_path / "motion.nc")
    again = fb.Trajectory.load(tmp_path / "motion.nc")
    np.testing.assert_array_equal(again["x"], motion["x"])
    np.testing.assert_array_equal(again.contacts["floor"].tangential, motion.contacts["floor"].tangential)
    assert str(again.modes) == str(motion.modes)


def test_motions_of_a_batch_with_a_signal():
    s = pushed_block(fb.signal([0, 2, 5], [0, 8, 8]))
    one = fb.simulate(s, 3, samples=4)
    data = fb.simulate(s, 3, initial={"x": [0.0, 1.0]}, samples=4)
    np.testing.assert_allclose(data["x"].values, [one["x"], one["x"] + 1], atol=1e-12)


def test_a_controller_reads_the_contacts_just_before_each_sample():
    """Under a weight that grows by 3 N/s, a push of 5 N/s in steps; at the start no force has acted."""
    read = []

    def law(t, x):
        read.append((t, x["N"], x["T"], x["left"], x["gap"], x["twice"]))
        return 5 * t

    sensors = {"N": "floor.normal", "T": "floor.tangential", "left": "floor.margin - 1", "gap": "floor.gap"}
    s = pushed_block((law, 0.1), mu=0.5, sensors=sensors | {"twice": "2*x'"})
    s.force("weight", s.bodies["block"].origin, (0, "-3*t", 0))
    fb.simulate(s, 1)
    t, N, T, left, gap, twice = np.array(read).T
    assert (N[0], T[0], left[0]) == (0, 0, -1)
    np.testing.assert_allclose(N[1:], M * G + 3 * t[1:], rtol=1e-12)
    np.testing.assert_allclose(T[1:], -5 * t[:-1], rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(left[1:], 0.5 * N[1:] - 5 * t[:-1] - 1, rtol=1e-12)
    assert not gap.any() and not twice.any()


def test_a_leg_that_pushes_while_its_foot_feels_the_floor():
    """A foot under a mass; each landing is felt at the next sample, and not before."""
    felt = []

    def law(t, x):
        felt.append((t, x["N"], x["gap"]))
        return 30.0 if x["N"] > 0 else 0.0

    s = fb.System("hopper")
    s.gravity = (0, -G, 0)
    u = s.parameters(u=0.0)
    foot, mass = s.body("foot", fb.particle(0.2)), s.body("mass", fb.particle(1))
    s.slider("rail", s.ground, foot, axis="y", coordinate="y")
    leg = s.slider("leg", foot, mass, axis="y", coordinate="h")
    s.force("motor", leg, u)
    s.force("spring", leg, "200*(0.5 - h)")
    s.contact("floor", foot.origin, s.ground.plane())
    s.controller(law, 0.02, "u", sensors={"N": "floor.normal", "gap": "floor.gap"}, name="law")
    motion = fb.simulate(s, 2, initial={"y": 0.3, "h": 0.5}, samples=2001)
    assert motion.energy.relative_residual < 1e-9
    closed = [(one.start, one.end) for one in motion.modes if one.mode != "open"]
    assert len(closed) == 3
    for t, N, gap in felt[1:]:
        touches = any(start < t <= end for start, end in closed)
        assert (N > 0) == touches and (gap > 0) == (not touches)
