"""Stores of studies: read while they run, written by two clients, rerun of lost lanes, and what is refused at once."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from concurrent.futures import ProcessPoolExecutor
from typing import Any

import numpy as np
import pytest
import scipy.stats
import xarray

import freebody as fb
from batch_machines import pendulum
from freebody.errors import SimulationError
from freebody.studies.blocks import run
from freebody.studies.blocks.crew import Crew


def swings(n: int, **options: Any) -> fb.Study:
    lanes = fb.sample({"theta": scipy.stats.uniform(0.1, 2), "m": (1, 2)}, n=n, by="random", seed=1)
    return fb.study(pendulum(), until=1, lanes=lanes, **{"outputs": "max(theta')", **options})


def test_a_store_is_read_while_it_runs(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(
        run, "size_of_block", lambda *_: 500
    )  # else a fast machine makes one block of all lanes
    study, path, seen = swings(3000), tmp_path / "x.zarr", []
    whole = study.run(progress=False)["max(theta')"].values

    def look(state: Any) -> None:
        data = xarray.open_zarr(path)
        done = data.status.values >= 0
        assert np.array_equal(data["max(theta')"].values[done], whole[done])
        seen.append(int(done.sum()))

    study.run(store=path, progress=look, threads=1)
    assert seen == sorted(seen) and any(0 < n < 3000 for n in seen) and seen[-1] == 3000


def test_a_netcdf_file_goes_on_where_it_was_stopped(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(run, "size_of_block", lambda *_: 500)
    study, path, calls = swings(3000), tmp_path / "x.nc", []
    whole = study.run(progress=False)

    def stop(state: Any) -> None:
        calls.append(state)
        if len(calls) == 3:
            raise KeyboardInterrupt

    with study.run(store=path, progress=stop, threads=1) as first:
        done = first.status.values >= 0
        assert 0 < done.sum() < 3000 and "interrupted" in first.attrs
        assert np.array_equal(first["max(theta')"].values[done], whole["max(theta')"].values[done])
    with study.run(store=path, progress=False) as second:
        assert set(second.data_vars) == set(whole.data_vars) and "interrupted" not in second.attrs
        for name in whole.data_vars:
            assert np.array_equal(second[name].values, whole[name].values), name


TWO = """
import sys
from test_store import swings
if __name__ == "__main__":
    swings(900).run("processes", store=sys.argv[1], progress=False)
