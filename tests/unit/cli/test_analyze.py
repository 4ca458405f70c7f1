"""``freebody analyze``: what it finds, prints and writes, and the sentence for what a machine does not have."""

from __future__ import annotations

import json
import math
import time
from pathlib import Path

import numpy as np
import pytest

import freebody as fb
from freebody.cli import main
from freebody.errors import ModelError
from freebody.gallery import entries
from freebody.studies.analysis.analysis import analysis
from freebody.studies.analysis.deadline import OutOfTimeError, within
from freebody.studies.analysis.section import plain_latex
from sampled import sampled

OSCILLATOR = """\
name = "oscillator"

[parameters]
m = 2.0
k = 8.0
c = 0.0
F = 0.0

[bodies.block]
solid = "particle"
mass = "m"

[joints.guide]
type = "slider"
child = "block"
axis = "x"
coordinate = "x"

[springs.spring]
joint = "guide"
stiffness = "k"

[dampers.damper]
joint = "guide"
damping = "c"

[forces.push]
at = {body = "block"}
components = ["F", 0, 0]
"""


class Result:
    def __init__(self, code: object, out: str, err: str) -> None:
        self.code, self.out, self.err = code, out, err

    @property
    def data(self) -> dict:  # type: ignore[type-arg]
        return json.loads(self.out)


@pytest.fixture
def freebody(capsys: pytest.CaptureFixture[str]):  # type: ignore[no-untyped-def]
    def call(*arguments: object) -> Result:
        with pytest.raises(SystemExit) as caught:
            main([str(argument) for argument in arguments])
        captured = capsys.readouterr()
        assert "Traceback" not in captured.err + captured.out
        return Result(caught.value.code, captured.out, captured.err)

    return call


@pytest.fixture
def oscillator(tmp_path: Path) -> str:
    path = tmp_path / "oscillator.toml"
    path.write_text(OSCILLATOR)
    return str(path)


# --- what it finds ---


def test_an_oscillator_from_a_file(freebody, oscillator: str) -> None:  # type: ignore[no-untyped-def]
    result = freebody("analyze", oscillator)
    assert result.code == 0
    for line in (
        "m*x'' + c*x' + k*x = F",
        "0 = k*x - F",
        "x = F/k",
        "natural frequencies in closed form: sqrt(k/m)",
        "2*x'' + 8*x = 0",
        "Add -o DIR to keep this as text, LaTeX and JSON.",
    ):
        assert line in result.out, result.out
    assert "None are known" in result.out  # a damper: c = 0 is a value, not a fact about the machine
    data = freebody("analyze", oscillator, "--json").data
    assert data["linear_model"]["about"] == {"x": 0, "x'": 0}
    assert (data["linear_model"]["M"], data["linear_model"]["K"]) == ([[2]], [[8]])
    (mode,) = data["modes"]
    assert (mode["kind"], mode["damping_ratio"], mode["shape"]) == ("oscillation", 0, {"x": 1})
    assert [mode["frequency"], *mode["eigenvalue"]] == pytest.approx([2, 0, 2], rel=1e-15)


def test_values_move_the_answers(freebody, oscillator: str) -> None:  # type: ignore[no-untyped-def]
    data = freebody("analyze", oscillator, "--set", "F=4", "--set", "c=4", "--json").data
    assert data["values"] == {"m": 2, "k": 8, "c": 4, "F": 4}
    assert data["linear_model"]["about"]["x"] == 0.5
    (state,) = data["steady_motions"]["states"]
    assert state["stability"] == "asymptotically stable"
    # s² + 2 s + 4: |s| = 2, damping ratio 1/2
    assert data["modes"][0]["frequency"] == pytest.approx(2, rel=1e-14)
    assert data["modes"][0]["damping_ratio"] == pytest.approx(0.5, rel=1e-14)


def test_the_double_pendulum(freebody) -> None:  # type: ignore[no-untyped-def]
    data = freebody("analyze", "double-pendulum", "--json").data
    assert [one["name"] for one in data["integrals"]] == ["energy"]
    assert data["integrals"][0]["proof"].startswith("d(energy)/dt = theta_1'*(equation of theta_1')")
    states = data["steady_motions"]["states"]
    assert [one["stability"] for one in states] == ["stable", "unstable", "unstable", "unstable"]
    answers = entries()["double-pendulum"].run().answers
    found = sorted(mode["frequency"] for mode in data["modes"])
    expected = [
        value
        for answer in answers.values()
        if "frequenc" in answer.question
        for value in np.ravel(answer.value)
    ]
    assert found == pytest.approx(sorted(expected), rel=1e-12)
    assert data["notes"]["linear_model"] == ["About the state in which all is zero."]


