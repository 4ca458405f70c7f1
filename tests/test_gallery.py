"""Every entry of the gallery: built, run, its answers against the closed forms, its pictures drawn."""

from __future__ import annotations

import json
import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy
from click.testing import CliRunner
from scipy.integrate import solve_ivp

import freebody as fb
from freebody import exact
from freebody.cli import command as program
from freebody.describe.description import about_of, parameters_of
from freebody.errors import FreebodyError, ModelError, SimulationError
from freebody.gallery import Gallery, Outcome, entries
from freebody.gallery.tools.answer import Answers, Check, same
from freebody.gallery.tools.case import TOLERANCE, Case
from freebody.picture.plots.plots import energy_residual, history, reaction
from freebody.picture.plots.sphere import axis_path, polhode
from freebody.scalar.element import is_zero
from freebody.symbolic.printing.closed.form import closed_form
from freebody.symbolic.printing.grouped import Grouped
from sampled import sampled

GALLERY = entries()
NAMES = tuple(GALLERY)

# Of answers worked out along the motion, relative to the larger of 1 and their size.
MOTION = 1e-9
# Answers worked out from the equations alone lose a few digits of rounding.
ALGEBRA = 1e-13

_outcomes: dict[str, Outcome] = {}


def outcome(name: str) -> Outcome:
    if name not in _outcomes:
        _outcomes[name] = GALLERY[name].run()
    return _outcomes[name]


def values(answers: Answers) -> dict[str, Any]:
    return {key: answer.value for key, answer in answers.items()}


def close(actual: Any, expected: Any, tolerance: float) -> None:
    np.testing.assert_allclose(actual, expected, rtol=tolerance, atol=tolerance)


# -- all of them ----------------------------------------------------------------------------------------------


def test_names_and_aliases() -> None:
    """Every system has a short name and is found by readable ones too; no name stands for two."""
    aliases = {
        "gyroscope": "sec-6-9", "torque-free": "sec-6-8", "hinged-bar": "ex-6-2", "cart-and-bar": "ex-6-5",
        "double-pendulum": "prob-6-15", "bicycle": "whipple-bicycle", "crank-rocker": "four-bar", "gears": "two-gears",
    }  # fmt: skip
    for alias, name in aliases.items():
        assert alias in GALLERY and GALLERY[alias] is GALLERY[name] and name in NAMES
    listed = [name for entry in GALLERY.values() for name in (entry.name, *entry.aliases)]
    assert len(set(listed)) == len(listed) and set(GALLERY.names) == set(listed)
    assert all(re.fullmatch("[a-z][a-z0-9]*(-[a-z0-9]+)*", name) for name in listed)
    assert "no-such-thing" not in GALLERY


def test_order_is_that_of_the_chapter() -> None:
    """Examples, sections, problems, each in the order of their numbers, then what is beyond the chapter."""
    kinds = ("ex", "sec", "prob")
    chapter = [name for name in NAMES if name.split("-")[0] in kinds]
    assert list(NAMES[: len(chapter)]) == chapter
    parts = [name.split("-") for name in chapter]
    order = [(kinds.index(kind), int(major), int(minor)) for kind, major, minor in parts]
    assert order == sorted(order)


@pytest.mark.parametrize("name", NAMES)
def test_description(name: str) -> None:
    """Each parameter has a default and says what it is, in which unit; the model assembles."""
    entry = GALLERY[name]
    assert entry.title and entry.asks and entry.until > 0
    system = entry.build()
    assert fb.assemble(system).n_u > 0
    for parameter in parameters_of(system):
        assert parameter.default is not None
        unit, about = about_of(system)[parameter.name]
        assert unit and about


@pytest.mark.parametrize("name", sampled(NAMES, 6))
def test_run_with_defaults(name: str) -> None:
    entry, found = GALLERY[name], outcome(name)
    assert found.trajectory.t[-1] == entry.until
    assert found.trajectory.status == "finished"
    assert found.trajectory.energy.relative_residual < 1000 * TOLERANCE
    assert found.equations.text() and found.equations.latex()
    for key, answer in found.answers.items():
        assert answer.question and len(key) <= 24 and " " not in key, key
        assert isinstance(answer.value, str) or (
            np.all(np.isfinite(answer.value)) and answer.unit is not None
        ), key
        assert answer.formula is None or (answer.text and answer.latex and answer.how), key
    json.dumps(values(found.answers))
    for check in found.checks:
        assert check.holds, check


