"""Malformed and hostile model files: each is refused with the line and the key."""

from __future__ import annotations

import ast
import os
import tempfile
from pathlib import Path
from time import process_time

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import freebody
import freebody as fb
from freebody.errors import FormatError, FreebodyError
from freebody.formats import MAX_SIZE, meshes, read_case
from freebody.formats.toml.read import MAX_ENTITIES, case_from_text

GOOD = """\
name = "good"
gravity = [0, "-g", 0]
assume = ["k > 0"]

[parameters]
m = 1.0
k = 2.0
g = 9.81

[bodies.bar]
solid = "slender_bar"
mass = "m"
length = 1
axis = "y"

[joints.pin]
type = "hinge"
child = "bar"
to = [0, 0.5, 0]
axis = "z"
coordinate = "theta"

[springs.coil]
joint = "pin"
stiffness = "k"

[forces.push]
at = { body = "bar", point = [0, -0.5, 0] }
components = [1, 0, 0]

[initial]
theta = "5deg"
"theta'" = 0

[run]
until = 2
tolerance = 1e-9
"""

# what of the good file is replaced, by what, the line and key of the refusal, its text
CASES = {
    "missing value": ("m = 1.0", "m =", "", "expected TOML. Invalid value (at line 6, column 4)"),
    "key twice": ('mass = "m"', 'mass = "m"\nmass = 2', "", "expected TOML. Cannot overwrite a value (at line 13"),
    "unclosed": ('name = "good"', 'name = "good', "", "expected TOML. Illegal character"),
    "no name": ('name = "good"', "name = 3", "line 1, name", "Expected a name (text), got 3."),
    "empty name": ('name = "good"', 'name = " "', "line 1, name", "Expected a name (text), got ' '."),
    "unknown table": ("[springs.coil]", "[sprungs.coil]", "line 23, sprungs", "Unknown key 'sprungs'; did you mean 'springs'?"),
    "unknown key": ("length = 1", "lenght = 1", "line 10, bodies.bar", "Expected the key 'length', but it is missing."),
    "key too much": ("length = 1", "length = 1\nradius = 2", "line 14, bodies.bar.radius", "Unknown key 'radius'; did you mean"),
    "key nearly": ('axis = "z"', 'axes = "z"', "line 20, joints.pin.axes", "Unknown key 'axes'; did you mean 'axis'?"),
    "not a table": ("[parameters]\nm = 1.0\nk = 2.0\ng = 9.81", "[parameters.x]\ny = 1", "line 5, parameters.x", "Expected a number, a number as text"),
    "body no table": ("[bodies.bar]", "[bodies]\nbar = 3\n[bodies_]", "line 11, bodies.bar", "Expected a table, got a number: 3."),
    "gravity of two": ('[0, "-g", 0]', '[0, "-g"]', "line 2, gravity", "Expected three components [x, y, z], got 2: [0, '-g']."),
    "gravity a number": ('[0, "-g", 0]', "9.81", "line 2, gravity", "Expected three components [x, y, z], got a number: 9.81."),
    "gravity a name": ('[0, "-g", 0]', '[0, "-G", 0]', "line 2, gravity", "Expected a known name, got 'G'; did you mean 'g'?"),
    "gravity moves": ('[0, "-g", 0]', '[0, "-g*t", 0]', "line 2, gravity", "Gravity must be constant, but it depends on t."),
    "assume nothing": ('["k > 0"]', '["k"]', "line 3, assume", "Expected a condition such as k > 0, got 'k'."),
    "assume less": ('["k > 0"]', '["k >= 0"]', "line 3, assume", "Expected a condition such as k > 0, got 'k >= 0'."),
    "assume a number": ('["k > 0"]', "[3]", "line 3, assume", "Expected a list of texts, got [3]."),
    "assume a stranger": ('["k > 0"]', '["q > 0"]', "line 3, assume", "Expected a known name, got 'q'"),
    "parameter of parameters": ("k = 2.0", 'k = "2*m"', "line 7, parameters.k", "The default value of parameter 'k' must be a number"),
    "parameter true": ("k = 2.0", "k = true", "line 7, parameters.k", "Expected a number, a number as text such as '75deg'"),
    "parameter date": ("k = 2.0", "k = 1979-05-27", "line 7, parameters.k", "Expected a number, a number as text such as '75deg'"),
    "parameter nan": ("k = 2.0", "k = nan", "line 7, parameters.k", "xpected a finite number, got nan"),
    "parameter infinite": ("k = 2.0", "k = inf", "line 7, parameters.k", "xpected a finite number, got inf"),
    "parameter name": ("k = 2.0", '"k-1" = 2.0', 'line 7, parameters."k-1"', "'k-1' cannot be the name of a parameter"),
    "parameter is time": ("k = 2.0", "t = 2.0", "line 7, parameters.t", "The name 't' is taken"),
    "huge integer": ("m = 1.0", "m = 1" + "0" * 5000, "", "expected TOML."),
    "coordinate twice": ("[parameters]", 'coordinates = ["m"]\n[parameters]', "line 5, coordinates", "The name 'm' is taken"),
    "solid unknown": ('"slender_bar"', '"slender_bat"', "line 11, bodies.bar.solid", "Unknown solid 'slender_bat'; did you mean 'slender_bar'?"),
    "solid no function": ('"slender_bar"', '"__class__"', "line 11, bodies.bar.solid", "Unknown solid '__class__'; known names: "),
    "mass true": ('mass = "m"', "mass = true", "line 12, bodies.bar.mass", "Expected a number or an expression in quotes, got true or false: True."),
    "mass missing": ('mass = "m"', "", "line 10, bodies.bar", "Expected the key 'mass', but it is missing."),
    "mass negative": ('mass = "m"', "mass = -1", "line 10, bodies.bar", "mass"),
    "mass moves": ('mass = "m"', 'mass = "m*t"', "line 10, bodies.bar", "Body 'bar' is rigid, but its mass properties depend on t."),
    "mass code": ('mass = "m"', "mass = \"__import__('os')\"", "line 12, bodies.bar.mass", "Expected a number, a name or an operator, got \"'\""),
    "inertia 2 by 2": ('solid = "slender_bar"\nmass = "m"\nlength = 1\naxis = "y"', "mass = 1\ninertia = [[1, 0], [0, 1]]", "line 12, bodies.bar.inertia", "Expected three rows"),
    "inertia impossible": ('solid = "slender_bar"\nmass = "m"\nlength = 1\naxis = "y"', "mass = 1\ninertia = [[1, 0, 0], [0, 1, 0], [0, 0, 3]]", "line 10, bodies.bar", "1 + 1"),
    "body ground": ("[bodies.bar]", "[bodies.ground]", "line 10, bodies.ground", "There is already a body 'ground'"),
    "hole first": ('[bodies.bar]\nsolid = "slender_bar"\nmass = "m"\nlength = 1\naxis = "y"', '[[bodies.bar.parts]]\nmass = 1\nhole = true', "line 12, bodies.bar.parts.hole", "Expected a part of mass before the first hole."),
    "parts no list": ('solid = "slender_bar"', "parts = 3", "line 11, bodies.bar.parts", "Expected a list of parts"),
    "joint type": ('type = "hinge"', 'type = "hingle"', "line 17, joints.pin.type", "Unknown type of joint 'hingle'; did you mean 'hinge'?"),
    "joint no type": ('type = "hinge"\n', "", "line 16, joints.pin", "Expected the key 'type', but it is missing."),
    "joint child": ('child = "bar"', 'child = "bat"', "line 16, joints.pin", "Unknown body 'bat' in hinge 'pin'; did you mean 'bar'?"),
    "joint child a number": ('child = "bar"', "child = 1", "line 18, joints.pin.child", "Expected text in quotes, got a number: 1."),
    "joint to itself": ('child = "bar"', 'child = "bar"\nparent = "bar"', "line 16, joints.pin", "joins body 'bar' to itself"),
    "joint place": ("to = [0, 0.5, 0]", "to = [0, 0.5]", "line 19, joints.pin.to", "Expected three components [x, y, z], got 2: [0, 0.5]."),
    "joint axis": ('axis = "z"', 'axis = "w"', "line 16, joints.pin", "Expected 'x', 'y', 'z' or three components"),
    "joint axis zero": ('axis = "z"', "axis = [0, 0, 0]", "line 16, joints.pin", "has length zero"),
    "joint coordinates": ('"theta"', '["a", "b"]', "line 16, joints.pin", "Expected 1 coordinate for joint 'pin', got 2: a, b."),
    "joint axes no rotation": ('axis = "z"', "parent_axes = [[1, 1, 0], [0, 1, 0], [0, 0, 1]]", "line 16, joints.pin", "Expected a rotation matrix"),
    "joint axes no list": ('type = "hinge"\nchild = "bar"\nto = [0, 0.5, 0]\naxis = "z"\ncoordinate = "theta"', 'type = "universal"\nchild = "bar"\naxis = "x"', "line 19, joints.pin.axis", "Expected a list of axes, such as ['x', 'y'], got 'x'."),
    "joint axes no rows": ('axis = "z"', "parent_axes = 3", "line 20, joints.pin.parent_axes", "Expected three rows [[...], [...], [...]], got 3."),
    "chain of no list": ('type = "hinge"\nchild = "bar"\nto = [0, 0.5, 0]\naxis = "z"\ncoordinate = "theta"', 'type = "chain"\nchild = "bar"\nmotions = 3', "line 19, joints.pin.motions", "Expected a list of tables [{...}, {...}], got a number: 3."),
    "chain of nothing known": ('type = "hinge"\nchild = "bar"\nto = [0, 0.5, 0]\naxis = "z"\ncoordinate = "theta"', 'type = "chain"\nchild = "bar"\nmotions = [{ type = "hing" }]', "line 19, joints.pin.motions.type", "Unknown motion 'hing' of a chain; did you mean 'hinge'?"),
    "family of no list": ("[run]", "[families.pile]\nshapes = 3\n[run]", "line 36, families.pile.shapes", "Expected a list of shapes [{ body = ..., shape = ... }, ...], got 3."),
    "load twice": ("[forces.push]", "[forces.coil]", "line 27, forces.coil", "There is already a load 'coil'"),
    "load joint": ('joint = "pin"', 'joint = "pan"', "line 24, springs.coil.joint", "Unknown joint 'pan'; did you mean 'pin'?"),
    "load displacement": ('joint = "pin"', 'joint = "pin"\ncoordinate = 1', "line 23, springs.coil", "Joint 'pin' has 1 displacements"),
    "load displacement text": ('joint = "pin"', 'joint = "pin"\ncoordinate = "x"', "line 25, springs.coil.coordinate", "Expected a whole number, got text: 'x'."),
    "load stiffness": ('stiffness = "k"', 'stiffness = "k*theta"', "line 23, springs.coil", "The stiffness of spring 'coil' must be constant"),
    "load point": ("point = [0, -0.5, 0]", "pont = [0, -0.5, 0]", "line 28, forces.push.at.pont", "Unknown key 'pont'; did you mean 'point'?"),
    "load body": ('body = "bar"', 'body = "bat"', "line 28, forces.push.at.body", "Unknown body 'bat'"),
    "load at a list": ('{ body = "bar", point = [0, -0.5, 0] }', "[0, 1, 0]", "line 28, forces.push.at", "Expected a point { body ="),
    "load speed": ("components = [1, 0, 0]", "components = [1, \"theta''\", 0]", "line 29, forces.push.components", "Expected a speed or an acceleration"),
    "spring ends": ('joint = "pin"', 'from = "bar"\nto = "bar"', "line 23, springs.coil", "Both ends of spring 'coil' are on 'bar'"),
    "generalized": ("[run]", '[generalized_forces.Q]\ncoordinate = "phi"\nvalue = 1\n[run]', "line 35, generalized_forces.Q", "Unknown coordinate 'phi'; known names: theta."),
    "describe": ("[run]", "[describe.x]\nunit = 'm'\n[run]", "line 35, describe.x", "Expected a known name, got 'x'"),
    "initial name": ('theta = "5deg"', "phi = 0", "line 32, initial.phi", "Unknown coordinate or speed 'phi'"),
    "initial a list": ('theta = "5deg"', "theta = [1]", "line 32, initial.theta", "Expected a number or an expression in quotes, got a list: [1]."),
    "initial attitude": ('type = "hinge"\nchild = "bar"\nto = [0, 0.5, 0]\naxis = "z"\ncoordinate = "theta"\n\n[springs.coil]\njoint = "pin"\nstiffness = "k"\n\n[forces.push]\nat = { body = "bar", point = [0, -0.5, 0] }\ncomponents = [1, 0, 0]\n\n[initial]\ntheta = "5deg"\n"theta\'" = 0', 'type = "ball"\nchild = "bar"\n[initial]\npin = [1, 0, 0]', "line 20, initial.pin", "Expected the quaternion [w, x, y, z] of joint 'pin', got [1, 0, 0]."),
    "initial moves": ('theta = "5deg"', "theta = \"theta'\"", "line 32, initial.theta", "Expected numbers and parameters only, got an expression of theta'."),
    "until zero": ("until = 2", "until = 0", "line 36, run.until", "Expected a time greater than 0, got 0."),
    "until a coordinate": ("until = 2", 'until = "theta"', "line 36, run.until", "Expected numbers and parameters only, got an expression of theta."),
    "tolerance": ("tolerance = 1e-9", "tolerance = 2", "line 37, run.tolerance", "Expected a number between 0 and 1, such as 1e-9, got 2."),
    "run key": ("tolerance = 1e-9", "tol = 1e-9", "line 37, run.tol", "Unknown key 'tol'; known names: tolerance, until."),
    "deep list": ("m = 1.0", "m = " + "[" * 9 + "]" * 9, "line 6", "expected at most 8 nested brackets, got more."),
    "deep key": ("m = 1.0", ".".join("abcdefghi") + " = 1", "line 6", "expected at most 8 nested names of a key, got more."),
}  # fmt: skip


