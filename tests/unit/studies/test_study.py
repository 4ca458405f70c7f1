"""Studies: values that run here or elsewhere with the same bits, are kept block by block, and go on after a stop."""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import numpy as np
import pytest
import scipy.stats
import xarray

import freebody as fb
from batch_machines import pendulum
from freebody.errors import SimulationError
from freebody.studies.blocks.schedule import shuffled
from freebody.studies.lanes.chosen import Chosen
from freebody.studies.stores import zarr as stores


def swings(n: int = 300, **options) -> fb.Study:
    lanes = fb.sample({"theta": scipy.stats.uniform(0.1, 2), "m": (1, 2)}, n=n, by="random", seed=1)
    return fb.study(pendulum(), until=1, lanes=lanes, **{"outputs": "max(theta')", **options})


def test_a_study_is_a_value() -> None:
    study = swings()
    again = pickle.loads(pickle.dumps(study))
    assert again.identity == study.identity and repr(again) == repr(study)
    assert repr(study).startswith("Study of 'pendulum' to 1 s: sample of theta ~ ")
    assert "of one processor" in str(study) and "of results" in str(study)
    others = [
        swings(301), swings(tolerance=1e-8), swings(outputs="max(theta)"), swings(values={"g": 1.62}), swings(samples=5)
    ]  # fmt: skip
    assert len({study.identity, *(x.identity for x in others)}) == 1 + len(others)


def test_lanes_are_those_of_simulate_wherever_they_run() -> None:
    study = swings()
    here = study.run(progress=False)
    columns = study.lanes.columns(0, study.count)
    batch = fb.simulate(
        pendulum(), 1, initial={"theta": columns["theta"]}, values={"m": columns["m"]}, outputs="max(theta')"
    )
    assert np.array_equal(here["max(theta')"], batch["max(theta')"])
    assert np.array_equal(here["m"], columns["m"]) and np.array_equal(here["theta_start"], columns["theta"])
    assert set(here.status.values.tolist()) == {1} and here.status.dtype == np.int8
    words = dict(zip(here.status.flag_values, here.status.flag_meanings.split(), strict=True))
    assert words[1] == "finished" and words[15] == "lost"
    for pool in (ProcessPoolExecutor(2), ThreadPoolExecutor(2)):
        with pool:
            assert study.run(pool, progress=False).identical(here)
    results = here.drop_vars(["m", "theta_start", "max(theta')"])
    assert sum(x.nbytes for x in results.data_vars.values()) <= 25 * study.count


def test_lanes_can_be_chosen() -> None:
    study, some = swings(), [7, 3, 4, 299]
    whole = study.run(progress=False)["max(theta')"].values
    assert np.array_equal(study.isel(lane=some).run(progress=False)["max(theta')"], whole[some])
    assert np.array_equal(
        study.isel(lane=slice(10, 20, 3)).run(progress=False)["max(theta')"], whole[10:20:3]
    )
    motion = study.isel(lane=-1)
    assert motion.t[-1] == 1 and abs(motion["theta'"].max() - whole[-1]) < 0.01
    assert isinstance(study.isel(lane=some).lanes, Chosen)
    with pytest.raises(SimulationError, match="Expected lanes from 0 to 299, got 300"):
        study.isel(lane=300)
    with pytest.raises(SimulationError, match="Expected a slice with lanes among 0 to 299, got slice"):
        study.isel(lane=slice(300, 400))
    many = fb.study(pendulum(), until=1, lanes=fb.sample({"theta": (0, 1)}, n=10**12, by="random"))
    assert many.isel(lane=slice(10**11, 10**11 + 3)).count == 3  # no array of all lanes
    with pytest.raises(SimulationError, match="Expected the number of a lane, several, or a slice, got 'x'"):
        study.isel(lane="x")


def test_a_store_is_read_by_xarray_and_goes_on_with_the_blocks_that_are_missing(tmp_path) -> None:
    study, path = swings(), tmp_path / "x.zarr"
    whole = study.run(progress=False)
    kept = study.run(store=path, progress=False)
    for name in whole.data_vars:
        assert np.array_equal(kept[name].values, whole[name].values), name
    assert np.array_equal(xarray.open_zarr(path).m.values, whole.m.values)
    stored = fb.open_study(path)
    assert stored.missing == 0 and stored.ended == {"finished": 300} and not stored.failed
    assert stored.study.identity == study.identity and "all lanes are kept" in repr(stored)
    chunks = sorted((path / "status" / "c").iterdir())
    assert len(chunks) > 1
    for name in ("status", "max(theta')"):
        (path / name / "c" / chunks[0].name).unlink()
    stored = fb.open_study(path)
    assert 0 < stored.missing < 300 and "lanes are missing" in repr(stored)
    low, high = next(iter(stores.missing(path)))
    assert np.isnan(stored.data["max(theta')"].values[low:high]).all()
    again = stored.resume(progress=False)
    assert np.array_equal(again["max(theta')"].values, whole["max(theta')"].values) and not stored.missing


