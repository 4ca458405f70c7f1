"""Where the machine stands when it is drawn: positions named by the user, those of a motion, or telling ones.

A drawing of a pendulum that hangs straight down shows neither its angle nor which way its reactions point. Coordinates
that are not named get values at which nothing lies in one line; machines with loops are closed near them.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import sympy
from numpy.typing import NDArray

from ...describe.system import System
from ...dynamics.constrained import closed_coordinates, constrained_loading, independent_rows
from ...dynamics.constraints import radial_names, rows, separating_force
from ...dynamics.contact import contact_layout, touches
from ...dynamics.kinematics import Posture, point_position, poses
from ...dynamics.motion import Motion, motion
from ...dynamics.newton_euler import reactions
from ...dynamics.state import State, float_state
from ...errors import FreebodyError, ModelError, SimulationError
from ...model.contact import Touching, in_modes
from ...model.model import Model
from ...motion.contact.equations_at_start import assembled, modes_at_start
from ...motion.ode.dense_output import observe
from ...motion.start.initial import named_state, number
from ...symbolic.equations import Equations, equations
from .shapes import machine_size

Array = NDArray[np.float64]

ANGLES = (35.0, 62.0, 48.0, 20.0, 75.0, 55.0)
"""Angles of the coordinates that are not named, one after another [deg]."""

NEAR = 1e-6
"""Gap of bodies that touch, in parts of the size of the machine."""

MOST_TRIED = 12
"""Contacts that are tried to be closed, one after another, to draw a machine of which no modes are given."""

FARTHEST = math.radians(45)
"""Turn up to which a second contact is closed: a bar that leans is not laid down."""

SLIDE = 0.45
"""Displacements of the coordinates that are not named, in parts of the size of the machine."""


@dataclass(frozen=True, eq=False)
class Configuration:
    """A model at an instant, in numbers.

    ``lookup`` holds the value of every symbol of the equations: parameters, coordinates, speeds; of a moment of a
    trajectory also accelerations and multipliers, and then ``moving`` is true and ``transmitted`` holds the force and
    moment of every joint on its child.
    """

    model: Model
    state: State
    values: dict[str, float]
    moving: bool = False
    lookup: dict[Any, float] = field(default_factory=dict)
    transmitted: dict[str, Any] = field(default_factory=dict)

    @property
    def t(self) -> float:
        """The time [s]."""
        return float(self.state.t)

    def posture(self, body: str) -> tuple[Array, Array]:
        """Rotation R_NB and position of a body's origin in ground axes."""
        if body == "ground":
            return np.eye(3), np.zeros(3)
        found: Posture = poses(self.model, self.state)[body]
        return np.array(found.rotation, dtype=float), np.array(found.position, dtype=float)

    def point(self, point: Any) -> Array:
        """A point of a body, in ground axes."""
        return np.array([float(x) for x in point_position(self.model, self.state, point)])

    def place(self, body: str, components: Any) -> Array:
        """A point of a body by its components, in ground axes."""
        R, p = self.posture(body)
        return p + R @ np.array([float(self.state(x)) for x in components])


def equations_at(
    system: Any, trajectory: Any = None, at: Any = None, modes: Mapping[str, Any] | None = None
) -> Equations:
    """The equations that a drawing is made from: those given, or of the system; with contacts, in the modes given, or
    those that they have at the moment of the motion that is drawn.

    Raises
    ------
    ModelError
        Modes for equations that have theirs, or for a motion, which has its own.
    SimulationError
        A motion whose forces are means over steps, of method "timestepping".
    """
    if modes is not None and (isinstance(system, Equations) or trajectory is not None):
        owner = "the equations given" if isinstance(system, Equations) else "a motion"
        raise ModelError(f"Expected no modes= with {owner}, whose contacts have theirs, got {modes!r}.")
    if isinstance(system, Equations):
        return system
    if trajectory is None or not trajectory.kernels.model.contacts:
        return equations(system, modes=modes)
    if not hasattr(trajectory.path, "segments"):
        raise SimulationError(
            f"A motion of '{trajectory.name}' by method='timestepping' has means over steps and no forces of a moment, "
            "so that no free-body diagram can be drawn of one. Simulate with method='auto', or draw with modes=."
        )
    t = _moment(trajectory, at)
    begun = [change for change in trajectory.modes if change.start <= t]
    return equations(system, modes={change.contact: change.mode for change in begun})


