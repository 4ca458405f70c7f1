"""Keyframes: the moments of a motion between which a page interpolates, as many as the tolerance takes and no more.

Between two moments, positions and vectors are interpolated linearly. A body turns with the mean of its angular
velocities at both, so that the turns of a fast rotor are counted; the remaining error at the end is spread evenly over
the interval. An interval is halved while the true motion at its middle differs from the interpolation by more than the
tolerance. Where speeds jump (a blow, an impact) or forces do (a contact closes, sticks or slips) there are two moments
at one time, before and after, and nothing is interpolated between them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...dynamics import State, poses
from ...dynamics.kinematics import angular_velocity
from ...dynamics.loads.actions import accelerating
from ...dynamics.motion import motion, transmitting
from ...motion.contact.course import forces_of
from ...motion.kernels.program import at_states
from ...motion.trajectory.phases import Segment, segments_of
from ...motion.trajectory.quantities import quaternions
from ...space.quaternion import Quaternion, quaternion_conjugate, quaternion_product
from .contacts import Contacts, Touched
from .forces import Arrow, applied, arrows, moving_points

if TYPE_CHECKING:
    from ...motion.trajectory.trajectory import Trajectory

Array = NDArray[np.float64]
Places = NDArray[Any]

TOLERANCE = 2e-3
"""Tolerance of the interpolation: of positions relative to the extent of the motion, of angles in rad, of all other
quantities relative to their greatest value."""

FEWEST = 61
"""Fewest moments of a motion."""

ROUNDS = 14
"""Most times that an interval is halved."""

MOST = 2**14
"""Moments beyond which a finer interpolation is not worth the size of the page."""

LOOSEST = 0.05
"""Largest tolerance that is used to stay below ``MOST``."""


@dataclass(frozen=True, eq=False)
class Keyframes:
    """Everything that a page shows of a motion at n moments.

    Attributes
    ----------
    t : ndarray (n,)
        Times [s].
    position : ndarray (n, bodies, 3)
        Positions of the origins of the bodies, in ground axes [m].
    quaternion : ndarray (n, bodies, 4)
        Ground from body, scalar first, continuous in time.
    spin : ndarray (n, bodies, 3)
        Angular velocity in the ground, in ground axes [rad/s].
    arrows : tuple of Arrow
        Forces and moments, loads first.
    vectors : dict of ndarray (n, 3)
        Value of every arrow by its key, in ground axes [N] or [N m].
    states : ndarray (n, ...)
        Coordinates and speeds.
    energy : dict of ndarray (n,)
        ``kinetic``, ``potential``, ``total``; also ``work`` if loads without potential or drives do work, and
        ``heat of friction`` if there is any [J].
    residual : ndarray (n,)
        Imbalance of the energy ledger [J].
    part : ndarray of int (n,)
        Number of the phase that each moment belongs to; between two phases the motion jumps.
    touched : Touched or None
        Forces, gaps and places of all contacts of a machine with contacts.
    tolerance : float
        Tolerance of the interpolation.
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
        """Numbers of the first moments of all phases except the first."""
        return [int(k) + 1 for k in np.flatnonzero(np.diff(self.part))]


def keyframes(trajectory: Trajectory, tolerance: float = TOLERANCE) -> Keyframes:
    """Return the moments of a motion that a page needs, with everything that it shows at them.

    Parameters
    ----------
    trajectory : Trajectory
    tolerance : float
        Greatest error of the interpolation in the middle between two moments: of positions relative to the extent of
        the motion, of rotations in rad, of forces, coordinates and energies relative to their greatest value. While it
        takes more than `MOST` moments, it is doubled, up to `LOOSEST`; `Keyframes.tolerance` is the final value.

    Returns
    -------
    Keyframes
    """
    source = _Source(trajectory)
    first = source(*source.start())
    sample = _refined(source, first, tolerance)
    while len(first.t) < len(sample.t) > MOST and 2 * tolerance <= LOOSEST:
        tolerance *= 2
        sample = _refined(source, first, tolerance)
    return source.finished(sample, tolerance)


