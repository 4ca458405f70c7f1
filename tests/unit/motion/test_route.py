"""A request is checked once, does not change, and finds its way."""

from __future__ import annotations

import inspect
import pickle
from dataclasses import FrozenInstanceError, fields, replace

import pytest

import freebody as fb
from freebody.errors import SimulationError
from freebody.motion.request import Request, problem_of
from freebody.motion.route import route
from motions import pendulum

KICK = [fb.blow(0.5, impulse=(1, 0, 0))]


def signalled():
    s = pendulum()
    s.torque("motor", s.bodies["bar"], (0, 0, 2 * fb.signal([0, 1], [0.0, 2.0])))
    return s


def touching():
    s = fb.System("ball")
    body = s.body("disk", fb.disk(1, 0.1))
    s.planar("plane", s.ground, body, coordinate="x y phi")
    s.contact("floor", body.circle(0.1), s.ground.plane())
    return s


WAYS = {
    "one leg": (pendulum, {}, "motion_in_one_leg"),
    "blow": (pendulum, {"impulses": KICK}, "motion_in_legs"),
    "signal": (signalled, {}, "motion_in_legs"),
    "contacts": (touching, {}, "touching_motion"),
    "steps": (touching, {"method": "timestepping", "step": 0.01}, "stepped_motion"),
    "sensitivities": (pendulum, {"sensitivities": ["m"]}, "sensitive_motion"),
    "batch": (pendulum, {"values": {"m": [1.0, 2.0]}}, "batch"),
    "one in a batch": (pendulum, {"outputs": "theta"}, "batch"),
    "cluster": (touching, {"executor": "processes"}, "batch"),
}


@pytest.mark.parametrize("name", WAYS)
def test_every_request_finds_its_way(name):
    machine, options, way = WAYS[name]
    request = Request(machine(), 1, **options)
    assert route(request).__name__ == way
    again = pickle.loads(pickle.dumps(replace(request, executor=None) if name == "cluster" else request))
    assert again.method == request.method and again.step == request.step
    assert again.many == (request.many and name != "cluster")


def test_arguments_stand_in_the_signature_and_in_the_request():
    """With the same names in the same order, and the same defaults; the machine is called ``s`` by users."""
    signature = inspect.signature(fb.simulate).parameters.values()
    arguments = [(x.name, x.default) for x in signature if x.default is not x.empty]
    own = [(x.name, x.default) for x in fields(Request) if x.init]
    assert [name for name, _ in own[:2]] == ["machine", "until"] and dict(own[2:]) == dict(arguments)


def test_a_request_does_not_change_and_a_changed_one_is_checked():
    request = Request(pendulum(), 1)
    with pytest.raises(FrozenInstanceError):
        request.until = 2
    with pytest.raises(SimulationError, match="Unknown method 'euler'"):
        replace(request, method="euler")
    lane = replace(request, initial={"theta": 0.5}, values={"m": 3})
    assert lane.kernels is request.kernels
    assert problem_of(lane).state.tolist() == [0.5, 0.0] and problem_of(request).state.tolist() == [0.0, 0.0]
    assert problem_of(lane).numbers["m"] == 3.0 and problem_of(request).numbers["m"] == 1.0
