"""The ``freebody`` command: what it prints and writes, and how it refuses."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import freebody as fb
from freebody.cli import main
from freebody.cli.model import Number
from freebody.scalar.digits import significant

SOURCE = str(Path(fb.__file__).parents[1])

PENDULUM = """\
name = "pendulum"
gravity = [0, "-g", 0]

[parameters]
m = 1.0
L = 2.0
g = 9.81
c = 0.0

[bodies.bar]
solid = "slender_bar"
mass = "m"
length = "L"
axis = "y"

[joints.pin]
type = "hinge"
child = "bar"
to = [0, "L/2", 0]
coordinate = "theta"

[dampers.pin_friction]
joint = "pin"
damping = "c"

[describe.L]
unit = "m"
about = "length of the bar"

[describe.theta]
unit = "rad"

[initial]
theta = "60deg"

[run]
until = 1
tolerance = 1e-10
"""


@pytest.fixture
def pendulum(tmp_path: Path) -> str:
    path = tmp_path / "pendulum.toml"
    path.write_text(PENDULUM)
    return str(path)


class Result:
    def __init__(self, code: object, out: str, err: str) -> None:
        self.code, self.out, self.err = code, out, err


@pytest.fixture
def freebody(capsys: pytest.CaptureFixture[str]):  # type: ignore[no-untyped-def]
    def call(*arguments: str) -> Result:
        with pytest.raises(SystemExit) as caught:
            main([str(argument) for argument in arguments])
        captured = capsys.readouterr()
        assert "Traceback" not in captured.err + captured.out
        return Result(caught.value.code, captured.out, captured.err)

    return call


# --- what it does ---


def test_help_and_version(freebody) -> None:  # type: ignore[no-untyped-def]
    for arguments in ((), ("--help",), ("-h",)):
        result = freebody(*arguments)
        assert result.code == 0
        for command in ("gallery", "run", "equations", "analyze", "check"):
            assert command in result.out + result.err
    assert freebody("--version").out == f"freebody, version {fb.__version__}\n"
    assert "--tolerance" in freebody("run", "--help").out


def test_check(freebody, pendulum: str) -> None:  # type: ignore[no-untyped-def]
    result = freebody("check", pendulum)
    assert result.code == 0
    lines = [" ".join(line.split()) for line in result.out.splitlines()]
    assert "bar m (0, 0, 0)" in lines
    assert "pin hinge ground bar theta" in lines
    assert "pin_friction JointDamper" in lines
    assert "L 2 m length of the bar" in lines
    assert "Gravity: (0, -g, 0)" in lines
    assert "Coordinates: theta" in lines
    assert "Degrees of freedom: 1" in lines
    assert lines[-1] == "'pendulum' is sound."


def test_equations(freebody, pendulum: str) -> None:  # type: ignore[no-untyped-def]
    expected = fb.equations(fb.read(pendulum))
    assert freebody("equations", pendulum).out.rstrip("\n") == expected.text().rstrip("\n")
    assert freebody("equations", pendulum, "--latex").out.rstrip("\n") == expected.latex().rstrip("\n")
    body = freebody("equations", pendulum, "--body", "bar")
    assert body.out.rstrip("\n") == expected.free_body("bar").text().rstrip("\n")
    assert "\\" in freebody("equations", pendulum, "--body", "bar", "--latex").out


def test_run_prints_and_writes_nothing(freebody, pendulum: str, monkeypatch, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    monkeypatch.chdir(tmp_path)
    result = freebody("run", pendulum)
    assert result.code == 0
    assert "energy residual, relative" in result.out
    assert "wall time" in result.out
    assert "Add -o DIR" in result.out
    assert [path.name for path in tmp_path.iterdir()] == ["pendulum.toml"]


def test_run_writes_its_products(freebody, pendulum: str, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    import xarray

    folder = tmp_path / "new" / "folder"
    result = freebody("run", pendulum, "-o", folder, "--json")
    report = json.loads(result.out)
    names = [
        "equations.txt",
        "equations.tex",
        "trajectory.nc",
        "drawing.svg",
        "free_body_bar.svg",
        "coordinates.png",
    ]
    assert [Path(file).name for file in report["files"]] == names
    assert sorted(path.name for path in folder.iterdir()) == sorted(names)
    assert "theta" in (folder / "equations.txt").read_text()
    assert (folder / "coordinates.png").read_bytes().startswith(b"\x89PNG")
    assert 0 <= report["energy_residual"] < 1e-8
    with xarray.open_dataset(folder / "trajectory.nc") as data:
        # L theta''/2 = -3/4 g sin(theta): at rest at 60 degrees at the start, swinging back after it
        assert float(data["theta"][0]) == pytest.approx(1.0471975511965976)
        assert float(data["time"][-1]) == 1.0
    again = freebody("run", pendulum, "-o", folder)
    assert again.code == 0
    assert f"wrote {folder / 'trajectory.nc'}" in again.out


def test_run_takes_values_length_and_tolerance(freebody, pendulum: str, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    import xarray

    folder = tmp_path / "out"
    arguments = ("--set", "L=4", "--set", "g=2*pi", "--until", "1/2", "--tolerance", "1e-8", "-o", folder)
    assert freebody("run", pendulum, *arguments).code == 0
    expected = fb.simulate(
        fb.read(pendulum),
        0.5,
        initial={"theta": "60deg"},
        values={"L": 4, "g": 6.283185307179586},
        tolerance=1e-8,
    )
    with xarray.open_dataset(folder / "trajectory.nc") as data:
        assert float(data["time"][-1]) == 0.5
        assert float(data["theta"][-1]) == pytest.approx(float(expected["theta"][-1]), abs=1e-12)


def test_gallery_lists_what_can_be_run(freebody) -> None:  # type: ignore[no-untyped-def]
    from freebody.gallery import entries

    listed = freebody("gallery")
    assert listed.code == 0
    assert "gyroscope" in entries()
    data = json.loads(freebody("gallery", "--json").out)
    assert [entry["name"] for entry in data] == list(entries())
    assert all(entry["name"] in listed.out and entry["title"] and entry["asks"] for entry in data)


def test_the_gyroscope_from_the_command_line(freebody, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    report = json.loads(freebody("run", "gyroscope", "--json", "-o", tmp_path).out)
    assert report["answers"]
    for answer in report["answers"].values():
        assert set(answer) == {"value", "unit", "formula", "question", "latex", "how", "where"}
    assert report["energy_residual"] < 1e-9
    written = {Path(file).name for file in report["files"]}
    assert {"equations.txt", "equations.tex", "trajectory.nc"} <= written
    assert sum(name.endswith(".png") for name in written) >= 3
    assert "theta" in freebody("equations", "gyroscope").out
    assert "sound" in freebody("check", "gyroscope").out


def test_equations_among_the_answers_stand_below_the_table(freebody) -> None:  # type: ignore[no-untyped-def]
    lines = freebody("run", "double-pendulum").out.splitlines()
    place = lines.index("equation_1: equation of motion of theta_1")
    assert lines[place + 1].endswith("= 0")
    assert max(len(line) for line in lines[lines.index("Answers") : place]) < 100


# --- how it refuses ---

REFUSALS = {
    "unknown model": (("run", "gyroscop"), "Expected a gallery name or the path of a .toml, .urdf or .xml file, got 'gyroscop'; did you mean 'gyroscope'?"),
    "no file": (("check", "none.toml"), "Expected a model file at 'none.toml', found no file."),
    "other format": (("check", "robot.sdf"), "Expected a file that ends in .toml, .urdf, .xml or .mjcf, got 'robot.sdf'."),
    "unknown parameter": (("run", "MODEL", "--set", "LL=2"), "--set LL: expected a parameter of 'pendulum', got 'LL'; "),
    "no value": (("run", "MODEL", "--set", "L"), "Expected name=value, such as m=2 or theta_0=75deg, got 'L'."),
    "no number": (("run", "MODEL", "--set", "L=two"), "Expected a number for L, such as 0.3, 2*pi or 75 deg, got 'two'"),
    "unit of another kind": (("run", "MODEL", "--set", "L=2 kg"), "Expected L in m or a unit of its kind, got '2 kg'"),
    "unknown unit": (("run", "MODEL", "--set", "L=2 ells"), "Unknown unit 'ells' in 'ells'; known units: m, km"),
    "empty value": (("run", "MODEL", "--set", "L="), "Expected name=value, such as m=2"),
    "negative time": (("run", "MODEL", "--until", "-1"), "Expected a time greater than 0, got -1."),
    "time text": (("run", "MODEL", "--until", "1 m"), "Expected a value in s or a unit of its kind, got '1 m'"),
    "tolerance": (("run", "MODEL", "--tolerance", "3"), "Expected a number between 0 and 1, got 3."),
    "unknown body": (("equations", "MODEL", "--body", "bat"), "Expected a body of 'pendulum', got 'bat'; did you mean 'bar'?"),
    "unknown option": (("run", "MODEL", "--untill", "1"), "No such option"),
    "unknown command": (("runn", "MODEL"), "No such command 'runn'; did you mean 'run'?"),
    "unknown model of no kin": (("run", "zzzz"), "got 'zzzz'; `freebody gallery` lists the known names."),
    "unknown equation": (("chapter", "six"), "got 'six'; `freebody chapter` lists the known names."),
    "two values": (("run", "MODEL", "--set", "L=2", "--set", "L=3"), "--set L: expected one value, got 2 and 3."),
    "too great": (("run", "MODEL", "--until", "1e400"), "Expected a finite number for a value, got 10000000000000000000…, 401 characters."),
    "report of another kind": (("report", "MODEL", "-o", "page.doc"), "Expected a file name that ends in .html or .pdf for a report, got 'page.doc'."),
    "live on paper": (("report", "MODEL", "--live", "-o", "page.pdf"), "Expected an .html file for a live page, got 'page.pdf': paper does not compute."),
    "paper without its ending": (("report", "MODEL", "--pdf", "-o", "page.html"), "--pdf: expected a file name that ends in .pdf after -o, got 'page.html'."),
    "scale without time": (("draw", "MODEL", "--body", "bar", "--mode", "scale"), "--mode scale: arrows to scale need a time of the motion; add it as --at 0.5."),
    "no model": (("run",), "Missing argument 'MODEL'"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSALS)
def test_refusal(case: str, freebody, pendulum: str) -> None:  # type: ignore[no-untyped-def]
    arguments, message = REFUSALS[case]
    result = freebody(*(pendulum if argument == "MODEL" else argument for argument in arguments))
    assert result.code == 2
    assert not result.out
    assert message in " ".join(result.err.split()), result.err


def test_a_model_that_can_not_be_assembled(freebody, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    path = tmp_path / "loose.toml"
    path.write_text(PENDULUM.replace("[joints.pin]", "[bodies.loose]\nmass = 1\n\n[joints.pin]"))
    result = freebody("check", path)
    assert result.code == 2
    assert "Error: Body 'loose' hangs on nothing" in result.err


def test_a_run_without_length(freebody, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    path = tmp_path / "short.toml"
    path.write_text(PENDULUM.partition("[run]")[0])
    result = freebody("run", path)
    assert result.code == 2
    assert "neither --until nor [run] of short.toml gives it. Add --until 10." in result.err
    assert freebody("run", path, "--until", "0.1").code == 0


def test_an_output_that_is_a_file(freebody, pendulum: str, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    (tmp_path / "file").write_text("")
    for output in (tmp_path / "file", tmp_path / "file" / "below"):
        result = freebody("run", pendulum, "-o", output)
        assert result.code == 2
        assert str(output) in result.err


def test_an_open_parameter(freebody, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    path = tmp_path / "open.toml"
    path.write_text(PENDULUM.replace("L = 2.0", "L = {}"))
    result = freebody("run", path)
    assert result.code == 2
    assert "'L'" in result.err
    assert freebody("run", path, "--set", "L=2").code == 0


def test_a_motion_that_breaks_off_is_kept(freebody, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    """A push with the cube of the speed: theta' reaches infinity in finite time."""
    path = tmp_path / "runaway.toml"
    push = '[torques.push]\njoint = "pin"\nvalue = "5*theta\'**3"\n\n[describe.L]'
    path.write_text(PENDULUM.replace("[describe.L]", push))
    result = freebody("run", path, "--until", "100", "-o", tmp_path / "out")
    assert result.code == 2
    assert "Error: " in result.err and "theta" in result.err
    assert [file.name for file in (tmp_path / "out").iterdir()] == ["trajectory.nc"]