def test_the_first_stable_equilibrium_is_taken(freebody) -> None:  # type: ignore[no-untyped-def]
    data = freebody("analyze", "ex-6-2", "--json").data
    assert [one["stability"] for one in data["steady_motions"]["states"]] == ["stable", "unstable"]
    assert data["linear_model"]["about"]["theta"] == pytest.approx(-math.pi / 2, rel=1e-15)
    # I_A w² = m g L/6 with I_A = m L²/9
    assert data["modes"][0]["frequency"] == pytest.approx(math.sqrt(1.5 * 9.81 / 1.5), rel=1e-14)
    assert [one["stable_if"] for one in data["steady_motions"]["motions"]] == [["-g > 0"], ["g > 0"]]


def test_the_gyroscope_precesses_at_its_release_angle(freebody) -> None:  # type: ignore[no-untyped-def]
    data = freebody("analyze", "gyroscope", "--json").data
    assert [one["name"] for one in data["integrals"]] == ["energy", "momentum of psi", "momentum of phi"]
    motions = data["steady_motions"]["motions"]
    assert [one["name"] for one in motions[:2]] == ["fast", "slow"]
    assert motions[0]["exists_if"] == ["R^4*phi'^2 + 4*(R^2 - 4*L^2)*L*g*cos(theta) >= 0"]
    assert motions[2]["singular"]
    fast = motions[0]
    assert fast["stable_if"] == [fast["stable_by_energy_if"]] and fast["stable_if"][0].startswith(
        "R^4*((R^4 + "
    )
    note, *_ = data["notes"]["steady_motions"]
    assert "phi' = 300, theta = 1.0472, which the conditions leave free" in note
    about = data["linear_model"]["about"]
    # (6.98) with phi' given: (I - I_0) cos(theta) w² + I phi' w - m g L = 0
    spin, I_0 = 1.2 * 0.06**2 / 2, 1.2 * (0.06**2 / 4 + 0.1**2)
    w = about["psi'"]
    assert (spin - I_0) * math.cos(about["theta"]) * w**2 + spin * 300 * w == pytest.approx(
        1.2 * 9.81 * 0.1, rel=1e-12
    )
    kinds = [mode["kind"] for mode in data["modes"]]
    assert kinds == ["rigid body", "rigid body", "drift", "drift", "oscillation"]


def test_the_bicycle_at_a_speed(freebody) -> None:  # type: ignore[no-untyped-def]
    """Meijaard et al. (2007), table 2, v = 5 m/s, to the digits printed."""
    data = freebody("analyze", "whipple-bicycle", "--about", "air_vx=5", "--patience", "0.5", "--json").data
    roots = [mode["eigenvalue"] for mode in data["modes"] if mode["kind"] not in ("rigid body", "drift")]
    expected = [[-0.32286642900409, 0], [-0.77534188219585, 4.46486771378823], [-14.07838969279822, 0]]
    assert np.allclose(roots, expected, rtol=0, atol=1e-11)
    assert data["linear_model"]["about"]["theta_R'"] == pytest.approx(-5 / 0.3, rel=1e-14)


LONG = ("prob-6-7", "sec-6-10", "sec-6-9", "turning-car")


@pytest.mark.parametrize(
    "name",
    [
        *sampled([name for name in entries() if name not in (*LONG, "whipple-bicycle")], 4),
        *(pytest.param(name, marks=pytest.mark.slow) for name in LONG),
    ],
)
def test_every_system_of_the_gallery(name: str, freebody) -> None:  # type: ignore[no-untyped-def]
    result = freebody("analyze", name)
    assert result.code == 0 and not result.err
    titles = [
        "Equations of motion", "Conserved quantities", "Steady motions", "Linear model", "Modes",
    ]  # fmt: skip
    lines = result.out.splitlines()
    places = [lines.index(title) for title in titles]
    assert places == sorted(places)
    for place in places:  # something is said under every heading
        assert lines[place + 2].strip()


# --- where to linearise ---


def test_about_a_given_state(freebody) -> None:  # type: ignore[no-untyped-def]
    data = freebody("analyze", "ex-6-2", "--about", "theta=90deg", "--json").data
    assert data["linear_model"]["about"]["theta"] == pytest.approx(math.pi / 2)
    assert [mode["kind"] for mode in data["modes"]] == ["decay", "growth"]
    assert data["modes"][1]["eigenvalue"][0] == pytest.approx(math.sqrt(9.81), rel=1e-12)


