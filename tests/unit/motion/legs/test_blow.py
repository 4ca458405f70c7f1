"""Blows in the middle of a motion: times, jumps, the ledger, and what is refused."""

import math

import numpy as np
import pytest

import freebody as fb
from freebody.errors import SimulationError

G = 9.81


def ball(axis="y"):
    s = fb.System("ball")
    (g,) = (s.parameters(g=G),)
    s.gravity = (0, -g, 0)
    body = s.body("ball", fb.particle(2))
    s.slider("rail", s.ground, body, axis=axis, coordinate="y")
    return s, body


def test_restituted_ball_follows_the_closed_form():
    # falls from 1 m: first meets the floor at sqrt(2/g), each flight e times as long as the last
    s, body = ball()
    e = 0.8
    floor = fb.blow(fb.event("y", direction=-1), at=body, normal=(0, 1, 0), restitution=e, name="bounce")
    motion = fb.simulate(s, 2, initial={"y": 1}, impulses=[floor])
    t1, v1 = math.sqrt(2 / G), math.sqrt(2 * G)
    expected = [t1, t1 + 2 * e * v1 / G, t1 + 2 * (e + e * e) * v1 / G]
    assert [event.name for event in motion.events] == ["bounce"] * 3
    np.testing.assert_allclose([event.time for event in motion.events], expected, rtol=0, atol=1e-12)
    lost = 2 * G * (e**6 - 1)
    assert motion.energy.impulses[-1] == pytest.approx(lost, rel=1e-13)
    assert motion.energy.relative_residual < 1e-13
    assert "y' -4.42945 → 3.54356" in str(motion.events[0])


def test_blow_at_a_time_and_at_both_ends():
    s, body = ball("x")
    kicks = [fb.blow(t, at=body, impulse=(2, 0, 0), name=f"kick {t}") for t in (2, 0, 1)]
    motion = fb.simulate(s, 2, times=[0, 0.5, 1, 1.5, 2], impulses=kicks)
    np.testing.assert_allclose(motion["y'"], [1, 1, 2, 2, 3], rtol=1e-14)
    np.testing.assert_allclose(motion["y"], [0, 0.5, 1, 2, 3], rtol=1e-14)
    assert [event.name for event in motion.events] == ["kick 0", "kick 1", "kick 2"]
    assert motion.energy.work[-1] == pytest.approx(9.0, rel=1e-14)
    assert list(motion.data["event_name"].values) == ["kick 0", "kick 1", "kick 2"]
    assert motion.at(1.0)["y'"] == pytest.approx(2)


def test_constrained_machine_stays_closed_through_a_blow():
    s = fb.System("pendulum of a rod in cartesian coordinates")
    m = s.body("m", fb.disk(1, 1))
    s.planar("rail", s.ground, m, coordinate="x y turn")
    s.constrain("x^2 + y^2 - 1", name="rod")
    s.constrain("turn", name="upright")
    s.gravity = (0, -G, 0)
    start = {"x": 0, "y": -1, "x'": 1.0}
    motion = fb.simulate(
        s,
        2,
        initial=start,
        near={"y": -1},
        impulses=[fb.blow("x - 0.1", at=m, impulse=(0.5, 0.3, 0), count=1)],
    )
    assert len(motion.events) == 1
    assert np.abs(motion["x^2 + y^2 - 1"]).max() < 1e-14
    assert np.abs(motion["x*x' + y*y'"]).max() < 1e-14
    assert motion.energy.relative_residual < 1e-8


def test_user_events_keep_their_numbers_and_may_stop_the_run():
    s, body = ball("x")
    motion = fb.simulate(
        s,
        9,
        events=[fb.event("y - 3", name="there", terminal=True)],
        impulses=[fb.blow("t - 1", at=body, impulse=(2, 0, 0))],
    )
    assert [event.name for event in motion.events] == ["blow", "there"]
    assert motion.t[-1] == pytest.approx(4, abs=1e-12)
    assert motion.status == "terminal event"


def test_refusals():
    s, body = ball("x")
    with pytest.raises(SimulationError, match=r"Expected a list of fb\.blow"):
        fb.simulate(s, 1, impulses=3)
    with pytest.raises(SimulationError, match=r"Expected fb\.blow\(time, at=point"):
        fb.simulate(s, 1, impulses=[(1, 2, 3)])
    with pytest.raises(SimulationError, match="within the run, 0 to 1 s, got 5 s"):
        fb.simulate(s, 1, impulses=[fb.blow(5, at=body, impulse=(1, 0, 0))])
    text = "Expected until later than start for a run with impulses=, got until = -1 s and start = 0 s"
    with pytest.raises(SimulationError, match=text):
        fb.simulate(s, -1, impulses=[fb.blow(0, at=body, impulse=(1, 0, 0))])
    with pytest.raises(SimulationError, match="is impossible: No impact"):
        fb.simulate(s, 1, impulses=[fb.blow(0.5, at=body, normal=(1, 0, 0), restitution=0.5)])


def test_ledger_of_a_blow_before_a_law_switches():
    s = fb.System("bar on a soft stop")
    s.gravity = (0, -9.81, 0)
    bar = s.body("bar", fb.slender_bar(1, 1, axis="y"))
    pin = s.hinge("pin", s.ground, bar, to=(0, 0.5, 0), axis="z", coordinate="theta")
    s.stop("wall", pin, low=-0.2, stiffness=500)
    blows = [fb.blow(t, at=bar.origin, impulse=(0.3, 0.1, 0)) for t in (0.3, 0.54)]  # before it and on it
    motion = fb.simulate(s, 1, initial={"theta": 0.5}, impulses=blows)
    assert [event.name for event in motion.events][0] == "blow"
    assert "wall leaves" in [event.name for event in motion.events]
    assert motion.energy.impulses[-1] != 0
    assert motion.energy.relative_residual < 1e-9


def test_a_rebound_that_returns_within_a_step_is_refused():
    """The ball fell through the surface after ten rebounds, without a word."""
    s = fb.System("ball")
    s.gravity = (0, -9.81, 0)
    ball = s.body("ball", fb.particle(1))
    s.slider("rail", s.ground, ball, axis="y", coordinate="y")
    given = {"at": ball.origin, "normal": (0, 1, 0), "restitution": 0.5}
    floor = fb.blow(fb.event("y", direction=-1), **given, name="floor")
    few = fb.simulate(s, 1.3, initial={"y": 1}, impulses=[floor])
    assert len(few.events) == 5
    said = r"The blow 'floor' falls again and again from t = 1\.35\d* s on: loads turn its rebound round within a step"
    with pytest.raises(SimulationError, match=said):
        fb.simulate(s, 3, initial={"y": 1}, impulses=[floor])
