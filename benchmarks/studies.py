"""What the engine of studies costs beside the lanes: blocks, cluster, store, preparation, memory of a reduction.

The peer is the study itself: the same lanes in one call, by threads, without store. Times are processor times of all
processes that take part, since the machine may be shared.

    python -m benchmarks studies
    python -m benchmarks.studies 100000000     reduces so many pendulums
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np

import freebody as fb
from freebody.studies.blocks import cutting
from freebody.studies.blocks.block import Whole, run_block
from freebody.studies.blocks.executors import sent
from freebody.studies.blocks.run import run
from freebody.studies.stores.memory import Flagged

from .tables import module, show, time_text

LANES = 10_000_000
SHORT = 8  # lanes of a block whose own time is small


def pendulum() -> fb.System:
    """A bar on a pin."""
    s = fb.System("pendulum")
    m, d, g = s.parameters(m=2.0, d=0.3, g=9.81)
    s.gravity = (0, -g, 0)
    bar = s.body("bar", fb.slender_bar(m, 2 * d, axis="y"))
    s.hinge("pin", s.ground, bar, to=(0, d, 0), axis="z", coordinate="theta")
    return s


def study(lanes: int, until: float = 10.0) -> fb.Study:
    """Pendulums, each with its own start and mass."""
    law = fb.sample({"theta": (0.1, 2.0), "m": (1, 2)}, n=lanes, by="random", seed=1)
    return fb.study(pendulum(), until=until, lanes=law, outputs="max(theta')")


def processor(call: Callable[[], Any], repeats: int = 3) -> float:
    """Least processor time of a call [s]."""
    times = []
    for _ in range(max(1, repeats)):
        begin = time.process_time()
        call()
        times.append(time.process_time() - begin)
    return min(times)


def in_blocks(of: fb.Study, executor: Any, size: int) -> None:
    """Run a study in blocks of some lanes."""
    job = of.ready.job

    def sink_of(size: int) -> Flagged:
        return Flagged(job, job.room(0, of.count), lambda: of._with_all_lanes(job))

    run(
        of.ready, of._source, executor, sink_of, size=size, pack=lambda: sent(of._work, of.machine),
        progress=False,
    )  # fmt: skip


def block(repeats: int) -> float:
    """Fixed cost of a block: the time of one lane by itself, less that of a lane among many [s]."""
    some = study(100_000)
    work = sent(some._work, some.machine)

    def blocks(lanes: int, count: int) -> None:
        for k in range(count):
            run_block(k * lanes, (k + 1) * lanes, Whole(), None, "benchmark", work)

    blocks(1, 1)
    one = processor(lambda: blocks(1, 200), repeats) / 200
    many = processor(lambda: blocks(4096, 4), repeats) / (4 * 4096)
    return one - many


@contextmanager
def cluster() -> Iterator[Any]:
    """Context with a client of two workers."""
    from distributed import Client, LocalCluster

    options = {"n_workers": 2, "threads_per_worker": 1, "processes": True, "dashboard_address": None}
    with LocalCluster(**options) as local, Client(local) as client:  # type: ignore[no-untyped-call]
        yield client


def everywhere(client: Any) -> float:
    """Processor time of client, scheduler and workers so far [s]."""
    return time.process_time() + float(sum(client.run(time.process_time).values()))


def dask_block(client: Any, blocks: int, repeats: int) -> float:
    """Cost of a block of a cluster beside its lanes, in client, scheduler and workers [s]."""
    some = study(blocks * SHORT)
    lanes = processor(lambda: in_blocks(some, None, some.count), repeats)
    times = []
    for _ in range(max(2, repeats)):
        begin = everywhere(client)
        in_blocks(some, client, SHORT)
        times.append(everywhere(client) - begin)
    return (min(times) - lanes) / blocks


def dask_efficiency(client: Any, blocks: int, repeats: int) -> tuple[float, float]:
    """Processor time, and elapsed time, of threads over those of two workers, for blocks of a second."""
    some = study(1 << 16)
    in_blocks(some, None, some.count)
    lane = processor(lambda: in_blocks(some, None, some.count), 1) / some.count
    size = int(1 / lane)
    some = study(blocks * size)
    here, there = [], []
    for _ in range(max(1, min(3, repeats))):
        clock, begin = time.perf_counter(), time.process_time()
        with ThreadPoolExecutor(2) as threads:
            in_blocks(some, threads, size)
        here.append((time.process_time() - begin, time.perf_counter() - clock))
        clock, begin = time.perf_counter(), everywhere(client)
        in_blocks(some, client, size)
        there.append((everywhere(client) - begin, time.perf_counter() - clock))
    (a, b), (c, d) = (np.min(x, axis=0).tolist() for x in (here, there))
    return a / c, b / d


def store(lanes: int, repeats: int) -> float:
    """Processor time that a store adds, as a share of the run."""
    some = study(lanes)
    some.run(progress=False, threads=1)
    without, kept = [], []
    for _ in range(max(2, repeats)):
        without.append(processor(lambda: some.run(progress=False, threads=1), 1))
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "x.zarr")
            kept.append(processor(lambda path=path: some.run(store=path, progress=False, threads=1), 1))
    return min(kept) / min(without) - 1


def size() -> float:
    """Bytes a run beyond outputs and coordinates."""
    some = study(10_000)
    data = some.run(progress=False)
    return sum(x.nbytes for name, x in data.data_vars.items() if name != "max(theta')") / some.count


class Begun(Exception):
    """The first lanes have run."""


def begun(part: float) -> None:
    """Stop at the first word of progress."""
    raise Begun


def preparation(lanes: int, repeats: int) -> tuple[float, float]:
    """Time of a study, and of arrays in `simulate`, until the first lanes have run [s]."""
    s = pendulum()

    def of_law() -> None:
        law = fb.sample({"theta": (0.1, 2.0), "m": (1, 2)}, n=lanes, by="random", seed=1)
        some = fb.study(s, until=1, lanes=law, outputs="max(theta')")
        str(some)
        with suppress(Begun):
            some.run(progress=begun)

    theta, m = (np.random.default_rng(k).uniform(1, 2, lanes) for k in (1, 2))

    def of_arrays() -> None:
        with suppress(Begun):
            fb.simulate(
                s, 1, initial={"theta": theta}, values={"m": m}, outputs="max(theta')", progress=begun
            )

    fb.simulate(s, 1, initial={"theta": theta[:100]}, values={"m": m[:100]}, outputs="max(theta')")
    return processor(of_law, repeats), processor(of_arrays, repeats)


def reduction(lanes: int) -> tuple[float, float, str]:
    """Elapsed time [s], greatest memory of the process [MB], and the answer of so many pendulums."""
    call = [sys.executable, "-m", "benchmarks.studies", str(lanes)]
    words = subprocess.run(call, capture_output=True, text=True, check=True).stdout.split(";")
    return float(words[0]), float(words[1]), words[2].strip()


def reduce(lanes: int) -> None:
    """Reduce a study of pendulums, and print time, memory and answer."""
    clock = time.perf_counter()
    data = study(lanes, 1.0).reduce(
        {
            "p": fb.mean("max(theta') > 3"),
            "tail": fb.quantile("max(theta')", [0.5, 0.999]),
            "spread": fb.histogram("max(theta')", 200),
            "worst": fb.largest("max(theta')", 10),
        },
        progress=False,
    )  # fmt: skip
    # ru_maxrss would count what the parent had when it started this process
    status = Path("/proc/self/status").read_text(encoding="utf-8")
    memory = float(status.split("VmHWM:")[1].split()[0]) / 1e3
    print(f"{time.perf_counter() - clock:.1f}; {memory:.0f}; {data.attrs['p']}")


def main(quick: bool = False, repeats: int = 5, limit: float = 0.0) -> None:
    """Print the table."""
    del limit
    lanes = LANES // 10 if quick else LANES
    rows = [["fixed cost of a block", "< 1 ms", time_text(block(repeats))]]
    if module("distributed") is not None:
        with cluster() as client:
            rows.append(
                [
                    "block of a dask cluster, client and workers",
                    "< 5 ms",
                    time_text(dask_block(client, 400, repeats)),
                ]
            )
            share, elapsed = dask_efficiency(client, 4 if quick else 8, repeats)
            text = f"{100 * share:.0f} % (elapsed {100 * elapsed:.0f} %)"
            rows.append(["two dask workers beside two threads, blocks of 1 s", ">= 90 %", text])
    rows.append(
        ["a zarr store", "< 10 %", f"{100 * store(400_000 if quick else 1_000_000, min(repeats, 3)):.1f} %"]
    )
    rows.append(["dataset beyond outputs and coordinates", "<= 25 bytes a run", f"{size():.0f} bytes"])
    of_law, of_arrays = preparation(lanes, min(repeats, 2))
    rows.append([f"preparation of {lanes:.0e} lanes of a law", "< 1 s at 1e7", time_text(of_law)])
    rows.append([f"preparation of {lanes:.0e} lanes of arrays", "< 1 s at 1e7", time_text(of_arrays)])
    elapsed, memory, answer = reduction(lanes)
    rows.append([f"{lanes:.0e} runs reduced, {elapsed:.0f} s: {answer}", "< 500 MB", f"{memory:.0f} MB"])
    show(
        "The engine of studies", ["", "wanted", "measured"], rows,
        [
            "pendulums of 10 s (1 s where they are prepared, or reduced) at the default tolerance; processor time",
            "of all processes, least of the repeats",
            f"blocks of a cluster have {SHORT} lanes here, whose own time is left out; its blocks take "
            f"{cutting.SECONDS:g} s else",
        ],
    )  # fmt: skip


if __name__ == "__main__":
    reduce(int(sys.argv[1]))