def test_about_a_part_of_a_steady_motion(freebody) -> None:  # type: ignore[no-untyped-def]
    data = freebody("analyze", "gyroscope", "--about", "theta=75deg", "--about", "phi'=200", "--json").data
    about = data["linear_model"]["about"]
    assert (about["theta"], about["phi'"]) == pytest.approx((math.radians(75), 200))
    assert {one["name"] for one in data["steady_motions"]["states"]} == {"slow", "fast"}
    assert about["psi'"] == pytest.approx(
        min(one["values"]["psi'"] for one in data["steady_motions"]["states"])
    )
    assert "The steady motion gives the values that --about does not." in data["notes"]["linear_model"]


# --- what does not exist ---


def test_no_equilibrium_says_the_residual_and_goes_on(freebody) -> None:  # type: ignore[no-untyped-def]
    result = freebody("analyze", "ex-6-2", "--about", "theta=0")
    assert result.code == 0
    assert "without accelerations the equations of motion leave theta: 7.3575 in place of 0" in result.out
    assert "No modes without a linear model." in result.out


def test_no_steady_motion_goes_on(freebody) -> None:  # type: ignore[no-untyped-def]
    result = freebody("analyze", "two-gears")
    assert result.code == 0
    assert "'two_gears' has no steady motion: it would need r_1*Q - r_2*T = 0." in result.out
    assert "No modes without a linear model." in result.out


def test_steady_motions_of_a_body_on_a_ball_joint(freebody) -> None:  # type: ignore[no-untyped-def]
    data = freebody("analyze", "torque-free", "--json").data
    assert "C_psi' = 0, C_phi' = 0, which the conditions leave free" in data["notes"]["steady_motions"][0]
    assert len(data["steady_motions"]["states"]) == 1 and len(data["modes"]) == 6
    assert len(data["integrals"]) == 5


def test_singular_coordinates(freebody) -> None:  # type: ignore[no-untyped-def]
    result = freebody("analyze", "gyroscope", "--about", "theta=0", "--about", "phi'=300")
    assert result.code == 0
    assert "The mass matrix of 'gyroscope' is singular at the state given" in result.out


def test_no_stable_motion() -> None:
    s = fb.System("inverted")
    k = s.parameters(k=1)
    bob = s.body("bob", fb.particle(1))
    guide = s.slider("guide", s.ground, bob, axis="x", coordinate="x")
    s.spring("push", guide, stiffness=-k)
    found = analysis(s)
    assert "None of the steady motions is known to be stable" in found.sections["linear_model"].notes[0]
    assert [mode["kind"] for mode in found.data()["modes"]] == ["decay", "growth"]


