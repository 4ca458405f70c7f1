"""Events in time steps: those of motions by events, with the same names and directions, up to a step or two."""

import numpy as np
import pytest

import freebody as fb

STEP = 1e-3
STEPS = {"method": "timestepping", "step": STEP}
QUANTITIES = ("gap", "approach", "normal", "tangential", "slip", "margin")


def block(lift, friction=0.5, static=None):
    s = fb.System("block")
    s.gravity = (0, -10, 0)
    body = s.body("block", fb.particle(1))
    s.chain("plane", s.ground, body, [fb.Slider("x", "x"), fb.Slider("y", "y")])
    s.contact("floor", body.origin, s.ground.plane(), friction=friction, static_friction=static)
    s.force("F", body.origin, (0, lift, 0))
    return s


def names(motion, events):
    known = {event.name for event in events}
    return sorted((one.name, one.direction, one.time) for one in motion.events if one.name in known)


@pytest.mark.parametrize("seed", range(4))
def test_events_of_contacts_are_those_of_motions_by_events(seed):
    """A block falls or lies, slips to rest, and is lifted off; every quantity passes zero, or a level, or neither."""
    rng = np.random.default_rng(seed)
    s = block(f"{rng.uniform(15, 25)}*t", rng.uniform(0.2, 0.5), 0.6 if seed % 2 else None)
    start = {"x'": rng.uniform(0.5, 1), "y": rng.uniform(0.02, 0.1) if seed > 1 else 0}
    levels = [f"floor.{what} - {level}" for what, level in (("gap", 0.01), ("normal", 4), ("slip", 0.3))]
    events = [fb.event(x) for x in (*(f"floor.{what}" for what in QUANTITIES), *levels, "x - 0.05")]
    by_events = names(fb.simulate(s, 1, initial=start, events=events), events)
    in_steps = names(fb.simulate(s, 1, initial=start, events=events, **STEPS), events)
    assert [one[:2] for one in in_steps] == [one[:2] for one in by_events] and len(by_events) > 6
    off = [abs(one[2] - other[2]) for one, other in zip(in_steps, by_events, strict=True)]
    assert max(off) < 3 * STEP  # a step for the time of the event, and one for the mean of a force


def test_the_gap_of_a_bounce_and_the_force_of_a_landing():
    """A gap that bounces reaches zero once, in the step of the impact; its force begins and ends with that step."""
    s = fb.System("ball")
    s.gravity = (0, -10, 0)
    ball = s.body("ball", fb.particle(1))
    s.slider("rail", s.ground, ball, axis="y", coordinate="y")
    s.contact("floor", ball.origin, s.ground.plane(), restitution=0.5)
    motion = fb.simulate(s, 0.7, initial={"y": 0.81}, events=["floor.gap", "floor.normal"], **STEPS)
    gap, rise, fall = (
        next(x for x in motion.events if (x.name, x.direction) == one)
        for one in (("floor.gap", -1), ("floor.normal", 1), ("floor.normal", -1))
    )
    assert len([x for x in motion.events if x.name in ("floor.gap", "floor.normal")]) == 3
    assert rise.time == pytest.approx(np.sqrt(0.162), abs=STEP)
    assert gap.time == pytest.approx(rise.time + STEP)
    assert fall.time == pytest.approx(rise.time + 2 * STEP)


def test_a_terminal_event_of_a_force_keeps_the_motion_up_to_it():
    s = block("20*t")
    event = fb.event("floor.normal - 4", terminal=True)
    motion = fb.simulate(s, 1, events=[event], **STEPS)
    assert motion.status == "terminal event" and motion.path.end == pytest.approx(0.3, abs=STEP)
    whole = fb.simulate(s, 1, **STEPS)
    np.testing.assert_array_equal(motion.path.states[:-1], whole.path.states[: len(motion.path.states) - 1])
    assert motion.contacts["floor"].normal[-1] == pytest.approx(4, abs=20 * STEP)


def test_blocks_of_steps_make_no_difference():
    """A terminal event that is looked for every hundred steps is the first of a run that goes on."""
    s, start = block("-2*sin(40*t)", 0.3), {"x'": 2.0}
    for text in ("floor.normal - 11.9", "floor.tangential + 2.6", "floor.slip - 0.7"):
        free = fb.simulate(s, 0.6, initial=start, events=[fb.event(text)], **STEPS)
        cut = fb.simulate(s, 0.6, initial=start, events=[fb.event(text, terminal=True)], **STEPS)
        first = next(x for x in free.events if x.name == text)
        assert (cut.events[-1].time, cut.events[-1].direction) == (first.time, first.direction)


