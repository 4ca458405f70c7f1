"""Motion of a model at a state, constrained or not: accelerations, multipliers and all forces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ..describe.constraints.constraint import Rolling
from ..model.closure import Closure
from ..model.contact_modes import Touching
from ..model.model import Model
from ..scalar.algebra import ZERO, Scalar, Vector, add, scale
from .articulated import forward_dynamics
from .conditions.constrained import constrained_dynamics, constrained_loading, constraint_power
from .conditions.constraint_forces import closed_forces, wrenches
from .conditions.constraints import rows
from .conditions.contact import wrench_on_feature
from .energy import mechanical_power
from .loads.loading import Loading, loading
from .newton_euler import reactions
from .state import State


@dataclass(frozen=True)
class Motion:
    """Accelerations u', multipliers of all conditions in the order of ``rows``, loads with constraint forces."""

    udot: tuple[Scalar, ...]
    multipliers: tuple[Scalar, ...]
    loads: Loading


def motion(model: Model, state: State, active: Sequence[int] | None = None) -> Motion:
    """Return the accelerations and the constraint forces.

    Parameters
    ----------
    active : sequence of int, optional
        The independent conditions (:func:`freebody.dynamics.conditions.constrained.independent_rows`); by default all.
    """
    if not model.constraints:
        udot = forward_dynamics(model, state)
        return Motion(udot, (), loading(model, state, udot=udot))
    conditions = range(len(rows(model))) if active is None else active
    udot, multipliers = constrained_dynamics(model, state, conditions)
    return Motion(udot, multipliers, constrained_loading(model, state, multipliers, udot))


def total_power(model: Model, state: State, moving: Motion) -> Scalar:
    """Return the rate of the total energy: loads without potential, drives, conditions with explicit time [W]."""
    power = mechanical_power(model, state, moving.udot, moving.loads)
    return power + constraint_power(model, state, moving.multipliers)


def transmitting(model: Model) -> list[tuple[str, str, str]]:
    """Return (name, body acted on, point) of every reaction, in the order of :func:`all_reactions`."""
    result = [
        (name, joint.child, f"the point of joint '{name}' on '{joint.child}'")
        for name, joint in model.joints.items()
    ]
    for name, constraint in model.constraints.items():
        if isinstance(constraint, Closure):
            child = constraint.child.name
            result.append((name, child, f"the point of joint '{name}' on '{child}'"))
        elif isinstance(constraint, Rolling):
            result.append((name, constraint.center.body.name, f"the centre of the wheel of '{name}'"))
        elif isinstance(constraint, Touching):
            result.append((name, constraint.contact.feature.body.name, f"the point of contact '{name}'"))
    return result


def all_reactions(model: Model, state: State, moving: Motion) -> dict[str, tuple[Vector, Vector]]:
    """Return (force, moment) of every joint on its child, about the joint's point, in ground axes.

    Joints that close loops and contacts (on their features, about the point of contact) come last.
    """
    result = reactions(model, state, moving.udot, loads=moving.loads)
    if not model.constraints:
        return result
    closed = {
        name: iter(closed_forces(model, state, constraint))
        for name, constraint in model.constraints.items()
        if isinstance(constraint, Touching)
    }
    for row, value, acting in zip(rows(model), moving.multipliers, wrenches(model, state), strict=True):
        if row.owner in closed:
            # about the point of contact, where its forces act
            contact = model.constraints[row.owner].contact
            force, moment = wrench_on_feature(model, state, contact, next(closed[row.owner]))
            f, n = result.get(row.owner, (ZERO, ZERO))
            result[row.owner] = (add(f, scale(value, force)), add(n, scale(value, moment)))
        elif isinstance(model.constraints[row.owner], Closure | Rolling):
            _, force, moment = acting[0]
            f, n = result.get(row.owner, (ZERO, ZERO))
            result[row.owner] = (add(f, scale(value, force)), add(n, scale(value, moment)))
    return result
