"""``freebody study``: runs, stores, what failed, a picture, and nonsense."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import scipy.stats

import freebody as fb
from freebody.cli import main


@pytest.fixture
def freebody(capsys, monkeypatch, tmp_path):
    """The command in an empty folder: exit code, and what it printed."""
    monkeypatch.chdir(tmp_path)
    s = fb.System("stone")
    m, g = s.parameters(m=1.0, g=9.81)
    s.gravity = (0, -g, 0)
    s.slider("fall", s.ground, s.body("stone", fb.particle(m)), axis="y", coordinate="y")
    fb.write(s, tmp_path / "stone.toml")

    def call(*arguments: str) -> tuple[int, str]:
        with pytest.raises(SystemExit) as end:
            main(arguments)
        out, err = capsys.readouterr()
        assert "Traceback" not in out + err
        return int(end.value.code or 0), out + err

    return call


RUN = ("study", "stone.toml", "--until", "1", "--output", "max(y)")
DRAW = (*RUN, "--sample", "y'=norm(2,0.5)", "--n", "200")


def test_a_sample_is_that_of_python(freebody) -> None:
    code, text = freebody(*DRAW, "--sample", "m=1:2", "--by", "lhs", "--seed", "3", "-o", "x.zarr")
    assert code == 0 and "200 finished" in text and "wrote x.zarr" in text and "y' ~ norm(2, 0.5)" in text
    lanes = fb.sample({"y'": scipy.stats.norm(2, 0.5), "m": (1, 2)}, 200, by="lhs", seed=3)
    data = fb.open_study("x.zarr").data
    for name, values in lanes.columns(0, 200).items():
        assert np.array_equal(data["y'_start" if name == "y'" else name], values)
    v = data["y'_start"].values
    assert np.allclose(data["max(y)"], np.where(v > 0, v**2 / (2 * 9.81), 0), rtol=0, atol=1e-8)


def test_a_stopped_study_goes_on(freebody) -> None:
    assert freebody(*DRAW, "-o", "x.zarr")[0] == 0
    whole = fb.open_study("x.zarr").data["max(y)"].values
    chunks = sorted((fb.open_study("x.zarr").path / "status" / "c").iterdir())
    chunks[0].unlink()
    missing = fb.open_study("x.zarr").missing
    code, text = freebody("study", "x.zarr")
    assert code == 0 and f"{missing} of 200 lanes are missing" in text and "Made by: " in text
    assert freebody(*DRAW, "-o", "x.zarr")[0] == 0 and fb.open_study("x.zarr").missing == 0
    assert np.array_equal(fb.open_study("x.zarr").data["max(y)"].values, whole)
    code, text = freebody(*RUN, "--sample", "y'=norm(2,0.6)", "--n", "200", "-o", "x.zarr")
    assert code == 2 and "holds those of a study that differs in the" in text


def test_where_it_runs_changes_nothing(freebody) -> None:
    for name, executor in (("a.zarr", "threads"), ("b.nc", "processes")):
        code, text = freebody(*DRAW, "-o", name, "--executor", executor)
        assert code == 0 and f"wrote {name}" in text
    import xarray

    with xarray.open_dataset("b.nc") as data:
        assert np.array_equal(data["max(y)"], fb.open_study("a.zarr").data["max(y)"])


def test_a_dask_cluster_by_its_address(freebody) -> None:
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None, protocol="tcp"
    ) as cluster:
        address = cluster.scheduler_address.replace("tcp://", "dask://")
        code, text = freebody(*DRAW, "-o", "x.zarr", "--executor", address)
        assert code == 0 and "200 finished" in text


def test_what_failed_is_told_with_the_first_lane(freebody) -> None:
    code, text = freebody(
        *RUN, "--vary", "y'=1,2,3", "--output", "range(1/(y-0.3))", "--event", "sqrt(0.15-y)", "-o", "x.zarr"
    )
    assert code == 0 and "1 finished" in text and "event undefined" in text
    shown = freebody("study", "x.zarr")
    assert shown[0] == 0 and "1 (y'_start = 2)" in shown[1] and "2 event undefined" in shown[1]


def test_the_picture(freebody) -> None:
    freebody(*DRAW, "--output", "y", "-o", "x.zarr")
    for name in ("x.png", "x.svg"):
        code, text = freebody("study", "x.zarr", "-o", name)
        assert code == 0 and f"wrote {name}" in text
    assert Path("x.svg").read_text(encoding="utf-8").count("<svg") == 1
    axes = fb.plot.lanes(fb.open_study("x.zarr").data)
    assert axes.shape == (2, 1) and axes[0, 0].get_ylabel() in ("y [m]", "max(y) [m]")


def test_a_sweep_is_a_study(freebody) -> None:
    vary = ("--vary", "y'=1:3:5", "--vary", "m=1,2", "--until", "1", "--output", "max(y)")
    for command, name in (("sweep", "a.zarr"), ("study", "b.zarr")):
        assert freebody(command, "stone.toml", *vary, "-o", name)[0] == 0
    a, b = fb.open_study("a.zarr"), fb.open_study("b.zarr")
    assert a.study.identity == b.study.identity and a.count == 10


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--sample", "y'=nrm(1,2)", "--n", "9"), "Expected a distribution of scipy.stats, got 'nrm'; did you mean 'norm'"),  # noqa: E501
        (("--sample", "y'=norm(1,2,3)", "--n", "9"), "Expected norm(loc, scale), got norm(1,2,3)"),
        (("--sample", "y'=gamma()", "--n", "9"), "Expected gamma(a, loc, scale), got gamma(): a is missing"),
        (("--sample", "y'=norm(scal=1)", "--n", "9"), "Expected norm(loc, scale), got norm(scal=1)"),
        (("--sample", "y'=norm(a,b)", "--n", "9"), "--sample y'"),
        (("--sample", "y'=norm(0,-1)", "--n", "9"), "Expected finite quantiles"),
        (("--sample", "y'=norm", "--n", "9"), "Expected name=norm(0.5,0.05) or name=low:high"),
        (("--sample", "y'=__import__('os')", "--n", "9"), "Expected a distribution of scipy.stats"),
        (("--sample", "y'=2:1", "--n", "9"), "low < high"),
        (("--sample", "z=norm(0,1)", "--n", "9"), "Unknown name 'z' in lanes"),
        (("--sample", "m=norm(0,1)", "--n", "99"), "% of the lanes"),
        (("--sample", "y'=norm(0,1)"), "Expected the number of lanes of --sample: add --n"),
        (("--sample", "y'=norm(0,1)", "--n", "2.5"), "Expected a whole number"),
        (("--sample", "y'=norm(0,1)", "--sample", "y'=0:1", "--n", "9"), "'y'' is drawn twice"),
        (("--sample", "y'=norm(0,1)", "--n", "9", "--by", "sobl"), "'sobl' is not one of"),
        (("--sample", "y'=norm(0,1)", "--n", "9", "--vary", "m=1,2"), "got both. Leave one out"),
        (("--vary", "m=1,2", "--n", "9"), "Expected --sample with --n"),
        ((), "Expected what varies: --vary NAME=FROM:TO:COUNT, or --sample"),
        (("--vary", "m=1,2", "--executor", "cloud"), "Expected threads, processes or dask://HOST:PORT, got 'cloud'"),
        (("--vary", "m=1,2", "-o", "x.csv"), "Expected x.zarr or x.nc for the results, got 'x.csv'"),
        (("--vary", "m=1,2", "--output", "max(z)"), "z"),
    ],
)  # fmt: skip
def test_nonsense_is_refused(freebody, arguments: tuple[str, ...], message: str) -> None:
    code, text = freebody(*RUN, *arguments)
    assert code == 2 and message in " ".join(text.split()), text


def test_nonsense_about_stores_is_refused(freebody, tmp_path) -> None:
    code, text = freebody("study", "no.zarr")
    assert code == 2 and "where nothing is" in text
    (tmp_path / "folder.zarr").mkdir()
    code, text = freebody("study", "folder.zarr")
    assert code == 2 and "Expected a zarr store of a study" in text
    freebody(*DRAW, "-o", "x.zarr")
    code, text = freebody("study", "x.zarr", "-o", "x.txt")
    assert code == 2 and "Expected a picture for -o, .png, .svg, .pdf" in text
    code, text = freebody("study", "x.zarr", "--until", "3")
    assert code == 2 and "is a store: it is shown" in text
    code, text = freebody("study", "x.zarr", "-o", "no/x.png")
    assert code == 2 and "Cannot write" in text
    code, text = freebody("study", "stone.toml", "--vary", "m=1,2")
    assert code == 2 and "Expected the length of the runs" in text


def test_ctrl_c_leaves_with_130(freebody, monkeypatch) -> None:
    from freebody.studies.blocks import block

    def stopped(*arguments):
        raise KeyboardInterrupt

    monkeypatch.setattr(block, "run_lanes", stopped)
    code, text = freebody(*DRAW, "-o", "x.zarr")
    assert code == 130 and "Stopped by the keyboard: 200 runs are left; the same command continues" in text