def test_the_good_file_is_good() -> None:
    assert repr(case_from_text(GOOD, "good.toml").system) == "System 'good': 1 body, 1 joint, 1 coordinate"


@pytest.mark.parametrize("case", CASES)
def test_malformed(case: str) -> None:
    old, new, place, message = CASES[case]
    assert GOOD.count(old) == 1
    with pytest.raises(FormatError) as caught:
        case_from_text(GOOD.replace(old, new), "bad.toml")
    text = str(caught.value)
    assert text.startswith(f"bad.toml, {place}: " if place else "bad.toml: "), text
    assert message in text


def test_too_many_entities() -> None:
    text = "[parameters]\n" + "\n".join(f"p{i} = 1" for i in range(MAX_ENTITIES + 1))
    with pytest.raises(
        FormatError, match=f"Expected at most {MAX_ENTITIES} parameters, bodies, joints and loads"
    ):
        case_from_text(text, "many.toml")


def test_too_large(tmp_path: Path) -> None:
    path = tmp_path / "large.toml"
    path.write_bytes(b"#" * (MAX_SIZE[".toml"] + 1))
    with pytest.raises(
        FormatError, match=f"large.toml: expected at most {MAX_SIZE['.toml']} bytes, got more"
    ):
        fb.read(path)


def test_not_utf8(tmp_path: Path) -> None:
    path = tmp_path / "latin.toml"
    path.write_bytes(b"name = 'a'\n# caf\xe9\n")
    with pytest.raises(FormatError, match="latin.toml, line 2: expected UTF-8 text, got the byte 0xe9"):
        fb.read(path)


