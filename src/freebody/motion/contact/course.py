"""Course of a motion with contacts: contact modes, contact forces and gaps."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, cast

import numpy as np

from ...dynamics.conditions.unilateral import MotionWarning
from ...errors import SimulationError, nearest
from ...model.contact import friction_margin
from ...model.model import Model
from ...model.resistance import pressers
from ..families.pair_quantities import pair_quantities, poses_at
from ..kernels.kernels import Kernels
from ..kernels.program import Program, at_states
from ..ode.dense_output import Array, Path, observe
from ..phase.candidates.candidates import stretch_numbers
from ..phase.scene import ends_of_sides
from ..start.initial import number
from ..start.overlap import behind_sides
from ..trajectory.computed_motion import ComputedMotion
from ..trajectory.course import Piece
from ..trajectory.event import Happening
from ..trajectory.in_legs import InLegs, phases_of
from ..trajectory.phases import Segment
from ..trajectory.quantities import ByName, Energy


@dataclass(frozen=True)
class Change:
    """Mode of a contact from ``start`` to ``end`` [s], and the reason why it began."""

    contact: str
    mode: str
    start: float
    end: float
    why: str

    def __str__(self) -> str:
        return f"{self.contact}: {shown(self.mode)} from {self.start:.6g} to {self.end:.6g} s ({self.why})"


def shown(mode: str) -> str:
    """Return the printed form of a mode."""
    return {"slip+": "slip +", "slip-": "slip -"}.get(mode, mode)


@dataclass(eq=False)
class Leap(Path):
    """One straight step, so short that double precision does not resolve its curvature."""

    curved = False

    def sample(self, times: Any, dense: bool = False) -> Array:
        """Return the states at ``times`` on the straight line between the two ends of the step."""
        del dense
        wanted = np.atleast_1d(np.asarray(times, dtype=float))
        length = self.times[-1] - self.times[0]
        x = (wanted - self.times[0]) / length if length > 0 else np.zeros_like(wanted)
        return self.states[0] + x[:, None] * (self.states[-1] - self.states[0])


@dataclass(frozen=True, eq=False)
class ContactMotion:
    """One contact at the output times.

    Attributes
    ----------
    gap : ndarray (n,)
        Distance of the surfaces [m].
    normal : ndarray (n,)
        Normal force N [N]; nan if the motion does not determine it.
    tangential : ndarray (n,) or (n, 2)
        Friction on the feature along the tangents [N]; nan if the motion does not determine it.
    slip : ndarray (n,) or (n, 2)
        Slip velocity along the tangents [m/s].
    margin : ndarray (n,)
        Friction-cone margin μ_s N - |T| [N]; nan while open.
    mode : ndarray of str (n,)
        open, stick, slip+, slip- or slip.
    least : ndarray (n, 1 + tangents)
        (N, T...) [N]; of forces that the motion does not determine, those least in norm.
    static_friction : ndarray (n,)
        Coefficient of static friction μ_s.
    least_margin : ndarray (n,)
        The margin of the forces ``least`` [N].
    approach : ndarray (n,)
        Speed at which the gap closes [m/s]; 0 while a rigid contact is closed.
    """

    gap: Array
    normal: Array
    tangential: Array
    slip: Array
    margin: Array
    mode: Any
    least: Array
    static_friction: Array
    least_margin: Array
    approach: Array


class Timeline(list[Change]):
    """Modes of all contacts in the order in which they began, printed one per line."""

    def of(self, contact: str) -> list[Change]:
        """Return the modes of one contact."""
        known = {change.contact for change in self}
        if not isinstance(contact, str) or contact not in known:
            raise SimulationError(f"Unknown contact '{contact}'; {nearest(str(contact), known)}")
        return [change for change in self if change.contact == contact]

    def __str__(self) -> str:
        return "\n".join(map(str, self))


def timeline(text: Any) -> Timeline:
    """Return the modes of all contacts in a lane of a batch, with their times and the reasons why they began.

    Parameters
    ----------
    text : str or DataArray of one
        Entry of the variable ``modes`` of a batch, such as ``data["modes"][3]``.

    Returns
    -------
    Timeline
        The same as ``trajectory.modes`` of a single run; empty for a lane without a motion.

    Raises
    ------
    SimulationError
        If ``text`` is not the timeline of one lane.

    Examples
    --------
    >>> print(timeline('[["floor", "stick", 0.0, 2.0, "the start"]]'))
    floor: stick from 0 to 2 s (the start)
    """
    try:
        given = text.item() if hasattr(text, "item") else text
        return Timeline(Change(*entry) for entry in (json.loads(given) if given else []))
    except (TypeError, ValueError):
        raise SimulationError(
            f'Expected the modes of one lane, such as data["modes"][3], got {text!r}.'
        ) from None


@dataclass(frozen=True, eq=False)
class Touching:
    """Course of a motion with contacts: phases, each with its modes.

    ``history``    blows, impacts and changes of mode; the timeline; forces that the motion does not determine
                   (`history.History`, or `history.Told`)
    """

    history: Any
    stepping: None = None
    derivatives: Any = None
    legs: ClassVar[InLegs] = InLegs()

    @property
    def timeline(self) -> Timeline:
        """Modes of every contact, with their times and the reasons why they began."""
        return cast(Timeline, self.history.timeline)

    @property
    def indeterminate(self) -> tuple[str, ...]:
        """Contact forces that the motion does not determine at some time of the run."""
        return cast("tuple[str, ...]", self.history.indeterminate)

    @property
    def residual(self) -> float:
        """Greatest residual of a decision or an impact."""
        return float(self.history.residual)

    @property
    def happenings(self) -> tuple[Happening, ...]:
        """Blows, impacts and changes of mode, in their order."""
        return cast("tuple[Happening, ...]", self.history.happenings)

    def modes(self, motion: ComputedMotion) -> Timeline:
        """Return the modes of every contact."""
        return self.timeline

    def works(self, motion: ComputedMotion) -> bool:
        """Return True: friction does work."""
        return True

    def observed(
        self, motion: ComputedMotion, program: Program, function: str, times: Array, states: Array
    ) -> Array:
        """Return outputs with the constants of each phase."""
        return self.legs.observed(motion, program, function, times, states)

    def quantity(self, motion: ComputedMotion, name: str) -> Array:
        """Return the rates, reactions or multipliers at the output times; the first two in the modes of their time."""
        if name == "multipliers":
            return self.legs.quantity(motion, name)
        return _by_phase(motion, "motion" if name == "rates" else name, (name,))[0]

    def energy(self, motion: ComputedMotion) -> Energy:
        """Return the energy ledger, with the work of friction; ``-friction`` is its heat."""
        n = motion.kernels.model.n_q + motion.kernels.model.n_u
        return replace(self.legs.energy(motion), friction=-motion.states[:, n + 1])

    def limit_pieces(self, motion: ComputedMotion) -> Iterator[Piece]:
        """Yield the phases with the margins to the limits of one-sided constraints."""
        return self.legs.limit_pieces(motion)

    def warnings(self, motion: ComputedMotion) -> tuple[MotionWarning, ...]:
        """Return the warnings of blows and impacts, and of what comes behind a side."""
        passed = InLegs(self.happenings).warnings(motion) if self.history.may_warn else ()
        return (*passed, *behind_sides(motion))

    def contacts(self, motion: ComputedMotion) -> dict[str, ContactMotion]:
        """Return gap, forces, slip and mode of every contact, by name."""
        gap, reach, rates, forces, static = _by_phase(
            motion, "contact", ("gap", "reach", "rate", "force", "static_friction")
        )
        path = phases_of(motion)
        segments, places = path.segments, path.places(motion.t)
        first, result = segments[0].kernels.scene, {}
        model = motion.kernels.model
        ratios = stretch_numbers(model, motion.numbers)
        gaps, approaches = distances(model, gap, reach, rates[:, list(first.first)])
        for k, contact in enumerate(model.contacts):
            at, n = first.first[k], first.tangents[k]
            lambdas = forces[:, at : at + 1 + n] * ratios[at : at + 1 + n]
            modes = np.array([segments[p].modes[k] for p in places])
            loose = np.array([segments[p].loose[at : at + 1 + n] for p in places]).reshape(-1, 1 + n)
            shown = np.where(loose, np.nan, lambdas)
            T, slip = shown[:, 1:], rates[:, at + 1 : at + 1 + n] / ratios[at + 1 : at + 1 + n]
            pressure = lambdas[:, 0] + number(model, motion.numbers, contact.adhesion, "an adhesion")
            room = friction_margin(static[:, k], pressure, lambdas[:, 1:].T, ratios[at + n], np.sqrt)
            margin = np.where((modes == "open") | loose.any(axis=1), np.nan, room)
            approach = approaches[:, k]
            if not contact.compliant:
                approach = np.where(modes == "open", approach, 0.0)
            result[contact.name] = ContactMotion(
                gaps[:, k],
                shown[:, 0],
                T[:, 0] if n == 1 else T,
                slip[:, 0] if n == 1 else slip,
                margin,
                modes,
                lambdas,
                static[:, k],
                room,
                approach,
            )
        for pair in motion.kernels.model.patches:
            result[pair.whole.name] = _whole(motion, pair, result)
        return ByName("contact", result)


def forces_of(motion: ComputedMotion, phase: Segment, times: Array, states: Array, ratios: Array) -> Array:
    """Return the forces of all contacts in a phase, in the order of :func:`contact_layout`, shape (n, rows).

    ``ratios`` are those of :func:`stretch_numbers`.
    """
    if not phase.modes:  # time-stepping, or a motion without phases
        stepped: Any = motion.course
        return np.asarray(stepped.mean_forces(times))
    if isinstance(phase.path, Leap):  # at its start, slip has no direction yet
        times, states = times * 0 + phase.path.end, np.repeat(phase.path.states[-1:], len(times), axis=0)
    program, kernels = phase.kernels.contact(), motion.kernels
    constants = program.constants(phase.values(kernels.parameters(motion.numbers)))
    return observe(program.address("force"), len(ratios), times, states, constants) * ratios


def distances(model: Model, gap: Array, reach: Array, rate: Array) -> tuple[Array, Array]:
    """Return the distances of all contacts, and the speeds at which they close, by gaps, least reaches and rates.

    Beyond the ends of a side they are those of its nearest corner; inf and nan where it has none.
    """
    beyond = reach < 0
    distance, approach = np.where(beyond, np.inf, gap), np.where(beyond, np.nan, -rate)
    for k, sides in ends_of_sides(model).items():
        for side, _ in sides:
            nearer = distance[:, k] < distance[:, side]
            distance[nearer, side], approach[nearer, side] = distance[nearer, k], approach[nearer, k]
    for k, normal in enumerate(pressers(model.contacts)):
        if normal >= 0:  # what resists rolling and spinning is where its contact is
            distance[:, k], approach[:, k] = distance[:, normal], approach[:, normal]
    return distance, approach


def _whole(motion: ComputedMotion, pair: Any, parts: Mapping[str, ContactMotion]) -> ContactMotion:
    """Return the contact of two solids as a whole: its gap, the slip where it is least, the sum of its forces."""
    model = motion.kernels.model
    rolled = motion.kernels.cache.setdefault("rolled", Kernels(pair.of))
    family, own, path = pair.of.families[pair.family], {p.name for p in pair.of.parameters}, phases_of(motion)
    gap, approach, slip = np.empty(motion.t.size), np.empty(motion.t.size), np.empty((motion.t.size, 2))
    for k, chosen in path.split(motion.t):
        given = zip(model.parameters, path.segments[k].values(motion._parameters), strict=True)
        values = {p.name: float(x) for p, x in given if p.name in own}
        times, states = motion.t[chosen], motion.states[chosen]
        poses = poses_at(rolled, values, times, states[:, : model.n_q + model.n_u])
        gap[chosen], approach[chosen], slip[chosen], _ = pair_quantities(
            rolled, values, family, (pair.first, pair.second), times, poses
        )
    some = [parts[model.contacts[k].name] for k in pair.places]
    forces = np.sum([part.least for part in some], axis=0)
    modes = np.array([part.mode for part in some])
    mode = np.where(
        (modes == "open").all(axis=0), "open", np.where((modes == "stick").any(axis=0), "stick", "slip")
    )
    static = some[0].static_friction  # a family has one law
    margin = static * forces[:, 0] - np.linalg.norm(forces[:, 1:], axis=1)
    return ContactMotion(
        gap,
        forces[:, 0],
        forces[:, 1:],
        slip,
        np.where(mode == "open", np.nan, margin),
        mode,
        forces,
        static,
        margin,
        np.where(mode == "open", approach, 0.0),
    )


def _by_phase(motion: ComputedMotion, name: str, functions: Sequence[str]) -> list[Array]:
    """Return outputs of functions at the output times, each from the program of its phase of this name."""
    parts: list[tuple[Any, list[Array]]] = []
    programs: dict[tuple[int, int], Any] = {}
    path = phases_of(motion)
    for k, chosen in path.split(motion.t):
        segment = path.segments[k]
        key = id(segment.kernels), id(segment.parameters)
        if key not in programs:
            program = getattr(segment.kernels, name)()
            programs[key] = (program, program.constants(segment.values(motion._parameters)))
        program, constants = programs[key]
        times, states = motion.t[chosen], motion.states[chosen]
        if isinstance(segment.path, Leap):  # the start of a leap has no direction of slip yet
            states = np.broadcast_to(segment.path.states[-1], states.shape)
            times = times * 0 + segment.path.end
        parts.append((chosen, [at_states(program, f, times, states, constants) for f in functions]))
    result = []
    for j in range(len(functions)):
        width = min((values[j].shape[1] for _, values in parts), default=0)
        whole = np.empty((len(motion.t), width))  # reactions of closed contacts follow those of joints
        for chosen, values in parts:
            whole[chosen] = values[j][:, :width]
        result.append(whole)
    return result