def _refined(source: _Source, sample: _Sample, tolerance: float) -> _Sample:
    """The sample with further moments, so that the interpolation is within the tolerance."""
    span = float(sample.t[-1] - sample.t[0])
    unchecked = np.ones(len(sample.t) - 1, dtype=bool)  # intervals
    for _ in range(ROUNDS):
        unchecked &= (np.diff(sample.t) > 1e-6 * span) & (np.diff(sample.part) == 0)
        if not unchecked.any():
            break
        at = np.flatnonzero(unchecked)
        middle = source((sample.t[at] + sample.t[at + 1]) / 2, sample.part[at])
        wrong = at[source.error(sample, at, middle) > tolerance]
        sample = sample.joined(middle, wrong + 1, np.isin(at, wrong))
        unchecked = np.zeros(len(sample.t) - 1, dtype=bool)
        halves = wrong + np.arange(len(wrong))
        unchecked[halves] = unchecked[halves + 1] = True
    return sample


def interpolated(a: Array, b: Array, turn: Array, part: float | Array) -> Array:
    """Unit quaternions (n, 4) at the ``part`` s (n, 1) of an interval from a to b with the turn φ (n, 3) [rad].

    q(s) = dˢ ∘ e(s φ) ∘ a,    d = b ∘ (e(φ) ∘ a)*,    e(φ) = (cos |φ|/2, φ/|φ| sin |φ|/2)
    """
    spun = quaternion_product(_turned(turn), _components(a))
    w, *v = quaternion_product(_components(b), quaternion_conjugate(spun))
    sine = np.sqrt(v[0] ** 2 + v[1] ** 2 + v[2] ** 2)
    # d and -d are the same rotation: take the smaller angle; v over its length, with 0 over 0 as 0
    angle = 2 * np.arctan2(sine, np.abs(w)) * np.where(w < 0, -1, 1)
    remainder = np.stack(v, axis=1) * (angle / np.where(sine > 0, sine, 1))[:, None]
    turned = quaternion_product(_turned(part * turn), _components(a))
    return np.stack(quaternion_product(_turned(part * remainder), turned), axis=1)


def _components(q: Array) -> Quaternion:
    """Components w, x, y, z of quaternions (n, 4)."""
    w, x, y, z = q.T
    return w, x, y, z


def _turned(turn: Array) -> Quaternion:
    """Quaternions of rotation vectors (n, 3); sin(x/2)/x is ½ sinc(x/2π)."""
    angle = np.linalg.norm(turn, axis=1)
    x, y, z = turn.T * np.sinc(angle / (2 * np.pi)) / 2
    return np.cos(angle / 2), x, y, z


def _moments(path: Any, events: Array, longest: float, resolve: bool) -> Array:
    """First moments of a phase: times at most ``longest`` apart, events, and steps if they ``resolve`` its motion."""
    first, last = min(path.start, path.end), max(path.start, path.end)
    if last == first:
        return np.array([first, first + 1e-9 * max(1.0, abs(first))])
    count = max(2, 1 + int(np.ceil((last - first) / longest))) if longest > 0 else 2
    times = [np.linspace(first, last, count), events[(events >= first) & (events <= last)]]
    if resolve:
        times.append(path.times)
    t: Array = np.unique(np.clip(np.concatenate(times), first, last))
    distinct = np.concatenate([[True], np.diff(t) > 1e-9 * (last - first)])
    distinct[-1] = True
    return np.asarray(t[distinct])


@dataclass(frozen=True, eq=False)
class _Sample:
    """Values at some moments.

    ``linear`` holds all values, except positions, whose linear interpolation is checked against the tolerance;
    ``extra`` holds values that are shown but not checked.
    """

    t: Array
    part: Places
    states: Array
    position: Array
    rotation: Array
    spin: Array
    linear: Array
    extra: Array

    def joined(self, other: _Sample, places: Places, chosen: Places) -> _Sample:
        """The sample with the ``chosen`` moments of another sample inserted at ``places``."""
        return _Sample(
            *(
                np.insert(getattr(self, name), places, getattr(other, name)[chosen], axis=0)
                for name in ("t", "part", "states", "position", "rotation", "spin", "linear", "extra")
            )
        )


