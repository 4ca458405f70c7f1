"""The load of joints with dry friction: the forces across the axis, at the places that bear them.

    F_a, F_b = F/2 ± (M × n)/length,      or F alone at one place

with the force F and the moment M of the joint across its axis n.
"""

from __future__ import annotations

from typing import Any

from ..describe.loads.action import JointForce
from ..model.model import Model
from ..scalar.algebra import ZERO, Scalar, Vector, add, apply, cross, divide, dot, scale, subtract
from .kinematics import rotation
from .loads.power import joint_link
from .motion import Motion, all_reactions
from .state import State

LOADED = 7
"""Number of outputs for each bearing: its lever, and the forces at two places."""


def bearing_loads(model: Model, state: State, moving: Motion) -> list[Scalar]:
    """Return the lever of the friction of each bearing and the forces at its two places, in ground axes."""
    found = all_reactions(model, state, moving)
    result: list[Scalar] = []
    for contact in model.contacts:
        law = contact.law
        if law is None or not contact.loaded:
            continue
        result += shared(model, state, law, *found[law.joint.name])
    return result


def shared(model: Model, state: State, law: Any, force: Vector, moment: Vector) -> list[Scalar]:
    """Return the lever of the friction of a bearing, and the shares of a force and a moment at its two places."""
    i = joint_link(model, JointForce(law.joint, 1, law.index))
    w, v = state.subspace(i)
    n = apply(rotation(model, state, i), w if law.turns else v)
    across = subtract(force, scale(dot(n, force), n))
    places: tuple[Vector, Vector] = (across, ZERO)
    if law.length is not None:
        couple = scale(divide(1, state(law.length)), cross(moment, n))
        half = scale(divide(1, 2), across)
        places = add(half, couple), subtract(half, couple)
    return [state(law.arm), *places[0], *places[1]]