def test_ctrl_c(pendulum: str, tmp_path: Path) -> None:
    """Ctrl-C while the model runs: what was computed is printed and written, exit code 130, no traceback."""
    long = [sys.executable, "-m", "freebody", "run", pendulum, "--until", "1e7", "-o", str(tmp_path / "out")]
    here = {**os.environ, "PYTHONPATH": SOURCE}
    process = subprocess.Popen(
        long, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=here,
        # where the tests run in the background, Ctrl-C is ignored by them and would be by what they start
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )  # fmt: skip
    try:
        time.sleep(4)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=60)
    finally:
        process.kill()
    assert "Traceback" not in err
    assert process.returncode == 130
    # modules may still be loading on a busy machine: then there is nothing to keep
    assert "Stopped." in err or ("Stopped by the keyboard at t =" in err and "trajectory.nc" in out)


def test_a_closed_pipe(pendulum: str) -> None:
    command = f"{sys.executable} -m freebody check {pendulum} | head -1"
    result = subprocess.run(
        command, shell=True, capture_output=True, text=True, env={**os.environ, "PYTHONPATH": SOURCE}
    )
    assert "Traceback" not in result.stderr
    assert result.stdout.count("\n") == 1


def test_help_is_quick() -> None:
    code = "import sys; from freebody.cli import main\ntry: main(['--help'])\nexcept SystemExit: pass\n"
    code += "print([m for m in ('numpy', 'sympy', 'matplotlib') if m in sys.modules], file=sys.stderr)"
    here = {**os.environ, "PYTHONPATH": SOURCE}
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=here)
    assert result.stderr.strip() == "[]"


# --- pieces ---


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("2", 2.0),
        ("1e-9", 1e-9),
        ("180deg", 3.141592653589793),
        ("-1/4", -0.25),
        ("2 rev", 12.566370614359172),
    ],
)
def test_number(text: str, value: float) -> None:
    assert Number().convert(text, None, None) == pytest.approx(value)


def test_significant() -> None:
    assert significant(1234567.0) == "1.23457e+06"
    assert significant("rolls") == "rolls"
    assert significant([1.0, 2.0]) == "1, 2"
    assert significant(None) == "None"
