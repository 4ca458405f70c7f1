"""Ctrl-C while compiled code runs: the run ends at once, whatever it does, and keeps what was computed."""

import os
import signal
import threading
import time

import numpy as np
import pytest

import freebody as fb
from freebody.motion.trajectory.progress import Halt, HaltedError, Progress

SOON = 5
"""Seconds within which a run must return, on a computer under any load; without the look it would take minutes."""


def disk(restitution=0):
    s = fb.System("disk")
    s.gravity = (0, -9.81, 0)
    body = s.body("disk", fb.disk(10, 0.3))
    s.planar("plane", s.ground, body, coordinate="x y turn")
    s.contact("floor", body.circle(0.3), s.ground.plane(), friction=0.2, restitution=restitution)
    return s


def pile(count):
    s, start = fb.System("pile"), {}
    s.gravity = (0, 0, -9.81)
    balls = [s.body(f"b{i}", fb.sphere(1, 0.05)) for i in range(count)]
    for i, ball in enumerate(balls):
        s.free(f"air{i}", s.ground, ball)
        start |= {f"air{i}_x": 0.001 * i, f"air{i}_z": 0.06 + 0.11 * i}
    s.contacts("pile", [*(ball.sphere(0.05) for ball in balls), s.ground.plane(normal="z")], friction=0.5)
    return s, start


def interrupted(run):
    """Return the result of a run that gets Ctrl-C after 0.2 s."""
    pressed = []

    def press():
        pressed.append(time.perf_counter())
        os.kill(os.getpid(), signal.SIGINT)

    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    timer = threading.Timer(0.2, press)
    timer.start()
    try:
        result = run()
        assert time.perf_counter() - pressed[0] < SOON
        return result
    finally:
        timer.join()
        signal.signal(signal.SIGINT, before)


@pytest.mark.skipif(os.name == "nt", reason="os.kill ends a process there")
def test_a_run_in_time_steps_keeps_its_steps():
    s, start = pile(3)
    options = {"initial": start, "method": "timestepping", "step": 1e-3}
    fb.simulate(s, 0.01, **options)
    motion = interrupted(lambda: fb.simulate(s, 400, **options))
    assert motion.interrupted and len(motion.path.times) > 100
    again = fb.simulate(s, 0.1, **options)
    assert np.array_equal(again.path.states, motion.path.states[:101])
    for name in ("contacts", "works", "corrections", "modes"):
        assert len(getattr(motion.course.impulses, name)) == len(motion.path.times) - 1
    assert len(motion.course.impulses.pairs) == len(motion.path.times) - 1


@pytest.mark.skipif(os.name == "nt", reason="os.kill ends a process there")
@pytest.mark.parametrize("lanes", [1, 40])
def test_a_run_by_events_ends(lanes):
    """An elastic disk bounces for ever; events and steps differ in what they cost."""
    s = disk(restitution=1)
    start = {"y": 0.5, "turn'": 1 if lanes == 1 else np.linspace(1, 2, lanes)}
    fb.simulate(s, 0.01, initial=start, outputs=None if lanes == 1 else ["y"])
    motion = interrupted(
        lambda: fb.simulate(s, 1e5, initial=start, outputs=None if lanes == 1 else ["y"], times=[0, 1])
    )
    if lanes == 1:
        assert motion.interrupted and 0 < motion.path.end < 1e5
    else:
        assert motion.attrs["interrupted"] == "40 of 40 lanes were not run"


def test_a_flag_ends_runs_of_other_threads():
    class Memory:
        stop = 0

    halt, memory, ended = Halt(), Memory(), []

    def run():
        between = Progress(0, 1, halt)
        between.halt.watch(memory)
        begun.set()
        while not memory.stop:
            time.sleep(0.001)
        try:
            between(0.5)
        except HaltedError:
            ended.append(True)

    begun = threading.Event()
    thread = threading.Thread(target=run)
    thread.start()
    begun.wait()
    halt.press()
    thread.join()
    assert ended == [True]
    halt.watch(late := Memory())
    assert late.stop == 1  # a run that begins later does not begin


def test_code_in_a_thread_gives_its_result_or_its_error():
    shown = []
    with Progress(0, 1, shown.append) as between:
        assert between.result(lambda: 0.5, lambda x: time.sleep(0.12) or x, 3) == 3
        assert set(shown) == {0.5}
        with pytest.raises(ZeroDivisionError):
            between.result(lambda: 0.5, lambda: 1 / 0)
