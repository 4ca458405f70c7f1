"""Models in MJCF against MuJoCo, where it is installed: mass matrix, bias forces, forward dynamics and poses."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import freebody as fb

pytest.importorskip("mujoco")
peer = pytest.importorskip("benchmarks.mujoco_peer", reason="benchmarks are not in the package")

WALKER = """<mujoco model="walker">
<compiler eulerseq="ZYX" boundmass="0.02"/>
<default><joint damping="0.3" armature="0.05"/><geom type="capsule" size="0.05" density="700"/>
<position kp="30" kv="1"/>
<default class="leg"><joint axis="0 1 0" stiffness="4" springref="20"/></default></default>
<worldbody><geom type="plane" size="1 1 1"/>
<body name="trunk" pos="0 0 1" euler="10 20 30"><joint type="free" stiffness="2"/>
<geom type="box" size="0.2 0.1 0.3" pos="0.1 0 0"/>
<frame pos="0 0.1 -0.3" axisangle="1 0 0 20">
<body name="thigh" childclass="leg"><joint name="abduct" axis="1 0 0" pos="0 0.02 0"/><joint name="swing" ref="15"/>
<geom fromto="0 0 0 0.1 0 -0.5"/><body name="shin" pos="0.1 0 -0.5" xyaxes="1 0.1 0 0 1 0"><joint name="knee"/>
<geom fromto="0 0 0 0 0 -0.5"/><geom type="ellipsoid" size="0.1 0.05 0.02" pos="0.05 0 -0.5" quat="1 0.2 0 0"/>
<body name="sole" pos="0 0 -0.55"><geom type="cylinder" size="0.03 0.02" mass="0.1"/></body></body></body></frame>
<body name="head" pos="0 0 0.4"><joint name="neck" type="ball" damping="0.2" stiffness="0.8"/>
<inertial pos="0 0 0.1" mass="1.2" fullinertia="0.01 0.02 0.025 0.001 -0.002 0.003"/>
<body name="eye" pos="0.1 0 0"><joint name="focus" type="slide" axis="1 1 0" damping="2"/>
<geom type="sphere" size="0.02"/>
</body></body></body></worldbody>
<tendon><fixed name="cord" stiffness="3" damping="0.4"><joint joint="swing" coef="1.5"/>
<joint joint="knee" coef="-1"/></fixed>
</tendon>
<actuator><motor name="a" joint="abduct" gear="12" ctrlrange="-0.5 0.5"/><position name="b" joint="swing" gear="2"/>
<velocity name="c" joint="focus" kv="4"/><motor name="d" tendon="cord" forcerange="-0.3 0.3"/>
<general name="e" joint="knee" gaintype="affine" gainprm="1 0.5 0.2" biastype="affine" biasprm="0.1 -2 -0.3"/>
</actuator>
</mujoco>"""


def test_a_walker_moves_as_in_mujoco(tmp_path: Path):
    path = tmp_path / "walker.xml"
    path.write_text(WALKER)
    outcome, found = peer.compared(path)
    assert outcome == "compared" and len(fb.read(path).reading.inputs) == 5
    assert (found.differences < 1e-13).all(), found


def test_a_hinge_and_a_ball_of_one_body_move_as_in_mujoco(tmp_path: Path):
    """Read, and written and read again; of a ball beside a hinge only what acts against its turn is left out."""
    arm = (
        '<joint name="yaw" axis="0 0.6 0.8" pos="0.05 0 0.02" damping="0.3" stiffness="2" ref="10" armature="0.02"/>'
        '<joint name="neck" type="ball" pos="0.1 0.02 -0.03" armature="0.1"{}/>'
        '<geom type="box" size="0.1 0.15 0.25" pos="0.1 0 0.2" mass="2"/>'
    )
    whole = (
        '<mujoco model="arm"><default><geom contype="0" conaffinity="0"/></default><worldbody>'
        '<body name="base"><joint name="pin" axis="0 1 0"/>'
        '<geom type="sphere" size="0.1"/><body name="arm" pos="0.3 0.1 0.2" euler="20 10 5">{}</body></body>'
        "</worldbody></mujoco>"
    )
    path, second = tmp_path / "arm.xml", tmp_path / "second.xml"
    path.write_text(whole.format(arm.format("")))
    system = fb.read(path, symbols="none")
    fb.write(system, second)
    for file in (path, second):
        outcome, found = peer.compared(file)
        assert outcome == "compared" and (found.differences < 1e-14).all(), found
        assert fb.assemble(fb.read(file)).coordinate_names == (
            "pin",
            "yaw",
            *(f"neck_e{i}" for i in range(4)),
        )
    assert not system.reading.notes
    path.write_text(whole.format(arm.format(' damping="0.2" stiffness="3" frictionloss="1" range="0 40"')))
    read = fb.read(path, symbols="none", limits=True, friction=True)
    (note,) = read.reading.notes
    assert "a ball beside hinges of its body moves without what acts against its turn" in str(read.reading)
    assert note.detail == "spring, damper, dry friction, stop"
    same = fb.assemble(read)
    assert same.links == fb.assemble(system).links


def test_mujoco_takes_our_inertias_in_exact_principal_axes(tmp_path):
    """What the benchmark does where the two differ: nothing else changes, and the report says all that is left out."""
    path = tmp_path / "walker.xml"
    path.write_text(WALKER)
    system = peer.tree_of(fb.read(path, symbols="none", meshes=False))
    theirs = peer.Peer(path)
    theirs.only(system)
    assert theirs.with_inertias_of(system) < 1e-13
    assert max(theirs.differences(system, np.random.default_rng(1))) < 1e-13
    assert not theirs.unsaid(system)
    system.reading._notes.clear()
    theirs.model.opt.density = 1
    assert "no fluid acts" in theirs.unsaid(system)
