"""Fits: exact data give back the parameters, noisy data errors of the stated size, idle data a refusal."""

from __future__ import annotations

import numpy as np
import pytest
import xarray

import freebody as fb
from freebody.errors import SimulationError

TRUE = {"I": 0.5, "theta": 0.8}
TIMES = np.linspace(0, 4, 81)


def pendulum() -> fb.System:
    s = fb.System("pendulum")
    m, d, inertia, c = s.parameters(m=2.0, d=0.3, I=0.5, c=0.0)
    s.gravity = (0, -9.81, 0)
    bar = s.body("bar", fb.MassProperties(m, (0, -d, 0), ((9, 0, 0), (0, 9, 0), (0, 0, inertia))))
    pin = s.hinge("pin", s.ground, bar, axis="z", coordinate="theta")
    s.damper("c", pin, damping=c)
    return s


def measured(noise: float = 0.0, seed: int = 0, **more) -> dict:
    motion = fb.simulate(pendulum(), 4, initial={"theta": 0.8}, times=TIMES, tolerance=1e-12, **more)
    rng = np.random.default_rng(seed)
    return {"time": TIMES, "theta": motion["theta"] + noise * rng.normal(size=TIMES.size)}


def test_exact_data_give_back_parameters_and_start() -> None:
    guesses = {"I": 0.8, "theta": 0.6, "c": 0.1}
    found = fb.fit(pendulum(), measured(values={"c": 0.07}), guesses, tolerance=1e-12)
    for name, value in {**TRUE, "c": 0.07}.items():
        assert found.values[name] == pytest.approx(value, rel=1e-8), name
    assert np.abs(found.residuals["theta"]).max() < 1e-9
    assert found.trajectory["theta"].shape == TIMES.shape
    assert "I = 0.5" in repr(found) and found.correlation.shape == (3, 3)


def test_errors_are_of_the_stated_size() -> None:
    """Over 120 seeded measurements the squares of error/standard error have mean 1 ± 3 sqrt(2/120)."""
    noise, s, runs = 0.02, pendulum(), 120
    clean = measured()
    deviations, errors, estimates = [], [], []
    for seed in range(runs):
        rng = np.random.default_rng(seed)
        data = {"time": TIMES, "theta": clean["theta"] + noise * rng.normal(size=TIMES.size)}
        found = fb.fit(s, data, {"I": 0.55, "theta": 0.8}, tolerance=1e-7)
        deviations.append([found.values[name] - value for name, value in TRUE.items()])
        errors.append([found.errors[name] for name in TRUE])
        estimates.append(found.sigma["theta"])
    ratio = np.mean((np.array(deviations) / np.array(errors)) ** 2, axis=0)
    spread = 3 * np.sqrt(2 / runs)
    assert np.all(np.abs(ratio - 1) < spread), ratio
    assert abs(np.mean(estimates) / noise - 1) < 3 / np.sqrt(2 * TIMES.size * runs) * 1.5
    # and they are correlated as stated
    seen = np.corrcoef(np.array(deviations).T)[0, 1]
    assert abs(seen - found.correlation[0, 1]) < 3 / np.sqrt(runs)


def test_given_sigma_is_taken_and_scales_the_errors() -> None:
    data = measured(0.02)
    one = fb.fit(pendulum(), data, ["I"], initial={"theta": 0.8}, sigma={"theta": 0.02})
    two = fb.fit(pendulum(), data, ["I"], initial={"theta": 0.8}, sigma={"theta": np.full(81, 0.04)})
    assert two.errors["I"] == pytest.approx(2 * one.errors["I"], rel=1e-6)
    assert one.values["I"] == pytest.approx(two.values["I"], rel=1e-9)


def test_several_motions_quantities_gaps_and_datasets() -> None:
    s = pendulum()
    runs, starts = [], [{"theta": 0.8}, {"theta": 2.0, "theta'": 1.0}]
    for start in starts:
        motion = fb.simulate(s, 3, initial=start, times=TIMES[:50], tolerance=1e-12, values={"c": 0.05})
        angle = motion["theta"].copy()
        angle[[3, 7]] = np.nan
        runs.append({"time": TIMES[:50], "theta": angle, "d*sin(theta)": motion["d*sin(theta)"]})
    sigma = {"theta": 0.01, "d*sin(theta)": 0.01}
    found = fb.fit(s, runs, {"I": 0.7, "c": 0.02, "d": 0.33}, initial=starts, sigma=sigma, tolerance=1e-12)
    assert found.values == pytest.approx({"I": 0.5, "c": 0.05, "d": 0.3}, rel=1e-7)
    assert len(found.trajectories) == 2 and found.residuals["theta"].size == 100
    table = xarray.Dataset({"theta": ("time", runs[0]["theta"])}, coords={"time": TIMES[:50]})
    single = fb.fit(s, table, {"I": 0.7}, initial={"theta": 0.8}, values={"c": 0.05}, tolerance=1e-12)
    assert single.values["I"] == pytest.approx(0.5, rel=1e-8)