def modes_drawn(
    system: System | Model, at: Any, initial: Any, values: Any, near: Any
) -> tuple[dict[str, str] | None, str]:
    """The modes of contacts that are drawn, and in words why these; None without contacts.

    Those in which the motion starts. Where no start is given and none of them is closed at rest with all coordinates
    zero, or a place is given, those in which it starts from rest as it is drawn.
    """
    model = assembled(system)
    if not model.contacts:
        if initial is not None:
            raise ModelError(f"Expected no initial= for '{model.name}', which has no contacts. Leave it out.")
        return None, ""
    if initial is not None or at is None:
        found, why = modes_at_start(system, initial, near, values)
        if initial is not None or set(found.values()) - {"open"}:
            return found, why
    there = configuration(model, at, values=values, near=near)
    rest = dict(zip(model.coordinate_names, there.state.q, strict=True))
    found, why = modes_at_start(system, rest, None, there.values)
    given = {str(name) for name in values or {}}
    drawn = [p.name for p in model.parameters if p.default is None and p.name not in given]
    words = f"it starts from rest as it is drawn{''.join(f', {name} = 1' for name in drawn)};"
    return found, why.replace("the motion starts;", words)


def _touched(model: Model) -> list[Touching]:
    return [one for one in model.constraints.values() if isinstance(one, Touching)]


def _standing(
    model: Model, q: list[float], t: float, values: dict[str, float], held: Any, size: float
) -> tuple[list[float], int]:
    """Coordinates near ``q`` at which bodies stand on what they may touch, and how many contacts are closed there: one
    after another, the nearest first, while all others stay outside of each other."""
    chosen: dict[str, Any] = {}
    tried: set[str] = set()
    best = q
    angles = [i for i, one in enumerate(model.coordinates) if one.kind == "scalar" and not _slid(model, one)]
    for _ in model.contacts[:MOST_TRIED]:
        gaps = [float(one.gap) for one in touches(model, float_state(model, best, None, t, values))]
        left = [pair for pair in zip(gaps, model.contacts, strict=True) if pair[1].name not in tried]
        contact = min(left, key=lambda pair: pair[0])[1]
        tried.add(contact.name)
        mode = "slip" if contact.frictionless else "slip+" if contact.planar is not None else ("slip", (1, 0))
        wanted = {**chosen, contact.name: mode}
        closed = in_modes(model, wanted)
        for start in (best, q) if chosen else (q,):
            try:
                found = closed_coordinates(closed, start, t, values, held)
            except FreebodyError:
                continue
            turned = max((abs(found[i] - q[i]) for i in angles), default=0.0)
            if chosen and turned > FARTHEST:
                continue
            if _apart(model, float_state(model, found, None, t, values), size, wanted):
                chosen, best = wanted, found
                break
    return best, len(chosen)