@pytest.mark.parametrize("name", sampled(NAMES, 3))
def test_formulas_speak_of_the_parameters(name: str) -> None:
    """A closed form holds parameters of the system, and its coordinates and speeds, and nothing else."""
    found = outcome(name)
    known = set(found.values)
    for key, answer in found.answers.items():
        if answer.formula is not None:
            left = {symbol.name for symbol in answer.formula.free_symbols} - known - {"t"} - set(answer.where)
            assert not left, (key, left)


IDLE = (("prob-6-5", "h"), ("jeffcott-rotor", "R"))
"""Drawn only: bar and disk move in planes, about the hinge line and about the shaft."""


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_every_parameter_counts(name: str) -> None:
    """Another value of any parameter changes an answer, or the motion or a reaction on the way."""
    entry, before = GALLERY[name], outcome(name)
    for parameter in parameters_of(entry.build()):
        if (name, parameter.name) in IDLE:
            continue
        after = nearby(entry, parameter)
        assert list(after.answers) == list(before.answers)
        assert values(after.answers) != values(before.answers) or not same_motion(after, before), (
            f"{name}: {parameter.name} changes nothing"
        )


def nearby(entry: Any, parameter: Any) -> Outcome:
    """The outcome at a value that is less or, where that is refused, greater."""
    for factor in (0.9, 0.98, 1.1):
        try:
            return entry.run({parameter.name: factor * parameter.default if parameter.default else 0.1})
        except FreebodyError as error:
            refused = error
    raise refused


def same_motion(a: Outcome, b: Outcome) -> bool:
    """Whether times, states and reactions are the same to the last bit."""
    one, other = a.trajectory, b.trajectory
    return (
        np.array_equal(one.t, other.t)
        and np.array_equal(one.states, other.states)
        and all(np.array_equal(one.reactions[k].force, other.reactions[k].force) for k in one.reactions)
    )


@pytest.mark.parametrize("name", sampled(NAMES, 6, ("whipple-bicycle",)))
def test_length_and_tolerance_of_the_run(name: str) -> None:
    """A shorter, coarser run gives the same answers, as far as it is exact; answers do not end with the plot."""
    found = GALLERY[name].run({}, 0.05, 1e-8)
    assert found.trajectory.t[-1] == 0.05
    assert set(found.trajectory.tolerances) == {1e-8}
    fine = values(outcome(name).answers)
    for answer, value in values(found.answers).items():
        if not isinstance(value, str) and answer != "H_change":
            close(value, fine[answer], 1e-5)