def test_parameters_that_the_motion_does_not_tell_apart_are_named() -> None:
    """Mass and moment of inertia together: the pendulum feels their ratio only."""
    s = pendulum()
    with pytest.raises(SimulationError, match="does not tell 'm', 'I' apart: .*m by .*1 %, I by .*1 %"):
        fb.fit(s, measured(), ["m", "I"], initial={"theta": 0.8})
    with pytest.raises(SimulationError, match="does not depend on 'm': it cannot be found"):
        t = fb.System("falling")
        m = t.parameters(m=1.0)
        t.gravity = (0, 0, -9.81)
        t.slider("z", t.ground, t.body("stone", fb.particle(m)), axis="z", coordinate="z")
        fb.fit(t, {"time": [0.0, 1.0, 2.0], "z": [0.0, -4.9, -19.6]}, ["m", "z'"])


@pytest.mark.parametrize(
    ("data", "options", "message"),
    [
        ({"theta": [1.0]}, {}, "Expected 'time' among the measured data, got theta"),
        ({"time": [1.0, 2.0]}, {}, "at least one measured quantity"),
        ({"time": [1.0, 2.0], "theta": [1.0]}, {}, "Expected 2 measured values of 'theta'"),
        ({"time": [-1.0, 2.0], "theta": [1.0, 2.0]}, {}, "after the start of the motion at 0 s, got one at -1 s"),
        ({"time": [1.0, 2.0], "theta": ["a", 2.0]}, {}, "arrays of numbers"),
        ({"time": [1.0, 2.0], "theta": [np.inf, 2.0]}, {}, "finite measured values of 'theta'"),
        ({"time": [1.0, np.nan], "theta": [1.0, 2.0]}, {}, "Expected finite times"),
        (3, {}, "Expected measured data by name"),
        ([3], {}, "Expected measured data by name"),
        ({"time": [1.0], "theta": [1.0]}, {"unknown": ["I", "theta"]}, "as many measured numbers as unknowns, got 1"),
        ({"time": [1.0], "theta": [1.0]}, {"unknown": ["J"]}, "Unknown name 'J' in unknown"),
        ({"time": [1.0], "theta": [1.0]}, {"sigma": {"x": 1}}, "Expected measured quantities in sigma, theta; got 'x'"),
        ({"time": [1.0], "theta": [1.0]}, {"sigma": {"theta": 0}}, "standard deviation greater than 0"),
        ({"time": [1.0], "theta": [1.0], "theta'": [1.0]}, {}, "Expected sigma= for several measured quantities"),
        ({"time": [1.0], "theta": [1.0], "theta'": [1.0]}, {"sigma": {"theta": 1}}, "that of theta' is missing"),
        ({"time": [1.0], "theta": [1.0]}, {"bounds": {"x": (0, 1)}}, "Expected unknowns in bounds, I; got 'x'"),
        ({"time": [1.0], "theta": [1.0]}, {"bounds": {"I": (1, 2)}}, "'I' within its bounds, 1 to 2, got 0.5"),
        ({"time": [1.0], "theta": [1.0]}, {"initial": [{}, {}]}, "one initial= for each of the 1 measurements, got 2"),
        ({"time": [1.0], "thet": [1.0]}, {}, "thet"),
    ],
)  # fmt: skip
def test_refusals(data, options: dict, message: str) -> None:
    options = {"unknown": ["I"], "initial": {"theta": 1.0}, **options}
    with pytest.raises(SimulationError, match=message):
        fb.fit(pendulum(), data, options.pop("unknown"), **options)


def free_pendulum():
    s = fb.System("pendulum")
    m, L, g = s.parameters(m=1.0, L=2.0, g=9.81)
    s.gravity = (0, -g, 0)
    bar = s.body("bar", fb.slender_bar(m, L, axis="y"))
    s.hinge("pin", s.ground, bar, to=(0, L / 2, 0), axis="z", coordinate="theta")
    t = np.linspace(0, 2, 21)
    return s, {"time": t, "theta": fb.simulate(s, 2, initial={"theta": 1}, times=t)["theta"]}


