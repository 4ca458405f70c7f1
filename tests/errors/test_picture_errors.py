"""What the commands and functions of pictures refuse, and in which words."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import pytest
from click.testing import CliRunner

import freebody as fb
from contact_machines import DISK
from freebody.cli import command
from freebody.errors import FormatError, FreebodyError, ModelError

CASES = {
    "unknown body": (
        ("draw", "--body", "dsk"),
        "expected a body of 'disk' or 'all', got 'dsk'; did you mean 'disk'",
    ),
    "unknown coordinate": (("draw", "--at", "q=3"), "Unknown name 'q' in at"),
    "unknown contact": (("draw", "--body", "disk", "--mode", "flor=stick"), "did you mean 'floor'"),
    "negative time": (("draw", "--at", "-1"), "expected a time of 0 s or later"),
    "ending": (("draw", "-o", "x.jpg"), "expected a file name that ends in .svg, .pdf, .png, .tex"),
    "no folder": (("draw", "-o", "/no/such/folder/x.svg"), "Expected an existing folder for"),
    "no permission": (("draw", "-o", "/proc/x.svg"), "Cannot write '/proc/x.svg'"),
    "negative radius": (
        ("draw", "--set", "R=-1"),
        "Expected positive dimensions to draw a disk, got radius = -1",
    ),
    "radius of zero": (
        ("draw", "--set", "R=0"),
        "Expected positive dimensions to draw a disk, got radius = 0",
    ),
    "report without folder": (("report", "-o", "/no/such/folder/x.html"), "Expected an existing folder for"),
    "report without permission": (("report", "-o", "/proc/x.html"), "Cannot write '/proc/x.html'"),
    "report backward": (("report", "--until", "-3"), "Expected a time greater than 0, got -3"),
    "report of nothing": (("report", "--set", "Q=1"), "expected a parameter of 'disk', got 'Q'"),
    "run into nothing": (("run", "-o", "/proc/zz"), "Cannot make the folder '/proc/zz'"),
    "view at no port": (("view", "--port", "99999"), "99999 is not in the range"),
}


@pytest.mark.parametrize("case", CASES)
def test_the_command_says_what_is_wrong(case: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    (name, *arguments), message = CASES[case]
    monkeypatch.chdir(tmp_path)
    Path("disk.toml").write_text(DISK)
    found = CliRunner().invoke(command, [name, "disk.toml", *arguments])
    text = found.output + str(found.exception)
    assert found.exit_code != 0 and message in text
    # main() shows FreebodyError and the errors of click as one line; anything else would be a traceback
    assert isinstance(found.exception, FreebodyError | SystemExit)
    assert [p.name for p in tmp_path.iterdir()] == ["disk.toml"]


def disk(name: str = "disk") -> fb.System:
    s = fb.System("disk")
    body = s.body(name, fb.disk(2, 0.3))
    s.planar("plane", s.ground, body, coordinate="x y phi")
    return s


def test_a_drawing_is_written_whole_or_not_at_all(tmp_path: Path):
    path = tmp_path / "x.svg"
    drawing = fb.draw(disk())
    drawing.save(path)
    before = path.read_bytes()
    with pytest.raises(FormatError, match="Expected an existing folder"):
        drawing.save(tmp_path / "no" / "x.svg")
    with pytest.raises(FormatError, match="got the folder"):
        (tmp_path / "y.svg").mkdir()
        drawing.save(tmp_path / "y.svg")
    assert path.read_bytes() == before


@pytest.mark.parametrize("name", ["body of mine", "x&y", "Körper"])
def test_names_that_equations_can_not_bear_are_refused_where_they_are_given(name: str):
    with pytest.raises(ModelError, match=f"'{name}' cannot be the name of a body: use letters, digits"):
        disk(name)


@pytest.mark.parametrize("title", ["a_b", "system of mine", "x & <y>", "Körper"])
def test_strange_titles_are_text(title: str):
    s = fb.System(title)
    s.planar("plane", s.ground, s.body("a_b", fb.disk(2, 0.3)), coordinate="x y phi")
    for svg in (fb.draw(s).svg, fb.free_body_diagram(s, "a_b").svg):
        root = ElementTree.fromstring(svg)
        assert root.tag.endswith("svg") and not any(e.tag.endswith("script") for e in root.iter())