def test_pairs_of_a_family():
    """A ball of a pile that falls on another one, in either order of their names; faces of solids have a gap."""
    s = fb.System("pile")
    s.gravity = (0, 0, -10)
    low, high = (s.body(name, fb.sphere(1, 0.1)) for name in ("low", "high"))
    for body in (low, high):
        s.free(f"f_{body.name}", s.ground, body)
    box = s.body("box", fb.box(1, (0.2, 0.2, 0.2)))
    s.free("f_box", s.ground, box)
    s.contacts(
        "pile", [low.sphere(0.1), high.sphere(0.1), s.ground.plane(normal="z"), box.box((0.2, 0.2, 0.2))]
    )
    start = {"f_low_z": 0.1, "f_high_z": 0.35, "f_box_z": 0.15, "f_box_x": 1}
    events = [fb.event(f"pile[{a},{b}].gap - 0.01", name=a) for a, b in (("low", "high"), ("high", "low"))]
    events += [
        fb.event("pile[box,ground].gap", name="box"),
        fb.event("pile[box,ground].normal - 9", name="load"),
    ]
    motion = fb.simulate(s, 0.3, initial=start, events=events, **STEPS)
    (first, other, landed, load) = (
        [x.time for x in motion.events if x.name == name] for name in ("low", "high", "box", "load")
    )
    assert first[0] == pytest.approx(np.sqrt(2 * 0.04 / 10), abs=STEP) and first == other
    assert landed[0] == pytest.approx(0.1, abs=2 * STEP) and load[0] == pytest.approx(0.1, abs=2 * STEP)


def test_the_end_of_a_side_is_far():
    """A point beyond the end of a side has no distance from it, and passes no level of its gap there."""
    s = fb.System("ledge")
    s.gravity = (0, -10, 0)
    body = s.body("b", fb.particle(1))
    s.chain("plane", s.ground, body, [fb.Slider("x", "x"), fb.Slider("y", "y")])
    s.contact("side", body.origin, s.ground.segment((-1, 0, 0), (0, 0, 0), normal="y"))
    start = {"x": -0.5, "y": 0.4, "x'": 2.0, "y'": 1.0}
    motion = fb.simulate(s, 0.8, initial=start, events=[fb.event("side.gap - 10")], **STEPS)
    assert [(x.name, x.direction) for x in motion.events] == [("side.gap - 10", 1)]
    assert motion.events[0].time == pytest.approx(0.25, abs=2 * STEP)


def test_what_starts_at_zero_rises_and_ends_no_run():
    s = block("20*t")
    for terminal in (False, True):
        motion = fb.simulate(s, 0.1, initial={"x'": 1}, events=[fb.event("x", terminal=terminal)], **STEPS)
        assert [(x.name, x.time, x.direction) for x in motion.events] == [("x", 0.0, 1)]
        assert motion.status == "finished"


def test_zero_for_a_moment_is_passed_and_zero_for_longer_is_left():
    """x passes 0 at the end of a step; a force that begins later than at the start has left zero."""
    s = block("20*t", friction=0)
    motion = fb.simulate(
        s, 0.4, initial={"x": -0.25, "x'": 1}, events=["x"], method="timestepping", step=2**-6
    )
    assert [(x.time, x.direction) for x in motion.events if x.name == "x"] == [(0.25, 1)]
    for terminal in (False, True):
        event = fb.event("floor.normal", direction=1, terminal=terminal)
        motion = fb.simulate(block("-t"), 0.3, initial={"y": 0.2}, events=[event], **STEPS)
        (landing,) = (x.time for x in motion.events if x.name == "floor.normal")
        assert landing == pytest.approx(0.2, abs=2 * STEP) and (motion.status == "finished") != terminal


def test_a_run_without_a_step():
    motion = fb.simulate(block("0"), 0, events=[fb.event("floor.normal - 1", terminal=True)], **STEPS)
    assert motion.status == "finished" and len(motion.events) == 0


def test_a_number_is_expected():
    with pytest.raises(fb.errors.SimulationError, match="Expected a number for event '1/floor.slip' at t = "):
        fb.simulate(block("0"), 1, initial={"x'": 1}, events=["1/floor.slip"], **STEPS)