@pytest.mark.parametrize(
    ("unknown", "more", "message"),
    [
        ({"m": 1.2}, {}, "The measured motion does not depend on 'm': it cannot be found"),
        (
            {"L": 1.5},
            {"values": {"L": 2}},
            "'L' has a first guess in unknown= and a value in values=.",
        ),
        ({"theta": 1.1}, {}, "'theta' has a first guess in unknown= and a value in initial=."),
        (
            {"L": 1.5},
            {"sigma": 0.01},
            "Expected standard deviations by quantity, such as sigma={'theta': 0.01}, got 0.01",
        ),
        ({"L": 1.5}, {"bounds": [1, 2]}, "Expected bounds by name, such as {'L': (0, 1)}, got [1, 2]."),
        ({"L": 1.5}, {"bounds": {"L": 3}}, "Expected (least, greatest) as bounds of 'L', got 3."),
    ],
)
def test_refusals_of_what_was_given(unknown, more, message):
    s, data = free_pendulum()
    with pytest.raises(fb.errors.SimulationError) as caught:
        fb.fit(s, data, unknown, initial={"theta": 1}, **more)
    assert message in str(caught.value)


def test_complex_measurements_are_refused():
    s, data = free_pendulum()
    with pytest.raises(fb.errors.SimulationError) as caught:
        fb.fit(s, {**data, "theta": data["theta"] + 0j}, {"L": 1.5}, initial={"theta": 1})
    assert "Expected real numbers for the measured 'theta', got complex numbers." in str(caught.value)


def test_tables_of_pandas():
    """Times in a column or in the index; numbers that may be missing; several tables; other libraries' tables."""
    pandas = pytest.importorskip("pandas")
    clean = measured()
    guesses = {"I": 1.0}
    wanted = fb.fit(pendulum(), clean, guesses, initial={"theta": 0.8}).values
    table = pandas.DataFrame(clean)

    class Other:
        columns = ("time", "theta")

        def __getitem__(self, name):
            return list(clean[name])

    gaps = table.astype("Float64")
    gaps.loc[3, "theta"] = pandas.NA
    without = {name: np.delete(np.asarray(x), 3) for name, x in clean.items()}
    for data, same in (
        (table, wanted),
        (table.set_index("time"), wanted),
        (table.rename(columns={"time": "t"}), wanted),
        ([table, table], None),
        (Other(), wanted),
        (gaps, fb.fit(pendulum(), without, guesses, initial={"theta": 0.8}).values),
    ):
        found = fb.fit(pendulum(), data, guesses, initial={"theta": 0.8}).values
        assert found == (same or pytest.approx(wanted, rel=1e-9))


def test_tables_that_say_too_little():
    pandas = pytest.importorskip("pandas")
    table = pandas.DataFrame(measured())

    def refused(data, text):
        with pytest.raises(SimulationError, match=text):
            fb.fit(pendulum(), data, {"I": 1.0}, initial={"theta": 0.8})

    refused(table[["theta"]], "Expected 'time' among the measured data, got theta")
    refused(table.assign(note="x"), "note")
    refused(table.assign(theta="x"), "Expected arrays of numbers for the measured 'theta'")
    refused(
        pandas.concat([table, table["theta"]], axis=1),
        "measured values of 'theta', one for each time, got shape",
    )
    lasting = table.assign(time=pandas.to_timedelta(table["time"], unit="s"))
    refused(
        lasting,
        "Expected numbers for the measured 'time', got dates or durations. Compute seconds from the start",
    )
    refused(lasting.set_index("time"), "'time', got dates or durations")
    refused(table["theta"], "Expected measured data by name")


