"""A package of a user, installed beside freebody, makes its kind of load known to files and the command line."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parent / "extension_package"

MODEL = """
[parameters]
k = 0.2
w = 4.0
[bodies.bar]
mass = 1
inertia = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
[joints.pin]
type = "hinge"
child = "bar"
to = [0, 1, 0]
coordinate = "theta"
[loads.blow]
kind = "gust"
point = { body = "bar", point = [0, -1, 0] }
factor = "k"
wind = ["w", 0, 0]
"""


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """A folder with the module and the metadata that an installer leaves, and a model file."""
    folder = tmp_path_factory.mktemp("site")
    about = tomllib.loads((PACKAGE / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    shutil.copy(PACKAGE / "freebody_gusts.py", folder)
    metadata = folder / "freebody_gusts-1.0.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {about['name']}\nVersion: 1.0\n")
    lines = [f"{name} = {value}" for name, value in about["entry-points"]["freebody.kinds"].items()]
    (metadata / "entry_points.txt").write_text("\n".join(["[freebody.kinds]", *lines, ""]))
    (folder / "kite.toml").write_text(MODEL)
    return folder


def called(folder, *arguments):
    environment = {**os.environ, "PYTHONPATH": str(folder)}
    return subprocess.run(
        [sys.executable, *arguments],
        env=environment,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )


def test_the_command_line_knows_the_kind(installed):
    result = called(installed, "-m", "freebody", "equations", str(installed / "kite.toml"))
    assert result.returncode == 0, result.stderr
    assert "sin(t)" in result.stdout and "theta" in result.stdout
    result = called(installed, "-m", "freebody", "check", str(installed / "kite.toml"))
    assert result.returncode == 0, result.stdout + result.stderr


def test_it_passes_the_battery_and_has_units(installed):
    result = called(
        installed, "-c",
        "import freebody as fb, freebody_gusts as g\n"
        "fb.testing.check_load(g.Gust)\n"
        "fb.testing.check_contact(g.Bowl, friction=0.3, curvature=0.2)\n"
        f"s = fb.read({str(installed / 'kite.toml')!r})\n"
        "motion = fb.simulate(s, 1, values={'w': '18 km/h', 'k': '0.2 N s^2/m^2'})\n"
        "print(motion.values['w'], abs(motion.energy.residual).max() < 1e-7)\n"
        "fb.simulate(s, 1, values={'w': '3 kg'})\n",
    )  # fmt: skip
    assert result.stdout.split() == ["5.0", "True"], result.stderr
    assert "'w'" in result.stderr and "m/s" in result.stderr


FLOOR = """
gravity = [0, 0, -9.81]
[parameters]
R = 0.1
[bodies.stone]
mass = 1
inertia = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
[joints.air]
type = "free"
child = "stone"
[contacts.floor]
feature = { body = "stone", shape = "puck", radius = "R" }
surface = { shape = "plane", normal = "z" }
"""


def test_a_shape_of_the_package_touches(installed):
    """By events, in a family by time steps, and in a file that is read and written."""
    path = installed / "puck.toml"
    path.write_text(FLOOR)
    result = called(
        installed, "-c",
        "import freebody as fb\n"
        f"s = fb.read({str(path)!r})\n"
        "motion = fb.simulate(s, 0.1, initial={'air_z': 0.1})\n"
        "print(round(float(motion.contacts['floor'].normal[-1]), 6))\n"
        "from freebody.formats.toml.write import toml_text\n"
        "print('shape = \"puck\", radius = \"R\" }' in toml_text(s))\n"
        "import freebody_gusts as g\n"
        "t = fb.System('family')\n"
        "t.gravity = (0, 0, -9.81)\n"
        "b = t.body('b', fb.sphere(1, 0.1)); t.free('j', t.ground, b)\n"
        "pile = t.contacts('pile', [g.Puck(b, 0.1), t.ground.plane(normal='z')])\n"
        "motion = fb.simulate(t, 0.1, initial={'j_z': 0.1}, method='timestepping', step=1e-3)\n"
        "print(round(float(motion.contacts['pile[b,ground]'].normal[-1]), 6))\n",
    )  # fmt: skip
    assert result.stdout.split() == ["9.81", "True", "9.81"], result.stderr


@pytest.mark.parametrize(
    ("kind", "message"),
    [
        (
            "broken_gust",
            "'broken_gust' is that of the package 'freebody-gusts', whose freebody_gusts:Storm cannot be",
        ),
        (
            "wrong_gust",
            "'wrong_gust' is that of the package 'freebody-gusts', but its freebody_gusts:NOTHING is not a",
        ),
        ("guts", "Unknown kind of load 'guts'; did you mean 'gust'"),
    ],
)
def test_a_kind_that_cannot_be_found_is_refused(installed, kind, message):
    path = installed / f"{kind}.toml"
    path.write_text(MODEL.replace('"gust"', f'"{kind}"'))
    result = called(installed, "-m", "freebody", "check", str(path))
    assert result.returncode != 0
    said = " ".join((result.stdout + result.stderr).split())
    assert message in said and "kind" in said
