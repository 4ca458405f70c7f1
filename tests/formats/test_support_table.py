"""The table of what is read says what the readers ask of a file, no more and no less."""

from __future__ import annotations

from collections import defaultdict
from pathlib import Path
from typing import Any

import pytest

import freebody as fb
from freebody.formats.mjcf import words as of_mjcf
from freebody.formats.mjcf.words import ATTRIBUTES, COMPILER
from freebody.formats.mjcf.words import QUIET as QUIET_IN_MJCF
from freebody.formats.urdf import words as of_urdf
from freebody.formats.urdf.words import QUIET, WORDS
from freebody.formats.xml_tree import Element

URDF = """<robot name="arm"><link name="world"/><link name="a">
<inertial><origin xyz="0 0 1" rpy="0 0 0"/><mass value="1"/>
<inertia ixx="1" iyy="1" izz="1" iyx="0" izx="0" izy="0"/></inertial>
<visual><geometry><box size="1 1 1"/></geometry></visual>
<collision><geometry><sphere radius="1"/></geometry></collision></link>
<joint name="pin" type="revolute"><parent link="world"/><child link="a"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/><dynamics damping="1"/></joint>
<link name="b"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link>
<joint name="same" type="continuous"><parent link="world"/><child link="b"/><mimic joint="pin"/></joint></robot>"""
MJCF = """<mujoco><compiler angle="radian"/><option gravity="0 0 -9.81"/>
<asset><mesh name="m" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/></asset>
<worldbody><geom type="plane" size="1 1 1"/><site name="s"/>
<body name="a"><freejoint/><geom type="capsule" fromto="0 0 0 0 0 1" size="0.1"/><geom type="mesh" mesh="m"/></body>
<body name="b"><joint name="j" damping="1" stiffness="1" range="0 1" springdamper="1 1"/>
<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/><geom type="box" size="1 1 1"/><site name="t" pos="0 0 1"/></body>
<body name="c"><joint name="k"/><inertial pos="0 0 0" mass="1" fullinertia="1 1 1 0 0 0"/></body>
</worldbody></mujoco>"""


@pytest.fixture
def asked(monkeypatch) -> dict[str, set[str]]:
    """Attributes that readers ask of the elements of a file, by element."""
    found: dict[str, set[str]] = defaultdict(set)

    class Asked(dict[str, str]):
        tag = ""

        def get(self, name: str, default: Any = None) -> Any:
            found[self.tag].add(name)
            return super().get(name, default)

        def __getitem__(self, name: str) -> str:
            found[self.tag].add(name)
            return super().__getitem__(name)

        def __contains__(self, name: object) -> bool:
            found[self.tag].add(str(name))
            return super().__contains__(name)

    create = Element.__init__

    def recorded(self: Element, tag: str, attributes: dict[str, str], *rest: Any, **options: Any) -> None:
        create(self, tag, Asked(attributes), *rest, **options)
        self.attributes.tag = tag  # type: ignore[attr-defined]

    monkeypatch.setattr(Element, "__init__", recorded)
    return found


def read(path: Path, text: str) -> None:
    path.write_text(text)
    fb.read(path, limits=True, friction=True, contacts="floor")


def test_what_urdf_claims_is_read(tmp_path, asked):
    read(tmp_path / "arm.urdf", URDF)
    for tag, (attributes, _, _) in WORDS.items():
        assert asked[tag] == {*attributes} - {*QUIET.get(tag, ())}, tag


def test_what_mjcf_claims_is_read(tmp_path, asked):
    read(tmp_path / "arm.xml", MJCF)
    asked["joint"] |= asked["freejoint"]
    for tag, words in {**ATTRIBUTES, "compiler": COMPILER}.items():
        claimed = {word for word, what in words.items() if not what} - {*QUIET_IN_MJCF.get(tag, ())}
        assert asked[tag] == claimed, tag


@pytest.mark.parametrize("words", [of_mjcf, of_urdf], ids=["mjcf", "urdf"])
def test_the_page_shows_the_readers_own_table(words):
    page = Path(__file__).parents[2] / "docs" / "robots.md"
    if not page.is_file():
        pytest.skip("the documentation is not in the package")
    assert words.table() in page.read_text(), f"put {words.__name__}.table() into docs/robots.md"
