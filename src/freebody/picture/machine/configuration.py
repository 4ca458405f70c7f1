"""Configuration in which a machine is drawn: coordinates that the user names, those of a motion, or generic ones.

A drawing of a pendulum that hangs straight down shows neither its angle nor the directions of its reactions. So
coordinates that the user does not name get generic values, at which nothing is in line. Machines with loops are closed
near them.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import sympy
from numpy.typing import NDArray

from ...describe.frame import Point
from ...describe.system import System
from ...dynamics.conditions.constrained import closed_coordinates, constrained_loading, independent_rows
from ...dynamics.conditions.constraint_forces import separating_force
from ...dynamics.conditions.constraints import radial_names, rows
from ...dynamics.conditions.contact import contact_layout, definite_touches
from ...dynamics.kinematics import Posture, point_position, poses
from ...dynamics.motion import Motion, motion
from ...dynamics.newton_euler import reactions
from ...dynamics.state import State, float_state
from ...errors import FreebodyError, ModelError, SimulationError
from ...model.contact import Contact
from ...model.contact_modes import Touching, in_modes
from ...model.model import Model
from ...motion.contact.course import forces_of
from ...motion.contact.equations_at_start import assembled, modes_at_start
from ...motion.phase.candidates.candidates import stretch_numbers
from ...motion.start.initial import named_state, number
from ...motion.trajectory.phases import Segment, segments_of
from ...scalar.algebra import Vector
from ...symbolic.equations import Equations, equations
from .shapes import machine_size

Array = NDArray[np.float64]

ANGLES = (35.0, 62.0, 48.0, 20.0, 75.0, 55.0)
"""Values of the angles that the user does not name, in turn [deg]."""

NEAR = 1e-6
"""Greatest gap of bodies that touch, relative to the size of the machine."""

MOST_TRIED = 12
"""Most contacts that are tried, one after another, when no contact modes are given."""

FARTHEST = math.radians(45)
"""Greatest turn that closes a second contact [rad]: a bar that leans is not laid down."""

SLIDE = 0.45
"""Values of the displacements that the user does not name, relative to the size of the machine."""


@dataclass(frozen=True, eq=False)
class Configuration:
    """A model at an instant, in numbers.

    ``lookup`` holds the value of every symbol of the equations: parameters, coordinates and speeds. ``moving`` is true
    at a time of a trajectory: then ``lookup`` also holds accelerations and multipliers, and ``transmitted`` the force
    and moment of every joint on its child; ``open`` names the contact forces that the motion does not determine.
    """

    model: Model
    state: State
    values: dict[str, float]
    moving: bool = False
    lookup: dict[Any, float] = field(default_factory=dict)
    transmitted: dict[str, Any] = field(default_factory=dict)
    open: frozenset[str] = frozenset()

    @property
    def t(self) -> float:
        """The time [s]."""
        return float(self.state.t)

    def posture(self, body: str) -> tuple[Array, Array]:
        """Rotation R_NB of a body, and the position of its origin in ground axes [m]."""
        if body == "ground":
            return np.eye(3), np.zeros(3)
        posture: Posture = poses(self.model, self.state)[body]
        return np.array(posture.rotation, dtype=float), np.array(posture.position, dtype=float)

    def point(self, point: Point) -> Array:
        """Position of a point of a body, in ground axes [m]."""
        return np.array([float(x) for x in point_position(self.model, self.state, point)])

    def place(self, body: str, components: Vector) -> Array:
        """Position of the point of a body with these components in its axes, in ground axes [m]."""
        R, p = self.posture(body)
        return p + R @ np.array([float(self.state(x)) for x in components])

    def moved(self, shifts: Mapping[int, float]) -> Configuration:
        """Return the configuration with these coordinates changed, by their number in q."""
        q = [x + shifts.get(i, 0) for i, x in enumerate(self.state.q)]
        return replace(self, state=float_state(self.model, q, None, self.t, self.values))


def equations_at(
    system: Any, trajectory: Any = None, at: Any = None, modes: Mapping[str, Any] | None = None
) -> Equations:
    """Equations that a drawing is made from: the given ones, or those of the system.

    A machine with contacts has them in the modes ``modes``, or in its modes at the drawn time of the trajectory.

    Raises
    ------
    ModelError
        If ``modes`` is given together with equations or a motion, which have their own.
    SimulationError
        If the motion was computed by method "timestepping", whose forces are means over steps.
    """
    if modes is not None and (isinstance(system, Equations) or trajectory is not None):
        owner = "the equations given" if isinstance(system, Equations) else "a motion"
        raise ModelError(f"Expected no modes= with {owner}, whose contacts have theirs, got {modes!r}.")
    if isinstance(system, Equations):
        return system
    if trajectory is None or not (trajectory.kernels.model.contacts or trajectory.kernels.model.families):
        return equations(system, modes=modes)
    if not hasattr(trajectory.path, "segments"):
        other = "" if trajectory.kernels.model.families else ", or draw with modes="
        raise SimulationError(
            f"A motion of '{trajectory.name}' by method='timestepping' has means over steps and no forces of a moment, "
            f"so that no free-body diagram can be drawn of one. Simulate with method='auto'{other}."
        )
    t = _moment(trajectory, at)
    changes = [change for change in trajectory.modes if change.start <= t]
    # the model that moved has a contact for each pair of a family
    return equations(trajectory.kernels.model, modes={change.contact: change.mode for change in changes})


def of_the_motion(system: Any, trajectory: Any, e: Equations) -> Equations:
    """Return the equations of the model that moved, if it differs: it has a contact for each pair of a family."""
    moved = None if trajectory is None else trajectory.kernels.model
    if (
        moved is None
        or isinstance(system, Equations)
        or not e.model.families
        or moved.names is not e.model.names
    ):
        return e
    return equations(moved, modes={})


def modes_drawn(
    system: System | Model, at: Any, initial: Any, values: Any, near: Any
) -> tuple[dict[str, str] | None, str]:
    """Contact modes that are drawn, and the reason in words; (None, "") for a machine without contacts.

    They are the modes in which the motion starts from ``initial``. Without ``initial`` they are those at zero
    coordinates; if no contact is closed there, or ``at`` is given, those in which it starts from rest as drawn.
    """
    model = assembled(system)
    if not model.contacts:
        if initial is not None:
            why = (
                f"whose contacts of the family '{model.families[0].name}' are those of a motion. Give it and its time, "
                "trajectory=, at=."
                if model.families
                else "which has no contacts. Leave it out."
            )
            raise ModelError(f"Expected no initial= for '{model.name}', {why}")
        return None, ""
    if initial is not None or at is None:
        modes, reason = modes_at_start(system, initial, near, values)
        if initial is not None or set(modes.values()) - {"open"}:
            return modes, reason
    drawn = configuration(model, at, values=values, near=near)
    rest = dict(zip(model.coordinate_names, drawn.state.q, strict=True))
    modes, reason = modes_at_start(system, rest, None, drawn.values)
    names = {str(name) for name in values or {}}
    units = [p.name for p in model.parameters if p.default is None and p.name not in names]
    words = f"it starts from rest as it is drawn{''.join(f', {name} = 1' for name in units)};"
    return modes, reason.replace("the motion starts;", words)


def _closed_contacts(model: Model) -> list[Touching]:
    return [touching for touching in model.constraints.values() if isinstance(touching, Touching)]


def _is_rigid(contact: Contact) -> bool:
    """Return True for two shapes whose gap is zero while they touch."""
    return contact.law is None and not contact.compliant


def _standing(
    model: Model, q: list[float], t: float, values: dict[str, float], fixed: tuple[int, ...], size: float
) -> tuple[list[float], int]:
    """Coordinates near ``q`` at which bodies stand on the surfaces they may touch, and the number of closed contacts.

    Contacts are closed one after another, the nearest first, as long as no bodies overlap. The coordinates numbered
    ``fixed`` keep their values.
    """
    chosen: dict[str, Any] = {}
    tried: set[str] = set()
    best = q
    angles = [
        i for i, c in enumerate(model.coordinates) if c.kind == "scalar" and not _is_displacement(model, c)
    ]
    for _ in [contact for contact in model.contacts if _is_rigid(contact)][:MOST_TRIED]:
        definite = definite_touches(model, float_state(model, best, None, t, values))
        untried = [pair for pair in definite if _is_rigid(pair[0]) and pair[0].name not in tried]
        if not untried:
            break
        contact = min(untried, key=lambda pair: float(pair[1].gap))[0]
        tried.add(contact.name)
        mode = "slip" if contact.frictionless else "slip+" if contact.tangents == 1 else ("slip", (1, 0))
        modes = {**chosen, contact.name: mode}
        closed = in_modes(model, modes)
        for start in (best, q) if chosen else (q,):
            try:
                coordinates = closed_coordinates(closed, start, t, values, fixed)
            except FreebodyError:
                continue
            turn = max((abs(coordinates[i] - q[i]) for i in angles), default=0.0)
            if chosen and turn > FARTHEST:
                continue
            if _apart(model, float_state(model, coordinates, None, t, values), size, modes):
                chosen, best = modes, coordinates
                break
    return best, len(chosen)


def _apart(model: Model, state: State, size: float, closed: Iterable[str]) -> bool:
    """True if no bodies overlap and every closed contact is within the ends of its surfaces."""
    for contact, touch in definite_touches(model, state):
        if contact.law is not None:
            continue
        within = all(float(x) >= -NEAR * size for x in touch.reach)
        if (float(touch.gap) < -NEAR * size and within) or (contact.name in closed and not within):
            return False
    return True


def configuration(
    model: Model,
    at: Any = None,
    *,
    trajectory: Any = None,
    values: Mapping[Any, Any] | None = None,
    near: Mapping[Any, Any] | None = None,
) -> Configuration:
    """Return the model at coordinates, or at a time of a motion.

    Parameters
    ----------
    at : mapping or number, optional
        Coordinates by name (and ``"t"``, the time), or the time of ``trajectory`` [s].
    trajectory : Trajectory, optional
        A motion of the model.
    values : mapping, optional
        Values of parameters, in place of their defaults. A parameter without a value or a default is drawn as 1.
    near : mapping, optional
        For machines with loops: an approximate closed configuration.

    Raises
    ------
    ModelError, SimulationError
        If a name is unknown, a time is given without a trajectory, or the machine does not close there.
    """
    if trajectory is not None:
        return _of_motion(model, trajectory, at)
    if at is not None and not isinstance(at, Mapping):
        raise ModelError(
            f"Expected coordinates by name, such as at={{'theta': '30deg'}}, got {at!r}. A time needs "
            f"trajectory= too: the motion that it is a time of."
        )
    numbers = _drawn_values(model, values or {})
    coordinates = dict(at or {})
    time = coordinates.pop("t", None)
    named_values, named = named_state(model, numbers, coordinates, "at")
    t = _visible_time(model, numbers) if time is None else number(model, numbers, time, "the time 't' in at")
    guess_values, guessed = named_state(model, numbers, near or {}, "near")
    size = machine_size(model, numbers)
    problem: Exception | None = None
    closed = {touching.contact.name for touching in _closed_contacts(model)}
    # second choices: bodies overlap, as the coordinates in ``at`` may require; bodies are apart and nothing touches
    overlapping: Configuration | None = None
    loose: Configuration | None = None
    stands = bool(model.contacts) and not closed and model.pose is None
    fixed = tuple(sorted({j for i in named if i < model.n_q for j in model.moved_by[i]}))
    for attempt in range(4):
        q = _generic_coordinates(model, size, attempt)
        for i in range(model.n_q):
            if i in named:
                q[i] = float(named_values[i])
            elif i in guessed:
                q[i] = float(guess_values[i])
        count = 0
        try:
            if stands:
                q, count = _standing(model, q, t, numbers, fixed, size)
            if model.constraints:
                # ``near`` holds at time zero; a driven joint moves the machine on from there
                steps = 6 if guessed and time is None and t > 0 else 0
                for k in range(steps):
                    q = closed_coordinates(model, q, t * k / steps, numbers, fixed)
                q = closed_coordinates(model, q, t, numbers, fixed)
            state = float_state(model, q, None, t, numbers)
            poses(model, state)
            candidate = Configuration(model, state, numbers, False, _lookup(model, state))
            if model.pose is None and model.contacts and not _apart(model, state, size, closed):
                overlapping = overlapping or candidate
            elif stands and count == 0:
                loose = loose or candidate
            else:
                return candidate
        except ModelError as error:
            problem = error
    second_choice = loose or overlapping
    if second_choice is not None:
        return second_choice
    raise ModelError(
        f"'{model.name}' cannot be drawn at these coordinates: {problem} Name coordinates near= a closed position."
    )


def _moment(trajectory: Any, at: Any) -> float:
    """Time of a trajectory that is drawn; its beginning, if no time is given."""
    if isinstance(at, Mapping) and set(at) == {"t"}:
        at = at["t"]
    if at is None:
        return float(trajectory.t[0])
    if not isinstance(at, int | float | np.number):
        raise SimulationError(f"Expected the time of the trajectory to draw, such as at=0.5, got {at!r}.")
    return float(at)


def _of_motion(model: Model, trajectory: Any, at: Any) -> Configuration:
    time = _moment(trajectory, at)
    if trajectory.kernels.model.names is not model.names:
        raise ModelError(
            f"Expected a trajectory of the system '{model.name}', got one of '{trajectory.name}'. "
            f"Simulate the system that is drawn."
        )
    now = trajectory.at(time)
    pressing = {one.normal_name for one in model.contacts if one.bounded}
    found = _forces_at(model, trajectory, time) if pressing else {}
    loads = {name: found[name] for name in pressing}
    numbers = {**_values_at(trajectory, time), **loads}  # those that the motion writes are not the machine's
    values = {name: x for name, x in numbers.items() if name in model.defaults}
    state = float_state(model, now.q.tolist(), now.u.tolist(), time, values)
    active = independent_rows(model, state) if model.constraints else None
    undetermined = _open_forces(model, trajectory, time)
    moving = _determined(model, state, motion(model, state, active), trajectory, time, undetermined)
    lookup = {**_lookup(model, state), **{sympy.Symbol(name, real=True): x for name, x in loads.items()}}
    for speed, value in zip(model.speeds, moving.udot, strict=True):
        lookup[speed.acceleration] = float(value)
    radial = radial_names(model)
    for row, value in zip(rows(model), moving.multipliers, strict=True):
        lookup[sympy.Symbol(row.name, real=True)] = float(value)
        if row.owner in radial:
            _, size = separating_force(model, state, model.constraints[row.owner])
            lookup[sympy.Symbol(radial[row.owner], real=True)] = float(size * abs(value))
    transmitted = reactions(model, state, moving.udot, loads=moving.loads)
    return Configuration(model, state, values, True, lookup, transmitted, undetermined)


def _segment(trajectory: Any, time: float) -> Segment:
    """Return the phase of a motion at a time."""
    segments = segments_of(trajectory.path, trajectory.kernels)
    return segments[int(trajectory.path.places(np.array([time]))[0]) if len(segments) > 1 else 0]


def _open_forces(model: Model, trajectory: Any, time: float) -> frozenset[str]:
    """Names of the contact forces that the motion does not determine at a time."""
    segment = _segment(trajectory, time)
    if segment.loose is None:
        return frozenset()
    return frozenset(
        row.name for row, open in zip(contact_layout(model.contacts), segment.loose, strict=True) if open
    )


def _determined(
    model: Model, state: State, moving: Motion, trajectory: Any, time: float, undetermined: frozenset[str]
) -> Motion:
    """The motion with the contact forces of the trajectory, least in norm where the motion does not determine them."""
    if not undetermined or not _closed_contacts(model):
        return moving
    force_of = _forces_at(model, trajectory, time)
    multipliers = tuple(
        force_of.get(row.name, float(value))
        for row, value in zip(rows(model), moving.multipliers, strict=True)
    )
    return Motion(moving.udot, multipliers, constrained_loading(model, state, multipliers, moving.udot))


def _forces_at(model: Model, trajectory: Any, time: float) -> dict[str, float]:
    """Return the contact forces of a motion at a time, by name."""
    times, segment = np.array([time]), _segment(trajectory, time)
    ratios = stretch_numbers(model, trajectory.numbers)
    forces = forces_of(trajectory, segment, times, segment.path.sample(times), ratios)[0]
    return {row.name: float(x) for row, x in zip(contact_layout(model.contacts), forces, strict=True)}


def _values_at(trajectory: Any, time: float) -> Mapping[str, float]:
    """Return the values of the parameters at a time of a motion: signals, controllers and places change them."""
    common = trajectory.kernels.parameters(trajectory.numbers)
    values = _segment(trajectory, time).values(common).tolist()
    return dict(zip(trajectory.numbers, values, strict=True))


def _lookup(model: Model, state: State) -> dict[Any, float]:
    """Value of every parameter, coordinate and speed, and of the time, by symbol; accelerations are 0."""
    result = {symbol: float(value) for symbol, value in state.values.items()}
    result[model.names.atoms["t"]] = float(state.t)
    result.update(zip((c.symbol for c in model.coordinates), map(float, state.q), strict=True))
    result.update(zip((s.symbol for s in model.speeds), map(float, state.u), strict=True))
    result.update((speed.acceleration, float(0)) for speed in model.speeds)
    return result


def _drawn_values(model: Model, values: Mapping[Any, Any]) -> dict[str, float]:
    """Values of all parameters, 1 for those without a value or a default."""
    names = {str(key) for key in values}
    missing = {p.name: 1.0 for p in model.parameters if p.default is None and p.name not in names}
    return model.values({**missing, **values})


def _visible_time(model: Model, values: Mapping[str, float]) -> float:
    """A time at which a driven joint has turned by 52 degrees, or has moved visibly; 0 without driven joints."""
    driven = [link for link in model.links if link.driven]
    state = float_state(model, values=values)
    fastest = max((abs(float(state(link.drift))) for link in driven), default=0.0)
    if fastest > 0:
        return math.radians(52) / fastest
    # if all start from rest: the first of increasing times at which a joint has moved that far
    for time in 1e-3 * 1.25 ** np.arange(70) if driven else ():
        later = float_state(model, t=float(time), values=values)
        if any(
            abs(float(later(link.displacement)) - float(state(link.displacement))) > math.radians(52)
            for link in driven
        ):
            return float(time)
    return 0.0


def _is_displacement(model: Model, coordinate: Any) -> bool:
    """True if a coordinate is a displacement, not an angle."""
    slides = [
        link.slides_only
        for link in model.links
        if link.one_dof
        and isinstance(link.displacement, sympy.Basic)
        and link.displacement.has(coordinate.symbol)
    ]
    return bool(slides) and all(slides)


def _generic_coordinates(model: Model, size: float, attempt: int) -> list[float]:
    """Coordinates that are far from special positions, different ones in each attempt; first a robot's own pose."""
    if model.pose is not None and attempt == 0:
        pose = {**dict(zip(model.coordinate_names, model.rest, strict=False)), **model.pose}
        return [pose[name] for name in model.coordinate_names]
    q = [0.0] * model.n_q
    angle_count = displacement_count = 0
    for i, coordinate in enumerate(model.coordinates):
        if coordinate.kind != "scalar":
            continue
        if _is_displacement(model, coordinate):
            # with contacts, each attempt is closer to the middle of the surface that a body stands on
            far = (1.0, 0.5, 0.25, 0.1)[attempt] if model.contacts else 1 + 0.3 * attempt
            q[i] = SLIDE * size * (far + 0.25 * displacement_count * (1 if not model.contacts else far))
            displacement_count += 1
        else:
            q[i] = math.radians(ANGLES[angle_count % len(ANGLES)] + 37 * attempt)
            angle_count += 1
    rolls = bool(model.constraints) and any(link.flies for link in model.links)
    for link in model.links:
        if not link.own:
            continue
        start = link.quaternion
        # upright in the first attempt if a body rolls or stands; otherwise turned a little about a generic axis
        if (rolls or model.contacts) and attempt % 2 == 0:
            q[start : start + 4] = [1.0, 0.0, 0.0, 0.0]
        elif rolls:
            q[start : start + 4] = [math.cos(math.radians(-35)), math.sin(math.radians(-35)), 0.0, 0.0]
        else:
            axis = np.array([0.5, 0.3, 0.8]) / np.linalg.norm([0.5, 0.3, 0.8])
            half = math.radians(18)
            q[start : start + 4] = [math.cos(half), *(math.sin(half) * axis)]
        if rolls:
            q[link.q + 2] = 0.3 * size
    return q
