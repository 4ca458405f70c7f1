"""Sweeps: every combination, by name."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from click.testing import CliRunner

import freebody as fb
from freebody.cli import command
from freebody.errors import SimulationError


def pendulum() -> fb.System:
    s = fb.System("pendulum")
    L, g = s.parameters(L=1.0, g=9.81)
    s.gravity = (0, -g, 0)
    s.hinge("pin", s.ground, s.body("bob", fb.particle(1)), to=(0, L, 0), axis="z", coordinate="theta")
    return s


LENGTHS, ANGLES = [1.0, 4.0, 2.0], [0.3, 2.0]


def test_a_grid_of_periods_agrees_with_elliptic_functions() -> None:
    """Half a period passes between two zeros of the speed."""
    data = fb.sweep(
        pendulum(), {"L": LENGTHS, "theta": ANGLES}, until=9.0, outputs=["theta", "max(theta')"], samples=4,
        events=[fb.event("theta'", name="turn", direction=1)], tolerance=1e-11,
    )  # fmt: skip
    assert dict(data.sizes) == {"L": 3, "theta_start": 2, "time": 4, "event": 1}
    for i, length in enumerate(LENGTHS):
        for j, angle in enumerate(ANGLES):
            rate = np.sqrt(9.81 / length)
            half = fb.exact.pendulum_period(angle, rate) / 2
            assert float(data.event_time[i, j, 0]) == pytest.approx(half, rel=1e-9)
            expected, _ = fb.exact.pendulum(angle, rate, data.time.values)
            assert np.allclose(data["theta"][i, j], expected, rtol=0, atol=1e-8)
            assert float(data["max(theta')"].sel(L=length, theta_start=angle)) == pytest.approx(
                2 * rate * np.sin(angle / 2), rel=1e-9
            )


def test_axes_may_be_written_with_units() -> None:
    said = fb.sweep(pendulum(), {"L": ["80 cm", "1.5 m"], "theta": ["20deg", "pi/4"]}, 0.5, samples=2)
    meant = fb.sweep(pendulum(), {"L": [0.8, 1.5], "theta": [np.pi / 9, np.pi / 4]}, 0.5, samples=2)
    assert said.equals(meant)
    with pytest.raises(
        SimulationError, match=r"without a unit for the values of 'theta' in vary, got '20 deg'\. Write pi/9"
    ):
        fb.sweep(pendulum(), {"theta": ["20 deg"]}, 0.5)


def test_other_executors_give_the_same(tmp_path) -> None:
    s, vary = pendulum(), {"theta": np.linspace(0.1, 3, 70)}
    here = fb.sweep(s, vary, 2, samples=3)
    with ThreadPoolExecutor(2) as pool:
        there = fb.sweep(s, vary, 2, samples=3, executor=pool)
        kept = fb.sweep(s, vary, 2, samples=3, executor=pool, store=tmp_path / "x.nc")
    assert there.identical(here)
    for name in here.data_vars:
        assert np.array_equal(kept[name].values, here[name].values), name
    again = fb.sweep(s, vary, 2, samples=3, store=tmp_path / "x.nc")
    assert np.array_equal(again["theta"], here["theta"]) and list(again.coords) == list(kept.coords)


@pytest.mark.parametrize(
    ("vary", "options", "message"),
    [
        ({}, {}, "Expected vary= by name"),
        ({"thet": [1, 2]}, {}, "Unknown name 'thet' in vary; did you mean 'theta'"),
        ({"L": [1, 2]}, {"values": {"L": 1}}, "'L' is in vary= and in values="),
        ({"theta": [1, 2]}, {"initial": {"theta": 1}}, "'theta' is in vary= and in initial="),
        ({"L": []}, {}, "at least one number for 'L'"),
        ({"L": 2}, {}, r"at least one number for 'L' in vary, got 2. Write"),
        ({"L": [1, 1]}, {}, "Expected different numbers for 'L'"),
        ({"L": ["a"]}, {}, "Expected an array of numbers for the values of 'L' in vary, got .*'a'"),
        ({"L": [None, {}]}, {}, "Expected numbers for 'L'"),
        ({"L": [1, float("inf")]}, {}, "Expected finite numbers for 'L'"),
        ({"L": [1, 2]}, {"values": {"L": 3}}, "'L' is in vary= and in values="),
        ({"L": [1, 2]}, {"executor": 3}, r"Expected an executor with submit\(\)"),
    ],
)
def test_refusals(vary: dict, options: dict, message: str) -> None:
    with pytest.raises(SimulationError, match=message):
        fb.sweep(pendulum(), vary, 1, **options)


def test_command_line(tmp_path) -> None:
    run = CliRunner().invoke
    path = tmp_path / "x.nc"
    arguments = [
        "sweep",
        "gyroscope",
        "--vary",
        "R=0.05:0.08:3",
        "--vary",
        "theta=20deg,60deg",
        "--until",
        "0.5",
    ]
    result = run(command, [*arguments, "--output", "max(theta)", "-o", str(path)])
    assert result.exit_code == 0 and "6 finished" in result.output and f"wrote {path}" in result.output
    assert "max(theta)" in result.output and "6 runs of" in result.output
    result = run(command, arguments)
    assert result.exit_code == 0 and "Add -o FILE.zarr or -o FILE.nc to keep" in result.output
    result = run(command, ["sweep", "bouncing-ball", "--vary", "h=1,2", "--until", "0.5"])  # which has texts
    assert result.exit_code == 0 and "2 finished" in result.output and "reason" not in result.output
    for wrong in ("R", "R=1:2", "R=1:2:x", "R=a:2:3"):
        result = run(command, ["sweep", "gyroscope", "--vary", wrong, "--until", "1"])
        assert result.exit_code == 2 and "Expected" in result.output, result.output
    result = run(command, [*arguments, "--vary", "R=1,2"])
    assert result.exit_code == 2 and "varied twice" in result.output
