"""Every entry of the gallery: built, run, its answers against the closed forms, its pictures drawn."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.integrate import solve_ivp

import freebody as fb
from freebody import exact
from freebody.cli import command as program
from freebody.errors import ModelError, SimulationError
from freebody.gallery import Outcome, entries
from freebody.gallery.entry import TOLERANCE
from freebody.picture.plots import energy_residual, history, reaction
from freebody.picture.sphere import axis_path, polhode

GALLERY = entries()
NAMES = tuple(GALLERY)

# The error at the end of a run is a multiple of that of one step, which the tolerance bounds.
MOTION = 1000 * TOLERANCE
# Answers worked out from the equations alone lose a few digits of rounding.
ALGEBRA = 1e-13

_outcomes: dict[str, Outcome] = {}


def outcome(name: str) -> Outcome:
    if name not in _outcomes:
        _outcomes[name] = GALLERY[name].run()
    return _outcomes[name]


def values(answers: dict[str, tuple[Any, str]]) -> dict[str, Any]:
    return {name: value for name, (value, _) in answers.items()}


def close(actual: Any, expected: Any, tolerance: float) -> None:
    np.testing.assert_allclose(actual, expected, rtol=tolerance, atol=tolerance)


# -- all of them ----------------------------------------------------------------------------------------------


def test_names_and_aliases() -> None:
    aliases = {
        "sec-6-9": "gyroscope", "sec-6-8": "torque-free", "hinged-bar": "ex-6-2", "cart-and-bar": "ex-6-5",
        "prob-6-15": "double-pendulum", "bicycle": "whipple-bicycle", "crank-rocker": "four-bar", "gears": "two-gears",
    }  # fmt: skip
    assert set(NAMES) == {
        *aliases.values(),
        "tumbling-body",
        "rolling-disk",
        "slider-crank",
        "block-and-tackle",
    }
    assert len(GALLERY) == 12
    for alias, name in aliases.items():
        assert alias in GALLERY and GALLERY[alias] is GALLERY[name]
    assert "no-such-thing" not in GALLERY


@pytest.mark.parametrize("name", NAMES)
def test_description(name: str) -> None:
    """Each parameter has a default and says what it is, in which unit; the model assembles."""
    entry = GALLERY[name]
    assert entry.title and entry.asks and entry.until > 0
    system = entry.build()
    assert fb.assemble(system).n_u > 0
    for parameter in system.parameter_list:
        assert parameter.default is not None
        unit, about = system.about[parameter.name]
        assert unit and about


@pytest.mark.parametrize("name", NAMES)
def test_run_with_defaults(name: str) -> None:
    entry, found = GALLERY[name], outcome(name)
    assert found.trajectory.t[-1] == entry.until
    assert found.trajectory.status == "finished"
    assert found.trajectory.energy.relative_residual < MOTION
    assert found.equations.text() and found.equations.latex()
    for answer, (value, unit) in found.answers.items():
        assert isinstance(unit, str)
        assert isinstance(value, str) or np.all(np.isfinite(value)), answer
    json.dumps(values(found.answers))


@pytest.mark.parametrize("name", NAMES)
def test_every_parameter_counts(name: str) -> None:
    """Another value of any parameter changes an answer."""
    entry, before = GALLERY[name], values(outcome(name).answers)
    for parameter in entry.build().parameter_list:
        other = {parameter.name: 0.9 * parameter.default}
        after = values(entry.run(other).answers)
        assert after != before, f"{name}: {parameter.name} changes nothing"


@pytest.mark.parametrize("name", NAMES)
def test_length_and_tolerance_of_the_run(name: str) -> None:
    """A shorter, coarser run gives the same answers, as far as it is exact; answers do not end with the plot."""
    found = GALLERY[name].run({}, 0.05, 1e-8)
    assert found.trajectory.t[-1] == 0.05
    assert set(found.trajectory.tolerances) == {1e-8}
    fine = values(outcome(name).answers)
    for answer, value in values(found.answers).items():
        if not isinstance(value, str) and "change of" not in answer:
            close(value, fine[answer], 1e-5)


@pytest.mark.parametrize("name", NAMES)
def test_plots(name: str, tmp_path: Path) -> None:
    """Pictures are written and show something: many pixels that are not white."""
    from matplotlib.image import imread

    for file, draw in outcome(name).plots.items():
        draw(tmp_path / file)
        pixels = imread(tmp_path / file)
        assert pixels.shape[0] > 400 and pixels.shape[1] > 900
        marked = (pixels[..., :3] < 0.9).any(axis=-1)
        assert marked.mean() > 0.005, file
        assert not marked[[0, -1]].any() and not marked[:, [0, -1]].any(), f"{file} is cut off"


# -- each against the closed form -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    "changed",
    [{}, {"theta_0": math.radians(75), "Omega_zeta": 250.0, "t_1": 0.9}, {"m": 0.7, "R": 0.08, "L": 0.05, "g": 3.7}],
    ids=["defaults", "another release", "another top"],
)  # fmt: skip
def test_gyroscope(changed: dict[str, float]) -> None:
    found = GALLERY["gyroscope"].run(changed)
    p = found.trajectory.values
    I = exact.gyroscope_moments(p["m"], p["R"], p["L"])  # noqa: E741
    mgL = p["m"] * p["g"] * p["L"]
    answers = values(found.answers)
    close(answers["I_xi"], I[0], ALGEBRA)
    close(answers["I_zeta"], I[1], ALGEBRA)
    for angle in ("theta_0", "theta_low"):
        fast, slow = exact.steady_precession(*I, mgL, p[angle], p["Omega_zeta"])
        close(answers[f"fast steady psi' at {angle}"], fast, ALGEBRA)
        close(answers[f"slow steady psi' at {angle}"], slow, ALGEBRA)
    least = exact.least_spin(*I, mgL, p["theta_0"])
    close(answers["smallest spin with steady precession at theta_0"], least, ALGEBRA)
    close(answers["smallest spin of the upright top"], exact.sleeping_spin(*I, mgL), ALGEBRA)

    motion = exact.top_from_rest(*I, mgL, p["theta_0"], p["Omega_zeta"], p["t_1"])
    close(answers["largest theta after release"], motion.theta_max, MOTION)
    close(answers["nutation period"], motion.period, MOTION)
    close(answers["theta at t_1"], motion.theta, MOTION)
    close(answers["psi at t_1"], motion.psi, MOTION)
    close(answers["theta' at t_1"], motion.theta_rate, MOTION)
    close(answers["psi' at t_1"], motion.psi_rate, MOTION)


def test_gyroscope_below_the_smallest_spin() -> None:
    answers = values(GALLERY["gyroscope"].run({"Omega_zeta": 40.0}).answers)
    assert (
        answers["fast steady psi' at theta_0"]
        == answers["slow steady psi' at theta_0"]
        == "none: spin too small"
    )
    # below the horizontal any spin will do, none too: a conical pendulum, either way round
    assert isinstance(answers["slow steady psi' at theta_low"], float)
    still = values(GALLERY["gyroscope"].run({"Omega_zeta": 0.0}).answers)
    conical = math.sqrt(9.81 * 0.1 / (0.06**2 / 4 + 0.1**2) / 0.5)
    rates = sorted(still[f"{kind} steady psi' at theta_low"] for kind in ("fast", "slow"))
    close(rates, [-conical, conical], ALGEBRA)


def test_gyroscope_steady_rates_stay_steady() -> None:
    """Started with either rate, theta does not change."""
    system = GALLERY["gyroscope"].build()
    answers = values(outcome("gyroscope").answers)
    for kind in ("fast", "slow"):
        rate = answers[f"{kind} steady psi' at theta_0"]
        start = {"theta": "theta_0", "psi'": rate, "phi'": f"Omega_zeta - ({rate!r})*cos(theta_0)"}
        motion = fb.simulate(system, 1, initial=start, tolerance=1e-12)
        assert np.ptp(motion["theta"]) < 1e-10


@pytest.mark.parametrize("case", ["a", "b"])
def test_torque_free(case: str) -> None:
    p = outcome("torque-free").trajectory.values
    answers = values(outcome("torque-free").answers)
    I_1, I_3 = (p["I_1"], p["I_3"]) if case == "a" else (p["I_1b"], p["I_3b"])
    motion = exact.torque_free_symmetric(I_1, I_3, p["w_1"], p["w_3"], p["t_1"])
    close(answers[f"({case}) rate Omega of omega about axis 3 in the body"], motion.rate, ALGEBRA)
    close(answers[f"({case}) angle alpha between axis 3 and H"], motion.alpha, MOTION)
    close(answers[f"({case}) angle beta between axis 3 and omega"], motion.beta, MOTION)
    close(answers[f"({case}) precession rate of axis 3 about H"], motion.precession_rate, MOTION)
    close(answers[f"({case}) omega in body axes at t_1"], motion.omega, MOTION)
    close(answers[f"({case}) axis 3 in ground axes at t_1"], motion.attitude[:, 2], MOTION)


def test_wobble_of_the_earth() -> None:
    earth = exact.torque_free_symmetric(1.0, 1.0033, 0.0, 2 * math.pi)
    close(values(outcome("torque-free").answers)["(c) period of the wobble"], 2 * math.pi / earth.rate, 1e-12)


def test_hinged_bar() -> None:
    answers = list(values(outcome("ex-6-2").answers).values())
    bar = exact.hinged_bar(3.0, 1.5)
    # clockwise is positive there
    close(answers[:2], (-bar.alpha, bar.reaction_start), ALGEBRA)
    close(answers[2:], (-bar.omega_vertical, bar.reaction_vertical, bar.energy_vertical), MOTION)


def test_cart_and_bar() -> None:
    answers = values(outcome("ex-6-5").answers)

    def rates(t: float, y: np.ndarray) -> Any:
        motion = exact.cart_and_bar(*y)
        return [y[2], y[3], motion.x_acceleration, motion.theta_acceleration]

    solution = solve_ivp(rates, (0, 2), [0, 0, 0, 0], "DOP853", [1, 2], rtol=1e-12, atol=1e-13)
    for y, label in zip(solution.y.T, ("t_1", "t_2"), strict=True):
        close([answers[f"{name} at {label}"] for name in ("x", "theta", "x'", "theta'")], y, MOTION)
        forces = exact.cart_and_bar(*y)
        close([answers[f"hinge force F_{axis} on M at {label}"] for axis in "xy"], forces.hinge, 10 * MOTION)
        close(answers[f"ground force f on M (up +) at {label}"], forces.ground, 10 * MOTION)
    assert (
        answers["equation of x"] == "(M + m)*x'' + m*a*(theta''*cos(theta) - theta'^2*sin(theta)) + k*x = F"
    )


def test_double_pendulum() -> None:
    answers = values(outcome("double-pendulum").answers)

    def rates(t: float, y: np.ndarray) -> Any:
        return [y[2], y[3], *exact.double_pendulum(*y).accelerations]

    solution = solve_ivp(rates, (0, 2), [0.5, 1, 0, 0], "DOP853", [1, 2], rtol=1e-12, atol=1e-13)
    for y, label in zip(solution.y.T, ("t_1", "t_2"), strict=True):
        names = ("theta_1", "theta_2", "theta_1'", "theta_2'")
        close([answers[f"{name} at {label}"] for name in names], y, MOTION)
        forces = exact.double_pendulum(*y)
        for axis, support, joint in zip("xy", forces.support, forces.joint, strict=True):
            close(answers[f"force of the support on link 1, {axis}, at {label}"], support, 10 * MOTION)
            close(answers[f"force of link 1 on link 2, {axis}, at {label}"], joint, 10 * MOTION)
    low, high = exact.double_pendulum_frequencies()
    close(answers["lower frequency of small oscillation"], low, ALGEBRA)
    close(answers["higher frequency of small oscillation"], high, ALGEBRA)


@pytest.mark.parametrize(
    "changed", [{}, {"w_x": 6.0, "w_y": 0.5}, {"a": 0.05, "w_z": 3.0}], ids=["z", "x", "relabelled"]
)
def test_tumbling_body(changed: dict[str, float]) -> None:
    found = GALLERY["tumbling-body"].run(changed)
    p, answers = found.trajectory.values, values(found.answers)
    moments = np.array(answers["I_x, I_y, I_z"])
    edges = np.array([p["a"], p["b"], p["c"]]) ** 2
    close(moments, p["m"] / 12 * (edges.sum() - edges), ALGEBRA)
    w0 = np.array([p["w_x"], p["w_y"], p["w_z"]])
    close(answers["kinetic energy"], moments @ w0**2 / 2, ALGEBRA)
    close(answers["angular momentum"], np.linalg.norm(moments * w0), ALGEBRA)
    assert answers["largest change of the angular momentum vector, relative"] < MOTION
    period = answers["period of omega in the body"]
    at = exact.torque_free(moments, w0, np.array([p["t_1"], period]))
    # the linear growth of small deviations about the middle axis multiplies the error of a step
    close(answers["omega in body axes at t_1"], at[0], 100 * MOTION)
    close(at[1], w0, 100 * MOTION)
    circled = "xyz".index(answers["axis that omega circles in the body"])
    w = np.stack([found.trajectory[f"flight_w{axis}"] for axis in "xyz"])
    assert (np.sign(w[circled]) == np.sign(w0[circled])).all()


def test_a_steady_turn_has_no_period() -> None:
    answers = values(GALLERY["tumbling-body"].run({"w_x": 0.0, "w_y": 0.0, "w_z": 3.0}).answers)
    assert answers["period of omega in the body"] == "none: it turns steadily"


# -- messages -------------------------------------------------------------------------------------------------


def test_unknown_parameter() -> None:
    with pytest.raises(ModelError, match="Unknown parameter 'Omega'; did you mean 'Omega_zeta'"):
        GALLERY["gyroscope"].run({"Omega": 3.0})


def test_vertical_shaft() -> None:
    with pytest.raises(
        ModelError, match="Expected theta_0 between 0 and pi, got 0: there the shaft is vertical"
    ):
        GALLERY["gyroscope"].run({"theta_0": 0.0})


def test_negative_time() -> None:
    with pytest.raises(ModelError, match="Expected times of 0 s or later to answer for, got -1 s"):
        GALLERY["ex-6-5"].run({"t_2": -1.0})


def test_bar_that_does_not_swing() -> None:
    with pytest.raises(
        SimulationError, match="Expected 'vertical' of 'hinged_bar' to happen 1 times.*it does not"
    ):
        GALLERY["ex-6-2"].run({"g": 0.0})


def test_plot_messages() -> None:
    motion = outcome("gyroscope").trajectory
    with pytest.raises(SimulationError, match="Expected the body axis 'x', 'y' or 'z', got 'w'"):
        axis_path(motion, "rotor", axis="w")
    with pytest.raises(SimulationError, match="Unknown body 'roter'; did you mean 'rotor'"):
        axis_path(motion, "roter")
    with pytest.raises(SimulationError, match="Expected at least one name to plot, got none"):
        history(motion, [])
    with pytest.raises(SimulationError, match="Unknown joint 'pivott'; did you mean 'pivot'"):
        reaction(motion, "pivott")


# -- plots as functions ---------------------------------------------------------------------------------------


def test_history_of_several_units() -> None:
    motion = outcome("ex-6-5").trajectory
    panels = history(motion)
    assert [panel.get_ylabel() for panel in panels] == ["x [m]", "theta [rad]"]
    np.testing.assert_array_equal(panels[1].lines[0].get_ydata(), motion["theta"])
    assert panels[1].get_xlabel() == "time [s]"


def test_history_of_one_unit_marks_events() -> None:
    motion = outcome("gyroscope").trajectory
    panel = history(motion, ["theta'", "psi'"], title="Rates")
    assert panel.get_title(loc="left") == "Rates" and panel.get_ylabel() == "[rad/s]"
    labels = [text.get_text() for text in panel.get_legend().get_texts()]
    assert labels == ["theta'", "psi'", "smallest theta", "largest theta"]
    highest = [event for event in motion.events if event.name == "largest theta"]
    marks = next(line for line in panel.lines if len(line.get_xdata()) == len(highest))
    np.testing.assert_array_equal(marks.get_xdata(), [event.time for event in highest])
    assert len(history(motion, "theta", events=False).lines) == 1
    # a long run has too many to be told apart
    long = GALLERY["gyroscope"].run(until=8).trajectory
    assert len(long.events) > 100 and len(history(long, "theta").lines) == 1
    assert len(long.t) > 15 * len(long.events)


def test_history_of_an_expression() -> None:
    motion = outcome("gyroscope").trajectory
    panel = history(motion, "phi' + psi'*cos(theta)")
    np.testing.assert_allclose(panel.lines[0].get_ydata(), 300, rtol=1e-9)


def test_plots_draw_into_given_axes() -> None:
    from matplotlib.figure import Figure

    motion = outcome("ex-6-5").trajectory
    axes = Figure().subplots(3, 1)
    assert history(motion, ["x", "theta"], ax=axes[0]) is axes[0] and len(axes[0].lines) == 2
    assert reaction(motion, "pin", ax=axes[1], axes="y") is axes[1] and len(axes[1].lines) == 1
    assert energy_residual(motion, ax=axes[2]) is axes[2]


def test_axis_path_is_on_the_sphere() -> None:
    from mpl_toolkits.mplot3d.art3d import Line3DCollection

    motion = outcome("gyroscope").trajectory
    ax = axis_path(motion, "rotor")
    assert any("60° to 63.84° from the vertical Z" in text.get_text() for text in ax.texts)
    psi, theta = motion["psi"], motion["theta"]
    tip = np.stack([np.sin(theta) * np.sin(psi), -np.sin(theta) * np.cos(psi), np.cos(theta)], axis=-1)
    drawn = [c for c in ax.collections if isinstance(c, Line3DCollection) and c.get_linewidth()[0] == 2.2]
    points = np.concatenate([np.asarray(c._segments3d)[:, 0] for c in drawn if len(c._segments3d) > 1])
    assert len(points) == len(tip) - 1
    assert {tuple(p) for p in np.round(points, 9)} <= {tuple(p) for p in np.round(tip, 9)}


def test_polhode_is_drawn_on_the_energy_ellipsoid() -> None:
    from mpl_toolkits.mplot3d.art3d import Line3DCollection

    found = outcome("tumbling-body")
    moments = values(found.answers)["I_x, I_y, I_z"]
    ax = polhode(found.trajectory, ["flight_wx", "flight_wy", "flight_wz"], moments)
    lines = [collection for collection in ax.collections if isinstance(collection, Line3DCollection)]
    assert len(lines) > 20
    for collection in lines:
        points = np.asarray(collection._segments3d)[:, 0]
        np.testing.assert_allclose(points**2 @ moments / 2, 0.065457425, rtol=1e-6)


# -- from the command line ------------------------------------------------------------------------------------


def test_gyroscope_from_the_command_line(tmp_path: Path) -> None:
    folder = tmp_path / "out"
    arguments = ["run", "sec-6-9", "--set", "theta_0=75deg", "--until", "0.5", "-o", str(folder), "--json"]
    result = CliRunner().invoke(program, arguments)
    assert result.exit_code == 0, result.output
    report = json.loads(result.output)
    I = exact.gyroscope_moments(1.2, 0.06, 0.1)  # noqa: E741
    motion = exact.top_from_rest(*I, 1.2 * 9.81 * 0.1, math.radians(75), 300.0)
    close(report["answers"]["nutation period"]["value"], motion.period, MOTION)
    assert {file.name for file in folder.iterdir()} == {
        "equations.txt", "equations.tex", "trajectory.nc", "theta.png", "psi.png", "spin_axis.png", "energy.png",
    }  # fmt: skip
    data = fb.Trajectory.load(folder / "trajectory.nc")
    assert data["theta"].values[0] == pytest.approx(math.radians(75))


def test_gallery_from_the_command_line() -> None:
    result = CliRunner().invoke(program, ["gallery"])
    assert result.exit_code == 0
    for name, entry in GALLERY.items():
        assert name in result.output and entry.title in result.output
