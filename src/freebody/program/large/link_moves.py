"""Motions of the joints by which speeds move the links, for the loop of the mass matrix.

    M_jk = Σ w_ij w_lk (momentum of motion i with all links outward of it)·(motion l),    w_ij = ∂y_i/∂q_j

over the links i and the links l inward of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from ...dynamics.state import State
from ...model.model import Model
from ...scalar.algebra import Scalar


class Moves(NamedTuple):
    """Entries of the links: those of link i stand from ``first[i]`` to ``first[i + 1]``.

    An entry has the number of the speed, the number of the motion, and the place of its weight in S (-1 for 1).
    ``armature`` has the places of the inertia that each motion of each link moves besides.
    """

    first: list[int]
    speeds: list[int]
    motions: list[int]
    weights: list[int]
    armature: list[list[int]]


def numbers(model: Model, state: State) -> list[Scalar]:
    """Return the weights of the motions of all links, then their armature."""
    weights = [state(partial) for link in model.links for _, partial in link.partials]
    return [*weights, *(a for i in range(len(model.links)) for a in state.armature(i))]


def moves(model: Model, places: Sequence[int]) -> Moves:
    """Return the motions of all links; the places are those of their `numbers`."""
    result = Moves([0], [], [], [], [])
    left = iter(places)
    for link in model.links:
        for k in range(link.n_speeds if link.own else 0):
            _append(result, link.u + k, k, -1)
        for j, partial in link.partials:
            place = next(left)
            _append(result, j, 0, -1 if partial == 1 else place)
        result.first.append(len(result.speeds))
    for link in model.links:
        count = link.n_speeds if link.own else int(bool(link.partials))
        armature = [next(left) for _ in link.armature]
        result.armature.append((armature or [0] * count)[:count])
    return result


def _append(result: Moves, speed: int, motion: int, weight: int) -> None:
    result.speeds.append(speed)
    result.motions.append(motion)
    result.weights.append(weight)
