"""Forces of constraints: the power of the forces of a condition is its rate, per unit of the multiplier."""

import numpy as np
import pytest

import freebody as fb
from freebody.dynamics import float_state
from freebody.dynamics.conditions.constraint_forces import torques, wrenches
from freebody.dynamics.conditions.constraints import rows
from freebody.dynamics.conditions.linearized import linearized
from freebody.dynamics.kinematics import Spot, angular_velocity, carried, point_position, velocities
from freebody.model.assemble import assemble


def loop(end=None) -> fb.System:
    """Three bars in space with a rope over a point of the ground, joined by a ball to it where the end is at ``q``."""
    s = fb.System("loop")
    below, bars = s.ground, []
    for i, axis in enumerate(("z", "x", "y")):
        bar = s.body(f"bar{i}", fb.slender_bar(1, 1, axis="x"))
        s.hinge(f"h{i}", below, bar, at=(0.5, 0.1, 0) if bars else (0, 0, 0), to=(-0.5, 0, 0), axis=axis)
        bars.append(bar)
        below = bar
    s.rope([bars[0].point(0.1, 0.2, 0), s.ground.point(2, 1, 3), bars[1].point(0, 0.3, 0)], 4, name="rope")
    if end is None:
        model = assemble(s)
        state = float_state(model, coordinates(model).tolist(), [0.0] * model.n_u, 0.0)
        return loop(tuple(map(float, point_position(model, state, below.point(0.5, 0, 0)))))
    s.ball("close", below, s.ground, at=(0.5, 0, 0), to=end)
    return s


def coordinates(model):
    """Coordinates, with unit quaternions."""
    q = np.random.default_rng(2).uniform(0.1, 1, model.n_q)
    for i in model.quaternions:
        q[i : i + 4] /= np.linalg.norm(q[i : i + 4])
    return q


def wheel() -> fb.System:
    """A wheel that leans, and rolls on the ground."""
    s = fb.System("wheel")
    disk = s.body("wheel", fb.disk(1, 0.5))
    s.free("f", s.ground, disk)
    s.rolling("roll", disk, radius=0.5, axis="z")
    return s


@pytest.mark.parametrize("machine", [loop, wheel])
def test_the_power_of_forces_is_the_rate_of_their_condition(machine):
    model = assemble(machine())
    q, u = coordinates(model), np.random.default_rng(3).normal(size=model.n_u)
    state = float_state(model, q.tolist(), u.tolist(), 0.0)
    rate = np.array(linearized(model, state).matrix, dtype=float) @ u
    twists = velocities(model, state)
    for i, actions in enumerate(wrenches(model, state)):
        power = 0.0
        for place, force, moment in actions:
            body, point = place if isinstance(place, tuple) else (place.body, place)
            spot = Spot(body, point_position(model, state, point))
            power += np.dot(carried(model, state, spot, twists), force)
            power += np.dot(angular_velocity(model, state, body), moment)
        assert power == pytest.approx(rate[i], rel=1e-12, abs=1e-13), rows(model)[i].name


def test_torques_of_a_ratio_are_along_both_joints():
    s = fb.System("pair")
    one, other = (s.body(name, fb.disk(1, 0.1)) for name in "ab")
    first = s.hinge("first", s.ground, one, axis="z")
    second = s.hinge("second", s.ground, other, axis="z")
    gear = s.gear(first, second, -3)
    model = assemble(s)
    state = float_state(model, [0.0] * model.n_q, [0.0] * model.n_u, 0.0)
    assert torques(model, state, model.constraints[gear.name]) == [("first", 0, 1), ("second", 1, 3)]
