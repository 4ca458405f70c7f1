"""Lanes that processes run: what cannot be handed over, and processes that die."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
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


@pytest.mark.parametrize("store", [False, True])
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
        "a process of the pool ended abruptly" in x and "BrokenProcessPool" in x
        for x in data.reason.values[~done]
    )
    assert data.attrs["interrupted"].startswith(
        f"{(~done).sum()} of 12 lanes were not run; {(~done).sum()} were lost"
    )
    data.close()
    if store:  # the same call goes on with the others, here in a process that does not die
        with h5py.File(tmp_path / "x.nc", "r") as file:
            assert ((file["status"][:] >= 0) == done).all()
        again = fb.simulate(s, 1, **STARTS, **kept)
        assert np.array_equal(again["x"], whole["x"]) and set(again.status.values) == {"finished"}


def test_machines_in_one_loop_tell_it_too() -> None:
    class Half(Executor):
        """Runs every other block."""

        calls = 0

        def submit(self, function, /, *arguments, **options):
            task: Future = Future()
            self.calls += 1
            if self.calls % 2:
                task.set_result(function(*arguments, **options))
            else:
                task.set_exception(MemoryError("no room"))
            return task

    start = {"theta": [0.1, 0.2, 0.3, 0.4]}
    data = fb.simulate(pendulum(), 1, initial=start, samples=2, executor=Half(), progress=False)
    assert list(data.status.values) == ["finished", "waiting"] * 2
    assert list(data.reason.values) == ["", "not finished: MemoryError: no room"] * 2
    grid = fb.sweep(
        pendulum(), {"theta": [0.1, 0.2], "m": [1, 2]}, 1, samples=2, executor=Half(), progress=False
    )
    assert grid.reason.dims == ("theta_start", "m") and list(grid.reason.values[:, 0]) == ["", ""]
    with pytest.raises(SimulationError, match="Expected another name for the output 'reason'"):
        fb.simulate(pendulum(), 1, initial=start, outputs={"reason": "theta"})


def test_an_executor_that_takes_no_more_leaves_what_it_has_done() -> None:
    class Tired(Executor):
        """Runs one block, leaves another, and takes no third."""

        _max_workers = 1
        calls = 0

        def submit(self, function, /, *arguments, **options):
            task: Future = Future()
            self.calls += 1
            if self.calls == 3:
                raise RuntimeError("cannot schedule new futures after shutdown")
            if self.calls == 1:
                task.set_result(function(*arguments, **options))
            else:
                task.set_exception(SystemExit(1))
            return task

    start = {"theta": np.linspace(0.1, 1, 9)}
    data = fb.simulate(pendulum(), 1, initial=start, samples=2, executor=Tired(), progress=False)
    assert list(data.status.values) == ["finished"] + 8 * ["waiting"]
    assert list(data.reason.values[:2]) == ["", "not finished: SystemExit: 1"]
    assert set(data.reason.values[2:]) == {
        "not begun: RuntimeError: cannot schedule new futures after shutdown"
    }


def test_where_no_lane_was_run_it_is_an_error() -> None:
    options = {"initial": {"x": [0.6, 0.7]}, "samples": 2, "progress": False}
    with (
        ProcessPoolExecutor(1) as pool,
        pytest.raises(
            SimulationError,
            match="No lane was run; the first was not finished: a process of the pool ended abruptly",
        ) as error,
    ):
        fb.simulate(cart(Mortal(), "law"), 1, executor=pool, **options)
    assert type(error.value.__cause__).__name__ == "BrokenProcessPool"


def closed(gain: float) -> Any:
    return lambda t, x: -gain * x["x"]


def test_a_law_that_no_other_process_finds_is_refused_before_anything_starts(tmp_path) -> None:
    path = tmp_path / "x.nc"

    def local(t: float, x: Any) -> float:
        return -x["x"]

    for law in (closed(2.0), local):
        with ProcessPoolExecutor(1) as pool:
            with pytest.raises(
                SimulationError,
                match=r"controller that other processes find by its name, .* 'pull' is <function .*: AttributeError: .*"
                r"Define it with def at the top level of a module .* leave out executor=, or pass a .*Thread",
            ):
                fb.simulate(cart(law, "pull"), 1, executor=pool, store=path, **STARTS)
            assert not path.exists() and not pool._processes
        with ThreadPoolExecutor(2) as pool:
            there = fb.simulate(cart(law, "pull"), 1, executor=pool, **STARTS)
        assert there.equals(fb.simulate(cart(law, "pull"), 1, **STARTS))
    with ProcessPoolExecutor(1) as pool:
        few = fb.simulate(cart(pull), 1, executor=pool, **STARTS)
    assert np.array_equal(few["x"], fb.simulate(cart(pull), 1, **STARTS)["x"])


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
        [sys.executable, "-c", PRESSED, str(tmp_path / "x.nc")], capture_output=True, text=True, timeout=120,
        env=environment, start_new_session=True,
    )  # fmt: skip
    assert found.stdout, found.stderr
    finished, waiting = map(int, found.stdout.split())
    assert finished >= 1 and finished + waiting == 300
    with h5py.File(tmp_path / "x.nc", "r") as file:
        assert (file["status"][:] >= 0).sum() == finished


def test_a_block_that_hears_ctrl_c_gives_back_the_lanes_that_are_done(monkeypatch) -> None:
    run = alone.Alone.lane

    def pressed(self: Any, lane: int) -> None:
        if lane == 2:
            raise KeyboardInterrupt
        run(self, lane)

    class Here(Executor):
        """One block of all lanes."""

        def submit(self, function, /, *arguments, **options):
            task: Future = Future()
            task.set_result(function(*arguments, **options))
            return task

    monkeypatch.setattr(alone.Alone, "lane", pressed)
    monkeypatch.setattr(pool, "_BLOCKS", 1)
    data = fb.simulate(cart(pull), 1, executor=Here(), **STARTS)
    assert list(data.status.values) == 2 * ["finished"] + 10 * ["waiting"]
    assert data.attrs["interrupted"] == "10 of 12 lanes were not run" and set(data.reason.values) == {""}
