"""``freebody export``, and ``freebody equations --link``."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import freebody as fb
from freebody.cli import main

ARM = """<mujoco model="arm"><worldbody><body name="left-arm"><joint name="pin" axis="0 1 0"/>
<geom type="capsule" size="0.04" fromto="0 0 0 0 0 -1"/><body name="hand" pos="0 0 -1"/></body></worldbody></mujoco>"""


@pytest.fixture
def freebody(capsys, monkeypatch, tmp_path):
    """The command in a folder with a robot: exit code, and what it printed."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "arm.xml").write_text(ARM)

    def call(*arguments: str) -> tuple[int, str]:
        with pytest.raises(SystemExit) as caught:
            main(list(arguments))
        captured = capsys.readouterr()
        return int(caught.value.code or 0), captured.out + captured.err

    return call


def test_functions_are_written_for_other_programs(freebody, tmp_path):
    code, out = freebody("export", "arm.xml", "--c", "--numpy", "-o", "arm")
    assert code == 0
    assert sorted(Path(line).name for line in out.split()) == ["arm.c", "arm.h", "arm.py"]
    names: dict[str, object] = {}
    exec((tmp_path / "arm" / "arm.py").read_text(), names)
    function: object = names["mass_matrix"]
    expected = fb.compile(fb.read("arm.xml")).mass_matrix([0.3])
    assert np.asarray(function(np.array([0.3]))) == pytest.approx(expected, rel=1e-14)  # type: ignore[operator]


def test_a_machine_is_written_as_a_robot(freebody, tmp_path):
    code, out = freebody("export", "arm.xml", "--urdf", "--mjcf", "--set", "m_left_arm=3", "-o", "out")
    assert code == 0, out
    assert [Path(line).name for line in out.split()] == ["arm.urdf", "arm.xml"]
    for name in ("arm.urdf", "arm.xml"):
        assert fb.read(tmp_path / "out" / name, symbols="none").bodies["left_arm"].mass_properties.mass == 3


def test_casadi_functions_are_saved(freebody, tmp_path):
    casadi = pytest.importorskip("casadi")
    code, _ = freebody("export", "arm.xml", "--casadi", "--product", "mass_matrix", "-o", ".")
    assert code == 0
    assert casadi.Function.load(str(tmp_path / "mass_matrix.casadi")).name() == "mass_matrix"


def test_a_link_is_named_as_in_the_file(freebody):
    assert freebody("equations", "arm.xml", "--link", "left-arm")[1] == freebody(
        "equations", "arm.xml", "--body", "left_arm"
    )[1]  # fmt: skip
    assert (
        freebody("equations", "arm.xml", "--link", "hand")[0] == 0
    )  # a body without joint is part of another


@pytest.mark.parametrize(
    "arguments, message",
    [
        (("export", "arm.xml"), "Expected a language: --c, --casadi, --numpy, --jax, --urdf or --mjcf."),
        (("equations", "arm.xml", "--link", "foot"), "Expected a link of 'arm', got 'foot'; "),
        (
            ("equations", "arm.xml", "--link", "world"),
            "Link 'world' is fixed to the ground, which has no equations.",
        ),
        (
            ("equations", "arm.xml", "--link", "hand", "--body", "a"),
            "Expected --body or --link, got both: a and hand.",
        ),
        (("equations", "ex-6-2", "--link", "hand"), "Expected a robot's file for --link hand; "),
    ],
)
def test_nonsense_is_refused(freebody, arguments, message):
    code, out = freebody(*arguments)
    assert code == 2 and message in " ".join(out.split())
