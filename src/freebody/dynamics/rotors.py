"""Rotors: outermost bodies on hinges whose mass is the same at every angle.

If a body's mass is symmetric about its hinge, and only its weight and the hinge act on it, neither its inertia nor its
momentum depends on the angle. Vectors of such a link may be written in axes that do not turn with it: the angle is then
an ignorable coordinate that occurs in no equation, and inertias need not be rotated.

    R = E instead of E R(n, y)        velocities and accelerations as before

Source: Featherstone, Rigid Body Dynamics Algorithms (2008), §9.1 (any axes may be used at an instant).
"""

from __future__ import annotations

from collections.abc import Container

from ..model.model import Link, Model
from ..scalar.algebra import Matrix, Vector
from ..space.spatial import Spatial
from .state import State


class Unturned(State):
    """A state in which the axes of the rotors do not turn with them."""

    rotors: tuple[Link, ...] = ()

    def _evaluate_joint(self, link: Link) -> tuple[Matrix, Vector, Spatial]:
        if any(link is rotor for rotor in self.rotors):
            n, rate = self.vector(link.axis), self.rate(link)
            x, y, z = n
            return (
                self.matrix(link.rotation),
                self.vector(link.position),
                ((rate * x, rate * y, rate * z), (0, 0, 0)),
            )
        return super()._evaluate_joint(link)


def unturned(model: Model, state: State, wrenches: Container[int]) -> State:
    """Return the state for an algorithm that never uses the attitude of a rotor; the same state if there are none.

    Parameters
    ----------
    wrenches : container of int
        Links with loads, whose components are in axes that turn.
    """
    parents = {link.parent for link in model.links}
    rotors = [
        link
        for i, link in enumerate(model.links)
        if i not in parents and i not in wrenches and is_symmetric(link)
    ]
    if not rotors:
        return state
    result = Unturned(model, state.field, state.t, state.q, state.u, state.values)
    result._memo = state._memo  # values of expressions, which are the same
    result.rotors = tuple(rotors)
    return result


def is_symmetric(link: Link) -> bool:
    """Return True if the mass of a hinged link is symmetric about its hinge, as described."""
    if not link.turns_only:
        return False
    nonzero = [k for k in range(3) if link.axis[k] != 0]
    if len(nonzero) != 1 or link.axis[nonzero[0]] not in (1, -1):
        return False
    k = nonzero[0]
    a, b = (i for i in range(3) if i != k)
    J = link.inertia
    return (
        link.center[a] == 0
        and link.center[b] == 0
        and J[a][a] == J[b][b]
        and all(J[i][j] == 0 for i in range(3) for j in range(3) if i != j)
    )
