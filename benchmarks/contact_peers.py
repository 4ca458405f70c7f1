"""The peers for contact: MuJoCo and Drake, as they come, on the scenes of `contact`."""

from __future__ import annotations

import math
import time
from pathlib import Path
from typing import Any

import numpy as np

G = 9.81


def _mujoco(body: str, step: float, gravity: tuple[float, float], mu: float, elliptic: bool = False) -> Any:
    import mujoco

    cone = ' cone="elliptic"' if elliptic else ""
    text = f"""
    <mujoco>
      <option timestep="{step}" gravity="{gravity[0]!r} 0 {gravity[1]!r}"{cone}/>
      <default><geom friction="{mu} 0 0" condim="3"/></default>
      <worldbody>
        <geom type="plane" size="0 0 1"/>
        <body name="b">
          <joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/><joint type="hinge" axis="0 -1 0"/>
          {body}
        </body>
      </worldbody>
    </mujoco>"""
    model = mujoco.MjModel.from_xml_string(text)
    return model, mujoco.MjData(model)


def _steps(model: Any, data: Any, count: int) -> float:
    """Seconds of ``count`` steps in one call."""
    import mujoco

    begin = time.process_time()
    mujoco.mj_step(model, data, count)
    return time.process_time() - begin


def mujoco_block(
    angle: float, until: float, step: float, mu: float, elliptic: bool = False
) -> tuple[float, float, float]:
    """(displacement, acceleration over the second half, greatest penetration)."""
    import mujoco

    gravity = (G * math.sin(angle), -G * math.cos(angle))
    model, data = _mujoco('<geom type="box" size="0.5 0.5 0.1" mass="2"/>', step, gravity, mu, elliptic)
    data.qpos[1] = 0.1
    count = round(until / step)
    deepest, half = 0.0, 0.0
    for k in range(200):
        mujoco.mj_step(model, data, count // 200)
        if data.ncon:
            deepest = max(deepest, -float(data.contact.dist.min()))
        if k == 99:
            half = float(data.qvel[0])
    return float(data.qpos[0]), (float(data.qvel[0]) - half) / (until / 2), deepest


def mujoco_disk(force: float, until: float, step: float) -> float:
    """Seconds per simulated second of the pulled disk."""
    model, data = _mujoco(
        '<inertial pos="0 0 0" mass="10" diaginertia="0.3 0.45 0.3"/>'
        '<geom type="cylinder" size="0.3 0.05" euler="90 0 0"/>',
        step, (0.0, -G), 0.2,
    )  # fmt: skip
    data.qpos[1] = 0.3
    data.qfrc_applied[:] = (force, 0.0, -force * 0.1)
    return _steps(model, data, round(until / step)) / until


def mujoco_rod(theta: float, until: float, step: float) -> float:
    """Seconds per simulated second of the falling rod, whose ends are small spheres."""
    inertia = 2 * 1.5**2 / 12
    ends = "".join(f'<geom type="sphere" size="0.001" pos="0 0 {z}"/>' for z in (-0.75, 0.75))
    model, data = _mujoco(
        f'<inertial pos="0 0 0" mass="2" diaginertia="{inertia} {inertia} 1e-3"/>{ends}', step, (0.0, -G), 0.3
    )
    data.qpos[:] = (-0.75 * math.sin(theta), 0.75 * math.cos(theta) + 0.001, theta)
    return _steps(model, data, round(until / step)) / until


def mujoco_coins(
    size: tuple[float, float], resistance: float, starts: Any, until: float, step: float
) -> float:
    """Mean seconds of a coin, a cylinder, thrown on a floor, with friction and resistance to rolling and spinning."""
    import mujoco

    model = mujoco.MjModel.from_xml_string(f"""
    <mujoco>
      <option timestep="{step}" gravity="0 0 {-G}"/>
      <default><geom friction="0.4 {resistance} {resistance}" condim="6"/></default>
      <worldbody>
        <geom type="plane" size="0 0 1"/>
        <body><freejoint/><geom type="cylinder" size="{size[0]} {size[1] / 2}" mass="0.005"/></body>
      </worldbody>
    </mujoco>""")
    seconds = 0.0
    for start in starts:
        data = mujoco.MjData(model)
        data.qpos[:] = 0, 0, start["f_z"], *(start[f"f_e{k}"] for k in range(4))
        data.qvel[3:] = [start[f"f_w{c}"] for c in "xyz"]
        seconds += _steps(model, data, round(until / step))
    return seconds / len(starts)


def mujoco_fall(path: Path, height: float, until: float, step: float) -> float:
    """Seconds of a robot in a file that falls from a height above the pose in which it touches the floor."""
    import mujoco

    model = mujoco.MjModel.from_xml_path(str(path))
    model.opt.timestep, data = step, mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    data.qpos[2] += height - float(data.contact.dist.min(initial=0.0))
    data.qvel[0] = 0.0
    return _steps(model, data, round(until / step))


def drake_block(angle: float, until: float, step: float, mu: float) -> tuple[float, float, float]:
    """(displacement, acceleration over the second half, greatest penetration), of a free box in discrete Drake."""
    from pydrake.geometry import Box, HalfSpace
    from pydrake.math import RigidTransform
    from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction
    from pydrake.multibody.tree import SpatialInertia, UnitInertia
    from pydrake.systems.analysis import Simulator
    from pydrake.systems.framework import DiagramBuilder

    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, step)
    plant.mutable_gravity_field().set_gravity_vector([G * math.sin(angle), 0, -G * math.cos(angle)])
    friction = CoulombFriction(mu, mu)
    plant.RegisterCollisionGeometry(plant.world_body(), RigidTransform(), HalfSpace(), "floor", friction)
    inertia = SpatialInertia(2.0, np.zeros(3), UnitInertia.SolidBox(1, 1, 0.2))
    body = plant.AddRigidBody("box", inertia)
    plant.RegisterCollisionGeometry(body, RigidTransform(), Box(1, 1, 0.2), "box", friction)
    plant.Finalize()
    diagram = builder.Build()
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    mine = plant.GetMyContextFromRoot(context)
    plant.SetFreeBodyPose(mine, body, RigidTransform([0.0, 0.0, 0.1]))
    deepest, half = 0.0, 0.0
    for k in range(1, 51):
        simulator.AdvanceTo(until * k / 50)
        deepest = max(deepest, 0.1 - float(plant.EvalBodyPoseInWorld(mine, body).translation()[2]))
        if k == 25:
            half = float(plant.EvalBodySpatialVelocityInWorld(mine, body).translational()[0])
    x = float(plant.EvalBodyPoseInWorld(mine, body).translation()[0])
    last = float(plant.EvalBodySpatialVelocityInWorld(mine, body).translational()[0])
    return x, (last - half) / (until / 2), deepest
