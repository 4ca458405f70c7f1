"""Studies on a dask cluster whose processes are killed at random moments: nothing that was kept is lost or changes."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import psutil
import pytest
import scipy.stats

import freebody as fb
from batch_machines import pendulum
from freebody.studies.stores.states import starts_of

pytest.importorskip("distributed")

CLUSTER = """
import time
from distributed import LocalCluster
if __name__ == "__main__":
    cluster = LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None)
    print(cluster.scheduler_address, flush=True)
    time.sleep(3600)
"""
CLIENT = """
import sys
from freebody.studies.blocks import cutting
from test_killed import reducers, swings
if __name__ == "__main__":
    address, path, kind = sys.argv[1:]
    cutting.SECONDS = 0.2
    if kind == "run":
        data = swings().run(address, store=path, progress=False)
    else:
        data = swings().reduce(reducers(), address, store=path, progress=False)
    print("interrupted" in data.attrs or "lost" in data.attrs, data.attrs.get("lanes"))
"""
LANES = 200_000


def swings() -> fb.Study:
    lanes = fb.sample({"theta": scipy.stats.uniform(0.1, 2), "m": (1, 2)}, n=LANES, by="random", seed=1)
    return fb.study(pendulum(), until=10, lanes=lanes, outputs="max(theta')")


def reducers() -> dict[str, Any]:
    return {
        "p": fb.mean("max(theta') > 3"),
        "tail": fb.quantile("max(theta')", [0.5, 0.9]),
        "worst": fb.largest("max(theta')", 3),
    }


class Killer:
    """A cluster, a client, and who kills them; what is dead is started again."""

    def __init__(self, folder: Path, seed: int) -> None:
        self.folder, self.random = folder, random.Random(seed)
        self.environment = {
            **os.environ,
            "PYTHONPATH": os.pathsep.join([*sys.path, os.path.dirname(__file__)]),
        }
        self.whole = swings().run(progress=False)["max(theta')"].values
        self.answer = swings().reduce(reducers(), progress=False)
        self.kills: dict[str, int] = {"worker": 0, "client": 0, "scheduler": 0}
        self.studies = 0
        self.cluster: Any = None
        self.client: Any = None
        self.next()

    def next(self) -> None:
        """Begin a study."""
        self.kind = ("run", "reduce")[self.studies % 2]
        self.studies += 1
        self.path = self.folder / f"{self.studies}.zarr"
        self.kept: set[Any] = set()

    def process(self, script: str, *arguments: str) -> Any:
        return subprocess.Popen(
            [sys.executable, "-c", script, *arguments], env=self.environment, text=True, stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL, start_new_session=True,
        )  # fmt: skip

    def start(self) -> None:
        """Start what does not run."""
        if self.cluster is None or self.cluster.poll() is not None:
            self.cluster = self.process(CLUSTER)
            self.address = self.cluster.stdout.readline().strip()
        if self.client is not None and self.client.poll() is not None:
            if self.client.returncode == 0 and self.client.stdout.read().startswith("False"):
                self.check_all()
                self.next()
            self.client = None
        if self.client is None:
            self.client = self.process(CLIENT, self.address, str(self.path), self.kind)

    def kill(self) -> None:
        """Kill a process at a random moment."""
        who = self.random.choice(list(self.kills))
        due = time.monotonic() + self.random.uniform(0.2, 6.0)
        while time.monotonic() < due and self.client.poll() is None:
            time.sleep(0.05)
        self.note()
        if who == "client":
            self.client.kill()
            self.client.wait()
        elif who == "scheduler":
            self.cluster.kill()
            self.cluster.wait()
            self.client.wait(timeout=60)  # ten seconds for the scheduler to come back, then it ends
        else:
            children = psutil.Process(self.cluster.pid).children(recursive=True)
            workers = [x for x in children if "spawn_main" in " ".join(x.cmdline())]
            if not workers:
                return
            os.kill(self.random.choice(workers).pid, signal.SIGKILL)
        self.kills[who] += 1
        self.check()

    def finished(self) -> set[Any]:
        """Return the lanes, or the first lanes of the blocks, that are kept."""
        if not self.path.exists():
            return set()
        if self.kind == "reduce":
            return set(starts_of(self.path))
        return set(np.flatnonzero(fb.open_study(self.path).data.status.values >= 0).tolist())

    def note(self) -> None:
        self.kept |= self.finished()

    def check(self) -> None:
        """Nothing that was kept is lost, and each number is that of a run that nobody killed."""
        finished = self.finished()
        assert self.kept <= finished
        if self.kind == "run" and finished:
            rows = np.array(sorted(finished))
            assert np.array_equal(fb.open_study(self.path).data["max(theta')"].values[rows], self.whole[rows])

    def check_all(self) -> None:
        self.note()
        self.check()
        stored = fb.open_study(self.path)
        assert not stored.missing
        if self.kind == "run":
            assert set(stored.ended) == {"finished"}
        else:
            assert stored.resume(progress=False).identical(self.answer)

    def end(self) -> None:
        """Let the last study end, and stop everything."""
        try:
            last, due = self.studies, time.monotonic() + 600
            while self.studies == last and time.monotonic() < due:
                self.start()
                time.sleep(0.2)
            assert self.studies > last
        finally:
            self.stop()

    def stop(self) -> None:
        for process in (self.client, self.cluster):
            if process is not None:
                process.kill()
                process.wait()
                process.stdout.close()


def killed(folder: Path, count: int, seed: int) -> Killer:
    """Kill so many processes."""
    killer = Killer(folder, seed)
    try:
        while sum(killer.kills.values()) < count:
            killer.start()
            killer.kill()
        killer.start()
    except BaseException:
        killer.stop()
        raise
    killer.end()
    return killer


@pytest.mark.slow  # of a process of a crew: `blocks.test_crew`
def test_a_few_kills_lose_no_block_and_change_no_bit(tmp_path) -> None:
    assert sum(killed(tmp_path, 1, 2).kills.values()) == 1


@pytest.mark.slow
def test_thirty_kills_lose_no_block_and_change_no_bit(tmp_path) -> None:
    killer = killed(tmp_path, 30, 1)
    print(killer.kills, killer.studies)
    assert min(killer.kills.values()) > 4
