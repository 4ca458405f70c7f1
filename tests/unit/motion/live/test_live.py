"""A live motion is the motion of `simulate`, follows its parameters, tells what it cannot do, and recovers."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from freebody.motion.ending import End
from freebody.motion.live.memory import READ, Live
from freebody.motion.start.closing_record import FAR, MET
from live_machines import Here, motion_of


def difference(a: np.ndarray, b: np.ndarray) -> float:
    return float((np.abs(a - b) / (1 + np.abs(b))).max())


@pytest.mark.parametrize("name", ["double pendulum", "gyroscope"])
def test_it_is_the_motion_of_simulate_bit_for_bit(name):
    motion = motion_of(name)
    live = Here(motion)
    states = live()
    assert (live.status, live.closed, live.fault, live.frames) == (End.FINISHED, MET, -1, 101)
    assert (live.steps, live.rejected) == (motion.steps, motion.path.rejected)
    assert np.array_equal(states, motion.path.sample(live.times[:101].copy()))
    assert live.event_times[: live.events].tolist() == [event.time for event in motion.events]
    assert np.array_equal(live.outputs[:101], states[:, : motion.kernels.model.n_q])


def test_frames_of_steps_come_from_the_dense_output():
    motion = motion_of("double pendulum")
    live = Here(motion)
    live.memory.evenly, live.memory.dense, live.memory.most_frames = 0, 1, 401
    states = live()
    times = live.times[: live.frames]
    assert (
        live.frames == 401 and times[0] == 0 and times[-1] == motion.path.end and (np.diff(times) > 0).all()
    )
    # the dense output has order 6: its error is that of the steps, 1e-10, to the power 6/8
    assert difference(states, motion.path.sample(times.copy())) < 1e-10 ** (6 / 8)


def test_the_start_follows_its_parameters_until_it_is_given():
    motion = motion_of("double pendulum")
    live = Here(motion)
    assert live(theta_0=0.3)[0].tolist() == [0.3, 0.5, 0, 0]
    live.given[0], live.initial[0] = 1, 0.7
    states = live(L=2.0)
    assert states[0].tolist() == [0.7, 0.5, 0, 0]
    other = motion_of("double pendulum", initial={"q1": 0.7, "q2": 0.5}, values={"L": 2.0, "theta_0": 0.3})
    assert np.array_equal(states, other.path.sample(live.times[:101].copy()))
    assert live.answers.tolist() == [2.0, 4.0, 2 * 9.81, 0.6]


def test_the_work_has_the_tolerance_of_the_energy():
    import freebody as fb

    s = fb.System("driven")
    s.gravity = (0, -9.81, 0)
    bar = s.body("bar", fb.slender_bar(1, 2, axis="y"))
    s.hinge("pin", s.ground, bar, to=(0, 1, 0), axis="z", coordinate="theta")
    s.torque("drive", bar, (0, 0, "sin(3*t)"))
    motion = fb.simulate(s, 5, initial={"theta": 1}, method="dop853")
    live = Here(motion)
    assert np.array_equal(live(), motion.path.sample(live.times[:101].copy())) and motion.has_work


def test_closed_loops_close_anew_and_recover():
    """A crank of 1.9 m and a rocker of 0.1 m do not reach each other over 3 m with a coupler of 0.5 m."""
    motion = motion_of("four-bar")
    live = Here(motion)
    states, steps = live(), live.steps
    assert live.closed == MET and live.status == End.FINISHED
    # the start is closed from the closed start: it moves by round-off
    assert difference(states, motion.path.sample(live.times[:101].copy())) < 1e-8
    assert live(b=0.5, c=0.1).size == 0
    assert (live.closed, live.status, live.frames, live.steps) == (FAR, End.RUNNING, 0, 0)
    again = live(b=3.0, c=2.0)
    assert live.steps == steps and np.array_equal(again, states)
    longer = live(b=3.2)
    other = motion_of("four-bar", values={"b": 3.2})
    assert difference(longer, other.path.sample(live.times[:101].copy())) < 1e-8


def test_a_motion_of_too_many_steps_ends_with_what_it_has():
    motion = motion_of("double pendulum")
    live = Here(motion, most_steps=50)
    states = live()
    assert (live.status, live.steps) == (End.TOO_MANY_STEPS, 50)
    assert live.reached == motion.path.times[50] and np.array_equal(states[-1], motion.path.states[50])
    live.memory.most_steps = 20
    live()
    assert live.steps == 20


def test_values_against_an_assumption_are_told():
    motion = motion_of("double pendulum")
    live = Here(motion)
    assert live(m=-1.0).size == 0 and live.fault >= 0 and live.status == End.RUNNING
    assert str(motion.kernels.model.assumed[live.fault]) == "m"
    live(m=1.0)
    assert live.status == End.FINISHED and live.fault == -1


def test_a_terminal_event_ends_it():
    import freebody as fb

    motion = motion_of("double pendulum", events=[fb.event("q1'", terminal=True, direction=1)])
    live = Here(motion)
    live()
    assert live.status == End.TERMINAL and live.reached == motion.path.end


def test_a_motion_knows_how_it_was_asked_to_start():
    motion = motion_of("four-bar", until=0.1)
    assert motion.initial == {"q1": 1.0, "q1'": 2.0} and motion.near == {"q2": -0.7, "q3": 1.2}
    again = pickle.loads(pickle.dumps(motion))
    assert (again.initial, again.near) == (motion.initial, motion.near)


def test_all_fields_for_the_caller_are_fields_and_named_once():
    assert set(READ) <= set(Live.fields) and len(READ) == len(set(READ))
    assert all(name in (Live.__doc__ or "") for name in READ)