@pytest.mark.parametrize(("name", "found"), [("none.toml", "no file"), ("folder.toml", "a folder")])
def test_no_file(tmp_path: Path, name: str, found: str) -> None:
    (tmp_path / "folder.toml").mkdir()
    with pytest.raises(FormatError, match=f"Expected a model file at '.*{name}', found {found}"):
        fb.read(tmp_path / name)


def test_a_folder_of_models(tmp_path: Path) -> None:
    for name in ("a.urdf", "b.xml", "c.toml", "d.mjcf", "e.txt"):
        (tmp_path / name).touch()
    with pytest.raises(FormatError, match=r"found a folder. It has a.urdf, b.xml, c.toml and 1 more\.$"):
        fb.read(tmp_path)
    with pytest.raises(FormatError, match="Expected a model file at '.', found a folder"):
        fb.read("")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs named pipes")
def test_a_pipe_is_not_opened(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.toml")
    with pytest.raises(FormatError, match="found a special file"):
        fb.read(tmp_path / "pipe.toml")


@pytest.mark.parametrize("path", ["robot.usd", "model", "a\0.toml"])
def test_other_suffixes(path: str) -> None:
    with pytest.raises(
        FormatError, match=r"Expected a file that ends in \.toml, \.urdf, \.xml or \.mjcf, got"
    ):
        fb.read(path)


def test_a_file_without_leave_to_read_or_write(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "model.toml"
    system = case_from_text(GOOD).system
    fb.write(system, path)

    def refuse(*arguments: object, **options: object) -> None:
        raise PermissionError(13, "Permission denied")

    with monkeypatch.context() as patched:
        patched.setattr(Path, "open", refuse)
        with pytest.raises(FormatError, match="Cannot read '.*model.toml': Permission denied"):
            fb.read(path)
    with monkeypatch.context() as patched:
        patched.setattr(tempfile, "mkstemp", refuse)
        with pytest.raises(FormatError, match="Cannot write '.*model.toml'.* Choose another folder"):
            fb.write(system, path)
    assert fb.read(path).name == "good"


def test_an_option_that_no_reader_has(tmp_path: Path) -> None:
    """As the command line gives it, ``--read frixion=true``."""
    (tmp_path / "arm.urdf").write_text("<robot/>")
    with pytest.raises(FormatError, match="Unknown option 'frixion' of fb.read; did you mean 'friction'?"):
        read_case(tmp_path / "arm.urdf", frixion=True)


def test_a_mesh_whose_library_is_missing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "a.dae").write_text("<COLLADA/>")
    monkeypatch.setattr(meshes, "find_spec", lambda name: None)
    with pytest.raises(FormatError, match="dae needs collada: pip install 'freebody\\[mesh\\]'"):
        meshes.check(tmp_path / "a.dae")


def test_no_path_at_all() -> None:
    with pytest.raises(FormatError, match="Expected the path of a model file, got 3"):
        fb.read(3)  # type: ignore[arg-type]


def test_write_into_no_folder(tmp_path: Path) -> None:
    system = case_from_text(GOOD).system
    with pytest.raises(
        FormatError, match="Expected an existing folder for '.*', got '.*none'. Make it first"
    ):
        fb.write(system, tmp_path / "none" / "x.toml")
    (tmp_path / "folder.toml").mkdir()
    with pytest.raises(FormatError, match="Expected the name of a file, got the folder"):
        fb.write(system, tmp_path / "folder.toml")


@pytest.mark.parametrize(
    "text",
    [
        "a = " + "[" * 100_000,
        "a" + ".a" * 100_000 + " = 1",
        "[" + "a." * 100_000 + "a]",
        "a = '''" + "x" * 1_000_000,
        'a = "' + "\\" * 1_000_001,
        "a = {" + "b = {" * 10_000,
        "\n".join("[[a]]" for _ in range(30_000)),
        'x = "' + "(" * 10_000 + '"',
        '[parameters]\nx = "' + "9**" * 5_000 + '9"',
        '[parameters]\nx = "' + "sin(" * 5_000 + '1"',
        "\x00\x01\x02",
        "= = =\n[[[]]]",
    ],
)
def test_hostile_text_ends_soon_in_a_refusal(text: str) -> None:
    start = process_time()
    with pytest.raises(FormatError):
        case_from_text(text, "hostile.toml")
    assert process_time() - start < 5


@settings(max_examples=150)
@given(st.data())
def test_damaged_files_are_read_or_refused_in_order(data: st.DataObject) -> None:
    """A good file with a stretch cut out or a piece of itself put in: nothing but FreebodyError comes out."""
    start = data.draw(st.integers(0, len(GOOD)))
    end = data.draw(st.integers(start, min(len(GOOD), start + 40)))
    other = data.draw(st.integers(0, len(GOOD)))
    piece = data.draw(
        st.sampled_from(["", GOOD[other : other + 15], "]", '"', "{", "'", "=", "\n[", "1e999", "..", "\\"])
    )
    try:
        case_from_text(GOOD[:start] + piece + GOOD[end:], "damaged.toml")
    except FreebodyError as error:
        assert isinstance(error, FormatError)
        assert str(error).startswith("damaged.toml")


# -- every rule of the readers ------------------------------------------------------------------------

FORMATS = Path(freebody.__file__).parent / "formats"
READERS = [
    path
    for path in (*FORMATS.glob("*.py"), *FORMATS.glob("urdf/*.py"), *FORMATS.glob("mjcf/*.py"))
    if not path.name.startswith("write") and path.name != "machine.py"
]
LEAST = 20
"""Letters of a message that no other text holds by chance."""


def messages(path: Path) -> list[tuple[int, list[str]]]:
    """Return line and texts of every refusal of a reader, without the values between them."""
    calls = [
        node for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))) if isinstance(node, ast.Call)
    ]
    found = []
    for call in calls:
        name = getattr(call.func, "attr", getattr(call.func, "id", ""))
        if name in ("error", "refuse", "FormatError"):
            parts = [
                part.value
                for value in call.args
                for part in ast.walk(value)
                if isinstance(part, ast.Constant)
            ]
            texts = [
                part.strip(" .") for part in parts if isinstance(part, str) and len(part.strip(" .")) > 5
            ]
            if texts:
                found.append((call.lineno, texts))
    return found


@pytest.mark.parametrize("path", READERS, ids=lambda path: f"{path.parent.name}/{path.name}")
def test_every_rule_has_a_broken_file(path: Path) -> None:
    """The message of each refusal stands in a test, which breaks a file by this rule."""
    tests = "".join(one.read_text(encoding="utf-8") for one in Path(__file__).parent.glob("*.py")).replace(
        "\\", ""
    )

    def stands(text: str) -> bool:
        return any(text[k : k + LEAST] in tests for k in range(max(1, len(text) - LEAST + 1)))

    missing = [(line, texts) for line, texts in messages(path) if not any(map(stands, texts))]
    assert not missing, missing