def test_an_open_parameter_leaves_the_symbols(freebody, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    path = tmp_path / "open.toml"
    path.write_text(OSCILLATOR.replace("k = 8.0", "k = {}"))
    result = freebody("analyze", path)
    assert result.code == 0
    assert "x = F/k" in result.out
    assert result.out.count("No numbers, since no value is given for k. Add --set k=VALUE.") == 2
    closed = freebody("analyze", path, "--set", "k=18", "--json").data
    assert closed["modes"][0]["frequency"] == pytest.approx(3, rel=1e-15)


def test_no_degree_of_freedom() -> None:
    s = fb.System("turntable")
    s.parameters(w=2)
    plate = s.body("plate", fb.disk(1, 1))
    s.hinge("shaft", s.ground, plate, axis="z", coordinate="w*t")
    text = analysis(s).text()
    assert "'turntable' has no degree of freedom: there is nothing to solve for." in text
    assert "Modes" not in text


def test_free_motion_is_steady(freebody) -> None:  # type: ignore[no-untyped-def]
    s = fb.System("puck")
    puck = s.body("puck", fb.particle(1))
    s.slider("ice", s.ground, puck, axis="x", coordinate="x")
    data = analysis(s).data()
    assert [mode["kind"] for mode in data["modes"]] == ["rigid body", "drift"]
    assert {one["name"] for one in data["integrals"]} >= {"momentum of x"}


def test_steady_motions_are_told_without_their_stability_if_that_takes_long(monkeypatch) -> None:
    monkeypatch.setattr(
        "freebody.symbolic.steady.motion.SteadyMotion.stable_if", property(lambda motion: time.sleep(60))
    )
    found = analysis(entries()["ex-6-2"].build(), patience=1.5).sections["steady_motions"]
    assert found.notes[0] == (
        "Conditions of stability not found in 1.5 s: the symbolic answer is large. Allow more time with --patience."
    )
    assert found.data["motions"] and all(motion["stable_if"] is None for motion in found.data["motions"])


def test_patience() -> None:
    system = entries()["double-pendulum"].build()
    found = analysis(system, patience=1e-9)
    for key in ("equations", "integrals", "steady_motions"):
        assert found.sections[key].notes == [
            "Not found in 1e-09 s: the symbolic answer is large. Allow more time with --patience."
        ]
    # what needs no symbols is there all the same
    assert len(found.data()["modes"]) == 2
    with pytest.raises(OutOfTimeError), within(time.monotonic() + 0.05):
        while True:
            pass


# --- files ---


def test_files(freebody, oscillator: str, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    folder = tmp_path / "new" / "folder"
    result = freebody("analyze", oscillator, "-o", folder)
    assert result.code == 0
    names = ["analysis.json", "analysis.tex", "analysis.txt"]
    assert sorted(path.name for path in folder.iterdir()) == names
    assert all(f"wrote {folder / name}" in result.out for name in names)
    text = (folder / "analysis.txt").read_text()
    assert text.startswith("Analysis of 'oscillator'\n") and text in result.out + "\n"
    data = json.loads((folder / "analysis.json").read_text())
    assert data["modes"][0]["frequency"] == pytest.approx(2, rel=1e-15)
    assert [Path(file).name for file in data["files"]] == ["analysis.txt", "analysis.tex", "analysis.json"]
    assert data["wall_time_s"] > 0


@pytest.mark.parametrize("name", ["gyroscope", "double-pendulum", "tumbling-body", "two-gears"])
def test_the_latex_document_is_whole(name: str, freebody, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    assert freebody("analyze", name, "-o", tmp_path).code == 0
    source = (tmp_path / "analysis.tex").read_text()
    assert source.startswith("\\documentclass") and source.endswith("\\end{document}\n")
    depth = 0
    for i, c in enumerate(source):
        if c in "{}" and source[i - 1] != "\\":
            depth += 1 if c == "{" else -1
            assert depth >= 0
    assert depth == 0
    assert source.count("\\left") - source.count("\\leftarrow") == source.count("\\right")
    opened = [line.split("}")[0] for line in source.split("\\begin{")[1:]]
    closed = [line.split("}")[0] for line in source.split("\\end{")[1:]]
    assert sorted(opened) == sorted(closed)
    # an underscore in text is an error of LaTeX
    for piece in source.split("\\text{")[1:]:
        assert "_" not in piece.split("}")[0].replace("\\_", "")


def test_plain_latex() -> None:
    assert plain_latex(r"a_b^c \ 50% {x}") == r"a\_b\textasciicircum{}c \textbackslash{} 50\% \{x\}"


# --- how it refuses ---

REFUSALS = {
    "unknown model": (("gyroscop",), "got 'gyroscop'; did you mean 'gyroscope'?"),
    "unknown parameter": (("MODEL", "--set", "kk=2"), "--set kk: expected a parameter of 'oscillator', got 'kk'; "),
    "unknown coordinate": (("MODEL", "--about", "y=2"), "--about y: expected a coordinate or a speed of"),
    "no value": (("MODEL", "--about", "x"), "Expected name=value, such as m=2 or theta_0=75deg, got 'x'."),
    "bad value": (("MODEL", "--about", "x=two"), "Expected a number for x, such as 0.3, 2*pi or 75 deg, got 'two'"),
    "patience": (("MODEL", "--patience", "0"), "Expected a time greater than 0, got 0."),
    "no model": ((), "Missing argument 'MODEL'"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSALS)
def test_refusal(case: str, freebody, oscillator: str) -> None:  # type: ignore[no-untyped-def]
    arguments, message = REFUSALS[case]
    result = freebody("analyze", *(oscillator if argument == "MODEL" else argument for argument in arguments))
    assert result.code == 2
    assert not result.out
    assert message in " ".join(result.err.split()), result.err


def test_an_output_that_is_a_file(freebody, oscillator: str, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    (tmp_path / "file").write_text("")
    for output in (tmp_path / "file", tmp_path / "file" / "below"):
        result = freebody("analyze", oscillator, "-o", output)
        assert result.code == 2
        assert str(output) in result.err


def test_an_impossible_value() -> None:
    with pytest.raises(ModelError, match="Unknown parameter|parameter"):
        analysis(entries()["ex-6-2"].build(), {"nothing": 1})
