"""Executors by text: ray (a small substitute with its calls, and ray itself where it is installed), names in dask."""

from __future__ import annotations

import sys
from concurrent.futures import CancelledError, ThreadPoolExecutor
from types import ModuleType

import numpy as np
import pytest
import scipy.stats

import freebody as fb
from batch_machines import pendulum
from freebody.errors import SimulationError
from freebody.studies.blocks.crew import prefix_of
from freebody.studies.blocks.executors import RayPool


def swings(n: int = 400, **options) -> fb.Study:
    lanes = fb.sample({"theta": scipy.stats.uniform(0.1, 2), "m": (1, 2)}, n=n, by="random", seed=1)
    return fb.study(pendulum(), until=1, lanes=lanes, **{"outputs": "max(theta')", **options})


class Reference:
    """What ray's ObjectRef has of what is used."""

    def __init__(self, future) -> None:
        self._future = future

    def future(self):
        return self._future


class Ray(ModuleType):
    """The calls of ray that are used: cluster_resources, remote, put, cancel, is_initialized, init."""

    def __init__(self) -> None:
        super().__init__("ray")
        self.pool, self.kept, self.begun, self.options = ThreadPoolExecutor(2), {}, [], []

    def is_initialized(self) -> bool:
        return bool(self.begun)

    def init(self, address, log_to_driver) -> None:
        if address is not None and "nowhere" in address:
            raise ConnectionError("no answer")
        self.begun.append(address)

    def cluster_resources(self) -> dict[str, float]:
        return {"CPU": 2.0, "memory": 1e9}

    def put(self, value):
        reference = Reference(None)
        self.kept[id(reference)] = value
        return reference

    def remote(self, **options):
        self.options.append(options)

        def decorated(function):
            def call(*arguments):
                values = [self.kept[id(x)] if isinstance(x, Reference) else x for x in arguments]
                return Reference(self.pool.submit(function, *values))

            decorated.remote = call
            return decorated

        return decorated

    def cancel(self, reference) -> None:
        reference.cancelled = True


@pytest.fixture
def ray(monkeypatch) -> Ray:
    substitute = Ray()
    monkeypatch.setitem(sys.modules, "ray", substitute)
    return substitute


def test_ray_runs_blocks_with_the_same_bits(ray: Ray) -> None:
    study = swings()
    here = study.run(progress=False)
    assert study.run("ray", progress=False).identical(here)
    assert ray.begun == [None] and ray.options == [{"max_retries": 0}] and len(ray.kept) == 1
    assert study.run("ray", progress=False).identical(here) and ray.begun == [None]  # it is not begun again


def test_a_task_that_is_cancelled_is_cancelled_in_ray(ray: Ray) -> None:
    pool = RayPool(ray)
    block = ThreadPoolExecutor(1)
    from threading import Event

    event = Event()
    ray.pool = block
    first, second = pool.submit(event.wait), pool.submit(event.wait)
    assert second.cancel()
    event.set()
    assert first.result() and pool.num_workers == 2
    with pytest.raises(CancelledError):
        second.result()


def test_ray_that_is_not_there(ray: Ray, monkeypatch) -> None:
    with pytest.raises(
        SimulationError, match="Expected a cluster of ray at 'ray://nowhere:1', but none answered: no answer"
    ):
        swings().run("ray://nowhere:1", progress=False)
    monkeypatch.setitem(sys.modules, "ray", None)
    with pytest.raises(SimulationError, match="Expected ray for executor='ray', .* Run: pip install ray"):
        swings().run("ray", progress=False)


@pytest.mark.slow
def test_ray_itself() -> None:
    pytest.importorskip("ray")
    study = swings(4000)
    assert study.run("ray", progress=False).identical(study.run(progress=False))


@pytest.mark.parametrize(
    "name", ["pendulum", "prob-6-18", "two gears", "3 gears, open", "ex-6-4 (b)", "a-deadbeef"]
)
def test_dask_shows_blocks_under_the_name_of_the_machine(name: str) -> None:
    key_split = pytest.importorskip("dask.utils").key_split
    assert key_split(f"{prefix_of(name)}-0a1b2c3d-0-100-140") == name.replace("-", "_").replace(",", "_")
    assert key_split(f"{prefix_of(name)}-abcdefab-0-100-140") == name.replace("-", "_").replace(",", "_")


def test_keys_on_a_scheduler_begin_with_the_name_of_the_machine() -> None:
    distributed = pytest.importorskip("distributed")
    study = swings()
    with (
        distributed.LocalCluster(n_workers=1, processes=False, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        data = study.run(client, progress=False)
        prefixes = set(client.run_on_scheduler(lambda dask_scheduler: list(dask_scheduler.task_prefixes)))
    assert "pendulum" in prefixes and np.array_equal(
        data["max(theta')"], study.run(progress=False)["max(theta')"]
    )


class Weak:
    """Has no submit."""


@pytest.mark.parametrize("executor", [3, "here", Weak(), ThreadPoolExecutor])
def test_what_is_no_executor(executor) -> None:
    for run in (swings().run, lambda x, progress: swings().reduce({"p": fb.mean("max(theta)")}, x)):
        with pytest.raises(SimulationError, match=r"Expected an executor with submit\(\), such as .* got "):
            run(executor, progress=False)