"""


@pytest.mark.slow
def test_two_clients_at_once_do_no_harm(tmp_path) -> None:
    path = tmp_path / "x.zarr"
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([*sys.path, os.path.dirname(__file__)])}
    clients = [subprocess.Popen([sys.executable, "-c", TWO, str(path)], env=environment) for _ in range(2)]
    assert [client.wait(timeout=600) for client in clients] == [0, 0]
    kept, whole = fb.open_study(path), swings(900).run(progress=False)
    assert not kept.missing and not list(tmp_path.glob(".*"))
    for name in whole.data_vars:
        assert np.array_equal(kept.data[name].values, whole[name].values), name


class Sick:
    """A law that ends its process for a heavy push, until it is cured by a file."""

    def __init__(self, cure: str) -> None:
        self.cure, self.home = cure, os.getpid()

    def __call__(self, t: float, x: Any) -> float:
        if x["x"] > 0.5 and os.getpid() != self.home and not os.path.exists(self.cure):
            os.kill(os.getpid(), signal.SIGKILL)
        return -4 * x["x"]


def cart(law: Any) -> fb.System:
    s = fb.System("cart")
    s.parameters(push=0.0)
    rail = s.slider("rail", s.ground, s.body("cart", fb.particle(2)), axis="x", coordinate="x")
    s.force("motor", rail, "push")
    s.controller(law, 0.1, "push", name="law")
    return s


def test_lost_lanes_run_again_if_they_are_asked_to(tmp_path) -> None:
    path, cure = tmp_path / "x.zarr", tmp_path / "cure"
    lanes = fb.grid(x=[0.1, 0.2, 0.3, 0.6])
    study = fb.study(cart(Sick(str(cure))), until=1, lanes=lanes, outputs="final(x)")
    with ProcessPoolExecutor(2) as pool:
        data = study.run(pool, store=path, progress=False)
    stored = fb.open_study(path)
    assert stored.failed == {"lost": 1} and data.attrs["lost"].startswith("1 of 4 lanes, the first 3")
    assert any("its process ended abruptly" in x for x in stored.data.reason.values)
    cure.touch()
    assert np.isnan(stored.resume(progress=False)["final(x)"].values[3])
    again = stored.resume(lost=True, progress=False)
    assert stored.failed == {} and not any(stored.data.reason.values)
    assert np.array_equal(again["final(x)"], study.run(progress=False)["final(x)"])


def test_a_grid_has_its_names_as_axes(tmp_path) -> None:
    vary: dict[str, Any] = {"m": [1, 2], "theta": [0.1, 1.0, 2.0]}
    study = fb.study(pendulum(), until=1, lanes=fb.grid(vary), outputs=["theta", "max(theta')"], samples=3)
    swept = fb.sweep(pendulum(), vary, until=1, outputs=["theta", "max(theta')"], samples=3)
    for data in (study.run(progress=False), study.run(store=tmp_path / "x.zarr", progress=False)):
        shaped = study.on_grid(data)
        assert shaped["theta"].dims == ("m", "theta_start", "time")
        for name in ("theta", "max(theta')"):
            assert shaped[name].equals(swept[name]), name
        assert shaped.status.sizes == {"m": 2, "theta_start": 3}
    with pytest.raises(SimulationError, match=r"Expected a study over fb.grid\(...\), whose names are axes"):
        swings(3).on_grid(data)
    with pytest.raises(
        SimulationError, match="Expected results of this study over 6 lanes, got the dimensions"
    ):
        study.on_grid(swept)


def test_stages_of_a_reduction_have_one_crew(monkeypatch) -> None:
    crews = []
    made = Crew.__init__

    def counted(self: Any, *arguments: Any) -> None:
        crews.append(self)
        made(self, *arguments)

    monkeypatch.setattr(Crew, "__init__", counted)
    with ProcessPoolExecutor(1) as pool:
        data = swings(5000).reduce(
            {"p": fb.mean("max(theta') > 4")}, pool, until=fb.error("p", relative=0.05), progress=False
        )
    assert data.attrs["lanes"] > 1024 and len(crews) == 1


def started(executor: Any) -> bool:
    return bool(executor._processes)


def test_what_cannot_be_run_is_refused_before_anything_runs(tmp_path) -> None:
    """The list of bad input of studies: each names what came, and the cure."""
    study, path = swings(200), tmp_path / "x.zarr"
    study.run(store=path, progress=False)
    with ProcessPoolExecutor(1) as pool:
        for call, message in (
            (lambda: study.run(object()), r"Expected an executor with submit\(\), such as .*, got <object"),
            (lambda: study.reduce({"p": fb.mean("end")}, object()), r"Expected an executor with submit\(\)"),
            (lambda: study.run("tcp://127.0.0.1:1"), "Expected a scheduler of dask at 'tcp://127.0.0.1:1', but none"),
            (lambda: swings(200, values={"g": 1.62}).run(pool, store=path), "a study that differs in the values"),
            (lambda: swings(300).run(pool, store=path), "differs in the values, the lanes"),
            (lambda: swings(200, outputs="min(theta)").run(pool, store=path), "differs in the outputs"),
            (lambda: study.reduce({"p": fb.mean("max(thetta)")}, pool), "'thetta'.*theta"),
            (lambda: study.reduce({"p": fb.mean("ned")}, pool), "ned.*end"),
            (lambda: study.reduce({"p": fb.mean("end")}, pool, until="soon"), r"Expected fb.error\(...\) or a list"),
            (lambda: study.reduce({"p": fb.mean("end")}, pool, threads=2), "Expected threads= or executor=, got both"),
        ):  # fmt: skip
            with pytest.raises(SimulationError, match=message):
                call()
        lock = threading.Lock()

        def guarded(t: float, x: Any) -> float:
            with lock:
                return 0.0

        law = fb.study(cart(guarded), until=1, lanes=fb.grid(x=[0.1, 0.2]), outputs="final(x)")
        for call in (lambda: law.run(pool), lambda: law.reduce({"p": fb.mean("end")}, pool)):
            with pytest.raises(
                SimulationError, match="controller that can be sent to other processes, but 'law' is"
            ):
                call()
        assert not started(pool)
    with pytest.raises(SimulationError, match="Expected values for which every lane is possible, but 0.1"):
        lanes = fb.sample({"m": scipy.stats.norm(1, 1 / 3)}, n=100_000, seed=1)
        fb.study(pendulum(), until=1, lanes=lanes, outputs="max(theta')")


def test_the_store_of_another_program_is_refused(tmp_path, monkeypatch) -> None:
    path = tmp_path / "x.zarr"
    swings(100).run(store=path, progress=False)
    monkeypatch.setattr("freebody.studies.identity.study_identity.version", lambda: "another")
    with pytest.raises(SimulationError, match="those of a study that differs in the version of freebody"):
        swings(100).run(store=path, progress=False)
