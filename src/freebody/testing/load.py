"""The battery of a kind of load."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import fields
from typing import Any

import numpy as np

from ..describe.frame import Frame, Point
from ..describe.loads.action import Action, Couple, GeneralizedForce, JointForce, PointForce
from ..describe.loads.load import Load
from ..describe.system import System
from ..dynamics.kinematics import point_position
from ..dynamics.loads.actions import actions
from ..dynamics.loads.loading import Loading
from ..dynamics.loads.power import action_power, virtual_powers
from ..dynamics.newton_euler import inverse_dynamics
from ..dynamics.state import State, float_state, polynomial_state
from ..model.assemble import assemble
from ..model.model import Model
from ..scalar.polynomial import Ring
from .comparison import flat, machine_with, same, same_after_a_file
from .states import polynomial_value, random_state, state_values


def check_load(kind: type[Load], /, seed: int = 0, *, balanced: bool | None = None, **data: Any) -> None:
    """Check a kind of load on a machine of its own; fields without ``data`` get random values.

    The power of its actions is that of its generalized forces, and with a potential -dV/dt; what acts between two
    bodies acts on both; floats, formulas and compiled code agree, one state and many; it is a function of the state;
    it is drawn as it stands in the equations; a kind with a name in files is the same when read again.

    Parameters
    ----------
    kind : subclass of Load
    seed : int
        Seed of the random machine, state and data.
    balanced : bool, optional
        Whether its forces and moments on all bodies are in balance; by default they must be if its data name points or
        bodies of two bodies.
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
    s = machine_with(kind, seed, data)
    model = assemble(s)
    q, u = random_state(model, seed)
    state = float_state(model, q, u)
    found = actions(model, state, "x")
    numbers = flat(found)
    _powers(kind, model, state, found)
    if _between(model.loads["x"]) if balanced is None else balanced:
        _third_law(kind, model, state, found)
    symbols = flat(actions(model, polynomial_state(model, Ring()), "x"))
    values = state_values(model, q, u)
    same(
        kind, "its actions as numbers and as formulas", numbers,
        [polynomial_value(x, values) for x in symbols], numbers,
    )  # fmt: skip
    _compiled(kind, s, model, (q, u))
    _drawn(kind, s, model, state, found)
    if kind.kind:
        same_after_a_file(kind, s, lambda again: flat(actions(again, float_state(again, q, u), "x")))


def _powers(kind: type[Load], model: Model, state: State, found: Sequence[Action]) -> None:
    """Power of the actions, of the generalized forces, and of the potential."""
    load, still = model.loads["x"], [0] * model.n_u
    unloaded = inverse_dynamics(model, state, still, Loading())
    loaded = inverse_dynamics(model, state, still)
    powers = [action_power(model, state, load, action) for action in found]
    Q = [a - b for a, b in zip(unloaded, loaded, strict=True)]
    same(
        kind, "the power of its actions and of its generalized forces", [sum(powers)], [np.dot(Q, state.u)],
        [*unloaded, *powers],
    )  # fmt: skip
    if load.is_conservative:
        of_actions, of_potential = virtual_powers(model, state, load, state.u, found)
        same(kind, "the power of its actions and -dV/dt", [of_actions], [of_potential], powers)


def _between(load: Load) -> bool:
    """True if the data of a load name two bodies."""
    values = [getattr(load, field.name) for field in fields(load)]
    bodies = {x.body for x in values if isinstance(x, Point)} | {x for x in values if isinstance(x, Frame)}
    return len(bodies) > 1


def _third_law(kind: type[Load], model: Model, state: State, found: Sequence[Action]) -> None:
    """Forces and moments on all bodies, the ground too, are in balance; those along joints act on both bodies."""
    force, moment, terms = np.zeros(3), np.zeros(3), [0.0]
    for action in found:
        match action:
            case PointForce(point, f):
                place = np.array(point_position(model, state, point), float)
                force = force + np.array(f, float)
                moment = moment + np.cross(place, np.array(f, float))
                terms += [*np.abs(np.array(f, float)), *np.abs(np.cross(place, np.array(f, float)))]
            case Couple(_, m):
                moment = moment + np.array(m, float)
            case JointForce() | GeneralizedForce():
                continue
    same(
        kind, "the sum of its forces and moments on all bodies and zero (Newton's third law)", [*force, *moment],
        [0.0] * 6, terms,
    )  # fmt: skip


def _compiled(
    kind: type[Load], s: System, model: Model, start: tuple[Sequence[float], Sequence[float]]
) -> None:
    """Forces in compiled code, of one state and of a batch."""
    from ..program.program import compile_system

    q, u = start
    udot = np.random.default_rng(model.n_u).normal(size=model.n_u).tolist()
    state = float_state(model, q, u)
    unloaded = inverse_dynamics(model, state, udot, Loading())
    program = compile_system(s)
    forces = np.asarray(program.inverse_dynamics(q, u, udot), float)
    loaded = inverse_dynamics(model, state, udot)
    same(kind, "forces as numbers and in compiled code", loaded, forces, unloaded)
    batch = program.inverse_dynamics(np.array([q, q]), np.array([u, u]), np.array([udot, udot]))
    many = np.asarray(batch, float).ravel()
    same(kind, "forces of one state and of a batch", [*forces, *forces], many, unloaded)


def _drawn(kind: type[Load], s: System, model: Model, state: State, found: Sequence[Action]) -> None:
    """The load is drawn, and its arrows on a body are its force in the free-body equations."""
    from ..picture.machine.draw import draw
    from ..picture.moving.forces import applied
    from ..symbolic.equations import equations

    if 'data-load="x"' not in draw(s).svg and any(not isinstance(a, GeneralizedForce) for a in found):
        raise AssertionError(f"{kind.__name__}: the load is not drawn. Yield an action at a point or a body.")
    if not all(isinstance(action, PointForce | Couple) for action in found):
        return  # a force along a joint has one arrow for both bodies
    e = equations(s)
    values = state_values(model, state.q, state.u)
    udot = np.random.default_rng(model.n_u).normal(size=model.n_u).tolist()
    values |= {speed.acceleration: a for speed, a in zip(model.speeds, udot, strict=True)}
    acting = applied(model, state, udot)
    for body in model.bodies:
        arrows = [v for arrow, v in acting if (arrow.name, arrow.body) == ("x", body)]
        kinds = [a.kind for a, _ in acting if (a.name, a.body) == ("x", body)]
        drawn = sum(
            (np.array(v, float) for v, sort in zip(arrows, kinds, strict=True) if sort == "force"),
            np.zeros(3),
        )
        # several actions of a load have numbers
        forces = [f for name, f in e.free_body(body).forces.items() if re.fullmatch(r"x(_\d+)?", name)]
        equation: Any = np.sum(
            [np.zeros(3), *(np.array([float(c.subs(values)) for c in f]) for f in forces)], axis=0
        )
        same(kind, f"its arrows on '{body}' and its force in the equations", drawn, equation, drawn)
