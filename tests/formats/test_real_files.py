"""A sample of real robots' files, which small packages of the extra ``test`` bring, against MuJoCo and Pinocchio.

All files of larger packages are compared by ``python -m benchmarks robots``. No robot's file is in this repository.
"""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

import freebody as fb
from freebody.errors import FormatError

pytest.importorskip("mujoco")
peer = pytest.importorskip("benchmarks.mujoco_peer", reason="benchmarks are not in the package")

MJCF = {
    "gymnasium": [
        f"envs/mujoco/assets/{name}.xml" for name in (
            "ant", "half_cheetah", "hopper", "humanoid", "humanoidstandup", "inverted_double_pendulum",
            "inverted_pendulum", "point", "pusher", "pusher_v5", "reacher", "swimmer", "walker2d", "walker2d_v5",
        )
    ],
    "mujoco": ["testdata/model.xml"],
}  # fmt: skip
URDF = {
    "jvrc_description": ["urdf/jvrc1.urdf"],
    "upkie_description": ["urdf/upkie.urdf", "urdf/upkie_camera.urdf"],
}
EXACT = 1e-12
"""Difference of both programs' round-off, relative to the largest entry."""


def files(table: dict[str, list[str]]) -> list[object]:
    """The files of the packages, as arguments of a test."""
    return [
        pytest.param(package, file, id=Path(file).name) for package, some in table.items() for file in some
    ]


def place(package: str, file: str) -> Path:
    """The path of a file of an installed package."""
    spec = find_spec(package)
    if spec is None or not spec.submodule_search_locations:
        pytest.skip(f"{package} is not installed")
    path = Path(spec.submodule_search_locations[0], file)
    if not path.is_file():
        pytest.skip(f"this version of {package} has no {file}")
    return path


@pytest.mark.parametrize(("package", "file"), files(MJCF))
def test_a_model_of_mujoco_moves_as_there(package, file):
    path = place(package, file)
    outcome, found = peer.compared(path)
    assert outcome == "compared", found
    assert max(found.differences) < EXACT and not found.unsaid, found
    assert fb.read(path, meshes=False, contacts="floor", limits=True, friction=True).reading.notes is not None


@pytest.mark.parametrize(("package", "file"), files(URDF))
def test_a_robot_moves_as_in_mujoco_and_pinocchio(package, file, monkeypatch):
    # right angles that are written with eleven decimals are right angles in freebody only
    monkeypatch.setattr("freebody.formats.urdf.origin.DECIMALS", 100)
    path = place(package, file)
    s = fb.read(path, symbols="none", meshes=False)
    random = np.random.default_rng(1)
    assert max(peer.of_urdf(path, s, random)) < EXACT
    if find_spec("pinocchio"):
        from benchmarks.robots import Peer

        for base in ("fixed", "free"):
            s = fb.read(path, symbols="none", meshes=False, base=base)
            assert max(Peer(path, base).differences(s, random)) < EXACT


def test_a_link_alone_is_read_and_a_mesh_alone_is_refused():
    assert not fb.read(place("mujoco", "testdata/model.urdf")).joints
    with pytest.raises(FormatError, match="msh.xml, line 1: expected a <worldbody>"):
        fb.read(place("mujoco", "testdata/msh.xml"))
