"""The page on the architecture is true: its table, its drawing, and the files that it names."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

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
    equals = {"describe.loads", "dynamics", "scalar", "exact", "gallery.beyond", "gallery.textbook.problems"}
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


def test_no_algorithm_names_a_kind_of_motion():
    """What a primitive motion can do is asked of it (`describe.joints.moving`); its word stands in its file."""
    words = ("hinge", "slider", "screw", "ball", "free", "weld")
    comparison = re.compile(rf"kind\w*\)? (?:==|!=|in|not in) \(?\"(?:{'|'.join(words)})\"")
    of_link = re.compile(r"link\.kind (?:==|!=|in|not in) ")
    source = Path(__file__).parents[1] / "src/freebody"
    # in drawings and files a joint's symbol and keys stand with its type
    rooms = ("model", "dynamics", "symbolic", "program", "describe", "motion", "picture", "studies")
    found = [
        f"{path.relative_to(source)}:{i}"
        for room in rooms
        for path in sorted((source / room).rglob("*.py"))
        for i, line in enumerate(path.read_text(encoding="utf-8").splitlines(), start=1)
        if (comparison if room in rooms[:5] else of_link).search(line)
    ]
    assert found == []
