"""A flying body with six limbs of five hinges each, 36 degrees of freedom, in each engine's own description.

States are (q, u) as freebody has them: position and quaternion (scalar first) of the base, hinge angles; angular and
linear velocity of the base in its own axes, hinge speeds. Each peer's order and axes differ; the conversions are here.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .chains import GRAVITY, Link, alternating_chain

LIMBS, JOINTS = 6, 5
AXES = {"x": "1 0 0", "y": "0 1 0", "z": "0 0 1"}


def limbs() -> tuple[Link, list[list[Link]]]:
    """The base (its hinge is not used), and the limbs from the base outward."""
    links = alternating_chain(1 + LIMBS * JOINTS)
    return links[0], [links[1 + JOINTS * k : 1 + JOINTS * (k + 1)] for k in range(LIMBS)]


def state(seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """A state in which nothing is aligned."""
    random = np.random.default_rng(seed)
    q, u = random.uniform(-0.6, 0.6, 7 + LIMBS * JOINTS), random.uniform(-1, 1, 6 + LIMBS * JOINTS)
    q[3:7] /= np.linalg.norm(q[3:7])
    return q, u


def system() -> Any:
    """For freebody."""
    import freebody as fb

    s = fb.System("floating tree")
    s.gravity = GRAVITY
    base, arms = limbs()
    body = s.body("base", fb.MassProperties(base.mass, base.center, base.inertia))
    s.free("air", s.ground, body, coordinate="f")
    for k, arm in enumerate(arms):
        parent = body
        for i, link in enumerate(arm):
            child = s.body(f"limb{k}_{i}", fb.MassProperties(link.mass, link.center, link.inertia))
            s.hinge(f"joint{k}_{i}", parent, child, at=link.at, axis=link.axis, coordinate=f"q{k}_{i}")
            parent = child
    return s


def pinocchio_tree() -> tuple[Any, Any]:
    """For Pinocchio: its model and data."""
    import pinocchio

    model = pinocchio.Model()
    model.gravity.linear = np.array(GRAVITY)
    joints = {"x": pinocchio.JointModelRX, "y": pinocchio.JointModelRY, "z": pinocchio.JointModelRZ}

    def add(parent: int, joint: Any, link: Link, at: Any, name: str) -> int:
        new = model.addJoint(parent, joint, pinocchio.SE3(np.eye(3), np.array(at)), name)
        inertia = pinocchio.Inertia(link.mass, np.array(link.center), np.array(link.inertia))
        model.appendBodyToJoint(new, inertia, pinocchio.SE3.Identity())
        return new

    base, arms = limbs()
    root = add(0, pinocchio.JointModelFreeFlyer(), base, (0.0, 0.0, 0.0), "air")
    for k, arm in enumerate(arms):
        parent = root
        for i, link in enumerate(arm):
            parent = add(parent, joints[link.axis](), link, link.at, f"joint{k}_{i}")
    return model, model.createData()


def pinocchio_state(q: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Scalar part last; linear velocity first."""
    return np.r_[q[:3], q[4:7], q[3], q[7:]], np.r_[u[3:6], u[:3], u[6:]]


def from_pinocchio(a: np.ndarray) -> np.ndarray:
    """u' of Pinocchio's accelerations."""
    return np.r_[a[3:6], a[:3], a[6:]]


def mujoco_tree(timestep: float) -> tuple[Any, Any]:
    """For MuJoCo: its model and data, without contacts and constraints."""
    import mujoco

    def text(values: Any) -> str:
        return " ".join(repr(float(value)) for value in values)

    def inertial(link: Link) -> str:
        J = link.inertia
        full = (J[0][0], J[1][1], J[2][2], J[0][1], J[0][2], J[1][2])
        return f'<inertial mass="{link.mass!r}" pos="{text(link.center)}" fullinertia="{text(full)}"/>'

    base, arms = limbs()
    parts = [f'<body name="base">{inertial(base)}<freejoint/>']
    for k, arm in enumerate(arms):
        for i, link in enumerate(arm):
            parts.append(f'<body name="limb{k}_{i}" pos="{text(link.at)}">{inertial(link)}')
            parts.append(f'<joint type="hinge" axis="{AXES[link.axis]}"/>')
        parts.append("</body>" * len(arm))
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><compiler angle="radian" inertiafromgeom="false"/>'
        f'<option gravity="{text(GRAVITY)}" timestep="{timestep!r}" integrator="Euler">'
        f'<flag contact="disable" constraint="disable" sensor="disable" eulerdamp="disable"/></option>'
        f"<worldbody>{''.join(parts)}</body></worldbody></mujoco>"
    )
    return model, mujoco.MjData(model)


def rotation(q: np.ndarray) -> np.ndarray:
    """Ground from base."""
    w, x, y, z = q[3:7]
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])  # fmt: skip


def mujoco_state(q: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Linear velocity first, in ground axes."""
    return q, np.r_[rotation(q) @ u[3:6], u[:3], u[6:]]


def from_mujoco(a: np.ndarray, q: np.ndarray, u: np.ndarray) -> np.ndarray:
    """u' of MuJoCo's accelerations: with v = R v_B,  v' = R (v_B' + w × v_B)."""
    return np.r_[a[3:6], rotation(q).T @ a[:3] - np.cross(u[:3], u[3:6]), a[6:]]
