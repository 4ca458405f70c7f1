"""Derivatives of the lanes of a batch are those of single runs, to the last bit."""

from __future__ import annotations

import numpy as np

import freebody as fb


def throw() -> fb.System:
    s = fb.System("throw")
    g = s.parameters(g=9.81)
    s.gravity = (0, -g, 0)
    s.slider("rail", s.ground, s.body("stone", fb.particle(1)), axis="y", coordinate="y")
    return s


def test_a_batch_is_its_single_runs(tmp_path) -> None:
    s, speeds = throw(), np.array([2.0, 3.0])
    hit = fb.event("y", name="hit", direction=-1, terminal=True)
    common = dict(events=[hit], times=[0.1, 0.2, 0.9], sensitivities=["g", "y'"])
    outputs = ["y", "max(y)", "final(y')"]
    data = fb.simulate(s, 1, initial={"y'": speeds}, outputs=outputs, **common)
    stored = fb.simulate(s, 1, initial={"y'": speeds}, outputs=outputs, store=tmp_path / "a.nc", **common)
    swept = fb.sweep(s, {"y'": speeds}, 1, outputs=outputs, **common)
    for k, v in enumerate(speeds):
        alone = fb.simulate(s, 1, initial={"y'": v}, **common)
        for name in ("max(y)", "final(y')"):
            assert np.array_equal(data[f"d({name})"][k], alone.sensitivity.of(name))
        assert np.array_equal(data["d(y)"][k, :2], alone.sensitivity.of("y"))
        assert np.array_equal(data["d(event_time)"][k, 0], alone.sensitivity.times("hit")[0])
    assert list(data["by"].values) == ["g", "y'"] and data["d(y)"].dims == ("lane", "time", "by")
    for name in ("d(y)", "d(max(y))", "d(end)", "d(event_last)"):
        assert np.array_equal(data[name], stored[name], equal_nan=True)
        assert np.array_equal(data[name].values, swept[name].values, equal_nan=True)