class _Source:
    """Values of a trajectory at any time."""

    def __init__(self, trajectory: Trajectory) -> None:
        self.trajectory = trajectory
        kernels = trajectory.kernels
        self.model = model = kernels.model
        self.parameters = kernels.parameters(trajectory.numbers)
        self.arrows = arrows(kernels)
        self.loads = [arrow for arrow in self.arrows if arrow.group == "force"]
        self.count = len(model.bodies)
        self.phases = phases_of(trajectory)
        self.contacts = Contacts(trajectory) if model.contacts else None
        # in time-stepping, forces are means over a step: they jump from step to step
        self.stepped = not hasattr(trajectory.path, "segments") and self.contacts is not None

        def scene(state: State) -> dict[str, Any]:
            pose = [
                x
                for posture in poses(model, state).values()
                for x in (*posture.position, *(x for row in posture.rotation for x in row))
            ]
            spins = [x for name in model.bodies for x in angular_velocity(model, state, Named(name))]
            asking = accelerating(model) and not model.contacts
            udot = motion(model, state, kernels.active).udot if asking else None
            loads = [x for _, vector in applied(model, state, udot) for x in vector]
            return {"pose": pose, "spin": spins, "loads": loads}

        self.scene = kernels.program("keyframes", scene)
        # number of each reaction, whose force and moment have 3 components each
        self.joints = {name: i for i, (name, _, _) in enumerate(transmitting(kernels.model))}

    def start(self) -> tuple[Array, Places]:
        """First moments, and the numbers of the phases that they belong to."""
        path = self.trajectory.path
        events = np.array([event.time for event in self.trajectory.events], dtype=float)
        longest = abs(path.end - path.start) / (FEWEST - 1)
        times = [
            _moments(phase.path, events if len(self.phases) == 1 else events[:0], longest, not self.stepped)
            for phase in self.phases
        ]
        return np.concatenate(times), np.repeat(np.arange(len(times)), [len(t) for t in times])

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
        linear = np.concatenate([loads, reactions, energy, ledger, states[:, :n], touched], axis=1)
        rotation = pose[:, :, 3:].reshape(len(t), self.count, 3, 3)
        return _Sample(t, part, states, pose[:, :, :3], rotation, spin, linear, extra)

    def _of_phase(self, k: int, t: Array, part: Places) -> tuple[Any, ...]:
        """(numbers, states, reactions, work and heat, contact forces) of the moments in phase k."""
        trajectory = self.trajectory
        chosen = np.flatnonzero(part == k)
        phase = self.phases[k]
        low, high = sorted((phase.path.start, phase.path.end))
        times = np.clip(t[chosen], low, high)
        states = phase.path.sample(times)
        stepping: Any = trajectory.course
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
        forces = np.zeros((len(times), 0))
        if self.contacts is not None:
            forces = forces_of(trajectory, phase, times, states, self.contacts.ratios)
        return chosen, states, reactions[:, : 6 * len(self.joints)], ledger, forces

    def _observed(self, program: Any, function: str, t: Array, states: Array) -> Array:
        constants = program.constants(self.parameters)
        return at_states(program, function, t, states, constants)

    def error(self, sample: _Sample, at: Places, middle: _Sample) -> Array:
        """Relative error of the interpolation at the middle of the interval after each of the moments ``at``."""
        p = sample.position
        extent = max(float(np.ptp(p.reshape(-1, 3), axis=0).max(initial=0.0)), 1e-12) if p.size else 1.0
        distance = np.linalg.norm((p[at] + p[at + 1]) / 2 - middle.position, axis=2)
        position_error = distance.max(axis=1, initial=0.0) / extent
        turn_error = np.zeros(len(at))
        duration = np.diff(sample.t)[at][:, None]
        for i in range(self.count):
            a, b = (quaternions(sample.rotation[j, i]) for j in (at, at + 1))
            m = quaternions(middle.rotation[:, i])
            w_a, w_b = sample.spin[at, i], sample.spin[at + 1, i]
            mean = (w_a + w_b) / 2
            half = interpolated(a, b, mean * duration, 0.5)
            at_middle = np.minimum(np.linalg.norm(half - m, axis=1), np.linalg.norm(half + m, axis=1))
            # a spin mean + 4 s (1 - s) δ has the error δ Δt (s - 3 s² + 2 s³) 2/3, which is 0 at the middle
            bend = np.linalg.norm((middle.spin[:, i] - mean) * duration, axis=1) * math.sqrt(3) / 27
            # if the axis of the spin moves, the body turns about the mean axis instead of the axes on the way
            size = np.maximum(np.linalg.norm(mean, axis=1), 1e-150)  # so that its square is not zero
            turns = np.minimum(1, size * duration[:, 0] / (2 * np.pi))
            sway = np.linalg.norm(np.cross(w_a, w_b), axis=1) / size**2 * turns
            turn_error = np.max([turn_error, 2 * at_middle, bend, sway], axis=0)
        scale = np.abs(sample.linear).max(axis=0, initial=0.0)
        scale = np.maximum(scale, 1e-9 * max(1.0, float(scale.max(initial=0.0))))
        difference = np.abs((sample.linear[at] + sample.linear[at + 1]) / 2 - middle.linear)
        linear_error = (difference / scale).max(axis=1, initial=0.0)
        return np.asarray(np.maximum(np.maximum(position_error, turn_error), linear_error))

    def finished(self, sample: _Sample, tolerance: float) -> Keyframes:
        """Return the keyframes of a sample."""
        n_loads, n_joints = 3 * len(self.loads), 6 * len(self.joints)
        loads, reactions = sample.linear[:, :n_loads], sample.linear[:, n_loads : n_loads + n_joints]
        if self.stepped:
            reactions, n_joints = sample.extra[:, :n_joints], 0
        T, V, W, heat = sample.linear[:, n_loads + n_joints : n_loads + n_joints + 4].T
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
            extra = sample.extra[:, 6 * len(self.joints) * self.stepped :]
            forces = extra[:, :width] if self.stepped else sample.linear[:, -width:]
            touched = self.contacts.touched(forces, extra[:, width * self.stepped :])
            for arrow in self.arrows:
                if arrow.contact is not None:
                    vectors[arrow.key] = touched.force(arrow.contact, arrow.role == "friction")
        shape = (len(sample.t), self.count, 4)
        turns = [quaternions(sample.rotation[:, i]) for i in range(self.count)]
        return Keyframes(
            sample.t,
            sample.position,
            np.stack(turns, axis=1) if turns else np.zeros(shape),
            sample.spin,
            tuple(self.arrows),
            vectors,
            sample.states,
            energy,
            T + V - (T[0] + V[0]) - (W - W[0]),
            sample.part,
            touched,
            tolerance,
        )


def phases_of(trajectory: Trajectory) -> Sequence[Segment]:
    """Phases of a motion, without the ones too short to see."""
    path: Any = trajectory.path
    segments = segments_of(path, trajectory.kernels)
    least = 1e-9 * abs(path.end - path.start)
    return [s for s in segments if abs(s.path.end - s.path.start) > least] or segments[-1:]


@dataclass(frozen=True)
class Named:
    """A body by its name alone: all that the algorithms of motion need of it."""

    name: str
    is_ground: bool = False


def paths_of_arrows(trajectory: Trajectory, keys: Keyframes) -> dict[str, Array]:
    """Return the points of the arrows that move over their bodies, by the keys of the arrows, shape (n, 3) [m]."""
    kernels = trajectory.kernels
    names = [arrow.key for arrow in keys.arrows if arrow.moves]
    if not names:
        return {}

    def points(state: State) -> dict[str, Any]:
        return {"points": [x for point in moving_points(kernels.model, state).values() for x in point]}

    program = kernels.program("points of arrows", points)
    constants = program.constants(kernels.parameters(trajectory.numbers))
    all_points = at_states(program, "points", keys.t, keys.states, constants)
    return {name: all_points[:, 3 * i : 3 * i + 3] for i, name in enumerate(names)}
