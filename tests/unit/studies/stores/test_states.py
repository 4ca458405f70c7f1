"""States that are kept: a reduction goes on after any stop, with the bits of one that was not stopped."""

from __future__ import annotations

import base64
import os
import pickle
from concurrent.futures import ProcessPoolExecutor
from typing import Any

import pytest
import scipy.stats
import zarr

import freebody as fb
from batch_machines import pendulum
from freebody.errors import SimulationError
from freebody.studies.blocks import cutting
from freebody.studies.stores.states import starts_of

REDUCERS = {
    "p": fb.mean("range(theta') > 2"),
    "tail": fb.quantile("range(theta')", [0.5, 0.9]),
    "spread": fb.histogram("range(theta')", 20),
    "worst": fb.largest("range(theta')", 3),
    "by_mass": fb.variance("end", by="floor(m)"),
}


def swings(n: int = 4000, **options) -> fb.Study:
    lanes = fb.sample({"theta": scipy.stats.uniform(0.1, 2), "m": (1, 3)}, n=n, by="random", seed=1)
    return fb.study(pendulum(), until=1, lanes=lanes, **options)


def test_a_store_gives_back_what_blocks_gave_and_runs_the_others(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(cutting, "_SHORTEST", 0.0)  # many blocks, on a slow machine too
    study, path = swings(), tmp_path / "x.zarr"
    whole = study.reduce(REDUCERS, progress=False)
    with ProcessPoolExecutor(2) as pool:
        assert study.reduce(REDUCERS, pool, store=path, progress=False).identical(whole)
    stored = fb.open_study(path)
    assert stored.reduced and stored.missing == 0 and "4000 of 4000 lanes are kept" in repr(stored)
    starts = sorted(starts_of(path))
    assert len(starts) >= 4
    for first in starts[1::2]:
        (path / "study" / "states" / "c" / str(first)).unlink()
    left = stored.missing
    assert 0 < left < 4000
    states: list[Any] = []
    assert stored.resume(progress=states.append, threads=1).identical(whole)
    assert states[0].done >= 4000 - left and not stored.missing
    states.clear()
    assert study.reduce(REDUCERS, store=path, progress=states.append).identical(whole)
    assert not states  # nothing was run


def test_ctrl_c_keeps_the_blocks_that_have_ended(tmp_path) -> None:
    study, path = swings(), tmp_path / "x.zarr"
    whole = study.reduce(REDUCERS, progress=False)

    def press(state: Any) -> None:
        if state.done > 500:
            raise KeyboardInterrupt

    part = study.reduce(REDUCERS, store=path, progress=press, threads=1)
    assert part.attrs["interrupted"].endswith("of 4000 lanes were not run") and part.attrs["lanes"] < 4000
    assert study.reduce(REDUCERS, store=path, progress=False).identical(whole)


def test_stages_of_another_rule_do_not_harm(tmp_path) -> None:
    study, path, p = swings(), tmp_path / "x.zarr", {"p": REDUCERS["p"]}
    rule = fb.error("p", relative=0.02)
    some, whole = study.reduce(p, until=rule, progress=False), study.reduce(p, progress=False)
    assert some.attrs["lanes"] < 4000
    assert study.reduce(p, until=rule, store=path, progress=False).identical(some)
    assert study.reduce(p, store=path, progress=False).identical(whole)
    assert study.reduce(p, until=rule, store=path, progress=False).identical(some)


def test_a_store_of_something_else_is_refused(tmp_path) -> None:
    study, path, lanes = swings(200), tmp_path / "x.zarr", tmp_path / "lanes.zarr"
    study.reduce({"p": REDUCERS["p"]}, store=path, progress=False)
    for reducers, options, what in (
        ({"p": fb.mean("range(theta') > 3")}, {}, "reducers"), ({"q": REDUCERS["p"]}, {}, "reducers"),
        ({"p": REDUCERS["p"]}, {"failed": "skip"}, "reducers"),
    ):  # fmt: skip
        with pytest.raises(
            SimulationError, match=f"those of a study that differs in the {what}. Choose another"
        ):
            study.reduce(reducers, store=path, progress=False, **options)
    with pytest.raises(SimulationError, match="that differs in the method or tolerance"):
        swings(200, tolerance=1e-7).reduce({"p": REDUCERS["p"]}, store=path, progress=False)
    study.run(store=lanes, progress=False)
    with pytest.raises(
        SimulationError, match="to hold a study that is reduced, but it holds the lanes of one"
    ):
        study.reduce({"p": REDUCERS["p"]}, store=lanes, progress=False)
    with pytest.raises(
        SimulationError, match="Expected lanes, which study.run.* keeps, but '.*' keeps statistics"
    ):
        fb.open_study(path).data  # noqa: B018
    with pytest.raises(SimulationError, match="those of a study that differs in"):
        study.run(store=path, progress=False)


def test_a_state_that_runs_code_is_not_read(tmp_path) -> None:
    study, path = swings(100), tmp_path / "x.zarr"
    study.reduce({"p": REDUCERS["p"]}, store=path, progress=False)

    class Planted:
        def __reduce__(self) -> Any:
            return os.mkdir, (str(tmp_path / "planted"),)

    group: Any = zarr.open_group(str(path), mode="r+")
    end = str(group["study/states"][0]).split()[0]
    group["study/states"][0] = f"{end} {base64.b64encode(pickle.dumps(Planted())).decode()}"
    with pytest.raises(
        SimulationError, match="but those of lane 0 cannot be read: .*mkdir is no part of a state"
    ):
        study.reduce({"p": REDUCERS["p"]}, store=path, progress=False)
    assert not (tmp_path / "planted").exists()


@pytest.mark.parametrize(
    "name", ["lanes", "failed", "failed_means", "lost", "interrupted", "p_error", "p_low", "end"]
)
def test_a_name_that_hides_something_is_refused(name: str) -> None:
    reducers = {"p": fb.mean("range(theta') > 2", by="end"), name: fb.mean("end")}
    with pytest.raises(
        SimulationError, match=f"Expected another name for the reducer '{name}', which in the result"
    ):
        swings(10).reduce(reducers, progress=False)
