"""Conditions of ``at.where`` are events of every motion: smooth, in legs, with contacts, in time steps."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb


class Brake(fb.Load):
    """A force -F that acts beyond a place."""

    joint: fb.Joint
    place: fb.Expression
    force: fb.Expression

    switches = ("brakes", "is let go")

    def actions(self, at):
        beyond = at.displacement(self.joint) - at(self.place)
        yield fb.JointForce(self.joint, at.where(beyond, -at(self.force), 0))


def cart(**options):
    s = fb.System("cart")
    F, x0 = s.parameters(F=3.0, x0=1.0)
    body = s.body("body", fb.box(2, (0.2, 0.2, 0.2)))
    rail = s.slider("rail", s.ground, body, axis="x", coordinate="x")
    s.add("brake", Brake(rail, x0, F))
    return s


def test_a_switch_is_located_and_named():
    """x = 2 t to the brake at t = 1/2, then a throw: back there after 2 m v/F, and away at -2 m/s."""
    motion = fb.simulate(cart(), 4, initial={"x'": 2.0}, events=["x'"])
    assert [event.name for event in motion.events] == ["brake brakes", "x'", "brake is let go"]
    times = [event.time for event in motion.events]
    assert times == pytest.approx([0.5, 0.5 + 2 * 2 / 3, 0.5 + 2 * 2 * 2 / 3], abs=1e-8)
    assert float(motion["x'"][-1]) == pytest.approx(-2, abs=1e-7)  # steps go over the jumps of the force


def test_no_name_at_a_speed_of_nothing():
    """A machine without switches has no further events."""
    s = cart()
    del s.loads["brake"]
    assert not fb.simulate(s, 1, initial={"x'": 2.0}).events


def test_switches_among_blows_and_contacts(tmp_path):
    s = cart()
    body = s.bodies["body"]
    blow = fb.blow(0.25, at=body.center, impulse=(2.0, 0, 0))  # 2 m/s, then 3 m/s
    motion = fb.simulate(s, 1, initial={"x'": 2.0}, impulses=[blow])
    (switch,) = [event for event in motion.events if event.name == "brake brakes"]
    assert switch.time == pytest.approx(0.25 + 0.5 / 3, abs=1e-9)
    motion.save(tmp_path / "run.nc")
    s.contact(
        "wall", body.point(0.1, 0, 0), s.ground.plane(at=(1.6, 0, 0), normal=(-1, 0, 0)), restitution=0.5
    )
    motion = fb.simulate(s, 2, initial={"x'": 2.0})
    assert [event.name for event in motion.events][0] == "brake brakes" and len(motion.events) >= 3
    assert motion.events[0].time == pytest.approx(0.5, abs=1e-9)
    stepped = fb.simulate(s, 1, initial={"x'": 2.0}, method="timestepping", step=1e-3)
    assert next(e for e in stepped.events if e.name == "brake brakes").time == pytest.approx(0.5, abs=2e-3)


def test_where_in_numbers_formulas_and_code():
    s = cart()
    assert "sign(" in fb.equations(s).text()
    program = fb.compile(s)
    states = np.array([[0.5], [1.5]])
    assert program.forward_dynamics(states, np.zeros((2, 1))).ravel().tolist() == [0.0, -1.5]
    linear = fb.linearize(s, about={"x": 0.5, "x'": 0}, values={})
    assert np.allclose(np.array(linear.K, float), 0)
