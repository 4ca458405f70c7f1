"""The page on the architecture is true: its table, its drawing, and the files that it names."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from pathlib import Path

import freebody.describe.system  # noqa: F401 (all kinds)
from freebody.describe.joints.joint import KINDS
from freebody.describe.joints.moving import MOTIONS

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "docs" / "_ext"))

import house  # noqa: E402

PAGE = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")

RUN = """
import sys
used = set()
def profile(frame, event, argument):
    file = frame.f_code.co_filename.replace("\\\\", "/")
    if event == "call" and "/src/freebody/" in file and frame.f_code.co_name != "<module>":
        used.add(file.partition("/src/freebody/")[2])
sys.setprofile(profile)
{code}
picture.svg
sys.setprofile(None)
print(*sorted(used), sep="\\n")
"""


def test_the_table_and_the_drawing_are_up_to_date() -> None:
    """``python docs/_ext/house.py`` writes both."""
    assert house.with_table(PAGE) == PAGE
    assert (ROOT / "docs" / "house.svg").read_text(encoding="utf-8") == house.drawing()


def test_no_circle_of_rooms() -> None:
    """Neither among the rooms nor among the inner rooms of any room."""
    graph = house.imports()
    folders = [name for name, path in house.modules().items() if path.name == "__init__.py"]
    assert {name: house.circles(house.rooms(graph, name)) for name in folders} == {
        name: [] for name in folders
    }


def test_circles_are_seen() -> None:
    graph = {"a": {"b"}, "b": {"c"}, "c": {"b"}, "d": set()}
    assert house.circles(graph) == [("b", "c")]


def test_rooms_are_small() -> None:
    """At most 26 files of code in a folder; more than 16 only where they are a list of equals."""
    equals = {
        "describe.loads",
        "dynamics",
        "scalar",
        "exact",
        "motion.ode",
        "gallery.beyond",
        "gallery.textbook.problems",
    }
    for room in (name for name, path in house.modules().items() if path.name == "__init__.py"):
        count = sum(
            x.rpartition(".")[0] == room and p.name != "__init__.py" for x, p in house.modules().items()
        )
        assert count <= (26 if room in equals else 16), (room, count)


def test_one_model_goes_through_the_files_that_are_named(tmp_path: Path) -> None:
    way = PAGE.partition("## One model on its way through the house")[2]
    code = re.search(r"```python\n(.*?)```", way, re.DOTALL).group(1)
    named = set(re.findall(r"`(\w+(?:/\w+)+\.py)`", way))
    for name in named:
        assert (ROOT / "src" / "freebody" / name).is_file(), name
    environment = {"PYTHONPATH": str(ROOT / "src"), "FREEBODY_CACHE": str(tmp_path), "PATH": ""}
    done = subprocess.run(
        [sys.executable, "-c", RUN.format(code=code)],
        capture_output=True,
        text=True,
        env=environment,
        check=True,
    )
    compiled = {"motion/ode/step_control.py", "motion/ode/dop853.py"}  # they run as machine code
    assert named - compiled <= set(done.stdout.split()), named - compiled - set(done.stdout.split())


def comparisons_of_kinds(text: str) -> list[int]:
    """Lines that compare something with the name of a kind of joint or motion, or the kind of a joint or link."""
    words = {*MOTIONS, *(name for name, kind in KINDS.items() if kind.__module__.startswith("freebody."))}
    found = []
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Compare):
            sides = [node.left, *node.comparators]
            inner = [x for side in sides for x in ast.walk(side)]
            named = any(isinstance(x, ast.Constant) and x.value in words for x in inner)
            of_joint = any(
                isinstance(x, ast.Attribute)
                and x.attr in ("type", "kind")
                and isinstance(x.value, ast.Name)
                and x.value.id in ("joint", "closure", "link", "motion", "primitive")
                for x in inner
            )
            # looks of shapes, memos and systems of coordinates have words of their own
            names = {getattr(x, "attr", getattr(x, "id", "")) for x in inner}
            named = named and not names & {"look", "bound", "cache", "coordinates"}
            if named or of_joint:
                found.append(node.lineno)
        elif isinstance(node, ast.Call) and getattr(node.func, "id", "") == "isinstance":
            kinds = [x.id for x in ast.walk(node.args[1]) if isinstance(x, ast.Name)]
            if {*kinds} & {kind.__name__ for kind in (*MOTIONS.values(), *KINDS.values())}:
                found.append(node.lineno)
        elif isinstance(node, ast.match_case):
            found += [
                x.value.lineno
                for x in ast.walk(node.pattern)
                if isinstance(x, ast.MatchValue)
                and isinstance(x.value, ast.Constant)
                and x.value.value in words
            ]
    return found


def test_comparisons_of_kinds_are_seen():
    for line in (
        'kind == "hinge"', 'joint.type in ("ball", "x")', "closure.type != other", '"path_joint" in names',
        "link.kind == other", "isinstance(motion, Ball)", "isinstance(j, HingeJoint | int)",
        'match kind:\n    case "weld" | "free":\n        pass',
    ):  # fmt: skip
        assert comparisons_of_kinds(line), line
    assert not comparisons_of_kinds('f("hinge"); joint.pair.revolute; s.kind == "linear"')


def test_no_file_names_a_kind_of_joint_or_motion():
    """What a joint leaves free is asked of its pair, what a motion can do of its class; files alone hold their words.

    Readers of robots' files compare the words of these formats, and random machines those of the caller.
    """
    source = Path(__file__).parents[1] / "src/freebody"
    others = ("describe/joints", "formats/mjcf", "formats/urdf", "testing")
    found = [
        f"{path.relative_to(source)}:{line}"
        for path in sorted(source.rglob("*.py"))
        if not str(path.relative_to(source)).startswith(others)
        for line in comparisons_of_kinds(path.read_text(encoding="utf-8"))
    ]
    assert found == []