def _apart(model: Model, state: State, size: float, closed: Iterable[str]) -> bool:
    """Whether no bodies are inside of each other, and those that are closed within the ends of their sides."""
    for contact, one in zip(model.contacts, touches(model, state), strict=True):
        within = all(float(x) >= -NEAR * size for x in one.reach)
        if (float(one.gap) < -NEAR * size and within) or (contact.name in closed and not within):
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
    """The model at the coordinates, or at the time of a motion, that a drawing was asked for.

    Parameters
    ----------
    at : mapping or number, optional
        Coordinates by name (and ``"t"``, the time), or the time of ``trajectory`` [s].
    trajectory : Trajectory, optional
        A motion of the model.
    values : mapping, optional
        Of parameters, in place of their defaults. Those that have none are drawn as 1.
    near : mapping, optional
        Of a machine with loops: coordinates near which it is closed.

    Raises
    ------
    ModelError, SimulationError
        Unknown names, a time without a trajectory, a machine that does not close there.
    """
    if trajectory is not None:
        return _of_motion(model, trajectory, at)
    if at is not None and not isinstance(at, Mapping):
        raise ModelError(
            f"Expected coordinates by name, such as at={{'theta': '30deg'}}, got {at!r}. A time needs "
            f"trajectory= too, of which it is a moment."
        )
    numbers = _drawn_values(model, values or {})
    given = dict(at or {})
    time = given.pop("t", None)
    wanted, named = named_state(model, numbers, given, "at")
    t = _telling_time(model, numbers) if time is None else number(model, numbers, time, "the time 't' in at")
    guessed, guess_named = named_state(model, numbers, near or {}, "near")
    size = machine_size(model, numbers)
    problem: Exception | None = None
    closed = {one.contact.name for one in _touched(model)}
    # where bodies are in each other, as the coordinates given may want it; where they are apart and nothing touches
    inside: Configuration | None = None
    loose: Configuration | None = None
    stands = bool(model.contacts) and not _touched(model)
    held = tuple(sorted({j for i in named if i < model.n_q for j in model.moved_by[i]}))
    for attempt in range(4):
        q = _telling(model, size, attempt)
        for i in range(model.n_q):
            if i in named:
                q[i] = float(wanted[i])
            elif i in guess_named:
                q[i] = float(guessed[i])
        count = 0
        try:
            if stands:
                q, count = _standing(model, q, t, numbers, held, size)
            if model.constraints:
                # what is near is so at the beginning; a drive takes it on from there
                steps = 6 if guess_named and time is None and t > 0 else 0
                for k in range(steps):
                    q = closed_coordinates(model, q, t * k / steps, numbers, held)
                q = closed_coordinates(model, q, t, numbers, held)
            state = float_state(model, q, None, t, numbers)
            poses(model, state)
            found = Configuration(model, state, numbers, False, _lookup(model, state))
            if model.contacts and not _apart(model, state, size, closed):
                inside = inside or found
            elif stands and count == 0:
                loose = loose or found
            else:
                return found
        except ModelError as error:
            problem = error
    left = loose or inside
    if left is not None:
        return left
    raise ModelError(
        f"'{model.name}' can not be drawn at these coordinates: {problem} Name coordinates near= a closed position."
    )


def _moment(trajectory: Any, at: Any) -> float:
    """The time of a trajectory that is drawn: its beginning, if none is given."""
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
            f"The trajectory given is one of '{trajectory.name}', not of this system '{model.name}'. "
            f"Simulate the system that is drawn."
        )
    now = trajectory.at(time)
    values = dict(trajectory.values)
    state = float_state(model, now.q.tolist(), now.u.tolist(), time, values)
    active = independent_rows(model, state) if model.constraints else None
    moving = _determined(model, state, motion(model, state, active), trajectory, time)
    lookup = _lookup(model, state)
    for speed, value in zip(model.speeds, moving.udot, strict=True):
        lookup[speed.acceleration] = float(value)
    radial = radial_names(model)
    for row, value in zip(rows(model), moving.multipliers, strict=True):
        lookup[sympy.Symbol(row.name, real=True)] = float(value)
        if row.owner in radial:
            _, size = separating_force(model, state, model.constraints[row.owner])
            # what no motion determines is drawn as its reactions are given, with nothing of it
            force = 0 if size is None else size * abs(value)
            lookup[sympy.Symbol(radial[row.owner], real=True)] = float(force)
    transmitted = reactions(model, state, moving.udot, loads=moving.loads)
    return Configuration(model, state, values, True, lookup, transmitted)


