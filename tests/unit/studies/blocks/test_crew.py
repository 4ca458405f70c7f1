"""Lanes that processes run: what cannot be handed over, and processes that die."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from typing import Any

import h5py
import numpy as np
import pytest

import freebody as fb
from batch_machines import pendulum
from freebody.errors import SimulationError
from freebody.motion.batch import alone
from freebody.studies.blocks import run


def cart(law: Any, name: str | None = None) -> fb.System:
    s = fb.System("cart")
    s.parameters(push=0.0)
    rail = s.slider("rail", s.ground, s.body("cart", fb.particle(2)), axis="x", coordinate="x")
    s.force("motor", rail, "push")
    s.controller(law, 0.1, "push", name=name)
    return s


def pull(t: float, x: Any) -> float:
    return -4 * x["x"]


class Mortal:
    """A law that ends its process where a cart starts beyond 0.5 m, once others had time to end."""

    def __init__(self) -> None:
        self.home = os.getpid()

    def __call__(self, t: float, x: Any) -> float:
        if t == 0 and x["x"] > 0.5 and os.getpid() != self.home:
            time.sleep(1.0)
            os.kill(os.getpid(), signal.SIGKILL)
        return -4 * x["x"]


STARTS = {"initial": {"x": np.append(np.linspace(0.1, 0.4, 11), 0.6)}, "samples": 3, "progress": False}


@pytest.mark.parametrize("store", [pytest.param(False, marks=pytest.mark.slow), True])
def test_a_process_that_dies_costs_its_lanes_only(tmp_path, store: bool) -> None:
    s, kept = cart(Mortal(), "law"), {"store": tmp_path / "x.nc"} if store else {}
    with ProcessPoolExecutor(2) as pool:
        data = fb.simulate(s, 1, executor=pool, **STARTS, **kept)
    done = (data.status == "finished").values
    assert (data.reason.values[~done] != "").all()
    assert done[:-1].all() and data.status.values[-1] == "lost"
    whole = fb.simulate(cart(pull), 1, **STARTS)
    assert np.array_equal(data["x"].values[done], whole["x"].values[done])
    assert np.isnan(data["x"].values[~done]).all()
    assert (data.reason.values[done] == "").all()
    assert all(
        "its process ended abruptly" in x and "BrokenProcessPool" in x for x in data.reason.values[~done]
    )
    assert data.attrs["lost"].startswith("1 of 12 lanes, the first 11: its process ended abruptly")
    data.close()
    if store:  # the same call goes on with the others, here in a process that does not die
        with h5py.File(tmp_path / "x.nc", "r") as file:
            assert ((file["status"][:] >= 0) == done).all()
        again = fb.simulate(s, 1, **STARTS, **kept)
        assert np.array_equal(again["x"], whole["x"]) and set(again.status.values) == {"finished"}


def test_a_block_that_breaks_is_halved_until_the_lane_is_alone() -> None:
    class Small(Executor):
        """Has no room for lane 2."""

        def submit(self, function, /, *arguments, **options):
            task: Future = Future()
            low, high = arguments[:2]
            if low <= 2 < high:
                task.set_exception(MemoryError("no room"))
            else:
                task.set_result(function(*arguments, **options))
            return task

    start = {"theta": [0.1, 0.2, 0.3, 0.4]}
    data = fb.simulate(pendulum(), 1, initial=start, samples=2, executor=Small(), progress=False)
    assert list(data.status.values) == ["finished", "finished", "lost", "finished"]
    assert list(data.reason.values) == ["", "", "MemoryError: no room", ""]
    assert data.attrs["lost"] == "1 of 4 lanes, the first 2: MemoryError: no room"
    grid = fb.sweep(
        pendulum(), {"theta": [0.1, 0.2], "m": [1, 2]}, 1, samples=2, executor=Small(), progress=False
    )
    assert grid.reason.dims == ("theta_start", "m") and grid.reason.values[1, 0] == "MemoryError: no room"
    with pytest.raises(SimulationError, match="Expected another name for the output 'reason'"):
        fb.simulate(pendulum(), 1, initial=start, outputs={"reason": "theta"})


def test_an_executor_that_takes_no_more_leaves_what_it_has_done() -> None:
    class Tired(Executor):
        """Runs one block, and takes no second."""

        calls = 0

        def submit(self, function, /, *arguments, **options):
            task: Future = Future()
            self.calls += 1
            if self.calls == 2:
                raise RuntimeError("cannot schedule new futures after shutdown")
            task.set_result(function(*arguments, **options))
            return task

    start = {"theta": np.linspace(0.1, 1, 9)}
    data = fb.simulate(pendulum(), 1, initial=start, samples=2, executor=Tired(), progress=False)
    assert list(data.status.values) == ["finished"] + 8 * ["waiting"]
    why = "not begun: RuntimeError: cannot schedule new futures after shutdown"
    assert data.attrs["interrupted"] == f"8 of 9 lanes were not run; {why}"


@pytest.mark.slow
def test_where_no_lane_was_run_it_is_an_error() -> None:
    options = {"initial": {"x": [0.6, 0.7]}, "samples": 2, "progress": False}
    with (
        ProcessPoolExecutor(1) as pool,
        pytest.raises(
            SimulationError, match="No lane of 2 was run; the first was its process ended abruptly"
        ),
    ):
        fb.simulate(cart(Mortal(), "law"), 1, executor=pool, **options)


def closed(gain: float) -> Any:
    return lambda t, x: -gain * x["x"]


def test_a_law_of_this_process_only_goes_along_by_value() -> None:
    def local(t: float, x: Any) -> float:
        return -x["x"]

    for law in (closed(2.0), local):
        here = fb.simulate(cart(law, "pull"), 1, **STARTS)
        for pool in (ProcessPoolExecutor(1), ThreadPoolExecutor(2)):
            with pool:
                assert fb.simulate(cart(law, "pull"), 1, executor=pool, **STARTS).equals(here)


def test_a_law_that_cannot_be_sent_is_refused_before_anything_starts() -> None:
    lock = threading.Lock()

    def guarded(t: float, x: Any) -> float:
        with lock:
            return -x["x"]

    with ProcessPoolExecutor(1) as pool:
        with pytest.raises(
            SimulationError,
            match=r"controller that can be sent to other processes, but 'pull' is <function .*: TypeError: .*lock.*"
            r"Open or make what it holds within the function, .* leave out executor=",
        ):
            fb.simulate(cart(guarded, "pull"), 1, executor=pool, **STARTS)
        assert not pool._processes
    with ThreadPoolExecutor(2) as pool:
        there = fb.simulate(cart(guarded, "pull"), 1, executor=pool, **STARTS)
    assert there.equals(fb.simulate(cart(guarded, "pull"), 1, **STARTS))


PRESSED = """
import os, signal, sys, time
from concurrent.futures import ProcessPoolExecutor
import numpy as np, freebody as fb
from freebody.gallery.beyond.bouncing_ball import build

