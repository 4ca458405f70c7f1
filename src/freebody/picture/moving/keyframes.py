"""Moments of a motion between which a page interpolates: as many as its accuracy takes, and no more.

Positions and vectors go in straight lines between two moments. A body goes on with the mean of its angular velocities
at both, so that the turns of a fast rotor are counted, and what that misses at the end is turned off evenly on the way.
An interval is halved while the true motion in its middle is farther from that than the tolerance. Where speeds jump (a
blow, an impact) or the forces do (a contact that closes, sticks or slips) there are two moments at one time, before
and after, and nothing is interpolated between them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...dynamics import State, poses
from ...dynamics.kinematics import angular_velocity
from ...motion.ode.dense_output import observe
from ...motion.trajectory.trajectory import quaternions
from ...space.quaternion import Quaternion, quaternion_conjugate, quaternion_product
from .contacts import Contacts, Touched
from .forces import Arrow, applied, arrows

if TYPE_CHECKING:
    from ...motion.trajectory.trajectory import Trajectory

Array = NDArray[np.float64]
Places = NDArray[Any]

TOLERANCE = 2e-3
"""Of the interpolation: of positions in parts of the size of the motion, of angles in rad, of all else in parts of its
greatest value."""

FEWEST = 61
ROUNDS = 14
MOST = 2**14
"""Moments beyond which a finer interpolation is not worth the size of the page."""
LOOSEST = 0.05


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
    part : ndarray of int (n,)
        Number of the phase that each moment belongs to; between two phases the motion jumps.
    touched : Touched or None
        Of machines with contacts: forces, gaps and places of all contacts.
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
    part: Places
    touched: Touched | None
    tolerance: float

    @property
    def breaks(self) -> list[int]:
        """Numbers of the first moments of phases, but for the first of all."""
        return [int(k) + 1 for k in np.flatnonzero(np.diff(self.part))]


def keyframes(trajectory: Trajectory, tolerance: float = TOLERANCE) -> Keyframes:
    """The moments of a motion that a page needs, with all that it shows at them.

    Parameters
    ----------
    trajectory : Trajectory
    tolerance : float
        Greatest error of the interpolation in the middle between two moments: of positions in parts of the extent of
        the motion, of rotations in rad, of forces, coordinates and energies in parts of their greatest value. It is
        doubled, and `Keyframes.tolerance` says so, while it takes more than `MOST` moments, up to `LOOSEST`.

    Returns
    -------
    Keyframes
    """
    source = _Source(trajectory)
    first = source(*source.start())
    found = _refined(source, first, tolerance)
    while len(first.t) < len(found.t) > MOST and 2 * tolerance <= LOOSEST:
        tolerance *= 2
        found = _refined(source, first, tolerance)
    return source.finished(found, tolerance)


def _refined(source: _Source, found: _Sample, tolerance: float) -> _Sample:
    """With the middles of intervals in which the interpolation is not within the tolerance."""
    span = float(found.t[-1] - found.t[0])
    unsure = np.ones(len(found.t) - 1, dtype=bool)
    for _ in range(ROUNDS):
        unsure &= (np.diff(found.t) > 1e-6 * span) & (np.diff(found.part) == 0)
        if not unsure.any():
            break
        at = np.flatnonzero(unsure)
        middle = source((found.t[at] + found.t[at + 1]) / 2, found.part[at])
        wrong = at[source.error(found, at, middle) > tolerance]
        found = found.joined(middle, wrong + 1, np.isin(at, wrong))
        unsure = np.zeros(len(found.t) - 1, dtype=bool)
        left = wrong + np.arange(len(wrong))
        unsure[left] = unsure[left + 1] = True
    return found


def interpolated(a: Array, b: Array, turn: Array, part: float | Array) -> Array:
    """Unit quaternions (n, 4) at the ``part`` s (n, 1) of the way from a to b, with the turn φ (n, 3) on it [rad].

    q(s) = dˢ ∘ e(s φ) ∘ a,    d = b ∘ (e(φ) ∘ a)*,    e(φ) = (cos |φ|/2, φ/|φ| sin |φ|/2)
    """
    spun = quaternion_product(_turned(turn), _components(a))
    w, *v = quaternion_product(_components(b), quaternion_conjugate(spun))
    sine = np.sqrt(v[0] ** 2 + v[1] ** 2 + v[2] ** 2)
    # of d and -d, the same rotation, that with the smaller angle; v over its length, 0 over 0 is 0
    angle = 2 * np.arctan2(sine, np.abs(w)) * np.where(w < 0, -1, 1)
    rest = np.stack(v, axis=1) * (angle / np.where(sine > 0, sine, 1))[:, None]
    here = quaternion_product(_turned(part * turn), _components(a))
    return np.stack(quaternion_product(_turned(part * rest), here), axis=1)


def _components(q: Array) -> Quaternion:
    w, x, y, z = q.T
    return w, x, y, z


def _turned(turn: Array) -> Quaternion:
    """Of rotation vectors (n, 3); sin(x/2)/x is ½ sinc."""
    angle = np.linalg.norm(turn, axis=1)
    x, y, z = turn.T * np.sinc(angle / (2 * np.pi)) / 2
    return np.cos(angle / 2), x, y, z


def _moments(path: Any, events: Array, fewest: float, resolved: bool) -> Array:
    """The steps of a phase, which resolve its motion, no farther apart than ``fewest``, and its events."""
    first, last = min(path.start, path.end), max(path.start, path.end)
    if last == first:
        return np.array([first, first + 1e-9 * max(1.0, abs(first))])
    count = max(2, 1 + int(np.ceil((last - first) / fewest))) if fewest > 0 else 2
    known = [np.linspace(first, last, count), events[(events >= first) & (events <= last)]]
    if resolved:
        known.append(path.times)
    t: Array = np.unique(np.clip(np.concatenate(known), first, last))
    near = np.concatenate([[True], np.diff(t) > 1e-9 * (last - first)])
    near[-1] = True
    return np.asarray(t[near])


@dataclass(frozen=True, eq=False)
class _Sample:
    """Values at some moments; ``rest`` holds all that is interpolated in straight lines, but for positions; ``extra``
    what is shown and not asked how straight it is."""

    t: Array
    part: Places
    states: Array
    position: Array
    rotation: Array
    spin: Array
    rest: Array
    extra: Array

    def joined(self, other: _Sample, places: Places, chosen: Places) -> _Sample:
        """With those chosen of the other inserted."""
        return _Sample(
            *(
                np.insert(getattr(self, name), places, getattr(other, name)[chosen], axis=0)
                for name in ("t", "part", "states", "position", "rotation", "spin", "rest", "extra")
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
        self.phases = phases_of(trajectory)
        self.contacts = Contacts(trajectory) if model.contacts else None
        # of steps of a given length, forces are means over a step: they jump from each to the next
        self.stepped = not hasattr(trajectory.path, "segments") and self.contacts is not None

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

        self.scene = kernels.program("keyframes", scene)
        # 3 components of each reaction's force and moment; arrows take them from here
        self.joints = {name: i for i, (name, _, _) in enumerate(kernels.transmitting)}

    def start(self) -> tuple[Array, Places]:
        """Moments to begin with, and the phases that they belong to."""
        path = self.trajectory.path
        events = np.array([event.time for event in self.trajectory.events], dtype=float)
        longest = abs(path.end - path.start) / (FEWEST - 1)
        times = [
            _moments(phase.path, events if len(self.phases) == 1 else events[:0], longest, not self.stepped)
            for phase in self.phases
        ]
        return np.concatenate(times), np.repeat(np.arange(len(times)), [len(one) for one in times])

    def __call__(self, t: Array, part: Places) -> _Sample:
        kernels = self.trajectory.kernels
        rows = [self._of_phase(k, t, part) for k in np.unique(part)]
        order = np.argsort(np.concatenate([chosen for chosen, *_ in rows]), kind="stable")
        states, reactions, ledger = (np.concatenate([row[i] for row in rows])[order] for i in (1, 2, 3))
        pose = self._observed(self.scene, "pose", t, states).reshape(len(t), self.count, 12)
        spin = self._observed(self.scene, "spin", t, states).reshape(len(t), self.count, 3)
        loads = self._observed(self.scene, "loads", t, states)
        energy = self._observed(kernels.motion(), "energy", t, states)
        extra = np.zeros((len(t), 0))
        touched = extra
        if self.contacts is not None:
            forces = np.concatenate([row[4] for row in rows])[order]
            touched, extra = forces, self.contacts.geometry(t, states)
            if self.stepped:
                touched, extra = forces[:, :0], np.concatenate([reactions, forces, extra], axis=1)
                reactions = reactions[:, :0]
        n = self.model.n_q + self.model.n_u
        rest = np.concatenate([loads, reactions, energy, ledger, states[:, :n], touched], axis=1)
        rotation = pose[:, :, 3:].reshape(len(t), self.count, 3, 3)
        return _Sample(t, part, states, pose[:, :, :3], rotation, spin, rest, extra)

    def _of_phase(self, k: int, t: Array, part: Places) -> tuple[Any, ...]:
        """(which moments, states, reactions, work and heat, contact forces) of those in a phase."""
        trajectory = self.trajectory
        chosen = np.flatnonzero(part == k)
        phase = self.phases[k]
        low, high = sorted((phase.path.start, phase.path.end))
        times = np.clip(t[chosen], low, high)
        states = phase.path.sample(times)
        stepping: Any = trajectory
        if self.stepped:
            reactions = stepping.mean_reactions(times)
        else:
            reactions = self._observed(phase.kernels.reactions(), "reactions", times, states)
        n = self.model.n_q + self.model.n_u
        ledger = np.zeros((len(times), 2))
        if self.stepped:
            ledger[:, 0] = stepping.work_until(times)[:, 0]
        else:
            if trajectory.kernels.works or states.shape[1] > n:
                ledger[:, 0] = states[:, n]
            ledger[:, 0] += phase.impulses
            if states.shape[1] > n + 1:
                ledger[:, 1] = states[:, n + 1]
        forces = (
            np.zeros((len(times), 0)) if self.contacts is None else self.contacts.forces(phase, times, states)
        )
        return chosen, states, reactions[:, : 6 * len(self.joints)], ledger, forces

    def _observed(self, program: Any, function: str, t: Array, states: Array) -> Array:
        constants = program.constants(self.parameters)
        return observe(program.address(function), program.outputs(function), t, states, constants)

    def error(self, found: _Sample, at: Places, middle: _Sample) -> Array:
        """Of the interpolation in the middles, after each of the moments ``at``, in parts of what is allowed as 1."""
        p = found.position
        extent = max(float(np.ptp(p.reshape(-1, 3), axis=0).max(initial=0.0)), 1e-12) if p.size else 1.0
        off = (
            np.linalg.norm((p[at] + p[at + 1]) / 2 - middle.position, axis=2).max(axis=1, initial=0.0)
            / extent
        )
        turn = np.zeros(len(at))
        lasting = np.diff(found.t)[at][:, None]
        for i in range(self.count):
            a, b = (quaternions(found.rotation[j, i]) for j in (at, at + 1))
            m = quaternions(middle.rotation[:, i])
            w_a, w_b = found.spin[at, i], found.spin[at + 1, i]
            mean = (w_a + w_b) / 2
            half = interpolated(a, b, mean * lasting, 0.5)
            away = np.minimum(np.linalg.norm(half - m, axis=1), np.linalg.norm(half + m, axis=1))
            # of a spin with a bend, mean + 4 s (1 - s) δ, the error δ Δt (s - 3 s² + 2 s³) 2/3 is 0 in the middle
            bend = np.linalg.norm((middle.spin[:, i] - mean) * lasting, axis=1) * math.sqrt(3) / 27
            # and where its axis moves by an angle, the body goes round the mean axis in place of the axes on the way
            size = np.maximum(np.linalg.norm(mean, axis=1), 1e-150)  # its square is no zero
            rounds = np.minimum(1, size * lasting[:, 0] / (2 * np.pi))
            sway = np.linalg.norm(np.cross(w_a, w_b), axis=1) / size**2 * rounds
            turn = np.max([turn, 2 * away, bend, sway], axis=0)
        scale = np.abs(found.rest).max(axis=0, initial=0.0)
        scale = np.maximum(scale, 1e-9 * max(1.0, float(scale.max(initial=0.0))))
        bent = (np.abs((found.rest[at] + found.rest[at + 1]) / 2 - middle.rest) / scale).max(
            axis=1, initial=0.0
        )
        return np.asarray(np.maximum(np.maximum(off, turn), bent))

    def finished(self, found: _Sample, tolerance: float) -> Keyframes:
        n_loads, n_joints = 3 * len(self.loads), 6 * len(self.joints)
        loads, reactions = found.rest[:, :n_loads], found.rest[:, n_loads : n_loads + n_joints]
        if self.stepped:
            reactions, n_joints = found.extra[:, :n_joints], 0
        T, V, W, heat = found.rest[:, n_loads + n_joints : n_loads + n_joints + 4].T
        vectors = {arrow.key: loads[:, 3 * i : 3 * i + 3] for i, arrow in enumerate(self.loads)}
        for arrow in self.arrows:
            if arrow.group == "reaction" and arrow.contact is None:
                first = 6 * self.joints[arrow.name] + 3 * (arrow.kind == "moment")
                vectors[arrow.key] = reactions[:, first : first + 3]
        energy = {"kinetic": T, "potential": V, "total": T + V}
        if self.trajectory.kernels.works or hasattr(self.trajectory.path, "segments") or self.stepped:
            energy["work"] = W
        if np.any(heat):
            energy["heat of friction"] = heat
        touched = None
        if self.contacts is not None:
            width = self.contacts.rows
            extra = found.extra[:, 6 * len(self.joints) * self.stepped :]
            forces = extra[:, :width] if self.stepped else found.rest[:, -width:]
            touched = self.contacts.touched(forces, extra[:, width * self.stepped :])
            for arrow in self.arrows:
                if arrow.contact is not None:
                    vectors[arrow.key] = touched.force(arrow.contact, arrow.role == "friction")
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
            found.part,
            touched,
            tolerance,
        )


@dataclass(frozen=True, eq=False)
class Phase:
    """Part of a motion in which nothing jumps; ``impulses`` is the work of all jumps before it [J]."""

    path: Any
    kernels: Any
    impulses: float = 0.0
    modes: tuple[str, ...] = ()


def phases_of(trajectory: Trajectory) -> list[Phase]:
    """The phases of a motion, without those too short to be seen."""
    path: Any = trajectory.path
    segments = getattr(path, "segments", None)
    if segments is None:
        return [Phase(path, trajectory.kernels)]
    least = 1e-9 * abs(path.end - path.start)
    long = [one for one in segments if abs(one.path.end - one.path.start) > least] or segments[-1:]
    return [Phase(one.path, one.kernels, one.impulses, tuple(one.modes)) for one in long]


@dataclass(frozen=True)
class Named:
    """A body by its name alone, as the algorithms ask for it."""

    name: str
    is_ground: bool = False
