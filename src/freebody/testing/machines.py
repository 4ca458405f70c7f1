"""Random machines: all joints, oblique axes, driven displacements and all kinds of loads."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import numpy as np

from ..describe.description import coordinates_of
from ..describe.joints.rotor import Rotor
from ..describe.system import System
from ..space.mass import MassProperties

JOINTS = ("hinge", "slider", "cylindrical", "screw", "universal", "ball", "gimbal", "planar", "free", "weld")


def random_inertia(rng: np.random.Generator) -> Any:
    """Inertia matrix about the mass centre of random particles, which a body can have [kg m²]."""
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


def small_inertia(rng: np.random.Generator) -> Any:
    """Inertia matrix about the mass centre of four particles and their mirror images [kg m²]."""
    points = rng.integers(-1, 2, size=(4, 3)) + np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, 0]])
    squares = (points**2).sum() * np.eye(3, dtype=int) - points.T @ points
    return tuple(tuple(2 * int(x) for x in row) for row in squares + np.eye(3, dtype=int))


def small_rotation(rng: np.random.Generator) -> Any:
    """An exactly orthogonal rotation matrix of small fractions."""
    quaternion = [(1, 0, 0, 0), (1, 1, 1, 1), (1, 1, 0, 0), (1, 0, -1, 0), (1, 3, 1, 1), (2, 1, 2, 0)]
    w, x, y, z = quaternion[rng.integers(len(quaternion))]
    n = w * w + x * x + y * y + z * z
    rows = [
        [n - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), n - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), n - 2 * (x * x + y * y)],
    ]
    return tuple(tuple(Fraction(value, n) for value in row) for row in rows)


def random_system(
    seed: int,
    bodies: int = 4,
    joints: Sequence[str] = JOINTS,
    *,
    branching: bool = True,
    loads: bool = True,
    driven: bool = False,
    small: bool = False,
    armature: bool = False,
) -> System:
    """Return a tree of random bodies joined by random joints, with gravity, springs, dampers and forces.

    Parameters
    ----------
    seed : int
    bodies : int
    joints : sequence of str
        The joint types to choose from.
    branching : bool
        If true, a body may carry several bodies; else the machine is a chain.
    loads : bool
        If true, springs, dampers, forces and couples act.
    driven : bool
        If true, the first hinge or slider is a given function of time.
    small : bool
        If true, numbers are small integers and axes exactly orthogonal, which exact symbols handle fast.
    armature : bool
        If true, joints with one displacement turn a rotor in their parent, and all others have armature.
    """
    rng = np.random.default_rng(seed)

    def vector() -> Any:
        if small:
            return tuple(int(x) for x in rng.integers(1, 3, size=3) * rng.choice([-1, 1], size=3))
        return tuple(round(float(x), 3) for x in rng.normal(size=3))

    s = System(f"random {seed}")
    s.gravity = vector()
    carriers = [s.ground]
    for i in range(bodies):
        mass = int(rng.integers(1, 4)) if small else round(float(rng.uniform(0.5, 3)), 3)
        body = s.body(
            f"b{i}", MassProperties(mass, vector(), (small_inertia if small else random_inertia)(rng))
        )
        parent = carriers[rng.integers(len(carriers))] if branching else carriers[-1]
        kind = str(rng.choice(list(joints)))
        rotation = small_rotation if small else random_rotation
        arguments: dict[str, Any] = {"at": vector(), "to": vector(), "parent_axes": rotation(rng)}
        arguments["child_axes"] = rotation(rng)
        if kind in ("hinge", "slider", "cylindrical", "screw"):
            arguments["axis"] = ["x", "y", "z", vector()][rng.integers(4)]
        if kind == "screw":
            arguments["pitch"] = 0.3
        if kind == "universal":
            arguments["axis"] = ("x", "y")
        if kind == "gimbal":
            arguments["axis"] = str(rng.choice(["ZXZ", "XYZ", "YXY"]))
        if driven and kind in ("hinge", "slider"):
            arguments["coordinate"] = 0.3 * s.t**2 + 0.2 * s.t
            driven = False
        if armature:
            arguments |= _armature(kind, i)
        joint = getattr(s, kind)(f"j{i}", parent, body, **arguments)
        if loads and kind in ("hinge", "slider", "screw", "planar"):
            s.spring(f"k{i}", joint, stiffness=2.5, rest=0.1)
            s.damper(f"c{i}", joint, damping=0.4)
        carriers.append(body)
    if loads:
        first, last = carriers[1], carriers[-1]
        s.force("F", last.point(*vector()), ("3*sin(t)", 1, -2), frame=first)
        s.torque("M", last, vector(), reaction_on=None if first is last else first)
        s.spring("rope", s.ground.point(5, 6, 7), last.point(*vector()), stiffness=1.5, rest=2)
        s.damper("dash", s.ground.point(-5, 6, 7), first.point(*vector()), damping=0.7)
        if coordinates_of(s):
            s.generalized_force(next(iter(coordinates_of(s))), 1.25)
    return s


def _armature(kind: str, i: int) -> dict[str, Any]:
    """Armature of the i-th joint, or a rotor: about the joint's axis, and about another one."""
    if kind in ("hinge", "slider", "screw"):
        return {"rotor": Rotor(Fraction(i + 2, 4), 2 - 5 * (i % 2), axis=None if i % 2 else (1, 2, 2))}
    return {} if kind == "weld" else {"armature": (2, 3) if kind == "free" else 2}


def random_chain(seed: int, links: int, axes: Sequence[Any] = ("x", "y", "z")) -> System:
    """Return a chain of hinges with random bodies, the standard machine of the benchmarks."""
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
