"""Chains of hinged bodies as plain data, and the same chain in each peer's own description.

The data is general on purpose (mass centre off the axes, full inertia matrix), so that no engine gains
from zeros of a special geometry.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

GRAVITY = (0.0, 0.0, -9.81)


@dataclass(frozen=True)
class Link:
    """One body and the hinge that carries it.

    ``axis`` is "x", "y" or "z" of the parent (and of the body); ``at`` is the hinge point on the parent
    from the parent's origin [m]; the body's origin is the hinge point; ``center`` is its mass centre from
    there [m]; ``inertia`` is the matrix about the mass centre [kg m²], in body axes.
    """

    axis: str
    at: tuple[float, float, float]
    mass: float
    center: tuple[float, float, float]
    inertia: tuple[tuple[float, float, float], ...]


def alternating_chain(n: int) -> list[Link]:
    """``n`` bodies that hang one below the other; the hinge axes are x, y, x, y, ...; no two bodies are alike."""
    random = np.random.default_rng(7)
    links = []
    for i in range(n):
        arm = np.array([0.01, -0.02, -0.3]) + random.uniform(-0.01, 0.01, 3)
        center = np.array([0.02, -0.01, -0.14]) + random.uniform(-0.01, 0.01, 3)
        inertia = np.diag([0.011, 0.0125, 0.0045])
        inertia[np.triu_indices(3, 1)] = [0.0004, -0.0003, 0.0002]
        inertia = np.triu(inertia * random.uniform(0.9, 1.1, (3, 3)))
        inertia = inertia + np.triu(inertia, 1).T
        links.append(
            Link(
                axis="xy"[i % 2],
                at=(0.0, 0.0, 0.0) if i == 0 else tuple(arm.tolist()),
                mass=float(random.uniform(0.8, 1.6)),
                center=tuple(center.tolist()),
                inertia=tuple(map(tuple, inertia.tolist())),
            )
        )
    return links


def chain_state(n: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Angles [rad] and speeds [rad/s] at which the engines are compared."""
    random = np.random.default_rng(seed)
    return random.uniform(-0.6, 0.6, n), random.uniform(-1.0, 1.0, n)


def pinocchio_chain(links: list[Link]) -> tuple[Any, Any]:
    """The chain as Pinocchio's model and data."""
    import pinocchio

    model = pinocchio.Model()
    model.gravity.linear = np.array(GRAVITY)
    joints = {"x": pinocchio.JointModelRX, "y": pinocchio.JointModelRY, "z": pinocchio.JointModelRZ}
    parent = 0
    for i, link in enumerate(links):
        placement = pinocchio.SE3(np.eye(3), np.array(link.at))
        parent = model.addJoint(parent, joints[link.axis](), placement, f"joint{i}")
        inertia = pinocchio.Inertia(link.mass, np.array(link.center), np.array(link.inertia))
        model.appendBodyToJoint(parent, inertia, pinocchio.SE3.Identity())
    return model, model.createData()


def mujoco_chain(links: list[Link], timestep: float = 1e-9, integrator: str = "Euler") -> tuple[Any, Any]:
    """The chain as MuJoCo's model and data, without contacts, constraints, limits or sensors."""
    import mujoco

    axes = {"x": "1 0 0", "y": "0 1 0", "z": "0 0 1"}

    def text(values: Any) -> str:
        return " ".join(repr(float(value)) for value in values)

    opening, closing = [], []
    for i, link in enumerate(links):
        I = link.inertia  # noqa: E741 - the inertia matrix
        full = (I[0][0], I[1][1], I[2][2], I[0][1], I[0][2], I[1][2])
        opening.append(
            f'<body name="body{i}" pos="{text(link.at)}">'
            f'<inertial mass="{link.mass!r}" pos="{text(link.center)}" fullinertia="{text(full)}"/>'
            f'<joint type="hinge" axis="{axes[link.axis]}"/>'
        )
        closing.append("</body>")
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><compiler angle="radian" inertiafromgeom="false"/>'
        f'<option gravity="{text(GRAVITY)}" timestep="{timestep!r}" integrator="{integrator}">'
        f'<flag contact="disable" constraint="disable" sensor="disable" eulerdamp="disable"/></option>'
        f"<worldbody>{''.join(opening)}{''.join(closing)}</worldbody></mujoco>"
    )
    return model, mujoco.MjData(model)