def test_a_fit_of_motions_with_contacts():
    """A block that is thrown, bounces and slides to rest: friction, restitution and height, within their errors."""

    def block():
        s = fb.System("block")
        s.parameters(mu=0.35, e=0.45)
        s.gravity = (0, -9.81, 0)
        body = s.body("block", fb.particle(2))
        s.chain("plane", s.ground, body, [fb.Slider("x", "x"), fb.Slider("y", "y")])
        s.contact("floor", body.origin, s.ground.plane(), friction="mu", restitution="e")
        return s

    true = {"mu": 0.3, "e": 0.5}
    s, t = block(), np.linspace(0, 1.5, 61)
    motion = fb.simulate(s, 1.5, initial={"x'": 2.0, "y": 0.3}, values=true, times=t)
    exact = {"time": t, "x": motion["x"], "y": motion["y"]}
    guesses, sigma = {"mu": 0.35, "e": 0.45, "y": 0.29}, {"x": 1e-4, "y": 1e-4}
    found = fb.fit(s, exact, guesses, initial={"x'": 2.0}, sigma=sigma)
    assert found.values == pytest.approx({**true, "y": 0.3}, abs=1e-7)
    rng = np.random.default_rng(0)
    noisy = {"time": t, **{name: exact[name] + 1e-4 * rng.normal(size=61) for name in ("x", "y")}}
    found = fb.fit(s, noisy, guesses, initial={"x'": 2.0}, sigma=sigma)
    for name, value in {**true, "y": 0.3}.items():
        assert abs(found.values[name] - value) < 4 * found.errors[name]


def test_a_fit_of_the_gains_of_a_controller_beside_friction():
    """A box on a rough floor that a sampled law moves: its derivatives, not differences, lead to the gains."""
    calls = []

    def law(t, x):
        calls.append(t)
        return x["kp"] * (0.3 - x["x"]) - x["kd"] * x["x'"]

    s = fb.System("box")
    s.parameters(kp=60.0, kd=6.0, mu=0.1, u=0.0)
    s.gravity = (0, -9.81, 0)
    box = s.body("box", fb.particle(2))
    s.chain("plane", s.ground, box, [fb.Slider("x", "x"), fb.Slider("y", "y")])
    s.contact("floor", box.origin, s.ground.plane(), friction="mu")
    s.force("push", box.origin, ("u", 0, 0))
    s.controller(law, 0.02, "u")
    true, t = {"kp": 75.0, "kd": 7.0, "mu": 0.13}, np.linspace(0.05, 0.55, 26)
    motion = fb.simulate(s, 0.55, values=true, times=t, tolerance=1e-11)
    calls.clear()
    found = fb.fit(s, {"time": t, "x": motion["x"]}, {"kp": 60.0, "kd": 6.0, "mu": 0.1}, tolerance=1e-11)
    assert found.values == pytest.approx(true, rel=1e-6)
    assert len(calls) % (2 * 28) == 0  # a motion and its derivatives for each point


def spun_disk():
    """A disk that spins, falls on a floor without rebound, and slips there."""
    s = fb.System("disk")
    s.parameters(mu=0.2)
    s.gravity = (0, -9.81, 0)
    disk = s.body("disk", fb.disk(1, 0.1))
    s.planar("air", s.ground, disk, coordinate="x y turn")
    s.contact("floor", disk.circle(0.1), s.ground.plane(), friction="mu")
    return s, {"turn'": -40.0}


def test_a_fit_may_begin_where_friction_does_not_act_yet():
    """From the first guess of its height the disk does not reach the floor."""
    s, start = spun_disk()
    t = np.linspace(0, 0.4, 41)
    truth = fb.simulate(s, 0.4, initial=start | {"y": 0.5}, times=t)
    data = {"time": t, "x": truth["x"], "y": truth["y"]}
    found = fb.fit(s, data, {"mu": 0.3, "y": 0.95}, initial=start, sigma={"x": 1e-3, "y": 1e-3})
    assert found.values == pytest.approx({"mu": 0.2, "y": 0.5}, rel=1e-6)
    assert found.misfit < 1e-3 and str(found).endswith(f"residuals: {found.misfit:.3g} sigma")
    message = (
        "The motion at mu = 0.3 does not depend on 'mu', as it does not on friction where contacts stick or stay open. "
        "Begin elsewhere, or give starts="
    )
    with pytest.raises(SimulationError, match=message):
        fb.fit(s, {"time": t, "y": truth["y"]}, {"mu": 0.3}, initial=start | {"y": 1.0})


def test_the_misfit_compares_residuals_with_the_errors_of_measurements():
    s, start = spun_disk()
    t = np.linspace(0, 0.4, 401)
    errors = np.random.default_rng(2).normal(0, 1e-3, t.size)
    x = fb.simulate(s, 0.4, initial=start | {"y": 0.4}, times=t)["x"] + errors
    for sigma, expected in ((1e-3, 1.0), (1e-4, 10.0)):
        found = fb.fit(s, {"time": t, "x": x}, {"mu": 0.25}, initial=start | {"y": 0.4}, sigma={"x": sigma})
        assert found.misfit == pytest.approx(expected, rel=3 / np.sqrt(2 * t.size))
