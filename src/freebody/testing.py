"""Random machines and states, for tests of the laws of mechanics, also with users' own joints and forces.

The machines mix all joints, oblique axes, driven displacements and all kinds of loads.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import MISSING, fields
from fractions import Fraction
from typing import Any

import numpy as np
from mpmath import mp

from .describe.contacts.gap import Gap
from .describe.description import coordinates_of
from .describe.joints.rotor import Rotor
from .describe.loads.action import PointForce
from .describe.loads.load import Load
from .describe.part import Part, sort_of
from .describe.system import System
from .errors import ModelError
from .model.model import Model
from .scalar.polynomial import Polynomial
from .space.mass import MassProperties

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


def random_state(model: Model, seed: int) -> tuple[list[float], list[float]]:
    """Return random q, with quaternions of unit length, and random u."""
    rng = np.random.default_rng(seed)
    q = rng.normal(size=model.n_q)
    for start in model.quaternions:
        q[start : start + 4] /= np.linalg.norm(q[start : start + 4])
    return [float(x) for x in q], [float(x) for x in rng.normal(size=model.n_u)]


def polynomial_value(x: Any, values: Mapping[Any, float], digits: int = 100) -> float:
    """Value of a canonical polynomial for ``values`` by SymPy atom (parameters, t, coordinates, speeds, ...).

    It is computed with many digits, since the terms of an expanded form may cancel.
    """
    generators: dict[int, Any] = {}

    def generator(ring: Any, g: Any) -> Any:
        if g.index not in generators:
            arguments = [polynomial(a) for a in g.arguments]
            if g.kind == "inverse":
                generators[g.index] = 1 / arguments[0]
            elif g.kind == "constant":
                generators[g.index] = mp.mpf(g.atom.evalf(digits))
            elif arguments:
                name = g.name or g.kind
                generators[g.index] = (_CHOICES.get(name) or getattr(mp, _MPMATH.get(name, name)))(*arguments)
            else:
                generators[g.index] = mp.mpf(values[g.atom])
        return generators[g.index]

    def polynomial(y: Any) -> Any:
        if not isinstance(y, Polynomial):
            return mp.mpf(Fraction(y).numerator) / Fraction(y).denominator
        total = mp.mpf(0)
        for monomial, coefficient in y.terms():
            term = mp.mpf(coefficient)
            for i, n in monomial:
                term *= generator(y.ring, y.ring.generators[i]) ** n
            total += term
        return total / y.den

    with mp.workdps(digits):
        return float(polynomial(x))


_MPMATH = {"abs": "fabs"}
_CHOICES: dict[str, Any] = {"max": max, "min": min}


def state_values(model: Model, q: Sequence[float], u: Sequence[float], t: float = 0) -> dict[Any, float]:
    """Values by SymPy atom: the time, the parameters at their defaults, q and u."""
    numbers = model.values()
    result: dict[Any, float] = {model.names.atoms["t"]: t}
    result.update((p.symbol, numbers[p.name]) for p in model.parameters)
    result.update(zip((c.symbol for c in model.coordinates), q, strict=True))
    result.update(zip((s.symbol for s in model.speeds), u, strict=True))
    return result


# --- the battery of a load ---------------------------------------------------------------------

LARGEST_ERROR = 2**20 * np.finfo(float).eps
"""Greatest error of what must be equal, relative to the largest term: a million roundings."""


def check_load(kind: type[Load], /, seed: int = 0, **data: Any) -> None:
    """Check a kind of load on a machine of its own; fields without ``data`` get random values.

    The power of its actions is that of its generalized forces, and with a potential -dV/dt; floats, formulas and
    compiled code agree, one state and many; it is drawn; a kind with a name in files is the same when read again.

    Parameters
    ----------
    kind : subclass of Load
    seed : int
        Seed of the random machine, state and data.
    **data : optional
        Values of fields, such as ``factor=0.1``.

    Raises
    ------
    AssertionError
        It says which law does not hold.
    ModelError
        A load that the machine refuses.

    Examples
    --------
    >>> from freebody.describe.loads.damper import Damper
    >>> check_load(Damper)
    """
    from .dynamics.loading import Loading, action_power, actions
    from .dynamics.newton_euler import inverse_dynamics
    from .dynamics.state import float_state, polynomial_state
    from .formats.toml.read import case_from_text
    from .formats.toml.write import toml_text
    from .model.assemble import assemble
    from .picture.machine.draw import draw
    from .program.program import compile_system
    from .scalar.polynomial import Ring

    s = _machine_with(kind, seed, data)
    model = assemble(s)
    q, u = random_state(model, seed)
    state = float_state(model, q, u)
    found = actions(model, state, "x")
    still = [0] * model.n_u
    unloaded = inverse_dynamics(model, state, still, Loading())
    Q = [a - b for a, b in zip(unloaded, inverse_dynamics(model, state, still), strict=True)]
    powers = [action_power(model, state, model.loads["x"], action) for action in found]
    _same(
        "the power of its actions and of its generalized forces",
        [sum(powers)],
        [np.dot(Q, u)],
        [*unloaded, *powers],
    )
    if model.loads["x"].is_conservative:
        rate = _rate_of_potential(model, q, u)
        _same("the power of its actions and -dV/dt", [sum(powers)], [-rate], powers)
    numbers = _flat(found)
    symbols = _flat(actions(model, polynomial_state(model, Ring()), "x"))
    values = state_values(model, q, u)
    _same(
        "actions as numbers and as formulas", numbers, [polynomial_value(x, values) for x in symbols], numbers
    )
    program = compile_system(s)
    forces = np.asarray(program.inverse_dynamics(q, u, still), float)
    _same("forces as numbers and in compiled code", inverse_dynamics(model, state, still), forces, unloaded)
    many = np.asarray(
        program.inverse_dynamics(np.array([q, q]), np.array([u, u]), np.zeros((2, model.n_u))), float
    )
    _same("forces of one state and of a batch", [*forces, *forces], many.ravel(), unloaded)
    if 'data-load="x"' not in draw(s).svg and any(not hasattr(action, "coordinate") for action in found):
        raise AssertionError(f"{kind.__name__}: the load is not drawn.")
    if kind.kind:
        again = assemble(case_from_text(toml_text(s)).system)
        _same(
            "actions before and after a file",
            numbers,
            _flat(actions(again, float_state(again, q, u), "x")),
            numbers,
        )


def check_contact(kind: type[Gap], /, seed: int = 0, **data: Any) -> None:
    """Check a kind of contact on a machine of its own; fields without ``data`` get random values.

    At a zero gap the power of its normal force is the rate of the gap, and its tangents move along the surfaces; the
    forces on all bodies are in balance; floats and formulas agree; a kind with a name in files is the same when read
    again.

    Parameters
    ----------
    kind : subclass of Gap
    seed : int
        Seed of the random machine, state and data.
    **data : optional
        Values of fields, such as ``friction=0.3``.

    Raises
    ------
    AssertionError
        It says which law does not hold.

    Examples
    --------
    >>> from freebody.describe.contacts.stop import Stop
    >>> check_contact(Stop, low=0.5, high=None)
    """
    from .dynamics.conditions.contact import contact_rows, touches, unit_forces
    from .dynamics.kinematics import coordinate_rates, point_position, state_along
    from .dynamics.state import float_state, polynomial_state
    from .formats.toml.read import case_from_text
    from .formats.toml.write import toml_text
    from .model.assemble import assemble
    from .scalar.polynomial import Ring
    from .scalar.series import derivative_at_start

    s = _machine_with(kind, seed, data)
    model = assemble(s)
    q, u = random_state(model, seed)
    for _ in range(100):  # to a zero gap, by Newton's method in short steps
        state = float_state(model, q, u)
        gap = float(touches(model, state)[0].gap)
        moved = [
            touches(model, state_along(model, state, row, 0, 1))[0].gap for row in np.eye(len(u)).tolist()
        ]
        slope = np.array([float(derivative_at_start(x)) for x in moved])
        if not slope.any():
            break
        step = -gap / (slope @ slope) * slope
        step = (step / max(1.0, 4 * float(np.abs(step).max()))).tolist()
        change = coordinate_rates(model, float_state(model, q, step))
        q = [a + float(d) for a, d in zip(q, change, strict=True)]
    state = float_state(model, q, u)
    given = contact_rows(model, state)
    if abs(float(given.gap[0])) > 2**-32:
        raise ModelError(
            f"Expected a state with a zero gap of {kind.__name__}, found none near a gap of {float(given.gap[0]):.3g}. "
            f"Give other data: check_contact(kind, field=...)."
        )
    along = touches(model, state_along(model, state, state.u, 1, 1))
    gaps = [float(derivative_at_start(touch.gap)) for touch in along]
    rates = [float(x) for x in given.rate]
    first = np.cumsum([0, *(1 + contact.tangents for contact in model.contacts)])[:-1]
    _same(
        "the power of the normal force and the rate of the gap",
        [rates[k] for k in first],
        gaps,
        [1.0, *rates],
    )
    _same("the rates and W u", rates, np.array(given.matrix, float) @ u, [1.0, *rates])
    for contact in model.contacts:
        for k, row in enumerate(unit_forces(model, state, contact)):
            pushes = [action for action in row if isinstance(action, PointForce)]
            places = [np.array(point_position(model, state, push.point), float) for push in pushes]
            forces = [np.array(push.force, float) for push in pushes]
            moments = [np.cross(p, f) for p, f in zip(places, forces, strict=True)]
            total = [x for sums in (forces, moments) for x in np.sum([np.zeros(3), *sums], axis=0).tolist()]
            _same(f"force {k} of contact '{contact.name}' and its opposite", total, [0.0] * 6, [1.0])
    values = state_values(model, q, u)
    symbols = contact_rows(model, polynomial_state(model, Ring()))
    _same(
        "rates as numbers and as formulas", rates, [polynomial_value(x, values) for x in symbols.rate], rates
    )
    if kind.kind:
        again = assemble(case_from_text(toml_text(s)).system)
        read = [float(x) for x in contact_rows(again, float_state(again, q, u)).rate]
        _same("rates before and after a file", rates, read, rates)


def _machine_with(kind: type[Part], seed: int, data: Mapping[str, Any]) -> System:
    """A slider and a hinge in a row, with a load x on them; missing data are drawn."""
    rng = np.random.default_rng(seed)
    s = System(f"machine of {kind.__name__}")
    s.parameters(g=9.8125)
    s.gravity = (0, "-g", 0)
    first = s.body("first", MassProperties(2, (0, 1, 0), small_inertia(rng)))
    last = s.body("last", MassProperties(1, (1, 0, 0), small_inertia(rng)))
    joints = [
        s.slider("rail", s.ground, first, at=(3, 2, 1), axis="x", coordinate="x"),
        s.hinge("pin", first, last, at=(0, 2, 1), axis="z", coordinate="phi"),
    ]
    points = [last.point(1, 2, 0), first.point(0, -1, 1), s.ground.point(-2, 5, 3)]
    bodies = [last, first]

    def drawn(name: str) -> str:
        s.parameters(**{f"x_{name}": round(float(rng.uniform(1, 2)), 3)})
        return f"x_{name}"

    values = dict(data)
    for field in fields(kind):
        sort = sort_of(field)
        if field.name == "name" or field.name in data:
            continue
        if sort == "Point":
            bodies_of_data = [value for value in values.values() if value in (last, first)]
            values[field.name] = next(point for point in points if point.body not in bodies_of_data)
            points.remove(values[field.name])
        elif sort == "Body" and field.default is MISSING:
            values[field.name] = bodies.pop(0)
        elif sort == "Joint":
            values[field.name] = joints.pop(0)
        elif sort == "Coordinate":
            values[field.name] = "phi"
        elif sort in ("Expression", "Constant") and not (issubclass(kind, Gap) and field.kw_only):
            values[field.name] = drawn(field.name)
        elif sort == "Law":
            values[field.name] = f"{drawn('linear')}*stretch + {drawn('cubic')}*stretch^3"
        elif sort == "Vector":
            values[field.name] = tuple(drawn(f"{field.name}_{axis}") for axis in "xyz")
        elif field.default is MISSING and field.default_factory is MISSING:
            raise ModelError(
                f"Expected data for '{field.name}' of {kind.__name__}: check_load(..., {field.name}=...)."
            )
    s.add("x", kind(**values))
    return s


def _rate_of_potential(model: Model, q: Sequence[float], u: Sequence[float]) -> float:
    """dV/dt of the load x, by dual numbers along the motion; speeds are the rates of the coordinates."""
    from .dynamics.loading import load_potential
    from .dynamics.state import State
    from .scalar.algebra import floats
    from .scalar.dual import Dual, DualField, slope_of

    field = DualField(floats)
    moving = [Dual(floats, x, {0: rate}) for x, rate in zip(q, u, strict=True)]
    numbers = model.values()
    values = {p.symbol: numbers[p.name] for p in model.parameters}
    return float(slope_of(load_potential(model, State(model, field, 0, moving, list(u), values)), 0))


def _flat(found: Sequence[Any]) -> list[Any]:
    """All components and values of actions."""
    result: list[Any] = []
    for action in found:
        value = next(getattr(action, name) for name in ("force", "moment", "value") if hasattr(action, name))
        result += value if isinstance(value, tuple) else [value]
    return result


def _same(what: str, a: Any, b: Any, terms: Any) -> None:
    """Raise AssertionError if two lists of numbers differ by more than round-off of the largest term."""
    a, b = np.array(a, float), np.array(b, float)
    size = max((abs(float(x)) for x in (*a, *terms)), default=0)
    if a.shape != b.shape or not np.all(np.abs(a - b) <= LARGEST_ERROR * (1 + size)):
        raise AssertionError(f"Expected {what} to be equal, got {a.tolist()} and {b.tolist()}.")