@pytest.mark.parametrize("name", sampled(NAMES, 6, ("whipple-bicycle",)))
def test_plots(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures are written and show something: many pixels that are not white. In half the width and height."""
    from matplotlib.figure import Figure
    from matplotlib.image import imread

    save = Figure.savefig
    monkeypatch.setattr(
        Figure, "savefig", lambda self, path, *, dpi, **how: save(self, path, dpi=dpi / 2, **how)
    )
    for file, draw in outcome(name).plots.items():
        draw(tmp_path / file)
        pixels = imread(tmp_path / file)
        assert pixels.shape[0] > 200 and pixels.shape[1] > 450
        marked = (pixels[..., :3] < 0.9).any(axis=-1)
        assert marked.mean() > 0.005, file
        assert not marked[[0, -1]].any() and not marked[:, [0, -1]].any(), f"{file} is cut off"


# -- each against the closed form -----------------------------------------------------------------------------


def test_gyroscope_below_the_smallest_spin() -> None:
    answers = values(GALLERY["gyroscope"].run({"Omega_zeta": 40.0}).answers)
    assert answers["psi'_fast"] == answers["psi'_slow"] == "none: spin too small"
    # below the horizontal any spin will do, none too: a conical pendulum, either way round
    assert isinstance(answers["psi'_slow(theta_low)"], float)
    still = values(GALLERY["gyroscope"].run({"Omega_zeta": 0.0}).answers)
    conical = math.sqrt(9.81 * 0.1 / (0.06**2 / 4 + 0.1**2) / 0.5)
    rates = sorted(still[f"psi'_{kind}(theta_low)"] for kind in ("fast", "slow"))
    close(rates, [-conical, conical], ALGEBRA)


def test_gyroscope_steady_rates_stay_steady() -> None:
    """Started with either rate, theta does not change."""
    system = GALLERY["gyroscope"].build()
    answers = values(outcome("gyroscope").answers)
    for kind in ("fast", "slow"):
        rate = answers[f"psi'_{kind}"]
        start = {"theta": "theta_0", "psi'": rate, "phi'": f"Omega_zeta - ({rate!r})*cos(theta_0)"}
        motion = fb.simulate(system, 1, initial=start, tolerance=1e-12)
        assert np.ptp(motion["theta"]) < 1e-10


def test_double_pendulum() -> None:
    answers = values(outcome("double-pendulum").answers)

    def rates(t: float, y: np.ndarray) -> Any:
        return [y[2], y[3], *exact.double_pendulum(*y).accelerations]

    solution = solve_ivp(rates, (0, 2), [0.5, 1, 0, 0], "DOP853", [1, 2], rtol=1e-12, atol=1e-13)
    for y, label in zip(solution.y.T, ("t_1", "t_2"), strict=True):
        names = ("theta_1", "theta_2", "theta_1'", "theta_2'")
        close([answers[f"{name}({label})"] for name in names], y, MOTION)
        forces = exact.double_pendulum(*y)
        for axis, support, joint in zip("xy", forces.support, forces.joint, strict=True):
            close(answers[f"O_{axis}({label})"], support, MOTION)
            close(answers[f"J_{axis}({label})"], joint, MOTION)
    low, high = exact.double_pendulum_frequencies()
    close(answers["omega_1"], low, ALGEBRA)
    close(answers["omega_2"], high, ALGEBRA)


@pytest.mark.parametrize(
    "changed", [{}, {"w_x": 6.0, "w_y": 0.5}, {"a": 0.05, "w_z": 3.0}], ids=["z", "x", "relabelled"]
)
def test_tumbling_body(changed: dict[str, float]) -> None:
    found = GALLERY["tumbling-body"].run(changed)
    p, answers = found.trajectory.values, values(found.answers)
    moments = np.array(answers["I"])
    edges = np.array([p["a"], p["b"], p["c"]]) ** 2
    close(moments, p["m"] / 12 * (edges.sum() - edges), ALGEBRA)
    w0 = np.array([p["w_x"], p["w_y"], p["w_z"]])
    close(answers["T"], moments @ w0**2 / 2, ALGEBRA)
    close(answers["H"], np.linalg.norm(moments * w0), ALGEBRA)
    assert answers["H_change"] < MOTION
    assert all(check.holds for check in found.checks)
    period = answers["period"]
    at = exact.torque_free(moments, w0, np.array([p["t_1"], period]))
    close(answers["omega(t_1)"], at[0], MOTION)
    close(at[1], w0, MOTION)
    motion = exact.torque_free(moments, w0)
    assert motion.period == pytest.approx(period, rel=MOTION)
    close(2 * answers["flip"], period, MOTION)
    middle = int(np.argsort(moments)[1])
    close(answers["axis(t_1)"], motion.attitude(p["t_1"])[:, middle], MOTION)
    circled = "xyz".index(answers["axis"])
    w = np.stack([found.trajectory[f"flight_w{axis}"] for axis in "xyz"])
    assert (np.sign(w[circled]) == np.sign(w0[circled])).all()


def test_a_steady_turn_has_no_period() -> None:
    answers = values(GALLERY["tumbling-body"].run({"w_x": 0.0, "w_y": 0.0, "w_z": 3.0}).answers)
    assert answers["period"] == "none: it turns steadily"


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_nonsense_is_refused(name: str) -> None:
    """Each parameter with the other sign: answers that pass the checks, or an error that says what is wrong."""
    entry = GALLERY[name]
    for parameter in parameters_of(entry.build()):
        try:
            found = entry.run({parameter.name: -parameter.default if parameter.default else -1.0})
        except FreebodyError as error:
            assert re.search("[Ee]xpected|not", str(error)), error
        else:
            assert all(check.holds for check in found.checks), (parameter.name, found.checks)


@pytest.mark.parametrize(
    ("name", "changed", "message"),
    [
        ("ex-6-2", {"L": -1.0}, "Expected L > 0 in 'hinged_bar', as .*but L = -1 makes it -1"),
        ("ex-6-1", {"g": -9.81}, "Expected g greater than 0, got g = -9.81"),
        ("ex-6-5", {"k": -50.0}, "Expected a stiffness of at least 0, got k = -50"),
        ("whipple-bicycle", {"r_R": 0.0}, "Expected r_R greater than 0, got r_R = 0"),
        ("turntable", {"v_0": 0.0}, "Expected a ball that moves on the ground, got v_0 = 0"),
        ("tippe-top", {"spin": 0.0}, "Expected a spin, got spin = 0"),
        ("rattleback", {"t_1": -8.0}, "Expected t_1 greater than 0, got t_1 = -8"),
        (
            "gyroscope",
            {"theta_0": "60 kg"},
            "Expected parameter 'theta_0' in rad or a unit of its kind, got '60 kg'",
        ),
    ],
)
def test_values_without_answers(name: str, changed: dict[str, Any], message: str) -> None:
    with pytest.raises(FreebodyError, match=message):
        GALLERY[name].run(changed)


def test_no_spin_is_needed_at_90_degrees() -> None:
    """A right angle given as a double has the cosine 0."""
    for right in ("90deg", math.pi / 2):
        assert GALLERY["gyroscope"].run({"theta_0": right}).answers["Omega_min"].value == 0


# -- messages -------------------------------------------------------------------------------------------------


def test_unknown_parameter() -> None:
    with pytest.raises(ModelError, match="Unknown parameter 'Omega'; did you mean 'Omega_zeta'"):
        GALLERY["gyroscope"].run({"Omega": 3.0})


def test_no_finite_value() -> None:
    with pytest.raises(
        ModelError, match="Expected L > 0 in 'tilted_disk', .*but L = 0 makes it 0. Change the values"
    ):
        GALLERY["sec-6-6"].run({"L": 0.0})
    system = GALLERY["sec-6-6"].build()
    case = Case(system, {"L": 0.0}, 1.0, 1e-9, fb.equations(system))
    with pytest.raises(
        ModelError, match="of 'tilted_disk' at which '1/L' is a finite number.*what is zero: L"
    ):
        case.number(1 / system.expression("L"))


def test_motorcycle_at_rest() -> None:
    with pytest.raises(ModelError, match="Expected a speed greater than 0, got v = 0"):
        GALLERY["motorcycle"].run({"v": 0.0})


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
    assert [panel.get_ylabel() for panel in panels] == ["$x$ [m]", r"$\theta$ [rad]"]
    np.testing.assert_array_equal(panels[1].lines[0].get_ydata(), motion["theta"])
    assert panels[1].get_xlabel() == "time [s]"


def test_history_of_one_unit_marks_events() -> None:
    motion = outcome("gyroscope").trajectory
    panel = history(motion, ["theta'", "psi'"], title="Rates")
    assert panel.get_title(loc="left") == "Rates" and panel.get_ylabel() == "[rad/s]"
    labels = [text.get_text() for text in panel.get_legend().get_texts()]
    assert labels == [r"$\dot{\theta}$", r"$\dot{\psi}$", r"smallest $\theta$, largest $\theta$"]
    marks = next(line for line in panel.lines if len(line.get_xdata()) == len(motion.events))
    np.testing.assert_array_equal(marks.get_xdata(), [event.time for event in motion.events])
    assert len(history(motion, "theta", events=False).lines) == 1
    # a long run has too many to be told apart: they are ticks on the axis of time
    long = GALLERY["gyroscope"].run(until=8).trajectory
    assert len(long.events) > 100 and len(history(long, "theta").lines) == 2
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
    moments = values(found.answers)["I"]
    ax = polhode(found.trajectory, ["flight_wx", "flight_wy", "flight_wz"], moments)
    lines = [collection for collection in ax.collections if isinstance(collection, Line3DCollection)]
    assert len(lines) > 20
    for collection in lines:
        points = np.asarray(collection._segments3d)[:, 0]
        np.testing.assert_allclose(points**2 @ moments / 2, 0.065457425, rtol=1e-6)


# -- from the command line ------------------------------------------------------------------------------------


@pytest.mark.slow  # test_cli has it, too
def test_gyroscope_from_the_command_line(tmp_path: Path) -> None:
    folder = tmp_path / "out"
    arguments = ["run", "sec-6-9", "--set", "theta_0=75deg", "--until", "0.5", "-o", str(folder), "--json"]
    result = CliRunner().invoke(program, arguments)
    assert result.exit_code == 0, result.output
    report = json.loads(result.output)
    I = exact.gyroscope_moments(1.2, 0.06, 0.1)  # noqa: E741
    motion = exact.top_from_rest(*I, 1.2 * 9.81 * 0.1, math.radians(75), 300.0)
    close(report["answers"]["period"]["value"], motion.period, MOTION)
    assert {file.name for file in folder.iterdir()} == {
        "equations.txt", "equations.tex", "trajectory.nc", "theta.png", "psi.png", "spin_axis.png", "energy.png",
        "drawing.svg", "free_body_rotor.svg",
    }  # fmt: skip
    trajectory = fb.Trajectory.load(folder / "trajectory.nc")
    assert trajectory["theta"][0] == pytest.approx(math.radians(75))


def test_gallery_from_the_command_line() -> None:
    result = CliRunner().invoke(program, ["gallery"])
    assert result.exit_code == 0
    for name, entry in GALLERY.items():
        assert name in result.output and entry.title in result.output
        assert all(alias in result.output for alias in entry.aliases)


def test_data_of_a_run() -> None:
    """``--json``: answers by short keys in the order in which they are asked, with value, unit, formula, question."""
    result = CliRunner().invoke(program, ["run", "hinged-bar", "--set", "L=3", "--json"])
    assert result.exit_code == 0, result.output
    report = json.loads(result.output)
    assert report["name"] == "ex-6-2" and report["aliases"] == ["hinged-bar"]
    assert report["parameters"]["L"] == {"value": 3.0, "unit": "m", "about": "length of the bar"}
    assert list(report["answers"]) == ["alpha", "R_1", "omega_2", "R_2", "T_2"] == list(report["values"])
    alpha = report["answers"]["alpha"]
    assert alpha["value"] == report["values"]["alpha"] == pytest.approx(-9.81 / 2, rel=1e-15)
    assert (alpha["unit"], alpha["formula"]) == ("rad/s²", "-3*g/(2*L)")
    assert alpha["latex"] and alpha["question"].startswith("angular acceleration") and "solve" in alpha["how"]
    assert {event["name"] for event in report["events"]} == {"vertical"}
    assert report["checks"] and all(check["holds"] for check in report["checks"])
    assert "pin_y - m*g = " in report["equations"]["free_bodies"]["bar"]
    assert report["equations"]["motion"] == ["m*L^2*theta''/9 + m*L*g*cos(theta)/6 = 0"]


CHAPTER = ("ex-", "sec-", "prob-")


def lengths(name: str) -> dict[str, tuple[int, int]]:
    """Operations of each formula as printed, and of the shortest of SymPy's rewritings."""
    benchmark = pytest.importorskip("benchmarks.formulas", reason="benchmarks are not in the package")
    shortest = json.loads(benchmark.STORE.read_text(encoding="utf-8"))
    formulas = {key: answer for key, answer in outcome(name).answers.items() if answer.formula is not None}
    return {
        key: (benchmark.operations(answer.text), shortest[f"{name} {key}"])
        for key, answer in formulas.items()
    }


def agree(one: Any, other: Any) -> bool:
    """Whether two formulas have the same values at random numbers, to 40 digits."""
    draw = np.random.default_rng(1).uniform
    moving = (one - other).atoms(sympy.Derivative, sympy.core.function.AppliedUndef)
    atoms = sorted(moving, key=lambda a: (not a.is_Derivative, str(a)))
    names = {a: sympy.Symbol(f"x{i}") for i, a in enumerate(atoms)}
    for a, name in names.items():
        one, other = one.xreplace({a: name}), other.xreplace({a: name})
    for _ in range(5):
        at = {
            a: sympy.Rational(int(draw(300, 1500)), 1000) for a in sorted((one - other).free_symbols, key=str)
        }
        if abs(sympy.N((one - other).xreplace(at), 40)) > 1e-30:
            return False
    return True


@pytest.mark.parametrize("name", sampled(NAMES, 2))
def test_formulas_are_printed_short_and_are_the_formulas(name: str) -> None:
    """No formula has more operations than SymPy's shortest rewriting; what is printed equals the formula exactly."""
    assert {key: n for key, n in lengths(name).items() if n[0] > n[1]} == {}
    ring = outcome(name).equations.ring
    for key, answer in outcome(name).answers.items():
        if isinstance(answer.formula, sympy.Expr):
            form = closed_form(ring.from_sympy(answer.formula), ring)
            if form is not None:
                tree, inside = form
                shown = Grouped(inside).sum(tree)
                exact = is_zero(inside.from_sympy(shown) - inside.from_sympy(answer.formula))
                # sqrt(sin(x)^2 y) is |sin(x)| sqrt(y), but the ring knows no such relation
                assert exact or agree(shown, answer.formula), key


@pytest.mark.slow
def test_the_formulas_of_the_chapter_are_shorter_than_sympys() -> None:
    pairs = [n for name in NAMES if name.startswith(CHAPTER) for n in lengths(name).values()]
    assert len(pairs) > 160
    assert sum(ours for ours, _ in pairs) < 0.9 * sum(theirs for _, theirs in pairs)


def test_what_a_run_prints() -> None:
    """Question, free-body equations, answers as number and formula, events, checks, in this order."""
    result = CliRunner().invoke(program, ["run", "ex-6-2"])
    places = [
        result.output.index(text)
        for text in (
            "just after release: angular acceleration", "Free body 'bar'", "-9.81", "alpha = -3*g/(2*L)",
            "Events:\n  t = 0.59196", "Checks\n  omega_2 against the simulation: agrees to",
        )
    ]  # fmt: skip
    assert places == sorted(places)


def test_a_check_that_does_not_hold_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    entry = GALLERY["ex-6-2"]

    def wrong(case: Any) -> Any:
        return replace(
            entry.solve(case), checks=(same("two and three", 2, 3, 1e-9), Check("nothing", math.nan, 1))
        )

    listed = Gallery(replace(entry, solve=wrong))
    monkeypatch.setattr("freebody.gallery.entries", lambda: listed)
    result = CliRunner().invoke(program, ["run", "ex-6-2"])
    assert result.exit_code == 1
    assert "two and three: DIFFERS by 3.3e-01 (1e-09 allowed)" in result.output
    assert "Checks that do not hold: two and three; nothing." in result.output


def test_the_page_prints_what_it_says(capsys: pytest.CaptureFixture[str]) -> None:
    """Every block of docs/gallery.md runs, in order, and prints the block of text below it."""
    page = (Path(__file__).parents[1] / "docs" / "gallery.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```\n(?:\n```text\n(.*?)```\n)?", page, re.DOTALL)
    assert len(blocks) == page.count("```python") == page.count("```text") == 3
    names: dict[str, object] = {}
    for code, printed in blocks:
        exec(compile(code, "docs/gallery.md", "exec"), names)
        assert capsys.readouterr().out == printed, code


def test_the_commands_of_the_page_run() -> None:
    page = (Path(__file__).parents[1] / "docs" / "gallery.md").read_text(encoding="utf-8")
    (block,) = re.findall(r"```sh\n(.*?)```", page, re.DOTALL)
    for line in block.splitlines():
        words = line.split("#")[0].split()
        assert words[0] == "freebody"
        if "-o" not in words:
            result = CliRunner().invoke(program, words[1:])
            assert result.exit_code == 0, (line, result.output)