def test_a_store_of_another_study_is_refused(tmp_path) -> None:
    path = tmp_path / "x.zarr"
    swings().run(store=path, progress=False)
    for other, what in (
        (swings(tolerance=1e-8), "method or tolerance"), (swings(301), "values, the lanes"),
        (swings(outputs="max(theta)"), "outputs"), (swings(values={"g": 1.62}), "values"),
    ):  # fmt: skip
        with pytest.raises(
            SimulationError, match=f"those of a study that differs in the {what}. Choose another"
        ):
            other.run(store=path, progress=False)
    with pytest.raises(
        SimulationError, match="Expected the zarr store of a study, got '.*nowhere', where nothing"
    ):
        fb.open_study(tmp_path / "nowhere")
    with pytest.raises(SimulationError, match="there is no folder '.*no'. Make it"):
        swings().run(store=tmp_path / "no" / "x.zarr", progress=False)
    (tmp_path / "y.zarr").mkdir()
    with pytest.raises(
        SimulationError, match="Expected a zarr store of a study at '.*y.zarr', but it cannot be read"
    ):
        swings().run(store=tmp_path / "y.zarr", progress=False)


KILLED = """
import sys
import freebody as fb, scipy.stats
from batch_machines import pendulum
from test_study import swings
if __name__ == "__main__":
    swings(40000).run("processes", store=sys.argv[1], progress=False)
"""


@pytest.mark.slow
def test_what_a_killed_client_has_kept_is_whole(tmp_path) -> None:
    path, whole = tmp_path / "x.zarr", swings(40000).run(progress=False)
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([*sys.path, os.path.dirname(__file__)])}
    for _ in range(3):
        with subprocess.Popen(
            [sys.executable, "-c", KILLED, str(path)], env=environment, start_new_session=True
        ) as child:
            time.sleep(2.0)
            os.killpg(child.pid, signal.SIGKILL)
        if path.exists():
            data = fb.open_study(path).data
            done = data.status.values >= 0
            assert np.array_equal(data["max(theta')"].values[done], whole["max(theta')"].values[done])
    data = swings(40000).run(store=path, progress=False)
    assert np.array_equal(data["max(theta')"].values, whole["max(theta')"].values)


def test_impossible_lanes_are_refused_before_anything_runs() -> None:
    lanes = fb.sample({"m": scipy.stats.norm(1, 0.5)}, n=1000, seed=1)
    with pytest.raises(
        SimulationError, match=r"Expected values for which every lane is possible, but 2\.\d+ % of"
    ):
        fb.study(pendulum(), until=1, lanes=lanes, outputs="max(theta')")


def test_progress_tells_all_that_is_known() -> None:
    states = []
    swings().run(progress=states.append)
    assert [float(x) for x in states] == sorted(map(float, states)) and states[-1] == 1
    last = states[-1]
    assert (last.done, last.count, last.failed, last.remaining) == (300, 300, {}, 0) and last.rate > 0
    assert str(last).startswith("300 of 300 lanes, ")


def test_nonsense_is_refused() -> None:
    lanes = fb.grid(theta=[0.1, 0.2])
    with pytest.raises(SimulationError, match=r"Expected fb.grid\(...\), fb.table\(...\) or fb.sample"):
        fb.study(pendulum(), until=1, lanes={"theta": [1, 2]})
    with pytest.raises(
        SimulationError, match=r"Expected store= where the study is run: study\(...\).run\(store=...\)"
    ):
        fb.study(pendulum(), until=1, lanes=lanes, store="x.nc")
    with pytest.raises(SimulationError, match="Unknown argument 'tolerence' of study"):
        fb.study(pendulum(), until=1, lanes=lanes, tolerence=1e-8)
    with pytest.raises(SimulationError, match="'theta' is in lanes= and in initial=. Leave one out"):
        fb.study(pendulum(), until=1, lanes=lanes, initial={"theta": 1})
    study = fb.study(pendulum(), until=1, lanes=lanes)
    with pytest.raises(SimulationError, match=r"Expected an executor with submit\(\), .* got 3"):
        study.run(3)
    with pytest.raises(SimulationError, match="Expected threads= or executor=, got both"):
        study.run("processes", threads=2)
    with pytest.raises(SimulationError, match="Expected a number of threads of at least 1, got 0"):
        study.run(threads=0)


def test_blocks_run_in_one_order_and_all_of_them() -> None:
    blocks = [(k, k + 1) for k in range(50)]
    assert shuffled(blocks) == shuffled(blocks) != blocks and sorted(shuffled(blocks)) == blocks