if __name__ == "__main__":
    with ProcessPoolExecutor(2) as pool:
        list(pool.map(abs, range(8)))
        seen = []
        def told(part):
            seen.append(part)
            if len(seen) == 1:
                os.killpg(0, signal.SIGINT)  # as a terminal does
        data = fb.simulate(
            build(), 3, initial={"y": "h"}, values={"h": np.linspace(1, 2, 300)}, samples=2, progress=told,
            executor=pool, store=sys.argv[1],
        )
    print((data.status == "finished").sum().item(), (data.status == "waiting").sum().item())
"""


def test_ctrl_c_of_a_terminal_keeps_lanes_of_blocks_that_are_run(tmp_path) -> None:
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    found = subprocess.run(
        [sys.executable, "-c", PRESSED, str(tmp_path / "x.nc")], capture_output=True, text=True, timeout=600,
        env=environment, start_new_session=True,
    )  # fmt: skip
    assert found.stdout, found.stderr
    finished, waiting = map(int, found.stdout.split())
    assert finished >= 1 and finished + waiting == 300
    with h5py.File(tmp_path / "x.nc", "r") as file:
        assert (file["status"][:] >= 0).sum() == finished


def test_a_block_that_hears_ctrl_c_gives_back_the_lanes_that_are_done(monkeypatch) -> None:
    lane_of = alone.Alone.lane

    def pressed(self: Any, lane: int) -> None:
        if lane == 2:
            raise KeyboardInterrupt
        lane_of(self, lane)

    class Here(Executor):
        """One block of all lanes."""

        def submit(self, function, /, *arguments, **options):
            task: Future = Future()
            task.set_result(function(*arguments, **options))
            return task

    monkeypatch.setattr(alone.Alone, "lane", pressed)
    monkeypatch.setattr(run, "growing", lambda ranges, *more: iter(ranges))
    data = fb.simulate(cart(pull), 1, executor=Here(), **STARTS)
    assert list(data.status.values) == 2 * ["finished"] + 10 * ["waiting"]
    assert data.attrs["interrupted"] == "10 of 12 lanes were not run" and set(data.reason.values) == {""}