def _determined(model: Model, state: State, moving: Motion, trajectory: Any, time: float) -> Motion:
    """With contact forces as the trajectory has them: those that no motion determines are least in norm."""
    segments = getattr(trajectory.path, "segments", None)
    if segments is None or not _touched(model):
        return moving
    segment = segments[int(trajectory.path.places(np.array([time]))[0])]
    if segment.loose is None or not np.any(segment.loose):
        return moving
    program = segment.kernels.contact()
    layout = contact_layout(model.contacts)
    forces = observe(
        program.address("force"), len(layout), np.array([time]), segment.path.sample(np.array([time])),
        program.constants(segment.kernels.parameters(trajectory.values)),
    )[0]  # fmt: skip
    known = {row.name: float(force) for row, force in zip(layout, forces, strict=True)}
    multipliers = tuple(
        known.get(row.name, float(value)) for row, value in zip(rows(model), moving.multipliers, strict=True)
    )
    return Motion(moving.udot, multipliers, constrained_loading(model, state, multipliers))


def _lookup(model: Model, state: State) -> dict[Any, float]:
    result = {symbol: float(value) for symbol, value in state.values.items()}
    result[model.names.atoms["t"]] = float(state.t)
    result.update(zip((c.symbol for c in model.coordinates), map(float, state.q), strict=True))
    result.update(zip((s.symbol for s in model.speeds), map(float, state.u), strict=True))
    return result


def _drawn_values(model: Model, given: Mapping[Any, Any]) -> dict[str, float]:
    names = {key if isinstance(key, str) else str(key) for key in given}
    missing = {p.name: 1.0 for p in model.parameters if p.default is None and p.name not in names}
    return model.values({**missing, **given})


def _telling_time(model: Model, values: Mapping[str, float]) -> float:
    """A time at which a driven joint has turned by about an eighth of a turn (or has moved visibly)."""
    driven = [link for link in model.links if link.driven]
    state = float_state(model, values=values)
    fastest = max((abs(float(state(link.drift))) for link in driven), default=0.0)
    if fastest > 0:
        return math.radians(52) / fastest
    # from rest: the first of ever longer times at which one has moved as far
    for time in 1e-3 * 1.25 ** np.arange(70) if driven else ():
        later = float_state(model, t=float(time), values=values)
        if any(
            abs(float(later(link.displacement)) - float(state(link.displacement))) > math.radians(52)
            for link in driven
        ):
            return float(time)
    return 0.0


def _slid(model: Model, coordinate: Any) -> bool:
    """Whether a coordinate is a displacement, and no angle."""
    kinds = {
        link.kind
        for link in model.links
        if link.one_dof
        and isinstance(link.displacement, sympy.Basic)
        and link.displacement.has(coordinate.symbol)
    }
    return kinds == {"slider"}


def _telling(model: Model, size: float, attempt: int) -> list[float]:
    """Coordinates that are far from special; other ones at every attempt."""
    q = [0.0] * model.n_q
    turned = slid = 0
    for i, coordinate in enumerate(model.coordinates):
        if coordinate.kind != "scalar":
            continue
        if _slid(model, coordinate):
            # where something stands on a side, nearer and nearer to its middle
            far = (1.0, 0.5, 0.25, 0.1)[attempt] if model.contacts else 1 + 0.3 * attempt
            q[i] = SLIDE * size * (far + 0.25 * slid * (1 if not model.contacts else far))
            slid += 1
        else:
            q[i] = math.radians(ANGLES[turned % len(ANGLES)] + 37 * attempt)
            turned += 1
    rolls = bool(model.constraints) and any(link.kind == "free" for link in model.links)
    for link in model.links:
        if link.kind not in ("ball", "free"):
            continue
        start = link.q + (3 if link.kind == "free" else 0)
        # upright first, where something rolls or stands; else a little turned about an axis that is no edge
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
