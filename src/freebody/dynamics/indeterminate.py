"""Indeterminate reactions: where several constraints do the same, rigid bodies do not tell how they share the load.

A self-stress is a set of multipliers n that moves nothing, Gᵀ n = 0. It presses on the bodies and so on the joints
of the tree as well; every component that some self-stress loads can take any value without a change of the motion.

Source: Wojtyra, Joint reaction forces in multibody systems with redundant constraints, Multibody System Dynamics 14
(2005).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..model.model import Model
from ..scalar.algebra import subtract
from .constrained import DEPENDENT, constrained_loading
from .constraints import linearized, rows
from .loading import loading
from .newton_euler import reactions
from .state import State

LETTERS = "xyz"


@dataclass(frozen=True)
class SelfStress:
    """Multipliers by name, and what they put on the joints of the tree: (force, moment) in ground axes."""

    multipliers: Mapping[str, float]
    joints: Mapping[str, tuple[Any, Any]]


def self_stresses(model: Model, state: State) -> list[SelfStress]:
    """A basis of the self-stresses at a state of floats that satisfies the constraints."""
    names = [row.name for row in rows(model)]
    # the directions that the forces act along, which are those of G but for sliding friction
    G = np.array([[float(x) for x in row] for row in linearized(model, state).acting]).reshape(
        len(names), model.n_u
    )
    sizes = np.linalg.norm(G, axis=1)
    live = [i for i in range(len(names)) if sizes[i] > DEPENDENT * sizes.max(initial=0)]
    basis = [np.eye(len(names))[i] for i in range(len(names)) if i not in live]
    if live:
        unit = G[live] / sizes[live, None]
        left, values, _ = np.linalg.svd(unit)
        rank = int(np.sum(values > DEPENDENT * values[0]))
        for column in left[:, rank:].T:
            whole = np.zeros(len(names))
            whole[live] = column / sizes[live]
            basis.append(whole / np.abs(whole).max())
    still = [0] * model.n_u
    before = reactions(model, state, still, loads=loading(model, state)) if basis else {}
    result = []
    for n in basis:
        cleared = [float(x) if abs(x) > DEPENDENT else 0 for x in n]
        after = reactions(model, state, still, loads=constrained_loading(model, state, cleared))
        change = {
            name: (subtract(after[name][0], force), subtract(after[name][1], moment))
            for name, (force, moment) in before.items()
        }
        result.append(SelfStress(dict(zip(names, cleared, strict=True)), change))
    return result


def indeterminate(model: Model, state: State) -> tuple[str, ...]:
    """Names of the reactions that no motion determines at a state of floats.

    Multipliers by their names; of the joints of the tree, ``A_z`` for the force along the ground's z and ``A_Mx`` for
    the moment about x.
    """
    found: dict[str, None] = {}
    for stress in self_stresses(model, state):
        found.update(dict.fromkeys(name for name, x in stress.multipliers.items() if x != 0))
        for joint, pair in stress.joints.items():
            for kind, vector in zip(("", "M"), pair, strict=True):
                # the size of a self-stress is 1
                found.update(
                    {
                        f"{joint}_{kind}{c}": None
                        for c, x in zip(LETTERS, vector, strict=True)
                        if abs(x) > DEPENDENT
                    }
                )
    return tuple(found)
