"""Random machines and the laws that every machine obeys: for the tests of users' own joints and forces.

The machines mix all joints, oblique axes, driven displacements and all kinds of loads.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from .describe.system import System
from .model.model import Model
from .space.mass import MassProperties

JOINTS = ("hinge", "slider", "cylindrical", "screw", "universal", "ball", "gimbal", "planar", "free", "weld")


def random_inertia(rng: np.random.Generator) -> Any:
    """Inertia matrix about the mass centre of a random cloud of points: one that a body can have [kg m²]."""
    points = rng.normal(size=(8, 3))
    points -= points.mean(axis=0)
    squares = (points**2).sum() * np.eye(3) - points.T @ points
    return tuple(tuple(float(x) for x in row) for row in squares / 4)


def random_rotation(rng: np.random.Generator) -> Any:
    """A rotation matrix, uniformly distributed."""
    e = rng.normal(size=4)
    w, x, y, z = e / np.linalg.norm(e)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return tuple(tuple(float(value) for value in row) for row in rows)


def random_system(
    seed: int,
    bodies: int = 4,
    joints: Sequence[str] = JOINTS,
    *,
    branching: bool = True,
    loads: bool = True,
    driven: bool = False,
) -> System:
    """A tree of random bodies joined by random joints, with gravity, springs, dampers and forces.

    Parameters
    ----------
    seed : int
    bodies : int
    joints : sequence of str
        The joint types to choose from.
    branching : bool
        Whether a body may carry several; a chain otherwise.
    loads : bool
        Whether springs, dampers, forces and couples act.
    driven : bool
        Whether the first hinge or slider is a given function of time.
    """
    rng = np.random.default_rng(seed)

    def vector() -> Any:
        return tuple(round(float(x), 3) for x in rng.normal(size=3))

    s = System(f"random {seed}")
    s.gravity = vector()
    made = [s.ground]
    for i in range(bodies):
        mass = round(float(rng.uniform(0.5, 3)), 3)
        body = s.body(f"b{i}", MassProperties(mass, vector(), random_inertia(rng)))
        parent = made[rng.integers(len(made))] if branching else made[-1]
        kind = str(rng.choice(list(joints)))
        given: dict[str, Any] = {"at": vector(), "to": vector(), "parent_axes": random_rotation(rng)}
        given["child_axes"] = random_rotation(rng)
        if kind in ("hinge", "slider", "cylindrical", "screw"):
            given["axis"] = ["x", "y", "z", vector()][rng.integers(4)]
        if kind == "screw":
            given["pitch"] = 0.3
        if kind == "universal":
            given["axis"] = ("x", "y")
        if kind == "gimbal":
            given["axis"] = str(rng.choice(["ZXZ", "XYZ", "YXY"]))
        if driven and kind in ("hinge", "slider"):
            given["coordinate"] = 0.3 * s.t**2 + 0.2 * s.t
            driven = False
        joint = getattr(s, kind)(f"j{i}", parent, body, **given)
        if loads and kind in ("hinge", "slider", "screw", "planar"):
            s.spring(f"k{i}", joint, stiffness=2.5, rest=0.1)
            s.damper(f"c{i}", joint, damping=0.4)
        made.append(body)
    if loads:
        first, last = made[1], made[-1]
        s.force("F", last.point(*vector()), ("3*sin(t)", 1, -2), frame=first)
        s.torque("M", last, vector(), reaction_on=None if first is last else first)
        s.spring("rope", s.ground.point(5, 6, 7), last.point(*vector()), stiffness=1.5, rest=2)
        s.damper("dash", s.ground.point(-5, 6, 7), first.point(*vector()), damping=0.7)
        if s.declared:
            s.generalized_force(next(iter(s.declared)), 1.25)
    return s


def random_chain(seed: int, links: int, axes: Sequence[Any] = ("x", "y", "z")) -> System:
    """A chain of hinges with random bodies: the standard machine of the benchmarks."""
    rng = np.random.default_rng(seed)
    s = System(f"chain of {links}")
    s.gravity = (0, 0, -9.81)
    parent = s.ground
    for i in range(links):
        center: Any = tuple(round(float(x), 3) for x in rng.uniform(-0.2, 0.2, size=3))
        body = s.body(
            f"b{i}", MassProperties(round(float(rng.uniform(0.5, 2)), 3), center, random_inertia(rng))
        )
        at = (0, 0, 0) if i == 0 else (0.3, 0.1, 0.2)
        s.hinge(f"j{i}", parent, body, at=at, axis=axes[i % len(axes)], coordinate=f"q{i}")
        parent = body
    return s


def random_state(model: Model, seed: int) -> tuple[list[float], list[float]]:
    """Random q (unit quaternions normalised) and u."""
    rng = np.random.default_rng(seed)
    q = rng.normal(size=model.n_q)
    for start in model.quaternions:
        q[start : start + 4] /= np.linalg.norm(q[start : start + 4])
    return [float(x) for x in q], [float(x) for x in rng.normal(size=model.n_u)]
