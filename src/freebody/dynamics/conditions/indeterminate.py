"""Indeterminate reactions: rigid bodies do not determine how redundant constraints share a load.

A self-stress is a set of multipliers n that moves nothing, Gᵀ n = 0. It loads the bodies and so the joints of the
tree as well. Every component that some self-stress loads can take any value without a change of the motion.

Source: Wojtyra, Joint reaction forces in multibody systems with redundant constraints, Multibody System Dynamics 14
(2005).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ...model.model import Model
from ...scalar.algebra import IDENTITY, ZERO, Vector, apply, subtract
from ..joints.freedom import transmissible
from ..kinematics import rotation
from ..loads.loading import loading
from ..newton_euler import reactions
from ..state import State
from .constrained import DEPENDENT, constrained_loading
from .constraints import rows
from .couplings import couplings
from .linearized import linearized

LETTERS = "xyz"


@dataclass(frozen=True)
class SelfStress:
    """Multipliers by name, and the reactions they cause in the joints of the tree: (force, moment) in ground axes."""

    multipliers: Mapping[str, float]
    joints: Mapping[str, tuple[Vector, Vector]]


def self_stresses(model: Model, state: State) -> list[SelfStress]:
    """Return a basis of the self-stresses at a state of floats that satisfies the constraints."""
    names = [row.name for row in rows(model)]
    # directions of the forces, which are the rows of G except for sliding friction
    G = np.array([[float(x) for x in row] for row in linearized(model, state).acting]).reshape(
        len(names), model.n_u
    )
    sizes = np.linalg.norm(G, axis=1)
    nonzero = [i for i in range(len(names)) if sizes[i] > DEPENDENT * sizes.max(initial=0)]
    basis = [np.eye(len(names))[i] for i in range(len(names)) if i not in nonzero]
    if nonzero:
        unit = G[nonzero] / sizes[nonzero, None]
        vectors, values, _ = np.linalg.svd(unit)
        rank = int(np.sum(values > DEPENDENT * values[0]))
        for column in vectors[:, rank:].T:
            whole = np.zeros(len(names))
            whole[nonzero] = column / sizes[nonzero]
            basis.append(whole / np.abs(whole).max())
    loaded = []
    for n in basis:
        cleared = [float(x) if abs(x) > DEPENDENT else 0 for x in n]
        loaded.append((dict(zip(names, cleared, strict=True)), constrained_loading(model, state, cleared)))
    zeros = [0] * model.n_u
    before = reactions(model, state, zeros, loads=loading(model, state)) if loaded else {}
    result = []
    for multipliers, loads in loaded:
        after = reactions(model, state, zeros, loads=loads)
        change = {
            name: (subtract(after[name][0], force), subtract(after[name][1], moment))
            for name, (force, moment) in before.items()
        }
        result.append(SelfStress(multipliers, change))
    return result + _shared_with_couplings(model, state)


def _shared_with_couplings(model: Model, state: State) -> list[SelfStress]:
    """Return every reaction that joints may transmit beside what couples them by a ratio."""
    result = []
    for coupling in couplings(model, state):
        for name in coupling.joints:
            joint = model.joints[name]
            R = rotation(model, state, joint.links[-1])
            for wrench in (*((ZERO, e) for e in IDENTITY), *((e, ZERO) for e in IDENTITY)):
                n, f = transmissible(model, state, joint, wrench)
                change = dict.fromkeys(model.joints, (ZERO, ZERO))
                result.append(SelfStress({}, {**change, name: (apply(R, f), apply(R, n))}))
    return result


def indeterminate(model: Model, state: State) -> tuple[str, ...]:
    """Return the names of the reactions that the motion does not determine, at a state of floats.

    They are the names of multipliers and, for joints of the tree, ``A_z`` for the force along the ground's z and
    ``A_Mx`` for the moment about x.
    """
    result: dict[str, None] = {}
    for stress in self_stresses(model, state):
        result.update(dict.fromkeys(name for name, x in stress.multipliers.items() if x != 0))
        for joint, pair in stress.joints.items():
            for kind, vector in zip(("", "M"), pair, strict=True):
                # the size of a self-stress is 1
                result.update(
                    {
                        f"{joint}_{kind}{c}": None
                        for c, x in zip(LETTERS, vector, strict=True)
                        if abs(x) > DEPENDENT
                    }
                )
    return tuple(result)
