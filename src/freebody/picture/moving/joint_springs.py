"""Springs and dampers on sliders of the ground, in an animation: lines along the axis, and the wall that holds them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...describe.loads.action import JointForce
from ...dynamics.loads.actions import places
from ...dynamics.loads.power import joint_link
from ...dynamics.state import State
from ...model.model import Model
from ...motion.trajectory.quantities import quaternions
from ...space.quaternion import matrix_from_quaternion
from ..machine.shapes import axes_along, numbers
from .keyframes import Keyframes

Array = NDArray[np.float64]


def joint_springs(
    model: Model, state: State, keys: Keyframes, size: float
) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """Return the lines, each with its two ends (body or -1, point of it), and the parts of the walls.

    A wall stands where the spring is still long when the body comes nearest.
    """
    lines: list[dict[str, Any]] = []
    walls: list[dict[str, Any]] = []
    beside: dict[str, int] = {}
    names = list(model.bodies)
    for name, load in model.loads.items():
        for action in places(model)[name]:
            if not (load.look.symbol and isinstance(action, JointForce)):
                continue
            joint = model.joints[action.joint.name]
            link = model.links[joint_link(model, action)]
            if joint.parent != "ground" or joint.child not in names or not joint.pair.guided:
                continue
            child = names.index(joint.child)
            at = numbers(state, joint.at)
            turn = np.array([[float(state(x)) for x in row] for row in link.rotation])
            axis = turn @ numbers(state, link.axis)
            nearest = min(0.0, float(((keys.position[:, child] - at) @ axis).min()))
            wall = at + (nearest - 0.45 * size) * axis
            count = beside.setdefault(action.joint.name, 0)
            beside[action.joint.name] += 1
            aside = 0.08 * size * count * axes_along(axis)[:, 0]
            R = np.array(matrix_from_quaternion(tuple(keys.quaternion[0, child])), dtype=float)
            to = numbers(state, joint.to) + R.T @ aside
            kind = "spring" if load.look.symbol == "zigzag" else "damper"
            ends = [[-1, (wall + aside).tolist()], [child, to.tolist()]]
            lines.append({"name": name, "kind": kind, "ends": ends})
            if not count:
                walls.append(_wall(wall, axis, size))
    return lines, walls


def _wall(at: Array, axis: Array, size: float) -> dict[str, Any]:
    r, h = 0.1 * size, 0.012 * size
    return {
        "kind": "lathe",
        "profile": [[0.0, -2 * h], [r, -2 * h], [r, 0.0], [0.0, 0.0]],
        "at": at.tolist(),
        "turn": quaternions(axes_along(axis)[None])[0].tolist(),
    }
