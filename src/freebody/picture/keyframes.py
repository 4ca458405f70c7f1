"""Moments of a motion between which a page interpolates: as many as its accuracy takes, and no more.

Positions and vectors go in straight lines between two moments, rotations at a constant rate about one axis. An
interval is halved while the true motion in its middle is farther from that than the tolerance.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..dynamics import State, poses
from ..dynamics.kinematics import angular_velocity
from ..simulate.path import observe
from ..simulate.trajectory import quaternions
from .forces import Arrow, applied, arrows

if TYPE_CHECKING:
    from ..simulate.trajectory import Trajectory

Array = NDArray[np.float64]
Places = NDArray[Any]

TOLERANCE = 2e-3
"""Of the interpolation: of positions in parts of the size of the motion, of angles in rad, of all else in parts of its
greatest value."""

FEWEST = 61
ROUNDS = 14
TURN = 2.0
"""Most that a body turns between two moments [rad]; beyond π a rotation would be taken for that the other way."""


@dataclass(frozen=True, eq=False)
class Keyframes:
    """Everything that a page shows of a motion, at n moments.

    Attributes
    ----------
    t : ndarray (n,)
        [s]
    position : ndarray (n, bodies, 3)
        Of the origins of the bodies, in ground axes [m].
    quaternion : ndarray (n, bodies, 4)
        Ground from body, scalar first, continuous in time.
    spin : ndarray (n, bodies, 3)
        Angular velocity in the ground, in ground axes [rad/s].
    arrows : tuple of Arrow
        Forces and moments, loads first.
    vectors : dict of ndarray (n, 3)
        Of every arrow by its key, in ground axes [N] or [N m].
    states : ndarray (n, ...)
        Coordinates and speeds.
    energy : dict of ndarray (n,)
        ``kinetic``, ``potential``, ``total`` and, where loads without potential or drives do work, ``work`` [J].
    residual : ndarray (n,)
        What the energy ledger fails to balance [J].
    tolerance : float
        Of the interpolation.
    """

    t: Array
    position: Array
    quaternion: Array
    spin: Array
    arrows: tuple[Arrow, ...]
    vectors: Mapping[str, Array]
    states: Array
    energy: Mapping[str, Array]
    residual: Array
    tolerance: float


def keyframes(trajectory: Trajectory, tolerance: float = TOLERANCE) -> Keyframes:
    """The moments of a motion that a page needs, with all that it shows at them.

    Parameters
    ----------
    trajectory : Trajectory
    tolerance : float
        Greatest error of the interpolation in the middle between two moments: of positions in parts of the extent of
        the motion, of rotations in rad, of forces, coordinates and energies in parts of their greatest value.

    Returns
    -------
    Keyframes
    """
    source = _Source(trajectory)
    t = _start(trajectory)
    found = source(t)
    # a body that turns far between two moments could seem to turn the other way
    spin = np.linalg.norm(found.spin, axis=2).max(axis=1, initial=0.0)
    fastest = np.maximum(spin[:-1], spin[1:])
    parts = np.maximum(1, np.ceil(np.diff(t) * fastest / TURN)).astype(int)
    if np.any(parts > 1):
        t = np.concatenate(
            [np.linspace(a, b, n, endpoint=False) for a, b, n in zip(t[:-1], t[1:], parts, strict=True)]
            + [t[-1:]]
        )
        found = source(t)
    span = float(t[-1] - t[0])
    unsure = np.ones(len(t) - 1, dtype=bool)
    for _ in range(ROUNDS):
        unsure &= np.diff(t) > 1e-6 * span
        if not unsure.any():
            break
        at = np.flatnonzero(unsure)
        middle = source((t[at] + t[at + 1]) / 2)
        wrong = at[source.error(found, at, middle) > tolerance]
        chosen = np.isin(at, wrong)
        t = np.insert(t, wrong + 1, middle.t[chosen])
        found = found.joined(middle, wrong + 1, chosen)
        unsure = np.zeros(len(t) - 1, dtype=bool)
        left = wrong + np.arange(len(wrong))
        unsure[left] = unsure[left + 1] = True
    return source.finished(found, tolerance)


def _start(trajectory: Trajectory) -> Array:
    """The steps of the run, which resolve its motion, no fewer than FEWEST, and the events."""
    path = trajectory.path
    first, last = min(path.start, path.end), max(path.start, path.end)
    known = [
        path.times,
        np.linspace(first, last, FEWEST),
        np.array([event.time for event in trajectory.events]),
    ]
    t: Array = np.unique(np.clip(np.concatenate(known), first, last))
    if len(t) < 2:
        return np.array([first, first + 1e-9 * max(1.0, abs(first))]) if last == first else t
    near = np.concatenate([[True], np.diff(t) > 1e-9 * (last - first)])
    near[-1] = True
    return np.asarray(t[near])


@dataclass(frozen=True, eq=False)
class _Sample:
    """Values at some moments; ``rest`` holds all that is interpolated in straight lines, but for positions."""

    t: Array
    states: Array
    position: Array
    rotation: Array
    spin: Array
    rest: Array

    def joined(self, other: _Sample, places: Places, chosen: Places) -> _Sample:
        """With those chosen of the other inserted."""
        return _Sample(
            *(
                np.insert(getattr(self, name), places, getattr(other, name)[chosen], axis=0)
                for name in ("t", "states", "position", "rotation", "spin", "rest")
            )
        )


class _Source:
    """What a trajectory says at any moment."""

    def __init__(self, trajectory: Trajectory) -> None:
        self.trajectory = trajectory
        kernels = trajectory.kernels
        self.model = model = kernels.model
        self.parameters = kernels.parameters(trajectory.values)
        self.arrows = arrows(kernels)
        self.loads = [arrow for arrow in self.arrows if arrow.group == "force"]
        self.count = len(model.bodies)

        def scene(state: State) -> dict[str, Any]:
            found = poses(model, state)
            pose = [
                x
                for name in model.bodies
                for x in (*found[name].position, *(x for row in found[name].rotation for x in row))
            ]
            spins = [x for name in model.bodies for x in angular_velocity(model, state, Named(name))]
            loads = [x for _, vector in applied(model, state) for x in vector]
            return {"pose": pose, "spin": spins, "loads": loads}

        self.scene = kernels.program("scene", scene)
        # 3 components of each reaction's force and moment; arrows take them from here
        self.joints = {name: i for i, (name, _, _) in enumerate(kernels.transmitting)}

    def __call__(self, t: Array) -> _Sample:
        trajectory, kernels = self.trajectory, self.trajectory.kernels
        low, high = sorted((trajectory.path.start, trajectory.path.end))
        t = np.clip(t, low, high)
        states = trajectory.path.sample(t)
        pose = self._observed(self.scene, "pose", t, states).reshape(len(t), self.count, 12)
        spin = self._observed(self.scene, "spin", t, states).reshape(len(t), self.count, 3)
        loads = self._observed(self.scene, "loads", t, states)
        reactions = self._observed(kernels.reactions(), "reactions", t, states)
        energy = self._observed(kernels.motion(), "energy", t, states)
        n = self.model.n_q + self.model.n_u
        work = states[:, n:] if kernels.works else np.zeros((len(t), 1))
        rest = np.concatenate([loads, reactions, energy, work, states[:, :n]], axis=1)
        rotation = pose[:, :, 3:].reshape(len(t), self.count, 3, 3)
        return _Sample(t, states, pose[:, :, :3], rotation, spin, rest)

    def _observed(self, program: Any, function: str, t: Array, states: Array) -> Array:
        constants = program.constants(self.parameters)
        return observe(program.address(function), program.outputs(function), t, states, constants)

    def error(self, found: _Sample, at: Places, middle: _Sample) -> Array:
        """Of the interpolation in the middles, after each of the moments ``at``, in parts of what is allowed as 1."""
        p = found.position
        size = max(float(np.ptp(p.reshape(-1, 3), axis=0).max(initial=0.0)), 1e-12) if p.size else 1.0
        off = (
            np.linalg.norm((p[at] + p[at + 1]) / 2 - middle.position, axis=2).max(axis=1, initial=0.0) / size
        )
        # half way at a constant rate, R = R_0 exp(log(R_0ᵀ R_1)/2): the middle is as far from both ends
        turn = np.zeros(len(at))
        for i in range(self.count):
            a, b = (quaternions(found.rotation[j, i]) for j in (at, at + 1))
            m = quaternions(middle.rotation[:, i])
            b = b * np.where(np.sum(a * b, axis=1) < 0, -1, 1)[:, None]
            half = a + b
            half /= np.linalg.norm(half, axis=1)[:, None]
            away = np.minimum(np.linalg.norm(half - m, axis=1), np.linalg.norm(half + m, axis=1))
            turn = np.maximum(turn, 2 * away)
        scale = np.abs(found.rest).max(axis=0, initial=0.0)
        scale = np.maximum(scale, 1e-9 * max(1.0, float(scale.max(initial=0.0))))
        bent = (np.abs((found.rest[at] + found.rest[at + 1]) / 2 - middle.rest) / scale).max(
            axis=1, initial=0.0
        )
        return np.asarray(np.maximum(np.maximum(off, turn), bent))

    def finished(self, found: _Sample, tolerance: float) -> Keyframes:
        n_loads, n_joints = 3 * len(self.loads), 6 * len(self.joints)
        loads, reactions = found.rest[:, :n_loads], found.rest[:, n_loads : n_loads + n_joints]
        T, V, W = found.rest[:, n_loads + n_joints : n_loads + n_joints + 3].T
        vectors = {arrow.key: loads[:, 3 * i : 3 * i + 3] for i, arrow in enumerate(self.loads)}
        for arrow in self.arrows:
            if arrow.group == "reaction":
                first = 6 * self.joints[arrow.name] + 3 * (arrow.kind == "moment")
                vectors[arrow.key] = reactions[:, first : first + 3]
        energy = {"kinetic": T, "potential": V, "total": T + V}
        if self.trajectory.kernels.works:
            energy["work"] = W
        shape = (len(found.t), self.count, 4)
        turns = [quaternions(found.rotation[:, i]) for i in range(self.count)]
        return Keyframes(
            found.t,
            found.position,
            np.stack(turns, axis=1) if turns else np.zeros(shape),
            found.spin,
            tuple(self.arrows),
            vectors,
            found.states,
            energy,
            T + V - (T[0] + V[0]) - (W - W[0]),
            tolerance,
        )


@dataclass(frozen=True)
class Named:
    """A body by its name alone, as the algorithms ask for it."""

    name: str
    is_ground: bool = False
