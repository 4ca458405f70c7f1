"""Exudyn on the four machines of `precision`: explicit Runge-Kutta on trees, implicit trapezoidal rule on the loop.

Each builder describes and assembles its machine outside the clock and returns ``solve`` -> (seconds of the solver,
state at the end). Trees are one ``ObjectKinematicTree`` in minimal coordinates; the tumbling body is a rigid body
integrated on the group; the loop is three plane bodies on four joints. The module without range checks, one thread, no
files written.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from .chains import GRAVITY

sys.exudynFast = True  # type: ignore[attr-defined]  # chooses the module, read at its first import

Solve = Callable[[], tuple[float, np.ndarray]]


def tree(
    links: list[dict[str, Any]], gravity: Any, start: tuple[Any, Any], end: float, method: str, setting: float
) -> Solve:
    """Hinged bodies, one hanging on the other; the state at the end is their angles.

    ``links``: axis, at, mass, center and inertia (about the mass centre) of each, as in `chains.Link`.
    """
    import exudyn as exu
    from exudyn.itemInterface import NodeGenericODE2, ObjectKinematicTree

    bodies, n = exu.SystemContainer().AddSystem(), len(links)
    node = bodies.AddNode(
        NodeGenericODE2(
            referenceCoordinates=[0.0] * n, initialCoordinates=[float(q) for q in start[0]],
            initialCoordinates_t=[float(u) for u in start[1]], numberOfODE2Coordinates=n,
        )
    )  # fmt: skip
    turns, offsets, inertias, centers = (
        exu.Matrix3DList(), exu.Vector3DList(), exu.Matrix3DList(), exu.Vector3DList()
    )  # fmt: skip
    for link in links:
        turns.Append(np.eye(3))
        offsets.Append(list(link["at"]))
        inertias.Append(np.array(link["inertia"], dtype=float))
        centers.Append(list(link["center"]))
    bodies.AddObject(
        ObjectKinematicTree(
            nodeNumber=node, jointTypes=[getattr(exu.JointType, f"Revolute{link['axis'].upper()}") for link in links],
            linkParents=list(range(-1, n - 1)), jointTransformations=turns, jointOffsets=offsets,
            linkInertiasCOM=inertias, linkCOMs=centers, linkMasses=[link["mass"] for link in links],
            gravity=list(gravity),
        )
    )  # fmt: skip
    return _solver(bodies, end, method, setting, lambda: bodies.systemData.GetODE2Coordinates())


def chain(links: Any, q: Any, u: Any, end: float, method: str, setting: float) -> Solve:
    """The links of `chains`."""
    return tree([vars(link) for link in links], GRAVITY, (q, u), end, method, setting)


def heavy_top(p: dict[str, Any], end: float, method: str, setting: float) -> Solve:
    """ZXZ angles: two hinges that carry bodies without mass, the third the top."""
    m, R, L = p["m"], p["R"], p["L"]
    nothing = {"at": (0, 0, 0), "mass": 0.0, "center": (0, 0, 0), "inertia": np.zeros((3, 3))}
    inertia = np.diag([m * R**2 / 4, m * R**2 / 4, m * R**2 / 2])
    links = [
        {**nothing, "axis": "z"},
        {**nothing, "axis": "x"},
        {**nothing, "axis": "z", "mass": m, "center": (0, 0, L), "inertia": inertia},
    ]
    start = (0.0, np.arccos(p["cos_theta0"]), 0.0), (0.0, 0.0, p["spin"])
    return tree(links, (0, 0, -p["g"]), start, end, method, setting)


def tumbling_body(p: dict[str, Any], end: float, method: str, setting: float) -> Solve:
    """A free body whose rotation vector is integrated on the group; the state at the end is a quaternion."""
    import exudyn as exu
    from exudyn.rigidBodyUtilities import RigidBodyInertia, RotationMatrix2EulerParameters

    bodies = exu.SystemContainer().AddSystem()
    bodies.CreateRigidBody(
        inertia=RigidBodyInertia(1.0, np.diag(p["moments"])), initialAngularVelocity=list(p["w0"]),
        nodeType=exu.NodeType.RotationRotationVector,
    )  # fmt: skip

    def quaternion() -> np.ndarray:
        attitude = bodies.GetNodeOutput(0, exu.OutputVariableType.RotationMatrix)
        return np.array(RotationMatrix2EulerParameters(np.array(attitude).reshape(3, 3)))

    return _solver(bodies, end, method, setting, quaternion)


def crank_rocker(initial: dict[str, float], end: float, method: str, setting: float) -> Solve:
    """Bars of 0.1, 0.3 and 0.2 m on a base of 0.3 m; the state at the end is alpha, beta, psi."""
    import exudyn as exu
    from exudyn.itemInterface import (
        Force,
        MarkerBodyPosition,
        NodeRigidBody2D,
        ObjectGround,
        ObjectRigidBody2D,
        RevoluteJoint2D,
    )

    bodies = exu.SystemContainer().AddSystem()
    ground = bodies.AddObject(ObjectGround())
    crank, rocker, base = 0.1, 0.2, np.array([0.3, 0.0])
    angle = [initial["alpha"], initial["alpha"] + initial["beta"], initial["psi"]]
    rate = [initial["alpha'"], initial["alpha'"] + initial["beta'"], initial["psi'"]]
    along = [np.array([np.cos(a), np.sin(a)]) for a in angle]
    across = [np.array([-e[1], e[0]]) for e in along]
    lengths = (crank, 0.3, rocker)
    roots = (np.zeros(2), crank * along[0], base)
    root_speeds = (np.zeros(2), crank * rate[0] * across[0], np.zeros(2))
    bars = []
    for i, L in enumerate(lengths):
        place, speed = roots[i] + L / 2 * along[i], root_speeds[i] + L / 2 * rate[i] * across[i]
        node = bodies.AddNode(
            NodeRigidBody2D(referenceCoordinates=[*place, angle[i]], initialVelocities=[*speed, rate[i]])
        )
        bar = bodies.AddObject(
            ObjectRigidBody2D(nodeNumber=node, physicsMass=4 * L, physicsInertia=4 * L**3 / 12)
        )
        weight = bodies.AddMarker(MarkerBodyPosition(bodyNumber=bar))
        bodies.AddLoad(Force(markerNumber=weight, loadVector=[0, -9.81 * 4 * L, 0]))
        bars.append(bar)

    def joint(first: int, at: float, second: int, to: float, place: Any = (0.0, 0.0)) -> None:
        ends = [(first, [at + place[0], place[1], 0]), (second, [to, 0, 0])]
        markers = [bodies.AddMarker(MarkerBodyPosition(bodyNumber=b, localPosition=x)) for b, x in ends]
        bodies.AddObject(RevoluteJoint2D(markerNumbers=markers))

    joint(ground, 0, bars[0], -crank / 2)
    joint(bars[0], crank / 2, bars[1], -0.15)
    joint(ground, 0, bars[2], -rocker / 2, base)
    joint(bars[2], rocker / 2, bars[1], 0.15)

    def angles() -> np.ndarray:
        turned = np.array(angle) + bodies.systemData.GetODE2Coordinates()[2::3]
        return np.array([turned[0], turned[1] - turned[0], turned[2]])

    return _solver(bodies, end, method, setting, angles)


def _solver(bodies: Any, end: float, method: str, setting: float, state: Callable[[], np.ndarray]) -> Solve:
    """``setting``: tolerance of DOPRI5, which controls its steps; length of the steps [s] of every other method."""
    import exudyn as exu

    bodies.Assemble()
    options = exu.SimulationSettings()
    options.solution.file.write = False
    options.solution.sensors.active = False
    options.parallel.numberOfThreads = 1
    scheme = options.timeIntegration
    scheme.endTime, scheme.stepInformation = end, 0
    if method == "DOPRI5":
        scheme.absoluteTolerance = scheme.relativeTolerance = setting
        scheme.numberOfSteps, scheme.initialStepSize, scheme.minimumStepSize = 1, 1e-3, 1e-9
    else:
        scheme.numberOfSteps, scheme.automaticStepSize, scheme.adaptiveStep = (
            round(end / setting),
            False,
            False,
        )
    # the implicit ones: a new Jacobian in each step makes them several times faster here than keeping it until it fails
    scheme.newton.modifiedNewtonJacUpdatePerStep = True
    scheme.newton.relativeTolerance, scheme.newton.absoluteTolerance = 1e-10, 1e-12
    kind = getattr(exu.DynamicSolverType, method)

    def solve() -> tuple[float, np.ndarray]:
        begin = time.perf_counter()
        bodies.SolveDynamic(options, solverType=kind)
        return time.perf_counter() - begin, state()

    return solve
