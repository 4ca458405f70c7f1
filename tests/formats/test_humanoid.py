"""A humanoid that falls on a floor: contacts by events and by time steps, and among its own parts."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import freebody as fb

LEG = """<body name="{0}_thigh" pos="0 {1}0.1 -0.2">
<joint name="{0}_hip_x" axis="1 0 0" damping="5" stiffness="10"/><joint name="{0}_hip_y" axis="0 1 0" damping="5" stiffness="20"/>
<geom name="{0}_thigh" fromto="0 0 0 0 0 -0.34" size="0.06"/>
<body name="{0}_shin" pos="0 0 -0.4"><joint name="{0}_knee" axis="0 -1 0" damping="0.5" stiffness="1"/>
<geom name="{0}_shin" fromto="0 0 0 0 0 -0.3" size="0.05"/>
<body name="{0}_foot" pos="0 0 -0.38"><joint name="{0}_ankle" axis="0 1 0" pos="0 0 0.06" damping="0.5" stiffness="6"/>
<geom name="{0}_foot" fromto="-0.07 0 0 0.14 0 0" size="0.03"/></body></body></body>"""
ARM = """<body name="{0}_arm" pos="0 {1}0.2 0.1">
<joint name="{0}_shoulder" axis="1 0.5 0" damping="0.5" stiffness="1"/><geom name="{0}_arm" fromto="0 0 0 0.1 {1}0.1 -0.2" size="0.04"/>
<body name="{0}_fore" pos="0.1 {1}0.1 -0.23"><joint name="{0}_elbow" axis="0 -1 1" damping="0.5" stiffness="1"/>
<geom name="{0}_fore" fromto="0 0 0 0.15 0 0.1" size="0.03"/></body></body>"""
HUMANOID = f"""<mujoco model="humanoid"><compiler angle="degree"/>
<default><geom type="capsule" friction="0.7" condim="1"/><joint armature="0.01"/></default>
<worldbody><geom name="floor" type="plane" size="9 9 1" friction="0.7"/>
<body name="torso" pos="0 0 1.4"><freejoint name="root"/>
<geom name="chest" fromto="0 -0.07 0 0 0.07 0" size="0.1"/><geom name="head" type="sphere" size="0.09" pos="0 0 0.22"/>
<body name="pelvis" pos="0 0 -0.3"><joint name="waist_y" axis="0 1 0" damping="5" stiffness="20"/>
<joint name="waist_z" axis="0 0 1" damping="5" stiffness="20"/><geom name="pelvis" fromto="0 -0.07 -0.05 0 0.07 -0.05" size="0.09"/>
{LEG.format("left", "")}{LEG.format("right", "-")}</body>
{ARM.format("left", "")}{ARM.format("right", "-")}</body></worldbody></mujoco>"""


@pytest.fixture
def humanoid(tmp_path: Path) -> Path:
    path = tmp_path / "humanoid.xml"
    path.write_text(HUMANOID)
    return path


def check_fall(path: Path, until: float) -> None:
    """Falls from 5 cm above the floor: no overlap, no pull, an energy ledger of round-off."""
    s = fb.read(path, contacts="floor")
    start = fb.on_floor(s, initial=s.reading.initial)
    motion = fb.simulate(s, until, initial=start | {"root_z": start["root_z"] + 0.05, "root_vx": 0.5})
    scale = float(np.abs(motion.energy.kinetic).max())
    assert np.abs(motion.energy.residual).max() < 1e-7 * scale
    assert min(contact.gap.min() for contact in motion.contacts.values()) > -1e-9
    assert (
        min(contact.normal.min() for contact in motion.contacts.values()) > -1e-9 * 1000
    )  # weight 400 to 700 N
    impacts = [event for event in motion.events if "impact" in str(event)]
    assert len(impacts) > 3 and motion["root_z"][-1] < motion["root_z"][0]


@pytest.mark.slow
def test_a_humanoid_falls_by_events(humanoid):
    check_fall(humanoid, 1.0)


@pytest.mark.slow
def test_the_humanoid_of_dm_control_falls_by_events():
    control = pytest.importorskip("dm_control")
    check_fall(Path(control.__file__).parent / "suite" / "humanoid.xml", 1.0)


@pytest.mark.slow
def test_a_humanoid_falls_on_itself_by_time_steps(humanoid):
    s = fb.read(humanoid, contacts="all")
    start = fb.on_floor(s, initial=s.reading.initial) | {"root_vx": 0.5}
    motion = fb.simulate(s, 1.0, initial=start, method="timestepping", step=2e-3)
    assert motion.residual < 1e-9 and motion.depth < 1e-8
    alone = fb.simulate(
        fb.read(humanoid, contacts="floor"), 1.0, initial=start, method="timestepping", step=2e-3
    )
    assert abs(alone["root_x"][-1] - motion["root_x"][-1]) > 0  # its parts met
