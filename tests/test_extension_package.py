"""A package of a user, installed beside freebody: its kinds pass the batteries, and files and commands know them."""

from __future__ import annotations

import ast
import os
import re
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
        "fb.testing.check_load(g.Water)\n"
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


WALKER = """
gravity = [0, -9.81, 0]
[parameters]
thigh = 0.4
k = 0.1
[bodies.foot]
solid = "box"
mass = 1
sizes = [0.1, 0.3, 0.1]
[bodies.bead]
solid = "sphere"
mass = 0.2
radius = 0.02
[joints.left]
type = "leg"
child = "foot"
at = [0, 1, 0]
to = [0, 0.15, 0]
thigh = "thigh"
[joints.wire]
type = "cycloid"
child = "bead"
at = [1, 1, 0.1]
radius = 0.3
[contacts.dish]
kind = "bowl"
point = "bead"
curvature = 0.01
friction = 0.1
[loads.air]
kind = "gust"
point = "foot"
factor = "k"
wind = [1, 0, 0]
[initial]
left_hip = 0.3
wire_phi = 0.5
[run]
until = 0.2
"""


@pytest.mark.slow
def test_joints_of_the_package_in_every_command(installed, tmp_path):
    path = installed / "walker.toml"
    path.write_text(WALKER)
    for arguments, words in {
        ("check",): ("leg", "cycloid", "left_hip", "wire_phi"),
        ("equations",): ("left_knee''", "wire_phi''"),
        ("draw", "-o", str(tmp_path / "walker.svg")): (),
        ("run", "--until", "0.1"): (),
    }.items():
        command, *more = arguments
        result = called(installed, "-m", "freebody", command, str(path), *more)
        assert result.returncode == 0, result.stdout + result.stderr
        for word in words:
            assert word in result.stdout, (word, result.stdout)
    pictures = "".join(file.read_text(encoding="utf-8") for file in tmp_path.rglob("*.svg"))
    for part in ('data-joint="left"', 'data-joint="wire"', 'data-load="air"'):
        assert part in pictures, part
    result = called(
        installed, "-c",
        "import freebody as fb\n"
        f"s = fb.read({str(path)!r})\n"
        "from freebody.formats.toml.write import toml_text\n"
        f"fb.write(s, {str(tmp_path / 'again.toml')!r})\n"
        f"print(fb.equations(fb.read({str(tmp_path / 'again.toml')!r})).text() == fb.equations(s).text())\n"
        "motion = fb.simulate(s, 0.3, initial={'left_hip': 0.3, 'wire_phi': 0.5})\n"
        "print(abs(motion.energy.residual).max() < 1e-7)\n"
        f"fb.report(s, motion, {str(tmp_path / 'report.html')!r})\n"
        "p = fb.compile(s)\n"
        "print(len(p.to_c('mass_matrix').source) > 1000)\n"
        "print('left' in fb.equations(s).reactions, 'wire' in fb.equations(s).reactions)\n"
        "print('left' in fb.free_body_diagram(s, 'foot').svg)\n",
    )  # fmt: skip
    assert result.stdout.split() == ["True"] * 6, result.stdout + result.stderr
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "leg" in page and "cycloid" in page


def test_joints_and_the_method_of_the_package_pass_the_batteries(installed):
    result = called(
        installed, "-c",
        "import freebody as fb\n"
        "s = fb.System('ball')\n"
        "s.gravity = (0, -9.81, 0)\n"
        "s.slider('guide', s.ground, s.body('ball', fb.particle(1)), axis='y', coordinate='y')\n"
        "print(round(float(fb.simulate(s, 1, method='bogacki')['y'][-1]), 6))\n"  # by its entry point
        "import freebody_gusts as g\n"
        "fb.testing.check_joint(g.Leg)\n"
        "fb.testing.check_joint(g.Cycloid)\n"
        "fb.testing.check_method(g.bogacki)\n",
    )  # fmt: skip
    assert result.returncode == 0, result.stderr
    assert result.stdout.split() == ["-4.905"]


def test_kinds_are_short_and_touch_nothing_internal():
    text = (PACKAGE / "freebody_gusts.py").read_text(encoding="utf-8")
    tree = ast.parse(text)
    imported = [x for x in ast.walk(tree) if isinstance(x, ast.Import | ast.ImportFrom)]
    assert {alias.name for x in imported for alias in x.names} == {"sympy", "freebody"}
    assert not re.search(r"fb\._|fb\.[a-z]\w*\.[a-z]", text)
    kinds = [x for x in tree.body if isinstance(x, ast.ClassDef)]
    assert {getattr(kind.bases[0], "attr", "") for kind in kinds} == {"Load", "Gap", "ContactShape", "Joint"}
    assert all(kind.end_lineno - kind.lineno < 30 for kind in kinds)


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


def test_the_page_on_extending_runs_and_prints_what_it_says(installed):
    """In a process of its own, since its kinds have names in files."""
    page = (PACKAGE.parents[1] / "docs" / "extending.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```(?:\n\n```text\n(.*?)```)?", page, re.DOTALL)
    assert len(blocks) == 8
    result = called(installed, "-c", "\n".join(code for code, _ in blocks))
    assert result.returncode == 0, result.stderr
    printed = [text for _, text in blocks if text]
    assert len(printed) == 3 and all(text in result.stdout for text in printed)
